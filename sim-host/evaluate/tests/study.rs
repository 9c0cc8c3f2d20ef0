//! Studies: placements, limits and the ways of the arm.

use crate::cell::{self, Fixtures, law};
use std::f64::consts::FRAC_PI_6;
use trueweld_core::JOINTS;
use trueweld_evaluate::study::{
    Allowance, ArmAlongSeam, Driven, LayoutTask, LimitStudy, Placement, PlacementRange, Range,
    RealArm, SEAM_PLACES, WAY_FIGURES, Workpiece, as_filed, confirm, numbers, pareto, shortened,
};
use trueweld_evaluate::{Limit, WELD_FIGURES};
use trueweld_plant::simulate::{ControllerKind, Scenario, Seam, WeldProgram};

/// The fixtures of a weld, and its seam as a part that stands in these ranges.
struct Shop {
    of: Fixtures,
    part: Workpiece,
    family: PlacementRange,
    allowed: Vec<Allowance>,
}

impl Shop {
    fn of(weld: &'static str, x: Range, z: Range) -> Self {
        let of = Fixtures::of(weld);
        let part = Workpiece::new(vec![of.weld.clone()]);
        let family = family(&part, x, z);
        let allowed = Allowance::usual(of.process.model.tool_diameter());
        Self { of, part, family, allowed }
    }

    fn task(&self) -> LayoutTask<'_> {
        LayoutTask {
            robot: &self.of.robot.robot,
            planned: &self.of.process,
            part: &self.part,
            family: &self.family,
            allowed: &self.allowed,
        }
    }
}

/// The same run at the step of studies.
fn coarse<'a>(scenario: &Scenario<'a>) -> Scenario<'a> {
    Scenario { plant_step: 2e-3, ..*scenario }
}

fn family(part: &Workpiece, x: Range, z: Range) -> PlacementRange {
    let mut ranges = numbers(&part.placement()).map(Range::at);
    ranges[0] = x;
    ranges[2] = z;
    PlacementRange(ranges)
}

#[test]
fn a_part_that_is_carried_about_the_axis_of_a1_is_worth_the_same() {
    let shop = Shop::of("inclined", Range::at(2.0), Range::at(0.5));
    let task = shop.task();
    let at = shop.part.placement();
    let (s, c) = FRAC_PI_6.sin_cos();
    let carried = Placement {
        x_m: c * at.x_m - s * at.y_m,
        y_m: s * at.x_m + c * at.y_m,
        turn_rad: FRAC_PI_6,
        ..at
    };
    let [here, there] = [at, carried].map(|at| task.place(&at, SEAM_PLACES[0]).expect("in reach"));
    for (k, of) in WAY_FIGURES.iter().enumerate() {
        // The angle to a limit counts A1's.
        if of.figure.key != "limit_min_rad" {
            let [a, b] = [here.values[k], there.values[k]];
            assert!((a - b).abs() <= 1e-6 * a.abs(), "{}: {a}, {b}", of.figure.key);
        }
    }
}

#[test]
fn the_optimiser_finds_what_a_grid_ten_times_as_fine_finds() {
    let [x, z] = [[1.3, 2.3], [0.3, 0.9]].map(|[low, high]| Range { low, high, step: 0.3 });
    let shop = Shop::of("vertical", x, z);
    let fine = family(&shop.part, Range { step: 0.03, ..x }, Range { step: 0.03, ..z });
    let task = shop.task();
    let found = task.best(&task.grid(|| {})).expect("in reach");
    let grid = LayoutTask { family: &fine, ..task }.grid(|| {});
    let best = grid.iter().filter_map(|placed| placed.outcome.as_ref().ok());
    let best = best.map(|placed| placed.cost()).fold(f64::INFINITY, f64::min);
    // The optimiser ends where a step brings less than 1e-4; its last look is closer than the grid's.
    assert!(found.cost() <= best * 1.005, "{} against {best}", found.cost());
    let within = |value: f64, range: Range| (range.low..=range.high).contains(&value);
    assert!(within(found.placement.x_m, x) && within(found.placement.z_m, z), "{found:?}");
    let reached: Vec<_> = grid.iter().filter_map(|placed| placed.outcome.as_ref().ok()).collect();
    let front = pareto(&reached, &[0, 3]);
    assert!(!front.is_empty() && front.len() < reached.len() / 4, "{}", front.len());
    for one in &front {
        let better = |other: &&&_| {
            let (a, b): (&trueweld_evaluate::study::PlacedPart, _) = (other, one);
            a.values[0] < b.values[0] && a.values[3] < b.values[3]
        };
        assert!(!reached.iter().any(|other| better(&other)), "{one:?}");
    }
}

#[test]
fn a_full_run_where_the_file_has_the_part_leaves_the_seam_as_statics_expect() {
    let shop = Shop::of("vertical", Range::at(1.7), Range::at(0.5));
    let (task, of) = (shop.task(), &shop.of);
    let (cell, law) = (of.cell(&[]), law("none"));
    let scenario = coarse(&of.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law));
    let arm = RealArm { robot: &of.robot.robot, effects: &[] };
    let placed = as_filed(&task).expect("in reach");
    let confirmed = confirm(&task, &scenario, &arm, &placed, std::slice::from_ref(&law), || {});
    let (figures, recording) = confirmed.welds[0].outcome.as_ref().expect("the run ends");
    // Statics leave out the memory of the material and the position loop's error.
    let share = figures.lateral.max_abs / placed.values[0];
    assert!((share - 1.0).abs() < 0.05, "{share}");
    assert!(confirmed.margins.is_ok_and(|margins| margins.len() == 9));
    // The arm is held to the branch: the same run as without being held.
    let free = trueweld_plant::simulate::run(&scenario, |_| {}).expect("the run ends");
    let last = |r: &trueweld_plant::simulate::Recording| r.rows.last().map(|row| row.link);
    assert_eq!(last(recording), last(&free));
}

#[test]
fn every_way_keeps_to_its_branch_and_within_the_ranges_of_the_joints() {
    let of = Fixtures::of("vertical");
    let robot = &of.robot.robot;
    let ways = ArmAlongSeam::all(robot, &of.process, &of.weld, 41).expect("in reach");
    assert!(ways.len() > 1);
    for way in &ways {
        let held = way.held(robot).expect("a robot");
        for at in &way.places {
            assert!(held.beyond_limits(&at.posture).is_none());
            let seam = Seam::of(&of.weld);
            let tool = robot.forward_kinematics(&at.posture);
            assert!(tool.error_to(&seam.nominal(at.path_m)).to_vector().amax() < 1e-9);
            let least = (0..JOINTS).map(|joint| {
                let [low, high] = robot.parameters().joints[joint].limits;
                (at.posture[joint] - low).min(high - at.posture[joint])
            });
            assert_eq!(at.to_limit, least.fold(f64::INFINITY, f64::min));
        }
    }
}

#[test]
fn the_edge_of_what_keeps_the_requirements_is_between_runs_that_do_and_do_not() {
    let mut of = Fixtures::of("vertical");
    of.weld = shortened(&of.weld, 0.06);
    let (cell, law) = (of.cell(&[]), law("none"));
    let figure = WELD_FIGURES.iter().find(|f| f.figure.key == "lateral_max_m").expect("a figure");
    let limit = Limit { figure: &figure.figure, value: 1.5e-3 };
    let study = LimitStudy {
        scenario: coarse(&of.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law)),
        arm: RealArm { robot: &of.robot.robot, effects: &[] },
        limits: &[limit],
        passes: 1,
    };
    let found = study.find(Driven::Force, [4e3, 30e3], || {});
    let largest = found.largest.expect("some push keeps it");
    let beyond = found.beyond.expect("some push does not");
    // Nine values evenly and six halvings between two of them.
    assert!(beyond.value - largest <= (30e3 - 4e3) / 8.0 / 64.0 * 1.001);
    let [kept, not] = [largest, beyond.value].map(|value| study.probe(Driven::Force, value));
    assert!(kept.is_kept() && !not.is_kept() && not.share < 1.02, "{kept:?} {not:?}");
    assert_eq!(found.kept_again, None);
    // Without a law the seam's own offset is deviation, one to one; what the load bends adds to it.
    let probe = |offset: f64| study.probe(Driven::Offset, offset).share * limit.value;
    assert!(((probe(-1e-3) - probe(0.0)).abs() - 1e-3).abs() < 5e-5);
    // Without a limit the weld must be the one that was asked for: a drive is below its limit.
    let (of, law) = (Fixtures::of("coupon"), cell::law("seam-tracking"));
    let cell = of.cell(&[]);
    let free = LimitStudy {
        scenario: coarse(&of.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law)),
        limits: &[],
        ..study
    };
    let [kept, saturated] = [18e3, 25e3].map(|push| free.probe(Driven::Force, push));
    assert!(kept.is_kept() && !saturated.is_kept(), "{kept:?} {saturated:?}");
    assert_eq!(saturated.figure.map(|figure| figure.key), Some("torque_share_max"));
    // No push keeps a limit of nothing.
    let none = LimitStudy { limits: &[Limit { value: 1e-12, ..limit }], ..study };
    assert_eq!(none.find(Driven::Force, [4e3, 8e3], || {}).largest, None);
}
