//! `trueweld study sensitivity`: which uncertain numbers a weld's figures follow from.
//!
//! The runs of the design may be kept in an evidence folder, resumed, and made in parts elsewhere, as
//! those of `certify`.

use super::sweep::{Sweep, SweepFolder};
use crate::inputs::{WeldArguments, check_length};
use crate::names::{ControllerParser, LawParser};
use crate::results::{Results, check_outputs, check_targets};
use clap::{Args, value_parser};
use miette::{Result, miette};
use std::path::PathBuf;
use std::slice;
use trueweld::{STEP_OF_MANY, read_input};
use trueweld_compensators::Entry;
use trueweld_evaluate::Requirements;
use trueweld_evaluate::study::{Input, SensitivityStudy, StudyRun, shortened};
use trueweld_output::StudySensitivityReport;
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::simulate::{Scenario, Seam, WeldProgram};

/// Arguments of `study sensitivity`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: WeldArguments,
    /// Compensation law, or several with + between them
    #[arg(long, value_name = "LAW", value_parser = LawParser, default_value = "none")]
    compensator: Entry,
    /// Hybrid force/position controller
    #[arg(long, value_parser = ControllerParser, default_value = ControllerKind::default().name())]
    controller: ControllerKind,
    /// Requirements, which say what is uncertain (default: those of the lap weld)
    #[arg(long, value_name = "F")]
    requirements: Option<PathBuf>,
    /// Length to weld, from the start of the seam, in metres; a whole seam is welded where it is shorter
    #[arg(long, value_name = "M", default_value_t = 0.3, allow_negative_numbers = true)]
    length: f64,
    /// Rows of the design: each has a run for every input and two more
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = value_parser!(u64).range(8..=100_000))]
    rows: u64,
    /// The margins of the loop in the middle of the seam as well
    #[arg(long)]
    margins: bool,
    /// Seed of the design
    #[arg(long, value_name = "N", default_value_t = 1)]
    draws: u64,
    #[command(flatten)]
    sweep: SweepFolder,
    #[command(flatten)]
    results: Results,
}

/// Where the page goes if the user does not say.
const PAGE: &str = "out/study-sensitivity.html";

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let mut results = arguments.results.clone();
    arguments.sweep.check(&results)?;
    if arguments.sweep.shard.is_none() {
        results.forms = results.forms.or_page(PAGE);
    }
    check_targets(&results.outputs())?;
    let length = arguments.length;
    check_length(length)?;
    let mut files = Vec::new();
    let requirements: Requirements = read_input(arguments.requirements.as_deref(), &mut files)?;
    let mut inputs = arguments.files.read()?;
    inputs.must_bear_push("study")?;
    inputs.weld = shortened(&inputs.weld, length);
    let length = Seam::of(&inputs.weld).length;
    if WeldProgram::Weld.steady(&inputs.weld, &Seam::of(&inputs.weld)).is_none() {
        return Err(inputs.too_short());
    }
    let assumed = requirements
        .uncertain_cell(&inputs.robot, &inputs.planned, &inputs.sensors)
        .map_err(|error| miette!("{error}"))?;
    let uncertain = inputs.measured(&assumed)?.unwrap_or(assumed);
    let of = Input::of(&uncertain);
    if of.is_empty() {
        return Err(miette!(
            help = "Give half widths above 0 in [uncertainty], or [[uncertain]] tables.",
            "the requirements call nothing uncertain; expected something that figures could follow from"
        ));
    }
    let (controller, law) = (arguments.controller, &arguments.compensator);
    let scenario = Scenario {
        plant_step: STEP_OF_MANY,
        ..inputs.scenario(WeldProgram::Weld, controller, law)
    };
    scenario.build_law().map_err(|error| inputs.failed(controller, &error))?;
    let study = SensitivityStudy {
        scenario,
        cell: inputs.nominal(&uncertain),
        seed: arguments.draws,
        rows: arguments.rows,
        margins: arguments.margins,
    };
    let mut simulation = inputs.simulation(&[controller], slice::from_ref(law), 1, STEP_OF_MANY);
    simulation.draws_seed = Some(arguments.draws);
    let margins = if arguments.margins { " --margins" } else { "" };
    let command = format!("study sensitivity --length {length} --rows {}{margins}", arguments.rows);
    let mut provenance = inputs.provenance(&command, simulation);
    provenance.files.extend(files);
    let mut outputs = results.outputs();
    let kept = arguments.sweep.files();
    outputs.extend(kept.iter().map(|path| ("--evidence", path.as_path())));
    check_outputs(&outputs)?;
    let all = study.runs(&of);
    let sweep = Sweep { provenance: &provenance, runs: all, results: &results };
    let is = |index: &u64, run: &StudyRun| run.index == *index;
    // A whole study has its derivatives as well.
    let more = if arguments.sweep.shard.is_some() { 0 } else { study.local_runs() };
    let Some((runs, progress)) =
        arguments.sweep.complete(&sweep, more, is, |index| study.run(*index, &of))?
    else {
        return Ok(());
    };
    let local = study.local(|done| progress.advance_to((all as usize + done) as f64));
    progress.finish();
    let global = study.global(of, &runs);
    if global.rows < 2 {
        let why = global.failed.unwrap_or_default();
        return Err(miette!(
            help = "Narrow what the requirements call uncertain, or choose another law or weld.",
            "no two rows of the design weld to their end: {why}"
        ));
    }
    let report = StudySensitivityReport {
        study: &study,
        length,
        runs: &runs,
        global: &global,
        local: &local,
        provenance: &provenance,
    };
    arguments.sweep.write(&report, &provenance, all)?;
    results.write(&report)
}
