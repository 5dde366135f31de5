//! `carom audit BAG`: reads, judges, tells.
//!
//! The bag is only read. Files are written where a folder was named, and nowhere else.

use std::cell::RefCell;
use std::io::{self, Write};
use std::path::PathBuf;

use super::recorded::{self, Robot};
use super::{Audit, Options, observed, page, tell};
use crate::bag::read::{self, Bag};
use crate::report::ReportError;
use crate::report::draw;
use crate::report::folder::{self, Growing};
use crate::report::progress::Bar;

/// The file of all collisions.
const COLLISIONS: &str = "collisions.csv";

/// What is wanted.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The recording.
    pub bag: PathBuf,
    /// The topic of circle states; `None` = the only one.
    pub topic: Option<String>,
    /// Robots whose odometry is read instead.
    pub robots: Vec<Robot>,
    /// What the audit is told.
    pub options: Options,
    /// Where page and data go, if anywhere.
    pub folder: Option<PathBuf>,
    /// One JSON object instead of words.
    pub json: bool,
}

/// Why there is no verdict.
#[derive(Debug, thiserror::Error)]
pub enum AuditError {
    /// Asked for what there is not, or a bag that cannot be read.
    #[error("{0}")]
    BadUse(String),
    /// The output.
    #[error("cannot write: {0}")]
    Output(#[from] io::Error),
    /// The folder.
    #[error(transparent)]
    Folder(ReportError),
}

/// Audits a bag, and says how many violations there are.
///
/// # Errors
/// [`AuditError`].
pub fn audit(wanted: &Wanted, out: &mut impl Write) -> Result<u64, AuditError> {
    let bag = Bag::open(&wanted.bag).map_err(|error| AuditError::BadUse(error.to_string()))?;
    let chosen = recorded::choose(&bag, wanted.topic.as_deref(), &wanted.robots)
        .map_err(AuditError::BadUse)?;
    let mut options = wanted.options.clone();
    let noted = recorded::noted_law(&bag, &chosen, &mut options);
    let (meetings, unknown) = observed::meetings(&bag, &chosen);
    options.surroundings.meetings = meetings;
    if let Some(folder) = &wanted.folder {
        if read::holds_a_bag(folder) {
            let name = folder.display();
            let why = format!("--out {name}: a bag is in it; name a folder without one");
            return Err(AuditError::BadUse(why));
        }
        folder::prepare(folder).map_err(AuditError::Folder)?;
    }
    let lines = RefCell::new(Lines::begin(wanted)?);
    let listener = Box::new(|collision: &super::findings::Collision| {
        lines.borrow_mut().add(|| page::row(collision));
    });
    let mut audit = Audit::new(options, listener);
    let mut bar = Bar::of_one("audit");
    let said = recorded::read(&bag, &chosen, |frame| audit.hear(frame), |part| bar.tell(part));
    bar.end();
    let mut findings = audit.finish();
    findings.said = noted.into_iter().chain(unknown).chain(said).collect();
    if findings.counts.samples == 0 {
        let unsound = findings.counts.unsound;
        let why = if unsound > 0 {
            format!("{unsound} states are no discs: numbers out of range, or ids that are taken")
        } else if findings.said.is_empty() {
            "its topic has none".to_owned()
        } else {
            findings.said.join("; ")
        };
        let name = wanted.bag.display();
        return Err(AuditError::BadUse(format!("{name}: no states could be read: {why}")));
    }
    lines.into_inner().finish()?;
    let name = wanted.bag.display().to_string();
    if let Some(folder) = &wanted.folder {
        let files = draw::files(page::page(&findings, &name));
        // No table of an earlier audit may stand beside this page.
        folder::remove_old(folder, &page::names(), &files).map_err(AuditError::Folder)?;
        folder::write(folder, &files).map_err(AuditError::Folder)?;
    }
    if wanted.json {
        tell::json(&findings, &name, out)?;
    } else {
        tell::words(&findings, &name, out)?;
        if let Some(folder) = &wanted.folder {
            writeln!(out, "\n{}", folder.join(draw::INDEX).display())?;
        }
    }
    Ok(findings.violations_in_all())
}

/// The file of all collisions, if there is a folder.
struct Lines {
    file: Option<Growing>,
    failed: Option<io::Error>,
}

impl Lines {
    fn begin(wanted: &Wanted) -> Result<Self, AuditError> {
        let begun = wanted.folder.as_ref().map(|folder| Growing::begin(folder, COLLISIONS));
        let file = begun.transpose().map_err(AuditError::Folder)?;
        let mut lines = Self { file, failed: None };
        lines.add(|| page::COLLISIONS.to_owned());
        Ok(lines)
    }

    fn add(&mut self, line: impl FnOnce() -> String) {
        if let (Some(file), None) = (&mut self.file, &self.failed) {
            self.failed = file.line(&line()).err();
        }
    }

    fn finish(self) -> Result<(), AuditError> {
        match (self.failed, self.file) {
            (Some(error), _) => Err(AuditError::Output(error)),
            (None, Some(file)) => file.finish().map_err(AuditError::Folder),
            (None, None) => Ok(()),
        }
    }
}
