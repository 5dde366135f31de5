//! The comparison as a person reads it.

use std::io::{self, Write};

use super::stretch::Times;
use super::{Comparison, Isolated, Row};

/// Writes both tables.
pub(super) fn tell(comparison: &Comparison, out: &mut impl Write) -> io::Result<()> {
    let Comparison { discs, area_fraction, seconds, seed, repeats, .. } = comparison;
    writeln!(
        out,
        "{discs} elastic discs, area fraction {area_fraction}, walls, seed {seed}: {seconds} s; \
         times are medians of {repeats} runs (least)\n"
    )?;
    writeln!(
        out,
        "{:<22} {:>8} {:>17} {:>19} {:>9} {:>9} {:>8} {:>8}",
        "", "step", "ns/disc-step", "ms/simulated s", "energy", "contacts", "", "overlap"
    )?;
    for row in &comparison.gas {
        gas(row, out)?;
    }
    writeln!(
        out,
        "\nenergy: relative error at the end. contacts: of pairs and walls, each once, by disc \
         and second,\nagainst the exact ones; of Box2D and Rapier each step with an impulse. \
         overlap: the largest, in radii.\n\n\
         One collision at 2 m/s: rms error of the velocity after it, m/s"
    )?;
    comparison.isolated.iter().try_for_each(|row| isolated(row, out))
}

fn gas(row: &Row, out: &mut impl Write) -> io::Result<()> {
    write!(out, "{:<22} {:>8}", row.mover, length(row.step_s))?;
    match &row.wrong {
        Some(wrong) => write!(out, " {:>37}", format!("no time: {wrong}"))?,
        None => write!(out, " {:>17} {:>19}", times(row.ns_per_disc_step), times(row.ms_per_s))?,
    }
    let against = match row.step_s {
        Some(_) => format!("{:+.1} %", 100.0 * row.contacts_error),
        None => String::new(),
    };
    writeln!(
        out,
        " {:>+9.1e} {:>9.3} {against:>8} {:>8.1e}",
        row.energy_error, row.contacts_per_disc_s, row.largest_overlap
    )
}

fn isolated(row: &Isolated, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{:<22} {:>8} {:>17.1e}", row.mover, length(row.step_s), row.rms_error_mps)
}

fn times(times: Option<Times>) -> String {
    let Some(Times { median, least }) = times else { return "-".to_owned() };
    let digits = if median < 10.0 { 3 } else { 1 };
    format!("{median:.digits$} ({least:.digits$})")
}

/// A length of the step as people say it.
fn length(step_s: Option<f64>) -> String {
    let Some(step) = step_s else { return "exact".to_owned() };
    let rate = 1.0 / step;
    if (rate - rate.round()).abs() < 1e-9 * rate {
        format!("1/{rate:.0} s")
    } else {
        format!("{step} s")
    }
}
