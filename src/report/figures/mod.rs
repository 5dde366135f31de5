//! The figures, one file a question, in the order of the page. Each measures and fills a section;
//! none draws.

pub mod fit;

pub mod gas;

pub mod items;

pub mod long_time;

pub mod mover;

pub mod short_time;

pub mod statistics;

pub mod timing;

pub mod turns;

use super::Figure;

/// Name, expected share of the whole time, and how to measure it.
pub const ALL: &[(&str, f64, Figure)] = &[
    ("gas", 240.0, gas::section),
    ("short_time", 240.0, short_time::section),
    ("long_time", 300.0, long_time::section),
    ("statistics", 300.0, statistics::section),
];
