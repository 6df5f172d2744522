//! Files that are there whole or not at all.

use std::io::{self, Write};
use std::path::Path;

/// Writes `bytes` to a temporary file in the folder of `path` and renames it to `path`.
///
/// Whoever reads `path` sees the old content or the new, never a part, whatever happens in between. A file that was there is
/// replaced and hands its permissions on; a new one gets those of any new file. The temporary file is removed
/// where something fails.
///
/// # Errors
/// What the operating system says: the folder is missing or not writable, the disk is full, `path` is a folder...
pub fn write_by_rename(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut temporary = with_usual_permissions(&mut tempfile::Builder::new())
        .prefix(".ringcal-")
        .tempfile_in(folder)?;
    temporary.write_all(bytes)?;
    // before the rename, or a power cut could leave the new name with nothing in it
    temporary.as_file().sync_all()?;
    if let Ok(old) = std::fs::metadata(path) {
        temporary.as_file().set_permissions(old.permissions())?;
    }
    temporary.persist(path).map_err(|failed| failed.error)?;
    Ok(())
}

/// Temporary files are for their owner alone; results are for whom the umask says.
#[cfg(unix)]
fn with_usual_permissions<'a, 'b>(
    builder: &'a mut tempfile::Builder<'b, 'b>,
) -> &'a mut tempfile::Builder<'b, 'b> {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(std::fs::Permissions::from_mode(0o666))
}

/// Elsewhere a new file inherits its permissions from the folder.
#[cfg(not(unix))]
fn with_usual_permissions<'a, 'b>(
    builder: &'a mut tempfile::Builder<'b, 'b>,
) -> &'a mut tempfile::Builder<'b, 'b> {
    builder
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn writes_and_replaces_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera_info.yaml");
        write_by_rename(&path, b"a longer first version").unwrap();
        write_by_rename(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(names(folder.path()), ["camera_info.yaml"]);
    }

    #[test]
    fn failure_leaves_the_old_state() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing").join("a.yaml");
        let error = write_by_rename(&missing, b"x").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        // a folder cannot be replaced by a file
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        fs::write(taken.join("inside"), "kept").unwrap();
        assert!(write_by_rename(&taken, b"x").is_err());
        assert_eq!(names(folder.path()), ["taken"]);
        assert_eq!(fs::read(taken.join("inside")).unwrap(), b"kept");
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_those_of_any_file_or_of_the_one_replaced() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        let (ours, usual) = (folder.path().join("ours"), folder.path().join("usual"));
        fs::write(&usual, "x").unwrap();
        write_by_rename(&ours, b"x").unwrap();
        assert_eq!(mode(&ours), mode(&usual));
        fs::set_permissions(&ours, fs::Permissions::from_mode(0o640)).unwrap();
        write_by_rename(&ours, b"y").unwrap();
        assert_eq!(mode(&ours), 0o640);
    }
}
