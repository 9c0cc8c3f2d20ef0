//! The first day with files of one's own: a folder to fill in, and files that are empty, cut, given
//! twice or in another unit than they say.

use crate::support::{Workspace, fixture};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// The TOML files of a folder and of those in it.
fn tomls(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(tomls(&path));
        } else if path.extension().is_some_and(|e| e == "toml") {
            found.push(path);
        }
    }
    found
}

#[test]
fn a_fresh_folder_lists_what_is_open_and_passes_when_it_is_filled_in() {
    let place = Workspace::new();
    place.done(&["init", "my-cell"]);
    let again = place.refused(&["init", "my-cell"]);
    assert!(again.contains("cannot make the folder my-cell"), "{again}");

    let cell = place.path().join("my-cell");
    let open: usize = tomls(&cell)
        .iter()
        .map(|f| fs::read_to_string(f).unwrap().matches("\"FILL IN: ").count())
        .sum();
    assert!(open > 100, "{open}");
    let checked = place.run(&["check", "my-cell", "--json", "check.json"]);
    assert_eq!(checked.status.code(), Some(1));
    let text = String::from_utf8(checked.stderr).unwrap();
    // One line an entry, with its file, its place and what is expected.
    let lines: Vec<&str> =
        text.lines().filter(|l| l.contains("is still to be filled in")).collect();
    assert_eq!(lines.len(), open, "{text}");
    assert!(lines.iter().all(|l| l.contains(".toml:") && l.contains("; expected ")), "{text}");

    for file in tomls(&cell) {
        let text = fs::read_to_string(&file).unwrap();
        let filled = |line: &str| match line.split_once("\"FILL IN: ") {
            Some((before, rest)) => {
                let (value, after) = rest.split_once('"').unwrap();
                format!("{before}{value}{after}\n")
            }
            None => format!("{line}\n"),
        };
        fs::write(file, text.lines().map(filled).collect::<String>()).unwrap();
    }
    // Nothing is recorded yet.
    let empty = String::from_utf8(place.run(&["check", "my-cell"]).stderr).unwrap();
    assert_eq!(empty.matches("there is no row after the header").count(), 4, "{empty}");
    for (log, from) in
        [("static", "static"), ("ring", "ring-25"), ("free", "free"), ("weld", "weld-1")]
    {
        let samples = fixture(&format!("campaigns/backlash/{from}/samples.csv"));
        fs::copy(samples, cell.join(log).join("samples.csv")).unwrap();
    }
    let text = place.done(&["check", "my-cell", "--json", "check.json"]);
    assert_eq!(text.matches(", in order").count(), 9, "{text}");
}

/// What `import-log` says of these files, which it cannot make a log of.
fn refused(place: &Workspace, files: &[&str]) -> String {
    let robot = fixture("campaigns/backlash/robot.toml");
    let mut arguments = vec!["import-log"];
    arguments.extend(files);
    arguments.extend(["--robot", &robot, "--out", "log"]);
    place.refused(&arguments)
}

#[test]
fn files_that_are_no_recording_are_refused() {
    let place = Workspace::new();
    let controller = fs::read_to_string(fixture("raw/krc.csv")).unwrap();
    let write = |name: &str, text: &[u8]| fs::write(place.path().join(name), text).unwrap();
    write("empty.csv", b"");
    write("header.csv", controller.lines().next().unwrap().as_bytes());
    write("cut.csv", &controller.as_bytes()[..5000]);
    write(
        "noise.csv",
        &(0..4000u32)
            .map(|k| (k.wrapping_mul(k).wrapping_mul(7919) >> 7).to_le_bytes()[0])
            .collect::<Vec<_>>(),
    );
    fs::create_dir(place.path().join("folder")).unwrap();
    let again = fixture("raw/krc.csv");
    for (files, said) in [
        (vec!["empty.csv"], "the file is empty"),
        (vec!["header.csv"], "there is no row after the header"),
        (vec!["cut.csv"], "the recording was cut off"),
        (vec!["noise.csv"], "noise.csv"),
        (vec!["folder"], "it is a folder"),
        (vec!["missing.csv"], "cannot be read"),
        (vec![again.as_str(), again.as_str()], "this file is given twice"),
    ] {
        let told = refused(&place, &files);
        assert!(told.contains(said), "{files:?}: {told}");
    }
}

#[test]
fn a_number_of_any_size_is_shown_short() {
    let place = Workspace::new();
    fs::write(place.path().join("huge.csv"), "t_s,qe1_rad\n0,1e19\n0.1,0.5\n").unwrap();
    let robot = fixture("campaigns/backlash/robot.toml");
    let told = place.done(&["import-log", "huge.csv", "--robot", &robot, "--out", "log"]);
    assert!(told.contains("0.5000 … 1.000e19"), "{told}");
}

/// A URDF's robot, rows without a time, and nobody to ask.
#[test]
fn a_log_is_proposed_for_a_robot_straight_from_its_urdf() {
    let place = Workspace::new();
    let urdf = fixture("robots/kr210-r2700.urdf");
    place.done(&["import-urdf", &urdf, "--out", "robot.toml"]);
    let mut rows = "J1,J2,J3,J4,J5,J6\n".to_owned();
    for k in 0..300 {
        let angle = |i: u32| 20.0 * (0.02 * f64::from(k) + f64::from(i)).sin() - 10.0;
        let fields: Vec<String> = (0..6).map(|i| format!("{:.4}", angle(i))).collect();
        rows += &(fields.join(",") + "\n");
    }
    fs::write(place.path().join("joints.csv"), rows).unwrap();
    let mut import = vec!["import-log", "joints.csv", "--robot", "robot.toml", "--out", "log"];
    import.extend(["--period", "0.004", "--yes", "--html", "import.html"]);
    let told = place.done(&import);
    assert!(told.contains("how sure"), "{told}");
    let log = fs::read_to_string(place.path().join("log/log.toml")).unwrap();
    assert!(log.contains("period_s = 0.004"), "{log}");
    // The robot's own values are open still; nothing of the log is.
    assert!(!log.lines().any(|line| line.contains("= \"FILL IN")), "{log}");
    let page = fs::read_to_string(place.path().join("import.html")).unwrap();
    assert!(page.contains("What each channel reads"), "no pictures");
    // A file of which nothing is known is not read.
    fs::write(place.path().join("notes.csv"), "mood,weather\n1,2\n2,3\n").unwrap();
    place.done(&["import-log", "joints.csv", "notes.csv", "--period", "0.004", "--out", "both"]);
    let log = fs::read_to_string(place.path().join("both/log.toml")).unwrap();
    assert!(log.contains("# no column of it is known: { path = \"../notes.csv\""), "{log}");
    let told = place.refused(&["import-log", "joints.csv", "--period", "0", "--out", "other"]);
    assert!(told.contains("above 0"), "{told}");
}

/// Columns of a proposal whose mapping is open in some way, with what is open.
fn doubts(result: &Value) -> Vec<(String, String)> {
    let columns = result["columns"].as_array().unwrap().iter();
    let open = columns.filter_map(|c| Some((c["header"].as_str()?, c["doubts"].as_array()?)));
    open.flat_map(|(header, all)| {
        all.iter().map(move |d| (header.to_owned(), d.as_str().unwrap().to_owned()))
    })
    .collect()
}

#[test]
fn a_header_of_another_unit_than_its_values_is_a_guess() {
    let place = Workspace::new();
    let tracker = fs::read_to_string(fixture("raw/tracker.txt")).unwrap();
    // Metres below a header that says millimetres.
    let metres = |line: &str| {
        let mut fields: Vec<String> = line.split('\t').map(str::to_owned).collect();
        for field in fields.iter_mut().skip(1).take(3) {
            if let Ok(value) = field.parse::<f64>() {
                *field = (value * 1e-3).to_string();
            }
        }
        fields.join("\t") + "\n"
    };
    let text: String = tracker.lines().map(metres).collect();
    fs::write(place.path().join("tracker.txt"), text).unwrap();
    let (controller, robot) = (fixture("raw/krc.csv"), fixture("campaigns/backlash/robot.toml"));
    place.done(&[
        "import-log",
        &controller,
        "tracker.txt",
        "--robot",
        &robot,
        "--out",
        "log",
        "--json",
        "i.json",
    ]);
    let open = doubts(&place.json("i.json"));
    let expected = ["X [mm]", "Y [mm]", "Z [mm]"].map(|h| (h.to_owned(), "unit".to_owned()));
    assert_eq!(open, expected);
    let log = fs::read_to_string(place.path().join("log/log.toml")).unwrap();
    assert!(log.contains("unit = \"FILL IN: mm?\""), "{log}");
    assert!(log.contains("off by a thousand"), "{log}");
}

/// Without a tracker nothing tells which way a vertical axis counts, nor then which way its torque
/// does.
#[test]
fn the_sign_of_a_torque_is_as_open_as_that_of_its_axis() {
    let place = Workspace::new();
    let (controller, robot) = (fixture("raw/krc.csv"), fixture("campaigns/backlash/robot.toml"));
    place.done(&["import-log", &controller, "--robot", &robot, "--out", "log", "--json", "i.json"]);
    let open = doubts(&place.json("i.json"));
    for axis in 1..=6 {
        let open = |name: String| open.contains(&(name, "sign".to_owned()));
        let (angle, torque) =
            (open(format!("AXIS_ACT.A{axis} [deg]")), open(format!("MOT_TRQ_{axis} [Nm]")));
        assert!(torque || !angle, "A{axis}");
        assert_eq!(angle, axis != 2 && axis != 3, "A{axis}");
    }
}
