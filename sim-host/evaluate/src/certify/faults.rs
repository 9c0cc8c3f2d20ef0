//! Fault cases: one instrument failing in the steady part of a weld and coming back, in the nominal
//! cell at several places of the weld and in drawn cells.
//!
//! Asked of every case: the correction stays within what the requirements allow, the tool stays
//! bounded while the fault lasts and until it must be over it, and then it keeps to the limits of
//! the steady part again. A fault that nobody detects is no reason to stop: such a weld is used as
//! any other, and must keep to the limits of the steady part all the time. Detected is a fault that
//! the controller or the law reports while it lasts.

use super::fault_figures::{DEPTH, FAULT_FIGURES, FaultSpreads, JUDGED, LATERAL, UNDETECTED};
use super::{Certification, FigureValues, SampledCell, Symptoms, figure_of, values};
use crate::requirements::{Faults, Requirements};
use crate::weld::{WELD_FIGURES, WeldFigures};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_plant::sensors::{Instrument, InstrumentFault, fault_name};
use trueweld_plant::simulate::{Recording, Scenario, Seam};

/// A run with a fault of which nothing is asked.
#[derive(Debug, thiserror::Error)]
#[error("no requirement asks for faults")]
struct NotAsked;

/// Longest plant step where the force sensor fails, s. A force loop that is lied to may lift the
/// tool off and let it hit the plate; at 1 ms such a blow throws the simulated arm by a metre,
/// at 0.25 ms it ends as at 0.05 ms, within 0.01 mm.
const BLOW_STEP: f64 = 2.5e-4;

/// Share of a weld's time that its plant steps take: a fault case of the force sensor, with eight
/// times as many, takes three times as long.
const PLANT_SHARE: f64 = 0.3;

/// The most that a figure of a fault case may be, SI units; after recovery that of the steady part.
/// `None` where nothing limits it.
pub(super) fn limit(key: &str, requirements: &Requirements, asked: &Faults) -> Option<f64> {
    match key {
        LATERAL => Some(asked.lateral),
        DEPTH => Some(asked.depth),
        UNDETECTED => Some(1.0),
        key => requirements.limit(key.strip_prefix("recovered_").unwrap_or(key)),
    }
}

/// An instrument that fails, and the cell in which it does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultCase {
    /// The fault.
    pub fault: InstrumentFault,
    /// Index of the drawn cell; `None` for the nominal one.
    pub draw: Option<u64>,
}

/// What one fault did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FaultTrial {
    /// Its name, as in "seam-stuck".
    pub name: String,
    /// The fault in words, as in "seam sensor stuck at its last value".
    pub fault: String,
    /// Index of the drawn cell; `None` for the nominal one.
    pub draw: Option<u64>,
    /// When it began and ended, s.
    pub time: [f64; 2],
    /// Time after its beginning at which the controller or the law first reported a fault, s; `None`
    /// where they did not while it lasted.
    pub detected: Option<f64>,
    /// The figure of the weld that was the largest share of its limit while the fault lasted and
    /// until the tool must be over it.
    pub worst: Option<LimitedFigure>,
    /// [`FAULT_FIGURES`]; `None` where the run came to no end.
    pub figures: Option<FigureValues>,
    /// How the loop behaved over the whole steady part.
    pub symptoms: Option<Symptoms>,
    /// Why there are no figures.
    pub failed: Option<String>,
}

/// A figure of a weld and its limit, SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitedFigure {
    /// Its key.
    pub name: String,
    /// What it came to.
    pub value: f64,
    /// The limit.
    pub limit: f64,
}

impl LimitedFigure {
    /// The share of the limit.
    pub fn share(&self) -> f64 {
        self.value / self.limit
    }
}

impl FaultTrial {
    /// Whether it is of a case.
    pub fn is_of(&self, case: &FaultCase) -> bool {
        let FaultCase { fault, draw } = case;
        let name = fault_name(fault.instrument, fault.failure);
        (&self.name, self.draw, self.time) == (&name, *draw, [fault.from, fault.until])
    }

    /// A figure by its key; infinite where the run came to no end, or to no number.
    pub fn figure(&self, key: &str) -> f64 {
        figure_of(self.figures.as_ref(), key)
    }
}

/// Requirements for faults that a weld cannot be judged by.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FaultsRefused {
    /// A seam too short for a fault and the recovery from it.
    #[error(
        "the steady part of the weld lasts {has:.1} s; expected at least {needs:.1} s for the fault cases: duration_s and recovery_s of \
         [faults], a second before and a second after"
    )]
    TooShort {
        /// How long it is, s.
        has: f64,
        /// How long it must be, s.
        needs: f64,
    },
    /// A limit that is none: where the tool is farther off, there is no weld.
    #[error(
        "`{key}` in [faults] is {:.2} mm; expected at most half the pin, {:.2} mm, beyond which the tool makes no weld",
        1e3 * limit, 1e3 * half_pin
    )]
    NoLimit {
        /// Its key.
        key: &'static str,
        /// What the file states, m.
        limit: f64,
        /// Half the pin's diameter, m.
        half_pin: f64,
    },
}

impl Certification<'_> {
    /// The fault cases of this weld, none where the requirements ask for none: every failure of the
    /// force sensor, and of the seam sensor where the cell has one, at every place and in every
    /// drawn cell that is asked for.
    ///
    /// # Errors
    /// [`FaultsRefused`].
    pub fn faults(&self) -> Result<Vec<FaultCase>, FaultsRefused> {
        let Some(asked) = &self.requirements.faults else {
            return Ok(Vec::new());
        };
        let scenario = &self.scenario;
        // `weld` judges across the seam and in depth by half the pin.
        let half_pin = scenario.planned.model.lateral_tolerance();
        for (key, limit) in [("lateral_max_m", asked.lateral), ("depth_max_m", asked.depth)] {
            if limit > half_pin * (1.0 + 1e-9) {
                return Err(FaultsRefused::NoLimit { key, limit, half_pin });
            }
        }
        let steady =
            scenario.program.steady(scenario.weld, &Seam::of(scenario.weld)).unwrap_or([0.0; 2]);
        let has = steady[1] - steady[0];
        let needs = asked.duration + asked.recovery + 2.0 * JUDGED;
        if has < needs {
            return Err(FaultsRefused::TooShort { has, needs });
        }
        let spread =
            |count: usize| (0..count).map(move |k| (k as f64 + 0.5) / count as f64 * (has - needs));
        let nominal = spread(asked.places).map(|after| (None, after));
        let drawn = spread(asked.draws).zip(0..).map(|(after, index)| (Some(index), after));
        let conditions: Vec<(Option<u64>, f64)> = nominal.chain(drawn).collect();
        let force = &scenario.sensors.force;
        let failures = asked.sizes.failures([force.noise_force, force.noise_moment]);
        let is_there = |instrument| match instrument {
            Instrument::ForceSensor => true,
            Instrument::SeamSensor => scenario.sensors.seam.is_some(),
        };
        let mut cases = Vec::new();
        for (instrument, failure) in failures.into_iter().filter(|of| is_there(of.0)) {
            cases.extend(conditions.iter().map(|&(draw, after)| {
                let from = steady[0] + JUDGED + after;
                let until = from + asked.duration;
                FaultCase { fault: InstrumentFault { instrument, failure, from, until }, draw }
            }));
        }
        Ok(cases)
    }

    fn plant_step(&self, fault: &InstrumentFault) -> f64 {
        match fault.instrument {
            Instrument::ForceSensor => self.scenario.plant_step.min(BLOW_STEP),
            Instrument::SeamSensor => self.scenario.plant_step,
        }
    }

    /// Time that a fault case takes over that of a weld without a fault, about.
    pub fn cost(&self, case: &FaultCase) -> f64 {
        let steps = self.scenario.plant_step / self.plant_step(&case.fault);
        1.0 + PLANT_SHARE * (steps - 1.0)
    }

    /// Runs one fault case.
    pub fn run_fault(&self, case: &FaultCase) -> FaultTrial {
        let FaultCase { fault, draw } = case;
        let cell = match draw {
            Some(index) => SampledCell::new(self.cell.uncertain, self.seed, *index),
            None => SampledCell::nominal(self.scenario.seed),
        };
        let plant_step = self.plant_step(fault);
        let scenario = Scenario { plant_step, fault: Some(*fault), ..self.scenario };
        let mut trial = FaultTrial {
            name: fault_name(fault.instrument, fault.failure),
            fault: fault.to_string(),
            draw: *draw,
            time: [fault.from, fault.until],
            detected: None,
            worst: None,
            figures: None,
            symptoms: None,
            failed: None,
        };
        match (self.cell.weld(&scenario, &cell, self.passes), &self.requirements.faults) {
            (Ok(mut recording), Some(asked)) => {
                trial.detected = detected(&recording, fault);
                trial.symptoms = Some(self.symptoms(&recording));
                let over = fault.until + asked.recovery;
                let mut spreads = FaultSpreads::of(&recording, fault, over);
                trial.worst = worst_share(&mut recording, fault, over, self.requirements);
                if let (None, Some(worst)) = (trial.detected, &trial.worst) {
                    spreads.undetected = worst.share();
                }
                trial.figures = Some(values(FAULT_FIGURES.iter(), &spreads));
            }
            (Ok(_), None) => trial.failed = Some(NotAsked.to_string()),
            (Err(error), _) => trial.failed = Some(error.to_string()),
        }
        trial
    }
}

/// When a fault was first reported, s after its beginning; `None` where it was not while it lasted,
/// or one was reported before.
fn detected(recording: &Recording, fault: &InstrumentFault) -> Option<f64> {
    let mut rows = recording.rows.iter().filter(|r| r.time >= fault.from - JUDGED);
    let first = rows.find(|r| r.fault.is_some())?;
    fault.is_on(first.time).then_some(first.time - fault.from)
}

/// Figures of a weld that are of its steady part, and not of the whole run, nor of an instrument: one
/// that fails reads wrong, and what counts is what becomes of the weld.
fn is_of_weld(key: &str) -> bool {
    const OTHERS: [&str; 5] = [
        "lateral_before_m",
        "correction_m",
        "correction_rad",
        "push_reading_error_n",
        "measured_push_error_rms_n",
    ];
    !key.contains('.') && !OTHERS.contains(&key)
}

/// The figure of the weld that is the largest share of its limit while the fault lasts, from its
/// end until the tool must be over it, or thereafter: each taken by itself, so that a short fault counts
/// in full in an RMS. Takes the rows.
fn worst_share(
    recording: &mut Recording,
    fault: &InstrumentFault,
    over: f64,
    requirements: &Requirements,
) -> Option<LimitedFigure> {
    let rows = std::mem::take(&mut recording.rows);
    let parts = [fault.from..fault.until, fault.until..over, over..f64::INFINITY].map(|part| {
        recording.rows = rows.iter().filter(|r| part.contains(&r.time)).cloned().collect();
        WeldFigures::of(recording)
    });
    let steady = WELD_FIGURES.iter().filter(|of| is_of_weld(of.figure.key));
    let limited = steady.filter_map(|of| Some((of, requirements.limit(of.figure.key)?)));
    let shares = limited.flat_map(|(of, limit)| {
        parts.iter().flatten().map(move |figures| {
            // A figure that is no number is beyond its limit.
            let value = Some((of.value)(figures)).filter(|value| value.is_finite());
            let (name, value) = (of.figure.key.to_owned(), value.unwrap_or(f64::MAX));
            LimitedFigure { name, value, limit }
        })
    });
    shares.reduce(|most, one| if one.share() > most.share() { one } else { most })
}
