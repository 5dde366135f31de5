//! What the robust time of impact costs and how exact it is: `cargo bench --bench impact`.
//!
//! Six categories of pairs in which plain formulas lose digits. Errors in units of 2^-53 against
//! 300-bit arithmetic, wrong decisions between hit and miss, and nanoseconds a pair: of many side by
//! side as the engine asks for them, of one by one, and of the plain formula inlined into a loop
//! over the same pairs. The ratio is that of many to plain. With `-- --full`, 2e6 pairs a category.
//! `carom report` shows the same beside other formulas.

use carom::report::figures::impact::formulas::Formula;
use carom::report::figures::impact::pairs::Category;
use carom::report::figures::impact::{Size, outcomes};

fn main() {
    let full = std::env::args().any(|argument| argument == "--full");
    let size = Size { pairs: if full { 2_000_000 } else { 20_000 }, repeats: 41 };
    println!("{} pairs a category", size.pairs);
    println!(
        "{:>16} {:>10} {:>8} {:>8} {:>8} {:>8} {:>6}",
        "", "largest u", "wrong", "many ns", "one ns", "plain ns", "ratio"
    );
    for category in Category::ALL {
        let found = outcomes(category, size).unwrap_or_else(|error| panic!("{error}"));
        let of = |formula: Formula| found[formula as usize];
        let [many, one, plain] =
            [Formula::CaromMany, Formula::Carom, Formula::Stable].map(|formula| of(formula).ns());
        let (worst, wrong) = (of(Formula::CaromMany).largest, of(Formula::CaromMany).wrong);
        println!(
            "{:>16} {worst:>10.3} {wrong:>8} {many:>8.2} {one:>8.2} {plain:>8.2} {:>6.2}",
            category.name(),
            many / plain
        );
    }
}
