//! Self-calibrating compensation: joint compliances estimated from the robot's own instruments, with
//! the plate as the reference.
//!
//! Under the push the encoders go deeper than the tool does, by what the arm bends towards the
//! plate; and where the tool is the plate says: on its surface, but for the depth at which the
//! material bears the push. Beyond the planned load ([`FeedForward`]) both the demand and that way
//! are linear in the relative errors ϑ of six compliances,
//!
//! ```text
//! x = x̂₀ + Φ ϑ,   Φ = Δ(J diag(K⁻¹ τ_s))
//! r = (E_z − f/k_z) − (x̂₀ − x̂₀(0, s₀))_z − Φ_z ϑ − d − n s
//! ```
//!
//! E_z: how far the encoders' pose lies below the set-point; f: measured push; k_z: stiffness of
//! the material; d, n: offset and slope of what is not known of plate and material. The angles along
//! the seam change Φ_z, so that joints are told apart; a Kalman filter takes a reading every
//! [`READING_DISTANCE`] of the way, at steady load.
//!
//! What is found moves the demand across and along the seam, and no reading there comes back: the
//! law closes no loop through the material across the seam.
//!
//! Needs: encoders, the push, a plate that lies where it was taught. Not observable: joints without
//! a lever into the plate (A5 and A6 of an arm whose tool points down), and what does not change
//! along the seam against an offset. Compliances are kept from weld to weld. Tuning: the priors.

use crate::OuterIntegral;
use crate::by_compliance::ByCompliance;
use crate::estimate::Estimate;
use crate::gain::{AT_MOST_ONE, AT_MOST_TEN, GainError, gains, positive, require, usable_period};
use crate::law::{Law, Needs, Setup};
use crate::laws::FeedForward;
use nalgebra::{SVector, Vector3};
use trueweld_core::compensation::{Compensator, Observation};
use trueweld_core::scalar::lit;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{Fault, JOINTS, Real, Robot, Twist, Wrench};

/// Unknowns: six compliances, offset and slope of the plate.
const CALIBRATION_UNKNOWNS: usize = JOINTS + 2;

/// Way between two readings, m.
const READING_DISTANCE: f64 = 0.02;

/// Length over which a plate's unevenness stays what it is, m: readings within it count as one.
const UNEVEN_OVER: f64 = 0.1;

/// Time constant of the low-pass on depth, s, and how many of them a steady load lasts before it is
/// believed.
const DEPTH_FILTER_TIME: f64 = 0.25;
const SETTLING_TIME_CONSTANTS: f64 = 4.0;

/// Change of the planned force over a period up to which it is steady, of the push, and relative error of
/// the push up to which it is the planned one.
const STEADY_FORCE_CHANGE: f64 = 1e-6;
const PUSH_ERROR_MAX: f64 = 0.05;

gains! {
    /// Gains of the self-calibrating law: how well the cell is known, one standard deviation each.
    pub struct SelfCalibratingGains {
        /// Of every joint's compliance, relative. 0.3: published stiffnesses of one robot differ by
        /// more.
        pub prior_compliance: f64 = 0.3,
        /// Of the plate's height at the start, and of the depth at which the material bears the push,
        /// m. 0.00025: clamping, and a third of 0.6 mm.
        pub prior_depth_m: f64 = 2.5e-4,
        /// Of the plate's slope along the seam, rad. 0.0001: 0.2 mm over 2 m.
        pub prior_slope_rad: f64 = 1e-4,
        /// Of the plate's unevenness, m. 0.00005.
        pub flatness_m: f64 = 5e-5,
        /// Stiffness k_z of the material under the tool, N/m. 30e6.
        pub material_stiffness_n_m: f64 = 30e6,
    }
}

/// Self-calibrating law.
#[derive(Debug, Clone)]
pub struct SelfCalibrating<T: Real> {
    estimate: Estimate<T, CALIBRATION_UNKNOWNS>,
    /// Variance of a reading.
    noise: T,
    compliance_of_material: T,
    period: T,
    by_compliance: ByCompliance<T>,
    /// x̂₀(0, s₀) along z of W, m.
    unloaded: Option<T>,
    depth: Option<Depth<T>>,
    frozen: bool,
}

/// What was seen of depth up to now.
#[derive(Debug, Clone, Copy)]
struct Depth<T: Real> {
    /// E_z − f/k_z, low-pass, m.
    bent: T,
    /// Planned force of the last period, axes of W, N, and how long it has been that, s.
    planned: Vector3<T>,
    since: T,
    /// Path position of the last reading, m.
    read: Option<T>,
}

impl<T: Real> SelfCalibrating<T> {
    /// A law that has learned nothing yet. `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless period and gains are positive, relative priors at most 10, and the
    /// others at most 1 rad and 1 m.
    pub fn new(gains: &SelfCalibratingGains, period: T) -> Result<Self, GainError> {
        let within = |value: f64, most: f64| value > 0.0 && value <= most;
        require(within(gains.prior_compliance, 10.0), "prior_compliance", AT_MOST_TEN)?;
        require(within(gains.prior_depth_m, 1.0), "prior_depth_m", AT_MOST_ONE)?;
        require(within(gains.prior_slope_rad, 1.0), "prior_slope_rad", AT_MOST_ONE)?;
        require(within(gains.flatness_m, 1.0), "flatness_m", AT_MOST_ONE)?;
        positive(gains.material_stiffness_n_m, "material_stiffness_n_m")?;
        usable_period(period)?;
        let prior = SVector::from_fn(|i, _| {
            lit(match i {
                0..JOINTS => gains.prior_compliance,
                JOINTS => gains.prior_depth_m,
                _ => gains.prior_slope_rad,
            })
        });
        Ok(Self {
            estimate: Estimate::new(prior, &SVector::zeros()),
            noise: lit(gains.flatness_m * gains.flatness_m * (UNEVEN_OVER / READING_DISTANCE)),
            compliance_of_material: lit(gains.material_stiffness_n_m.recip()),
            period,
            by_compliance: ByCompliance::new(),
            unloaded: None,
            depth: None,
            frozen: false,
        })
    }

    /// Estimated relative errors of the six compliances, each with its standard deviation.
    pub fn compliance(&self) -> [(T, T); JOINTS] {
        self.estimate.compliance()
    }

    /// What the arm bends towards the plate, m, where a reading of it is due.
    fn reading(&mut self, robot: &Robot<T>, observation: &Observation<'_, T>) -> Option<T> {
        let push = -observation.sensed.wrench.force.z;
        let load = observation.planned.force;
        let below = observation.encoder_displacement(robot).linear.z;
        let bent = below - push * self.compliance_of_material;
        let path = observation.path;
        if !(bent.is_finite() && path.is_finite()) {
            self.depth = None;
            return None;
        }
        let Some(depth) = &mut self.depth else {
            self.depth = Some(Depth { bent, planned: load, since: T::zero(), read: None });
            return None;
        };
        let share = self.period / (self.period + lit(DEPTH_FILTER_TIME));
        depth.bent += (bent - depth.bent) * share;
        let planned = -load.z;
        // While the feed rises, the drag does, and the arm bends by it in depth as well.
        let steady = (load - depth.planned).norm() <= planned.abs() * lit(STEADY_FORCE_CHANGE);
        let near =
            (push - planned).abs() <= planned.abs() * lit(PUSH_ERROR_MAX) && planned > T::zero();
        depth.since = if steady && near { depth.since + self.period } else { T::zero() };
        depth.planned = load;
        let due = depth.read.is_none_or(|read| (path - read).abs() >= lit(READING_DISTANCE));
        if !due || depth.since < lit(DEPTH_FILTER_TIME * SETTLING_TIME_CONSTANTS) {
            return None;
        }
        depth.read = Some(path);
        Some(depth.bent)
    }
}

impl<T: Real> Law<T> for SelfCalibrating<T> {
    const NAME: &'static str = "self-calibrating";
    const SUMMARY: &'static str =
        "Feed-forward, with stiffnesses learned from push and encoders (--passes)";
    const NEEDS: Needs = Needs { force_sensor: true, passes: true, ..Needs::NOTHING };
    type Gains = SelfCalibratingGains;
    type Built = OuterIntegral<T, Self>;

    fn build(gains: &SelfCalibratingGains, setup: &Setup<T>) -> Result<Self::Built, GainError> {
        let following = FeedForward::following(&setup.following);
        OuterIntegral::new(Self::new(gains, setup.period)?, &following, setup.period)
    }
}

impl<T: Real> Compensator<T> for SelfCalibrating<T> {
    fn reset(&mut self) {
        self.by_compliance = ByCompliance::new();
        self.unloaded = None;
        self.depth = None;
        self.estimate.forget_from(JOINTS);
    }

    fn freeze(&mut self) {
        self.frozen = true;
    }

    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault> {
        if !observation.sensed.wrench.is_finite() {
            return Err(Fault::Force);
        }
        let link = observation.nominal_angles(robot)?;
        let demand_for =
            |load: &Wrench<T>| observation.demand_for(robot, &robot.fake_target(&link, load));
        let planned = demand_for(&observation.planned_in_t());
        let columns = self.by_compliance.columns(robot, &robot.frames(&link), &link, observation);
        let unloaded = *self.unloaded.get_or_insert_with(|| demand_for(&Wrench::zero()).linear.z);
        if let Some(bent) = self.reading(robot, observation).filter(|_| !self.frozen) {
            let mut row = SVector::<T, CALIBRATION_UNKNOWNS>::zeros();
            row.fixed_rows_mut::<JOINTS>(0).copy_from(&columns.row(5).transpose());
            (row[JOINTS], row[JOINTS + 1]) = (T::one(), observation.path);
            let expected = planned.linear.z - unloaded + row.dot(self.estimate.unknown());
            self.estimate.update(&row, bent - expected, self.noise, T::zero());
        }
        let found = columns * self.estimate.unknown().fixed_rows::<JOINTS>(0);
        Ok(planned + Twist::from_vector(&found))
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.estimate.visit_state(visitor)?;
        self.by_compliance.visit_state(visitor)?;
        visitor.scalar_option(&mut self.unloaded)?;
        let zero = T::zero();
        let blank = Depth { bent: zero, planned: Vector3::zeros(), since: zero, read: None };
        visitor.option(&mut self.depth, blank, |visitor, depth| {
            visitor.scalar(&mut depth.bent)?;
            visitor.matrix(&mut depth.planned)?;
            visitor.scalar(&mut depth.since)?;
            visitor.scalar_option(&mut depth.read)
        })?;
        visitor.flag(&mut self.frozen)
    }
}
