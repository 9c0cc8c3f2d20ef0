//! Parallel hybrid control (2.2): position in the selected directions, force along the tool.

use super::gains::{depth_gains, parallel};
use super::model::{ControllerEntry, ControllerKind};
use trueweld_compensators::Scheme;
use trueweld_core::control::Parallel;

impl ControllerKind {
    /// Scheme 1, (2.2).
    pub const PARALLEL: Self = Self(PARALLEL_HYBRID.name);
}

pub(super) static PARALLEL_HYBRID: ControllerEntry = ControllerEntry {
    name: "parallel",
    about: "Parallel hybrid control with selection matrix (2.2)",
    optional: false,
    read: |table, control| {
        control.parallel = parallel(table)?;
        Ok(())
    },
    joint: |control| Some(&control.parallel.joint),
    build: |control| {
        let gains = &control.parallel;
        Some(Box::new(Parallel::new(gains.joint, gains.force, control.period)))
    },
    core: Some(|control| (Scheme::Parallel, depth_gains(&control.parallel.force))),
};
