//! `trueweld study layout`: where to put a part, and the arm's posture there.

use super::grid::GridArgument;
use crate::inputs::CellArguments;
use crate::names::{ControllerParser, LawParser};
use crate::results::{RecordedResults, check_outputs, check_targets};
use clap::Args;
use miette::{Result, miette};
use std::path::{Path, PathBuf};
use trueweld::{PLANT_STEP, WeldingCell};
use trueweld_compensators::{Elastostatic, Entry, FeedForward, SeamTracking, Uncompensated};
use trueweld_evaluate::study::{
    Allowance, LayoutTask, OutOfReach, PlacedPart, PlacementRange, Range, RealArm, WAY_FIGURES,
    Workpiece, as_filed, confirm, numbers, pareto, way_figure,
};
use trueweld_output::{StudyLayoutReport, out_of_reach_in_words};
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::sensors::sees_deviation;
use trueweld_plant::simulate::{Scenario, WeldProgram};

/// Arguments of `study layout`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Weld file; several are seams of one part, which move together (default: the first published
    /// sequence)
    #[arg(long, value_name = "F")]
    weld: Vec<PathBuf>,
    #[command(flatten)]
    cell: CellArguments,
    /// Where the middle of the seams may be along x of B, in metres (default: 0.6 m to either side
    /// of where the file has it, by 0.1 m)
    #[arg(long, value_name = "LOW:HIGH:STEP", allow_hyphen_values = true)]
    x: Option<GridArgument>,
    /// Likewise along y (default: as the file has it)
    #[arg(long, value_name = "LOW:HIGH:STEP", allow_hyphen_values = true)]
    y: Option<GridArgument>,
    /// Likewise along z (default: from 0.3 m below to 0.9 m above the file's, by 0.1 m)
    #[arg(long, value_name = "LOW:HIGH:STEP", allow_hyphen_values = true)]
    z: Option<GridArgument>,
    /// Turn of the part about the vertical, in degrees (default: −90:90:30)
    #[arg(long, value_name = "LOW:HIGH:STEP", allow_hyphen_values = true)]
    turn: Option<GridArgument>,
    /// Inclination of the part about the first seam, in degrees (default: as the file has it)
    #[arg(long, value_name = "LOW:HIGH:STEP", allow_hyphen_values = true)]
    incline: Option<GridArgument>,
    /// Turn of the tool about its own axis, in degrees (default: as the robot's file has it)
    #[arg(long, value_name = "LOW:HIGH:STEP", allow_hyphen_values = true)]
    roll: Option<GridArgument>,
    /// What is allowed of a figure, such as torque_share=0.8; may be given several times
    #[arg(long, value_name = "FIGURE=VALUE")]
    allow: Vec<String>,
    /// Figures that the front is of, comma between them
    #[arg(
        long,
        value_name = "FIGURE,...",
        value_delimiter = ',',
        default_value = "lateral_max_m,torque_share,tilt_max_rad"
    )]
    front: Vec<String>,
    /// Law that the full runs are made with, beside those without (default: seam-tracking, where the cell
    /// has the sensor)
    #[arg(long, value_name = "LAW", value_parser = LawParser)]
    compensator: Option<Entry>,
    /// Hybrid force/position controller
    #[arg(long, value_parser = ControllerParser, default_value = ControllerKind::default().name())]
    controller: ControllerKind,
    #[command(flatten)]
    results: RecordedResults,
}

/// Where the page goes if the user does not say.
const PAGE: &str = "out/study-layout.html";

/// Most placements of a grid: an hour on two cores.
const MOST: usize = 2_000_000;

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let forms = arguments.results.files.forms.clone().or_page(PAGE);
    let files = crate::results::Results { forms, ..arguments.results.files.clone() };
    let results = RecordedResults { files, rrd: arguments.results.rrd.clone() };
    check_targets(&results.outputs())?;
    let front_of = arguments.front.iter().map(|key| figure(key)).collect::<Result<Vec<_>>>()?;
    let files: Vec<Option<&Path>> = match arguments.weld.as_slice() {
        [] => vec![None],
        files => files.iter().map(|f| Some(f.as_path())).collect(),
    };
    let inputs = files
        .into_iter()
        .map(|f| arguments.cell.files().read_anywhere(f))
        .collect::<Result<Vec<WeldingCell>>>()?;
    let first = &inputs[0];
    first.must_bear_push("study")?;
    let part = Workpiece::new(inputs.iter().map(|inputs| inputs.weld.clone()).collect());
    let family = arguments.family(&part)?;
    let mut allowed = Allowance::usual(2.0 * first.planned.model.lateral_tolerance());
    for text in &arguments.allow {
        allow(text, &mut allowed)?;
    }
    check_outputs(&results.outputs())?;
    let task = LayoutTask {
        robot: &first.controller_model,
        planned: &first.planned,
        part: &part,
        family: &family,
        allowed: &allowed,
    };
    let none = Entry::of::<Uncompensated>();
    let law = match &arguments.compensator {
        Some(law) => law.clone(),
        None if sees_deviation(&first.sensors) => Entry::of::<SeamTracking<f64, FeedForward>>(),
        None => Entry::of::<Elastostatic<f64>>(),
    };
    let mut laws = vec![none];
    if law.name() != laws[0].name() {
        laws.push(law);
    }
    let controller = arguments.controller;
    let scenario = Scenario {
        plant_step: PLANT_STEP,
        ..first.scenario(WeldProgram::Weld, controller, &laws[0])
    };
    for law in &laws {
        let built = Scenario { law, ..scenario }.build_law();
        built.map_err(|error| first.failed(controller, &error))?;
    }
    // A full run is worth some hundred placements.
    const RUN: usize = 400;
    let confirmed = 2 * (laws.len() * inputs.len() + 1);
    let total = family.count() + RUN * confirmed;
    let progress = results.files.progress("placing", total as f64);
    let grid = task.grid(|| progress.advance_by(1));
    let Some(best) = task.best(&grid) else {
        let far = |placed: &trueweld_evaluate::study::RatedPlacement| placed.outcome.clone().err();
        let farthest = grid.iter().filter_map(far).reduce(|a, b| if b.0 > a.0 { b } else { a });
        return Err(nowhere(grid.len(), farthest));
    };
    let arm = RealArm { robot: &first.robot.robot, effects: &first.effects };
    let confirmed = |placed: &PlacedPart| {
        confirm(&task, &scenario, &arm, placed, &laws, || progress.advance_by(RUN))
    };
    let filed = as_filed(&task).map(|placed| confirmed(&placed));
    let chosen = confirmed(&best);
    progress.finish();
    let reached: Vec<&PlacedPart> =
        grid.iter().filter_map(|placed| placed.outcome.as_ref().ok()).collect();
    let front = pareto(&reached, &front_of);
    let mut simulation = first.simulation(&[controller], &laws, 1, PLANT_STEP);
    simulation.welds = inputs.iter().map(|inputs| inputs.weld_name.clone()).collect();
    let mut provenance = first.provenance("study layout", simulation);
    for inputs in &inputs[1..] {
        let more = inputs.files.iter().filter(|file| !provenance.files.contains(file));
        let more: Vec<_> = more.cloned().collect();
        provenance.files.extend(more);
    }
    results.write(&StudyLayoutReport {
        task: &task,
        grid: &grid,
        front_of: &front_of,
        front: &front,
        filed: &filed,
        chosen: &chosen,
        provenance: &provenance,
    })
}

impl Arguments {
    fn family(&self, part: &Workpiece) -> Result<PlacementRange> {
        let own = numbers(&part.placement());
        let beside = |k: usize, below: f64, above: f64, step: f64| Range {
            low: own[k] - below,
            high: own[k] + above,
            step,
        };
        let degrees = |given: &Option<GridArgument>, usual: Range| {
            given.map_or(usual, |grid| grid.scaled(1f64.to_radians()))
        };
        let metres = |given: &Option<GridArgument>, usual: Range| {
            given.map_or(usual, |grid| grid.scaled(1.0))
        };
        let turn = Range { low: -90.0, high: 90.0, step: 30.0 };
        let turn = GridArgument(turn).scaled(1f64.to_radians());
        let family = PlacementRange([
            metres(&self.x, beside(0, 0.6, 0.6, 0.1)),
            metres(&self.y, Range::at(own[1])),
            metres(&self.z, beside(2, 0.3, 0.9, 0.1)),
            degrees(&self.turn, turn),
            degrees(&self.incline, Range::at(0.0)),
            degrees(&self.roll, Range::at(0.0)),
        ]);
        match family.count() {
            0 | 1 => Err(miette!(
                help = "Give a range to one of them at least, such as --x 1.4:2.4:0.1.",
                "--x, --y, --z, --turn, --incline and --roll leave one placement; expected several, to choose from"
            )),
            count if count > MOST => Err(miette!(
                help = "Take wider steps: the best placement is searched between them.",
                "the family has {count} placements; expected at most {MOST}"
            )),
            _ => Ok(family),
        }
    }
}

/// The place of a figure in the table, by its key.
fn figure(key: &str) -> Result<usize> {
    way_figure(key).map(|(k, _)| k).ok_or_else(|| {
        let all: Vec<&str> = WAY_FIGURES.iter().map(|of| of.figure.key).collect();
        miette!("{key}: there is no such figure of a placement; expected one of {}", all.join(", "))
    })
}

/// Changes what is allowed by `figure=value`.
fn allow(text: &str, allowed: &mut Vec<Allowance>) -> Result<()> {
    let (key, value) = text
        .split_once('=')
        .ok_or_else(|| miette!("--allow {text}: expected FIGURE=VALUE, as torque_share=0.8"))?;
    let figure = figure(key.trim())?;
    let limit: f64 = value.trim().parse().unwrap_or(f64::NAN);
    if !(limit > 0.0 && limit.is_finite()) {
        return Err(miette!("--allow {text}: expected a number above 0 behind the ="));
    }
    match allowed.iter_mut().find(|of| of.figure == figure) {
        Some(of) => of.limit = limit,
        None => allowed.push(Allowance { figure, limit }),
    }
    Ok(())
}

/// What to say where no placement is reached.
fn nowhere(count: usize, farthest: Option<OutOfReach>) -> miette::Report {
    let farthest = farthest
        .map_or(String::new(), |why| format!("; the farthest: {}", out_of_reach_in_words(why)));
    miette!(
        help = "Move the family nearer to the robot, or shorten the seam.",
        "none of the {count} placements is reached along the whole seam{farthest}"
    )
}
