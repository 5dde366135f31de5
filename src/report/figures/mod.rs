//! The figures, one file a question, in the order of the page. Each measures and fills a section;
//! none draws.

use super::Entry;

/// Name, expected share of the whole time, and how to measure it.
pub const ALL: &[Entry] = &[];
