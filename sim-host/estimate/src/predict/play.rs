//! Links in the backlash of their gears.
//!
//! Within a gap the spring carries nothing, and where the link lies is decided by torques far below
//! what any model knows: how it was left before the log began, a bearing's drag, the noise of the
//! encoders that drive the model. A model with play therefore says "anywhere in the gap", and the
//! link is taken to be where it was seen. Where the gap is closed nothing is taken from what was
//! measured.

use nalgebra::{Matrix3, Vector3, Vector6};
use trueweld_core::spatial::rotation_vector;
use trueweld_core::{JOINTS, JointVector, Pose};
use trueweld_logs::noise::{NoiseLevel, NoiseLevels};
use trueweld_plant::robot::ElasticRobot;

/// Time over which it is averaged where a link was seen, s: the tracker's noise is that much less,
/// and a link hardly moves in its gap meanwhile.
pub(super) const SEEN_OVER: f64 = 0.05;

/// Follows which links are in their backlash.
#[derive(Debug, Clone)]
pub(super) struct BacklashObserver {
    play: JointVector<f64>,
    /// Twist beyond the gap that is within what the encoders' noise makes of it, rad.
    margin: JointVector<f64>,
    /// Instants at which each link has been in its backlash since the start of the log; none once
    /// it was held.
    since: [Option<usize>; JOINTS],
    share: f64,
    period: f64,
}

impl BacklashObserver {
    /// `None` where no gear of the robot has play. `margin`: twist that is within the noise, rad;
    /// `period`: of what was seen, s, infinite where that is an average already.
    pub(super) fn new(robot: &ElasticRobot, margin: JointVector<f64>, period: f64) -> Option<Self> {
        let play = JointVector::from_fn(|i, _| robot.play(i));
        (play.amax() > 0.0).then(|| Self {
            play,
            margin,
            since: [Some(0); JOINTS],
            share: (period / SEEN_OVER).min(1.0),
            period,
        })
    }

    /// By how much links at `link` behind motors at `motor` are to be moved to be where they were
    /// seen. Zero for a link that its spring holds.
    pub(super) fn moved(
        &mut self,
        robot: &ElasticRobot,
        motor: &JointVector<f64>,
        link: &JointVector<f64>,
        seen: &Observed,
    ) -> Moved {
        let twist = motor - link + robot.ports.link_angle;
        let mut moved = Moved::default();
        let (in_backlash, held): (Vec<usize>, Vec<usize>) = (0..JOINTS)
            .partition(|&i| self.play[i] > 0.0 && twist[i].abs() <= self.play[i] + self.margin[i]);
        held.into_iter().for_each(|i| self.since[i] = None);
        let (by_itself, by_tool): (Vec<usize>, Vec<usize>) =
            in_backlash.into_iter().partition(|&i| seen.link[i].is_finite());
        let mut found: Vec<(usize, f64, f64)> =
            by_itself.iter().map(|&i| (i, seen.link[i], OWN_SHARE)).collect();
        if !by_tool.is_empty() && seen.tool.sum().is_finite() {
            // Turns count as what they move at the lever.
            let lever = if seen.turn.sum().is_finite() { seen.lever } else { 0.0 };
            let turn = if lever > 0.0 { seen.turn * lever } else { Vector3::zeros() };
            let mut jacobian = robot.model.frames(link).jacobian().0;
            jacobian.fixed_rows_mut::<3>(0).scale_mut(lever);
            let mut tool = Vector6::new(turn.x, turn.y, turn.z, 0.0, 0.0, 0.0);
            tool.fixed_rows_mut::<3>(3).copy_from(&seen.tool);
            by_itself.iter().for_each(|&i| tool -= jacobian.column(i) * seen.link[i]);
            let columns = jacobian.select_columns(&by_tool);
            let mut square = columns.tr_mul(&columns);
            for k in 0..by_tool.len() {
                square[(k, k)] += LEAST_ARM * LEAST_ARM;
            }
            let right = columns.tr_mul(&tool);
            if let Some(factor) = square.cholesky() {
                let (all, known) = (factor.solve(&right), factor.inverse());
                for (k, i) in by_tool.iter().enumerate() {
                    // What may be noise is none: it would pass for play of the noise's size.
                    if all[k].abs() > ELSEWHERE_DEVIATIONS * seen.deviation * known[(k, k)].sqrt() {
                        found.push((*i, all[k], self.share));
                    }
                }
            }
        }
        for (i, found, running) in found {
            // Nothing is known of it at first: a plain mean, then a running one.
            let share = self.since[i].map_or(running, |n| running.max(1.0 / (n + 1) as f64));
            self.since[i] = self.since[i].map(|n| n + 1);
            // What runs into its spring is left to it.
            let (low, high) = (twist[i].min(-self.play[i]), twist[i].max(self.play[i]));
            moved.by[i] = twist[i] - (twist[i] - share * found).clamp(low, high);
            moved.placed[i] = true;
            // An observer of position and rate, critically damped.
            moved.rate[i] = 0.5 * running.powi(2) / self.period * found;
        }
        moved
    }
}

/// Deviation of a tracker's position over that of its rotation, m; 0 where it does not see both.
pub(super) fn lever(noise: &NoiseLevels) -> f64 {
    let deviation = |levels: &[Option<NoiseLevel>; 3]| levels[0].map_or(0.0, |l| l.deviation);
    let lever = deviation(&noise.position) / deviation(&noise.rotation);
    if lever.is_finite() { lever } else { 0.0 }
}

/// By what the tool was seen turned from where it is predicted, rad, in B; NaN where nobody looked.
pub(super) fn turn(tool: &Pose<f64>, seen: Option<&Matrix3<f64>>) -> Vector3<f64> {
    let turn = |seen: &Matrix3<f64>| tool.rotation * rotation_vector(&tool.rotation.tr_mul(seen));
    seen.map_or(Vector3::repeat(f64::NAN), turn)
}

/// How links in their backlash are moved to where they were seen.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Moved {
    /// By so much, rad.
    pub by: JointVector<f64>,
    /// Change of their rates, rad/s.
    pub rate: JointVector<f64>,
    /// True for a link that is put where it was seen.
    pub placed: [bool; JOINTS],
}

/// Where tool and links were seen, less where they are predicted; NaN where nobody looked.
pub(super) struct Observed {
    /// TCP, in B, m.
    pub tool: Vector3<f64>,
    /// Rotation of the tool, in B, rad.
    pub turn: Vector3<f64>,
    /// Deviation of a seen position over that of a seen rotation, m.
    pub lever: f64,
    /// Deviation of a seen position, m, where each is believed by itself; 0 where many are averaged.
    pub deviation: f64,
    /// Second encoders, rad.
    pub link: [f64; JOINTS],
}

/// Share of what a second encoder reads that is believed at once: its noise is far below the
/// tracker's.
const OWN_SHARE: f64 = 0.5;

/// Deviations from which on a link that is seen once is believed to be elsewhere.
const ELSEWHERE_DEVIATIONS: f64 = 3.0;

/// Arm below which a joint moves the tool too little to be seen, m.
const LEAST_ARM: f64 = 0.1;
