//! What experiments would show, before they are made.

use super::diagnose::{confusable_table, limits_table};
use super::{PublishedResult, Report};
use crate::document::{Block, Column, Document, Medium, Table, number, words};
use crate::json::plan::PlanResult;
use crate::text::diagnose::{Limits, limits};
use crate::text::{counted, fixed, listed};
use crate::{PlanReport, RecordedLog};
use trueweld_diagnose::ShownEffect;
use trueweld_plant::effects::EffectPlace;

/// Pairs of effects that are hard to tell apart, shown at most.
const HARDLY_APART_MAX: usize = 20;

impl Report for PlanReport<'_> {
    const SCHEMA: &'static str = "plan/1";

    fn json(&self) -> impl PublishedResult {
        PlanResult::of(self)
    }

    fn document(&self) -> Document {
        let mut document = Document::new("Plan", self.headline(), self.provenance);
        document.push(Block::Lead(self.useless()));
        let robot = &self.model.robot;
        let shown = self.detectability.shown.iter().map(|ShownEffect { limit, .. }| limit);
        document.section(
            Medium::All,
            "What each experiment shows best",
            Block::Table(self.experiments()),
        );
        document.section(
            Medium::All,
            "The smallest effects that they would show together, all calibrations free",
            Block::Table(limits_table(shown, robot)),
        );
        document.section(
            Medium::All,
            "What they would not show at any plausible size",
            Block::List(self.not_shown()),
        );
        document.section(
            Medium::All,
            "What they would hardly tell apart, and from how many times the smallest size on",
            Block::Table(confusable_table(&self.detectability.confusable, robot, HARDLY_APART_MAX)),
        );
        document
    }
}

impl PlanReport<'_> {
    fn headline(&self) -> String {
        let shown = self.detectability.shown.len();
        format!(
            "{} would show {shown} of {} effects, counted at each place.",
            counted(self.logs.len(), "experiment"),
            shown + self.detectability.not_shown.len()
        )
    }

    /// The experiments that show no effect better than the others do; empty where there are none.
    fn useless(&self) -> String {
        let any = |log: &usize| self.detectability.shown.iter().any(|s| s.best_log == Some(*log));
        let idle = (0..self.logs.len()).filter(|log| !any(log));
        let names: Vec<&str> = idle.map(|log| self.logs[log].name.as_str()).collect();
        match names.as_slice() {
            [] => String::new(),
            names => format!("No effect is shown best by {}.", listed(names, "or")),
        }
    }

    fn experiments(&self) -> Table {
        let robot = &self.model.robot;
        let rows = self.logs.iter().enumerate();
        let columns: [Column<'_, (usize, &RecordedLog)>; 4] = [
            (words("experiment"), &|(_, log)| words(log.name.clone())),
            (words("kind"), &|(_, log)| words(log.kind)),
            (number("takes, s"), &|(_, log)| number(fixed(log.time_s[1] - log.time_s[0], 1))),
            (words("shows best"), &|(log, _)| {
                let own = self.detectability.shown.iter().filter(|s| s.best_log == Some(*log));
                let all = limits(own.map(|s| &s.limit), robot);
                let of = |line: &Limits| {
                    let places: Vec<&str> = line.places.iter().map(|(at, _)| at.as_str()).collect();
                    format!("{} {}", line.kind.id, places.join(" ")).trim().to_owned()
                };
                words(all.iter().map(of).collect::<Vec<_>>().join("; "))
            }),
        ];
        Table::of(rows, &columns)
    }

    /// A line a kind.
    fn not_shown(&self) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        let mut last = "";
        for EffectPlace { kind, at } in &self.detectability.not_shown {
            let place = at.name(&self.model.robot);
            match lines.last_mut().filter(|_| last == kind.id) {
                Some(line) => *line += &format!(", {place}"),
                None => lines.push(format!("{} {place}", kind.id).trim().to_owned()),
            }
            last = kind.id;
        }
        lines
    }
}
