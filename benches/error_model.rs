//! How wrong a contact is, by method: writes the numbers of `config/error_model.json`.
//!
//! `cargo bench --bench error_model --no-default-features > config/error_model.json`. No time is
//! measured: the same numbers on every machine, but for the last digits of rounding.

use carom::bench::collision::coefficients;
use carom::plan::budget::ErrorModel;

/// By what the coefficients are larger than what was measured: in a scene contacts fall into the
/// same step, and share discs.
const MARGIN: f64 = 1.5;

fn main() {
    let [events, plain, ticks, steps, springs] = coefficients().expect("every method does it");
    // To two digits, upwards.
    let up = |x: f64| {
        let unit = 10f64.powi((MARGIN * x).log10().floor() as i32 - 1);
        format!("{:.1e}", (MARGIN * x / unit).ceil() * unit).parse().expect("a number")
    };
    let model = ErrorModel {
        command: "cargo bench --bench error_model --no-default-features".to_owned(),
        meaning: "error of the relative velocity after one contact over the relative speed before \
                  it, root mean square; of steps over the way in a step, of springs over the way \
                  in sqrt(mu / k), both in contact distances"
            .to_owned(),
        events: up(events),
        plain: up(plain),
        ticks: up(ticks),
        steps: up(steps),
        springs: up(springs),
        margin: MARGIN,
    };
    println!("{}", serde_json::to_string_pretty(&model).expect("plain numbers"));
}
