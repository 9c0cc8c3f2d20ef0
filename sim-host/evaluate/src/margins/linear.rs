//! The cell about one operating point: ẋ = A x + B Γ from differences of the plant's own right-hand
//! side, sampled exactly.

use nalgebra::{DMatrix, SMatrix, SVector, Vector3, Vector6};
use trueweld_core::{JointVector, Pose, Robot, Twist, Wrench};
use trueweld_plant::cell::{Cell, STATES, State};
use trueweld_plant::integrate::rest;
use trueweld_plant::simulate::real_inverse_near;

/// Differences of angles, rates and what else a state holds: good to 1e-6 of the slopes against
/// rounding, and no kink is stepped over.
const DIFFERENCE: f64 = 1e-6;

/// A cell linear in what it differs by from an operating point.
#[derive(Debug, Clone)]
pub struct LinearCell {
    /// The operating point: a tool on its line, moving at the feed.
    pub point: State,
    /// Motor torque there, N·m.
    pub torque: JointVector<f64>,
    wrench_in_t: SVector<f64, 6>,
    step: SMatrix<f64, STATES, STATES>,
    input: SMatrix<f64, STATES, 6>,
    sensed: SMatrix<f64, 6, STATES>,
}

/// The cell at work with its tool on the nominal pose, pressing with `push`, N, and moving at
/// `feed`, m/s: what the weld is to be. `None` where no posture near `near` does that;
/// `planned` is the arm as the controller knows it.
pub fn operating_point(
    cell: &Cell,
    planned: &Robot<f64>,
    nominal: &Pose<f64>,
    push: f64,
    feed: f64,
    near: &JointVector<f64>,
) -> Option<State> {
    let w = cell.b_from_w.rotation;
    let deep = Twist {
        angular: Vector3::zeros(),
        linear: w.column(2) * (push / cell.process.depth_stiffness),
    };
    let pose = nominal.displaced(&deep);
    let link = real_inverse_near(&cell.robot.model, planned, &pose, near).ok()?;
    let frames = cell.robot.model.frames(&link);
    let forward = w.column(0) * feed;
    let twist = Vector6::new(0.0, 0.0, 0.0, forward.x, forward.y, forward.z);
    let rate = frames.jacobian().0.lu().solve(&twist)?;
    let mut state = State::at_rest(&link, &link, 0.0);
    state.0.fixed_rows_mut::<6>(12).copy_from(&rate);
    state.0.fixed_rows_mut::<6>(18).copy_from(&rate);
    let load = cell.evaluate(0.0, &state).reaction.force;
    let motor = rest::motors_for(cell, &link, &cell.wrench(&load));
    state.0.fixed_rows_mut::<6>(6).copy_from(&motor);
    state.0.iter().all(|v| v.is_finite()).then_some(state)
}

impl LinearCell {
    /// The cell about `point`, sampled every `h` s with the torque held. The ripple of the process
    /// must be left out of the cell.
    ///
    /// `None` where the right-hand side is not finite there.
    pub fn about(cell: &Cell, point: &State, h: f64) -> Option<Self> {
        let at = cell.evaluate(0.0, point);
        let torque =
            JointVector::from_fn(|i, _| -at.rates[18 + i] * cell.robot.model.rotor_inertia()[i]);
        let right = |state: &State| {
            let at = cell.evaluate(0.0, state);
            (at.rates, cell.wrench_in_t(&at).to_vector())
        };
        let mut slopes = SMatrix::<f64, STATES, STATES>::zeros();
        let mut sensed = SMatrix::<f64, 6, STATES>::zeros();
        for k in 0..STATES {
            let beside = |by: f64| {
                let mut state = *point;
                state.0[k] += by;
                right(&state)
            };
            let (ahead, behind) = (beside(DIFFERENCE), beside(-DIFFERENCE));
            slopes.set_column(k, &((ahead.0 - behind.0) / (2.0 * DIFFERENCE)));
            sensed.set_column(k, &((ahead.1 - behind.1) / (2.0 * DIFFERENCE)));
        }
        // Held input as further states that do not change: exp([A B; 0 0] h) = [A_h B_h; 0 1].
        let mut joined = DMatrix::<f64>::zeros(STATES + 6, STATES + 6);
        joined.view_mut((0, 0), (STATES, STATES)).copy_from(&slopes);
        for i in 0..6 {
            joined[(18 + i, STATES + i)] = 1.0 / cell.robot.model.rotor_inertia()[i];
        }
        let sampled = (joined * h).exp();
        sampled.iter().all(|v| v.is_finite()).then(|| Self {
            point: *point,
            torque,
            wrench_in_t: cell.wrench_in_t(&at).to_vector(),
            step: sampled.fixed_view::<STATES, STATES>(0, 0).into_owned(),
            input: sampled.fixed_view::<STATES, 6>(0, STATES).into_owned(),
            sensed,
        })
    }

    /// One step: what the state differs by from the operating point, under this motor torque, N·m.
    pub fn advance(
        &self,
        x: &SVector<f64, STATES>,
        torque: &JointVector<f64>,
    ) -> SVector<f64, STATES> {
        self.step * x + self.input * (torque - self.torque)
    }

    /// The process' wrench on the tool, in T.
    pub fn wrench(&self, x: &SVector<f64, STATES>) -> Wrench<f64> {
        Wrench::from_vector(&(self.wrench_in_t + self.sensed * x))
    }

    /// The state that differs by x.
    pub fn state(&self, x: &SVector<f64, STATES>) -> State {
        State(self.point.0 + x)
    }
}
