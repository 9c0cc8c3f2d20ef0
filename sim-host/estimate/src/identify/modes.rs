//! Modes of the arm on its springs as it rings after a brake's stop: frequencies and decay read off
//! the tracker alone, mode by mode, beside what the identified M, K and D make of them.
//!
//! With the motors locked M θ̈ + D θ̇ + K θ = 0 rings in the eigenvectors v of K v = ω² M v. A mode's
//! decay rate is σ = vᵀ D v/(2 vᵀ M v), and the paper's (1.5) reads it off two amplitudes a period T
//! apart: c = (2/T) ln(A₁/A₂) = 2σ, in 1/s. Axes 2 and 3 couple, and two modes may lie half a hertz
//! apart, so that no filter separates them within a second. Here a damped oscillation for each mode is
//! fitted to the three coordinates of the tracker at once, frequency, decay rate and amplitudes free,
//! from the eigenfrequencies on. Damping of the joints follows from the decay rates by least squares
//! over c = vᵀ D v.

use crate::identify::fit::IdentificationFit;
use crate::identify::number::TWO_SIDED;
use nalgebra::{DMatrix, DVector, Matrix6, SymmetricEigen, Vector3};
use trueweld_core::{JOINTS, JointVector};
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::noise::instruments;

/// One mode in one log.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Name of the log.
    pub log: String,
    /// Natural frequency by the identified M and K, rad/s.
    pub natural: f64,
    /// Damped frequency seen by the tracker, rad/s.
    pub frequency: f64,
    /// Half of its 95 % interval, rad/s.
    pub frequency_half: f64,
    /// c = 2σ by the decrement, 1/s.
    pub decay: f64,
    /// Half of its 95 % interval, 1/s.
    pub decay_half: f64,
    /// c by the identified D, 1/s.
    pub fitted: f64,
    /// Damping over critical damping, by the decrement.
    pub ratio: f64,
    /// Share of the mode's energy in each joint's spring.
    pub shares: [f64; JOINTS],
    /// Largest amplitude of the tool, m.
    pub amplitude: f64,
}

/// Damping of a joint by the decrements alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ByDecrement {
    /// Damping of the joint, N·m·s/rad.
    pub value: f64,
    /// Half of its 95 % interval, N·m·s/rad.
    pub half: f64,
}

/// Time after the encoders stand that is left out, s: what a brake does is over.
const BRAKE_SETTLING_TIME: f64 = 0.004;

/// Rows that a decay needs, and most that are looked at.
const DECAY_ROWS_MIN: usize = 100;
const DECAY_ROWS_MAX: usize = 1500;

/// Amplitude over the noise that a mode needs.
const MODE_AMPLITUDE_RATIO_MIN: f64 = 3.0;

/// Steps of the fit of one log.
const MODE_FIT_STEPS: usize = 40;

/// Most uncertainty of a decay rate, or of a joint's damping, over its value that is told.
const RATE_UNCERTAINTY_MAX: f64 = 0.5;

/// Eigenfrequencies, rad/s, and mode shapes with vᵀ M v = 1, slowest first.
fn eigen(inertia: &Matrix6<f64>, stiffness: &JointVector<f64>) -> Vec<(f64, JointVector<f64>)> {
    let soft = stiffness.map(|k| k.sqrt().recip());
    let scaled = Matrix6::from_fn(|i, j| soft[i] * inertia[(i, j)] * soft[j]);
    let SymmetricEigen { eigenvectors, eigenvalues } = scaled.symmetric_eigen();
    let mode = |k: usize| {
        let omega = eigenvalues[k].max(f64::MIN_POSITIVE).sqrt().recip();
        // u = K^½ v of length 1 has vᵀ K v = 1 = ω² vᵀ M v.
        (omega, eigenvectors.column(k).component_mul(&soft) * omega)
    };
    let mut modes: Vec<_> = (0..JOINTS).map(mode).collect();
    modes.sort_by(|a, b| a.0.total_cmp(&b.0));
    modes
}

/// First row from which on the encoders stand.
fn stands_from(log: &Log, noise: f64) -> Option<usize> {
    let encoder = &log.samples.encoder;
    let last = encoder.last()?;
    let moves = |q: &JointVector<f64>| (q - last).amax() > 6.0 * noise;
    Some(encoder.iter().rposition(moves).map_or(0, |k| k + 1))
}

/// What is fitted to a log: a constant and damped oscillations.
struct Ringing {
    time: Vec<f64>,
    position: Vec<Vector3<f64>>,
}

/// Damped oscillations at a point of their fit: amplitudes of cosine and sine of each, three
/// coordinates, after the constant.
struct Solved {
    amplitudes: DMatrix<f64>,
    residual: DMatrix<f64>,
    basis: DMatrix<f64>,
}

impl Ringing {
    /// Amplitudes by linear least squares, for poles (ω, σ).
    fn solve(&self, poles: &[[f64; 2]]) -> Option<Solved> {
        let n = self.time.len();
        let basis = DMatrix::from_fn(n, 1 + 2 * poles.len(), |row, column| {
            let t = self.time[row];
            match column {
                0 => 1.0,
                c => {
                    let [omega, sigma] = poles[(c - 1) / 2];
                    let (sine, cosine) = (omega * t).sin_cos();
                    (-sigma * t).exp() * if c % 2 == 1 { cosine } else { sine }
                }
            }
        });
        let measured = DMatrix::from_fn(n, 3, |row, c| self.position[row][c]);
        let amplitudes = basis.tr_mul(&basis).cholesky()?.solve(&basis.tr_mul(&measured));
        let residual = &measured - &basis * &amplitudes;
        Some(Solved { amplitudes, residual, basis })
    }

    /// Slopes of the prediction by ω and σ of every pole, with the amplitudes free: what the basis
    /// explains is taken out.
    fn slopes(&self, poles: &[[f64; 2]], at: &Solved) -> Option<Vec<DMatrix<f64>>> {
        let factor = at.basis.tr_mul(&at.basis).cholesky()?;
        let mut slopes = Vec::with_capacity(2 * poles.len());
        for (pole, part) in (0..poles.len()).flat_map(|pole| [(pole, 0), (pole, 1)]) {
            let of = DMatrix::from_fn(self.time.len(), 3, |row, c| {
                let t = self.time[row];
                let [cosine, sine] = [1 + 2 * pole, 2 + 2 * pole].map(|k| at.basis[(row, k)]);
                let [a, b] = [1 + 2 * pole, 2 + 2 * pole].map(|k| at.amplitudes[(k, c)]);
                match part {
                    0 => t * (b * cosine - a * sine),
                    _ => -t * (a * cosine + b * sine),
                }
            });
            slopes.push(&of - &at.basis * factor.solve(&at.basis.tr_mul(&of)));
        }
        Some(slopes)
    }

    /// Poles fitted from a start on, with the covariance of (ω, σ) of each in turn.
    fn fit(&self, start: &[[f64; 2]]) -> Option<(Vec<[f64; 2]>, Solved, DMatrix<f64>)> {
        let mut poles = start.to_vec();
        let mut at = self.solve(&poles)?;
        let mut damping = 1e-3;
        for _ in 0..MODE_FIT_STEPS {
            let slopes = self.slopes(&poles, &at)?;
            let m = slopes.len();
            let mut normal = DMatrix::from_fn(m, m, |i, j| slopes[i].dot(&slopes[j]));
            let right = DVector::from_fn(m, |i, _| slopes[i].dot(&at.residual));
            let before = at.residual.norm_squared();
            for i in 0..m {
                normal[(i, i)] *= 1.0 + damping;
            }
            let step = normal.cholesky()?.solve(&right);
            let next: Vec<[f64; 2]> = poles
                .iter()
                .enumerate()
                .map(|(k, [omega, sigma])| {
                    let most = 0.05 * omega;
                    let by = [step[2 * k], step[2 * k + 1]].map(|s| s.clamp(-most, most));
                    [omega + by[0], (sigma + by[1]).max(1e-3)]
                })
                .collect();
            match self.solve(&next).filter(|s| s.residual.norm_squared() <= before) {
                Some(there) => {
                    let gained = before - there.residual.norm_squared();
                    (poles, at) = (next, there);
                    damping = (damping * 0.1).max(1e-9);
                    if gained < 1e-7 * before {
                        break;
                    }
                }
                None if damping > 1e6 => break,
                None => damping *= 10.0,
            }
        }
        let slopes = self.slopes(&poles, &at)?;
        let m = slopes.len();
        let normal = DMatrix::from_fn(m, m, |i, j| slopes[i].dot(&slopes[j]));
        let numbers = m + 3 * at.basis.ncols();
        let freedom = (3 * self.time.len()).checked_sub(numbers)?.max(1);
        let variance = at.residual.norm_squared() / freedom as f64;
        let covariance = normal.cholesky()?.inverse() * variance;
        Some((poles, at, covariance))
    }
}

/// Modes of every ring-down, and the damping of the joints by their decrements.
pub(crate) fn modes(fit: &IdentificationFit) -> (Vec<Mode>, [Option<ByDecrement>; JOINTS]) {
    let robot = &fit.model.robot.robot;
    let levels = instruments(&fit.logs);
    let mut modes = Vec::new();
    // Rows of c = Σ D_j v_j², each over its deviation.
    let mut equations: Vec<([f64; JOINTS], f64)> = Vec::new();
    for (log, levels) in fit.logs.iter().zip(&levels) {
        let (LogKind::RingDown, Some(position)) = (log.kind, &log.samples.position) else {
            continue;
        };
        let encoder_noise = levels.encoder[0].map_or(0.0, |level| level.deviation);
        let Some(from) = stands_from(log, encoder_noise) else { continue };
        let begins = log.samples.time.get(from).map_or(f64::INFINITY, |t| t + BRAKE_SETTLING_TIME);
        let rows: Vec<usize> = (0..position.len())
            .filter(|k| log.samples.time[*k] >= begins && position[*k].sum().is_finite())
            .take(DECAY_ROWS_MAX)
            .collect();
        if rows.len() < DECAY_ROWS_MIN {
            continue;
        }
        let first = log.samples.time[rows[0]];
        let ringing = Ringing {
            time: rows.iter().map(|k| log.samples.time[*k] - first).collect(),
            position: rows.iter().map(|k| position[*k]).collect(),
        };
        let frames = robot.frames(&log.samples.encoder[rows[0]]);
        let natural = eigen(&robot.crba(&frames), robot.stiffness());
        let decay = |v: &JointVector<f64>| v.component_mul(v).dot(robot.damping());
        // Half of the sampling rate, and what is over before anything is seen of it.
        let step = ringing.time[ringing.time.len() - 1] / (ringing.time.len() - 1) as f64;
        let mut kept: Vec<usize> =
            (0..JOINTS).filter(|k| natural[*k].0 * step < 1.5 && natural[*k].0 > 0.0).collect();
        // Modes that are not seen leave the fit, the weakest first.
        let found = loop {
            let start: Vec<[f64; 2]> =
                kept.iter().map(|k| [natural[*k].0, 0.5 * decay(&natural[*k].1)]).collect();
            if start.is_empty() {
                break None;
            }
            let fitted = ringing.fit(&start);
            let worst = match &fitted {
                None => Some(kept.len() - 1),
                Some((poles, _, covariance)) => {
                    let doubt = |k: usize| covariance[(2 * k + 1, 2 * k + 1)].sqrt() / poles[k][1];
                    let astray = |k: usize| (poles[k][0] / start[k][0] - 1.0).abs() > 0.3;
                    let unseen = |k: &usize| {
                        astray(*k) || doubt(*k) > RATE_UNCERTAINTY_MAX / MODE_AMPLITUDE_RATIO_MIN
                    };
                    let unseen = (0..kept.len()).filter(unseen);
                    unseen.max_by(|a, b| doubt(*a).total_cmp(&doubt(*b)))
                }
            };
            match worst {
                Some(k) => drop(kept.remove(k)),
                None => break fitted,
            }
        };
        let Some((poles, at, covariance)) = found else { continue };
        for (i, k) in kept.iter().enumerate() {
            let (omega, shape) = &natural[*k];
            let [frequency, sigma] = poles[i];
            let deviation = |part: usize| covariance[(2 * i + part, 2 * i + part)].sqrt();
            let energy = shape.component_mul(shape).component_mul(robot.stiffness());
            let amplitude =
                |c: usize| at.amplitudes[(1 + 2 * i, c)].hypot(at.amplitudes[(2 + 2 * i, c)]);
            modes.push(Mode {
                log: log.name.clone(),
                natural: *omega,
                frequency,
                frequency_half: TWO_SIDED * deviation(0),
                decay: 2.0 * sigma,
                decay_half: 2.0 * TWO_SIDED * deviation(1),
                fitted: decay(shape),
                ratio: sigma / frequency.hypot(sigma),
                shares: (energy / energy.sum()).into(),
                amplitude: (0..3).map(amplitude).fold(0.0, f64::max),
            });
            let weight = (2.0 * deviation(1)).recip();
            equations.push((
                std::array::from_fn(|j| weight * shape[j] * shape[j]),
                weight * 2.0 * sigma,
            ));
        }
    }
    let damping = by_decrement(&equations, robot.damping());
    (modes, damping)
}

/// Damping of the joints by least squares over c = Σ D_j v_j²; `None` where the modes leave it open.
fn by_decrement(
    equations: &[([f64; JOINTS], f64)],
    near: &JointVector<f64>,
) -> [Option<ByDecrement>; JOINTS] {
    // In units of the damping identified, drawn to it by no more than a factor of three.
    const WIDE: f64 = 2.0;
    let mut normal = Matrix6::<f64>::identity() / (WIDE * WIDE);
    let mut right = JointVector::<f64>::repeat(1.0 / (WIDE * WIDE));
    for (row, value) in equations {
        let row = JointVector::from_fn(|j, _| row[j] * near[j]);
        normal += row * row.transpose();
        right += row * *value;
    }
    let Some(factor) = normal.cholesky() else { return [None; JOINTS] };
    let (solved, covariance) = (factor.solve(&right), factor.inverse());
    std::array::from_fn(|j| {
        let half = TWO_SIDED * covariance[(j, j)].sqrt();
        (half < RATE_UNCERTAINTY_MAX * solved[j])
            .then_some(ByDecrement { value: solved[j] * near[j], half: half * near[j] })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trueweld_plant::random::Random;

    #[test]
    fn two_modes_half_a_hertz_apart_are_told_from_a_second_of_three_coordinates() {
        // 12.1 and 12.6 Hz in different directions, 3 and 2.5 % damped, and noise of 30 µm; 200 times.
        let truth = [[76.0, 2.28], [79.2, 1.98]];
        let direction = [Vector3::new(8e-4, 6e-4, 0.0), Vector3::new(-2e-4, 1e-4, 9e-4)];
        let mut covered = [0; 2];
        for seed in 0..200 {
            let mut random = Random::new(seed, 0);
            let time: Vec<f64> = (0..1000).map(|k| k as f64 * 1e-3).collect();
            let position = time
                .iter()
                .map(|t| {
                    let of = |k: usize| {
                        let [omega, sigma] = truth[k];
                        direction[k] * (-sigma * t).exp() * (omega * t + k as f64).cos()
                    };
                    of(0) + of(1) + Vector3::from_fn(|_, _| 3e-5 * random.normal())
                })
                .collect();
            let ringing = Ringing { time, position };
            let (poles, _, covariance) = ringing.fit(&[[75.0, 2.0], [80.0, 2.0]]).unwrap();
            for k in 0..2 {
                let off = (poles[k][1] - truth[k][1]).abs();
                let deviation = covariance[(2 * k + 1, 2 * k + 1)].sqrt();
                covered[k] += usize::from(off < TWO_SIDED * deviation);
            }
        }
        // 95 % of 200 are 190 ± 6 (two standard deviations).
        assert!(covered.iter().all(|c| (180..=199).contains(c)), "{covered:?}");
    }
}
