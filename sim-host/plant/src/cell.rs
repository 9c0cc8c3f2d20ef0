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

/// Length of the state vector.
pub const STATES: usize = 26 + INTERNAL_STATES;

/// Where in the state a process keeps its trail.
const TRAIL: usize = STATES - 1;

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
        &self.0.as_slice()[26..]
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
        let first = self.contact_at(time, state, drives, self.robot.model.frames(&drives.link));
        if !self.robot.ports.frames_give() {
            return first;
        }
        // Bearings and base give under the force, and the force depends on where they give to. The
        // contact can be stiffer than they are, where the plain fixed point diverges: Aitken's
        // relaxation.
        let mut force = first.reaction.force;
        let mut contact = first;
        let mut relaxation = 0.5;
        let mut before: Option<Vector3<f64>> = None;
        for _ in 0..FRAME_ITERATIONS {
            let load = wrench(&contact.axes, &force);
            let frames = self.robot.frames(&drives.link, &load, time);
            contact = self.contact_at(time, state, drives, frames);
            let residual = contact.reaction.force - force;
            if residual.amax() < FRAME_TOLERANCE {
                return contact;
            }
            if let Some(before) = before {
                let change = residual - before;
                relaxation *= -before.dot(&change) / change.norm_squared();
            }
            force += residual * relaxation;
            before = Some(residual);
        }
        if before.is_some_and(|residual| residual.amax() > FRAME_RESIDUAL_MAX) {
            contact.reaction.force.fill(f64::NAN);
        }
        contact
    }

    /// The same where the frames are known.
    fn contact_at(
        &self,
        time: f64,
        state: &State,
        drives: &Drives,
        frames: Frames<f64>,
    ) -> Contact {
        let placed = self.seam.place(&frames.tcp.position);
        let velocity = placed.axes.transpose() * frames.twist(&drives.link_rate).linear;
        let trail = self.process.keeps_trail().then(|| state.trail());
        let reaction = reaction_with_trail(
            &self.process,
            &self.robot.ports,
            time,
            (&placed.position, &velocity),
            (state.channel(), trail),
            state.spindle_angle(),
        );
        Contact { frames, reaction, axes: placed.axes }
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
            self.rates(time, state, &drives, &spring, &acceleration, &contact.reaction);
        let Contact { frames, reaction, axes } = contact;
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
        Some(self.rates(time, state, &drives, &spring, &acceleration, &contact.reaction).0)
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
        reaction: &Reaction,
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
        rates[24] = reaction.channel_rate;
        rates[25] = self.process.spindle;
        self.robot.internal_rates(drives, state.internal(), &mut rates.as_mut_slice()[26..]);
        if self.process.keeps_trail() {
            rates[TRAIL] = reaction.trail_rate;
        }
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
