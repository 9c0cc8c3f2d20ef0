//! Superposed hybrid control (2.3): the position loop acts in all directions, force along the tool too.

use super::gains::{depth_gains, parallel};
use super::model::{ControllerEntry, ControllerKind};
use trueweld_compensators::Scheme;
use trueweld_core::control::Superposed;

impl ControllerKind {
    /// Scheme 2, (2.3).
    pub const SUPERPOSED: Self = Self(SUPERPOSED_HYBRID.name);
}

pub(super) static SUPERPOSED_HYBRID: ControllerEntry = ControllerEntry {
    name: "superposed",
    about: "Superposed hybrid control (2.3)",
    optional: false,
    read: |table, control| {
        control.superposed = parallel(table)?;
        Ok(())
    },
    joint: |control| Some(&control.superposed.joint),
    build: |control| {
        let gains = &control.superposed;
        Some(Box::new(Superposed::new(gains.joint, gains.force, control.period)))
    },
    core: Some(|control| (Scheme::Superposed, depth_gains(&control.superposed.force))),
};
