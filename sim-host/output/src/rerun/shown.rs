//! Simulated runs as a recording shows them: their entities, names, colours and timelines.

use crate::color::{Rgb, run};
use crate::path::moving;
use re_chunk::TimeColumn;
use trueweld_plant::simulate::Recording;

/// Entity of what a recording is of.
pub(super) const ORIGIN: &str = "/origin";

/// Timeline that counts from the step.
pub(super) const SINCE_STEP: &str = "since_step";

/// A run and how it appears in the recording.
pub(super) struct DrawnRun<'a> {
    pub recording: &'a Recording,
    /// Root of its entities.
    pub root: String,
    /// Its name for people.
    pub name: String,
    pub color: Rgb,
    pub beside: Beside,
}

/// The timeline that a recording has beside `time`.
pub(super) enum Beside {
    /// `path_um`: distance gone along the seam, m, one value a row; counts only while the tool
    /// moves.
    Path(Vec<f64>),
    /// `since_step`: time since the step of the set-point at this time, s.
    Step(f64),
}

impl<'a> DrawnRun<'a> {
    /// All runs, with names that tell them apart.
    pub(crate) fn all(
        recordings: impl Iterator<Item = &'a Recording>,
        names: &[String],
        beside: impl Fn(&Recording) -> Beside,
    ) -> Vec<Self> {
        let all = recordings.zip(names).enumerate().map(|(k, (recording, name))| Self {
            recording,
            root: root(name),
            name: name.clone(),
            color: run(k),
            beside: beside(recording),
        });
        all.collect()
    }

    /// The timelines of some rows, which are all on the seam or all off it.
    pub(crate) fn times(&self, picked: impl Iterator<Item = usize> + Clone) -> Vec<TimeColumn> {
        let rows = &self.recording.rows;
        let mut times =
            vec![TimeColumn::new_duration_secs("time", picked.clone().map(|k| rows[k].time))];
        match &self.beside {
            Beside::Path(travelled) => {
                if picked.clone().next().is_some_and(|k| moving(rows[k].phase)) {
                    let travelled = picked.map(|k| micrometres(travelled[k]));
                    times.push(TimeColumn::new_sequence("path_um", travelled));
                }
            }
            Beside::Step(at) => {
                times.push(TimeColumn::new_duration_secs(
                    SINCE_STEP,
                    picked.map(|k| rows[k].time - at),
                ));
            }
        }
        times
    }
}

/// A position on the seam as the timeline counts it.
pub(super) fn micrometres(metres: f64) -> i64 {
    (metres * 1e6).round() as i64
}

/// What the entities of a run begin with.
fn root(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    match name {
        "no compensation" => "none".to_owned(),
        name => name.chars().map(plain).collect::<String>().replace("__", "_"),
    }
}
