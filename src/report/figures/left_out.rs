//! What the plan leaves out of each shipped scene, what that saves, and that it changes no bit.
//!
//! Measured by what `carom explain` measures with. That bits are the same with a part and without
//! is a condition of the report, not a result.

use super::items::{numbers, times, words};
use crate::bench::explain::{Blocks, Saving, Savings, savings};
use crate::plan::why::Verdict;
use crate::report::page::{Item, Section, Table};
use crate::report::{Effort, Progress, ReportError};
use crate::scene::{Scene, shipped};

/// Measures the section.
///
/// # Errors
/// [`ReportError::Wrong`] when a part that is not needed changes a bit.
pub fn section(effort: Effort, progress: Progress) -> Result<Section, ReportError> {
    let blocks = if effort == Effort::Quick { Blocks::FEW } else { Blocks::MANY };
    let names: Vec<&str> = shipped::names().collect();
    section_of(&names, blocks, progress)
}

/// The same for these scenes, in so many blocks.
///
/// # Errors
/// As [`section`].
pub fn section_of(
    names: &[&str],
    blocks: Blocks,
    progress: Progress,
) -> Result<Section, ReportError> {
    let (mut scenes, mut rows) = (Vec::new(), Vec::new());
    for (k, name) in names.iter().enumerate() {
        let scene = Scene::load(name).map_err(|error| ReportError::Wrong(error.to_string()))?;
        let found = savings(&scene, blocks);
        rows.extend(part_rows(name, &found)?);
        scenes.push(scene_row(name, &found)?);
        progress((k + 1) as f64 / names.len() as f64);
    }
    Ok(Section {
        name: "left_out",
        title: "What a scene does not need is left out".to_owned(),
        text: text(blocks),
        items: vec![Item::Table(scene_table(scenes)), Item::Table(part_table(rows))],
    })
}

fn part_rows(name: &str, found: &Savings) -> Result<Vec<Vec<String>>, ReportError> {
    let mut rows = Vec::new();
    for part in &found.parts {
        let absent = matches!(part.row.verdict, Verdict::LeftOut);
        if !absent || (part.saving.is_none() && part.same_bits.is_none()) {
            continue;
        }
        if part.same_bits == Some(false) {
            let part = part.row.part.name();
            return Err(ReportError::Wrong(format!("left out: {part} changes {name}")));
        }
        rows.push(vec![
            name.to_owned(),
            part.row.part.name().to_owned(),
            percent(part.saving.as_ref()),
            interval(part.saving.as_ref()),
            bits(part.same_bits),
            part.row.why.clone(),
        ]);
    }
    Ok(rows)
}

fn scene_row(name: &str, found: &Savings) -> Result<Vec<String>, ReportError> {
    if found.same_bits == Some(false) {
        return Err(ReportError::Wrong(format!("left out: all parts together change {name}")));
    }
    let count = |verdict: Verdict| found.parts.iter().filter(|p| p.row.verdict == verdict).count();
    Ok(vec![
        name.to_owned(),
        found.method.map_or("none: only answers".to_owned(), |method| method.to_string()),
        count(Verdict::LeftOut).to_string(),
        count(Verdict::Kept).to_string(),
        found.ns_per_contact.map_or(String::new(), |ns| format!("{ns:.0}")),
        percent(found.all.as_ref()),
        interval(found.all.as_ref()),
        bits(found.same_bits),
        found.contacts.to_string(),
    ])
}

fn percent(saving: Option<&Saving>) -> String {
    match saving {
        Some(saving) if saving.below_noise => "below noise".to_owned(),
        Some(saving) => format!("{:.1}", saving.percent),
        None => "-".to_owned(),
    }
}

fn interval(saving: Option<&Saving>) -> String {
    saving.map_or("-".to_owned(), |saving| format!("{:.1} to {:.1}", saving.from, saving.to))
}

fn bits(same: Option<bool>) -> String {
    let word = match same {
        Some(true) => "the same bits",
        Some(false) => "DIFFERENT",
        None => "-",
    };
    word.to_owned()
}

fn text(blocks: Blocks) -> Vec<String> {
    vec![
        "From the numbers of a scene carom derives what it needs and builds only that. What is \
         left out costs nothing, and its absence changes no bit of any position, velocity or \
         contact: the error is not only as small, it is the same number."
            .to_owned(),
        format!(
            "Measured on the first stretch of each shipped scene from copies of one start, in \
             turns without and with the part: {} blocks of at least four runs each, of which the \
             quickest counts; told is the median of the blocks and its 99 % interval. In the same \
             report the stretch is run once without and once with the part and all contacts and \
             the states at its end are compared bit by bit. carom explain SCENE measures the same.",
            blocks.count
        ),
        "Left out: parts that a scene needs, that a method always has or that it does not know, \
         and those with which other formulas would run; for these nothing can be compared. The \
         grid is for answers to circle states, so it is timed on as many circles as the scene \
         has pucks."
            .to_owned(),
    ]
}

fn scene_table(rows: Vec<Vec<String>>) -> Table {
    Table {
        name: "left_out_scenes".to_owned(),
        title: "Every shipped scene: with all parts, needed or not".to_owned(),
        caption: "How much longer a contact would take if every part were built that can be \
                  (--keep-all)."
            .to_owned(),
        columns: vec![
            words("scene"),
            words("method"),
            numbers("parts left out"),
            numbers("needed"),
            times("time of a contact (ns)"),
            times("saved by leaving out (%)"),
            times("99 % interval"),
            words("result with all parts"),
            times("contacts compared"),
        ],
        rows,
    }
}

fn part_table(rows: Vec<Vec<String>>) -> Table {
    Table {
        name: "left_out_parts".to_owned(),
        title: "Each part that was left out, by itself".to_owned(),
        caption: "How much longer a contact would take with that part alone.".to_owned(),
        columns: vec![
            words("scene"),
            words("part"),
            times("saved (%)"),
            times("99 % interval"),
            words("result with it"),
            words("why it is not needed"),
        ],
        rows,
    }
}
