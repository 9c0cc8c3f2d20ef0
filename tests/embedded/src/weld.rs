//! A short weld in closed loop, in any scalar: the robot, its controller with the elastostatic law,
//! and drives that follow at once. The build script runs it in double precision on the host, the
//! program in the controller's own.

use nalgebra::{Matrix3, SVector, Vector3};
use trueweld_compensators::{Elastostatic, ElastostaticGains};
use trueweld_core::compensation::{Compensated, Compensator, LoopLimits};
use trueweld_core::control::{
    DriveCommand, External, ExternalGains, ForceSensorLimits, JointGains, SensorReadings, Setpoint,
};
use trueweld_core::monitor::{HealthMonitor, HealthSignals};
use trueweld_core::scalar::lit;
use trueweld_core::{
    Counterbalance, Friction, JOINTS, JointParameters, JointVector, Pose, Real, Robot,
    RobotParameters, ToolParameters, Twist, Wrench,
};

/// Control cycles of the run.
pub const CYCLES: usize = 200;

/// Control period, s.
pub const PERIOD: f64 = 0.012;

/// Rate of the spindle, rad/s: 600 rpm.
const SPINDLE: f64 = -62.83;

/// Feed along the weld, m/s.
const FEED: f64 = 0.010;

/// What the weld puts on the tool, axes of T, N: 4 kN along, 1 kN across, 18 kN depth.
const LOAD: [f64; 3] = [-4e3, 1e3, -18e3];

/// One joint of the robot file, SI units and rad.
#[derive(Debug, Clone, Copy)]
pub struct Joint {
    pub origin: [f64; 3],
    pub axis: [f64; 3],
    pub limits: [f64; 2],
    pub max_rate: f64,
    pub max_torque: f64,
    pub stiffness: f64,
    pub damping: f64,
    pub rotor_inertia: f64,
    pub mass: f64,
    pub center_of_mass: [f64; 3],
    /// xx, yy, zz, xy, xz, yz.
    pub inertia: [f64; 6],
}

/// The robot file as a constant of the program, SI units and rad.
#[derive(Debug, Clone, Copy)]
pub struct Numbers {
    pub gravity: [f64; 3],
    pub joints: [Joint; JOINTS],
    pub viscous: [f64; JOINTS],
    pub coulomb: [f64; JOINTS],
    pub smoothing: f64,
    pub counterbalance: [f64; 3],
    pub flange_offset: [f64; 3],
    pub tool_mass: f64,
    pub com_from_flange: [f64; 3],
    pub tool_inertia: [f64; 6],
    pub tcp_from_flange: [f64; 3],
    pub z_axis: [f64; 3],
    pub y_axis: [f64; 3],
}

impl Numbers {
    /// The checked model in the scalar `T`; `None` where the numbers are no robot.
    pub fn robot<T: Real>(&self) -> Option<Robot<T>> {
        let mut counterbalance = Counterbalance::default();
        for c in self.counterbalance {
            counterbalance.cosine.push(lit(c)).ok()?;
        }
        Robot::new(RobotParameters {
            gravity: vector(&self.gravity),
            joints: self.joints.each_ref().map(|j| JointParameters {
                origin: vector(&j.origin),
                axis: vector(&j.axis),
                limits: j.limits.map(lit),
                max_rate: lit(j.max_rate),
                max_torque: lit(j.max_torque),
                stiffness: lit(j.stiffness),
                damping: lit(j.damping),
                rotor_inertia: lit(j.rotor_inertia),
                mass: lit(j.mass),
                center_of_mass: vector(&j.center_of_mass),
                inertia: inertia(&j.inertia),
            }),
            friction: Friction {
                viscous: vector(&self.viscous),
                coulomb: vector(&self.coulomb),
                smoothing: lit(self.smoothing),
            },
            counterbalance,
            tool: ToolParameters {
                flange_offset: vector(&self.flange_offset),
                mass: lit(self.tool_mass),
                com_from_flange: vector(&self.com_from_flange),
                inertia: inertia(&self.tool_inertia),
                tcp_from_flange: vector(&self.tcp_from_flange),
                z_axis: vector(&self.z_axis),
                y_axis: vector(&self.y_axis),
            },
        })
        .ok()
    }
}

fn vector<T: Real, const N: usize>(v: &[f64; N]) -> SVector<T, N> {
    SVector::from(v.map(lit::<T>))
}

fn inertia<T: Real>([xx, yy, zz, xy, xz, yz]: &[f64; 6]) -> Matrix3<T> {
    Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz).map(lit)
}

/// Where the tool is to be in cycle `k`, `b_from_t`: a vertical tool on its way along +y of B.
pub fn nominal<T: Real>(k: usize) -> Pose<T> {
    let z = -Vector3::z();
    let x = Vector3::y();
    let y = lit::<T>(FEED * PERIOD * k as f64);
    Pose {
        rotation: Matrix3::from_columns(&[x, z.cross(&x), z]),
        position: Vector3::new(lit(1.7), y, lit(0.5)),
    }
}

/// The law under test: external force control with the elastostatic compensation.
pub type Law<T> = Compensated<T, External<T>, Elastostatic<T>>;

/// External control with a law.
pub fn controller<T: Real, C: Compensator<T>>(law: C) -> Compensated<T, External<T>, C> {
    let position = JointGains {
        kp: vector(&[4.0e6, 4.0e6, 2.5e6, 2.0e5, 2.0e5, 1.0e5]),
        ki: vector(&[1.0e7, 1.0e7, 6.0e6, 5.0e5, 5.0e5, 2.5e5]),
        kd: vector(&[3.0e5, 3.0e5, 1.5e5, 1.0e4, 1.0e4, 5.0e3]),
    };
    let force = ExternalGains {
        kp: lit(1e-8),
        ki: lit(2e-8),
        kd: T::zero(),
        material_stiffness: lit(30e6),
        tuned_stiffness: lit(5e6),
        max_correction: lit(0.020),
        max_rate: lit(0.020),
    };
    let [lateral, orientation] = [0.010, 0.020].map(|most| LoopLimits {
        bandwidth: lit(12.0),
        size: lit(most),
        rate: lit(most),
    });
    let period = lit(PERIOD);
    let external = External::new(position, force, period);
    // The drives' part of the check is made every period; drives that follow at once bear no weld.
    let limits = ForceSensorLimits { moment: lit(5e3), force: lit(30e3), disagreement: lit(1e9) };
    Compensated::new(external, law, lateral, orientation, period).with_force_sensor_limits(limits)
}

/// What one control cycle is given.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<T: Real> {
    /// Where the real tool should be.
    pub nominal: Pose<T>,
    /// The set-point as taught, under gravity alone.
    pub setpoint: Setpoint<T>,
    /// The instruments.
    pub sensed: SensorReadings<T>,
}

/// The robot on its weld.
#[derive(Debug, Clone)]
pub struct Weld<T: Real> {
    /// The robot.
    pub robot: Robot<T>,
    /// Its controller.
    pub law: Law<T>,
    encoder: JointVector<T>,
    rate: JointVector<T>,
    torque: JointVector<T>,
}

impl<T: Real> Weld<T> {
    /// At rest on the start of the weld under the full load; `start`: joint angles near it, rad.
    /// `None` where the numbers are no robot or the weld is out of reach.
    pub fn new(numbers: &Numbers, start: &[f64; JOINTS]) -> Option<Self> {
        let robot = numbers.robot()?;
        let link = robot.inverse_near(&nominal(0), &vector(start)).ok()?;
        let encoder = robot.fake_target(&link, &Wrench::zero());
        let frames = robot.frames(&encoder);
        let torque =
            robot.spring_torque_at_rest(&frames, &encoder, &load(0).rotated(&frames.tcp.rotation));
        let elastostatic = Elastostatic::new(&ElastostaticGains::default(), lit(PERIOD)).ok()?;
        let mut law = controller(elastostatic);
        law.start(&robot, &encoder, &torque);
        Some(Self { robot, law, encoder, rate: JointVector::zeros(), torque })
    }

    /// What cycle `k` is given; `None` where the weld is out of reach.
    pub fn inputs(&self, k: usize) -> Option<Inputs<T>> {
        let nominal = nominal(k);
        let link = self.robot.inverse_near(&nominal, &self.encoder).ok()?;
        let pose = self.robot.forward_kinematics(&self.robot.fake_target(&link, &Wrench::zero()));
        Some(Inputs {
            nominal,
            setpoint: Setpoint {
                pose,
                b_from_w: nominal.rotation,
                force: Some(lit(-LOAD[2])),
                spindle_speed: lit(SPINDLE),
            },
            sensed: SensorReadings {
                encoder: self.encoder,
                encoder_rate: self.rate,
                motor_torque: self.torque,
                wrench: load(k),
            },
        })
    }

    /// The drives go three tenths of the way to the corrected set-point in a period; `None` where
    /// it is out of reach.
    pub fn follow(
        &mut self,
        inputs: &Inputs<T>,
        command: &DriveCommand<T>,
        mut correction: Twist<T>,
    ) -> Option<()> {
        correction.linear.z += command.depth_correction;
        let target = inputs.setpoint.pose.displaced(&correction.rotated(&inputs.setpoint.b_from_w));
        let way =
            (self.robot.inverse_near(&target, &self.encoder).ok()? - self.encoder) * lit::<T>(0.3);
        self.encoder += way;
        self.rate = way / lit::<T>(PERIOD);
        self.torque = command.torque;
        Some(())
    }
}

/// The watch beside the law, in `f32` whatever the law runs in.
pub fn watch<T: Real + Into<f64>>(
    monitor: &mut HealthMonitor,
    inputs: &Inputs<T>,
) -> HealthSignals {
    monitor.watch(&inputs.setpoint, &inputs.sensed)
}

/// The load of cycle `k` on the tool, with a ripple of up to 100 N on its push.
fn load<T: Real>(k: usize) -> Wrench<T> {
    let ripple = Vector3::z() * lit::<T>(50.0 * ((k % 5) as f64 - 2.0));
    Wrench { moment: Vector3::zeros(), force: vector(&LOAD) + ripple }
}
