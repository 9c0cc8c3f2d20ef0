//! The motor encoders: angles on a grid, and their rates by difference over a control period.

use super::model::{SensorEntry, stepped};
use trueweld_core::JointVector;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};

pub(super) static ENCODERS: SensorEntry = SensorEntry {
    name: "encoder",
    about: "Motor angles, seen from the joint, with the step of their grid.",
    optional: false,
    read: |table, sensors| {
        table.only(&["resolution_rad"])?;
        sensors.encoder_resolution = table.quantities("resolution_rad")?;
        Ok(())
    },
    numbers: &[("encoder.resolution_rad", |s| s.encoder_resolution.iter_mut().collect())],
    outside: None,
};

/// The encoders of one run.
#[derive(Debug, Clone)]
pub(super) struct Encoders {
    resolution: [f64; 6],
    period: f64,
    before: Option<JointVector<f64>>,
}

impl Encoders {
    /// Read every `period` s.
    pub(super) fn new(resolution: [f64; 6], period: f64) -> Self {
        Self { resolution, period, before: None }
    }

    /// Angles and rates, rad and rad/s.
    pub(super) fn read(&mut self, truth: &[f64; 6]) -> [JointVector<f64>; 2] {
        let encoder = JointVector::from_fn(|i, _| stepped(truth[i], self.resolution[i]));
        let rate =
            self.before.map_or(JointVector::zeros(), |before| (encoder - before) / self.period);
        self.before = Some(encoder);
        [encoder, rate]
    }
}

impl Stateful for Encoders {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.option(&mut self.before, JointVector::zeros(), |visitor, before| {
            visitor.matrix(before)
        })
    }
}
