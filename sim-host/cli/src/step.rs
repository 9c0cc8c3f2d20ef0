//! `trueweld step`: the published step of 11 kN at the start of the weld, with all three
//! controllers.

use crate::inputs::WeldArguments;
use crate::results::{RecordedResults, check_outputs, check_targets};
use clap::Args;
use miette::{Result, miette};
use std::slice;
use trueweld::{PLANT_STEP, checked_option};
use trueweld_compensators::{Entry, Uncompensated};
use trueweld_evaluate::StepFigures;
use trueweld_output::{StepReport, StepRun};
use trueweld_plant::simulate::{self, ControllerKind, WeldProgram};

/// Arguments of `step`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: WeldArguments,
    /// Height of the step in newtons
    #[arg(long, value_name = "N", default_value_t = 11_000.0, allow_negative_numbers = true)]
    height: f64,
    #[command(flatten)]
    results: RecordedResults,
}

/// Time from closing the force loop to the step, s.
const HOLD: f64 = 1.0;

/// Time recorded after the step, s.
const LENGTH: f64 = 3.0;

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let height = arguments.height;
    if !(height.is_finite() && height != 0.0) {
        return Err(miette!("--height {height}: expected a number of newtons other than 0"));
    }
    checked_option("--height", "force_n", height.abs())?;
    let outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    let inputs = arguments.files.read()?;
    check_outputs(&outputs)?;
    let at = inputs.weld.settle + HOLD;
    let program = WeldProgram::ForceStep { height, hold: HOLD, length: LENGTH };
    let none = Entry::of::<Uncompensated>();
    let whole = at + LENGTH;
    let total = ControllerKind::required().len() as f64 * whole;
    let progress = arguments.results.files.progress("stepping", total);
    let recordings = ControllerKind::required()
        .iter()
        .enumerate()
        .map(|(k, controller)| {
            let begin = k as f64 * whole;
            let scenario = inputs.scenario(program, *controller, &none);
            simulate::run(&scenario, |time| progress.advance_to(begin + time))
                .map_err(|error| inputs.failed(*controller, &error))
        })
        .collect::<Result<Vec<_>>>()?;
    progress.finish();
    let figures = recordings
        .iter()
        .map(|r| {
            StepFigures::of(r, at, height).ok_or_else(|| miette!("the run ended before the step"))
        })
        .collect::<Result<Vec<_>>>()?;
    let runs: Vec<StepRun<'_>> = recordings
        .iter()
        .zip(&figures)
        .map(|(recording, figures)| StepRun { recording, figures })
        .collect();
    let mut simulation =
        inputs.simulation(&ControllerKind::required(), slice::from_ref(&none), 1, PLANT_STEP);
    simulation.force_step_n = Some(height);
    let provenance = inputs.provenance("step", simulation);
    arguments.results.write(&StepReport { runs: &runs, at, height, provenance: &provenance })
}
