//! Everything that one run is made of: cell, weld, program, controller, law, instruments.

use super::{RunError, WeldProgram};
use crate::cell::Cell;
use crate::controllers::{ControllerKind, PlantController};
use crate::input::{Control, Process, Sensors, Weld};
use crate::integrate::Integrator;
use crate::process::ProcessMisfit;
use crate::seam::Seam;
use crate::sensors::{InstrumentFault, sees_deviation};
use trueweld_compensators::Entry;
use trueweld_core::Robot;
use trueweld_core::compensation::Compensator;

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

/// Plant steps in a cycle of a force that the process repeats by itself.
const LEAST_STEPS_A_CYCLE: f64 = 8.0;

impl Scenario<'_> {
    /// That the weld is one of the process.
    ///
    /// # Errors
    /// [`ProcessMisfit`].
    pub fn check_process(&self) -> Result<(), ProcessMisfit> {
        if let WeldProgram::ForceStep { .. } = self.program
            && !self.cell.process.bears_push()
        {
            return Err(ProcessMisfit::NoStep { process: self.cell.process.kind().name });
        }
        self.planned.fits(self.weld)
    }

    /// Plant steps in a control period, and the length of each, s.
    pub fn plant_steps(&self) -> (usize, f64) {
        let period = self.control.period;
        // Of what repeats by itself within a turn, the first order in so many steps at least.
        let turns = self.cell.process.spindle.abs() / std::f64::consts::TAU;
        let own = self.cell.process.model.own_orders().first().map_or(0.0, |order| order * turns);
        let longest = self.plant_step.min((LEAST_STEPS_A_CYCLE * own).recip());
        let steps = (period / longest - 1e-9).ceil().max(1.0);
        (steps as usize, period / steps)
    }

    /// The controller with the gains of the control file, at rest.
    ///
    /// # Errors
    /// [`RunError::NoGains`].
    pub fn build_controller(&self) -> Result<Box<dyn PlantController>, RunError> {
        let controller = self.controller.name();
        self.controller.build(self.control).ok_or(RunError::NoGains { controller })
    }

    /// The law as it is before its first weld.
    ///
    /// # Errors
    /// [`RunError::NoSeamSensor`], and [`RunError::Law`] where a gain does not suit the control
    /// period.
    pub fn build_law(&self) -> Result<Box<dyn Compensator<f64> + Send>, RunError> {
        if self.law.needs().seam_sensor && !sees_deviation(self.sensors) {
            return Err(RunError::NoSeamSensor { law: self.law.name().to_owned() });
        }
        let setup = self.control.setup(Seam::of(self.weld).length);
        self.law
            .build(&self.control.laws, &setup)
            .map_err(|source| RunError::Law { source, period: setup.period })
    }
}
