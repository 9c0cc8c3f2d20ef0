//! Gains for a robot, what limits them, and the runs that confirm them.

use super::{PublishedResult, Report};
use crate::TuneReport;
use crate::document::{Block, Column, Document, Medium, Table, TableCell, number, words};
use crate::json::tune::TuneResult;
use crate::text::requirement::shown;
use crate::text::step::milliseconds;
use crate::text::tune::{confirmed, headline, limits, of_weld, setting};
use crate::text::{fixed, share};
use std::f64::consts::TAU;
use trueweld_evaluate::ArmAt;
use trueweld_evaluate::tune::{LoopCriterion, Rating};

impl Report for TuneReport<'_> {
    const SCHEMA: &'static str = "tune/1";

    fn json(&self) -> impl PublishedResult {
        TuneResult::of(self)
    }

    fn document(&self) -> Document {
        let good = self.is_confirmed();
        let verdict = if good { "CONFIRMED" } else { "NOT CONFIRMED" };
        let mut document =
            Document::new("Gains", headline(self), self.provenance).judged(verdict, good);
        document.push(Block::Note(setting(self)));
        document.push(Block::Table(self.controllers_table()));
        document.table("Laws, on top of the external controller", self.laws_table());
        document.list("What limits them", limits(self));
        document.section(Medium::Page, "The arm along the weld", Block::Table(self.arm_table()));
        document
    }
}

impl TuneReport<'_> {
    fn margin_heads(&self) -> impl Iterator<Item = TableCell> {
        self.tuning.asked.iter().map(|limit| number(limit.figure.label))
    }

    /// The margins in the order in which they are asked for.
    fn margin_cells(&self, margins: &[Rating]) -> Vec<TableCell> {
        let cell = |key: &str| {
            let of = |rating: &&Rating| matches!(rating.criterion, LoopCriterion::Margin { figure, .. } if figure.key == key);
            match margins.iter().find(of) {
                Some(rating) => number(shown(key, rating.value)).bad(!rating.is_met()),
                None => number("unstable").bad(true),
            }
        };
        self.tuning.asked.iter().map(|limit| cell(limit.figure.key)).collect()
    }

    fn controllers_table(&self) -> Table {
        let head = ["controller", "confirmed", "within 5 %", "overshoot"].map(words);
        let head = head
            .into_iter()
            .chain(self.margin_heads())
            .chain([number("weld: lateral, push error")]);
        let rows = self.tuning.controllers.iter().map(|tuned| {
            let met = |criterion: LoopCriterion| {
                tuned.response.iter().any(|r| r.criterion == criterion && r.is_met())
            };
            let settled = tuned.step.as_ref().and_then(|step| step.settle_5pct_s);
            let settled = settled.map_or("never".to_owned(), milliseconds);
            let overshoot =
                tuned.step.as_ref().map_or("–".to_owned(), |step| share(step.overshoot));
            let first = [
                words(tuned.controller.name()),
                words(confirmed(tuned.is_confirmed())).bad(!tuned.is_confirmed()),
                number(settled).bad(!met(LoopCriterion::Settling)),
                number(overshoot).bad(!met(LoopCriterion::Overshoot)),
            ];
            let weld = number(of_weld(&tuned.weld));
            first.into_iter().chain(self.margin_cells(&tuned.margins)).chain([weld]).collect()
        });
        Table { head: vec![head.collect()], rows: rows.collect() }
    }

    fn laws_table(&self) -> Table {
        let head = ["law", "confirmed"].map(words);
        let head = head
            .into_iter()
            .chain(self.margin_heads())
            .chain([number("weld: lateral, push error")]);
        let rows = self.tuning.laws.iter().map(|tuned| {
            let good = tuned.is_confirmed();
            let first = [words(tuned.law.name()), words(confirmed(good)).bad(!good)];
            let weld = number(of_weld(&tuned.weld));
            first.into_iter().chain(self.margin_cells(&tuned.margins)).chain([weld]).collect()
        });
        Table { head: vec![head.collect()], rows: rows.collect() }
    }

    fn arm_table(&self) -> Table {
        let percent = |all: &[f64]| {
            let each: Vec<String> = all.iter().map(|v| fixed(100.0 * v, 0)).collect();
            number(each.join(" / "))
        };
        let columns: [Column<'_, &ArmAt>; 7] = [
            (words("path"), &|at| words(format!("{:.2} m", at.path_m))),
            (words("first mode, Hz"), &|at| number(fixed(at.mode_rad_s / TAU, 1))),
            (words("along the tool, kN/mm"), &|at| number(fixed(1e-6 * at.stiffness_n_m, 2))),
            (words("torque A1…A6, %"), &|at| percent(&at.torque)),
            (words("speed A1…A6, %"), &|at| percent(&at.speed)),
            (words("correction asked for, mm"), &|at| number(fixed(1e3 * at.correction_m, 2))),
            (words("°"), &|at| number(fixed(at.correction_rad.to_degrees(), 3))),
        ];
        Table::of(&self.tuning.arm, &columns)
    }
}
