//! Peripheral milling: forces against the published closed forms, the arm that bends under them,
//! and what does not fit the process.

use super::fixture;
use super::support::{Fixtures, law};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};
use trueweld_core::Wrench;
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{InputFile, Process, Weld};
use trueweld_plant::process::{ProcessMisfit, planned, processes, reaction};
use trueweld_plant::robot::Ports;
use trueweld_plant::simulate::{
    ControllerKind, Phase, Recording, RunError, Seam, WeldProgram, run,
};

const TRIM: &str = include_str!("../../../../fixtures/processes/trim-7075-t6.toml");

/// Feed of the fixture's weld, m/s, and with its 2 teeth at 846.14 rad/s the feed per tooth, m.
const FEED: f64 = 0.020;
const CHIP: f64 = FEED * PI / 846.1356;
const TEETH: f64 = 2.0;
const DEPTH: f64 = 0.010;
/// K_tc, K_rc, K_ac in N/m², K_te, K_re, K_ae in N/m.
const CUTTING: [f64; 3] = [767.01e6, 168.8e6, 222e6];
const EDGE: [f64; 3] = [27.7e3, 26.6e3, 0.7e3];

fn slot() -> Process {
    Process::parse(TRIM, "trim.toml").unwrap()
}

/// A side cut of 5 mm with the tool of 20 mm.
fn side(cut: &str) -> Process {
    let text = TRIM.replace("cut = \"slot\"", &format!("cut = \"{cut}\""));
    Process::parse(&text.replace("radial_depth_m = 0.020", "radial_depth_m = 0.005"), cut).unwrap()
}

/// Force on a tool on its line at full feed, at an angle of the spindle.
fn force_at(process: &Process, angle: f64) -> Vector3<f64> {
    let (at, velocity) = (Vector3::zeros(), Vector3::x() * FEED);
    reaction(process, &Ports::default(), 0.0, &at, &velocity, 0.0, angle).force
}

/// The mean over a turn, by the sum over so many angles.
fn mean_over_a_turn(process: &Process) -> Vector3<f64> {
    let count = 20_000;
    let angles = (0..count).map(|k| TAU * f64::from(k) / f64::from(count));
    angles.map(|angle| force_at(process, angle)).sum::<Vector3<f64>>() / f64::from(count)
}

/// Mean forces per tooth period between an entry and an exit angle: Altintas, Manufacturing
/// Automation, 2nd ed., eq. (2.104), with y along the normal, in W with the spindle clockwise.
fn published([entry, exit]: [f64; 2]) -> Vector3<f64> {
    let [[tc, rc, ac], [te, re, ae]] = [CUTTING, EDGE];
    let (cut, rub) = (TEETH * DEPTH * CHIP / (8.0 * PI), TEETH * DEPTH / TAU);
    let at = |a: f64| {
        let (s, c, s2, c2) = (a.sin(), a.cos(), (2.0 * a).sin(), (2.0 * a).cos());
        let x = cut * (tc * c2 - rc * (2.0 * a - s2)) + rub * (-te * s + re * c);
        let y = cut * (tc * (2.0 * a - s2) + rc * c2) - rub * (te * c + re * s);
        let z = TEETH * DEPTH / TAU * (-ac * CHIP * c + ae * a);
        Vector3::new(x, -y, z)
    };
    at(exit) - at(entry)
}

#[test]
fn the_mean_force_of_a_slot_is_the_published_one() {
    let [[tc, rc, ac], [te, re, ae]] = [CUTTING, EDGE];
    // Eq. (2.105): what cutting coefficients are calibrated by.
    let expected = Vector3::new(
        -TEETH * DEPTH * CHIP / 4.0 * rc - TEETH * DEPTH / PI * re,
        -TEETH * DEPTH * CHIP / 4.0 * tc - TEETH * DEPTH / PI * te,
        TEETH * DEPTH * CHIP / PI * ac + TEETH * DEPTH / 2.0 * ae,
    );
    assert!((planned(&slot(), 0.0, FEED) - expected).amax() < 1e-9 * expected.amax());
    // The sum over angles at which a tooth enters or leaves is exact to its step.
    assert!((mean_over_a_turn(&slot()) - expected).amax() < 1e-5 * expected.amax());
    // 461 N across, 232 N against the feed, 112 N out of the holder.
    assert!((expected - Vector3::new(-232.0, -461.1, 112.0)).amax() < 0.5, "{expected}");
}

#[test]
fn the_mean_force_of_a_side_cut_is_the_published_one() {
    // 1 − a_e/R = 0.5: 60 degrees of immersion.
    for (cut, immersion) in [("up", [0.0, PI / 3.0]), ("down", [2.0 * PI / 3.0, PI])] {
        let (process, expected) = (side(cut), published(immersion));
        let error = planned(&process, 0.0, FEED) - expected;
        assert!(error.amax() < 1e-9 * expected.amax(), "{cut}: {error}");
        let error = mean_over_a_turn(&process) - expected;
        assert!(error.amax() < 1e-5 * expected.amax(), "{cut}: {error}");
    }
}

#[test]
fn a_tooth_of_little_helix_cuts_what_one_element_does() {
    // With 0.06 degrees of helix the whole edge is at one angle: K h + K_e at 90 degrees.
    let text = TRIM.replace("helix_rad = 0.5235987755982988", "helix_rad = 0.001");
    let process = Process::parse(&text.replace("teeth = 2", "teeth = 1"), "one tooth").unwrap();
    let chip = 2.0 * CHIP;
    let [t, r, a] = [0, 1, 2].map(|k| (CUTTING[k] * chip + EDGE[k]) * DEPTH);
    let error = force_at(&process, 0.5 * PI) - Vector3::new(-r, -t, a);
    // The edge spans 2 tan β a/D = 0.001 rad.
    assert!(error.amax() < 2e-3 * t, "{error}");
    // In the half turn without material there is no force.
    assert_eq!(force_at(&process, 1.5 * PI), Vector3::zeros());
}

#[test]
fn a_spindle_that_turns_the_other_way_mirrors_the_cut() {
    let clockwise = side("up");
    let mirrored = Process { spindle: -clockwise.spindle, ..clockwise.clone() };
    for k in 0..7 {
        let angle = 0.9 * f64::from(k);
        let (a, b) = (force_at(&clockwise, angle), force_at(&mirrored, -angle));
        assert!((a - Vector3::new(b.x, -b.y, b.z)).amax() < 1e-9, "{a} {b}");
    }
}

#[test]
fn a_tool_that_stands_is_free_and_one_above_the_plate_too() {
    let force = |at: Vector3<f64>, velocity: Vector3<f64>| {
        reaction(&slot(), &Ports::default(), 0.0, &at, &velocity, 0.0, 0.3).force
    };
    assert_eq!(force(Vector3::zeros(), Vector3::zeros()), Vector3::zeros());
    let above = Vector3::new(0.0, 0.0, -DEPTH);
    assert_eq!(force(above, Vector3::x() * FEED), Vector3::zeros());
}

#[test]
fn slopes_are_those_of_the_mean_force() {
    for process in [slot(), side("up"), side("down")].map(|process| process.even()) {
        let (at, v) = (Vector3::new(0.1, 2e-4, -3e-4), Vector3::new(FEED, 4e-4, 1e-4));
        let of = |at: Vector3<f64>, v: Vector3<f64>| {
            reaction(&process, &Ports::default(), 0.0, &at, &v, 0.0, 0.0)
        };
        let here = of(at, v);
        for axis in 0..3 {
            let mut by = Vector3::zeros();
            by[axis] = 1e-7;
            let [k, b] = [
                (of(at - by, v).force - of(at + by, v).force) / 2e-7,
                (of(at, v - by).force - of(at, v + by).force) / 2e-7,
            ];
            let error = (here.stiffness.column(axis) - k).amax();
            assert!(error < 1e-5 * (1.0 + here.stiffness.amax()), "{process:?} {axis}: {error}");
            let error = (here.damping.column(axis) - b).amax();
            assert!(error < 1e-5 * (1.0 + here.damping.amax()), "{process:?} {axis}: {error}");
        }
    }
}

/// The KR 500 MT at the fixture's cut.
fn trimming() -> Fixtures {
    let weld = Weld::read(fixture("welds/trim.toml")).unwrap();
    Fixtures { process: slot(), weld, ..Fixtures::of("coupon") }
}

fn cut(fixtures: &Fixtures, name: &str) -> Recording {
    let (cell, law) = (fixtures.cell(&[]), law(name));
    let (program, controller) = (WeldProgram::Weld, ControllerKind::EXTERNAL);
    fixtures.run(&cell, program, controller, &law, &fixtures.robot.robot)
}

/// Mean of the lateral deviation over the steady part, m.
fn lateral(recording: &Recording) -> f64 {
    let steady = recording.rows.iter().filter(|row| row.phase == Phase::Steady);
    let lateral: Vec<f64> = steady.map(|row| row.deviation_w.linear.y).collect();
    assert!(lateral.len() > 500, "{}", lateral.len());
    lateral.iter().sum::<f64>() / lateral.len() as f64
}

#[test]
fn the_arm_bends_under_the_cut_by_its_compliance_and_a_law_takes_it_back() {
    let fixtures = trimming();
    let recording = cut(&fixtures, "none");
    // In the middle of the seam: J K⁻¹ Jᵀ w, first order.
    let middle = &recording.rows[recording.rows.len() / 2];
    let robot = &fixtures.robot.robot;
    let frames = robot.frames(&middle.link);
    let force = middle.axes * planned(&fixtures.process, 0.0, FEED);
    let load = Wrench { moment: Vector3::zeros(), force };
    let torsion = frames.joint_torque(&load).component_div(robot.stiffness());
    let bent = (frames.jacobian().0.fixed_rows::<3>(3) * torsion).dot(&middle.axes.column(1));
    let without = lateral(&recording);
    // The compliance changes by a few per cent along the seam, gravity's part is left out.
    assert!((without / bent - 1.0).abs() < 0.1, "{without} {bent}");
    assert!(without.abs() > 1e-4, "{without}");
    for name in ["feed-forward", "elastostatic"] {
        let with = lateral(&cut(&fixtures, name));
        assert!(with.abs() < 0.1 * without.abs(), "{name}: {with} of {without}");
    }
    // No force loop closes.
    assert!(recording.rows.iter().all(|row| row.force_desired.is_none()));
    assert!(recording.rows.iter().all(|row| row.depth_correction == 0.0));
}

#[test]
fn effects_act_on_what_the_process_has_and_are_refused_where_it_has_it_not() {
    let fixtures = trimming();
    let force = |text: &str| {
        let effect = Effect::parse(text, &fixtures.robot).unwrap();
        let seam = Seam::real(&fixtures.weld);
        let cell = Cell::new(&fixtures.robot.robot, &[effect], &fixtures.process, seam)?;
        let (at, v) = (Vector3::new(0.2, 0.0, 0.0), Vector3::x() * FEED);
        Ok(reaction(&cell.process, &cell.robot.ports, 8.0, &at, &v, 0.0, 0.3).force)
    };
    let plain = force_at(&fixtures.process, 0.3);
    let is_near = |a: Vector3<f64>, b: Vector3<f64>| (a - b).amax() < 1e-9 * plain.amax();
    let refused = |text: &str| -> String {
        let error: Result<_, trueweld_plant::effects::EffectError> = force(text);
        error.unwrap_err().to_string()
    };
    let acts = |text: &str| -> Vector3<f64> {
        let force: Result<_, trueweld_plant::effects::EffectError> = force(text);
        force.unwrap()
    };
    assert!(is_near(acts("material-step::ratio=0.2,position_m=0.1"), plain * 1.2));
    let soft = 1.0 - 0.1 * (1.0 - (-1.0_f64).exp());
    assert!(is_near(acts("thermal-softening::share=0.1,time_s=8"), plain * soft));
    let runout = 1.0 + 0.1 * 0.3_f64.sin();
    let harmonic = acts("spindle-harmonic::order=1,axial=0.0,in_plane=0.1,phase_rad=0.0");
    assert!(is_near(harmonic, Vector3::new(plain.x * runout, plain.y * runout, plain.z)));
    // A surface 2 mm higher is cut 2 mm deeper: a fifth more of the mean.
    let wave = "plate-waviness::amplitude_m=2e-3,length_m=0.8,phase_rad=0";
    assert!(acts(wave).norm() > 1.1 * plain.norm());
    assert_eq!(
        refused("drag-error::relative=0.1"),
        "drag-error acts on `feed_drag_ns_m`, which peripheral milling does not have"
    );
    assert_eq!(
        refused("process-stiffness-error::relative=0.1"),
        "process-stiffness-error acts on `depth_stiffness_n_m`, which peripheral milling does not have"
    );
    assert_eq!(
        refused("feed-power-law::exponent=0.7"),
        "feed-power-law acts on the drag in proportion to feed and push, which peripheral milling does not have"
    );
    assert_eq!(
        refused("advancing-side::ratio=0.02"),
        "advancing-side acts on the push, which peripheral milling does not have"
    );
}

#[test]
fn a_weld_of_another_process_is_refused() {
    let refused = |fixtures: &Fixtures, program| {
        let (cell, none) = (fixtures.cell(&[]), law("none"));
        run(&fixtures.scenario(&cell, program, ControllerKind::EXTERNAL, &none), |_| {})
            .unwrap_err()
    };
    let process = "peripheral milling";
    let pushed = Fixtures { process: slot(), ..Fixtures::of("coupon") };
    let error = refused(&pushed, WeldProgram::Weld);
    assert_eq!(error, RunError::Process(ProcessMisfit::PushAsked { process }));
    let held = Fixtures { weld: trimming().weld, ..Fixtures::of("coupon") };
    let process = "friction stir welding";
    let error = refused(&held, WeldProgram::Weld);
    assert_eq!(error, RunError::Process(ProcessMisfit::NoPush { process }));
    let step = WeldProgram::ForceStep { height: 1e3, hold: 0.5, length: 0.5 };
    let process = "peripheral milling";
    let error = refused(&trimming(), step);
    assert_eq!(error, RunError::Process(ProcessMisfit::NoStep { process }));
}

#[test]
fn a_file_without_a_kind_is_of_the_first_process() {
    let lap = std::fs::read_to_string(fixture("processes/lap-weld-2024-t3.toml")).unwrap();
    let schema = "schema = \"process/1\"\n";
    let stated = lap.replace(schema, &format!("{schema}kind = \"friction-stir-welding\"\n"));
    assert_ne!(lap, stated);
    assert_eq!(Process::parse(&lap, "lap").unwrap(), Process::parse(&stated, "lap").unwrap());
    let error = Process::parse(&TRIM.replace("peripheral", "peripherial"), "x.toml").unwrap_err();
    assert!(error.to_string().contains("did you mean `peripheral-milling`?"), "{error}");
}

#[test]
fn every_process_states_what_it_is() {
    for kind in processes() {
        assert!(![kind.id, kind.name, kind.equation, kind.about].contains(&""), "{}", kind.id);
        assert!(kind.quantities.iter().all(|q| kind.keys.contains(&q.key)), "{}", kind.id);
        assert!(kind.drawn.iter().all(|(key, k)| kind.keys.contains(key) && *k < 5), "{}", kind.id);
    }
    // Every number is reached by its key.
    let mut process = slot();
    let own = process.kind().keys.iter().filter(|key| !key.starts_with("ripple."));
    assert!(own.clone().all(|key| process.numbers(key).len() == 1));
}
