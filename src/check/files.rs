//! The case files on disk: which there are, and their bytes. The only place here that reads files.

use std::path::{Path, PathBuf};

/// Where the cases are in the project.
const USUAL: &str = "tests/cases";

/// Why the cases cannot be read: bad use, in one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BadUse(pub String);

/// One file.
pub struct CaseFile {
    /// Its name without the ending.
    pub stem: String,
    /// What is in it.
    pub bytes: Vec<u8>,
}

/// All case files of a folder (or the one file that is named), by name.
///
/// # Errors
/// [`BadUse`] when the folder or a file cannot be read, or none fits.
pub fn read(cases: Option<&Path>, only: Option<&str>) -> Result<Vec<CaseFile>, BadUse> {
    let folder = cases.unwrap_or(Path::new(USUAL));
    if cases.is_none() && !folder.is_dir() {
        return Err(BadUse(format!("{USUAL}: not here; name the folder with --cases DIR")));
    }
    let mut paths = if folder.is_file() { vec![folder.to_owned()] } else { list(folder)? };
    paths.sort();
    let fits = |path: &PathBuf| only.is_none_or(|pattern| matches(pattern, &stem(path)));
    let chosen: Vec<PathBuf> = paths.into_iter().filter(fits).collect();
    if chosen.is_empty() {
        let which = only.map(|pattern| format!(" named `{pattern}`")).unwrap_or_default();
        return Err(BadUse(format!("{}: no case files (*.json){which}", folder.display())));
    }
    chosen.iter().map(|path| open(path)).collect()
}

fn list(folder: &Path) -> Result<Vec<PathBuf>, BadUse> {
    let unreadable = |cause| BadUse(format!("{}: {cause}", folder.display()));
    let mut paths = Vec::new();
    for entry in folder.read_dir().map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path.extension().is_some_and(|ending| ending == "json") {
            paths.push(path);
        }
    }
    Ok(paths)
}

fn open(path: &Path) -> Result<CaseFile, BadUse> {
    let bytes = std::fs::read(path).map_err(|cause| BadUse(format!("{}: {cause}", path.display())));
    Ok(CaseFile { stem: stem(path), bytes: bytes? })
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Whether a name fits a pattern in which `*` stands for any text and `?` for one character.
pub fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) =
        (pattern.chars().collect(), name.chars().collect());
    let (mut p, mut n) = (0, 0);
    // Where the last `*` was, and up to where it reaches.
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        if pattern.get(p) == Some(&'*') {
            star = Some((p, n));
            p += 1;
        } else if pattern.get(p).is_some_and(|&c| c == '?' || c == name[n]) {
            (p, n) = (p + 1, n + 1);
        } else if let Some((at, reach)) = star {
            star = Some((at, reach + 1));
            (p, n) = (at + 1, reach + 1);
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(|&c| c == '*')
}
