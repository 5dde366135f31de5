//! Several that are timed in turns, so that a noisy machine is noisy for all.
//!
//! Never an answer: what was computed is judged elsewhere, untimed.

use super::timing::Timing;

/// Something that tells how long it took, s.
pub type Timed<'a> = Box<dyn FnMut() -> Result<f64, String> + 'a>;

/// Times each so many times; `told` is how much is done. Who needs a warm-up has had it.
///
/// # Errors
/// The first that fails.
pub fn in_turns(
    runs: usize,
    all: &mut [Timed<'_>],
    mut told: impl FnMut(f64),
) -> Result<Vec<Timing>, String> {
    let mut times = vec![Vec::with_capacity(runs); all.len()];
    for turn in 0..runs {
        for (timed, times) in all.iter_mut().zip(&mut times) {
            times.push(timed()?);
        }
        told((turn + 1) as f64 / runs as f64);
    }
    Ok(times.into_iter().map(timing).collect())
}

/// Of times that were taken (s), at least one.
pub fn timing(mut times: Vec<f64>) -> Timing {
    times.sort_by(f64::total_cmp);
    let repeats = times.len();
    let (least_s, most_s) = (times[0], times[repeats - 1]);
    Timing { median_s: times[repeats / 2], least_s, most_s, repeats }
}
