//! Seams of any shape: a curved seam that is straight is the straight one, the process turns with the
//! seam, deviations count from the real one, and what the arm cannot weld is refused.

use crate::cell::KR500;
use crate::cell::support::{Fixtures, law};
use nalgebra::Vector3;
use std::sync::Arc;
use trueweld_core::JointVector;
use trueweld_plant::cell::{Cell, State};
use trueweld_plant::input::{InputFile, Wave, Weld};
use trueweld_plant::path::{Joined, Path, PathPoint};
use trueweld_plant::simulate::{
    ControllerKind, Recording, RunError, Seam, WeldProgram, check_reach, real_inverse_near,
    start_angles,
};

fn panel(name: &'static str) -> Fixtures {
    Fixtures::of(name)
}

/// A weld of 40 mm.
fn short(mut fixtures: Fixtures, change: impl Fn(&mut Weld)) -> Recording {
    let weld = &mut fixtures.weld;
    let along = (weld.end - weld.start).normalize();
    (weld.end, weld.settle) = (weld.start + along * 0.04, 0.5);
    change(weld);
    let cell = fixtures.cell(&[]);
    fixtures.run(&cell, WeldProgram::Weld, ControllerKind::EXTERNAL, &law("elastostatic"), &KR500)
}

#[test]
fn two_points_with_one_normal_are_the_straight_seam_of_a_weld_1() {
    let straight = Fixtures::of("published-vertical").weld;
    let rest = "feed_m_s = 0.01\nfeed_ramp_s = 1.0\nforce_n = 18000.0\nforce_ramp_s = 3.0\n\
                initial_depth_m = 0.0003\nsettle_s = 2.0\n";
    let point = |y: f64| format!("[[point]]\nat_m = [1.7, {y:?}, 0.5]\nnormal = [0.0, 0.0, 2.0]\n");
    let head = "schema = \"weld/2\"\njoined = \"legs\"\n";
    let text = [head, rest, &point(-1.0), &point(1.0)].concat();
    assert_eq!(Weld::parse(&text, "weld.toml").expect("a weld"), straight);
}

/// The same equations in another order of rounding: the encoders' steps make 2 µrad of a difference in
/// the last digit, 3 µm at the tool.
#[test]
fn a_curve_through_points_of_a_line_welds_as_the_line_does() {
    let line = short(Fixtures::of("vertical"), |_| {});
    let curve = short(Fixtures::of("vertical"), |weld| {
        let at = |share: f64| PathPoint {
            position: weld.start + (weld.end - weld.start) * share,
            normal: -weld.tool_axis,
        };
        let path = Path::new(&[0.0, 0.2, 0.5, 1.0].map(at), Joined::Spline).expect("a path");
        weld.path = Some(Arc::new(path));
    });
    assert_eq!(line.rows.len(), curve.rows.len());
    for (a, b) in line.rows.iter().zip(&curve.rows) {
        let apart = (a.deviation_w.linear - b.deviation_w.linear).norm();
        assert!(apart < 5e-6, "{apart:e} m at {} s", a.time);
    }
}

/// Anywhere along an arc, a tool that stands in the material is pushed out along the normal there, with
/// k_z times its depth: the process' own equation.
#[test]
fn the_process_turns_with_the_seam() {
    let fixtures = panel("panel-frame");
    let cell = fixtures.cell(&[]);
    let seam = Seam::of(&fixtures.weld);
    let mut q = start_angles(&KR500, &seam).expect("reach");
    for k in 0..=10 {
        let path = seam.length * f64::from(k) / 10.0;
        let (mut pose, axes) = (seam.nominal(path), seam.axes(path));
        pose.position += axes.column(2) * 4e-4;
        q = real_inverse_near(&KR500, &KR500, &pose, &q).expect("reach");
        let state = State::at_rest(&q, &q, 0.0);
        let contact = cell.contact(0.0, &state, &state.drives());
        let ripple = contact.reaction.force.norm() / (4e-4 * cell.process.model.depth_stiffness());
        assert!((ripple - 1.0).abs() < 0.05, "{ripple}");
        let force = contact.wrench().force;
        // The normal of the panel: out of its axis, 1.5 m below the floor of the robot.
        let mut outward = pose.position - Vector3::new(1.7, 0.0, -1.5);
        outward.y = 0.0;
        assert!(force.angle(&outward) < 1e-4, "{}", force.angle(&outward));
        assert!((cell.seam.place(&pose.position).position.x - path).abs() < 1e-9);
    }
}

#[test]
fn deviations_count_from_the_real_seam() {
    let plain = short(Fixtures::of("vertical"), |_| {});
    let shifted = short(Fixtures::of("vertical"), |weld| {
        weld.real.by.linear.y = 1e-3;
        weld.real.wave = Some(Wave { amplitude: 5e-4, length: 0.3, phase: 0.5 });
    });
    // The same tool, seen from another line; the wave's slope of 0.01 turns what it is off along.
    let [there, off] = [&plain, &shifted].map(|run| run.rows[0].deviation_w.linear.y);
    let expected = 1e-3 + 5e-4 * 0.5f64.sin();
    assert!((there - off - expected).abs() < 1e-5, "{} for {expected}", there - off);
}

/// Where the seam is 20 mm ahead, with W gone on straight: y(s + a) − y(s) − a y′(s) of a sine.
#[test]
fn the_seam_sensor_sees_the_wave_ahead() {
    let wave = Wave { amplitude: 5e-4, length: 0.3, phase: 0.2 };
    let seam = Seam::of(&Fixtures::of("vertical").weld).waved(&wave);
    let rate = std::f64::consts::TAU / wave.length;
    for path in [0.1, 0.4321, 1.2] {
        let slope = wave.amplitude * rate * (rate * path + wave.phase).cos();
        let expected = wave.at(path + 0.02) - wave.at(path) - 0.02 * slope;
        assert!((seam.bend(path, 0.02) - expected).abs() < 1e-7, "{}", seam.bend(path, 0.02));
    }
}

#[test]
fn what_the_arm_cannot_weld_is_named_with_its_place() {
    let fixtures = panel("panel-frame");
    check_reach(&KR500, &fixtures.weld).expect("the panel is within reach");
    let moved = |x: f64, abc: &str| {
        let text = include_str!("../../../../fixtures/welds/panel-frame.toml")
            .replace("[1.700, 0.000, 0.500]", &format!("[{x}, 0.0, 0.5]"))
            .replace("[90.0, 0.0, 0.0]", abc);
        Weld::parse(&text, "panel.toml").expect("a weld")
    };
    let behind = check_reach(&KR500, &moved(-6.0, "[90.0, 0.0, 0.0]")).unwrap_err();
    assert!(matches!(behind, RunError::Reach { path: 0.0, .. }), "{behind}");
    let far = check_reach(&KR500, &moved(2.9, "[-90.0, 0.0, 0.0]")).unwrap_err();
    assert!(matches!(far, RunError::Reach { path, .. } if path > 0.0), "{far}");
}

/// Speeds and places of a profile: v² = 2 a s on the way up, and the run-out's length at the end.
#[test]
fn the_feed_follows_its_profile_to_the_end_of_the_run_out() {
    let mut weld = Fixtures::of("published-vertical").weld;
    weld.end = weld.start + Vector3::y() * 0.3;
    (weld.feeds, weld.run_out, weld.dwell) = (vec![(0.1, 0.005), (0.2, 0.02)], 0.03, 1.5);
    let (seam, program) = (Seam::of(&weld), WeldProgram::Weld);
    let duration = program.duration(&weld, &seam);
    let at = |time: f64| program.target(&weld, &seam, 500.0, time);
    let step = 1e-3;
    let mut way = 0.0;
    for k in 0..(duration / step) as usize {
        let target = at((k as f64 + 0.5) * step);
        way += target.feed * step;
        let next = at((k + 1) as f64 * step);
        assert!((next.path - way).abs() < 1e-6, "{} for {way}", next.path);
        let expected = match next.path {
            s if s > 0.006 && s < 0.1 => Some(0.01),
            s if s > 0.105 && s < 0.2 => Some(0.005),
            s if s > 0.22 && s < 0.3 => Some(0.02),
            _ => None,
        };
        assert!(expected.is_none_or(|feed| (next.feed - feed).abs() < 1e-12), "{next:?}");
    }
    assert!((at(duration).path - 0.33).abs() < 1e-9);
    let [begins, ends] = program.steady(&weld, &seam).expect("a steady part");
    assert!((at(ends).path - 0.3).abs() < 1e-6 && begins > weld.settle + weld.force_ramp + 1.5);
}

/// Lead and tilt turn the tool about y and x of W, and leave the surface where it is.
#[test]
fn a_tool_that_leans_stands_on_the_same_surface() {
    let mut fixtures = Fixtures::of("vertical");
    let upright = Seam::of(&fixtures.weld);
    fixtures.weld.lean = [0.05, -0.02];
    let leant = Seam::of(&fixtures.weld);
    let (a, b) = (upright.nominal(0.4), leant.nominal(0.4));
    assert_eq!((a.position, upright.axes(0.4)), (b.position, leant.axes(0.4)));
    let in_w = leant.axes(0.4).tr_mul(&b.rotation.column(2));
    // The tip ahead of the spindle, and to the side of a rotation about x.
    let expected = Vector3::new(0.05f64.sin(), 0.02f64.sin(), 0.0);
    assert!((in_w.xy() - expected.xy()).norm() < 1e-4, "{in_w}");
    let cell = Cell::new(&KR500, &[], &fixtures.process, leant).expect("a cell");
    let q: JointVector<f64> = start_angles(&KR500, &cell.seam).expect("reach");
    assert!(q.iter().all(|angle| angle.is_finite()));
}
