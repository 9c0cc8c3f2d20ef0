//! External hybrid control (2.4), (2.5): a force loop moves the set-point of a position loop.

use super::gains::cascade;
use super::model::{ControllerEntry, ControllerKind};
use trueweld_compensators::Scheme;
use trueweld_core::control::External;

impl ControllerKind {
    /// Scheme 3, (2.4)–(2.5).
    pub const EXTERNAL: Self = Self(EXTERNAL_HYBRID.name);
}

pub(super) static EXTERNAL_HYBRID: ControllerEntry = ControllerEntry {
    name: "external",
    about: "External hybrid control: force loop around a position loop (2.4), (2.5)",
    optional: false,
    read: |table, control| {
        control.external = cascade(table)?;
        Ok(())
    },
    joint: |control| Some(&control.external.joint),
    build: |control| {
        let gains = &control.external;
        Some(Box::new(External::new(gains.joint, gains.force, control.period)))
    },
    core: Some(|control| (Scheme::External, control.external.force)),
};
