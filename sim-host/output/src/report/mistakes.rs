//! Gross mistakes in the files: what every command about measurements says in place of physics.

use super::Report;
use crate::document::{Block, Document};
use crate::json::MistakesResult;
use crate::words::mistakes::{change, headline, sentence, target};
use trueweld_measure::mistakes::Found;
use trueweld_plant::input::ModelFile;
use trueweld_plant::provenance::Provenance;

/// Mistakes that were found.
#[derive(Debug, Clone, Copy)]
pub struct MistakesReport<'a> {
    /// The model that the logs were to be compared with.
    pub model: &'a ModelFile,
    /// What was found.
    pub found: &'a Found,
    /// What the result is of; its command says in which form programs get it.
    pub provenance: &'a Provenance,
}

impl Report for MistakesReport<'_> {
    type Json = MistakesResult;

    fn provenance(&self) -> &Provenance {
        self.provenance
    }

    fn json(&self) -> MistakesResult {
        MistakesResult::of(self)
    }

    fn document(&self) -> Document {
        let joints = &self.model.robot.joint_names;
        let mut document = Document::new("Mistakes", headline(self.found, joints));
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

impl super::Recorded for MistakesReport<'_> {
    #[cfg(feature = "rerun")]
    fn record(&self, path: &std::path::Path) -> Result<(), crate::OutputError> {
        let reason = "of mistakes in the files there is nothing to be seen".to_owned();
        Err(crate::OutputError::Record { path: path.to_owned(), reason })
    }
}
