//! Laws side by side: what each depends on, and what it does not.

use nalgebra::Vector3;
use trueweld_compensators::library;
use trueweld_evaluate::WeldFigures;
use trueweld_evaluate::laws::{LawComparison, ScenarioChange};
use trueweld_plant::simulate::{ControllerKind, WeldProgram};
use trueweld_tests::cell::{Fixtures, law};

/// Figures of laws under changes, on six centimetres of the first published weld.
fn figures(points: &[(&str, ScenarioChange)]) -> Vec<WeldFigures> {
    let mut fixtures = Fixtures::of("vertical");
    fixtures.weld.end = fixtures.weld.start + Vector3::y() * 0.06;
    let cell = fixtures.cell(&[]);
    let none = law("none");
    let scenario = fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &none);
    let robot = &fixtures.robot.robot;
    let comparison =
        LawComparison { scenario, robot, stiffness_error: 0.2, laws: library(), passes: 2 };
    points
        .iter()
        .map(|(name, change)| comparison.point(&law(name), *change).expect("figures"))
        .collect()
}

#[test]
fn a_law_depends_on_no_sensor_that_it_does_not_read() {
    use ScenarioChange::{Lost, Noise};
    let law = "feed-forward";
    let all = figures(&[(law, Lost(0.0)), (law, Lost(1.0)), (law, Noise(0.25)), (law, Noise(8.0))]);
    // As text, in which what the weld has not got is equal to itself.
    assert_eq!(format!("{:?}", all[0]), format!("{:?}", all[1]));
    // What the force loop makes of the force sensor's noise: depth, and hardly anything beside the
    // seam.
    let (quiet, loud) = (all[2].lateral.rms, all[3].lateral.rms);
    assert!((quiet - loud).abs() < 0.01 * quiet, "{quiet} {loud}");
}

#[test]
fn seam_tracking_without_a_reading_is_feed_forward() {
    let all = figures(&[
        ("seam-tracking", ScenarioChange::Lost(1.0)),
        ("feed-forward", ScenarioChange::Lost(1.0)),
    ]);
    // But for the pace of the outer integral. Either makes up for what the encoders see, to
    // hundredths of a millimetre; what is left is what bends behind them.
    let [tracking, planned] = [0, 1].map(|k| all[k].lateral.rms);
    assert!((tracking - planned).abs() < 1e-5, "{tracking} {planned}");
    // And with them it is not.
    let seeing = figures(&[("seam-tracking", ScenarioChange::Lost(0.0))]);
    assert!(seeing[0].lateral.rms < 0.5 * all[1].lateral.rms);
}

#[test]
fn what_the_elastostatic_law_leaves_grows_with_the_error_of_the_stiffness() {
    let errors =
        [0.0, 0.1, 0.2, 0.3].map(|error| ("elastostatic", ScenarioChange::StiffnessError(error)));
    let left: Vec<f64> = figures(&errors).iter().map(|f| f.lateral.rms).collect();
    assert!(left.is_sorted_by(|a, b| 1.2 * a < *b), "{left:?}");
}

#[test]
fn what_was_learned_outlives_the_sensor() {
    let law = "learning";
    let all = figures(&[(law, ScenarioChange::Lost(1.0)), (law, ScenarioChange::DeadInLastPass)]);
    assert!(
        all[1].lateral.rms < 0.3 * all[0].lateral.rms,
        "{} {}",
        all[1].lateral.rms,
        all[0].lateral.rms
    );
}

#[test]
fn a_dead_force_sensor_does_not_take_the_tool_off_its_line() {
    // The depth is held, and what the seam sensor sees goes on being corrected; believed, a zero
    // would press the tool in by the limits of the force loop, and the drag with it.
    let law = "seam-tracking";
    let all = figures(&[(law, ScenarioChange::Lost(0.0)), (law, ScenarioChange::ForceSensorDies)]);
    assert!(all[0] != all[1] && all[1].lateral.max_abs < 0.2e-3, "{all:?}");
    assert!(all[1].force.error_rms < 2000.0, "{}", all[1].force.error_rms);
}
