//! `ringcal detect --overlay`: pictures of what was found.

use crate::board::Board;
use crate::detect::{Detection, Miss};
use crate::formats::write_by_rename;
use crate::frame::Frame;
use crate::report::{Scale, overlay, png};
use crate::source::{Inputs, Origin};
use anyhow::Context;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// A folder of pictures of what was found, named after the images.
pub(super) struct Overlays {
    folder: PathBuf,
    /// Names that are taken: images of two folders may be called the same.
    taken: HashSet<PathBuf>,
    /// The files that are read, without links.
    inputs: HashSet<PathBuf>,
}

impl Overlays {
    /// Makes the folder where it is missing.
    ///
    /// # Errors
    /// An input that is named like one of the pictures in the folder, and a folder that cannot be made.
    pub(super) fn new(folder: PathBuf, inputs: &Inputs) -> anyhow::Result<Self> {
        let taken = HashSet::new();
        let there = inputs.files().filter_map(|path| path.canonicalize().ok());
        let overlays = Self {
            inputs: there.collect(),
            folder,
            taken,
        };
        if let Some(path) = overlays.over_an_input(inputs) {
            anyhow::bail!(
                "{} is an input, and the overlay of the same name would be written over it: choose another folder for \
                 --overlay",
                path.display()
            );
        }
        let folder = &overlays.folder;
        std::fs::create_dir_all(folder).with_context(|| format!("folder {}", folder.display()))?;
        Ok(overlays)
    }

    /// An overlay of an image file that would take the place of an input.
    fn over_an_input(&self, inputs: &Inputs) -> Option<PathBuf> {
        inputs
            .files()
            .map(|path| self.folder.join(format!("{}.png", stem(path))))
            .find(|path| self.is_input(path))
    }

    fn is_input(&self, path: &Path) -> bool {
        let path = path.canonicalize();
        path.is_ok_and(|path| self.inputs.contains(&path))
    }

    /// Draws what was found in a frame.
    pub(super) fn write(
        &mut self,
        origin: &Origin,
        frame: &Frame,
        board: &Board,
        outcome: &Result<Detection, Miss>,
    ) -> anyhow::Result<()> {
        let stem = match origin.number {
            Some(number) => format!("{}_{number:06}", stem(&origin.path)),
            None => stem(&origin.path),
        };
        let path = std::iter::once(format!("{stem}.png"))
            .chain((2..).map(|n| format!("{stem}_{n}.png")))
            .map(|name| self.folder.join(name))
            .find(|path| !self.taken.contains(path) && !self.is_input(path))
            .context("no free name for the overlay")?;
        let picture = overlay(frame, board, outcome.as_ref(), &[], Scale::default());
        write_by_rename(&path, &png(&picture)?).with_context(|| format!("{}", path.display()))?;
        self.taken.insert(path);
        Ok(())
    }
}

fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}
