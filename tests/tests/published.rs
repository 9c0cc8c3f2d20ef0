//! The figures of the published study (Bres et al. 2010): the step of 11 kN, and the two welds of
//! 2000 mm.

use nalgebra::SVector;
use trueweld_evaluate::{StepFigures, WeldFigures};
use trueweld_plant::simulate::{ControllerKind, WeldProgram};
use trueweld_tests::cell::{Fixtures, law};

fn step(controller: ControllerKind) -> StepFigures {
    let fixtures = Fixtures::of("published-vertical");
    let cell = fixtures.cell(&[]);
    let program = WeldProgram::ForceStep { height: 11e3, hold: 1.0, length: 3.0 };
    let recording = fixtures.run(&cell, program, controller, &law("none"), &fixtures.robot.robot);
    StepFigures::of(&recording, fixtures.weld.settle + 1.0, 11e3).expect("the step is recorded")
}

/// 5 % time within 10 % and overshoot within 3 points of what was published.
fn assert_published(figures: &StepFigures, settle: f64, overshoot: f64) {
    let time = figures.settle_5pct_s.expect("it settles");
    assert!(
        (time - settle).abs() <= 0.1 * settle,
        "{}: 5 % time {time} s, published {settle} s",
        figures.controller
    );
    let measured = figures.overshoot;
    assert!(
        (measured - overshoot).abs() <= 0.03,
        "{}: overshoot {measured}, published {overshoot}",
        figures.controller
    );
}

#[test]
fn parallel_control_answers_the_step_as_published() {
    let figures = step(ControllerKind::PARALLEL);
    assert_published(&figures, 0.370, 0.24);
    // "No static error": below what two of the sensor's standard deviations would show.
    assert!(figures.static_error_n.abs() < 50.0, "{figures:?}");
}

#[test]
fn superposed_control_answers_the_step_as_published() {
    let figures = step(ControllerKind::SUPERPOSED);
    assert_published(&figures, 0.580, 0.20);
    // "Near 200 N", sign not printed.
    assert!((figures.static_error_n.abs() - 200.0).abs() < 50.0, "{figures:?}");
}

#[test]
fn external_control_answers_the_step_as_published() {
    let figures = step(ControllerKind::EXTERNAL);
    assert_published(&figures, 0.860, 0.045);
    assert!(figures.static_error_n.abs() < 50.0, "{figures:?}");
    assert!(figures.ripple_n <= 50.0, "{figures:?}");
}

fn weld(name: &'static str, law_name: &str, stiffness_error: f64) -> WeldFigures {
    let fixtures = Fixtures::of(name);
    let cell = fixtures.cell(&[]);
    let controller_model = fixtures
        .robot
        .robot
        .with_stiffness_scaled(&SVector::from_element(1.0 + stiffness_error))
        .expect("a robot");
    let recording = fixtures.run(
        &cell,
        WeldProgram::Weld,
        ControllerKind::EXTERNAL,
        &law(law_name),
        &controller_model,
    );
    WeldFigures::of(&recording).expect("a steady part")
}

#[test]
fn first_weld_leaves_its_line_by_five_millimetres_and_holds_its_force() {
    let figures = weld("published-vertical", "none", 0.0);
    // "Up to 5 mm"; 5.1 mm by a quasi-static estimate of the same cell, plus the ripple on top.
    assert!((4.8e-3..5.4e-3).contains(&figures.lateral.max_abs), "{figures:?}");
    assert!((figures.force.mean - 18e3).abs() < 100.0, "{figures:?}");
    // "Most of the lateral deviation from the proximal joints"; axes 2 and 3 carry four fifths of
    // it.
    let proximal = figures.joint_share[1] + figures.joint_share[2];
    assert!((0.75..0.92).contains(&proximal), "{:?}", figures.joint_share);
}

#[test]
fn second_weld_holds_its_force_and_its_line() {
    let figures = weld("published-inclined", "none", 0.0);
    assert!((figures.force.mean - 18e3).abs() < 100.0, "{figures:?}");
    // The published envelope is wider than the first weld's where axes 4 and 6 fall in line. This
    // cell's tool never comes nearer to that than 27° (sin A5 = 0.46 at the start), and the
    // envelope stays below the first weld's.
    assert!(figures.force.envelope < 300.0, "{:?}", figures.force);
    assert!(figures.lateral.max_abs < 2e-3, "{figures:?}");
}

#[test]
fn elastostatic_compensation_keeps_the_first_weld_on_its_line_with_exact_stiffness() {
    let figures = weld("published-vertical", "elastostatic", 0.0);
    assert!(figures.lateral.rms < 0.15e-3, "{figures:?}");
    assert!(figures.tilt.rms < 0.05_f64.to_radians(), "{figures:?}");
}

#[test]
fn a_stiffness_error_passes_through_one_to_one() {
    // What is left is the share of the deflection that the law gets wrong: 1 − 1/(1 + error).
    let bare = weld("published-vertical", "none", 0.0).lateral.rms;
    for error in [-0.1, 0.1, 0.3] {
        let left = weld("published-vertical", "elastostatic", error).lateral.rms;
        let expected = bare * (1.0 - 1.0 / (1.0_f64 + error)).abs();
        assert!(
            (left - expected).abs() < 0.15 * expected + 0.05e-3,
            "{error}: {left} m, expected {expected} m"
        );
    }
}

#[test]
fn believing_in_a_robot_thirty_percent_too_soft_ends_in_a_bounded_limit_cycle() {
    // The law adds the deflection of the force it measures, and the material answers the motion
    // with force: a positive feedback whose gain is the believed over the real compliance. Above
    // one it swings until the authority holds it.
    let figures = weld("published-vertical", "elastostatic", -0.3);
    assert!(figures.limited_rows > 1000, "{figures:?}");
    assert!(figures.lateral.max_abs < 10e-3, "{figures:?}");
}

/// The last of so many passes of the first weld with a law that believes in a stiffness off by
/// `error`.
fn passes(law_name: &str, error: f64, passes: usize) -> WeldFigures {
    let fixtures = Fixtures::of("published-vertical");
    let cell = fixtures.cell(&[]);
    let controller_model = fixtures
        .robot
        .robot
        .with_stiffness_scaled(&SVector::from_element(1.0 + error))
        .expect("a robot");
    let law = law(law_name);
    let scenario = fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
    let scenario =
        trueweld_plant::simulate::Scenario { controller_model: &controller_model, ..scenario };
    let recording =
        trueweld_plant::simulate::run_passes(&scenario, passes, |_| {}).expect("the run ends");
    WeldFigures::of(&recording).expect("a steady part")
}

#[test]
fn feed_forward_is_off_by_its_stiffness_and_does_not_swing() {
    let exact = passes("feed-forward", 0.0, 1);
    assert!(exact.lateral.rms < 0.05e-3, "{exact:?}");
    let soft = passes("feed-forward", -0.3, 1);
    assert!((0.5e-3..2.0e-3).contains(&soft.lateral.rms), "{soft:?}");
    // The elastostatic law's limit cycle peaks at 1.7 times its mean square.
    assert!(soft.lateral.max_abs < 1.4 * soft.lateral.rms, "{soft:?}");
}

#[test]
fn the_observer_is_as_good_as_a_force_sensor() {
    let figures = passes("observer", 0.0, 1);
    assert!(figures.lateral.rms < 0.05e-3, "{figures:?}");
}

#[test]
fn a_seam_sensor_holds_the_line_whatever_the_stiffness() {
    for error in [-0.3, 0.3] {
        let figures = passes("seam-tracking", error, 1);
        assert!(figures.lateral.rms < 0.05e-3, "{error}: {figures:?}");
        let figures = passes("adaptive", error, 2);
        assert!(figures.lateral.rms < 0.03e-3, "{error}: {figures:?}");
    }
}

#[test]
fn push_and_encoders_tell_much_of_what_a_wrong_stiffness_leaves() {
    for error in [-0.3, 0.3] {
        let [planned, first, second] =
            [("feed-forward", 1), ("self-calibrating", 1), ("self-calibrating", 2)]
                .map(|(law, count)| passes(law, error, count).lateral.rms);
        // Of the joints that bend the tool aside A5 has no lever into the plate: a sixth of the
        // deviation stays.
        assert!(first < 0.55 * planned, "{error}: {first} of {planned}");
        assert!((0.15..0.45).contains(&(second / planned)), "{error}: {second} of {planned}");
    }
}

#[test]
fn a_law_that_learns_holds_the_line_in_its_second_pass() {
    for error in [-0.3, 0.3] {
        let figures = passes("learning", error, 2);
        assert!(
            figures.lateral.rms < 0.03e-3 && figures.lateral.max_abs < 0.2e-3,
            "{error}: {figures:?}"
        );
    }
}
