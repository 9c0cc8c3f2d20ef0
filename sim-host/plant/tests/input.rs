//! The input layer: the fixtures read as written, every class of mistake is explained at its place,
//! and no input whatever makes a reader panic.

use miette::{GraphicalReportHandler, GraphicalTheme};
use nalgebra::{Matrix3, Matrix4, Rotation3, Vector3, Vector4};
use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use trueweld_plant::input::*;

const ROBOT: &str = include_str!("../../../fixtures/robots/kr500-mt.toml");
const PROCESS: &str = include_str!("../../../fixtures/processes/lap-weld-2024-t3.toml");
const VERTICAL: &str = include_str!("../../../fixtures/welds/vertical.toml");
const INCLINED: &str = include_str!("../../../fixtures/welds/inclined.toml");
const JOGGLE: &str = include_str!("../../../fixtures/welds/panel-joggle-off.toml");
const CONTROL: &str = include_str!("../../../fixtures/control/kr500-mt.toml");
const SENSORS: &str = include_str!("../../../fixtures/sensors/kr500-mt.toml");
const URDF: &str = include_str!("../../../fixtures/robots/arm6.urdf");

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
    match Document::parse(text, name)?.kind()? {
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
    Document::parse(&text, &name)?.kind()
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
    assert_eq!((p.depth_stiffness, p.depth_damping), (30e6, 1.5e6));
    assert_eq!((p.memory_length, p.lateral_ratio, p.pin_diameter), (0.008, 0.25, 0.005));
    assert!(
        (p.spindle + 20.0 * std::f64::consts::PI).abs() < 1e-12,
        "600 rpm, against the tool's z"
    );
    assert_eq!(p.ripple.len(), 2);
    assert_eq!(p.ripple[1], Ripple { order: 2.0, axial: 0.005, in_plane: 0.03, phase: 0.7 });
    // The load case that the file says it is calibrated to: 4 kN of drag and 1 kN across at 10
    // mm/s.
    assert!((p.feed_drag * 0.010 - 4000.0).abs() < 1e-9);
    assert!((p.lateral_ratio * p.feed_drag * 0.010 - 1000.0).abs() < 1e-9);
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
        "{name}:{line}:11: `force_n` at the top level is 3e5; plausible are 100 to 1e5 N (depth force)"
    );
    assert_eq!(told, [expected]);
}

#[test]
fn nothing_in_the_fixtures_is_implausible() {
    RobotFile::read(fixture("robots/kr500-mt.toml")).unwrap();
    Process::read(fixture("processes/lap-weld-2024-t3.toml")).unwrap();
    Weld::read(fixture("welds/vertical.toml")).unwrap();
    Weld::read(fixture("welds/inclined.toml")).unwrap();
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

/// The imported text with its markers filled in.
fn filled(text: &str) -> String {
    let fill = |line: &str| match line.split_once(" = \"FILL IN") {
        None => format!("{line}\n"),
        Some((key, _)) => {
            let value = match key {
                "gravity_m_s2" => "[0.0, 0.0, -9.80665]",
                "cos_nm" => "[]",
                "viscous_nms_rad" | "coulomb_nm" => "[1, 1, 1, 1, 1, 1]",
                _ => "1.0",
            };
            format!("{key} = {value}\n")
        }
    };
    text.lines().map(fill).collect()
}

#[test]
fn an_imported_urdf_keeps_its_bodies_and_geometry() {
    let text = import_urdf(fixture("robots/arm6.urdf")).unwrap();
    let file = RobotFile::parse(&filled(&text), "arm6.toml").unwrap();
    assert_eq!(file.name, "arm6");
    let p = &file.parameters;
    assert_eq!(p.joints.map(|j| j.mass), [900.0, 550.0, 600.0, 120.0, 80.0, 250.0]);
    assert_eq!(p.joints.map(|j| j.mass).iter().sum::<f64>(), 2500.0);
    let expected = [
        (Vector3::new(0.0, 0.0, 0.675), Vector3::z()),
        (Vector3::new(0.5, 0.0, 0.37), Vector3::y()),
        (Vector3::new(0.0, 0.0, 1.3), Vector3::y()),
        (Vector3::new(1.025, 0.0, -0.055), Vector3::x()),
        (Vector3::new(0.25, 0.0, 0.0), Vector3::y()),
        (Vector3::new(0.29, 0.0, 0.0), Vector3::x()),
    ];
    for (i, (j, (origin, axis))) in p.joints.iter().zip(expected).enumerate() {
        assert!((j.origin - origin).norm() < 1e-11, "origin of joint {i}");
        assert_eq!(j.axis, axis);
        assert!((j.limits[1] - 6.0).abs() < 1e-12 && (j.max_rate - 10.0).abs() < 1e-11);
        assert_eq!(j.max_torque, 1e6);
    }
    assert!((p.joints[5].center_of_mass - Vector3::new(0.25, 0.0, -0.1)).norm() < 1e-11);
    assert!((p.joints[2].inertia.diagonal() - Vector3::new(30.0, 120.0, 115.0)).norm() < 1e-11);
    // The tool frame: 0.4 m on, 0.15 m down, turned by 45 degrees about y.
    let half = 0.5f64.sqrt();
    assert!(
        (p.tool.flange_offset + p.tool.tcp_from_flange - Vector3::new(0.4, 0.0, -0.15)).norm()
            < 1e-11
    );
    assert!((p.tool.z_axis - Vector3::new(half, 0.0, half)).norm() < 1e-11);
    assert_eq!((p.tool.y_axis, p.tool.mass), (Vector3::y(), 0.0));
}

#[test]
fn the_shipped_arm_is_its_urdf_filled_in() {
    let text = import_urdf(fixture("robots/kr210-r2700.urdf")).unwrap();
    let (robot, tool) = text.split_once("[tool]").unwrap();
    let filled = std::fs::read_to_string(fixture("robots/kr210-fsw.toml")).unwrap();
    for line in robot.lines().filter(|line| line.contains(" = ") && !line.starts_with('#')) {
        let (key, value) = line.split_once(" = ").unwrap();
        if value.contains("FILL IN") {
            let of = |l: &&str| l.starts_with(key) && l.ends_with("# filled in");
            assert!(filled.lines().any(|l| of(&l)), "{key}");
        } else if !value.contains("KR 210") {
            assert!(filled.lines().any(|l| l == line), "{line}");
        }
    }
    let offset = tool.lines().find(|line| line.starts_with("flange_offset_m")).unwrap();
    assert!(filled.lines().any(|line| line == offset));
    let file = RobotFile::read(fixture("robots/kr210-fsw.toml")).unwrap();
    // 645 + 1150 + 115 mm up with the upper arm upright, 330 + 1220 + 215 + 350 mm out.
    let upright = [0.0, -90.0_f64.to_radians(), 90.0_f64.to_radians(), 0.0, 0.0, 0.0];
    let tool = file.robot.forward_kinematics(&upright.into()).position;
    assert!((tool - Vector3::new(2.115, 0.0, 1.91)).norm() < 1e-9, "{tool}");
}

#[test]
fn what_a_urdf_cannot_say_must_be_filled_in() {
    let text = import_urdf_text(URDF, "arm6.urdf").unwrap();
    for key in [
        "gravity_m_s2",
        "stiffness_nm_rad",
        "damping_nms_rad",
        "rotor_inertia_kg_m2",
        "viscous_nms_rad",
        "coulomb_nm",
        "smoothing_rad_s",
        "cos_nm",
    ] {
        let start = format!("{key} = ");
        let marker =
            text.lines().find(|l| l.starts_with(&format!("{start}\"FILL IN: "))).expect(key);
        // Everything filled in but this one value: the reader names it.
        let rest =
            |line: &str| format!("{}\n", if line.starts_with(&start) { marker } else { line });
        let left: String = filled(&text).lines().map(rest).collect();
        let shown = rendered(&RobotFile::parse(&left, "dir/arm.toml").unwrap_err());
        for needle in ["dir/arm.toml:", key, "still to be filled in", "expected"] {
            assert!(shown.contains(needle), "{shown}");
        }
    }
}

/// A URDF in which every frame is turned and every link is split in two by a fixed joint.
fn turned_urdf() -> String {
    let mut xml = r#"<robot name="turned"><link name="world"/><link name="base"/>
        <joint name="floor" type="fixed"><parent link="world"/><child link="base"/>
        <origin xyz="0 0 0.2" rpy="0 0 1.5707963267948966"/></joint>"#
        .to_owned();
    let mut parent = "base".to_owned();
    for i in 1..=6 {
        xml += &format!(
            r#"<link name="l{i}"><inertial><origin xyz="0.1 0.2 0.3" rpy="0.3 -0.2 0.5"/><mass value="{i}0"/>
            <inertia ixx="3" iyy="4" izz="5" ixy="0.1" ixz="-0.2" iyz="0.3"/></inertial></link>
            <link name="m{i}"><inertial><origin xyz="0 0 0.1"/><mass value="2"/>
            <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
            <joint name="j{i}" type="revolute"><parent link="{parent}"/><child link="l{i}"/>
            <origin xyz="0.5 -0.1 0.2" rpy="0.4 0.5 -0.6"/><axis xyz="0 0 2"/>
            <limit lower="-1" upper="2" effort="30" velocity="4"/></joint>
            <joint name="f{i}" type="fixed"><parent link="l{i}"/><child link="m{i}"/>
            <origin xyz="0.3 0 0" rpy="1.5707963267948966 0 0"/></joint>"#
        );
        parent = format!("m{i}");
    }
    xml + r#"<link name="tool0"/><joint name="t" type="fixed"><parent link="m6"/><child link="tool0"/></joint></robot>"#
}

/// The turned arm against sums over its bodies, each placed by a product of homogeneous transforms.
#[test]
fn links_are_merged_and_turned_into_base_axes() {
    let transform = |x: [f64; 3], [roll, pitch, yaw]: [f64; 3]| {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), pitch)
            * Rotation3::from_axis_angle(&Vector3::x_axis(), roll);
        Matrix4::new_translation(&Vector3::from(x)) * turn.to_homogeneous()
    };
    let column = |m: &Matrix4<f64>, i: usize| Vector3::new(m[(0, i)], m[(1, i)], m[(2, i)]);
    let quarter = std::f64::consts::FRAC_PI_2;
    let text = import_urdf_text(&turned_urdf(), "t.urdf").unwrap();
    let file = RobotFile::parse(&filled(&text), "t.toml").unwrap();
    let uneven = Matrix3::new(3.0, 0.1, -0.2, 0.1, 4.0, 0.3, -0.2, 0.3, 5.0);
    // A symmetric tensor is fixed by the energy of turning about the axes and about the diagonals
    // between them.
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let turns = [x, y, z, x + y, x + z, y + z];

    let mut parent = transform([0.0, 0.0, 0.2], [0.0, 0.0, quarter]);
    let mut origin = Vector3::zeros();
    for (i, j) in file.parameters.joints.iter().enumerate() {
        let l = parent * transform([0.5, -0.1, 0.2], [0.4, 0.5, -0.6]);
        let m = l * transform([0.3, 0.0, 0.0], [quarter, 0.0, 0.0]);
        let at = column(&l, 3);
        assert!((j.origin - (at - origin)).norm() < 1e-11, "origin of joint {i}");
        assert!((j.axis - (l * Vector4::z()).xyz()).norm() < 1e-11, "axis of joint {i}");
        let bodies = [
            (10.0 * (i + 1) as f64, l * transform([0.1, 0.2, 0.3], [0.3, -0.2, 0.5]), uneven),
            (2.0, m * transform([0.0, 0.0, 0.1], [0.0; 3]), Matrix3::identity()),
        ];
        let mass: f64 = bodies.iter().map(|b| b.0).sum();
        let com =
            bodies.iter().map(|(mass, pose, _)| column(pose, 3) * *mass).sum::<Vector3<f64>>()
                / mass;
        assert!((j.mass - mass).abs() < 1e-12);
        assert!((j.center_of_mass - (com - at)).norm() < 1e-11, "centre of link {i}");
        for w in turns {
            let energy = |(mass, pose, inertia): &(f64, Matrix4<f64>, Matrix3<f64>)| {
                let local = pose.fixed_view::<3, 3>(0, 0).transpose() * w;
                local.dot(&(inertia * local))
                    + mass * w.cross(&(column(pose, 3) - com)).norm_squared()
            };
            let sum: f64 = bodies.iter().map(energy).sum();
            assert!((w.dot(&(j.inertia * w)) - sum).abs() < 1e-9, "inertia of link {i}");
        }
        (parent, origin) = (m, at);
    }
    // tool0 is the flange; it sits on the last link's second half.
    let t = &file.parameters.tool;
    assert!(
        (t.flange_offset - (column(&parent, 3) - origin)).norm() < 1e-11
            && t.tcp_from_flange.norm() < 1e-11
    );
    assert!(
        (t.z_axis - column(&parent, 2)).norm() < 1e-11
            && (t.y_axis - column(&parent, 1)).norm() < 1e-11
    );
}

/// As [`mistake`], in the URDF.
#[track_caller]
fn urdf_mistake(from: &str, to: &str, needles: &[&str]) {
    let broken = URDF.replacen(from, to, 1);
    assert_ne!(broken, URDF, "the fixture no longer holds `{from}`");
    let error = import_urdf_text(&broken, "dir/arm.urdf").expect_err(to);
    let shown = rendered(&error);
    for needle in [&["dir/arm.urdf", "expected"], needles].concat() {
        assert!(shown.contains(needle), "`{needle}` is not in:\n{shown}");
    }
    assert!(!error.help_text().is_empty());
}

#[test]
fn a_urdf_that_is_no_six_axis_arm_is_refused() {
    let a3 = r#"<joint name="A3" type="revolute">"#;
    urdf_mistake(
        a3,
        r#"<joint name="A3" type="prismatic">"#,
        &["dir/arm.urdf:10:", "`A3` is prismatic", "revolute"],
    );
    urdf_mistake(a3, r#"<joint name="A3" type="planar">"#, &["`A3` is planar"]);
    urdf_mistake(a3, r#"<joint name="A3" type="hinge">"#, &["<joint>", "hinge"]);
    urdf_mistake(a3, r#"<joint name="A3" type="fixed">"#, &["5 revolute joints", "expected six"]);
    urdf_mistake(
        r#"name="tool" type="fixed""#,
        r#"name="tool" type="revolute""#,
        &["`tool`", "number 7"],
    );
    let (on_l2, on_l1) = (r#"<parent link="l2"/>"#, r#"<parent link="l1"/>"#);
    urdf_mistake(on_l2, on_l1, &["`A2` and `A3` branch"]);
    urdf_mistake(r#"<parent link="base"/>"#, r#"<parent link="tcp"/>"#, &["not connected"]);
    urdf_mistake(r#"<child link="l1"/>"#, r#"<child link="l2"/>"#, &["hangs on joint"]);
    urdf_mistake(
        r#"<child link="l1"/>"#,
        r#"<child link="l11"/>"#,
        &["`l11`", "Did you mean `l1`?"],
    );
    urdf_mistake(r#"<link name="l2">"#, r#"<link name="l1">"#, &["another link `l1`"]);
    urdf_mistake(
        r#"<link name="tcp"/>"#,
        r#"<link name="tcp"/><link name="table"/>"#,
        &["`base` and `table`"],
    );
    let axis = r#"<axis xyz="0 0 1"/>"#;
    urdf_mistake(axis, r#"<axis xyz="0 0 0"/>"#, &["`A1` is 0 0 0"]);
    let seventh = r#"<link name="l7"><inertial><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="A7" type="revolute"><parent link="tcp"/><child link="l7"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;
    urdf_mistake("</robot>", seventh, &["`A7`", "number 7", "expected six"]);
}

#[test]
fn bad_numbers_and_broken_xml_in_a_urdf_are_shown() {
    let mass = r#"<mass value="550"/>"#;
    urdf_mistake(
        mass,
        r#"<mass value="much"/>"#,
        &["dir/arm.urdf:7:", "`value` of <mass> is \"much\"", "one finite"],
    );
    urdf_mistake(mass, r#"<mass value="-550"/>"#, &["`l2` is -550 kg"]);
    urdf_mistake(mass, "", &["<link>", "mass"]);
    urdf_mistake(r#"iyz="0""#, "", &["<link>", "iyz"]);
    let place = r#"xyz="0.2 0 0.15""#;
    urdf_mistake(place, r#"xyz="0.2 0""#, &["\"0.2 0\"", "3 finite numbers"]);
    urdf_mistake(place, r#"xyz="0.2 nan 0.15""#, &["0.2 nan 0.15"]);
    urdf_mistake(place, r#"xyz="${a} 0 0.15""#, &["${a}"]);
    urdf_mistake(
        r#"<link name="l3"><inertial>"#,
        r#"<link name="l3"><inertia>"#,
        &["well-formed XML"],
    );
    urdf_mistake("</robot>", "", &["still open"]);
    let name = r#"name="l3""#;
    urdf_mistake(name, r#"name="l3"#, &["dir/arm.urdf:"]);
    urdf_mistake(name, r#"name="l3" name="l3""#, &["attribute of <link>"]);
    urdf_mistake(name, r#"name="&none;""#, &["attribute of <link>"]);
    urdf_mistake(r#"<link name="base"/>"#, r#"<xacro:include filename="x"/>"#, &["macro", "xacro"]);
    urdf_mistake(r#"<robot name="arm6">"#, r#"<sdf><robot name="arm6">"#, &["<sdf>"]);
    for text in [
        "",
        "schema = \"robot/1\"",
        "<robot",
        "<robot/>",
        "<a:robot xmlns:a='b'/>",
        "<robot><link/></robot>",
    ] {
        assert!(import_urdf_text(text, "x.urdf").is_err(), "{text}");
    }
    // Depth alone must not exhaust the stack.
    let deep = format!("<robot>{}", "<link name='a'>".repeat(100_000));
    assert!(import_urdf_text(&deep, "deep.urdf").is_err());
}

#[test]
fn what_surrounds_the_arm_in_a_urdf_does_not_matter() {
    let plain = import_urdf_text(URDF, "arm.urdf").unwrap();
    let dressed = URDF.replace("<robot name", "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\" name").replace(
        r#"<link name="base"/>"#,
        r#"<link name="base"><visual><geometry><mesh filename="a.stl"/></geometry></visual></link>
            <transmission name="t"><joint name="A1"><hardwareInterface>x</hardwareInterface></joint></transmission>
            <gazebo reference="l1"><link name="l1"/></gazebo><!-- <joint> -->"#,
    );
    assert_eq!(import_urdf_text(&dressed, "arm.urdf").unwrap(), plain);
}

#[test]
fn joints_that_mimic_others_are_held_or_axes_and_the_file_says_which() {
    let plain = import_urdf_text(URDF, "arm.urdf").unwrap();
    // A finger turned by 0.5 rad and one that slides: fixed to the last link, at their offsets.
    let fingers = r#"<link name="f1"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>
        <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="F1" type="revolute"><parent link="l6"/><child link="f1"/><axis xyz="0 0 1"/>
        <mimic joint="A6" multiplier="-1" offset="0.5"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
        <link name="f2"/><joint name="F2" type="prismatic"><parent link="f1"/><child link="f2"/>
        <axis xyz="1 0 0"/><mimic joint="F1" multiplier="2"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;
    let text = import_urdf_text(&URDF.replace("</robot>", fingers), "arm.urdf").unwrap();
    assert!(
        text.contains("# Joint F1 is held at 0.5 rad: it follows A6 by a factor of -1"),
        "{text}"
    );
    assert!(text.contains("# Joint F2 is held at 0 m: it follows F1 by a factor of 2"), "{text}");
    let last = |text: &str| RobotFile::parse(&filled(text), "a.toml").unwrap().parameters.joints[5];
    let (with, without) = (last(&text), last(&plain));
    assert!((with.mass - without.mass - 2.0).abs() < 1e-12);
    let finger = Vector3::new(0.1 * 0.5_f64.cos(), 0.1 * 0.5_f64.sin(), 0.0);
    let expected = (without.center_of_mass * without.mass + finger * 2.0) / with.mass;
    assert!((with.center_of_mass - expected).norm() < 1e-11);

    let axis = r#"<axis xyz="0 0 1"/>"#;
    let coupled = URDF.replacen(axis, &format!("{axis}<mimic joint=\"A2\"/>"), 1);
    let text = import_urdf_text(&coupled, "arm.urdf").unwrap();
    let said =
        "# Joint A1 is an axis of its own here: that it follows A2 by a factor of 1 is left out.";
    assert!(text.contains(said), "{text}");
    let all = |text: &str| RobotFile::parse(&filled(text), "a.toml").unwrap().parameters;
    assert_eq!(all(&text), all(&plain));
}

#[test]
fn every_entry_still_to_be_filled_in_is_listed_with_its_place_and_meaning() {
    let bare = URDF.replace(
        r#"<mass value="120"/><inertia ixx="2" iyy="6" izz="6" ixy="0" ixz="0" iyz="0"/>"#,
        "",
    );
    let bare = bare.replace(r#"<inertial><origin xyz="0.15 0 0"/></inertial>"#, "");
    let text = import_urdf_text(&bare, "arm.urdf").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.toml");
    fs::write(&path, &text).unwrap();
    let open: Vec<String> = open_entries(&path).unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(open.len(), text.matches("= \"FILL IN").count(), "{open:#?}");
    // Gravity, three values of each drive, three of the link without inertia, friction, weight.
    assert_eq!(open.len(), 1 + 6 * 3 + 3 + 3 + 1);
    let line = text.lines().position(|l| l.starts_with("mass_kg = \"FILL IN")).unwrap() + 1;
    let mass = open.iter().find(|entry| entry.contains("mass_kg")).unwrap();
    for words in [&format!("arm.toml:{line}:11"), "[[joint]] 4 (A4)", "mass of a link", "in kg"] {
        assert!(mass.contains(words), "{words} in {mass}");
    }
    assert_eq!(open_entries(fixture("robots/kr500-mt.toml")).unwrap().len(), 0);
}

#[test]
fn what_a_urdf_leaves_unstated_must_be_filled_in() {
    let endless = URDF.replace(r#"name="A6" type="revolute""#, r#"name="A6" type="continuous""#);
    let text = import_urdf_text(&endless, "arm.urdf").unwrap();
    assert_eq!(text.matches("limits_deg = \"FILL IN").count(), 1);
    let unrated = URDF.replacen(r#"effort="1e6" velocity="10""#, r#"effort="0" velocity="0""#, 1);
    let text = import_urdf_text(&unrated, "arm.urdf").unwrap();
    assert!(
        text.contains("max_torque_nm = \"FILL IN") && text.contains("max_speed_deg_s = \"FILL IN")
    );
    let toolless = URDF.replace("\"tcp\"", "\"end\"");
    assert!(
        import_urdf_text(&toolless, "arm.urdf").unwrap().contains("tcp_from_flange_m = \"FILL IN")
    );
    let flange = import_urdf_text(&URDF.replace("\"tcp\"", "\"flange\""), "arm.urdf").unwrap();
    assert!(
        flange.contains("flange_offset_m = [0.4, 0.0, -0.15]")
            && flange.contains("z_axis = \"FILL IN")
    );
}

/// Runs every reader on a text; the outcome does not matter, only that there is one, and that it
/// can be shown.
fn read_everything(text: &str) {
    let outcomes = [
        RobotFile::parse(text, "x").map(drop),
        Process::parse(text, "x").map(drop),
        Weld::parse(text, "x").map(drop),
        Control::parse(text, "x").map(drop),
        Sensors::parse(text, "x").map(drop),
        parse(text, "x"),
        import_urdf_text(text, "x").map(drop),
    ];
    for error in outcomes.into_iter().filter_map(Result::err) {
        assert!(!rendered(&error).is_empty());
    }
}

/// A fixture with a few bytes replaced, removed or put in, mostly by what numbers and syntax are
/// made of.
fn mutated() -> impl Strategy<Value = Vec<u8>> {
    let fixtures =
        prop::sample::select(vec![ROBOT, PROCESS, VERTICAL, JOGGLE, CONTROL, SENSORS, URDF]);
    let pieces = [
        "-", "e308", "e-320", "nan", "inf", "\"", "[", "]", "{", "}", "=", "\n", "<", ">", "/",
        "&", "é", ".", "9",
    ];
    let piece = prop_oneof![
        prop::sample::select(pieces.map(|s| s.as_bytes().to_vec()).to_vec()),
        prop::collection::vec(any::<u8>(), 0..4),
    ];
    let edits = prop::collection::vec((any::<prop::sample::Index>(), 0..6usize, piece), 1..5);
    (fixtures, edits).prop_map(|(text, edits)| {
        let mut bytes = text.as_bytes().to_vec();
        for (at, cut, put) in edits {
            let at = at.index(bytes.len() + 1);
            let end = (at + cut).min(bytes.len());
            bytes.splice(at..end, put);
        }
        bytes
    })
}

/// A fixture with one to three of its numbers replaced by extreme ones.
fn extreme() -> impl Strategy<Value = String> {
    let fixtures = prop::sample::select(vec![ROBOT, PROCESS, VERTICAL, CONTROL, SENSORS]);
    let numbers = [
        "0",
        "-0.0",
        "1e12",
        "-1e12",
        "1e-320",
        "1e308",
        "nan",
        "-inf",
        "1e-200",
        "1e-160",
        "0x7fffffffffffffff",
    ];
    let edits = prop::collection::vec(
        (any::<prop::sample::Index>(), prop::sample::select(numbers.to_vec())),
        1..4,
    );
    (fixtures, edits).prop_map(|(text, edits)| {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let values: Vec<usize> = (0..lines.len()).filter(|i| lines[*i].contains('=')).collect();
        for (at, number) in edits {
            let line = &mut lines[values[at.index(values.len())]];
            let start = line.find('=').map_or(0, |i| i + 1);
            let digits = |c: char| c.is_ascii_digit() || c == '-';
            let Some(from) = line[start..].find(digits).map(|i| i + start) else {
                continue;
            };
            let length = line[from..]
                .find(|c: char| !"0123456789.eE-+".contains(c))
                .unwrap_or(line.len() - from);
            line.replace_range(from..from + length, number);
        }
        lines.join("\n")
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_text_makes_a_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        read_everything(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn no_mutated_fixture_makes_a_reader_panic(bytes in mutated()) {
        read_everything(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn no_extreme_value_makes_a_reader_panic(text in extreme()) {
        read_everything(&text);
    }

    #[test]
    fn no_file_makes_check_panic(bytes in mutated()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mutated");
        fs::write(&path, bytes).unwrap();
        let _ = check(&path);
        let _ = import_urdf(&path);
    }
}
