//! `trueweld compare-laws`: one weld with every compensation law, over a wrong stiffness, noise,
//! delay and a lost sensor.

use crate::inputs::{WeldArguments, passes};
use crate::names::{ControllerParser, LawParser};
use crate::results::{Results, check_outputs, check_targets};
use clap::Args;
use miette::Result;
use std::path::PathBuf;
use trueweld::{STEP_OF_MANY, read_input};
use trueweld_compensators::{Entry, library};
use trueweld_evaluate::Requirements;
use trueweld_evaluate::laws::{LawComparison, NoFigures};
use trueweld_output::LawsReport;
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::simulate::{Scenario, WeldProgram};

/// Arguments of `compare-laws`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: WeldArguments,
    /// Compensation laws, comma between them (default: all, without combinations)
    #[arg(long, value_delimiter = ',', value_name = "LAW,...", value_parser = LawParser)]
    laws: Vec<Entry>,
    /// Hybrid force/position controller
    #[arg(long, value_parser = ControllerParser, default_value = ControllerKind::default().name())]
    controller: ControllerKind,
    /// Welds of the seam for laws that learn from one to the next; the last one counts
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = passes())]
    passes: u32,
    /// Requirements, whose lateral limit is drawn (default: those of the lap weld)
    #[arg(long, value_name = "F")]
    requirements: Option<PathBuf>,
    #[command(flatten)]
    results: Results,
}

/// Where the page goes if the user does not say.
const PAGE: &str = "out/compare-laws.html";

/// Error of the stiffness believed in where the user gives none: within what is published of one
/// robot, and enough to tell laws apart that are one where the model is exact. Too stiff, since
/// laws fed by force swing where it is too soft.
const STIFFNESS_ERROR: f64 = 0.2;

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let mut results = arguments.results.clone();
    results.forms = results.forms.or_page(PAGE);
    check_targets(&results.outputs())?;
    let mut files = Vec::new();
    let requirements: Requirements = read_input(arguments.requirements.as_deref(), &mut files)?;
    let inputs = arguments.files.read()?;
    check_outputs(&results.outputs())?;
    let controller = arguments.controller;
    let laws = if arguments.laws.is_empty() { library() } else { &arguments.laws };
    let comparison = LawComparison {
        scenario: Scenario {
            plant_step: STEP_OF_MANY,
            ..inputs.scenario(WeldProgram::Weld, controller, &laws[0])
        },
        robot: &inputs.robot.robot,
        stiffness_error: arguments.files.cell.stiffness_error.unwrap_or(STIFFNESS_ERROR),
        laws,
        passes: arguments.passes as usize,
    };
    let progress = results.progress("welding", comparison.welds() as f64);
    let sweeps = comparison.run(|done| progress.advance_to(done as f64));
    progress.finish();
    let mut points = sweeps.iter().flat_map(|sweep| sweep.points.iter().flatten());
    if let (Some(Err(why)), true) = (points.next(), points.all(Result::is_err)) {
        return Err(match why {
            NoFigures::Run(error) => inputs.failed(controller, error),
            NoFigures::NotSteady => inputs.too_short(),
        });
    }
    let limit = requirements.limit("lateral_rms_m");
    let mut simulation = inputs.simulation(&[controller], laws, comparison.passes, STEP_OF_MANY);
    simulation.stiffness_error = comparison.stiffness_error;
    let mut provenance = inputs.provenance("compare-laws", simulation);
    provenance.files.extend(files);
    results.write(&LawsReport {
        comparison: &comparison,
        sweeps: &sweeps,
        limit,
        provenance: &provenance,
    })
}
