//! Responses of the controllers to a step of the push.

use super::{PublishedResult, Report};
use crate::color;
use crate::document::{
    Block, Document, Medium, Picture, Plot, PlotLine, Table, TableCell, Tone, number, reference,
    words,
};
use crate::samples::{self, BlockTable};
use crate::text::step::{headline, milliseconds, setting};
use crate::text::{PublishedStep, fixed};
use crate::{MILLI, StepReport, StepRun};
use trueweld_plant::simulate::RecordRow;

impl Report for StepReport<'_> {
    const SCHEMA: &'static str = "step-result/1";

    fn json(&self) -> impl PublishedResult {
        self
    }

    fn samples(&self) -> Option<BlockTable<'_>> {
        Some(samples::of_runs(self.runs.iter().map(|run| run.recording)))
    }

    fn document(&self) -> Document {
        let mut document = Document::new("Force step", headline(self.runs), self.provenance);
        document.push(Block::Note(setting(self.height)));
        document.push(Block::Table(table(self.runs)));
        document.push_on(Medium::Page, Block::Figures(self.figures()));
        document
    }
}

/// Ours, and below it what is published of the same scheme.
fn table(runs: &[StepRun]) -> Table {
    let time = |time: Option<f64>| time.map_or("never".to_owned(), milliseconds);
    let percent = |share: f64| format!("{} %", fixed(100.0 * share, 1));
    let mut rows = Vec::new();
    for StepRun { figures: ours, .. } in runs {
        rows.push(vec![
            words(ours.controller),
            number(time(ours.first_within_5pct_s)),
            number(time(ours.settle_5pct_s)),
            number(percent(ours.overshoot)),
            number(format!("{} N", fixed(ours.static_error_n, 0))),
            number(format!("{:.0} N", ours.ripple_n)),
        ]);
        if let Some(theirs) = PublishedStep::of(ours.controller) {
            rows.push(vec![
                words(format!("  published, scheme {}", theirs.scheme)).tone(Tone::Aside),
                number(""),
                number(milliseconds(theirs.settle)),
                number(percent(theirs.overshoot)),
                number(theirs.static_error),
                number(theirs.ripple),
            ]);
        }
    }
    Table { head: vec![headings().to_vec()], rows }
}

/// Headings of the table, in its order.
fn headings() -> [TableCell; 6] {
    ["controller", "first within 5 %", "stays within 5 %", "overshoot", "static error", "ripple"]
        .map(number)
}

impl StepReport<'_> {
    /// A signal of a run since shortly before the step.
    fn since_step(
        run: &StepRun,
        at: f64,
        of: impl Fn(&RecordRow) -> Option<f64>,
    ) -> Vec<(f64, f64)> {
        let rows = run.recording.rows.iter().filter(|row| row.time >= at - 0.2);
        rows.filter_map(|row| of(row).map(|value| (row.time - at, value))).collect()
    }

    /// A signal of every run.
    fn lines(&self, of: impl Fn(&RecordRow) -> Option<f64>) -> Vec<PlotLine> {
        let line = |(k, run): (usize, &StepRun)| {
            let points = Self::since_step(run, self.at, &of);
            PlotLine::new(run.recording.controller, color::run(k), points)
        };
        self.runs.iter().enumerate().map(line).collect()
    }

    fn figures(&self) -> Vec<Picture> {
        let last = self.runs.first().and_then(|run| run.recording.rows.last());
        let goal = last.and_then(|row| row.force_desired).unwrap_or(0.0);
        let near = 0.05 * self.height.abs();
        let mut push = self.lines(|row| Some(-row.force_w.z / MILLI));
        push.extend(self.runs.first().map(|run| {
            let desired = |row: &RecordRow| row.force_desired.map(|force| force / MILLI);
            reference("push asked for", held(&Self::since_step(run, self.at, desired)))
        }));
        let plot = |y_label: &str, lines: Vec<PlotLine>, band: [f64; 2]| Plot {
            band: Some(band),
            band_name: "±5 % of the step".into(),
            wide: true,
            ..Plot::new("time since the step, s", y_label, lines)
        };
        let errors = self.lines(|row| row.force_desired.map(|desired| -row.force_w.z - desired));
        vec![
            Picture::new(
                "Response",
                plot("push, kN", push, [goal - near, goal + near].map(|f| f / MILLI)),
            ),
            Picture::new(
                "The same near its end value, less the push asked for: static error and ripple",
                Plot {
                    y_range: Some([-3.0 * near, 3.0 * near]),
                    ..plot("push less push asked for, N", errors, [-near, near])
                },
            ),
        ]
    }
}

/// A line that holds each value until the next one.
fn held(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let corner = |pair: &[(f64, f64)]| [pair[0], (pair[1].0, pair[0].1)];
    points.windows(2).flat_map(corner).chain(points.last().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::assert_self_contained;
    use crate::sample;

    #[test]
    fn the_published_figures_stand_below_ours() {
        let steps = sample::steps();
        let runs = steps.runs();
        let report = StepReport {
            runs: &runs,
            at: sample::STEP_AT,
            height: sample::STEP_HEIGHT,
            provenance: sample::provenance(),
        };
        let (text, page) = (report.text(), report.page());
        assert_self_contained(&page);
        let lines: Vec<&str> = text.lines().skip_while(|l| !l.starts_with("controller")).collect();
        let published = [("370 ms", "24.0 %"), ("580 ms", "20.0 %"), ("860 ms", "4.5 %")];
        for (k, (settled, overshoot)) in published.iter().enumerate() {
            assert!(lines[1 + 2 * k].starts_with(steps.figures[k].controller), "{text}");
            assert!(lines[2 + 2 * k].contains(settled) && lines[2 + 2 * k].contains(overshoot));
            assert!(page.contains(settled) && page.contains(overshoot));
        }
    }
}
