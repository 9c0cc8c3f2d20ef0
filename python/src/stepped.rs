//! A weld that goes on period by period: its setting, and what changes.

use crate::law::{LawFailure, six_of, twist};
use sha2::{Digest, Sha256};
use trueweld::WeldingCell;
use trueweld::core::compensation::{Compensator, Observation};
use trueweld::core::state::{StateError, StateResult, StateVisitor, Stateful};
use trueweld::core::{Fault, Robot, Twist};
use trueweld::laws::{Entry, OwnedLaw, Uncompensated};
use trueweld::plant::controllers::ControllerKind;
use trueweld::plant::provenance::Provenance;
use trueweld::plant::simulate::{
    CellView, RecordRow, RunError, Scenario, Simulation, WeldProgram, restore_state, state_of,
};

/// First bytes of a kept state, with the version of its layout.
const STATE_HEAD: &[u8] = b"trueweld-state/2";

/// Bytes of a digest.
const DIGEST_BYTES: usize = 32;

/// Columns of a state: link angles, motor angles, link rates, motor rates.
pub(crate) const STATE_COLUMNS: usize = 24;

/// Columns of the readings: encoder angles and rates, motor torques, force, moment, seam sensor across
/// and in tilt.
pub(crate) const READING_COLUMNS: usize = 26;

/// Columns of the deviation: displacement, rotation.
pub(crate) const DEVIATION_COLUMNS: usize = 6;

/// Signals of the record of a period, each with its columns: axes of W, SI units.
pub(crate) const RECORD_SIGNALS: [(&str, usize); 10] = [
    ("time_s", 1),
    ("path_m", 1),
    ("deviation_m", 3),
    ("deviation_rad", 3),
    ("correction_m", 3),
    ("correction_rad", 3),
    ("force_n", 3),
    ("link_rad", 6),
    ("motor_rad", 6),
    ("torque_nm", 6),
];

/// Columns of all of them.
const RECORD_COLUMNS: usize = 35;

/// What a simulation is made of and never changes.
pub(crate) struct Setting {
    pub(crate) cell: WeldingCell,
    pub(crate) controller: ControllerKind,
    pub(crate) law: Entry,
    /// Longest plant step, s.
    pub(crate) plant_step: f64,
    /// What a law in Python raised.
    pub(crate) failure: LawFailure,
}

/// SHA-256 of everything that a simulation follows from, whatever the names of its files.
pub(crate) type SettingDigest = [u8; DIGEST_BYTES];

impl Setting {
    fn scenario(&self, seed: u64) -> Scenario<'_> {
        let scenario = self.cell.scenario(WeldProgram::Weld, self.controller, &self.law);
        Scenario { plant_step: self.plant_step, seed, ..scenario }
    }

    /// The law as it is before a weld; `None` where there is none but the correction.
    fn build_law(&self, seed: u64) -> Result<Option<OwnedLaw>, RunError> {
        if self.law.name() == Entry::of::<Uncompensated>().name() {
            return Ok(None);
        }
        self.scenario(seed).build_law().map(|law| Some(OwnedLaw(law)))
    }

    /// See [`SettingDigest`].
    pub(crate) fn digest(&self) -> SettingDigest {
        let laws = std::slice::from_ref(&self.law);
        let of = self.cell.simulation(&[self.controller], laws, 1, self.plant_step);
        let of = self.cell.provenance("simulation", of);
        let Provenance { version, sources, robot, effects, simulation, files, .. } = of;
        let mut digest = Sha256::new();
        digest.update(format!("{version} {sources} {robot} {effects:?} {simulation:?}"));
        for file in files {
            digest.update(format!("{} {}", file.role, file.sha256));
        }
        digest.finalize().into()
    }
}

/// A law with a correction from outside added to what it demands.
struct SteppedLaw {
    inner: Option<OwnedLaw>,
    added: Twist<f64>,
}

impl Compensator<f64> for SteppedLaw {
    fn reset(&mut self) {
        if let Some(law) = &mut self.inner {
            law.reset();
        }
    }

    fn demand(
        &mut self,
        robot: &Robot<f64>,
        observation: &Observation<'_, f64>,
    ) -> Result<Twist<f64>, Fault> {
        match &mut self.inner {
            Some(law) => Ok(law.demand(robot, observation)? + self.added),
            None => Ok(self.added),
        }
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        // What is added is told anew every period.
        self.inner.as_mut().map_or(Ok(()), |law| law.visit_state(visitor))
    }
}

impl Clone for SteppedLaw {
    /// Without the law, which is built anew: see [`SteppedWeld::begun_again`].
    fn clone(&self) -> Self {
        Self { inner: None, added: self.added }
    }
}

/// What changes.
pub(crate) struct SteppedWeld {
    /// Of the instruments' noise.
    seed: u64,
    run: Simulation<SteppedLaw>,
    /// The start of the period that comes; after the last one, of the last one.
    period: CellView,
    /// The period that is over; none before the first.
    record: Option<[f64; RECORD_COLUMNS]>,
    /// Why it cannot go on, where it cannot.
    broken: Option<String>,
}

/// The state as numbers. What the period is asked follows from its time.
impl Stateful for SteppedWeld {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.run.visit_state(visitor)?;
        visitor.scalar(&mut self.period.time)?;
        self.period.readings.visit_state(visitor)?;
        visitor.option(&mut self.record, [0.0; RECORD_COLUMNS], |visitor, record| {
            visitor.scalars(record)
        })
    }
}

impl SteppedWeld {
    pub(crate) fn begin(setting: &Setting, seed: u64) -> Result<Self, String> {
        let scenario = setting.scenario(seed);
        let failed = |error: RunError| error.to_string();
        let inner = setting.build_law(seed).map_err(failed)?;
        let law = SteppedLaw { inner, added: Twist::zero() };
        let mut run = Simulation::with_law(&scenario, law).map_err(failed)?;
        let period = run.cell.observe(&scenario);
        Ok(Self { seed, run, period, record: None, broken: None })
    }

    /// The same weld in the same period under a law that is as before its first period.
    pub(crate) fn begun_again(&self, setting: &Setting) -> Result<Self, String> {
        let inner = setting.build_law(self.seed).map_err(|error| error.to_string())?;
        let mut run = self.run.clone();
        run.law().inner = inner;
        run.law().reset();
        let (period, broken) = (self.period.clone(), self.broken.clone());
        Ok(Self { seed: self.seed, run, period, record: self.record, broken })
    }

    /// The same weld in the same period, on its own from here on.
    pub(crate) fn copied(&mut self, setting: &Setting) -> Result<Self, String> {
        let mut copy = self.begun_again(setting)?;
        if self.run.law().inner.is_some() {
            let refused = |error: StateError| error.to_string();
            copy.run.restore(&self.run.state().map_err(refused)?).map_err(refused)?;
            copy.evaluate(setting);
        }
        Ok(copy)
    }

    /// Its state in bytes, which [`restored`](Self::restored) takes in any process:
    ///
    /// ```text
    /// 16 bytes  "trueweld-state/" and the version of this layout
    /// 32 bytes  digest of cell, weld, law, options and program
    ///  8 bytes  seed
    ///  …        numbers as f64
    /// 32 bytes  SHA-256 of all before
    /// ```
    ///
    /// Integers and numbers are little-endian.
    pub(crate) fn state(&mut self, digest: &SettingDigest) -> Result<Vec<u8>, String> {
        if let Some(why) = &self.broken {
            return Err(format!("a weld that broke off has no state: {why}"));
        }
        let numbers = state_of(self).map_err(|error| error.to_string())?;
        let mut bytes = [STATE_HEAD, digest, &self.seed.to_le_bytes()].concat();
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        let seal = Sha256::digest(&bytes);
        bytes.extend(seal);
        Ok(bytes)
    }

    /// The weld in a state that [`state`](Self::state) gave of the same setting.
    pub(crate) fn restored(
        &self,
        setting: &Setting,
        digest: &SettingDigest,
        state: &[u8],
    ) -> Result<Self, String> {
        let cut = "it is cut off or damaged";
        let rest = state.strip_prefix(STATE_HEAD);
        let rest = rest.ok_or("it is of another program or version")?;
        let (of, rest) = rest.split_first_chunk::<DIGEST_BYTES>().ok_or(cut)?;
        if of != digest {
            return Err("cell, weld, law, options or the version of trueweld are others".to_owned());
        }
        let (numbers, seal) = rest.split_last_chunk::<DIGEST_BYTES>().ok_or(cut)?;
        let sealed = &state[..state.len() - seal.len()];
        if *seal != *Sha256::digest(sealed) {
            return Err(cut.to_owned());
        }
        let (seed, numbers) = numbers.split_first_chunk().ok_or(cut)?;
        let (numbers, odd) = numbers.as_chunks();
        if !odd.is_empty() {
            return Err(cut.to_owned());
        }
        let numbers: Vec<f64> = numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let seed = u64::from_le_bytes(*seed);
        let mut restored = if seed == self.seed {
            self.begun_again(setting)?
        } else {
            Self::begin(setting, seed)?
        };
        restored.broken = None;
        restore_state(&mut restored, &numbers).map_err(|error| error.to_string())?;
        restored.evaluate(setting);
        Ok(restored)
    }

    /// Makes what follows from the numbers of a state.
    fn evaluate(&mut self, setting: &Setting) {
        let CellView { time, readings, .. } = &self.period;
        self.period = self.run.cell.observed(&setting.scenario(self.seed), *time, readings.clone());
    }

    /// One period with a correction; false where the weld is over or broken.
    pub(crate) fn step(&mut self, setting: &Setting, correction: [f64; 6]) -> bool {
        if self.run.cell.is_done() || self.broken.is_some() {
            return false;
        }
        let scenario = setting.scenario(self.seed);
        self.run.law().added = twist(correction);
        self.record = Some(record_of(&self.run.control(&scenario, &self.period)));
        if let Err(diverged) = self.run.cell.advance(&scenario) {
            self.broken = Some(diverged.to_string());
            return true;
        }
        if !self.run.cell.is_done() {
            self.period = self.run.cell.observe(&scenario);
        }
        true
    }

    /// The start of the period that comes; after the last one, of the last one.
    pub(crate) fn period(&self) -> &CellView {
        &self.period
    }

    /// The period that is over, in the columns of [`RECORD_SIGNALS`]; none before the first.
    pub(crate) fn record(&self) -> Option<&[f64]> {
        self.record.as_ref().map(|record| &record[..])
    }

    /// Why the weld broke off, where it did.
    pub(crate) fn broken(&self) -> Option<&str> {
        self.broken.as_deref()
    }

    /// Periods that are over, and those of the whole weld.
    pub(crate) fn periods(&self) -> (usize, usize) {
        (self.run.cell.periods_done(), self.run.cell.periods())
    }

    /// True after the last period.
    pub(crate) fn is_done(&self) -> bool {
        self.run.cell.is_done()
    }

    pub(crate) fn drives(&self) -> [f64; STATE_COLUMNS] {
        let drives = self.run.cell.motion().state.drives();
        let parts = [drives.link, drives.motor, drives.link_rate, drives.motor_rate];
        let mut state = [0.0; STATE_COLUMNS];
        for (columns, part) in state.chunks_exact_mut(6).zip(parts) {
            columns.copy_from_slice(part.as_slice());
        }
        state
    }

    pub(crate) fn readings(&self) -> [f64; READING_COLUMNS] {
        let sensed = &self.period.readings.sensed;
        let mut readings = [f64::NAN; READING_COLUMNS];
        for (columns, part) in readings.chunks_exact_mut(6).zip([
            sensed.encoder.as_slice(),
            sensed.encoder_rate.as_slice(),
            sensed.motor_torque.as_slice(),
        ]) {
            columns.copy_from_slice(part);
        }
        readings[18..21].copy_from_slice(sensed.wrench.force.as_slice());
        readings[21..24].copy_from_slice(sensed.wrench.moment.as_slice());
        for seen in self.period.readings.measurements.iter().filter(|seen| seen.is_usable()) {
            let column = if seen.along.linear.y > 0.0 { 24 } else { 25 };
            readings[column] = seen.deviation;
        }
        readings
    }

    pub(crate) fn deviation(&self) -> [f64; DEVIATION_COLUMNS] {
        six_of(&self.period.readings.deviation_w)
    }
}

/// A period in the columns of [`RECORD_SIGNALS`].
fn record_of(row: &RecordRow) -> [f64; RECORD_COLUMNS] {
    let signals: [&[f64]; RECORD_SIGNALS.len()] = [
        &[row.time],
        &[row.path],
        row.deviation_w.linear.as_slice(),
        row.deviation_w.angular.as_slice(),
        row.correction_w.linear.as_slice(),
        row.correction_w.angular.as_slice(),
        row.force_w.as_slice(),
        row.link.as_slice(),
        row.motor.as_slice(),
        row.torque.as_slice(),
    ];
    let mut record = [0.0; RECORD_COLUMNS];
    record.iter_mut().zip(signals.into_iter().flatten()).for_each(|(to, from)| *to = *from);
    record
}
