//! Bags: a stream of frames, of which a session keeps the views as it does for the node.

use super::{Rules, Seen};
use crate::board::Board;
use crate::cli::progress::Progress;
use crate::session::{Session, Verdict, View};
use crate::source::Origin;
use std::collections::BTreeMap;
use std::path::PathBuf;

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
        }
    }

    /// Takes in a frame that was looked at.
    pub(super) fn add(&mut self, origin: &Origin, seen: &Seen, progress: &Progress) {
        self.next_frame(origin);
        let found = seen.found.as_ref();
        let Ok(offer) = self.session.observe(&seen.frame_id, seen.stamp, found) else {
            return;
        };
        self.boards += 1;
        if offer.restart.is_some() {
            progress.warn(&format!("{origin}: {offer}"));
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
        let counted = [
            ("not looked at: as the frames before", self.repeats),
            ("without a picture", self.unreadable),
        ];
        for (what, count) in counted.into_iter().filter(|(_, count)| *count > 0) {
            progress.remark(&format!("  {count} {what}"));
        }
        for (why, count) in &self.not_kept {
            progress.remark(&format!("  {count} not kept: {why}"));
        }
    }
}

/// Why a frame with a board is not kept, without what is particular to it.
fn not_kept(verdict: &Verdict) -> Option<&'static str> {
    Some(match verdict {
        Verdict::Kept { .. } | Verdict::Replaced { .. } => return None,
        Verdict::FirstSight => "the board had just come into sight",
        Verdict::Moving { .. } => "the board moved (--max-motion-px)",
        Verdict::NotNew { .. } => "repeats a view",
        Verdict::TooFewRings { .. } => "too few rings",
        Verdict::Contradicts { .. } => "does not agree with the views kept",
        Verdict::AddsLittle { .. } => "adds too little",
        Verdict::Full { .. } => "as many views as wanted were kept (--max-views)",
        Verdict::Stray(_) => "not of the same camera",
    })
}
