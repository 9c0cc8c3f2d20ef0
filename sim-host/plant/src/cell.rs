//! The cell: elastic robot and process joined at the tool, as one first-order system of
//! differential equations.
//!
//! The process acts on the real tool pose, never on the encoders'. Who turns the motors is not
//! known here.

use crate::effects::{Effect, EffectError};
use crate::input::Process;
use crate::process::{Reaction, reaction_with_trail};
use crate::robot::{Drives, ElasticRobot, INTERNAL_STATES, TooManyStates};
use crate::seam::Seam;
use nalgebra::{Matrix3, Matrix3x6, Matrix6, SVector, Vector3};
use trueweld_core::ldlt::Ldlt;
use trueweld_core::{Frames, JointVector, Robot, Wrench};

/// Iterations in which tilting frames and the contact agree on the force.
const FRAME_ITERATIONS: usize = 30;

/// Force to which they agree, N: a billionth of a weld's.
const FRAME_TOLERANCE: f64 = 1e-5;

/// Force that frame and contact may be apart by when the iterations are used up, N: where it is more
/// they have no common place, and nobody knows the force.
const FRAME_RESIDUAL_MAX: f64 = 1.0;

/// Time over which the rate at which bearings and base give is taken, s: far below any swing of the arm.
const GIVE_TIME: f64 = 5e-3;

/// Force by which what they give to it is told, N.
const PROBING_FORCE: f64 = 1e3;

/// Length of the state vector.
pub const STATES: usize = GIVEN + 3;

/// Where in the state a process keeps its trail, the last of what effects keep.
const TRAIL: usize = GIVEN - 1;

/// Where in the state stands by how much bearings and base had given.
const GIVEN: usize = 26 + INTERNAL_STATES;

/// What a cell's state holds, or how fast it changes.
pub type StateVector = SVector<f64, STATES>;

/// The cell's state: angles and rates on both sides of the gears, the channel behind the tool, the
/// spindle, and what effects keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State(pub StateVector);

impl State {
    /// Everything at rest at these angles. `channel`: y_m, m.
    pub fn at_rest(link: &JointVector<f64>, motor: &JointVector<f64>, channel: f64) -> Self {
        let mut state = SVector::<f64, STATES>::zeros();
        state.fixed_rows_mut::<6>(0).copy_from(link);
        state.fixed_rows_mut::<6>(6).copy_from(motor);
        state[24] = channel;
        Self(state)
    }

    /// Angles and rates of links and motors.
    #[inline]
    pub fn drives(&self) -> Drives {
        let six = |first| self.0.fixed_rows::<6>(first).into_owned();
        Drives { link: six(0), motor: six(6), link_rate: six(12), motor_rate: six(18) }
    }

    /// Lateral position y_m of the plastic channel left behind the tool, in W, m.
    pub fn channel(&self) -> f64 {
        self.0[24]
    }

    /// Spindle angle φ, rad.
    pub fn spindle_angle(&self) -> f64 {
        self.0[25]
    }

    /// States that effects keep.
    pub fn internal(&self) -> &[f64] {
        &self.0.as_slice()[26..GIVEN]
    }

    /// By how much bearings and base had given at the tool, axes of B, m: it follows what they give
    /// within [`GIVE_TIME`].
    fn given(&self) -> Vector3<f64> {
        self.0.fixed_rows::<3>(GIVEN).into_owned()
    }

    /// Path position x_m of what the tool left behind, m: of a process that keeps it, in the last
    /// of the effects' places.
    fn trail(&self) -> f64 {
        self.0[TRAIL]
    }
}

/// Robot and process.
#[derive(Debug)]
pub struct Cell {
    /// The elastic robot.
    pub robot: ElasticRobot,
    /// The welding process.
    pub process: Process,
    /// The seam as it really lies.
    pub seam: Seam,
}

/// The tool in the material.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    /// Frames of the real arm.
    pub frames: Frames<f64>,
    /// What the process does to the tool, in axes of W where the tool is.
    pub reaction: Reaction,
    /// These axes in B.
    pub axes: Matrix3<f64>,
    /// Rate at which bearings and base give at the tool, axes of B, m/s.
    give_rate: Vector3<f64>,
}

impl Contact {
    /// The process' force as a wrench at the TCP in axes of B.
    pub fn wrench(&self) -> Wrench<f64> {
        wrench(&self.axes, &self.reaction.force)
    }
}

fn wrench(axes: &Matrix3<f64>, force_w: &Vector3<f64>) -> Wrench<f64> {
    Wrench { moment: Vector3::zeros(), force: axes * force_w }
}

/// The right-hand side at one state, with what it was made of.
#[derive(Debug, Clone, Copy)]
pub struct Evaluation {
    /// Time derivative of the state with the motors' torque left out.
    pub rates: StateVector,
    /// Frames of the real arm.
    pub frames: Frames<f64>,
    /// Inertia matrix of the links.
    pub inertia: Matrix6<f64>,
    /// Its factors; `None` where the state is not finite.
    pub factor: Option<Ldlt<f64>>,
    /// Slope of motor friction by θ̇_E, N·m·s/rad.
    pub friction_slope: JointVector<f64>,
    /// What the process does to the tool, in axes of W where the tool is.
    pub reaction: Reaction,
    /// These axes in B.
    pub axes: Matrix3<f64>,
}

impl Cell {
    /// The cell of a robot with the effects it has, a process, and the seam it welds.
    ///
    /// # Errors
    /// [`EffectError`] where an effect cannot be installed.
    pub fn new(
        model: &Robot<f64>,
        effects: &[Effect],
        process: &Process,
        seam: impl Into<Seam>,
    ) -> Result<Self, EffectError> {
        let mut process = process.clone();
        let robot = ElasticRobot::with_effects(model, effects, Some(&mut process))?;
        if process.keeps_trail() && robot.ports.memories() == INTERNAL_STATES {
            return Err(TooManyStates.into());
        }
        Ok(Self { robot, process, seam: seam.into() })
    }

    /// Everything at rest at these angles, with what the tool leaves behind where it stands.
    pub(crate) fn at_rest(&self, link: &JointVector<f64>, motor: &JointVector<f64>) -> State {
        let position = self.robot.model.forward_kinematics(link).position;
        let mut state = State::at_rest(link, motor, self.seam.across(&position));
        if self.process.keeps_trail() {
            state.0[TRAIL] = self.seam.place(&position).position.x;
        }
        state
    }

    /// Frames of the real arm and the process' reaction on its tool, whose force is NaN where what
    /// gives under it finds no place.
    #[inline]
    pub fn contact(&self, time: f64, state: &State, drives: &Drives) -> Contact {
        self.contact_giving(time, state, drives, GIVE_TIME.recip())
    }

    /// The same where nothing gives any more than it has.
    pub(crate) fn standing_contact(&self, state: &State, drives: &Drives) -> Contact {
        self.contact_giving(0.0, state, drives, 0.0)
    }

    /// A state whose bearings and base have given what they give to where it is.
    pub fn settled(&self, mut state: State) -> State {
        let drives = state.drives();
        let contact = self.standing_contact(&state, &drives);
        let rigid = self.robot.model.forward_kinematics(&drives.link);
        let given = contact.frames.tcp.position - rigid.position;
        state.0.fixed_rows_mut::<3>(GIVEN).copy_from(&given);
        state
    }

    /// Of bearings and base that give at so much a second of what they have yet to.
    #[inline]
    fn contact_giving(&self, time: f64, state: &State, drives: &Drives, speed: f64) -> Contact {
        let rigid = self.robot.model.frames(&drives.link);
        let none = Vector3::zeros();
        if !self.robot.ports.frames_give() {
            return self.contact_at(time, state, drives, rigid, -state.given() * speed);
        }
        let first = self.contact_at(time, state, drives, rigid, none);
        // Bearings and base give under the force, and the force depends on where they give to, and how
        // fast. Newton's method, with what they give in proportion to the force.
        let given = |axes: &Matrix3<f64>, force: &Vector3<f64>| {
            let frames = self.robot.frames(&drives.link, &wrench(axes, force), time);
            (frames, frames.tcp.position - rigid.tcp.position)
        };
        let idle = given(&first.axes, &none).1;
        let compliance = Matrix3::from_columns(&[0, 1, 2].map(|axis| {
            let probing = Vector3::ith(axis, PROBING_FORCE);
            first.axes.tr_mul(&(given(&first.axes, &probing).1 - idle)) / PROBING_FORCE
        }));
        let (mut contact, mut force, mut left) = (first, first.reaction.force, f64::INFINITY);
        let mut step = force;
        for _ in 0..FRAME_ITERATIONS {
            let (frames, by) = given(&contact.axes, &force);
            let rate = (by - state.given()) * speed;
            contact = self.contact_at(time, state, drives, frames, rate);
            let residual = contact.reaction.force - force;
            if residual.amax() < FRAME_TOLERANCE {
                return contact;
            }
            // Where the force bends, a step too long is taken back by half.
            if residual.amax() > left {
                step *= 0.5;
                force -= step;
                continue;
            }
            left = residual.amax();
            let Reaction { stiffness, damping, .. } = contact.reaction;
            let slope = Matrix3::identity() + (stiffness + damping * speed) * compliance;
            step = slope.lu().solve(&residual).unwrap_or(residual);
            force += step;
        }
        if left > FRAME_RESIDUAL_MAX {
            contact.reaction.force.fill(f64::NAN);
        }
        contact
    }

    /// The same where the frames are known, and how fast they give.
    fn contact_at(
        &self,
        time: f64,
        state: &State,
        drives: &Drives,
        frames: Frames<f64>,
        give_rate: Vector3<f64>,
    ) -> Contact {
        let placed = self.seam.place(&frames.tcp.position);
        let velocity = frames.twist(&drives.link_rate).linear + give_rate;
        let velocity = placed.axes.transpose() * velocity;
        let trail = self.process.keeps_trail().then(|| state.trail());
        let reaction = reaction_with_trail(
            &self.process,
            &self.robot.ports,
            time,
            (&placed.position, &velocity),
            (state.channel(), trail),
            state.spindle_angle(),
        );
        Contact { frames, reaction, axes: placed.axes, give_rate }
    }

    /// The right-hand side of (2.1) and of the process at a state, but for the motors' torque: see
    /// [`driven`](Self::driven).
    ///
    /// Where the state is not finite the rates are NaN, and whoever integrates sees it.
    #[inline]
    pub fn evaluate(&self, time: f64, state: &State) -> Evaluation {
        let drives = state.drives();
        let contact = self.contact(time, state, &drives);
        let spring = self.robot.spring_torque(&drives, state.internal());
        let solved = self.robot.link_acceleration(
            &contact.frames,
            (&drives, state.internal()),
            &spring,
            &contact.wrench(),
        );
        let (acceleration, inertia, factor) = match solved {
            Some((acceleration, inertia, factor)) => (acceleration, inertia, Some(factor)),
            None => (JointVector::from_element(f64::NAN), Matrix6::zeros(), None),
        };
        let (rates, friction_slope) =
            self.rates(time, state, &drives, &spring, &acceleration, &contact);
        let Contact { frames, reaction, axes, .. } = contact;
        Evaluation { rates, frames, inertia, factor, friction_slope, reaction, axes }
    }

    /// The rates of [`evaluate`](Self::evaluate) within a step from a state whose evaluation is `near`:
    /// see [`ElasticRobot::link_acceleration_near`].
    #[inline]
    pub fn rates_near(&self, time: f64, state: &State, near: &Evaluation) -> Option<StateVector> {
        let drives = state.drives();
        let contact = self.contact(time, state, &drives);
        let spring = self.robot.spring_torque(&drives, state.internal());
        let before = near.rates.fixed_rows::<6>(12).into_owned();
        let acceleration = self.robot.link_acceleration_near(
            &contact.frames,
            (&drives, state.internal()),
            &spring,
            &contact.wrench(),
            (&before, near.factor.as_ref()?),
        );
        Some(self.rates(time, state, &drives, &spring, &acceleration, &contact).0)
    }

    /// Rates of the whole state, and the slope of motor friction.
    #[inline]
    fn rates(
        &self,
        time: f64,
        state: &State,
        drives: &Drives,
        spring: &JointVector<f64>,
        acceleration: &JointVector<f64>,
        contact: &Contact,
    ) -> (StateVector, JointVector<f64>) {
        let mut friction_slope = JointVector::zeros();
        let mut rates = SVector::<f64, STATES>::zeros();
        for i in 0..6 {
            let friction = self.robot.friction(drives, i, spring[i], state.internal(), time);
            friction_slope[i] = friction.slope;
            rates[i] = drives.link_rate[i];
            rates[6 + i] = drives.motor_rate[i];
            rates[12 + i] = acceleration[i];
            rates[18 + i] = -(spring[i] + friction.value) / self.robot.model.rotor_inertia()[i];
        }
        let Contact { reaction, give_rate, .. } = contact;
        rates[24] = reaction.channel_rate;
        rates[25] = self.process.spindle;
        self.robot.internal_rates(drives, state.internal(), &mut rates.as_mut_slice()[26..GIVEN]);
        if self.process.keeps_trail() {
            rates[TRAIL] = reaction.trail_rate;
        }
        rates.fixed_rows_mut::<3>(GIVEN).copy_from(give_rate);
        (rates, friction_slope)
    }

    /// Time derivative of the state under motor torque Γ, N·m, from its rates without.
    #[inline]
    pub fn driven(&self, mut rates: StateVector, torque: &JointVector<f64>) -> StateVector {
        for i in 0..6 {
            rates[18 + i] += torque[i] / self.robot.model.rotor_inertia()[i];
        }
        rates
    }
}

impl Evaluation {
    /// The process' wrench on the tool, at the TCP in axes of B.
    pub fn wrench(&self) -> Wrench<f64> {
        wrench(&self.axes, &self.reaction.force)
    }

    /// The same in axes of the real tool frame T, where the sensor sits.
    pub fn wrench_in_t(&self) -> Wrench<f64> {
        self.wrench().rotated(&self.frames.tcp.rotation.transpose())
    }

    /// The tool's velocity in W for joint rates: rows 4 to 6 of J, turned into axes of W.
    #[inline]
    pub fn tool_jacobian_w(&self) -> Matrix3x6<f64> {
        self.axes.transpose() * self.frames.jacobian().0.fixed_rows::<3>(3)
    }
}
