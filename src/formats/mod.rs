//! The files ringcal reads and writes.

mod write_by_rename;

pub use write_by_rename::write_by_rename;
