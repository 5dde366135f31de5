//! The files of a bag: found and opened for reading only, or made; none is ever overwritten.
//!
//! What a file is, its first bytes say, not its name. A bag without `metadata.yaml` is the files of
//! its folder, in the order of the numbers at the ends of their names.

use std::fs::{self, File};
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use super::fault::Fault;

/// A file that is written. It has no buffer: whoever writes has one.
pub type Output = File;

/// A file that is read, with a buffer.
pub type Input = BufReader<File>;

/// Bytes of that buffer.
const BUFFER_BYTES: usize = 1 << 16;

/// The storages that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// MCAP.
    Mcap,
    /// A database of SQLite 3.
    Sqlite,
}

const MCAP_MAGIC: &[u8] = mcap::MAGIC;
const SQLITE_MAGIC: &[u8] = b"SQLite format 3\0";
const ZSTD_MAGIC: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];

/// Largest metadata.yaml that is read, bytes.
const METADATA_BYTES_MAX: u64 = 16 << 20;

/// A file and its length in bytes.
///
/// # Errors
/// [`Fault::Unreadable`].
pub fn open(path: &Path) -> Result<(Input, u64), Fault> {
    let file = File::open(path).map_err(Fault::Unreadable)?;
    let length = file.metadata().map_err(Fault::Unreadable)?.len();
    Ok((BufReader::with_capacity(BUFFER_BYTES, file), length))
}

/// What a file is stored in.
///
/// # Errors
/// [`Fault::NotABag`] with what it is instead, [`Fault::Unreadable`].
pub fn storage(path: &Path) -> Result<Storage, Fault> {
    let metadata = fs::metadata(path).map_err(Fault::Unreadable)?;
    if !metadata.is_file() {
        return Err(Fault::NotABag("is neither a file nor a folder".to_owned()));
    }
    let (file, _) = open(path)?;
    let mut head = Vec::new();
    file.take(16).read_to_end(&mut head).map_err(Fault::Unreadable)?;
    if head.starts_with(MCAP_MAGIC) {
        return Ok(Storage::Mcap);
    }
    if head.starts_with(SQLITE_MAGIC) {
        return Ok(Storage::Sqlite);
    }
    let what = if head.is_empty() {
        "is empty"
    } else if head.starts_with(ZSTD_MAGIC) {
        "is packed as a whole: unpack it first with `zstd -d`"
    } else if MCAP_MAGIC.starts_with(&head) || SQLITE_MAGIC.starts_with(&head) {
        "ends within its first bytes"
    } else {
        "is no recording: an MCAP file, an sqlite3 database, or a folder of them is wanted"
    };
    Err(Fault::NotABag(what.to_owned()))
}

/// Whether it is a folder.
pub fn is_folder(path: &Path) -> bool {
    path.is_dir()
}

/// Whether a folder is a bag, or has its files.
pub fn holds_a_bag(folder: &Path) -> bool {
    folder.join("metadata.yaml").exists()
        || recordings(folder).is_ok_and(|recordings| !recordings.is_empty())
}

/// The recordings in a folder, in their order.
///
/// # Errors
/// [`Fault::Unreadable`].
pub fn recordings(folder: &Path) -> Result<Vec<PathBuf>, Fault> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(Fault::Unreadable)? {
        let path = entry.map_err(Fault::Unreadable)?.path();
        let ending = path.extension().and_then(|ending| ending.to_str());
        if matches!(ending, Some("mcap" | "db3")) && path.is_file() {
            found.push(path);
        }
    }
    found.sort_by_cached_key(|path| (number(path), path.clone()));
    Ok(found)
}

/// The number at the end of a name, without its ending.
fn number(path: &Path) -> u64 {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let digits = stem.len() - stem.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    stem[stem.len() - digits..].parse().unwrap_or(0)
}

/// The text of a file beside the recordings, if there is one.
///
/// # Errors
/// [`Fault::Unreadable`], [`Fault::NotABag`] if it is too long or no text.
pub fn text(path: &Path) -> Result<Option<String>, Fault> {
    if !path.exists() {
        return Ok(None);
    }
    let (file, _) = open(path)?;
    let mut bytes = Vec::new();
    file.take(METADATA_BYTES_MAX + 1).read_to_end(&mut bytes).map_err(Fault::Unreadable)?;
    if bytes.len() as u64 > METADATA_BYTES_MAX {
        return Err(Fault::NotABag(format!("is larger than {METADATA_BYTES_MAX} bytes")));
    }
    let text = String::from_utf8(bytes);
    text.map(Some).map_err(|_| Fault::NotABag("is no text".to_owned()))
}

/// Whether the file beside another one, which has its name and this ending, holds anything.
pub fn holds_anything(path: &Path, ending: &str) -> bool {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    fs::metadata(name).is_ok_and(|metadata| metadata.len() > 0)
}

/// The absolute path: the library of SQLite is told no other.
///
/// # Errors
/// As the operating system has it.
pub fn absolute(path: &Path) -> io::Result<PathBuf> {
    fs::canonicalize(path)
}

/// Makes a folder, and those around it.
///
/// # Errors
/// As the operating system has it; that it is there already.
pub fn create_folder(folder: &Path) -> io::Result<()> {
    match folder.parent() {
        // What is there already is not the folder, then.
        Some(parent) if !parent.as_os_str().is_empty() => fs::create_dir_all(parent)
            .map_err(|error| io::Error::other(format!("{}: {error}", parent.display())))?,
        _ => {}
    }
    fs::create_dir(folder)
}

/// Makes a file.
///
/// # Errors
/// As the operating system has it; that it is there already.
pub fn create(path: &Path) -> io::Result<Output> {
    File::create_new(path)
}

/// Writes a text into a new file, which has its name when it is whole.
///
/// # Errors
/// As the operating system has it.
pub fn write(path: &Path, text: &str) -> io::Result<()> {
    let mut unfinished = path.as_os_str().to_owned();
    unfinished.push(".unfinished");
    let mut file = File::create_new(&unfinished)?;
    file.write_all(text.as_bytes())?;
    fs::rename(unfinished, path)
}
