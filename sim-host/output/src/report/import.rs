//! Files of unknown make, and how they are proposed to be read.

use super::{PublishedResult, Report};
use crate::ImportReport;
use crate::document::{Block, Document, Medium, Table, Tone, number, words};
use crate::json::import::ImportResult;
use crate::text::import::{bases, doubts, headline};
use trueweld_logs::log::channel_name;

impl Report for ImportReport<'_> {
    const SCHEMA: &'static str = "import-log/1";

    fn json(&self) -> impl PublishedResult {
        ImportResult::of(self)
    }

    fn document(&self) -> Document {
        let proposal = self.proposal;
        let mut document = Document::new("Import", headline(proposal), self.provenance);
        let head = ["column", "values", "channel", "why"].map(words).to_vec();
        let mut rows = Vec::new();
        for (k, file) in proposal.files.iter().enumerate() {
            let topic = file.topic.as_ref().map_or(String::new(), |topic| format!(", {topic}"));
            let shown = format!("{}{topic}", file.path.display());
            rows.push(vec![words(shown).tone(Tone::Strong).over(4)]);
            for column in proposal.columns.iter().filter(|c| c.file == k) {
                let shown = |v: f64| match v.abs() {
                    ..1e9 => format!("{v:.4}"),
                    _ => format!("{v:.3e}"),
                };
                let range = column.range.map_or(String::new(), |ends| ends.map(shown).join(" … "));
                let channel = column.mapping.as_ref().map_or(String::new(), |mapping| {
                    let sign = if mapping.factor < 0.0 { "−" } else { "" };
                    format!("{sign}{}, {}", channel_name(mapping.column), mapping.unit)
                });
                let doubts = doubts(column);
                let why = match doubts.as_str() {
                    "" => words(bases(column)),
                    doubts => words(format!("{}; not sure of {doubts}", bases(column))).bad(true),
                };
                let header = words(format!("  {}", column.header));
                rows.push(vec![header, number(range), words(channel), why]);
            }
        }
        document.push_on(Medium::All, Block::Table(Table { head: vec![head], rows }));
        document
    }
}
