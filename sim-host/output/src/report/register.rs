//! Where a tracker stands, and what it sees of the tool.

use super::{PublishedResult, Report};
use crate::RegisterReport;
use crate::document::{Block, Document, Table, TableCell, number, words};
use crate::json::register::RegisterResult;
use crate::text::register::{half, headline, table};
use crate::text::{Scale, fixed};
use trueweld_core::Pose;
use trueweld_core::spatial::rotation_vector;
use trueweld_logs::register::Mounting;

impl Report for RegisterReport<'_> {
    const SCHEMA: &'static str = "register/1";

    fn json(&self) -> impl PublishedResult {
        RegisterResult::of(self)
    }

    fn document(&self) -> Document {
        let mut document = Document::new("Register", headline(self.registered), self.provenance);
        for registered in self.registered {
            let found = &registered.registration;
            document.push(Block::Heading(registered.logs.join(", ")));
            let head = ["", "x", "y", "z", "95 %"].map(number).to_vec();
            let Mounting { frame, tool } = &found.mounting;
            let rows = [
                pose_rows("base, seen by the tracker", frame, &found.frame_interval),
                pose_rows("tracked point, in the tool frame", tool, &found.tool_interval),
            ];
            document.push(Block::Table(Table { head: vec![head], rows: rows.concat() }));
            document.push(Block::Note(table(&found.mounting)));
        }
        document
    }
}

/// Position and rotation of a pose with the half-width of their widest 95 % interval, a row each.
fn pose_rows(name: &str, pose: &Pose<f64>, interval: &[f64; 6]) -> [Vec<TableCell>; 2] {
    let turn = rotation_vector(&pose.rotation);
    [("m", pose.position, &interval[..3]), ("rad", turn, &interval[3..])].map(
        |(unit, vector, interval)| {
            let widest = interval.iter().copied().fold(0.0, f64::max);
            let mut row = vec![words(format!("{name}, {unit}"))];
            row.extend(vector.iter().map(|v| number(fixed(*v, 6))));
            row.push(number(half(&Scale::small(unit), widest)));
            row
        },
    )
}
