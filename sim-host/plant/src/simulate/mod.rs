//! The multi-rate loop: plant at 1 ms or less, control held over its period.

mod program;
mod record;
mod run;

pub use program::{Program, Seam, Target};
pub use record::{Phase, Recording, Row};
pub use run::{Controller, Law, RunError, Scenario, run, start_angles};
