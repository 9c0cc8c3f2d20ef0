//! Instruments that fail: what the force sensor or the seam sensor gives the controller while it is
//! faulty.
//!
//! A fault stands between an instrument and the controller. It changes what is read and nothing
//! else: the physics goes on, and so does the instrument's noise, so that two runs that differ by a
//! fault alone are the same until it begins.
//!
//! Left out: encoders (the drives' own monitoring stops the robot) and faults that the robot's bus
//! would report.

use crate::named;
use crate::random::visit_stream;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::VecDeque;
use std::fmt;
use trueweld_core::compensation::DeviationMeasurement;
use trueweld_core::control::SensorReadings;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{Twist, Wrench};

/// Its stream of random numbers, beside those of the instruments.
const FAULT_STREAM: u64 = 2;

/// Periods over which readings out of order are mixed: a quarter of a second at the usual control
/// period.
const MIXED: usize = 20;

/// Readings of one period that a state may have: more than any sensor gives.
const READINGS_MAX: usize = 1 << 10;

named! {
    /// Which instrument fails.
    pub enum Instrument {
        /// The force/torque sensor between flange and tool.
        ForceSensor = "force",
        /// The seam sensor.
        SeamSensor = "seam",
    }
}

/// How an instrument fails.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Failure {
    /// Every reading is NaN.
    Nan,
    /// Every reading is the last good one, and called fresh.
    Stuck,
    /// Every reading stands at the end of the instrument's range, with the sign that it last had.
    /// `linear`: of forces, N, or of displacements, m; `angular`: of moments, N·m, or of angles,
    /// rad.
    Saturated {
        /// Range of forces or displacements.
        linear: f64,
        /// Range of moments or angles.
        angular: f64,
    },
    /// Nothing comes. A seam sensor gives no readings; the channels of a force sensor stand at
    /// zero.
    Dropped,
    /// Old readings, any of the last quarter of a second or so, each with the age of a fresh one.
    OutOfOrder,
    /// Readings that are off by a constant: along every axis of a force sensor, in displacement and
    /// in tilt of a seam sensor. Units as in [`Failure::Saturated`].
    Offset {
        /// Of forces or displacements.
        linear: f64,
        /// Of moments or angles.
        angular: f64,
    },
    /// As [`Failure::Offset`], growing evenly from nothing to this at the end of the fault.
    Drift {
        /// Of forces or displacements.
        linear: f64,
        /// Of moments or angles.
        angular: f64,
    },
    /// Every reading is too large by this share of itself.
    Gain {
        /// The share.
        relative: f64,
    },
    /// Noise about zero and nothing else; a live reading, but of nothing. Units as in
    /// [`Failure::Saturated`].
    Noise {
        /// Standard deviation of forces or displacements.
        linear: f64,
        /// Standard deviation of moments or angles.
        angular: f64,
    },
}

/// Name in files and results of an instrument that fails in a way, as in "seam-stuck".
pub fn fault_name(instrument: Instrument, failure: Failure) -> String {
    let failure = match failure {
        Failure::Nan => "nan",
        Failure::Stuck => "stuck",
        Failure::Saturated { .. } => "saturated",
        Failure::Dropped => "dropped",
        Failure::OutOfOrder => "out-of-order",
        Failure::Offset { .. } => "offset",
        Failure::Drift { .. } => "drift",
        Failure::Gain { .. } => "gain",
        Failure::Noise { .. } => "noise",
    };
    format!("{}-{failure}", instrument.name())
}

/// One instrument that fails for a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstrumentFault {
    /// Which.
    pub instrument: Instrument,
    /// How.
    pub failure: Failure,
    /// From this time of the run, s.
    pub from: f64,
    /// Until before this time of the run, s.
    pub until: f64,
}

impl InstrumentFault {
    /// How much of the fault's time is over at a time, s: from 0 to 1.
    fn progress(&self, time: f64) -> f64 {
        (time - self.from) / (self.until - self.from)
    }

    /// True at a time, s, at which the instrument is faulty.
    pub fn is_on(&self, time: f64) -> bool {
        (self.from..self.until).contains(&time)
    }
}

impl fmt::Display for InstrumentFault {
    /// In words, without the time: "seam sensor stuck at its last value".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let instrument = self.instrument.name();
        let failure = match (self.failure, self.instrument) {
            (Failure::Nan, _) => "that gives no numbers",
            (Failure::Stuck, _) => "stuck at its last value",
            (Failure::Saturated { .. }, _) => "at the end of its range",
            (Failure::Dropped, Instrument::ForceSensor) => "dropped to zero",
            (Failure::Dropped, Instrument::SeamSensor) => "that gives nothing",
            (Failure::OutOfOrder, _) => "with readings out of order",
            (Failure::Offset { .. }, _) => "with an offset",
            (Failure::Drift { .. }, _) => "whose zero drifts",
            (Failure::Gain { .. }, _) => "whose scale is off",
            (Failure::Noise { .. }, _) => "that reads noise about zero",
        };
        write!(f, "{instrument} sensor {failure}")
    }
}

/// What the instruments give where one of them may fail.
#[derive(Debug, Clone)]
pub struct FaultyInstruments {
    fault: Option<InstrumentFault>,
    random: ChaCha8Rng,
    /// What the force sensor read, newest last.
    wrenches: VecDeque<Wrench<f64>>,
    /// What came of the seam sensor, newest last, periods without readings left out.
    measurements: VecDeque<Vec<DeviationMeasurement<f64>>>,
}

impl FaultyInstruments {
    /// Instruments of which one may fail; `seed` mixes readings that come out of order.
    pub fn new(fault: Option<InstrumentFault>, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(FAULT_STREAM);
        Self { fault, random, wrenches: VecDeque::new(), measurements: VecDeque::new() }
    }

    /// Makes of what the instruments read at `time`, s, what the controller gets. Called once a
    /// period.
    pub fn pass_on(
        &mut self,
        time: f64,
        sensed: &mut SensorReadings<f64>,
        measurements: &mut Vec<DeviationMeasurement<f64>>,
    ) {
        let Some(fault) = self.fault else { return };
        match (fault.instrument, fault.is_on(time)) {
            (Instrument::ForceSensor, true) => {
                sensed.wrench = self.wrench(&fault, time, sensed.wrench)
            }
            (Instrument::ForceSensor, false) => keep(&mut self.wrenches, sensed.wrench),
            (Instrument::SeamSensor, true) => {
                *measurements = self.sighted(&fault, time, measurements)
            }
            (Instrument::SeamSensor, false) if measurements.is_empty() => {}
            (Instrument::SeamSensor, false) => keep(&mut self.measurements, measurements.clone()),
        }
    }

    fn wrench(&mut self, fault: &InstrumentFault, time: f64, read: Wrench<f64>) -> Wrench<f64> {
        let last = self.wrenches.back().copied().unwrap_or(read);
        let all = |force: f64, moment: f64| Wrench {
            moment: Vector3::repeat(moment),
            force: Vector3::repeat(force),
        };
        let off = |linear, angular| {
            let off = all(linear, angular);
            Wrench { moment: read.moment + off.moment, force: read.force + off.force }
        };
        match fault.failure {
            Failure::Nan => all(f64::NAN, f64::NAN),
            Failure::Stuck => last,
            Failure::Saturated { linear, angular } => Wrench {
                moment: last.moment.map(|m| angular.copysign(m)),
                force: last.force.map(|f| linear.copysign(f)),
            },
            Failure::Dropped => Wrench::zero(),
            Failure::OutOfOrder => {
                keep(&mut self.wrenches, read);
                self.wrenches[self.random.random_range(0..self.wrenches.len())]
            }
            Failure::Offset { linear, angular } => off(linear, angular),
            Failure::Drift { linear, angular } => {
                let progress = fault.progress(time);
                off(progress * linear, progress * angular)
            }
            Failure::Gain { relative } => Wrench {
                moment: read.moment * (1.0 + relative),
                force: read.force * (1.0 + relative),
            },
            Failure::Noise { linear, angular } => Wrench {
                moment: Vector3::from_fn(|_, _| angular * self.normal()),
                force: Vector3::from_fn(|_, _| linear * self.normal()),
            },
        }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    fn sighted(
        &mut self,
        fault: &InstrumentFault,
        time: f64,
        read: &[DeviationMeasurement<f64>],
    ) -> Vec<DeviationMeasurement<f64>> {
        if read.is_empty() {
            return Vec::new();
        }
        let last = self.measurements.back().cloned().unwrap_or_else(|| read.to_vec());
        let told = |from: &[DeviationMeasurement<f64>],
                    value: &dyn Fn(&DeviationMeasurement<f64>) -> f64|
         -> Vec<DeviationMeasurement<f64>> {
            // What comes claims to be as fresh as readings are.
            let age = read[0].age;
            from.iter().map(|s| DeviationMeasurement { deviation: value(s), age, ..*s }).collect()
        };
        let by_kind = |s: &DeviationMeasurement<f64>, linear: f64, angular: f64| {
            if s.along.linear.norm() > 0.0 { linear } else { angular }
        };
        match fault.failure {
            Failure::Nan => told(read, &|_| f64::NAN),
            Failure::Stuck => told(&last, &|s| s.deviation),
            Failure::Saturated { linear, angular } => {
                told(&last, &|s| by_kind(s, linear, angular).copysign(s.deviation))
            }
            Failure::Dropped => Vec::new(),
            Failure::OutOfOrder => {
                keep(&mut self.measurements, read.to_vec());
                let any = &self.measurements[self.random.random_range(0..self.measurements.len())];
                told(any, &|s| s.deviation)
            }
            Failure::Offset { linear, angular } => {
                told(read, &|s| s.deviation + by_kind(s, linear, angular))
            }
            Failure::Drift { linear, angular } => {
                let progress = fault.progress(time);
                told(read, &|s| s.deviation + progress * by_kind(s, linear, angular))
            }
            Failure::Gain { relative } => told(read, &|s| s.deviation * (1.0 + relative)),
            Failure::Noise { linear, angular } => {
                let mut noisy = told(read, &|s| by_kind(s, linear, angular));
                noisy.iter_mut().for_each(|s| s.deviation *= self.normal());
                noisy
            }
        }
    }
}

impl Stateful for FaultyInstruments {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visit_stream(&mut self.random, visitor)?;
        let length = visitor.length(self.wrenches.len(), MIXED)?;
        self.wrenches.resize(length, Wrench::zero());
        self.wrenches.iter_mut().try_for_each(|wrench| visitor.wrench(wrench))?;
        let length = visitor.length(self.measurements.len(), MIXED)?;
        self.measurements.resize(length, Vec::new());
        self.measurements.iter_mut().try_for_each(|read| visit_measurements(read, visitor))
    }
}

/// Shows the measurements of one period.
pub(crate) fn visit_measurements(
    read: &mut Vec<DeviationMeasurement<f64>>,
    visitor: &mut dyn StateVisitor,
) -> StateResult {
    let blank = DeviationMeasurement {
        deviation: 0.0,
        along: Twist::zero(),
        noise: 0.0,
        age: 0.0,
        ahead: 0.0,
    };
    let length = visitor.length(read.len(), READINGS_MAX)?;
    read.resize(length, blank);
    for m in read {
        let DeviationMeasurement { deviation, along, noise, age, ahead } = m;
        visitor.twist(along)?;
        visitor.scalars([deviation, noise, age, ahead])?;
    }
    Ok(())
}

fn keep<T>(past: &mut VecDeque<T>, read: T) {
    if past.len() == MIXED {
        past.pop_front();
    }
    past.push_back(read);
}
