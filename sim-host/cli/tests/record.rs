//! The virtual laboratory and what is identified from it, from the command line.

use crate::support::{Workspace, fixture};
use std::fs;

/// Records a fixture's protocol, changed, into `campaign`.
fn recorded(change: impl Fn(&str) -> String) -> Workspace {
    let place = Workspace::new();
    let text = fs::read_to_string(fixture("protocols/laboratory-day.toml")).unwrap();
    let text = change(&text).replace("\"../", &format!("\"{}", fixture("")));
    fs::write(place.path().join("protocol.toml"), text).unwrap();
    place.done(&["record", "protocol.toml", "--out", "campaign", "--truth", "truth.toml", "-q"]);
    place
}

#[test]
fn what_is_recorded_of_the_model_scores_one() {
    let place = recorded(str::to_owned);
    place.done(&["compare", "campaign", "--json", "compare.json", "-q"]);
    let json = place.json("compare.json");
    let names = ["loads", "stop-123", "stop-456", "motion", "weld"];
    for (log, name) in json["logs"].as_array().unwrap().iter().zip(names) {
        assert_eq!(log["path"].as_str().unwrap(), format!("campaign/{name}"));
        for channel in log["channels"].as_array().unwrap() {
            // Three standard deviations of √(χ²/n). In a band samples follow each other: a quarter
            // of them count. What drives a weld's prediction is taken for an upper bound of noise.
            let samples = channel["samples"].as_f64().unwrap();
            let each = if ["loads", "stop-123", "stop-456"].contains(&name) { 1.0 } else { 0.25 };
            let far = channel["score"].as_f64().unwrap() - 1.0;
            let most = 3.0 / (2.0 * each * samples).sqrt();
            assert!(far < most, "{name}: {channel}");
            assert!(far > -most || name == "weld", "{name}: {channel}");
        }
    }
    let truth = fs::read_to_string(place.path().join("truth.toml")).unwrap();
    assert!(truth.contains("verdict = \"adequate\""));
    assert!(!place.path().join("campaign/truth.toml").exists());
}

/// The KR 500 with A5 beside the axis of A4, and A6 beside that of A5.
#[test]
fn an_arm_without_a_spherical_wrist_welds_and_is_recorded_and_compared() {
    let place = Workspace::new();
    let mut joint = 0;
    let line = |line: &str| {
        joint += usize::from(line == "[[joint]]");
        match (joint, line.starts_with("origin_m")) {
            (5, true) => "origin_m = [1.025, 0.12, 0.05]\n".to_owned(),
            (6, true) => "origin_m = [0.0, -0.08, 0.10]\n".to_owned(),
            _ => format!("{line}\n"),
        }
    };
    let robot = fs::read_to_string(fixture("robots/kr500-mt.toml")).unwrap();
    fs::write(place.path().join("robot.toml"), robot.lines().map(line).collect::<String>())
        .unwrap();
    place.done(&["check", "robot.toml"]);

    let off = |law: &str| {
        let weld = ["weld", "--robot", "robot.toml", "--weld", "short.toml", "--compensator", law];
        place.done(&[&weld[..], &["--json", "weld.json", "-q"]].concat());
        let runs = place.json("weld.json")["runs"].clone();
        let last = runs.as_array().unwrap().last().unwrap().clone();
        last["lateral_m"]["max_abs"].as_f64().unwrap()
    };
    // The arm bends as much as with its own wrist, and the law corrects it as well.
    let (bare, corrected) = (off("none"), off("seam-tracking"));
    assert!((2e-3..8e-3).contains(&bare), "{bare}");
    assert!(corrected < 0.2e-3, "{corrected}");

    let weld = fixture("welds/coupon.toml");
    let protocol = format!(
        "schema = \"protocol/1\"\nrobot = \"robot.toml\"\nprocess = {:?}\nseed = 1\n[[log]]\nname = \"weld\"\n\
         kind = \"weld\"\nweld = {weld:?}\n",
        fixture("processes/lap-weld-2024-t3.toml")
    );
    fs::write(place.path().join("protocol.toml"), protocol).unwrap();
    place.done(&["record", "protocol.toml", "--out", "campaign", "-q"]);
    place.done(&["compare", "campaign", "--json", "compare.json", "-q"]);
    let score = place.json("compare.json")["score"].as_f64().unwrap();
    assert!((0.7..1.1).contains(&score), "{score}");

    // What only branches can say is refused in a sentence.
    let layout = ["study", "layout", "--robot", "robot.toml", "--weld", "short.toml"];
    let own = ["--compensator", "none", "-q", "--html", "page.html"];
    let told = place.refused(&[&layout[..], &own].concat());
    assert!(told.contains("spherical wrist"), "{told}");
}

/// The KR 210 without its tool: a light wrist, and the damper of its drive on it.
#[test]
fn a_wrist_that_swings_faster_than_the_step_is_recorded_and_compared() {
    let place = Workspace::new();
    let robot = fs::read_to_string(fixture("robots/kr210-fsw.toml")).unwrap();
    let tool = "xx = 1.5, yy = 3.0, zz = 3.0";
    assert!(robot.contains("\nmass_kg = 110.0") && robot.contains(tool));
    let robot = robot
        .replace("\nmass_kg = 110.0", "\nmass_kg = 0.0")
        .replace(tool, "xx = 0.0, yy = 0.0, zz = 0.0");
    fs::write(place.path().join("robot.toml"), &robot).unwrap();
    let protocol = "schema = \"protocol/1\"\nrobot = \"robot.toml\"\nseed = 1\n[[log]]\nname = \"motion\"\n\
                    kind = \"free-motion\"\nposture_deg = [20, -50, 95, 0, 45, 0]\n[[log.waypoint]]\n\
                    posture_deg = [40, -40, 105, 40, -30, 40]\ntakes_s = 3.0\n";
    fs::write(place.path().join("protocol.toml"), protocol).unwrap();
    place.done(&["record", "protocol.toml", "--out", "campaign", "-q"]);
    place.done(&["compare", "campaign", "--json", "compare.json", "-q"]);
    let score = place.json("compare.json")["score"].as_f64().unwrap();
    // 1.0 but for chance and what is an upper bound of noise.
    assert!((0.8..1.1).contains(&score), "{score}");

    // What nobody can follow is named, by the check as by the commands.
    let stiff = robot.replace("stiffness_nm_rad = 470000.0", "stiffness_nm_rad = 4.7e8");
    assert_ne!(stiff, robot);
    fs::write(place.path().join("robot.toml"), &stiff).unwrap();
    let named = "A6 swings at ";
    assert!(place.done(&["check", "robot.toml"]).contains(named));
    fs::write(place.path().join("campaign/robot.toml"), &stiff).unwrap();
    let refused = place.run(&["record", "protocol.toml", "--out", "more"]);
    assert!(!refused.status.success());
    assert!(String::from_utf8_lossy(&refused.stderr).contains(named), "{refused:?}");
    assert!(!place.path().join("more").exists(), "half a campaign");
    assert!(place.refused(&["compare", "campaign"]).contains(named));
}

#[test]
fn welds_along_curved_seams_are_compared_and_what_is_along_them_is_named() {
    let place = Workspace::new();
    let text = fs::read_to_string(fixture("protocols/panel-welds.toml")).unwrap();
    let hidden = text.replace("\"../", &format!("\"{}", fixture("")));
    let effect = hidden.find("[[effect]]").unwrap()..hidden.find("[[log]]").unwrap();
    let mut clean = hidden.clone();
    clean.replace_range(effect, "");
    for (name, text) in [("clean", &clean), ("hidden", &hidden)] {
        let protocol = format!("{name}.toml");
        fs::write(place.path().join(&protocol), text).unwrap();
        place.done(&["record", &protocol, "--out", name, "--json", "record.json", "-q"]);
    }
    let recorded = place.json("record.json");
    assert_eq!(recorded["provenance"]["effects"][0]["id"], "material-step");
    for log in recorded["logs"].as_array().unwrap() {
        let table = place.bytes(&format!("hidden/{}/samples.csv", log["name"].as_str().unwrap()));
        let rows = table.iter().filter(|byte| **byte == b'\n').count() - 1;
        assert_eq!(log["rows"], rows, "{log}");
    }
    place.done(&["compare", "clean", "--json", "compare.json", "-q"]);
    for log in place.json("compare.json")["logs"].as_array().unwrap() {
        let score = log["score"].as_f64().unwrap();
        assert!(score < 1.1, "{log}");
    }
    place.done(&["diagnose", "hidden", "--json", "diagnose.json", "-q"]);
    let found = &place.json("diagnose.json")["candidates"][0]["effects"][0];
    assert_eq!(found["effect"], "material-step", "{found}");
    // Three standard deviations; intervals of 95 % have two.
    let holds = |name: &str, truth: f64| {
        let [low, value, high] =
            ["low", "value", "high"].map(|of| found["parameters"][name][of].as_f64().unwrap());
        assert!((value - truth).abs() < 0.75 * (high - low), "{name}: {found}");
    };
    holds("ratio", 0.1);
    holds("position_m", 0.3);
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_one_others() {
    let one = |text: &str| text.split("[[log]]\nname = \"stop").next().unwrap().to_owned();
    let place = recorded(one);
    for (out, seed) in [("again", "1"), ("other", "2")] {
        place.done(&["record", "protocol.toml", "--out", out, "--seed", seed, "-q"]);
    }
    let samples = |name: &str| place.bytes(&format!("{name}/loads/samples.csv"));
    assert_eq!(samples("campaign"), samples("again"));
    assert_ne!(samples("campaign"), samples("other"));
}

#[test]
fn a_protocol_that_cannot_be_recorded_is_refused_at_its_place() {
    let place = Workspace::new();
    let text = fs::read_to_string(fixture("protocols/laboratory-day.toml")).unwrap();
    let text = text.replace("\"../", &format!("\"{}", fixture("")));
    let cases = [
        ("[20, -50, 95, 0, 45, 0]", "[20, -50, 950, 0, 45, 0]", "A3 goes from -100.0 to 144.0"),
        ("payload_kg = 500", "payload_kg = 5e9", "`payload_kg`"),
        (
            "rate_deg_s = [4, 3, 4, 0, 0, 0]",
            "rate_deg_s = [0, 0, 0, 0, 0, 0]",
            "a joint that turns",
        ),
        (
            "rate_deg_s = [4, 3, 4, 0, 0, 0]",
            "rate_deg_s = [400, 3, 4, 0, 0, 0]",
            "A1 turns at up to",
        ),
        ("takes_s = 2.5", "takes_s = 0.1", "needs"),
        ("kind = \"weld\"", "kind = \"wield\"", "static-load, ring-down, free-motion or weld"),
        ("name = \"motion\"", "name = \"../motion\"", "a short name"),
        ("name = \"motion\"", "name = \"weld\"", "a name that no other log has"),
        ("seed = 1", "seed = 1\n[noise]\nforce_n = 1e9\n", "`force_n`"),
    ];
    for (from, to, expected) in cases {
        assert!(text.contains(from), "{from}");
        fs::write(place.path().join("protocol.toml"), text.replacen(from, to, 1)).unwrap();
        let told = place.refused(&["record", "protocol.toml", "--out", "campaign", "-q"]);
        assert!(told.contains(expected), "{to}: {told}");
    }
    fs::write(place.path().join("protocol.toml"), "schema = \"protocol/1\"\n").unwrap();
    let told = place.refused(&["record", "protocol.toml", "--out", "campaign"]);
    assert!(told.contains("missing key `robot`"), "{told}");
}

#[test]
fn what_experiments_would_show_is_said_before_they_are_made() {
    let place = Workspace::new();
    let protocol = fixture("protocols/unknown-stiffness.toml");
    place.done(&["plan", &protocol, "--json", "plan.json", "--html", "plan.html", "-q"]);
    let json = place.json("plan.json");
    let all = |key: &str| json[key].as_array().unwrap().clone();
    let is = |e: &serde_json::Value, effect: &str| e["effect"].as_str() == Some(effect);
    // Loads at rest know of stiffness, and nothing of friction or of a process.
    assert!(all("shown").iter().any(|e| is(e, "nonlinear-stiffness") && e["best_log"] == "loads"));
    for effect in ["joint-friction", "drag-error", "channel-delay"] {
        assert!(all("shown").iter().all(|e| !is(e, effect)), "{effect}");
        assert!(all("not_shown").iter().any(|e| is(e, effect)), "{effect}");
    }
    // A base that gives and a first bearing that gives are the same to them.
    let base = |pair: &&serde_json::Value| {
        is(&pair["first"], "base-compliance") && is(&pair["second"], "bearing-tilt")
    };
    assert!(all("confusable").iter().any(|pair| base(&pair)));
    // Nothing is left behind, and another robot may be asked about.
    assert_eq!(place.files(), ["plan.html", "plan.json", "short.toml"]);
    let robot = fixture("robots/kr500-mt.toml");
    place.done(&["plan", &protocol, "--robot", &robot, "--json", "same.json", "-q"]);
    assert_eq!(place.json("same.json")["shown"], json["shown"]);
    let refused = place.refused(&["plan", &protocol, "--robot", "none.toml"]);
    assert!(refused.contains("none.toml"), "{refused}");
}
