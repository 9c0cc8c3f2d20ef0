//! The files of a laboratory: a campaign as two instruments would have written it, in their units,
//! on their clocks, reads as the clean one does.

#[path = "../../../tests/src/raw_files.rs"]
mod raw_files;

use nalgebra::Vector3;
use raw_files::{PLACES, PoseForm, raw};
use std::fs;
use std::path::{Path, PathBuf};
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JointVector, Pose};
use trueweld_diagnose::{FittedEffect, diagnose};
use trueweld_estimate::align::align_clocks;
use trueweld_estimate::fit::FitProblem;
use trueweld_estimate::residuals::compare::{Comparison, baseline, compare, experiments};
use trueweld_logs::campaign::read_logs;
use trueweld_logs::log::import::{Doubt, LeftOut, Proposal, ProposedColumn, Stated, propose};
use trueweld_logs::log::{Log, LogKind, NoiseLevel};
use trueweld_plant::effects::Location;
use trueweld_plant::input::{InputFile, ModelFile, RobotFile};

fn fixture(path: &str) -> PathBuf {
    let fixtures = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    fixtures.join(path).canonicalize().expect("a fixture")
}

/// A campaign, raw; every log in its own form.
fn raw_campaign(campaign: &Path, folder: &Path, stated: bool) -> Vec<PathBuf> {
    let mut logs = Vec::new();
    for (k, name) in LOGS.iter().enumerate() {
        raw(&campaign.join(name), &folder.join(name), PoseForm::ALL[k % 3], stated);
        logs.push(folder.join(name));
    }
    logs
}

const LOGS: [&str; 5] = ["static", "ring-25", "free", "weld-1", "weld-2"];

fn compared(campaign: &Path, paths: &[PathBuf]) -> (Vec<Log>, Comparison) {
    let (_, mut logs) = read_logs(paths).expect("logs");
    let model = ModelFile::read(campaign.join("model.toml")).expect("a model");
    let baseline = baseline(&model);
    align_clocks(&mut logs, &baseline).expect("clocks");
    let problem = FitProblem::new(&model, experiments(&logs, &baseline).expect("experiments"));
    let comparison = compare(&model, &logs, &problem, &|_| ()).expect("a comparison");
    (logs, comparison)
}

/// Scores of every log, raw against clean, within one percent.
fn same_scores(campaign: &str, stated: bool) {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = fixture(campaign);
    let clean: Vec<PathBuf> = LOGS.iter().map(|name| campaign.join(name)).collect();
    let (_, clean) = compared(&campaign, &clean);
    let (logs, raw) = compared(&campaign, &raw_campaign(&campaign, folder.path(), stated));
    for (log, (raw, clean)) in logs.iter().zip(raw.logs.iter().zip(&clean.logs)) {
        let clocks = &log.origin.clocks;
        println!("{}: {} {} {clocks:?}", log.name, raw.score, clean.score);
    }
    for (log, (raw, clean)) in logs.iter().zip(raw.logs.iter().zip(&clean.logs)) {
        assert!((raw.score / clean.score - 1.0).abs() < 0.01, "{}", log.name);
    }
}

#[test]
fn raw_files_of_stated_clocks_score_as_the_clean_ones() {
    same_scores("campaigns/backlash", true);
}

#[test]
fn raw_files_of_clocks_that_are_not_known_score_as_the_clean_ones() {
    same_scores("campaigns/nothing-missing", false);
}

/// Every key that a `log.toml` may have, as its format is published: each is read, and acts.
#[test]
fn every_key_of_the_published_format_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let [plain, full] = ["plain", "full"].map(|name| folder.path().join(name));
    let campaign = fixture("campaigns/backlash");
    for log in [&plain, &full] {
        raw(&campaign.join("free"), log, PoseForm::Reflectors, true);
    }
    let file = full.join("log.toml");
    let text = fs::read_to_string(&file).expect("log.toml");
    let (top, rest) = text.split_once("[noise]").expect("noise");
    let (_, rest) = rest.split_once("[clock.tracker]").expect("a clock");
    let changed = |text: &str, from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    };
    let rest = changed(
        rest,
        "channel = \"tm1\", unit = \"kNm\", factor = 1.0",
        "channel = \"tm1\", unit = \"A\", factor = 58.2",
    );
    let rest = changed(
        &rest,
        "channel = \"qe2\", unit = \"deg\", factor = 1.0",
        "channel = \"qe2\", unit = \"deg\", factor = 1.0, offset = 0.5",
    );
    let text = format!(
        "{top}weld = {:?}\nprocess = {:?}\n[noise]\ntcp_position_m = 3e-5\n\
         tcp_rotation_rad = [5e-5, 5e-5, 6e-5]\nencoder_rad = 2e-6\nforce_n = 25.0\nmoment_nm = 8\n\
         motor_torque_nm = [40, 40, 40, 30, 30, 30]\nlink_encoder_rad = 1e-6\n\
         [tracker]\nbase_m = [0.1, 0.0, 0.0]\n[clock.tracker]{rest}",
        campaign.join("weld-1/weld.toml"),
        campaign.join("process.toml"),
    );
    fs::write(&file, text).expect("log.toml");
    let [plain, full] = [&plain, &full].map(|log| Log::read(log).expect("a log"));
    assert!(full.weld.is_some() && full.process.is_some());
    assert_eq!(full.period, Some(0.004));
    let stated = |deviation: f64| Some(NoiseLevel { deviation, stated: true });
    assert_eq!(full.noise.motor_torque, [40.0, 40.0, 40.0, 30.0, 30.0, 30.0].map(stated));
    assert_eq!(full.noise.link_encoder, [stated(1e-6); 6]);
    let rotation = full.noise.rotation.map(|level| level.expect("noise").deviation);
    assert!(rotation[2] > rotation[0], "{rotation:?}");
    let torque = |log: &Log| log.samples.motor_torque[0].as_ref().expect("a torque")[7];
    assert!((torque(&full) / torque(&plain) - 58.2e-3).abs() < 1e-9);
    let turned = full.samples.encoder[7][1] - plain.samples.encoder[7][1];
    assert!((turned - 0.5f64.to_radians()).abs() < 1e-9, "{turned}");
    let seen = |log: &Log| log.samples.position.as_ref().expect("positions")[7];
    assert!((seen(&plain) - seen(&full) - Vector3::new(0.1, 0.0, 0.0)).norm() < 1e-9);
}

/// What a model lacks bends a clock that is fitted to it; under a model that has it, the clock is
/// the right one, and no effect is found to mend it.
#[test]
fn a_clock_that_is_not_known_is_told_together_with_what_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = fixture("campaigns/backlash");
    let logs = ["static", "ring-25", "free"];
    let clean: Vec<PathBuf> = logs.iter().map(|name| campaign.join(name)).collect();
    raw(&clean[2], &folder.path().join("free"), PoseForm::Abc, false);
    let unknown = [clean[0].clone(), clean[1].clone(), folder.path().join("free")];
    let answer = |paths: &[PathBuf]| {
        let (_, mut logs) = read_logs(paths).expect("logs");
        let model = ModelFile::read(campaign.join("model.toml")).expect("a model");
        align_clocks(&mut logs, &baseline(&model)).expect("clocks");
        let experiments = experiments(&logs, &baseline(&model)).expect("experiments");
        let problem = FitProblem::new(&model, experiments);
        let found = diagnose(&problem, &logs, &|_, _| ()).expect("a diagnosis");
        println!("{:?}", found.fits.improved.residuals.iter().map(|p| p.late).collect::<Vec<_>>());
        found.diagnosis
    };
    let (clean, raw) = (answer(&clean), answer(&unknown));
    let [of_clean, of_raw] = [&clean, &raw].map(|found| found.candidates[0].effects.as_slice());
    let ([of_clean], [of_raw]) = (of_clean, of_raw) else { panic!("{of_clean:?} {of_raw:?}") };
    println!("{of_clean:?}\n{of_raw:?}");
    let place = |found: &FittedEffect| (found.effect.kind.id, found.effect.at);
    assert_eq!(place(of_clean), ("backlash", Location::Joint(4)));
    assert_eq!(place(of_raw), place(of_clean));
    assert_eq!((raw.verdict, raw.chosen), (clean.verdict, clean.chosen));
    let [low, high] = of_raw.interval[0];
    assert!((low..high).contains(&of_clean.effect.values[0]), "{of_raw:?} {of_clean:?}");
    let [a, b] = [&clean, &raw].map(|found| found.candidates[0].held_out_after);
    println!("{a} {b}");
    assert!((b / a - 1.0).abs() < 0.03, "{b} against {a}");
}

#[test]
fn a_reflector_alone_is_compared_as_the_point_that_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("free");
    raw(&fixture("campaigns/backlash/free"), &log, PoseForm::Reflectors, true);
    let text = fs::read_to_string(log.join("log.toml")).expect("log.toml");
    // The other two are not mapped.
    let kept = |line: &&str| !(line.starts_with("\"R2_") || line.starts_with("\"R3_"));
    let text: String = text.lines().filter(kept).map(|line| format!("{line}\n")).collect();
    fs::write(log.join("log.toml"), text).expect("log.toml");
    let campaign = fixture("campaigns/backlash");
    let (logs, found) = compared(&campaign, &[log]);
    let (_, clean) = compared(&campaign, &[campaign.join("free")]);
    assert_eq!(logs[0].kind, LogKind::FreeMotion);
    assert!(logs[0].samples.rotation.is_none());
    assert_eq!(logs[0].origin.target, Some(Vector3::from(PLACES[0])));
    let score = |c: &Comparison| {
        let channel = c.logs[0].channels.iter().find(|c| c.name == "tcp_position");
        channel.expect("a position").score
    };
    // The point lies elsewhere on the tool: it moves otherwise, by the same noise.
    assert!(
        (score(&found) / score(&clean) - 1.0).abs() < 0.3,
        "{} {}",
        score(&found),
        score(&clean)
    );
}

/// Files of two instruments, as `fixtures/raw/README.md` tells.
#[test]
fn the_mapping_of_two_instruments_is_proposed() {
    let robot = RobotFile::read(fixture("campaigns/backlash/robot.toml")).expect("a robot");
    let files = [fixture("raw/krc.csv"), fixture("raw/tracker.txt")];
    let found = propose(&files, Some(&robot), Stated::default()).expect("a proposal");
    for column in &found.columns {
        println!("{:?} {:?} {:?} {:?}", column.header, column.mapping, column.bases, column.doubts);
    }
    assert_eq!(found.kind, LogKind::FreeMotion);
    assert!(found.missing.is_empty(), "{:?}", found.missing);
    let mapping = |header: &str| {
        let column = found.columns.iter().find(|c| c.header == header).expect("a column");
        assert!(column.doubts.is_empty(), "{header}: {:?}", column.doubts);
        let mapping = column.mapping.as_ref().expect("a mapping");
        (mapping.channel(), mapping.unit, mapping.factor)
    };
    assert_eq!(mapping("Zeit [ms]"), ("t", "ms", 1.0));
    for axis in 1..=6 {
        let sign = if axis == 4 { -1.0 } else { 1.0 };
        let header = format!("AXIS_ACT.A{axis} [deg]");
        assert_eq!(mapping(&header), (format!("qe{axis}").as_str(), "deg", sign));
    }
    for (axis, header) in [(2, "MOT_TRQ_2 [Nm]"), (3, "MOT_TRQ_3 [Nm]")] {
        assert_eq!(mapping(header), (format!("tm{axis}").as_str(), "Nm", 1.0));
    }
    for (header, channel, unit) in
        [("X [mm]", "px", "mm"), ("B [deg]", "b", "deg"), ("Stamp [s]", "t", "s")]
    {
        assert_eq!(mapping(header), (channel, unit, 1.0));
    }
    let commanded = found.columns.iter().find(|c| c.header.contains("SOLL")).expect("a column");
    assert_eq!(commanded.mapping, Err(LeftOut::Commanded));
    let clock = found.files[1].fitted.expect("a clock");
    assert_eq!(found.files[1].clock.as_deref(), Some("tracker"));
    // To less than a row of either.
    assert!((clock.map.offset - 512.345_678).abs() < 2e-3, "{clock:?}");
}

/// A motion of six axes in degrees, a row every 4 ms: what the header names does not matter to it.
fn motion(header: &str, delimiter: char, row: impl Fn(usize) -> Vec<f64>) -> String {
    let mut text = header.to_owned();
    for k in 0..60 {
        let fields: Vec<String> = row(k).iter().map(|value| format!("{value:.5}")).collect();
        text += "\n";
        text += &fields.join(&delimiter.to_string());
    }
    text
}

fn axes(k: usize) -> Vec<f64> {
    (0..6).map(|i| 20.0 * (0.05 * k as f64 + f64::from(i)).sin()).collect()
}

/// What files of these texts are proposed to be: header, channel or why it is none, unit.
fn proposed(texts: &[(&str, &str)]) -> (Proposal, Vec<(String, String, &'static str)>) {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |(name, text): &(&str, &str)| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("a file");
        path
    };
    let files: Vec<PathBuf> = texts.iter().map(write).collect();
    let found = propose(&files, None, Stated::default()).expect("a proposal");
    let columns = found.columns.iter().map(|column| match &column.mapping {
        Ok(mapping) => (column.header.clone(), mapping.channel().to_owned(), mapping.unit),
        Err(why) => (column.header.clone(), format!("{why:?}"), ""),
    });
    let columns = columns.collect();
    (found, columns)
}

#[test]
fn a_row_of_units_below_the_header_is_the_unit_of_each_column() {
    let row = |k: usize| {
        let load = [0.0, 0.5 * k as f64, 18.0 + 0.01 * k as f64];
        [vec![0.004 * k as f64], axes(k).iter().map(|a| 0.1 * a).collect(), load.to_vec()].concat()
    };
    let header = "t;A1;A2;A3;A4;A5;A6;Fx;Fy;Fz\ns;deg;deg;deg;deg;deg;deg;N;N;kN";
    let (_, columns) = proposed(&[("a.csv", &motion(header, ';', row))]);
    let units: Vec<&str> = columns.iter().map(|(_, _, unit)| *unit).collect();
    assert_eq!(units, ["s", "deg", "deg", "deg", "deg", "deg", "deg", "N", "N", "kN"]);
}

#[test]
fn times_since_1970_are_in_the_unit_that_their_size_says() {
    for (factor, unit) in [(1.0, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")] {
        // A row a second, by which alone milliseconds would be microseconds.
        let row = |k: usize| [vec![factor * (1.7e9 + k as f64)], axes(k)].concat();
        let (_, columns) = proposed(&[("a.csv", &motion("time,A1,A2,A3,A4,A5,A6", ',', row))]);
        assert_eq!((columns[0].1.as_str(), columns[0].2), ("t", unit));
    }
}

#[test]
fn a_file_without_a_time_asks_for_its_period() {
    let (found, _) = proposed(&[("a.csv", &motion("A1,A2,A3,A4,A5,A6", ',', axes))]);
    assert!(found.period_open && !found.missing.contains(&"t"), "{:?}", found.missing);
}

/// An export with comments, names in the first columns and no header.
#[test]
fn the_names_in_a_comment_are_offered_for_the_columns_with_decimals() {
    let mut text =
        "// Points Relative to Frame 'A::WORLD'\n// AXES = CARTESIAN: X,  Y,  Z (mm)\n".to_owned();
    for k in 0..20 {
        text +=
            &format!("Group,  P1,  {k},  2255.5{k:02},  -2602.98,  -275.08,  02/12/25 16:52:45\n");
    }
    let (found, columns) = proposed(&[("a.txt", &text)]);
    let channels: Vec<(&str, &str)> =
        columns[3..6].iter().map(|(_, channel, unit)| (channel.as_str(), *unit)).collect();
    assert_eq!(channels, [("px", "mm"), ("py", "mm"), ("pz", "mm")]);
    assert!(found.columns[3..6].iter().all(|c| c.doubts.contains(&Doubt::Channel)));
    assert_eq!((found.files[0].header, found.files[0].first_row, found.files[0].rows), (0, 3, 20));
}

#[test]
fn files_of_other_programs_are_named_with_how_to_convert_them() {
    let folder = tempfile::tempdir().expect("a folder");
    for (bytes, what, help) in [
        (&b"#ROSBAG V2.0\nE\0\0\0"[..], "a bag of ROS 1", "rostopic echo"),
        (b"\x1f\x8b\x08\0", "gzip", "gunzip"),
        (b"\x89HDF\r\n\x1a\n", "HDF5", "h5dump"),
        (b"{\"a\": [1, 2]}", "JSON", "CSV"),
        (b"ab\0\x01\x02cd", "binary data", "text"),
    ] {
        let path = folder.path().join("file");
        fs::write(&path, bytes).expect("a file");
        let error = propose(&[path], None, Stated::default()).map(drop).expect_err(what);
        assert!(error.message().contains(what) && error.help_text().contains(help), "{error}");
        let told = error.to_string();
        assert!(told.chars().all(|c| !c.is_control() || c == '\n'), "{told:?}");
        assert!(told.contains("expected one of text, a KUKA trace, Parquet, MCAP"), "{told}");
    }
    // Formats that are read say what of them is wrong, or what the build is to have.
    for (bytes, what, help) in [
        (&b"SQLite format 3\0"[..], "a bag of ROS 2", "rosbag"),
        (b"PK\x03\x04\x14\0", "cannot be unpacked", "numpy.savez"),
        (b"MATLAB 5.0 MAT-file", "no array of numbers", "save("),
        (b"\x93NUMPY\x01\0", "ends within its header", "numpy.savez"),
    ] {
        let path = folder.path().join("file");
        fs::write(&path, bytes).expect("a file");
        let error = propose(&[path], None, Stated::default()).map(drop).expect_err(what);
        assert!(error.message().contains(what) && error.help_text().contains(help), "{error}");
    }
}

/// A pose as the controller has it: by the encoders, written to the digits of its file. `base` and
/// `tool`: its own, where they are not the robot file's.
fn by_the_encoders(clean: &Path, base: &Pose<f64>, tool: &Pose<f64>, digits: usize) -> String {
    let robot = RobotFile::read(clean.join("../robot.toml")).expect("a robot");
    let text = fs::read_to_string(clean.join("samples.csv")).expect("samples");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let place = |name: &str| header.iter().position(|h| *h == name).expect("a column");
    let (first, seen) = (place("qe1_rad"), place("px_m"));
    let mut all = vec![header.join(",")];
    for line in lines {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        let q = JointVector::from_fn(|i, _| fields[first + i].parse().expect("an angle"));
        let pose = *base * robot.robot.forward_kinematics(&q) * *tool;
        let vector = rotation_vector(&pose.rotation);
        for (k, value) in pose.position.iter().chain(&vector).enumerate() {
            fields[seen + k] = format!("{value:.digits$}");
        }
        all.push(fields.join(","));
    }
    all.join("\n")
}

#[test]
fn a_pose_that_the_controller_computed_is_no_measured_one() {
    let clean = fixture("campaigns/backlash/free");
    let toml = fs::read_to_string(clean.join("log.toml")).expect("log.toml");
    let (none, away) = (
        Pose::identity(),
        Pose {
            rotation: rotation_from_vector(&Vector3::new(0.3, -0.2, 1.4)),
            position: Vector3::new(1.2, -0.4, 0.3),
        },
    );
    let read = |text: &str| Log::parse(&toml, text.as_bytes(), &clean);
    for (base, tool) in [(none, none), (away, away)] {
        let error = read(&by_the_encoders(&clean, &base, &tool, 7)).map(drop).expect_err("a pose");
        let told = error.to_string();
        assert!(told.contains("`px_m`, `py_m`, `pz_m` agree with the encoders"), "{told}");
        assert!(told.contains("gravity bends the arm"), "{told}");
    }
    // A rotation of the controller beside the position of a tracker.
    let computed = by_the_encoders(&clean, &away, &none, 7);
    let measured = fs::read_to_string(clean.join("samples.csv")).expect("samples");
    let mixed: Vec<String> = computed
        .lines()
        .zip(measured.lines())
        .map(|(a, b)| {
            let (mut a, b): (Vec<&str>, Vec<&str>) =
                (a.split(',').collect(), b.split(',').collect());
            let header: Vec<&str> = measured.lines().next().expect("a header").split(',').collect();
            let seen = header.iter().position(|h| *h == "px_m").expect("a column");
            a[seen..seen + 3].copy_from_slice(&b[seen..seen + 3]);
            a.join(",")
        })
        .collect();
    let told = read(&mixed.join("\n")).map(drop).expect_err("a rotation").to_string();
    assert!(told.contains("`rx_rad`, `ry_rad`, `rz_rad` agree with the encoders"), "{told}");
    // Written to centimetres, by which no arm bends, the numbers tell nothing.
    assert!(read(&by_the_encoders(&clean, &none, &none, 2)).is_ok());
}

/// Beside a tracker's file, and under a name that says nothing.
#[test]
fn the_controllers_pose_gives_way_to_the_trackers() {
    let robot = RobotFile::read(fixture("campaigns/backlash/robot.toml")).expect("a robot");
    let text = fs::read_to_string(fixture("raw/krc.csv")).expect("a file");
    let mut lines = text.lines();
    let mut all = vec![format!("{};X [mm];Y [mm];Z [mm]", lines.next().expect("a header"))];
    for line in lines {
        let angles: Vec<f64> = line
            .split(';')
            .skip(1)
            .take(6)
            .map(|field| field.replace(',', ".").parse::<f64>().expect("a number").to_radians())
            .collect();
        let q = JointVector::from_fn(|i, _| if i == 3 { -angles[i] } else { angles[i] });
        let at = robot.robot.forward_kinematics(&q).position * 1e3;
        let at: Vec<String> = at.iter().map(|v| format!("{v:.4}").replace('.', ",")).collect();
        all.push(format!("{line};{}", at.join(";")));
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("krc.csv");
    fs::write(&path, all.join("\n")).expect("a file");
    let found = propose(&[path, fixture("raw/tracker.txt")], Some(&robot), Stated::default())
        .expect("a proposal");
    let of = |file: usize| {
        let position = |c: &&ProposedColumn| c.file == file && c.header.ends_with("[mm]");
        found.columns.iter().filter(position).collect::<Vec<_>>()
    };
    assert!(of(0).iter().all(|c| matches!(c.mapping, Err(LeftOut::Rigid(_)))), "{:?}", of(0));
    assert!(of(1).iter().all(|c| c.mapping.is_ok()), "{:?}", of(1));
}
