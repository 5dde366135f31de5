//! Virtual environments of the tests: made once, under the target directory, and made again when
//! what they are made of changes.
//!
//! Shared by the tests with rclpy and those of the wire. It never touches any Python package
//! outside the target directory.

use std::collections::hash_map::DefaultHasher;
use std::fs::{self, File};
use std::hash::{Hash, Hasher};
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Prints the version, then the path of Python.h; fails where `venv` cannot work.
const PROBE: &str = "import ensurepip, venv, sys, sysconfig; print(sys.version); \
    print(sysconfig.get_paths()['include'] + '/Python.h'); sys.exit(sys.version_info < (3, 10))";

/// The target directory: what is made there is removed by `cargo clean`.
pub fn target() -> &'static Path {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR"));
    scratch.parent().expect("cargo's scratch directory is inside the target directory")
}

/// The environment whose name begins so, of this Python and these files, made if it is not there.
pub fn find_or_make(
    prefix: &str,
    python: &str,
    files: &[PathBuf],
    make: impl FnOnce(&Path) -> Result<(), String>,
) -> Result<PathBuf, String> {
    let made_of = digest(python, files).map_err(|e| format!("cannot read {prefix}: {e}"))?;
    let environment = target().join(format!("{prefix}{made_of:016x}"));
    let complete = environment.join("complete");
    // Against another `cargo test` at the same time; dropped, and so unlocked, at the end.
    let lock = File::create(target().join(format!("{prefix}lock"))).map_err(|e| e.to_string())?;
    lock.lock().map_err(|e| format!("cannot lock the environment: {e}"))?;
    if !complete.exists() {
        eprintln!("making {}: once, a minute at most", environment.display());
        remove_all(prefix).map_err(|e| format!("cannot remove old environments: {e}"))?;
        step("python3 -m venv", Command::new("python3").args(["-m", "venv"]).arg(&environment))?;
        make(&environment)?;
        File::create(complete).map_err(|e| e.to_string())?;
    }
    Ok(environment)
}

/// Installs what a file names.
pub fn pip_install(environment: &Path, requirements: &Path) -> Result<(), String> {
    step(
        "pip install (it needs the network)",
        Command::new(environment.join("bin/python"))
            .args(["-m", "pip", "install", "--disable-pip-version-check", "--retries", "2", "-r"])
            .arg(requirements),
    )
}

/// What Python says of itself, and the path of its header.
pub fn python() -> Option<(String, PathBuf)> {
    let text = run("python3", &["-c", PROBE])?;
    let header = text.lines().last()?.into();
    Some((text, header))
}

/// What a program prints, if it is there and succeeds.
pub fn run(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// A hash of all that an environment is made of.
fn digest(python: &str, files: &[PathBuf]) -> io::Result<u64> {
    let mut hasher = DefaultHasher::new();
    python.hash(&mut hasher);
    for file in files {
        file.hash(&mut hasher);
        fs::read(file)?.hash(&mut hasher);
    }
    Ok(hasher.finish())
}

/// Those of other inputs, and one that was left unfinished.
fn remove_all(prefix: &str) -> io::Result<()> {
    for entry in fs::read_dir(target())? {
        let entry = entry?;
        let ours = entry.file_name().to_string_lossy().starts_with(prefix);
        if ours && entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        }
    }
    Ok(())
}

/// Runs one command; on failure, its last lines are the message.
pub fn step(name: &str, command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|e| format!("{name}: {e}"))?;
    if output.status.success() {
        return Ok(());
    }
    let text = [output.stdout, output.stderr].concat();
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<&str> = text.lines().collect();
    let tail = lines[lines.len().saturating_sub(20)..].join("\n");
    Err(format!("{name}: {}\n{tail}", output.status))
}
