//! A gross mistake in the files of logs.

use super::{finite, result};
use crate::text::log_faults::{change, place, sentence, target};
use trueweld_estimate::log_faults::Mistake;

result! {
    /// A gross mistake in the files.
    FileMistake of (mistake: &Mistake, joints: &[String]) {
        /// `sign`, `zero`, `exchanged`, `coupling`, `unit`, `gear-side`, `tracker-frame`, `time-unit`, `wrench-side`,
        /// `wrench-axes`, `wrench-point` or `payload`.
        what: &'static str = mistake.kind.name(),
        /// What it is in: joints by their names, columns of the wrench (`Fx`), or `encoders`, `torque`,
        /// `wrench`, `tracker`, `time`, `spindle`, `payload`.
        at: String = place(mistake, joints),
        /// The channel that it is in.
        channel: &'static str = mistake.channel.name(),
        /// Names of the logs that it is in.
        logs: Vec<String> = mistake.logs.clone(),
        /// What shows it.
        evidence: MistakeEvidence = MistakeEvidence::of(mistake),
        /// The line to write; several where it takes several.
        change: String = change(mistake),
        /// Where the line belongs.
        change_in: &'static str = target(mistake),
        /// The same in words.
        sentence: String = sentence(mistake, joints),
    }
}

result! {
    /// What a residual is as the files are, and with the mistake undone.
    MistakeEvidence of (mistake: &Mistake) with {
        let evidence = &mistake.evidence;
    } {
        /// Channel that is compared.
        channel: &'static str = evidence.channel.name(),
        /// Unit of both figures.
        unit: &'static str = evidence.unit,
        /// Root mean square as the files are.
        rms_before: Option<f64> = finite(evidence.before),
        /// Root mean square with the mistake undone.
        rms_after: Option<f64> = finite(evidence.after),
    }
}
