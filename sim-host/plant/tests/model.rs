//! Model files: read, written and read back; every mistake explained at its place; whatever text a
//! user may write as an expression, it is either worked out as mathematics has it or refused.

use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use trueweld_plant::effects::expression::Expression;
use trueweld_plant::effects::formula::PORTS;
use trueweld_plant::effects::{
    Effect, EffectKind, Location, LocationKind, Parameter, library, stiffness_error,
};
use trueweld_plant::input::*;
use trueweld_plant::robot::{ElasticRobot, JointState};

fn fixture(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(path)
}

fn cable_drag() -> String {
    fs::read_to_string(fixture("models/cable-drag.toml")).unwrap()
}

/// Text as if it stood among the fixtures' models.
fn parse(text: &str) -> Result<ModelFile, InputError> {
    ModelFile::parse(text, &fixture("models/test.toml"))
}

fn head() -> String {
    "schema = \"model/1\"\nrobot = \"../robots/kr500-mt.toml\"\n".to_owned()
}

/// What can be compared of a model's effects.
fn effects_of(model: &ModelFile) -> Vec<(&'static str, Location, Vec<f64>, Scope)> {
    model
        .effects
        .iter()
        .map(|e| (e.effect.kind.id, e.effect.at, e.effect.values.clone(), e.scope))
        .collect()
}

#[test]
fn a_model_holds_robot_process_and_effects() {
    let model = ModelFile::read(fixture("models/cable-drag.toml")).unwrap();
    assert_eq!(model.robot, RobotFile::read(fixture("robots/kr500-mt.toml")).unwrap());
    assert_eq!(
        model.process,
        Some(Process::read(fixture("processes/lap-weld-2024-t3.toml")).unwrap())
    );
    let expected = vec![
        ("backlash", Location::Joint(4), vec![1e-4], Scope::Campaign),
        ("cable-drag", Location::Joint(0), vec![150.0, 4000.0], Scope::Campaign),
    ];
    assert_eq!(effects_of(&model), expected);
    let bare = parse(&head()).unwrap();
    assert!(bare.process.is_none() && bare.effects.is_empty());
}

#[test]
fn the_same_definition_is_the_same_kind() {
    let kinds =
        |text: &str| parse(text).unwrap().effects.iter().map(|e| e.effect.kind).collect::<Vec<_>>();
    let text = cable_drag();
    // Values are no part of it; a range is.
    let (first, again) = (kinds(&text), kinds(&text.replace("value = 150.0", "value = 160.0")));
    let other = kinds(&text.replace("high = 500.0", "high = 600.0"));
    assert!(std::ptr::eq(first[1], again[1]));
    assert!(!std::ptr::eq(first[1], other[1]));
}

#[test]
fn values_of_one_log_may_be_left_to_the_fit() {
    let text = head()
        + "[[effect]]\nid = \"thermal-drift\"\nscope = \"log\"\nx_m = 1e-4\n[[effect]]\nid = \"backlash\"\nat = \"A2\"\n\
           scope = \"campaign\"\nhalf_gap_rad = 1e-4\n";
    let model = parse(&text).unwrap();
    // No drift where nothing is written, and the first of the time constants to start from.
    assert_eq!(effects_of(&model)[0].2, [1e-4, 0.0, 0.0, 5.0]);
    assert_eq!([effects_of(&model)[0].3, effects_of(&model)[1].3], [Scope::Log, Scope::Campaign]);
}

/// One effect of each kind of the library, with every value at its upper end, and the user's own.
fn one_of_each() -> String {
    let mut text = head() + "process = \"../processes/lap-weld-2024-t3.toml\"\n";
    for (i, kind) in library().enumerate() {
        text += &format!("[[effect]]\nid = \"{}\"\n", kind.id);
        match kind.place {
            LocationKind::Joint => text += &format!("at = \"A{}\"\n", i % 6 + 1),
            LocationKind::Channel => text += "at = \"wrench\"\n",
            LocationKind::Cell => {}
        }
        if i % 3 == 0 {
            text += "scope = \"log\"\n";
        }
        for parameter in kind.parameters {
            text += &format!("{} = {:?}\n", parameter.name, parameter.high);
        }
    }
    text + cable_drag()
        .split_once("[[effect]]")
        .map_or("", |(_, rest)| rest)
        .trim_start_matches(|c| c != '[')
        + HOSE
        + LEVER
}

/// An effect of the user's own that is given as a table over two variables: a hose whose lever turns with
/// the joint before.
const LEVER: &str = r#"
[[effect]]
id = "lever"
at = "A4"
port = "link-torque"
expression = "-table(link, encoder_before)"

[effect.table]
x = [-1.0, 0.0, 2.0]
across = [0.0, 0.5]
y = [
  -100.0, 0.0, 200.0,
  -40.0, 0.0, 80.0,
]
bend = 50.0
"#;

/// An effect of the user's own that is given as a table: a hose that is slack about the middle.
const HOSE: &str = r#"
[[effect]]
id = "hose"
at = "A4"
port = "link-torque"
expression = "gain * table(link - centre)"

[effect.table]
x = [-1.0, -0.2, 0.2, 1.0]
y = [160.0, 0.0, 0.0, -160.0]
bend = 50.0

[effect.parameters.gain]
value = 1.5
unit = "1"
low = 0.0
high = 2.0
step = 0.1

[effect.parameters.centre]
value = 0.1
unit = "rad"
low = -0.5
high = 0.5
step = 0.01
shape = [0.0]
"#;

#[test]
fn what_is_written_is_read_back() {
    let model = parse(&one_of_each()).unwrap();
    assert_eq!(model.effects.len(), library().count() + 3);
    let folder = tempfile::tempdir().unwrap();
    let below = folder.path().join("results/of today");
    fs::create_dir_all(&below).unwrap();
    let comments = Comments {
        posterior: String::new(),
        file: "Fitted to two logs.\nThe first of them is short.".into(),
        effects: vec![EffectComments {
            effect: "Held-out score 3.1 before, 1.2 after.".into(),
            parameters: vec!["95 %: 0.18 to\u{7} 0.22".into()],
        }],
    };
    for path in [folder.path().join("improved.toml"), below.join("improved.toml")] {
        model.write(&path, &comments).unwrap();
        let back = ModelFile::read(&path).unwrap();
        assert_eq!(effects_of(&back), effects_of(&model));
        assert_eq!((&back.robot, &back.process), (&model.robot, &model.process));
        assert!(
            back.effects
                .iter()
                .zip(&model.effects)
                .all(|(a, b)| std::ptr::eq(a.effect.kind, b.effect.kind))
        );
        let text = fs::read_to_string(&path).unwrap();
        assert!(
            text.starts_with(
                "# Fitted to two logs.\n# The first of them is short.\nschema = \"model/1\"\n"
            ),
            "{text}"
        );
        assert!(
            text.contains(
                "# Held-out score 3.1 before, 1.2 after.\n[[effect]]\nid = \"stiffness-error\""
            ),
            "{text}"
        );
        assert!(text.contains("# 95 %: 0.18 to 0.22\nrelative = "), "{text}");
    }
}

#[test]
fn what_is_known_without_the_logs_is_read_back() {
    let text = "[[known]]
id = \"encoder-offset\"

[[known]]
id = \"encoder-offset\"
at = \"A2\"
deviation = { offset_rad = 1e-5 }

[[known]]
id = \"payload-error\"
";
    let model = parse(&format!("{}\n{text}", head())).unwrap();
    let written = model.to_toml(&fixture("models"), &Comments::default());
    assert!(written.ends_with(text), "{written}");
    let zero = EffectKind::of("encoder-offset").unwrap();
    let known = |joint| KnownEffect::of(&model.known, zero, Location::Joint(joint)).unwrap();
    assert!(known(0).is_exact());
    assert_eq!(known(1).deviation, [1e-5]);
    let mistake = |known: &str, says: &str| {
        let error = parse(&format!("{}[[known]]\n{known}", head())).expect_err(known);
        let shown = format!("{error}\n{}", error.help_text());
        assert!(shown.contains(says), "`{says}` is not in: {shown}");
    };
    mistake("id = \"encoder-ofset\"", "Did you mean `encoder-offset`?");
    mistake("id = \"encoder-offset\"\nat = \"A9\"", "A9");
    mistake("id = \"payload-error\"\ndeviation = { mass_kg = 1.0 }", "no calibration");
    mistake("id = \"encoder-offset\"\ndeviation = { offset_rad = 1.0 }", "offset_rad");
    mistake("id = \"encoder-offset\"\ndeviation = { offset_mrad = 1.0 }", "offset_mrad");
    let twice = "id = \"encoder-offset\"\n[[known]]\nid = \"encoder-offset\"";
    mistake(twice, "stands twice");
}

#[test]
fn paths_lead_from_the_written_file() {
    let folder = tempfile::tempdir().unwrap();
    for below in ["cell", "out"] {
        fs::create_dir(folder.path().join(below)).unwrap();
    }
    fs::copy(fixture("robots/kr500-mt.toml"), folder.path().join("cell/my robot.toml")).unwrap();
    let path = folder.path().join("cell/model.toml");
    fs::write(&path, "schema = \"model/1\"\nrobot = \"my robot.toml\"\n").unwrap();
    let model = ModelFile::read(&path).unwrap();
    let written = folder.path().join("out/improved.toml");
    model.write(&written, &Comments::default()).unwrap();
    let expected = "schema = \"model/1\"\nrobot = \"../cell/my robot.toml\"\n";
    assert_eq!(fs::read_to_string(&written).unwrap(), expected);
    model.write(&path, &Comments::default()).unwrap();
    assert!(fs::read_to_string(&path).unwrap().contains("robot = \"my robot.toml\""));
}

#[test]
fn what_could_not_be_read_is_not_written() {
    let mut model = parse(&one_of_each()).unwrap();
    model.effects[0].effect.values[0] = f64::NAN;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("improved.toml");
    let error = model.write(&path, &Comments::default()).unwrap_err();
    assert!(error.to_string().contains("stiffness-error"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    model.effects.clear();
    let error =
        model.write(folder.path().join("none/improved.toml"), &Comments::default()).unwrap_err();
    assert!(error.to_string().contains("none/improved.toml"), "{error}");
}

/// In the example file `from` becomes `to`: the error stands at `place` (line:column) and says all
/// of `says`.
#[track_caller]
fn mistake(from: &str, to: &str, place: &str, says: &[&str]) {
    let text = cable_drag();
    assert!(text.contains(from), "the fixture no longer holds `{from}`");
    let error = parse(&text.replacen(from, to, 1)).expect_err(to);
    assert!(error.place().ends_with(&format!("models/test.toml:{place}")), "{error}");
    let shown = format!("{error}\n{}", error.help_text());
    for needle in says {
        assert!(shown.contains(needle), "`{needle}` is not in: {shown}");
    }
}

#[test]
fn mistakes_in_the_file_are_explained_at_their_place() {
    mistake(
        "../robots/kr500-mt.toml",
        "robots/none.toml",
        "4:9",
        &["robots/none.toml", "there is no", "this file's folder"],
    );
    mistake("process = ", "proces = ", "5:1", &["unknown key `proces`", "Did you mean `process`?"]);
    mistake(
        "\"backlash\"",
        "\"backlsh\"",
        "8:6",
        &["\"backlsh\"", "Did you mean `backlash`?", "stiffness-error"],
    );
    mistake(
        "half_gap_rad",
        "half_gap",
        "10:1",
        &["unknown key `half_gap`", "Did you mean `half_gap_rad`?"],
    );
    mistake(
        "half_gap_rad = 1e-4",
        "",
        "7:1",
        &["missing key `half_gap_rad`", "(backlash)", "in rad"],
    );
    mistake("\"A5\"", "\"A9\"", "9:6", &["\"A9\"", "A1, A2, A3, A4, A5, A6"]);
    mistake("at = \"A5\"", "", "7:1", &["missing key `at`", "A1, A2, A3, A4, A5, A6"]);
    mistake("1e-4", "nan", "10:16", &["nan", "a number from 0.0 to 0.001 in rad"]);
    mistake("1e-4", "0.2", "10:16", &["0.2", "a number from 0.0 to 0.001 in rad"]);
    mistake("1e-4", "\"small\"", "10:16", &["a number from 0.0 to 0.001 in rad"]);
    mistake("1e-4", "1e-4\nscope = \"weld\"", "11:9", &["\"weld\"", "\"campaign\" or \"log\""]);
    mistake(
        "\"backlash\"\nat = \"A5\"\nhalf_gap_rad = 1e-4",
        "\"counterbalance-loss\"\nat = \"A5\"\nloss = 0.1",
        "9:6",
        &["\"A5\"", "nothing"],
    );
}

#[test]
fn mistakes_in_an_effect_of_ones_own_are_explained_at_their_place() {
    // The expression's text begins in column 15 of line 18.
    mistake(
        "\"link-torque\"",
        "\"link-torq\"",
        "16:8",
        &["\"link-torq\"", "Did you mean `link-torque`?", "surface-height"],
    );
    mistake(
        "\"N·m\"\nexpression",
        "\"Nm\"\nexpression",
        "17:8",
        &["\"Nm\"", "\"N·m\", the unit of link-torque"],
    );
    mistake("port = \"link-torque\"\n", "", "13:1", &["missing key `port`"]);
    mistake(
        "link_rate /",
        "link_speed /",
        "18:26",
        &["`link_speed`", "encoder_rate", "link_rate", "(c, s)"],
    );
    mistake("s * link)", "q * link)", "18:47", &["`q`", "the parameters (c, s)"]);
    mistake("/ 0.001)", "/ 0.001", "18:16", &["never closed"]);
    mistake("c * tanh", "c tanh", "18:19", &["read `t`", "an operator"]);
    let long = "link + ".repeat(100_000) + "c * tanh";
    mistake("c * tanh", &long, "18:3522", &["more than 1000 numbers, names and operators"]);
    mistake("0.001", "0.0.1", "18:38", &["`0.0.1`", "a finite number"]);
    mistake("* link)", "* )", "18:51", &["read `)`", "a number, a name or `(`"]);
    mistake(
        "/ 0.001",
        "/ link",
        "18:15",
        &["NaN at", "link = 0.0", "c = 150.0", "expected a finite number"],
    );
    mistake("s * link)", "s * ln(link))", "18:15", &["inf at", "link = 0.0"]);
    mistake(" + s * link", "", "18:15", &["the parameter `s` does not occur"]);
    mistake(
        "[effect.parameters.c]",
        "[effect.parameters.twist]",
        "21:1",
        &["no name for a parameter"],
    );
    mistake("step = 20.0", "", "21:1", &["neither `step` nor `shape`"]);
    mistake("step = 20.0", "shape = []", "27:9", &["at least one value"]);
    mistake("value = 150.0", "value = 501.0", "22:9", &["501.0", "a number from 0.0 to 500.0"]);
    mistake("high = 500.0", "high = 0.0", "26:8", &["a number above `low`"]);
    mistake("value = 150.0", "", "21:1", &["missing key `value`", "`c`"]);
    mistake("\"A1\"", "\"X\"", "15:6", &["\"X\"", "one of the joints"]);
    // Not finite at the end of a parameter's range, though it is at the value.
    mistake("0.001", "c", "18:15", &["NaN at", "c = 0.0"]);
}

#[test]
fn mistakes_in_a_loop_are_explained_at_their_place() {
    let loop_of = |of: &str| format!("dahl({of})");
    let spring = "s * link)";
    let of = |of: &str, place: &str, says: &[&str]| {
        mistake(spring, &format!("s * {})", loop_of(of)), place, says);
    };
    of("link", "18:60", &["read `)`", "`,` and a second value"]);
    of("2 * link, 0.1", "18:51", &["`dahl(2 * link, 0.1)`", "a variable, whose way is remembered"]);
    of("link, 0.1 * twist", "18:51", &["a width made of numbers and parameters alone"]);
    of("link, 0.1) + play(twist, 0.1", "18:69", &["one such loop in an expression"]);
    of("link_rate, 0.1", "18:15", &["a loop over `link_rate`", "encoder, link, twist"]);
    of("link, 0", "18:15", &["a loop 0 wide", "above 0"]);
    // Over the range of the parameter.
    of("link, c", "18:15", &["a loop 0 wide", "above 0"]);
    let elsewhere = head()
        + "[[effect]]\nid = \"mine\"\nat = \"A2\"\nport = \"link-encoder\"\nexpression = \"1e-4 * dahl(link, 0.1)\"\n";
    let error = parse(&elsewhere).unwrap_err().to_string();
    let expected = "a loop at link-encoder; expected one of the ports spring-torque, motor-friction, link-torque";
    assert!(error.contains(expected), "{error}");
}

/// Torque of the first effect of the user's own on a link at an angle and at one of the joint before,
/// N·m.
fn link_torque(text: &str, link: f64, encoder_before: f64) -> f64 {
    let model = parse(text).unwrap();
    let robot = &model.robot.robot;
    let elastic = ElasticRobot::with_effects(robot, &model.cell_effects(), None).unwrap();
    let at = JointState {
        encoder: link,
        encoder_rate: 0.0,
        link,
        link_rate: 0.0,
        encoder_before,
        smoothing: 1e-3,
        spring_torque: 0.0,
        remembered: 0.0,
        time: 0.0,
    };
    elastic.ports.link_torque[3][0].0.link_torque(&at, 0.0)
}

#[test]
fn a_table_is_read_by_straight_lines_and_held_beyond_its_ends() {
    let text = head() + HOSE;
    // Slack from 0.1 − 0.2 to 0.1 + 0.2 rad; beyond it 1.5 × 200 N·m a radian, up to ±1 rad.
    for (link, torque) in [(0.0, 0.0), (0.25, 0.0), (0.5, -60.0), (-0.5, 120.0), (1.7, -240.0)] {
        assert!((link_torque(&text, link, 0.0) - torque).abs() < 1e-9, "{link} rad");
    }
}

#[test]
fn a_table_over_two_variables_is_straight_along_each_of_them() {
    let text = head() + LEVER;
    for ([link, before], torque) in [
        ([-1.0, 0.0], 100.0),
        ([1.0, 0.0], -100.0),
        ([1.0, 0.25], -70.0),
        ([2.0, 0.5], -80.0),
        ([5.0, 9.0], -80.0),
        ([-5.0, -1.0], 100.0),
    ] {
        let read = link_torque(&text, link, before);
        assert!((read - torque).abs() < 1e-9, "{read} at {link} and {before} rad");
    }
}

#[test]
fn mistakes_in_a_table_are_explained_at_their_place() {
    let refused_in = |table: &str, from: &str, to: &str, says: &str| {
        let text = head() + table;
        assert!(text.contains(from), "{from}");
        let error = parse(&text.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    };
    let refused = |from: &str, to: &str, says: &str| refused_in(HOSE, from, to, says);
    refused("-0.2, 0.2", "0.2, -0.2", "each above the one before");
    refused("0.0, 0.0, -160.0", "0.0, -160.0", "4 numbers, as many as in `x`");
    refused("bend = 50.0", "bend = 0.0", "bend");
    refused("table(link - centre)", "(link - centre)", "the table is not read");
    refused("bend = 50.0", "low = -100.0", "from -100.0");
    refused("parameters.gain", "parameters.y1", "another name");
    let refused = |from: &str, to: &str, says: &str| refused_in(LEVER, from, to, says);
    refused("0.0, 0.5]", "0.5, 0.0]", "each above the one before");
    refused("across = [0.0, 0.5]", "across = [0.0]", "two numbers or more");
    refused(
        "-40.0, 0.0, 80.0,",
        "-40.0, 0.0,",
        "6 numbers, as many as in `x` for each place in `across`",
    );
    refused("table(link, encoder_before)", "table(link)", "`,` and a second value");
    refused("across = [0.0, 0.5]\n", "", "3 numbers, as many as in `x`");
    let many: Vec<String> = (0..30).map(|k| k.to_string()).collect();
    let many = ["across = [", &many.join(", "), "]"].concat();
    refused("across = [0.0, 0.5]", &many, "at most 64 values with `x`");
}

#[test]
fn an_expression_over_several_lines_is_pointed_into() {
    let text = cable_drag().replace(
        "expression = \"-(c * tanh(link_rate / 0.001) + s * link)\"",
        "expression = \"\"\"\n  -c * tanh(link_rate / 0.001)\n  - s * lnk\"\"\"",
    );
    assert!(parse(&text).unwrap_err().place().ends_with(":20:9"));
    assert!(parse(&text.replace("lnk", "link")).is_ok());
}

#[test]
fn every_port_takes_every_one_of_its_variables() {
    for port in PORTS {
        let sum = port.variables.iter().map(|v| v.name).collect::<Vec<_>>().join(" + ");
        let at = if port.place() == LocationKind::Joint { "at = \"A2\"\n" } else { "" };
        let text = head()
            + &format!(
                "[[effect]]\nid = \"mine\"\n{at}port = \"{}\"\nunit = \"{}\"\nexpression = \"a * ({sum})\"\n\
                 parameters.a = {{ value = 0, unit = \"1\", low = -1, high = 1, step = 0.1 }}\n",
                port.name, port.unit
            );
        parse(&text).unwrap_or_else(|error| panic!("{}: {error}", port.name));
    }
}

#[test]
fn the_guide_names_every_port_and_variable() {
    let guide = include_str!("../../../docs/your-own-effect.md");
    for port in PORTS {
        for name in port.variables.iter().map(|v| v.name).chain([port.name]) {
            let numbered = name.trim_end_matches(|c: char| c.is_ascii_digit());
            let said = guide.contains(&format!("`{name}`"))
                || (name.starts_with("encoder_") && guide.contains(numbered));
            assert!(said, "{name} at {}", port.name);
        }
    }
}

#[test]
fn arithmetic_is_read_as_in_print() {
    let x = 0.7_f64;
    for (text, value) in [
        ("-x^2", -(x * x)),
        ("2^-x", 2_f64.powf(-x)),
        ("2^3^2", 512.0),
        ("2 - 3 - 4", -5.0),
        ("8 / x / 2 * 3", 8.0 / x / 2.0 * 3.0),
        ("2 * -x", -2.0 * x),
        ("- - x", x),
        ("sin(x + 2 + 3)", (x + 5.0).sin()),
        ("max(min(x, 1e-3), 5E-4) + 1e0 + .5", 1.501),
        ("atan2(x, -x)", f64::atan2(x, -x)),
        ("step(x) + step(-x) + step(0) + sign(-x) + sign(0)", 0.0),
        ("sin(pi / 6)\n + 0", 0.5),
    ] {
        let got = Expression::parse(text, &["x"], &[]).unwrap().eval(&[x], &[]);
        assert!((got - value).abs() < 1e-15, "{text}: {got}, expected {value}");
    }
    let lost = Expression::parse("max(0, ln(x)) + min(ln(x), 0)", &["x"], &[]).unwrap();
    assert!(lost.eval(&[-1.0], &[]).is_nan(), "what is not a number must not vanish");
    for deep in ["(".repeat(1000), "-(".repeat(1000), "2^".repeat(1000), "sin(".repeat(1000)] {
        assert!(Expression::parse(&format!("{deep}1"), &[], &[]).is_err());
    }
    assert!(Expression::parse(&format!("{}x", "-".repeat(100_000)), &["x"], &[]).is_ok());
    assert!(Expression::parse(&vec!["x"; 500].join("+"), &["x"], &[]).is_ok());
    assert!(Expression::parse(&vec!["x"; 501].join("+"), &["x"], &[]).is_err());
}

/// A random expression with its value worked out beside the text.
fn worked_out(x: f64, c: f64) -> impl Strategy<Value = (String, f64)> {
    let leaf = prop_oneof![
        Just(("x".to_owned(), x)),
        Just(("c".to_owned(), c)),
        (0.01..10.0_f64).prop_map(|v| (format!("{v:e}"), v)),
    ];
    leaf.prop_recursive(6, 40, 2, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone())
                .prop_map(|((a, x), (b, y))| (format!("({a}+{b})"), x + y)),
            (inner.clone(), inner.clone())
                .prop_map(|((a, x), (b, y))| (format!("({a}) - ({b})"), x - y))
                .prop_map(|(t, v)| (format!("({t})"), v)),
            (inner.clone(), inner.clone())
                .prop_map(|((a, x), (b, y))| (format!("({a})*({b})"), x * y)),
            (inner.clone(), inner.clone())
                .prop_map(|((a, x), (b, y))| (format!("(({a})/({b}))"), x / y)),
            (inner.clone(), inner.clone())
                .prop_map(|((a, x), (b, y))| (format!("atan2({a}, {b})"), x.atan2(y))),
            inner.clone().prop_map(|(a, x)| (format!("tanh( {a} )"), x.tanh())),
            inner.prop_map(|(a, x)| (format!("(-({a}))"), -x)),
        ]
    })
}

proptest! {
    #[test]
    fn an_expression_has_the_value_that_mathematics_gives_it(
        (x, c, (text, value)) in (-5.0..5.0_f64, -5.0..5.0_f64).prop_flat_map(|(x, c)| (Just(x), Just(c), worked_out(x, c)))
    ) {
        let got = Expression::parse(&text, &["x"], &["c"]).unwrap().eval(&[x], &[c]);
        prop_assert!(got.to_bits() == value.to_bits() || (got.is_nan() && value.is_nan()), "{text}: {got}, {value}");
    }

    #[test]
    fn no_text_makes_the_parser_panic(text in "(?s).{0,80}", like in "[-+*/^(),.0-9e x c\\tsinmaxpi·∞]{0,80}") {
        for text in [text, like] {
            match Expression::parse(&text, &["x", "y"], &["c"]) {
                Ok(expression) => { expression.eval(&[0.1, 0.2], &[0.3]); }
                Err(mistake) => prop_assert!(mistake.at.start <= mistake.at.end && mistake.at.end <= text.len()),
            }
        }
    }

    #[test]
    fn no_edit_of_a_model_file_makes_its_reader_panic(at in 0..1400usize, length in 0..40usize, put in "[ -~·\\n]{0,20}") {
        let text = cable_drag();
        let boundary = |at: usize| (0..=at.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0);
        let (from, to) = (boundary(at), boundary(at + length));
        let edited = format!("{}{put}{}", &text[..from], &text[to..]);
        if let Err(error) = parse(&edited) {
            prop_assert!(Path::new(error.place()).components().count() > 1 && !error.message().is_empty());
        }
    }
}

/// The model of a gap at A5 with what was measured of it and of a stiffness.
fn measured() -> String {
    let path = fixture("campaigns/backlash/model.toml");
    let plain = std::fs::read_to_string(&path).unwrap();
    let text =
        format!("{plain}\n[[effect]]\nid = \"backlash\"\nat = \"A5\"\nhalf_gap_rad = 2.4e-4\n");
    let model = ModelFile::parse(&text, &path).unwrap();
    let number = |effect: &Effect, value: f64| MeasuredNumber {
        kind: effect.kind,
        at: effect.at,
        occurrence: 0,
        parameter: 0,
        value,
        between_logs: 0.0,
    };
    let posterior = Posterior {
        numbers: vec![
            number(&model.effects[0].effect, 2.3e-4),
            number(&stiffness_error::effect(1, 0.0), 0.1 + 0.2),
        ],
        covariance: vec![1e-12, -3e-10, 1e-6],
        logs: vec!["static".to_owned()],
        campaign: "00".to_owned(),
        score: 1.0,
        at_bound: Vec::new(),
        undetermined: vec!["stiffness-error at A2: relative".to_owned()],
        not_measured: Vec::new(),
        seal: String::new(),
    };
    let model = model.with_posterior(posterior).unwrap();
    model.to_toml(path.parent().unwrap(), &Comments::default())
}

fn parsed(text: &str) -> Result<ModelFile, String> {
    let path = fixture("campaigns/backlash/model.toml");
    ModelFile::parse(text, &path).map_err(|error| error.to_string())
}

#[test]
fn a_posterior_is_read_back_to_the_last_bit_and_does_not_outlive_a_change() {
    let text = measured();
    let model = parsed(&text).unwrap();
    let posterior = model.posterior.as_ref().unwrap();
    assert_eq!(posterior.numbers[1].value.to_bits(), (0.1_f64 + 0.2).to_bits());
    assert_eq!(posterior.covariance_of(0, 1), -3e-10);
    assert_eq!(posterior.covariance_of(1, 0), -3e-10);
    assert!(model.is_sealed().unwrap());
    for (from, to) in [
        ("half_gap_rad = 0.00024", "half_gap_rad = 0.00025"),
        ("1e-12", "1e-13"),
        ("[\"static\"]", "[\"other\"]"),
        ("process = \"process.toml\"", "process = \"holdout/../process.toml\""),
    ] {
        assert!(text.contains(from), "{from}: {text}");
        let changed = parsed(&text.replace(from, to)).unwrap();
        // Where files lie is no part of it.
        assert_eq!(changed.is_sealed().unwrap(), from.starts_with("process"), "{from}");
    }
}

/// A posterior of numbers of the library, each at a share of its range and with a deviation of that
/// many powers of ten.
fn spread(numbers: &[(prop::sample::Index, f64, f64)]) -> Posterior {
    let places = |kind: &'static EffectKind| {
        let all = kind.places().into_iter();
        all.flat_map(move |at| (0..kind.parameters.len()).map(move |k| (kind, at, k)))
    };
    let all: Vec<_> = library().flat_map(places).collect();
    let (mut told, mut deviations): (Vec<MeasuredNumber>, Vec<f64>) = (Vec::new(), Vec::new());
    for (index, share, power) in numbers {
        let (kind, at, parameter) = *index.get(&all);
        let same = |n: &MeasuredNumber| (n.kind.id, n.at, n.parameter) == (kind.id, at, parameter);
        if told.iter().any(same) {
            continue;
        }
        let Parameter { low, high, .. } = kind.parameters[parameter];
        let value = (low + share * (high - low)).clamp(low, high);
        let between_logs = 10f64.powf(*power);
        told.push(MeasuredNumber { kind, at, occurrence: 0, parameter, value, between_logs });
        deviations.push(between_logs);
    }
    let row = |i: usize| (0..=i).map(move |j| (i, j));
    let covariance = (0..told.len()).flat_map(row);
    let covariance = covariance.map(|(i, j)| {
        let correlation = if i == j { 1.0 } else { -0.3 };
        correlation * deviations[i] * deviations[j]
    });
    Posterior {
        covariance: covariance.collect(),
        numbers: told,
        logs: vec!["a log".to_owned()],
        campaign: "00".to_owned(),
        score: 1.0,
        at_bound: Vec::new(),
        undetermined: Vec::new(),
        not_measured: Vec::new(),
        seal: String::new(),
    }
}

/// What a file holds of a posterior, to the last bit.
fn bits(of: &Posterior) -> Vec<u64> {
    let numbers = of.numbers.iter().flat_map(|n| [n.value, n.between_logs]);
    numbers.chain(of.covariance.iter().copied()).map(f64::to_bits).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    // A quantity of a cell is at most 1e12 in SI units, and so is its deviation.
    #[test]
    fn a_posterior_of_any_quantities_is_read_back_and_one_of_none_is_not_written(
        numbers in prop::collection::vec((any::<prop::sample::Index>(), 0.0..=1.0, -18.0..12.0), 1..8),
        none in prop::option::of((any::<prop::sample::Index>(), prop::sample::select(vec![f64::NAN, f64::INFINITY, 1e25]))),
    ) {
        let mut posterior = spread(&numbers);
        if let Some((index, none)) = &none {
            *index.get_mut(&mut posterior.covariance) = *none;
        }
        let model = parse(&head()).unwrap().with_posterior(posterior.clone()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("improved.toml");
        let written = model.write(&path, &Comments::default());
        prop_assert_eq!(written.is_ok(), none.is_none(), "{:?}", written);
        prop_assert_eq!(path.exists(), none.is_none());
        if none.is_none() {
            let read = ModelFile::read(&path).unwrap();
            prop_assert!(read.is_sealed().unwrap());
            prop_assert_eq!(bits(read.posterior.as_ref().unwrap()), bits(&posterior));
        }
    }
}

#[test]
fn a_posterior_that_does_not_fit_is_refused_at_its_place() {
    for (from, to, said) in [
        ("backlash.half_gap_rad", "backlash.gap", "a parameter of backlash"),
        ("\"stiffness-error.relative\"", "\"stifness.relative\"", "an effect of the library"),
        ("\"A5\", \"A2\"", "\"A5\"", "2 places"),
        ("[1e-12, -3e-10, 1e-6]", "[1e-12, -3e-10]", "3 numbers"),
        ("[1e-12, -3e-10, 1e-6]", "[1e-12, -3e-10, -1e-6]", "no variance below zero"),
        ("0.30000000000000004", "7.0", "a value that the parameter may have"),
        ("score = 1.0", "scores = 1.0", "unknown key `scores`"),
    ] {
        let text = measured();
        assert!(text.contains(from), "{from}: {text}");
        let error = parsed(&text.replace(from, to)).unwrap_err();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn an_effect_that_stands_twice_is_told_and_two_waves_are_not() {
    let told = |name: &str, effects: &str| {
        let path = fixture("models").join(name);
        ModelFile::parse(&(head() + effects), &path).unwrap();
        warnings().into_iter().filter(|w| w.contains(name)).collect::<Vec<_>>()
    };
    let backlash = "[[effect]]\nid = \"backlash\"\nat = \"A5\"\nhalf_gap_rad = 1e-4\n";
    let twice = told("twice.toml", &backlash.repeat(2));
    assert_eq!(twice.len(), 1, "{twice:?}");
    assert!(twice[0].contains("backlash at A5 stands twice"), "{twice:?}");
    let wave = |order: f64| {
        format!(
            "[[effect]]\nid = \"transmission-error\"\nat = \"A1\"\namplitude_rad = 1e-4\n\
             order = {order:?}\nphase_rad = 0.0\n"
        )
    };
    let elsewhere = backlash.replace("A5", "A4");
    let none = told("waves.toml", &(wave(1.0) + &wave(2.0) + backlash + &elsewhere));
    assert!(none.is_empty(), "{none:?}");
}
