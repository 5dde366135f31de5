//! The machine: what run times depend on, as a person reads it.
//!
//! Processor and load are asked of Linux; elsewhere they are not told. No name of the machine and
//! no date: they say nothing about a run time, and the page may be shown to anybody.

use std::thread::available_parallelism;

use super::{Effort, Options};

/// Name and value of everything that run times depend on; how the load was, as it is now.
pub fn describe(options: &Options) -> Vec<(String, String)> {
    let processors = available_parallelism().map_or("unknown".to_owned(), |n| n.to_string());
    let pairs = [
        ("processor", model().unwrap_or_else(|| "not told by the system".to_owned())),
        ("processors that carom may use", processors),
        ("threads used", "1; for the table of cases 2".to_owned()),
        ("vector units found", vector_units()),
        ("compiled for", compiled_for()),
        ("debug assertions", debug_assertions().to_owned()),
        ("carom", format!("{}, features {}", env!("CARGO_PKG_VERSION"), features())),
        ("command", command(options)),
        ("load average at start", load().unwrap_or_else(|| "not told by the system".to_owned())),
    ];
    pairs.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// Without the folder: where the files went says nothing.
fn command(options: &Options) -> String {
    let quick = if options.effort == Effort::Quick { " --quick" } else { "" };
    let only = options.only.join(",");
    let only = if only.is_empty() { only } else { format!(" --only {only}") };
    format!("carom report{quick}{only}")
}

fn model() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Over 1, 5 and 15 minutes.
fn load() -> Option<String> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    let means: Vec<&str> = text.split_whitespace().take(3).collect();
    Some(format!("{} over 1, 5 and 15 minutes", means.join(", ")))
}

#[cfg(target_arch = "x86_64")]
fn vector_units() -> String {
    let units = [
        ("SSE2", true),
        ("AVX2", std::is_x86_feature_detected!("avx2")),
        ("FMA", std::is_x86_feature_detected!("fma")),
        ("AVX-512F", std::is_x86_feature_detected!("avx512f")),
    ];
    listed(&units)
}

#[cfg(not(target_arch = "x86_64"))]
fn vector_units() -> String {
    "none that carom asks for".to_owned()
}

/// What the compiler took for granted.
fn compiled_for() -> String {
    let features = [
        ("avx", cfg!(target_feature = "avx")),
        ("avx2", cfg!(target_feature = "avx2")),
        ("fma", cfg!(target_feature = "fma")),
        ("avx512f", cfg!(target_feature = "avx512f")),
    ];
    let (architecture, system) = (std::env::consts::ARCH, std::env::consts::OS);
    format!("{architecture} {system}; of avx, avx2, fma, avx512f: {}", listed(&features))
}

fn debug_assertions() -> &'static str {
    if cfg!(debug_assertions) {
        "ON: these run times say nothing, build with --release"
    } else {
        "off"
    }
}

fn features() -> String {
    listed(&[
        ("ros", cfg!(feature = "ros")),
        ("report", cfg!(feature = "report")),
        ("peers", cfg!(feature = "peers")),
    ])
}

fn listed(all: &[(&str, bool)]) -> String {
    let there: Vec<&str> = all.iter().filter(|(_, there)| *there).map(|(name, _)| *name).collect();
    if there.is_empty() { "none".to_owned() } else { there.join(", ") }
}
