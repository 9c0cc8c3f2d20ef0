//! Everything that one run is made of: cell, weld, program, controller, law, instruments.

use super::{RunError, WeldProgram};
use crate::cell::Cell;
use crate::input::{Control, Process, Sensors, Weld};
use crate::integrate::Integrator;
use crate::seam::Seam;
use crate::sensors::InstrumentFault;
use trueweld_compensators::Entry;
use trueweld_core::Robot;
use trueweld_core::compensation::Compensator;
use trueweld_core::control::{External, HybridController, JointGains, Parallel, Superposed};

/// Which hybrid controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ControllerKind {
    /// Scheme 1, (2.2).
    Parallel,
    /// Scheme 2, (2.3).
    Superposed,
    /// Scheme 3, (2.4)–(2.5).
    External,
}

impl ControllerKind {
    /// All of them, in the order of the published study.
    pub const ALL: [Self; 3] = [Self::Parallel, Self::Superposed, Self::External];

    /// Its name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Parallel => "parallel",
            Self::Superposed => "superposed",
            Self::External => "external",
        }
    }

    /// Gains of its joint position loop.
    pub fn joint_gains(self, control: &Control) -> &JointGains<f64> {
        match self {
            Self::Parallel => &control.parallel.joint,
            Self::Superposed => &control.superposed.joint,
            Self::External => &control.external.joint,
        }
    }

    /// The controller with the gains of a cell, at rest.
    pub fn build(self, control: &Control) -> Box<dyn HybridController<f64>> {
        let (joint, period) = (*self.joint_gains(control), control.period);
        match self {
            Self::Parallel => Box::new(Parallel::new(joint, control.parallel.force, period)),
            Self::Superposed => Box::new(Superposed::new(joint, control.superposed.force, period)),
            Self::External => Box::new(External::new(joint, control.external.force, period)),
        }
    }
}

/// Everything one run is made of.
#[derive(Debug, Clone, Copy)]
pub struct Scenario<'a> {
    /// Name of the weld, for the record.
    pub name: &'a str,
    /// Robot and process.
    pub cell: &'a Cell,
    /// The robot as the controller believes it is.
    pub controller_model: &'a Robot<f64>,
    /// The process as the weld was planned with it.
    pub planned: &'a Process,
    /// The weld.
    pub weld: &'a Weld,
    /// What is done.
    pub program: WeldProgram,
    /// Gains and limits.
    pub control: &'a Control,
    /// Instruments.
    pub sensors: &'a Sensors,
    /// Which controller.
    pub controller: ControllerKind,
    /// Which law.
    pub law: &'a Entry,
    /// How the plant is integrated.
    pub integrator: Integrator,
    /// Longest plant step, s; the control period is divided evenly.
    pub plant_step: f64,
    /// Seed of the instruments' noise.
    pub seed: u64,
    /// An instrument that fails, in the last run where there are several.
    pub fault: Option<InstrumentFault>,
}

impl Scenario<'_> {
    /// Plant steps in a control period, and the length of each, s.
    pub fn plant_steps(&self) -> (usize, f64) {
        let period = self.control.period;
        let steps = (period / self.plant_step - 1e-9).ceil().max(1.0);
        (steps as usize, period / steps)
    }

    /// The law as it is before its first weld.
    ///
    /// # Errors
    /// [`RunError::NoSeamSensor`], and [`RunError::Law`] where a gain does not suit the control
    /// period.
    pub fn build_law(&self) -> Result<Box<dyn Compensator<f64>>, RunError> {
        if self.law.needs().seam_sensor && self.sensors.seam.is_none() {
            return Err(RunError::NoSeamSensor { law: self.law.name().to_owned() });
        }
        let setup = self.control.setup(Seam::of(self.weld).length);
        self.law
            .build(&self.control.laws, &setup)
            .map_err(|source| RunError::Law { source, period: setup.period })
    }
}
