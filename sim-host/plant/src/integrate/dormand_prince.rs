//! The reference integrator: adaptive Dormand–Prince 5(4).
//!
//! Explicit, with error control per step and local extrapolation; slow here, because the contact
//! makes the system stiff, but its error is known. Source: Dormand, Prince 1980; step control after
//! Hairer, Nørsett, Wanner I, II.4.

use crate::cell::{Cell, Evaluation, STATES, State, StateVector};
use trueweld_core::JointVector;

const NODES: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const STAGES: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Weights of the fifth-order solution less those of the embedded fourth-order one.
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Error allowed per step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Relative to the size of each state.
    pub relative: f64,
    /// In the state's unit (rad, rad/s, m).
    pub absolute: f64,
}

impl Tolerance {
    /// 1e-9 relative, 1e-11 absolute: the tool's position to nanometres over one control period.
    pub const REFERENCE: Self = Self { relative: 1e-9, absolute: 1e-11 };
}

/// Advances `state` from `time`, where its evaluation is `at`, by `span` seconds with motor torque
/// held. `suggested`: first step to try, s; it is left at the one to try next. `None` where the
/// state left the finite numbers or the step fell below 1e-9 s.
#[expect(
    clippy::too_many_arguments,
    reason = "the integrator's whole interface; used in one place"
)]
pub(crate) fn advance(
    cell: &Cell,
    time: f64,
    state: &State,
    at: &Evaluation,
    torque: &JointVector<f64>,
    span: f64,
    tolerance: Tolerance,
    suggested: &mut f64,
) -> Option<State> {
    let mut y = state.0;
    let mut done = 0.0;
    let mut k: [StateVector; 7] = [cell.driven(at.rates, torque); 7];
    while done < span {
        let remaining = span - done;
        let last = *suggested >= remaining;
        let h = if last { remaining } else { *suggested };
        if h < 1e-9 && !last {
            return None;
        }
        let mut next = y;
        for stage in 1..7 {
            next = y;
            for (weight, k) in STAGES[stage].iter().zip(&k).take(stage) {
                next += k * (h * weight);
            }
            let at = cell.evaluate(time + done + NODES[stage] * h, &State(next));
            k[stage] = cell.driven(at.rates, torque);
        }
        let mut square = 0.0;
        for i in 0..STATES {
            let error: f64 = h * ERROR.iter().zip(&k).map(|(w, k)| w * k[i]).sum::<f64>();
            let scale = tolerance.absolute + tolerance.relative * y[i].abs().max(next[i].abs());
            square += (error / scale).powi(2);
        }
        let error = (square / STATES as f64).sqrt();
        if !error.is_finite() {
            if h < 1e-6 {
                return None;
            }
            *suggested = h * 0.1;
            continue;
        }
        let growth = (0.9 * error.powf(-0.2)).clamp(0.2, 5.0);
        if error <= 1.0 {
            done += h;
            y = next;
            // First same as last.
            k[0] = k[6];
            if last {
                *suggested = suggested.max(h * growth);
                break;
            }
        }
        *suggested = h * growth;
    }
    Some(State(y))
}
