//! What the model says the instruments should have read: the plant driven by a log.
//!
//! One way a kind of log, each in the band in which its data carry information:
//!
//! | log | driven by | predicted | how |
//! |---|---|---|---|
//! | static-load | encoders, wrench, payload | tracker pose | links standing under their load, row after row |
//! | ring-down | encoders | tracker position, second encoders | links swinging, at the log's own rate |
//! | free-motion | encoders | motor torque, tracker pose, second encoders | links swinging; torque below 8 Hz |
//! | weld | encoders, wrench | tracker pose | links standing, below 2 Hz |
//! | weld | tracker pose, spindle | wrench | the process under the tool: slowly, and at the spindle's orders |
//!
//! Every residual is measured less predicted, over the standard deviation of measured and
//! propagated noise together: a perfect model has residuals of mean square 1.

mod accuracy;
mod clock;
mod columns;
mod compared;
mod contact;
mod instruments;
mod memory;
mod moving;
mod play;
mod reach;
mod standing;
mod wiener;

pub(crate) use columns::period;
pub(crate) use columns::{filled, filled_vectors};
pub use compared::{Compared, ComparedQuantity};
pub(crate) use contact::Folded;
pub use memory::{StartFit, StartState};
pub use moving::SwingGain;
pub(crate) use standing::with_payload;

use clock::{Late, OpenClock};
use instruments::TrackedPoint;
use nalgebra::Vector3;
use std::borrow::Cow;
use std::sync::Arc;
use trueweld_core::{JOINTS, JointVector, Pose, Robot};
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::noise::{NoiseLevel, NoiseLevels};
use trueweld_plant::effects::{CalibrationScope, Effect, EffectError, EffectKind, Location};
use trueweld_plant::input::{Accuracy, ModelFile, Process};
use trueweld_plant::integrate::TooFast;
use trueweld_plant::robot::{Channel, ElasticRobot, INTERNAL_STATES, Memory, mount};

/// Angle of a joint by which one posture is another, rad.
pub(crate) const ANOTHER_POSTURE: f64 = 0.1;

/// The model that logs are compared with, before effects.
#[derive(Debug, Clone)]
pub struct BaselineModel {
    /// The robot.
    pub robot: Robot<f64>,
    /// The process; a weld log's own stands in where the model names none.
    pub process: Option<Process>,
    /// How exact predictions need be, where a log's campaign says nothing of it.
    pub accuracy: Accuracy,
    /// Torque of one unit of a joint's recorded current, N·m, where the model states it.
    pub torque_constants: [Option<f64>; JOINTS],
    /// Joints whose drives are stated to be rigid.
    pub rigid: [bool; JOINTS],
    /// Joints whose rotor inertia is stated to be unknown.
    pub unknown_rotor: [bool; JOINTS],
}

/// The baseline that a model file stands on.
pub fn baseline(model: &ModelFile) -> BaselineModel {
    BaselineModel {
        robot: model.robot.robot.clone(),
        process: model.process.clone(),
        accuracy: model.accuracy,
        rigid: model.robot.rigid,
        unknown_rotor: model.robot.unknown_rotor,
        torque_constants: std::array::from_fn(|joint| {
            let stated = model.effects.iter().map(|stated| &stated.effect);
            let mut own = stated.filter(|effect| effect.at == Location::Joint(joint));
            own.find(|effect| is_open_factor(effect.kind)).map(|effect| effect.values[0])
        }),
    }
}

/// True for a calibration of a factor that no file states.
pub fn is_open_factor(kind: &EffectKind) -> bool {
    kind.calibration.is_some_and(|calibration| calibration.scope == CalibrationScope::OpenFactor)
}

/// What the links did, as far as the model says: reused where a change of the model does not move
/// them.
#[derive(Debug, Clone, Default)]
pub struct LinkMotion {
    /// Log rows that the instants belong to.
    pub rows: Vec<usize>,
    /// Link angles, rad.
    pub link: Vec<JointVector<f64>>,
    /// Spring torques, N·m.
    pub spring: Vec<JointVector<f64>>,
    /// Real tool poses; empty where the links swing and neither bearings nor base give.
    pub tool: Vec<Pose<f64>>,
    /// True where a link may be where it was seen, for its gear has play.
    pub placed: bool,
    /// Which links are put where they were seen, at every instant; empty where links swing or no gear
    /// has play.
    pub in_backlash: Vec<[bool; JOINTS]>,
    /// What the gears remember at every instant; empty where none does.
    pub memory: Vec<Memory>,
    /// What told how links swing that do so when a log begins.
    pub swing: Option<Arc<SwingGain>>,
    /// What gears were found to remember when the log begins; `None` where none remembers, or it
    /// begins at rest without a load.
    pub start: Option<Arc<StartFit>>,
}

/// Residuals of one log, over their noise, with the motion behind them.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// (measured − predicted)/deviation, in the order of [`PreparedLog::compared`].
    pub residual: Vec<f64>,
    /// What the links did.
    pub motion: Option<Arc<LinkMotion>>,
    /// By how much a tracker whose clock is not given is later than the clock that was fitted before,
    /// s: in the middle of the log, and more at its end.
    pub late: Option<[f64; 2]>,
    /// What it takes from the evidence, as a sum of squares, that links are put where they were seen,
    /// gears begin as fits best, and a tracker's clock is where it fits.
    pub not_evidence: f64,
    /// How much larger noise is under the model than residuals are weighed by; `None` where it is as large.
    pub noise: Option<Arc<NoiseFactors>>,
}

impl Prediction {
    /// Residuals over the noise that is under the model.
    pub fn in_own_noise(&self) -> Cow<'_, [f64]> {
        let mut residual = Cow::from(&self.residual);
        if self.noise.is_some() {
            self.divide_by_noise(residual.to_mut());
        }
        residual
    }

    /// The same with the noise that is under the model.
    ///
    /// # Errors
    /// [`PredictError::Effect`].
    pub(crate) fn with_noise(
        mut self,
        log: &PreparedLog,
        model: &BaselineModel,
        effects: &[Effect],
    ) -> Result<Self, PredictError> {
        if let Some(contact) = &log.contact {
            let mut process = contact.process(model);
            let robot = ElasticRobot::with_effects(&model.robot, effects, Some(&mut process))?;
            let noise = contact.noise_factors(model, (&robot, &process), &log.compared);
            let is_as_weighed = noise.deviation.iter().all(|by| *by == 1.0);
            self.noise = (!is_as_weighed).then(|| Arc::new(noise));
        }
        Ok(self)
    }

    /// Puts values in the order of residuals over the noise that is under the model.
    pub fn divide_by_noise(&self, values: &mut [f64]) {
        let factors = self.noise.iter().flat_map(|noise| &noise.deviation);
        values.iter_mut().zip(factors).for_each(|(value, by)| *value /= by);
    }
}

/// How much larger the noise of a log's values is under a model than it was taken for, in the order of
/// [`PreparedLog::compared`].
#[derive(Debug, Clone, Default)]
pub struct NoiseFactors {
    /// Factor of each deviation.
    pub deviation: Vec<f64>,
    /// Factor by which values lie farther apart beforehand: the same, but for a force that is held by its
    /// controller. There it is the depth that the tracker's noise is in and that the force tells, to the
    /// same exactness however firm the material is.
    pub spread: Vec<f64>,
}

/// A log that cannot be compared, or a model that cannot be driven through it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PredictError {
    /// Nothing in it that any kind of prediction covers.
    #[error("{log}: nothing to compare: {what}")]
    Nothing {
        /// The log.
        log: String,
        /// What is missing.
        what: &'static str,
    },
    /// Noise neither stated nor to be estimated.
    #[error(
        "{log}: the noise of {what} is neither stated nor can it be read off any log of the campaign; add it to [noise] in log.toml"
    )]
    Noise {
        /// The log.
        log: String,
        /// The instrument.
        what: &'static str,
    },
    /// No process file for a weld.
    #[error("{log}: a weld log needs a process, and neither the model nor the log names one")]
    NoProcess {
        /// The log.
        log: String,
    },
    /// The model cannot be built.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// The model's links move too fast to be followed.
    #[error("{log}: {what}")]
    TooFast {
        /// The log.
        log: String,
        /// The joint, and how fast.
        what: String,
    },
    /// The model's motion left the finite numbers.
    #[error("{log}: driven by this log the model leaves the finite numbers")]
    Diverged {
        /// The log.
        log: String,
    },
}

/// One log made ready: its drives smoothed, its measurements brought into their band, their noise
/// known.
#[derive(Debug, Clone)]
pub struct PreparedLog {
    /// Name of the log.
    pub name: String,
    /// What was done.
    pub kind: LogKind,
    /// Sampling period, s; infinite where each row is at rest.
    pub period: f64,
    /// What is compared, in the order of the residuals.
    pub compared: Vec<Compared>,
    /// Where the log has no value, among all that could be compared.
    missing: Vec<bool>,
    /// How many of these are poses, which come first, and how many of those are compared.
    raw_poses: usize,
    poses: usize,
    standing: Option<standing::StaticPrediction>,
    moving: Option<moving::DynamicPrediction>,
    contact: Option<contact::ContactForcePrediction>,
    /// The point of the tool that the tracker saw, in T, m, where it is not the tool centre point.
    target: Option<Vector3<f64>>,
    /// True where the tracker's frame was fitted to such logs as this one.
    pub registered: bool,
    /// Names of the joints.
    joint_names: [String; JOINTS],
    /// Torque of one unit of a current whose factor is not stated, as it was found, N·m.
    pub(crate) factors: [Option<f64>; JOINTS],
    /// True where a measured force drives the prediction or is compared.
    force: bool,
    /// The spindle's line for which forces are not compared.
    pub(crate) folded: Option<Folded>,
    /// The tracker's clock, where it is not given.
    clock: Option<OpenClock>,
    /// True where the log begins in motion or under a load: gears may remember anything then.
    starts_anywhere: bool,
}

impl PreparedLog {
    /// Makes a log ready to be compared with `model`.
    ///
    /// # Errors
    /// [`PredictError`].
    pub fn new(
        log: &Log,
        noise: &NoiseLevels,
        model: &BaselineModel,
    ) -> Result<Self, PredictError> {
        let mut compared = Vec::new();
        let mut folded = None;
        let (mut standing, mut moving, mut contact) = (None, None, None);
        match log.kind {
            LogKind::StaticLoad => {
                standing = standing::StaticPrediction::of_loads(log, noise, model, &mut compared)?
            }
            LogKind::RingDown | LogKind::FreeMotion => {
                moving = Some(moving::DynamicPrediction::new(log, noise, model, &mut compared)?);
            }
            LogKind::Weld => {
                standing = standing::StaticPrediction::of_weld(log, noise, model, &mut compared)?;
                contact = contact::ContactForcePrediction::new(
                    log,
                    noise,
                    model,
                    &mut compared,
                    &mut folded,
                )?;
            }
        }
        let of_poses =
            |compared: &[Compared]| compared.iter().filter(|c| c.quantity.is_pose()).count();
        let missing: Vec<bool> = compared.iter().map(|c| !c.measured.is_finite()).collect();
        let raw_poses = of_poses(&compared);
        compared.retain(|c| c.measured.is_finite());
        if compared.is_empty() {
            let what = match log.kind {
                LogKind::StaticLoad | LogKind::RingDown => "it has no tracker columns",
                LogKind::FreeMotion => {
                    "it has no motor torque, tracker or second encoder columns, or is too short"
                }
                LogKind::Weld => "it needs tracker and wrench columns, and some seconds",
            };
            return Err(PredictError::Nothing { log: log.name.clone(), what });
        }
        accuracy::allow(&mut compared, log, log.accuracy.or(model.accuracy));
        let poses = of_poses(&compared);
        let clock = OpenClock::of(log, compared.iter().map(|c| c.row));
        let read = |force: &Vec<Vector3<f64>>| force.iter().any(|f| f.sum().is_finite());
        let force = moving.is_none() && log.samples.force.as_ref().is_some_and(read);
        let period = if log.kind == LogKind::StaticLoad { f64::INFINITY } else { period(log) };
        let starts_anywhere = standing.as_ref().is_some_and(|s| s.begins_under_load(model))
            || moving.as_ref().is_some_and(|m| m.begins_in_motion());
        Ok(Self {
            name: log.name.clone(),
            kind: log.kind,
            period,
            compared,
            missing,
            raw_poses,
            poses,
            standing,
            moving,
            contact,
            target: log.origin.target,
            registered: log.origin.is_registered(),
            joint_names: log.robot.joint_names.clone(),
            factors: log.origin.currents.map(|current| current?.factor),
            force,
            folded,
            clock,
            starts_anywhere,
        })
    }

    /// The same log with the noise of each channel taken for so many times as large.
    pub fn inflate_noise(&self, factor: impl Fn(&'static str) -> f64) -> Self {
        let mut inflate_noise = self.clone();
        for compared in &mut inflate_noise.compared {
            compared.deviation *= factor(compared.quantity.channel());
        }
        inflate_noise
    }

    /// Residuals under a model with these effects. `beside`: a prediction of this log under a model
    /// that differs in one effect alone, and that effect; what it has no say in is taken from
    /// there.
    ///
    /// # Errors
    /// [`PredictError::Effect`], [`PredictError::Diverged`].
    pub fn predict(
        &self,
        model: &BaselineModel,
        effects: &[Effect],
        beside: Option<(&Prediction, &Effect)>,
    ) -> Result<Prediction, PredictError> {
        let known = beside.map(|(at, effect)| (at, Some(effect)));
        self.predict_from(model, effects, known)?.with_noise(self, model, effects)
    }

    /// The same without the noise that is under the model. `known`: a prediction of this log under a model
    /// not far from this one, and the effect in which the two differ where it is one alone.
    pub(crate) fn predict_from(
        &self,
        model: &BaselineModel,
        effects: &[Effect],
        known: Option<(&Prediction, Option<&Effect>)>,
    ) -> Result<Prediction, PredictError> {
        let beside = known.and_then(|(at, effect)| Some((at, effect?)));
        let placed = |at: &Prediction| at.motion.as_ref().is_some_and(|m| m.placed);
        let same_motion = beside.filter(|(at, effect)| !placed(at) && !self.moves(effect));
        let same_poses = beside.filter(|(at, effect)| !placed(at) && !self.shows_in_poses(effect));
        let mut process = self.contact.as_ref().map(|c| c.process(model));
        let mut robot = ElasticRobot::with_effects(&model.robot, effects, process.as_mut())?;
        if let Some(at) = self.target {
            let point = Box::new(TrackedPoint { at });
            robot.ports.sensor.insert(0, (Channel::Tracker, point));
        }
        let remembers = robot.ports.memories() > 0;
        let same_loads = beside.filter(|(at, effect)| {
            (self.moving.is_none() || !placed(at)) && !self.shows_in_loads(effect, remembers)
        });
        let motion = match same_motion {
            Some((at, _)) => at.motion.clone(),
            None => {
                let near = known.and_then(|(at, _)| at.motion.as_deref());
                self.motion(&mut robot, near, beside.is_some())?.map(Arc::new)
            }
        };
        let process = process.as_ref();
        // Beside another prediction the gears begin as there, and where they would is told by slopes.
        let fit = motion.as_ref().and_then(|m| m.start.as_deref());
        let held = fit.filter(|_| beside.is_some() && same_poses.is_none());
        let settle = |residual: &mut [f64]| held.iter().for_each(|fit| fit.settle(residual));
        let mut late = None;
        let residual = match (&self.clock, same_poses, same_loads) {
            (Some(_), Some((at, _)), Some(_)) => {
                late = at.late;
                at.residual.clone()
            }
            (Some(clock), ..) => {
                let motion = motion.as_deref();
                let mut residual = self.residual(&robot, motion, process, [None; 2]);
                robot.ports.time.push(Box::new(Late(clock::DELAY_STEP)));
                let mut read_late = self.residual(&robot, motion, process, [None; 2]);
                settle(&mut residual);
                settle(&mut read_late);
                late = clock.settle(&mut residual, &read_late);
                residual
            }
            _ => {
                let same = [same_poses, same_loads].map(|same| same.map(|(at, _)| at));
                let mut residual = self.residual(&robot, motion.as_deref(), process, same);
                settle(&mut residual);
                residual
            }
        };
        if residual.iter().any(|r| !r.is_finite()) {
            return Err(PredictError::Diverged { log: self.name.clone() });
        }
        let of_links = self.standing.as_ref().zip(motion.as_ref());
        let of_links = of_links.map_or(0.0, |(links, motion)| links.free_play_term(&robot, motion));
        let of_clock = self.clock.as_ref().zip(late).map_or(0.0, |(clock, by)| clock.prior(by));
        let of_start = motion.as_ref().and_then(|motion| motion.start.as_deref());
        let of_start = of_start.map_or(0.0, StartFit::not_evidence);
        let not_evidence = of_links + of_start + of_clock;
        Ok(Prediction { residual, motion, late, not_evidence, noise: None })
    }

    /// Residuals over their noise; poses and loads from another prediction where that is given.
    fn residual(
        &self,
        robot: &ElasticRobot,
        motion: Option<&LinkMotion>,
        process: Option<&Process>,
        [same_poses, same_loads]: [Option<&Prediction>; 2],
    ) -> Vec<f64> {
        let mut residual = Vec::with_capacity(self.compared.len());
        match same_poses {
            Some(at) => residual.extend_from_slice(&at.residual[..self.poses]),
            None => self.pose_residual(robot, motion, &mut residual),
        }
        match same_loads {
            Some(at) => residual.extend_from_slice(&at.residual[self.poses..]),
            None => {
                let mut raw = Vec::with_capacity(self.missing.len() - self.raw_poses);
                if let (Some(moving), Some(motion)) = (&self.moving, motion) {
                    moving.torques(robot, motion, &mut raw);
                }
                if let (Some(contact), Some(process)) = (&self.contact, process) {
                    contact.residual(robot, process, &mut raw);
                }
                self.weigh(&raw, self.raw_poses, &mut residual);
            }
        }
        residual
    }

    /// What the links do under a model, `None` where nothing is compared that they have a say in.
    /// `near`: what they do under one not far from it, with what gears remember at the start kept
    /// where `held`.
    fn motion(
        &self,
        robot: &mut ElasticRobot,
        near: Option<&LinkMotion>,
        held: bool,
    ) -> Result<Option<LinkMotion>, PredictError> {
        match memory::at_the_start(self, robot, near, held)? {
            Some(motion) => Ok(Some(motion)),
            None => {
                let swing = near.and_then(|near| near.swing.as_ref());
                self.follow(robot, &[0.0; INTERNAL_STATES], swing, None)
            }
        }
    }

    /// The same with what the gears remember at the start. `swing`: what tells how links that
    /// remember swing there, where it is known; `before`: what the links do with another memory,
    /// which is taken over from where that is forgotten.
    fn follow(
        &self,
        robot: &mut ElasticRobot,
        memory: &Memory,
        swing: Option<&Arc<SwingGain>>,
        before: Option<&LinkMotion>,
    ) -> Result<Option<LinkMotion>, PredictError> {
        match (&self.standing, &self.moving) {
            (Some(standing), _) => Ok(Some(standing.motion(robot, memory, before)?)),
            (None, Some(moving)) => {
                let log = || self.name.clone();
                let told = |mode: TooFast| mode.told(&self.joint_names[mode.0.joint]);
                let too_fast = |mode| PredictError::TooFast { log: log(), what: told(mode) };
                let diverged = |_| PredictError::Diverged { log: log() };
                let substeps = moving.substeps(robot).map_err(too_fast)?;
                let motion = moving.motion(robot, memory, swing, before, substeps);
                motion.map(Some).map_err(diverged)
            }
            (None, None) => Ok(None),
        }
    }

    /// Adds residuals of poses over their noise.
    fn pose_residual(
        &self,
        robot: &ElasticRobot,
        motion: Option<&LinkMotion>,
        residual: &mut Vec<f64>,
    ) {
        let mut raw = Vec::with_capacity(self.raw_poses);
        if let Some(motion) = motion {
            self.standing.iter().for_each(|s| s.residual(robot, motion, &mut raw));
            self.moving.iter().for_each(|m| m.poses(robot, motion, &mut raw));
        }
        self.weigh(&raw, 0, residual);
    }

    /// Residuals where the link behind a joint is mounted off by `motion` more, in its frame before
    /// that, and the links stay where they are in `at`, the prediction under `effects`: what gravity
    /// makes of the motion is left out.
    ///
    /// # Errors
    /// [`PredictError::Effect`].
    pub(crate) fn remounted(
        &self,
        model: &BaselineModel,
        effects: &[Effect],
        at: &Prediction,
        joint: usize,
        motion: &Pose<f64>,
    ) -> Result<Vec<f64>, PredictError> {
        let mut robot = ElasticRobot::with_effects(&model.robot, effects, None)?;
        let mut residual = Vec::with_capacity(self.compared.len());
        let mut moved = None;
        if let Some(links) = &at.motion {
            let mut links = LinkMotion::clone(links);
            for (tool, link) in links.tool.iter_mut().zip(&links.link) {
                let frames = robot.model.frames(link);
                let frame =
                    Pose { rotation: frames.rotation[joint], position: frames.origin[joint] };
                *tool = frame * *motion * frame.inverse() * *tool;
            }
            if self.moving.is_some() {
                let mut parameters = robot.model.parameters().clone();
                mount(&mut parameters, joint, motion);
                robot.model = Robot::new(parameters)
                    .map_err(|reason| EffectError::Model { id: "a link's mounting", reason })?;
            }
            moved = Some(links);
        }
        self.pose_residual(&robot, moved.as_ref(), &mut residual);
        let fit = moved.as_ref().and_then(|m| m.start.as_deref());
        let settle = |residual: &mut [f64]| fit.iter().for_each(|fit| fit.settle(residual));
        if let Some(clock) = &self.clock {
            let mut late = Vec::with_capacity(residual.len());
            robot.ports.time.push(Box::new(Late(clock::DELAY_STEP)));
            self.pose_residual(&robot, moved.as_ref(), &mut late);
            settle(&mut residual);
            settle(&mut late);
            clock.settle(&mut residual, &late);
            residual.extend_from_slice(&at.residual[self.poses..]);
        } else {
            residual.extend_from_slice(&at.residual[self.poses..]);
            settle(&mut residual);
        }
        Ok(residual)
    }

    /// True where a tracker saw the tool in postures that differ by more than a load's bending.
    pub fn sees_postures(&self) -> bool {
        let motors = match (&self.standing, &self.moving) {
            (Some(standing), _) => standing.motors(),
            (None, Some(moving)) => moving.motors(),
            (None, None) => return false,
        };
        let Some(first) = motors.first() else {
            return false;
        };
        self.measures(Channel::Tracker, None)
            && motors.iter().any(|m| (m.angle - first.angle).amax() > ANOTHER_POSTURE)
    }

    /// Adds raw residuals, of which the first is that of index `from` among all that could be
    /// compared, over their noise.
    fn weigh(&self, raw: &[f64], from: usize, residual: &mut Vec<f64>) {
        for (r, missing) in raw.iter().zip(&self.missing[from..]) {
            if !missing {
                residual.push(r / self.compared[residual.len()].deviation);
            }
        }
    }
}

impl LinkMotion {
    /// A motion that is still to come.
    fn new(length: usize, placed: bool) -> Self {
        let rows = (0..length).collect();
        let [link, spring] = [(); 2].map(|()| Vec::with_capacity(length));
        Self { rows, link, spring, placed, ..Self::default() }
    }

    /// True where gears and links are at the end of this motion where they are in another one that
    /// goes on.
    fn joins(&self, other: &Self) -> bool {
        let last = self.link.len().wrapping_sub(1);
        let (Some(a), Some(b)) = (self.memory.get(last), other.memory.get(last)) else {
            return false;
        };
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < EQUAL_MOTION_DIFFERENCE)
            && (self.link[last] - other.link[last]).amax() < SAME_LINK
    }

    /// Goes on as another one does.
    fn go_on(&mut self, other: &Self) {
        let from = self.link.len();
        self.link.extend_from_slice(&other.link[from..]);
        self.spring.extend_from_slice(&other.spring[from..]);
        self.tool.extend(other.tool.get(from..).unwrap_or_default());
        self.in_backlash.extend(other.in_backlash.get(from..).unwrap_or_default());
        self.memory.extend_from_slice(&other.memory[from..]);
    }
}

/// Difference of what gears remember, as a share of all that they can, and of links, rad, below which
/// two motions are one.
const EQUAL_MOTION_DIFFERENCE: f64 = 1e-4;
const SAME_LINK: f64 = 1e-7;

/// Deviation of an instrument, or the error that says it is not known.
fn known(
    levels: &[Option<NoiseLevel>],
    log: &Log,
    channel: LogChannel,
) -> Result<Vec<NoiseLevel>, PredictError> {
    let what = channel.entry().instrument;
    let error = || PredictError::Noise { log: log.name.clone(), what };
    levels.iter().map(|l| l.ok_or_else(error)).collect()
}
