//! What `import-log` proposes.

use super::result;
use crate::ImportReport;
use crate::text::import::left_out;
use trueweld_logs::log::channel_name;
use trueweld_logs::log::import::{Doubt, Proposal, ProposedColumn, ProposedFile};

result! {
    /// How files of unknown make are proposed to be read.
    ImportResult of (report: &ImportReport<'_>) with {
        let proposal = report.proposal;
        let columns = proposal.columns.iter();
    } {
        /// The `log.toml` that was written.
        out: String = report.out.display().to_string(),
        /// What was probably done: a kind of log.
        kind: &'static str = proposal.kind.name(),
        /// Whether only this kind fits, or it was given.
        kind_sure: bool = proposal.kind_sure,
        /// Whether no column is the time of the encoders, so that the period of the rows is to be stated.
        period_open: bool = proposal.period_open,
        /// Channels that the kind needs and no column is.
        missing: Vec<&'static str> = proposal.missing.clone(),
        /// The files.
        files: Vec<ImportedFile> = proposal.files.iter().map(ImportedFile::of).collect(),
        /// Their columns.
        columns: Vec<ImportedColumn> =
            columns.map(|column| ImportedColumn::of(column, proposal)).collect(),
    }
}

result! {
    /// A file.
    ImportedFile of (of: &ProposedFile) {
        /// Its path.
        path: String = of.path.display().to_string(),
        /// Rows that were looked at.
        rows: usize = of.rows,
        /// Period of the rows, s.
        period_s: Option<f64> = of.period,
        /// Name of its clock; null for the log's own.
        clock: Option<String> = of.clock.clone(),
        /// Offset that was fitted, s.
        offset_s: Option<f64> = of.fitted.map(|f| f.map.offset),
        /// Drift that was fitted, s per s.
        drift: Option<f64> = of.fitted.map(|f| f.map.drift),
    }
}

result! {
    /// A column.
    ImportedColumn of (column: &ProposedColumn, proposal: &Proposal) with {
        let mapping = column.mapping.as_ref().ok();
        let doubts = column.doubts.iter().filter(|_| mapping.is_some());
    } {
        /// Path of its file.
        file: String = proposal.files[column.file].path.display().to_string(),
        /// Its header.
        header: String = column.header.clone(),
        /// The channel; null where it is left out.
        channel: Option<&'static str> = mapping.map(|m| channel_name(m.column)),
        /// The unit.
        unit: Option<&'static str> = mapping.map(|m| m.unit),
        /// What values are multiplied by.
        factor: Option<f64> = mapping.map(|m| m.factor),
        /// What is only a guess: channel, unit, sign, factor.
        doubts: Vec<&'static str> = doubts.map(doubt).collect(),
        /// Why it is left out; null where it is mapped.
        left_out: Option<String> = column.mapping.as_ref().err().map(left_out),
    }
}

fn doubt(of: &Doubt) -> &'static str {
    match of {
        Doubt::Channel => "channel",
        Doubt::Unit | Doubt::Scale => "unit",
        Doubt::Sign => "sign",
        Doubt::Factor => "factor",
    }
}
