//! Gross mistakes in the files: what every command about measurements says in place of physics.

use super::Report;
use crate::MistakesReport;
use crate::document::{Block, Document};
use crate::json::MistakesResult;
use crate::words::mistakes::{change, headline, sentence, target};

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
        let mut lines = Vec::new();
        for mistake in &self.found.mistakes {
            lines.push(sentence(mistake, joints));
            lines.push(format!("In {}: {}", target(mistake), change(mistake)));
        }
        document.push(Block::List(lines));
        document
    }
}
