//! Image files: whoever names them has chosen them, so all are used but repeats and strays.

use super::Collected;
use crate::cli::progress::Progress;
use crate::detect::Detection;
use crate::formats::Outcome;
use crate::frame::Thumbnail;
use crate::report::{MISSED_PICTURES, Picture, Pictures};
use crate::session::{Session, View};
use crate::source::Origin;

/// The files so far, in their order.
#[derive(Debug, Default)]
pub(super) struct Files {
    all: Vec<(String, Result<Detection, String>)>,
    boards: u64,
    pictures: Pictures,
    missed_pictures: usize,
}

impl Files {
    /// Takes in one file: what was found, and the file reduced.
    pub(super) fn add(
        &mut self,
        origin: &Origin,
        (found, small): (Result<Detection, String>, Option<Thumbnail>),
        progress: &Progress,
    ) {
        let source = origin.to_string();
        let shown = found.is_ok() || self.missed_pictures < MISSED_PICTURES;
        let picture = small.filter(|_| shown).and_then(|s| Picture::of(&s));
        if let Some(picture) = picture {
            self.missed_pictures += usize::from(found.is_err());
            self.pictures.insert(source.clone(), picture);
        }
        if let Ok(detection) = &found {
            self.boards += 1;
            let (rings, blur) = (detection.rings.len(), detection.blur_sigma_px());
            progress.remark(&format!("{source}: {rings} rings, blur {blur:.1} px"));
        }
        self.all.push((source, found));
    }

    /// The pictures, which are then no longer here.
    pub(super) fn take_pictures(&mut self) -> Pictures {
        std::mem::take(&mut self.pictures)
    }

    /// How many there are.
    pub(super) fn count(&self) -> u64 {
        self.all.len() as u64
    }

    /// How many of them show the board.
    pub(super) fn boards(&self) -> u64 {
        self.boards
    }

    /// Sizes of the frames with a board.
    pub(super) fn sizes(&self) -> impl Iterator<Item = (usize, usize)> {
        let found = self.all.iter().filter_map(|(_, found)| found.as_ref().ok());
        found.map(|detection| (detection.width, detection.height))
    }

    /// Offers all of them to a session, in their order; without one all are kept. Frames of another size than `size` are not of
    /// the same camera.
    pub(super) fn finish(
        self,
        collected: &mut Collected,
        mut session: Option<Session>,
        size: (usize, usize),
    ) {
        for (source, found) in self.all {
            let used = usable(&source, found, size, session.as_mut());
            collected.outcomes.push(match used {
                Ok(view) => {
                    collected.views.push(view);
                    Outcome::Used(collected.views.len() - 1)
                }
                Err(reason) => {
                    eprintln!("{source}: not used: {reason}");
                    Outcome::NotUsed { source, reason }
                }
            });
        }
    }
}

/// The view of a file, or why it is not used.
fn usable(
    source: &str,
    found: Result<Detection, String>,
    size: (usize, usize),
    session: Option<&mut Session>,
) -> Result<View, String> {
    let detection = found.map_err(|reason| {
        // the file's name stands before the reason already
        let bare = reason.strip_prefix(&format!("{source}: "));
        bare.map_or_else(|| reason.clone(), str::to_owned)
    })?;
    if let Some(reason) = of_other_size((detection.width, detection.height), size) {
        return Err(reason);
    }
    let view = View::of_file(source, &detection);
    let offer = session.map(|session| session.offer(view.clone()));
    match offer {
        Some(offer) if !offer.kept() => Err(offer.to_string()),
        _ => Ok(view),
    }
}

/// Why a frame of a size, px, is not used where most are of another.
pub(super) fn of_other_size(found: (usize, usize), size: (usize, usize)) -> Option<String> {
    (found != size).then(|| {
        format!(
            "{} x {} px, but most frames are {} x {} px: not of the same camera",
            found.0, found.1, size.0, size.1
        )
    })
}

/// Width and height, px, of most of the frames with a board, so that a stray picture decides nothing; of the first of them
/// where two are equally common.
pub(super) fn most_common_size(sizes: impl Iterator<Item = (usize, usize)>) -> (usize, usize) {
    let mut counts: Vec<((usize, usize), usize)> = Vec::new();
    for size in sizes {
        match counts.iter_mut().find(|(other, _)| *other == size) {
            Some((_, count)) => *count += 1,
            None => counts.push((size, 1)),
        }
    }
    let most = counts.iter().rev().max_by_key(|(_, count)| *count);
    most.map_or((0, 0), |(size, _)| *size)
}
