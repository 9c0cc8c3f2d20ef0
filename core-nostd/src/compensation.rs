//! Compensation of the tool's deviation, on top of a hybrid controller.
//!
//! A law ([`Compensator`]) turns measurements into a demanded correction of the pose set-point. Two
//! loops bring it onto the set-point, one for position (lateral and longitudinal in W) and one for
//! orientation; each follows the demand with a stated bandwidth, bounded in size and rate. Depth
//! stays with the force loop: S selects here too.
//!
//! A set-point is taught with the real arm, which puts right what the model has wrong there, and a
//! pose of the model has it wrong again. Demands therefore count from the state in which the weld was
//! taught, the arm bent by its own weight alone: with X̂(w) the model's pose under the load w and s₀
//! the place where the loop closes,
//!
//! ```text
//! demand(s) = X̂(w, s) ⊖ X_set(s) − (X̂(0, s₀) ⊖ X_set(s₀))
//! ```
//!
//! so that an error of geometry, zeros or stiffness enters with what load and way add to it.

use crate::control::{
    DriveCommand, ForceSensorCheck, ForceSensorLimits, HybridController, SensorReadings, Setpoint,
};
use crate::error::Fault;
use crate::robot::Robot;
use crate::scalar::{JointVector, Real};
use crate::spatial::{Pose, Twist, Wrench};
use crate::state::{StateError, StateResult, StateVisitor, Stateful};
use nalgebra::{Matrix3, SVector, Vector2, Vector3};

/// What an instrument outside the robot (a seam sensor, a tracker, a touch probe) saw of the tool's
/// deviation.
///
/// It sees h·d of the deviation d of the real tool from its nominal pose: a seam sensor a metres
/// ahead of the tool sees across the seam d_y + a·d_rz, a tracker one coordinate at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviationMeasurement<T: Real> {
    /// What was seen, h·d, m or rad.
    pub deviation: T,
    /// h, axes of W: per rad of rotation and per m of displacement at the TCP.
    pub along: Twist<T>,
    /// Standard deviation of its noise, m or rad.
    pub noise: T,
    /// How long ago it was seen, s.
    pub age: T,
    /// How far ahead of the tool along the seam, m: what is seen there of the seam's own shape the
    /// tool meets later.
    pub ahead: T,
}

impl<T: Real> DeviationMeasurement<T> {
    /// True for a reading that can be used at all: finite, with noise, of something, and not from
    /// the future.
    pub fn is_usable(&self) -> bool {
        let finite = self.deviation.is_finite() && self.along.is_finite() && self.noise.is_finite();
        let times = self.age.is_finite() && self.age >= T::zero() && self.ahead.is_finite();
        finite && times && self.noise > T::zero() && self.along.to_vector().amax() > T::zero()
    }

    /// h·d of a deviation d, axes of W.
    pub fn of(&self, deviation: &Twist<T>) -> T {
        self.along.to_vector().dot(&deviation.to_vector())
    }
}

/// Inputs of a law in one period.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a, T: Real> {
    /// The set-point before correction: where the encoders would be if nothing bent.
    pub setpoint: &'a Setpoint<T>,
    /// Where the real tool should be, `b_from_t`.
    pub nominal: &'a Pose<T>,
    /// Readings of the robot's instruments.
    pub sensed: &'a SensorReadings<T>,
    /// Where the tool is along the seam, m.
    pub path: T,
    /// The load that the weld was planned with at this instant: on the tool, at the TCP, axes of W.
    pub planned: Wrench<T>,
    /// Measurements from outside the robot since the last period; may be empty.
    pub measurements: &'a [DeviationMeasurement<T>],
    /// X̂(0, s₀) ⊖ X_set(s₀), axes of W, depth left out: how far the model had the unloaded arm from
    /// the set-point where that was taught (see the [module](self) text). [`Compensated`] fills it
    /// in. `None` for a set-point that was not taught: then the model is believed as it is.
    pub taught: Option<Twist<T>>,
}

impl<'a, T: Real> Observation<'a, T> {
    /// The robot's own instruments alone, at the start of a seam planned without load.
    pub fn of_robot(
        setpoint: &'a Setpoint<T>,
        nominal: &'a Pose<T>,
        sensed: &'a SensorReadings<T>,
    ) -> Self {
        Self {
            setpoint,
            nominal,
            sensed,
            path: T::zero(),
            planned: Wrench::zero(),
            measurements: &[],
            taught: None,
        }
    }

    /// How far the encoders' pose lies from the nominal one, axes of W.
    pub fn encoder_deviation(&self, robot: &Robot<T>) -> Twist<T> {
        let encoders = robot.forward_kinematics(&self.sensed.encoder);
        self.nominal.error_to(&encoders).rotated(&self.setpoint.b_from_w.transpose())
    }

    /// How far the set-point lies from the nominal pose before correction, axes of W.
    pub fn setpoint_deviation(&self) -> Twist<T> {
        self.nominal.error_to(&self.setpoint.pose).rotated(&self.setpoint.b_from_w.transpose())
    }

    /// How far the encoders' pose lies from the set-point before correction, axes of W.
    pub fn encoder_displacement(&self, robot: &Robot<T>) -> Twist<T> {
        self.encoder_deviation(robot) - self.setpoint_deviation()
    }

    /// Joint angles of the nominal pose on the encoders' branch, rad.
    ///
    /// # Errors
    /// [`Fault::Compensation`] where there are none.
    pub fn nominal_angles(&self, robot: &Robot<T>) -> Result<JointVector<T>, Fault> {
        robot.inverse_near(self.nominal, &self.sensed.encoder).map_err(|_| Fault::Compensation)
    }

    /// The planned load in axes of the tool frame T, as a force sensor would measure it.
    pub fn planned_in_t(&self) -> Wrench<T> {
        self.planned.rotated(&(self.nominal.rotation.transpose() * self.setpoint.b_from_w))
    }

    /// The way from the set-point to the pose that the encoders would see at these angles, axes of
    /// W, less that of the unloaded arm where the set-point was [taught](Self::taught): a law's
    /// demand.
    pub fn demand_for(&self, robot: &Robot<T>, encoder: &JointVector<T>) -> Twist<T> {
        self.way_from_setpoint(robot, encoder) - self.taught.unwrap_or_else(Twist::zero)
    }

    fn way_from_setpoint(&self, robot: &Robot<T>, encoder: &JointVector<T>) -> Twist<T> {
        let pose = robot.forward_kinematics(encoder);
        self.setpoint.pose.error_to(&pose).rotated(&self.setpoint.b_from_w.transpose())
    }

    /// X̂(0) ⊖ X_set of this period, axes of W, depth left out. `None` where the nominal pose is out
    /// of reach.
    fn unloaded(&self, robot: &Robot<T>) -> Option<Twist<T>> {
        let link = self.nominal_angles(robot).ok()?;
        let mut way = self.way_from_setpoint(robot, &robot.fake_target(&link, &Wrench::zero()));
        way.linear.z = T::zero();
        Some(way)
    }
}

/// A compensation law: from what it sees to the correction it demands, once a control period.
pub trait Compensator<T: Real> {
    /// The start of a weld: forgets what belongs to the last one. What was learned of the robot or
    /// of the part stays.
    fn reset(&mut self);

    /// Stops learning what would stay from weld to weld. No effect on a law that does not learn.
    fn freeze(&mut self) {}

    /// Demanded displacement of the set-point, axes of W, about the TCP: linear in m, angular as a
    /// rotation vector. Its depth component is ignored.
    ///
    /// # Errors
    /// [`Fault::Compensation`] where no correction can be formed, [`Fault::Force`] where the wrench
    /// is not a number; the loops then hold what they have.
    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault>;

    /// Shows its state, as [`Stateful`] does.
    ///
    /// # Errors
    /// [`StateError`]; [`StateError::Unsupported`] where a law does not list it.
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        let _ = visitor;
        Err(StateError::Unsupported)
    }
}

impl<T: Real, L: Compensator<T> + ?Sized> Compensator<T> for &mut L {
    fn reset(&mut self) {
        (**self).reset();
    }

    fn freeze(&mut self) {
        (**self).freeze();
    }

    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault> {
        (**self).demand(robot, observation)
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        (**self).visit_state(visitor)
    }
}

/// Bounds and speed of a compensation loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopLimits<T: Real> {
    /// First-order bandwidth with which the demand is followed, rad/s.
    pub bandwidth: T,
    /// Largest correction (Euclidean norm), m or rad.
    pub size: T,
    /// Largest rate of the correction, m/s or rad/s.
    pub rate: T,
}

/// A correction that follows its demand with limited bandwidth, rate and size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrectionLoop<T: Real, const D: usize> {
    limits: LoopLimits<T>,
    period: T,
    correction: SVector<T, D>,
}

/// Correction across and along the weld (y and x of W), m.
pub type LateralLoop<T> = CorrectionLoop<T, 2>;

/// Correction of the tool's orientation, rotation vector in W, rad.
pub type OrientationLoop<T> = CorrectionLoop<T, 3>;

impl<T: Real, const D: usize> CorrectionLoop<T, D> {
    /// A loop with nothing corrected.
    pub fn new(limits: LoopLimits<T>, period: T) -> Self {
        Self { limits, period, correction: SVector::zeros() }
    }

    /// One period: c ← c + (1 − e^(−bandwidth·period)) (demand − c), the step held within
    /// rate·period and the result within size. A demand that is not finite is not followed. Returns
    /// the correction and whether a limit held it.
    pub fn follow(&mut self, demand: &SVector<T, D>) -> (SVector<T, D>, bool) {
        if !crate::scalar::all_finite(demand.iter()) {
            return (self.correction, true);
        }
        let share = T::one() - (-self.limits.bandwidth * self.period).exp();
        let (step, slow) =
            shortened((demand - self.correction) * share, self.limits.rate * self.period);
        let (next, short) = shortened(self.correction + step, self.limits.size);
        self.correction = next;
        (next, slow || short)
    }

    /// Nothing corrected.
    pub fn reset(&mut self) {
        self.correction = SVector::zeros();
    }

    /// The correction in force, m or rad, axes of W.
    pub fn correction(&self) -> &SVector<T, D> {
        &self.correction
    }
}

/// The vector shortened to at most `limit`, and whether it was.
pub fn shortened<T: Real, const D: usize>(v: SVector<T, D>, limit: T) -> (SVector<T, D>, bool) {
    let norm = v.norm();
    if norm > limit { (v * (limit / norm), true) } else { (v, false) }
}

/// A displacement along (x) and across (y) the seam held within `limit`, Euclidean norm, and
/// whether it was: the part across is shortened last. A tool that lags along its seam still welds
/// on it; one beside it does not.
fn across_first<T: Real>(v: Vector2<T>, limit: T) -> (Vector2<T>, bool) {
    if v.norm() <= limit || !crate::scalar::all_finite(v.iter()) {
        return (v, false);
    }
    let across = v.y.max(-limit).min(limit);
    let along = (limit * limit - across * across).max(T::zero()).sqrt();
    (Vector2::new(v.x.max(-along).min(along), across), true)
}

/// A hybrid controller whose pose set-point is corrected by a law through the lateral and the
/// orientation loop.
#[derive(Debug, Clone, Copy)]
pub struct Compensated<T: Real, C, L> {
    controller: C,
    law: L,
    lateral: LateralLoop<T>,
    orientation: OrientationLoop<T>,
    force_sensor: ForceSensorCheck<T>,
    /// In the last period, m.
    path: Option<T>,
    /// As of the first period with the force loop closed, with the axes of W in B then.
    taught: Option<(Twist<T>, Matrix3<T>)>,
}

impl<T: Real, C: HybridController<T>, L: Compensator<T>> Compensated<T, C, L> {
    /// Puts `law` on top of `controller`. `lateral` limits in m and m/s, `orientation` limits in
    /// rad and rad/s.
    // Moved, not copied, to where it runs: a law may be large.
    #[inline(always)]
    pub fn new(
        controller: C,
        law: L,
        lateral: LoopLimits<T>,
        orientation: LoopLimits<T>,
        period: T,
    ) -> Self {
        Self {
            controller,
            law,
            lateral: CorrectionLoop::new(lateral, period),
            orientation: CorrectionLoop::new(orientation, period),
            force_sensor: ForceSensorCheck::new(ForceSensorLimits::unknown()),
            path: None,
            taught: None,
        }
    }

    /// With a force sensor that can read this in order: what it cannot is a fault.
    #[inline(always)]
    pub fn with_force_sensor_limits(self, limits: ForceSensorLimits<T>) -> Self {
        Self { force_sensor: ForceSensorCheck::new(limits), ..self }
    }

    /// Starts from rest with nothing corrected: the drives hold `torque` at `encoder` angles.
    pub fn start(&mut self, robot: &Robot<T>, encoder: &JointVector<T>, torque: &JointVector<T>) {
        self.controller.start(robot, encoder, torque);
        self.lateral.reset();
        self.orientation.reset();
        self.start_weld();
    }

    /// Starts a weld with the correction in force: the law forgets what belongs to the last one, and
    /// its new demand is followed from there.
    pub fn start_weld(&mut self) {
        self.law.reset();
        self.force_sensor.reset();
        self.path = None;
        self.taught = None;
    }

    /// One period. The law acts while the force loop is closed; before that its correction stays as
    /// it is. A force sensor that is stuck, beyond its range or contradicted by the drives
    /// ([`ForceSensorCheck`]) is a fault for law and controller alike; a nominal pose that is none
    /// and a path that cannot be are faults of the law.
    ///
    /// Returns the controller's command, with the law's fault if the controller had none.
    pub fn cycle(&mut self, robot: &Robot<T>, observation: &Observation<'_, T>) -> DriveCommand<T> {
        let Observation { setpoint, sensed, .. } = *observation;
        let wrench = self.force_sensor.checked(robot, setpoint, sensed);
        let sensed = &SensorReadings { wrench, ..*sensed };
        let followable = self.is_followable(robot, observation);
        let mut law_fault = None;
        let mut held = false;
        let authority = self.lateral.limits.size;
        if setpoint.force.is_some() && !followable {
            law_fault = Some(Fault::Compensation);
        } else if setpoint.force.is_some() {
            let w = setpoint.b_from_w;
            self.taught = self.taught.or_else(|| Some((self.taught_at(robot, observation)?, w)));
            // Along a curved seam W turns, and what was taught stays what it is in B.
            let taught =
                self.taught.map(
                    |(way, then)| {
                        if then == w { way } else { way.rotated(&(w.transpose() * then)) }
                    },
                );
            match self.law.demand(robot, &Observation { sensed, taught, ..*observation }) {
                Ok(demand) => {
                    let (linear, short) =
                        across_first(Vector2::new(demand.linear.x, demand.linear.y), authority);
                    held = short
                        | self.lateral.follow(&linear).1
                        | self.orientation.follow(&demand.angular).1;
                }
                Err(fault) => law_fault = Some(fault),
            }
        }
        let correction = self.correction().rotated(&setpoint.b_from_w);
        let corrected = Setpoint { pose: setpoint.pose.displaced(&correction), ..*setpoint };
        let mut command = self.controller.cycle(robot, &corrected, sensed);
        command.fault = command.fault.or(law_fault);
        command.limited.compensation |= held;
        command
    }

    /// True where the nominal pose is one, and the path is finite and has moved no faster than the arm
    /// can. It counts from the last period's, so that one wrong value is over after two.
    fn is_followable(&mut self, robot: &Robot<T>, observation: &Observation<'_, T>) -> bool {
        let path = observation.path;
        let step = robot.largest_tool_speed() * self.lateral.period;
        // Also false where a number is not finite.
        let moves = (path - self.path.unwrap_or(path)).abs() <= step;
        self.path = Some(path);
        moves && observation.nominal.is_rigid()
    }

    /// What the model has wrong of the taught pose. `None` where that is more than may be corrected:
    /// such a set-point was not taught.
    fn taught_at(&self, robot: &Robot<T>, observation: &Observation<'_, T>) -> Option<Twist<T>> {
        observation.unloaded(robot).filter(|way| {
            way.linear.norm() <= self.lateral.limits.size
                && way.angular.norm() <= self.orientation.limits.size
        })
    }

    /// The law.
    pub fn law(&mut self) -> &mut L {
        &mut self.law
    }

    /// The correction in force, axes of W: linear in m (depth zero), angular as a rotation vector.
    pub fn correction(&self) -> Twist<T> {
        let c = self.lateral.correction();
        Twist { angular: *self.orientation.correction(), linear: Vector3::new(c.x, c.y, T::zero()) }
    }
}

impl<T: Real, const D: usize> Stateful for CorrectionLoop<T, D> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.matrix(&mut self.correction)
    }
}

impl<T: Real, C: HybridController<T>, L: Compensator<T>> Stateful for Compensated<T, C, L> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.controller.visit_state(visitor)?;
        self.law.visit_state(visitor)?;
        self.lateral.visit_state(visitor)?;
        self.orientation.visit_state(visitor)?;
        self.force_sensor.visit_state(visitor)?;
        visitor.scalar_option(&mut self.path)?;
        let untaught = (Twist::zero(), Matrix3::zeros());
        visitor.option(&mut self.taught, untaught, |visitor, (way, axes)| {
            visitor.twist(way)?;
            visitor.matrix(axes)
        })
    }
}
