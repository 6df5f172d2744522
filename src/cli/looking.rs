//! Frames looked at on all cores, the results in order, memory bounded.
//!
//! A batch of encoded frames is read, decoded in parallel and looked at in parallel, then the next one: however long a recording
//! is, two batches are in memory at most. What comes out does not depend on the number of threads.

use crate::frame::Frame;
use crate::source::{Item, Origin, Recorded, SourceError};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// How frames are looked at.
#[derive(Debug, Clone, Copy)]
pub struct Looking<'a> {
    /// Frames in a batch.
    pub batch: usize,
    /// Ends the reading once it is raised; what was read is still looked at.
    pub stop: &'a AtomicBool,
}

/// What becomes of an item.
#[derive(Debug)]
pub enum Step<T> {
    /// Something to tell of an input.
    Warning(String),
    /// There is no picture.
    Unreadable(Origin, SourceError),
    /// It was looked at.
    Looked(Origin, T),
}

/// An item on its way.
enum Slot {
    Warning(String),
    Encoded(Recorded),
}

impl Looking<'_> {
    /// Batches that keep all cores busy, although one frame takes longer than another.
    pub fn on_all_cores(stop: &AtomicBool) -> Looking<'_> {
        let batch = 2 * rayon::current_num_threads();
        Looking { batch, stop }
    }

    /// Hands every frame to `look`, on any thread, and every result to `take`, in order, until that breaks it off.
    ///
    /// # Errors
    /// The error of `take`, which ends it.
    pub fn each<T: Send>(
        self,
        items: impl Iterator<Item = Item>,
        look: impl Fn(&Origin, Frame) -> T + Sync,
        mut take: impl FnMut(Step<T>) -> anyhow::Result<ControlFlow<()>>,
    ) -> anyhow::Result<()> {
        let mut items = items.fuse();
        loop {
            let slots = self.read(&mut items);
            if slots.is_empty() {
                return Ok(());
            }
            let steps: Vec<Step<T>> = slots
                .into_par_iter()
                .map(|slot| match slot {
                    Slot::Warning(text) => Step::Warning(text),
                    Slot::Encoded(recorded) => looked(recorded, &look),
                })
                .collect();
            for step in steps {
                if take(step)?.is_break() {
                    return Ok(());
                }
            }
        }
    }

    /// The next batch, encoded; empty at the end.
    fn read(self, items: &mut impl Iterator<Item = Item>) -> Vec<Slot> {
        let mut slots = Vec::new();
        while slots.len() < self.batch && !self.stop.load(Ordering::Relaxed) {
            match items.next() {
                Some(Item::Frame(recorded)) => slots.push(Slot::Encoded(recorded)),
                Some(Item::Warning(text)) => slots.push(Slot::Warning(text)),
                None => break,
            }
        }
        slots
    }
}

fn looked<T>(recorded: Recorded, look: impl Fn(&Origin, Frame) -> T) -> Step<T> {
    let origin = recorded.origin().clone();
    match recorded.read() {
        Ok(frame) => {
            let result = look(&origin, frame);
            Step::Looked(origin, result)
        }
        Err(error) => Step::Unreadable(origin, error),
    }
}
