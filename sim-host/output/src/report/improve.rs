//! How a model was improved: how the error fell step by step, and every value with where it comes
//! from.

use super::diagnose::evidence;
use super::error_fall::{ErrorFall, level};
use super::residuals::{BEFORE_AND_AFTER_COLUMNS, before_and_after, score_bar};
use super::{PublishedResult, Report};
use crate::ImproveReport;
use crate::document::{Block, Column, Document, Medium, Table, TableCell, number, words};
use crate::json::improve::{ImproveResult, PosteriorNumber};
use crate::samples::{self, BlockTable};
use crate::text::diagnose::{CURVES, INCOMPLETE_HEADING, incomplete, remains};
use crate::text::error::channel;
use crate::text::{Scale, condensed, digits, score};
use trueweld_diagnose::DiagnosisVerdict;
use trueweld_diagnose::improve::ImprovementStep;
use trueweld_estimate::residuals::error::ChannelError;

impl Report for ImproveReport<'_> {
    const SCHEMA: &'static str = "improve/1";

    fn json(&self) -> impl PublishedResult {
        ImproveResult::of(self)
    }

    fn samples(&self) -> Option<BlockTable<'_>> {
        Some(samples::of_logs(vec![
            (["given", "fitted"], self.before),
            (["given", "held out"], self.held_out[0]),
            (["improved", "fitted"], self.after),
            (["improved", "held out"], self.held_out[1]),
        ]))
    }

    fn document(&self) -> Document {
        let improvement = self.improvement;
        let mut document = Document::new("Improve", self.headline(), self.provenance);
        document.push(Block::Lead(self.verdict()));
        document.push(Block::List(self.laws()));
        document.push(Block::Note(self.setting()));
        document
            .table("Step by step: scores, and RMS errors where nothing was fitted", self.steps());
        document.figures("How the error falls where nothing was fitted", self.fall().pictures());
        if improvement.is_any() {
            let found = super::discover::curves(&improvement.discovered, &self.model.robot);
            document.figures(crate::text::discover::CURVE, found);
            let curves = self
                .reason
                .filter(|_| self.adds_effects() && improvement.discovered.is_empty())
                .map_or(Vec::new(), |r| evidence(r, &self.model.robot));
            document.figures(CURVES, curves);
            for (logs, [before, after]) in [
                ("of the logs held out, to which nothing was fitted", self.held_out),
                ("of the logs fitted", [self.before, self.after]),
            ] {
                let heading = format!(
                    "Measured and predicted {logs}, before and after: the columns that changed most"
                );
                let figures =
                    Block::Figures(before_and_after(before, after, BEFORE_AND_AFTER_COLUMNS));
                document.section(Medium::Page, &heading, figures);
            }
        }
        document.table("The values of the improved model", self.values());
        document.section(
            Medium::Page,
            "What the logs measure of the cell, jointly: [posterior] of the improved model",
            Block::Table(self.posterior()),
        );
        document.push_on(Medium::Page, Block::Note(self.not_measured()));
        document.table("Tried and not kept", self.rejections());
        let left_out = incomplete(&improvement.incomplete, &self.model.robot);
        document.list(INCOMPLETE_HEADING, left_out);
        if improvement.verdict == DiagnosisVerdict::UnknownEffect {
            document
                .list("What the residual follows that is left", remains(&improvement.unexplained));
        }
        document.push(Block::List(crate::text::compare::notes(self.notices)));
        document
    }
}

impl ImproveReport<'_> {
    /// Whether the improved model has effects that the given one does not.
    fn adds_effects(&self) -> bool {
        self.improvement.steps.iter().any(|step| !step.added.is_empty())
    }

    /// The score of every step, on the logs fitted and where nothing was fitted.
    fn steps(&self) -> Table {
        let steps = &self.improvement.steps;
        let highest = steps.iter().flat_map(|s| [s.score, s.held_out]).fold(2.0, f64::max);
        let cell = |value: f64| number(score(value)).with_bar(score_bar(value, highest));
        let first = &self.improvement.first().errors;
        let of_channels = |value: &dyn Fn(&ChannelError) -> f64, errors: &[ChannelError]| {
            let quantity = |e: &ChannelError| number(level(value(e), Scale::small(e.unit)));
            errors.iter().map(quantity).collect::<Vec<_>>()
        };
        let row = |(k, step): (usize, &ImprovementStep)| {
            let scores = [words(self.step(k)), cell(step.score), cell(step.held_out)];
            scores.into_iter().chain(of_channels(&|e| e.rmse, &step.errors)).collect()
        };
        let floor = |name: &str, value: &dyn Fn(&ChannelError) -> f64| {
            let any = first.iter().any(|e| value(e) > 0.0);
            let scores = [words(name), number(""), number("")];
            any.then(|| scores.into_iter().chain(of_channels(value, first)).collect())
        };
        let floors = [floor("noise", &|e| e.noise), floor("accuracy", &|e| e.accuracy)];
        let rows: Vec<Vec<TableCell>> = steps.iter().enumerate().map(row).collect();
        let scores = [words(""), number("score, fitted"), number("not fitted")];
        let channels = first.iter().map(|e| number(channel(e)));
        Table {
            head: vec![scores.into_iter().chain(channels).collect()],
            rows: rows.into_iter().chain(floors.into_iter().flatten()).collect(),
        }
    }

    /// How the error falls, where nothing was fitted.
    fn fall(&self) -> ErrorFall<'_> {
        let steps = self.improvement.steps.iter().enumerate();
        let named = steps.map(|(k, step)| (self.step(k), step.errors.as_slice()));
        ErrorFall { steps: named.collect() }
    }

    fn values(&self) -> Table {
        let rows = self.fitted().into_iter().map(|cells| cells.map(words).to_vec());
        let head = ["", "parameter", "value, 95 %", "where it comes from"].map(words).to_vec();
        Table { head: vec![head], rows: rows.collect() }
    }

    /// Every number that the logs measure, with every calibration free beside it.
    fn posterior(&self) -> Table {
        let numbers = |of| PosteriorNumber::all(of, &self.model.robot);
        let name = |n: &PosteriorNumber| match n.at.as_str() {
            "" => format!("{}: {}", n.effect, n.parameter),
            at => format!("{} at {at}: {}", n.effect, n.parameter),
        };
        let interval =
            |n: &PosteriorNumber| format!("{} to {}", digits(n.low, 3), digits(n.high, 3));
        let columns: [Column<'_, PosteriorNumber>; 6] = [
            (words(""), &|n| words(name(n))),
            (number("value"), &|n| number(digits(n.value, 3))),
            (number("95 %"), &|n| number(interval(n))),
            (number("± from log to log"), &|n| match n.between_logs > 0.0 {
                true => number(digits(n.between_logs, 2)),
                false => number(""),
            }),
            (words("unit"), &|n| words(n.unit)),
            (words(""), &|n| words(if n.at_bound { "at the bound" } else { "" })),
        ];
        Table::of(self.posterior.map_or(Vec::new(), numbers), &columns)
    }

    fn not_measured(&self) -> String {
        match self.posterior.map_or(&[][..], |of| &of.not_measured) {
            [] => String::new(),
            names => format!("Fitted, and next to nothing known of it: {}.", condensed(names)),
        }
    }

    fn rejections(&self) -> Table {
        let rows = self.improvement.rejected.iter().map(|rejected| {
            let [what, why] = self.rejected(rejected);
            let held_out = rejected.held_out;
            let held_out = if held_out.is_finite() { score(held_out) } else { "–".to_owned() };
            vec![words(what), number(held_out), words(why)]
        });
        let head = vec![words(""), number("held-out score"), words("why not")];
        Table { head: vec![head], rows: rows.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::assert_self_contained;
    use crate::sample;
    use std::path::Path;

    #[test]
    fn text_and_page_have_every_step_and_say_what_was_not_kept() {
        let parts = sample::diagnosis(DiagnosisVerdict::EffectFound);
        let improvement = sample::improvement(parts.diagnosis);
        let report = ImproveReport {
            model: &parts.model,
            out: Path::new("improved.toml"),
            improvement: &improvement,
            posterior: Some(&sample::posterior()),
            before: &parts.before,
            after: &parts.after,
            held_out: [&parts.before, &parts.after],
            reason: parts.explanation.reasons.first(),
            notices: &[],
            provenance: sample::provenance(),
        };
        let (text, page) = (report.text(), report.page());
        assert_self_contained(&page);
        for said in [
            "With backlash at A5 the error of the tool position falls from 0.104 to 0.0332 mm RMS (90 % of its",
            "square) where nothing was fitted: the score falls from 3.37 to 1.07.",
            "recalibration alone",
            "the error elsewhere does not fall",
            "improved.toml",
        ] {
            assert!(text.replace('\n', " ").contains(said), "{said}: {text}");
            assert!(page.contains(said), "{said}");
        }
        // How the error falls; the effect's curve; what was held out; what was fitted.
        assert_eq!(page.matches("<svg").count(), 4);
        for heading in ["The curve that shows it", "of the logs held out", "of the logs fitted"] {
            assert!(page.contains(heading), "{heading}");
        }
    }
}
