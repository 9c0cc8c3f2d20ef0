//! Adaptive compensation: joint compliances estimated from whatever is seen of the tool's pose.
//!
//! On top of the planned load case ([`feed_forward`](crate::FeedForward)) the demand is linear in
//! what is not known of it,
//!
//! ```text
//! x = x̂₀ + Φ ϑ,   Φ = [ J diag(K⁻¹ τ_s)  |  −J K⁻¹ Jᵀ [f_x e_x, f_y e_y]  |  e_rx, e_y ]
//! ```
//!
//! ϑ: relative errors of six compliances and of the two planned forces in the plane, and two
//! offsets (a sensor's zero, a seam beside its taught line), that of lateral tilt and that across
//! the seam. Every sighting is one row of a Kalman filter,
//!
//! ```text
//! r = h·(E − x̂₀)(t − age) − z − φᵀϑ,  φ = Φᵀh,  s = φᵀPφ + R
//! ϑ ← ϑ + P φ r / s,   P ← P − P φ φᵀ P / s
//! ```
//!
//! * R is the square of the reading's noise, and never less than what Φ leaves out of any reading.
//! * Forgetting: P grows by Q a second, the compliances slowly, the offsets faster; only while
//!   there is excitation.
//! * Compliances and forces learn while the tool feeds evenly only: where it stands, the material
//!   holds it beside its line with forces that no plan has, and what they bend would pass for
//!   compliance. The offsets learn at all times.
//! * Freeze: a row that can teach nothing (φᵀPφ below a hundredth of R) changes neither ϑ nor P.
//! * Covariance bound: no variance ever exceeds its prior.
//! * Projection: ϑ stays within three priors, no compliance below 0.3 of the believed one.
//!
//! What is learned of compliances and planned forces stays from weld to weld; the offsets are begun
//! anew.
//!
//! Needs: sightings of any kind, at any times. Cannot see: compliances that no sighting shows apart
//! (a seam sensor alone shows sums of six; they serve well where they were learned, and less
//! elsewhere), depth, play and friction. Tuning: none beyond how well the model is known.

use crate::deviation_history::{DeviationHistory, beside_depth};
use crate::law::{GainError, Law, Needs, Setup, require, usable_period};
use crate::{FeedForward, OuterIntegral};
use nalgebra::{SMatrix, SVector, Vector3};
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::scalar::lit;
use trueweld_core::{Fault, Real, Robot, Twist, Wrench};

/// Unknowns: six compliances, two forces, two offsets.
const UNKNOWN: usize = 10;

/// First of the offsets.
const OFFSETS: usize = 8;

/// Change of the feed from period to period that is none, as a share of it; and way at even feed
/// from which on the material behind the tool has forgotten how it began, m: several shoulder
/// radii.
const EVEN: f64 = 0.01;
const SETTLED: f64 = 0.03;

/// What Φ leaves out of a reading, rad and m: the ripple of the process, and that the material
/// answers a correction with force. A reading with less noise than that is no better; believed in,
/// it makes the estimate fast enough to swing with the material.
const LEFT_OUT: [f64; 2] = [1e-4, 5e-5];

/// Deviations of its noise beyond which a reading says no more than so many.
const CLIPPED: f64 = 30.0;

/// A row that could lower no variance by more than this share of the noise teaches nothing.
const EXCITED: f64 = 0.01;

/// Deviations of the prior that an unknown is held within.
const REACH: f64 = 3.0;

/// Least relative compliance error: none is stiffer than 1/0.3 of what is believed.
const LEAST: f64 = -0.7;

/// Time in which forgetting would give an unknown its prior variance back, s: of compliances and
/// forces, and of offsets. With the least noise that is believed the latter makes the offset across
/// the seam follow at 4 rad/s, as fast as the plastic channel behind the tool lets it be (see seam
/// tracking).
const FORGOTTEN: [f64; 2] = [3600.0, 480.0];

/// How well the model is known: one standard deviation each.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "host", derive(serde::Serialize, serde::Deserialize))]
pub struct AdaptiveGains {
    /// Of every joint's compliance, relative. 0.3: published stiffnesses of one robot differ by
    /// more.
    pub prior_compliance: f64,
    /// Of the planned forces in the plane, relative. 0.3.
    pub prior_force: f64,
    /// Of the offset of lateral tilt, rad. 0.0005.
    pub prior_tilt_rad: f64,
    /// Of the offset across the seam, m. 0.0005.
    pub prior_lateral_m: f64,
}

impl Default for AdaptiveGains {
    fn default() -> Self {
        Self {
            prior_compliance: 0.3,
            prior_force: 0.3,
            prior_tilt_rad: 5e-4,
            prior_lateral_m: 5e-4,
        }
    }
}

/// Adaptive law.
#[derive(Debug, Clone)]
pub struct Adaptive<T: Real> {
    prior: SVector<T, UNKNOWN>,
    period: T,
    seen: DeviationHistory<T>,
    unknown: SVector<T, UNKNOWN>,
    covariance: SMatrix<T, UNKNOWN, UNKNOWN>,
    /// Path position and speed of the last period, and where the speed became even.
    fed: Option<(T, T, T)>,
    frozen: bool,
}

impl<T: Real> Adaptive<T> {
    /// A law that knows nothing yet. `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless period and priors are positive, relative ones at most 10, and the
    /// others at most 1 rad and 1 m.
    pub fn new(gains: &AdaptiveGains, period: T) -> Result<Self, GainError> {
        const UP_TO_10: &str = "a number above 0 and at most 10";
        const UP_TO_1: &str = "a number above 0 and at most 1";
        let within = |value: f64, most: f64| value > 0.0 && value <= most;
        require(within(gains.prior_compliance, 10.0), "prior_compliance", UP_TO_10)?;
        require(within(gains.prior_force, 10.0), "prior_force", UP_TO_10)?;
        require(within(gains.prior_tilt_rad, 1.0), "prior_tilt_rad", UP_TO_1)?;
        require(within(gains.prior_lateral_m, 1.0), "prior_lateral_m", UP_TO_1)?;
        usable_period(period)?;
        let prior = SVector::from_fn(|i, _| {
            lit(match i {
                0..6 => gains.prior_compliance,
                6 | 7 => gains.prior_force,
                8 => gains.prior_tilt_rad,
                _ => gains.prior_lateral_m,
            })
        });
        Ok(Self {
            prior,
            period,
            seen: DeviationHistory::new(period),
            unknown: SVector::zeros(),
            covariance: SMatrix::from_diagonal(&prior.component_mul(&prior)),
            fed: None,
            frozen: false,
        })
    }

    /// Relative errors of the six compliances as they are estimated, and the standard deviation of
    /// each.
    pub fn compliance(&self) -> [(T, T); 6] {
        core::array::from_fn(|i| (self.unknown[i], self.covariance[(i, i)].max(T::zero()).sqrt()))
    }

    /// Φ at the nominal pose under the planned load, axes of W.
    fn regressor(
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<SMatrix<T, 6, UNKNOWN>, Fault> {
        let link = robot
            .inverse_near(observation.nominal, &observation.sensed.encoder)
            .map_err(|_| Fault::Compensation)?;
        let frames = robot.frames(&link);
        let w = observation.setpoint.b_from_w;
        let load = observation.planned.rotated(&w);
        let twist =
            robot.spring_torque_at_rest(&frames, &link, &load).component_div(robot.stiffness());
        let jacobian = frames.jacobian();
        let compliance = robot.cartesian_compliance(&jacobian);
        let in_w = |v: SVector<T, 6>| Twist::from_vector(&v).rotated(&w.transpose()).to_vector();
        let mut regressor = SMatrix::<T, 6, UNKNOWN>::zeros();
        for i in 0..6 {
            regressor.set_column(i, &in_w(jacobian.0.column(i) * twist[i]));
        }
        for (i, part) in [
            (6, Vector3::x() * observation.planned.force.x),
            (7, Vector3::y() * observation.planned.force.y),
        ] {
            let force = Wrench { moment: Vector3::zeros(), force: w * part };
            regressor.set_column(i, &in_w(-(compliance * force.to_vector())));
        }
        regressor[(0, OFFSETS)] = T::one();
        regressor[(4, OFFSETS + 1)] = T::one();
        Ok(regressor)
    }

    /// True where the feed has been the same for long enough.
    fn feeds_evenly(&mut self, path: T) -> bool {
        let (before, speed, since) = self.fed.unwrap_or((path, T::zero(), path));
        let now = (path - before) / self.period;
        let even = now > T::zero() && (now - speed).abs() <= now * lit(EVEN);
        let since = if even { since } else { path };
        self.fed = Some((path, now, since));
        even && path - since >= lit(SETTLED)
    }

    fn learn(
        &mut self,
        regressor: &SMatrix<T, 6, UNKNOWN>,
        sighting: &DeviationMeasurement<T>,
        evenly: bool,
    ) {
        let mut row = regressor.tr_mul(&beside_depth(sighting));
        let expected = row.dot(&self.unknown);
        let Some(innovation) = self.seen.innovation(sighting, expected, CLIPPED) else {
            return;
        };
        if !evenly {
            row.rows_mut(0, OFFSETS).fill(T::zero());
        }
        let spread = self.covariance * row;
        let along =
            |axes: &Vector3<T>, left_out: f64| axes.norm_squared() * lit(left_out * left_out);
        let left_out = along(&sighting.along.angular, LEFT_OUT[0])
            + along(&sighting.along.linear, LEFT_OUT[1]);
        let (told, noise) = (row.dot(&spread), left_out.max(sighting.noise * sighting.noise));
        if !told.is_finite() || told < noise * lit(EXCITED) {
            return;
        }
        let gain = spread / (told + noise);
        self.unknown += gain * innovation;
        self.covariance -= gain * spread.transpose();
        for i in 0..UNKNOWN {
            let forgotten: T = lit(FORGOTTEN[usize::from(i >= OFFSETS)]);
            let most = self.prior[i] * self.prior[i];
            let grown = self.covariance[(i, i)] + most * self.period / forgotten;
            self.covariance[(i, i)] = grown.min(most).max(most * lit(1e-9));
            let reach = self.prior[i] * lit(REACH);
            let least = if i < 6 { (-reach).max(lit(LEAST)) } else { -reach };
            self.unknown[i] = self.unknown[i].max(least).min(reach);
        }
        // What rounding takes from its symmetry.
        let transposed = self.covariance.transpose();
        self.covariance = (self.covariance + transposed) * lit::<T>(0.5);
    }
}

impl<T: Real> Law<T> for Adaptive<T> {
    const NAME: &'static str = "adaptive";
    const SUMMARY: &'static str =
        "Feed-forward, with stiffnesses learned from a seam sensor (--passes)";
    const NEEDS: Needs = Needs { seam_sensor: true, passes: true, ..Needs::NOTHING };
    type Gains = AdaptiveGains;
    type Built = OuterIntegral<T, Self>;

    fn build(gains: &AdaptiveGains, setup: &Setup<T>) -> Result<Self::Built, GainError> {
        OuterIntegral::new(Self::new(gains, setup.period)?, &setup.following, setup.period)
    }
}

impl<T: Real> Compensator<T> for Adaptive<T> {
    fn reset(&mut self) {
        self.seen.reset();
        self.fed = None;
        for i in OFFSETS..UNKNOWN {
            self.unknown[i] = T::zero();
            for j in 0..UNKNOWN {
                (self.covariance[(i, j)], self.covariance[(j, i)]) = (T::zero(), T::zero());
            }
            self.covariance[(i, i)] = self.prior[i] * self.prior[i];
        }
    }

    fn freeze(&mut self) {
        self.frozen = true;
    }

    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault> {
        let planned = FeedForward.demand(robot, observation)?;
        let regressor = Self::regressor(robot, observation)?;
        self.seen.remember(robot, observation, &planned)?;
        let evenly = self.feeds_evenly(observation.path) && !self.frozen;
        for sighting in observation.sightings {
            self.learn(&regressor, sighting, evenly);
        }
        Ok(planned + Twist::from_vector(&(regressor * self.unknown)))
    }
}
