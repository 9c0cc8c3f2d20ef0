//! What was recorded of a simulated cell.

use super::Report;
use crate::RecordReport;
use crate::document::{Block, Document, Table, number, words};
use crate::json::RecordResult;
use crate::words::{counted, fixed};
use trueweld_measure::data::log::Log;

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
        let row = |log: &Log| {
            let time = |of: Option<&f64>| number(of.map_or(String::new(), |t| fixed(*t, 3)));
            vec![
                words(log.name.clone()),
                words(log.kind.name()),
                number(log.samples.len().to_string()),
                time(log.samples.time.first()),
                time(log.samples.time.last()),
            ]
        };
        document.push(Block::Table(Table {
            head: vec![head],
            rows: self.logs.iter().map(row).collect(),
        }));
        document
    }
}
