//! The report: error against run time, for every method, on scenes with a known answer.
//!
//! ```text
//! figures: one question each, measured -> page: plots, maps, tables -> draw: CSV, SVG, HTML
//!                                                                          -> folder: files
//! ```
//!
//! Every figure is a function of the [`Effort`] alone; what is no run time has the same bits in
//! every report. Nothing here computes physics: scenes go through the same arena that the node
//! runs. Figures run one after the other, so that none disturbs the run times of another.

pub mod draw;

pub mod digits;

pub mod figures;

pub mod judge;

pub mod page;

pub(crate) mod folder;

mod machine;

pub(crate) mod progress;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use page::{Page, Section};

/// How long the report may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// A minute on two cores.
    Quick,
    /// 22 minutes.
    Full,
}

/// What is wanted.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where the files go; it is made if there is none.
    pub folder: PathBuf,
    /// How long it may take.
    pub effort: Effort,
    /// Names of the figures; none = all.
    pub only: Vec<String>,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// Asked for what there is not.
    #[error("{0}")]
    BadUse(String),
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

/// Name, expected share of the whole time, and how to measure it.
pub type Entry = (&'static str, f64, Figure);

/// Measures all figures that are wanted, writes the files and says where the page is.
///
/// # Errors
/// [`ReportError`]; then nothing is written, or what is written is whole.
pub fn report(options: &Options, out: &mut impl Write) -> Result<(), ReportError> {
    report_on(figures::ALL, options, out)
}

/// The same for other figures.
///
/// # Errors
/// As [`report`].
pub fn report_on(
    figures: &[Entry],
    options: &Options,
    out: &mut impl Write,
) -> Result<(), ReportError> {
    let wanted = chosen(figures, &options.only)?;
    folder::prepare(&options.folder)?;
    let machine = machine::describe(options);
    let (seconds, sections) = crate::bench::seconds(|| measured(&wanted, options.effort));
    let files = draw::files(Page { machine, sections: sections?, ..Page::default() });
    folder::write(&options.folder, &files)?;
    tell(&options.folder.join(draw::INDEX), seconds, out)
        .map_err(|error| ReportError::Output { path: "standard output".to_owned(), error })
}

/// Those that were named, in the order of the page.
fn chosen(figures: &[Entry], only: &[String]) -> Result<Vec<Entry>, ReportError> {
    let names: Vec<&str> = figures.iter().map(|(name, ..)| *name).collect();
    if let Some(unknown) = only.iter().find(|wanted| !names.contains(&wanted.as_str())) {
        let known = names.join(", ");
        return Err(ReportError::BadUse(format!("--only {unknown}: no such figure, but {known}")));
    }
    let wanted = |name: &str| only.is_empty() || only.iter().any(|wanted| wanted == name);
    Ok(figures.iter().filter(|(name, ..)| wanted(name)).copied().collect())
}

fn measured(figures: &[Entry], effort: Effort) -> Result<Vec<Section>, ReportError> {
    let mut bar = progress::Bar::new(figures.iter().map(|(_, share, _)| share).sum());
    let mut sections = Vec::new();
    for (k, (name, share, figure)) in figures.iter().enumerate() {
        bar.begin(k + 1, figures.len(), name, *share);
        match figure(effort, &mut |part| bar.tell(part)) {
            Ok(section) => sections.push(section),
            Err(error) => {
                bar.end();
                return Err(error);
            }
        }
    }
    bar.end();
    Ok(sections)
}

fn tell(page: &Path, seconds: f64, out: &mut impl Write) -> io::Result<()> {
    let (minutes, seconds) = ((seconds / 60.0).floor(), seconds % 60.0);
    let minutes = if minutes > 0.0 { format!("{minutes} min ") } else { String::new() };
    writeln!(out, "{} ({minutes}{seconds:.0} s)", page.display())
}
