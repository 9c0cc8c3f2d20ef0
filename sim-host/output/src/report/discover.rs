//! The curve of a law that the library does not hold.

use crate::color::{self, Dash};
use crate::document::{Figure, Line, Marked, Plot};
use crate::words::{self, Scale};
use trueweld_measure::discover::Discovery;
use trueweld_plant::input::RobotFile;

/// Curves with their bands and points, the formula over each.
pub(super) fn curves(all: &[Discovery], robot: &RobotFile) -> Vec<Figure> {
    all.iter().map(|discovery| curve(discovery, robot)).collect()
}

fn curve(discovery: &Discovery, robot: &RobotFile) -> Figure {
    let (hypothesis, free) = (&discovery.hypothesis, &discovery.curve);
    let over = hypothesis.variables().first().copied().unwrap_or_default();
    let x = match free.x.iter().all(|x| x.abs() < 0.05) {
        true => Scale::small(hypothesis.x_unit()),
        false => Scale::large(hypothesis.x_unit()),
    };
    // A curve that is multiplied by something has a unit of its own.
    let plain = hypothesis.y_unit() == hypothesis.port.unit;
    let y =
        if plain { Scale::small(hypothesis.port.unit) } else { Scale { factor: 1.0, unit: "" } };
    let line =
        |name: &str, run: usize, dash: Dash, points: &mut dyn Iterator<Item = (f64, f64)>| {
            let points = points.map(|(at, value)| (at * x.factor, value * y.factor)).collect();
            Line { name: name.to_owned(), color: color::run(run), dash, points }
        };
    let places = || free.x.iter().copied();
    let edge = |end: usize| free.band.iter().map(move |band| band[end]);
    let mut lines = vec![
        line("the free curve", 0, Dash::Solid, &mut places().zip(free.y.iter().copied())),
        line("95 %, low", 0, Dash::Dotted, &mut places().zip(edge(0))),
        line("95 %, high", 0, Dash::Dotted, &mut places().zip(edge(1))),
    ];
    if !free.formula.is_empty() {
        let mut points = free.formula.iter().map(|[x, y]| (*x, *y));
        lines.push(line("the formula", 1, Dash::Solid, &mut points));
    }
    let name = words::discover::variable(hypothesis, over, robot);
    let quantity = words::discover::quantity(hypothesis, robot);
    let plot = Plot {
        x_label: x.named(&name),
        y_label: if plain { y.unit.to_owned() } else { hypothesis.y_unit() },
        lines,
        marked: free
            .points
            .iter()
            .map(|p| Marked { x: p.x * x.factor, y: p.y * y.factor, error: p.error * y.factor })
            .collect(),
        wide: true,
        ..Plot::default()
    };
    let times = match hypothesis.times {
        "1" => String::new(),
        times => format!(", over {times}"),
    };
    Figure::new(format!("{quantity}{times}, over {name}"), plot)
}
