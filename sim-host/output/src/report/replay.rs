//! A recorded run of a controller's core beside the same core on this machine.

use super::{PublishedResult, Report};
use crate::CoreReplayReport;
use crate::document::{Block, Document, Table, number, words};
use crate::text::fixed;
use crate::text::replay::{headline, load, rounding};
use trueweld_core::JOINTS;
use trueweld_evaluate::CoreReadings;

impl Report for CoreReplayReport<'_> {
    const SCHEMA: &'static str = "replay/1";

    fn json(&self) -> impl PublishedResult {
        self
    }

    fn document(&self) -> Document {
        let mut document = Document::new("Replay", headline(self.replay), self.provenance);
        document.push(Block::Lead(rounding(self.replay)));
        if let Some(first) = &self.replay.first {
            document.table("What the core was given in this period", readings(&first.readings));
            document.push(Block::Note(load(&first.readings)));
        }
        document.push(Block::Note(format!("Digest of the core: {}.", self.replay.digest)));
        document
    }
}

/// A column a joint.
fn readings(of: &CoreReadings) -> Table {
    let row = |name: &str, values: &[f64; JOINTS], decimals: usize| {
        let values = values.iter().map(|value| number(fixed(*value, decimals)));
        std::iter::once(words(name)).chain(values).collect()
    };
    let joints = (1..=JOINTS).map(|joint| number(format!("A{joint}")));
    Table {
        head: vec![std::iter::once(words("")).chain(joints).collect()],
        rows: vec![
            row("encoder, rad", &of.encoder_rad, 6),
            row("rate, rad/s", &of.encoder_rate_rad_s, 6),
            row("motor torque, N·m", &of.motor_torque_nm, 1),
        ],
    }
}
