//! Where a part is best put.

use crate::color;
use crate::document::{
    Block, Document, Map, Marked, Medium, Picture, Plot, PlotLine, Table, TableCell, number,
    reference, words,
};
use crate::json::study::layout::StudyLayoutResult;
use crate::path::{moving, travelled};
use crate::report::{PublishedResult, Report};
use crate::samples::{self, BlockTable};
use crate::text::fixed;
use crate::text::requirement::shown;
use crate::text::study::layout::{
    PLACEMENT_NUMBERS, allowed, coordinate, headline, notices, posture, setting, unit, value,
};
use crate::{MILLI, StudyLayoutReport};
use trueweld_evaluate::WeldFigures;
use trueweld_evaluate::margins::MARGIN_FIGURES;
use trueweld_evaluate::study::{
    Confirmation, ConfirmedWeld, MARGINS_ASKED, PlacedPart, WAY_FIGURES, more_is_better, numbers,
};

/// Rows of the front in a table.
const FRONT: usize = 8;

/// Points of the cloud in a picture.
const CLOUD: usize = 600;

/// Figures of full runs: what they are called, and how they are written.
type RunFigure = (&'static str, fn(&WeldFigures) -> String);
const FULL_RUN_FIGURES: [RunFigure; 6] = [
    ("lateral, largest", |f| format!("{} mm", fixed(f.lateral.max_abs * MILLI, 2))),
    ("lateral, RMS", |f| format!("{} mm", fixed(f.lateral.rms * MILLI, 3))),
    ("along the seam, largest", |f| format!("{} mm", fixed(f.longitudinal.max_abs * MILLI, 2))),
    ("tilt, largest", |f| format!("{}°", fixed(f.tilt.max_abs.to_degrees(), 3))),
    ("push, max − min", |f| format!("{:.0} N", f.force.envelope)),
    ("the weld asked for?", |f| if f.met { "yes" } else { "no" }.to_owned()),
];

impl Report for StudyLayoutReport<'_> {
    const SCHEMA: &'static str = "study-layout/1";

    fn json(&self) -> impl PublishedResult {
        StudyLayoutResult::of(self)
    }

    fn samples(&self) -> Option<BlockTable<'_>> {
        Some(samples::of_layout(self))
    }

    fn document(&self) -> Document {
        let mut document = Document::new("Layout", headline(self), self.provenance);
        document.push(Block::Note(setting(self)));
        document.push(Block::List(notices(self)));
        document.push(Block::Table(self.comparison()));
        document.push_on(Medium::Page, Block::Maps(self.maps()));
        document.push_on(Medium::Page, Block::Figures(self.figures()));
        let of: Vec<&str> = self.front_of.iter().map(|k| WAY_FIGURES[*k].figure.label).collect();
        let heading = format!("No other placement is better in all of: {}", of.join("; "));
        document.table(&heading, self.front_table());
        document
    }
}

impl StudyLayoutReport<'_> {
    /// Where the file has the part, where that is reached, and where it is best put.
    fn both(&self) -> Vec<(&'static str, &Confirmation)> {
        let filed = self.filed.as_ref().ok().map(|of| ("as its file has it", of));
        filed.into_iter().chain([("chosen", self.chosen)]).collect()
    }

    /// The placements side by side: where, by statics, by full runs, margins.
    fn comparison(&self) -> Table {
        let both = self.both();
        let mut rows: Vec<Vec<TableCell>> = Vec::new();
        let mut row = |name: &str, cells: Vec<TableCell>, aside: String| {
            let name = match aside.as_str() {
                "" => name.to_owned(),
                aside => format!("{name} ({aside})"),
            };
            rows.push(std::iter::once(words(name)).chain(cells).collect());
        };
        let each = |of: &dyn Fn(&Confirmation) -> TableCell| -> Vec<TableCell> {
            both.iter().map(|(_, confirmed)| of(confirmed)).collect()
        };
        for k in 0..PLACEMENT_NUMBERS.len() {
            let cell = |of: &Confirmation| number(coordinate(k, numbers(&of.placed.placement)[k]));
            row(PLACEMENT_NUMBERS[k].0, each(&cell), String::new());
        }
        let postures = |of: &Confirmation| {
            let mut all: Vec<String> = of.placed.branches.iter().map(|b| posture(*b)).collect();
            all.dedup();
            TableCell { lines: all, ..number("") }
        };
        row("posture", each(&postures), String::new());
        for (k, of) in WAY_FIGURES.iter().enumerate() {
            let limit = self.task.allowed.iter().find(|a| a.figure == k);
            let is_beyond = |value: f64| match (limit, more_is_better(k)) {
                (None, _) => false,
                (Some(limit), true) => value < limit.limit,
                (Some(limit), false) => value > limit.limit,
            };
            let cell = |confirmed: &Confirmation| {
                let value = confirmed.placed.values[k];
                number(unit(k).quantity(value)).bad(is_beyond(value))
            };
            row(of.figure.label, each(&cell), limit.map_or(String::new(), allowed));
        }
        let runs = |confirmed: &Confirmation| confirmed.welds.len();
        for k in 0..both.iter().map(|(_, of)| runs(of)).max().unwrap_or(0) {
            let Some(first) = self.chosen.welds.get(k) else { continue };
            let seam = if self.chosen.placed.branches.len() > 1 {
                format!("seam {}, ", first.seam + 1)
            } else {
                String::new()
            };
            let name = match first.law.as_str() {
                "none" => format!("{seam}no compensation"),
                law => format!("{seam}{law}"),
            };
            for (label, of) in FULL_RUN_FIGURES {
                let cell = |confirmed: &Confirmation| match figures(confirmed.welds.get(k)) {
                    Some(figures) => number(of(figures)),
                    None => number("none").bad(true),
                };
                row(&format!("{name}, full run: {label}"), each(&cell), String::new());
            }
        }
        for of in MARGIN_FIGURES.iter().take(MARGINS_ASKED) {
            let cell = |confirmed: &Confirmation| {
                let margins = confirmed.margins.as_ref().map_or(&[][..], Vec::as_slice);
                let least = margins.iter().map(|m| (of.value)(m).0);
                number(shown(of.figure.key, least.fold(f64::INFINITY, f64::min)))
            };
            row(of.figure.label, each(&cell), "least of the loop".to_owned());
        }
        let head = std::iter::once(words(""));
        let head = head.chain(
            both.iter()
                .enumerate()
                .map(|(k, (name, _))| number(*name).colored(color::run(k + 2 - both.len()))),
        );
        Table { head: vec![head.collect()], rows }
    }

    fn front_table(&self) -> Table {
        let varied: Vec<usize> =
            (0..6).filter(|k| self.task.family.0[*k].high > self.task.family.0[*k].low).collect();
        let mut front: Vec<&&PlacedPart> = self.front.iter().collect();
        front.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        let head = varied.iter().map(|k| number(PLACEMENT_NUMBERS[*k].0));
        let figures = self.front_of.iter().map(|k| {
            let label = WAY_FIGURES[*k].figure.label.split(',').next().unwrap_or_default();
            number(unit(*k).named(label))
        });
        let head = head.chain(figures).chain([number("of the allowed")]).collect();
        let rows = front.iter().take(FRONT).map(|of| self.front_row(of, &varied)).collect();
        Table { head: vec![head], rows }
    }

    /// `varied`: numbers of the placement that the grid varies.
    fn front_row(&self, of: &PlacedPart, varied: &[usize]) -> Vec<TableCell> {
        let at = numbers(&of.placement);
        let place = varied.iter().map(|k| number(coordinate(*k, at[*k])));
        let values = self.front_of.iter().map(|k| number(value(*k, of)));
        let share = of.limiting().share;
        let share = number(format!("{} %", fixed(100.0 * share, 0))).bad(share > 1.0);
        place.chain(values).chain([share]).collect()
    }

    /// The two numbers that vary most over the family, for the axes of maps.
    fn axes(&self) -> Option<[usize; 2]> {
        let values = self.task.family.0.map(|range| range.values().len());
        let mut varied: Vec<usize> = (0..6).filter(|k| values[*k] > 1).collect();
        varied.sort_by_key(|k| std::cmp::Reverse(values[*k]));
        let mut axes = [*varied.first()?, *varied.get(1)?];
        axes.sort_unstable();
        Some(axes)
    }

    /// Maps through the chosen placement, the other numbers at the nearest of the grid.
    fn maps(&self) -> Vec<Map> {
        let Some([across, up]) = self.axes() else { return Vec::new() };
        let ranges = self.task.family.0.map(|range| range.values());
        let at = numbers(&self.chosen.placed.placement);
        let nearest = |k: usize| {
            let distance = |v: &f64| (v - at[k]).abs();
            ranges[k].iter().copied().min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let fixed_at: Vec<f64> = (0..6).map(|k| nearest(k).unwrap_or(0.0)).collect();
        let strides: Vec<usize> =
            (0..6).map(|k| ranges[k + 1..].iter().map(Vec::len).product()).collect();
        let place = |k: usize, value: f64| {
            let found = ranges[k].iter().position(|v| (v - value).abs() < 1e-9);
            found.unwrap_or(0) * strides[k]
        };
        let index = |x: f64, y: f64, k: usize| match k {
            k if k == across => place(k, x),
            k if k == up => place(k, y),
            k => place(k, fixed_at[k]),
        };
        let slice = |x: f64, y: f64| {
            self.grid.get((0..6).map(|k| index(x, y, k)).sum::<usize>())?.outcome.as_ref().ok()
        };
        let label = |k: usize| format!("{}, {}", PLACEMENT_NUMBERS[k].0, PLACEMENT_NUMBERS[k].1);
        let [fx, fy] = [across, up].map(|k| PLACEMENT_NUMBERS[k].2);
        let own = numbers(&self.task.part.placement());
        let inside = |k: usize| {
            let range = self.task.family.0[k];
            (range.low - 1e-9..=range.high + 1e-9).contains(&own[k])
        };
        let filed = (inside(across) && inside(up)).then_some((own[across] * fx, own[up] * fy, 'F'));
        let chosen = (at[across] * fx, at[up] * fy, 'C');
        let map = Map {
            title: "Largest share of what is allowed, %".to_owned(),
            x_label: label(across),
            y_label: label(up),
            xs: ranges[across].iter().map(|x| x * fx).collect(),
            ys: ranges[up].iter().map(|y| y * fy).collect(),
            values: Vec::new(),
            allowed: Some((100.0, false)),
            marks: filed.into_iter().chain([chosen]).collect(),
        };
        let values = |of: &dyn Fn(&PlacedPart) -> f64| -> Vec<Vec<Option<f64>>> {
            let row = |y: &f64| ranges[across].iter().map(|x| slice(*x, *y).map(of)).collect();
            ranges[up].iter().map(row).collect()
        };
        let share = Map { values: values(&|p| 100.0 * p.limiting().share), ..map.clone() };
        let of_figure = |k: usize| {
            let factor = unit(k).factor;
            Map { values: values(&|p| p.values[k] * factor), ..self.figure_map(k, &map) }
        };
        std::iter::once(share).chain((0..WAY_FIGURES.len()).map(of_figure)).collect()
    }

    /// A map of a figure, without its values.
    fn figure_map(&self, k: usize, map: &Map) -> Map {
        let unit = unit(k);
        let limit = self.task.allowed.iter().find(|a| a.figure == k);
        Map {
            title: sentence(&unit.named(WAY_FIGURES[k].figure.label)),
            allowed: limit.map(|limit| (limit.limit * unit.factor, more_is_better(k))),
            ..map.clone()
        }
    }

    fn figures(&self) -> Vec<Picture> {
        let mut figures = vec![Picture {
            text: "Every dot is a placement of the grid; the line joins those that none is better than in both; ringed: \
                   the chosen one."
                .to_owned(),
            ..Picture::new("What is traded for what", self.trade())
        }];
        let lateral = |row: &trueweld_plant::simulate::RecordRow| row.deviation_w.linear.y * MILLI;
        let tilt = |row: &trueweld_plant::simulate::RecordRow| row.tilt.to_degrees();
        figures.push(Picture::new(
            "Lateral deviation without compensation, full runs",
            self.runs("lateral deviation, mm", lateral),
        ));
        figures
            .push(Picture::new("Tilt without compensation, full runs", self.runs("tilt, °", tilt)));
        figures
    }

    /// Placements by the first two figures of the front.
    fn trade(&self) -> Plot {
        let &[a, b, ..] = self.front_of else { return Plot::default() };
        let point =
            |of: &PlacedPart| (of.values[a] * unit(a).factor, of.values[b] * unit(b).factor);
        let reached: Vec<&PlacedPart> =
            self.grid.iter().filter_map(|placed| placed.outcome.as_ref().ok()).collect();
        let mut front: Vec<(f64, f64)> =
            trueweld_evaluate::study::pareto(&reached, &[a, b]).into_iter().map(point).collect();
        front.sort_by(|p, q| p.0.total_cmp(&q.0));
        let every = reached.len().div_ceil(CLOUD).max(1);
        let cloud = reached.iter().step_by(every).map(|of| {
            let (x, y) = point(of);
            Marked { x, y, error: 0.0 }
        });
        let label = |k: usize| unit(k).named(WAY_FIGURES[k].figure.label);
        let lines = vec![PlotLine::new("best in both", color::run(1), front)];
        Plot {
            marked: cloud.collect(),
            marked_name: "placement",
            rings: vec![point(&self.chosen.placed)],
            rings_name: "chosen",
            ..Plot::new(label(a), label(b), lines)
        }
    }

    /// A signal of the first seam's run without compensation, at both placements.
    fn runs(
        &self,
        y_label: &str,
        of: impl Fn(&trueweld_plant::simulate::RecordRow) -> f64,
    ) -> Plot {
        let both = self.both();
        let lines = both.iter().enumerate().filter_map(|(k, (name, confirmed))| {
            let weld = confirmed.welds.first()?;
            let (_, recording) = weld.outcome.as_ref().ok()?;
            let rows = recording.rows.iter().zip(travelled(&recording.rows));
            let on_seam = rows.filter(|(row, _)| moving(row.phase));
            let points = on_seam.map(|(row, s)| (s * MILLI, of(row))).collect();
            Some(PlotLine::new(*name, color::run(k + 2 - both.len()), points))
        });
        let mut lines: Vec<PlotLine> = lines.collect();
        let length = lines.iter().filter_map(|l| l.points.last()).map(|p| p.0).fold(0.0, f64::max);
        lines.push(reference("", vec![(0.0, 0.0), (length, 0.0)]));
        Plot::new("position on the seam, mm", y_label, lines)
    }
}

fn figures(of: Option<&ConfirmedWeld>) -> Option<&WeldFigures> {
    of?.outcome.as_ref().ok().map(|(figures, _)| figures)
}

fn sentence(label: &str) -> String {
    crate::text::study::sensitivity::capital(label)
}
