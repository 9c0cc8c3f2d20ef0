//! The hybrid force/position controllers: one file each, and the table of them.
//!
//! A controller's file holds its name, what is said of it, the table of gains that it reads from a
//! control file, and how it is built; its equations are in `trueweld_core::control`, where they are
//! meant for the controller of a robot. To add one, write its file, and its line in the table below.

mod external;
mod gains;
mod model;
mod parallel;
mod superposed;

pub(crate) use gains::blank;
pub use gains::{DEPTH_KEYS, FORCE_KEYS, GainKey, JOINT_KEYS};
pub use model::{ControllerEntry, ControllerKind, CoreGains, PlantController};

use crate::input::{Control, nearest};
use trueweld_core::control::JointGains;

/// The controllers, in the order of the published study: one line each.
static CONTROLLERS: &[&ControllerEntry] =
    &[&parallel::PARALLEL_HYBRID, &superposed::SUPERPOSED_HYBRID, &external::EXTERNAL_HYBRID];

/// Every controller that there is.
pub fn controllers() -> &'static [&'static ControllerEntry] {
    CONTROLLERS
}

impl Default for ControllerKind {
    /// The one that commands use where none is asked for.
    fn default() -> Self {
        Self::EXTERNAL
    }
}

impl ControllerKind {
    /// The controllers that every control file has gains for.
    pub fn required() -> Vec<Self> {
        let required = CONTROLLERS.iter().filter(|controller| !controller.optional);
        required.map(|controller| Self(controller.name)).collect()
    }

    /// The controller of a name.
    ///
    /// # Errors
    /// The name of the table that it resembles, if any.
    pub fn find(name: &str) -> Result<Self, Option<&'static str>> {
        let mut names = CONTROLLERS.iter().map(|controller| controller.name);
        let known = names.clone();
        names.find(|known| *known == name).map(Self).ok_or_else(|| nearest(name, known))
    }

    /// Its line of the table.
    pub fn entry(self) -> &'static ControllerEntry {
        // A kind is made of the table's names alone.
        CONTROLLERS.iter().find(|of| of.name == self.0).unwrap_or(&CONTROLLERS[0])
    }

    /// Its name on the command line and in results.
    pub fn name(self) -> &'static str {
        self.0
    }

    /// Gains of its joint position loop; `None` where the control file leaves it out.
    pub fn joint_gains(self, control: &Control) -> Option<&JointGains<f64>> {
        (self.entry().joint)(control)
    }

    /// The controller with the gains of a cell, at rest; `None` where the control file leaves it out.
    pub fn build(self, control: &Control) -> Option<Box<dyn PlantController>> {
        (self.entry().build)(control)
    }
}
