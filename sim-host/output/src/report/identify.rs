//! Numbers that were identified, with intervals, and what shows whether the model fits.

use super::Report;
use crate::IdentifyReport;
use crate::color::{Dash, run};
use crate::document::{Block, Document, Figure, Line, Medium, Plot, Table, number, words};
use crate::json::IdentifyResult;
use crate::words::identify::{
    headline, is_misfit, lead, linear, open, quantity, setting, with_interval,
};
use crate::words::{fixed, signed_share};
use trueweld_identify::{StiffnessCurve, Target};

impl Report for IdentifyReport<'_> {
    type Json = IdentifyResult;

    fn json(&self) -> IdentifyResult {
        IdentifyResult::of(self)
    }

    fn document(&self) -> Document {
        let found = self.found;
        let mut document = Document::new("Identify", headline(found), self.provenance);
        if is_misfit(found) {
            document = document.judged("THE MODEL DOES NOT FIT", false);
        }
        document.push(Block::Lead(lead(found)));
        document.push(Block::Table(self.numbers()));
        document.push(Block::List(open(found)));
        document.push(Block::Note(setting(self)));
        let curves = found.curves.iter().map(|curve| self.curve(curve)).collect();
        document.section(Medium::Page, "Stiffness over torque", Block::Figures(curves));
        document.section(Medium::Page, "Correlation", Block::Table(self.correlation()));
        document.push(Block::List(crate::words::compare::notes(&found.notices)));
        document
    }
}

impl IdentifyReport<'_> {
    fn numbers(&self) -> Table {
        let found = self.found;
        let of_stiffness = found.target == Target::Stiffness;
        let mut head =
            vec![words(""), number("given"), number("identified, 95 %"), number("change")];
        if of_stiffness {
            head.push(words("linear"));
        }
        let joints = &self.model.robot.joint_names;
        let row = |n: &trueweld_identify::Number| {
            let change = match n.interval {
                Some(_) => signed_share(n.value / n.given - 1.0),
                None => "–".to_owned(),
            };
            let label = if n.at.is_empty() { &n.name } else { &n.at };
            let mut row = vec![
                words(label.clone()),
                number(quantity(n.given, n.unit)),
                number(with_interval(n)).bad(!n.is_identifiable()),
                number(change),
            ];
            if of_stiffness {
                let curve = found.curves.iter().find(|c| joints[c.joint] == n.at);
                let bent = curve.is_some_and(|c| !c.is_linear());
                row.push(words(linear(curve)).bad(bent));
            }
            row
        };
        Table { head: vec![head], rows: found.numbers.iter().map(row).collect() }
    }

    fn correlation(&self) -> Table {
        let numbers = &self.found.numbers;
        if numbers.len() < 2 {
            return Table::default();
        }
        let label = |n: &trueweld_identify::Number| {
            if n.at.is_empty() { n.name.clone() } else { n.at.clone() }
        };
        let mut head = vec![words("")];
        head.extend(numbers.iter().map(|n| number(label(n))));
        let row = |i: usize| {
            let mut row = vec![words(label(&numbers[i]))];
            row.extend((0..numbers.len()).map(|j| {
                let value = self.found.correlation[(i, j)];
                number(if value.is_finite() { fixed(value, 2) } else { "–".to_owned() })
            }));
            row
        };
        Table { head: vec![head], rows: (0..numbers.len()).map(row).collect() }
    }

    /// K(τ) with its interval, and the one number.
    fn curve(&self, curve: &StiffnessCurve) -> Figure {
        let joint = &self.model.robot.joint_names[curve.joint];
        let stiffness = self.found.model.robot.parameters.joints[curve.joint].stiffness;
        let ends = [curve.points.first(), curve.points.last()].map(|p| p.map_or(0.0, |p| p.torque));
        let line = |name: &str, color, dash, of: &dyn Fn(&trueweld_identify::CurvePoint) -> f64| {
            let points = curve.points.iter().map(|p| {
                let value = of(p) * 1e-6;
                (p.torque * 1e-3, if value.is_finite() { value } else { f64::NAN })
            });
            Line { name: name.to_owned(), color, dash, points: points.collect() }
        };
        let plot = Plot {
            x_label: "spring torque, kN·m".to_owned(),
            y_label: "stiffness, MN·m/rad".to_owned(),
            lines: vec![
                line("over torque", run(0), Dash::Solid, &|p| p.stiffness),
                line("", run(0), Dash::Dotted, &|p| p.interval[0]),
                line("", run(0), Dash::Dotted, &|p| p.interval[1]),
                Line {
                    name: "one number".to_owned(),
                    color: run(1),
                    dash: Dash::Dashed,
                    points: ends.map(|torque| (torque * 1e-3, stiffness * 1e-6)).to_vec(),
                },
            ],
            named: true,
            ..Plot::default()
        };
        Figure {
            text: format!("Linear: {}. Dotted: 95 %.", linear(Some(curve))),
            ..Figure::new(joint.clone(), plot)
        }
    }
}
