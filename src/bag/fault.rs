//! What can be wrong with a bag: one line, with the file, the place and what would be right.

use std::fmt;
use std::path::PathBuf;

/// What is wrong, and in which file.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", .path.display())]
pub struct BagError {
    /// The file or folder at fault.
    pub path: PathBuf,
    /// What is wrong with it.
    pub fault: Fault,
}

/// What is wrong with a file of a bag.
#[derive(Debug)]
pub enum Fault {
    /// The operating system does not let it be read.
    Unreadable(std::io::Error),
    /// It is no recording, or nothing that can be read here.
    NotABag(String),
    /// It ends too early.
    Cut {
        /// The last whole record ends here.
        at_byte: u64,
        /// The last message that could be read, ns since 1970.
        last_time_ns: Option<u64>,
    },
    /// A part of it is not what it should be and is left out.
    Damaged {
        /// Where the part begins, or the number of a row.
        at: u64,
        /// What is wrong with it.
        what: String,
    },
    /// It says of itself, or another file says of it, what it does not hold or makes no sense.
    Contradicts(String),
    /// Something that should be there is not; the rest can be read.
    Missing(String),
}

impl Fault {
    /// The fault of a file.
    pub(crate) fn of(self, path: &std::path::Path) -> BagError {
        BagError { path: path.to_owned(), fault: self }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(error) => write!(f, "cannot be read: {error}"),
            Self::NotABag(what) | Self::Contradicts(what) | Self::Missing(what) => {
                write!(f, "{what}")
            }
            Self::Cut { at_byte, last_time_ns: Some(time) } => write!(
                f,
                "ends too early: it can be read up to byte {at_byte}, the message of {} s",
                seconds(*time)
            ),
            Self::Cut { at_byte, last_time_ns: None } => {
                write!(f, "ends too early: nothing but its first {at_byte} bytes can be read")
            }
            Self::Damaged { at, what } => write!(f, "damaged at {at}: {what}"),
        }
    }
}

/// Nanoseconds since 1970 as seconds, every digit of them.
pub(crate) fn seconds(time_ns: u64) -> String {
    format!("{}.{:09}", time_ns / 1_000_000_000, time_ns % 1_000_000_000)
}
