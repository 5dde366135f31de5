//! The command: what it refuses, what it leaves in the folder, what it says.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use carom::report::page::Section;
use carom::report::{Effort, Entry, Options, Progress, ReportError, figures, report_on};

use crate::sample;

fn fresh(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.parent().expect("a parent")).expect("a folder");
    folder
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = folder.read_dir().expect("a folder");
    entries.map(|entry| entry.expect("entry").file_name().into_string().expect("text")).collect()
}

fn good(_: Effort, progress: Progress) -> Result<Section, ReportError> {
    for part in [0.0, 0.5, f64::NAN, 2.0, -1.0] {
        progress(part);
    }
    let items = sample::page().sections.into_iter().flat_map(|section| section.items).collect();
    Ok(Section { name: "good", title: "Good".to_owned(), text: Vec::new(), items })
}

fn wrong(_: Effort, _: Progress) -> Result<Section, ReportError> {
    Err(ReportError::Wrong("the energy was not kept".to_owned()))
}

const FIGURES: &[Entry] = &[("good", 20.0, good), ("wrong", 1.0, wrong)];

fn run(folder: &Path, only: &[&str]) -> Result<String, ReportError> {
    let only = only.iter().map(|name| (*name).to_owned()).collect();
    let options = Options { folder: folder.to_owned(), effort: Effort::Quick, only };
    let mut out = Vec::new();
    report_on(FIGURES, &options, &mut out)?;
    Ok(String::from_utf8(out).expect("text"))
}

#[test]
fn a_report_leaves_whole_files_and_says_where() {
    let folder = fresh("good").join("made/on/the/way");
    let said = run(&folder, &["good"]).expect("a report");
    assert!(said.starts_with(&format!("{}/index.html (", folder.display())), "{said}");
    let drawn = ["cost", "gas_energy", "growth", "stable"];
    let drawn = drawn.iter().flat_map(|name| [format!("{name}.csv"), format!("{name}.svg")]);
    let others = ["cases.csv", "index.html"].map(str::to_owned);
    assert_eq!(names(&folder), drawn.chain(others).collect());
    let page = std::fs::read_to_string(folder.join("index.html")).expect("the page");
    for word in ["processor", "vector units", "compiled for", "load average", "carom report"] {
        assert!(page.contains(word), "{word}");
    }
}

#[test]
fn nothing_is_drawn_from_a_wrong_run() {
    let folder = fresh("wrong");
    let error = run(&folder, &[]).expect_err("a wrong run");
    assert_eq!(error.to_string(), "no report: the energy was not kept");
    assert!(names(&folder).is_empty());
}

#[test]
fn bad_use_is_refused_before_anything_is_measured() {
    let error = run(&fresh("unknown"), &["wrong", "nothing"]).expect_err("no such figure");
    assert_eq!(error.to_string(), "--only nothing: no such figure, but good, wrong");
    let file = fresh("file");
    std::fs::write(&file, "mine").expect("a file");
    for folder in [file.clone(), file.join("below")] {
        let error = run(&folder, &["wrong"]).expect_err("no folder");
        assert!(matches!(error, ReportError::BadUse(_)), "{error}");
        assert_eq!(error.to_string().lines().count(), 1);
    }
    assert_eq!(std::fs::read_to_string(&file).expect("the file"), "mine");
}

#[test]
fn figures_have_names_of_their_own() {
    let names: BTreeSet<&str> = figures::ALL.iter().map(|(name, ..)| *name).collect();
    assert_eq!(names.len(), figures::ALL.len());
    let allowed = |c: char| c.is_ascii_lowercase() || c == '_';
    assert!(names.iter().all(|name| !name.is_empty() && name.chars().all(allowed)));
    assert!(figures::ALL.iter().all(|(_, share, _)| *share > 0.0));
}

fn carom(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.arg("report").args(arguments).output().expect("carom starts")
}

#[test]
fn the_command_says_in_one_line_what_is_wrong() {
    let file = fresh("command-file");
    std::fs::write(&file, "").expect("a file");
    let file = file.to_str().expect("text");
    let unused = fresh("unused");
    let unused = unused.to_str().expect("text");
    for arguments in [&["--out", file][..], &["--only", "x", "--out", unused], &["--fast"]] {
        let output = carom(arguments);
        let said = String::from_utf8(output.stderr).expect("text");
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(output.stdout.is_empty());
    }
    assert!(!Path::new(unused).exists());
}

/// The quickest figure, by the command itself; while there is none, a page without any.
#[test]
fn the_command_makes_the_page() {
    let folder = fresh("command");
    let quickest = figures::ALL.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(name, ..)| *name);
    let mut arguments = vec!["--quick", "--out", folder.to_str().expect("text")];
    arguments.extend(quickest.iter().flat_map(|name| ["--only", name]));
    let output = carom(&arguments);
    let said = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(0), "{said}");
    let page = folder.join("index.html");
    let told = String::from_utf8(output.stdout).expect("text");
    assert!(told.starts_with(page.to_str().expect("text")), "{told}");
    let page = std::fs::read_to_string(page).expect("the page");
    if let Some(name) = quickest {
        assert_eq!(said, format!("carom report: {name} (1 of 1)\n"));
        assert!(page.contains(&format!("<section id=\"{name}\">")));
        let data = names(&folder).into_iter().filter(|file| file.ends_with(".csv"));
        assert!(data.count() > 0);
    }
}
