//! What a weld's figures depend on.

use crate::StudySensitivityReport;
use crate::color::{self, Rgb};
use crate::document::{Bar, Block, Document, Table, TableCell, number, words};
use crate::json::study::sensitivity::StudySensitivityResult;
use crate::report::{PublishedResult, Report};
use crate::samples::{self, BlockTable};
use crate::text::fixed;
use crate::text::study::sensitivity::{
    capital, derivative, headline, input, notices, setting, unit,
};
use trueweld_evaluate::study::{Derivative, SobolIndex, WithInterval};

/// Inputs in a table: what makes less is rarely told from nothing.
const SHOWN_INPUTS: usize = 8;

/// Share of a figure's variance from which an input stands in the overview.
const MATTERS: f64 = 0.03;

impl Report for StudySensitivityReport<'_> {
    const SCHEMA: &'static str = "study-sensitivity/1";

    fn json(&self) -> impl PublishedResult {
        StudySensitivityResult::of(self)
    }

    fn samples(&self) -> Option<BlockTable<'_>> {
        Some(samples::of_study(self))
    }

    fn document(&self) -> Document {
        let mut document = Document::new("Sensitivity", headline(self), self.provenance);
        document.push(Block::Note(setting(self)));
        document.push(Block::List(notices(self)));
        document.table("What each figure follows from: share of its variance, %", self.overview());
        for figure in self.study.figures() {
            let table = self.table(figure.key);
            let of = self.global.figures.iter().find(|f| f.figure.key == figure.key);
            let spread = of.map_or(String::new(), |f| {
                let [mean, deviation] = [f.mean, f.deviation].map(|v| unit(figure.key).quantity(v));
                format!(": {mean} ± {deviation}")
            });
            document.table(&format!("{}{spread}", capital(figure.label)), table);
        }
        document
    }
}

impl<'a> StudySensitivityReport<'a> {
    /// The inputs of a figure with their indices, the largest total first.
    pub(crate) fn ranked(&self, key: &str) -> Vec<(&'a str, SobolIndex)> {
        let Some(figure) = self.global.figures.iter().find(|f| f.figure.key == key) else {
            return Vec::new();
        };
        let names = self.global.inputs.iter().map(|input| input.name.as_str());
        let mut ranked: Vec<(&str, SobolIndex)> =
            names.zip(figure.indices.iter().copied()).collect();
        ranked.sort_by(|a, b| b.1.total.value.total_cmp(&a.1.total.value));
        ranked
    }

    /// The inputs of a figure with its derivatives, the largest first.
    pub(crate) fn derivatives(&self, key: &str) -> Vec<(&'a str, Option<Derivative>)> {
        let Some(figure) = self.local.figures.iter().find(|f| f.figure.key == key) else {
            return Vec::new();
        };
        let names = self.local.inputs.iter().map(|input| input.name.as_str());
        let mut all: Vec<_> = names.zip(figure.derivatives.iter().copied()).collect();
        let size = |of: &Option<Derivative>| of.map_or(f64::INFINITY, |d| d.value.abs());
        all.sort_by(|a, b| size(&b.1).total_cmp(&size(&a.1)));
        all
    }

    /// Every input that matters to some figure, and its total index of each.
    fn overview(&self) -> Table {
        let figures = &self.global.figures;
        let matters = |i: &usize| figures.iter().any(|f| f.indices[*i].total.value >= MATTERS);
        let mut inputs: Vec<usize> = (0..self.global.inputs.len()).filter(matters).collect();
        let most = |i: usize| figures.iter().map(|f| f.indices[i].total.value).fold(0.0, f64::max);
        inputs.sort_by(|a, b| most(*b).total_cmp(&most(*a)));
        let row = |i: usize| {
            let cells = figures.iter().map(|f| {
                let share = f.indices[i].total.value;
                number(percent(share)).shaded(shade(share))
            });
            std::iter::once(words(input(&self.global.inputs[i].name))).chain(cells).collect()
        };
        let head = figures.iter().map(|f| number(f.figure.label));
        Table {
            head: vec![std::iter::once(words("")).chain(head).collect()],
            rows: inputs.into_iter().map(row).collect(),
        }
    }

    /// The inputs that matter most to a figure: indices, and derivatives beside them.
    fn table(&self, key: &str) -> Table {
        let derivatives = self.derivatives(key);
        let ranked = self.ranked(key);
        let of_input = |name: &str| {
            let found = derivatives.iter().find(|(other, _)| *other == name);
            found.map_or("–".to_owned(), |(_, d)| derivative(key, *d))
        };
        let rows: Vec<Vec<TableCell>> = match ranked.is_empty() {
            true => derivatives
                .iter()
                .take(SHOWN_INPUTS)
                .map(|(name, d)| {
                    let mut row = vec![words(input(name))];
                    row.extend(vec![number("–"); 4]);
                    row.push(number(derivative(key, *d)));
                    row
                })
                .collect(),
            false => ranked
                .iter()
                .take(SHOWN_INPUTS)
                .map(|(name, index)| {
                    vec![
                        words(input(name)),
                        number(percent(index.total.value)).with_bar(Bar {
                            share: index.total.value,
                            mark: None,
                            color: color::run(1),
                        }),
                        number(interval(index.total)),
                        number(percent(index.first.value)),
                        number(interval(index.first)),
                        number(of_input(name)),
                    ]
                })
                .collect(),
        };
        let head = [
            words("input"),
            number("of the variance, %"),
            number("interval"),
            number("by itself, %"),
            number("interval"),
            number("per standard deviation"),
        ];
        Table { head: vec![head.to_vec()], rows }
    }
}

fn percent(share: f64) -> String {
    fixed(100.0 * share, 0)
}

fn interval(of: WithInterval) -> String {
    format!("{} to {}", percent(of.low), percent(of.high))
}

/// White for nothing, a strong colour for all of the variance.
fn shade(share: f64) -> Rgb {
    let share = share.clamp(0.0, 1.0);
    color::run(1).map(|full| (255.0 + share * (f64::from(full) - 255.0)) as u8)
}
