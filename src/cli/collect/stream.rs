//! Bags: a stream of frames, of which a session keeps the views as it does for the node.

use super::{Rules, Seen};
use crate::board::Board;
use crate::cli::progress::Progress;
use crate::report::{Picture, Pictures};
use crate::session::{Session, Verdict, View};
use crate::source::Origin;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Why a frame with a board that moved is not kept.
const MOVED: &str = "the board moved (--max-motion-px)";

/// What the bags have shown so far.
#[derive(Debug)]
pub(super) struct Stream {
    session: Session,
    /// The bag that is being read.
    bag: Option<PathBuf>,
    frames: u64,
    boards: u64,
    unreadable: u64,
    repeats: u64,
    /// Why frames with a board were not kept, and how many.
    not_kept: BTreeMap<&'static str, u64>,
    /// Why the first frame without the board has none.
    first_miss: Option<String>,
    /// Of the views that are kept.
    pictures: Pictures,
}

impl Stream {
    pub(super) fn new(board: &Board, rules: &Rules) -> Self {
        let mut session = Session::new(board.clone(), rules.stream);
        session.set_options(rules.options.clone());
        Self {
            session,
            bag: None,
            frames: 0,
            boards: 0,
            unreadable: 0,
            repeats: 0,
            not_kept: BTreeMap::new(),
            first_miss: None,
            pictures: Pictures::new(),
        }
    }

    /// Takes in a frame that was looked at.
    pub(super) fn add(&mut self, origin: &Origin, seen: Seen, progress: &Progress) {
        self.next_frame(origin);
        let found = seen.found.as_ref();
        let offer = match self.session.observe(&seen.frame_id, seen.stamp, found) {
            Ok(offer) => offer,
            Err(miss) => {
                self.first_miss.get_or_insert_with(|| miss.clone());
                return;
            }
        };
        self.boards += 1;
        if offer.restart.is_some() {
            progress.warn(&format!("{origin}: {offer}"));
            self.pictures.clear();
        }
        if let Verdict::Replaced { replaced, .. } = &offer.verdict {
            self.pictures.remove(replaced);
        }
        if offer.kept() {
            let picture = seen.small.and_then(|small| Picture::of(&small));
            if let (Some(view), Some(picture)) = (self.session.views().last(), picture) {
                self.pictures.insert(view.source.clone(), picture);
            }
        }
        if let Some(why) = not_kept(&offer.verdict) {
            *self.not_kept.entry(why).or_default() += 1;
        }
    }

    /// Takes in a frame without a picture; the first one is told, the others are counted.
    pub(super) fn unreadable(&mut self, origin: &Origin, reason: &str, progress: &Progress) {
        self.next_frame(origin);
        self.session.missed();
        self.unreadable += 1;
        if self.unreadable == 1 {
            progress.warn(reason);
        }
    }

    /// Takes in a frame that shows what those before it showed.
    pub(super) fn repeat(&mut self, origin: &Origin) {
        self.next_frame(origin);
        self.repeats += 1;
    }

    fn next_frame(&mut self, origin: &Origin) {
        self.frames += 1;
        if self.bag.as_ref() != Some(&origin.path) {
            // the last frame of another recording says nothing about motion
            self.session.missed();
            self.bag = Some(origin.path.clone());
        }
    }

    /// Frames read.
    pub(super) fn frames(&self) -> u64 {
        self.frames
    }

    /// Frames in which the board was found.
    pub(super) fn boards(&self) -> u64 {
        self.boards
    }

    /// Frames that were not kept because the board moved.
    pub(super) fn moving(&self) -> u64 {
        self.not_kept.get(MOVED).copied().unwrap_or(0)
    }

    /// The views kept.
    pub(super) fn views(&self) -> &[View] {
        self.session.views()
    }

    /// How uncertain the views leave the camera where it is least certain, px at infinity, once they tell it.
    pub(super) fn uncertain_px(&self) -> Option<f64> {
        let (_, std_px) = self.session.estimate()?.least_certain()?;
        Some(std_px)
    }

    /// Says what became of the frames.
    pub(super) fn tell(&self, progress: &Progress) {
        if self.frames == 0 {
            return;
        }
        let (frames, boards, views) = (self.frames, self.boards, self.views().len());
        progress.remark(&format!(
            "{frames} frames of bags, {boards} with the board, {views} kept as views"
        ));
        for (count, why) in self.passed_over() {
            progress.remark(&format!("  {count} {why}"));
        }
    }

    /// Frames that became no views: how many, and why.
    pub(super) fn passed_over(&self) -> Vec<(u64, String)> {
        let looked_at = self.frames - self.repeats - self.unreadable;
        let first_miss = self.first_miss.as_deref().unwrap_or_default();
        let without = format!("without the board; the first of them: {first_miss}");
        let counted = [
            (
                self.repeats,
                "not looked at: as the frames before".to_owned(),
            ),
            (self.unreadable, "without a picture".to_owned()),
            (looked_at - self.boards, without),
        ];
        let not_kept = self.not_kept.iter();
        counted
            .into_iter()
            .chain(not_kept.map(|(why, count)| (*count, format!("not kept: {why}"))))
            .filter(|(count, _)| *count > 0)
            .collect()
    }

    /// The pictures of the views kept, which are then no longer here.
    pub(super) fn take_pictures(&mut self) -> Pictures {
        std::mem::take(&mut self.pictures)
    }
}

/// Why a frame with a board is not kept, without what is particular to it.
fn not_kept(verdict: &Verdict) -> Option<&'static str> {
    Some(match verdict {
        Verdict::Kept { .. } | Verdict::Replaced { .. } => return None,
        Verdict::FirstSight => "the board had just come into sight",
        Verdict::Moving { .. } => MOVED,
        Verdict::NotNew { .. } => "repeats a view",
        Verdict::TooFewRings { .. } => "too few rings",
        Verdict::Contradicts { .. } => "does not agree with the views kept",
        Verdict::AddsLittle { .. } => "adds too little",
        Verdict::Full { .. } => "as many views as wanted were kept (--max-views)",
        Verdict::Stray(_) => "not of the same camera",
    })
}
