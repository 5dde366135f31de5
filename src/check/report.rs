//! How the results look: a row a case for people, one JSON document for programs.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::case::Field;
use super::{CaseReport, Finding, Summary, Verdict};

/// Whether a case says of itself that it is information.
pub fn is_information(root: &Field) -> bool {
    let kind = root.find("tolerance").and_then(|tolerance| tolerance.find("kind"));
    kind.is_some_and(|kind| kind.words().is_ok_and(|kind| kind == "information"))
}

/// The row of a case: verdict, name, error beside tolerance, time, what is worth saying.
pub fn row(report: &CaseReport, out: &mut impl Write) -> io::Result<()> {
    let worst = report.worst();
    let margin = match worst {
        Some(finding) if finding.tolerance == 0.0 && finding.error == 0.0 => "exact".to_owned(),
        Some(finding) => format!("{:.2e} <= {:.2e}", finding.error, finding.tolerance),
        None => String::new(),
    };
    let margin = if report.verdict == Verdict::Fail { margin.replace("<=", "> ") } else { margin };
    let note = worst.map_or(report.reason.clone(), |finding| said(finding, &report.findings));
    writeln!(
        out,
        "{}  {:<28} {:>4}  {margin:<22} {:>7.2} s  {note}",
        report.verdict.word(),
        report.name,
        report.findings.len(),
        report.seconds,
    )?;
    out.flush()
}

fn said(finding: &Finding, findings: &[Finding]) -> String {
    let failed = findings.iter().filter(|finding| finding.verdict == Verdict::Fail).count();
    let also = if failed > 1 { format!(" ({failed} sub-cases fail)") } else { String::new() };
    let label = if findings.len() > 1 { format!("[{}] ", finding.label) } else { String::new() };
    format!("{label}{}{also}", finding.note)
}

/// The last line.
pub fn ending(summary: &Summary, out: &mut impl Write) -> io::Result<()> {
    let Summary { passed, failed, skipped } = summary;
    writeln!(out, "{passed} passed, {failed} failed, {skipped} skipped")
}

/// Everything.
pub fn json(reports: &[CaseReport], summary: &Summary, out: &mut impl Write) -> io::Result<()> {
    let findings = || reports.iter().flat_map(|report| &report.findings);
    let subcases = |verdict| findings().filter(|finding| finding.verdict == verdict).count();
    let failed = subcases(Verdict::Fail);
    let document = json!({
        "passed": summary.passed,
        "failed": summary.failed,
        "skipped": summary.skipped,
        "subcases": {
            "passed": findings().count() - failed,
            "gold": subcases(Verdict::Gold),
            "failed": failed,
        },
        "cases": reports.iter().map(case).collect::<Vec<Value>>(),
    });
    serde_json::to_writer_pretty(&mut *out, &document)?;
    writeln!(out)
}

fn case(report: &CaseReport) -> Value {
    json!({
        "name": report.name,
        "kind": report.kind,
        "verdict": report.verdict.word().to_lowercase(),
        "reason": report.reason,
        "seconds": report.seconds,
        "subcases": report.findings.iter().map(subcase).collect::<Vec<Value>>(),
    })
}

/// An infinite error is null: JSON has no word for it.
fn subcase(finding: &Finding) -> Value {
    json!({
        "label": finding.label,
        "verdict": finding.verdict.word().to_lowercase(),
        "error": finding.error,
        "tolerance": finding.tolerance,
        "note": finding.note,
    })
}
