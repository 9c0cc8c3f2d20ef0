//! Equilibrium: (2.1) at rest, the deformed start of a weld.

use crate::cell::{Cell, State};
use crate::robot::Drives;
use nalgebra::Matrix6;
use trueweld_core::{JointVector, Wrench};

/// Iterations after which an equilibrium is given up. The baseline takes four; inside a backlash gap the spring's true
/// slope is missing and convergence is linear.
const ITERATIONS: usize = 500;

/// Link angle step at which an equilibrium is found, rad: 1e-12 is a picometre at the tool.
const TOLERANCE: f64 = 1e-12;

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
#[error("no equilibrium within {ITERATIONS} iterations: the load still moves the joints by {residual:e} rad")]
pub struct NoRest {
    /// Last step, rad.
    pub residual: f64,
}

/// Link angles at rest for motor angles held at `motor`: τ_s + τ_cb + Jᵀ w = g, with `load` giving the wrench on the
/// tool (axes of B) and its joint-space stiffness at a trial state.
///
/// Newton's method with the baseline's stiffness K + K_w; the loads' own change with angle beyond that is left to the
/// iteration.
fn settle(
    cell: &Cell,
    motor: &JointVector<f64>,
    mut load: impl FnMut(&Drives) -> (Wrench<f64>, Matrix6<f64>),
) -> Result<(JointVector<f64>, JointVector<f64>), NoRest> {
    let robot = &cell.robot;
    let still = JointVector::zeros();
    let mut drives = Drives { link: *motor, link_rate: still, motor: *motor, motor_rate: still };
    let mut residual = f64::INFINITY;
    for _ in 0..ITERATIONS {
        let (wrench, stiffness) = load(&drives);
        let frames = robot.frames(&drives.link, &wrench);
        let spring = robot.spring_torque(&drives, &[0.0; crate::robot::INTERNAL_STATES]);
        let torque =
            spring + robot.link_torque(&drives) - robot.model.gravity_torque(&frames) + frames.joint_torque(&wrench);
        let slope = Matrix6::from_diagonal(robot.model.stiffness()) + stiffness;
        let Some(step) = slope.lu().solve(&torque) else { break };
        drives.link += step;
        residual = step.amax();
        if residual < TOLERANCE {
            return Ok((drives.link, spring));
        }
        if !residual.is_finite() {
            break;
        }
    }
    Err(NoRest { residual })
}

/// The cell at rest in contact, motors held at `motor`, the plastic channel under the tool.
///
/// # Errors
/// [`NoRest`] where the iteration does not converge.
pub fn in_contact(cell: &Cell, motor: &JointVector<f64>) -> Result<Rest, NoRest> {
    let at_rest = |link: &JointVector<f64>| {
        let y = cell.b_from_w.inverse().transform_point(&cell.robot.model.forward(link).position).y;
        State::at_rest(link, motor, y)
    };
    let (link, torque) = settle(cell, motor, |drives| {
        let (frames, reaction) = cell.contact(0.0, &at_rest(&drives.link), drives);
        let jacobian = cell.tool_jacobian_w(&frames);
        (cell.wrench(&reaction.force), jacobian.transpose() * reaction.stiffness * jacobian)
    })?;
    Ok(Rest { state: at_rest(&link), torque })
}

/// Link angles at rest under a given wrench on the tool (at the TCP, axes of B), motors held at `motor`.
///
/// # Errors
/// [`NoRest`] where the iteration does not converge.
pub fn under_wrench(cell: &Cell, motor: &JointVector<f64>, wrench: &Wrench<f64>) -> Result<JointVector<f64>, NoRest> {
    settle(cell, motor, |_| (*wrench, Matrix6::zeros())).map(|(link, _)| link)
}

/// Motor angles that hold the real tool at link angles `link` against a given wrench: the springs' equation inverted
/// by the same iteration, so that effects count.
///
/// # Errors
/// [`NoRest`] where the iteration does not converge.
pub fn motors_for(cell: &Cell, link: &JointVector<f64>, wrench: &Wrench<f64>) -> Result<JointVector<f64>, NoRest> {
    let mut motor = *link;
    let mut residual = f64::INFINITY;
    for _ in 0..ITERATIONS {
        let step = link - under_wrench(cell, &motor, wrench)?;
        motor += step;
        residual = step.amax();
        if residual < TOLERANCE {
            return Ok(motor);
        }
    }
    Err(NoRest { residual })
}
