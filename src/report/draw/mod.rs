//! Draw: a page becomes files. Nothing here measures.
//!
//! ```text
//! page -> html: one page     plot, map -> svg: axes, legend -> scale: ticks, look: colours
//!      -> csv: all numbers
//! ```
//!
//! Whatever the page says, drawing does not fail: a number that has no place is left out and
//! counted, a name that is taken gets a number, a text is only ever text.

pub mod csv;

pub mod html;

pub mod plot;

pub mod map;

pub mod svg;

pub mod scale;

pub mod look;

pub mod text;

use std::collections::BTreeSet;

use super::page::{Item, Page};

/// The page itself among the files.
pub const INDEX: &str = "index.html";

/// Name and content of every file; the page is the last.
pub fn files(mut page: Page) -> Vec<(String, String)> {
    make_names_distinct(&mut page);
    let mut files = Vec::new();
    for item in page.sections.iter().flat_map(|section| &section.items) {
        let name = item.texts().0;
        files.push((format!("{name}.csv"), csv::text(item)));
        match item {
            Item::Plot(plot) => files.push((format!("{name}.svg"), plot::draw(plot, true))),
            Item::Map(map) => files.push((format!("{name}.svg"), map::draw(map, true))),
            Item::Table(_) => {}
        }
    }
    files.push((INDEX.to_owned(), html::text(&page)));
    files
}

/// Names become file names and anchors: letters, digits, no two alike.
fn make_names_distinct(page: &mut Page) {
    let mut taken = BTreeSet::new();
    for item in page.sections.iter_mut().flat_map(|section| &mut section.items) {
        let name = item.name_mut();
        let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        let word: String = name.chars().map(|c| if allowed(c) { c } else { '_' }).collect();
        let word = if word.is_empty() { "item".to_owned() } else { word };
        *name = word.clone();
        for number in 2.. {
            if taken.insert(name.clone()) {
                break;
            }
            *name = format!("{word}_{number}");
        }
    }
}
