//! What a weld's figures depend on: derivatives about the middle of what is not known of a cell, and
//! Sobol indices over all of it.
//!
//! Inputs are the numbers that requirements call uncertain, each in standard deviations of its own:
//! of an even distribution the half width over √3, of any other the standard normal behind it. All
//! cells have the same noise of the instruments, so that a figure is a function of the inputs.

use super::figures::{STUDY_FIGURES, asked, margins_asked};
use super::sobol::{DesignPoint, SobolIndex, indices};
use crate::certify::worst::{SHORT, cell_at, names};
use crate::certify::{FigureValues, NominalCell, SampledCell, values};
use crate::figure::Figure;
use crate::laws::NoFigures;
use crate::margins::OperatingPoint;
use crate::uncertain::UncertainCell;
use crate::weld::WeldFigures;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};
use trueweld_plant::random::Random;
use trueweld_plant::simulate::{Scenario, Seam};

/// Steps of the differences, standard deviations: the second checks the first.
const DIFFERENCE_STEPS: [f64; 2] = [0.5, 0.25];

/// Difference of both derivatives, over the larger, beyond which the figure has a kink or noise
/// there.
const SMOOTH: f64 = 0.2;

/// Share of the largest derivative below which a derivative is rounding.
const DERIVATIVE_ROUNDING: f64 = 0.01;

/// A study of what a weld's figures depend on.
#[derive(Debug, Clone, Copy)]
pub struct SensitivityStudy<'a> {
    /// The nominal scenario; its cell is not used.
    pub scenario: Scenario<'a>,
    /// What every cell is made from.
    pub cell: NominalCell<'a>,
    /// Seed of the design.
    pub seed: u64,
    /// Rows of the design.
    pub rows: u64,
    /// Whether the margins of the loop in the middle of the seam are figures as well.
    pub margins: bool,
}

/// One input: a number of the cell, or several that are moved together.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// Its name.
    pub name: String,
    /// Coordinates of the cell that it moves.
    coordinates: Vec<usize>,
}

/// One run of a study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StudyRun {
    /// Which.
    pub index: u64,
    /// The cell.
    pub draw: SampledCell,
    /// Its figures; none where the run came to no end.
    pub figures: Option<FigureValues>,
    /// Why there are none.
    pub failed: Option<String>,
}

/// The indices of one figure.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureIndices {
    /// Which.
    pub figure: &'static Figure,
    /// Its mean over the cells.
    pub mean: f64,
    /// Its standard deviation over the cells.
    pub deviation: f64,
    /// Of every input, in their order.
    pub indices: Vec<SobolIndex>,
}

/// Sobol indices of all figures.
#[derive(Debug, Clone, PartialEq)]
pub struct GlobalSensitivity {
    /// The inputs.
    pub inputs: Vec<Input>,
    /// The figures that vary.
    pub figures: Vec<FigureIndices>,
    /// Rows that count.
    pub rows: usize,
    /// Rows left out since one of their runs came to no end.
    pub dropped: usize,
    /// Why such a run did not.
    pub failed: Option<String>,
}

/// The derivative of a figure by an input, per standard deviation of the input, in the figure's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Derivative {
    /// By the smaller step.
    pub value: f64,
    /// By the step twice as large.
    pub wider: f64,
    /// Both agree, or the derivative is small beside the figure's largest one.
    pub smooth: bool,
}

/// Derivatives of one figure.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureDerivatives {
    /// Which.
    pub figure: &'static Figure,
    /// Its value in the middle cell.
    pub value: f64,
    /// By every input; `None` where a run came to no end.
    pub derivatives: Vec<Option<Derivative>>,
}

/// Derivatives of all figures about the middle cell.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalSensitivity {
    /// The inputs, each a number by itself.
    pub inputs: Vec<Input>,
    /// The figures.
    pub figures: Vec<FigureDerivatives>,
    /// Why the middle cell has none.
    pub failed: Option<String>,
}

/// Most inputs that are looked at one by one; more are taken together by what they are of.
const ONE_BY_ONE: usize = 24;

impl Input {
    /// Every number of a cell that is not known exactly.
    pub fn numbers(uncertain: &UncertainCell) -> Vec<Self> {
        let names = names(uncertain);
        let coordinates = names.into_iter().enumerate().filter(|(k, _)| varies(uncertain, *k));
        coordinates.map(|(k, name)| Self { name, coordinates: vec![k] }).collect()
    }

    /// The same where they are few; else those of one effect, of the process, of the seam together.
    pub fn of(uncertain: &UncertainCell) -> Vec<Self> {
        let numbers = Self::numbers(uncertain);
        if numbers.len() <= ONE_BY_ONE {
            return numbers;
        }
        let mut groups: Vec<Self> = Vec::new();
        for number in numbers {
            let name = kind(&number.name);
            match groups.iter_mut().find(|group| group.name == name) {
                Some(group) => group.coordinates.extend(number.coordinates),
                None => groups.push(Self { name: name.to_owned(), ..number }),
            }
        }
        groups
    }

    /// How many numbers it moves.
    pub fn count(&self) -> usize {
        self.coordinates.len()
    }
}

/// What a number is of: the part of its name before its place or its key.
fn kind(name: &str) -> &str {
    let end = name.find(['.', ':', ' ']).unwrap_or(name.len());
    match &name[..end] {
        // A measured number stands behind this word.
        "measured" | "group" => name,
        kind => kind,
    }
}

/// Whether anything follows from a coordinate.
fn varies(uncertain: &UncertainCell, coordinate: usize) -> bool {
    let cell = |end: f64| {
        let mut at = vec![0.0; SHORT + uncertain.latents()];
        at[coordinate] = end;
        let draw = cell_of(uncertain, &at, 0);
        let values = uncertain.values(&draw.latents);
        (SampledCell { latents: Vec::new(), ..draw }, values)
    };
    cell(1.0) != cell(-1.0)
}

/// The cell at standard deviations of every coordinate from the middle.
fn cell_of(uncertain: &UncertainCell, at: &[f64], noise: u64) -> SampledCell {
    let share: Vec<f64> = at[..SHORT].iter().map(|v| v / 3.0_f64.sqrt()).collect();
    cell_at(uncertain, &share, at[SHORT..].to_vec(), noise)
}

impl SensitivityStudy<'_> {
    /// The figures that are asked for.
    pub fn figures(&self) -> impl Iterator<Item = &'static Figure> {
        asked(self.margins)
    }

    /// The cell of a run of the design.
    fn cell(&self, index: u64, inputs: &[Input]) -> SampledCell {
        let point = DesignPoint::of(index, inputs.len());
        let (mut at, other) = (self.sample(2 * point.row), self.sample(2 * point.row + 1));
        for (_, input) in inputs.iter().enumerate().filter(|(i, _)| point.of_second(*i)) {
            input.coordinates.iter().for_each(|k| at[*k] = other[*k]);
        }
        cell_of(self.cell.uncertain, &at, self.scenario.seed)
    }

    /// Coordinates of a cell, drawn from a stream of the seed.
    fn sample(&self, stream: u64) -> Vec<f64> {
        let mut random = Random::new(self.seed, stream);
        let even = 3.0_f64.sqrt();
        let coordinate = |k: usize| match k {
            k if k < SHORT => random.between(-even, even),
            _ => random.normal(),
        };
        (0..SHORT + self.cell.uncertain.latents()).map(coordinate).collect()
    }

    /// How many runs the design has.
    pub fn runs(&self, inputs: &[Input]) -> u64 {
        self.rows * (inputs.len() as u64 + 2)
    }

    /// One run of the design.
    pub fn run(&self, index: u64, inputs: &[Input]) -> StudyRun {
        self.of(index, self.cell(index, inputs))
    }

    /// The run of a cell.
    fn of(&self, index: u64, draw: SampledCell) -> StudyRun {
        let figures = self.cell.weld(&self.scenario, &draw, 1).map_err(NoFigures::from);
        let figures = figures.and_then(|recording| {
            let figures = WeldFigures::of(&recording).ok_or(NoFigures::NotSteady)?;
            let mut all = values(STUDY_FIGURES.iter(), &figures);
            if self.margins {
                let weld = self.scenario.weld;
                let at = OperatingPoint::steady(weld, 0.5 * Seam::of(weld).length);
                let margins = self.cell.margins(&self.scenario, &draw, &at)?;
                all.extend(margins_asked(&margins));
            }
            Ok(all)
        });
        let (figures, failed) = match figures {
            Ok(figures) => (Some(figures), None),
            Err(error) => (None, Some(error.to_string())),
        };
        StudyRun { index, draw, figures, failed }
    }

    /// The indices from all runs of the design, in their order.
    pub fn global(&self, inputs: Vec<Input>, runs: &[StudyRun]) -> GlobalSensitivity {
        let columns = inputs.len() + 2;
        let whole: Vec<&[StudyRun]> = runs
            .chunks_exact(columns)
            .filter(|row| row.iter().all(|run| run.figures.is_some()))
            .collect();
        let figures = self.figures().filter_map(|figure| {
            let value = |run: &StudyRun| run.figures.as_ref()?.get(figure.key).copied();
            let row = |row: &&[StudyRun]| row.iter().map(value).collect::<Option<Vec<f64>>>();
            let rows: Vec<Vec<f64>> = whole.iter().filter_map(row).collect();
            let ([mean, deviation], indices) = indices(&rows, self.seed)?;
            Some(FigureIndices { figure, mean, deviation, indices })
        });
        GlobalSensitivity {
            figures: figures.collect(),
            rows: whole.len(),
            dropped: runs.len() / columns - whole.len(),
            failed: runs.iter().find_map(|run| run.failed.clone()),
            inputs,
        }
    }

    /// How many runs the derivatives take.
    pub fn local_runs(&self) -> usize {
        1 + 2 * DIFFERENCE_STEPS.len() * Input::numbers(self.cell.uncertain).len()
    }

    /// Derivatives about the middle cell. `progress` is told how many runs are done.
    pub fn local(&self, progress: impl Fn(usize) + Sync) -> LocalSensitivity {
        let uncertain = self.cell.uncertain;
        let inputs = Input::numbers(uncertain);
        let middle = vec![0.0; SHORT + uncertain.latents()];
        let mut cells = vec![middle.clone()];
        for input in &inputs {
            for step in DIFFERENCE_STEPS.iter().flat_map(|step| [*step, -*step]) {
                let mut at = middle.clone();
                input.coordinates.iter().for_each(|k| at[*k] = step);
                cells.push(at);
            }
        }
        let done = AtomicUsize::new(0);
        let runs: Vec<StudyRun> = cells
            .par_iter()
            .map(|at| {
                let run = self.of(0, cell_of(uncertain, at, self.scenario.seed));
                progress(done.fetch_add(1, Ordering::Relaxed) + 1);
                run
            })
            .collect();
        let figures = self.figures().filter_map(|figure| {
            let value = |run: &StudyRun| run.figures.as_ref()?.get(figure.key).copied();
            let around = runs[1..].chunks_exact(2 * DIFFERENCE_STEPS.len());
            let of_input = |runs: &[StudyRun]| {
                let [wider, narrower] = [0, 1].map(|k| {
                    let [above, below] = [&runs[2 * k], &runs[2 * k + 1]].map(value);
                    Some((above? - below?) / (2.0 * DIFFERENCE_STEPS[k]))
                });
                Some([narrower?, wider?])
            };
            let slopes: Vec<Option<[f64; 2]>> = around.map(of_input).collect();
            let largest = slopes.iter().flatten().map(|s| s[0].abs()).fold(0.0, f64::max);
            let derivative = |[value, wider]: [f64; 2]| Derivative {
                value,
                wider,
                smooth: (value - wider).abs()
                    <= (SMOOTH * value.abs().max(wider.abs())).max(DERIVATIVE_ROUNDING * largest),
            };
            let derivatives = slopes.into_iter().map(|s| s.map(derivative)).collect();
            Some(FigureDerivatives { figure, value: value(&runs[0])?, derivatives })
        });
        LocalSensitivity { figures: figures.collect(), failed: runs[0].failed.clone(), inputs }
    }
}
