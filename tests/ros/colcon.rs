//! `colcon build` of this repository, as in anybody's workspace, and what it installs.
//!
//! colcon and ROS come from wheels, the node from cargo: the same steps as on a machine with ROS.

use std::fs;
use std::io;
use std::path::Path;
use std::process::Command;
use std::sync::PoisonError;

use crate::MACHINE;
use crate::environment::venv::target;
use crate::environment::{Distribution, cmake_arguments, colcon, environment, scripts, step};

/// Apart from the domains of the other scripts.
const DOMAIN: &str = "100";

#[test]
fn a_workspace_gets_the_node_its_messages_and_the_launch_file() {
    let environment = environment(Distribution::Kilted);
    let _alone = MACHINE.write().unwrap_or_else(PoisonError::into_inner);
    // Gone with the environment: CMake keeps where it found ROS.
    let workspace = environment.join("workspace");
    let (install, package) = (workspace.join("install"), workspace.join("src/carom"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    copy(root, &package).expect("the target directory is writable");
    let mut build = colcon(environment, &[&package], &workspace);
    build.arg("--install-base").arg(&install).args(cmake_arguments(environment));
    // The time of a release build.
    step("colcon build", &mut build).unwrap_or_else(|message| panic!("{message}"));
    let mut script = Command::new("bash");
    script
        .args(["-c", ". \"$0\" && exec \"$1\" \"$2\""])
        .arg(install.join("setup.bash"))
        .arg(environment.join("bin/python"))
        .arg(scripts().join("installed.py"))
        .env("AMENT_PREFIX_PATH", environment)
        .env("CAROM_BIN", install.join("carom/lib/carom/carom"))
        .env("CAROM_ROOT", root)
        .env("ROS_DOMAIN_ID", DOMAIN)
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env_remove("PYTHONPATH");
    step("installed.py", &mut script).unwrap_or_else(|message| panic!("{message}"));
}

/// As a clone has them: without what is built, and so outside of what CMake calls the source.
fn copy(root: &Path, to: &Path) -> io::Result<()> {
    if to.exists() {
        fs::remove_dir_all(to)?;
    }
    fs::create_dir_all(to)?;
    let mut files = Vec::new();
    for entry in fs::read_dir(root)? {
        let entry = entry?;
        let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
        if !is_hidden && entry.path() != target() {
            files.push(entry.path());
        }
    }
    let copied = Command::new("cp").arg("-r").args(files).arg(to).status()?;
    if copied.success() { Ok(()) } else { Err(io::Error::other("cp")) }
}
