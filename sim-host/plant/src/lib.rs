//! The simulated welding cell: input files, effects, elastic robot, process, sensors, integrators
//! and the multi-rate loop that joins them.
//!
//! Layers, bottom up: [`input`] reads and checks files; [`effects`] are terms at named ports;
//! [`robot`] is the elastic robot (2.1) with its ports, [`process`] the force of the material;
//! [`path`] and [`seam`] are where it welds; [`cell`] joins them to one system of differential equations; [`integrate`] solves it in time or
//! at rest; [`sensors`] read it; [`controllers`] drive it;
//! [`simulate`] runs it under a controller and a law.
//!
//! ```
//! use trueweld_plant::cell::Cell;
//! use trueweld_plant::effects::Effect;
//! use trueweld_plant::input::{Control, InputFile, Process, RobotFile, Sensors, Weld};
//! use trueweld_plant::integrate::Integrator;
//! use trueweld_plant::simulate::{ControllerKind, Scenario, Seam, WeldProgram, run};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let fixture = |name| format!("{}/../../fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
//! let robot = RobotFile::read(fixture("robots/kr500-mt.toml"))?;
//! let process = Process::read(fixture("processes/lap-weld-2024-t3.toml"))?;
//! let weld = Weld::read(fixture("welds/vertical.toml"))?;
//! let control = Control::read(fixture("control/kr500-mt.toml"))?;
//! let sensors = Sensors::read(fixture("sensors/kr500-mt.toml"))?;
//! let backlash = Effect::parse("backlash:A5:half_gap_rad=2e-4", &robot)?;
//! let cell = Cell::new(&robot.robot, &[backlash], &process, Seam::real(&weld))?;
//! let scenario = Scenario {
//!     name: "vertical",
//!     cell: &cell,
//!     // The controller does not know of the backlash.
//!     controller_model: &robot.robot,
//!     planned: &process,
//!     weld: &weld,
//!     program: WeldProgram::ForceStep { height: 11e3, hold: 0.5, length: 0.5 },
//!     control: &control,
//!     sensors: &sensors,
//!     controller: ControllerKind::EXTERNAL,
//!     law: &trueweld_compensators::find("none").expect("a law of the table"),
//!     integrator: Integrator::LinearlyImplicit,
//!     plant_step: 1e-3,
//!     seed: 1,
//!     fault: None,
//! };
//! let recording = run(&scenario, |_| {})?;
//! assert!(recording.rows.iter().all(|row| row.deviation_w.linear.norm() < 0.01));
//! # Ok(())
//! # }
//! ```

pub mod cell;
pub mod controllers;
pub mod effects;
pub mod input;
pub mod integrate;
pub mod path;
pub mod process;
pub mod provenance;
pub mod random;
pub mod robot;
pub mod seam;
pub mod sensors;
mod serialize;
pub mod simulate;
