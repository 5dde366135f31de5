//! The folder of the report: refused before anything is measured, written when all of it is there.
//!
//! A file is written under another name and gets its own when it is whole, so whoever interrupts
//! the report finds old files or new ones, never half of one. Nothing is ever deleted but our own
//! unfinished files.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::ReportError;

/// Makes the folder, and sure that it can be written to.
///
/// # Errors
/// [`ReportError::BadUse`], with what would be right.
pub fn prepare(folder: &Path) -> Result<(), ReportError> {
    let name = folder.display();
    let refused = |why: &dyn std::fmt::Display| {
        ReportError::BadUse(format!("--out {name}: {why}; it must be a folder to write into"))
    };
    if folder.exists() && !folder.is_dir() {
        return Err(refused(&"that is a file"));
    }
    fs::create_dir_all(folder).map_err(|error| refused(&error))?;
    let probe = unfinished(folder, "probe");
    fs::write(&probe, "").and_then(|()| fs::remove_file(&probe)).map_err(|error| refused(&error))
}

/// Writes all files: first whole under other names, then each under its own.
///
/// # Errors
/// [`ReportError::Output`] with the file at fault.
pub fn write(folder: &Path, files: &[(String, String)]) -> Result<(), ReportError> {
    let at_fault = |name: &str| {
        let path = folder.join(name).display().to_string();
        move |error: io::Error| ReportError::Output { path, error }
    };
    for (name, text) in files {
        fs::write(unfinished(folder, name), text).map_err(at_fault(name))?;
    }
    for (name, _) in files {
        fs::rename(unfinished(folder, name), folder.join(name)).map_err(at_fault(name))?;
    }
    Ok(())
}

fn unfinished(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!(".{name}.unfinished"))
}
