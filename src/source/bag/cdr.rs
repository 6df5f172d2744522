//! Reading CDR, the form in which ROS 2 messages are recorded: a header of four bytes, then the fields, numbers aligned to their
//! own size counted from the end of the header.
//!
//! Every length is held against the bytes that are there before anything is taken, so a damaged message is an error and
//! nothing else.

/// No `frame_id` or name of an encoding is longer, bytes.
const LONGEST_STRING: u32 = 4096;

/// Why bytes are not the message they should be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// The header names another encoding than plain CDR, or is missing.
    #[error("the message is not in plain CDR: it begins with {header:02x?}")]
    NotCdr {
        /// Its first bytes, four at most.
        header: Vec<u8>,
    },
    /// A field reaches beyond the end.
    #[error(
        "the message ends in the middle of its {field}: {needed} bytes are needed, {left} are left"
    )]
    EndsEarly {
        /// The field's name.
        field: &'static str,
        /// Bytes that the field takes.
        needed: u64,
        /// Bytes from its place to the end.
        left: usize,
    },
    /// A text of a length that no such text has.
    #[error("its {field} is said to be {length} bytes long, which is not believed")]
    LongText {
        /// The field's name.
        field: &'static str,
        /// Bytes it is said to have.
        length: u32,
    },
}

/// A place in a message.
#[derive(Debug)]
pub(super) struct Cdr<'a> {
    /// All that follows the header; alignment counts from its start.
    body: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl<'a> Cdr<'a> {
    /// The start of a message's fields.
    pub(super) fn new(message: &'a [u8]) -> Result<Self, CdrError> {
        let not_cdr = || CdrError::NotCdr {
            header: message.iter().take(4).copied().collect(),
        };
        let (header, body) = message.split_first_chunk::<4>().ok_or_else(not_cdr)?;
        // 0 and 1 are CDR, 6 and 7 its second edition, which differs in numbers of eight bytes alone; images have none
        let big_endian = match header[..2] {
            [0, 0 | 6] => true,
            [0, 1 | 7] => false,
            _ => return Err(not_cdr()),
        };
        Ok(Self {
            body,
            at: 0,
            big_endian,
        })
    }

    /// `uint8`.
    pub(super) fn u8(&mut self, field: &'static str) -> Result<u8, CdrError> {
        self.take(field, 1).map(|bytes| bytes[0])
    }

    /// `uint32`.
    pub(super) fn u32(&mut self, field: &'static str) -> Result<u32, CdrError> {
        self.at = self.at.next_multiple_of(4);
        let bytes = self.take(field, 4)?;
        let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
        Ok(if self.big_endian {
            u32::from_be_bytes(bytes)
        } else {
            u32::from_le_bytes(bytes)
        })
    }

    /// `int32`.
    pub(super) fn i32(&mut self, field: &'static str) -> Result<i32, CdrError> {
        self.u32(field).map(u32::cast_signed)
    }

    /// `string`; what is not UTF-8 in it is replaced.
    pub(super) fn string(&mut self, field: &'static str) -> Result<String, CdrError> {
        let length = self.u32(field)?;
        if length > LONGEST_STRING {
            return Err(CdrError::LongText { field, length });
        }
        let bytes = self.take(field, u64::from(length))?;
        // the length counts the zero at the end; some writers leave it out of an empty string
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        Ok(String::from_utf8_lossy(text).into_owned())
    }

    /// `uint8[]`.
    pub(super) fn bytes(&mut self, field: &'static str) -> Result<&'a [u8], CdrError> {
        let length = self.u32(field)?;
        self.take(field, u64::from(length))
    }

    fn take(&mut self, field: &'static str, needed: u64) -> Result<&'a [u8], CdrError> {
        // alignment may have moved the place beyond the end
        let rest = self.body.get(self.at..).unwrap_or_default();
        let taken = usize::try_from(needed).ok().and_then(|n| rest.get(..n));
        let taken = taken.ok_or(CdrError::EndsEarly {
            field,
            needed,
            left: rest.len(),
        })?;
        self.at += taken.len();
        Ok(taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_and_of_either_byte_order() {
        let little = [0, 1, 0, 0, 7, 9, 9, 9, 1, 2, 0, 0];
        let mut cdr = Cdr::new(&little).unwrap();
        assert_eq!((cdr.u8("a"), cdr.u32("b")), (Ok(7), Ok(0x201)));
        let big = [0, 0, 0, 0, 7, 9, 9, 9, 0xff, 0xff, 0xff, 0xfe];
        let mut cdr = Cdr::new(&big).unwrap();
        assert_eq!((cdr.u8("a"), cdr.i32("b")), (Ok(7), Ok(-2)));
    }

    #[test]
    fn strings_lose_their_zero_and_empty_ones_need_none() {
        let text = [0, 1, 0, 0, 3, 0, 0, 0, b'a', b'b', 0, 9, 0, 0, 0, 0, 5];
        let mut cdr = Cdr::new(&text).unwrap();
        assert_eq!(cdr.string("a").unwrap(), "ab");
        assert_eq!(cdr.string("b").unwrap(), "");
        assert_eq!(cdr.u8("c"), Ok(5));
    }

    #[test]
    fn what_is_not_there_is_not_read() {
        assert!(matches!(Cdr::new(&[0, 1, 0]), Err(CdrError::NotCdr { .. })));
        assert!(matches!(
            Cdr::new(b"\x00\x03\x00\x00rest"),
            Err(CdrError::NotCdr { .. })
        ));
        let huge = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 1];
        let left = 1;
        assert_eq!(
            Cdr::new(&huge).unwrap().bytes("data"),
            Err(CdrError::EndsEarly {
                field: "data",
                needed: 0xffff_ffff,
                left
            })
        );
        assert!(matches!(
            Cdr::new(&huge).unwrap().string("name"),
            Err(CdrError::LongText { .. })
        ));
        let mut cdr = Cdr::new(&[0, 1, 0, 0, 1]).unwrap();
        assert_eq!(cdr.u8("a"), Ok(1));
        assert!(cdr.u32("b").is_err());
        assert!(cdr.u8("c").is_err());
    }
}
