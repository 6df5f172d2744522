//! The image files of a folder.

use super::SourceError;
use super::natural_order::natural_order;
use std::path::{Path, PathBuf};

/// Names that end like this are image files; which format they are is decided by their content.
pub(super) const EXTENSIONS: [&str; 11] = [
    "png", "jpg", "jpeg", "pgm", "ppm", "pbm", "pnm", "pam", "tif", "tiff", "bmp",
];

/// The image files of a folder in natural order of their names; folders in it are not entered and hidden files (`.x.png`)
/// not taken.
///
/// # Errors
/// [`SourceError`] where the folder cannot be listed or has no image files.
pub(super) fn image_files(folder: &Path) -> Result<Vec<PathBuf>, SourceError> {
    let listing = |reason| SourceError::from_io(folder, reason);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(listing)? {
        let path = entry.map_err(listing)?.path();
        if is_image_name(&path) && path.is_file() {
            files.push(path);
        }
    }
    if files.is_empty() {
        return Err(SourceError::EmptyFolder {
            path: folder.to_owned(),
        });
    }
    files.sort_by(|a, b| natural_order(&name(a), &name(b)).then_with(|| a.cmp(b)));
    Ok(files)
}

fn is_image_name(path: &Path) -> bool {
    let known = path.extension().is_some_and(|extension| {
        EXTENSIONS
            .iter()
            .any(|known| extension.eq_ignore_ascii_case(known))
    });
    known && !name(path).starts_with('.')
}

fn name(path: &Path) -> std::borrow::Cow<'_, str> {
    path.file_name().unwrap_or_default().to_string_lossy()
}
