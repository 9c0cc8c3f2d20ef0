//! Gross mistakes in the files: what every command about measurements says in place of physics.

use super::Report;
use crate::MistakesReport;
use crate::document::{Block, Document};
use crate::json::MistakesResult;
use crate::words::mistakes::{headline, mistake};

impl Report for MistakesReport<'_> {
    type Json = MistakesResult;

    fn json(&self) -> MistakesResult {
        MistakesResult::of(self)
    }

    fn document(&self) -> Document {
        let joints = &self.model.robot.joint_names;
        let mut document = Document::new("Mistakes", headline(self.found, joints), self.provenance);
        document.push(Block::Note(
            "Nothing else was looked for: on top of such a mistake every effect would be wrong."
                .to_owned(),
        ));
        let lines = self.found.mistakes.iter().flat_map(|found| mistake(found, joints));
        document.push(Block::List(lines.collect()));
        document
    }
}
