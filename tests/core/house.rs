//! The rules of the house, kept by reading the source.

use std::path::{Path, PathBuf};

const LINE_MAX: usize = 100;
const FILE_MAX: usize = 800;
const FUNCTION_MAX: usize = 70;
const FUNCTION_USUAL: usize = 30;

fn files(folder: &str, ending: &str) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in folder.read_dir().expect("a folder") {
            let path = entry.expect("entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == ending) {
                let text = std::fs::read_to_string(&path).expect("text");
                found.push((path, text));
            }
        }
    }
    assert!(!found.is_empty());
    found
}

/// Lengths of all functions of a formatted file, with their first lines.
fn functions(text: &str) -> Vec<(usize, String)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut lengths = Vec::new();
    for (k, line) in lines.iter().enumerate() {
        let code = line.trim_start();
        let indent = &line[..line.len() - code.len()];
        let words = ["pub ", "pub(crate) ", "pub(super) ", "async ", "const "];
        let rest = words.iter().fold(code, |code, word| code.strip_prefix(word).unwrap_or(code));
        if !rest.starts_with("fn ") || line.ends_with(';') || line.ends_with('}') {
            continue;
        }
        let end = lines[k..].iter().position(|l| *l == format!("{indent}}}"));
        lengths.push((end.map_or(1, |end| end + 1), (*line).to_owned()));
    }
    lengths
}

#[test]
fn files_and_lines_are_short_and_begin_with_why() {
    for (path, text) in files("src", "rs").into_iter().chain(files("tests", "rs")) {
        let name = path.display();
        assert!(text.starts_with("//!"), "{name}: say first what the file is");
        assert!(text.lines().count() <= FILE_MAX, "{name}: too long");
        for (k, line) in text.lines().enumerate() {
            let width = line.chars().count();
            assert!(width <= LINE_MAX, "{name}:{}: {width} columns", k + 1);
        }
    }
}

#[test]
fn functions_are_short() {
    let all: Vec<(usize, String)> =
        files("src", "rs").iter().flat_map(|(_, text)| functions(text)).collect();
    assert!(all.len() > 100, "functions were found: {}", all.len());
    let long: Vec<_> = all.iter().filter(|(length, _)| *length > FUNCTION_MAX).collect();
    assert!(long.is_empty(), "{long:?}");
    let unusual = all.iter().filter(|(length, _)| *length > FUNCTION_USUAL).count();
    assert!(unusual * 10 <= all.len(), "{unusual} of {} functions are long", all.len());
}

#[test]
fn borders_hold() {
    let ros = ["ros2_client", "rustdds", "tokio"];
    let clocks = ["Instant::now", "SystemTime"];
    let random = ["rand_pcg"];
    let disk = ["std::fs", "File::"];
    for (path, text) in files("src", "rs") {
        let name = path.to_string_lossy().replace('\\', "/");
        let may = |rooms: &[&str]| rooms.iter().any(|room| name.contains(room));
        let has = |words: &[&str]| words.iter().any(|word| text.contains(word));
        assert!(!has(&ros) || may(&["src/node/"]), "{name} names ROS");
        assert!(
            !has(&clocks) || may(&["src/node/", "src/check/mod.rs", "src/bench/mod.rs"]),
            "{name} reads a clock"
        );
        assert!(
            !has(&["unsafe {"])
                || may(&[
                    "src/detect/fused.rs",
                    "src/resolve/listed.rs",
                    "src/motion/events/lanes",
                    "src/motion/events/pages.rs",
                    "src/motion/near/lanes.rs",
                    "src/node/stopped.rs",
                ]),
            "{name} is unsafe"
        );
        // The second: noise of cameras, from a seed too; it never reaches the motion.
        assert!(
            !has(&random) || may(&["src/scene/batch.rs", "src/wire/realism.rs"]),
            "{name} draws random numbers"
        );
        assert!(
            !has(&disk)
                || may(&[
                    "src/scene/mod.rs",
                    "src/bag/files.rs",
                    "src/check/files.rs",
                    "src/bench/mod.rs",
                    "src/node/arguments.rs",
                    "src/report/folder.rs",
                    "src/report/machine.rs",
                ]),
            "{name} touches the file system"
        );
    }
}

#[test]
fn unwraps_have_their_reason_beside_them() {
    for (path, text) in files("src", "rs") {
        let lines: Vec<&str> = text.lines().collect();
        for (k, line) in lines.iter().enumerate() {
            if line.contains(".unwrap()") || line.contains(".expect(") {
                let above = k.checked_sub(1).is_some_and(|k| lines[k].trim().starts_with("//"));
                assert!(above, "{}:{}: say why it cannot fail", path.display(), k + 1);
            }
        }
    }
}
