//! Samples of studies: a row for every weld, with what it was made of and what came of it.

use super::{BlockTable, ColumnValues};
use crate::text::study::layout::out_of_reach;
use crate::{StudyLayoutReport, StudySensitivityReport};
use std::borrow::Cow;
use trueweld_evaluate::study::{
    DesignPoint, PlacedPart, RatedPlacement, StudyRun, WAY_FIGURES, numbers,
};

/// Rows in one block.
const STUDY_BLOCK_ROWS: usize = 10_000;

/// Welds of a design: their place in it, the cell, and the figures.
pub(crate) fn of_study<'a>(report: &StudySensitivityReport<'a>) -> BlockTable<'a> {
    let inputs = report.global.inputs.len();
    let keys: Vec<&'static str> = report.study.figures().map(|figure| figure.key).collect();
    let cell = cell_columns(report.study.cell.uncertain.latent_names());
    let latents = report.study.cell.uncertain.latents();
    let numbers = ["run", "row", "column"].map(str::to_owned).into_iter().chain(cell);
    let numbers = numbers.chain(keys.clone().into_iter().map(str::to_owned));
    let blocks = report.runs.chunks(STUDY_BLOCK_ROWS).map(move |runs| {
        let failed = |run: &StudyRun| Cow::from(run.failed.clone().unwrap_or_default());
        let column =
            |of: &dyn Fn(&StudyRun) -> f64| ColumnValues::Numbers(runs.iter().map(of).collect());
        let place = |run: &StudyRun| DesignPoint::of(run.index, inputs);
        let mut block = vec![
            ColumnValues::Words(runs.iter().map(failed).collect()),
            column(&|run| run.index as f64),
            column(&|run| place(run).row as f64),
            column(&|run| place(run).column as f64),
        ];
        let of_cell = |k: usize| move |run: &StudyRun| cell_values(run).nth(k).unwrap_or(f64::NAN);
        block.extend((0..16 + latents).map(|k| column(&of_cell(k))));
        block.extend(keys.iter().map(|key| {
            column(&|run| {
                let value = run.figures.as_ref().and_then(|figures| figures.get(*key));
                value.copied().unwrap_or(f64::NAN)
            })
        }));
        block
    });
    BlockTable::new(["failed".to_owned()], numbers, blocks)
}

/// Names of the columns that say what a cell is.
fn cell_columns(latents: &[String]) -> impl Iterator<Item = String> + use<'_> {
    let stiffness = (1..=6).map(|joint| format!("stiffness_a{joint}"));
    let others = [
        "process_depth",
        "process_feed_drag",
        "process_lateral_damping",
        "process_lateral_stiffness",
        "process_lateral_ratio",
        "ripple_size",
        "ripple_phase_rad",
        "crosstalk_x",
        "crosstalk_y",
        "delay_periods",
    ];
    let plain = |name: &String| {
        let kept = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        name.chars().map(kept).collect::<String>()
    };
    stiffness.chain(others.map(str::to_owned)).chain(latents.iter().map(plain))
}

/// Their values.
fn cell_values(run: &StudyRun) -> impl Iterator<Item = f64> + '_ {
    let cell = &run.draw;
    let short = cell.stiffness.iter().chain(&cell.process).chain(&cell.ripple);
    let short = short.chain(&cell.crosstalk).chain(std::iter::once(&cell.delay));
    short.chain(&cell.latents).copied()
}

/// Placements of a grid: where, and what statics have of them.
pub(crate) fn of_layout<'a>(report: &StudyLayoutReport<'a>) -> BlockTable<'a> {
    let names = ["x_m", "y_m", "z_m", "turn_rad", "incline_rad", "roll_rad"];
    let keys = WAY_FIGURES.iter().map(|of| of.figure.key);
    let columns: Vec<&str> = names.into_iter().chain(keys).chain(["share"]).collect();
    let limiting = report.task.allowed;
    let blocks = report.grid.chunks(STUDY_BLOCK_ROWS).map(move |placed| {
        let words = |of: &dyn Fn(&RatedPlacement) -> String| {
            ColumnValues::Words(placed.iter().map(|placed| Cow::from(of(placed))).collect())
        };
        let mut block = vec![
            words(&|placed| {
                placed.outcome.as_ref().err().map_or(String::new(), |w| out_of_reach(*w))
            }),
            words(&|placed| {
                let of =
                    placed.outcome.as_ref().ok().map(|of| limiting[of.limiting().allowance].figure);
                of.map_or(String::new(), |figure| WAY_FIGURES[figure].figure.key.to_owned())
            }),
        ];
        let column = |of: &dyn Fn(&RatedPlacement) -> f64| {
            ColumnValues::Numbers(placed.iter().map(of).collect())
        };
        block.extend((0..6).map(|k| column(&|placed| numbers(&placed.placement)[k])));
        let value = |of: &dyn Fn(&PlacedPart) -> f64| {
            column(&|placed| placed.outcome.as_ref().map_or(f64::NAN, of))
        };
        block.extend((0..WAY_FIGURES.len()).map(|k| value(&|of| of.values[k])));
        block.push(value(&|of| of.limiting().share));
        block
    });
    BlockTable::new(["out_of_reach", "limiting"], columns, blocks)
}
