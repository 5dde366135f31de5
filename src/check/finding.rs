//! What a case shows: for each sub-case the worst error beside its tolerance, and the verdict.

use super::number;
use crate::exact::DoubleDouble;

/// The outcome of a case or sub-case, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Within the gold tolerance that the case states.
    Gold,
    /// Within its tolerance.
    Pass,
    /// Information: shown, not judged.
    Shown,
    /// Not run.
    Skip,
    /// Beyond its tolerance, or malformed.
    Fail,
}

impl Verdict {
    /// The word in the table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Gold => "gold",
            Self::Pass => "pass",
            Self::Shown => "info",
            Self::Skip => "skip",
            Self::Fail => "FAIL",
        }
    }
}

/// One sub-case.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Which one.
    pub label: String,
    /// How it went.
    pub verdict: Verdict,
    /// The error that came nearest to its tolerance, or went farthest beyond it.
    pub error: f64,
    /// Its tolerance.
    pub tolerance: f64,
    /// What has that error; what is wrong; what else is worth showing.
    pub note: String,
}

/// Collects the comparisons of one sub-case.
pub struct Tally {
    finding: Finding,
    ratio: f64,
    gold: Option<bool>,
    notes: Vec<String>,
}

impl Tally {
    /// Of nothing yet.
    pub fn new(label: impl Into<String>) -> Self {
        let finding = Finding {
            label: label.into(),
            verdict: Verdict::Pass,
            error: 0.0,
            tolerance: 0.0,
            note: String::new(),
        };
        Self { finding, ratio: -1.0, gold: None, notes: Vec::new() }
    }

    /// An error that must not exceed its tolerance.
    pub fn within(&mut self, what: impl Into<String>, error: f64, tolerance: f64) {
        let good = error <= tolerance;
        // A tolerance of 0 that is met counts as no error, one that is not as the worst.
        let ratio = if good && error == 0.0 { 0.0 } else { error / tolerance };
        let ratio = if ratio.is_nan() { f64::INFINITY } else { ratio };
        if !good {
            self.finding.verdict = Verdict::Fail;
        }
        if ratio > self.ratio {
            self.ratio = ratio;
            (self.finding.error, self.finding.tolerance) = (error, tolerance);
            self.finding.note = what.into();
        }
    }

    /// A number that must be near the expected one; with a tolerance of 0, the very double that the
    /// decimal stands for, which forty digits may not write out.
    pub fn near(&mut self, what: &str, actual: f64, expected: DoubleDouble, tolerance: f64) {
        let lo = if tolerance == 0.0 { 0.0 } else { expected.lo };
        let expected = DoubleDouble { lo, ..expected };
        self.within(what, number::error(actual, expected), tolerance);
    }

    /// The same for a case that states a gold tolerance too.
    pub fn gold(&mut self, what: &str, error: f64, tolerance: f64, gold: f64) {
        self.within(what, error, tolerance);
        self.gold = Some(self.gold.unwrap_or(true) && error <= gold);
    }

    /// Something that must be as said, without tolerance.
    pub fn exact<T: PartialEq + std::fmt::Debug>(&mut self, what: &str, actual: T, wanted: T) {
        if actual != wanted {
            self.fail(format!("{what}: {actual:?}, must be {wanted:?}"));
        }
    }

    /// A measured mean against an exact one: at most `limit` standard errors apart.
    pub fn z(&mut self, what: &str, measured: (f64, f64), expected: (f64, f64), limit: f64) {
        let sigma = measured.1.hypot(expected.1);
        let z = (measured.0 - expected.0) / sigma;
        self.within(format!("z of {what}"), z.abs(), limit);
        self.note(format!("{what} {:.6} +- {:.1e} z={z:+.2}", measured.0, measured.1));
    }

    /// A failure that is no number.
    pub fn fail(&mut self, what: impl Into<String>) {
        self.within(what, f64::INFINITY, 0.0);
    }

    /// Something worth showing.
    pub fn note(&mut self, what: impl Into<String>) {
        self.notes.push(what.into());
    }

    /// The sub-case as it stands.
    pub fn finish(mut self) -> Finding {
        if self.gold == Some(true) && self.finding.verdict == Verdict::Pass {
            self.finding.verdict = Verdict::Gold;
        }
        if !self.notes.is_empty() {
            let between = if self.finding.note.is_empty() { "" } else { "; " };
            self.finding.note = format!("{}{between}{}", self.finding.note, self.notes.join(", "));
        }
        self.finding
    }
}
