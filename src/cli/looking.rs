//! Frames looked at on all cores, the results in order, memory bounded.
//!
//! A batch of encoded frames is read and decoded in parallel; of a stream, frames that repeat those before them are passed over.
//! Once there are enough to keep all cores busy they are looked at in parallel. However long a recording is, three batches are in
//! memory at most. What comes out does not depend on the number of threads.

use crate::frame::{Frame, Thumbnail};
use crate::session::Repeats;
use crate::source::{Item, Origin, SourceError};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// Batches of which the results are told, although too few frames wait to keep all cores busy.
const PATIENCE: usize = 16;

/// How frames are looked at.
#[derive(Debug, Clone, Copy)]
pub struct Looking<'a> {
    /// Frames in a batch.
    pub batch: usize,
    /// Whether frames of a stream that show what those before them showed are passed over.
    pub skip_repeats: bool,
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
    /// It shows what the frames before it showed.
    Repeat(Origin),
    /// It was looked at.
    Looked(Origin, T),
}

/// A frame that is decoded.
struct Decoded {
    frame: Frame,
    thumbnail: Option<Thumbnail>,
}

impl Looking<'_> {
    /// Batches that keep all cores busy, although one frame takes longer than another.
    pub fn on_all_cores(stop: &AtomicBool, skip_repeats: bool) -> Looking<'_> {
        Looking {
            batch: 2 * rayon::current_num_threads(),
            skip_repeats,
            stop,
        }
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
        let mut streams = Streams::default();
        loop {
            let (waiting, at_end) = self.gather(&mut items, &mut streams);
            let steps: Vec<Step<T>> = waiting
                .into_par_iter()
                .map(|step| match step {
                    Step::Warning(text) => Step::Warning(text),
                    Step::Unreadable(origin, error) => Step::Unreadable(origin, error),
                    Step::Repeat(origin) => Step::Repeat(origin),
                    Step::Looked(origin, frame) => {
                        let result = look(&origin, frame);
                        Step::Looked(origin, result)
                    }
                })
                .collect();
            for step in steps {
                if take(step)?.is_break() {
                    return Ok(());
                }
            }
            if at_end {
                return Ok(());
            }
        }
    }

    /// Frames to look at and all that comes between them, until there is a batch of frames; and whether that is the end.
    fn gather(
        self,
        items: &mut impl Iterator<Item = Item>,
        streams: &mut Streams,
    ) -> (Vec<Step<Frame>>, bool) {
        let mut waiting = Vec::new();
        let mut frames = 0;
        while frames < self.batch && waiting.len() < PATIENCE * self.batch {
            let read = self.read(items);
            if read.is_empty() {
                return (waiting, true);
            }
            let decoded: Vec<Step<Decoded>> =
                read.into_par_iter().map(|i| self.decoded(i)).collect();
            for step in decoded {
                let step = streams.passed_over(step);
                frames += usize::from(matches!(step, Step::Looked(..)));
                waiting.push(step);
            }
        }
        (waiting, false)
    }

    /// The next batch, encoded; empty at the end.
    fn read(self, items: &mut impl Iterator<Item = Item>) -> Vec<Item> {
        let wanted = || !self.stop.load(Ordering::Relaxed);
        std::iter::from_fn(|| if wanted() { items.next() } else { None })
            .take(self.batch)
            .collect()
    }

    fn decoded(self, item: Item) -> Step<Decoded> {
        let recorded = match item {
            Item::Warning(text) => return Step::Warning(text),
            Item::Frame(recorded) => recorded,
        };
        let origin = recorded.origin().clone();
        match recorded.read() {
            Ok(frame) => {
                let compared = self.skip_repeats && origin.is_stream();
                let thumbnail = compared.then(|| Thumbnail::of(&frame));
                Step::Looked(origin, Decoded { frame, thumbnail })
            }
            Err(error) => Step::Unreadable(origin, error),
        }
    }
}

/// The repeats of one stream after the other.
#[derive(Debug, Default)]
struct Streams {
    path: Option<PathBuf>,
    repeats: Repeats,
}

impl Streams {
    /// Drops the picture of a frame that is a repeat.
    fn passed_over(&mut self, step: Step<Decoded>) -> Step<Frame> {
        match step {
            Step::Warning(text) => Step::Warning(text),
            Step::Unreadable(origin, error) => Step::Unreadable(origin, error),
            Step::Repeat(origin) => Step::Repeat(origin),
            Step::Looked(origin, Decoded { frame, thumbnail }) => {
                let repeats = thumbnail.is_some_and(|thumbnail| {
                    if self.path.as_ref() != Some(&origin.path) {
                        self.repeats = Repeats::default();
                        self.path = Some(origin.path.clone());
                    }
                    self.repeats.is_repeat(thumbnail)
                });
                if repeats {
                    Step::Repeat(origin)
                } else {
                    Step::Looked(origin, frame)
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Inputs;
    use image::{GrayImage, Luma};

    /// Files of which every third is no picture.
    fn files(folder: &std::path::Path, count: u8) -> Vec<PathBuf> {
        let write = |number: u8| {
            let path = folder.join(format!("{number}.png"));
            if number % 3 == 2 {
                std::fs::write(&path, "no picture").unwrap();
            } else {
                let picture = GrayImage::from_pixel(4, 3, Luma([number]));
                picture.save(&path).unwrap();
            }
            path
        };
        (0..count).map(write).collect()
    }

    /// The numbers that were taken, negative where there is no picture, until `until` of them.
    fn taken(paths: &[PathBuf], batch: usize, stop: &AtomicBool, until: usize) -> Vec<i32> {
        let items = Inputs::open(paths.to_vec(), None).unwrap().items();
        let looking = Looking {
            batch,
            skip_repeats: true,
            stop,
        };
        let number = |origin: &Origin| -> i32 {
            let stem = origin.path.file_stem().unwrap();
            stem.to_str().unwrap().parse().unwrap()
        };
        let mut all = Vec::new();
        let look = |origin: &Origin, _: Frame| number(origin);
        looking
            .each(items, look, |step| {
                all.push(match step {
                    Step::Looked(_, number) => number,
                    Step::Unreadable(origin, _) => -number(&origin),
                    other => panic!("{other:?}"),
                });
                Ok(if all.len() < until {
                    ControlFlow::Continue(())
                } else {
                    ControlFlow::Break(())
                })
            })
            .unwrap();
        all
    }

    #[test]
    fn results_come_in_order_whatever_the_batch_until_nobody_wants_more() {
        let folder = tempfile::tempdir().unwrap();
        let paths = files(folder.path(), 20);
        let expected: Vec<i32> = (0..20).map(|n| if n % 3 == 2 { -n } else { n }).collect();
        let stop = AtomicBool::new(false);
        for batch in [1, 3, 100] {
            assert_eq!(taken(&paths, batch, &stop, usize::MAX), expected);
            assert_eq!(taken(&paths, batch, &stop, 7), expected[..7]);
        }
        stop.store(true, Ordering::Relaxed);
        assert!(taken(&paths, 3, &stop, usize::MAX).is_empty());
    }
}
