//! What was recorded of a simulated cell.

use crate::RecordReport;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_logs::log::Log;
use trueweld_plant::provenance::Provenance;

/// A campaign that was recorded of a simulated cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "record/1"))]
    pub schema: String,
    /// What the result is of; its effects are those of the cell, which the logs' model need not have.
    pub provenance: Provenance,
    /// The campaign's folder.
    pub folder: String,
    /// Seed of everything random.
    pub seed: u64,
    /// The logs, in the protocol's order.
    pub logs: Vec<RecordedLog>,
}

/// A log that was recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordedLog {
    /// Its name.
    pub name: String,
    /// What was done.
    pub kind: String,
    /// Rows.
    pub rows: usize,
    /// Time of the first row and of the last, s.
    pub time_s: [f64; 2],
}

impl RecordResult {
    pub(crate) fn of(report: &RecordReport<'_>) -> Self {
        let log = |log: &Log| {
            let time = &log.samples.time;
            RecordedLog {
                name: log.name.clone(),
                kind: log.kind.name().to_owned(),
                rows: time.len(),
                time_s: [time[0], time[time.len() - 1]],
            }
        };
        Self {
            schema: "record/1".to_owned(),
            provenance: report.provenance.clone(),
            folder: report.folder.display().to_string(),
            seed: report.seed,
            logs: report.logs.iter().map(log).collect(),
        }
    }
}
