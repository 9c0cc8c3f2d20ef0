//! `trueweld study paper`: the published steps and welds beside the printed figures, and the push
//! near collinear axes 4 and 6.

use crate::inputs::CellArguments;
use crate::results::{Results, check_outputs, check_targets};
use clap::Args;
use miette::{Result, miette};
use rayon::prelude::*;
use std::slice;
use trueweld::{PLANT_STEP, WeldingCell};
use trueweld_compensators::{Entry, Uncompensated};
use trueweld_evaluate::study::{RealArm, centred, envelopes, reachable};
use trueweld_evaluate::{StepFigures, WeldFigures};
use trueweld_output::{StepRun, StudyPaperReport, WeldRun};
use trueweld_plant::simulate::{ControllerKind, Recording, WeldProgram, run as simulate};

/// Arguments of `study paper`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    cell: CellArguments,
    #[command(flatten)]
    results: Results,
}

/// Where the page goes if the user does not say.
const PAGE: &str = "out/study-paper.html";

/// Height of the published step, N, and time before and after it, s.
const HEIGHT: f64 = 11_000.0;
const HOLD: f64 = 1.0;
const AFTER: f64 = 3.0;

/// Length of the welds near collinear axes, m.
const LENGTH: f64 = 1.0;

/// Range of x of B in which they are put, m, and the step; and the places at which the inclined weld
/// is looked at besides.
const RANGE: [f64; 2] = [1.0, 3.2];
const STEP: f64 = 0.1;
const CLOSER: [f64; 3] = [2.65, 2.73, 2.76];

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let mut results = arguments.results.clone();
    results.forms = results.forms.or_page(PAGE);
    let outputs = results.outputs();
    check_targets(&outputs)?;
    let both = arguments.cell.files().read_published()?;
    check_outputs(&outputs)?;
    let none = Entry::of::<Uncompensated>();
    let scenario = |inputs: &'_ WeldingCell, program, controller| {
        simulate(&inputs.scenario(program, controller, &none), |_| {})
            .map_err(|error| inputs.failed(controller, &error))
    };
    let first = &both[0];
    let step = WeldProgram::ForceStep { height: HEIGHT, hold: HOLD, length: AFTER };
    let at = first.weld.settle + HOLD;
    // A weld moved along x, and where the arm reaches it.
    let moved = both.iter().map(|inputs| {
        let weld = centred(&inputs.weld, LENGTH);
        let scenario = inputs.scenario(WeldProgram::Weld, ControllerKind::EXTERNAL, &none);
        let distances = reachable(&scenario, &weld, RANGE, STEP);
        (weld, distances)
    });
    let (moved, mut distances): (Vec<_>, Vec<Vec<f64>>) = moved.unzip();
    if let Some(farthest) = distances[1].last().copied() {
        distances[1].extend(CLOSER.into_iter().filter(|x| *x < farthest));
        distances[1].sort_by(f64::total_cmp);
    }
    let runs = 7 + distances.iter().map(Vec::len).sum::<usize>();
    let progress = results.progress("welding", runs as f64);
    let steps = ControllerKind::required()
        .par_iter()
        .map(|controller| scenario(first, step, *controller))
        .collect::<Result<Vec<Recording>>>()?;
    progress.advance_by(3);
    let welds = both
        .par_iter()
        .map(|inputs| scenario(inputs, WeldProgram::Weld, ControllerKind::EXTERNAL))
        .collect::<Result<Vec<Recording>>>()?;
    progress.advance_by(4);
    let [vertical, inclined] = [0, 1].map(|k| {
        let inputs = &both[k];
        let arm = RealArm { robot: &inputs.robot.robot, effects: &inputs.effects };
        let scenario = inputs.scenario(WeldProgram::Weld, ControllerKind::EXTERNAL, &none);
        envelopes(&scenario, &arm, &moved[k], &distances[k], || progress.advance_by(1))
    });
    progress.finish();
    let short = || miette!("the runs are too short to have figures");
    let of_steps = steps.iter().map(|r| StepFigures::of(r, at, HEIGHT).ok_or_else(short));
    let of_steps = of_steps.collect::<Result<Vec<_>>>()?;
    let of_welds = welds.iter().map(|r| WeldFigures::of(r).ok_or_else(short));
    let of_welds = of_welds.collect::<Result<Vec<_>>>()?;
    let steps: Vec<StepRun<'_>> = steps
        .iter()
        .zip(&of_steps)
        .map(|(recording, figures)| StepRun { recording, figures })
        .collect();
    let robot = &first.robot.robot;
    let welds: Vec<WeldRun<'_>> = welds
        .iter()
        .zip(&of_welds)
        .map(|(recording, figures)| WeldRun::new(recording, figures, robot))
        .collect();
    let of = |inputs: &WeldingCell| {
        let mut simulation =
            inputs.simulation(&ControllerKind::required(), slice::from_ref(&none), 1, PLANT_STEP);
        simulation.force_step_n = Some(HEIGHT);
        inputs.provenance("study paper", simulation)
    };
    let mut provenance = of(first);
    provenance.join(&of(&both[1]));
    results.write(&StudyPaperReport {
        steps: &steps,
        at,
        height: HEIGHT,
        welds: &welds,
        envelopes: [&vertical, &inclined],
        length: LENGTH,
        provenance: &provenance,
    })
}
