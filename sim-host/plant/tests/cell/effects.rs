//! Every effect of the library does in the plant what its equation says, can be seen by whoever
//! fits it, and leaves a weld that runs.

use crate::cell::support::{Fixtures, law};
use crate::cell::{KR500, fixture};
use nalgebra::{Matrix3, Vector3};
use trueweld_core::spatial::rotation_from_vector;
use trueweld_core::{Displacement, JointVector, Pose, Wrench};
use trueweld_plant::cell::{Cell, State};
use trueweld_plant::effects::library;
use trueweld_plant::input::{ModelFile, Weld};
use trueweld_plant::integrate::rest;
use trueweld_plant::process::reaction;
use trueweld_plant::robot::{Channel, Drives, Readings};
use trueweld_plant::simulate::{ControllerKind, RecordRow, RunError, Seam, WeldProgram, run};

/// One of each, at a joint where it matters in the first weld, of a size that a laboratory would
/// look for.
const ONE_OF_EACH: &[&str] = &[
    "stiffness-error:A3:relative=0.2",
    "damping-error:A2:relative=0.5",
    "nonlinear-stiffness:A4:gain=0.5,twist_rad=8e-4",
    "backlash:A5:half_gap_rad=2e-4",
    "hysteresis:A2:torque_nm=2400,twist_rad=1e-4",
    "joint-friction:A1:coulomb_nm=500,viscous_nms_rad=1000",
    "stribeck:A1:torque_nm=400,rate_rad_s=0.02",
    "asymmetric-friction:A2:torque_nm=300",
    "transmission-error:A1:amplitude_rad=1.6e-4,order=40,phase_rad=0.8",
    "wrist-coupling:A6:ratio=0.02",
    "bearing-tilt:A2:compliance_rad_nm=2e-8",
    "base-compliance::compliance_rad_nm=3e-9",
    "counterbalance-loss::loss=0.25",
    "payload-error::mass_kg=14,x_m=0.015,y_m=0.005,z_m=-0.01",
    "encoder-offset:A3:offset_rad=1e-4",
    "link-encoder-offset:A2:offset_rad=1e-4",
    "link-encoder-ripple:A2:amplitude_rad=1e-4,order=30,phase_rad=0.3",
    "tracker-registration::x_m=1e-4,y_m=-2e-4,z_m=3e-4,rx_rad=1e-4,ry_rad=2e-4,rz_rad=-1e-4",
    "thermal-drift::x_m=2e-4,y_m=-1e-4,z_m=3e-4,time_s=5",
    "force-crosstalk::fx_per_fz=0.012,fy_per_fz=-0.008",
    "force-offset::fx_n=50,fy_n=-80,fz_n=120",
    "channel-delay:wrench:delay_s=0.024",
    "process-stiffness-error::relative=0.3",
    "drag-error::relative=0.16",
    "thermal-softening::share=0.12,time_s=3",
    "feed-power-law::exponent=0.6",
    "advancing-side::ratio=0.03",
    "spindle-harmonic::order=3,axial=0.02,in_plane=0.05,phase_rad=0.4",
    "plate-waviness::amplitude_m=2e-4,length_m=0.05,phase_rad=0",
    "fixture-compliance::stiffness_n_m=5e7",
    "material-step::ratio=0.2,position_m=0.02",
    "load-friction:A2:ratio=0.1",
    "torque-ripple:A1:amplitude_nm=300,order=40,phase_rad=0.8",
    "torque-scale:A2:relative=0.1",
    "force-scale::relative=-0.05",
    "gravity-direction::rx_rad=5e-3,ry_rad=-3e-3",
    "geometry-error:A3:x_m=3e-4,y_m=-2e-4,z_m=1e-4,rx_rad=2e-4,ry_rad=3e-4,rz_rad=-1e-4",
    "torque-constant:A3:nm_per_unit=58,relative=0.1",
    "rotor-inertia-error:A2:relative=0.5",
    "friction-error:A2:coulomb=0.5,viscous=-0.2",
    "drive-compliance:A2:compliance_rad_nm=2e-8",
];

/// What the instruments that the weld's controller does not read would show of a row.
fn measured(cell: &Cell, row: &RecordRow) -> Readings {
    let mut readings = Readings {
        force: row.real.rotation.tr_mul(&(row.axes * row.force_w)),
        motor_torque: row.torque.into(),
        ..Readings::of(row.time, &row.motor, &row.link, &row.real)
    };
    cell.robot.ports.sense(&mut readings);
    readings
}

/// A weld of 40 mm, so that all effects show within seconds of simulated time.
fn short(name: &'static str) -> Fixtures {
    let mut fixtures = Fixtures::of(name);
    let along = (fixtures.weld.end - fixtures.weld.start).normalize();
    fixtures.weld = Weld { end: fixtures.weld.start + along * 0.04, settle: 0.5, ..fixtures.weld };
    fixtures
}

#[test]
fn there_is_one_of_each() {
    let tried: Vec<&str> = ONE_OF_EACH.iter().map(|e| e.split(':').next().unwrap_or("")).collect();
    let table: Vec<&str> = library().map(|k| k.id).collect();
    assert_eq!(tried, table);
}

#[test]
fn the_guide_has_every_effect_with_its_parameters() {
    let guide = include_str!("../../../../docs/effects.md");
    for kind in library() {
        let row = guide.lines().find(|line| line.starts_with(&format!("| `{}`", kind.id)));
        let row = row.unwrap_or_else(|| panic!("{} has no row", kind.id));
        for parameter in kind.parameters {
            assert!(row.contains(&format!("`{}`", parameter.name)), "{}: {row}", kind.id);
        }
    }
}

#[test]
fn every_effect_shows_in_a_weld_that_runs() {
    let fixtures = short("vertical");
    let program = WeldProgram::Weld;
    let go = |cell: &Cell| {
        fixtures
            .run(cell, program, ControllerKind::EXTERNAL, &law("none"), &fixtures.robot.robot)
            .rows
    };
    let bare_cell = fixtures.cell(&[]);
    let bare = go(&bare_cell);
    for effect in ONE_OF_EACH {
        let difference = |text: &str| -> f64 {
            let cell = fixtures.cell(&[text]);
            let rows = go(&cell);
            assert_eq!(rows.len(), bare.len(), "{text}: the weld must run to its end");
            // In units of an instrument's noise: tracker 30 µm, link encoder 5 µrad, torque 40 N·m,
            // force 25 N.
            let one = |a: &RecordRow, b: &RecordRow| {
                let (m, n) = (measured(&cell, a), measured(&bare_cell, b));
                let [encoders, torques] =
                    [(m.link_encoder, n.link_encoder), (m.motor_torque, n.motor_torque)]
                        .map(|(m, n)| JointVector::from(m) - JointVector::from(n));
                (m.tcp_position - n.tcp_position).norm() / 3e-5
                    + encoders.norm() / 5e-6
                    + torques.norm() / 40.0
                    + (a.force_sensed_w - b.force_sensed_w).norm() / 25.0
            };
            rows.iter().zip(&bare).map(|(a, b)| one(a, b)).sum::<f64>() / rows.len() as f64
        };
        let seen = difference(effect);
        assert!(seen > 0.05, "{effect}: {seen} noise levels; whoever fits it could not see it");
    }
}

fn drives() -> Drives {
    let link = JointVector::from([0.286, -0.932, 1.944, 0.1, 0.559, 0.286]);
    Drives {
        link,
        link_rate: JointVector::repeat(0.02),
        motor: link.add_scalar(6e-4),
        motor_rate: JointVector::repeat(0.03),
    }
}

/// τ_s of one joint with an effect, from K, D, twist and twist rate.
fn assert_spring(effect: &str, joint: usize, expected: impl Fn(f64, f64, f64, f64) -> f64) {
    let cell = Fixtures::of("vertical").cell(&[effect]);
    let torque = cell.robot.spring_torque(&drives(), &[0.5; 6]);
    let wanted = expected(KR500.stiffness()[joint], KR500.damping()[joint], 6e-4, 0.01);
    assert!(
        (torque[joint] - wanted).abs() < 1e-9 * wanted.abs(),
        "{effect}: {} N·m, expected {wanted}",
        torque[joint]
    );
    let bare = Fixtures::of("vertical").cell(&[]).robot.spring_torque(&drives(), &[0.5; 6]);
    assert_eq!((torque - bare).remove_row(joint).amax(), 0.0, "{effect}: other joints");
}

#[test]
fn spring_effects_follow_their_equations() {
    assert_spring("stiffness-error:A3:relative=0.2", 2, |k, d, x, v| 1.2 * k * x + d * v);
    assert_spring("damping-error:A2:relative=0.5", 1, |k, d, x, v| k * x + 1.5 * d * v);
    assert_spring("nonlinear-stiffness:A4:gain=0.5,twist_rad=8e-4", 3, |k, d, x, v| {
        k * x * (1.0 + 0.5 * (1.0 - (-(x / 8e-4_f64).powi(2)).exp())) + d * v
    });
    assert_spring("backlash:A5:half_gap_rad=2e-4", 4, |k, d, x, v| k * (x - 2e-4) + d * v);
    assert_spring("hysteresis:A2:torque_nm=2400,twist_rad=1e-4", 1, |k, d, x, v| {
        k * x + d * v + 2400.0 * 0.5
    });
    let encoder = drives().motor;
    assert_spring(
        "transmission-error:A1:amplitude_rad=1.6e-4,order=40,phase_rad=0.8",
        0,
        |k, d, x, v| k * (x + 1.6e-4 * (40.0 * encoder[0] + 0.8).sin()) + d * v,
    );
    assert_spring("wrist-coupling:A6:ratio=0.02", 5, |k, d, x, v| {
        k * (x + 0.02 * encoder[4]) + d * v
    });
    assert_spring("encoder-offset:A3:offset_rad=1e-4", 2, |k, d, x, v| k * (x + 1e-4) + d * v);
}

#[test]
fn hysteresis_turns_its_loop() {
    // dz/dδ = (1 − z sgn δ̇)/δh: from z = 0, loading by n δh leaves 1 − e⁻ⁿ, whatever the rate.
    let cell = Fixtures::of("vertical").cell(&["hysteresis:A2:torque_nm=2400,twist_rad=1e-4"]);
    for rate in [1e-3, -2e-3] {
        let mut z = [0.0; 6];
        let mut at = drives();
        at.motor_rate[1] = at.link_rate[1] + rate;
        let (steps, h) = (20_000, 3e-4 / rate.abs() / 20_000.0);
        for _ in 0..steps {
            let mut rates = [0.0; 6];
            cell.robot.internal_rates(&at, &z, &mut rates);
            z[0] += h * rates[0];
        }
        let expected = rate.signum() * (1.0 - (-3.0_f64).exp());
        assert!((z[0] - expected).abs() < 1e-3, "{} expected {expected}", z[0]);
    }
}

#[test]
fn friction_effects_follow_their_equations_and_give_their_slope() {
    let smoothing = KR500.parameters().friction.smoothing;
    type Equation = fn(f64, f64) -> f64;
    let cases: [(&str, usize, Equation); 3] = [
        ("joint-friction:A1:coulomb_nm=500,viscous_nms_rad=1000", 0, |v, s| {
            500.0 * (v / s).tanh() + 1000.0 * v
        }),
        ("stribeck:A1:torque_nm=400,rate_rad_s=0.02", 0, |v, s| {
            400.0 * (v / s).tanh() * (-(v / 0.02).powi(2)).exp()
        }),
        ("asymmetric-friction:A2:torque_nm=300", 1, |v, s| {
            if v > 0.0 { 300.0 * (v / s).tanh() } else { 0.0 }
        }),
    ];
    for (effect, joint, equation) in cases {
        let fixtures = Fixtures::of("vertical");
        let (cell, bare) = (fixtures.cell(&[effect]), fixtures.cell(&[]));
        for rate in [-0.03, -5e-4, 4e-4, 0.01, 0.05] {
            let friction = |cell: &Cell, rate: f64| {
                let mut at = drives();
                at.motor_rate[joint] = rate;
                cell.robot.friction(&at, joint, 0.0, &[], 0.0)
            };
            let gained = friction(&cell, rate).value - friction(&bare, rate).value;
            assert!(
                (gained - equation(rate, smoothing)).abs() < 1e-9,
                "{effect} at {rate}: {gained}"
            );
            let step = 1e-8;
            let slope = (friction(&cell, rate + step).value - friction(&cell, rate - step).value)
                / (2.0 * step);
            // Rounding of some hundred N·m over 2e-8 rad/s: 1e-5 of the slope's scale, c/smoothing.
            assert!(
                (friction(&cell, rate).slope - slope).abs() < 1e-5 * 1e6,
                "{effect} at {rate}: slope {slope}"
            );
        }
    }
}

#[test]
fn a_motor_gets_what_was_commanded_and_its_ripple_and_pays_for_its_load() {
    let fixtures = Fixtures::of("vertical");
    let at = drives();
    let state = {
        let mut state = State::at_rest(&at.link, &at.motor, 0.0);
        state.0.fixed_rows_mut::<6>(12).copy_from(&at.link_rate);
        state.0.fixed_rows_mut::<6>(18).copy_from(&at.motor_rate);
        state
    };
    let acceleration = |effects: &[&str]| {
        fixtures.cell(effects).evaluate(0.0, &state).rates.fixed_rows::<6>(18).into_owned()
    };
    let bare = acceleration(&[]);
    let rotor = KR500.rotor_inertia();
    let ripple = acceleration(&["torque-ripple:A1:amplitude_nm=300,order=40,phase_rad=0.8"]) - bare;
    let given = 300.0 * (40.0 * at.motor[0] + 0.8).sin();
    assert!((ripple[0] * rotor[0] - given).abs() < 1e-6, "{ripple}, {given} N·m");
    assert_eq!(ripple.remove_row(0).amax(), 0.0);
    let load = acceleration(&["load-friction:A2:ratio=0.1"]) - bare;
    let spring = fixtures.cell(&[]).robot.spring_torque(&at, &[0.0; 6])[1];
    let smoothing = KR500.parameters().friction.smoothing;
    let lost = 0.1 * spring.abs() * (at.motor_rate[1] / smoothing).tanh();
    assert!(lost > 100.0 && (load[1] * rotor[1] + lost).abs() < 1e-6, "{load}, {lost} N·m");
    assert_eq!(load.remove_row(1).amax(), 0.0);
}

/// dU/dq by central differences of a potential energy, N·m.
fn gravity_by_energy(
    q: &JointVector<f64>,
    energy: impl Fn(&JointVector<f64>) -> f64,
) -> JointVector<f64> {
    JointVector::from_fn(|i, _| {
        let (mut above, mut below) = (*q, *q);
        above[i] += 1e-4;
        below[i] -= 1e-4;
        (energy(&above) - energy(&below)) / 2e-4
    })
}

#[test]
fn gravity_turned_is_the_base_turned_the_other_way() {
    let fixtures = Fixtures::of("vertical");
    let q = drives().link;
    let model = fixtures.cell(&["gravity-direction::rx_rad=0.03,ry_rad=-0.02"]).robot.model;
    let torque = model.gravity_torque(&model.frames(&q));
    let mut by = Displacement::none();
    by.base.rotation = rotation_from_vector(&Vector3::new(-0.03, 0.02, 0.0));
    let expected =
        gravity_by_energy(&q, |q| KR500.potential_energy(&KR500.frames_displaced(q, &by)));
    // Differences over 2e-4 rad: 1e-8 of some 10 kN·m by curvature, 1e-7 N·m by rounding.
    assert!((torque - expected).amax() < 1e-2, "{torque} {expected}");
    // A1 carries nothing of gravity as long as it stands upright.
    assert!(torque[0].abs() > 100.0, "{torque}");
}

/// Tool in B, and potential energy of links and tool, by the chain of fixed transforms of the robot
/// file with a rigid motion behind one joint.
fn by_chain(q: &JointVector<f64>, joint: usize, off: &Pose<f64>) -> (Pose<f64>, f64) {
    let parameters = KR500.parameters();
    let shift = |position: Vector3<f64>| Pose { position, ..Pose::identity() };
    let weight = |mass: f64, at: Vector3<f64>| -mass * parameters.gravity.dot(&at);
    let (mut frame, mut energy) = (Pose::identity(), 0.0);
    for (i, link) in parameters.joints.iter().enumerate() {
        let turn = Pose { rotation: rotation_from_vector(&(link.axis * q[i])), ..Pose::identity() };
        frame = frame * shift(link.origin) * turn;
        if i == joint {
            frame = frame * *off;
        }
        energy += weight(link.mass, frame.transform_point(&link.center_of_mass));
    }
    let tool = &parameters.tool;
    let flange = frame * shift(tool.flange_offset);
    energy += weight(tool.mass, flange.transform_point(&tool.com_from_flange));
    let axes = Matrix3::from_columns(&[tool.y_axis.cross(&tool.z_axis), tool.y_axis, tool.z_axis]);
    (flange * Pose { rotation: axes, position: tool.tcp_from_flange }, energy)
}

#[test]
fn a_link_mounted_off_takes_tool_and_masses_with_it() {
    let fixtures = Fixtures::of("vertical");
    let off = Pose {
        rotation: rotation_from_vector(&Vector3::new(3e-3, -2e-3, 4e-3)),
        position: Vector3::new(2e-3, -3e-3, 1e-3),
    };
    let motion = "x_m=2e-3,y_m=-3e-3,z_m=1e-3,rx_rad=3e-3,ry_rad=-2e-3,rz_rad=4e-3";
    for (joint, name) in fixtures.robot.joint_names.iter().enumerate() {
        let model = fixtures.cell(&[&format!("geometry-error:{name}:{motion}")]).robot.model;
        for k in 0..10 {
            let q = JointVector::from_fn(|i, _| f64::from(k * 7 + i as i32 * 3).sin());
            let tool = model.forward_kinematics(&q);
            let (expected, _) = by_chain(&q, joint, &off);
            assert!((tool.position - expected.position).norm() < 1e-12, "{name}: {tool:?}");
            assert!((tool.rotation - expected.rotation).norm() < 1e-9, "{name}: {tool:?}");
            let nominal = KR500.forward_kinematics(&q).position;
            assert!((tool.position - nominal).norm() > 1e-3, "{name} moves the tool");
            let torque = model.gravity_torque(&model.frames(&q));
            let asked = gravity_by_energy(&q, |q| by_chain(q, joint, &off).1);
            assert!((torque - asked).amax() < 1e-2, "{name}: {torque} {asked}");
        }
    }
}

#[test]
fn frames_give_under_load_and_drift_with_time() {
    let fixtures = Fixtures::of("vertical");
    let q = drives().link;
    let push = Wrench { moment: Vector3::zeros(), force: Vector3::new(0.0, 0.0, 18e3) };
    let rigid = KR500.forward_kinematics(&q).position;
    let moved = |effect: &str, time: f64| {
        fixtures.cell(&[effect]).robot.frames(&q, &push, time).tcp.position - rigid
    };
    // A push upwards lifts the tool on a bearing or a base that gives.
    assert!(moved("bearing-tilt:A1:compliance_rad_nm=2e-8", 0.0).z > 1e-5);
    assert!(moved("base-compliance::compliance_rad_nm=3e-9", 0.0).z > 1e-5);
    let drift = moved("thermal-drift::x_m=2e-4,y_m=-1e-4,z_m=3e-4,time_s=5", 10.0);
    let expected = Vector3::new(2e-4, -1e-4, 3e-4) * (1.0 - (-2.0_f64).exp());
    assert!((drift - expected).norm() < 1e-12, "{drift}");
}

#[test]
fn counterbalance_and_payload_change_what_gravity_asks_for() {
    let fixtures = Fixtures::of("vertical");
    let q = drives().link;
    let bare = fixtures.cell(&[]);
    let none = Wrench::zero();
    let hold = |cell: &Cell| rest::under_wrench(cell, &q, &none).expect("rest");
    let lost = hold(&fixtures.cell(&["counterbalance-loss::loss=0.25"]));
    let more = 0.25 * KR500.counterbalance_torque(q[1]) / KR500.stiffness()[1];
    // The links hang by λ τ_cb/K further on A2; the rest is what the changed posture makes of
    // gravity.
    assert!(((lost - hold(&bare))[1] + more).abs() < 2e-2 * more.abs(), "{lost}");
    let heavy = fixtures.cell(&["payload-error::mass_kg=14,x_m=0.015,y_m=0.005,z_m=-0.01"]);
    let tool = heavy.robot.model.parameters().tool;
    let nominal = KR500.parameters().tool;
    assert_eq!(tool.mass, nominal.mass + 14.0);
    assert!(
        (tool.com_from_flange - nominal.com_from_flange - Vector3::new(0.015, 0.005, -0.01)).norm()
            < 1e-15
    );
}

#[test]
fn sensor_effects_follow_their_equations() {
    let fixtures = Fixtures::of("vertical");
    let truth = Readings {
        time: 3.0,
        encoder: [0.1; 6],
        link_encoder: [0.2; 6],
        motor_torque: [3e3; 6],
        force: Vector3::new(100.0, 200.0, -18e3),
        moment: Vector3::new(10.0, -20.0, 30.0),
        tcp_position: Vector3::new(1.7, -0.3, 0.5),
        tcp_rotation: Vector3::new(0.0, 3.1, 0.0),
    };
    let read = |effect: &str| {
        let mut readings = truth;
        fixtures.cell(&[effect]).robot.ports.sense(&mut readings);
        readings
    };
    assert!(
        (read("link-encoder-offset:A2:offset_rad=1e-4").link_encoder[1] - 0.2001).abs() < 1e-15
    );
    let ripple =
        read("link-encoder-ripple:A2:amplitude_rad=1e-4,order=30,phase_rad=0.3").link_encoder[1];
    assert!((ripple - 0.2 - 1e-4 * (30.0_f64 * 0.2 + 0.3).sin()).abs() < 1e-15);
    let crosstalk = read("force-crosstalk::fx_per_fz=0.012,fy_per_fz=-0.008").force;
    assert!((crosstalk - Vector3::new(100.0 - 216.0, 200.0 + 144.0, -18e3)).norm() < 1e-9);
    let offset = read("force-offset::fx_n=50,fy_n=-80,fz_n=120").force;
    assert!((offset - truth.force - Vector3::new(50.0, -80.0, 120.0)).norm() < 1e-9);
    let scaled = read("force-scale::relative=-0.04");
    assert!((scaled.force - truth.force * 0.96).norm() < 1e-9);
    assert!((scaled.moment - truth.moment * 0.96).norm() < 1e-9);
    let torque = read("torque-scale:A3:relative=0.1").motor_torque;
    assert_eq!(torque, [3e3, 3e3, 1.1 * 3e3, 3e3, 3e3, 3e3]);
    let turned = read("tracker-registration::x_m=0,y_m=0,z_m=1e-3,rx_rad=0,ry_rad=0,rz_rad=1e-3");
    let turn = rotation_from_vector(&Vector3::new(0.0, 0.0, 1e-3));
    assert!(
        (turned.tcp_position - turn * truth.tcp_position - Vector3::new(0.0, 0.0, 1e-3)).norm()
            < 1e-15
    );
    for (name, channel) in [
        ("tracker", Channel::Tracker),
        ("wrench", Channel::Wrench),
        ("torque", Channel::MotorTorque),
        ("link-encoder", Channel::LinkEncoder),
    ] {
        let cell = fixtures.cell(&[&format!("channel-delay:{name}:delay_s=0.004")]);
        for other in [Channel::Tracker, Channel::Wrench, Channel::MotorTorque, Channel::LinkEncoder]
        {
            assert_eq!(cell.robot.ports.delay(other), if other == channel { 0.004 } else { 0.0 });
        }
    }
}

#[test]
fn process_effects_follow_their_equations() {
    let fixtures = Fixtures::of("vertical");
    let (spindle_angle, time, x) = (0.3, 4.0, 0.13);
    let force = |effects: &[&str]| {
        let cell = fixtures.cell(effects);
        let (at, v) = (Vector3::new(x, 2e-4, 5e-4), Vector3::new(0.012, 1e-3, 2e-4));
        reaction(&cell.process, &cell.robot.ports, time, &at, &v, 1e-4, spindle_angle).force
    };
    let p = &fixtures.process;
    let number = |key: &str| p.number(key);
    let wave = |order: f64, phase: f64| (order * spindle_angle + phase).sin();
    let in_plane = 1.0 + p.ripple.iter().map(|r| r.in_plane * wave(r.order, r.phase)).sum::<f64>();
    let axial = 1.0 + p.ripple.iter().map(|r| r.axial * wave(r.order, r.phase)).sum::<f64>();
    // F by the equations of the baseline, with what an effect changes as arguments.
    let expected =
        |k_z: f64, c_x: f64, depth: f64, power: f64, extra: f64, give: f64, more: [f64; 2]| {
            let depth_force =
                (k_z * depth + number("depth_damping_ns_m") * 2e-4) / (1.0 + k_z * give);
            let e = depth_force / number("reference_force_n");
            let feed = c_x * 0.012 * e * 1.2_f64.powf(power - 1.0);
            let lateral = number("lateral_ratio") * feed * p.spindle.signum()
                + (number("lateral_damping_ns_m") * 1e-3 + number("lateral_stiffness_n_m") * 1e-4)
                    * e
                + extra * depth_force * p.spindle.signum();
            let (in_plane, axial) = (in_plane + more[1], axial + more[0]);
            -Vector3::new(feed * in_plane, lateral * in_plane, depth_force * axial)
        };
    let (k, c) = (number("depth_stiffness_n_m"), number("feed_drag_ns_m"));
    let plain = expected(k, c, 5e-4, 1.0, 0.0, 0.0, [0.0; 2]);
    let third = wave(3.0, 0.4);
    for (effect, wanted) in [
        ("", plain),
        (
            "process-stiffness-error::relative=0.3",
            expected(1.3 * k, c, 5e-4, 1.0, 0.0, 0.0, [0.0; 2]),
        ),
        ("drag-error::relative=0.16", expected(k, 1.16 * c, 5e-4, 1.0, 0.0, 0.0, [0.0; 2])),
        (
            "thermal-softening::share=0.12,time_s=3",
            plain * (1.0 - 0.12 * (1.0 - (-4.0_f64 / 3.0).exp())),
        ),
        ("feed-power-law::exponent=0.6", expected(k, c, 5e-4, 0.6, 0.0, 0.0, [0.0; 2])),
        ("advancing-side::ratio=0.03", expected(k, c, 5e-4, 1.0, 0.03, 0.0, [0.0; 2])),
        (
            "spindle-harmonic::order=3,axial=0.02,in_plane=0.05,phase_rad=0.4",
            expected(k, c, 5e-4, 1.0, 0.0, 0.0, [0.02 * third, 0.05 * third]),
        ),
        (
            "plate-waviness::amplitude_m=2e-4,length_m=0.05,phase_rad=0.2",
            expected(
                k,
                c,
                5e-4 + 2e-4 * (std::f64::consts::TAU * x / 0.05 + 0.2).sin(),
                1.0,
                0.0,
                0.0,
                [0.0; 2],
            ),
        ),
        ("fixture-compliance::stiffness_n_m=5e7", expected(k, c, 5e-4, 1.0, 0.0, 2e-8, [0.0; 2])),
        ("material-step::ratio=0.2,position_m=0.02", plain * 1.2),
        ("material-step::ratio=0.2,position_m=0.2", plain),
    ] {
        let effects: &[&str] = if effect.is_empty() { &[] } else { &[effect] };
        let got = force(effects);
        assert!((got - wanted).norm() < 1e-9 * wanted.norm(), "{effect}: {got} expected {wanted}");
    }
}

#[test]
fn a_payload_that_leaves_no_robot_is_refused() {
    let fixtures = Fixtures::of("vertical");
    let mut effect = trueweld_plant::effects::Effect::parse(
        "payload-error::mass_kg=-50,x_m=0,y_m=0,z_m=0",
        &fixtures.robot,
    )
    .expect("understood");
    // What no file or command line may ask for, a program can.
    effect.values[0] = -500.0;
    let seam = Seam::of(&fixtures.weld);
    let cell = Cell::new(&fixtures.robot.robot, &[effect], &fixtures.process, seam);
    assert!(
        cell.expect_err("no robot weighs less than nothing").to_string().contains("payload-error")
    );
}

#[test]
fn a_coupled_wrist_is_still_taught_on_its_line() {
    // 0.2 of A5's 0.69 rad at the start: far beyond any twist of a load, and the real tool must
    // stand on the line all the same.
    let fixtures = short("vertical");
    let cell = fixtures.cell(&["wrist-coupling:A6:ratio=0.2"]);
    let link =
        trueweld_plant::simulate::start_angles(&KR500, &Seam::of(&fixtures.weld)).expect("reach");
    let motor = rest::motors_for(&cell, &link, &Wrench::zero());
    let back = rest::under_wrench(&cell, &motor, &Wrench::zero()).expect("rest");
    assert!((back - link).amax() < 1e-9, "{}", back - link);
    assert!((motor[5] - link[5]).abs() > 0.1);
}

/// The cell with effects of the user's own, each `at|port|expression`, without parameters.
fn own(fixtures: &Fixtures, effects: &[&str]) -> Cell {
    let mut text = "schema = \"model/1\"\nrobot = \"../robots/kr500-mt.toml\"\n".to_owned();
    for effect in effects {
        let mut parts = effect.splitn(3, '|');
        let mut part = || parts.next().expect("three parts");
        text += "[[effect]]\nid = \"own\"\n";
        let at = part();
        if !at.is_empty() {
            text += &format!("at = \"{at}\"\n");
        }
        text += &format!("port = \"{}\"\nexpression = \"{}\"\n", part(), part());
    }
    let model =
        ModelFile::parse(&text, &fixture("models/own.toml")).expect("the model is in order");
    let seam = Seam::of(&fixtures.weld);
    Cell::new(&fixtures.robot.robot, &model.cell_effects(), &fixtures.process, seam)
        .expect("a cell")
}

#[test]
fn an_expression_does_what_the_effect_of_the_library_does() {
    let fixtures = short("vertical");
    let cases: [(&str, &[&str]); 10] = [
        (
            "hysteresis:A2:torque_nm=2400,twist_rad=1e-4",
            &["A2|spring-torque|2400 * dahl(twist, 1e-4)"],
        ),
        (
            "transmission-error:A1:amplitude_rad=1.6e-4,order=40,phase_rad=0.8",
            &["A1|twist|1.6e-4 * sin(40 * encoder + 0.8)"],
        ),
        ("wrist-coupling:A6:ratio=0.02", &["A6|twist|0.02 * encoder_before"]),
        (
            "joint-friction:A1:coulomb_nm=500,viscous_nms_rad=1000",
            &["A1|motor-friction|500 * tanh(encoder_rate / smoothing) + 1000 * encoder_rate"],
        ),
        (
            "load-friction:A2:ratio=0.1",
            &["A2|motor-friction|0.1 * abs(spring_torque) * tanh(encoder_rate / smoothing)"],
        ),
        ("counterbalance-loss::loss=0.25", &["A2|link-torque|-0.25 * counterbalance"]),
        (
            "material-step::ratio=0.2,position_m=0.02",
            &[
                "|process-force-x|0.2 * fx * step(x - 0.02)",
                "|process-force-y|0.2 * fy * step(x - 0.02)",
                "|process-force-z|0.2 * fz * step(x - 0.02)",
            ],
        ),
        (
            "plate-waviness::amplitude_m=2e-4,length_m=0.05,phase_rad=0",
            &["|surface-height|2e-4 * sin(2 * pi * x / 0.05)"],
        ),
        (
            "thermal-drift::x_m=2e-4,y_m=-1e-4,z_m=3e-4,time_s=5",
            &[
                "|tool-shift-x|2e-4 * (1 - exp(-time / 5))",
                "|tool-shift-y|-1e-4 * (1 - exp(-time / 5))",
                "|tool-shift-z|3e-4 * (1 - exp(-time / 5))",
            ],
        ),
        (
            "force-crosstalk::fx_per_fz=0.012,fy_per_fz=-0.008",
            &["|force-sensor-x|0.012 * fz", "|force-sensor-y|-0.008 * fz"],
        ),
    ];
    for (library, expressions) in cases {
        let weld = |cell: &Cell| {
            fixtures
                .run(
                    cell,
                    WeldProgram::Weld,
                    ControllerKind::EXTERNAL,
                    &law("none"),
                    &fixtures.robot.robot,
                )
                .rows
        };
        let (wanted, got) = (weld(&fixtures.cell(&[library])), weld(&own(&fixtures, expressions)));
        assert_eq!(wanted.len(), got.len());
        for (a, b) in wanted.iter().zip(&got) {
            let (moved, turned) =
                ((a.real.position - b.real.position).norm(), (a.torque - b.torque).amax());
            // Rounding, seconds of simulation later.
            assert!(
                moved < 1e-11 && turned < 1e-3,
                "{library} at {} s: {moved:e} m, {turned:e} N·m",
                a.time
            );
        }
    }
}

/// Torque for torque: along a weld the two would part by what the encoders' steps make of rounding,
/// since the integrator's linear part knows the robot's stiffness and no expression.
#[test]
fn an_expression_for_a_stiffness_gives_its_torque() {
    let fixtures = short("vertical");
    let stiffer = format!("A3|spring-torque|{:e} * twist", 0.2 * KR500.stiffness()[2]);
    let library = fixtures.cell(&["stiffness-error:A3:relative=0.2"]).robot;
    let expression = own(&fixtures, &[&stiffer]).robot;
    for k in 0..50 {
        let some =
            |scale: f64| JointVector::from_fn(|i, _| scale * f64::from(k * 7 + i as i32 * 3).sin());
        let drives = Drives {
            link: some(1.0),
            link_rate: some(0.1),
            motor: some(1.0) + some(2e-3),
            motor_rate: some(0.2),
        };
        let (a, b) = (library.spring_torque(&drives, &[]), expression.spring_torque(&drives, &[]));
        assert!((a - b).amax() < 1e-9 * a.amax(), "{a} {b}");
    }
}

#[test]
fn instruments_read_what_expressions_add() {
    let fixtures = Fixtures::of("vertical");
    let truth = Readings {
        time: 3.0,
        encoder: [0.1; 6],
        link_encoder: [0.2; 6],
        motor_torque: [3e3; 6],
        force: Vector3::new(100.0, 200.0, -18e3),
        moment: Vector3::zeros(),
        tcp_position: Vector3::new(1.7, -0.3, 0.5),
        tcp_rotation: Vector3::zeros(),
    };
    let cell = own(
        &fixtures,
        &[
            "A2|link-encoder|1e-3 * sin(link) + encoder",
            "A2|recorded-torque|0.01 * torque + encoder",
            "|tracker-z|1e-4 * px * encoder_3",
            "|force-sensor-y|0.1 * time",
        ],
    );
    let mut read = truth;
    cell.robot.ports.sense(&mut read);
    let mut expected = truth;
    expected.link_encoder[1] += 1e-3 * 0.2_f64.sin() + 0.1;
    expected.motor_torque[1] += 0.01 * 3e3 + 0.1;
    expected.tcp_position.z += 1e-4 * 1.7 * 0.1;
    expected.force.y += 0.1 * 3.0;
    assert_eq!(read, expected);
}

#[test]
fn an_expression_that_ceases_to_be_finite_ends_the_run_and_nothing_else() {
    let fixtures = short("vertical");
    // Roots of what is negative only on the way: finite at rest and wherever a reader of the file
    // tries them.
    for (effect, at_rest) in [
        ("A1|spring-torque|sqrt((link_rate + 0.001) * (link_rate + 0.05))", false),
        ("A1|spring-torque|sqrt((link - 0.1) * (link - 0.9))", true),
        ("A1|twist|1e-6 * sqrt((encoder_rate + 0.001) * (encoder_rate + 0.05))", false),
        ("A1|motor-friction|sqrt((encoder_rate + 0.001) * (encoder_rate + 0.05))", false),
        ("A1|link-torque|sqrt((link - 0.1) * (link - 0.9))", true),
        ("|process-force-z|sqrt((x - 0.01) * (x - 0.05))", false),
        ("|surface-height|1e-6 * sqrt((x - 0.01) * (x - 0.05))", false),
        ("|tool-shift-y|1e-6 * sqrt((time - 2) * (time - 90))", false),
        ("|force-sensor-z|1e-6 * sqrt((time - 2) * (time - 90))", false),
    ] {
        let cell = own(&fixtures, &[effect]);
        let none = law("none");
        let scenario = fixtures.scenario(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &none);
        match run(&scenario, |_| {}) {
            Err(RunError::RanAway { .. }) => assert!(!at_rest, "{effect}"),
            Err(RunError::Rest(_)) => assert!(at_rest, "{effect}"),
            // The controller knows a sensor that reads no number, and holds.
            Ok(run) if effect.contains("sensor") => {
                assert!(run.rows.iter().all(|r| r.fault.is_some() == (r.time > 2.0)), "{effect}")
            }
            other => panic!("{effect}: {:?}", other.map(|r| r.rows.len())),
        }
    }
}
