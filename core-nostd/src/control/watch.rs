//! Checks of what a period is given, before a controller or a law acts on it.
//!
//! A live force sensor has noise: its six channels do not all repeat to the last digit for long. They
//! do where the sensor is stuck or saturated, has dropped to zero, or its bus repeats the last
//! telegram. And no reading lies beyond what the sensor can measure: one that does is of the bus or
//! of an overloaded sensor. Such readings are replaced by NaN, and controllers and laws hold as for
//! any faulty sensor. A force loop on a stuck reading would press the tool in up to its limits, and a
//! law on a single wrong one moves it by millimetres.
//!
//! A sensor whose noise goes on while its signal is lost is found by the drives: what they bear
//! beyond weight and measured load is a push that the sensor does not show. Along the depth axis n,
//! at rest, by least squares with each joint's torque over its rating m,
//!
//! ```text
//! δ = Σ t_i r_i / m_i² / Σ t_i² / m_i²,   t = Jᵀ n,   r = Γ − (g − τ_cb − Jᵀ w)
//! ```
//!
//! Friction and acceleration, which are left out, payload, counterbalance and the drives' torque
//! constants make |δ| a few kN on a heavy robot that welds: only a sensor that is grossly wrong
//! shows.
//!
//! Requires noise above the sensor's resolution while the force loop is closed: with the tool free
//! and at rest, a coarse sensor repeats its reading too. Not detected: a reading that is wrong but
//! still noisy, within the range, and near what the drives bear.

use super::{SensorReadings, Setpoint};
use crate::error::Fault;
use crate::robot::Robot;
use crate::scalar::{JOINTS, JointVector, Real, lit};
use crate::spatial::Wrench;
use crate::state::{StateResult, StateVisitor, Stateful};
use nalgebra::Vector3;

/// Number of periods in a row from which on a sensor that repeats itself counts as stuck, and one
/// that the drives contradict as wrong: in four periods of 12 ms the external force loop moves the
/// depth by half a millimetre at most.
pub const STUCK: u8 = 4;

/// Counts equal readings in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RepeatCounter<V> {
    last: Option<V>,
    equal: u8,
}

impl<V: PartialEq> RepeatCounter<V> {
    /// Nothing read yet.
    pub const fn new() -> Self {
        Self { last: None, equal: 0 }
    }

    /// Takes a reading; returns how many in a row have been equal to it, itself included.
    pub fn count(&mut self, reading: V) -> u8 {
        if self.last.as_ref() == Some(&reading) {
            self.equal = self.equal.saturating_add(1);
        } else {
            (self.last, self.equal) = (Some(reading), 1);
        }
        self.equal
    }
}

impl<V: PartialEq> Default for RepeatCounter<V> {
    fn default() -> Self {
        Self::new()
    }
}

/// What a force sensor that is in order can read. 0: not known, and not checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceSensorLimits<T: Real> {
    /// Largest moment of each channel, N·m.
    pub moment: T,
    /// Largest force of each channel, N.
    pub force: T,
    /// Largest difference between the push that it shows and the push that the drives bear, N.
    pub disagreement: T,
}

impl<T: Real> ForceSensorLimits<T> {
    /// Not known.
    pub fn unknown() -> Self {
        Self { moment: T::zero(), force: T::zero(), disagreement: T::zero() }
    }

    /// True where every channel is within its range; at its end the sensor is saturated.
    fn holds(&self, wrench: &Wrench<T>) -> bool {
        let within = |channels: &Vector3<T>, most: T| {
            most <= T::zero() || channels.iter().all(|channel| channel.abs() < most)
        };
        within(&wrench.moment, self.moment) && within(&wrench.force, self.force)
    }
}

/// Replaces the readings of a force sensor that is stuck, beyond its range or contradicted by the
/// drives by NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceSensorCheck<T: Real> {
    repeated: RepeatCounter<Wrench<T>>,
    limits: ForceSensorLimits<T>,
    /// Periods in a row in which the drives bore another push.
    contradicted: u8,
}

impl<T: Real> ForceSensorCheck<T> {
    /// Nothing read yet.
    pub fn new(limits: ForceSensorLimits<T>) -> Self {
        Self { repeated: RepeatCounter::new(), limits, contradicted: 0 }
    }

    /// Forgets what was read.
    pub fn reset(&mut self) {
        *self = Self::new(self.limits);
    }

    /// Takes the reading of this period and returns it. Or NaN: from the [`STUCK`]th equal reading
    /// on, until one differs in any channel; for a reading beyond the range; and from the
    /// [`STUCK`]th period on in which the drives bear another push, until they agree. Drives are
    /// asked while a push is asked for and their torque is known: not NaN, and not zero in every
    /// joint.
    pub fn checked(
        &mut self,
        robot: &Robot<T>,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
    ) -> Wrench<T> {
        let wrench = sensed.wrench;
        let contradicted = setpoint.force.is_some()
            && self.limits.disagreement > T::zero()
            && unseen_push(robot, setpoint, sensed).abs() > self.limits.disagreement;
        self.contradicted = if contradicted { self.contradicted.saturating_add(1) } else { 0 };
        let repeated = self.repeated.count(wrench);
        if repeated < STUCK && self.contradicted < STUCK && self.limits.holds(&wrench) {
            return wrench;
        }
        let nan = Vector3::repeat(lit(f64::NAN));
        Wrench { moment: nan, force: nan }
    }
}

/// Push along z of W that the drives bear and the force sensor does not show, δ of the
/// [module](self) text, N. NaN where a reading is; 0 where no torque is known.
fn unseen_push<T: Real>(robot: &Robot<T>, setpoint: &Setpoint<T>, sensed: &SensorReadings<T>) -> T {
    if sensed.motor_torque == JointVector::zeros() {
        return T::zero();
    }
    let frames = robot.frames(&sensed.encoder);
    let shown = sensed.wrench.rotated(&frames.tcp.rotation);
    let of_push =
        frames.joint_torque(&Wrench { moment: Vector3::zeros(), force: setpoint.depth_axis() });
    let unexplained =
        sensed.motor_torque - robot.spring_torque_at_rest(&frames, &sensed.encoder, &shown);
    let (mut along, mut square) = (T::zero(), T::zero());
    for (i, joint) in robot.parameters().joints.iter().enumerate() {
        let (t, r) = (of_push[i] / joint.max_torque, unexplained[i] / joint.max_torque);
        along += t * r;
        square += t * t;
    }
    along / square
}

/// Checks encoders and set-point from period to period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InputCheck<T: Real> {
    last_good: JointVector<T>,
    /// Time since they were good before this period, s.
    without: T,
}

impl<T: Real> InputCheck<T> {
    /// Starts at these encoder angles, rad.
    pub fn new(encoder: &JointVector<T>) -> Self {
        Self { last_good: *encoder, without: T::zero() }
    }

    /// Encoder angles of the last period in which they were good, rad.
    pub fn last_good(&self) -> &JointVector<T> {
        &self.last_good
    }

    /// Takes what a period is given. `elapsed`: since the last one, s.
    ///
    /// # Errors
    /// [`Fault::Encoder`], [`Fault::Setpoint`], [`Fault::Limit`].
    pub fn check(
        &mut self,
        robot: &Robot<T>,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
        elapsed: T,
    ) -> Result<(), Fault> {
        self.without += elapsed;
        for i in 0..JOINTS {
            let (angle, rate) = (sensed.encoder[i], sensed.encoder_rate[i]);
            let reach = robot.parameters().joints[i].max_rate * self.without * lit(2.0);
            if !angle.is_finite() || !rate.is_finite() || (angle - self.last_good[i]).abs() > reach
            {
                return Err(Fault::Encoder(i));
            }
        }
        // Good encoders are remembered whatever else is wrong, or an arm that moves meanwhile would
        // stay locked out.
        self.last_good = sensed.encoder;
        self.without = T::zero();
        if !setpoint.is_sound() {
            return Err(Fault::Setpoint);
        }
        robot.beyond_limits(&sensed.encoder).map_or(Ok(()), |joint| Err(Fault::Limit(joint)))
    }
}

impl<T: Real> Stateful for RepeatCounter<T> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.scalar_option(&mut self.last)?;
        visitor.byte(&mut self.equal)
    }
}

impl<T: Real> Stateful for ForceSensorCheck<T> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        let RepeatCounter { last, equal } = &mut self.repeated;
        visitor.option(last, Wrench::zero(), |visitor, wrench| visitor.wrench(wrench))?;
        visitor.byte(equal)?;
        visitor.byte(&mut self.contradicted)
    }
}

impl<T: Real> Stateful for InputCheck<T> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.matrix(&mut self.last_good)?;
        visitor.scalar(&mut self.without)
    }
}
