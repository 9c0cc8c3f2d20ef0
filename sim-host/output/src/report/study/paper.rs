//! The published study's figures as curves, ours with the published numbers marked.

use crate::color::{self, Dash, JOINT_COLOURS as JOINT_COLORS};
use crate::document::{
    Block, Column, Document, Medium, Picture, Plot, PlotLine, Table, Tone, number, reference, words,
};
use crate::json::study::paper::StudyPaperResult;
use crate::path::{moving, travelled};
use crate::report::{PublishedResult, Report};
use crate::text::study::paper::{
    Kind, PUBLISHED_LATERAL_MAX, Statement, headline, held, runs, setting, statements, widest,
};
use crate::text::{PublishedStep, fixed};
use crate::{MILLI, StudyPaperReport};
use trueweld_core::JOINTS;
use trueweld_plant::simulate::{Phase, RecordRow, Recording};

/// Time shown after the step, s: all published times and half again.
const SHOWN_TIME: f64 = 1.5;

impl Report for StudyPaperReport<'_> {
    const SCHEMA: &'static str = "study-paper/1";

    fn json(&self) -> impl PublishedResult {
        StudyPaperResult::of(self)
    }

    fn document(&self) -> Document {
        let mut document = Document::new("Published study", headline(self), self.provenance);
        document.push(Block::Note(setting(self)));
        document.push(Block::Table(published(self)));
        document.push_on(Medium::Page, Block::Figures(self.figures()));
        document.table("Push near collinear axes 4 and 6, without compensation", self.distances());
        document
    }
}

fn published(report: &StudyPaperReport<'_>) -> Table {
    let columns: [Column<'_, Statement>; 5] = [
        (words(""), &|of| words(&of.what)),
        (words("published"), &|of| words(&of.published)),
        (words("here"), &|of| words(&of.ours)),
        (words(""), &|of| words(if of.tuned { "tuned" } else { "" }).tone(Tone::Aside)),
        (words("agrees"), &|of| {
            let agrees = of.agrees.map_or("–", |agrees| if agrees { "yes" } else { "no" });
            words(agrees).bad(of.agrees == Some(false))
        }),
    ];
    Table::of(statements(report), &columns)
}

impl StudyPaperReport<'_> {
    fn distances(&self) -> Table {
        let rows = Kind::ALL.iter().flat_map(|kind| {
            kind.points(self).iter().map(|point| {
                let mut row = vec![words(kind.label()), number(fixed(point.x, 2))];
                match &point.outcome {
                    Ok(run) => row.extend([
                        number(fixed(run.collinearity.to_degrees(), 1)),
                        number(format!("{:.0}", run.figures.force.envelope)),
                        number(fixed(run.figures.lateral.max_abs * MILLI, 2)),
                        words(held(run)).tone(Tone::Aside),
                    ]),
                    Err(why) => row.push(words(why.to_string()).over(4)),
                }
                row
            })
        });
        let head = [
            words("weld"),
            number("x, m"),
            number("angle A4–A6, °"),
            number("push, max − min, N"),
            number("lateral, mm"),
            words(""),
        ];
        Table { head: vec![head.to_vec()], rows: rows.collect() }
    }

    fn figures(&self) -> Vec<Picture> {
        let mut figures = vec![
            Picture::new(
                "Step of the push by 11 kN; dotted: the published peak, drawn to the published 5 % time",
                self.step(),
            ),
            Picture::new("Lateral deviation along both published welds", self.lateral()),
            Picture::new("Push along both published welds", self.push()),
            Picture::new(
                "Torsion of the drives, first weld: the wrist's is of the same order",
                self.torsion(),
            ),
            Picture::new("Width of the push over the angle of axes 4 and 6", self.envelope()),
        ];
        if let Some((x, _)) = widest(self, Kind::Inclined) {
            let title = format!("Push along the weld at 45°, x = {} m", fixed(x, 2));
            figures.push(Picture::new(title, self.along(1, "push, kN", 1.0 / MILLI)));
            let title = "Angle between axes 4 and 6 along the same weld";
            figures.push(Picture::new(title, self.along(2, "angle A4–A6, °", 1f64.to_degrees())));
        }
        figures
    }

    /// The responses, with the published time and peak of each in its colour.
    fn step(&self) -> Plot {
        let mut lines = Vec::new();
        let mut goal = 0.0;
        for (k, run) in self.steps.iter().enumerate() {
            let rows = &run.recording.rows;
            let shown = rows.iter().filter(|r| (-0.2..=SHOWN_TIME).contains(&(r.time - self.at)));
            let points = shown.map(|r| (r.time - self.at, -r.force_w.z / MILLI)).collect();
            let (name, color) = (run.figures.controller, color::run(k));
            lines.push(PlotLine::new(name, color, points));
            let Some(theirs) = PublishedStep::of(run.figures.controller) else { continue };
            goal = rows.last().and_then(|r| r.force_desired).unwrap_or(0.0) / MILLI;
            let peak = goal + theirs.overshoot * self.height / MILLI;
            // At the height of the peak, to the published time.
            let points = vec![(0.0, peak), (theirs.settle, peak)];
            let name = format!("published, scheme {}", theirs.scheme);
            lines.push(PlotLine::new(name, color, points).dashed(Dash::Dotted));
        }
        let near = 0.05 * self.height / MILLI;
        Plot {
            band: Some([goal - near, goal + near]),
            band_name: "±5 % of the step".into(),
            wide: true,
            ..Plot::new("time since the step, s", "push, kN", lines)
        }
    }

    /// A signal of every published weld over the position on its seam.
    fn over_path(&self, of: impl Fn(&RecordRow) -> f64) -> Vec<PlotLine> {
        let line = |(k, run): (usize, &crate::WeldRun<'_>)| {
            let name = Kind::ALL.get(k).map_or("", |kind| kind.label());
            PlotLine::new(name, color::run(k), path_points(run.recording, &of))
        };
        self.welds.iter().enumerate().map(line).collect()
    }

    fn lateral(&self) -> Plot {
        let mut lines = self.over_path(|row| row.deviation_w.linear.y * MILLI);
        let ends = lines.first().and_then(|l| Some([l.points.first()?.0, l.points.last()?.0]));
        if let (Some(ends), Some(first)) = (ends, self.welds.first()) {
            // On the side that the first weld's deviation is on.
            let limit = PUBLISHED_LATERAL_MAX.copysign(first.figures.lateral.mean) * MILLI;
            lines.push(reference("published: up to 5 mm", ends.map(|x| (x, limit)).into()));
        }
        over_seam("lateral deviation, mm", lines)
    }

    fn push(&self) -> Plot {
        let lines = self.over_path(|row| -row.force_w.z / MILLI);
        let widest = self.welds.iter().map(|run| run.figures.force.envelope).fold(0.0, f64::max);
        let mean = self.welds.first().map_or(0.0, |run| run.figures.force.mean);
        let range = [-1.0, 1.0].map(|side| (mean + side * widest) / MILLI);
        Plot {
            y_range: (widest > 0.0).then_some(range),
            rippled: true,
            ..over_seam("push, kN", lines)
        }
    }

    fn torsion(&self) -> Plot {
        let first = |of: &dyn Fn(&RecordRow) -> f64| {
            self.welds.first().map_or(Vec::new(), |run| path_points(run.recording, of))
        };
        let lines = (0..JOINTS).map(|joint| {
            let points = first(&|row| row.torsion()[joint] * MILLI);
            PlotLine::new(format!("A{}", joint + 1), JOINT_COLORS[joint], points)
        });
        over_seam("torsion, mrad", lines.collect())
    }

    fn envelope(&self) -> Plot {
        let lines = Kind::ALL.iter().enumerate().map(|(k, kind)| {
            let mut points: Vec<(f64, f64)> = runs(self, *kind)
                .map(|(_, run)| (run.collinearity.to_degrees(), run.figures.force.envelope))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            PlotLine::new(kind.label(), color::run(k), points)
        });
        let [x_label, y_label] = ["least angle between axes 4 and 6, °", "push, max − min, N"];
        Plot { named: true, logarithmic: true, ..Plot::new(x_label, y_label, lines.collect()) }
    }

    /// A signal of the weld whose push swings most: push (1) or angle (2).
    fn along(&self, signal: usize, y_label: &str, factor: f64) -> Plot {
        let points = widest(self, Kind::Inclined).map(|(_, run)| {
            run.trace.iter().map(|at| (at[0] * MILLI, at[signal] * factor)).collect()
        });
        let name = Kind::Inclined.label();
        let line = PlotLine::new(name, color::run(1), points.unwrap_or_default());
        over_seam(y_label, vec![line])
    }
}

/// A signal of a weld over the position on its seam, mm, while the tool moves.
fn path_points(recording: &Recording, of: impl Fn(&RecordRow) -> f64) -> Vec<(f64, f64)> {
    let rows = recording.rows.iter().zip(travelled(&recording.rows));
    let on_seam = rows.filter(|(row, _)| moving(row.phase) && row.phase >= Phase::FeedRamp);
    on_seam.map(|(row, s)| (s * MILLI, of(row))).collect()
}

fn over_seam(y_label: &str, lines: Vec<PlotLine>) -> Plot {
    Plot::new("position on the seam, mm", y_label, lines)
}
