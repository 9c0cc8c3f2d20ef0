//! What `import-log` proposes.

use crate::ImportReport;
use crate::words::import::left_out;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_logs::log::channel_name;
use trueweld_logs::log::import::{Doubt, ProposedColumn};

/// How files of unknown make are proposed to be read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImportResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "import-log/1"))]
    pub schema: String,
    /// The `log.toml` that was written.
    pub out: String,
    /// What was probably done: a kind of log.
    pub kind: String,
    /// Whether only this kind fits, or it was given.
    pub kind_sure: bool,
    /// Whether no column is the time of the encoders, so that the period of the rows is to be stated.
    pub period_open: bool,
    /// Channels that the kind needs and no column is.
    pub missing: Vec<String>,
    /// The files.
    pub files: Vec<ImportedFile>,
    /// Their columns.
    pub columns: Vec<ImportedColumn>,
}

/// A file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImportedFile {
    /// Its path.
    pub path: String,
    /// Rows that were looked at.
    pub rows: usize,
    /// Period of the rows, s.
    pub period_s: Option<f64>,
    /// Name of its clock; null for the log's own.
    pub clock: Option<String>,
    /// Offset that was fitted, s.
    pub offset_s: Option<f64>,
    /// Drift that was fitted, s per s.
    pub drift: Option<f64>,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImportedColumn {
    /// Path of its file.
    pub file: String,
    /// Its header.
    pub header: String,
    /// The channel; null where it is left out.
    pub channel: Option<String>,
    /// The unit.
    pub unit: Option<String>,
    /// What values are multiplied by.
    pub factor: Option<f64>,
    /// What is only a guess: channel, unit, sign, factor.
    pub doubts: Vec<String>,
    /// Why it is left out; null where it is mapped.
    pub left_out: Option<String>,
}

impl ImportResult {
    pub(crate) fn of(report: &ImportReport<'_>) -> Self {
        let proposal = report.proposal;
        let path = |k: usize| proposal.files[k].path.display().to_string();
        let file = |k: usize| {
            let file = &proposal.files[k];
            ImportedFile {
                path: path(k),
                rows: file.rows,
                period_s: file.period,
                clock: file.clock.clone(),
                offset_s: file.fitted.map(|f| f.map.offset),
                drift: file.fitted.map(|f| f.map.drift),
            }
        };
        let doubt = |doubt: &Doubt| match doubt {
            Doubt::Channel => "channel".to_owned(),
            Doubt::Unit | Doubt::Scale => "unit".to_owned(),
            Doubt::Sign => "sign".to_owned(),
            Doubt::Factor => "factor".to_owned(),
        };
        let column = |column: &ProposedColumn| {
            let mapping = column.mapping.as_ref().ok();
            let doubts = column.doubts.iter().filter(|_| mapping.is_some());
            ImportedColumn {
                file: path(column.file),
                header: column.header.clone(),
                channel: mapping.map(|m| channel_name(m.column).to_owned()),
                unit: mapping.map(|m| m.unit.to_owned()),
                factor: mapping.map(|m| m.factor),
                doubts: doubts.map(doubt).collect(),
                left_out: column.mapping.as_ref().err().map(left_out),
            }
        };
        Self {
            schema: "import-log/1".to_owned(),
            out: report.out.display().to_string(),
            kind: proposal.kind.name().to_owned(),
            kind_sure: proposal.kind_sure,
            period_open: proposal.period_open,
            missing: proposal.missing.iter().map(|name| (*name).to_owned()).collect(),
            files: (0..proposal.files.len()).map(file).collect(),
            columns: proposal.columns.iter().map(column).collect(),
        }
    }
}
