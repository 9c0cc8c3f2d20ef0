//! What is not known of a cell, number by number: `[[uncertain]]` of the requirements.
//!
//! An uncertain number is a parameter of an effect of the library at a place, a number of the
//! process or the sensors, or where the seam really lies. Behind the numbers stand independent
//! standard normals, the latents: z = Σ w ξ of a number's latents is standard normal, and the number
//! is the quantile of its distribution at Φ(z). Numbers of one group share a latent; the joint
//! distribution of measured numbers ([`UncertainCell::measured`]) is the rows of a factor of its
//! correlation matrix as weights. What was measured stands in place of what was assumed.
//! A search and a method for rare failures walk over the latents.
//!
//! Left out: what is not a number, such as which effect a cell has.
mod distribution;
mod entry;

pub use distribution::Distribution;
pub(crate) use entry::SEAM_KEYS;
pub use entry::{Group, UncertainEntry};

use distribution::CUT;
use entry::{Subject, places, within_range};
use nalgebra::{DMatrix, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_core::{JOINTS, Robot};
use trueweld_plant::effects::{
    Action, Effect, EffectKind, Location, force_crosstalk, library, stiffness_error,
};
use trueweld_plant::input::{MeasuredNumber, Posterior, Process, RobotFile, Sensors};
use trueweld_plant::process::ProcessKind;
use trueweld_plant::random::Random;
use trueweld_plant::robot::{Channel, Port};
use trueweld_plant::seam::Seam;
use trueweld_plant::sensors::sensor_numbers;

/// What is not known of a cell, in short: half widths of uniform distributions about the nominal
/// value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// Of every joint's stiffness, relative.
    pub stiffness: f64,
    /// Of every gain of the process, relative.
    pub process: f64,
    /// Of the amplitude of the spindle's ripple, relative; its phases are anything.
    pub ripple: f64,
    /// Of the force across the tool that the sensor shows per axial force, each axis.
    pub crosstalk: f64,
    /// Least and most delay of the force sensor and the seam sensor, control periods.
    pub delay: [f64; 2],
}

/// An uncertain number of a cell.
#[derive(Debug, Clone)]
pub struct UncertainNumber {
    /// What it is, as in `joint-friction at A2: coulomb_nm` or `sensor force.zero_nm 1`.
    pub name: String,
    /// Its unit; "1" for a share.
    pub unit: &'static str,
    /// Whether it is a share of the number that the cell's files state.
    pub relative: bool,
    /// How it is distributed.
    pub distribution: Distribution,
    /// What it is uncertain with.
    pub group: Option<Group>,
    /// Who assumed it; empty of a measured number.
    pub source: String,
    /// Where it was measured: which of the effects of its kind at its place it is of, from 0. Its
    /// value stands in place of the cell's then, and not beside it.
    measured: Option<usize>,
    subject: Subject,
    /// Of an effect.
    at: Location,
    /// Of a key with several numbers: which.
    component: usize,
    /// Latents and their weights, whose squares sum to 1.
    weights: Vec<(usize, f64)>,
}

/// What requirements assume of a number that was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReplacedAssumption {
    /// The number.
    pub number: String,
    /// Whether the distribution is one of shares.
    pub relative: bool,
    /// What was assumed of it.
    pub distribution: Distribution,
    /// Who assumed it.
    pub source: String,
}

/// An uncertain number that the cell does not have.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}: {why}")]
pub struct NoSuchNumber {
    /// `file:line:column` of the requirements.
    pub place: String,
    /// What is wrong.
    pub why: String,
}

/// All that is not known of one cell.
#[derive(Debug, Clone)]
pub struct UncertainCell {
    /// The short keys, `[uncertainty]`.
    pub short: Uncertainty,
    /// The numbers of `[[uncertain]]`, in the file's order.
    pub numbers: Vec<UncertainNumber>,
    /// What was measured; `None` where all is assumed.
    pub posterior: Option<Posterior>,
    /// What the requirements assume of numbers that were measured.
    pub replaced: Vec<ReplacedAssumption>,
    /// Names of the joints whose stiffness is drawn by the short key.
    pub assumed_stiffness: Vec<String>,
    /// True for a joint whose stiffness was measured.
    measured_stiffness: [bool; JOINTS],
    /// Keys of the process' numbers that were measured.
    measured_process: Vec<&'static str>,
    /// Names of the latents.
    latents: Vec<String>,
    left_out: Vec<String>,
}

impl UncertainCell {
    /// Half width of the uniform distribution of a joint's stiffness, relative, by the short key.
    pub(crate) fn stiffness(&self, joint: usize) -> f64 {
        if self.measured_stiffness[joint] { 0.0 } else { self.short.stiffness }
    }

    /// The same cell where this was measured: jointly, and in place of what was assumed.
    ///
    /// # Errors
    /// Why the covariance is none.
    pub fn measured(
        mut self,
        posterior: &Posterior,
        robot: &RobotFile,
        process: &Process,
        sensors: &Sensors,
    ) -> Result<Self, String> {
        let rows = factor(posterior)?;
        let (mut process, mut sensors) = (process.clone(), sensors.clone());
        for number in &posterior.numbers {
            self.replace(number, robot, &mut process);
        }
        let mut named: Vec<String> = Vec::new();
        for (k, (number, row)) in posterior.numbers.iter().zip(rows).enumerate() {
            let parameter = &number.kind.parameters[number.parameter];
            let effect = number.effect().name(robot);
            let name = match number.occurrence {
                0 => format!("{effect}: {}", parameter.name),
                n => format!("{effect}, number {}: {}", n + 1, parameter.name),
            };
            let sd = posterior.deviation(k).hypot(number.between_logs);
            let distribution = if sd > 0.0 {
                let end = |x: f64| {
                    if parameter.holds(x) { x } else { x.clamp(parameter.low, parameter.high) }
                };
                let [low, high] = [-CUT, CUT].map(|cut| end(number.value + cut * sd));
                Distribution::Normal { mean: number.value, sd, low, high }
            } else {
                Distribution::Fixed { value: number.value }
            };
            named.push(format!("measured {name}"));
            let weights: Vec<(usize, f64)> = row
                .into_iter()
                .enumerate()
                .filter(|(_, weight)| *weight != 0.0)
                .map(|(i, weight)| (self.latent(&named[i]), weight))
                .collect();
            self.numbers.push(UncertainNumber {
                name,
                unit: parameter.unit,
                relative: false,
                distribution,
                group: None,
                source: String::new(),
                measured: Some(number.occurrence),
                subject: Subject::Effect(number.kind, number.parameter),
                at: number.at,
                component: 0,
                weights,
            });
        }
        self.forget_unused();
        let names = robot.joint_names.iter().zip(self.measured_stiffness);
        self.assumed_stiffness =
            names.filter(|(_, measured)| !measured).map(|(name, _)| name.clone()).collect();
        self.posterior = Some(posterior.clone());
        self.left_out = self.not_drawn(robot, &mut process, &mut sensors);
        Ok(self)
    }

    /// Takes out what is assumed of a number that was measured.
    fn replace(&mut self, number: &MeasuredNumber, robot: &RobotFile, process: &mut Process) {
        let changed = match number.kind.action {
            Action::Process(change) => renamed(process, change, number.kind, number.parameter),
            _ => Vec::new(),
        };
        let same = |n: &mut UncertainNumber| n.is_replaced(number, &changed);
        let replaced = self.numbers.extract_if(.., same).map(|n| ReplacedAssumption {
            number: n.name,
            relative: n.relative,
            distribution: n.distribution,
            source: n.source,
        });
        self.replaced.extend(replaced.collect::<Vec<_>>());
        if let Location::Joint(joint) = number.at
            && std::ptr::eq(number.kind, stiffness_error::effect(joint, 0.0).kind)
            && !self.measured_stiffness[joint]
        {
            let name = format!("stiffness of {}", robot.joint_names[joint]);
            self.replace_short(name, self.short.stiffness);
            self.measured_stiffness[joint] = true;
        }
        for key in changed {
            if process.kind().draws(key) && !self.measured_process.contains(&key) {
                self.replace_short(format!("process {key}"), self.short.process);
            }
            self.measured_process.push(key);
        }
    }

    /// Notes that a number of the short form, drawn evenly by up to a share `half`, was measured.
    fn replace_short(&mut self, number: String, half: f64) {
        if half > 0.0 {
            self.replaced.push(ReplacedAssumption {
                number,
                relative: true,
                distribution: Distribution::Uniform { low: -half, high: half },
                source: SHORT_SOURCE.to_owned(),
            });
        }
    }

    /// Takes out latents that no number stands on any more.
    fn forget_unused(&mut self) {
        let used = |k: usize| self.numbers.iter().any(|n| n.weights.iter().any(|w| w.0 == k));
        let kept: Vec<usize> = (0..self.latents.len()).filter(|k| used(*k)).collect();
        let position = |k: usize| kept.iter().position(|old| *old == k).unwrap_or(0);
        for (k, _) in self.numbers.iter_mut().flat_map(|n| &mut n.weights) {
            *k = position(*k);
        }
        self.latents = kept.iter().map(|k| self.latents[*k].clone()).collect();
    }

    /// What entries say of a cell of this robot, process and these sensors.
    ///
    /// # Errors
    /// [`NoSuchNumber`].
    pub fn of(
        short: &Uncertainty,
        entries: &[UncertainEntry],
        robot: &RobotFile,
        process: &Process,
        sensors: &Sensors,
    ) -> Result<Self, NoSuchNumber> {
        let mut cell = Self {
            short: *short,
            numbers: Vec::new(),
            posterior: None,
            replaced: Vec::new(),
            assumed_stiffness: robot.joint_names.to_vec(),
            measured_stiffness: [false; JOINTS],
            measured_process: Vec::new(),
            latents: Vec::new(),
            left_out: Vec::new(),
        };
        let (mut process, mut sensors) = (process.clone(), sensors.clone());
        for entry in entries {
            let wrong = |why: String| NoSuchNumber { place: entry.place.clone(), why };
            for (name, at, component) in
                places(entry, robot, &mut process, &mut sensors).map_err(&wrong)?
            {
                if cell.numbers.iter().any(|number| number.name == name) {
                    return Err(wrong(format!("{name} is drawn twice; expected each number once")));
                }
                within_range(entry, at, robot).map_err(|why| wrong(format!("{name}: {why}")))?;
                let weights = cell.weights(&name, entry.group.as_ref()).map_err(&wrong)?;
                cell.numbers.push(UncertainNumber {
                    name,
                    unit: entry.unit(),
                    relative: entry.relative,
                    distribution: entry.distribution,
                    group: entry.group.clone(),
                    source: entry.source.clone(),
                    measured: None,
                    subject: entry.subject,
                    at,
                    component,
                    weights,
                });
            }
        }
        cell.left_out = cell.not_drawn(robot, &mut process, &mut sensors);
        Ok(cell)
    }

    /// The latent of a name, a new one where there is none yet.
    fn latent(&mut self, name: &str) -> usize {
        self.latents.iter().position(|known| known == name).unwrap_or_else(|| {
            self.latents.push(name.to_owned());
            self.latents.len() - 1
        })
    }

    /// The latents of a number with their weights: its own, or its share in those of a group.
    fn weights(&mut self, name: &str, group: Option<&Group>) -> Result<Vec<(usize, f64)>, String> {
        let Some(Group { name: of, correlation }) = group else {
            return Ok(vec![(self.latent(name), 1.0)]);
        };
        let mut others = self.numbers.iter().filter_map(|number| number.group.as_ref());
        if let Some(other) = others.find(|g| g.name == *of && g.correlation != *correlation) {
            return Err(format!(
                "the correlation of the group {of} is {correlation} here and {} before; expected one",
                other.correlation
            ));
        }
        let shared = (self.latent(&format!("group {of}")), correlation.sqrt());
        Ok(match 1.0 - correlation {
            0.0 => vec![shared],
            rest => vec![shared, (self.latent(name), rest.sqrt())],
        })
    }

    /// True where all cells that are drawn are one but for phase and noise: nothing is uncertain.
    pub fn is_one_cell(&self) -> bool {
        let Uncertainty { stiffness, process, ripple, crosstalk, delay } = self.short;
        let short = [stiffness, process, ripple, crosstalk, delay[1] - delay[0]];
        self.numbers.is_empty() && short.iter().all(|half| *half == 0.0)
    }

    /// How many latents there are.
    pub fn latents(&self) -> usize {
        self.latents.len()
    }

    /// What the latents are of: a number, or a group of them.
    pub fn latent_names(&self) -> &[String] {
        &self.latents
    }

    /// The latents of a trial. Each has a stream of its own: a number more or less in the file
    /// leaves the others as they were.
    pub fn draw(&self, seed: u64, index: u64) -> Vec<f64> {
        // FNV-1a.
        let hash = |name: &str| {
            name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
            })
        };
        self.latents.iter().map(|name| Random::new(seed ^ hash(name), index).normal()).collect()
    }

    /// The numbers at latents; none where there are no latents, as in the nominal cell.
    pub fn values(&self, latents: &[f64]) -> Vec<f64> {
        if latents.is_empty() {
            return Vec::new();
        }
        let value = |number: &UncertainNumber| {
            let z = number.weights.iter().map(|(k, weight)| weight * latents[*k]).sum();
            number.distribution.value(z)
        };
        self.numbers.iter().map(value).collect()
    }

    /// The effects of a cell of this robot with these values: its own, of which the measured ones have
    /// the values measured, and beside them those that are assumed.
    pub(crate) fn effects(
        &self,
        own: &[Effect],
        values: &[f64],
        robot: &Robot<f64>,
    ) -> Vec<Effect> {
        let mut effects: Vec<Effect> = own.to_vec();
        let drawn = || self.numbers.iter().zip(values);
        for (number, value) in drawn().filter(|(number, _)| number.measured.is_some()) {
            let Subject::Effect(kind, parameter) = number.subject else { continue };
            let k = index_of(&mut effects, 0, number, kind);
            effects[k].values[parameter] = *value;
        }
        let beside = effects.len();
        for (number, value) in drawn().filter(|(number, _)| number.measured.is_none()) {
            let Subject::Effect(kind, parameter) = number.subject else { continue };
            let k = index_of(&mut effects, beside, number, kind);
            let own = kind.own(parameter, number.at, robot.parameters());
            let own = own.filter(|_| number.relative).unwrap_or(1.0);
            effects[k].values[parameter] = value * own;
        }
        effects
    }

    /// Puts into a process what was drawn of it. `planned`: what its measured numbers are as the
    /// effects that they were measured by find them.
    pub(crate) fn change_process(&self, values: &[f64], planned: &Process, process: &mut Process) {
        let mut planned = planned.clone();
        for key in &self.measured_process {
            let own = planned.numbers(key).into_iter().map(|v| *v).collect::<Vec<_>>();
            process.numbers(key).into_iter().zip(own).for_each(|(drawn, own)| *drawn = own);
        }
        for (number, value) in self.numbers.iter().zip(values) {
            if let Subject::Process(key) = number.subject {
                number.change(process.numbers(key), *value);
            }
        }
    }

    pub(crate) fn change_sensors(&self, values: &[f64], sensors: &mut Sensors) {
        for (number, value) in self.numbers.iter().zip(values) {
            if let Subject::Sensor(k) = number.subject {
                number.change((sensor_numbers()[k].1)(sensors), *value);
            }
        }
    }

    /// Where the seam really lies that was taught at this frame.
    pub(crate) fn seam(&self, values: &[f64], real: Seam) -> Seam {
        let mut off = [0.0; 6];
        for (number, value) in self.numbers.iter().zip(values) {
            if let Subject::Seam(k) = number.subject {
                off[k] = *value;
            }
        }
        if off == [0.0; 6] {
            return real;
        }
        let by = trueweld_core::Twist {
            angular: Vector3::new(off[3], off[4], off[5]),
            linear: Vector3::new(off[0], off[1], off[2]),
        };
        real.displaced(&by)
    }

    /// What is taken as known although it might not be: effects of the library that the weld would
    /// show and nothing draws, and numbers of the files.
    pub fn left_out(&self) -> &[String] {
        &self.left_out
    }

    /// True for a number of the process that is drawn or was measured.
    fn draws_process(&self, of: &ProcessKind, key: &'static str) -> bool {
        let of_short = match key {
            _ if of.draws(key) => self.short.process > 0.0,
            "ripple.axial" | "ripple.in_plane" => self.short.ripple > 0.0,
            "ripple.phase_rad" => true,
            _ => false,
        };
        of_short
            || self.measured_process.contains(&key)
            || self.numbers.iter().any(|n| matches!(n.subject, Subject::Process(is) if is == key))
    }

    fn not_drawn(
        &self,
        robot: &RobotFile,
        process: &mut Process,
        sensors: &mut Sensors,
    ) -> Vec<String> {
        let (short, of) = (&self.short, process.kind());
        let mut left = Vec::new();
        for kind in library().filter(|kind| !kind.is_of_open_file()) {
            if let Action::Process(change) = kind.action {
                // An effect that is another name for numbers of the process.
                let mut renamed: Vec<&'static str> = Vec::new();
                for parameter in 0..kind.parameters.len() {
                    renamed.extend(self::renamed(process, change, kind, parameter));
                }
                if !renamed.is_empty() && renamed.into_iter().all(|key| self.draws_process(of, key))
                {
                    continue;
                }
            }
            let of_short = std::ptr::eq(kind, stiffness_error::effect(0, 0.0).kind)
                && short.stiffness > 0.0
                || std::ptr::eq(kind, force_crosstalk::effect([0.0; 2]).kind)
                    && short.crosstalk > 0.0;
            if of_short {
                continue;
            }
            let drawn = |at: Location, parameter: usize| {
                self.numbers.iter().any(|n| {
                    n.at == at
                        && matches!(n.subject, Subject::Effect(of, p)
                            if std::ptr::eq(of, kind) && p == parameter)
                })
            };
            let sizes = || (0..kind.parameters.len()).filter(|k| kind.parameters[*k].is_size());
            let places: Vec<Location> =
                kind.places().into_iter().filter(|at| is_seen(kind, *at)).collect();
            let all = |parameter| places.iter().any(|at| drawn(*at, parameter));
            if !places.is_empty() && !(0..kind.parameters.len()).any(all) {
                left.push(kind.id.to_owned());
                continue;
            }
            for parameter in sizes() {
                let not: Vec<Location> =
                    places.iter().copied().filter(|at| !drawn(*at, parameter)).collect();
                if not.is_empty() {
                    continue;
                }
                let mut what = kind.id.to_owned();
                if not.len() < places.len() {
                    let at = |at: &Location| at.name(robot).to_owned();
                    what += &format!(" at {}", not.iter().map(at).collect::<Vec<_>>().join(", "));
                }
                if sizes().count() > 1 {
                    what += &format!(": {}", kind.parameters[parameter].name);
                }
                left.push(what);
            }
        }
        for key in of.keys.iter().copied().filter(|key| !self.draws_process(of, key)) {
            if !process.numbers(key).is_empty() {
                left.push(format!("process {key}"));
            }
        }
        for (k, (key, of)) in sensor_numbers().iter().enumerate() {
            let drawn = |n: &UncertainNumber| matches!(n.subject, Subject::Sensor(i) if i == k);
            let of_short = key.ends_with(".delay_s") && short.delay[1] > 0.0;
            if !of_short && !of(sensors).is_empty() && !self.numbers.iter().any(drawn) {
                left.push(format!("sensor {key}"));
            }
        }
        for (k, key) in SEAM_KEYS.iter().enumerate() {
            let drawn = |n: &UncertainNumber| matches!(n.subject, Subject::Seam(i) if i == k);
            if !self.numbers.iter().any(drawn) {
                left.push(format!("seam {key}"));
            }
        }
        left
    }
}

/// Source of what the short keys draw.
pub const SHORT_SOURCE: &str = "[uncertainty] of the requirements";

/// Keys of the process' numbers that a parameter of an effect changes.
fn renamed(
    process: &mut Process,
    change: fn(&mut Process, &[f64]),
    kind: &EffectKind,
    parameter: usize,
) -> Vec<&'static str> {
    let mut changed = process.clone();
    let mut values: Vec<f64> = kind.parameters.iter().map(|p| p.neutral()).collect();
    values[parameter] += 0.01;
    change(&mut changed, &values);
    // One more line of the ripple is no other value of those that there are.
    if changed.ripple.len() != process.ripple.len() {
        return Vec::new();
    }
    let of = |p: &mut Process, key: &str| -> Vec<f64> {
        p.numbers(key).into_iter().map(|v| *v).collect()
    };
    let keys = process.kind().keys.iter().copied();
    keys.filter(|key| of(&mut changed, key) != of(process, key)).collect()
}

/// Rows of a factor L of the correlation of measured numbers in a cell that is yet to be met, each
/// of length 1: what they vary by from log to log is each number's own.
fn factor(posterior: &Posterior) -> Result<Vec<Vec<f64>>, String> {
    let n = posterior.numbers.len();
    let variance =
        |k: usize| posterior.covariance_of(k, k) + posterior.numbers[k].between_logs.powi(2);
    let correlation = DMatrix::from_fn(n, n, |i, j| {
        let scale = (variance(i) * variance(j)).sqrt();
        // Numbers that go together to the last digit leave a factor by a hair.
        let own = if i == j { 1.0 + 1e-9 } else { 0.0 };
        if i == j || scale == 0.0 { own } else { posterior.covariance_of(i, j) / scale }
    });
    let factor = correlation
        .cholesky()
        .ok_or("the covariance of [posterior] is none: a combination of numbers has a variance below zero")?
        .unpack();
    let unit = |i: usize| {
        let row: Vec<f64> = factor.row(i).iter().take(i + 1).copied().collect();
        let length = row.iter().map(|w| w * w).sum::<f64>().sqrt();
        row.into_iter().map(|w| w / length).collect()
    };
    Ok((0..n).map(unit).collect())
}

/// False for an effect of an instrument that the controller does not read.
fn is_seen(kind: &'static EffectKind, at: Location) -> bool {
    let channel = match (at, kind.neutral(at).port()) {
        (Location::Channel(channel), _) | (_, Some(Port::SensorChannel(channel))) => channel,
        _ => return true,
    };
    matches!(channel, Channel::Wrench | Channel::MotorTorque)
}

/// Index of the effect that a number is of, among those from `from` on; added where it is missing.
fn index_of(
    effects: &mut Vec<Effect>,
    from: usize,
    number: &UncertainNumber,
    kind: &'static EffectKind,
) -> usize {
    let same = |e: &(usize, &Effect)| std::ptr::eq(e.1.kind, kind) && e.1.at == number.at;
    let mut all = effects.iter().enumerate().skip(from).filter(same);
    let found = all.nth(number.measured.unwrap_or(0)).map(|(k, _)| k);
    found.unwrap_or_else(|| {
        effects.push(kind.neutral(number.at));
        effects.len() - 1
    })
}

impl UncertainNumber {
    /// True for a number that was measured, jointly with all others that were.
    pub fn is_measured(&self) -> bool {
        self.measured.is_some()
    }

    /// True for one that was assumed, in place of which a number was measured. `changed`: the
    /// numbers of the process that this one changes.
    fn is_replaced(&self, by: &MeasuredNumber, changed: &[&str]) -> bool {
        match self.subject {
            _ if self.is_measured() => false,
            Subject::Effect(kind, parameter) => {
                std::ptr::eq(kind, by.kind) && (self.at, parameter) == (by.at, by.parameter)
            }
            Subject::Process(key) => changed.contains(&key),
            Subject::Sensor(_) | Subject::Seam(_) => false,
        }
    }

    fn change(&self, numbers: Vec<&mut f64>, value: f64) {
        if let Some(number) = numbers.into_iter().nth(self.component) {
            *number = if self.relative { *number * (1.0 + value) } else { value };
        }
    }
}
