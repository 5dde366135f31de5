//! The page: one HTML file that needs no network, no script and nothing beside it.
//!
//! It is light or dark as the reader's system is, and fits a phone: wide tables scroll in a box of
//! their own, plots scale. Every text is escaped by the markup macro. Links go to the data files
//! beside it, which it does not need.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::look::{self, DARK_PAPER, FONT, LIGHT_PAPER};
use super::text::clean;
use super::{map, plot};
use crate::report::page::{Item, Page, Section, Table};

/// Letters of a cell that is broken into lines, in a column that stays wide enough for it.
const WORDS: usize = 26;

/// The page as a text.
pub fn text(page: &Page) -> String {
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (page.front.command) }
                style { (PreEscaped(style())) (PreEscaped(look::style())) }
            }
            body {
                header {
                    h1 { (page.front.command) }
                    p.lead { (page.front.lead) }
                }
                (contents(page))
                main {
                    (machine(page))
                    @for section in &page.sections { (of_section(section)) }
                }
                footer { p { "Made by " code { (page.front.command) } "." } }
            }
        }
    };
    clean(markup.into_string())
}

fn contents(page: &Page) -> Markup {
    html! {
        nav aria-label="Contents" {
            ol {
                @for section in &page.sections {
                    li { a href={ "#" (section.name) } { (section.title) } }
                }
            }
        }
    }
}

fn machine(page: &Page) -> Markup {
    html! {
        section id="machine" {
            h2 { (page.front.facts) }
            p { (note(page.front.note)) }
            (boxed(page.front.facts, &html! {
                table {
                    tbody {
                        @for (name, value) in &page.machine {
                            tr { th scope="row" { (name) } td { (value) } }
                        }
                    }
                }
            }))
        }
    }
}

/// The word `timed` looks as it does in headings.
fn note(text: &str) -> Markup {
    let parts: Vec<&str> = text.splitn(2, " timed ").collect();
    html! {
        (parts[0])
        @if let Some(rest) = parts.get(1) { " " span.timed { "timed" } " " (rest) }
    }
}

fn of_section(section: &Section) -> Markup {
    html! {
        section id=(section.name) {
            h2 { (section.title) }
            @for paragraph in &section.text { p { (set(paragraph)) } }
            @for item in &section.items { (of_item(item)) }
        }
    }
}

/// Plain text but for commands, which stand between backticks.
fn set(text: &str) -> Markup {
    let parts: Vec<&str> = text.split('`').collect();
    html! {
        @for (k, part) in parts.iter().enumerate() {
            @if k % 2 == 0 { (part) }
            @else if k + 1 < parts.len() { code { (part) } }
            @else { "`" (part) }
        }
    }
}

fn of_item(item: &Item) -> Markup {
    let (name, title, caption) = item.texts();
    let (content, drawn) = match item {
        Item::Plot(plot) => (PreEscaped(plot::draw(plot, false)), true),
        Item::Map(map) => (PreEscaped(map::draw(map, false)), true),
        Item::Table(table) => (boxed(title, &rows(table)), false),
    };
    html! {
        figure id={ "item-" (name) } {
            h3 { (title) }
            (content)
            figcaption {
                @if !caption.is_empty() { p { (set(caption)) } }
                p.files {
                    a href={ (name) ".csv" } { "CSV" }
                    @if drawn { " " a href={ (name) ".svg" } { "SVG" } }
                }
            }
        }
    }
}

/// What is wider than a phone scrolls by itself, also by the keyboard.
fn boxed(label: &str, content: &Markup) -> Markup {
    html! { div.box role="region" aria-label=(label) tabindex="0" { (content) } }
}

fn rows(table: &Table) -> Markup {
    let number = |k: usize| table.columns.get(k).is_some_and(|column| column.number);
    let letters =
        |k: usize| table.rows.iter().filter_map(move |row| row.get(k)?.chars().nth(WORDS));
    let class = |k: usize| match (number(k), letters(k).count()) {
        (true, _) => Some("number"),
        (false, 0) => None,
        (false, _) => Some("words"),
    };
    let classes: Vec<_> = (0..table.columns.len()).map(class).collect();
    html! {
        table {
            thead {
                tr {
                    @for column in &table.columns {
                        th scope="col" class=[column.number.then_some("number")] {
                            (column.label)
                            @if column.timed { " " span.timed { "timed" } }
                        }
                    }
                }
            }
            tbody {
                @for row in &table.rows {
                    tr {
                        @for (k, cell) in row.iter().enumerate() {
                            td class=[classes.get(k).copied().flatten()] { (cell) }
                        }
                    }
                }
            }
        }
    }
}

fn style() -> String {
    let colours = |[paper, ink, weak, grid, minor]: [&str; 5], link: &str| {
        format!(
            ":root{{--paper:{paper};--ink:{ink};--weak:{weak};--grid:{grid};--minor:{minor};\
             --link:{link}}}"
        )
    };
    let light = colours(LIGHT_PAPER, "#0a5ea8");
    let dark = colours(DARK_PAPER, "#7cc0f5");
    format!("{light}@media (prefers-color-scheme:dark){{{dark}}}{}", rules())
}

fn rules() -> String {
    format!(
        "*{{box-sizing:border-box}}\
         body{{margin:0 auto;padding:0 1rem 3rem;max-width:64rem;background:var(--paper);\
         color:var(--ink);font:1rem/1.55 {FONT};overflow-wrap:break-word}}\
         h1{{margin:2rem 0 0;font-size:1.9rem;line-height:1.2}}\
         h2{{margin:3rem 0 .6rem;font-size:1.4rem;line-height:1.25}}\
         h3{{margin:0 0 .5rem;font-size:1.05rem;line-height:1.3}}\
         p,h3,nav,.plot{{max-width:52rem}}p{{margin:.6rem 0}}\
         .lead{{color:var(--weak);font-size:1.1rem;margin:.2rem 0 1rem}}\
         a{{color:var(--link)}}\
         nav{{padding:.8rem 1rem;border:1px solid var(--grid);border-radius:.5rem}}\
         nav ol{{margin:0;padding-left:1.4rem}}nav li{{padding:.15rem 0}}\
         figure{{margin:1.8rem 0}}figcaption{{color:var(--weak);font-size:.9rem}}\
         figcaption p{{margin:.4rem 0}}.files a{{margin-right:.6rem;padding:.3rem 0}}\
         .plot{{display:block;width:100%;height:auto}}\
         .box{{overflow:auto;max-height:75vh;border:1px solid var(--grid);border-radius:.5rem;\
         background:linear-gradient(90deg,var(--paper) 50%,transparent) 0 0/2.5rem 100% local,\
         linear-gradient(270deg,var(--paper) 50%,transparent) 100% 0/2.5rem 100% local,\
         linear-gradient(90deg,var(--grid),transparent) 0 0/1rem 100% scroll,\
         linear-gradient(270deg,var(--grid),transparent) 100% 0/1rem 100% scroll;\
         background-repeat:no-repeat}}\
         table{{border-collapse:collapse;width:100%;font-size:.9rem;line-height:1.35;\
         font-variant-numeric:tabular-nums}}\
         th,td{{padding:.35rem .7rem;text-align:left;vertical-align:top;\
         border-bottom:1px solid var(--minor);overflow-wrap:normal;min-width:4.5rem;\
         max-width:24rem}}\
         td{{white-space:nowrap}}.words,td:only-of-type{{min-width:13rem;white-space:normal}}\
         thead th{{position:sticky;top:0;background:var(--paper);\
         box-shadow:inset 0 -1px var(--weak);vertical-align:bottom}}\
         tbody tr:last-child>*{{border-bottom:0}}\
         .number{{text-align:right}}code{{font-size:.92em}}\
         .timed{{color:var(--weak);font-size:.8em;font-weight:400;font-style:italic}}\
         footer{{margin-top:3rem;color:var(--weak);font-size:.9rem}}"
    )
}
