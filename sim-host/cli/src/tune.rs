//! `trueweld tune`: gains for a robot that is not ours, and the runs that confirm them.

use crate::inputs::CellArguments;
use crate::names::LawParser;
use crate::results::{Results, check_outputs, check_targets, write};
use clap::Args;
use miette::{IntoDiagnostic, Result, miette};
use std::path::PathBuf;
use trueweld::{PLANT_STEP, read_input};
use trueweld_compensators::{Entry, FeedForward, SeamTracking, Uncompensated, library};
use trueweld_evaluate::Requirements;
use trueweld_evaluate::tune::{AskedResponse, TuneError, TuneTask, tune};
use trueweld_output::{TuneReport, control_toml};
use trueweld_plant::cell::Cell;
use trueweld_plant::input::{Control, InputFile};
use trueweld_plant::sensors::sees_deviation;
use trueweld_plant::simulate::{ControllerKind, Scenario, WeldProgram};

/// Arguments of `tune`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Weld file (default: the first published sequence)
    #[arg(long, value_name = "F")]
    weld: Option<PathBuf>,
    /// Requirements file, for its margins (default: those of the lap weld)
    #[arg(long, value_name = "F")]
    requirements: Option<PathBuf>,
    /// Law that is to be confirmed beside the controllers; the others are tuned and told
    #[arg(long, value_name = "LAW", value_parser = LawParser)]
    compensator: Option<Entry>,
    /// Time after which a step of the push is to stay within 5 %, s
    #[arg(long, value_name = "S", default_value_t = 0.9)]
    settle: f64,
    /// Largest overshoot of the step, over its height
    #[arg(long, value_name = "SHARE", default_value_t = 0.25)]
    overshoot: f64,
    /// Height of the step in newtons (default: six tenths of the weld's push)
    #[arg(long, value_name = "N")]
    height: Option<f64>,
    #[command(flatten)]
    cell: CellArguments,
    /// Control file to write
    #[arg(long, value_name = "FILE", default_value = "out/control.toml")]
    out: PathBuf,
    #[command(flatten)]
    results: Results,
}

/// Largest static error after a step, over its height: the band in which it counts as settled.
const STATIC_ERROR: f64 = 0.05;

/// Share of the weld's push that the step is high.
const OF_PUSH: f64 = 0.6;

/// Runs the command. Its status is 1 where the runs do not confirm the gains.
pub(crate) fn run(arguments: &Arguments) -> Result<u8> {
    let response = |flag: &str, value: f64, most: f64| {
        let usable = value > 0.0 && value <= most;
        usable
            .then_some(value)
            .ok_or_else(|| miette!("{flag} {value}: expected a number above 0 and at most {most}"))
    };
    let settle = response("--settle", arguments.settle, 2.5)?;
    let overshoot = response("--overshoot", arguments.overshoot, 1.0)?;
    let mut outputs = arguments.results.outputs();
    outputs.push(("--out", &arguments.out));
    check_targets(&outputs)?;
    let mut files = Vec::new();
    let requirements: Requirements = read_input(arguments.requirements.as_deref(), &mut files)?;
    let margins = requirements.margins.as_ref().ok_or_else(|| {
        miette!(
            help = "Add a table [margins] with places and the least margins.",
            "the requirements ask for no margins; expected some, to tune by"
        )
    })?;
    let inputs = arguments.cell.read(arguments.weld.as_deref())?;
    inputs.must_bear_push("tune")?;
    check_outputs(&outputs)?;
    let height =
        response("--height", arguments.height.unwrap_or(OF_PUSH * inputs.weld.force), 1e6)?;
    let law = match &arguments.compensator {
        Some(law) => law.clone(),
        None => Entry::of::<SeamTracking<f64, FeedForward>>(),
    };
    // A law that this cell has no sensor for cannot be tuned in it; without any law each controller
    // welds.
    let none = Entry::of::<Uncompensated>();
    let usable = |law: &&Entry| {
        law.name() != none.name() && (!law.needs().seam_sensor || sees_deviation(&inputs.sensors))
    };
    let mut laws: Vec<Entry> = library().iter().filter(usable).cloned().collect();
    if laws.iter().all(|known| known.name() != law.name()) {
        laws.push(law.clone());
    }
    let still = inputs.planned.even();
    let seam = inputs.cell.seam.clone();
    let still = Cell::new(&inputs.robot.robot, &inputs.effects, &still, seam).into_diagnostic()?;
    let task = TuneTask {
        scenario: Scenario {
            plant_step: PLANT_STEP,
            ..inputs.scenario(WeldProgram::Weld, ControllerKind::EXTERNAL, &law)
        },
        still: &still,
        from_file: arguments.cell.states_control(),
        margins,
        response: AskedResponse { height, settle, overshoot, static_error: STATIC_ERROR },
        laws: &laws,
    };
    let progress = arguments.results.progress("tuning", 1.0);
    let tuning = tune(&task, |stage, share| progress.stage(stage, share)).map_err(|error| {
        let TuneError::Run(error) = error;
        inputs.failed(ControllerKind::EXTERNAL, &error)
    })?;
    progress.finish();
    let mut simulation = inputs.simulation(&ControllerKind::required(), &laws, 1, PLANT_STEP);
    simulation.force_step_n = Some(height);
    let mut provenance = inputs.provenance("tune", simulation);
    provenance.files.extend(files);
    let out = arguments.out.as_path();
    let report = TuneReport { tuning: &tuning, law: law.name(), out, provenance: &provenance };
    let text = control_toml(&report);
    // What is written is what was confirmed, and nothing that cannot be read again.
    let written = Control::parse(&text, &out.display().to_string())?;
    if written != tuning.control {
        return Err(miette!("{}: the gains are not as they were confirmed", out.display()));
    }
    write(out, &text)?;
    arguments.results.write(&report)?;
    Ok(if report.is_confirmed() { 0 } else { 1 })
}
