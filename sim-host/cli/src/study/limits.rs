//! `trueweld study limits`: the largest push, feed and offset of the seam that keep requirements.

use super::grid::GridArgument;
use crate::inputs::{WeldArguments, check_length, passes};
use crate::names::{ControllerParser, LawParser};
use crate::results::{Results, check_outputs, check_targets};
use clap::{Args, ValueEnum};
use miette::{Result, miette};
use std::path::PathBuf;
use std::slice;
use trueweld::{STEP_OF_MANY, read_input};
use trueweld_compensators::Entry;
use trueweld_evaluate::study::{
    ArmAlongSeam, Driven, LimitStudy, Placement, PlacementRange, Range, RealArm, Workpiece,
    numbers, shortened,
};
use trueweld_evaluate::{Limit, Requirements};
use trueweld_output::{LimitsAt, StudyLimitsReport};
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::simulate::{Scenario, Seam, WeldProgram};

/// Arguments of `study limits`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: WeldArguments,
    /// Compensation law, or several with + between them
    #[arg(long, value_name = "LAW", value_parser = LawParser, default_value = "seam-tracking")]
    compensator: Entry,
    /// Hybrid force/position controller
    #[arg(long, value_parser = ControllerParser, default_value = ControllerKind::default().name())]
    controller: ControllerKind,
    /// Requirements, whose [limits] are to be kept (default: those of the lap weld)
    #[arg(long, value_name = "F")]
    requirements: Option<PathBuf>,
    /// What is driven
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [What::Force, What::Feed, What::Offset])]
    what: Vec<What>,
    /// Largest push, in newtons (default: twice the weld's)
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    most_force: Option<f64>,
    /// Largest feed, in metres a second (default: three times the weld's); feeds along the seam change
    /// in proportion
    #[arg(long, value_name = "M/S", allow_negative_numbers = true)]
    most_feed: Option<f64>,
    /// Largest offset of the seam to either side, in metres (default: 0.01)
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    most_offset: Option<f64>,
    /// Length to weld, from the start of the seam, in metres (default: the whole seam)
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    length: Option<f64>,
    /// Places of the seam's middle along x of B besides its own, in metres
    #[arg(long, value_name = "LOW:HIGH:STEP", allow_hyphen_values = true)]
    x: Option<GridArgument>,
    /// Likewise along z
    #[arg(long, value_name = "LOW:HIGH:STEP", allow_hyphen_values = true)]
    z: Option<GridArgument>,
    /// Welds of one seam, the law kept; the last one counts
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = passes())]
    passes: u32,
    #[command(flatten)]
    results: Results,
}

/// What can be driven.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// The push
    Force,
    /// The speed along the seam
    Feed,
    /// The offset of the seam from where it was taught
    Offset,
}

/// Where the page goes if the user does not say.
const PAGE: &str = "out/study-limits.html";

/// Least share of push and feed that is looked at.
const LEAST: f64 = 0.2;

/// Most places.
const MOST_PLACES: usize = 1000;

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let mut results = arguments.results.clone();
    results.forms = results.forms.or_page(PAGE);
    check_targets(&results.outputs())?;
    let mut files = Vec::new();
    let requirements: Requirements = read_input(arguments.requirements.as_deref(), &mut files)?;
    let mut inputs = arguments.files.read()?;
    inputs.must_bear_push("study")?;
    if let Some(length) = arguments.length {
        check_length(length)?;
        inputs.weld = shortened(&inputs.weld, length);
    }
    let seam = Seam::of(&inputs.weld);
    if WeldProgram::Weld.steady(&inputs.weld, &seam).is_none() {
        return Err(inputs.too_short());
    }
    let asked = inputs.asked(&requirements, &files)?;
    // What is asked of every weld follows what is driven.
    let stated = |limit: &&Limit| asked.limits.contains(limit);
    let limits: Vec<Limit> = requirements.limits.iter().filter(stated).copied().collect();
    let ranges = arguments.ranges(&inputs.weld)?;
    check_outputs(&results.outputs())?;
    let (controller, law) = (arguments.controller, &arguments.compensator);
    let scenario = Scenario {
        plant_step: STEP_OF_MANY,
        ..inputs.scenario(WeldProgram::Weld, controller, law)
    };
    scenario.build_law().map_err(|error| inputs.failed(controller, &error))?;
    let part = Workpiece::new(vec![inputs.weld.clone()]);
    let (places, out_of_reach) = arguments.places(&part, &scenario)?;
    let study = LimitStudy {
        scenario,
        arm: RealArm { robot: &inputs.robot.robot, effects: &inputs.effects },
        limits: &limits,
        passes: arguments.passes as usize,
    };
    let runs: usize = ranges.iter().map(|(driven, _)| driven.runs()).sum();
    let total = places.len() * runs;
    let progress = results.progress("welding", total as f64);
    let count = || progress.advance_by(1);
    let at_place = |at: &Placement| {
        let weld = &part.welds_at(at)[0];
        let study = LimitStudy { scenario: Scenario { weld, ..study.scenario }, ..study };
        let find = |(driven, range): &(Driven, [f64; 2])| study.find(*driven, *range, count);
        LimitsAt { at: *at, limits: ranges.iter().map(find).collect() }
    };
    let places: Vec<LimitsAt> = places.iter().map(at_place).collect();
    progress.finish();
    let passes = arguments.passes as usize;
    let simulation = inputs.simulation(&[controller], slice::from_ref(law), passes, STEP_OF_MANY);
    let mut provenance = inputs.provenance("study limits", simulation);
    provenance.files.extend(files);
    results.write(&StudyLimitsReport {
        study: &study,
        length: seam.length,
        places: &places,
        out_of_reach,
        provenance: &provenance,
    })
}

impl Arguments {
    /// What is driven, and from where to where.
    fn ranges(&self, weld: &trueweld_plant::input::Weld) -> Result<Vec<(Driven, [f64; 2])>> {
        let all = [
            (What::Force, Driven::Force, "--most-force", self.most_force, 2.0 * weld.force),
            (What::Feed, Driven::Feed, "--most-feed", self.most_feed, 3.0 * weld.feed),
            (What::Offset, Driven::Offset, "--most-offset", self.most_offset, 0.01),
        ];
        let mut ranges = Vec::new();
        for (what, driven, flag, most, usual) in all {
            if !self.what.contains(&what) {
                if most.is_some() {
                    return Err(miette!(
                        "{flag}: this is not driven; expected it among --what, or not at all"
                    ));
                }
                continue;
            }
            let (most, least) = (most.unwrap_or(usual), LEAST * driven.nominal(weld));
            if !(most > least && most.is_finite() && most < 1e6) {
                return Err(miette!("{flag} {most}: expected a number above {least}"));
            }
            ranges.push((driven, [least, most]));
        }
        Ok(ranges)
    }

    /// The weld's own place, and those of the grid that the arm reaches; how many it does not.
    fn places(&self, part: &Workpiece, scenario: &Scenario<'_>) -> Result<(Vec<Placement>, usize)> {
        const POINTS: usize = 41;
        let own = part.placement();
        let range = |given: Option<GridArgument>, own: f64| {
            given.map_or(Range::at(own), |grid| grid.scaled(1.0))
        };
        let at = numbers(&own);
        let mut family = PlacementRange(at.map(Range::at));
        family.0[0] = range(self.x, own.x_m);
        family.0[2] = range(self.z, own.z_m);
        if family.count() > MOST_PLACES {
            return Err(miette!(
                "--x and --z ask for {} places; expected at most {MOST_PLACES}",
                family.count()
            ));
        }
        let asked = if self.x.is_none() && self.z.is_none() { vec![] } else { family.placements() };
        let is_reached = |at: &Placement| {
            let weld = &part.welds_at(at)[0];
            ArmAlongSeam::all(scenario.controller_model, scenario.planned, weld, POINTS).is_ok()
        };
        let count = asked.len();
        let grid: Vec<Placement> = asked.into_iter().filter(is_reached).collect();
        if count > 0 && grid.is_empty() {
            return Err(miette!(
                help = "Move them nearer to the robot, or shorten the seam with --length.",
                "none of the {count} places is reached along the whole seam"
            ));
        }
        let missed = count - grid.len();
        Ok((std::iter::once(own).chain(grid).collect(), missed))
    }
}
