//! Simulated runs: the plant at 1 ms or less, the control held over its period.

mod configuration;
mod cycle;
mod error;
mod health;
mod limits;
mod program;
mod record;
mod run;
mod scenario;
mod simulation;
mod start;

pub use crate::controllers::ControllerKind;
pub use crate::seam::Seam;
pub use configuration::{ConfigurationRefused, ControllerConstants};
pub use cycle::{ControlSide, Controlled, InstrumentReadings, Plant, PlantSide, Reference};
pub use error::RunError;
pub use health::{HealthWarning, HealthWarningKind, health_warnings};
pub use limits::{LimitKind, LimitSpan, limit_spans};
pub use program::{ProgramTarget, WeldProgram};
pub use record::{Phase, RecordRow, Recording};
pub use run::{run, run_after, run_passes, run_with};
pub use scenario::Scenario;
pub use simulation::{
    CellMotion, CellView, OpenCell, SimulatedCell, Simulation, restore_state, state_of,
};
pub use start::{
    Taught, TaughtOffset, check_reach, encoder_offset, postures_at, real_inverse_near, start_angles,
};
