//! A base that gives is a spring in series with the joints', in motion as at rest.

use crate::cell::KR500;
use crate::cell::support::{Fixtures, law};
use nalgebra::{Matrix6, Vector3};
use trueweld_core::{JointVector, Robot};
use trueweld_plant::effects::{Effect, EffectKind, Location};
use trueweld_plant::integrate::link_dynamics::{DynamicLinks, Motors};
use trueweld_plant::process::reaction;
use trueweld_plant::robot::{ElasticRobot, Ports};
use trueweld_plant::simulate::{ControllerKind, Phase, WeldProgram};

const COMPLIANCE: f64 = 1e-8;
const PERIOD: f64 = 1e-3;

fn arm() -> (ElasticRobot, Motors) {
    let effect = Effect {
        kind: EffectKind::of("base-compliance").unwrap(),
        at: Location::Cell,
        values: vec![COMPLIANCE],
    };
    let robot = ElasticRobot::with_effects(&KR500, &[effect], None).unwrap();
    // In the plane of x and z: the base leans about y alone.
    (robot, Motors::at_rest(JointVector::from([0.0, -1.0, 0.9, 0.0, 0.6, 0.0])))
}

#[test]
fn an_arm_on_a_base_that_gives_stands_still_where_it_starts() {
    let (robot, motors) = arm();
    let mut links = DynamicLinks::start(&robot, &motors, 0.0);
    let (link, tool) = (links.drives().link, links.frames(&robot, 0.0).tcp.position);
    for k in 1..=200 {
        links.advance(&robot, &motors, f64::from(k) * PERIOD, 1).unwrap();
    }
    // The start knows that gravity acts on an arm that leans by 0.2 mrad, the motion does not: of
    // joints that gravity bends by up to 3 mrad, 0.6 µrad.
    let moved = links.drives().link - link;
    assert!(moved.amax() < 6e-7, "{moved}");
    assert!((links.frames(&robot, 0.2).tcp.position - tool).amax() < 2e-6);
}

#[test]
fn it_swings_at_the_lowest_frequency_of_base_and_joints_together() {
    let (robot, motors) = arm();
    // The base as a joint of its own in place of A1, which does not move: the inertia and the
    // springs of all that swings.
    let mut parameters = KR500.parameters().clone();
    parameters.joints[0].axis = Vector3::y();
    let with_base = Robot::new(parameters).unwrap();
    let inertia = with_base.crba(&with_base.frames(&motors.angle));
    let mut stiffness = *KR500.stiffness();
    let lowest = |stiffness: &JointVector<f64>| {
        let half = inertia.cholesky().unwrap().l().try_inverse().unwrap();
        let modes = (half * Matrix6::from_diagonal(stiffness) * half.transpose()).symmetric_eigen();
        let k = modes.eigenvalues.imin();
        (modes.eigenvalues[k].sqrt(), half.tr_mul(&modes.eigenvectors.column(k).into_owned()))
    };
    stiffness[0] = 1e12;
    let (rigid, _) = lowest(&stiffness);
    stiffness[0] = 1.0 / COMPLIANCE;
    let (expected, mode) = lowest(&stiffness);
    assert!(expected < 0.95 * rigid, "{expected} {rigid}");

    // Struck in the shape of that mode: β̇ = θ̇ + M⁻¹ Lᵀ φ̇.
    let joints = KR500.crba(&KR500.frames(&motors.angle));
    let mut coupling = inertia.column(0).into_owned();
    coupling[0] = 0.0;
    let mut struck = joints.cholesky().unwrap().solve(&coupling) * mode[0] + mode;
    struck[0] = 0.0;
    let mut links = DynamicLinks::start(&robot, &motors, 0.0);
    let rest = links.drives().link[1];
    links.displace(&JointVector::zeros(), &(struck * (1e-3 / struck.amax())));
    let (mut crossings, mut before) = (Vec::new(), 0.0);
    for k in 1..=1500 {
        links.advance(&robot, &motors, f64::from(k) * PERIOD, 1).unwrap();
        let away = links.drives().link[1] - rest;
        if k > 1 && away * before < 0.0 {
            crossings.push((f64::from(k) - away / (away - before)) * PERIOD);
        }
        before = away;
    }
    let halves = (crossings.len() - 1) as f64;
    let measured = std::f64::consts::PI * halves / (crossings[crossings.len() - 1] - crossings[0]);
    // Gravity's own stiffness, 24 kN·m/rad of 10 MN·m/rad, and damping of 3 % change a frequency by
    // a thousandth; the inertia that no joint follows counts to first order.
    assert!((measured / expected - 1.0).abs() < 5e-3, "{measured} {expected} {rigid}");
}

#[test]
fn the_process_drags_on_a_tool_that_moves_as_fast_as_the_base_gives() {
    let mut fixtures = Fixtures::of("vertical");
    let along = (fixtures.weld.end - fixtures.weld.start).normalize();
    fixtures.weld.end = fixtures.weld.start + along * 0.02;
    fixtures.process = fixtures.process.even();
    let cell = fixtures.cell(&["base-compliance::compliance_rad_nm=2e-8"]);
    let none = law("none");
    let run = fixtures.run(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &none, &KR500);
    let (mut largest, mut drag) = (0.0_f64, 0.0_f64);
    for rows in run.rows.windows(3) {
        let [before, now, after] = rows else { panic!("three of them") };
        if now.phase != Phase::FeedRamp {
            continue;
        }
        let turn = now.axes.transpose();
        let velocity =
            turn * (after.real.position - before.real.position) / (after.time - before.time);
        let position = cell.seam.place(&now.real.position).position;
        let (process, ports) = (&fixtures.process, Ports::default());
        let at = reaction(process, &ports, now.time, &position, &velocity, position.y, 0.0);
        largest = largest.max((now.force_w.x - at.force.x).abs());
        drag = drag.max(at.force.x.abs());
    }
    assert!(drag > 2e3 && largest < 0.01 * drag, "{largest} of {drag} N");
}
