//! Links that swing faster than the step of their integration.

use crate::cell::{KR500, fixture};
use nalgebra::Matrix3;
use trueweld_core::{JointVector, Robot};
use trueweld_plant::input::{InputFile, RobotFile};
use trueweld_plant::integrate::link_dynamics::{DynamicLinks, Motors};
use trueweld_plant::integrate::{FastestMode, substeps};
use trueweld_plant::robot::ElasticRobot;

/// Time between two states of the motors, and the step that is usual, s.
const PERIOD: f64 = 4e-3;
const STEP: f64 = 2e-3;

/// The KR 210 without its tool, and what is stiff and damped at A6 times as much as in its file.
fn without_tool(stiffness: f64, damping: f64) -> ElasticRobot {
    let file = RobotFile::read(fixture("robots/kr210-fsw.toml")).expect("the robot is in order");
    let mut parameters = file.parameters;
    parameters.tool.mass = 0.0;
    parameters.tool.inertia = Matrix3::zeros();
    parameters.joints[5].stiffness *= stiffness;
    parameters.joints[5].damping *= damping;
    let robot = Robot::new(parameters).expect("a robot");
    ElasticRobot::with_effects(&robot, &[], None).expect("a robot without effects")
}

/// A motion from rest to rest in three seconds.
fn motors(time: f64) -> Motors {
    let start = JointVector::from([20.0, -50.0, 95.0, 0.0, 45.0, 0.0]).map(f64::to_radians);
    let way = JointVector::from([20.0, 10.0, 10.0, 40.0, -75.0, 40.0]).map(f64::to_radians);
    let s = time / 3.0;
    let place = s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
    let rate = 30.0 * s * s * (1.0 - s).powi(2) / 3.0;
    let acceleration = 60.0 * s * (1.0 - 3.0 * s + 2.0 * s * s) / 9.0;
    Motors { angle: start + way * place, rate: way * rate, acceleration: way * acceleration }
}

fn postures() -> impl Iterator<Item = JointVector<f64>> {
    (0..=20).map(|k| motors(f64::from(k) * 0.15).angle)
}

/// The links every period, so many steps to each.
fn followed(robot: &ElasticRobot, substeps: usize) -> Vec<JointVector<f64>> {
    let mut links = DynamicLinks::start(robot, &motors(0.0), 0.0);
    let of = |k: u32| {
        let time = f64::from(k) * PERIOD;
        links.advance(robot, &motors(time), time, substeps).map(|()| links.drives().link)
    };
    (1..=750).map(of).collect::<Result<_, _>>().expect("finite")
}

#[test]
fn a_light_wrist_follows_as_it_does_in_steps_ten_times_finer() {
    // Light; a stiff drive, nearly at the fastest mode that is followed; an overdamped one.
    for (stiffness, damping) in [(1.0, 1.0), (100.0, 1.0), (1.0, 8.0)] {
        let robot = without_tool(stiffness, damping);
        let needed = substeps(&robot, postures(), PERIOD, STEP).expect("followed");
        assert!(needed > 2, "{stiffness} {damping}");
        let (links, finer) = (followed(&robot, needed), followed(&robot, 10 * needed));
        for (k, (link, fine)) in links.iter().zip(&finer).enumerate() {
            // A hundredth of what an encoder resolves: no mode that the motors excite is fast.
            assert!((link - fine).amax() < 2e-8, "{stiffness} {damping}, row {k}: {}", link - fine);
        }
    }
}

#[test]
fn no_step_gives_energy_to_links_that_ring() {
    let robot = without_tool(1.0, 0.01);
    let held = Motors::at_rest(motors(0.0).angle);
    let needed = substeps(&robot, [held.angle], PERIOD, STEP).expect("followed");
    let mut links = DynamicLinks::start(&robot, &held, 0.0);
    // Struck where the fastest mode is.
    let mut struck = JointVector::zeros();
    struck[5] = 1.0;
    links.displace(&JointVector::zeros(), &struck);
    let rest = DynamicLinks::start(&robot, &held, 0.0);
    let [least, mut before] = [&rest, &links].map(|links| robot.energy(&links.drives()));
    let given = before - least;
    for k in 1..=500 {
        let time = f64::from(k) * PERIOD;
        links.advance(&robot, &held, time, needed).expect("finite");
        let energy = robot.energy(&links.drives());
        // The posture is that of the middle of a step.
        assert!(energy - before < 1e-3 * given, "{k}: {} of {given} J", energy - before);
        before = energy;
    }
    assert!(before - least < 0.5 * given, "{} of {given} J", before - least);
}

#[test]
fn arms_that_need_no_smaller_steps_keep_theirs_and_what_is_too_fast_is_named() {
    let robot = ElasticRobot::with_effects(&KR500, &[], None).expect("no effects");
    assert_eq!(substeps(&robot, postures(), PERIOD, STEP), Ok(2));

    // A single joint against its closed form: only A6 is light, and turns by itself.
    let light = without_tool(100.0, 1.0);
    let link = JointVector::zeros();
    let mode = FastestMode::of(&light, &link).expect("a mode");
    let inertia = light.model.crba(&light.model.frames(&link));
    let reduced = 1.0 / inertia.try_inverse().expect("positive definite")[(5, 5)];
    let alone = (light.model.stiffness()[5] / reduced).sqrt();
    assert_eq!((mode.joint, mode.damped), (5, false));
    assert!((mode.rate / alone - 1.0).abs() < 0.01, "{} {alone}", mode.rate);

    for (stiffness, damping, word) in
        [(1e4, 1.0, "stiffness_nm_rad"), (1.0, 1e5, "damping_nms_rad")]
    {
        let robot = without_tool(stiffness, damping);
        let error = substeps(&robot, postures(), PERIOD, STEP).expect_err("too fast").to_string();
        assert!(error.starts_with("joint 6 ") && error.contains(word), "{error}");
    }
}
