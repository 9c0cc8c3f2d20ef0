//! Laws side by side.

use super::{PublishedResult, Report};
use crate::color;
use crate::document::{
    Block, Document, Medium, Picture, Plot, PlotLine, Table, number, reference, words,
};
use crate::json::laws::LawsResult;
use crate::samples::{self, BlockTable};
use crate::text::laws::{axis, failures, headline, label, setting, title};
use crate::{LawsReport, MILLI};
use trueweld_compensators::{Entry, library};
use trueweld_evaluate::WeldFigures;
use trueweld_evaluate::laws::{ScenarioChange, ScenarioSweep};

/// A figure of a table, and the factor to the unit that it is shown in.
type TableFigure = (fn(&WeldFigures) -> f64, f64);

const LATERAL_RMS: TableFigure = (|f| f.lateral.rms, MILLI);

/// Where a table is shown, what is in it, and its figures, one beside the other in a cell.
const TABLES: [(Medium, &str, &[TableFigure]); 3] = [
    (Medium::Terminal, "lateral, RMS, mm", &[LATERAL_RMS]),
    (Medium::Page, "lateral, RMS / largest, mm", &[LATERAL_RMS, (|f| f.lateral.max_abs, MILLI)]),
    (
        Medium::Page,
        "tilt across the seam / travel angle, RMS, °",
        &[
            (|f| f.side_tilt.rms, 180.0 / std::f64::consts::PI),
            (|f| f.travel_angle.rms, 180.0 / std::f64::consts::PI),
        ],
    ),
];

impl Report for LawsReport<'_> {
    const SCHEMA: &'static str = "compare-laws/1";

    fn json(&self) -> impl PublishedResult {
        LawsResult::of(self)
    }

    fn samples(&self) -> Option<BlockTable<'_>> {
        Some(samples::of_laws(self))
    }

    fn document(&self) -> Document {
        let welds = self.sweeps.iter().flat_map(|sweep| sweep.points.iter().flatten().flatten());
        let lateral = welds.map(|figures| figures.lateral.rms).chain(self.limit);
        // The same in all pictures: what is high in one is high in every other.
        let [low, high] = lateral
            .filter(|v| *v > 0.0 && v.is_finite())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        let y_range = (low <= high).then_some([0.8 * low * MILLI, 1.25 * high * MILLI]);
        let mut document = Document::new("Laws", headline(self), self.provenance);
        document.push(Block::Note(setting(self.comparison)));
        let figures = self.sweeps.iter().map(|sweep| self.figure(sweep, y_range)).collect();
        document.push_on(Medium::Page, Block::Figures(figures));
        for sweep in self.sweeps {
            document.push(Block::Heading(title(self.comparison, sweep.quantity)));
            for (medium, what, figures) in TABLES {
                document.push_on(medium, Block::Table(self.table(sweep, what, figures)));
            }
            document.push(Block::List(failures(self.comparison, sweep)));
        }
        document
    }
}

impl LawsReport<'_> {
    /// The figures of every law under every change, one beside the other in a cell.
    fn table(&self, sweep: &ScenarioSweep, what: &str, figures: &[TableFigure]) -> Table {
        let cell = |point: &Result<WeldFigures, _>| match point {
            Ok(f) => {
                let all = figures.iter().map(|(of, factor)| format!("{:.3}", of(f) * factor));
                number(all.collect::<Vec<_>>().join(" / "))
            }
            Err(_) => number("none"),
        };
        let rows = self.comparison.laws.iter().zip(&sweep.points).map(|(law, points)| {
            std::iter::once(words(law.name())).chain(points.iter().map(cell)).collect()
        });
        let changes = sweep.quantity.changes();
        let head = std::iter::once(words(what)).chain(changes.iter().map(|c| number(label(*c))));
        Table { head: vec![head.collect()], rows: rows.collect() }
    }

    /// Place of a law's colour: a law of the library has its own whichever others it is compared
    /// with; combinations come after them.
    fn place(&self, law: &Entry) -> usize {
        let all = library();
        let known = |law: &Entry| all.iter().position(|l| l.name() == law.name());
        let others = self.comparison.laws.iter().filter(|law| known(law).is_none());
        known(law).unwrap_or_else(|| {
            all.len() + others.take_while(|other| other.name() != law.name()).count()
        })
    }

    fn figure(&self, sweep: &ScenarioSweep, y_range: Option<[f64; 2]>) -> Picture {
        let changes = sweep.quantity.changes();
        let categories: Vec<String> = changes.iter().map(|change| label(*change)).collect();
        let ends = [-0.2, categories.len() as f64 - 0.8];
        let required =
            self.limit.map(|limit| reference("required", ends.map(|x| (x, limit * MILLI)).into()));
        let lines = self.comparison.laws.iter().zip(&sweep.points).map(|(law, welds)| {
            let mut points = Vec::new();
            for (k, (change, weld)) in changes.iter().zip(welds).enumerate() {
                // A point beside the line: not more of what is varied, but something else.
                if matches!(
                    change,
                    ScenarioChange::DeadInLastPass | ScenarioChange::ForceSensorDies
                ) {
                    points.push((k as f64 - 0.5, f64::NAN));
                }
                let lateral = weld.as_ref().map_or(f64::NAN, |figures| figures.lateral.rms);
                points.push((k as f64, lateral * MILLI));
            }
            let (color, dash) = color::series(self.place(law));
            PlotLine::new(law.name(), color, points).dashed(dash)
        });
        let lines = required.into_iter().chain(lines).collect();
        let plot = Plot {
            x_range: Some(ends),
            y_range,
            categories,
            named: true,
            logarithmic: true,
            ..Plot::new(axis(sweep.quantity), "lateral, RMS, mm", lines)
        };
        Picture::new(title(self.comparison, sweep.quantity), plot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;
    use std::collections::BTreeSet;

    #[test]
    fn fifteen_laws_are_told_apart_by_colour_and_dash() {
        let mut names: Vec<String> = library().iter().map(|law| law.name().to_owned()).collect();
        for first in ["feed-forward", "elastostatic"] {
            names.extend(library().iter().map(|law| format!("{first}+{}", law.name())));
        }
        let names: Vec<&str> = names.iter().map(String::as_str).take(15).collect();
        assert_eq!(names.len(), 15);
        let laws = sample::laws(&names);
        let report = LawsReport {
            comparison: &laws.comparison(),
            sweeps: &laws.sweeps,
            limit: Some(5e-5),
            provenance: sample::provenance(),
        };
        for sweep in report.sweeps {
            let figure = report.figure(sweep, None);
            let drawn: BTreeSet<(color::Rgb, Option<[u32; 2]>)> =
                figure.plot.lines.iter().map(|line| (line.color, line.dash.pixels())).collect();
            // And what is required.
            assert_eq!(drawn.len(), 16);
        }
        let page = report.page();
        for name in names {
            // Beside its line, in every picture.
            assert!(page.matches(&format!(">\n{name}\n")).count() == 4, "{name}");
        }
    }
}
