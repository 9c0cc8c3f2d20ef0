//! A few rows of every log, enough to tell a gross mistake.

use crate::predict::{filled, filled_vectors};
use nalgebra::{Matrix3, Vector3};
use trueweld_core::spatial::rotation_from_vector;
use trueweld_core::{JOINTS, JointVector, Robot, Wrench};
use trueweld_logs::fir::LowPass;
use trueweld_logs::log::{Log, LogKind, Payload};
use trueweld_logs::register::PosePair;

/// Rows of each log that are looked at.
const ROWS_PER_LOG: usize = 100;

/// Band in which motion and torque are compared, Hz.
const TORQUE_COMPARISON_BAND: f64 = 8.0;

/// One row. Torques that were not measured are NaN.
#[derive(Debug, Clone)]
pub(super) struct LogRow {
    /// True where nothing moves, and the tool is where its load leaves it.
    pub at_rest: bool,
    /// Encoder angles, rad.
    pub encoder: JointVector<f64>,
    /// Encoder rates, rad/s; zero at rest.
    pub rate: JointVector<f64>,
    /// Encoder accelerations, rad/s²; zero at rest.
    pub acceleration: JointVector<f64>,
    /// Measured wrench on the tool, at the TCP, in T; N, N·m.
    pub wrench: Wrench<f64>,
    /// Mass stated on the flange.
    pub payload: Payload,
    /// The point of the tool that the tracker saw, in T, m.
    pub point: Vector3<f64>,
    /// That point in B, by the tracker, m.
    pub position: Option<Vector3<f64>>,
    /// Rotation of T in B, by the tracker.
    pub rotation: Option<Matrix3<f64>>,
    /// Motor torques, N·m.
    pub torque: JointVector<f64>,
}

impl LogRow {
    /// Rows of a log that stand for all of it.
    pub(crate) fn of(log: &Log) -> Vec<Self> {
        let s = &log.samples;
        let n = s.time.len();
        let moving = log.kind != LogKind::StaticLoad;
        let low = moving.then(|| {
            let period = crate::predict::period(log);
            (LowPass::new(TORQUE_COMPARISON_BAND.min(0.2 / period), period), period)
        });
        let half = low.as_ref().map_or(0, |(low, _)| low.half()).min(n.saturating_sub(1) / 2);
        let (first, last) = (half, n - 1 - half);
        let count = ROWS_PER_LOG.min(last - first + 1);
        // Where the tracker is read more seldom, its reading that is nearest.
        let is_tracked = |k: &usize| {
            [&s.position, &s.rotation].into_iter().flatten().all(|v| v[*k].sum().is_finite())
        };
        let reach = (last - first) / (2 * count);
        let row = |k: usize| {
            let row = first + (last - first) * k / count.saturating_sub(1).max(1);
            let near = (0..=reach).flat_map(|by| [row.saturating_sub(by), row + by]);
            near.filter(|k| (first..=last).contains(k)).find(is_tracked).unwrap_or(row)
        };
        let at = |derivative: usize, series: &dyn Fn(usize) -> f64, k: usize| match &low {
            Some((low, _)) => low.at(derivative, series, n, k),
            None if derivative == 0 => series(k),
            None => 0.0,
        };
        let vector = |series: &Option<Vec<Vector3<f64>>>, k: usize| {
            series.as_ref().map(|v| v[k]).filter(|v| v.sum().is_finite())
        };
        // In motion what is read more seldom than the encoders goes on between its readings. A load that
        // was not read is not known: its row tells nothing.
        let loads = [&s.force, &s.moment];
        let through = loads.map(filled_vectors);
        let is_read = |k: usize| match moving {
            true => {
                loads.iter().zip(&through).all(|(read, whole)| read.is_none() || whole.is_some())
            }
            false => loads.iter().all(|read| read.is_none() || vector(read, k).is_some()),
        };
        let torque: [Option<Vec<f64>>; JOINTS] = std::array::from_fn(|i| match moving {
            true => filled(s.motor_torque[i].as_ref()?),
            false => s.motor_torque[i].clone(),
        });
        let still = Payload { mass: 0.0, centre: Vector3::zeros() };
        (0..count)
            .map(row)
            .filter(|k| is_read(*k))
            .map(|k| {
                let joints = |d: usize| JointVector::from_fn(|i, _| at(d, &|r| s.encoder[r][i], k));
                let load = |whole: &Option<[Vec<f64>; 3]>| match whole {
                    Some(whole) => Vector3::from_fn(|c, _| at(0, &|r| whole[c][r], k)),
                    None => Vector3::zeros(),
                };
                Self {
                    at_rest: !moving,
                    encoder: s.encoder[k],
                    rate: joints(1),
                    acceleration: joints(2),
                    wrench: Wrench { moment: load(&through[1]), force: load(&through[0]) },
                    payload: s.payload.as_ref().map_or(still, |p| p[k]),
                    position: vector(&s.position, k),
                    point: log.origin.target.unwrap_or_else(Vector3::zeros),
                    rotation: vector(&s.rotation, k).map(|r| rotation_from_vector(&r)),
                    torque: JointVector::from_fn(|i, _| {
                        torque[i].as_ref().map_or(f64::NAN, |t| at(0, &|r| t[r], k))
                    }),
                }
            })
            .collect()
    }

    /// The row with the tool where a robot with these encoder angles stands under its load.
    pub(crate) fn pose_pair(
        &self,
        robot: &Robot<f64>,
        encoder: &JointVector<f64>,
    ) -> Option<PosePair> {
        let mut nominal = robot.deflected(encoder, &self.load(robot, encoder), 2).real;
        nominal.position += nominal.rotation * self.point;
        Some(PosePair { nominal, position: self.position?, rotation: self.rotation })
    }

    /// Measured wrench and what hangs on the flange, at the TCP in T.
    fn load(&self, robot: &Robot<f64>, encoder: &JointVector<f64>) -> Wrench<f64> {
        self.wrench + self.weight(robot, encoder, self.payload.mass, &self.payload.centre)
    }

    /// A mass at a place from the flange, in axes of the last link, as a wrench at the TCP in T.
    pub(crate) fn weight(
        &self,
        robot: &Robot<f64>,
        encoder: &JointVector<f64>,
        mass: f64,
        centre: &Vector3<f64>,
    ) -> Wrench<f64> {
        if mass == 0.0 {
            return Wrench::zero();
        }
        let frames = robot.frames(encoder);
        let parameters = robot.parameters();
        let force = parameters.gravity * mass;
        let arm = frames.rotation[JOINTS - 1] * (centre - parameters.tool.tcp_from_flange);
        Wrench { moment: arm.cross(&force), force }.rotated(&frames.tcp.rotation.transpose())
    }

    /// What the motors need for this motion without a load at the tool, N·m.
    pub(crate) fn motor_torque(
        &self,
        robot: &Robot<f64>,
        [encoder, rate, acceleration]: [&JointVector<f64>; 3],
    ) -> TorqueParts {
        let frames = robot.frames(encoder);
        let slow = robot.rnea(&frames, rate, &JointVector::zeros(), &Wrench::zero());
        let inertia = robot.rnea(&frames, rate, acceleration, &Wrench::zero()) - slow
            + robot.rotor_inertia().component_mul(acceleration);
        let mut held = slow;
        held[1] -= robot.counterbalance_torque(encoder[1]);
        let friction = &robot.parameters().friction;
        TorqueParts {
            held,
            inertia,
            friction: JointVector::from_fn(|i, _| friction.torque(i, rate[i]).0),
        }
    }

    /// As it was read.
    pub(crate) fn motion(&self) -> [&JointVector<f64>; 3] {
        [&self.encoder, &self.rate, &self.acceleration]
    }
}

/// Motor torque by what needs it, N·m.
#[derive(Debug, Clone, Copy)]
pub(super) struct TorqueParts {
    /// Gravity, counterbalance, and what rates make of the inertia.
    pub held: JointVector<f64>,
    /// Accelerations.
    pub inertia: JointVector<f64>,
    /// Friction.
    pub friction: JointVector<f64>,
}

impl TorqueParts {
    /// All of it.
    pub(crate) fn sum(&self) -> JointVector<f64> {
        self.held + self.inertia + self.friction
    }
}
