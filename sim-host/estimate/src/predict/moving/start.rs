//! How the links swing where a ring-down begins after its stop: told by what the tracker saw first.

use super::super::{BaselineModel, LinkMotion, known};
use super::swing::{Elsewhere, Swing, SwingGain};
use super::{DynamicPrediction, Links};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::Log;
use trueweld_logs::noise::NoiseLevels;
use trueweld_plant::robot::{ElasticRobot, INTERNAL_STATES, Memory};

/// Time over which the start of the links is told, periods of the arm's lowest mode, and the fewest
/// rows in it.
const SWING_PERIODS: f64 = 1.5;
const SWING_ROWS_MIN: usize = 10;

/// Rounds that bring the start to where the model has it.
const START_FIT_ROUNDS: usize = 6;

/// By how much the sum of squares must fall for an arm to be taken to swing when a log begins: twelve
/// numbers lower it by 12, and by 40 once in ten thousand times.
const START_SWING_FALL_MIN: f64 = 60.0;

/// Rate by which motors may change while the start is told, rad/s.
const START_MOTOR_RATE_CHANGE: f64 = 5e-3;

impl DynamicPrediction {
    /// How the start of the links is told, under the model without its effects; `None` where the arm does not swing when the log begins.
    pub(super) fn swing(
        &self,
        log: &Log,
        noise: &NoiseLevels,
        model: &BaselineModel,
    ) -> Option<(Swing, Arc<SwingGain>)> {
        let position = self.position.as_ref()?;
        let level = known(&noise.position, log, LogChannel::Position).ok()?;
        let frames = model.robot.frames(&self.drive[0].angle);
        let lowest = model.robot.natural_frequencies(&frames)?[0];
        let length = (SWING_PERIODS * TAU / lowest / self.period) as usize;
        let rate = self.drive[0].rate;
        let rows = self.drive.iter().step_by(self.parts);
        let steady = rows.take_while(|m| (m.rate - rate).amax() < START_MOTOR_RATE_CHANGE).count();
        let seen = |row: &usize| position[*row].sum().is_finite();
        let rows: Vec<usize> = (0..length.min(steady)).filter(seen).collect();
        if rows.len() < SWING_ROWS_MIN {
            return None;
        }
        let robot = ElasticRobot::with_effects(&model.robot, &[], None).ok()?;
        let variance = [0, 1, 2].map(|c| level[c].deviation.powi(2));
        let swing = Swing { rows, lowest, variance };
        let substeps = self.substeps(&robot).ok()?;
        let memory = [0.0; INTERNAL_STATES];
        let (slopes, plain) = self.swing_slopes(&robot, &swing, &memory, substeps)?;
        let (weighted, normal) = swing.normal(&slopes);
        let right = weighted.tr_mul(&plain);
        let explained = |from: usize| {
            let size = 18 - from;
            let normal = normal.view((from, from), (size, size)).into_owned();
            let right = right.rows(from, size).into_owned();
            Some(right.dot(&normal.cholesky()?.solve(&right)))
        };
        if explained(0)? - explained(12)? < START_SWING_FALL_MIN {
            return None;
        }
        let gain = swing.gain(&slopes)?;
        Some((swing, Arc::new(gain)))
    }

    /// How the links swing at the first row under a model: by the slopes of one not far from it, or
    /// of the model without its effects, as long as these bring the start to where nothing moves it;
    /// else by its own. `links`: those that start so.
    pub(super) fn begun(
        &self,
        robot: &ElasticRobot,
        (swing, plain): &(Swing, Arc<SwingGain>),
        memory: &Memory,
        known: Option<&Arc<SwingGain>>,
        links: &impl Fn(&Elsewhere) -> Links,
        substeps: usize,
    ) -> (Elsewhere, Arc<SwingGain>) {
        // From nothing, so that it does not depend on where another model's links started; and whether
        // it settled.
        let settled = |gain: &SwingGain| {
            let mut elsewhere = Elsewhere::zeros();
            let settled = (0..START_FIT_ROUNDS).any(|_| {
                let left = self.first_residual(robot, &swing.rows, links(&elsewhere));
                let by = left.map(|left| gain.step(&elsewhere, &left));
                by.is_none_or(|by| {
                    elsewhere += by;
                    swing.has_settled(&by)
                })
            });
            (elsewhere, settled)
        };
        let gain = known.unwrap_or(plain);
        let (elsewhere, is_settled) = settled(gain);
        if !is_settled {
            let slopes = self.swing_slopes(robot, swing, memory, substeps);
            if let Some(gain) = slopes.and_then(|(slopes, _)| swing.gain(&slopes)) {
                // What is no straight line may swing about its start a little.
                return (settled(&gain).0, Arc::new(gain));
            }
        }
        (elsewhere, gain.clone())
    }

    /// By how much the residuals of the first rows fall with the links starting elsewhere, a column
    /// for each of their angles and rates, then for where the tracker stands, and how it drifts; and
    /// these residuals.
    fn swing_slopes(
        &self,
        robot: &ElasticRobot,
        swing: &Swing,
        memory: &Memory,
        substeps: usize,
    ) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let still = Elsewhere::zeros();
        let start = |elsewhere: &_| self.start(robot, memory, elsewhere);
        let begin = |elsewhere: &_| Links::new(robot, start(elsewhere), None, substeps);
        let plain = self.first_residual(robot, &swing.rows, begin(&still))?;
        let mut columns = DMatrix::<f64>::zeros(plain.len(), 18);
        for k in 0..12 {
            let mut start = still;
            start[k] = 0.1 * swing.size(k);
            let moved = self.first_residual(robot, &swing.rows, begin(&start))?;
            columns.set_column(k, &((&plain - moved) / 0.1));
        }
        let count = swing.rows.len();
        for r in 0..count {
            for c in 0..3 {
                columns[(3 * r + c, 12 + c)] = 1e-2;
                columns[(3 * r + c, 15 + c)] = 1e-2 * (r as f64 / count as f64 - 0.5);
            }
        }
        Some((columns, plain))
    }

    /// Measured less predicted position of the tool at the first rows, m, with the links starting
    /// so.
    fn first_residual(
        &self,
        robot: &ElasticRobot,
        rows: &[usize],
        links: Links,
    ) -> Option<DVector<f64>> {
        let position = self.position.as_ref()?;
        let mut motion = LinkMotion::new(rows.last()? + 1, false);
        self.go_through(robot, links, None, &mut motion).ok()?;
        let mut left = Vec::with_capacity(3 * rows.len());
        for &row in rows {
            left.extend((position[row] - self.seen_pose(robot, &motion, row).position).iter());
        }
        Some(DVector::from_vec(left))
    }
}
