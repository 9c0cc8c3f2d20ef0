//! Adaptive compensation: joint compliances estimated from measurements of the tool's deviation.
//!
//! Beyond the planned load case ([`FeedForward`]) the demand is linear in the unknowns ϑ,
//!
//! ```text
//! x = x̂₀ + Φ ϑ,   Φ = [ Δ(J diag(K⁻¹ τ_s))  |  −J K⁻¹ Jᵀ [f_x e_x, f_y e_y]  |  e_rx, e_y ]
//! ```
//!
//! Δ: less its value with the arm unloaded where the set-point was taught.
//!
//! ϑ: relative errors of six compliances and of the two planned forces in the plane, and two
//! offsets (a sensor's zero, a seam beside its taught line), that of lateral tilt and that across
//! the seam. Every measurement is one update of a Kalman filter,
//!
//! ```text
//! r = h·(E − x̂₀)(t − age) − z − φᵀϑ,  φ = Φᵀh,  s = φᵀPφ + R
//! ϑ ← ϑ + P φ r / s,   P ← P − P φ φᵀ P / s + Q
//! ```
//!
//! * R is the variance of the measurement, and at least the square of what Φ leaves out.
//! * Forgetting: P grows at a rate Q, slowly for the compliances, faster for the offsets, and only
//!   under excitation.
//! * Compliances and forces are estimated at constant feed only: a tool that stands is held beside
//!   its line by forces that are not planned, and their deflection would be taken for compliance.
//!   The offsets are always estimated.
//! * A measurement without information (φᵀPφ below a hundredth of R) changes neither ϑ nor P.
//! * No variance exceeds its prior, and ϑ stays within bounds (see `estimate.rs`).
//!
//! Compliances and planned forces are kept from weld to weld; the offsets are reset.
//!
//! Needs: deviation measurements of any kind, at any time. Not observable: compliances that no
//! measurement separates (a seam sensor alone shows one sum of six, which holds where it was
//! learned and less elsewhere), depth, backlash, friction. Tuning: the priors.

use crate::by_compliance::ByCompliance;
use crate::deviation_history::{DeviationHistory, beside_depth};
use crate::estimate::Estimate;
use crate::gain::{AT_MOST_ONE, AT_MOST_TEN, GainError, gains, require, usable_period};
use crate::law::{Law, Needs, Setup};
use crate::{FeedForward, OuterIntegral};
use nalgebra::{SMatrix, SVector, Vector3};
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::scalar::lit;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{Fault, Real, Robot, Twist, Wrench};

/// Unknowns: six compliances, two forces, two offsets.
const ADAPTIVE_UNKNOWNS: usize = 10;

/// First of the offsets.
const OFFSETS: usize = 8;

/// Relative change of the feed over a period up to which it counts as constant; and distance at
/// constant feed after which the material behind the tool is in its steady state, m: several
/// shoulder radii.
const CONSTANT_FEED_CHANGE: f64 = 0.01;
const STEADY_MATERIAL_DISTANCE: f64 = 0.03;

/// What Φ leaves out of a measurement, rad and m: the ripple of the process, and the force with
/// which the material answers a correction. A smaller R would make the estimate so fast that it
/// oscillates with the material.
const UNMODELLED_DEVIATIONS: [f64; 2] = [1e-4, 5e-5];

/// Innovations are clipped at so many standard deviations of the noise.
const ADAPTIVE_INNOVATION_LIMIT: f64 = 30.0;

/// A measurement is used only where φᵀPφ is more than this share of R.
const EXCITED: f64 = 0.01;

/// Time in which forgetting restores the prior variance, s: of compliances and forces, and of
/// offsets. At the smallest R the offset across the seam then follows at 4 rad/s, the limit that
/// the plastic channel behind the tool sets (see seam tracking).
const FORGETTING_TIMES: [f64; 2] = [3600.0, 480.0];

gains! {
    /// Gains of the adaptive law: how well the model is known, one standard deviation each.
    pub struct AdaptiveGains {
        /// Of every joint's compliance, relative. 0.3: published stiffnesses of one robot differ by
        /// more.
        pub prior_compliance: f64 = 0.3,
        /// Of the planned forces in the plane, relative. 0.3.
        pub prior_force: f64 = 0.3,
        /// Of the offset of lateral tilt, rad. 0.0005.
        pub prior_tilt_rad: f64 = 5e-4,
        /// Of the offset across the seam, m. 0.0005.
        pub prior_lateral_m: f64 = 5e-4,
    }
}

/// Adaptive law.
#[derive(Debug, Clone)]
pub struct Adaptive<T: Real> {
    estimate: Estimate<T, ADAPTIVE_UNKNOWNS>,
    period: T,
    history: DeviationHistory<T>,
    /// Path position and speed of the last period, and where the speed became even.
    fed: Option<(T, T, T)>,
    by_compliance: ByCompliance<T>,
    frozen: bool,
}

impl<T: Real> Adaptive<T> {
    /// A law that has learned nothing yet. `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless period and priors are positive, relative ones at most 10, and the
    /// others at most 1 rad and 1 m.
    pub fn new(gains: &AdaptiveGains, period: T) -> Result<Self, GainError> {
        let within = |value: f64, most: f64| value > 0.0 && value <= most;
        require(within(gains.prior_compliance, 10.0), "prior_compliance", AT_MOST_TEN)?;
        require(within(gains.prior_force, 10.0), "prior_force", AT_MOST_TEN)?;
        require(within(gains.prior_tilt_rad, 1.0), "prior_tilt_rad", AT_MOST_ONE)?;
        require(within(gains.prior_lateral_m, 1.0), "prior_lateral_m", AT_MOST_ONE)?;
        usable_period(period)?;
        let prior = SVector::from_fn(|i, _| {
            lit(match i {
                0..6 => gains.prior_compliance,
                6 | 7 => gains.prior_force,
                8 => gains.prior_tilt_rad,
                _ => gains.prior_lateral_m,
            })
        });
        let growth = SVector::from_fn(|i, _| {
            let forgotten: T = lit(FORGETTING_TIMES[usize::from(i >= OFFSETS)]);
            period / forgotten
        });
        Ok(Self {
            estimate: Estimate::new(prior, &growth),
            period,
            history: DeviationHistory::new(period),
            fed: None,
            by_compliance: ByCompliance::new(),
            frozen: false,
        })
    }

    /// Estimated relative errors of the six compliances, each with its standard deviation.
    pub fn compliance(&self) -> [(T, T); 6] {
        self.estimate.compliance()
    }

    /// Φ at the nominal pose under the planned load, axes of W.
    fn regressor(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<SMatrix<T, 6, ADAPTIVE_UNKNOWNS>, Fault> {
        let link = observation.nominal_angles(robot)?;
        let frames = robot.frames(&link);
        let w = observation.setpoint.b_from_w;
        let jacobian = frames.jacobian();
        let compliance = robot.cartesian_compliance(&jacobian);
        let in_w = |v: SVector<T, 6>| Twist::from_vector(&v).rotated(&w.transpose()).to_vector();
        let columns = self.by_compliance.columns(robot, &frames, &link, observation);
        let mut regressor = SMatrix::<T, 6, ADAPTIVE_UNKNOWNS>::zeros();
        regressor.fixed_columns_mut::<6>(0).copy_from(&columns);
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

    /// True where the feed has been constant for long enough.
    fn feeds_evenly(&mut self, path: T) -> bool {
        let (before, speed, since) = self.fed.unwrap_or((path, T::zero(), path));
        let now = (path - before) / self.period;
        let even = now > T::zero() && (now - speed).abs() <= now * lit(CONSTANT_FEED_CHANGE);
        let since = if even { since } else { path };
        self.fed = Some((path, now, since));
        even && path - since >= lit(STEADY_MATERIAL_DISTANCE)
    }

    fn learn(
        &mut self,
        regressor: &SMatrix<T, 6, ADAPTIVE_UNKNOWNS>,
        measurement: &DeviationMeasurement<T>,
        evenly: bool,
    ) {
        let mut row = regressor.tr_mul(&beside_depth(measurement));
        let expected = row.dot(self.estimate.unknown());
        let Some(innovation) =
            self.history.innovation(measurement, expected, ADAPTIVE_INNOVATION_LIMIT)
        else {
            return;
        };
        if !evenly {
            row.rows_mut(0, OFFSETS).fill(T::zero());
        }
        let along =
            |axes: &Vector3<T>, left_out: f64| axes.norm_squared() * lit(left_out * left_out);
        let left_out = along(&measurement.along.angular, UNMODELLED_DEVIATIONS[0])
            + along(&measurement.along.linear, UNMODELLED_DEVIATIONS[1]);
        let noise = left_out.max(measurement.noise * measurement.noise);
        self.estimate.update(&row, innovation, noise, lit(EXCITED));
    }
}

impl<T: Real> Law<T> for Adaptive<T> {
    const NAME: &'static str = "adaptive";
    const SUMMARY: &'static str =
        "Feed-forward, with stiffnesses learned from a seam sensor (--passes)";
    const NEEDS: Needs = Needs { seam_sensor: true, passes: true, ..Needs::NOTHING };
    const BANDWIDTH_GAINS: &'static [&'static str] = &["prior_tilt_rad", "prior_lateral_m"];
    type Gains = AdaptiveGains;
    type Built = OuterIntegral<T, Self>;

    fn build(gains: &AdaptiveGains, setup: &Setup<T>) -> Result<Self::Built, GainError> {
        OuterIntegral::new(Self::new(gains, setup.period)?, &setup.following, setup.period)
    }
}

impl<T: Real> Compensator<T> for Adaptive<T> {
    fn reset(&mut self) {
        self.history.reset();
        self.fed = None;
        self.by_compliance = ByCompliance::new();
        self.estimate.forget_from(OFFSETS);
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
        let regressor = self.regressor(robot, observation)?;
        self.history.remember(robot, observation, &planned)?;
        let evenly = self.feeds_evenly(observation.path) && !self.frozen;
        for measurement in observation.measurements {
            self.learn(&regressor, measurement, evenly);
        }
        Ok(planned + Twist::from_vector(&(regressor * self.estimate.unknown())))
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.estimate.visit_state(visitor)?;
        self.history.visit_state(visitor)?;
        let zero = T::zero();
        visitor.option(&mut self.fed, (zero, zero, zero), |visitor, (path, speed, since)| {
            visitor.scalars([path, speed, since])
        })?;
        self.by_compliance.visit_state(visitor)?;
        visitor.flag(&mut self.frozen)
    }
}
