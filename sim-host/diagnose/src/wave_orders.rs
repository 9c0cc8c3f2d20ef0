//! Orders of a wave over a joint's angle that logs show: the spectrum of what calibrations leave against
//! that angle, beside all calibrations.
//!
//! A sine of the angle θ times the response s to a constant has the sums Σ s a sin nθ and Σ s a cos nθ
//! with every column a of the calibrations. Calibrations hide part of a wave, and of few angles almost all
//! of it: without them the highest lines lie beside the true order. The sums are those of a histogram
//! over the angle, and its Fourier transform gives them for all orders at once, whatever the number of
//! rows (least-squares spectra: Lomb 1976; with other columns free: Zechmeister and Kürster 2009).

use nalgebra::{Complex, DMatrix, DVector};
use rayon::prelude::*;
use realfft::{RealFftPlanner, RealToComplex};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;
use trueweld_estimate::fit::{Fitted, ReducedFit, Slopes};
use trueweld_estimate::predict::PreparedLog;

/// Highest order that is looked for.
pub(crate) const HIGHEST_ORDER: f64 = 300.0;

/// Orders that are given: the highest lines.
const LINES: usize = 3;

/// Angles from which on a wave shows, rad, and the largest step between orders that are tried.
const RANGE_MIN: f64 = 1e-3;
const SPACING_MAX: f64 = 4.0;

/// Bins of the angle in half a turn of twice the highest order.
const BINS_IN_HALF_TURN: f64 = 4.0;

/// A wave over a joint's angle that is looked for.
pub(crate) struct SoughtWave<'a> {
    /// The joint.
    pub joint: usize,
    /// Response to a constant in place of the wave, of the fit's unit of size.
    pub slope: &'a Slopes,
    /// Highest order that is plausible.
    pub top: f64,
    /// Largest size that is plausible, in the fit's unit.
    pub largest: f64,
}

/// Orders with the highest lines, best first; none where the joint hardly moves. `fitted`: the
/// calibrations at their best; `base`: the same with all its values taken out.
pub(crate) fn likeliest_orders(
    logs: &[PreparedLog],
    (fitted, base): (&Fitted, &ReducedFit<'_>),
    wave: &SoughtWave<'_>,
) -> Vec<f64> {
    let Some(spectra) = AngleSpectra::of(logs, fitted, wave) else { return Vec::new() };
    let power: Vec<(f64, f64)> =
        spectra.orders().into_par_iter().map(|k| spectra.gain(base, k, wave.largest)).collect();
    let at = |j: usize| power.get(j).map_or(0.0, |p| p.1);
    let is_peak = |k: &usize| {
        at(*k) > 0.0 && at(*k) >= at(k + 1) && k.checked_sub(1).is_none_or(|j| at(*k) >= at(j))
    };
    let mut peaks: Vec<usize> = (0..power.len()).filter(is_peak).collect();
    peaks.sort_by(|a, b| power[*b].1.total_cmp(&power[*a].1));
    peaks.iter().take(LINES).map(|k| power[*k].0).collect()
}

/// Fourier transforms over a joint's angle.
struct AngleSpectra {
    /// Of s a, for every column a of the calibrations; then of s r, for the residual r.
    columns: Vec<Vec<Complex<f64>>>,
    /// Of s².
    squares: Vec<Complex<f64>>,
    /// Step from one order to the next.
    spacing: f64,
    /// Angle of the first bin, rad.
    first: f64,
    /// Highest order that is looked at.
    top: f64,
}

impl AngleSpectra {
    fn of(logs: &[PreparedLog], fitted: &Fitted, wave: &SoughtWave<'_>) -> Option<Self> {
        let mut rows: Vec<(usize, usize, f64)> = Vec::new();
        for (log, experiment) in logs.iter().enumerate() {
            let (Some(slope), Some(motion)) = (&wave.slope[log], &fitted.residuals[log].motion)
            else {
                continue;
            };
            let seen = (0..slope.len()).filter(|i| slope[*i] != 0.0);
            rows.extend(
                seen.map(|i| (log, i, motion.link[experiment.compared[i].row][wave.joint])),
            );
        }
        let ends = [f64::INFINITY, f64::NEG_INFINITY];
        let [low, high] = rows.iter().fold(ends, |[l, h], row| [l.min(row.2), h.max(row.2)]);
        let range = high - low;
        if range.is_nan() || range <= RANGE_MIN {
            return None;
        }
        let top = wave.top.min(HIGHEST_ORDER);
        let bins = (range * 2.0 * top * BINS_IN_HALF_TURN / PI).ceil();
        let width = range / bins;
        // Half a turn of phase over the range tells two orders apart.
        let spacing = (FRAC_PI_2 / range).min(SPACING_MAX);
        let length = (TAU / (spacing * width)).ceil() as usize;
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
        let bin = |angle: f64| (((angle - low) / width) as usize).min(bins as usize - 1);
        let slope = |log: usize, i: usize| wave.slope[log].as_ref().map_or(0.0, |s| s[i]);
        let spectrum = |value: &(dyn Fn(usize, usize) -> f64 + Sync)| {
            let mut sums = vec![0.0; length];
            rows.iter().for_each(|(log, i, angle)| {
                sums[bin(*angle)] += slope(*log, *i) * value(*log, *i);
            });
            transformed(&transform, sums)
        };
        let of_column = |column: &Slopes| {
            spectrum(&|log: usize, i: usize| column[log].as_ref().map_or(0.0, |a| a[i]))
        };
        let mut columns: Vec<Vec<Complex<f64>>> = fitted.slopes.par_iter().map(of_column).collect();
        columns.push(spectrum(&|log: usize, i: usize| fitted.residuals[log].residual[i]));
        let spacing = TAU / (length as f64 * width);
        Some(Self { columns, squares: spectrum(&slope), spacing, first: low + 0.5 * width, top })
    }

    /// Lines of the orders that are looked at, from 1 on.
    fn orders(&self) -> Vec<usize> {
        let highest = (self.top / self.spacing) as usize;
        let lines = (1.0 / self.spacing).ceil() as usize..=highest;
        lines.filter(|k| 2 * k < self.squares.len()).collect()
    }

    /// Σ h e^(inθ) of a histogram h, n the order of line `k`: cosine and sine.
    fn sum(&self, spectrum: &[Complex<f64>], k: usize) -> Complex<f64> {
        let turn = Complex::from_polar(1.0, k as f64 * self.spacing * self.first);
        turn * spectrum[k].conj()
    }

    /// The order of line `k`, and by how much the sum of squares falls with a wave of it; by nothing
    /// where that would be larger than `largest`: of a short range a slow wave of any height is made,
    /// but none is of any height.
    fn gain(&self, base: &ReducedFit<'_>, k: usize, largest: f64) -> (f64, f64) {
        let of_columns: Vec<Complex<f64>> = self.columns.iter().map(|c| self.sum(c, k)).collect();
        let (own, calibrations) = (of_columns[of_columns.len() - 1], of_columns.len() - 1);
        let part = |z: Complex<f64>, cosine: usize| if cosine == 1 { z.re } else { z.im };
        let cross = DMatrix::from_fn(calibrations, 2, |j, cosine| part(of_columns[j], cosine));
        let (all, double) = (self.squares[0].re, self.sum(&self.squares, 2 * k));
        let jtj = DMatrix::from_row_slice(
            2,
            2,
            &[0.5 * (all - double.re), 0.5 * double.im, 0.5 * double.im, 0.5 * (all + double.re)],
        );
        let jtr = DVector::from_vec(vec![own.im, own.re]);
        let beside = base.beside_products(&cross, jtj, jtr);
        let wave = beside.least().filter(|wave| wave.norm() < largest);
        (k as f64 * self.spacing, wave.map_or(0.0, |wave| -beside.at(&wave)).max(0.0))
    }
}

fn transformed(transform: &Arc<dyn RealToComplex<f64>>, mut sums: Vec<f64>) -> Vec<Complex<f64>> {
    let mut spectrum = transform.make_output_vec();
    match transform.process(&mut sums, &mut spectrum) {
        Ok(()) => spectrum,
        Err(_) => vec![Complex::ZERO; spectrum.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::static_loads::STATIC_LOADS;
    use trueweld_core::JointVector;
    use trueweld_estimate::fit::{self, FitState, Linear, Termination};
    use trueweld_estimate::predict::{LinkMotion, Prediction};

    /// The angle of A1 in a row, rad.
    fn angle(row: usize) -> f64 {
        0.3 + 0.004 * row as f64
    }

    /// What calibrations leave of a wave of this order, where they are so many powers of the angle.
    fn left(order: f64, calibrations: i32) -> Fitted {
        let compared = &STATIC_LOADS.logs[0].compared;
        let by_angle = |value: &dyn Fn(f64) -> f64| {
            compared.iter().map(|c| value(angle(c.row))).collect::<Vec<f64>>()
        };
        let last = compared.iter().map(|c| c.row).max().unwrap();
        let motion = LinkMotion {
            link: (0..=last).map(|row| JointVector::repeat(angle(row))).collect(),
            ..LinkMotion::default()
        };
        let at = |residual| {
            let motion = Some(Arc::new(motion.clone()));
            vec![Prediction { residual, motion, late: None, not_evidence: 0.0, noise: None }]
        };
        let slopes: Vec<Slopes> = (0..calibrations)
            .map(|power| vec![Some(by_angle(&|q| ((q - 0.4) * 10.0).powi(power)))])
            .collect();
        let columns: Vec<&Slopes> = slopes.iter().collect();
        let blocks = fit::blocks_of(&STATIC_LOADS);
        let n = slopes.len();
        let none = || (DMatrix::zeros(n, n), DVector::zeros(n));
        let linear_at = |at: &_| {
            let (prior, away) = none();
            Linear::new(&blocks, at, &columns, prior, away)
        };
        let mut residual = by_angle(&|q| -5.0 * (order * q + 1.0).sin());
        let step = linear_at(&at(residual.clone())).solve(None, 0.0, None).unwrap().step;
        for (slope, step) in slopes.iter().zip(step.iter()) {
            let slope = slope[0].as_ref().unwrap();
            residual.iter_mut().zip(slope).for_each(|(r, a)| *r += a * step);
        }
        let residuals = at(residual);
        let linear = linear_at(&residuals);
        Fitted {
            point: FitState::empty(1),
            cost: fit::chi_square(&residuals),
            residuals,
            slopes,
            linear,
            termination: Termination::Converged,
        }
    }

    fn found(fitted: &Fitted, largest: f64) -> Vec<f64> {
        let base = ReducedFit::of(fitted).unwrap();
        let slope = vec![Some(vec![1.0; STATIC_LOADS.logs[0].compared.len()])];
        let wave = SoughtWave { joint: 0, slope: &slope, top: 400.0, largest };
        likeliest_orders(&STATIC_LOADS.logs, (fitted, &base), &wave)
    }

    #[test]
    fn a_wave_that_calibrations_hide_is_found_at_its_order() {
        let last = STATIC_LOADS.logs[0].compared.iter().map(|c| c.row).max().unwrap();
        for (order, calibrations) in [(31.0, 1), (31.0, 4), (74.0, 4), (74.0, 8), (190.0, 8)] {
            let best = found(&left(order, calibrations), f64::INFINITY)[0];
            let off = (best - order).abs() * (angle(last) - angle(0));
            assert!(off < FRAC_PI_2, "{order} beside {calibrations}: {best}");
        }
    }

    #[test]
    fn a_wave_that_is_larger_than_any_is_none() {
        assert!(found(&left(74.0, 4), 1.0).iter().all(|order| (order - 74.0).abs() > 10.0));
    }
}
