//! Gross mistakes in the files: what every command about measurements says in place of physics.

use super::{PublishedResult, Report};
use crate::document::{Block, Document};
use crate::json;
use crate::json::log_faults::MistakesResult;
use crate::text::log_faults::{headline, mistake};
use crate::{DiagnoseReport, ImproveReport, MistakesReport};

impl Report for MistakesReport<'_> {
    const SCHEMA: &'static str = "compare/1";

    fn json(&self) -> impl PublishedResult {
        MistakesResult::of(self)
    }

    fn json_text(&self) -> String {
        let schema = match self.provenance.command.as_str() {
            "diagnose" => DiagnoseReport::SCHEMA,
            "improve" => ImproveReport::SCHEMA,
            _ => Self::SCHEMA,
        };
        json::text(schema, &self.json())
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
