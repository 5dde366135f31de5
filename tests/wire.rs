//! The node against teams' own means: protobuf's Python classes, generated from definitions of the
//! tests' own, on loopback.
//!
//! Each script of tests/wire runs the built binary on ports that are free and in a ROS domain of
//! its own, and fails by its exit code.

#[path = "environment/script.rs"]
mod script;
#[path = "environment/venv.rs"]
mod venv;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Apart from the domains of the rclpy scripts.
const FIRST_DOMAIN: u32 = 30;

#[test]
fn small_size() {
    run("small_size", 0);
}

#[test]
fn very_small_size() {
    run("very_small_size", 1);
}

fn run(script: &str, index: u32) {
    let environment = environment();
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("wire-{script}"));
    // Of an earlier run; there may have been none.
    let _ = fs::remove_dir_all(&scratch);
    fs::create_dir_all(&scratch).expect("cargo's scratch directory is writable");
    script::run(
        &format!("wire-{script}"),
        FIRST_DOMAIN + index,
        &environment.join("bin/python"),
        &scripts().join(format!("{script}.py")),
        &[("PYTHONPATH", &environment.join("generated")), ("WIRE_SCRATCH", &scratch)],
    );
}

fn scripts() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/wire")
}

/// A Python with protobuf and the classes of the definitions; made once.
fn environment() -> &'static Path {
    static ENVIRONMENT: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let find_or_make = || {
        let missing = "the tests of the wire need the Debian package python3-venv (Python 3.10)";
        let (python, _) = venv::python().ok_or(missing)?;
        let definitions = ["ssl.proto", "fira.proto"].map(|name| scripts().join(name));
        let requirements = scripts().join("requirements.txt");
        let mut files = definitions.to_vec();
        files.push(requirements.clone());
        venv::find_or_make("wire-", &python, &files, |environment| {
            venv::pip_install(environment, &requirements)?;
            let generated = environment.join("generated");
            fs::create_dir_all(&generated).map_err(|error| error.to_string())?;
            venv::step(
                "protoc",
                Command::new(environment.join("bin/python"))
                    .args(["-m", "grpc_tools.protoc", "-I"])
                    .arg(scripts())
                    .arg(format!("--python_out={}", generated.display()))
                    .args(&definitions),
            )
        })
    };
    match ENVIRONMENT.get_or_init(find_or_make) {
        Ok(path) => path,
        Err(message) => panic!("{message}"),
    }
}
