//! What instruments would record of a cell: measurement campaigns with a chosen truth.
//!
//! A [`Laboratory`] is a cell as its input files describe it. A [`Recipe`] states the truth of one
//! campaign: the effects that the cell has and its model lacks, what the laboratory gets wrong
//! besides (stiffnesses, encoder zeros, tracker registration), the noise, and the [`Protocol`]: which
//! logs are recorded. [`Laboratory::write`] simulates the logs and writes a campaign folder as
//! `trueweld diagnose` reads it, with the truth in `truth.toml`. [`Laboratory::corpus`] draws
//! recipes at random. A [`ProtocolFile`] states instead, row by row, what a user wants recorded.
//!
//! Layers, bottom up: `motion` and `protocol` hold what is done; `static_arm` and `moving_arm` solve
//! the plant's equations for it by methods that no comparison uses, and a weld runs in the plant's
//! own simulation; `track` and `samples` turn the truth into delayed, noisy columns; `logs` and
//! `campaign` write the files. Nothing here predicts or fits. Left out: a spindle whose speed
//! varies, instruments with a filter.
//!
//! ```
//! use trueweld_laboratory::{Laboratory, Protocol, Recipe};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let fixture = |name| format!("{}/../../fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
//! let laboratory = Laboratory::read(
//!     fixture("robots/kr500-mt.toml"),
//!     fixture("processes/lap-weld-2024-t3.toml"),
//!     fixture("control/kr500-mt.toml"),
//!     fixture("sensors/kr500-mt.toml"),
//! )?;
//! let protocol = Protocol { rings: 0, welds: 0, free: 0.0, ..Protocol::short() };
//! let effect = laboratory.draw("backlash", 1.0, &protocol, 7).ok_or("no such effect")?;
//! let recipe = Recipe { protocol, ..Recipe::plain(7) }.with_effect(effect);
//! # let folder = std::env::temp_dir().join(format!("trueweld-laboratory-{}", std::process::id()));
//! laboratory.write(&recipe, &folder)?;
//! assert!(folder.join("static/samples.csv").exists());
//! # std::fs::remove_dir_all(folder)?;
//! # Ok(())
//! # }
//! ```

mod campaign;
mod corpus;
mod draw;
mod error;
mod instruments;
mod laboratory;
mod logs;
mod motion;
mod moving_arm;
mod out_of_library;
mod protocol;
mod protocol_file;
mod random;
mod recipe;
mod samples;
mod static_arm;
mod track;
mod truth;
mod weld_file;
mod weld_log;

pub use corpus::{CorpusCase, Hidden};
pub use draw::effect;
pub use error::CampaignError;
pub use instruments::InstrumentNoise;
pub use laboratory::Laboratory;
pub use motion::Waypoint;
pub use out_of_library::{OutOfLibrary, OutOfLibraryKind};
pub use protocol::Protocol;
pub use protocol_file::{LoadRow, LogPlan, PlannedLog, ProtocolFile};
pub use recipe::Recipe;
pub use static_arm::Unsettled;
pub use weld_file::weld_file;
pub use weld_log::{ReadRow, WeldLog};
