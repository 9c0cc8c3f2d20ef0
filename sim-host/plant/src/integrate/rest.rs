//! Equilibrium: (2.1) at rest, the deformed start of a weld.

use crate::cell::{Cell, State};
use crate::robot::{Drives, INTERNAL_STATES};
use nalgebra::Matrix6;
use trueweld_core::{Frames, JOINTS, JointVector, Wrench};

/// Iterations after which an equilibrium is given up. The baseline takes five; every kink (a gap's
/// end, the plate's surface) costs a few more, and a joint that slides through its gap along the
/// plate some thousand.
const EQUILIBRIUM_ITERATIONS_MAX: usize = 5000;

/// Unbalance of a joint that is rest as well, over its K, rad. A joint that hangs in its gap on the
/// plate's edge creeps there in steps far larger than what is left unbalanced: 1e-11 K is some
/// µN·m, and 10 nm where gravity alone holds it.
const BALANCED: f64 = 1e-11;

/// Damping of the first step, and the least, in units in which every spring is 1. Even a joint that
/// hangs in its gap, held by gravity alone, is stiffer than the least by orders.
const FIRST_DAMPING: f64 = 1e-6;
const LEAST_DAMPING: f64 = 1e-14;

/// Link angle step at which an equilibrium is found, rad: 1e-12 is a picometre at the tool.
const EQUILIBRIUM_STEP_TOLERANCE: f64 = 1e-12;

/// Link angle difference for the slope, rad: the slope is good to 1e-4 of K against rounding, and a
/// kink is not stepped over.
const LINK_ANGLE_DIFFERENCE: f64 = 1e-8;

/// Largest torsion that a spring is asked for, rad: beyond that of any load.
const LARGEST_TWIST: f64 = 1e-2;

/// The cell at rest.
#[derive(Debug, Clone, Copy)]
pub struct Rest {
    /// The state: all rates zero.
    pub state: State,
    /// Motor torque that holds it, N·m.
    pub torque: JointVector<f64>,
}

/// No equilibrium was found.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "no equilibrium within {EQUILIBRIUM_ITERATIONS_MAX} iterations: the load still moves the joints by {residual:e} rad"
)]
pub struct EquilibriumError {
    /// Last step, rad.
    pub residual: f64,
}

const ZERO_RATES: JointVector<f64> = JointVector::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);

fn drives_at_rest(link: &JointVector<f64>, motor: &JointVector<f64>) -> Drives {
    Drives { link: *link, link_rate: ZERO_RATES, motor: *motor, motor_rate: ZERO_RATES }
}

/// Torque that the springs must carry for the links to stand: g − τ_cb − Jᵀ w and what effects add,
/// N·m.
fn carried(
    cell: &Cell,
    drives: &Drives,
    frames: &Frames<f64>,
    wrench: &Wrench<f64>,
) -> JointVector<f64> {
    cell.robot.model.gravity_torque(frames)
        - cell.robot.link_torque(drives, &[0.0; INTERNAL_STATES])
        - frames.joint_torque(wrench)
}

/// Link angles at rest for motor angles held at `motor`, and the torque of the springs there: τ_s =
/// g − τ_cb − Jᵀ w, with `load` giving frames and wrench (axes of B) at a trial state.
///
/// Levenberg–Marquardt with the slope by differences: a gap, or a plate that ends, changes the
/// slope altogether, and where Newton's method then jumps to and fro between two of them, this one
/// only ever descends.
fn settle(
    cell: &Cell,
    motor: &JointVector<f64>,
    load: impl Fn(&Drives) -> (Frames<f64>, Wrench<f64>),
) -> Result<(JointVector<f64>, JointVector<f64>), EquilibriumError> {
    let spring = |drives: &Drives| cell.robot.spring_torque(drives, &[0.0; INTERNAL_STATES]);
    let unbalance = |link: &JointVector<f64>| {
        let drives = drives_at_rest(link, motor);
        let (frames, wrench) = load(&drives);
        spring(&drives) - carried(cell, &drives, &frames, &wrench)
    };
    // In units in which every spring is 1: angles times √K, torques over √K.
    let unit = cell.robot.model.stiffness().map(f64::sqrt);
    let mut link = *motor;
    let mut torque = unbalance(&link);
    let mut damping = FIRST_DAMPING;
    let mut residual = f64::INFINITY;
    for _ in 0..EQUILIBRIUM_ITERATIONS_MAX {
        let slope = Matrix6::from_columns(&std::array::from_fn::<_, JOINTS, _>(|i| {
            // Central: at a kink the mean of both sides still leads down, where either side alone
            // may not.
            let (mut above, mut below) = (link, link);
            above[i] += LINK_ANGLE_DIFFERENCE;
            below[i] -= LINK_ANGLE_DIFFERENCE;
            (unbalance(&above) - unbalance(&below)).component_div(&unit)
                / (2.0 * LINK_ANGLE_DIFFERENCE * unit[i])
        }));
        let scaled = torque.component_div(&unit);
        let descent = slope.tr_mul(&scaled);
        let normal = slope.tr_mul(&slope);
        let lower = loop {
            let damped = normal + Matrix6::from_diagonal_element(damping);
            let Some(factor) = damped.cholesky() else {
                return Err(EquilibriumError { residual });
            };
            let step = -factor.solve(&descent).component_div(&unit);
            residual = step.amax();
            let next = link + step;
            let left = unbalance(&next);
            if left.component_div(&unit).norm() <= scaled.norm() {
                (link, torque) = (next, left);
                break true;
            }
            if residual < EQUILIBRIUM_STEP_TOLERANCE || !residual.is_finite() {
                break false;
            }
            damping *= 10.0;
        };
        damping = (damping * 0.1).max(LEAST_DAMPING);
        if residual < EQUILIBRIUM_STEP_TOLERANCE
            || torque.component_div(cell.robot.model.stiffness()).amax() < BALANCED
        {
            let drives = drives_at_rest(&link, motor);
            return Ok((link, spring(&drives)));
        }
        if !lower {
            break;
        }
    }
    Err(EquilibriumError { residual })
}

/// The cell at rest in contact, motors held at `motor`, the plastic channel under the tool.
///
/// # Errors
/// [`EquilibriumError`] where the iteration does not converge.
pub(crate) fn in_contact(cell: &Cell, motor: &JointVector<f64>) -> Result<Rest, EquilibriumError> {
    let at_rest = |link: &JointVector<f64>| cell.at_rest(link, motor);
    let (link, torque) = settle(cell, motor, |drives| {
        let contact = cell.standing_contact(&at_rest(&drives.link), drives);
        (contact.frames, contact.wrench())
    })?;
    Ok(Rest { state: cell.settled(at_rest(&link)), torque })
}

/// Link angles at rest under a given wrench on the tool (at the TCP, axes of B), motors held at
/// `motor`.
///
/// # Errors
/// [`EquilibriumError`] where the iteration does not converge.
pub fn under_wrench(
    cell: &Cell,
    motor: &JointVector<f64>,
    wrench: &Wrench<f64>,
) -> Result<JointVector<f64>, EquilibriumError> {
    settle(cell, motor, |drives| (cell.robot.frames(&drives.link, wrench, 0.0), *wrench))
        .map(|(link, _)| link)
}

/// Motor angles that hold the links at `link` against a given wrench on the tool (at the TCP, axes
/// of B): each spring's equation inverted by bisection, so that effects count. Within a gap that
/// carries nothing, its middle is taken; NaN for a joint whose torques are not finite there.
pub fn motors_for(cell: &Cell, link: &JointVector<f64>, wrench: &Wrench<f64>) -> JointVector<f64> {
    let frames = cell.robot.frames(link, wrench, 0.0);
    let wanted = carried(cell, &drives_at_rest(link, link), &frames, wrench);
    let mut motor = *link;
    // In order of the joints: a coupling makes a spring depend on the motor before its own.
    for i in 0..JOINTS {
        let spare = |angle: f64| {
            let mut motor = motor;
            motor[i] = angle;
            cell.robot.spring_torque(&drives_at_rest(link, &motor), &[0.0; INTERNAL_STATES])[i]
                - wanted[i]
        };
        let short_of = |angle: f64, below: bool| {
            if below { spare(angle) < 0.0 } else { spare(angle) <= 0.0 }
        };
        // A torsion of any load first; wider for a gear that adds a share of another joint's angle.
        let mut reach = LARGEST_TWIST;
        while reach < 1.0 && (short_of(link[i] + reach, false) || !short_of(link[i] - reach, true))
        {
            reach *= 4.0;
        }
        // Lower and upper end of the angles that carry just this torque; they differ only across a
        // gap.
        let edge = |below: bool| edge([link[i] - reach, link[i] + reach], |at| short_of(at, below));
        let middle = 0.5 * (edge(true) + edge(false));
        motor[i] = if spare(middle).is_finite() { middle } else { f64::NAN };
    }
    motor
}

/// Where a condition ceases to hold between two numbers, the first of which meets it.
fn edge([mut low, mut high]: [f64; 2], holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
