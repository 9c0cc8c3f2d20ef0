//! Numbers that were identified, with intervals, and what shows whether the model fits.

use super::{PublishedResult, Report};
use crate::color::{Dash, run};
use crate::document::{
    Block, Column, Document, Medium, Picture, Plot, PlotLine, Table, TableCell, number, words,
};
use crate::json::identify::{IdentifyResult, StiffnessPlanResult};
use crate::text::identify::{
    expected, headline, is_misfit, joints_of, lead, linear, load, open, part, plan_headline,
    plan_setting, quantity, setting, with_interval,
};
use crate::text::{digits, fixed, score, share, signed_share};
use crate::{IdentifyReport, StiffnessPlanReport};
use std::f64::consts::TAU;
use trueweld_estimate::identify::{
    CurvePoint, IdentificationTarget, Mode, Number, Section, StiffnessCurve,
};

impl Report for IdentifyReport<'_> {
    const SCHEMA: &'static str = "identify/1";

    fn json(&self) -> impl PublishedResult {
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
        document.push(Block::List(open(self)));
        document.table("Modes, motors locked", self.modes());
        document.table("Parts of the welds", self.sections());
        document.push(Block::Note(setting(self)));
        let curves = found.curves.iter().map(|curve| self.curve(curve)).collect();
        document.figures("Stiffness over torque", curves);
        document.section(Medium::Page, "Correlation", Block::Table(self.correlation()));
        document.push(Block::List(crate::text::compare::notes(&found.notices)));
        document
    }
}

impl IdentifyReport<'_> {
    fn numbers(&self) -> Table {
        let found = self.found;
        let mut head =
            vec![words(""), number("given"), number("identified, 95 %"), number("change")];
        match found.target {
            IdentificationTarget::Stiffness => head.push(words("linear")),
            IdentificationTarget::Damping => head.push(number("by decrements alone, 95 %")),
            IdentificationTarget::Process => {}
        }
        Table { head: vec![head], rows: found.numbers.iter().map(|n| self.number_row(n)).collect() }
    }

    fn number_row(&self, n: &Number) -> Vec<TableCell> {
        let found = self.found;
        let joints = &self.model.robot.joint_names;
        let change = match n.interval {
            Some(_) if n.unit == "rad" || n.given.is_nan() || n.given == 0.0 => String::new(),
            Some(_) => signed_share(n.value / n.given - 1.0),
            None => "–".to_owned(),
        };
        let label = match (n.at.as_str(), found.target) {
            ("", _) => n.name.clone(),
            (at, IdentificationTarget::Process) => format!("{at}: {}", n.name),
            (at, _) => at.to_owned(),
        };
        let mut row = vec![
            words(label),
            match n.given.is_nan() && n.unit == "N·m/rad" {
                true => words("rigid"),
                false => number(quantity(n.given, n.unit)),
            },
            number(with_interval(n)).bad(!n.is_identifiable()),
            number(change),
        ];
        match found.target {
            IdentificationTarget::Stiffness => {
                let curve = found.curves.iter().find(|c| joints[c.joint] == n.at);
                let bent = curve.is_some_and(|c| !c.is_linear());
                row.push(words(linear(curve)).bad(bent));
            }
            IdentificationTarget::Damping => {
                let joint = joints.iter().position(|name| *name == n.at);
                let by = joint.and_then(|j| found.decrements[j]);
                row.push(number(by.map_or("–".to_owned(), |by| {
                    format!("{} ± {}", quantity(by.value, n.unit), share(by.half / by.value))
                })));
            }
            IdentificationTarget::Process => {}
        }
        row
    }

    fn modes(&self) -> Table {
        let names = &self.model.robot.joint_names;
        let hz = |rate: f64, places: usize| fixed(rate / TAU, places);
        let columns: [Column<'_, &Mode>; 7] = [
            (words("log"), &|m| words(m.log.clone())),
            (number("from M and K, Hz"), &|m| number(hz(m.natural, 2))),
            (number("seen, Hz"), &|m| {
                number(format!("{} ± {}", hz(m.frequency, 3), hz(m.frequency_half, 3)))
            }),
            (number("c = (2/T) ln(A₁/A₂), 1/s"), &|m| {
                number(format!("{} ± {}", digits(m.decay, 3), digits(m.decay_half, 2)))
            }),
            (number("from D, 1/s"), &|m| number(digits(m.fitted, 3))),
            (number("of critical"), &|m| number(share(m.ratio))),
            (words("energy in"), &|m| words(joints_of(m, names))),
        ];
        Table::of(&self.found.modes, &columns)
    }

    fn sections(&self) -> Table {
        let columns: [Column<'_, &Section>; 5] = [
            (words("log"), &|s| words(s.log.clone())),
            (words("part"), &|s| words(part(s))),
            (number("lasts"), &|s| number(format!("{} s", fixed(s.lasts, 1)))),
            (number("values"), &|s| number(s.samples.to_string())),
            (number("score"), &|s| number(score(s.score))),
        ];
        Table::of(&self.found.sections, &columns)
    }

    fn correlation(&self) -> Table {
        let numbers = &self.found.numbers[..self.found.correlation.nrows()];
        if numbers.len() < 2 {
            return Table::default();
        }
        let label = |n: &Number| if n.at.is_empty() { n.name.clone() } else { n.at.clone() };
        let head = std::iter::once(words("")).chain(numbers.iter().map(|n| number(label(n))));
        let cell = |i: usize, j: usize| match self.found.correlation[(i, j)] {
            value if value.is_finite() => number(fixed(value, 2)),
            _ => number("–"),
        };
        let row = |i: usize| {
            let cells = (0..numbers.len()).map(|j| cell(i, j));
            std::iter::once(words(label(&numbers[i]))).chain(cells).collect()
        };
        Table { head: vec![head.collect()], rows: (0..numbers.len()).map(row).collect() }
    }

    /// K(τ) with its interval, and the one number.
    fn curve(&self, curve: &StiffnessCurve) -> Picture {
        let joint = &self.model.robot.joint_names[curve.joint];
        let stiffness = self.found.model.robot.parameters.joints[curve.joint].stiffness;
        let ends = [curve.points.first(), curve.points.last()].map(|p| p.map_or(0.0, |p| p.torque));
        let points = |of: fn(&CurvePoint) -> f64| -> Vec<(f64, f64)> {
            let drawn = |value: f64| if value.is_finite() { value } else { f64::NAN };
            curve.points.iter().map(|p| (p.torque * 1e-3, drawn(of(p) * 1e-6))).collect()
        };
        let one = ends.map(|torque| (torque * 1e-3, stiffness * 1e-6)).to_vec();
        let lines = vec![
            PlotLine::new("over torque", run(0), points(|p| p.stiffness)),
            PlotLine::new("95 %, low", run(0), points(|p| p.interval[0])).dashed(Dash::Dotted),
            PlotLine::new("95 %, high", run(0), points(|p| p.interval[1])).dashed(Dash::Dotted),
            PlotLine::new("one number", run(1), one).dashed(Dash::Dashed),
        ];
        let plot = Plot {
            named: true,
            ..Plot::new("spring torque, kN·m", "stiffness, MN·m/rad", lines)
        };
        Picture {
            text: format!("Linear: {}.", linear(Some(curve))),
            ..Picture::new(joint.clone(), plot)
        }
    }
}

impl Report for StiffnessPlanReport<'_> {
    const SCHEMA: &'static str = "identify-plan/1";

    fn json(&self) -> impl PublishedResult {
        StiffnessPlanResult::of(self)
    }

    fn document(&self) -> Document {
        let mut document = Document::new("Plan", plan_headline(self), self.provenance);
        let joints = &self.model.robot.joint_names;
        let of = |deviations: &[f64], j: usize| number(expected(deviations[j]));
        let columns: [Column<'_, usize>; 3] = [
            (words(""), &|j| words(joints[*j].clone())),
            (number("planned, 95 %"), &|j| of(&self.plan.deviations, *j)),
            (number("picked by hand, 95 %"), &|j| of(&self.plan.by_hand_deviations, *j)),
        ];
        document.push(Block::Table(Table::of(0..joints.len(), &columns)));
        let degrees = |q: &trueweld_core::JointVector<f64>| {
            q.iter().map(|a| number(fixed(a.to_degrees(), 0))).collect::<Vec<_>>()
        };
        let row = |(k, planned): (usize, &trueweld_estimate::identify::plan::PlannedLoad)| {
            let mut row = vec![words((k + 1).to_string())];
            row.extend(degrees(&planned.posture));
            row.push(words(load(self, planned)));
            row
        };
        let mut head = vec![words("")];
        head.extend(joints.iter().map(|name| number(format!("{name}, °"))));
        head.push(words("load"));
        document.table(
            "The loads, in order",
            Table { head: vec![head], rows: self.plan.loads.iter().enumerate().map(row).collect() },
        );
        document.push(Block::Note(plan_setting(self)));
        document
    }
}
