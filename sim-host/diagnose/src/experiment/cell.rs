//! What a laboratory can do, as far as its logs and its robot tell: instruments, where the arm may
//! stand, what can be hung on it and pressed against it.
//!
//! Postures stay near those of the logs, within the joints' limits, above the floor, clear of the
//! base and, where something is pressed, of singularities. Left out: what else stands in the cell.

use nalgebra::Vector3;
use std::f64::consts::PI;
use trueweld_core::{JOINTS, JointVector, Pose, Robot, Wrench};
use trueweld_estimate::safe_space::{OFF_LIMITS, SafeSpace};
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::noise::{NoiseLevels, instruments};

/// How far beyond what the logs visited a joint may go, rad.
const JOINT_RANGE_MARGIN: f64 = 20.0 * PI / 180.0;

/// Postures that a plan chooses from.
const PLAN_POSTURES: usize = 8;

/// What is hung on the flange where no log says what the laboratory has: mass, kg, and centre, m.
const USUAL_PAYLOAD: (f64, [f64; 3]) = (100.0, [0.15, 0.0, 0.0]);

/// Channels that logs of one kind have.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Channels {
    /// Position of the tool.
    pub position: bool,
    /// Orientation of the tool.
    pub rotation: bool,
    /// Encoders on the links.
    pub link_encoder: [bool; JOINTS],
    /// Torques of the motors.
    pub motor_torque: [bool; JOINTS],
    /// Force on the tool.
    pub force: bool,
    /// Moment on the tool.
    pub moment: bool,
}

impl Channels {
    fn of<'l>(logs: impl Iterator<Item = &'l Log> + Clone) -> Self {
        let any = |has: &dyn Fn(&Log) -> bool| logs.clone().any(has);
        Self {
            position: any(&|l| l.samples.position.is_some()),
            rotation: any(&|l| l.samples.rotation.is_some()),
            link_encoder: std::array::from_fn(|i| any(&|l| l.samples.link_encoder[i].is_some())),
            motor_torque: std::array::from_fn(|i| any(&|l| l.samples.motor_torque[i].is_some())),
            force: any(&|l| l.samples.force.is_some()),
            moment: any(&|l| l.samples.moment.is_some()),
        }
    }
}

/// The laboratory.
#[derive(Debug)]
pub(super) struct ExperimentCell<'a> {
    pub robot: &'a Robot<f64>,
    logs: &'a [Log],
    noise: Vec<NoiseLevels>,
    /// Where the arm may stand.
    pub space: SafeSpace<'a>,
    /// Postures to work in, whole steps of 5°.
    pub postures: Vec<JointVector<f64>>,
    /// Largest force, N, and moment, N·m, that can be pressed with; 0 where no log has it.
    pub force: f64,
    pub moment: f64,
    /// Largest mass to hang on the flange, kg, and its centre from the flange in axes of the last
    /// link, m.
    pub mass: f64,
    pub centre: Vector3<f64>,
}

impl<'a> ExperimentCell<'a> {
    /// What the logs show of the laboratory; `None` where they show nowhere to go.
    pub(super) fn of(robot: &'a Robot<f64>, logs: &'a [Log]) -> Option<Self> {
        logs.first()?;
        let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; JOINTS];
        for q in logs.iter().flat_map(|l| &l.samples.encoder) {
            for i in 0..JOINTS {
                range[i] = [range[i][0].min(q[i]), range[i][1].max(q[i])];
            }
        }
        let parameters = robot.parameters();
        for (range, joint) in range.iter_mut().zip(&parameters.joints) {
            let [low, high] = joint.limits;
            let within = [
                (range[0] - JOINT_RANGE_MARGIN).max(low + OFF_LIMITS),
                (range[1] + JOINT_RANGE_MARGIN).min(high - OFF_LIMITS),
            ];
            if within[0].is_nan() || within[1].is_nan() || within[0] > within[1] {
                // No log shows the joint anywhere that it could go from.
                return None;
            }
            *range = within;
        }
        let lowest = logs
            .iter()
            .flat_map(|l| l.samples.encoder.iter().step_by((l.samples.len() / 50).max(1)))
            .map(|q| robot.forward_kinematics(q).position.z)
            .fold(f64::INFINITY, f64::min);
        // What presses on a resting tool: as far as some log shows that the laboratory has it.
        let most = |part: &dyn Fn(&Log) -> Option<&Vec<Vector3<f64>>>| {
            let all =
                logs.iter().filter(|l| l.kind == LogKind::StaticLoad).filter_map(part).flatten();
            all.map(Vector3::norm).filter(|n| n.is_finite()).fold(0.0, f64::max)
        };
        let hung =
            logs.iter().flat_map(|l| l.samples.payload.iter().flatten()).filter(|p| p.mass > 0.0);
        let hung = hung.max_by(|a, b| a.mass.total_cmp(&b.mass));
        let (mass, centre) =
            hung.map_or((USUAL_PAYLOAD.0, USUAL_PAYLOAD.1.into()), |p| (p.mass, p.centre));
        let mut cell = Self {
            robot,
            logs,
            noise: instruments(logs),
            space: SafeSpace::seen(robot, range, lowest),
            postures: Vec::new(),
            force: round_down(most(&|l| l.samples.force.as_ref()), 500.0),
            moment: round_down(most(&|l| l.samples.moment.as_ref()), 50.0),
            mass,
            centre: centre.map(|x| (x * 1e3).round() / 1e3),
        };
        cell.postures = cell.space.postures(PLAN_POSTURES);
        Some(cell)
    }

    fn pattern(&self, kind: LogKind) -> Option<&'a Log> {
        self.logs.iter().find(|l| l.kind == kind)
    }

    /// Any log: of the same kind, if there is one.
    pub(crate) fn like(&self, kind: LogKind) -> &'a Log {
        self.pattern(kind).unwrap_or(&self.logs[0])
    }

    /// Sampling period to expect in a log of a kind, s: that of the logs of that kind, or of any.
    pub(crate) fn period(&self, kind: LogKind) -> Option<f64> {
        match self.pattern(kind) {
            Some(log) => log.period,
            None => self.logs.iter().find_map(|l| l.period),
        }
    }

    /// Channels to expect in a log of a kind: those of the logs of that kind, or of all where there
    /// is none.
    pub(crate) fn channels(&self, kind: LogKind) -> Channels {
        match self.pattern(kind) {
            Some(_) => Channels::of(self.logs.iter().filter(|l| l.kind == kind)),
            None => Channels::of(self.logs.iter()),
        }
    }

    /// Noise of the instruments in a log of a kind.
    pub(crate) fn noise(&self, kind: LogKind) -> NoiseLevels {
        let index = self.logs.iter().position(|l| l.kind == kind).unwrap_or(0);
        self.noise[index]
    }

    /// What the weight of a mass on the flange is to the tool, in axes of T.
    pub(crate) fn weight(&self, q: &JointVector<f64>, mass: f64) -> Wrench<f64> {
        let frames = self.robot.frames(q);
        let parameters = self.robot.parameters();
        let lever = frames.rotation[JOINTS - 1] * (self.centre - parameters.tool.tcp_from_flange);
        let force = parameters.gravity * mass;
        Wrench { moment: lever.cross(&force), force }.rotated(&frames.tcp.rotation.transpose())
    }

    /// Where the tool is under a wrench, in axes of T: as the baseline has it.
    pub(crate) fn pose(&self, q: &JointVector<f64>, wrench_in_t: &Wrench<f64>) -> Pose<f64> {
        self.robot.deflected(q, wrench_in_t, 4).real
    }
}

/// The largest whole number of steps within a size.
fn round_down(size: f64, step: f64) -> f64 {
    (size / step).floor() * step
}
