//! Opening a SQLite file without touching it, whatever its recorder left behind.
//!
//! A recorder that was killed may leave the last messages in a write-ahead log beside the file (`-wal`). They are read from there;
//! an ordinary connection would fold the log into the file, or at least put an index beside it.

use crate::source::bag::files::BagFile;
use crate::source::bag::storage::StorageError;
use crate::source::bag::zstd;
use rusqlite::config::DbConfig;
use rusqlite::{Connection, ErrorCode, OpenFlags};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// An open file. The connection is dropped before the unpacked copy that it reads.
pub(super) struct Opened {
    pub(super) connection: Connection,
    /// How its compression ended early.
    pub(super) damage: Option<io::Error>,
    path: PathBuf,
    _unpacked: Option<TempPath>,
}

impl Opened {
    pub(super) fn new(file: &BagFile) -> Result<Self, StorageError> {
        let (path, unpacked, damage) = if file.packed {
            let (unpacked, damage) = zstd::unpacked_file(&file.path)?;
            (unpacked.to_path_buf(), Some(unpacked), damage)
        } else {
            (file.path.clone(), None, None)
        };
        // SQLite takes an empty file for an empty database
        if std::fs::metadata(&path)?.len() == 0 {
            return Err(damage.map_or(StorageError::CutOff, StorageError::from));
        }
        Ok(Self {
            connection: connect(&path)?,
            damage,
            path,
            _unpacked: unpacked,
        })
    }

    /// What an error while reading means: a file that is shorter than it says was cut off.
    pub(super) fn explain(&mut self, error: rusqlite::Error) -> StorageError {
        if let Some(damage) = self.damage.take() {
            return damage.into();
        }
        // a page that is missing is corruption, one of which a part is there a short read
        let short = matches!(
            error.sqlite_error_code(),
            Some(ErrorCode::DatabaseCorrupt | ErrorCode::SystemIoFailure)
        );
        if short && is_cut_off(&self.path) == Some(true) {
            StorageError::CutOff
        } else {
            error.into()
        }
    }
}

fn connect(path: &Path) -> rusqlite::Result<Connection> {
    if has_log(path)
        && let Ok(connection) = with_log(path)
    {
        return Ok(connection);
    }
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI;
    let connection = Connection::open_with_flags(immutable_uri(path), flags)?;
    forgiving(&connection)?;
    Ok(connection)
}

/// Lets SQLite open a file that is shorter than its header says. Nothing is written: the connection is read-only.
fn forgiving(connection: &Connection) -> rusqlite::Result<()> {
    connection.execute_batch("PRAGMA writable_schema = ON")
}

fn has_log(path: &Path) -> bool {
    let mut log = path.as_os_str().to_owned();
    log.push("-wal");
    std::fs::metadata(log).is_ok_and(|log| log.len() > 0)
}

/// A connection that reads the write-ahead log too and leaves everything as it is.
fn with_log(path: &Path) -> rusqlite::Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY;
    // without locks the index of the log can be kept in memory; elsewhere it becomes a file beside the bag
    let connection = if cfg!(unix) {
        Connection::open_with_flags_and_vfs(path, flags, c"unix-none")?
    } else {
        Connection::open_with_flags(path, flags)?
    };
    connection.set_db_config(DbConfig::SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, true)?;
    connection.query_row("PRAGMA locking_mode = EXCLUSIVE", [], |_| Ok(()))?;
    forgiving(&connection)?;
    // a journal of another kind, or a log that cannot be opened, shows here
    connection.query_row("SELECT count(*) FROM sqlite_master", [], |_| Ok(()))?;
    Ok(connection)
}

/// The name under which SQLite reads a file without locks, logs or journals.
fn immutable_uri(path: &Path) -> String {
    let mut uri = String::from("file:");
    for byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'_' | b'-' => {
                uri.push(char::from(*byte));
            }
            other => uri += &format!("%{other:02X}"),
        }
    }
    uri + "?immutable=1"
}

/// Whether a file has fewer pages than its header says.
fn is_cut_off(path: &Path) -> Option<bool> {
    let mut header = [0; 100];
    let mut file = File::open(path).ok()?;
    file.read_exact(&mut header).ok()?;
    // a page of 65536 bytes is written as 1
    let page = match u16::from_be_bytes([header[16], header[17]]) {
        1 => 65_536,
        size => u64::from(size),
    };
    let pages = u32::from_be_bytes([header[28], header[29], header[30], header[31]]);
    Some(file.metadata().ok()?.len() < page * u64::from(pages))
}
