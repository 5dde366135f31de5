//! Check: runs the reference cases through the functions that the node uses, and says by how much
//! they pass.
//!
//! ```text
//! files -> case -> kinds: how is this kind run, what is its tolerance? -> findings -> report
//!                    |
//!   resolve  impact  detect  invalid  trajectory  exact_solutions  collapse  statistics
//!   stepped  penalty  periodic
//! ```
//!
//! A case is a JSON file (tests/cases/README.md). It is run by its `kind` alone, whatever its
//! numbers, and its tolerance is read from it. The expected values and the tolerances are computed
//! here; what is under test never is: scenes go through [`crate::world::World::step`], pairs
//! through [`crate::resolve`] and [`crate::detect`], bad input through [`crate::receive`] and
//! [`crate::scene`]. The only clock here is the stopwatch below.

pub(crate) mod arena;
pub(crate) mod case;
mod files;
mod finding;
mod formula;
mod kinds;
mod number;
mod report;

mod collapse;
mod detect;
mod exact_solutions;
mod impact;
mod invalid;
mod penalty;
mod periodic;
mod resolve;
pub(crate) mod statistics;
mod stepped;
mod trajectory;

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::Instant;

use serde_json::Value;

use arena::Trouble;
use case::{Field, Read};
pub use files::BadUse;
use files::CaseFile;
pub use finding::{Finding, Verdict};

/// What to check.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The folder of the cases, or one file; `None` = the one in the project.
    pub cases: Option<PathBuf>,
    /// Only cases whose name fits this pattern.
    pub only: Option<String>,
    /// Shorter statistics, no long runs.
    pub quick: bool,
    /// One JSON document instead of a table.
    pub json: bool,
}

/// How much time a case may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// As long as the stated error needs, days if must be: only where a case is asked for by name.
    Days,
    /// As long as the stated error needs.
    Full,
    /// A minute for all cases.
    Quick,
}

impl Effort {
    /// Whether statistics are as good as stated.
    fn is_full(self) -> bool {
        self != Self::Quick
    }
}

/// How one case went.
#[derive(Clone, Debug)]
pub struct CaseReport {
    /// Its name.
    pub name: String,
    /// Its kind, as far as it could be read.
    pub kind: String,
    /// How it went as a whole.
    pub verdict: Verdict,
    /// Why it was not run, or what is wrong with the file.
    pub reason: String,
    /// Its sub-cases.
    pub findings: Vec<Finding>,
    /// Wall time used, s.
    pub seconds: f64,
}

impl CaseReport {
    /// The finding with the worst verdict, of these the one nearest to its tolerance or beyond it.
    pub fn worst(&self) -> Option<&Finding> {
        let ratio = |finding: &Finding| match finding.error / finding.tolerance {
            ratio if ratio.is_nan() => 0.0,
            ratio => ratio,
        };
        self.findings
            .iter()
            .max_by(|a, b| a.verdict.cmp(&b.verdict).then(ratio(a).total_cmp(&ratio(b))))
    }
}

/// How many cases went how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Passed, gold and information included.
    pub passed: usize,
    /// Failed.
    pub failed: usize,
    /// Not run.
    pub skipped: usize,
}

impl Summary {
    /// Of these.
    pub fn of(reports: &[CaseReport]) -> Self {
        let mut summary = Self::default();
        for report in reports {
            match report.verdict {
                Verdict::Gold | Verdict::Pass | Verdict::Shown => summary.passed += 1,
                Verdict::Skip => summary.skipped += 1,
                Verdict::Fail => summary.failed += 1,
            }
        }
        summary
    }
}

/// Why a check did not come to its end.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// No such folder, file or case.
    #[error(transparent)]
    BadUse(#[from] BadUse),
    /// The reader of the report has gone.
    #[error("cannot write the report: {0}")]
    Output(#[from] io::Error),
}

/// Runs the cases, writes the report to `out`, and counts.
///
/// # Errors
/// [`CheckError`]; a malformed case file is none, it is a failed case.
pub fn check(options: &Options, out: &mut impl Write) -> Result<Summary, CheckError> {
    let (files, effort) = wanted(options)?;
    let mut reports = Vec::with_capacity(files.len());
    each_in_order(&files, effort, |report| {
        if !options.json {
            report::row(&report, out)?;
        }
        reports.push(report);
        Ok(())
    })?;
    let summary = Summary::of(&reports);
    match options.json {
        true => report::json(&reports, &summary, out)?,
        false => report::ending(&summary, out)?,
    }
    Ok(summary)
}

/// Runs the cases as [`check()`] does; `see` gets the reports in the order of the files, with how
/// many of how many there are then.
///
/// # Errors
/// [`BadUse`].
#[cfg(feature = "report")]
pub(crate) fn reports(
    options: &Options,
    mut see: impl FnMut(usize, usize),
) -> Result<Vec<CaseReport>, BadUse> {
    let (files, effort) = wanted(options)?;
    let mut reports = Vec::with_capacity(files.len());
    let seen = each_in_order(&files, effort, |report| {
        reports.push(report);
        see(reports.len(), files.len());
        Ok(())
    });
    seen.map(|()| reports).map_err(|error| BadUse(error.to_string()))
}

/// The cases, and how much time each may take.
fn wanted(options: &Options) -> Result<(Vec<CaseFile>, Effort), BadUse> {
    let files = files::read(options.cases.as_deref(), options.only.as_deref())?;
    let effort = match (options.quick, &options.only) {
        (true, _) => Effort::Quick,
        (false, Some(_)) => Effort::Days,
        (false, None) => Effort::Full,
    };
    Ok((files, effort))
}

/// Runs the cases on all cores; `see` gets the reports in the order of the files.
fn each_in_order(
    files: &[CaseFile],
    effort: Effort,
    mut see: impl FnMut(CaseReport) -> io::Result<()>,
) -> io::Result<()> {
    let next = AtomicUsize::new(0);
    let (done, reports) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, |cores| cores.get()) {
            let (next, done) = (&next, done.clone());
            scope.spawn(move || {
                while let Some((k, file)) = {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    files.get(k).map(|file| (k, file))
                } {
                    // Nobody listens any more: the output has gone.
                    if done.send((k, run(file, effort))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(done);
        let mut waiting = BTreeMap::new();
        let mut due = 0;
        for (k, report) in reports {
            waiting.insert(k, report);
            while let Some(report) = waiting.remove(&due) {
                see(report)?;
                due += 1;
            }
        }
        Ok(())
    })
}

fn run(file: &CaseFile, effort: Effort) -> CaseReport {
    let start = Instant::now();
    let mut report = CaseReport {
        name: file.stem.clone(),
        kind: String::new(),
        verdict: Verdict::Fail,
        reason: String::new(),
        findings: Vec::new(),
        seconds: 0.0,
    };
    match serde_json::from_slice(&file.bytes) {
        Ok(document) => judge(&document, effort, &mut report),
        Err(error) => report.reason = format!("not JSON: {error}"),
    }
    report.seconds = start.elapsed().as_secs_f64();
    report
}

/// Runs one case and fills in how it went.
fn judge(document: &Value, effort: Effort, report: &mut CaseReport) {
    let root = Field::root(document);
    let outcome = head(&root, report).map_err(Trouble::from).and_then(|needs| {
        match kinds::find(&report.kind, &needs, effort) {
            Ok(runner) => runner(&root, effort).map(Ok),
            Err(reason) => Ok(Err(reason)),
        }
    });
    match outcome {
        Ok(Ok(findings)) => {
            let informative = report::is_information(&root);
            report.findings = findings;
            report.findings.iter_mut().filter(|_| informative).for_each(show_only);
            let verdicts = report.findings.iter().map(|finding| finding.verdict);
            report.verdict = verdicts.max().unwrap_or(Verdict::Fail);
        }
        Ok(Err(reason)) => (report.verdict, report.reason) = (Verdict::Skip, reason),
        Err(trouble) => report.reason = trouble.to_string(),
    }
    if report.verdict == Verdict::Fail && report.findings.is_empty() && report.reason.is_empty() {
        report.reason = "no sub-cases".to_owned();
    }
}

/// Name and kind into the report; the needs.
fn head(root: &Field, report: &mut CaseReport) -> Read<Vec<String>> {
    if let Some(name) = root.find("name") {
        report.name = name.words()?.to_owned();
    }
    report.kind = root.get("kind")?.words()?.to_owned();
    let Some(needs) = root.find("needs") else { return Ok(Vec::new()) };
    needs.items()?.iter().map(|need| need.words().map(str::to_owned)).collect()
}

fn show_only(finding: &mut Finding) {
    finding.verdict = Verdict::Shown;
}
