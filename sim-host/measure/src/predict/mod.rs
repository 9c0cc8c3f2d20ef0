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

mod clock;
mod contact;
mod memory;
mod moving;
mod play;
mod standing;

pub use memory::{StartFit, StartState};
pub(crate) use standing::hung;

use crate::data::channel::LogChannel;
use crate::data::log::{Log, LogKind};
use crate::data::noise::{Level, NoiseLevels};
use clock::{Late, OpenClock};
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::sync::Arc;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JOINTS, JointVector, Pose, Robot, Wrench};
use trueweld_plant::effects::{Action, Effect, EffectError, Location};
use trueweld_plant::input::Process;
use trueweld_plant::robot::{
    Channel, ElasticRobot, INTERNAL_STATES, Memory, Port, Ports, Readings, Term, mount,
};

/// Angle of a joint by which one posture is another, rad.
const ANOTHER_POSTURE: f64 = 0.1;

/// The model that logs are compared with, before effects.
#[derive(Debug, Clone)]
pub struct Model {
    /// The robot.
    pub robot: Robot<f64>,
    /// The process; a weld log's own stands in where the model names none.
    pub process: Option<Process>,
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// Tracker: TCP position in B, m.
    Position,
    /// Tracker: rotation from the predicted to the measured tool, in T, rad.
    Rotation,
    /// Second encoder of a joint, rad.
    LinkEncoder,
    /// Motor torque of a joint, N·m.
    MotorTorque,
    /// Force on the tool in T below the spindle's frequency, N.
    Force,
    /// Moment on the tool in T below the spindle's frequency, N·m.
    Moment,
    /// Force on the tool in T in step with a multiple of the spindle's angle: real and imaginary
    /// amplitude, N.
    Ripple {
        /// Periods per turn.
        order: u8,
        /// True for the part with the sine.
        sine: bool,
    },
}

impl Quantity {
    /// The channel of the log that it is of.
    pub fn log_channel(self) -> LogChannel {
        match self {
            Self::Position => LogChannel::Position,
            Self::Rotation => LogChannel::Rotation,
            Self::LinkEncoder => LogChannel::LinkEncoder,
            Self::MotorTorque => LogChannel::MotorTorque,
            Self::Force | Self::Ripple { .. } => LogChannel::Force,
            Self::Moment => LogChannel::Moment,
        }
    }

    /// Channel name in results.
    pub fn channel(self) -> &'static str {
        self.log_channel().entry().name
    }

    /// True for what tracker and second encoders read, false for forces and torques.
    fn is_pose(self) -> bool {
        matches!(self, Self::Position | Self::Rotation | Self::LinkEncoder)
    }

    /// Unit.
    pub fn unit(self) -> &'static str {
        self.log_channel().entry().unit
    }
}

/// One compared number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compared {
    /// What it is.
    pub quantity: Quantity,
    /// Component: axis, or joint from 0.
    pub component: u8,
    /// Row of the log it belongs to.
    pub row: usize,
    /// Measured value; for a rotation, from the model without effects to the measured tool.
    pub measured: f64,
    /// Standard deviation of measured and propagated noise.
    pub deviation: f64,
    /// True where that noise was stated by the log.
    pub stated: bool,
}

/// What the links did, as far as the model says: reused where a change of the model does not move
/// them.
#[derive(Debug, Clone, Default)]
pub struct Motion {
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
    pub afloat: Vec<[bool; JOINTS]>,
    /// What the gears remember at every instant; empty where none does.
    pub memory: Vec<Memory>,
    /// What the first residuals tell of how links swing that remember; see the rooms of motion.
    pub swing: Option<Arc<DMatrix<f64>>>,
    /// What gears were found to remember when the log begins; `None` where none remembers, or it
    /// begins at rest without a load.
    pub start: Option<Arc<StartFit>>,
}

/// Residuals of one log, over their noise, with the motion behind them.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// (measured − predicted)/deviation, in the order of [`Experiment::compared`].
    pub residual: Vec<f64>,
    /// What the links did.
    pub motion: Option<Arc<Motion>>,
    /// By how much a tracker whose clock is not given is later than the clock that was fitted before,
    /// s: in the middle of the log, and more at its end.
    pub late: Option<[f64; 2]>,
    /// What it takes from the evidence that links are put where they were seen, as a sum of squares.
    pub anywhere: f64,
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
pub struct Experiment {
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
    standing: Option<standing::Standing>,
    moving: Option<moving::Moving>,
    contact: Option<contact::Contact>,
    /// The point of the tool that the tracker saw, in T, m, where it is not the tool centre point.
    target: Option<Vector3<f64>>,
    /// True where the tracker's frame was fitted to such logs as this one.
    pub(crate) registered: bool,
    /// True where a measured force drives the prediction or is compared.
    force: bool,
    /// The tracker's clock, where it is not given.
    clock: Option<OpenClock>,
    /// True where the log begins in motion or under a load: gears may remember anything then.
    starts_anywhere: bool,
}

impl Experiment {
    /// Makes a log ready to be compared with `model`.
    ///
    /// # Errors
    /// [`PredictError`].
    pub fn new(log: &Log, noise: &NoiseLevels, model: &Model) -> Result<Self, PredictError> {
        let mut compared = Vec::new();
        let (mut standing, mut moving, mut contact) = (None, None, None);
        match log.kind {
            LogKind::StaticLoad => {
                standing = standing::Standing::of_loads(log, noise, model, &mut compared)?
            }
            LogKind::RingDown | LogKind::FreeMotion => {
                moving = Some(moving::Moving::new(log, noise, model, &mut compared)?);
            }
            LogKind::Weld => {
                standing = standing::Standing::of_weld(log, noise, model, &mut compared)?;
                contact = contact::Contact::new(log, noise, model, &mut compared)?;
            }
        }
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
        let of_poses =
            |compared: &[Compared]| compared.iter().filter(|c| c.quantity.is_pose()).count();
        let missing: Vec<bool> = compared.iter().map(|c| !c.measured.is_finite()).collect();
        let raw_poses = of_poses(&compared);
        compared.retain(|c| c.measured.is_finite());
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
            force,
            clock,
            starts_anywhere,
        })
    }

    /// The same log with the noise of each channel taken for so many times as large.
    pub(crate) fn inflate_noise(&self, factor: impl Fn(&'static str) -> f64) -> Self {
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
        model: &Model,
        effects: &[Effect],
        beside: Option<(&Prediction, &Effect)>,
    ) -> Result<Prediction, PredictError> {
        self.predict_from(model, effects, beside.map(|(at, effect)| (at, Some(effect))))
    }

    /// The same; `known`: a prediction of this log under a model not far from this one, and the
    /// effect in which the two differ where it is one alone.
    pub(crate) fn predict_from(
        &self,
        model: &Model,
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
                robot.ports.time.push(Box::new(Late(clock::STEP)));
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
        let anywhere = match (&self.standing, &motion) {
            (Some(standing), Some(motion)) => standing.anywhere(&robot, motion),
            _ => 0.0,
        };
        Ok(Prediction { residual, motion, late, anywhere })
    }

    /// Residuals over their noise; poses and loads from another prediction where that is given.
    fn residual(
        &self,
        robot: &ElasticRobot,
        motion: Option<&Motion>,
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
        near: Option<&Motion>,
        held: bool,
    ) -> Result<Option<Motion>, PredictError> {
        match memory::at_the_start(self, robot, near, held)? {
            Some(motion) => Ok(Some(motion)),
            None => self.follow(robot, &[0.0; INTERNAL_STATES], None, None),
        }
    }

    /// The same with what the gears remember at the start. `swing`: what tells how links that
    /// remember swing there, where it is known; `before`: what the links do with another memory,
    /// which is taken over from where that is forgotten.
    fn follow(
        &self,
        robot: &mut ElasticRobot,
        memory: &Memory,
        swing: Option<&Arc<DMatrix<f64>>>,
        before: Option<&Motion>,
    ) -> Result<Option<Motion>, PredictError> {
        match (&self.standing, &self.moving) {
            (Some(standing), _) => Ok(Some(standing.motion(robot, memory, before)?)),
            (None, Some(moving)) => {
                let diverged = |_| PredictError::Diverged { log: self.name.clone() };
                moving.motion(robot, memory, swing, before).map(Some).map_err(diverged)
            }
            (None, None) => Ok(None),
        }
    }

    /// Adds residuals of poses over their noise.
    fn pose_residual(
        &self,
        robot: &ElasticRobot,
        motion: Option<&Motion>,
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
    /// makes of the motion is left out, a hundredth of it.
    ///
    /// # Errors
    /// [`PredictError::Effect`].
    pub(crate) fn remounted(
        &self,
        model: &Model,
        effects: &[Effect],
        at: &Prediction,
        joint: usize,
        motion: &Pose<f64>,
    ) -> Result<Vec<f64>, PredictError> {
        let mut robot = ElasticRobot::with_effects(&model.robot, effects, None)?;
        let mut residual = Vec::with_capacity(self.compared.len());
        let mut moved = None;
        if let Some(links) = &at.motion {
            let mut links = Motion::clone(links);
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
            robot.ports.time.push(Box::new(Late(clock::STEP)));
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

    /// True where this log compares what an instrument read, or is driven by it. `joint`: the
    /// joint that is asked for, where the instrument is one of each joint.
    pub fn measures(&self, instrument: Channel, joint: Option<usize>) -> bool {
        let of_joint = |c: &Compared| joint.is_none_or(|j| usize::from(c.component) == j);
        self.compared.iter().any(|c| match (instrument, c.quantity) {
            (Channel::Tracker, Quantity::Position | Quantity::Rotation) => true,
            (Channel::MotorTorque, Quantity::MotorTorque)
            | (Channel::LinkEncoder, Quantity::LinkEncoder) => of_joint(c),
            (Channel::Wrench, _) => self.force,
            _ => false,
        })
    }

    /// True where an effect can change anything that this log compares.
    pub fn concerns(&self, effect: &Effect) -> bool {
        let joint = if let Location::Joint(joint) = effect.at { Some(joint) } else { None };
        match (effect.kind.action, effect.port()) {
            (Action::Process(_), _) | (_, Some(Port::ProcessForce | Port::PlateSurface)) => {
                self.contact.is_some()
            }
            (Action::Mounting(_), _) => self.measures(Channel::Tracker, None),
            (_, Some(Port::MotorFriction(_))) => self.measures(Channel::MotorTorque, None),
            (_, Some(Port::SensorChannel(instrument))) => self.measures(instrument, joint),
            (_, Some(Port::TimeBase)) => match effect.at {
                // A row at rest is what it is whenever it is read.
                _ if self.kind == LogKind::StaticLoad => false,
                Location::Channel(instrument) => self.measures(instrument, None),
                _ => true,
            },
            _ => true,
        }
    }

    /// True where an effect can change how the links move in this log, and not only what is
    /// measured of it.
    fn moves(&self, effect: &Effect) -> bool {
        let stands = self.standing.is_some();
        match (effect.kind.action, effect.port()) {
            (Action::Process(_), _) => false,
            (_, Some(Port::ProcessForce | Port::PlateSurface | Port::MotorFriction(_))) => false,
            (_, Some(Port::SensorChannel(_) | Port::TimeBase)) => stands,
            _ => true,
        }
    }

    /// True where an effect can change what tracker and second encoders read.
    fn shows_in_poses(&self, effect: &Effect) -> bool {
        self.moves(effect)
            || match effect.port() {
                Some(Port::SensorChannel(Channel::MotorTorque)) => false,
                Some(Port::SensorChannel(_)) => true,
                Some(Port::TimeBase) => effect.at != Location::Channel(Channel::MotorTorque),
                _ => false,
            }
    }

    /// True where an effect can change what motors or the force sensor read. A weld's forces follow
    /// from where the tool was seen, whatever the links did, but for how stiff gears are that
    /// remember, where one `remembers`.
    fn shows_in_loads(&self, effect: &Effect, remembers: bool) -> bool {
        match (self.kind, effect.kind.action, effect.port()) {
            (LogKind::Weld, Action::Process(_), _) => true,
            (
                LogKind::Weld,
                _,
                Some(
                    Port::ProcessForce
                    | Port::PlateSurface
                    | Port::SensorChannel(_)
                    | Port::TimeBase,
                ),
            ) => true,
            (LogKind::Weld, _, Some(Port::SpringTorque(_))) => remembers,
            (LogKind::Weld, ..) => false,
            (
                _,
                _,
                Some(
                    Port::MotorFriction(_)
                    | Port::TimeBase
                    | Port::SensorChannel(Channel::MotorTorque),
                ),
            ) => true,
            _ => self.moves(effect),
        }
    }
}

impl Motion {
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
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < FORGOTTEN)
            && (self.link[last] - other.link[last]).amax() < SAME_LINK
    }

    /// Goes on as another one does.
    fn go_on(&mut self, other: &Self) {
        let from = self.link.len();
        self.link.extend_from_slice(&other.link[from..]);
        self.spring.extend_from_slice(&other.spring[from..]);
        self.tool.extend(other.tool.get(from..).unwrap_or_default());
        self.afloat.extend(other.afloat.get(from..).unwrap_or_default());
        self.memory.extend_from_slice(&other.memory[from..]);
    }
}

/// Difference of what gears remember, as a share of all that they can, and of links, rad, below which
/// two motions are one.
const FORGOTTEN: f64 = 1e-4;
const SAME_LINK: f64 = 1e-7;

/// Deviation of an instrument, or the error that says it is not known.
fn known(
    levels: &[Option<Level>],
    log: &Log,
    channel: LogChannel,
) -> Result<Vec<Level>, PredictError> {
    let what = channel.entry().instrument;
    let error = || PredictError::Noise { log: log.name.clone(), what };
    levels.iter().map(|l| l.ok_or_else(error)).collect()
}

/// Period of an evenly sampled log, s: as stated, or the median step.
pub(crate) fn period(log: &Log) -> f64 {
    log.period.unwrap_or_else(|| {
        let mut steps: Vec<f64> = log.samples.time.windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(1.0)
    })
}

/// A series whose missing values are filled along straight lines; `None` where it has none at all.
fn filled(series: &[f64]) -> Option<Vec<f64>> {
    let known: Vec<usize> = (0..series.len()).filter(|k| series[*k].is_finite()).collect();
    let (first, last) = (*known.first()?, *known.last()?);
    let mut out = series.to_vec();
    out[..first].fill(series[first]);
    out[last + 1..].fill(series[last]);
    for pair in known.windows(2) {
        for k in pair[0] + 1..pair[1] {
            let share = (k - pair[0]) as f64 / (pair[1] - pair[0]) as f64;
            out[k] = series[pair[0]] * (1.0 - share) + series[pair[1]] * share;
        }
    }
    Some(out)
}

/// One row of three columns.
fn vector(columns: &[Vec<f64>; 3], row: usize) -> Vector3<f64> {
    Vector3::from_fn(|c, _| columns[c][row])
}

/// Rotations as the first one and what every one turns from there: rotation vectors flip their
/// sign near half a turn.
fn turned_from_first(rotation: &[Vec<f64>; 3]) -> (Matrix3<f64>, [Vec<f64>; 3]) {
    let all: Vec<Matrix3<f64>> =
        (0..rotation[0].len()).map(|k| rotation_from_vector(&vector(rotation, k))).collect();
    let turned: Vec<Vector3<f64>> =
        all.iter().map(|r| rotation_vector(&all[0].tr_mul(r))).collect();
    (all[0], [0, 1, 2].map(|c| turned.iter().map(|v| v[c]).collect()))
}

/// Measured value of a rotation, which is compared as what it turns from the predicted one: NaN
/// where there is none.
fn none_where_missing(rotation: &Matrix3<f64>) -> f64 {
    if rotation.sum().is_finite() { 0.0 } else { f64::NAN }
}

/// Lists what is compared of some columns of a quantity, row by row. `of`: measured value,
/// deviation of its noise, and whether that was stated, by index of the row and by column.
fn list(
    compared: &mut Vec<Compared>,
    quantity: Quantity,
    rows: &[usize],
    columns: std::ops::Range<usize>,
    of: impl Fn(usize, usize) -> (f64, f64, bool),
) {
    for (k, &row) in rows.iter().enumerate() {
        for c in columns.clone() {
            let (measured, deviation, stated) = of(k, c);
            let component = c as u8;
            compared.push(Compared { quantity, component, row, measured, deviation, stated });
        }
    }
}

/// Spindle angle at every row, 0 at the first, rad; `None` without a spindle column.
fn spindle_angle(log: &Log) -> Option<Vec<f64>> {
    let spindle = filled(log.samples.spindle.as_ref()?)?;
    let time = &log.samples.time;
    let mut angle = vec![0.0; time.len()];
    for k in 1..time.len() {
        angle[k] = angle[k - 1] + 0.5 * (spindle[k - 1] + spindle[k]) * (time[k] - time[k - 1]);
    }
    Some(angle)
}

/// Force and moment at every row, three columns each: filled where a reading is missing, zero where
/// the log has no such columns.
fn wrench_columns(log: &Log) -> [[Vec<f64>; 3]; 2] {
    let none = || std::array::from_fn(|_| vec![0.0; log.samples.time.len()]);
    [&log.samples.force, &log.samples.moment].map(|v| filled_vectors(v).unwrap_or_else(none))
}

/// Three columns of vectors, filled.
fn filled_vectors(series: &Option<Vec<Vector3<f64>>>) -> Option<[Vec<f64>; 3]> {
    let series = series.as_ref()?;
    let column = |i: usize| filled(&series.iter().map(|v| v[i]).collect::<Vec<_>>());
    Some([column(0)?, column(1)?, column(2)?])
}

/// Readings in which nothing was read yet.
fn unread(time: f64) -> Readings {
    Readings {
        time,
        encoder: [0.0; 6],
        link_encoder: [0.0; 6],
        motor_torque: [0.0; 6],
        force: Vector3::zeros(),
        moment: Vector3::zeros(),
        tcp_position: Vector3::zeros(),
        tcp_rotation: Vector3::zeros(),
    }
}

/// What an instrument makes of what is true.
fn sensed(ports: &Ports, instrument: Channel, mut truth: Readings) -> Readings {
    ports.sense_by(instrument, &mut truth);
    truth
}

/// A tracker that sees another point of the tool than its centre: p' = p + R b.
#[derive(Debug)]
struct TrackedPoint {
    /// Where the point is, in T, m.
    at: Vector3<f64>,
}

impl Term for TrackedPoint {
    fn sense(&self, readings: &mut Readings) {
        readings.tcp_position += rotation_from_vector(&readings.tcp_rotation) * self.at;
    }
}

/// What the tracker makes of a tool pose.
fn seen(ports: &Ports, pose: &Pose<f64>, time: f64) -> Pose<f64> {
    if !ports.senses(Channel::Tracker) {
        return *pose;
    }
    let readings = Readings {
        tcp_position: pose.position,
        tcp_rotation: rotation_vector(&pose.rotation),
        ..unread(time)
    };
    let readings = sensed(ports, Channel::Tracker, readings);
    Pose { position: readings.tcp_position, rotation: rotation_from_vector(&readings.tcp_rotation) }
}

/// The true pose behind what the tracker saw.
fn pose_behind(ports: &Ports, measured: &Pose<f64>, time: f64) -> Pose<f64> {
    if !ports.senses(Channel::Tracker) {
        return *measured;
    }
    let mut truth = *measured;
    for _ in 0..4 {
        let read = seen(ports, &truth, time);
        truth.position += measured.position - read.position;
        truth.rotation *= read.rotation.tr_mul(&measured.rotation);
    }
    truth
}

/// Mean size of a series, what is missing left out.
fn mean_abs(series: &[f64]) -> f64 {
    let known: Vec<f64> = series.iter().filter(|v| v.is_finite()).map(|v| v.abs()).collect();
    known.iter().sum::<f64>() / known.len().max(1) as f64
}

/// The true wrench behind a measured one: the sensor's terms undone. They change little, so that
/// the fixed point converges: with a gain off by a third to 1e-12 in 25 steps.
fn wrench_behind(ports: &Ports, measured: &Wrench<f64>, time: f64) -> Wrench<f64> {
    if !ports.senses(Channel::Wrench) {
        return *measured;
    }
    let mut truth = *measured;
    let enough = 1e-12 * (measured.force.norm() + measured.moment.norm());
    for _ in 0..25 {
        let Wrench { force, moment } = truth;
        let readings = sensed(ports, Channel::Wrench, Readings { force, moment, ..unread(time) });
        let (force, moment) = (measured.force - readings.force, measured.moment - readings.moment);
        truth.force += force;
        truth.moment += moment;
        if force.norm() + moment.norm() <= enough {
            break;
        }
    }
    truth
}
