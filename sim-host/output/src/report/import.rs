//! Files of unknown make, and how they are proposed to be read.

use super::{PublishedResult, Report};
use crate::ImportReport;
use crate::color::run;
use crate::document::{
    Block, Document, Medium, Picture, Plot, PlotLine, Table, Tone, number, reference, words,
};
use crate::json::import::ImportResult;
use crate::text::import::{bases, certainty, doubts, headline};
use trueweld_logs::log::import::ProposedColumn;
use trueweld_logs::log::{ColumnMapping, channel_name, dimension};

impl Report for ImportReport<'_> {
    const SCHEMA: &'static str = "import-log/1";

    fn json(&self) -> impl PublishedResult {
        ImportResult::of(self)
    }

    fn document(&self) -> Document {
        let proposal = self.proposal;
        let mut document = Document::new("Import", headline(proposal), self.provenance);
        let head = ["column", "values", "read as", "unit", "how sure", "why"].map(words).to_vec();
        let mut rows = Vec::new();
        for (k, file) in proposal.files.iter().enumerate() {
            let topic = file.topic.as_ref().map_or(String::new(), |topic| format!(", {topic}"));
            let shown = format!("{}{topic}", file.path.display());
            rows.push(vec![words(shown).tone(Tone::Strong).over(6)]);
            for column in proposal.columns.iter().filter(|c| c.file == k) {
                let shown = |v: f64| match v.abs() {
                    ..1e9 => format!("{v:.4}"),
                    _ => format!("{v:.3e}"),
                };
                let range = column.range.map_or(String::new(), |ends| ends.map(shown).join(" … "));
                let mapping = column.mapping.as_ref().ok();
                let channel = mapping.map_or(String::new(), read_as);
                let unit = mapping.map_or("", |mapping| mapping.unit);
                let doubts = doubts(column);
                let why = match doubts.as_str() {
                    "" => words(bases(column)),
                    doubts => words(format!("{}; not sure of {doubts}", bases(column))),
                };
                let sure = words(certainty(column)).bad(!doubts.is_empty());
                let header = words(format!("  {}", column.header));
                rows.push(vec![header, number(range), words(channel), words(unit), sure, why]);
            }
        }
        document.push_on(Medium::All, Block::Table(Table { head: vec![head], rows }));
        let pictures = proposal.columns.iter().filter_map(picture);
        document.figures("What each channel reads", pictures.collect());
        document
    }
}

/// What makes a column: its channel, with the sign, less what other channels add.
fn read_as(mapping: &ColumnMapping) -> String {
    let sign = |positive: bool| if positive { "+" } else { "−" };
    let own = if mapping.factor < 0.0 { "−" } else { "" };
    let others = mapping.plus.iter();
    let others: String = others
        .map(|(other, times)| format!(" {} {}", sign(*times < 0.0), channel_name(*other)))
        .collect();
    format!("{own}{}{others}", channel_name(mapping.column))
}

/// What a column reads over time, beside what the model makes of the encoders' motion.
fn picture(column: &ProposedColumn) -> Option<Picture> {
    let (mapping, preview) = (column.mapping.as_ref().ok()?, column.preview.as_ref()?);
    let points = |values: &[f64]| -> Vec<(f64, f64)> {
        preview.time.iter().copied().zip(values.iter().copied()).collect()
    };
    let channel = channel_name(mapping.column);
    let mut lines = vec![PlotLine::new("read", run(0), points(&preview.read))];
    if let Some(predicted) = &preview.predicted {
        lines.push(reference("by the encoders and the robot file", points(predicted)));
    }
    let axis = format!("{channel}, {}", dimension(mapping.column).unit());
    Some(Picture::new(format!("{channel}: {}", column.header), Plot::new("time, s", axis, lines)))
}
