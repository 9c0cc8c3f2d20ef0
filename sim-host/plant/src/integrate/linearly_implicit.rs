//! The default integrator: a linearly implicit four-stage scheme of third order, cut to this
//! system.
//!
//! ROS34PW2 (Rang, Angermann 2005), L-stable, with s = γh and A an approximation of ∂f/∂u:
//!
//! (I − sA) Uᵢ = s f(u + Σ aᵢⱼ Uⱼ) + γ Σ cᵢⱼ Uⱼ,  u⁺ = u + Σ mᵢ Uᵢ.
//!
//! It keeps its order for any matrix A (a W-method), so A holds what is stiff and no more: springs,
//! dampers, the slope of friction, and the contact. Those couple a motor with its own link only, so
//! that the motors are eliminated joint by joint and each stage solves 6 × 6 instead of 32 × 32. The
//! inertia matrix is factored once a step: later stages take link accelerations by inverse dynamics
//! about the first ([`ElasticRobot::link_acceleration_near`]).
//! Effects that change a spring keep the baseline's K and D in A.
//!
//! [`ElasticRobot::link_acceleration_near`]: crate::robot::ElasticRobot::link_acceleration_near

use crate::cell::{Cell, Evaluation, State, StateVector};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3};
use trueweld_core::JointVector;
use trueweld_core::ldlt::Ldlt;

/// Diagonal of Γ.
const G: f64 = 4.358_665_215_084_59e-1;

/// α of the published tableau: weights of earlier stages in the argument of f.
const ALPHA: [[f64; 4]; 4] = [
    [0.0, 0.0, 0.0, 0.0],
    [8.717_330_430_169_18e-1, 0.0, 0.0, 0.0],
    [8.445_706_001_536_942e-1, -1.129_906_423_648_418_5e-1, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
];

/// Γ of the published tableau: weights of A times earlier stages.
const GAMMA: [[f64; 4]; 4] = [
    [G, 0.0, 0.0, 0.0],
    [-8.717_330_430_169_18e-1, G, 0.0, 0.0],
    [-9.033_805_701_304_408e-1, 5.418_067_238_809_533e-2, G, 0.0],
    [2.421_238_070_609_534_6e-1, -1.223_250_583_904_514_7, 5.452_602_553_351_021e-1, G],
];

/// Weights of the solution.
const B: [f64; 4] =
    [2.421_238_070_609_534_6e-1, -1.223_250_583_904_514_7, 1.545_260_255_335_102, G];

/// The tableau in the variables U = hΓk, in which no product with A is needed.
struct Tableau {
    /// α Γ⁻¹.
    a: [[f64; 4]; 4],
    /// γ (diag(1/γ) − Γ⁻¹), strictly lower.
    c: [[f64; 4]; 4],
    /// b Γ⁻¹.
    m: [f64; 4],
    /// Σ α: where in the step each stage stands.
    node: [f64; 4],
}

const TABLEAU: Tableau = transformed();

const fn transformed() -> Tableau {
    // Γ⁻¹ of a lower triangle by forward substitution, column by column.
    let mut inverse = [[0.0; 4]; 4];
    let mut j = 0;
    while j < 4 {
        let mut i = j;
        while i < 4 {
            let mut sum = if i == j { 1.0 } else { 0.0 };
            let mut k = j;
            while k < i {
                sum -= GAMMA[i][k] * inverse[k][j];
                k += 1;
            }
            inverse[i][j] = sum / GAMMA[i][i];
            i += 1;
        }
        j += 1;
    }
    let mut t = Tableau { a: [[0.0; 4]; 4], c: [[0.0; 4]; 4], m: [0.0; 4], node: [0.0; 4] };
    let mut i = 0;
    while i < 4 {
        let mut j = 0;
        while j < 4 {
            let mut k = 0;
            while k < 4 {
                t.a[i][j] += ALPHA[i][k] * inverse[k][j];
                k += 1;
            }
            if j < i {
                t.c[i][j] = -G * inverse[i][j];
            }
            t.m[j] += B[i] * inverse[i][j];
            t.node[i] += ALPHA[i][j];
            j += 1;
        }
        i += 1;
    }
    t
}

/// I − sA, factored: s = γh.
struct StageMatrix {
    s: f64,
    stiffness: JointVector<f64>,
    /// sD + s²K: what ties a motor to its link.
    tie: JointVector<f64>,
    /// 1 / (I_m + sD + s²K + s τ_f′).
    motor: JointVector<f64>,
    rotor: JointVector<f64>,
    inertia: Matrix6<f64>,
    /// Tool velocity in W for joint rates, and the contact's stiffness along each axis there.
    jacobian: Matrix3x6<f64>,
    contact: Vector3<f64>,
    link: Ldlt<f64>,
}

impl StageMatrix {
    #[inline]
    fn new(cell: &Cell, at: &Evaluation, s: f64) -> Option<Self> {
        let model = &cell.robot.model;
        let stiffness = *model.stiffness();
        let tie = model.damping() * s + stiffness * (s * s);
        let motor = (model.rotor_inertia() + tie + at.friction_slope * s).map(f64::recip);
        let jacobian = at.tool_jacobian_w();
        // Along each axis by itself: what couples them is not stiff, and without it the matrix is
        // symmetric.
        let contact = at.reaction.stiffness.diagonal();
        let tangent = at.reaction.damping.diagonal() * s + contact * (s * s);
        let mut link = at.inertia + jacobian.tr_mul(&(Matrix3::from_diagonal(&tangent) * jacobian));
        for i in 0..6 {
            link[(i, i)] += tie[i] - tie[i] * tie[i] * motor[i];
        }
        let link = Ldlt::new(link)?;
        Some(Self {
            s,
            stiffness,
            tie,
            motor,
            rotor: *model.rotor_inertia(),
            inertia: at.inertia,
            jacobian,
            contact,
            link,
        })
    }

    /// k of (I − sA) k = r.
    #[inline]
    fn solve(&self, r: &StateVector) -> StateVector {
        let r_link: JointVector<f64> = r.fixed_rows::<6>(0).into_owned();
        let r_motor: JointVector<f64> = r.fixed_rows::<6>(6).into_owned();
        let r_link_rate: JointVector<f64> = r.fixed_rows::<6>(12).into_owned();
        let r_motor_rate: JointVector<f64> = r.fixed_rows::<6>(18).into_owned();
        let spring = self.stiffness.component_mul(&(r_motor - r_link)) * self.s;
        let on_motor = self.rotor.component_mul(&r_motor_rate) - spring;
        let on_link = self.inertia * r_link_rate + spring
            - self.jacobian.tr_mul(&self.contact.component_mul(&(self.jacobian * r_link))) * self.s
            + self.tie.component_mul(&self.motor).component_mul(&on_motor);
        let link_rate = self.link.solve(&on_link);
        let motor_rate = self.motor.component_mul(&(on_motor + self.tie.component_mul(&link_rate)));
        let mut k = *r;
        k.fixed_rows_mut::<6>(0).copy_from(&(r_link + link_rate * self.s));
        k.fixed_rows_mut::<6>(6).copy_from(&(r_motor + motor_rate * self.s));
        k.fixed_rows_mut::<6>(12).copy_from(&link_rate);
        k.fixed_rows_mut::<6>(18).copy_from(&motor_rate);
        k
    }
}

/// One step of `h` seconds from `state` at `time`, whose evaluation is `at`, with the motors'
/// torque held. `None` where the state left the finite numbers.
pub(crate) fn step(
    cell: &Cell,
    time: f64,
    state: &State,
    at: &Evaluation,
    torque: &JointVector<f64>,
    h: f64,
) -> Option<State> {
    let s = G * h;
    let stage = StageMatrix::new(cell, at, s)?;
    let mut u = [StateVector::zeros(); 4];
    u[0] = stage.solve(&(cell.driven(at.rates, torque) * s));
    let mut next = state.0 + u[0] * TABLEAU.m[0];
    for i in 1..4 {
        let (mut argument, mut right) = (state.0, StateVector::zeros());
        for (earlier, (a, c)) in u.iter().zip(TABLEAU.a[i].iter().zip(&TABLEAU.c[i])).take(i) {
            argument += earlier * *a;
            right += earlier * *c;
        }
        let there = cell.rates_near(time + TABLEAU.node[i] * h, &State(argument), at)?;
        u[i] = stage.solve(&(right + cell.driven(there, torque) * s));
        next += u[i] * TABLEAU.m[i];
    }
    next.sum().is_finite().then_some(State(next))
}
