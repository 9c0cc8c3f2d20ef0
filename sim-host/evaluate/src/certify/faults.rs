//! Fault cases: the nominal cell, one instrument failing in the steady part of its weld and coming
//! back.
//!
//! Asked of every case: the correction stays within what the requirements allow, the tool stays
//! bounded while the fault lasts and until it must be over it, and then it keeps to the limits of
//! the steady part again.

use super::{Certification, FigureValues, SampledCell, Symptoms, figure_of, values};
use crate::figure::FigureOf;
use crate::requirements::{Faults, Requirements};
use crate::weld::Spread;
use serde::{Deserialize, Serialize};
use trueweld_plant::sensors::{Failure, Instrument, InstrumentFault};
use trueweld_plant::simulate::{Phase, RecordRow, Recording, Scenario, Seam};

/// A run with a fault of which nothing is asked.
#[derive(Debug, thiserror::Error)]
#[error("no requirement asks for faults")]
struct NotAsked;

/// Where in the steady part a fault begins, as a share of it.
const BEGINS: f64 = 0.4;

/// Longest plant step where the force sensor fails, s. A force loop that is lied to may lift the
/// tool off and let it hit the plate; at 1 ms such a blow throws the simulated arm by a metre,
/// at 0.25 ms it ends as at 0.05 ms, within 0.01 mm.
const BLOW_STEP: f64 = 2.5e-4;

/// Share of a weld's time that its plant steps take: a fault case of the force sensor, with eight
/// times as many, takes three times as long.
const PLANT_SHARE: f64 = 0.3;

/// Least time after recovery over which it is judged, s.
const JUDGED: f64 = 1.0;

/// Figures of a fault case: the largest correction of the whole run; while the fault lasts and until
/// the tool must be over it, how far it leaves its line, and how far depth goes from its mean before;
/// after that the steady figures again.
pub static FAULT_FIGURES: [FigureOf<FaultSpreads>; 7] = [
    FigureOf::new("correction_m", "correction, translation", "m", |f| f.correction[0]),
    FigureOf::new("correction_rad", "correction, rotation", "rad", |f| f.correction[1]),
    FigureOf::new(LATERAL, "lateral in the fault, largest", "m", |f| f.lateral_during.max_abs),
    FigureOf::new(DEPTH, "depth in the fault, largest change", "m", |f| f.depth_during.max_abs),
    FigureOf::new("recovered_lateral_rms_m", "lateral after recovery, RMS", "m", |f| {
        f.lateral_after.rms
    }),
    FigureOf::new("recovered_lateral_max_m", "lateral after recovery, largest", "m", |f| {
        f.lateral_after.max_abs
    }),
    FigureOf::new(
        "recovered_push_error_rms_n",
        "push after recovery, RMS of its error",
        "N",
        |f| f.push_error_after.rms,
    ),
];

/// Keys of the figures that have limits of their own.
const LATERAL: &str = "fault_lateral_max_m";
const DEPTH: &str = "fault_depth_max_m";

/// The most that a figure of a fault case may be, SI units; after recovery that of the steady part.
/// `None` where nothing limits it.
pub(super) fn limit(key: &str, requirements: &Requirements, asked: &Faults) -> Option<f64> {
    match key {
        LATERAL => Some(asked.lateral),
        DEPTH => asked.depth,
        key => requirements.limit(key.strip_prefix("recovered_").unwrap_or(key)),
    }
}

/// What a run with a fault came to, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultSpreads {
    correction: [f64; 2],
    lateral_during: Spread,
    depth_during: Spread,
    lateral_after: Spread,
    push_error_after: Spread,
}

/// What one fault did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FaultTrial {
    /// The fault in words, as in "seam sensor stuck at its last value".
    pub fault: String,
    /// When it began and ended, s.
    pub time: [f64; 2],
    /// [`FAULT_FIGURES`]; `None` where the run came to no end.
    pub figures: Option<FigureValues>,
    /// How the loop behaved over the whole steady part.
    pub symptoms: Option<Symptoms>,
    /// Why there are no figures.
    pub failed: Option<String>,
}

impl FaultTrial {
    /// A figure by its key; infinite where the run came to no end, or to no number.
    pub fn figure(&self, key: &str) -> f64 {
        figure_of(self.figures.as_ref(), key)
    }
}

/// A seam too short for a fault and the recovery from it.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the steady part of the weld lasts {has:.1} s; expected at least {needs:.1} s for the fault cases, which begin at 40 % of it, last \
     as long as [faults] says, and are judged for a second after the recovery"
)]
pub struct SteadyTooShort {
    /// How long it is, s.
    pub has: f64,
    /// How long it must be, s.
    pub needs: f64,
}

impl Certification<'_> {
    /// The fault cases of this weld, none where the requirements ask for none: every failure of the
    /// force sensor, and of the seam sensor where the cell has one.
    ///
    /// # Errors
    /// [`SteadyTooShort`].
    pub fn faults(&self) -> Result<Vec<InstrumentFault>, SteadyTooShort> {
        let Some(asked) = &self.requirements.faults else {
            return Ok(Vec::new());
        };
        let scenario = &self.scenario;
        let steady =
            scenario.program.steady(scenario.weld, &Seam::of(scenario.weld)).unwrap_or([0.0; 2]);
        let has = steady[1] - steady[0];
        let needs = (asked.duration + asked.recovery + JUDGED) / (1.0 - BEGINS);
        if has < needs {
            return Err(SteadyTooShort { has, needs });
        }
        let from = steady[0] + BEGINS * has;
        let at = |(instrument, failure)| InstrumentFault {
            instrument,
            failure,
            from,
            until: from + asked.duration,
        };
        let force = failures(asked.force_range).map(|failure| (Instrument::ForceSensor, failure));
        let [linear, angular] = asked.seam_offset;
        let lies = Failure::Offset { linear, angular };
        let seam = failures(asked.seam_range)
            .into_iter()
            .chain([lies])
            .map(|failure| (Instrument::SeamSensor, failure));
        let seen = scenario.sensors.seam.is_some();
        Ok(force.into_iter().chain(seam.filter(|_| seen)).map(at).collect())
    }

    fn plant_step(&self, fault: &InstrumentFault) -> f64 {
        match fault.instrument {
            Instrument::ForceSensor => self.scenario.plant_step.min(BLOW_STEP),
            Instrument::SeamSensor => self.scenario.plant_step,
        }
    }

    /// Time that a fault case takes over that of a weld without a fault, about.
    pub fn cost(&self, fault: &InstrumentFault) -> f64 {
        let steps = self.scenario.plant_step / self.plant_step(fault);
        1.0 + PLANT_SHARE * (steps - 1.0)
    }

    /// Runs one fault case.
    pub fn run_fault(&self, fault: &InstrumentFault) -> FaultTrial {
        let draw = SampledCell::nominal(self.scenario.seed);
        let plant_step = self.plant_step(fault);
        let scenario = Scenario { plant_step, fault: Some(*fault), ..self.scenario };
        let recording = self.cell.weld(&scenario, &draw, self.passes);
        let (figures, symptoms, failed) = match (&recording, &self.requirements.faults) {
            (Ok(recording), Some(asked)) => (
                Some(FaultSpreads::of(recording, fault, asked).values()),
                Some(self.symptoms(recording)),
                None,
            ),
            (Ok(_), None) => (None, None, Some(NotAsked.to_string())),
            (Err(error), _) => (None, None, Some(error.to_string())),
        };
        FaultTrial {
            fault: fault.to_string(),
            time: [fault.from, fault.until],
            figures,
            symptoms,
            failed,
        }
    }
}

fn failures([linear, angular]: [f64; 2]) -> [Failure; 5] {
    let saturated = Failure::Saturated { linear, angular };
    [Failure::Nan, Failure::Stuck, saturated, Failure::Dropped, Failure::OutOfOrder]
}

impl FaultSpreads {
    fn of(recording: &Recording, fault: &InstrumentFault, asked: &Faults) -> Self {
        let rows = || recording.rows.iter();
        let steady = || rows().filter(|r| r.phase == Phase::Steady);
        let over = fault.until + asked.recovery;
        let before = steady().filter(|r| r.time < fault.from).map(|r| r.deviation_w.linear.z);
        let before = Spread::of(before).mean;
        let during = || rows().filter(|r| (fault.from..over).contains(&r.time));
        let after =
            |of: fn(&RecordRow) -> f64| Spread::of(steady().filter(|r| r.time >= over).map(of));
        Self {
            correction: [
                Spread::of(rows().map(|r| r.correction_w.linear.norm())).max_abs,
                Spread::of(rows().map(|r| r.correction_w.angular.norm())).max_abs,
            ],
            lateral_during: Spread::of(during().map(|r| r.deviation_w.linear.y)),
            depth_during: Spread::of(during().map(|r| r.deviation_w.linear.z - before)),
            lateral_after: after(|r| r.deviation_w.linear.y),
            push_error_after: after(|r| -r.force_w.z - r.force_desired.unwrap_or(0.0)),
        }
    }

    fn values(&self) -> FigureValues {
        values(FAULT_FIGURES.iter(), self)
    }
}
