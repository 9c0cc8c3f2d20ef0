//! The cell about one operating point: ẋ = A x + B Γ from differences of the plant's own right-hand
//! side, sampled exactly.

use nalgebra::{DMatrix, SMatrix, SVector, Vector3, Vector6};
use schemars::JsonSchema;
use serde::Serialize;
use trueweld_core::{JointVector, Pose, Robot, Twist, Wrench};
use trueweld_plant::cell::{Cell, STATES, State};
use trueweld_plant::input::Weld;
use trueweld_plant::integrate::rest;
use trueweld_plant::seam::SeamPosition;
use trueweld_plant::simulate::{Seam, real_inverse_near};

/// Differences of angles, rates and what else a state holds: good to 1e-6 of the slopes against
/// rounding, and no kink is stepped over.
const STATE_DIFFERENCE: f64 = 1e-6;

/// A cell linear in what it differs by from an operating point.
#[derive(Debug, Clone)]
pub(crate) struct LinearCell {
    /// The operating point: a tool on its line, moving at the feed.
    pub point: State,
    /// Motor torque there, N·m.
    pub torque: JointVector<f64>,
    wrench_in_t: SVector<f64, 6>,
    step: SMatrix<f64, STATES, STATES>,
    input: SMatrix<f64, STATES, 6>,
    sensed: SMatrix<f64, 6, STATES>,
}

/// Where in a weld a loop is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct OperatingPoint {
    /// Path position, m.
    #[serde(rename = "path_m")]
    pub path: f64,
    /// Push there, N.
    #[serde(rename = "push_n")]
    pub push: f64,
    /// Feed there, m/s.
    #[serde(rename = "feed_m_s")]
    pub feed: f64,
    /// Whether push and feed are still rising, or the tool has come to its end.
    pub ramp: bool,
}

impl OperatingPoint {
    /// The steady part of a weld at a path position, m.
    pub fn steady(weld: &Weld, path: f64) -> Self {
        Self { path, push: weld.force, feed: weld.feed_at(path), ramp: false }
    }

    /// So many places of the steady part from the start of the seam to its end; then the ramps: at
    /// the start half of the push, all of it and half of the feed, at the end the tool that stands.
    pub fn along(weld: &Weld, places: usize) -> Vec<Self> {
        let length = Seam::of(weld).length;
        let last = places.saturating_sub(1).max(1) as f64;
        let steady = (0..places).map(|k| Self::steady(weld, length * k as f64 / last));
        let ramp = |path| Self { ramp: true, ..Self::steady(weld, path) };
        let [start, end] = [0.0, length].map(ramp);
        let ramps = [
            Self { push: 0.5 * weld.force, feed: 0.0, ..start },
            Self { feed: 0.0, ..start },
            Self { feed: 0.5 * start.feed, ..start },
            Self { feed: 0.0, ..end },
        ];
        steady.chain(ramps).collect()
    }
}

/// The cell at work with its tool on the nominal pose. `None` where no posture near `near` does
/// that; `planned` is the arm as the controller knows it.
pub(crate) fn operating_point(
    cell: &Cell,
    planned: &Robot<f64>,
    nominal: &Pose<f64>,
    at: &OperatingPoint,
    near: &JointVector<f64>,
) -> Option<State> {
    let OperatingPoint { push, feed, .. } = *at;
    // The real seam may lie beside the taught one: as deep as the force loop presses, in the channel
    // that the tool itself has left.
    let SeamPosition { position: beside, axes: w } = cell.seam.place(&nominal.position);
    let deep = Twist {
        angular: Vector3::zeros(),
        linear: w.column(2) * (cell.process.depth_under(push) - beside.z),
    };
    let pose = nominal.displaced(&deep);
    let link = real_inverse_near(&cell.robot.model, planned, &pose, near).ok()?;
    let frames = cell.robot.model.frames(&link);
    let forward = w.column(0) * feed;
    let twist = Vector6::new(0.0, 0.0, 0.0, forward.x, forward.y, forward.z);
    let rate = frames.jacobian().0.lu().solve(&twist)?;
    let mut state = State::at_rest(&link, &link, beside.y);
    state.0.fixed_rows_mut::<6>(12).copy_from(&rate);
    state.0.fixed_rows_mut::<6>(18).copy_from(&rate);
    state = cell.settled(state);
    let load = cell.evaluate(0.0, &state).wrench();
    let motor = rest::motors_for(cell, &link, &load);
    state.0.fixed_rows_mut::<6>(6).copy_from(&motor);
    state.0.iter().all(|v| v.is_finite()).then_some(state)
}

impl LinearCell {
    /// The cell about `point`, sampled every `h` s with the torque held, with `friction`,
    /// N·m·s/rad, for the slopes of the drives' friction by their rates. The ripple of the process
    /// must be left out of the cell.
    ///
    /// `None` where the right-hand side is not finite there.
    pub(crate) fn about(
        cell: &Cell,
        point: &State,
        friction: &JointVector<f64>,
        h: f64,
    ) -> Option<Self> {
        let at = cell.evaluate(0.0, point);
        let torque =
            JointVector::from_fn(|i, _| -at.rates[18 + i] * cell.robot.model.rotor_inertia()[i]);
        let right = |state: &State| {
            let at = cell.evaluate(0.0, state);
            (at.rates, at.wrench_in_t().to_vector())
        };
        let mut slopes = SMatrix::<f64, STATES, STATES>::zeros();
        let mut sensed = SMatrix::<f64, 6, STATES>::zeros();
        for k in 0..STATES {
            let beside = |by: f64| {
                let mut state = *point;
                state.0[k] += by;
                right(&state)
            };
            let (ahead, behind) = (beside(STATE_DIFFERENCE), beside(-STATE_DIFFERENCE));
            slopes.set_column(k, &((ahead.0 - behind.0) / (2.0 * STATE_DIFFERENCE)));
            sensed.set_column(k, &((ahead.1 - behind.1) / (2.0 * STATE_DIFFERENCE)));
        }
        for i in 0..6 {
            let beyond = friction[i] - at.friction_slope[i];
            slopes[(18 + i, 18 + i)] -= beyond / cell.robot.model.rotor_inertia()[i];
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
            wrench_in_t: at.wrench_in_t().to_vector(),
            step: sampled.fixed_view::<STATES, STATES>(0, 0).into_owned(),
            input: sampled.fixed_view::<STATES, 6>(0, STATES).into_owned(),
            sensed,
        })
    }

    /// One step: what the state differs by from the operating point, under this motor torque, N·m.
    pub(crate) fn advance(
        &self,
        x: &SVector<f64, STATES>,
        torque: &JointVector<f64>,
    ) -> SVector<f64, STATES> {
        self.step * x + self.input * (torque - self.torque)
    }

    /// The process' wrench on the tool, in T.
    pub(crate) fn wrench(&self, x: &SVector<f64, STATES>) -> Wrench<f64> {
        Wrench::from_vector(&(self.wrench_in_t + self.sensed * x))
    }

    /// The state that differs by x.
    pub(crate) fn state(&self, x: &SVector<f64, STATES>) -> State {
        State(self.point.0 + x)
    }
}
