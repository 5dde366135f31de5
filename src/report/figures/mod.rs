//! The figures, one file a question, in the order of the page. Each measures and fills a section;
//! none draws.

use super::Figure;

/// Name, expected share of the whole time, and how to measure it.
pub const ALL: &[(&str, f64, Figure)] = &[];
