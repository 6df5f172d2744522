//! The records of an MCAP file one after the other, those in chunks included.

use crate::source::bag::message::LONGEST_MESSAGE;
use crate::source::bag::storage::StorageError;
use ::mcap::parse_record;
use ::mcap::records::Record;
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::io::{self, Read};

/// The source is asked for this many bytes at a time at most: a record that claims to be longer than the file must not cost the
/// memory before its bytes are there.
const PIECE: usize = 1 << 20;

/// Room for a message and what surrounds it in a record, bytes.
const LONGEST_RECORD: usize = LONGEST_MESSAGE + 64;

/// The records of a file up to the end of its data; what follows there, summary and index, is not needed.
pub(super) struct Records<R> {
    source: R,
    reader: LinearReader,
    /// The data are read, or after an error nothing can be told apart any more.
    ended: bool,
}

impl<R: Read> Records<R> {
    pub(super) fn new(source: R) -> Self {
        let options = LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD);
        Self {
            source,
            reader: LinearReader::new_with_options(options),
            ended: false,
        }
    }

    /// Hands record after record to `pick` until it makes something of one. `None` after the last record of a file that is whole, or
    /// after an error.
    pub(super) fn find<T>(
        &mut self,
        mut pick: impl FnMut(Record) -> Option<T>,
    ) -> Option<Result<T, StorageError>> {
        while !self.ended {
            match self.step(&mut pick) {
                Ok(None) => {}
                Ok(Some(found)) => return Some(Ok(found)),
                Err(error) => {
                    self.ended = true;
                    return Some(Err(error));
                }
            }
        }
        None
    }

    fn step<T>(
        &mut self,
        pick: &mut impl FnMut(Record) -> Option<T>,
    ) -> Result<Option<T>, StorageError> {
        let needed = match self.reader.next_event() {
            None => {
                self.ended = true;
                return Ok(None);
            }
            Some(Err(error)) => return Err(error.into()),
            Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                let record = parse_record(opcode, data)?;
                self.ended = matches!(record, Record::DataEnd(_));
                return Ok(pick(record));
            }
            Some(Ok(LinearReadEvent::ReadRequest(needed))) => needed.min(PIECE),
        };
        let read = loop {
            match self.source.read(self.reader.insert(needed)) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                read => break read?,
            }
        };
        // no bytes mean the end of the file
        self.reader.notify_read(read);
        Ok(None)
    }
}
