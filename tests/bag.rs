//! Bags: what is written comes back, and what is broken is named, never believed, never changed.

#[path = "bag/broken.rs"]
mod broken;
#[path = "bag/common.rs"]
mod common;
#[path = "bag/database.rs"]
mod database;
#[path = "bag/reading.rs"]
mod reading;
#[cfg(feature = "ros")]
#[path = "bag/recorder.rs"]
mod recorder;
#[path = "bag/runs.rs"]
mod runs;
#[path = "bag/writing.rs"]
mod writing;
