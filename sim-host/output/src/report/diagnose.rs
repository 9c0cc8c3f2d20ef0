//! Which physical effect is missing in a model.

use super::error_fall::ErrorFall;
use super::residuals::{BEFORE_AND_AFTER_COLUMNS, before_and_after, map};
use super::{PublishedResult, Report};
use crate::DiagnoseReport;
use crate::color;
use crate::document::{
    Bar, Block, Column, Document, Marked, Medium, Picture, Plot, PlotLine, Table, TableCell,
    number, words,
};
use crate::json::diagnose::DiagnoseResult;
use crate::samples::{self, BlockTable};
use crate::text::curve::{title, x_name, y_name};
use crate::text::diagnose::{
    Limits, confusable, in_a_line, incomplete, limits, none_of_these, ranked, remains, values,
};
use crate::text::finding::map_title;
use crate::text::{self, Scale, counted, probability, score, share};
use trueweld_diagnose::evidence::EffectCurve;
use trueweld_diagnose::{
    Confusable, DiagnosisVerdict, EffectLimit, ExplanationReason, FittedEffect,
};
use trueweld_estimate::residuals::localize::{ConditionBin, foremost};
use trueweld_plant::effects::CalibrationScope;
use trueweld_plant::input::RobotFile;

/// Longest name beside an axis.
const MOST_OF_AXIS: usize = 30;
/// Pairs of effects that are hard to tell apart, shown at most.
const CONFUSABLE_PAIRS_MAX: usize = 12;

impl Report for DiagnoseReport<'_> {
    const SCHEMA: &'static str = "diagnose/1";

    fn json(&self) -> impl PublishedResult {
        DiagnoseResult::of(self)
    }

    fn samples(&self) -> Option<BlockTable<'_>> {
        Some(samples::of_logs(vec![
            (["given", "fitted"], self.before),
            (["improved", "fitted"], self.after),
        ]))
    }

    fn document(&self) -> Document {
        let diagnosis = self.diagnosis;
        let missing = diagnosis.verdict != DiagnosisVerdict::Adequate;
        let mut document = Document::new("Diagnose", self.headline(), self.provenance);
        document.push(Block::Lead(self.explanation().unwrap_or_default()));
        document.push(Block::List(self.details()));
        document.push(Block::Note(self.setting()));
        let found = super::discover::curves(self.discovered, &self.model.robot);
        document.figures(text::discover::CURVE, found);
        let differences = super::discover::differences(self.discovered, &self.model.robot);
        document.figures(text::discover::NEAREST_EFFECT_HEADING, differences);
        let curves = self.reason().map_or(Vec::new(), |r| evidence(r, &self.model.robot));
        document.figures(text::diagnose::CURVES, curves);
        if let Some(plan) = &self.explanation.next_experiment {
            let lead = text::experiment::lead(plan);
            document.section(Medium::All, "What to record next", Block::Lead(lead));
            if text::experiment::is_worth_recording(plan) {
                document.push(Block::Steps(text::experiment::steps(plan)));
            }
        }
        let explained = diagnosis.chosen > 0 || !self.discovered.is_empty();
        let fall = self.fall(explained);
        document.section(
            Medium::All,
            "RMS errors where nothing was fitted",
            Block::Table(fall.table()),
        );
        document.section(
            Medium::Page,
            "How the error falls where nothing was fitted",
            Block::Figures(if missing { fall.pictures() } else { Vec::new() }),
        );
        // Where no effect is named they are what there is to say.
        if !explained {
            self.push_calibrations(&mut document);
        }
        if missing && explained {
            document.figures(
                "Measured and predicted, with the model as given and with the best explanation",
                before_and_after(self.before, self.after, BEFORE_AND_AFTER_COLUMNS),
            );
        }
        document.table(
            "Explanations that were fitted, every effect of the library at every place, most evidence first",
            self.ranking(),
        );
        if explained {
            self.push_calibrations(&mut document);
        }
        document.list(
            &format!(
                "What the residual follows that is left (score {})",
                score(self.diagnosis.score_after)
            ),
            remains(&diagnosis.unexplained),
        );
        let left = foremost(&diagnosis.unexplained, text::diagnose::REMAINS);
        for (finding, over_two) in left.iter().filter_map(|f| Some((f, f.map.as_ref()?))) {
            let table = Block::Table(map(over_two, finding));
            document.section(Medium::Page, &map_title(finding, over_two), table);
        }
        let left_out = incomplete(&diagnosis.incomplete, &self.model.robot);
        document.list(text::diagnose::INCOMPLETE_HEADING, left_out);
        let medium = if missing { Medium::Page } else { Medium::All };
        document.section(
            medium,
            "The smallest effects that these logs would have shown",
            Block::Table(limits_table(&diagnosis.limits, &self.model.robot)),
        );
        document.section(
            medium,
            "What these logs hardly tell apart, and from how many times the smallest size on",
            Block::Table(confusable_table(
                &diagnosis.confusable,
                &self.model.robot,
                CONFUSABLE_PAIRS_MAX,
            )),
        );
        document.push(Block::List(text::compare::notes(self.notices)));
        document
    }
}

impl DiagnoseReport<'_> {
    /// How the error falls, to the best explanation where one is `explained`.
    fn fall(&self, explained: bool) -> ErrorFall<'_> {
        let errors = &self.diagnosis.errors;
        let mut steps = vec![
            ("as given".to_owned(), errors.before.as_slice()),
            ("recalibrated".to_owned(), errors.calibrated.as_slice()),
        ];
        if explained {
            steps.push(("with it".to_owned(), errors.after.as_slice()));
        }
        ErrorFall { steps }
    }

    /// The calibrations that are off, and what the logs fix of mountings where one is of a link.
    fn push_calibrations(&self, document: &mut Document) {
        document
            .list("Calibrations that are off, which are no missing effect", self.calibrations());
        let mountings = self.diagnosis.mountings.as_ref().filter(|_| {
            let posture = |f: &FittedEffect| {
                f.effect.kind.calibration.is_some_and(|c| c.scope == CalibrationScope::Postures)
            };
            self.diagnosis.calibration.iter().any(posture)
        });
        if let Some(mountings) = mountings {
            document.push(Block::Note(text::diagnose::mountings(mountings, &self.model.robot)));
        }
    }

    /// The calibrations that are told from nothing, a line each, and how many others there are.
    fn calibrations(&self) -> Vec<String> {
        let line = |found: &FittedEffect| {
            let of = found.log.map_or(String::new(), |log| format!(" in {}", self.log(log)));
            format!("{}{of}", in_a_line(found, &self.model.robot))
        };
        let all = &self.diagnosis.calibration;
        let mut lines: Vec<String> =
            all.iter().filter(|f| f.is_told_from_nothing()).map(line).collect();
        let others = all.len() - lines.len();
        if !lines.is_empty() && others > 0 {
            let others = counted(others, "further calibration");
            lines.push(format!("{others}: none leaves zero"));
        }
        lines
    }

    fn ranking(&self) -> Table {
        let robot = &self.model.robot;
        let likely = |p: f64| {
            number(probability(p)).with_bar(Bar { share: p, mark: None, color: color::run(1) })
        };
        let lines = |lines: Vec<String>| TableCell { lines, ..words("") };
        let any_tied = ranked(self.diagnosis).iter().any(|c| !c.indistinguishable.is_empty());
        let mut rows: Vec<Vec<TableCell>> = ranked(self.diagnosis)
            .iter()
            .map(|candidate| {
                let told = candidate.effects.iter().flat_map(values);
                let tied = candidate.indistinguishable.iter();
                let tied = tied.filter_map(|k| self.diagnosis.candidates.get(*k));
                vec![
                    words(candidate.name(robot)),
                    lines(told.map(|(name, value)| format!("{name} {value}")).collect()),
                    number(score(candidate.held_out_after)),
                    number(share(candidate.left.clamp(0.0, 1.0))),
                    likely(candidate.probability),
                    lines(tied.map(|other| other.name(robot)).collect()),
                ]
            })
            .collect();
        if !rows.is_empty() {
            let none = likely(none_of_these(self.diagnosis));
            rows.push(vec![
                words("none of these"),
                words(""),
                number(score(self.diagnosis.held_out_without())),
                number(""),
                none,
                words(""),
            ]);
        }
        let mut head = vec![
            words(""),
            words("values, 95 %"),
            number("held-out score"),
            number("unexplained"),
            number("probability"),
            words("cannot be told from"),
        ];
        if !any_tied {
            head.pop();
            rows.iter_mut().for_each(|row| drop(row.pop()));
        }
        Table { head: vec![head], rows }
    }
}

/// The smallest effects that logs show, a row a kind.
pub(super) fn limits_table<'l>(
    all: impl IntoIterator<Item = &'l EffectLimit>,
    robot: &RobotFile,
) -> Table {
    let columns: [Column<'_, Limits>; 3] = [
        (words("effect"), &|line| words(line.kind.id)),
        (words("size"), &|line| words(line.size.clone())),
        (words("by place"), &|line| words(line.by_place())),
    ];
    Table::of(limits(all, robot), &columns)
}

/// Effects that logs hardly tell apart, a row a pair, at most so many.
pub(super) fn confusable_table(pairs: &[Confusable], robot: &RobotFile, most: usize) -> Table {
    let rows = pairs.iter().take(most).map(|pair| {
        let [first, second, apart] = confusable(pair, robot);
        vec![words(first), words(second), number(apart)]
    });
    let head = vec![words("one"), words("the other"), number("from × its limit")];
    Table { head: vec![head], rows: rows.collect() }
}

/// The curves that show an explanation's effects.
pub(super) fn evidence(reason: &ExplanationReason, robot: &RobotFile) -> Vec<Picture> {
    reason.evidence.iter().flatten().map(|c| curve(c, &robot.joint_names)).collect()
}

/// What the measurements show of an effect, and the effect as fitted.
fn curve(curve: &EffectCurve, joints: &[String]) -> Picture {
    // A twist is a thousandth of what a joint turns by.
    let x = match curve.points.iter().all(|p| p.x.abs() < 0.05) {
        true => Scale::small(curve.x.unit()),
        false => Scale::large(curve.x.unit()),
    };
    // A lag is read in the unit of the delay that it shows.
    let y = match curve.y_unit {
        "s" => Scale { factor: 1e3, unit: "ms" },
        unit => Scale::small(unit),
    };
    let shown = y_name(curve, joints);
    let marked = |p: &ConditionBin| Marked {
        x: p.x * x.factor,
        y: p.y * y.factor,
        error: p.error * y.factor,
    };
    let fitted: Vec<(f64, f64)> =
        curve.fitted.iter().map(|p| (p[0] * x.factor, p[1] * y.factor)).collect();
    // A loop comes in order of time, from posture to posture: a line through it would be a
    // scribble.
    let winding = !fitted.is_sorted_by(|a, b| a.0 <= b.0);
    let name = if winding { "ringed: the effect as fitted" } else { "the effect as fitted" };
    let points = if winding { Vec::new() } else { fitted.clone() };
    // A long name stands in the title.
    let y_label = match shown.chars().count() {
        0..=MOST_OF_AXIS => y.named(&shown),
        _ => y.unit.to_owned(),
    };
    let lines = vec![PlotLine::new(name, color::run(1), points)];
    let plot = Plot {
        rings: if winding { fitted } else { Vec::new() },
        marked: curve.points.iter().map(marked).collect(),
        wide: true,
        ..Plot::new(x.named(&x_name(curve, joints)), y_label, lines)
    };
    Picture::new(title(curve, joints), plot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::assert_self_contained;
    use crate::sample;

    #[test]
    fn the_page_says_the_verdict_and_draws_what_shows_it() {
        let page = sample::diagnosis(DiagnosisVerdict::EffectFound).diagnosed().page();
        assert_self_contained(&page);
        assert!(page.contains("What is missing: backlash at A5"));
        // The evidence, how the error falls, and the differences: of positions nothing else would be
        // seen.
        assert_eq!(page.matches("<svg").count(), 3);
        assert!(page.contains("What these logs hardly tell apart"));
        assert!(!page.contains("What to record next"));
    }

    #[test]
    fn calibrations_that_hold_zero_are_told_by_their_number() {
        let mut parts = sample::diagnosis(DiagnosisVerdict::Adequate);
        let off = parts.diagnosis.calibration[0].clone();
        let zero = FittedEffect { interval: vec![[-1e-6, 2.1e-5]], ..off };
        parts.diagnosis.calibration.splice(0..0, [zero.clone(), zero]);
        let (text, page) = (parts.diagnosed().text(), parts.diagnosed().page());
        assert!(
            text.starts_with("The calibration is off: encoder-offset at A5 in 1 log."),
            "{text}"
        );
        for shown in [&text, &page] {
            assert_eq!(shown.matches("encoder-offset at A5 (offset").count(), 1);
            assert!(shown.contains("2 further calibrations: none leaves zero"));
        }
    }

    #[test]
    fn what_may_not_be_named_is_not() {
        for verdict in [DiagnosisVerdict::UnknownEffect, DiagnosisVerdict::Adequate] {
            let mut parts = sample::diagnosis(verdict);
            parts.diagnosis.candidates[0].may_be_named = false;
            parts.diagnosis.calibration.clear();
            let headline = parts.diagnosed().headline();
            assert!(!headline.contains("backlash"), "{headline}");
        }
    }

    #[test]
    fn where_nothing_is_missing_nothing_is_drawn_as_found() {
        let mut parts = sample::diagnosis(DiagnosisVerdict::Adequate);
        parts.diagnosis.score_before = 1.02;
        parts.diagnosis.calibration.clear();
        parts.diagnosis.unexplained.clear();
        let (text, page) = (parts.diagnosed().text(), parts.diagnosed().page());
        for shown in [&text, &page] {
            assert!(shown.contains("Nothing is missing above the noise floor"));
            assert!(shown.contains("The smallest effects that these logs would have shown"));
        }
        assert_eq!(page.matches("<svg").count(), 0);
    }
}
