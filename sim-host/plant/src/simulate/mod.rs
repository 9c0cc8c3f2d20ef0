//! The multi-rate loop: plant at 1 ms or less, control held over its period.

mod program;
mod record;
mod run;

pub use program::{Program, Seam, Target};
pub use record::{Phase, RecordRow, Recording};
pub use run::{Controller, RunError, Scenario, run, run_after, run_passes, start_angles};
