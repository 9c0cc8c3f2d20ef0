//! What a controller is to the rest of the plant: a line of the table, and the name that stands for it.

use crate::input::{Control, InputError, TomlTable};
use trueweld_compensators::Scheme;
use trueweld_core::control::{
    DriveCommand, ExternalGains, HybridController, JointGains, SensorReadings, Setpoint,
};
use trueweld_core::state::{StateResult, StateVisitor};
use trueweld_core::{JointVector, Robot};

/// Which hybrid controller: its name on the command line and in results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ControllerKind(pub(super) &'static str);

/// One hybrid controller of the table.
#[derive(Debug)]
pub struct ControllerEntry {
    /// Its name on the command line and in results, and of its table in a control file.
    pub name: &'static str,
    /// What it is, for the command line.
    pub about: &'static str,
    /// True for one that a control file may leave out; commands that compare all controllers leave it
    /// out too.
    pub optional: bool,
    /// Reads its table of a control file.
    pub read: fn(table: &TomlTable<'_>, control: &mut Control) -> Result<(), InputError>,
    /// Gains of its joint position loop; `None` where the control file leaves it out.
    pub joint: fn(control: &Control) -> Option<&JointGains<f64>>,
    /// The controller with the gains of a cell, at rest; `None` where the control file leaves it out.
    pub build: fn(control: &Control) -> Option<Box<dyn PlantController>>,
    /// What a controller's core is built from; `None` for one that no core has.
    pub core: Option<CoreGains>,
}

/// A controller as runs have it: one that is copied with a run in progress.
pub trait PlantController: HybridController<f64> + Send + Sync {
    /// The same controller in the same state.
    fn copied(&self) -> Box<dyn PlantController>;
}

impl<H: HybridController<f64> + Clone + Send + Sync + 'static> PlantController for H {
    fn copied(&self) -> Box<dyn PlantController> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn PlantController> {
    fn clone(&self) -> Self {
        (**self).copied()
    }
}

impl HybridController<f64> for Box<dyn PlantController> {
    fn start(&mut self, robot: &Robot<f64>, encoder: &JointVector<f64>, torque: &JointVector<f64>) {
        (**self).start(robot, encoder, torque);
    }

    fn cycle(
        &mut self,
        robot: &Robot<f64>,
        setpoint: &Setpoint<f64>,
        sensed: &SensorReadings<f64>,
    ) -> DriveCommand<f64> {
        (**self).cycle(robot, setpoint, sensed)
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        (**self).visit_state(visitor)
    }
}

/// The scheme and the gains of a controller that a core has.
pub type CoreGains = fn(control: &Control) -> (Scheme, ExternalGains<f64>);
