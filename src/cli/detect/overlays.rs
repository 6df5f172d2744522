//! `ringcal detect --overlay`: pictures of what was found.

use crate::board::Board;
use crate::detect::{Detection, Miss};
use crate::formats::write_by_rename;
use crate::frame::Frame;
use crate::report::{Scale, overlay, png};
use crate::source::Origin;
use anyhow::Context;
use std::collections::HashSet;
use std::path::PathBuf;

/// A folder of pictures of what was found, named after the images.
pub(super) struct Overlays {
    folder: PathBuf,
    /// Names that are taken: images of two folders may be called the same.
    taken: HashSet<PathBuf>,
}

impl Overlays {
    /// Makes the folder where it is missing.
    pub(super) fn new(folder: PathBuf) -> anyhow::Result<Self> {
        std::fs::create_dir_all(&folder).with_context(|| format!("folder {}", folder.display()))?;
        let taken = HashSet::new();
        Ok(Self { folder, taken })
    }

    /// Draws what was found in a frame.
    pub(super) fn write(
        &mut self,
        origin: &Origin,
        frame: &Frame,
        board: &Board,
        outcome: &Result<Detection, Miss>,
    ) -> anyhow::Result<()> {
        let stem = origin.path.file_stem().unwrap_or_default();
        let stem = match origin.number {
            Some(number) => format!("{}_{number:06}", stem.to_string_lossy()),
            None => stem.to_string_lossy().into_owned(),
        };
        let path = std::iter::once(format!("{stem}.png"))
            .chain((2..).map(|n| format!("{stem}_{n}.png")))
            .map(|name| self.folder.join(name))
            .find(|path| !self.taken.contains(path))
            .context("no free name for the overlay")?;
        let picture = overlay(frame, board, outcome.as_ref(), &[], Scale::default());
        write_by_rename(&path, &png(&picture)?).with_context(|| format!("{}", path.display()))?;
        self.taken.insert(path);
        Ok(())
    }
}
