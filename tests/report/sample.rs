//! A page as the figures make them: numbers and texts of the right size, measured by nobody.

use carom::report::page::{
    Axis, Column, Item, Kind, Map, Page, Plot, Point, Scale, Section, Series, Table,
};

pub fn axis(label: &str, unit: &str, log: bool, timed: bool) -> Axis {
    Axis { label: label.to_owned(), unit: unit.to_owned(), log, timed }
}

pub fn point(x: f64, y: f64) -> Point {
    Point { x, y, spread: None, note: String::new() }
}

pub fn series(label: &str, kind: Kind, points: Vec<Point>) -> Series {
    Series { label: label.to_owned(), kind, points }
}

pub fn plot(name: &str, series: Vec<Series>) -> Plot {
    Plot {
        name: name.to_owned(),
        title: "Position error after a simulated second against run time".to_owned(),
        caption: "1000 equal discs, area fraction 0.3, seed 1. Median of 10 runs; bars from the \
                  least to the largest."
            .to_owned(),
        x: axis("run time of a simulated second", "ms", true, true),
        y: axis("relative energy error after a second", "1", true, false),
        series,
    }
}

/// Eight methods, an exact one whose error is zero, and two guides.
pub fn gas() -> Plot {
    let names = [
        "carom events",
        "carom plain",
        "carom ticks",
        "carom steps",
        "carom springs, 1e4 N/m",
        "carom springs, 1e6 N/m",
        "Box2D 3.2",
        "Rapier 0.36",
    ];
    let mut all = Vec::new();
    for (k, name) in names.iter().enumerate() {
        let count = if k < 3 { 1 } else { 7 };
        let points = (0..count).map(|i| {
            let step = 60.0 * 2_f64.powi(i);
            let x =
                if k < 3 { 0.3 * 10_f64.powi(k as i32) } else { 0.01 * step * (k as f64 - 2.0) };
            let y = if k < 3 {
                2e-16 * (k as f64 + 1.0)
            } else {
                (k as f64) / step.powi(1 + (k as i32 % 2))
            };
            Point { x, y, spread: Some((0.9 * x, 1.3 * x)), note: format!("1/{step} s") }
        });
        all.push(series(name, if k < 3 { Kind::Marks } else { Kind::Curve }, points.collect()));
    }
    all[0].points[0].y = 0.0;
    let slope = |order: i32| vec![point(1.0, 0.5), point(300.0, 0.5 / 300_f64.powi(order))];
    all.push(series("first order", Kind::Guide, slope(1)));
    all.push(series("second order", Kind::Guide, slope(2)));
    plot("gas_energy", all)
}

fn straight() -> Plot {
    let rate = |k: i32| Point {
        spread: Some((0.0, 1.0)),
        ..point(f64::from(k) * 0.05, 0.1 * f64::from(k * k))
    };
    let mut plot = plot(
        "cost",
        vec![
            series(
                "events, one size of discs in a periodic box of a hundred diameters, and two walls \
             of different restitution",
                Kind::Curve,
                (0..12).map(rate).collect(),
            ),
            series("Enskog", Kind::Guide, vec![point(0.0, 0.0), point(0.6, 14.0)]),
        ],
    );
    plot.x = axis("area fraction", "1", false, false);
    plot.y = axis(
        "collisions of a disc in the time that it needs for its own diameter at mean speed",
        "1/s",
        false,
        true,
    );
    plot.title = "Cost against density".to_owned();
    plot
}

pub fn map(name: &str, scale: Scale, value: impl Fn(f64, f64) -> f64) -> Map {
    let xs: Vec<f64> = (0..40).map(|k| 10_f64.powf(-2.0 + 0.1 * f64::from(k))).collect();
    let ys: Vec<f64> = (0..30).map(|k| 0.05 * f64::from(k)).collect();
    let bound = xs.iter().map(|x| point(*x, 1.4 / (1.0 + x)));
    Map {
        name: name.to_owned(),
        title: "Where a spring stays stable".to_owned(),
        caption: "Symplectic Euler, one contact.".to_owned(),
        x: axis("step times frequency", "1", true, false),
        y: axis("damping ratio", "1", false, false),
        values: ys.iter().map(|y| xs.iter().map(|x| value(*x, *y)).collect()).collect(),
        lines: vec![
            series("theoretical boundary", Kind::Curve, bound.collect()),
            series(
                "half of it",
                Kind::Guide,
                xs.iter().map(|x| point(*x, 0.7 / (1.0 + x))).collect(),
            ),
        ],
        xs,
        ys,
        scale,
    }
}

pub fn table(rows: usize) -> Table {
    let column = |label: &str, number, timed| Column { label: label.to_owned(), number, timed };
    let row = |k: usize| {
        vec![
            format!("E{k:02}_many_discs"),
            "trajectory".to_owned(),
            format!("{:.2e}", 1e-16 * k as f64),
            "1e-12".to_owned(),
            format!("{:.3}", 0.01 * k as f64),
            "a long remark on what was left out here and why, in words".to_owned(),
        ]
    };
    Table {
        name: "cases".to_owned(),
        title: "Reference cases".to_owned(),
        caption: "As `carom check` runs them.".to_owned(),
        columns: vec![
            column("case", false, false),
            column("kind", false, false),
            column("largest error", true, false),
            column("tolerance", true, false),
            column("time (s)", true, true),
            column("remark", false, false),
        ],
        rows: (0..rows).map(row).collect(),
    }
}

pub fn page() -> Page {
    let text = vec![
        "How wrong is each method, and what does it cost? The exact method is also the quickest: \
         fixed steps pay more for every digit."
            .to_owned(),
        "One simulated second of 1000 equal discs between walls, area fraction 0.3, seed 1; 10 \
         repeats, median and least."
            .to_owned(),
    ];
    let section = |name, title: &str, items| Section {
        name,
        title: title.to_owned(),
        text: text.clone(),
        items,
    };
    let number = axis("relative energy error", "1", true, false);
    let classes = ["stable", "grows slowly", "unstable", "not run"].map(str::to_owned).to_vec();
    let class = |x: f64, y: f64| ((x * (1.0 + y)).log10() + 1.5).floor().clamp(0.0, 3.0);
    let error =
        |x: f64, y: f64| if x * y > 40.0 { f64::NAN } else { 1e-12 * (x * (1.0 + y)).powi(6) };
    Page {
        machine: vec![
            ("processor".to_owned(), "Some Processor 3000 @ 2.0 GHz".to_owned()),
            (
                "load average at start".to_owned(),
                "0.1, 0.2, 0.3 over 1, 5 and 15 minutes".to_owned(),
            ),
        ],
        sections: vec![
            section(
                "gas",
                "A gas: error against run time",
                vec![Item::Plot(gas()), Item::Plot(straight())],
            ),
            section(
                "stability",
                "Stability",
                vec![
                    Item::Map(map("growth", Scale::Continuous(number), error)),
                    Item::Map(map("stable", Scale::Classes(classes), class)),
                ],
            ),
            section("cases", "Reference cases", vec![Item::Table(table(60))]),
        ],
        ..Page::default()
    }
}
