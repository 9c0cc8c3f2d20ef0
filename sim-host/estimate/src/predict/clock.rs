//! The tracker's clock, where nobody knows it: told together with what the model predicts.
//!
//! A clock that was fitted to the motion that both instruments saw is bent by what the model lacks
//! then; under a model that has it, the clock is another one. What is left of it enters every
//! prediction anew, r + s Δt + s (Δd) t with the slopes s of the residuals by the tracker's delay, so
//! that effects are fitted jointly with the clock, and none is made up to mend it.

use nalgebra::{Matrix2, Vector2};
use trueweld_logs::clock::DRIFT;
use trueweld_logs::log::{Log, LogKind};
use trueweld_plant::robot::{Channel, Term};

/// By how much a fitted clock may be off, s: one standard deviation.
const OFFSET: f64 = 1e-3;

/// Delay over which slopes are taken, s.
pub(super) const DELAY_STEP: f64 = 1e-4;

/// A tracker that is read later than the model says.
#[derive(Debug)]
pub(super) struct Late(pub f64);

impl Term for Late {
    fn delay(&self, channel: Channel) -> f64 {
        if channel == Channel::Tracker { self.0 } else { 0.0 }
    }
}

/// What of the tracker's clock is not given.
#[derive(Debug, Clone)]
pub(super) struct OpenClock {
    /// Deviations of the delay, s, in the middle of the log and of what drift adds at its ends; none
    /// of a drift that is given.
    deviation: Vector2<f64>,
    /// Where each compared value stands in time: −1 at the start of the log, 1 at its end.
    place: Vec<f64>,
}

impl OpenClock {
    /// Of a log of which these rows are compared, value by value. `None` where the tracker's clock is
    /// given, or rows are at rest.
    pub(crate) fn of(log: &Log, rows: impl Iterator<Item = usize>) -> Option<Self> {
        let clock = log.origin.clocks.iter().find(|clock| clock.fitted.is_some())?;
        let time = &log.samples.time;
        let (first, last) = (*time.first()?, *time.last()?);
        if log.kind == LogKind::StaticLoad || log.samples.position.is_none() {
            return None;
        }
        let [offset, drift] = clock.given.map(|given| if given { 0.0 } else { 1.0 });
        let half = 0.5 * (last - first);
        Some(Self {
            deviation: Vector2::new(offset * OFFSET, drift * DRIFT * half),
            place: rows.map(|row| (time[row] - first) / half - 1.0).collect(),
        })
    }

    /// By how much the tracker is later than its clock says, s, in the middle of the log and more at
    /// its end: what fits these residuals best, where they are `late` with a delay of
    /// [`DELAY_STEP`]. Residuals are then those with this clock.
    pub(crate) fn settle(&self, residual: &mut [f64], late: &[f64]) -> Option<[f64; 2]> {
        let slope = |k: usize| {
            let slope = (late[k] - residual[k]) / DELAY_STEP;
            Vector2::new(slope, slope * self.place[k]).component_mul(&self.deviation)
        };
        let (mut normal, mut right) = (Matrix2::identity(), Vector2::zeros());
        for (k, r) in residual.iter().enumerate() {
            normal += slope(k) * slope(k).transpose();
            right += slope(k) * *r;
        }
        let by = -normal.cholesky()?.solve(&right);
        let settled: Vec<f64> =
            residual.iter().enumerate().map(|(k, r)| r + slope(k).dot(&by)).collect();
        residual.copy_from_slice(&settled);
        Some(by.component_mul(&self.deviation).into())
    }

    /// Squares of how far the clock is off, s, over what was expected.
    pub(crate) fn prior(&self, late: [f64; 2]) -> f64 {
        let off = late.iter().zip(&self.deviation).filter(|(_, expected)| **expected > 0.0);
        off.map(|(late, expected)| (late / expected).powi(2)).sum()
    }
}
