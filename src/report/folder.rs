//! The folder of the report: refused before anything is measured, written when all of it is there.
//!
//! A file is written under another name and gets its own when it is whole, so whoever interrupts
//! the report finds old files or new ones, never half of one. Nothing is ever deleted but our own
//! unfinished files, and files by names that are ours alone.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
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

/// Removes files of an earlier run by these names, but for those that are written anew.
///
/// # Errors
/// [`ReportError::Output`] with the file at fault.
pub fn remove_old(
    folder: &Path,
    names: &[String],
    files: &[(String, String)],
) -> Result<(), ReportError> {
    let is_new = |name: &String| files.iter().any(|(new, _)| new == name);
    for name in names.iter().filter(|name| !is_new(name)) {
        let path = folder.join(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(ReportError::Output { path: path.display().to_string(), error });
            }
            _ => {}
        }
    }
    Ok(())
}

/// A file that grows while others are still to be made.
pub(crate) struct Growing {
    whole: PathBuf,
    unfinished: PathBuf,
    out: BufWriter<File>,
}

impl Growing {
    /// Begins a file of a folder.
    ///
    /// # Errors
    /// [`ReportError::Output`] with the file at fault.
    pub(crate) fn begin(folder: &Path, name: &str) -> Result<Self, ReportError> {
        let (whole, unfinished) = (folder.join(name), unfinished(folder, name));
        match File::create(&unfinished) {
            Ok(file) => Ok(Self { whole, unfinished, out: BufWriter::new(file) }),
            Err(error) => Err(ReportError::Output { path: whole.display().to_string(), error }),
        }
    }

    /// Adds a line.
    pub(crate) fn line(&mut self, line: &str) -> io::Result<()> {
        self.out.write_all(line.as_bytes())?;
        self.out.write_all(b"\n")
    }

    /// It is whole: it gets its name.
    ///
    /// # Errors
    /// [`ReportError::Output`] with the file at fault.
    pub(crate) fn finish(mut self) -> Result<(), ReportError> {
        let done = self.out.flush().and_then(|()| fs::rename(&self.unfinished, &self.whole));
        let path = self.whole.display().to_string();
        done.map_err(|error| ReportError::Output { path, error })
    }
}

fn unfinished(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!(".{name}.unfinished"))
}
