//! The report: what is drawn is well-formed, self-contained and readable whatever the numbers are.

#[path = "report/sample.rs"]
mod sample;

use std::path::PathBuf;

use carom::report::draw;

#[test]
fn sample_page() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("sample-report");
    std::fs::create_dir_all(&folder).expect("a folder");
    for (name, text) in draw::files(sample::page()) {
        std::fs::write(folder.join(name), text).expect("a file");
    }
}
