//! rosbag2's own compression: whole files (`FILE`) and single messages (`MESSAGE`), both zstd.
//!
//! Whether something is compressed is seen from its first bytes, which no file and no message can have otherwise; what
//! metadata.yaml says of it is not needed.

use super::message::LONGEST_MESSAGE;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;
use tempfile::TempPath;

/// A zstd frame begins with these bytes; a CDR message with two zeros at most.
pub(super) const MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// A window of 128 MiB, the largest that zstd's own tool opens unasked.
const LARGEST_WINDOW_LOG: u32 = 27;

/// Why a compressed message cannot be unpacked.
#[derive(Debug, thiserror::Error)]
pub enum UnpackError {
    /// The zstd frame is damaged.
    #[error("the message's compression is damaged: {0}")]
    Damaged(io::Error),
    /// It holds more than any image.
    #[error("unpacked the message is longer than {LONGEST_MESSAGE} bytes")]
    TooLong,
}

/// The message itself, where it is compressed.
pub(super) fn unpack_message(data: Vec<u8>) -> Result<Vec<u8>, UnpackError> {
    if !data.starts_with(&MAGIC) {
        return Ok(data);
    }
    let mut unpacked = Vec::new();
    let decoder = decoder(&*data).map_err(UnpackError::Damaged)?;
    let limit = LONGEST_MESSAGE as u64 + 1;
    let read = decoder.take(limit).read_to_end(&mut unpacked);
    if read.map_err(UnpackError::Damaged)? > LONGEST_MESSAGE {
        return Err(UnpackError::TooLong);
    }
    Ok(unpacked)
}

/// What a compressed file holds, from the start on.
pub(super) fn unpacking(path: &Path) -> io::Result<impl Read + Send + use<>> {
    decoder(BufReader::new(File::open(path)?))
}

/// What a compressed file holds as a file of its own, in the folder for temporary files, until it is dropped. Of a compressed
/// file that is damaged or cut off, what comes before the damage, and the damage.
pub(super) fn unpacked_file(path: &Path) -> io::Result<(TempPath, Option<io::Error>)> {
    let mut file = tempfile::NamedTempFile::new()?;
    let mut source = unpacking(path)?;
    let mut buffer = vec![0; 1 << 20];
    loop {
        match source.read(&mut buffer) {
            Ok(0) => return Ok((file.into_temp_path(), None)),
            // a full disk is not the bag's end
            Ok(read) => io::Write::write_all(&mut file, &buffer[..read])?,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(damage) => return Ok((file.into_temp_path(), Some(damage))),
        }
    }
}

fn decoder<R: Read>(source: R) -> io::Result<impl Read + use<R>> {
    let mut decoder = ::zstd::stream::read::Decoder::new(source)?;
    decoder.window_log_max(LARGEST_WINDOW_LOG)?;
    Ok(decoder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_compressed_stays_as_it_is() {
        let plain = vec![0, 1, 0, 0, 9];
        assert_eq!(unpack_message(plain.clone()).unwrap(), plain);
        let packed = ::zstd::encode_all(&*plain, 1).unwrap();
        assert_eq!(unpack_message(packed.clone()).unwrap(), plain);
        let cut = packed[..packed.len() - 2].to_vec();
        assert!(matches!(unpack_message(cut), Err(UnpackError::Damaged(_))));
    }

    #[test]
    fn a_cut_file_is_unpacked_as_far_as_it_goes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.zstd");
        // pseudo-random, so that it does not shrink to one block
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let plain: Vec<u8> = (0..400_000).map(|_| next()).collect();
        let packed = ::zstd::encode_all(&*plain, 1).unwrap();
        std::fs::write(&path, &packed).unwrap();
        let (file, damage) = unpacked_file(&path).unwrap();
        assert!(damage.is_none());
        assert!(std::fs::read(&file).unwrap() == plain);
        std::fs::write(&path, &packed[..packed.len() * 2 / 3]).unwrap();
        let (file, damage) = unpacked_file(&path).unwrap();
        assert!(damage.is_some());
        let got = std::fs::read(&file).unwrap();
        assert!(!got.is_empty() && plain.starts_with(&got));
    }
}
