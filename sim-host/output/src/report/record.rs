//! What was recorded of a simulated cell.

use super::Report;
use crate::RecordReport;
use crate::document::{Block, Document, Table, number, words};
use crate::json::{RecordResult, RecordedLog};
use crate::words::{counted, fixed};

impl Report for RecordReport<'_> {
    type Json = RecordResult;

    fn json(&self) -> RecordResult {
        RecordResult::of(self)
    }

    fn document(&self) -> Document {
        let headline = format!(
            "recorded {} of {} into {}, seed {}.",
            counted(self.logs.len(), "log"),
            self.robot,
            self.folder.display(),
            self.seed
        );
        let mut document = Document::new("Record", headline, self.provenance);
        let head =
            vec![words("log"), words("kind"), number("rows"), number("from, s"), number("to, s")];
        let row = |log: &RecordedLog| {
            let [from, to] = log.time_s.map(|time| number(fixed(time, 3)));
            let rows = number(log.rows.to_string());
            vec![words(log.name.clone()), words(log.kind.clone()), rows, from, to]
        };
        document.push(Block::Table(Table {
            head: vec![head],
            rows: self.json().logs.iter().map(row).collect(),
        }));
        document
    }
}
