//! Drawing: pages, plots, maps and data files from any numbers and any text.

use std::collections::BTreeSet;

use carom::report::draw::look::{self, Look};
use carom::report::draw::scale::Scale;
use carom::report::draw::{self, csv};
use carom::report::page::{Item, Kind, Page, Plot, Point, Scale as Meaning, Section};
use roxmltree::Document;

use crate::sample::{self, axis, point, series};

fn files(page: Page) -> Vec<(String, String)> {
    let files = draw::files(page);
    assert_eq!(files.last().expect("a page").0, "index.html");
    files
}

/// All drawings of a page, inline and alone, as they were parsed.
fn each_drawing(files: &[(String, String)], mut look: impl FnMut(&Document)) {
    let mut count = 0;
    for (name, text) in files {
        let mut rest = text.as_str();
        while let Some(start) = rest.find("<svg") {
            let end = start + rest[start..].find("</svg>").expect("an end") + "</svg>".len();
            let document = Document::parse(&rest[start..end]);
            look(&document.unwrap_or_else(|error| panic!("{name}: {error}")));
            rest = &rest[end..];
            count += 1;
        }
    }
    assert!(count > 0);
}

fn page_of(items: Vec<Item>) -> Page {
    let section = Section { name: "one", title: "One".to_owned(), text: Vec::new(), items };
    Page { machine: Vec::new(), sections: vec![section], ..Page::default() }
}

fn one_plot(plot: Plot) -> Vec<(String, String)> {
    files(page_of(vec![Item::Plot(plot)]))
}

/// Every number in every coordinate is one.
fn assert_drawable(files: &[(String, String)]) {
    each_drawing(files, |document| {
        for node in document.descendants().filter(|node| node.is_element()) {
            for name in ["d", "x", "y", "width", "height", "viewBox"] {
                let Some(value) = node.attribute(name) else { continue };
                let fine = |c: char| c.is_ascii_digit() || "MLHVZhvaz. -%".contains(c);
                assert!(value.chars().all(fine), "{name}={value}");
                let numbers = value.split(|c: char| !(c.is_ascii_digit() || c == '.'));
                let numbers = numbers.filter_map(|number| number.parse::<f64>().ok());
                assert!(numbers.fold(0.0, f64::max) < 2e4, "{name}={value}");
            }
        }
    });
}

#[test]
fn every_drawing_is_well_formed_and_says_what_it_is() {
    let files = files(sample::page());
    assert_drawable(&files);
    each_drawing(&files, |document| {
        let svg = document.root_element();
        assert_eq!(svg.attribute("role"), Some("img"));
        assert!(svg.attribute("viewBox").is_some());
        let labels = svg.attribute("aria-labelledby").expect("labels");
        for id in labels.split(' ') {
            let labelled = |node: &roxmltree::Node| node.attribute("id") == Some(id);
            let node = document.descendants().find(labelled).expect("the label");
            assert!(node.text().is_some_and(|text| !text.is_empty()));
        }
    });
}

#[test]
fn the_page_needs_nothing_beside_it() {
    let files = files(sample::page());
    for (name, text) in files.iter().filter(|(name, _)| !name.ends_with(".csv")) {
        let bare = text.replace("http://www.w3.org/2000/svg", "");
        for word in ["http:", "https:", "//", "<script", "src=", "@import", "<link", "onload"] {
            assert!(!bare.contains(word), "{name} has {word}");
        }
        let mut urls = bare.split("url(").skip(1);
        assert!(urls.all(|rest| rest.starts_with('#')), "{name}");
    }
    let html = &files.last().expect("the page").1;
    let ids: Vec<&str> =
        html.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let distinct: BTreeSet<&&str> = ids.iter().collect();
    assert_eq!(ids.len(), distinct.len());
    let links = html.split(" href=\"").skip(1).filter_map(|rest| rest.split('"').next());
    for link in links {
        let beside = files.iter().any(|(name, _)| name == link);
        assert!(beside || ids.contains(&link.trim_start_matches('#')), "{link}");
    }
}

#[test]
fn light_and_dark_go_with_every_drawing_alone() {
    for (name, text) in files(sample::page()).iter().filter(|(name, _)| name.ends_with(".svg")) {
        assert!(text.contains("prefers-color-scheme:dark"), "{name}");
    }
    let picture = include_str!("../../README.md").split("](").skip(1);
    let pictures = picture.filter_map(|rest| rest.split(')').next());
    for picture in pictures.filter(|name| name.ends_with(".svg")) {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(picture);
        let text = std::fs::read_to_string(path).expect("the picture that README shows");
        assert!(text.contains("prefers-color-scheme:dark") && !text.contains("<script"));
        Document::parse(&text).expect("well-formed");
    }
}

#[test]
fn any_text_is_only_text() {
    let hostile =
        "</svg><script>alert('1')</script> & \" < > ]]> \u{0} \u{1b}[31m \u{ffff} \u{202e}";
    let mut plot = sample::gas();
    for text in [&mut plot.title, &mut plot.caption, &mut plot.name] {
        *text = hostile.to_owned();
    }
    (plot.x.label, plot.y.unit) = (hostile.to_owned(), hostile.to_owned());
    plot.series[0].label = hostile.to_owned();
    plot.series[0].points[0].note = hostile.to_owned();
    let mut map = sample::map("m", Meaning::Classes(vec![hostile.to_owned()]), |_, _| 0.0);
    map.lines[0].label = hostile.to_owned();
    let mut table = sample::table(2);
    table.rows[1][0] = hostile.to_owned();
    table.columns[0].label = hostile.to_owned();
    let mut page = page_of(vec![Item::Plot(plot), Item::Map(map), Item::Table(table)]);
    page.machine.push((hostile.to_owned(), hostile.to_owned()));
    page.sections[0].text.push(hostile.to_owned());
    let files = files(page);
    assert_drawable(&files);
    for (name, text) in &files {
        let harmless = |c: char| c.is_ascii_lowercase() || "_.0123456789".contains(c);
        assert!(name.chars().all(harmless), "{name}");
        assert!(name.ends_with(".csv") || !text.contains("<script"), "{name}");
        assert!(name.ends_with(".csv") || !text.contains('\u{0}'), "{name}");
    }
    let (_, text) = files.iter().find(|(name, _)| name == "cases.csv").expect("the table");
    let mut reader = ::csv::Reader::from_reader(text.as_bytes());
    let row = reader.records().nth(1).expect("a row").expect("as it was");
    assert_eq!(&row[0], hostile);
}

const ODD: [f64; 12] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    0.0,
    -0.0,
    -1.0,
    5e-324,
    f64::MAX,
    f64::MIN,
    1e-300,
    1.0,
    1.0 + f64::EPSILON,
];

#[test]
fn no_number_breaks_a_plot() {
    for (log_x, log_y) in [(false, false), (true, false), (false, true), (true, true)] {
        let draw = |points: Vec<Point>| {
            let mut plot = sample::plot("p", vec![series("s", Kind::Curve, points)]);
            (plot.x.log, plot.y.log) = (log_x, log_y);
            assert_drawable(&one_plot(plot));
        };
        draw(Vec::new());
        for x in ODD {
            for y in ODD {
                draw(vec![Point { spread: Some((y, x)), ..point(x, y) }]);
                draw(vec![point(x, y), point(1.0, 2.0), point(y, x)]);
            }
        }
        draw(ODD.iter().map(|x| point(*x, *x)).collect());
    }
    assert_drawable(&one_plot(sample::plot("p", Vec::new())));
}

#[test]
fn no_number_breaks_a_map() {
    let number = Meaning::Continuous(axis("error", "1", true, false));
    let classes = Meaning::Classes(vec!["one".to_owned(), "two".to_owned()]);
    for scale in [number, classes] {
        for log in [false, true] {
            for (xs, ys) in [(0, 0), (1, 1), (3, 1), (12, 12)] {
                let mut map = sample::map("m", scale.clone(), |_, _| 0.0);
                (map.x.log, map.y.log) = (log, log);
                map.xs = ODD[..xs].to_vec();
                map.ys = ODD[12 - ys..].to_vec();
                // Rows that are missing, too short, too long.
                map.values = (0..13).map(|k| ODD[..k.min(12)].to_vec()).collect();
                map.lines[0].points = ODD.iter().map(|x| point(*x, *x)).collect();
                assert_drawable(&files(page_of(vec![Item::Map(map)])));
            }
        }
    }
}

#[test]
fn what_has_no_place_is_counted() {
    let points = vec![point(1.0, f64::NAN), point(1.0, 1.0), point(-1.0, 1.0), point(2.0, 0.0)];
    let files = one_plot(sample::plot("p", vec![series("s", Kind::Curve, points)]));
    assert!(files[1].1.contains("2 of 4 points have no place here"));
}

#[test]
fn commands_in_a_text_are_set_as_such() {
    let mut page = page_of(Vec::new());
    page.sections[0].text.push("with `carom <check>` and `odd".to_owned());
    let text = files(page).pop().expect("the page").1;
    let set = "<p>with <code>carom &lt;check&gt;</code> and `odd</p>";
    assert!(text.contains(set));
}

#[test]
fn names_of_files_are_distinct() {
    let items = (0..3).map(|_| Item::Table(sample::table(1))).collect();
    let names: Vec<String> = files(page_of(items)).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["cases.csv", "cases_2.csv", "cases_3.csv", "index.html"]);
}

#[test]
fn data_files_give_the_same_bits_back() {
    let numbers = [0.1, -1.0 / 3.0, 5e-324, f64::MAX, 1.0 + f64::EPSILON, f64::INFINITY, -0.0];
    let points: Vec<Point> = numbers.iter().map(|x| point(*x, -x)).collect();
    let text = csv::text(&Item::Plot(sample::plot("p", vec![series("s", Kind::Marks, points)])));
    let mut reader = ::csv::Reader::from_reader(text.as_bytes());
    for (row, x) in reader.records().zip(numbers) {
        let row = row.expect("a row");
        assert_eq!(row[1].parse::<f64>().expect("a number").to_bits(), x.to_bits());
        assert_eq!(row[2].parse::<f64>().expect("a number").to_bits(), (-x).to_bits());
    }
    let head = text.lines().next().expect("a head");
    assert!(head.contains("run time of a simulated second (ms) [timed]"), "{head}");
}

#[test]
fn two_reports_are_compared_without_their_times() {
    let report = |time: f64, error: f64| {
        let mut page = sample::page();
        for item in page.sections.iter_mut().flat_map(|section| &mut section.items) {
            match item {
                Item::Plot(plot) if plot.x.timed => {
                    let point = &mut plot.series[4].points[2];
                    (point.x, point.y) = (point.x * time, point.y * error);
                    point.spread = point.spread.map(|(least, most)| (least * time, most * time));
                }
                Item::Table(table) => table.rows[1][4] = format!("{time} s"),
                _ => {}
            }
        }
        let data = files(page).into_iter().filter(|(name, _)| name.ends_with(".csv"));
        data.map(|(_, text)| csv::untimed(&text).expect("CSV")).collect::<Vec<String>>()
    };
    assert_eq!(report(1.0, 1.0), report(1.7, 1.0));
    assert_ne!(report(1.0, 1.0), report(1.0, 1.0 + f64::EPSILON));
}

fn labels(scale: &Scale, room: usize) -> Vec<String> {
    let labels = scale.ticks(room).into_iter().filter_map(|tick| tick.label);
    labels.map(|label| label.base + label.exponent.as_deref().unwrap_or_default()).collect()
}

#[test]
fn ticks_are_where_a_reader_wants_them() {
    let log = axis("error", "1", true, false);
    let straight = axis("rate", "1/s", false, false);
    let around = |axis, values: &[f64]| Scale::around(axis, values.iter().copied());
    assert_eq!(labels(&around(&log, &[1e-3, 1.0]), 7), ["10−3", "10−2", "10−1", "100"]);
    assert_eq!(labels(&around(&log, &[3e-16, 0.2]), 4), ["10−15", "10−10", "10−5"]);
    assert_eq!(labels(&around(&log, &[3.0, 3.0]), 7), ["100", "2×100", "5×100", "101"]);
    assert_eq!(labels(&around(&log, &[0.0, 1e-3, 1.0]), 3)[0], "0");
    assert_eq!(labels(&around(&straight, &[0.0, 1.0]), 5), ["0", "0.5", "1.0"]);
    assert_eq!(labels(&around(&straight, &[2e9, 4e9]), 3), ["2×109", "3×109", "4×109"]);
    let places = around(&log, &[1.0, 100.0]);
    let place = |value| places.place(value).expect("a place");
    assert!((place(10.0) - 0.5).abs() < 1e-12 && place(1.0) > 0.0 && place(100.0) < 1.0);
}

/// Relative luminance of a colour, as of WCAG 2.
fn luminance(colour: &str) -> f64 {
    let part = |k: usize| {
        let part = u8::from_str_radix(&colour[k..k + 2], 16).expect("a colour");
        let part = f64::from(part) / 255.0;
        if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
}

#[test]
fn every_colour_is_seen_on_its_paper() {
    let contrast = |a: &str, b: &str| {
        let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
        f64::max(a / b, b / a)
    };
    for (colours, [paper, ink, weak, ..]) in
        [(look::LIGHT, look::LIGHT_PAPER), (look::DARK, look::DARK_PAPER)]
    {
        assert!(colours.iter().all(|colour| contrast(colour, paper) >= 3.0));
        assert!(contrast(ink, paper) >= 7.0 && contrast(weak, paper) >= 4.5);
    }
    let looks: BTreeSet<String> = (0..128).map(|k| format!("{:?}", Look::of(k))).collect();
    assert_eq!(looks.len(), 128);
    assert!((0..8).all(|k| Look::of(k).shape == k && Look::of(k).colour == k));
}
