//! An arm at rest under loads, its motors held: the links in quasi-static equilibrium.
//!
//! Equation (2.1), link side, of the plant's own robot, solved by a damped Newton method that no
//! comparison uses. The internal states of effects (hysteresis) follow the load's path.

use crate::motion::Motor;
use nalgebra::{Matrix6, SVector, Vector3};
use trueweld_core::{Frames, JOINTS, JointVector, Pose, Wrench};
use trueweld_plant::cell::Cell;
use trueweld_plant::robot::{Drives, INTERNAL_STATES};

/// No equilibrium was found, or a motion left the finite numbers.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the links find no rest, or the motion diverges, at {time:.3} s")]
pub struct Unsettled {
    /// Time in the log, s.
    pub time: f64,
}

/// A load hung on or pressed against the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AppliedLoad {
    /// At the TCP, in T: what the force sensor sees.
    pub wrench_in_t: Wrench<f64>,
    /// Mass hung on the flange, kg.
    pub payload: f64,
    /// Its centre from the flange, in the last link's frame, m.
    pub center: Vector3<f64>,
}

impl AppliedLoad {
    pub(crate) fn none() -> Self {
        Self { wrench_in_t: Wrench::zero(), payload: 0.0, center: Vector3::zeros() }
    }

    fn towards(&self, other: &Self, share: f64) -> Self {
        let mix = |a: Vector3<f64>, b: Vector3<f64>| a + (b - a) * share;
        Self {
            wrench_in_t: Wrench {
                moment: mix(self.wrench_in_t.moment, other.wrench_in_t.moment),
                force: mix(self.wrench_in_t.force, other.wrench_in_t.force),
            },
            payload: self.payload + (other.payload - self.payload) * share,
            // What hangs there does not slide: the centre is that of whichever load has a mass.
            center: if other.payload > 0.0 { other.center } else { self.center },
        }
    }

    /// Both together at the TCP in axes of B.
    fn wrench(&self, cell: &Cell, frames: &Frames<f64>) -> Wrench<f64> {
        let mut wrench = self.wrench_in_t.rotated(&frames.tcp.rotation);
        let parameters = cell.robot.model.parameters();
        let weight = parameters.gravity * self.payload;
        let last = JOINTS - 1;
        let hangs = frames.origin[last]
            + frames.rotation[last] * (parameters.tool.flange_offset + self.center);
        wrench.force += weight;
        wrench.moment += (hangs - frames.tcp.position).cross(&weight);
        wrench
    }
}

/// Share of K that holds the links where they come from: what the dampers do in a slow motion. A
/// link that hangs free in a gap stays at the end that it was left at; elsewhere it shifts an
/// equilibrium by picometres a micrometre.
const HOLDING_STIFFNESS_SHARE: f64 = 1e-6;

/// Share of a joint's largest torque with which a link presses on when its motor stops: enough to
/// cross a gap.
const ARRIVES: f64 = 0.002;

/// Links between motors that turn evenly, or are at rest, and a load.
struct LinkBalance<'a, C, W> {
    cell: &'a Cell,
    motor: &'a Motor,
    /// Where the links come from, rad.
    near: &'a JointVector<f64>,
    /// A torque that presses on the links, N·m.
    pushed: &'a JointVector<f64>,
    /// Time in the log, s.
    time: f64,
    /// τ_s with what the link ports add, N·m.
    carried: C,
    /// The load at the TCP in axes of B.
    wrench: W,
}

impl<C, W> LinkBalance<'_, C, W>
where
    C: Fn(&Drives) -> JointVector<f64>,
    W: Fn(&Frames<f64>) -> Wrench<f64>,
{
    /// Link angles at which all is in balance, rad.
    fn solve(&self) -> Result<JointVector<f64>, Unsettled> {
        const SLOPE_STEP_OF_BALANCE: f64 = 1e-8;
        // In units in which every spring is 1.
        let unit = self.cell.robot.model.stiffness().map(f64::sqrt);
        let mut at = (self.near - self.motor.angle).component_mul(&unit);
        let mut rest = self.left(&unit, &at);
        let mut damping = 1e-8;
        for _ in 0..2000 {
            let slope = Matrix6::from_columns(&std::array::from_fn::<_, JOINTS, _>(|i| {
                let mut by = JointVector::zeros();
                by[i] = SLOPE_STEP_OF_BALANCE * unit[i];
                (self.left(&unit, &(at + by)) - self.left(&unit, &(at - by))) / (2.0 * by[i])
            }));
            let (normal, descent) = (slope.tr_mul(&slope), slope.tr_mul(&rest));
            let step = loop {
                let damped = normal + Matrix6::from_diagonal_element(damping);
                let step = -damped.cholesky().ok_or(Unsettled { time: self.time })?.solve(&descent);
                let there = self.left(&unit, &(at + step));
                // Gaps and turning points change the slope: only a step that leads down is taken.
                if there.norm() <= rest.norm() {
                    (at, rest) = (at + step, there);
                    break step;
                }
                if step.component_div(&unit).amax() < 1e-13 || !step.sum().is_finite() {
                    break step;
                }
                damping *= 10.0;
            };
            if step.component_div(&unit).amax() < 1e-12 || rest.component_div(&unit).amax() < 1e-12
            {
                return Ok(at.component_div(&unit) + self.motor.angle);
            }
            damping = (damping * 0.1).max(1e-14);
        }
        Err(Unsettled { time: self.time })
    }

    /// Torque that is out of balance, over `unit`, at a torsion times `unit`.
    fn left(&self, unit: &JointVector<f64>, scaled: &JointVector<f64>) -> JointVector<f64> {
        let Self { cell, motor, near, pushed, time, carried, wrench } = self;
        let robot = &cell.robot;
        let link = scaled.component_div(unit) + motor.angle;
        let drives =
            Drives { link, link_rate: motor.rate, motor: motor.angle, motor_rate: motor.rate };
        let load = wrench(&robot.model.frames(&link));
        let frames = robot.frames(&link, &load, *time);
        let (_, bias) = robot.model.equation_of_motion(&frames, &motor.rate, &load);
        let held = robot.model.stiffness().component_mul(&(link - *near)) * HOLDING_STIFFNESS_SHARE;
        (carried(&drives) + *pushed - bias - held).component_div(unit)
    }
}

/// Torque of springs and link ports on the links, N·m, with what effects remember.
fn on_links(cell: &Cell, drives: &Drives, internal: &[f64]) -> JointVector<f64> {
    cell.robot.spring_torque(drives, internal) + cell.robot.link_torque(drives, internal)
}

/// The torque with which links press on in a direction.
fn pressing(cell: &Cell, direction: &JointVector<f64>) -> JointVector<f64> {
    let sign = |v: f64| if v == 0.0 { 0.0 } else { v.signum() };
    JointVector::from_fn(|i, _| {
        ARRIVES * cell.robot.model.parameters().joints[i].max_torque * sign(direction[i])
    })
}

/// Unloaded links in balance with their motors, effects' own states at zero, after the links
/// pressed in a direction.
pub(crate) fn settled(
    cell: &Cell,
    motor: &Motor,
    direction: &JointVector<f64>,
) -> Result<JointVector<f64>, Unsettled> {
    let carried = |drives: &Drives| on_links(cell, drives, &[0.0; INTERNAL_STATES]);
    let unloaded = |_: &Frames<f64>| Wrench::zero();
    let (near, pushed) = (&motor.angle, &pressing(cell, direction));
    let pressing = LinkBalance { cell, motor, near, pushed, time: 0.0, carried, wrench: unloaded };
    let (near, pushed) = (&pressing.solve()?, &JointVector::zeros());
    LinkBalance { near, pushed, ..pressing }.solve()
}

fn at_rest(angle: &JointVector<f64>) -> Motor {
    Motor { angle: *angle, rate: JointVector::zeros(), acceleration: JointVector::zeros() }
}

/// An arm that stands, led slowly from one load and posture to the next.
#[derive(Debug)]
pub(crate) struct StaticArm<'a> {
    cell: &'a Cell,
    motor: JointVector<f64>,
    load: AppliedLoad,
    link: JointVector<f64>,
    internal: [f64; INTERNAL_STATES],
    /// True where the way matters.
    remembers: bool,
}

impl<'a> StaticArm<'a> {
    /// At rest, unloaded, effects' own states at zero, having come from angles of 0.
    pub(crate) fn new(cell: &'a Cell, motor: &JointVector<f64>) -> Result<Self, Unsettled> {
        let internal = [0.0; INTERNAL_STATES];
        let load = AppliedLoad::none();
        let link = settled(cell, &at_rest(motor), motor)?;
        let remembers = cell.robot.ports.memories() > 0;
        Ok(Self { cell, motor: *motor, load, link, internal, remembers })
    }

    /// Leads it evenly to another posture or load, reached at `time`, s.
    pub(crate) fn lead(
        &mut self,
        motor: &JointVector<f64>,
        load: &AppliedLoad,
        time: f64,
    ) -> Result<(), Unsettled> {
        let (motor_before, load_before) = (self.motor, self.load);
        let moves = motor != &motor_before;
        let steps = match (self.remembers, moves) {
            (false, false) => 1,
            (false, true) => 2,
            (true, false) => 10,
            (true, true) => 40,
        };
        for k in 1..=steps {
            let share = k as f64 / steps as f64;
            let there = motor_before + (motor - motor_before) * share;
            let between = load_before.towards(load, share);
            if moves && k == steps {
                // The motor stops, and the link presses on.
                self.step(&there, &between, &pressing(self.cell, &(motor - motor_before)), time)?;
            }
            self.step(&there, &between, &JointVector::zeros(), time)?;
        }
        self.load = *load;
        Ok(())
    }

    fn step(
        &mut self,
        motor: &JointVector<f64>,
        load: &AppliedLoad,
        pushed: &JointVector<f64>,
        time: f64,
    ) -> Result<(), Unsettled> {
        let carried = |drives: &Drives| on_links(self.cell, drives, &self.carried_along(drives));
        // The link goes along with its motor: from there the springs only have to take up the
        // change of load.
        let near = self.link + (motor - self.motor);
        let wrench = |frames: &Frames<f64>| load.wrench(self.cell, frames);
        let (cell, near, at_rest) = (self.cell, &near, &at_rest(motor));
        let balance = LinkBalance { cell, motor: at_rest, near, pushed, time, carried, wrench };
        let link = balance.solve()?;
        let drives = Drives { link, link_rate: link * 0.0, motor: *motor, motor_rate: link * 0.0 };
        self.internal = self.carried_along(&drives);
        (self.motor, self.link) = (*motor, link);
        Ok(())
    }

    /// Effects' own states after the twists have gone evenly from here to those of `to`.
    fn carried_along(&self, to: &Drives) -> [f64; INTERNAL_STATES] {
        /// Parts of a way, at least; over each a state takes a step that is not larger than itself.
        const WAY_PARTS_MIN: f64 = 4.0;
        let mut state = SVector::from(self.internal);
        if !self.remembers {
            return self.internal;
        }
        let way = Drives {
            link: to.link,
            link_rate: to.link - self.link,
            motor: to.motor,
            motor_rate: to.motor - self.motor,
        };
        let slope = |state: &SVector<f64, INTERNAL_STATES>| {
            let mut rates = [0.0; INTERNAL_STATES];
            self.cell.robot.internal_rates(&way, state.as_slice(), &mut rates);
            SVector::from(rates)
        };
        let steepest = (slope(&state) - slope(&state.add_scalar(1.0))).amax();
        let parts = WAY_PARTS_MIN.max(steepest.ceil());
        for _ in 0..parts as usize {
            state += runge_kutta(&state, 1.0 / parts, |_, s| slope(s));
        }
        state.into()
    }

    /// Where the tool is at a time, s.
    pub(crate) fn pose(&self, time: f64) -> Pose<f64> {
        let robot = &self.cell.robot;
        let wrench = self.load.wrench(self.cell, &robot.model.frames(&self.link));
        robot.frames(&self.link, &wrench, time).tcp
    }

    /// Where the links are, rad.
    pub(crate) fn link(&self) -> &JointVector<f64> {
        &self.link
    }
}

/// Change over one step of the classical fourth-order scheme; `slope` takes the time since the
/// step's start.
pub(crate) fn runge_kutta<const N: usize>(
    y: &SVector<f64, N>,
    h: f64,
    slope: impl Fn(f64, &SVector<f64, N>) -> SVector<f64, N>,
) -> SVector<f64, N> {
    let k1 = slope(0.0, y);
    let k2 = slope(0.5 * h, &(y + k1 * (0.5 * h)));
    let k3 = slope(0.5 * h, &(y + k2 * (0.5 * h)));
    let k4 = slope(h, &(y + k3 * h));
    (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0)
}
