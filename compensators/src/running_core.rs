//! Robot model, controller and law as one thing that runs, built from a [`Configuration`].

use crate::configuration::{Configuration, ConfigurationError, Scheme};
use crate::law::Law;
use trueweld_core::compensation::{Compensated, Compensator, Observation};
use trueweld_core::control::{
    DriveCommand, External, HybridController, Parallel, SensorReadings, Setpoint, Superposed,
};
use trueweld_core::{JointVector, Real, Robot, Twist};

/// One of the three hybrid controllers.
#[derive(Debug, Clone, Copy)]
pub enum Hybrid<T: Real> {
    /// Scheme 1, (2.2).
    Parallel(Parallel<T>),
    /// Scheme 2, (2.3).
    Superposed(Superposed<T>),
    /// Scheme 3, (2.4)–(2.5).
    External(External<T>),
}

impl<T: Real> HybridController<T> for Hybrid<T> {
    fn start(&mut self, robot: &Robot<T>, encoder: &JointVector<T>, torque: &JointVector<T>) {
        match self {
            Self::Parallel(controller) => controller.start(robot, encoder, torque),
            Self::Superposed(controller) => controller.start(robot, encoder, torque),
            Self::External(controller) => controller.start(robot, encoder, torque),
        }
    }

    fn cycle(
        &mut self,
        robot: &Robot<T>,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
    ) -> DriveCommand<T> {
        match self {
            Self::Parallel(controller) => controller.cycle(robot, setpoint, sensed),
            Self::Superposed(controller) => controller.cycle(robot, setpoint, sensed),
            Self::External(controller) => controller.cycle(robot, setpoint, sensed),
        }
    }
}

/// What a controller runs every period: model, controller and law, and the digest of what they were
/// built from. `L`: the law as it runs, [`Law::Built`].
#[derive(Debug, Clone)]
pub struct RunningCore<T: Real, L> {
    robot: Robot<T>,
    controller: Compensated<T, Hybrid<T>, L>,
    digest: [u8; 32],
}

impl<T: Real, L: Compensator<T>> RunningCore<T, L> {
    /// Builds and checks everything; at rest once [started](Self::start). `K`: the law that the
    /// configuration names.
    ///
    /// # Errors
    /// The first thing of the configuration that is wrong.
    // In one function with what builds a law, or every step from there to where the core runs would
    // keep a copy of the law on the stack, of 25 kB where it is `learning`.
    #[inline(always)]
    pub fn new<K: Law<T, Built = L>>(
        configuration: &Configuration,
    ) -> Result<Self, ConfigurationError> {
        configuration.check()?;
        let (control, law) = (&configuration.control, &configuration.law);
        if law.name.as_str() != K::NAME {
            return Err(ConfigurationError::Law);
        }
        let robot =
            Robot::new(configuration.robot.parameters()?).map_err(ConfigurationError::Robot)?;
        let (joint, period) = (control.joint_gains(), control.period());
        let hybrid = match control.scheme::<T>()? {
            Scheme::Parallel => {
                Hybrid::Parallel(Parallel::new(joint, control.force_gains(), period))
            }
            Scheme::Superposed => {
                Hybrid::Superposed(Superposed::new(joint, control.force_gains(), period))
            }
            Scheme::External => {
                Hybrid::External(External::new(joint, control.external_gains(), period))
            }
        };
        let built =
            K::build(&law.gains()?, &law.setup(period)?).map_err(ConfigurationError::Gain)?;
        let [lateral, orientation] = [control.lateral.limits(), control.orientation.limits()];
        let digest = configuration.digest();
        Ok(Self {
            robot,
            controller: Compensated::new(hybrid, built, lateral, orientation, period)
                .with_force_sensor_limits(control.force_sensor_limits()),
            digest,
        })
    }

    /// Starts a weld from rest: the drives hold `torque`, N·m, at `encoder` angles, rad.
    pub fn start(&mut self, encoder: &JointVector<T>, torque: &JointVector<T>) {
        self.controller.start(&self.robot, encoder, torque);
    }

    /// One control period; see [`Compensated::cycle`].
    pub fn cycle(&mut self, observation: &Observation<'_, T>) -> DriveCommand<T> {
        self.controller.cycle(&self.robot, observation)
    }

    /// The correction of the set-point in force, axes of W: m and rad.
    pub fn correction(&self) -> Twist<T> {
        self.controller.correction()
    }

    /// The model.
    pub fn robot(&self) -> &Robot<T> {
        &self.robot
    }

    /// SHA-256 of the configuration that it was built from: what a certificate states.
    pub fn digest(&self) -> &[u8; 32] {
        &self.digest
    }
}
