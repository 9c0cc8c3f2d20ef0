//! A gross mistake in the files of logs.

use super::finite;
use crate::words::mistakes::{change, place, sentence, target};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_estimate::mistakes::Mistake;

/// A gross mistake in the files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileMistake {
    /// `sign`, `zero`, `exchanged`, `unit`, `gear-side`, `tracker-frame`, `time-unit`, `wrench-side`,
    /// `wrench-axes`, `wrench-point` or `payload`.
    pub what: String,
    /// What it is in: joints by their names, columns of the wrench (`Fx`), or `encoders`, `torque`,
    /// `wrench`, `tracker`, `time`, `spindle`, `payload`.
    pub at: String,
    /// The channel that it is in.
    pub channel: String,
    /// Names of the logs that it is in.
    pub logs: Vec<String>,
    /// What shows it.
    pub evidence: MistakeEvidence,
    /// The line to write; several where it takes several.
    pub change: String,
    /// Where the line belongs.
    pub change_in: String,
    /// The same in words.
    pub sentence: String,
}

/// What a residual is as the files are, and with the mistake undone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MistakeEvidence {
    /// Channel that is compared.
    pub channel: String,
    /// Unit of both figures.
    pub unit: String,
    /// Root mean square as the files are.
    pub rms_before: Option<f64>,
    /// Root mean square with the mistake undone.
    pub rms_after: Option<f64>,
}

impl FileMistake {
    pub(super) fn of(mistake: &Mistake, joints: &[String]) -> Self {
        Self {
            what: mistake.kind.name().to_owned(),
            at: place(mistake, joints),
            channel: mistake.channel.name().to_owned(),
            logs: mistake.logs.clone(),
            evidence: MistakeEvidence {
                channel: mistake.evidence.channel.name().to_owned(),
                unit: mistake.evidence.unit.to_owned(),
                rms_before: finite(mistake.evidence.before),
                rms_after: finite(mistake.evidence.after),
            },
            change: change(mistake),
            change_in: target(mistake).to_owned(),
            sentence: sentence(mistake, joints),
        }
    }
}
