//! The links of an arm whose motors are where they are put: quasi-statically under loads, and in
//! motion.
//!
//! Equation (2.1), link side, asked of the plant's own robot. Reached by ways that no comparison
//! takes: equilibria by a descent of its own that carries a hysteresis' history along, motion by
//! Runge–Kutta at steps far below the fastest mode.

use super::motion::{Motor, Path};
use super::stranger::OutOfLibrary;
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
pub(super) struct Load {
    /// At the TCP, in T: what the force sensor sees.
    pub wrench_in_t: Wrench<f64>,
    /// Mass hung on the flange, kg.
    pub payload: f64,
    /// Its centre from the flange, in the last link's frame, m.
    pub center: Vector3<f64>,
}

impl Load {
    pub fn none() -> Self {
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
const HELD: f64 = 1e-6;

/// Share of a joint's largest torque with which a link presses on when its motor stops: enough to
/// cross a gap.
const ARRIVES: f64 = 0.002;

/// Link angles that balance motors turning evenly (or at rest) and a torque `pushed` on the links,
/// coming from `near`. `spring` gives τ_s, `wrench` the load.
fn balanced(
    cell: &Cell,
    motor: &Motor,
    near: &JointVector<f64>,
    pushed: &JointVector<f64>,
    time: f64,
    spring: impl Fn(&Drives) -> JointVector<f64>,
    wrench: impl Fn(&Frames<f64>) -> Wrench<f64>,
) -> Result<JointVector<f64>, Unsettled> {
    const SLOPE: f64 = 1e-8;
    let robot = &cell.robot;
    // In units in which every spring is 1.
    let unit = robot.model.stiffness().map(f64::sqrt);
    let left = |scaled: &JointVector<f64>| {
        let link = scaled.component_div(&unit) + motor.angle;
        let drives =
            Drives { link, link_rate: motor.rate, motor: motor.angle, motor_rate: motor.rate };
        let load = wrench(&robot.model.frames(&link));
        let frames = robot.frames(&link, &load, time);
        let (_, bias) = robot.model.equation_of_motion(&frames, &motor.rate, &load);
        let held = robot.model.stiffness().component_mul(&(link - near)) * HELD;
        (spring(&drives) + robot.link_torque(&drives) + pushed - bias - held).component_div(&unit)
    };
    let mut at = (near - motor.angle).component_mul(&unit);
    let mut rest = left(&at);
    let mut damping = 1e-8;
    for _ in 0..2000 {
        let slope = Matrix6::from_columns(&std::array::from_fn::<_, JOINTS, _>(|i| {
            let mut by = JointVector::zeros();
            by[i] = SLOPE * unit[i];
            (left(&(at + by)) - left(&(at - by))) / (2.0 * by[i])
        }));
        let (normal, descent) = (slope.tr_mul(&slope), slope.tr_mul(&rest));
        let step = loop {
            let damped = normal + Matrix6::from_diagonal_element(damping);
            let step = -damped.cholesky().ok_or(Unsettled { time })?.solve(&descent);
            let there = left(&(at + step));
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
        if step.component_div(&unit).amax() < 1e-12 || rest.component_div(&unit).amax() < 1e-12 {
            return Ok(at.component_div(&unit) + motor.angle);
        }
        damping = (damping * 0.1).max(1e-14);
    }
    Err(Unsettled { time })
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
fn settled(
    cell: &Cell,
    motor: &Motor,
    direction: &JointVector<f64>,
) -> Result<JointVector<f64>, Unsettled> {
    let spring = |drives: &Drives| cell.robot.spring_torque(drives, &[0.0; INTERNAL_STATES]);
    let unloaded = |_: &Frames<f64>| Wrench::zero();
    let pressed =
        balanced(cell, motor, &motor.angle, &pressing(cell, direction), 0.0, spring, unloaded)?;
    balanced(cell, motor, &pressed, &JointVector::zeros(), 0.0, spring, unloaded)
}

fn at_rest(angle: &JointVector<f64>) -> Motor {
    Motor { angle: *angle, rate: JointVector::zeros(), acceleration: JointVector::zeros() }
}

/// An arm that stands, led slowly from one load and posture to the next.
#[derive(Debug)]
pub(super) struct HeldArm<'a> {
    cell: &'a Cell,
    motor: JointVector<f64>,
    load: Load,
    link: JointVector<f64>,
    internal: [f64; INTERNAL_STATES],
    /// True where the way matters.
    remembers: bool,
}

impl<'a> HeldArm<'a> {
    /// At rest, unloaded, effects' own states at zero, having come from angles of 0.
    pub fn new(cell: &'a Cell, motor: &JointVector<f64>) -> Result<Self, Unsettled> {
        let internal = [0.0; INTERNAL_STATES];
        let load = Load::none();
        let link = settled(cell, &at_rest(motor), motor)?;
        let mut rates = [0.0; INTERNAL_STATES];
        let still = JointVector::zeros();
        let twisting = Drives {
            link: still,
            link_rate: still,
            motor: still,
            motor_rate: JointVector::repeat(1.0),
        };
        cell.robot.internal_rates(&twisting, &internal, &mut rates);
        let remembers = rates.iter().any(|r| *r != 0.0);
        Ok(Self { cell, motor: *motor, load, link, internal, remembers })
    }

    /// Leads it evenly to another posture or load, reached at `time`, s.
    pub fn lead(
        &mut self,
        motor: &JointVector<f64>,
        load: &Load,
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
        load: &Load,
        pushed: &JointVector<f64>,
        time: f64,
    ) -> Result<(), Unsettled> {
        let robot = &self.cell.robot;
        let spring = |drives: &Drives| robot.spring_torque(drives, &self.carried_along(drives));
        // The link goes along with its motor: from there the springs only have to take up the
        // change of load.
        let near = self.link + (motor - self.motor);
        let wrench = |frames: &Frames<f64>| load.wrench(self.cell, frames);
        let link = balanced(self.cell, &at_rest(motor), &near, pushed, time, spring, wrench)?;
        let drives = Drives { link, link_rate: link * 0.0, motor: *motor, motor_rate: link * 0.0 };
        self.internal = self.carried_along(&drives);
        (self.motor, self.link) = (*motor, link);
        Ok(())
    }

    /// Effects' own states after the twists have gone evenly from here to those of `to`.
    fn carried_along(&self, to: &Drives) -> [f64; INTERNAL_STATES] {
        const PARTS: usize = 4;
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
        for _ in 0..PARTS {
            state += runge_kutta(&state, 1.0 / PARTS as f64, |_, s| slope(s));
        }
        state.into()
    }

    /// Where the tool is at a time, s.
    pub fn pose(&self, time: f64) -> Pose<f64> {
        let robot = &self.cell.robot;
        let wrench = self.load.wrench(self.cell, &robot.model.frames(&self.link));
        robot.frames(&self.link, &wrench, time).tcp
    }

    /// Where the links are, rad.
    pub fn link(&self) -> &JointVector<f64> {
        &self.link
    }
}

/// Change over one step of the classical fourth-order scheme; `slope` takes the time since the
/// step's start.
fn runge_kutta<const N: usize>(
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

/// Links, rates, effects' states, and place and velocity of what hangs on the tool.
type Moving = SVector<f64, { 12 + INTERNAL_STATES + 6 }>;

/// Where those of what hangs on the tool begin.
const HUNG: usize = 12 + INTERNAL_STATES;

/// The truth at one instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instant {
    /// Encoders, rad.
    pub motor: JointVector<f64>,
    /// Links, rad.
    pub link: JointVector<f64>,
    /// Motor torque, N·m.
    pub torque: JointVector<f64>,
    /// Tool in B.
    pub pose: Pose<f64>,
    /// What the environment applies to the tool at the TCP, in T.
    pub wrench: Wrench<f64>,
}

/// An arm in motion without contact, its motors on a path.
#[derive(Debug)]
pub(super) struct Follower<'a, P> {
    pub cell: &'a Cell,
    pub stranger: Option<&'a OutOfLibrary>,
    pub path: &'a P,
}

impl<P: Path> Follower<'_, P> {
    /// The truth every `step` s from `start` to `end`, the log's own time being from 0 on: before
    /// it the arm runs in, and what remembers does not yet. It begins in balance at the rate that
    /// its motors have then.
    pub fn run(&self, start: f64, end: f64, step: f64) -> Result<Vec<Instant>, Unsettled> {
        let motor = self.path.at(start);
        // Motors that turn drag their links behind them; before a start from rest they came from
        // angles of 0.
        let came = if motor.rate.amax() > 0.0 { -motor.rate } else { motor.angle };
        let link = settled(self.cell, &motor, &came)?;
        let mut y = Moving::zeros();
        y.fixed_rows_mut::<6>(0).copy_from(&link);
        y.fixed_rows_mut::<6>(6).copy_from(&motor.rate);
        let frames = self.cell.robot.frames(&link, &Wrench::zero(), 0.0);
        y.fixed_rows_mut::<3>(HUNG).copy_from(&frames.tcp.position);
        y.fixed_rows_mut::<3>(HUNG + 3).copy_from(&frames.twist(&motor.rate).linear);

        let count = ((end - start) / step).round() as usize;
        let mut instants = Vec::with_capacity(count + 1);
        for k in 0..=count {
            let time = start + k as f64 * step;
            instants.push(self.instant(time, &y));
            y += runge_kutta(&y, step, |after, y| self.slope(time + after, y));
            if !y.sum().is_finite() {
                return Err(Unsettled { time });
            }
        }
        Ok(instants)
    }

    fn drives(motor: &Motor, y: &Moving) -> Drives {
        Drives {
            link: y.fixed_rows::<6>(0).into_owned(),
            link_rate: y.fixed_rows::<6>(6).into_owned(),
            motor: motor.angle,
            motor_rate: motor.rate,
        }
    }

    /// Frames, and the wrench of what hangs on the tool or shakes it.
    fn frames(&self, time: f64, drives: &Drives, y: &Moving) -> (Frames<f64>, Wrench<f64>) {
        let (robot, clock) = (&self.cell.robot, time.max(0.0));
        let free = robot.frames(&drives.link, &Wrench::zero(), clock);
        let Some(stranger) = self.stranger else {
            return (free, Wrench::zero());
        };
        let mut force = stranger.force(clock);
        if let Some(hung) = stranger.appendage() {
            let away = y.fixed_rows::<3>(HUNG) - free.tcp.position;
            let faster = y.fixed_rows::<3>(HUNG + 3) - free.twist(&drives.link_rate).linear;
            force += away * hung.stiffness + faster * hung.damping;
        }
        let wrench = Wrench { moment: Vector3::zeros(), force };
        (robot.frames(&drives.link, &wrench, clock), wrench)
    }

    fn slope(&self, time: f64, y: &Moving) -> Moving {
        let robot = &self.cell.robot;
        let drives = Self::drives(&self.path.at(time), y);
        let internal = &y.as_slice()[12..HUNG];
        let (frames, wrench) = self.frames(time, &drives, y);
        let spring = robot.spring_torque(&drives, internal);
        let acceleration = robot.link_acceleration(&frames, &drives, &spring, &wrench);
        let mut slope = Moving::zeros();
        slope.fixed_rows_mut::<6>(0).copy_from(&drives.link_rate);
        let nowhere = JointVector::repeat(f64::NAN);
        slope.fixed_rows_mut::<6>(6).copy_from(&acceleration.map_or(nowhere, |(a, _)| a));
        if time >= 0.0 {
            robot.internal_rates(&drives, internal, &mut slope.as_mut_slice()[12..HUNG]);
        }
        if let Some(hung) = self.stranger.and_then(OutOfLibrary::appendage) {
            let velocity = y.fixed_rows::<3>(HUNG + 3).into_owned();
            slope.fixed_rows_mut::<3>(HUNG).copy_from(&velocity);
            slope.fixed_rows_mut::<3>(HUNG + 3).copy_from(&(-wrench.force / hung.mass));
        }
        slope
    }

    fn instant(&self, time: f64, y: &Moving) -> Instant {
        let robot = &self.cell.robot;
        let motor = self.path.at(time);
        let drives = Self::drives(&motor, y);
        let spring = robot.spring_torque(&drives, &y.as_slice()[12..HUNG]);
        let smoothing = robot.model.parameters().friction.smoothing;
        let friction = JointVector::from_fn(|i, _| {
            let fading =
                self.stranger.map_or(0.0, |s| s.friction(i, motor.rate[i], time, smoothing));
            robot.friction(&drives, i).value + fading
        });
        Instant {
            motor: motor.angle,
            link: drives.link,
            torque: robot.model.rotor_inertia().component_mul(&motor.acceleration)
                + spring
                + friction,
            pose: self.frames(time, &drives, y).0.tcp,
            wrench: Wrench::zero(),
        }
    }
}
