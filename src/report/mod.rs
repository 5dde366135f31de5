//! The report: error against run time, for every method, on scenes with a known answer.
//!
//! ```text
//! figures: one question each, measured -> page: plots, maps, tables -> draw: CSV, SVG, HTML
//! ```
//!
//! Every figure is a function of the [`Effort`] alone; what is no run time has the same bits in
//! every report. Nothing here computes physics: scenes go through the same arena that the node
//! runs.

pub mod draw;

pub mod figures;

pub mod judge;

pub mod page;

use std::io;

use page::Section;

/// How long the report may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Under 3 minutes on two cores.
    Quick,
    /// Under 40 minutes.
    Full,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A run was wrong where it must not be.
    #[error("no report: {0}")]
    Wrong(String),
    /// The output.
    #[error("cannot write {path}: {error}")]
    Output {
        /// Which file or folder.
        path: String,
        /// Why.
        error: io::Error,
    },
}

/// Told how much of a figure is done, 0 to 1.
pub type Progress<'a> = &'a mut dyn FnMut(f64);

/// Measures one section.
pub type Figure = fn(Effort, Progress) -> Result<Section, ReportError>;
