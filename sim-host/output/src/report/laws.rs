//! Laws side by side.

use super::Report;
use crate::MILLI;
use crate::color;
use crate::document::{
    Block, Document, Figure, Line, Medium, Plot, Table, number, reference, words,
};
use crate::json::LawsResult;
use crate::words::laws::{axis, failures, headline, label, setting, title};
use trueweld_compensators::library;
use trueweld_evaluate::WeldFigures;
use trueweld_evaluate::laws::{Change, LawComparison, Sweep};

use trueweld_plant::provenance::Provenance;

/// A finished comparison of laws.
#[derive(Debug, Clone, Copy)]
pub struct LawsReport<'a> {
    /// What was compared.
    pub comparison: &'a LawComparison<'a>,
    /// What came out.
    pub sweeps: &'a [Sweep],
    /// What the lateral deviation is to stay within, RMS, m; `None` where nothing is required.
    pub limit: Option<f64>,
    /// What the result is of.
    pub provenance: &'a Provenance,
}

/// A figure of a table, and the factor to the unit that it is shown in.
type Shown = (fn(&WeldFigures) -> f64, f64);

const LATERAL: Shown = (|f| f.lateral.rms, MILLI);

/// Where a table is shown, what is in it, and its figures, one beside the other in a cell.
const TABLES: [(Medium, &str, &[Shown]); 3] = [
    (Medium::Terminal, "lateral, RMS, mm", &[LATERAL]),
    (Medium::Page, "lateral, RMS / largest, mm", &[LATERAL, (|f| f.lateral.max_abs, MILLI)]),
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
    type Json = LawsResult;

    fn provenance(&self) -> &Provenance {
        self.provenance
    }

    fn json(&self) -> LawsResult {
        LawsResult::of(self)
    }

    fn document(&self) -> Document {
        let welds = self.sweeps.iter().flat_map(|sweep| sweep.points.iter().flatten().flatten());
        let lateral = welds.map(|figures| figures.lateral.rms).chain(self.limit);
        // The same in all pictures: what is high in one is high in every other.
        let [low, high] = lateral
            .filter(|v| *v > 0.0 && v.is_finite())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        let y_range = (low <= high).then_some([0.8 * low * MILLI, 1.25 * high * MILLI]);
        let mut document = Document::new("Laws", headline(self));
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
    fn table(&self, sweep: &Sweep, what: &str, figures: &[Shown]) -> Table {
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

    fn figure(&self, sweep: &Sweep, y_range: Option<[f64; 2]>) -> Figure {
        let changes = sweep.quantity.changes();
        let categories: Vec<String> = changes.iter().map(|change| label(*change)).collect();
        let ends = [-0.2, categories.len() as f64 - 0.8];
        let required =
            self.limit.map(|limit| reference("required", ends.map(|x| (x, limit * MILLI)).into()));
        let lines = self.comparison.laws.iter().zip(&sweep.points).map(|(law, welds)| {
            let mut points = Vec::new();
            for (k, (change, weld)) in changes.iter().zip(welds).enumerate() {
                // A point beside the line: not more of what is varied, but something else.
                if matches!(change, Change::DeadInLastPass | Change::ForceSensorDies) {
                    points.push((k as f64 - 0.5, f64::NAN));
                }
                let lateral = weld.as_ref().map_or(f64::NAN, |figures| figures.lateral.rms);
                points.push((k as f64, lateral * MILLI));
            }
            // A law has its colour whichever others it is compared with.
            let all = library();
            let place = all.iter().position(|l| l.name() == law.name()).unwrap_or(all.len());
            Line { name: law.name().to_owned(), color: color::run(place), dashed: false, points }
        });
        let plot = Plot {
            x_label: axis(sweep.quantity).to_owned(),
            y_label: "lateral, RMS, mm".to_owned(),
            lines: required.into_iter().chain(lines).collect(),
            x_range: Some(ends),
            y_range,
            categories,
            named: true,
            logarithmic: true,
            ..Plot::default()
        };
        Figure::new(title(self.comparison, sweep.quantity), plot)
    }
}
