//! The figures, one file a question, in the order of the page. Each measures and fills a section;
//! none draws.

pub mod items;

pub mod random;

pub mod timing;

pub mod turns;

pub mod mover;

pub mod fit;

pub mod gas;

pub mod short_time;

pub mod long_time;

pub mod statistics;

pub mod resolver;

pub mod impact;

pub mod scaling;

pub mod stability;

pub mod cases;

pub mod left_out;

use super::Figure;

/// Name, expected share of the whole time, and how to measure it.
pub const ALL: &[(&str, f64, Figure)] = &[
    ("gas", 240.0, gas::section),
    ("short_time", 240.0, short_time::section),
    ("long_time", 300.0, long_time::section),
    ("statistics", 300.0, statistics::section),
    ("resolver", 60.0, resolver::section),
    ("impact", 60.0, impact::section),
    ("scaling", 240.0, scaling::section),
    ("stability", 120.0, stability::section),
    ("cases", 650.0, cases::section),
    ("left_out", 60.0, left_out::section),
];
