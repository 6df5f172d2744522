//! Bags: a stream of frames, of which a session keeps the views as it does for the node.

use super::{Rules, Seen};
use crate::board::Board;
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
            not_kept: BTreeMap::new(),
        }
    }

    /// Takes in a frame that was looked at.
    pub(super) fn add(&mut self, origin: &Origin, seen: &Seen) {
        self.next_frame(origin);
        let found = seen.found.as_ref();
        let Ok(offer) = self.session.observe(&seen.frame_id, seen.stamp, found) else {
            return;
        };
        self.boards += 1;
        if offer.restart.is_some() {
            eprintln!("warning: {origin}: {offer}");
        }
        if let Some(why) = not_kept(&offer.verdict) {
            *self.not_kept.entry(why).or_default() += 1;
        }
    }

    /// Takes in a frame without a picture; the first one is told, the others are counted.
    pub(super) fn unreadable(&mut self, origin: &Origin, reason: &str) {
        self.next_frame(origin);
        self.session.missed();
        self.unreadable += 1;
        if self.unreadable == 1 {
            eprintln!("warning: {reason}");
        }
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

    /// Says what became of the frames.
    pub(super) fn tell(&self) {
        if self.frames == 0 {
            return;
        }
        let (frames, boards, views) = (self.frames, self.boards, self.session.views().len());
        eprintln!("{frames} frames of bags, {boards} with the board, {views} kept as views");
        if self.unreadable > 0 {
            eprintln!("  {} without a picture", self.unreadable);
        }
        for (why, count) in &self.not_kept {
            eprintln!("  {count} not kept: {why}");
        }
    }

    /// The views kept.
    pub(super) fn into_views(self) -> Vec<View> {
        self.session.views().to_vec()
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
