//! Small text files.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The text of a file; `None` where it is longer than `longest` bytes: a device or a picture given by mistake may be endless.
pub(super) fn read_at_most(path: &Path, longest: u64) -> io::Result<Option<String>> {
    let mut text = String::new();
    let read = File::open(path)?
        .take(longest + 1)
        .read_to_string(&mut text)?;
    Ok((read as u64 <= longest).then_some(text))
}
