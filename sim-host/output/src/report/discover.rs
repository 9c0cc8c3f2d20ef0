//! The curve of a law that the library does not hold.

use crate::color::{self, Dash};
use crate::document::{Marked, Picture, Plot, PlotLine};
use crate::text::{self, Scale};
use trueweld_diagnose::discover::{Discovery, FreeCurve, FreeSurface, Hypothesis, LikeEffect};
use trueweld_estimate::residuals::localize::ConditionBin;
use trueweld_plant::effects::table::interpolate;
use trueweld_plant::input::RobotFile;

/// Curves with their bands and points, the formula over each.
pub(super) fn curves(all: &[Discovery], robot: &RobotFile) -> Vec<Picture> {
    all.iter().map(|discovery| curve(discovery, robot)).collect()
}

/// What the library's nearest effect leaves of each curve that it is like.
pub(super) fn differences(all: &[Discovery], robot: &RobotFile) -> Vec<Picture> {
    all.iter().filter_map(|d| Some(difference(d, d.like.as_ref()?, robot))).collect()
}

/// Scales and names of a law's axes.
struct Axes {
    x: Scale,
    y: Scale,
    x_label: String,
    y_label: String,
    title: String,
}

impl Axes {
    fn of(discovery: &Discovery, robot: &RobotFile) -> Self {
        let (hypothesis, free) = (&discovery.hypothesis, &discovery.curve);
        let x = scale(&free.x, hypothesis.x_unit());
        // A curve that is multiplied by something has a unit of its own.
        let plain = hypothesis.y_unit() == hypothesis.port.unit;
        let y = match plain {
            true => Scale::small(hypothesis.port.unit),
            false => Scale { factor: 1.0, unit: "" },
        };
        let name = text::discover::axis(hypothesis, robot);
        let quantity = text::discover::quantity(hypothesis, robot);
        let times = match hypothesis.times {
            "1" => String::new(),
            times => format!(", over {times}"),
        };
        let across = free.surface.as_ref().map_or(String::new(), |surface| {
            [", at ", &across(surface, surface.middle, hypothesis, robot)].concat()
        });
        Self {
            x_label: x.named(&name),
            y_label: if plain { y.unit.to_owned() } else { hypothesis.y_unit() },
            title: format!("{quantity}{times}, over {name}{across}"),
            x,
            y,
        }
    }

    fn line(
        &self,
        name: &str,
        run: usize,
        dash: Dash,
        points: impl Iterator<Item = (f64, f64)>,
    ) -> PlotLine {
        let scaled = |(at, value): (f64, f64)| (at * self.x.factor, value * self.y.factor);
        let points = points.map(scaled).collect();
        PlotLine::new(name, color::run(run), points).dashed(dash)
    }

    fn figure(self, lines: Vec<PlotLine>, marked: Vec<Marked>) -> Picture {
        let Self { x_label, y_label, title, .. } = self;
        Picture::new(title, Plot { marked, wide: true, ..Plot::new(x_label, y_label, lines) })
    }
}

/// Where a row of a surface is, such as `the angle of A2 of 12°`.
fn across(surface: &FreeSurface, row: usize, hypothesis: &Hypothesis, robot: &RobotFile) -> String {
    let value = scale(&surface.across, hypothesis.across_unit()).quantity(surface.across[row]);
    format!("{} of {value}", text::discover::across(hypothesis, robot))
}

/// The scale that suits values of a variable.
fn scale(values: &[f64], unit: &'static str) -> Scale {
    match values.iter().all(|v| v.abs() < 0.05) {
        true => Scale::small(unit),
        false => Scale::large(unit),
    }
}

/// What a line over the curve is lifted by: where the logs leave the level open, every line is drawn
/// at that of the curve, the places counting as well as they are known.
fn lift(free: &FreeCurve, points: &[(f64, f64)]) -> f64 {
    if free.level.is_none() {
        return 0.0;
    }
    let widths: Vec<f64> = free.shape.iter().map(|[low, high]| high - low).collect();
    let (mut sum, mut all) = (0.0, 0.0);
    for (x, y) in points {
        let weight = interpolate(&free.x, &widths, *x).powi(-2);
        sum += weight * (interpolate(&free.x, &free.y, *x) - y);
        all += weight;
    }
    if all > 0.0 && all.is_finite() { sum / all } else { 0.0 }
}

/// Names of the band's edges.
fn edges(discovery: &Discovery) -> [&'static str; 2] {
    match discovery.curve.level {
        None => ["95 %, low", "95 %, high"],
        Some(_) => ["95 % but for its level, low", "95 % but for its level, high"],
    }
}

fn difference(discovery: &Discovery, like: &LikeEffect, robot: &RobotFile) -> Picture {
    let (free, axes) = (&discovery.curve, Axes::of(discovery, robot));
    let library: Vec<(f64, f64)> = like.curve.iter().map(|p| (p.x, p.y)).collect();
    let lift = lift(free, &library);
    let less = |of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        let values: Vec<f64> = (0..free.x.len()).map(of).collect();
        library.iter().map(|(x, y)| (*x, interpolate(&free.x, &values, *x) - y - lift)).collect()
    };
    let edge = |end: usize| less(&|k| free.shape[k][end]).into_iter();
    let name = format!("the free curve less {}", text::discover::like_name(like, robot));
    let [low, high] = edges(discovery);
    let lines = vec![
        axes.line(&name, 0, Dash::Solid, less(&|k| free.y[k]).into_iter()),
        axes.line(low, 0, Dash::Dotted, edge(0)),
        axes.line(high, 0, Dash::Dotted, edge(1)),
    ];
    axes.figure(lines, Vec::new())
}

fn curve(discovery: &Discovery, robot: &RobotFile) -> Picture {
    let (free, axes) = (&discovery.curve, Axes::of(discovery, robot));
    let places = || free.x.iter().copied();
    let edge = |end: usize| places().zip(free.shape.iter().map(move |band| band[end]));
    let [low, high] = edges(discovery);
    let mut lines = vec![
        axes.line("the free curve", 0, Dash::Solid, places().zip(free.y.iter().copied())),
        axes.line(low, 0, Dash::Dotted, edge(0)),
        axes.line(high, 0, Dash::Dotted, edge(1)),
    ];
    let lifted = |points: Vec<(f64, f64)>| {
        let lift = lift(free, &points);
        points.into_iter().map(move |(x, y)| (x, y + lift))
    };
    if !free.formula.is_empty() {
        let points = lifted(free.formula.iter().map(|[x, y]| (*x, *y)).collect());
        lines.push(axes.line("the formula", 1, Dash::Solid, points));
    }
    if let Some(surface) = &free.surface {
        let rows = [(0, Dash::Dashed), (surface.across.len() - 1, Dash::Solid)];
        for (row, dash) in rows {
            let name = across(surface, row, &discovery.hypothesis, robot);
            let points = places().zip(surface.y[row].iter().copied());
            lines.push(axes.line(&format!("the surface at {name}"), 2, dash, points));
        }
    }
    if let Some(like) = &discovery.like {
        let name = text::discover::like_name(like, robot);
        let points = lifted(like.curve.iter().map(|p| (p.x, p.y)).collect());
        lines.push(axes.line(&format!("{name}, as fitted"), 3, Dash::Dashed, points));
    }
    let (x, y) = (axes.x.factor, axes.y.factor);
    let mark = |p: &ConditionBin| Marked { x: p.x * x, y: p.y * y, error: p.error * y };
    let marked = free.points.iter().map(mark).collect();
    axes.figure(lines, marked)
}
