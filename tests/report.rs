//! The report: what is drawn is well-formed, self-contained and readable whatever the numbers are,
//! and what is written is whole.

#[path = "report/sample.rs"]
mod sample;

#[path = "report/drawing.rs"]
mod drawing;

#[path = "report/command.rs"]
mod command;
