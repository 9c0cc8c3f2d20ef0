//! `trueweld weld`: a weld, with and without compensation, and how far the tool leaves its line.

use crate::certify::certificate;
use crate::inputs::{Files, Inputs, PLANT_STEP, STEP_OF_MANY, passes};
use crate::names::{Controller, LawParser};
use crate::results::{FormFiles, RecordedResults, Results, check_outputs, check_targets};
use clap::Args;
use miette::{Report, Result, miette};
use std::path::PathBuf;
use trueweld_compensators::{Elastostatic, Entry, Uncompensated};
use trueweld_evaluate::WeldFigures;
use trueweld_output::{WeldReport, WeldRun};
use trueweld_plant::simulate::{self, Recording, Scenario, Seam, WeldProgram};

/// Arguments of `weld`.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    files: Files,
    /// Hybrid force/position controller
    #[arg(long, value_enum, default_value_t = Controller::External)]
    controller: Controller,
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
    pub fn first_published() -> Self {
        let forms = FormFiles::default().or_page("out/weld.html");
        let results = RecordedResults {
            files: Results { forms, ..Results::default() },
            rrd: cfg!(feature = "rerun").then(|| PathBuf::from("out/weld.rrd")),
        };
        Self {
            files: Files::default(),
            controller: Controller::External,
            compensator: None,
            passes: 1,
            certificate: None,
            exaggeration: 50.0,
            results,
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    if !(arguments.exaggeration.is_finite() && arguments.exaggeration >= 1.0) {
        return Err(miette!(
            "--exaggeration {}: expected a number from 1 up",
            arguments.exaggeration
        ));
    }
    let outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    let inputs = arguments.files.read()?;
    let controller = arguments.controller.controller();
    let laws = match &arguments.compensator {
        None => vec![Entry::of::<Uncompensated>(), Entry::of::<Elastostatic<f64>>()],
        Some(law) => vec![law.clone()],
    };
    let passes = arguments.passes as usize;
    // Under a certificate the run is the one that was certified.
    let plant_step = if arguments.certificate.is_some() { STEP_OF_MANY } else { PLANT_STEP };
    let simulation = inputs.simulation(&[controller], &laws, passes, plant_step);
    let provenance = inputs.provenance("weld", simulation);
    let certificate = arguments.certificate.as_deref();
    let certificate = certificate
        .map(|path| Ok::<_, Report>((path, certificate::check(path, &provenance)?)))
        .transpose()?;
    check_outputs(&outputs)?;
    let recordings = simulate_all(&inputs, controller, &laws, plant_step, arguments)?;
    let figures = recordings
        .iter()
        .map(|r| WeldFigures::of(r).ok_or_else(|| inputs.too_short()))
        .collect::<Result<Vec<_>>>()?;
    if let Some((path, certificate)) = &certificate {
        figures.iter().try_for_each(|run| certificate::tell(path, certificate, run))?;
    }
    let runs: Vec<WeldRun<'_>> = recordings
        .iter()
        .zip(&figures)
        .map(|(recording, figures)| WeldRun { recording, figures, robot: &inputs.robot.robot })
        .collect();
    arguments.results.write(&WeldReport {
        runs: &runs,
        exaggeration: arguments.exaggeration,
        provenance: &provenance,
    })
}

/// One run a law, side by side on their own threads; the same bytes come out whatever their number.
fn simulate_all(
    inputs: &Inputs,
    controller: simulate::ControllerKind,
    laws: &[Entry],
    plant_step: f64,
    arguments: &Arguments,
) -> Result<Vec<Recording>> {
    let duration = WeldProgram::Weld.duration(&inputs.weld, &Seam::of(&inputs.weld));
    let passes = arguments.passes as usize;
    let progress = arguments.results.files.progress("welding", duration * passes as f64);
    let results: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = laws
            .iter()
            .enumerate()
            .map(|(k, law)| {
                let progress = (k == 0).then_some(&progress);
                let scenario =
                    Scenario { plant_step, ..inputs.scenario(WeldProgram::Weld, controller, law) };
                scope.spawn(move || {
                    simulate::run_passes(&scenario, passes, |time| {
                        if let Some(progress) = progress {
                            progress.advance_to(time);
                        }
                    })
                })
            })
            .collect();
        threads.into_iter().map(|t| t.join()).collect()
    });
    progress.finish();
    results
        .into_iter()
        .map(|joined| {
            joined
                .map_err(|_| miette!("a simulation thread stopped"))?
                .map_err(|error| inputs.failed(controller, &error))
        })
        .collect()
}
