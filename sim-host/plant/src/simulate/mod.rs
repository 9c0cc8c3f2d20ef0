//! The multi-rate loop: plant at 1 ms or less, control held over its period.

mod record;

pub use record::{Phase, Recording, Row};
