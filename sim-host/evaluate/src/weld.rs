//! Figures of a weld over its steady part (full feed, full force).

use trueweld_core::{JOINTS, JointVector};
use trueweld_plant::simulate::{Phase, RecordRow, Recording};

/// Mean, root mean square and largest magnitude of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Root mean square about zero.
    pub rms: f64,
    /// Largest magnitude.
    pub max_abs: f64,
}

impl Spread {
    /// Of a signal; zeros for an empty one.
    pub fn of(signal: impl Iterator<Item = f64>) -> Self {
        let (mut n, mut sum, mut square, mut max_abs) = (0_usize, 0.0, 0.0, 0.0_f64);
        for v in signal {
            n += 1;
            sum += v;
            square += v * v;
            max_abs = max_abs.max(v.abs());
        }
        let n = n.max(1) as f64;
        Self { mean: sum / n, rms: (square / n).sqrt(), max_abs }
    }
}

/// The push in the steady part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceFigures {
    /// Mean of the real push, N.
    pub mean: f64,
    /// Largest less smallest real push, N: the width of its envelope.
    pub envelope: f64,
    /// Root mean square of real push less the push asked for, N.
    pub error_rms: f64,
}

/// How far the tool left its line in the steady part of one weld.
#[derive(Debug, Clone, PartialEq)]
pub struct WeldFigures {
    /// Across the seam (y of W), m.
    pub lateral: Spread,
    /// Along the seam (x of W), m.
    pub longitudinal: Spread,
    /// Into the material from the plate's surface (z of W), m.
    pub depth: Spread,
    /// Angle between the real and the nominal tool axis, rad.
    pub tilt: Spread,
    /// Its part across the seam, about x of W, rad.
    pub side_tilt: Spread,
    /// Its part along the seam, about y of W, rad: what the travel angle is off by.
    pub travel_angle: Spread,
    /// The push.
    pub force: ForceFigures,
    /// Share of each joint's twist in the lateral deviation; sums to 1. Each joint's contribution
    /// is averaged along the seam with the sign of the whole, so that a deviation that crosses zero
    /// still has shares.
    pub joint_share: JointVector<f64>,
    /// Largest lateral deviation over half the pin's diameter: below 1 the seam is met.
    pub of_half_pin: f64,
    /// Largest correction of the set-point in the whole run: translation in m, rotation in rad.
    pub correction: [f64; 2],
    /// Largest lateral deviation from the closing of the force loop to full feed, m: the transient
    /// before the steady part.
    pub lateral_before: f64,
    /// Rows in which some limit was reached or a fault was raised, whole run.
    pub limited_rows: usize,
}

impl WeldFigures {
    /// Figures of one recording. `None` where the run never reached its steady part.
    pub fn of(recording: &Recording) -> Option<Self> {
        let steady: Vec<&RecordRow> =
            recording.rows.iter().filter(|r| r.phase == Phase::Steady).collect();
        if steady.is_empty() {
            return None;
        }
        let spread = |f: fn(&RecordRow) -> f64| Spread::of(steady.iter().map(|r| f(r)));
        let push = |r: &RecordRow| -r.force_w.z;
        let (low, high) = steady
            .iter()
            .map(|r| push(r))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let error = Spread::of(steady.iter().map(|r| push(r) - r.force_desired.unwrap_or(0.0)));
        let mut share = JointVector::zeros();
        for row in &steady {
            let sign = row.lateral_by_joint.sum().signum();
            share += row.lateral_by_joint * sign;
        }
        let total: f64 = (0..JOINTS).map(|i| share[i]).sum();
        let lateral = spread(|r| r.deviation_w.linear.y);
        let before =
            recording.rows.iter().filter(|r| matches!(r.phase, Phase::ForceRamp | Phase::FeedRamp));
        Some(Self {
            lateral,
            longitudinal: spread(|r| r.deviation_w.linear.x),
            depth: spread(|r| r.deviation_w.linear.z),
            tilt: spread(|r| r.tilt),
            side_tilt: spread(|r| r.deviation_w.angular.x),
            travel_angle: spread(|r| r.deviation_w.angular.y),
            force: ForceFigures {
                mean: spread(|r| -r.force_w.z).mean,
                envelope: high - low,
                error_rms: error.rms,
            },
            joint_share: if total > 0.0 { share / total } else { share },
            of_half_pin: lateral.max_abs / recording.half_pin,
            correction: [
                Spread::of(recording.rows.iter().map(|r| r.correction_w.linear.norm())).max_abs,
                Spread::of(recording.rows.iter().map(|r| r.correction_w.angular.norm())).max_abs,
            ],
            lateral_before: Spread::of(before.map(|r| r.deviation_w.linear.y)).max_abs,
            limited_rows: recording.rows.iter().filter(|r| r.limited || r.fault.is_some()).count(),
        })
    }
}
