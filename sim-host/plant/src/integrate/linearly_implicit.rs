//! The default integrator: a linearly implicit two-stage scheme of second order, made for this system.
//!
//! ROS2 (Verwer, Spee, Blom, Hundsdorfer 1999) with γ = 1 − 1/√2, L-stable:
//!
//! (I − γhA) k₁ = f(u),  (I − γhA) k₂ = f(u + h k₁) − 2 k₁,  u⁺ = u + (3/2) h k₁ + (1/2) h k₂.
//!
//! It keeps its order for any matrix A (a W-method), so A holds what is stiff and no more: springs, dampers, the slope
//! of friction, and the contact. Those couple a motor with its own link only, so that the motors are eliminated joint by
//! joint and each stage solves 6 × 6 instead of 34 × 34. Effects that change a spring keep the baseline's K and D in A.

use crate::cell::{Cell, Evaluation, STATES, State};
use nalgebra::{Const, LU, SVector};
use trueweld_core::JointVector;

/// γ = 1 − 1/√2: the value for which ROS2 is L-stable with the smaller error constant.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

type Vector = SVector<f64, STATES>;

/// I − sA, factored: s = γh.
struct Stage {
    s: f64,
    stiffness: JointVector<f64>,
    /// sD + s²K: what ties a motor to its link.
    tie: JointVector<f64>,
    /// 1 / (I_m + sD + s²K + s τ_f′).
    motor: JointVector<f64>,
    rotor: JointVector<f64>,
    inertia: nalgebra::Matrix6<f64>,
    contact: nalgebra::Matrix6<f64>,
    link: LU<f64, Const<6>, Const<6>>,
}

impl Stage {
    #[inline]
    fn new(cell: &Cell, at: &Evaluation, s: f64) -> Self {
        let model = &cell.robot.model;
        let stiffness = *model.stiffness();
        let tie = model.damping() * s + stiffness * (s * s);
        let motor = (model.rotor_inertia() + tie + at.friction_slope * s).map(f64::recip);
        let contact = cell.in_joints(&at.frames, &at.reaction.stiffness);
        let tangent = at.reaction.damping * s + at.reaction.stiffness * (s * s);
        let mut link = at.inertia + cell.in_joints(&at.frames, &tangent);
        for i in 0..6 {
            link[(i, i)] += tie[i] - tie[i] * tie[i] * motor[i];
        }
        Self { s, stiffness, tie, motor, rotor: *model.rotor_inertia(), inertia: at.inertia, contact, link: link.lu() }
    }

    /// k of (I − sA) k = r; `None` where the matrix is singular (a state that is not finite).
    #[inline]
    fn solve(&self, r: &Vector) -> Option<Vector> {
        let r_link: JointVector<f64> = r.fixed_rows::<6>(0).into_owned();
        let r_motor: JointVector<f64> = r.fixed_rows::<6>(6).into_owned();
        let r_link_rate: JointVector<f64> = r.fixed_rows::<6>(12).into_owned();
        let r_motor_rate: JointVector<f64> = r.fixed_rows::<6>(18).into_owned();
        let spring = self.stiffness.component_mul(&(r_motor - r_link)) * self.s;
        let on_motor = self.rotor.component_mul(&r_motor_rate) - spring;
        let on_link = self.inertia * r_link_rate + spring - self.contact * r_link * self.s
            + self.tie.component_mul(&self.motor).component_mul(&on_motor);
        let link_rate = self.link.solve(&on_link)?;
        let motor_rate = self.motor.component_mul(&(on_motor + self.tie.component_mul(&link_rate)));
        let mut k = *r;
        k.fixed_rows_mut::<6>(0).copy_from(&(r_link + link_rate * self.s));
        k.fixed_rows_mut::<6>(6).copy_from(&(r_motor + motor_rate * self.s));
        k.fixed_rows_mut::<6>(12).copy_from(&link_rate);
        k.fixed_rows_mut::<6>(18).copy_from(&motor_rate);
        Some(k)
    }
}

/// How far friction may depart from its linearisation in one step, as the motor displacement it causes, rad: 1e-9 is two
/// nanometres at the tool.
const FRICTION_DEFECT: f64 = 1e-9;

/// How often a step may be halved where friction turns round.
const HALVINGS: u32 = 4;

/// One step of `h` seconds from `state` at `time`, whose evaluation is `at`, with the motors' torque held. `None` where
/// the state left the finite numbers.
///
/// Where a motor turns round, friction swings from one level to the other over a rate of 1 mrad/s: no straight line
/// follows that, so such a step is halved until one does.
pub fn step(
    cell: &Cell,
    time: f64,
    state: &State,
    at: &Evaluation,
    torque: &JointVector<f64>,
    h: f64,
) -> Option<State> {
    halved(cell, time, state, at, torque, h, HALVINGS)
}

fn halved(
    cell: &Cell,
    time: f64,
    state: &State,
    at: &Evaluation,
    torque: &JointVector<f64>,
    h: f64,
    halvings: u32,
) -> Option<State> {
    let stage = Stage::new(cell, at, GAMMA * h);
    let k1 = stage.solve(&cell.driven(at, torque))?;
    let ahead = State(state.0 + k1 * h);
    let second = cell.evaluate(time + h, &ahead);
    if halvings > 0 && turns_round(cell, state, at, &ahead, &second, h) {
        let half = 0.5 * h;
        let middle = halved(cell, time, state, at, torque, half, halvings - 1)?;
        let at = cell.evaluate(time + half, &middle);
        return halved(cell, time + half, &middle, &at, torque, half, halvings - 1);
    }
    let k2 = stage.solve(&(cell.driven(&second, torque) - k1 * 2.0))?;
    let next = state.0 + k1 * (1.5 * h) + k2 * (0.5 * h);
    next.sum().is_finite().then_some(State(next))
}

/// True where some motor's friction leaves its linearisation by more than [`FRICTION_DEFECT`] within the step.
fn turns_round(cell: &Cell, from: &State, at: &Evaluation, to: &State, ahead: &Evaluation, h: f64) -> bool {
    let rotor = cell.robot.model.rotor_inertia();
    (0..6).any(|i| {
        let change = at.friction_slope[i] * (to.0[18 + i] - from.0[18 + i]);
        let defect = ahead.friction[i] - at.friction[i] - change;
        defect.abs() * h * h > FRICTION_DEFECT * rotor[i]
    })
}
