//! The program as a user runs it: what it writes, that it writes the same again, and how it
//! refuses.

use crate::support::{Workspace, assert_valid, fixture, one_line};
use serde_json::Value;
use std::fs;
use std::process::Command;
use std::time::Instant;

#[test]
fn a_weld_is_told_as_table_json_and_page() {
    let place = Workspace::new();
    let out =
        place.done(&["weld", "--weld", "short.toml", "--json", "weld.json", "--html", "weld.html"]);
    assert!(out.starts_with("At full feed the tool leaves the seam by up to "), "{out}");
    assert!(out.lines().all(|line| line.chars().count() <= 110), "{out}");
    let value = place.json("weld.json");
    assert_eq!(value["schema"], "weld-result/1");
    let runs = value["runs"].as_array().unwrap();
    assert_eq!(
        runs.iter().map(|run| &run["compensator"]).collect::<Vec<_>>(),
        ["none", "elastostatic"]
    );
    for run in runs {
        assert_eq!(run["weld"], "short");
        assert_eq!(run["controller"], "external");
        assert!(run["seed"].is_u64());
        for quantity in ["lateral_m", "longitudinal_m", "depth_m", "tilt_rad"] {
            for figure in ["mean", "rms", "max_abs"] {
                assert!(run[quantity][figure].is_f64(), "{quantity} {figure}");
            }
        }
        for figure in ["mean", "envelope", "error_rms"] {
            assert!(run["force_n"][figure].is_f64(), "{figure}");
        }
        let share: f64 =
            run["joint_share"].as_array().unwrap().iter().map(|s| s.as_f64().unwrap()).sum();
        // To first order in the torsion.
        assert!((share - 1.0).abs() < 0.05, "{share}");
        assert!(run["simulated_s"].as_f64() > Some(5.0) && run["wall_s"].as_f64() > Some(0.0));
    }
    // The point of it all.
    let largest = |run: &Value| run["lateral_m"]["max_abs"].as_f64().unwrap();
    assert!(largest(&runs[1]) < 0.5 * largest(&runs[0]));
    assert!(String::from_utf8(place.bytes("weld.html")).unwrap().starts_with("<!DOCTYPE html>"));
}

#[test]
fn a_step_is_told_for_all_three_controllers() {
    let place = Workspace::new();
    // The guide's commands write into `out`, which a new clone does not have.
    let out = place.done(&[
        "step",
        "--weld",
        "short.toml",
        "--json",
        "out/step.json",
        "--html",
        "out/step.html",
    ]);
    assert!(out.contains("published, scheme 3"), "{out}");
    let value = place.json("out/step.json");
    assert_eq!(value["schema"], "step-result/1");
    let controllers = value["controllers"].as_array().unwrap();
    assert_eq!(
        controllers.iter().map(|c| &c["name"]).collect::<Vec<_>>(),
        ["parallel", "superposed", "external"]
    );
    for controller in controllers {
        for key in ["first_within_5pct_s", "settle_5pct_s"] {
            let time = controller.get(key).unwrap();
            assert!(time.is_f64() || time.is_null(), "{key}");
        }
        for key in ["overshoot", "static_error_n", "ripple_n"] {
            assert!(controller[key].is_f64(), "{key}");
        }
    }
    assert!(place.bytes("out/step.html").starts_with(b"<!DOCTYPE html>"));
}

#[test]
fn the_same_inputs_and_seed_give_the_same_bytes() {
    let place = Workspace::new();
    let mut outputs = vec!["json", "html"];
    if cfg!(feature = "rerun") {
        outputs.push("rrd");
    }
    for name in ["a", "b"] {
        let mut arguments =
            vec!["weld".to_owned(), "--weld".into(), "short.toml".into(), "--quiet".into()];
        for output in &outputs {
            arguments.extend([format!("--{output}"), format!("{name}.{output}")]);
        }
        place.done(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    }
    let figures = |name: &str| -> String {
        let text = String::from_utf8(place.bytes(name)).unwrap();
        assert_eq!(text.matches("\"wall_s\"").count(), 2, "{name}");
        text.lines().filter(|line| !line.contains("\"wall_s\"")).collect()
    };
    assert_eq!(figures("a.json"), figures("b.json"));
    assert!(place.bytes("a.html") == place.bytes("b.html"), "no wall time stands on a page");
    if cfg!(feature = "rerun") {
        assert!(place.bytes("a.rrd") == place.bytes("b.rrd"));
    }
    // Another seed is another run.
    place.done(&["weld", "--weld", "short.toml", "-q", "--seed", "99", "--json", "c.json"]);
    assert_ne!(figures("a.json"), figures("c.json"));
}

#[cfg(feature = "rerun")]
#[test]
fn a_step_recording_is_the_same_again() {
    let place = Workspace::new();
    for name in ["a.rrd", "b.rrd"] {
        place.done(&["step", "--weld", "short.toml", "--rrd", name]);
    }
    let [first, second] = ["a.rrd", "b.rrd"].map(|name| place.bytes(name));
    assert!(first.starts_with(b"RRF") && first == second);
}

#[test]
fn bad_input_ends_in_one_message_and_no_file() {
    let place = Workspace::new();
    place.weld("nan.toml", "[1.7, -1.0, 0.5]", "[1.7, nan, 0.5]");
    place.weld("far.toml", "[9.0, -1.0, 0.5]", "[9.0, 1.0, 0.5]");
    place.weld("tiny.toml", "[1.7, -1.0, 0.5]", "[1.7, -0.999, 0.5]");
    let slow = String::from_utf8(place.bytes("short.toml")).unwrap();
    let slow = slow.replace("feed_m_s = 0.010", "feed_m_s = 1e-6");
    fs::write(place.path().join("slow.toml"), slow).unwrap();
    let robot = fixture("robots/kr500-mt.toml");
    fs::write(place.path().join("half.toml"), format!("schema = \"model/1\"\nrobot = {robot:?}\n"))
        .unwrap();
    let cases: &[(&[&str], &[&str])] = &[
        (&["--weld", "gone.toml"], &["gone.toml", "cannot be read", "expected a file"]),
        (&["--weld", &robot], &["kr500-mt.toml:", "\"robot/1\"", "expected \"weld/1\""]),
        (
            &["--weld", "nan.toml"],
            &["nan.toml:4", "`end_m`", "expected a number from -1000 to 1000 in m"],
        ),
        (
            &["--weld", "far.toml"],
            &["far.toml", "out of reach", "Expected a seam that the robot reaches"],
        ),
        (&["--weld", "tiny.toml"], &["tiny.toml", "too short", "Expected a seam long enough"]),
        (&["--effect", "slack:A5:x=1"], &["--effect slack:A5:x=1", "expected one of", "backlash"]),
        (
            &["--effect", "backlash:A9:half_gap_rad=1e-4"],
            &["A9", "expected one of the joints A1, A2"],
        ),
        (&["--effect", "backlash:A5:half_gap_rad=nan"], &["half_gap_rad = nan is not finite"]),
        (
            &["--effect", "backlash:A5:half_gap_rad=0.2"],
            &["half_gap_rad = 0.2 is outside its range", "half_gap_rad (rad, from 0e0 to 1e-3)"],
        ),
        (&["--effect", "backlsh:A5:half_gap_rad=1e-4"], &["did you mean `backlash`?"]),
        (&["--effect", "backlash:A5:half_gap=1e-4"], &["did you mean `half_gap_rad`?"]),
        (&["--effect", "channel-delay:trakcer:delay_s=0.01"], &["did you mean `tracker`?"]),
        (&["--model", "half.toml"], &["half.toml: names no process", "process = "]),
        (
            &["--model", "half.toml", "--robot", &robot],
            &["'--model <F>' cannot be used with '--robot <F>'"],
        ),
        (&["--period", "-0.012"], &["--period -0.012", "a number from 1e-4 to 1 in s"]),
        (&["--weld", "slow.toml"], &["control cycles", "GB of memory; expected at most 2.0 GB"]),
        (&["--period", "nan"], &["--period NaN", "a number from 1e-4 to 1 in s"]),
        (&["--stiffness-error", "-1"], &["--stiffness-error -1", "a number from -0.9 to 2"]),
        (&["--stiffness-error", "30"], &["--stiffness-error 30", "a number from -0.9 to 2"]),
        (&["--spindle-rpm", "-750"], &["--spindle-rpm -750", "a number from 0 to 30000 in 1/min"]),
        (
            &["--exaggeration", "0", "--rrd", "out.rrd"],
            &["--exaggeration 0", "expected a number from 1 up"],
        ),
        (&["--html", "absent/page.html"], &["absent/page.html", "expected a folder absent"]),
        (&["--html", "."], &["--html: cannot write .", "expected the name of a file"]),
    ];
    for (wrong, expected) in cases {
        let mut arguments = vec!["weld", "--quiet", "--json", "out.json"];
        if !wrong.contains(&"--weld") {
            arguments.extend(["--weld", "short.toml"]);
        }
        arguments.extend(*wrong);
        let message = place.refused(&arguments);
        for words in *expected {
            assert!(message.contains(words), "{words} in: {message}");
        }
    }
    let message = place.refused(&["step", "--height", "nan", "--json", "out.json"]);
    assert!(message.contains("--height NaN: expected a number of newtons"), "{message}");
}

#[test]
fn a_model_file_gives_robot_process_and_effects() {
    let place = Workspace::new();
    let head = format!(
        "schema = \"model/1\"\nrobot = {:?}\nprocess = {:?}\n",
        fixture("robots/kr500-mt.toml"),
        fixture("processes/lap-weld-2024-t3.toml")
    );
    let effect = "[[effect]]\nid = \"backlash\"\nat = \"A5\"\nhalf_gap_rad = 2e-4\n";
    fs::write(place.path().join("model.toml"), head + effect).unwrap();
    let lateral = |arguments: &[&str]| {
        let mut all = vec![
            "weld",
            "--quiet",
            "--weld",
            "short.toml",
            "--compensator",
            "none",
            "--json",
            "out.json",
        ];
        all.extend(arguments);
        place.done(&all);
        place.json("out.json")["runs"][0]["lateral_m"].clone()
    };
    let with = lateral(&["--effect", "backlash:A5:half_gap_rad=2e-4"]);
    assert_eq!(lateral(&["--model", "model.toml"]), with);
    // Effects add up, and one of the user's own is one of them.
    assert_ne!(
        lateral(&["--model", "model.toml", "--effect", "stiffness-error:A3:relative=0.1"]),
        with
    );
    assert_ne!(lateral(&["--model", &fixture("models/cable-drag.toml")]), lateral(&[]));
}

#[test]
fn a_refused_command_leaves_the_former_result() {
    let place = Workspace::new();
    fs::write(place.path().join("out.json"), "former").unwrap();
    place.refused(&["weld", "--weld", "gone.toml", "--json", "out.json"]);
    assert_eq!(place.bytes("out.json"), b"former");
}

#[test]
fn check_says_what_a_file_is_or_what_is_wrong_with_it() {
    let place = Workspace::new();
    let files = [
        "robots/kr500-mt",
        "processes/lap-weld-2024-t3",
        "control/kr500-mt",
        "sensors/kr500-mt",
        "welds/inclined",
        "models/cable-drag",
    ]
    .map(|name| fixture(&format!("{name}.toml")));
    let mut arguments = vec!["check", "--json", "check.json", "short.toml"];
    arguments.extend(files.iter().map(String::as_str));
    let out = place.done(&arguments);
    assert_eq!(out.lines().filter(|line| line.ends_with(", in order")).count(), 7, "{out}");
    let value = place.json("check.json");
    assert_eq!(value["schema"], "check/1");
    assert!(value["files"].as_array().unwrap().iter().all(|file| file["ok"] == true));

    let process = fs::read_to_string(&files[1]).unwrap();
    let wide = process.replace("pin_diameter_m = 0.005", "pin_diameter_m = 0.05");
    fs::write(place.path().join("wide.toml"), wide).unwrap();
    let out = place.done(&["check", "wide.toml", "--json", "check.json"]);
    assert!(out.contains("a welding process, readable; ") && !out.contains("in order"), "{out}");
    let notices = &place.json("check.json")["files"][0]["notices"];
    assert!(notices[0].as_str().unwrap().contains("`pin_diameter_m`"), "{notices}");

    place.weld("nan.toml", "[1.7, -1.0, 0.5]", "[1.7, nan, 0.5]");
    let output = place.run(&["check", "short.toml", "nan.toml", "--json", "check.json"]);
    assert!(!output.status.success());
    let message = one_line(&String::from_utf8(output.stderr).unwrap());
    for said in ["nan.toml:4", "1 file is not in order"] {
        assert!(message.contains(said), "{message}");
    }
    assert_valid(&place.bytes("check.json"));
    let wrong = &place.json("check.json")["files"][1];
    assert!(wrong["ok"] == false && wrong["error"].is_string(), "{wrong}");
}

#[test]
fn an_imported_urdf_says_what_is_still_to_be_filled_in() {
    let place = Workspace::new();
    let out = place.done(&["import-urdf", &fixture("robots/arm6.urdf"), "--out", "arm6.toml"]);
    assert!(
        out.contains("wrote arm6.toml")
            && out.contains("The tool is the URDF's tcp")
            && out.contains("23 values are marked")
            && out.contains("FILL IN")
            && out.contains("trueweld check"),
        "{out}"
    );
    let message = place.refused(&["check", "arm6.toml"]);
    assert!(message.contains("arm6.toml: 23 entries are still to be filled in:"), "{message}");
    for entry in ["gravity_m_s2", "`stiffness_nm_rad` in [[joint]] 6 (A6)", "[counterbalance]"] {
        assert!(message.contains(entry), "{entry} in {message}");
    }
}

#[test]
fn a_campaign_is_compared_with_its_model_and_says_where_it_fails() {
    let place = Workspace::new();
    let campaign = fixture("campaigns/backlash");
    let said =
        place.done(&["compare", &campaign, "--quiet", "--json", "c.json", "--html", "c.html"]);
    assert!(said.starts_with("Score 5."), "{said}");
    assert!(said.contains("A5's spring torque"), "{said}");
    let value = place.json("c.json");
    assert_eq!(value["schema"], "compare/1");
    assert_eq!(value["logs"].as_array().unwrap().len(), 7);
    assert_eq!(value["logs"][0]["channels"][0]["noise_is"], "stated");
    assert!(value["worst"][0]["share"].as_f64().unwrap() > 0.5);
    let page = fs::read_to_string(place.path().join("c.html")).unwrap();
    assert!(page.contains("<h1>Score 5."));
    // The same again; and one log alone, with the model named.
    let again = place.done(&["compare", &campaign, "--quiet"]);
    assert!(said.starts_with(&again));
    let (log, model) = (format!("{campaign}/static"), format!("{campaign}/model.toml"));
    assert!(place.done(&["compare", "--model", &model, &log]).contains("static, static-load"));
}

#[test]
fn a_hidden_effect_is_found_added_and_the_error_falls_where_nothing_was_fitted() {
    let place = Workspace::new();
    let (campaign, holdout) =
        (fixture("campaigns/backlash"), fixture("campaigns/backlash/holdout"));
    let said = place.done(&[
        "improve",
        &campaign,
        "--out",
        "improved.toml",
        "-q",
        "--json",
        "i.json",
        "--html",
        "i.html",
    ]);
    assert!(
        said.starts_with("With backlash at A5 the error of the tool position falls from 0.12"),
        "{said}"
    );
    assert!(said.lines().all(|line| line.chars().count() <= 112), "{said}");
    let value = place.json("i.json");
    assert_eq!(
        (&value["schema"], &value["verdict"]),
        (&"improve/1".into(), &"effect-found".into())
    );
    let steps = value["steps"].as_array().unwrap();
    assert_eq!(steps[0]["added"].as_array().map(Vec::len), Some(0));
    let (first, last) = (&steps[0], &steps[steps.len() - 1]);
    assert_eq!(
        (&last["added"][0]["effect"], &last["added"][0]["at"]),
        (&"backlash".into(), &"A5".into())
    );
    // What the campaign was made with: half a gap of 0.24 mrad.
    let gap = last["added"][0]["parameters"]["half_gap_rad"]["value"].as_f64().unwrap();
    assert!((gap - 2.4e-4).abs() < 5e-6, "{gap}");
    assert!(
        last["holdout_score"].as_f64() < Some(1.2) && first["holdout_score"].as_f64() > Some(2.0)
    );
    assert!(String::from_utf8(place.bytes("i.html")).unwrap().contains("<h1>With backlash at A5"));
    // The file that was written, on logs of the same cell that nobody fitted.
    let score = |model: &str| {
        place.done(&["compare", "--model", model, &holdout, "-q", "--json", "c.json"]);
        place.json("c.json")["score"].as_f64().unwrap()
    };
    let (before, after) = (score(&format!("{holdout}/model.toml")), score("improved.toml"));
    // What is left is in one stretch of the weld and in a few static loads.
    assert!(before > 2.0 && after < 1.1, "{before} {after}");
    // And it is a cell to weld in.
    place.done(&[
        "weld",
        "--model",
        "improved.toml",
        "--weld",
        "short.toml",
        "--compensator",
        "none",
        "-q",
    ]);
}

/// A motion of the campaign without flaws, with the second encoder of A2 zeroed anew: it reads `more`,
/// rad.
fn zeroed_anew(place: &Workspace, log: &str, name: &str, more: f64) {
    let from = fixture(&format!("campaigns/nothing-missing/{log}"));
    let robot = fixture("campaigns/nothing-missing/robot.toml");
    let toml = fs::read_to_string(format!("{from}/log.toml")).unwrap();
    let samples = fs::read_to_string(format!("{from}/samples.csv")).unwrap();
    let column = samples.lines().next().unwrap().split(',').position(|c| c == "ql2_rad").unwrap();
    let read = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Ok(angle) = cells[column].parse::<f64>() {
            cells[column] = format!("{:.8}", angle + more);
        }
        cells.join(",") + "\n"
    };
    let folder = place.path().join(name);
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("log.toml"), toml.replace("../robot.toml", &robot)).unwrap();
    fs::write(folder.join("samples.csv"), samples.lines().map(read).collect::<String>()).unwrap();
}

#[test]
fn a_zero_is_the_logs_own_and_is_fitted_to_a_log_of_another_day_and_told() {
    let place = Workspace::new();
    let model = fixture("campaigns/nothing-missing/model.toml");
    zeroed_anew(&place, "free", "monday", 1.2e-3);
    zeroed_anew(&place, "holdout/free-2", "tuesday", -1.25e-3);
    zeroed_anew(&place, "holdout/free-2", "as-zeroed", 0.0);
    let score = |model: &str, log: &str| {
        let said = place.done(&["compare", "--model", model, log, "--json", "c.json"]);
        let value = place.json("c.json");
        let channels = value["logs"][0]["channels"].as_array().unwrap().clone();
        let second = channels.iter().find(|c| c["name"] == "link_encoder").unwrap();
        (second["score"].as_f64().unwrap(), said.replace('\n', " "))
    };
    place.done(&["improve", "--model", &model, "monday", "--out", "improved.toml", "-q"]);
    let (before, _) = score(&model, "tuesday");
    let (after, said) = score("improved.toml", "tuesday");
    // As well as the given model where nothing was zeroed anew.
    let (best, _) = score(&model, "as-zeroed");
    assert!(before > 20.0 * best && after < 1.01 * best, "{before} {after} {best}");
    let told = said.split("link-encoder-offset at A2 is each log's own").nth(1).expect(&said);
    let told = told.split("offset ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    let told: f64 = told.replace('\u{2212}', "-").parse().expect(told);
    // Four standard deviations of the mean of a thousand readings, and what the gear's stiffness takes.
    assert!((told + 1.25).abs() < 0.02, "{said}");
    // The file has the mean of what was fitted, and the scope that says so.
    let file = fs::read_to_string(place.path().join("improved.toml")).unwrap();
    let entry = file
        .split("[[effect]]")
        .find(|e| e.contains("id = \"link-encoder-offset\"\nat = \"A2\"\nscope = \"log\""));
    let value = entry.and_then(|e| e.split("offset_rad = ").nth(1)).expect(&file);
    let value: f64 = value.lines().next().unwrap().parse().unwrap();
    assert!((value - 1.2e-3).abs() < 2e-5, "{file}");
}

#[test]
fn a_diagnosis_names_the_effect_its_size_and_the_curve_that_shows_it() {
    let place = Workspace::new();
    let campaign = fixture("campaigns/backlash");
    let model = format!("{campaign}/model.toml");
    let logs = ["ring-25", "static"].map(|log| format!("{campaign}/{log}"));
    let all = [
        "diagnose", "--model", &model, &logs[0], &logs[1], "-q", "--json", "d.json", "--html",
        "d.html",
    ];
    let said = place.done(&all);
    assert!(said.starts_with("What is missing: backlash at A5"), "{said}");
    let value = place.json("d.json");
    assert_eq!(
        (&value["schema"], &value["verdict"]),
        (&"diagnose/1".into(), &"effect-found".into())
    );
    let best = &value["candidates"][0];
    for key in ["holdout_score_before", "holdout_score_after", "probability"] {
        assert!(best[key].is_f64(), "{key}");
    }
    assert!(
        best["indistinguishable"].is_array()
            && best["explanation"].as_str().unwrap().contains("A5")
    );
    let gap = &best["effects"][0]["parameters"]["half_gap_rad"];
    let [low, value_of, high] = ["low", "value", "high"].map(|key| gap[key].as_f64().unwrap());
    assert!(low < value_of && value_of < high && (value_of - 2.4e-4).abs() < 1e-5, "{gap}");
    assert_eq!(gap["unit"], "rad");
    let curve = &best["evidence"];
    let count = |key: &str| curve[key].as_array().unwrap().len();
    assert!(
        count("x") > 3
            && count("x") == count("y")
            && curve["x_name"].is_string()
            && curve["y_unit"].is_string()
    );
    for key in ["calibration", "unexplained", "limits", "confusable"] {
        assert!(value[key].is_array(), "{key}");
    }
    assert!(value.get("next_experiment").is_some());
    assert!(String::from_utf8(place.bytes("d.html")).unwrap().contains("The curve that shows it"));
}

#[test]
fn what_cannot_be_improved_is_refused_before_the_work() {
    let place = Workspace::new();
    let campaign = fixture("campaigns/backlash");
    let model = format!("{campaign}/model.toml");
    let log = format!("{campaign}/static");
    let own = fs::read_to_string(&model).unwrap();
    let own = own
        .replace("= \"", &format!("= \"{campaign}/"))
        .replace(&format!("{campaign}/model/1"), "model/1");
    fs::write(place.path().join("model.toml"), own).unwrap();
    let cases: &[(&[&str], &[&str])] = &[
        (&["diagnose"], &["<LOG>..."]),
        (&["diagnose", &log], &["--model is missing"]),
        (&["diagnose", "--model", "gone.toml", &log], &["gone.toml", "cannot be read"]),
        (
            &["diagnose", &campaign, "--json", "absent/d.json"],
            &["absent/d.json", "expected a folder absent"],
        ),
        (&["improve", &campaign], &["--out"]),
        (&["improve", &campaign, "--out", "absent/improved.toml"], &["expected a folder absent"]),
        (&["improve", &campaign, "--out", "."], &["expected the name of a file"]),
        (
            &["improve", "--model", "model.toml", &log, "--out", "model.toml"],
            &["--out: cannot write model.toml", "it is an input of this command"],
        ),
        (
            &["improve", &campaign, "--out", "improved.toml", "--held-out", &log],
            &["also among those to be fitted", "expected another log"],
        ),
        (
            &["improve", &campaign, "--out", "improved.toml", "--held-out", "gone"],
            &["gone", "does not exist"],
        ),
    ];
    for (arguments, expected) in cases {
        let message = place.refused(arguments);
        for words in *expected {
            assert!(message.contains(words), "{words} in: {message}");
        }
    }
}

#[test]
fn logs_without_a_model_or_of_another_robot_are_refused() {
    let place = Workspace::new();
    let log = fixture("campaigns/backlash/static");
    let message = place.refused(&["compare", &log]);
    assert!(
        message.contains("--model is missing") && message.contains("--model model.toml"),
        "{message}"
    );
    let other = fixture("campaigns/kr300-measured/model.toml");
    let message = place.refused(&["compare", "--model", &other, &log]);
    assert!(message.contains("this is a log of another robot"), "{message}");
    let message = place.refused(&["compare", "nowhere"]);
    assert!(message.contains("expected the folder of a log or of a campaign"), "{message}");
}

#[test]
fn laws_are_compared_the_same_with_any_number_of_threads() {
    let place = Workspace::new();
    let all = ["compare-laws", "--weld", "short.toml", "--laws", "learning,none", "-q"];
    let out = place.done(&[&all[..], &["--json", "a.json"]].concat());
    assert!(out.starts_with("Within 0.05 mm RMS whatever the stiffness error"), "{out}");
    assert!(
        out.contains("learning: pass 2") && out.contains("Sensor delay, periods of 12 ms"),
        "{out}"
    );
    assert!(out.lines().all(|line| line.chars().count() <= 110), "{out}");
    let value = place.json("a.json");
    assert_eq!((&value["schema"], &value["weld"]), (&"compare-laws/1".into(), &"short".into()));
    // In the order in which they were asked for, each with its passes.
    let laws =
        serde_json::json!([{ "name": "learning", "passes": 2 }, { "name": "none", "passes": 1 }]);
    assert_eq!(value["laws"], laws);
    let sweeps = value["sweeps"].as_array().unwrap();
    let varied: Vec<&Value> = sweeps.iter().map(|sweep| &sweep["varied"]).collect();
    assert_eq!(varied, ["stiffness_error", "noise_factor", "delay_periods", "lost_share"]);
    for sweep in sweeps {
        for point in sweep["results"]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|r| r["points"].as_array().unwrap())
        {
            assert!(point[sweep["varied"].as_str().unwrap()].is_f64());
            for key in
                ["lateral_rms_m", "lateral_max_m", "side_tilt_rms_rad", "travel_angle_rms_rad"]
            {
                assert!(point[key].is_f64(), "{key} in {point}");
            }
        }
    }
    let page = String::from_utf8(place.bytes("out/compare-laws.html")).unwrap();
    assert_eq!(page.matches("<svg").count(), 4);
    let one_thread = [("RAYON_NUM_THREADS", "1")];
    let output = place.run_with(&[&all[..], &["--json", "b.json"]].concat(), &one_thread);
    assert!(output.status.success());
    assert!(place.bytes("a.json") == place.bytes("b.json"));
    assert!(place.bytes("out/compare-laws.html") == page.into_bytes());
}

#[test]
fn laws_that_cannot_be_compared_are_refused() {
    let place = Workspace::new();
    place.weld("far.toml", "[9.0, -1.0, 0.5]", "[9.0, 1.0, 0.5]");
    place.weld("tiny.toml", "[1.7, -1.0, 0.5]", "[1.7, -0.999, 0.5]");
    let sensors = fs::read_to_string(fixture("sensors/kr500-mt.toml")).unwrap();
    fs::write(place.path().join("blind.toml"), sensors.split("[seam]").next().unwrap()).unwrap();
    let cases: &[(&[&str], &[&str])] = &[
        (&["--weld", "far.toml"], &["far.toml", "out of reach"]),
        (&["--weld", "tiny.toml"], &["tiny.toml", "too short"]),
        (&["--laws", "none,magic"], &["'magic'", "seam-tracking"]),
        (&["--laws", "learning", "--sensors", "blind.toml"], &["learning needs a seam sensor"]),
        (&["--passes", "0"], &["--passes"]),
        (&["--html", "absent/page.html"], &["absent/page.html", "expected a folder absent"]),
    ];
    for (wrong, expected) in cases {
        let mut arguments = vec!["compare-laws", "-q", "--json", "out.json"];
        if !wrong.contains(&"--html") {
            arguments.extend(["--html", "page.html"]);
        }
        arguments.extend(*wrong);
        let message = place.refused(&arguments);
        for words in *expected {
            assert!(message.contains(words), "{words} in: {message}");
        }
    }
}

/// A certification of the short weld, its evidence in a folder.
fn certify(evidence: &str) -> Vec<&str> {
    [&CERTIFY[..], &["--evidence", evidence]].concat()
}

/// Requirements that the short weld meets or not, by its lateral limit.
fn requirements(place: &Workspace, lateral_rms: &str) {
    place.requirements(|key, line| match key {
        "lateral_rms_m" => Some(format!("lateral_rms_m = {lateral_rms}\n")),
        // Of the weld; the tool stays bounded in faults.
        "lateral_max_m" if !line.contains("half the pin") => Some(String::new()),
        "side_tilt_rms_rad" | "travel_angle_rms_rad" | "depth_rms_m" | "push_error_rms_n" => {
            Some(String::new())
        }
        "failure_probability" => Some("failure_probability = 0.5\n".to_owned()),
        _ => None,
    });
}

const CERTIFY: [&str; 11] = [
    "certify",
    "--compensator",
    "seam-tracking",
    "--weld",
    "short.toml",
    "--requirements",
    "requirements.toml",
    "--trials",
    "6",
    "--worst",
    "5",
];

#[test]
fn a_certification_goes_on_where_it_was_stopped_and_is_the_same_with_any_number_of_threads() {
    let place = Workspace::new();
    requirements(&place, "0.002");
    let out = place.done(&certify("whole"));
    assert!(out.starts_with("PASS, with "), "{out}");
    let value: Value = place.json("whole/certify.json");
    assert_eq!((&value["schema"], &value["verdict"]), (&"certify/1".into(), &"pass".into()));
    for requirement in value["requirements"].as_array().unwrap() {
        for key in ["limit", "achieved", "confidence"] {
            assert!(requirement[key].is_f64(), "{key}");
        }
        assert!(requirement["name"].is_string() && requirement["pass"].is_boolean());
    }
    assert!(place.bytes("whole/certify.html").starts_with(b"<!DOCTYPE html>"));

    for case in ["nominal", "draws", "faults"] {
        let of = value["requirements"].as_array().unwrap().iter().filter(|r| r["case"] == case);
        assert!(of.count() > 2, "{case}");
    }
    assert_eq!(value["welds"][0]["worst_case"]["runs"], 5);

    // Cut off in the middle of the fourth line: the header and two trials. Of the other sections a
    // few runs are there.
    let text = String::from_utf8(place.bytes("whole/trials-short.jsonl")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let kept = format!("{}\n{}", lines[..3].join("\n"), &lines[3][..40]);
    fs::create_dir(place.path().join("part")).unwrap();
    fs::write(place.path().join("part/trials-short.jsonl"), kept).unwrap();
    for (section, lines) in [("worst", 4), ("faults", 3)] {
        let text = String::from_utf8(place.bytes(&format!("whole/{section}-short.jsonl"))).unwrap();
        let kept: Vec<&str> = text.lines().take(lines).collect();
        fs::write(place.path().join(format!("part/{section}-short.jsonl")), kept.join("\n") + "\n")
            .unwrap();
    }
    let output = place.run_with(&certify("part"), &[("RAYON_NUM_THREADS", "1")]);
    assert!(output.status.success());
    let sections =
        ["nominal", "trials", "worst", "faults"].map(|section| format!("{section}-short.jsonl"));
    for file in sections.iter().map(String::as_str).chain(["certify.json", "certify.html"]) {
        assert!(
            place.bytes(&format!("whole/{file}")) == place.bytes(&format!("part/{file}")),
            "{file}"
        );
    }
    // Runs of other requirements do not count, nor of another controller, seed, effect, speed,
    // period, belief or number of passes.
    let refused = |more: &[&str]| {
        let message = place.refused(&[&certify("whole")[..], more].concat());
        assert!(message.contains("runs of something else"), "{more:?}: {message}");
    };
    for more in [
        &["--controller", "superposed"][..],
        &["--seed", "7"],
        &["--draws", "7"],
        &["--effect", "backlash:A5:half_gap_rad=1e-4"],
        &["--spindle-rpm", "700"],
        &["--period", "0.006"],
        &["--stiffness-error", "0.01"],
        &["--passes", "2"],
    ] {
        refused(more);
    }
    requirements(&place, "0.0021");
    refused(&[]);
}

#[test]
fn a_certificate_says_what_it_is_of_so_that_sha256sum_agrees() {
    let place = Workspace::new();
    requirements(&place, "0.002");
    let model = format!(
        "schema = \"model/1\"\nrobot = {:?}\nprocess = {:?}\n[[effect]]\nid = \"backlash\"\nat = \"A5\"\nhalf_gap_rad = 1e-4\n",
        fixture("robots/kr500-mt.toml"),
        fixture("processes/lap-weld-2024-t3.toml")
    );
    fs::write(place.path().join("model.toml"), model).unwrap();
    let few = ["--trials", "1", "--worst", "0", "--model", "model.toml", "--seed", "9", "-q"];
    let own = ["--effect", "joint-friction:A1:coulomb_nm=20,viscous_nms_rad=1"];
    let output = place.run(&[&CERTIFY[..7], &few, &own, &["--evidence", "e"]].concat());
    // One draw shows nothing of one weld in two at 95 %: that is no pass, and no failure of the draws.
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let value = place.json("e/certify.json");
    assert_ne!(value["verdict"], "pass");
    let draws: Vec<&Value> =
        value["requirements"].as_array().unwrap().iter().filter(|r| r["case"] == "draws").collect();
    assert!(draws.iter().all(|r| r["verdict"] == "not-shown" && r["pass"] == false), "{draws:?}");
    let of = &value["provenance"];
    let ids: Vec<&Value> = of["effects"].as_array().unwrap().iter().map(|e| &e["id"]).collect();
    assert_eq!(ids, ["backlash", "joint-friction"]);
    assert_eq!(of["effects"][0]["values"]["half_gap_rad"], 1e-4);
    let simulation = &of["simulation"];
    assert_eq!(simulation["noise_seed"], 9);
    assert_eq!(
        (&simulation["controllers"][0], &simulation["laws"][0]),
        (&"external".into(), &"seam-tracking".into())
    );
    let files = of["files"].as_array().unwrap();
    let roles: Vec<&str> = files.iter().map(|f| f["role"].as_str().unwrap()).collect();
    assert_eq!(roles, ["weld", "model", "robot", "process", "control", "sensors", "requirements"]);
    for file in files.iter().filter(|f| !f["file"].as_str().unwrap().starts_with("embedded")) {
        let path = file["file"].as_str().unwrap();
        let sum = Command::new("sha256sum").arg(path).current_dir(place.path()).output().unwrap();
        let sum = String::from_utf8(sum.stdout).unwrap();
        assert_eq!(sum.split_whitespace().next(), file["sha256"].as_str(), "{path}");
    }
}

#[test]
fn implausible_values_stand_in_a_certificate_too() {
    let place = Workspace::new();
    requirements(&place, "0.002");
    let text = String::from_utf8(place.bytes("requirements.toml")).unwrap();
    let text = text.replace("failure_probability = 0.5", "failure_probability = 0.6");
    fs::write(place.path().join("requirements.toml"), text).unwrap();
    let few = ["--trials", "1", "--worst", "0", "-q", "--evidence", "e"];
    let output = place.run(&[&CERTIFY[..7], &few].concat());
    let warned = String::from_utf8(output.stderr).unwrap();
    assert!(warned.contains("Warning: ") && warned.contains("failure_probability"), "{warned}");
    assert_valid(&place.bytes("e/certify.json"));
    let value = place.json("e/certify.json");
    let warnings = value["provenance"]["warnings"].as_array().unwrap();
    assert!(
        warnings.iter().any(|w| w.as_str().unwrap().contains("failure_probability")),
        "{warnings:?}"
    );
}

#[test]
fn a_weld_that_is_not_the_one_asked_for_is_said_to_be_none() {
    let place = Workspace::new();
    let changed = |name: &str, from: &str, changes: &[(&str, &str)]| {
        let text = fs::read_to_string(fixture(from)).unwrap();
        let line = |line: &str| match changes.iter().find(|(key, _)| line.starts_with(key)) {
            Some((key, value)) => format!("{key} = {value}\n"),
            None => format!("{line}\n"),
        };
        fs::write(place.path().join(name), text.lines().map(line).collect::<String>()).unwrap();
    };
    let verdict = |more: &[&str], expected: &[&str]| {
        let short = ["weld", "--weld", "short.toml", "--compensator", "elastostatic", "-q"];
        let out = place.done(&[&short[..], more, &["--json", "out.json"]].concat());
        let run = place.json("out.json")["runs"][0].clone();
        let judged = run["judged"].as_array().unwrap();
        let missed = judged.iter().filter(|j| j["met"] == false);
        let missed: Vec<&str> = missed.map(|j| j["figure"].as_str().unwrap()).collect();
        assert!(expected.iter().all(|key| missed.contains(key)), "{more:?}: {missed:?}");
        assert_eq!(run["verdict"] == "pass", missed.is_empty());
        let out = out.split_whitespace().collect::<Vec<_>>().join(" ");
        let told = "not the weld that was asked for";
        assert_eq!(out.contains(told), missed.iter().any(|k| *k != "lateral_max_m"), "{out}");
    };
    verdict(&[], &[]);
    assert_eq!(place.json("out.json")["runs"][0]["verdict"], "pass");
    // The force loop does nothing; the weld is laterally on its line.
    let idle = [("force_kp_m_n", "0.0"), ("force_ki_m_ns", "0.0")];
    changed("idle.toml", "control/kr500-mt.toml", &idle);
    verdict(&["--control", "idle.toml"], &["push_mean_n"]);
    // The correction may be no larger than a few micrometres.
    let held = [("max_translation_m", "1e-5")];
    changed("held.toml", "control/kr500-mt.toml", &held);
    place.done(&["weld", "--weld", "short.toml", "--control", "held.toml", "--json", "out.json"]);
    let first = &place.json("out.json")["runs"][1]["first_limit"];
    assert_eq!((&first["compensation"], &first["torque"]), (&true.into(), &false.into()));
    assert!(first["time_s"].as_f64() > Some(0.0) && first["phase"].is_string(), "{first}");
    let longest = &place.json("out.json")["runs"][1]["limits"][0];
    assert_eq!(longest["what"], "compensation");
    assert!(longest["time_s"].as_f64() > Some(1.0), "{longest}");
}

#[test]
fn equal_runs_give_equal_pages() {
    let place = Workspace::new();
    for page in ["a.html", "b.html"] {
        place.done(&["weld", "--weld", "short.toml", "--html", page]);
    }
    assert!(place.bytes("a.html") == place.bytes("b.html"));
}

#[test]
fn requirements_are_checked_too() {
    let place = Workspace::new();
    let file = fixture("requirements/lap-weld.toml");
    assert!(place.done(&["check", &file]).contains("requirements of a certification, in order"));
    let text = fs::read_to_string(file).unwrap().replace("recovery_s", "recover_s");
    fs::write(place.path().join("wrong.toml"), text).unwrap();
    assert!(place.refused(&["check", "wrong.toml"]).contains("unknown key `recover_s`"));
}

#[test]
fn a_limit_of_faults_beyond_half_the_pin_is_refused_as_none() {
    let place = Workspace::new();
    for key in ["lateral_max_m", "depth_max_m"] {
        let limit = format!("{key} = 2.6e-3\n");
        let is_it = |line: &str| line.contains("half the pin") || line.contains("the skin");
        place.requirements(|k, line| (k == key && is_it(line)).then(|| limit.clone()));
        let said = place.refused(&certify("none"));
        let what =
            format!("`{key}` in [faults] is 2.60 mm; expected at most half the pin, 2.50 mm");
        assert!(said.contains("requirements.toml: ") && said.contains(&what), "{said}");
    }
}

#[test]
fn two_welds_of_one_name_are_refused_before_anything_runs() {
    let place = Workspace::new();
    requirements(&place, "0.002");
    fs::create_dir(place.path().join("other")).unwrap();
    fs::copy(place.path().join("short.toml"), place.path().join("other/short.toml")).unwrap();
    fs::create_dir(place.path().join("e")).unwrap();
    let message =
        place.refused(&[&CERTIFY[..], &["--weld", "other/short.toml", "--evidence", "e"]].concat());
    assert!(message.contains("other/short.toml") && message.contains("two welds"), "{message}");
    assert_eq!(fs::read_dir(place.path().join("e")).unwrap().count(), 0);
}

#[test]
fn counts_out_of_their_range_are_refused() {
    let place = Workspace::new();
    for arguments in [
        &["weld", "--passes", "0"][..],
        &["weld", "--passes", "18446744073709551615"],
        &["compare-laws", "--passes", "1000000"],
        &["certify", "--compensator", "none", "--passes", "0"],
        &["certify", "--compensator", "none", "--trials", "18446744073709551615"],
        &["certify", "--compensator", "none", "--worst", "1000000000000"],
        // It acts on a recording alone.
        &["weld", "--exaggeration", "2"],
    ] {
        let message = place.refused(arguments);
        assert!(message.contains(arguments[arguments.len() - 2]), "{message}");
    }
}

#[test]
fn a_law_that_fails_its_requirements_ends_with_a_status_that_says_so() {
    let place = Workspace::new();
    requirements(&place, "0.00001");
    let output =
        place.run(&[&CERTIFY[..], &["--evidence", "evidence", "--json", "result.json"]].concat());
    assert_eq!(output.status.code(), Some(1));
    let value = place.json("result.json");
    assert_eq!(value["verdict"], "fail");
    let failed: Vec<&Value> =
        value["requirements"].as_array().unwrap().iter().filter(|r| r["pass"] == false).collect();
    let names: Vec<_> =
        failed.iter().map(|r| (r["case"].as_str().unwrap(), r["name"].as_str().unwrap())).collect();
    let expected = [
        ("nominal", "lateral_rms_m"),
        ("draws", "lateral_rms_m"),
        // All limits together.
        ("draws", "of_limit"),
        ("faults", "undetected_of_limit"),
        ("faults", "recovered_lateral_rms_m"),
    ];
    assert_eq!(names, expected);
    let says = |r: &Value| match r["name"].as_str() {
        Some("of_limit") => "times its limit",
        _ => "leaves its line",
    };
    for r in failed {
        assert!(r["reason"].as_str().is_some_and(|why| why.contains(says(r))), "{r}");
    }
    let help = place.done(&["certify", "--help"]);
    assert!(help.contains("--evidence"), "{help}");
}

#[test]
fn logs_and_campaigns_are_checked_too() {
    let place = Workspace::new();
    for file in ["campaigns/backlash/campaign.toml", "campaigns/backlash/static/log.toml"] {
        assert!(place.done(&["check", &fixture(file)]).contains(", in order"), "{file}");
    }
}

#[test]
fn a_campaign_is_checked_with_logs_that_lie_elsewhere_and_what_is_left_out_is_told() {
    let place = Workspace::new();
    place.done(&["init", "cell"]);
    let logs = format!("[\"../free\", {:?}]", fixture("campaigns/backlash/static"));
    let list = "schema = \"campaign/1\"\nmodel = \"model.toml\"\nlogs = ".to_owned() + &logs;
    fs::create_dir(place.path().join("list")).unwrap();
    fs::write(place.path().join("list/campaign.toml"), list).unwrap();
    let model = format!("schema = \"model/1\"\nrobot = {:?}\n", fixture("robots/kr500-mt.toml"));
    fs::write(place.path().join("list/model.toml"), model).unwrap();
    // A torque that is misspelt is a torque that is lost.
    fs::create_dir(place.path().join("free")).unwrap();
    let samples = fs::read_to_string(fixture("campaigns/backlash/free/samples.csv")).unwrap();
    let samples = samples.replacen(",tm1_nm,", ",tm_1,", 1);
    fs::write(place.path().join("free/samples.csv"), samples).unwrap();
    let toml = fs::read_to_string(fixture("campaigns/backlash/free/log.toml")).unwrap();
    let robot = format!("robot = {:?}", fixture("robots/kr500-mt.toml"));
    let toml = toml.lines().map(|l| if l.starts_with("robot") { &robot } else { l });
    let toml = toml.collect::<Vec<_>>().join("\n");
    fs::write(place.path().join("free/log.toml"), &toml).unwrap();
    let out = place.done(&["check", "list", "--json", "check.json"]);
    assert!(out.contains("static/log.toml: a log of measurements, in order"), "{out}");
    assert!(out.contains("tm_1"), "{out}");
    let result = place.json("check.json");
    let told = |file: &serde_json::Value| file["notices"].as_array().is_some_and(|n| n.len() == 1);
    assert!(result["files"].as_array().unwrap().iter().any(told), "{result}");
    // A log that is not filled in is told of, wherever it lies.
    let open = toml.replace("robot = ", "weld = \"FILL IN\"\nrobot = ");
    fs::write(place.path().join("free/log.toml"), open).unwrap();
    assert!(place.refused(&["check", "list"]).contains("free/log.toml"));
}

#[test]
fn a_template_that_nobody_filled_in_gives_way_to_a_proposal() {
    let place = Workspace::new();
    place.done(&["init", "cell"]);
    let [krc, robot] = ["raw/krc.csv", "robots/kr500-mt.toml"].map(fixture);
    let import = ["import-log", &krc, "--robot", &robot, "--out", "cell/free"];
    place.done(&import);
    assert!(place.refused(&import).contains("there is a log.toml already"));
}

#[test]
fn an_improvement_keeps_to_its_budget_and_says_what_it_left_undone() {
    let place = Workspace::new();
    let campaign = fixture("campaigns/backlash");
    let begun = Instant::now();
    place.done(&["compare", &campaign, "--json", "compare.json"]);
    // What the logs take to be read and predicted, under whatever else the machine does.
    let read = begun.elapsed();
    let begun = Instant::now();
    let budget = read.as_secs_f64().to_string();
    let all = ["improve", &campaign, "--out", "m.toml", "--json", "i.json", "--budget", &budget];
    let out = place.done(&all);
    // Beyond the budget: what was under way, and the result. Without one it takes ten times as long.
    assert!(begun.elapsed() < 4 * read, "{:?}, {read:?} to read", begun.elapsed());
    assert!(out.contains("Left undone"), "{out}");
    assert!(!place.json("i.json")["undone"].as_array().unwrap().is_empty());
}
