//! Compensation laws side by side: one weld with every law, one thing at a time made worse.
//!
//! Four sweeps: what the law believes of the joints' stiffness, the noise of the sensors, their
//! delay, and lost sensors. The last three are run with a stiffness believed in wrongly, since a
//! seam sensor has nothing to do where the model is exact. Noise and delay of the force sensor are
//! also those of the force loop: a law that does not read it still welds with it.
//!
//! Every run depends on scenario and seed alone: not on the number of threads, nor on the order in
//! which they finish.

use crate::WeldFigures;
use nalgebra::SVector;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use trueweld_compensators::Entry;
use trueweld_core::{Fault, Robot};
use trueweld_plant::input::Sensors;
use trueweld_plant::sensors::{Failure, Instrument, InstrumentFault};
use trueweld_plant::serialize_as_text;
use trueweld_plant::simulate::{RecordRow, Recording, RunError, Scenario, Seam, run_after};

/// One change of the scenario.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ScenarioChange {
    /// Relative error of every joint's stiffness as the law believes in it, instead of the
    /// comparison's.
    StiffnessError(f64),
    /// Factor on the noise of force sensor and seam sensor. Never 0: laws weigh readings by their
    /// noise.
    Noise(f64),
    /// Delay of force sensor and seam sensor, control periods, instead of their file's.
    Delay(f64),
    /// Share of the seam sensor's readings that are lost, in every pass, instead of its file's.
    Lost(f64),
    /// The seam sensor reads nothing in the last pass, and is as its file says in those before.
    DeadInLastPass,
    /// The force sensor drops to zero half-way through the last pass's steady part, and stays
    /// there.
    ForceSensorDies,
}

/// What a sweep changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VariedQuantity {
    /// [`ScenarioChange::StiffnessError`].
    StiffnessError,
    /// [`ScenarioChange::Noise`].
    Noise,
    /// [`ScenarioChange::Delay`].
    Delay,
    /// [`ScenarioChange::Lost`], [`ScenarioChange::DeadInLastPass`] and
    /// [`ScenarioChange::ForceSensorDies`].
    Lost,
}

serialize_as_text!(VariedQuantity::key);

impl VariedQuantity {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::StiffnessError, Self::Noise, Self::Delay, Self::Lost];

    /// Its key in results.
    pub fn key(self) -> &'static str {
        match self {
            Self::StiffnessError => "stiffness_error",
            Self::Noise => "noise_factor",
            Self::Delay => "delay_periods",
            Self::Lost => "lost_share",
        }
    }

    /// The changes of its sweep.
    pub fn changes(self) -> &'static [ScenarioChange] {
        use ScenarioChange::{DeadInLastPass, Delay, ForceSensorDies, Lost, Noise, StiffnessError};
        match self {
            Self::StiffnessError => &[
                StiffnessError(-0.3),
                StiffnessError(-0.2),
                StiffnessError(-0.1),
                StiffnessError(0.0),
                StiffnessError(0.1),
                StiffnessError(0.2),
                StiffnessError(0.3),
            ],
            Self::Noise => {
                &[Noise(0.25), Noise(0.5), Noise(1.0), Noise(2.0), Noise(4.0), Noise(8.0)]
            }
            Self::Delay => &[Delay(0.0), Delay(1.0), Delay(2.0), Delay(4.0), Delay(8.0)],
            Self::Lost => &[
                Lost(0.0),
                Lost(0.1),
                Lost(0.5),
                Lost(0.9),
                Lost(1.0),
                DeadInLastPass,
                ForceSensorDies,
            ],
        }
    }
}

/// Why a run has no figures.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoFigures {
    /// It did not come to its end.
    #[error(transparent)]
    Run(#[from] RunError),
    /// It never reached full feed and full push.
    #[error("the steady part is not reached")]
    NotSteady,
}

serialize_as_text!(NoFigures::to_string);

/// A fault in a weld whose instruments are sound: a cell can stop there.
#[derive(Debug, thiserror::Error)]
#[error("a fault is reported at {time:.3} s: {fault:?}")]
pub(crate) struct ReportedFault {
    fault: Fault,
    time: f64,
}

impl ReportedFault {
    /// The first of a run.
    pub(crate) fn of(recording: &Recording) -> Option<Self> {
        let at = |row: &RecordRow| Some(Self { fault: row.fault?, time: row.time });
        recording.rows.iter().find_map(at)
    }
}

/// What a run came to: the figures of its last pass.
pub type SweepPoint = Result<WeldFigures, NoFigures>;

/// One sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioSweep {
    /// What was changed.
    pub quantity: VariedQuantity,
    /// For every law, in the order asked for, one point for each of the quantity's changes.
    pub points: Vec<Vec<SweepPoint>>,
}

/// Laws to be compared.
#[derive(Debug, Clone, Copy)]
pub struct LawComparison<'a> {
    /// Weld, cell, gains and instruments. Its law and its belief are not used.
    pub scenario: Scenario<'a>,
    /// The robot that laws believe in, before any error of stiffness.
    pub robot: &'a Robot<f64>,
    /// Relative error of the stiffness believed in, except where that is what is changed.
    pub stiffness_error: f64,
    /// The laws.
    pub laws: &'a [Entry],
    /// Welds of the seam, one after another, for a law that learns from one to the next; the last
    /// one counts. The others weld once, since more would change nothing.
    pub passes: usize,
}

impl LawComparison<'_> {
    /// Passes that a law is given.
    pub fn passes_of(&self, law: &Entry) -> usize {
        if law.needs().passes { self.passes.max(1) } else { 1 }
    }

    /// Welds of the whole comparison.
    pub fn welds(&self) -> usize {
        let changes: usize = VariedQuantity::ALL.iter().map(|q| q.changes().len()).sum();
        changes * self.laws.iter().map(|law| self.passes_of(law)).sum::<usize>()
    }

    /// All sweeps, on all cores. `progress` is told how many welds are done, from whichever thread.
    pub fn run(&self, progress: impl Fn(usize) + Sync) -> Vec<ScenarioSweep> {
        let each = |quantity: VariedQuantity| {
            self.laws
                .iter()
                .flat_map(move |law| quantity.changes().iter().map(move |change| (law, *change)))
        };
        let runs: Vec<(&Entry, ScenarioChange)> =
            VariedQuantity::ALL.into_iter().flat_map(each).collect();
        let done = AtomicUsize::new(0);
        let points: Vec<SweepPoint> = runs
            .par_iter()
            .map(|(law, change)| {
                let point = self.point(law, *change);
                let welds = self.passes_of(law);
                progress(done.fetch_add(welds, Ordering::Relaxed) + welds);
                point
            })
            .collect();
        let mut points = points.into_iter();
        let sweep = |quantity: VariedQuantity| {
            let of_law = |_: &Entry| points.by_ref().take(quantity.changes().len()).collect();
            ScenarioSweep { quantity, points: self.laws.iter().map(of_law).collect() }
        };
        VariedQuantity::ALL.into_iter().map(sweep).collect()
    }

    /// One law under one change.
    ///
    /// # Errors
    /// [`NoFigures`].
    pub fn point(&self, law: &Entry, change: ScenarioChange) -> SweepPoint {
        let error = if let ScenarioChange::StiffnessError(error) = change {
            error
        } else {
            self.stiffness_error
        };
        let controller_model = self
            .robot
            .with_stiffness_scaled(&SVector::repeat(1.0 + error))
            .map_err(|_| RunError::Cell)?;
        let [before, last] = [false, true].map(|last| self.sensors(change, last));
        let fault =
            if change == ScenarioChange::ForceSensorDies { self.force_sensor_dies() } else { None };
        let scenario = Scenario {
            law,
            controller_model: &controller_model,
            sensors: &last,
            fault,
            ..self.scenario
        };
        // The last pass has the scenario's own noise, as in `run_passes`.
        let earlier: Vec<Scenario<'_>> = (1..self.passes_of(law))
            .rev()
            .map(|k| Scenario {
                sensors: &before,
                seed: scenario.seed.wrapping_add(k as u64),
                fault: None,
                ..scenario
            })
            .collect();
        let recording = run_after(&earlier, &scenario, |_| {})?;
        WeldFigures::of(&recording).ok_or(NoFigures::NotSteady)
    }

    fn force_sensor_dies(&self) -> Option<InstrumentFault> {
        let Scenario { program, weld, .. } = &self.scenario;
        let [rises, falls] = program.steady(weld, &Seam::of(weld))?;
        Some(InstrumentFault {
            instrument: Instrument::ForceSensor,
            failure: Failure::Dropped,
            from: 0.5 * (rises + falls),
            until: f64::INFINITY,
        })
    }

    /// The instruments of the last pass, or of those before.
    fn sensors(&self, change: ScenarioChange, last: bool) -> Sensors {
        let mut sensors = self.scenario.sensors.clone();
        let period = self.scenario.control.period;
        let Sensors { force, seam, .. } = &mut sensors;
        match change {
            ScenarioChange::StiffnessError(_) | ScenarioChange::ForceSensorDies => {}
            ScenarioChange::Noise(factor) => {
                force.noise_force *= factor;
                force.noise_moment *= factor;
                if let Some(seam) = seam {
                    seam.noise *= factor;
                    seam.tilt_noise *= factor;
                }
            }
            ScenarioChange::Delay(periods) => {
                force.delay = periods * period;
                if let Some(seam) = seam {
                    seam.delay = periods * period;
                }
            }
            ScenarioChange::Lost(share) => seam.iter_mut().for_each(|seam| seam.lost = share),
            ScenarioChange::DeadInLastPass => {
                seam.iter_mut().filter(|_| last).for_each(|seam| seam.lost = 1.0)
            }
        }
        sensors
    }
}
