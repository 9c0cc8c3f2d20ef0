//! `trueweld weld`: a weld, with and without compensation, and how far the tool leaves its line.

use crate::certify::certificate;
use crate::inputs::{WeldArguments, passes};
use crate::names::{ControllerParser, LawParser};
use crate::results::{FormFiles, RecordedResults, Results, check_outputs, check_targets};
use clap::Args;
use miette::{Report, Result, miette};
use std::path::PathBuf;
use trueweld::{PLANT_STEP, STEP_OF_MANY, SimulatedWeld, simulate};
use trueweld_compensators::{Elastostatic, Entry, Uncompensated};
use trueweld_output::{WeldReport, WeldRun};
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::simulate::{Seam, WeldProgram};

/// Arguments of `weld`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: WeldArguments,
    /// Hybrid force/position controller
    #[arg(long, value_parser = ControllerParser, default_value = ControllerKind::default().name())]
    controller: ControllerKind,
    /// Compensation law, or several with + between them (default: a run without and a run with
    /// elastostatic)
    #[arg(long, value_name = "LAW", value_parser = LawParser)]
    compensator: Option<Entry>,
    /// Welds of the same seam one after another, the law kept from one to the next; the last one is
    /// reported
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = passes())]
    passes: u32,
    /// Certificate (certify.json) that this weld is made under: refused where it is of another cell, law
    /// or weld, does not pass, or this is not the weld that was asked for
    #[arg(long, value_name = "FILE", requires = "compensator")]
    certificate: Option<PathBuf>,
    /// Factor by which the recording exaggerates deviations
    #[arg(
        long,
        value_name = "X",
        default_value_t = 50.0,
        allow_negative_numbers = true,
        requires = "rrd"
    )]
    exaggeration: f64,
    #[command(flatten)]
    results: RecordedResults,
}

impl Arguments {
    /// The first published weld with and without compensation, written to `out/`.
    pub(crate) fn first_published() -> Self {
        let forms = FormFiles::default().or_page("out/weld.html");
        let results = RecordedResults {
            files: Results { forms, ..Results::default() },
            rrd: cfg!(feature = "rerun").then(|| PathBuf::from("out/weld.rrd")),
        };
        Self {
            files: WeldArguments::default(),
            controller: ControllerKind::default(),
            compensator: None,
            passes: 1,
            certificate: None,
            exaggeration: 50.0,
            results,
        }
    }
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    if !(arguments.exaggeration.is_finite() && arguments.exaggeration >= 1.0) {
        return Err(miette!(
            "--exaggeration {}: expected a number from 1 up",
            arguments.exaggeration
        ));
    }
    let outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    let inputs = arguments.files.read()?;
    let controller = arguments.controller;
    let laws = match &arguments.compensator {
        None => vec![Entry::of::<Uncompensated>(), Entry::of::<Elastostatic<f64>>()],
        Some(law) => vec![law.clone()],
    };
    let passes = arguments.passes as usize;
    // Under a certificate the run is the one that was certified.
    let plant_step = if arguments.certificate.is_some() { STEP_OF_MANY } else { PLANT_STEP };
    let simulation = simulate(&inputs).controller(controller).passes(passes).plant_step(plant_step);
    let simulation = laws.into_iter().fold(simulation, |simulation, law| simulation.law(law));
    let provenance = simulation.provenance();
    let certificate = arguments.certificate.as_deref();
    let certificate = certificate
        .map(|path| Ok::<_, Report>((path, certificate::check(path, &provenance)?)))
        .transpose()?;
    check_outputs(&outputs)?;
    let duration = WeldProgram::Weld.duration(&inputs.weld, &Seam::of(&inputs.weld));
    let progress = arguments.results.files.progress("welding", duration * passes as f64);
    let welds = simulation.on_progress(&|time| progress.advance_to(time)).run();
    progress.finish();
    let welds = welds?.runs;
    if let Some((path, certificate)) = &certificate {
        welds.iter().try_for_each(|weld| certificate::tell(path, certificate, &weld.figures))?;
    }
    let robot = &inputs.robot.robot;
    let runs: Vec<WeldRun<'_>> = welds
        .iter()
        .map(|SimulatedWeld { recording, figures }| WeldRun::new(recording, figures, robot))
        .collect();
    arguments.results.write(&WeldReport {
        runs: &runs,
        exaggeration: arguments.exaggeration,
        provenance: &provenance,
    })
}
