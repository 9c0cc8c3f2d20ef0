//! Laws side by side as they are told: text, one JSON value, one page.

use crate::color;
use crate::figures::MILLI;
use crate::html::{figure, page};
use crate::plot::{Line, Plot, reference};
use crate::table::wrapped;
use crate::words::{share, signed_share};
use maud::{Markup, html};
use serde_json::{Value, json};
use trueweld_compensators::{Entry, library};
use trueweld_evaluate::WeldFigures;
use trueweld_evaluate::laws::{Change, LawComparison, Sweep, VariedQuantity};

/// A finished comparison of laws.
#[derive(Debug, Clone, Copy)]
pub struct LawsCompared<'a> {
    /// What was compared.
    pub comparison: &'a LawComparison<'a>,
    /// What came out.
    pub sweeps: &'a [Sweep],
    /// What the lateral deviation is to stay within, RMS, m; `None` where nothing is required.
    pub limit: Option<f64>,
}

/// A figure of a table, and the factor to the unit that it is shown in.
type Shown = (fn(&WeldFigures) -> f64, f64);

const LATERAL: Shown = (|f| f.lateral.rms, MILLI);

/// Tables of the page: what is in them, and their figures, one beside the other in a cell.
const TABLES: [(&str, &[Shown]); 2] = [
    ("lateral deviation, RMS / largest, mm", &[LATERAL, (|f| f.lateral.max_abs, MILLI)]),
    (
        "tilt across the seam / travel angle, RMS, °",
        &[
            (|f| f.side_tilt.rms, 180.0 / std::f64::consts::PI),
            (|f| f.travel_angle.rms, 180.0 / std::f64::consts::PI),
        ],
    ),
];

impl LawsCompared<'_> {
    /// Lateral deviation of every law under every change, one block a sweep.
    pub fn text(&self) -> String {
        const FIRST: usize = 16;
        let mut out = format!(
            "{}Lateral deviation, RMS, mm: full feed and full push. Weld {}, {} control, seed {}{}.\n",
            wrapped(&self.headline()),
            self.comparison.scenario.name,
            self.comparison.scenario.controller.name(),
            self.comparison.scenario.seed,
            self.passes()
        );
        for sweep in self.sweeps {
            let labels: Vec<String> = sweep.quantity.changes().iter().map(|c| label(*c)).collect();
            let width = |k: usize| labels[k].chars().count().max(6) + 3;
            out += &format!("\n{}\n", self.title(sweep.quantity));
            let mut row = |first: &str, cells: &[String]| {
                let cells =
                    cells.iter().enumerate().map(|(k, cell)| format!("{cell:>0$}", width(k)));
                out += format!("{first:<FIRST$}{}", cells.collect::<String>()).trim_end();
                out.push('\n');
            };
            row("", &labels);
            for (law, cells) in self.rows(sweep, &[LATERAL]) {
                row(law.name(), &cells);
            }
            for failure in self.failures(sweep) {
                out += &format!("  {failure}\n");
            }
        }
        out
    }

    /// The result as one JSON value, schema `compare-laws/1`.
    pub fn json(&self) -> Value {
        let c = self.comparison;
        let laws: Vec<Value> = c
            .laws
            .iter()
            .map(|law| json!({ "name": law.name(), "passes": c.passes_of(law) }))
            .collect();
        let sweep = |sweep: &Sweep| {
            let results: Vec<Value> = c
                .laws
                .iter()
                .zip(&sweep.points)
                .map(|(law, points)| {
                    let points: Vec<Value> = sweep
                        .quantity
                        .changes()
                        .iter()
                        .zip(points)
                        .map(|(change, point)| {
                            let mut value = match point {
                                Ok(f) => json!({
                                    "lateral_rms_m": f.lateral.rms,
                                    "lateral_max_m": f.lateral.max_abs,
                                    "side_tilt_rms_rad": f.side_tilt.rms,
                                    "travel_angle_rms_rad": f.travel_angle.rms,
                                }),
                                Err(why) => json!({ "failed": why.to_string() }),
                            };
                            value[key(sweep.quantity)] = amount(*change).into();
                            if sweep.quantity == VariedQuantity::Lost {
                                value["only_in_last_pass"] =
                                    (*change == Change::DeadInLastPass).into();
                                value["force_sensor_dies"] =
                                    (*change == Change::ForceSensorDies).into();
                            }
                            value
                        })
                        .collect();
                    json!({ "law": law.name(), "points": points })
                })
                .collect();
            json!({ "varied": key(sweep.quantity), "results": results })
        };
        json!({
            "schema": "compare-laws/1",
            "weld": c.scenario.name,
            "controller": c.scenario.controller.name(),
            "seed": c.scenario.seed,
            "control_period_s": c.scenario.control.period,
            "stiffness_error_where_not_varied": c.stiffness_error,
            "lateral_rms_limit_m": self.limit,
            "laws": laws,
            "sweeps": self.sweeps.iter().map(sweep).collect::<Vec<_>>(),
        })
    }

    /// One page: four pictures, and the tables beneath.
    pub fn html(&self) -> String {
        let lateral = || {
            self.sweeps
                .iter()
                .flat_map(|s| s.points.iter().flatten().flatten())
                .map(|f| f.lateral.rms)
        };
        // The same in all pictures: what is high in one is high in every other.
        let [low, high] = lateral()
            .chain(self.limit)
            .filter(|v| *v > 0.0 && v.is_finite())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        let y_range = (low <= high).then_some([0.8 * low * MILLI, 1.25 * high * MILLI]);
        let body = html! {
            h1 { (self.headline()) }
            p.setting {
                "Weld " (self.comparison.scenario.name) ", " (self.comparison.scenario.controller.name()) " control, seed "
                (self.comparison.scenario.seed) (self.passes()) ". Figures over the steady part (full feed, full push). \
                Instruments as their file says, but for what is varied; noise and delay of the force sensor are also the force \
                loop's."
            }
            div.pairs { @for sweep in self.sweeps { (self.picture(sweep, y_range)) } }
            @for sweep in self.sweeps {
                h2 { (self.title(sweep.quantity)) }
                @for (what, figures) in TABLES { (self.table(sweep, what, figures)) }
                @for failure in self.failures(sweep) { p.setting { (failure) } }
            }
        };
        page("Laws", &body)
    }

    fn picture(&self, sweep: &Sweep, y_range: Option<[f64; 2]>) -> Markup {
        let categories: Vec<String> = sweep.quantity.changes().iter().map(|c| label(*c)).collect();
        let ends = [-0.2, categories.len() as f64 - 0.8];
        let mut lines: Vec<Line> = self
            .limit
            .map(|limit| reference("required", ends.map(|x| (x, limit * MILLI)).to_vec()))
            .into_iter()
            .collect();
        for (law, points) in self.comparison.laws.iter().zip(&sweep.points) {
            let of_line = |part: usize| Line {
                name: String::new(),
                // A law has its colour whichever others it is compared with.
                color: color::run(place(law)),
                dashed: false,
                points: sweep
                    .quantity
                    .changes()
                    .iter()
                    .zip(points)
                    .enumerate()
                    .filter(|(_, (change, _))| part_of(**change) == part)
                    .filter_map(|(k, (_, point))| {
                        Some((k as f64, point.as_ref().ok()?.lateral.rms * MILLI))
                    })
                    .collect(),
            };
            let mut parts = Vec::from([0, 1, 2].map(of_line));
            parts.retain(|part| !part.points.is_empty());
            if let Some(last) = parts.last_mut() {
                last.name = law.name().to_owned();
            }
            lines.extend(parts);
        }
        let plot = Plot {
            x_label: axis(sweep.quantity).to_owned(),
            y_label: "lateral, RMS, mm".to_owned(),
            lines,
            x_range: Some(ends),
            y_range,
            categories,
            named: true,
            logarithmic: true,
            ..Plot::default()
        };
        figure(&self.title(sweep.quantity), &plot)
    }

    fn table(&self, sweep: &Sweep, what: &str, figures: &[Shown]) -> Markup {
        html! {
            table {
                thead { tr {
                    th { (what) }
                    @for change in sweep.quantity.changes() { th { (label(*change)) } }
                } }
                tbody {
                    @for (law, cells) in self.rows(sweep, figures) {
                        tr { th scope="row" { (law.name()) } @for cell in cells { td { (cell) } } }
                    }
                }
            }
        }
    }

    /// Every law with its cells.
    fn rows(&self, sweep: &Sweep, figures: &[Shown]) -> Vec<(&Entry, Vec<String>)> {
        let cell = |point: &Result<WeldFigures, _>| match point {
            Ok(f) => figures
                .iter()
                .map(|(of, unit)| format!("{:.3}", of(f) * unit))
                .collect::<Vec<_>>()
                .join(" / "),
            Err(_) => "none".to_owned(),
        };
        self.comparison
            .laws
            .iter()
            .zip(&sweep.points)
            .map(|(law, p)| (law, p.iter().map(cell).collect()))
            .collect()
    }

    /// Why there are no figures, a sentence for every law and reason.
    fn failures(&self, sweep: &Sweep) -> Vec<String> {
        let mut told: Vec<(String, Vec<String>)> = Vec::new();
        for (law, points) in self.comparison.laws.iter().zip(&sweep.points) {
            for (change, point) in sweep.quantity.changes().iter().zip(points) {
                let Err(why) = point else { continue };
                let why = format!("{}: {why}", law.name());
                match told.iter_mut().find(|(other, _)| *other == why) {
                    Some((_, levels)) => levels.push(label(*change)),
                    None => told.push((why, vec![label(*change)])),
                }
            }
        }
        told.into_iter().map(|(why, levels)| format!("{why} ({})", levels.join("; "))).collect()
    }

    /// Which laws stay within what is required, whatever is varied.
    fn headline(&self) -> String {
        let Some(limit) = self.limit else {
            return "Compensation laws side by side.".to_owned();
        };
        let holds = |points: &[Result<WeldFigures, _>]| {
            points.iter().all(|p| p.as_ref().is_ok_and(|f| f.lateral.rms <= limit))
        };
        let mut groups: Vec<(Vec<&str>, Vec<&str>)> = Vec::new();
        for sweep in self.sweeps {
            let laws =
                self.comparison.laws.iter().zip(&sweep.points).filter(|(_, points)| holds(points));
            let names: Vec<&str> = laws.map(|(law, _)| law.name()).collect();
            match groups.iter_mut().find(|(others, _)| *others == names) {
                Some((_, quantities)) => quantities.push(whatever(sweep.quantity)),
                None => groups.push((names, vec![whatever(sweep.quantity)])),
            }
        }
        let parts = groups.iter().map(|(names, quantities)| {
            let who = if names.is_empty() { "no law".to_owned() } else { names.join(", ") };
            format!("whatever the {}: {who}", quantities.join(", the "))
        });
        format!("Within {} mm RMS {}.", limit * MILLI, parts.collect::<Vec<_>>().join("; "))
    }

    fn passes(&self) -> String {
        let c = self.comparison;
        let learning: Vec<&str> =
            c.laws.iter().filter(|law| c.passes_of(law) > 1).map(|law| law.name()).collect();
        if learning.is_empty() {
            String::new()
        } else {
            format!("; {}: pass {}", learning.join(", "), c.passes)
        }
    }

    fn title(&self, quantity: VariedQuantity) -> String {
        let at = signed_share(self.comparison.stiffness_error);
        match quantity {
            VariedQuantity::StiffnessError => "Error of the believed stiffness".to_owned(),
            VariedQuantity::Noise => format!("Sensor noise, believed stiffness {at}"),
            VariedQuantity::Delay => {
                let period = self.comparison.scenario.control.period * MILLI;
                format!("Sensor delay, periods of {period} ms, believed stiffness {at}")
            }
            VariedQuantity::Lost => format!("Lost sensors, believed stiffness {at}"),
        }
    }
}

/// What stands below a picture.
fn axis(quantity: VariedQuantity) -> &'static str {
    match quantity {
        VariedQuantity::StiffnessError => "error of every joint's stiffness; +: believed too stiff",
        VariedQuantity::Noise => "factor on the noise of force and seam sensor",
        VariedQuantity::Delay => "delay of force and seam sensor, periods",
        VariedQuantity::Lost => {
            "share of seam readings lost; all in the last pass alone; force sensor dead from half-way on"
        }
    }
}

/// The quantity in a sentence.
fn whatever(quantity: VariedQuantity) -> &'static str {
    match quantity {
        VariedQuantity::StiffnessError => "stiffness error",
        VariedQuantity::Noise => "noise",
        VariedQuantity::Delay => "delay",
        VariedQuantity::Lost => "sensors lost",
    }
}

/// The quantity's key in JSON.
fn key(quantity: VariedQuantity) -> &'static str {
    match quantity {
        VariedQuantity::StiffnessError => "stiffness_error",
        VariedQuantity::Noise => "noise_factor",
        VariedQuantity::Delay => "delay_periods",
        VariedQuantity::Lost => "lost_share",
    }
}

/// The value of a change.
fn amount(change: Change) -> f64 {
    match change {
        Change::StiffnessError(v) | Change::Noise(v) | Change::Delay(v) | Change::Lost(v) => v,
        Change::DeadInLastPass => 1.0,
        Change::ForceSensorDies => 0.0,
    }
}

/// Place in the library, and after it for a combination.
fn place(law: &Entry) -> usize {
    library().iter().position(|l| l.name() == law.name()).unwrap_or(library().len())
}

/// Which part of a law's line a change belongs to: what is lost in the last pass alone, and another
/// sensor, are no more of what is lost in every pass, but points beside the line.
fn part_of(change: Change) -> usize {
    match change {
        Change::DeadInLastPass => 1,
        Change::ForceSensorDies => 2,
        _ => 0,
    }
}

/// A change in a heading of a table or below a picture.
fn label(change: Change) -> String {
    match change {
        Change::StiffnessError(error) => signed_share(error),
        Change::Noise(factor) => format!("×{factor}"),
        Change::Delay(periods) => format!("{periods}"),
        Change::Lost(1.0) => "all".to_owned(),
        Change::Lost(lost) => share(lost),
        Change::DeadInLastPass => "last pass".to_owned(),
        Change::ForceSensorDies => "force".to_owned(),
    }
}
