//! The reference cases: which pass, by how much, and how long each took.
//!
//! They are run as `carom check` runs them. They are files of the project: a program that is
//! installed elsewhere says so instead.

use super::items::{numbers, short, times, words};
use crate::check::{self, CaseReport, Options, Summary, Verdict};
use crate::report::page::{Item, Section, Table};
use crate::report::{Effort, Progress, ReportError};

/// Measures the section.
///
/// # Errors
/// None; a case that fails is told.
pub fn section(effort: Effort, progress: Progress) -> Result<Section, ReportError> {
    section_of(&Options { quick: effort == Effort::Quick, ..Options::default() }, progress)
}

/// The same of other cases.
///
/// # Errors
/// As [`section`].
pub fn section_of(options: &Options, progress: Progress) -> Result<Section, ReportError> {
    let (title, name) = ("The reference cases".to_owned(), "cases");
    let see = |done: usize, all: usize| progress(done as f64 / all as f64);
    let (text, items) = match check::reports(options, see) {
        Ok(reports) => (text(options, &reports), vec![Item::Table(table(&reports))]),
        Err(why) => (vec![absent(&why.to_string())], Vec::new()),
    };
    Ok(Section { name, title, text, items })
}

fn absent(why: &str) -> String {
    format!(
        "Left out: the reference cases are files of carom's project and are not here ({why}); run \
         carom report in the folder of the project to see them."
    )
}

fn text(options: &Options, reports: &[CaseReport]) -> Vec<String> {
    let Summary { passed, failed, skipped } = Summary::of(reports);
    let command = if options.quick { "carom check --quick" } else { "carom check" };
    let of_them = |verdict| reports.iter().filter(|report| report.verdict == verdict).count();
    let failing = if failed == 0 { "none fails" } else { "THE FAILING ONES ARE WRONG" };
    let mut text = vec![
        "Scenes whose right answer is known better than any double: in closed form, from several \
         hundred bits, or published. They go through the functions that the node uses."
            .to_owned(),
        format!(
            "{passed} pass ({} of them within a stricter, golden tolerance, {} are information and \
             not judged), {failed} fail, {skipped} are skipped: {failing}. Told are the error that \
             comes nearest to its tolerance, and that tolerance, in the unit of the case.",
            of_them(Verdict::Gold),
            of_them(Verdict::Shown)
        ),
        format!(
            "Run once each by {command}, on all cores at once, so times are rough. The cases, the \
             source of every expected value and the rule of every tolerance are in tests/cases."
        ),
    ];
    let left: Vec<String> = reports
        .iter()
        .filter(|report| report.verdict == Verdict::Skip)
        .map(|report| format!("{} ({})", report.name, report.reason))
        .collect();
    if !left.is_empty() {
        text.push(format!("Left out: {}.", left.join("; ")));
    }
    text
}

fn table(reports: &[CaseReport]) -> Table {
    Table {
        name: "cases".to_owned(),
        title: "One row for each case".to_owned(),
        caption: "What R, D, T, E, S, C, W, P and I stand for: one contact, detection, time of \
                  impact, events, statistics, conservation, steps, springs, invalid input."
            .to_owned(),
        columns: vec![
            words("case"),
            words("verdict"),
            numbers("sub-cases"),
            numbers("error"),
            numbers("tolerance"),
            times("time (s)"),
            words("what"),
        ],
        rows: reports.iter().map(row).collect(),
    }
}

fn row(report: &CaseReport) -> Vec<String> {
    let worst = report.worst();
    let number = |of: fn(&check::Finding) -> f64| worst.map_or(String::new(), |w| short(of(w)));
    vec![
        report.name.clone(),
        report.verdict.word().to_owned(),
        report.findings.len().to_string(),
        number(|finding| finding.error),
        number(|finding| finding.tolerance),
        format!("{:.2}", report.seconds),
        worst.map_or(report.reason.clone(), |finding| finding.note.clone()),
    ]
}
