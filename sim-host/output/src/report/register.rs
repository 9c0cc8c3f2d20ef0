//! Where a tracker stands, and what it sees of the tool.

use super::{PublishedResult, Report};
use crate::RegisterReport;
use crate::document::{Block, Document, Table, number, words};
use crate::json::register::RegisterResult;
use crate::words::register::{half, headline, table};
use crate::words::{Scale, fixed};
use trueweld_core::Pose;
use trueweld_core::spatial::rotation_vector;

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
            let pose = |name: &str, pose: &Pose<f64>, interval: &[f64; 6]| {
                let turn = rotation_vector(&pose.rotation);
                [
                    (format!("{name}, m"), pose.position, &interval[..3], "m", 6),
                    (format!("{name}, rad"), turn, &interval[3..], "rad", 6),
                ]
                .map(|(label, vector, interval, unit, digits)| {
                    let widest = interval.iter().copied().fold(0.0, f64::max);
                    let value = |v: &f64| number(fixed(*v, digits));
                    let mut row = vec![words(label)];
                    row.extend(vector.iter().map(value));
                    row.push(number(half(&Scale::small(unit), widest)));
                    row
                })
            };
            let rows = [
                pose("base, seen by the tracker", &found.mounting.frame, &found.frame_interval),
                pose(
                    "tracked point, in the tool frame",
                    &found.mounting.tool,
                    &found.tool_interval,
                ),
            ];
            document.push(Block::Table(Table {
                head: vec![head],
                rows: rows.into_iter().flatten().collect(),
            }));
            document.push(Block::Note(table(&found.mounting)));
        }
        document
    }
}
