//! Stiffness over torque, K(τ), axis by axis, as in the paper's figure 5 c, d; and the test whether
//! it is one number.
//!
//! The twist of a joint beyond τ/K is a broken line over its torque with a corner at each knot. How
//! far the tool goes for a twist is the Jacobian; the corners are fitted beside everything that the
//! fit is free in, but for that joint's own stiffness, whose place they take. A spring is linear
//! where the corners lie on one line: a χ² test. A curve is reckoned from the smallest torque that
//! the logs hold, since a constant twist is an encoder's zero.

use crate::identify::coordinates::FreeCoordinate;
use crate::identify::fit::IdentificationFit;
use crate::identify::number::TWO_SIDED;
use crate::predict::ComparedQuantity;
use nalgebra::{DMatrix, DVector, Matrix6, Vector3};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use trueweld_core::JOINTS;
use trueweld_plant::effects::Location;

/// Stretches between knots on the side with more torque.
const STRETCHES: usize = 4;

/// Rows that a stretch needs.
const LEAST_ROWS: usize = 4;

/// Share of the largest torque that a stretch is long at least.
const LEAST_SPAN: f64 = 0.1;

/// Probability below which one joint's spring counts as not linear. Corners that a few rows tell scatter
/// by more than χ² has it: of 18 linear springs in simulated plans two lay below 0.001, none below this.
const BY_CHANCE: f64 = 1e-6;

/// One point of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Spring torque, N·m.
    pub torque: f64,
    /// (τ − τ₀)/(δ − δ₀) from the curve's origin to here, N·m/rad.
    pub stiffness: f64,
    /// 95 % interval of the stiffness, N·m/rad.
    pub interval: [f64; 2],
    /// Twist beyond the origin's, rad.
    pub twist: f64,
}

/// Stiffness of one joint over its torque.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessCurve {
    /// The joint, from 0.
    pub joint: usize,
    /// Torque that it is reckoned from, N·m.
    pub origin: f64,
    /// The points, by torque.
    pub points: Vec<CurvePoint>,
    /// Probability that a linear spring shows as much.
    pub chance: f64,
}

impl StiffnessCurve {
    /// True where the logs do not show that the spring is anything but linear.
    pub fn is_linear(&self) -> bool {
        self.chance > BY_CHANCE
    }
}

/// Curves of the joints that are told and loaded over a range.
pub(crate) fn curves(fit: &IdentificationFit, asked: &[FreeCoordinate]) -> Vec<StiffnessCurve> {
    let told = |k: &usize| fit.told[*k];
    let joint = |k: usize| match asked[k].at {
        Location::Joint(joint) => curve(fit, fit.indices[k], joint),
        _ => None,
    };
    (0..asked.len()).filter(told).filter_map(joint).collect()
}

/// Torques at which the broken line has corners, the origin among them.
fn knots(torques: &[f64]) -> Option<(f64, Vec<f64>)> {
    let mut sorted = torques.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (*sorted.first()?, *sorted.last()?);
    let origin = 0f64.clamp(low, high);
    let span = (high - origin).max(origin - low) / STRETCHES as f64;
    if span <= LEAST_SPAN * high.abs().max(low.abs()) / STRETCHES as f64 {
        return None;
    }
    let rows = |from: f64, to: f64| sorted.iter().filter(|t| (from..=to).contains(*t)).count();
    let mut knots = Vec::new();
    for sign in [-1.0, 1.0] {
        let end = if sign < 0.0 { low } else { high };
        let (mut from, mut at) = (origin, origin + sign * span);
        while sign * (end - at) > -1e-9 * span {
            let between = if sign < 0.0 { rows(at, from) } else { rows(from, at) };
            if between >= LEAST_ROWS {
                knots.push(at);
                from = at;
            }
            at += sign * span;
        }
    }
    knots.sort_by(f64::total_cmp);
    (knots.len() >= 2).then_some((origin, knots))
}

/// Share of a corner in the broken line at a torque; the line goes on beyond its ends.
fn share(origin: f64, knots: &[f64], k: usize, torque: f64) -> f64 {
    let mut corners: Vec<(f64, Option<usize>)> =
        knots.iter().enumerate().map(|(k, t)| (*t, Some(k))).collect();
    corners.push((origin, None));
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    let after = corners.partition_point(|c| c.0 <= torque).clamp(1, corners.len() - 1);
    let (left, right) = (corners[after - 1], corners[after]);
    let s = (torque - left.0) / (right.0 - left.0);
    match (left.1 == Some(k), right.1 == Some(k)) {
        (true, _) => 1.0 - s,
        (_, true) => s,
        _ => 0.0,
    }
}

/// Slopes of a residual, and the residual.
type CurveRow = (DVector<f64>, f64);

fn curve(fit: &IdentificationFit, own: usize, joint: usize) -> Option<StiffnessCurve> {
    let torques: Vec<f64> = fit
        .fitted
        .residuals
        .iter()
        .flat_map(|p| p.motion.iter().flat_map(|m| m.spring.iter().map(|s| s[joint])))
        .collect();
    let (origin, knots) = knots(&torques)?;
    let stiffness = fit.model.robot.parameters.joints[joint].stiffness;
    // Slopes of every residual: of what is free, but for the joint's own stiffness, then of corners.
    let kept: Vec<usize> = (0..fit.fitted.slopes.len()).filter(|k| *k != own).collect();
    let n = kept.len() + knots.len();
    let (mut normal, mut right) = (DMatrix::<f64>::zeros(n, n), DVector::<f64>::zeros(n));
    // Slopes and residual of each component at each row: components of a row go together.
    let mut rows: Vec<[Option<CurveRow>; 6]> = Vec::new();
    for (log, experiment) in fit.problem.logs.iter().enumerate() {
        let prediction = &fit.fitted.residuals[log];
        let motion = prediction.motion.as_ref()?;
        let target = fit.logs[log].origin.target.unwrap_or_else(Vector3::zeros);
        let mut last = usize::MAX;
        let mut places: Vec<usize> = Vec::new();
        let (mut jacobian, mut turned) =
            (nalgebra::Matrix6::zeros(), nalgebra::Matrix3::identity());
        for (i, compared) in experiment.compared.iter().enumerate() {
            if compared.row != last {
                last = compared.row;
                let frames = fit.model.robot.robot.frames(&motion.link[last]);
                jacobian = frames.jacobian().0;
                turned = frames.tcp.rotation;
                // The point that was tracked: v + ω × R b.
                for j in 0..JOINTS {
                    let angular = jacobian.fixed_view::<3, 1>(0, j).into_owned();
                    let mut linear = jacobian.fixed_view_mut::<3, 1>(3, j);
                    linear += angular.cross(&(turned * target));
                }
            }
            let by_twist = match compared.quantity {
                ComparedQuantity::Position => {
                    jacobian[(3 + usize::from(compared.component), joint)]
                }
                ComparedQuantity::Rotation => {
                    let angular = jacobian.fixed_view::<3, 1>(0, joint);
                    turned.tr_mul(&angular)[usize::from(compared.component)]
                }
                _ => continue,
            } / compared.deviation;
            let torque = motion.spring[last][joint];
            let slope = DVector::from_fn(n, |k, _| match kept.get(k) {
                Some(k) => fit.fitted.slopes[*k][log].as_ref().map_or(0.0, |s| s[i]),
                None => by_twist * share(origin, &knots, k - kept.len(), torque),
            });
            let residual = prediction.residual[i];
            normal.ger(1.0, &slope, &slope, 1.0);
            right.axpy(residual, &slope, 1.0);
            let component = usize::from(compared.component)
                + if compared.quantity == ComparedQuantity::Position { 3 } else { 0 };
            while places.len() <= compared.row {
                places.push(rows.len());
                rows.push(Default::default());
            }
            rows[places[compared.row]][component] = Some((slope, residual));
        }
    }
    let linear = &fit.fitted.linear;
    for (i, k) in kept.iter().enumerate() {
        let weight = linear.prior[(*k, *k)];
        normal[(i, i)] += weight;
        right[i] += weight * linear.away[*k];
    }
    // In units in which each has a weight of 1.
    let scale = normal.diagonal().map(|own| if own > 0.0 { own.sqrt().recip() } else { 1.0 });
    let scaled = normal.component_mul(&(&scale * scale.transpose()));
    let factor = (scaled + DMatrix::from_diagonal_element(n, n, 1e-12)).cholesky()?;
    let solved = -factor.solve(&right.component_mul(&scale)).component_mul(&scale);
    let covariance = factor.inverse().component_mul(&(&scale * scale.transpose()));
    let first = kept.len();
    let corners = solved.rows(first, knots.len()).into_owned();
    // Noise of the wrench, and of points that a pose follows from, is shared by the components of a
    // row: what the residuals show of it counts, and at least the noise itself.
    let mut together = Matrix6::<f64>::zeros();
    let mut counts = Matrix6::<f64>::zeros();
    for row in &rows {
        for (i, a) in row.iter().enumerate() {
            for (j, b) in row.iter().enumerate() {
                if let (Some((slope_a, _)), Some((slope_b, _))) = (a, b) {
                    let left = |slope: &DVector<f64>, residual: f64| residual + slope.dot(&solved);
                    let [r, s] = [(slope_a, a), (slope_b, b)]
                        .map(|(slope, of)| left(slope, of.as_ref().map_or(0.0, |of| of.1)));
                    together[(i, j)] += r * s;
                    counts[(i, j)] += 1.0;
                }
            }
        }
    }
    let values: f64 = counts.diagonal().sum();
    let freedom = (values / (values - n as f64).max(1.0)).min(4.0);
    together = together.zip_map(&counts, |t, c| if c > 0.0 { freedom * t / c } else { 0.0 });
    for k in 0..6 {
        together[(k, k)] = together[(k, k)].max(1.0);
    }
    let mut score = DMatrix::<f64>::from_diagonal(&DVector::from_fn(n, |k, _| {
        kept.get(k).map_or(0.0, |k| linear.prior[(*k, *k)])
    }));
    for row in &rows {
        for (i, a) in row.iter().enumerate() {
            for (j, b) in row.iter().enumerate() {
                if let (Some((slope_a, _)), Some((slope_b, _))) = (a, b) {
                    score.ger(together[(i, j)], slope_a, slope_b, 1.0);
                }
            }
        }
    }
    let covariance = &covariance * score * &covariance;
    let of_corners = covariance.view((first, first), (knots.len(), knots.len())).into_owned();
    let of_corners = 0.5 * (&of_corners + of_corners.transpose());
    let points = (0..knots.len())
        .map(|k| {
            let load = knots[k] - origin;
            let twist = load / stiffness + corners[k];
            let wide = TWO_SIDED * of_corners[(k, k)].sqrt();
            let ends = [twist - wide, twist + wide].map(|t| load / t);
            CurvePoint {
                torque: knots[k],
                stiffness: load / twist,
                // A twist that may be none is a spring that may be rigid.
                interval: if (twist - wide) * (twist + wide) > 0.0 {
                    [ends[0].min(ends[1]), ends[0].max(ends[1])]
                } else {
                    [ends[0].max(ends[1]), f64::INFINITY]
                },
                twist,
            }
        })
        .collect();
    let chance = linear_by_chance(&knots, origin, &corners, &of_corners)?;
    Some(StiffnessCurve { joint, origin, points, chance })
}

/// Probability that corners of this covariance lie as far off a line through the origin by chance.
fn linear_by_chance(
    knots: &[f64],
    origin: f64,
    corners: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> Option<f64> {
    let factor = covariance.clone().cholesky()?;
    let line = DVector::from_iterator(knots.len(), knots.iter().map(|t| t - origin));
    let weighted = factor.solve(&line);
    let along = weighted.dot(corners) / weighted.dot(&line);
    let off = corners - line * along;
    let distance = off.dot(&factor.solve(&off));
    let freedom = knots.len() - 1;
    Some(ChiSquared::new(freedom as f64).ok()?.sf(distance))
}
