//! What a weld over RSI leaves behind, and a core that knows its model.

use crate::support::{Workspace, fixture};
use std::fs;
use std::net::UdpSocket;
use std::thread;

/// An address of this machine with a port that nobody has.
fn free_address() -> String {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.local_addr().unwrap().to_string()
}

/// Context and monitor that the published weld fits into.
const OPENED: [&str; 5] = ["--lock-step", "--clamp-mm", "15", "--monitor-mm", "20"];

#[test]
fn the_log_of_a_weld_over_rsi_is_compared_with_the_model_that_it_was_made_with() {
    let place = Workspace::new();
    let address = free_address();
    let weld =
        ["rsi-robot", "--weld", "short.toml", "--compensator", "elastostatic", "--log", "log"];
    let weld = [&weld[..], &["--to", &address], &OPENED].concat();
    assert!(place.done(&weld).contains("wrote log"));
    let checked = place.done(&["check", "log"]);
    assert!(checked.contains("a campaign of logs, in order"), "{checked}");
    place.done(&["compare", "log", "--json", "compare.json"]);
    let compared = place.json("compare.json");
    // Nothing is missing in the model: the noise floor, within what three thousand samples tell.
    let score = compared["score"].as_f64().unwrap();
    assert!((0.7..1.1).contains(&score), "{score}");
    let rows = fs::read_to_string(place.path().join("log/weld/samples.csv")).unwrap();
    let spindle = rows.lines().nth(1).and_then(|row| row.rsplit(',').next()).unwrap();
    assert_eq!(spindle, "-62.83185");
    // Recordings are never written over.
    let said = place.refused(&weld);
    assert!(said.contains("--log log: there is something in this folder"), "{said}");
}

#[test]
fn the_log_of_a_client_has_what_came_over_the_line() {
    let place = Workspace::new();
    let address = free_address();
    let client = ["rsi-compensate", "--weld", "short.toml", "--authority-mm", "15"];
    let client = [&client[..], &["--listen", &address, "--log", "log"]].concat();
    let robot = [&["rsi-robot", "--weld", "short.toml", "--to", &address][..], &OPENED].concat();
    thread::scope(|scope| {
        let client = scope.spawn(|| place.done(&client));
        place.done(&robot);
        assert!(client.join().unwrap().contains("wrote log"));
    });
    place.done(&["check", "log"]);
    // A tracker is another instrument: what is missing is said.
    let said = place.refused(&["compare", "log"]);
    assert!(said.contains("it needs tracker and wrench columns"), "{said}");
    let rows = fs::read_to_string(place.path().join("log/weld/samples.csv")).unwrap();
    // Twelve seconds at 12 ms, but for the settling before RSI is on.
    assert!(rows.lines().count() > 900, "{}", rows.lines().count());
}

#[test]
fn a_client_tells_a_controller_that_fell_silent_from_the_end_of_a_weld() {
    let place = Workspace::new();
    let address = free_address();
    let client = ["rsi-compensate", "--weld", "short.toml", "--silence", "0.5"];
    let client = [&client[..], &["--listen", &address, "--controller", "127.0.0.1"]].concat();
    // RSI stops as soon as the correction is larger than is monitored.
    let robot = ["rsi-robot", "--weld", "short.toml", "--lock-step", "--monitor-mm", "0.5"];
    let robot = [&robot[..], &["--to", &address]].concat();
    thread::scope(|scope| {
        let client = scope.spawn(|| place.refused(&client));
        assert!(place.refused(&robot).contains("KSS29000"));
        let said = client.join().unwrap();
        assert!(said.contains("the controller fell silent"), "{said}");
        assert!(said.contains("before the end of the seam"), "{said}");
    });
}

#[test]
fn an_element_that_no_packet_has_is_refused_with_those_that_there_are() {
    let place = Workspace::new();
    let said = place.refused(&["rsi-robot", "--send", "DEF_RIst,RPos"]);
    assert!(said.contains("\"RPos\" is no element; expected some of RIst, RSol, AIPos"), "{said}");
}

#[test]
fn a_viewer_that_is_not_there_is_said_before_anything_is_welded() {
    let place = Workspace::new();
    let url = "rerun+http://127.0.0.1:1/proxy";
    let said = place.refused(&["rsi-robot", "--weld", "short.toml", "--live", url]);
    assert!(said.contains("--live") && said.contains(url), "{said}");
}

#[test]
fn a_core_knows_what_its_model_file_says_of_the_robot_and_nothing_is_left_out_unsaid() {
    let place = Workspace::new();
    let text = fs::read_to_string(fixture("robots/kr500-mt.toml")).unwrap();
    assert_eq!(text.matches("stiffness_nm_rad = 6.2e6").count(), 1);
    let softer = text.replace("stiffness_nm_rad = 6.2e6", "stiffness_nm_rad = 3.1e6");
    fs::write(place.path().join("softer.toml"), softer).unwrap();
    let model = |name: &str, effect: &str| {
        let text = format!(
            "schema = \"model/1\"\nrobot = {:?}\nprocess = {:?}\n[[effect]]\n{effect}\n",
            fixture("robots/kr500-mt.toml"),
            fixture("processes/lap-weld-2024-t3.toml")
        );
        fs::write(place.path().join(name), text).unwrap();
    };
    model("soft.toml", "id = \"stiffness-error\"\nat = \"A3\"\nrelative = -0.5");
    model("loose.toml", "id = \"backlash\"\nat = \"A5\"\nhalf_gap_rad = 2e-4");
    let exported = |arguments: &[&str]| {
        place.done(&[&["export-core", "--compensator", "elastostatic"], arguments].concat())
    };
    let digest = |said: &str| {
        said.lines().find(|line| line.starts_with("digest")).map(str::to_owned).unwrap()
    };
    // The same core as of a robot file with that stiffness.
    let informed = exported(&["--model", "soft.toml", "--informed"]);
    assert_eq!(digest(&informed), digest(&exported(&["--robot", "softer.toml"])));
    let uninformed = exported(&["--model", "soft.toml"]);
    assert!(uninformed.contains("without stiffness-error at A3: --informed"), "{uninformed}");
    assert_eq!(digest(&uninformed), digest(&exported(&[])));
    // What a core cannot hold is named.
    let loose = ["export-core", "--compensator", "elastostatic", "--model", "loose.toml"];
    let said = place.refused(&[&loose[..], &["--informed"]].concat());
    assert!(said.contains("cannot hold backlash at A5"), "{said}");
}
