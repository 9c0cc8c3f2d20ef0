//! What was recorded of a simulated cell.

use super::{PublishedResult, Report};
use crate::document::{Block, Column, Document, Table, number, words};
use crate::text::{counted, fixed};
use crate::{RecordReport, RecordedLog};

impl Report for RecordReport<'_> {
    const SCHEMA: &'static str = "record/1";

    fn json(&self) -> impl PublishedResult {
        self
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
        let columns: [Column<'_, &RecordedLog>; 5] = [
            (words("log"), &|log| words(log.name.clone())),
            (words("kind"), &|log| words(log.kind)),
            (number("rows"), &|log| number(log.rows.to_string())),
            (number("from, s"), &|log| number(fixed(log.time_s[0], 3))),
            (number("to, s"), &|log| number(fixed(log.time_s[1], 3))),
        ];
        document.push(Block::Table(Table::of(self.logs, &columns)));
        document
    }
}
