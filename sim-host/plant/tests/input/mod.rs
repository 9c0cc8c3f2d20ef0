//! The input layer: the fixtures read as written, every class of mistake is explained at its place,
//! and no input whatever makes a reader panic.

mod any_text;
mod urdf;

use miette::{GraphicalReportHandler, GraphicalTheme};
use nalgebra::Vector3;
use std::fs;
use std::path::{Path, PathBuf};
use trueweld_core::JointVector;
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::input::*;
use trueweld_plant::sensors::{sensor_numbers, sensors};

const ROBOT: &str = include_str!("../../../../fixtures/robots/kr500-mt.toml");
const PROCESS: &str = include_str!("../../../../fixtures/processes/lap-weld-2024-t3.toml");
const VERTICAL: &str = include_str!("../../../../fixtures/welds/vertical.toml");
const INCLINED: &str = include_str!("../../../../fixtures/welds/inclined.toml");
const JOGGLE: &str = include_str!("../../../../fixtures/welds/panel-joggle-off.toml");
const CONTROL: &str = include_str!("../../../../fixtures/control/kr500-mt.toml");
const SENSORS: &str = include_str!("../../../../fixtures/sensors/kr500-mt.toml");
const URDF: &str = include_str!("../../../../fixtures/robots/arm6.urdf");

fn fixture(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(path)
}

/// What a person sees in the terminal.
fn rendered(error: &InputError) -> String {
    let mut out = String::new();
    let handler =
        GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(2000);
    handler.render_report(&mut out, error).unwrap();
    out
}

/// The file parsed by the reader of its kind.
fn parse(text: &str, name: &str) -> Result<(), InputError> {
    match TomlDocument::parse(text, name)?.kind()? {
        FileKind::Robot => RobotFile::parse(text, name).map(drop),
        FileKind::Process => Process::parse(text, name).map(drop),
        FileKind::Weld => Weld::parse(text, name).map(drop),
        FileKind::Control => Control::parse(text, name).map(drop),
        FileKind::Sensors => Sensors::parse(text, name).map(drop),
        // Not read by this crate.
        FileKind::Requirements | FileKind::Log | FileKind::Campaign | FileKind::Protocol => Ok(()),
        FileKind::Model => ModelFile::parse(text, name.as_ref()).map(drop),
    }
}

/// A file read and parsed by the reader of its kind.
fn check(path: impl AsRef<Path>) -> Result<FileKind, InputError> {
    let (name, text) = read_text(path.as_ref())?;
    parse(&text, &name)?;
    TomlDocument::parse(&text, &name)?.kind()
}

#[test]
fn robot_fixture_holds_its_figures() {
    let file = RobotFile::parse(ROBOT, "kr500-mt.toml").unwrap();
    assert_eq!(file.name, "KR 500 MT + FSW end effector");
    assert_eq!(file.joint_names, ["A1", "A2", "A3", "A4", "A5", "A6"]);
    let p = &file.parameters;
    assert_eq!(p.gravity, Vector3::new(0.0, 0.0, -9.80665));
    assert_eq!(p.joints.map(|j| j.mass), [558.0, 485.0, 311.0, 86.0, 48.0, 7.0]);
    assert_eq!(p.joints.map(|j| j.stiffness), [13e6, 15e6, 6.2e6, 0.5e6, 0.6e6, 0.4e6]);
    assert_eq!(p.joints[1].limits, [-130f64.to_radians(), 20f64.to_radians()]);
    assert_eq!(p.joints[2].max_rate, 37.5f64.to_radians());
    assert_eq!(p.joints[0].inertia.m23, -1.85);
    assert_eq!(p.joints[0].inertia, p.joints[0].inertia.transpose());
    assert_eq!(p.friction.coulomb[5], 80.0);
    assert_eq!(p.counterbalance.cosine.as_slice(), [-9000.0, -80.0, 290.0]);
    assert_eq!(p.tool.tcp_from_flange, Vector3::new(0.4, 0.0, 0.0));
    assert_eq!(file.robot.parameters(), p);
}

#[test]
fn process_fixture_holds_its_figures() {
    let p = Process::parse(PROCESS, "lap.toml").unwrap();
    let number = |key: &str| p.number(key);
    assert_eq!([number("depth_stiffness_n_m"), number("depth_damping_ns_m")], [30e6, 1.5e6]);
    assert_eq!([number("memory_length_m"), number("lateral_ratio")], [0.008, 0.25]);
    assert_eq!(p.model.tool_diameter(), 0.005);
    assert!(
        (p.spindle + 20.0 * std::f64::consts::PI).abs() < 1e-12,
        "600 rpm, against the tool's z"
    );
    assert_eq!(p.ripple.len(), 2);
    assert_eq!(p.ripple[1], Ripple { order: 2.0, axial: 0.005, in_plane: 0.03, phase: 0.7 });
    // The load case that the file says it is calibrated to: 4 kN of drag and 1 kN across at 10
    // mm/s.
    assert!((number("feed_drag_ns_m") * 0.010 - 4000.0).abs() < 1e-9);
    assert!((number("lateral_ratio") * number("feed_drag_ns_m") * 0.010 - 1000.0).abs() < 1e-9);
    let smooth =
        Process::parse(PROCESS.split("[[ripple]]").next().unwrap(), "smooth.toml").unwrap();
    assert!(smooth.ripple.is_empty());
}

#[test]
fn weld_fixtures_are_two_metres_along_y() {
    for (text, tilt) in [(VERTICAL, 0.0), (INCLINED, 45f64)] {
        let w = Weld::parse(text, "weld.toml").unwrap();
        assert_eq!(w.end - w.start, Vector3::new(0.0, 2.0, 0.0));
        assert!((w.tool_axis.norm() - 1.0).abs() < 1e-15);
        assert!((-w.tool_axis.z - tilt.to_radians().cos()).abs() < 1e-12);
        assert_eq!((w.feed, w.force, w.initial_depth, w.settle), (0.010, 18_000.0, 0.0003, 2.0));
    }
}

/// Points of the fixture: ten centimetres and more apart along the fuselage, on a skin of 2 m radius.
#[test]
fn panel_seams_lie_on_the_skin() {
    let axis = Vector3::new(1.7, 0.0, -1.5);
    for name in ["panel-joggle", "panel-joggle-off", "panel-frame"] {
        let weld = Weld::read(fixture(&format!("welds/{name}.toml"))).unwrap();
        let path = weld.path.as_ref().expect("a curved seam");
        for k in 0..=50 {
            let (position, axes) = path.at(path.length() * f64::from(k) / 50.0);
            let mut outward = position - axis;
            outward.y = 0.0;
            // A spline leaves the circle by less than 10 µm between points 50 mm and 100 mm apart, and
            // the normal by some 0.1 mrad.
            assert!((outward.norm() - 2.0).abs() < 1e-5, "{name}: {}", outward.norm() - 2.0);
            assert!(outward.normalize().angle(&-axes.column(2)) < 2e-3, "{name}");
        }
    }
    let stringer = Weld::read(fixture("welds/panel-stringer.toml")).unwrap();
    assert!(stringer.path.is_none() && stringer.run_out == 0.02 && stringer.dwell == 1.0);
    let off = Weld::parse(JOGGLE, "joggle.toml").unwrap();
    assert_eq!(off.real.by.linear, Vector3::new(0.0, 1e-3, 0.0));
    let wave = off.real.wave.expect("a wave");
    assert!((wave.at(0.075) - 5e-4).abs() < 1e-12 && wave.at(0.15).abs() < 1e-12);
}

#[test]
fn what_no_tool_can_follow_is_refused_at_its_place() {
    let third = "at_m = [-0.200000, 0.000000, 0.000000]\nnormal = [0.0, 0.000000, 1.000000]";
    let put = |to: &str, needles: &[&str]| {
        let broken = JOGGLE.replacen(third, to, 1);
        assert_ne!(broken, JOGGLE);
        let error = rendered(&Weld::parse(&broken, "dir/file.toml").expect_err(to));
        assert!(needles.iter().all(|needle| error.contains(needle)), "{error}");
    };
    let second = "at_m = [-0.250000, 0.000000, 0.000000]\nnormal = [0.0, 0.0, 1.0]";
    put(second, &["[[point]] 3", "does not stand where the one before it does"]);
    let at = "at_m = [-0.200000, 0.000000, 0.000000]\n";
    put(&format!("{at}normal = [0.0, 0.0, 0.0]"), &["[[point]] 3", "has a direction"]);
    put(&format!("{at}normal = [0.0, 0.0, -1.0]"), &["[[point]] 3", "turn over"]);
    put(&format!("{at}normal = [0.0, 0.0, nan]"), &["[[point]] 3", "finite number"]);
    put(&format!("{at}normal = [1.0, 0.0, 0.01]"), &["[[point]] 3", "turn over"]);
    let kink = "at_m = [-0.200000, 0.030000, 0.000000]\nnormal = [0.0, 0.0, 1.0]";
    put(kink, &["[[point]]", "it bends with"]);
    let legs = JOGGLE.replace("\"spline\"", "\"legs\"");
    let error = rendered(&Weld::parse(&legs, "dir/file.toml").expect_err("corners"));
    assert!(error.contains("[[point]] 3") && error.contains("corner_radius_m"), "{error}");
    let one = format!("{}[[point]]", JOGGLE.split("[[point]]").next().unwrap());
    let one = one + "\nat_m = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\n";
    let error = parse(&one, "dir/file.toml").expect_err("one point");
    assert!(rendered(&error).contains("at least two points"), "{}", rendered(&error));
    let rest = [
        ("shift_y_m = 0.001", "shift_y_m = 0.1", "puts the seam 100.5 mm off"),
        ("shift_y_m = 0.001", "turn_z_rad = 0.1", "mm off at 0.6"),
        ("feed_m_s = 0.010", "feed_m_s = 0.0", "from 1e-6 to 1"),
        ("\"spline\"", "\"splines\"", "\"spline\" or \"legs\""),
        ("lead_deg = 2.0", "corner_radius_m = 0.05", "A spline has no corners"),
        ("lead_deg = 2.0", "lead_deg = 60.0", "from -20 to 20"),
        ("wave_length_m = 0.300", "", "missing key `wave_length_m`"),
        ("[real_seam]", "[[feed]]\nfrom_m = 0.9\nfeed_m_s = 0.005\n[real_seam]", "from 0.0050 to"),
        ("\"weld/2\"", "\"weld/3\"", "expected \"weld/1\" or \"weld/2\""),
    ];
    for (from, to, needle) in rest {
        let broken = JOGGLE.replacen(from, to, 1);
        let error = Weld::parse(&broken, "dir/file.toml").expect_err(to);
        assert!(rendered(&error).contains(needle), "{}", rendered(&error));
    }
}

#[test]
fn control_and_sensor_fixtures_hold_their_figures() {
    let c = Control::parse(CONTROL, "control.toml").unwrap();
    assert!(
        c.period > 0.0 && c.external.force.ki > 0.0 && c.parallel.joint.kp.iter().all(|k| *k > 0.0)
    );
    // The clamped interface differs in what it lets through, and in nothing else.
    let mut clamped = Control::read(fixture("control/kuka-clamped.toml")).unwrap();
    let limits = &mut clamped.compensation;
    assert_eq!(limits.lateral.size, 5e-3);
    assert!((limits.orientation.size.to_degrees() - 5.0).abs() < 0.01);
    limits.lateral.size = c.compensation.lateral.size;
    limits.orientation.size = c.compensation.orientation.size;
    clamped.external.force.max_correction = c.external.force.max_correction;
    clamped.laws = c.laws.clone();
    assert_eq!(clamped, c);
    let s = Sensors::parse(SENSORS, "sensors.toml").unwrap();
    assert_eq!(s.encoder_resolution, [2e-6; 6]);
    assert_eq!((s.force.noise_force, s.force.noise_moment, s.force.delay), (25.0, 8.0, 0.002));
}

/// One mistake: in this text, this becomes that, and the rendered error names the line and contains
/// all of these.
#[track_caller]
fn mistake(text: &str, from: &str, to: &str, needles: &[&str]) {
    let broken = text.replacen(from, to, 1);
    assert_ne!(broken, text, "the fixture no longer holds `{from}`");
    let error = parse(&broken, "dir/file.toml").expect_err(to);
    let shown = rendered(&error);
    let line =
        format!("dir/file.toml:{}:", text[..text.find(from).unwrap()].matches('\n').count() + 1);
    for needle in [&[line.as_str()], needles].concat() {
        assert!(shown.contains(needle), "`{needle}` is not in:\n{shown}");
    }
    assert!(shown.contains("expected") || shown.contains("not TOML"), "{shown}");
    assert!(!error.help_text().is_empty());
}

#[test]
fn broken_toml_is_shown_at_its_place() {
    mistake(ROBOT, "name = \"A1\"", "name = \"A1", &["not TOML", "\"A1"]);
    mistake(ROBOT, "mass_kg = 558.0", "mass_kg = 558,0", &["not TOML", "read `mass_kg = 558,0`"]);
    mistake(ROBOT, "mass_kg = 485.0", "max_torque_nm = 485.0", &["not TOML", "duplicate"]);
    let error = parse(URDF, "arm.toml").unwrap_err();
    assert!(rendered(&error).contains("XML"), "{error:?}");
}

#[test]
fn unknown_keys_are_refused_with_the_likely_one() {
    let likely =
        ["unknown key `stifness_nm_rad`", "[[joint]] 1 (A1)", "Did you mean `stiffness_nm_rad`?"];
    mistake(ROBOT, "stiffness_nm_rad = 13", "stifness_nm_rad = 13", &likely);
    mistake(ROBOT, "[tool]", "[tol]", &["unknown key `tol`", "Did you mean `tool`?"]);
    mistake(ROBOT, "xx = 4.5", "ixx = 4.5", &["unknown key `ixx`", "`inertia_kg_m2` in [tool]"]);
    mistake(
        PROCESS,
        "in_plane = 0.03",
        "inplane = 0.03",
        &["[[ripple]] 2", "Did you mean `in_plane`?"],
    );
    let wrong = ["unknown key `colour`", "[compensation]", "`following_rad_s`"];
    mistake(CONTROL, "following_max_m", "colour", &wrong);
}

#[test]
fn gains_of_a_law_are_checked_where_they_stand() {
    let near = ["unknown key `seam-trackin` in [law]", "Did you mean `seam-tracking`?"];
    mistake(CONTROL, "law.seam-tracking", "law.seam-trackin", &near);
    let near = ["unknown key `rate_rads`", "`seam-tracking` in [law]", "`rate_rad_s`"];
    mistake(CONTROL, "rate_rad_s = 4.5", "rate_rads = 4.0", &near);
    let text = ["`rate_rad_s`", "in rad/s"];
    mistake(CONTROL, "rate_rad_s = 4.5", "rate_rad_s = \"fast\"", &text);
    let nyquist = ["`wrench_filter_hz`", "is 50.0", "below half the control rate"];
    mistake(CONTROL, "wrench_filter_hz = 5.0", "wrench_filter_hz = 50.0", &nyquist);
    mistake(CONTROL, "share = 1.0", "share = 1.5", &["is 1.5", "at most 1"]);
    let combination = "[law.\"observer+feed-forward\"]\nfirst_owns = [\"w\"]\n[law.learning]";
    mistake(CONTROL, "[law.learning]", combination, &["\"w\" is no direction"]);
    let part = "[law.\"observer+feed-forwrd\"]\n[law.learning]";
    mistake(CONTROL, "[law.learning]", part, &["unknown key `observer+feed-forwrd` in [law]"]);
}

#[test]
fn a_gain_that_the_control_file_leaves_out_has_its_default() {
    use trueweld_compensators::{GainTables, find};
    let stated = Control::parse(CONTROL, "control.toml").unwrap();
    let silent = CONTROL.split("\n[law.elastostatic]").next().unwrap();
    let silent = Control::parse(silent, "control.toml").unwrap();
    assert_eq!(silent.laws, GainTables::new());
    // The fixture states every default.
    for name in stated.laws.keys() {
        let law = find(name).unwrap();
        assert_eq!(law.gains(&stated.laws), law.gains(&silent.laws), "{name}");
    }
    let one = CONTROL.replacen("rate_rad_s = 4.5", "", 1).replacen(
        "seam_shape_s_m = 0.0",
        "seam_shape_s_m = 25",
        1,
    );
    let gains =
        find("seam-tracking").unwrap().gains(&Control::parse(&one, "control.toml").unwrap().laws);
    assert_eq!(gains["rate_rad_s"].as_float(), Some(4.5));
    assert_eq!(gains["seam_shape_s_m"].as_float(), Some(25.0));
}

#[test]
fn missing_keys_name_the_table_at_its_header() {
    let friction = ["missing key `viscous_nms_rad` in [friction]", "in N·m·s/rad"];
    mistake(ROBOT, "[friction]\nviscous_nms_rad", "[friction]\n#", &friction);
    let encoder = ["missing key `resolution_rad` in [encoder]", "in rad"];
    mistake(SENSORS, "[encoder]\nresolution_rad", "[encoder]\n#", &encoder);
    mistake(
        PROCESS,
        "[[ripple]]\norder = 1",
        "[[ripple]]",
        &["missing key `order` in [[ripple]] 1"],
    );
}

#[test]
fn a_missing_top_level_key_names_the_file() {
    let error =
        Weld::parse(&VERTICAL.replace("feed_m_s = 0.010", ""), "dir/weld.toml").unwrap_err();
    let shown = rendered(&error);
    for needle in ["dir/weld.toml", "missing key `feed_m_s` at the top level", "m/s", "expected"] {
        assert!(shown.contains(needle), "{shown}");
    }
}

#[test]
fn a_rigid_drive_swings_far_above_any_motion_and_an_unknown_rotor_matches_its_link() {
    let damped = ROBOT.replacen("= 13.0e6", "= \"rigid\"", 1);
    let shown = rendered(&RobotFile::parse(&damped, "robot.toml").unwrap_err());
    for needle in ["robot.toml:22:", "`damping_nms_rad`", "(A1)", "nothing beside a rigid drive"] {
        assert!(shown.contains(needle), "{shown}");
    }
    let mut lines = ROBOT.lines().map(str::to_owned).collect::<Vec<_>>();
    for key in ["damping_nms_rad", "stiffness_nm_rad", "rotor_inertia_kg_m2"] {
        let last = lines.iter().rposition(|line| line.starts_with(key)).unwrap();
        match key {
            "damping_nms_rad" => drop(lines.remove(last)),
            "stiffness_nm_rad" => lines[last] = "stiffness_nm_rad = \"rigid\"".to_owned(),
            _ => lines[last] = "rotor_inertia_kg_m2 = \"unknown\"".to_owned(),
        }
    }
    let robot = RobotFile::parse(&lines.join("\n"), "robot.toml").unwrap();
    assert_eq!(robot.rigid, [false, false, false, false, false, true]);
    assert_eq!(robot.unknown_rotor, robot.rigid);
    let last = &robot.parameters.joints[5];
    // The link's inertia about the last axis is the tool's and its own, wherever the arm stands.
    let felt = last.rotor_inertia;
    let inverse = robot.robot.crba(&robot.robot.frames(&JointVector::zeros())).try_inverse();
    let here = 1.0 / inverse.unwrap()[(5, 5)];
    // It depends on the posture by what the other free joints give way.
    assert!((felt / here - 1.0).abs() < 0.05, "{felt}, {here}");
    let rate = (last.stiffness / felt).sqrt();
    assert!((rate / std::f64::consts::TAU - 500.0).abs() < 1e-6, "{rate}");
    let stated = RobotFile::parse(ROBOT, "robot.toml").unwrap();
    assert_eq!(robot.parameters.joints[..5], stated.parameters.joints[..5]);
}

#[test]
fn wrong_types_say_what_was_read() {
    let origin = "origin_m = [0.5, 0.0, 1.045]";
    mistake(
        ROBOT,
        "mass_kg = 485.0",
        "mass_kg = \"heavy\"",
        &["\"heavy\"", "a number from 0 to 1e6 in kg", "(A2)"],
    );
    mistake(ROBOT, origin, "origin_m = 0.5", &["`origin_m`", "a list of 3 numbers in m"]);
    mistake(ROBOT, origin, "origin_m = [0.5, 1.045]", &["has 2 entries", "3 numbers"]);
    mistake(ROBOT, origin, "origin_m = [0.5, true, 1.045]", &["entry 2 of `origin_m`", "true"]);
    mistake(
        ROBOT,
        "name = \"A3\"",
        "name = 3",
        &["`name` in [[joint]] 3", "is 3", "expected text"],
    );
    mistake(
        ROBOT,
        "inertia_kg_m2 = { xx = 31",
        "inertia_kg_m2 = 31 # { xx",
        &["is 31", "expected a table"],
    );
    mistake(SENSORS, "seed = 1", "seed = 1.5", &["is 1.5", "a whole number"]);
    mistake(SENSORS, "seed = 1", "seed = -1", &["is -1", "a whole number"]);
    mistake(VERTICAL, "feed_m_s = 0.010", "feed_m_s = 2026-01-01", &["is 2026-01-01"]);
    mistake(
        PROCESS,
        "schema = \"process/1\"",
        "schema = 1",
        &["`schema` at the top level is 1", "expected text"],
    );
}

#[test]
fn numbers_out_of_range_are_underlined() {
    let stiffness = "stiffness_nm_rad = 13.0e6";
    let range = "a number from 1 to 1e11 in N·m/rad";
    mistake(ROBOT, stiffness, "stiffness_nm_rad = -13.0e6", &["is -13.0e6", range]);
    mistake(ROBOT, stiffness, "stiffness_nm_rad = nan", &["is nan", range]);
    mistake(ROBOT, stiffness, "stiffness_nm_rad = 5e-324", &["is 5e-324", range]);
    mistake(ROBOT, "com_m = [0.453", "com_m = [-inf", &["entry 1 of `com_m`", "is -inf", "-20 to"]);
    mistake(ROBOT, "mass_kg = 485.0", "mass_kg = 1e400", &["is 1e400"]);
    mistake(ROBOT, "mass_kg = 485.0", "mass_kg = 1e12", &["is 1e12", "0 to 1e6 in kg"]);
    mistake(ROBOT, "mass_kg = 485.0", "mass_kg = 1e200", &["is 1e200", "at most 1e12"]);
    mistake(ROBOT, "max_speed_deg_s = 40.0", "max_speed_deg_s = 1e-6", &["is 1e-6", "deg/s"]);
    mistake(ROBOT, "damping_nms_rad = 8600.0", "damping_nms_rad = -1", &["is -1", "N·m·s/rad"]);
    mistake(VERTICAL, "feed_m_s = 0.010", "feed_m_s = 10", &["is 10", "from 1e-6 to 1 in m/s"]);
    mistake(VERTICAL, "force_n = 18000.0", "force_n = 0", &["is 0", "from 1 to 1e7 in N"]);
    mistake(VERTICAL, "settle_s = 2.0", "settle_s = 1e12", &["is 1e12", "in s"]);
    let pin = "pin_diameter_m = 0.005";
    mistake(PROCESS, pin, "pin_diameter_m = 5.0", &["is 5.0", "to 0.2 in m"]);
    let depth = "depth_stiffness_n_m = 30.0e6";
    mistake(PROCESS, depth, "depth_stiffness_n_m = 1e-6", &["is 1e-6", "1000 to 1e11 in N/m"]);
    let spindle = "spindle_rad_s = -62.83185307179586";
    mistake(PROCESS, spindle, "spindle_rad_s = 1e12", &["is 1e12", "-3200 to 3200 in rad/s"]);
    mistake(SENSORS, "delay_s = 0.002", "delay_s = -0.002", &["is -0.002", "from 0 to 1 in s"]);
    let gain = "force_ki_m_ns = 5.4e-7";
    mistake(CONTROL, gain, "force_ki_m_ns = -2.0e-8", &["[external]", "m/(N·s)"]);
    let material = "material_stiffness_n_m = 30.0e6";
    mistake(CONTROL, material, "material_stiffness_n_m = 0.0", &["[external]", "in N/m"]);
    mistake(
        CONTROL,
        "tuned_stiffness_n_m",
        "tuned_stiffness",
        &["unknown key `tuned_stiffness`", "`tuned_stiffness_n_m`"],
    );
    mistake(CONTROL, "period_s = 0.012", "period_s = 1e-9", &["is 1e-9", "to 1 in s"]);
}

#[test]
fn a_value_that_is_possible_and_not_plausible_is_told_once() {
    let name = "a push of three hundred kilonewtons.toml";
    let text = VERTICAL.replace("force_n = 18000.0", "force_n = 3e5");
    for _ in 0..2 {
        Weld::parse(&text, name).unwrap();
    }
    let told: Vec<_> = warnings().into_iter().filter(|w| w.starts_with(name)).collect();
    let line = VERTICAL.lines().position(|l| l.starts_with("force_n")).unwrap() + 1;
    let expected = format!(
        "{name}:{line}:11: `force_n` at the top level is 3e5; plausible are 500 to 50000 N (depth force)"
    );
    assert_eq!(told, [expected]);
}

/// What a process and a weld planned with it are warned of, by the name that both have.
fn warned(process: &str, weld: &str, name: &str) -> Vec<String> {
    let process = Process::parse(process, name).unwrap();
    let weld = Weld::parse(weld, name).unwrap();
    check_weld(&weld, &process, |key| format!("{name}: {key}"));
    warnings().into_iter().filter(|w| w.starts_with(name)).collect()
}

#[test]
fn nothing_off_by_a_factor_of_ten_is_plausible() {
    const BUTT: &str = include_str!("../../../../fixtures/processes/butt-weld-6061.toml");
    const KR210: &str = include_str!("../../../../fixtures/welds/kr210.toml");
    // A ratio and a ripple have no unit to be mistaken, and one that is smaller is another process.
    let of_process = [
        "depth_stiffness_n_m",
        "depth_damping_ns_m",
        "feed_drag_ns_m",
        "lateral_damping_ns_m",
        "lateral_stiffness_n_m",
        "memory_length_m",
        "reference_force_n",
        "spindle_rad_s",
        "pin_diameter_m",
    ];
    let of_weld = ["feed_m_s", "force_n"];
    let times = |text: &str, key: &str, factor: f64| {
        let line = text.lines().find(|line| line.starts_with(key)).unwrap();
        let value = line.split_once('=').unwrap().1.split('#').next().unwrap().trim();
        let value: f64 = value.parse().unwrap();
        text.replace(line, &format!("{key} = {:?}", value * factor))
    };
    for (cell, process, weld) in [("lap", PROCESS, VERTICAL), ("butt", BUTT, KR210)] {
        assert_eq!(warned(process, weld, &format!("{cell} as it is.toml")), [""; 0]);
        for factor in [0.1, 10.0] {
            let name = |key: &str| format!("{cell}, {key} times {factor}.toml");
            for key in of_process {
                assert!(
                    !warned(&times(process, key, factor), weld, &name(key)).is_empty(),
                    "{}",
                    name(key)
                );
            }
            for key in of_weld {
                assert!(
                    !warned(process, &times(weld, key, factor), &name(key)).is_empty(),
                    "{}",
                    name(key)
                );
            }
        }
    }
    // Turns a minute in the place of rad/s.
    let rpm = times(PROCESS, "spindle_rad_s", 60.0 / std::f64::consts::TAU);
    let told = warned(&rpm, VERTICAL, "turns a minute.toml");
    assert!(told.iter().any(|w| w.contains("`spindle_rad_s`")), "{told:?}");
}

#[test]
fn numbers_that_do_not_fit_each_other_are_told_at_their_place() {
    let name = "a drag of another unit.toml";
    let told = warned(&PROCESS.replace("= 4.0e5 ", "= 4.0e3 "), VERTICAL, name);
    let line = PROCESS.lines().position(|l| l.starts_with("feed_drag")).unwrap() + 1;
    let expected = format!(
        "{name}:{line}:1: `feed_drag_ns_m` does not fit `reference_force_n`: drag along the weld per feed and push is \
         0.222 s/m; plausible are 3 to 150 s/m"
    );
    assert_eq!(told.first(), Some(&expected), "{told:#?}");
}

#[test]
fn nothing_in_the_fixtures_is_implausible() {
    RobotFile::read(fixture("robots/kr500-mt.toml")).unwrap();
    for (process, welds) in [
        ("lap-weld-2024-t3", &["vertical", "inclined", "coupon", "panel-stringer"][..]),
        ("butt-weld-6061", &["kr210"]),
    ] {
        let process = Process::read(fixture(&format!("processes/{process}.toml"))).unwrap();
        for weld in welds.iter().map(|name| fixture(&format!("welds/{name}.toml"))) {
            let place = |key: &str| format!("{}: {key}", weld.display());
            check_weld(&Weld::read(&weld).unwrap(), &process, place);
        }
    }
    Control::read(fixture("control/kr500-mt.toml")).unwrap();
    Sensors::read(fixture("sensors/kr500-mt.toml")).unwrap();
    for campaign in ["backlash", "nothing-missing", "kr300-measured"] {
        ModelFile::read(fixture(&format!("campaigns/{campaign}/model.toml"))).unwrap();
    }
    let told: Vec<_> = warnings().into_iter().filter(|w| w.contains("fixtures/")).collect();
    assert!(told.is_empty(), "{told:#?}");
}

#[test]
fn a_model_that_is_no_robot_is_traced_to_its_line() {
    mistake(
        ROBOT,
        "axis = [0, 0, -1]",
        "axis = [0, 0, -2]",
        &["[[joint]] 1 (A1)", "a vector of length 1, not 2"],
    );
    mistake(
        ROBOT,
        "limits_deg = [-130.0, 20.0]",
        "limits_deg = [20.0, -130.0]",
        &["(A2)", "lower limit below"],
    );
    mistake(ROBOT, "{ xx = 13.32", "{ xx = 913.32", &["(A2)", "principal moments"]);
    mistake(ROBOT, "{ xx = 4.5", "{ xx = 99", &["in [tool]", "is { xx = 99", "principal moments"]);
    mistake(
        ROBOT,
        "y_axis = [0, 1, 0]",
        "y_axis = [1, 0, 0]",
        &["`y_axis` in [tool]", "square to each other"],
    );
    mistake(ROBOT, "z_axis = [1, 0, 0]", "z_axis = [1, 1, 0]", &["`z_axis` in [tool]", "length 1"]);
    mistake(ROBOT, "name = \"A3\"", "name = \"A2\"", &["is \"A2\"", "no other joint has"]);
    mistake(ROBOT, "name = \"A3\"", "name = \" \"", &["not blank"]);
    mistake(ROBOT, "name = \"A3\"", "name = \"A\\n3\"", &["on one line"]);
    let nine = "cos_nm = [1, 2, 3, 4, 5, 6, 7, 8, 9]";
    mistake(ROBOT, "cos_nm = [-9000.0, -80.0, 290.0]", nine, &["9 entries", "at most 8"]);
}

#[test]
fn a_counterbalance_has_a_phase_or_a_table() {
    let series = "cos_nm = [-9000.0, -80.0, 290.0]";
    let torque = |to: &str, q: f64| {
        let text = ROBOT.replace(series, to);
        RobotFile::parse(&text, "a.toml").unwrap().robot.counterbalance_torque(q)
    };
    let phase = format!("{series}\nphase_rad = 0.3");
    assert!((torque(&phase, 0.8) - torque(series, 0.5)).abs() < 1e-9);
    let table = "angle_deg = [-90, -45, 0]\ntorque_nm = [-1e3, -7e3, -9e3]";
    assert!((torque(table, -45_f64.to_radians()) + 7e3).abs() < 1e-9);
    let uneven = "torque_nm = [-1e3, -7e3]\nangle_deg = [-90, -45, 0]";
    mistake(ROBOT, series, uneven, &["`torque_nm` in [counterbalance]", "as many numbers"]);
    let falling = "angle_deg = [0, -45]\ntorque_nm = [-1e3, -7e3]";
    mistake(ROBOT, series, falling, &["`angle_deg`", "rising angles"]);
}

#[test]
fn a_robot_has_six_joints() {
    let (head, tail) = ROBOT.split_at(ROBOT.find("# Friction").unwrap());
    let last = &head[head.rfind("[[joint]]").unwrap()..];
    let seven = format!("{head}{}\n{tail}", last.replace("A6", "A7"));
    let five = format!("{}{tail}", &head[..head.rfind("[[joint]]").unwrap()]);
    for (text, count) in [(seven, "7 joints"), (five, "5 joints")] {
        let shown = rendered(&RobotFile::parse(&text, "dir/robot.toml").unwrap_err());
        assert!(
            shown.contains(count)
                && shown.contains("expected 6")
                && shown.contains("dir/robot.toml:"),
            "{shown}"
        );
    }
}

#[test]
fn a_robot_without_inertia_about_its_last_axis_is_refused() {
    let zero = "{ xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0 }";
    let text = ROBOT
        .replace("{ xx = 0.034, yy = 0.018, zz = 0.018, xy = 0.0, xz = 0.0, yz = 0.0 }", zero)
        .replace("{ xx = 4.5, yy = 9.0, zz = 9.0, xy = 0.0, xz = 0.0, yz = 0.0 }", zero);
    let shown = rendered(&RobotFile::parse(&text, "dir/robot.toml").unwrap_err());
    assert!(shown.contains("[[joint]] 6 (A6)") && shown.contains("about the last axis"), "{shown}");
}

#[test]
fn a_weld_needs_a_length_and_a_side() {
    let axis = "tool_axis = [0.0, 0.0, -1.0]";
    mistake(VERTICAL, "end_m = [1.700, 1.000", "end_m = [1.700, -1.000", &["other than `start_m`"]);
    mistake(VERTICAL, axis, "tool_axis = [0.0, -1.0, 0.0]", &["not parallel to the path"]);
    mistake(VERTICAL, axis, "tool_axis = [0.0, 0.0, -1.1]", &["length 1", "[0, 0, -1]"]);
    mistake(VERTICAL, axis, "tool_axis = [0, 0, 0]", &["length 1, not 0"]);
    let leans = "tool_axis = [0.0, 0.0523359562429438, -0.9986295347545738]";
    mistake(VERTICAL, axis, leans, &["square to the path", "3.00°", "lead_deg"]);
}

#[test]
fn another_kind_of_file_is_named() {
    let shown = rendered(&RobotFile::parse(VERTICAL, "dir/weld.toml").unwrap_err());
    for needle in [
        "dir/weld.toml:2:",
        "\"weld/1\", a weld",
        "expected \"robot/1\"",
        "\"sensors/1\" (sensors)",
    ] {
        assert!(shown.contains(needle), "`{needle}` is not in {shown}");
    }
    mistake(ROBOT, "robot/1", "robots/1", &["\"robots/1\"", "Did you mean \"robot/1\"?"]);
    let shown = rendered(&parse("name = 3", "dir/none.toml").unwrap_err());
    assert!(shown.contains("missing key `schema`") && shown.contains("\"process/1\""), "{shown}");
    assert!(parse("", "empty.toml").is_err());
}

#[test]
fn a_piece_of_a_large_file_keeps_its_place() {
    let source = Source::piece("big.csv", 1_000_000, "1.5,x7,2.5\nnext");
    assert_eq!(source.error(4..6, "m", "l", "h").place(), "big.csv:1000000:5");
    assert_eq!(source.error(11..12, "m", "l", "h").place(), "big.csv:1000001:1");
    let shown = rendered(&source.error(4..6, "m", "l", "h"));
    assert!(
        shown.contains("[big.csv:1000000:5]") && shown.contains("1000000 │ 1.5,x7,2.5"),
        "{shown}"
    );
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let gone = folder.path().join("gone.toml");
    for error in [
        check(&gone).unwrap_err(),
        RobotFile::read(&gone).unwrap_err(),
        import_urdf(&gone).unwrap_err(),
    ] {
        assert!(rendered(&error).contains("gone.toml: cannot be read"), "{error}");
    }
    let binary = folder.path().join("binary.toml");
    fs::write(&binary, b"schema = \"weld/1\"\n\xff\xfe").unwrap();
    let shown = rendered(&check(&binary).unwrap_err());
    assert!(
        shown.contains("binary.toml:2:1") && shown.contains("0xff") && shown.contains("UTF-8"),
        "{shown}"
    );
    assert!(check(folder.path()).is_err(), "a folder");
}

#[test]
fn written_files_are_whole_and_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("result.json");
    write_atomically(&path, b"one").unwrap();
    write_atomically(&path, b"two").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"two");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let error = write_atomically(folder.path().join("none/result.json"), b"x").unwrap_err();
    assert!(error.to_string().contains("result.json cannot be written"), "{error}");
    assert!(write_atomically(folder.path(), b"x").is_err(), "a folder");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    #[cfg(unix)]
    {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let plain = folder.path().join("plain");
        fs::write(&plain, b"").unwrap();
        let mode = |p: &PathBuf| fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&plain), "as readable as any new file");
        let link = folder.path().join("link");
        symlink(&path, &link).unwrap();
        write_atomically(&link, b"three").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"three");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}

#[test]
fn controllers_and_sensors_are_read_by_their_tables() {
    let control = Control::parse(CONTROL, "control.toml").unwrap();
    for kind in ControllerKind::required() {
        assert_eq!(ControllerKind::find(kind.name()), Ok(kind));
        assert!(kind.joint_gains(&control).unwrap().kp.iter().all(|k| *k > 0.0), "{}", kind.name());
        assert!(kind.build(&control).is_some());
        // A table that is missing is told by its name.
        let without = CONTROL.replace(&format!("[{}]", kind.name()), "[compensations]");
        let error = Control::parse(&without, "control.toml").unwrap_err().to_string();
        assert!(error.contains("compensations"), "{error}");
    }
    assert_eq!(ControllerKind::find("extern"), Err(Some("external")));
    // Every number that a table states is of that table, and is reached by its key.
    let mut read = Sensors::read(fixture("sensors/seam-at-the-tool.toml")).unwrap();
    for sensor in sensors() {
        for (key, of) in sensor.numbers {
            assert!(key.starts_with(&format!("{}.", sensor.name)), "{key}");
            assert!([1, 3, 6].contains(&of(&mut read).len()), "{key}");
        }
    }
    assert_eq!(sensor_numbers().len(), 26);
}

#[test]
fn what_a_model_asks_of_its_predictions_is_read_and_written_again() {
    let path = fixture("models/cable-drag.toml");
    let given = fs::read_to_string(&path).unwrap();
    let asked = "\n[accuracy]\ntcp_position_m = 1e-4\nforce_n = 50.0\n";
    let model = ModelFile::parse(&(given.clone() + asked), &path).unwrap();
    let said = [("tcp_position_m", 1e-4), ("force_n", 50.0)];
    assert_eq!(model.accuracy.entries().collect::<Vec<_>>(), said);
    let again =
        ModelFile::parse(&model.to_toml(path.parent().unwrap(), &Default::default()), &path);
    assert_eq!(again.unwrap().accuracy, model.accuracy);
    for (wrong, needles) in [
        ("tcp_position_mm = 0.1", &["unknown key", "Did you mean `tcp_position_m`?"][..]),
        ("tcp_position_m = 0.0", &["[accuracy]", "tcp_position_m"]),
        ("tcp_position_m = 10.0", &["[accuracy]", "tcp_position_m"]),
        ("force_n = \"50 N\"", &["[accuracy]", "force_n"]),
    ] {
        let error =
            ModelFile::parse(&format!("{given}\n[accuracy]\n{wrong}\n"), &path).unwrap_err();
        let shown = rendered(&error);
        needles.iter().for_each(|needle| assert!(shown.contains(needle), "{needle}: {shown}"));
    }
}
