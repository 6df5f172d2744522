//! Results on stdout, and readers of them that leave early.

use std::io::{self, Write};

/// Whether somebody still reads the results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reader {
    /// As far as is known.
    There,
    /// It closed the pipe, as `head` does when it has its lines: it wants no more, and nothing went wrong.
    Gone,
}

/// Writes whole lines to stdout, at once.
///
/// # Errors
/// What the operating system says, except that the reader has gone.
pub fn print(lines: &str) -> io::Result<Reader> {
    print_to(&mut io::stdout().lock(), lines)
}

fn print_to(stdout: &mut impl Write, lines: &str) -> io::Result<Reader> {
    let written = stdout.write_all(lines.as_bytes());
    match written.and_then(|()| stdout.flush()) {
        Ok(()) => Ok(Reader::There),
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(Reader::Gone),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Refuses everything for one reason.
    struct Broken(io::ErrorKind);

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(self.0.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Err(self.0.into())
        }
    }

    #[test]
    fn a_reader_that_leaves_is_no_failure_and_a_full_disk_is() {
        let mut written = Vec::new();
        assert_eq!(print_to(&mut written, "a\n").unwrap(), Reader::There);
        assert_eq!(written, b"a\n");
        let to = |kind| print_to(&mut Broken(kind), "a\n");
        assert_eq!(to(io::ErrorKind::BrokenPipe).unwrap(), Reader::Gone);
        let full = to(io::ErrorKind::StorageFull).unwrap_err();
        assert_eq!(full.kind(), io::ErrorKind::StorageFull);
    }
}
