//! Logs and campaigns: good ones read as written, every class of mistake is explained at its place,
//! and nothing whatever in the files makes a reader panic.

use nalgebra::Vector3;
use proptest::prelude::*;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use trueweld_logs::campaign::{Campaign, read_logs};
use trueweld_logs::log::{Log, LogKind, LogNotice, NoiseLevel, NoiseLevels};
use trueweld_plant::input::{InputError, InputFile, RobotFile};

const HEADER: &str =
    "t_s,qe1_rad,qe2_rad,qe3_rad,qe4_rad,qe5_rad,qe6_rad,ql1_rad,ql3_rad,tm2_nm,px_m,py_m,pz_m";
const FREE: &str =
    "t_s,qe1_rad,qe2_rad,qe3_rad,qe4_rad,qe5_rad,qe6_rad,ql1_rad,ql3_rad,tm2_nm,px_m,py_m,pz_m
0.000,0.1,-0.9,1.6,-0.2,0.6,0.4,0.1001,1.6001,-2740.4,2.1,-0.1,0.6
0.004,0.101,-0.9,1.6,-0.2,0.6,0.4,,1.6002,-2682.8,2.11,-0.1,0.6
0.008,1.02e-1,-0.9,1.6,-0.2,0.6,0.4,0.1021,1.6003,,2.12,,0.6
";
const STATIC: &str =
    "t_s,qe1_rad,qe2_rad,qe3_rad,qe4_rad,qe5_rad,qe6_rad,fx_n,fy_n,fz_n,rx_rad,ry_rad,rz_rad,\
payload_kg,cx_m,cy_m,cz_m
0,-0.4,-0.9,1.2,-0.1,1.0,-0.9,5,-38,-36,0.9,2.8,0.4,0,,,
14.5,-0.4,-0.9,1.2,-0.1,1.0,-0.9,2,0.3,-40,0.9,2.8,0.4,150,0.17,-0.03,-0.14
";
const WELD: &str = "t_s,qe1_rad,qe2_rad,qe3_rad,qe4_rad,qe5_rad,qe6_rad,fx_n,fy_n,fz_n,mx_nm,my_nm,mz_nm,spindle_rad_s
0.000,0.4,-0.9,1.8,0,0.6,0.4,-10,-22,-1207,-0.3,3,-14,62.8
0.012,0.4,-0.9,1.8,0,0.6,0.4,-22,30,-1225,0.7,7,-2,62.9
";

fn fixture(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../fixtures")
        .join(path)
        .canonicalize()
        .unwrap()
}

fn log_toml(kind: &str, rest: &str) -> String {
    format!(
        "schema = \"log/1\"\nkind = \"{kind}\"\nrobot = {:?}\n{rest}",
        fixture("robots/kr500-mt.toml")
    )
}

fn weld_toml() -> String {
    let (weld, process) =
        (fixture("welds/vertical.toml"), fixture("processes/lap-weld-2024-t3.toml"));
    log_toml("weld", &format!("weld = {weld:?}\nprocess = {process:?}\nperiod_s = 0.012\n"))
}

fn parse(toml: &str, csv: impl AsRef<[u8]>) -> Result<Log, InputError> {
    Log::parse(toml, csv.as_ref(), Path::new("dir/run"))
}

fn free(csv: impl AsRef<[u8]>) -> Result<Log, InputError> {
    parse(&log_toml("free-motion", "period_s = 0.004\n"), csv)
}

/// The whole message: place, what is wrong, what to do.
fn told(error: &InputError) -> String {
    format!("{error}\n{}", error.help_text())
}

/// Reading fails in `samples.csv` at this place (`line:column`, or nothing), and says all of these.
#[track_caller]
fn refused(read: Result<Log, InputError>, place: &str, needles: &[&str]) {
    let error = read.expect_err(place);
    let file = if place.is_empty() {
        "dir/run/samples.csv".to_owned()
    } else {
        format!("dir/run/samples.csv:{place}")
    };
    assert_eq!(error.place(), file, "{}", told(&error));
    let told = told(&error);
    for needle in needles {
        assert!(told.contains(needle), "`{needle}` is not in:\n{told}");
    }
    assert!(told.contains("expected"), "{told}");
}

#[track_caller]
fn refused_toml(toml: &str, csv: &str, place: &str, needles: &[&str]) {
    let error = parse(toml, csv).expect_err(place);
    assert_eq!(error.place(), format!("dir/run/log.toml:{place}"), "{}", told(&error));
    for needle in needles {
        assert!(told(&error).contains(needle), "`{needle}` is not in:\n{}", told(&error));
    }
}

/// The free-motion log with one replacement.
#[track_caller]
fn changed(from: &str, to: &str) -> String {
    let text = FREE.replacen(from, to, 1);
    assert_ne!(text, FREE, "`{from}` is not there");
    text
}

#[test]
fn a_free_motion_log_reads_as_written() {
    let noise = "period_s = 0.004\n[noise]\ntcp_position_m = 3e-5\nencoder_rad = [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6]\n\
                 link_encoder_rad = [5e-6, 7e-6]\nmotor_torque_nm = 40\n";
    let log = parse(&log_toml("free-motion", noise), FREE).unwrap();
    assert_eq!(
        (log.kind, log.name.as_str(), log.period),
        (LogKind::FreeMotion, "run", Some(0.004))
    );
    assert_eq!(log.robot.name, "KR 500 MT + FSW end effector");
    assert_eq!(log.path, Path::new("dir/run"));
    assert!(log.weld.is_none() && log.process.is_none() && log.notices.is_empty());
    let s = &log.samples;
    assert_eq!((s.len(), s.time.as_slice()), (3, [0.0, 0.004, 0.008].as_slice()));
    assert_eq!(s.encoder[2].as_slice(), [0.102, -0.9, 1.6, -0.2, 0.6, 0.4]);
    assert_eq!(
        s.link_encoder.each_ref().map(Option::is_some),
        [true, false, true, false, false, false]
    );
    let first = s.link_encoder[0].as_ref().unwrap();
    assert!(
        first[0] == 0.1001 && first[1].is_nan() && first[2] == 0.1021,
        "a missing value is NaN"
    );
    assert!(s.motor_torque[1].as_ref().unwrap()[2].is_nan() && s.motor_torque[0].is_none());
    let position = s.position.as_ref().unwrap();
    assert_eq!(position[1], Vector3::new(2.11, -0.1, 0.6));
    assert!(
        position[2].x == 2.12 && position[2].y.is_nan() && position[2].z == 0.6,
        "each component for itself"
    );
    assert!(s.rotation.is_none() && s.force.is_none() && s.moment.is_none());
    assert!(s.spindle.is_none() && s.payload.is_none());
    let stated = |deviation: f64| Some(NoiseLevel { deviation, stated: true });
    assert_eq!(log.noise.position, [stated(3e-5); 3]);
    assert_eq!(log.noise.encoder, [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6].map(stated));
    assert_eq!(log.noise.motor_torque, [stated(40.0); 6]);
    // One a column that the log has.
    assert_eq!(log.noise.link_encoder[..3], [stated(5e-6), None, stated(7e-6)]);
    assert_eq!((log.noise.force, log.noise.rotation), ([None; 3], [None; 3]));
}

#[test]
fn static_and_weld_logs_read_as_written() {
    let log = parse(&log_toml("static-load", ""), STATIC).unwrap();
    let payload = log.samples.payload.as_ref().unwrap();
    assert_eq!(
        (payload[0].mass, payload[0].centre),
        (0.0, Vector3::zeros()),
        "no centre where nothing hangs"
    );
    assert_eq!((payload[1].mass, payload[1].centre), (150.0, Vector3::new(0.17, -0.03, -0.14)));
    assert_eq!(log.samples.force.as_ref().unwrap()[1], Vector3::new(2.0, 0.3, -40.0));
    assert_eq!(log.samples.rotation.as_ref().unwrap()[0], Vector3::new(0.9, 2.8, 0.4));
    assert_eq!(log.period, None);

    let log = parse(&weld_toml(), WELD).unwrap();
    assert_eq!(log.weld.unwrap().force, 18_000.0);
    assert_eq!(log.process.unwrap().model.memory_length(), 0.008);
    assert_eq!(log.samples.spindle.unwrap(), [62.8, 62.9]);
    assert_eq!(log.samples.moment.unwrap()[1], Vector3::new(0.7, 7.0, -2.0));
}

#[test]
fn what_spreadsheets_and_systems_add_is_accepted() {
    let plain = free(FREE).unwrap().samples;
    // Missing values are NaN, which equals nothing: compared as text.
    let same =
        |csv: String| assert_eq!(format!("{:?}", free(csv).unwrap().samples), format!("{plain:?}"));
    same(format!("\u{feff}{FREE}"));
    same(FREE.replace('\n', "\r\n"));
    same(format!("{FREE}\n  \n\r\n"));
    same(FREE.trim_end().to_owned());
    same(FREE.replace(',', " , "));
    same(FREE.replace(
        HEADER,
        &HEADER.split(',').map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(","),
    ));
}

#[test]
fn unknown_and_empty_columns_are_left_out_with_a_notice() {
    let log = free(FREE.replace('\n', ",7\n").replacen(",7\n", ",gripper\n", 1)).unwrap();
    assert_eq!(log.notices, [LogNotice::UnknownColumns(vec!["gripper".to_owned()])]);
    let text = FREE.replace('\n', ",broken\n").replacen(",broken\n", ",comment\n", 1);
    assert_eq!(free(text).unwrap().samples.len(), 3, "what is not read need not be a number");
    let log = free(FREE.replace('\n', ",\n").replacen(",\n", ",tm5_nm\n", 1)).unwrap();
    assert_eq!(log.notices, [LogNotice::EmptyColumns(vec!["tm5_nm"])]);
    assert!(log.samples.motor_torque[4].is_none());
    let log = parse(&weld_toml(), WELD.replace('\n', ",0\n").replacen(",0\n", ",px_mean_m\n", 1))
        .unwrap();
    assert_eq!(log.notices, [LogNotice::UnknownColumns(vec!["px_mean_m".to_owned()])]);
}

#[test]
fn a_missing_column_is_named() {
    refused(
        free(changed("qe6_rad", "load")),
        "1:1",
        &["missing column `qe6_rad`", "free-motion", "names of the columns"],
    );
    refused(
        free(changed("qe6_rad", "q6_rad")),
        "1:45",
        &["missing column `qe6_rad`", "read `q6_rad`", "call it `qe6_rad`"],
    );
    refused(
        free(&FREE[FREE.find('\n').unwrap() + 1..]),
        "1:1",
        &["missing column `t_s`", "begins with a number"],
    );
    refused(
        parse(&weld_toml(), WELD.replace("spindle_rad_s", "turns")),
        "1:1",
        &["`spindle_rad_s`", "every weld log"],
    );
    refused(
        free(changed(",pz_m", ",other")),
        "1:76",
        &["`px_m` without `pz_m`", "all of `px_m`, `py_m`, `pz_m`, or none"],
    );
    // Zeros and empty fields are no force, and those in the plane go with the depth force.
    let depth = ["`fx_n`, `fy_n` alone was measured", "expected `fz_n`"];
    refused(parse(&weld_toml(), WELD.replace("fz_n", "other")), "1:53", &depth);
    for of_no_force in ["0.0", ""] {
        let place = format!(",{of_no_force},{of_no_force},-12");
        let text = WELD.replace(",-10,-22,-12", &place).replace(",-22,30,-12", &place);
        let alone = parse(&weld_toml(), text).unwrap();
        assert_eq!(alone.samples.unmeasured_force, [true, true, false]);
        assert!(alone.notices.contains(&LogNotice::ForceInPart(vec!["fz_n"])));
    }
    let alone = parse(&weld_toml(), WELD.replace("fx_n,fy_n", "other,more")).unwrap();
    assert_eq!(alone.samples.unmeasured_force, [true, true, false]);
    // A sensor that is turned reads all of the force in each component.
    let turned = format!("{}\n[wrench]\npoint_m = [0.0, 0.0, -0.3]\n", weld_toml());
    let message = told(&parse(&turned, WELD.replace("fx_n,fy_n", "other,more")).unwrap_err());
    assert!(message.contains("log.toml:8:1"), "{message}");
    assert!(message.contains("a part was not measured"), "{message}");
    let text = STATIC.replace("cy_m", "other");
    refused(parse(&log_toml("static-load", ""), text), "1:89", &["`payload_kg` without `cy_m`"]);
    refused(free(changed(",tm2_nm", ",qe3_rad")), "1:69", &["`qe3_rad`", "a second time"]);
    let bare = "t_s,qe1_rad,qe2_rad,qe3_rad,qe4_rad,qe5_rad,qe6_rad\n0,0,0,0,0,0,0\n";
    refused(
        parse(&log_toml("ring-down", ""), bare),
        "1:1",
        &["ring-down", "`px_m`", "nothing to compare"],
    );
}

#[test]
fn another_unit_or_spelling_is_not_lost() {
    refused(
        free(changed("qe1_rad", "qe1_deg")),
        "1:5",
        &["`qe1_deg` is in deg", "expected `qe1_rad`, in rad", "π/180"],
    );
    refused(free(changed("px_m", "px_mm")), "1:76", &["`px_mm` is in mm", "`px_m`, in m", "0.001"]);
    refused(free(changed("t_s", "t_ms")), "1:1", &["`t_ms` is in ms", "`t_s`"]);
    refused(free(changed("tm2_nm", "tm2_knm")), "1:69", &["in knm", "`tm2_nm`, in N·m", "1000"]);
    refused(free(changed("tm2_nm", "tm2")), "1:69", &["names no unit", "`tm2_nm`"]);
    refused(free(changed("tm2_nm", "tm2_n")), "1:69", &["names the unit n", "`tm2_nm`"]);
    refused(
        free(changed("tm2_nm", "TM2_Nm")),
        "1:69",
        &["`TM2_Nm`", "expected `tm2_nm`", "small letters"],
    );
    let rpm = WELD.replace("spindle_rad_s", "spindle_rpm");
    refused(parse(&weld_toml(), rpm), "1:86", &["is in rpm", "`spindle_rad_s`, in rad/s", "2π/60"]);
    // Beside the column in the right unit, one in another is only one more.
    let both = FREE.replace('\n', ",5\n").replacen(",5\n", ",qe1_deg\n", 1);
    assert_eq!(
        free(both).unwrap().notices,
        [LogNotice::UnknownColumns(vec!["qe1_deg".to_owned()])]
    );
}

#[test]
fn a_value_that_is_no_number_is_shown() {
    refused(free(changed("-2682.8", "lost")), "3:43", &["`tm2_nm` is `lost`", "a number in N·m"]);
    for text in ["inf", "-Infinity", "1e999"] {
        refused(
            free(changed("-2682.8", text)),
            "3:43",
            &[text, "a finite number in N·m", "leave the field empty"],
        );
    }
    refused(
        free(changed("-2682.8", "\"-2682,8\"")),
        "3:43",
        &["`-2682,8`", "not the comma", "dots"],
    );
    refused(
        free(changed("-2682.8", "-2682.8 Nm")),
        "3:43",
        &["`-2682.8 Nm`", "the unit stands in the column's name"],
    );
    refused(free(changed("-2682.8", "\"open")), "3:62", &["this row has 10 fields; expected 13"]);
    refused(free(changed("0.008,", ",")), "4:1", &["`t_s` is missing"]);
    let latin1: Vec<u8> = FREE
        .replacen("-2682.8", "@", 1)
        .into_bytes()
        .iter()
        .map(|b| if *b == b'@' { 0xb5 } else { *b })
        .collect();
    refused(free(latin1), "3:43", &["`tm2_nm` is", "a number in N·m"]);
    // A carriage return and multi-byte text before the place count as they look.
    let text = FREE.replace('\n', "\r\n").replacen("0.004,0.101", "0.004,µ", 1);
    refused(free(text), "3:7", &["`qe1_rad` is `µ`"]);
    let text = FREE.replace('\n', "\n\n").replacen("-2682.8", "lost", 1);
    refused(free(text), "5:43", &["`lost`"]);
}

#[test]
fn what_programs_write_for_no_value_is_a_missing_one() {
    for text in ["", "nan", "NaN", "NULL", "none", "n/a", "-"] {
        let log = free(changed("-2682.8", text)).unwrap();
        let torque = log.samples.motor_torque[1].as_ref().unwrap();
        assert!(torque[1].is_nan() && torque[0].is_finite(), "{text}");
    }
    refused(free(changed("0.008,", "nan,")), "4:1", &["`t_s` is missing"]);
}

#[test]
fn a_number_that_stands_for_none_is_a_missing_value_and_told() {
    let (text, torque) = (long(40, |_| false, |_| false), 9);
    let with = |place: usize, number: &str| {
        let line = text.lines().nth(9).unwrap();
        let mut fields: Vec<&str> = line.split(',').collect();
        fields[place] = number;
        text.replace(line, &fields.join(","))
    };
    let log = free(with(torque, "-9999")).unwrap();
    let column = "tm2_nm";
    assert!(log.notices.contains(&LogNotice::Sentinel { column, value: -9999.0, rows: 1 }));
    assert!(log.samples.motor_torque[1].as_ref().unwrap()[8].is_nan());
    // Of an encoder, whose limits it is beyond.
    let log = free(with(1, "-999")).unwrap();
    assert!(log.notices.iter().any(|n| matches!(n, LogNotice::Sentinel { rows: 1, .. })));
}

#[test]
fn what_other_channels_add_to_a_column_is_added() {
    let toml = |line: &str| log_toml("free-motion", &format!("[columns]\n{line}\n"));
    let sum =
        "\"qe3_rad\" = { channel = \"qe3\", unit = \"rad\", plus = { qe2 = 1.0, qe1 = -0.5 } }";
    let (plain, summed) = (free(FREE).unwrap(), parse(&toml(sum), FREE).unwrap());
    for (a, b) in plain.samples.encoder.iter().zip(&summed.samples.encoder) {
        assert!((b[2] - (a[2] + a[1] - 0.5 * a[0])).abs() < 1e-12);
    }
    for (line, expected) in [
        (sum.replace("qe1", "tm1"), "another channel in rad"),
        (sum.replace("qe1", "ql2"), "a channel of the same file"),
    ] {
        let error = parse(&toml(&line), FREE).map(drop).expect_err(&line);
        assert!(told(&error).contains(expected), "{}", told(&error));
    }
}

#[test]
fn rows_that_came_in_bursts_are_spread_where_their_rhythm_is_even() {
    let text = long(41, |_| false, |_| false);
    let stamped = |every: usize| {
        let (header, rows) = text.split_once('\n').unwrap();
        let of = |(k, line): (usize, &str)| {
            let (_, rest) = line.split_once(',').unwrap();
            format!("{:.3},{rest}\n", 0.004 * (every * (k / every)) as f64)
        };
        let rows: String = rows.lines().enumerate().map(of).collect();
        format!("{header}\n{rows}")
    };
    let uneven = |text: String| parse(&log_toml("free-motion", ""), text);
    let log = uneven(stamped(5)).unwrap();
    assert!(log.notices.contains(&LogNotice::Bursts { rows: 5 }), "{:?}", log.notices);
    let steps = log.samples.time.windows(2).map(|w| w[1] - w[0]);
    assert!(steps.into_iter().all(|step| (step - 0.004).abs() < 1e-9));
    // A row is missing from a burst: where, nobody knows.
    let mut lines: Vec<String> = stamped(5).lines().map(str::to_owned).collect();
    lines.remove(12);
    let error = uneven(lines.join("\n")).map(drop).expect_err("uneven bursts");
    assert!(told(&error).contains("a second time"), "{}", told(&error));
}

#[test]
fn other_separators_and_decimal_commas_are_recognised() {
    refused(
        free(FREE.replace(',', ";")),
        "1:4",
        &["this file uses `;` as separator", "expected `,`"],
    );
    refused(
        free(FREE.replace(',', ";").replace('.', ",")),
        "1:4",
        &["uses `;` as separator", "dots in the numbers"],
    );
    refused(free(FREE.replace(',', "\t")), "1:4", &["uses a tab as separator"]);
    refused(free(FREE.replace(',', " ")), "1:4", &["uses a blank as separator"]);
    let quoted = FREE.replace("t_s,", "\"t_s\",").replace(',', ";");
    refused(free(quoted), "1:6", &["uses `;` as separator"]);
    let (header, rows) = FREE.split_once('\n').unwrap();
    let comma = format!("{header}\n{}", rows.replace('.', ","));
    refused(free(comma), "2:31", &["has 26 fields; expected 13", "commas are decimal marks"]);
    let rows = rows.replace(',', ";");
    refused(
        free(format!("{header}\n{rows}")),
        "2:1",
        &["has 1 field; expected 13", "uses `;` as separator"],
    );
    refused(free(FREE.replace('\n', "\r")), "1:90", &["carriage return", "LF"]);
    let utf16: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(FREE.bytes().flat_map(|b| [b, 0])).collect();
    refused(free(utf16), "1:1", &["UTF-16", "UTF-8"]);
}

#[test]
fn uneven_rows_and_empty_files_are_named() {
    refused(
        free(changed(",1.6002,", ",")),
        "3:57",
        &["this row has 12 fields; expected 13", "empty field"],
    );
    refused(free(changed(",1.6002,", ",1,2,")), "3:58", &["this row has 14 fields; expected 13"]);
    refused(
        free(&FREE[..FREE.len() - 9]),
        "4:53",
        &["this row has 11 fields", "cut off", "Delete the row"],
    );
    refused(free(""), "", &["the file is empty", "a header"]);
    refused(free("\n\n\u{20}\n"), "", &["the file is empty"]);
    refused(free(HEADER), "", &["no row after the header"]);
    refused(free(format!("{HEADER}\n\n")), "", &["no row after the header"]);
    refused(free(&FREE[..FREE.find("0.004").unwrap()]), "", &["there is 1 row", "at least 2"]);
    refused(free(vec![b'x'; 3 << 20]), "1:1", &["longer than 1048576 bytes"]);
}

/// All values of a log; one that is missing equals another.
fn values(log: &Log) -> String {
    format!("{:?}", log.samples)
}

#[test]
fn a_row_that_is_written_twice_counts_once() {
    let second = FREE.lines().nth(2).unwrap();
    let twice = FREE.replace(second, &format!("{second}\n{second}"));
    let log = free(&twice).unwrap();
    assert_eq!(values(&log), values(&free(FREE).unwrap()));
    assert_eq!(log.notices, [LogNotice::RowsRepeated(1)]);
}

#[test]
fn rows_that_overtook_each_other_are_put_in_order_of_time() {
    let long = |order: &[usize]| {
        let row = FREE.lines().nth(1).unwrap();
        let row = |k: &usize| {
            // A torque that was not measured stands for none, wherever its row went.
            let torque = if *k == 4 { "-9999" } else { "12.5" };
            let fields: Vec<&str> = row.split(',').collect();
            let fields = fields.iter().enumerate().map(|(i, field)| match i {
                0 => format!("{:.3}", 0.004 * *k as f64),
                1 => format!("{:.5}", 0.1 + 1e-4 * *k as f64),
                9 => torque.to_owned(),
                _ => (*field).to_owned(),
            });
            fields.collect::<Vec<_>>().join(",") + "\n"
        };
        format!("{}\n{}", FREE.lines().next().unwrap(), order.iter().map(row).collect::<String>())
    };
    let expected = free(long(&[0, 1, 2, 3, 4, 5, 6, 7])).unwrap();
    let swapped = free(long(&[0, 2, 1, 3, 5, 4, 7, 6])).unwrap();
    assert_eq!(values(&swapped), values(&expected));
    assert!(swapped.notices.contains(&LogNotice::RowsSwapped(3)), "{:?}", swapped.notices);
    // A wrong time lies between others as well; two recordings after each other are none.
    let wrong = long(&[0, 1, 2, 3, 4, 5]).replace("\n0.016,", "\n0.010,");
    refused(free(wrong), "6:1", &["runs backwards", "`0.010` after 0.012"]);
    refused(free(long(&[0, 1, 2, 3, 0, 1, 2, 3])), "6:1", &["runs backwards"]);
    refused(free(long(&[2, 1, 3, 4])), "3:1", &["runs backwards"]);
}

#[test]
fn times_of_day_and_a_stated_period_are_times() {
    let expected = free(FREE).unwrap();
    let of = |from: &str, to: &str| FREE.replace(from, to);
    let midnight =
        FREE.replace("\n0.000,", "\n23:59:59.996,").replace("\n0.004,", "\n00:00:00.000,");
    let midnight = midnight.replace("\n0.008,", "\n00:00:00.004,");
    for text in [
        of("\n0.00", "\n10:57:00.00"),
        of("\n0.00", "\n2024-05-17T10:57:00.00"),
        of("\n0.00", "\n17.05.2024 10:57:00.00"),
        midnight,
    ] {
        let log = free(text).unwrap();
        let passed = |log: &Log| log.samples.time.iter().map(|t| t - log.samples.time[0]).collect();
        let (now, then): (Vec<f64>, Vec<f64>) = (passed(&log), passed(&expected));
        // What a double holds of seconds since 1970.
        assert!(now.iter().zip(&then).all(|(a, b)| (a - b).abs() < 1e-6), "{now:?}");
    }
    let (header, rows) = FREE.split_once('\n').unwrap();
    let untimed = |line: &str| format!("{}\n", line.split_once(',').unwrap().1);
    let text: String = std::iter::once(header).chain(rows.lines()).map(untimed).collect();
    // Of files as instruments write them; a plain log has a time.
    let mapped = "[columns]\n\"tm2_nm\" = { channel = \"tm2\", unit = \"Nm\" }\n";
    let toml = |period: &str| log_toml("free-motion", &format!("{period}{mapped}"));
    let stated = parse(&toml("period_s = 0.004\n"), &text).unwrap();
    assert_eq!(values(&stated), values(&expected));
    assert!(parse(&toml(""), &text).is_err());
    refused(free(&text), "1:1", &["missing column `t_s`"]);
}

#[test]
fn time_rises_in_steps_of_the_period() {
    refused(free(changed("0.008", "-0.002")), "4:1", &["runs backwards", "`-0.002` after 0.004"]);
    refused(free(changed("0.008", "0.004")), "4:1", &["`0.004` a second time"]);
    let even = |csv: &str, period: f64| {
        parse(&log_toml("free-motion", &format!("period_s = {period}\n")), csv)
    };
    refused(even(FREE, 0.006), "3:1", &["0.004000 s after", "a step of 0.006 s", "`period_s`"]);
    refused(even(FREE, 0.005), "4:1", &["0.004000 s a row since the first", "a step of 0.005 s"]);
    let milliseconds = FREE.replace("0.004,", "4,").replace("0.008,", "8,");
    refused(even(&milliseconds, 0.004), "3:1", &["looks like milliseconds"]);
    assert!(
        parse(&log_toml("free-motion", ""), changed("0.008", "0.5")).is_ok(),
        "no period, no even steps"
    );
    // 120 Hz, written to the millisecond: steps of 8 and 9 ms are even to the precision they are
    // written in.
    let rounded = FREE.replace("0.004,", "0.008,").replacen("\n0.008,1.02", "\n0.017,1.02", 1);
    assert!(even(&rounded, 1.0 / 120.0).is_ok());
    // A clock that counts from 1970.
    let epoch = FREE.replace("\n0.00", "\n1700000000.00");
    assert!(even(&epoch, 0.004).is_ok());
    assert!(even(&changed("0.008", "0.0080399"), 0.004).is_ok(), "1 % of jitter");
    refused(even(&changed("0.008", "0.0082"), 0.004), "4:1", &["0.004200 s after"]);
}

/// A free motion of so many rows, 4 ms apart, without the rows that `lost` names and without the
/// first encoder in those that `blank` names.
fn long(rows: usize, lost: impl Fn(usize) -> bool, blank: impl Fn(usize) -> bool) -> String {
    let mut text = format!("{HEADER}\n");
    for k in (0..rows).filter(|k| !lost(*k)) {
        let t = 0.004 * k as f64;
        let angle = if blank(k) { String::new() } else { format!("{:.9}", 0.1 * (3.0 * t).sin()) };
        let measured = format!("{:.4},1.6,{:.1},{:.4},-0.1,0.6", 0.1 + t, t - 2740.4, 2.1 + t);
        writeln!(text, "{t:.3},{angle},-0.9,1.6,-0.2,0.6,0.4,{measured}").unwrap();
    }
    text
}

#[test]
fn short_gaps_of_the_encoders_are_filled_and_long_ones_cut_the_log() {
    let filled = |log: &Log| {
        assert_eq!(log.samples.len(), 200);
        for (t, q) in log.samples.time.iter().zip(&log.samples.encoder) {
            assert!((q[0] - 0.1 * (3.0 * t).sin()).abs() < 1e-6, "{t}: {q}");
        }
    };
    let log = free(long(200, |_| false, |k| (50..54).contains(&k))).unwrap();
    filled(&log);
    assert_eq!(log.notices, [LogNotice::RowsInterpolated(4)]);
    let log = free(long(200, |k| (50..54).contains(&k), |_| false)).unwrap();
    filled(&log);
    assert!(log.samples.position.unwrap()[52].x.is_nan(), "what was measured is not made up");

    let folder = tempfile::tempdir().unwrap();
    for lost in [true, false] {
        let gap = |k: usize| (50..90).contains(&k);
        let text = long(200, |k| lost && gap(k), |k| !lost && gap(k));
        write_log(folder.path(), &log_toml("free-motion", "period_s = 0.004\n"), &text);
        let pieces = Log::read_pieces(folder.path()).unwrap();
        assert_eq!(pieces.iter().map(|p| p.samples.len()).collect::<Vec<_>>(), [50, 110]);
        assert!(pieces[1].name.ends_with(", 2 of 2"), "{}", pieces[1].name);
        let LogNotice::Cut { column: None, gaps, pieces: 2 } = &pieces[0].notices[0] else {
            panic!("{:?}", pieces[0].notices);
        };
        let [[from, to]] = gaps[..] else { panic!("{gaps:?}") };
        assert!((from - 0.196).abs() < 1e-9 && (to - 0.36).abs() < 1e-9, "{gaps:?}");
        assert_eq!(Log::read(folder.path()).unwrap().samples.len(), 110, "the longest");
    }
    refused(free(long(40, |_| false, |_| true)), "", &["no row has a value of every encoder"]);
}

#[test]
fn rows_are_placed_by_their_times_whether_a_period_is_stated_or_not() {
    let unstated = |csv: String| parse(&log_toml("free-motion", ""), csv).unwrap();
    for lost in [50..50, 50..51, 50..54] {
        let text = long(200, |k| lost.contains(&k), |_| false);
        let (log, stated) = (unstated(text.clone()), free(text).unwrap());
        // As text, in which one missing value equals another.
        assert_eq!(format!("{:?}", log.samples), format!("{:?}", stated.samples));
        assert_eq!(log.notices, stated.notices);
        assert!((log.period.unwrap() - 0.004).abs() < 1e-9, "{:?}", log.period);
    }
    // Steps of 4, 8, 12 and 4 ms.
    let log = unstated(long(700, |k| ![0, 1, 3, 6].contains(&(k % 7)), |_| false));
    assert!(matches!(log.notices[0], LogNotice::Resampled(_)), "{:?}", log.notices);
    let period = log.period.unwrap();
    for (k, q) in log.samples.encoder.iter().enumerate() {
        let time = period * k as f64;
        assert!((log.samples.time[k] - time).abs() < 1e-9, "{k}");
        assert!((q[0] - 0.1 * (3.0 * time).sin()).abs() < 1e-6, "{k}: {}", q[0]);
    }
}

#[test]
fn an_instrument_that_pauses_is_told() {
    let mut rows: Vec<String> = long(200, |_| false, |_| false).lines().map(String::from).collect();
    for row in &mut rows[51..=90] {
        let mut fields: Vec<&str> = row.split(',').collect();
        fields[9] = "";
        *row = fields.join(",");
    }
    let log = free(rows.join("\n")).unwrap();
    let [LogNotice::Dropout { columns, stretches }] = &log.notices[..] else {
        panic!("{:?}", log.notices);
    };
    assert_eq!(columns, &["tm2_nm"]);
    let [[from, to]] = stretches[..] else { panic!("{stretches:?}") };
    assert!((from - 0.2).abs() < 1e-9 && (to - 0.356).abs() < 1e-9, "{stretches:?}");
}

#[test]
fn values_that_cannot_be_are_in_another_unit_or_of_another_robot() {
    let degrees = changed("-0.9,1.6,-0.2", "-51.6,1.6,-0.2");
    refused(
        free(degrees),
        "2:11",
        &["`qe2_rad` is `-51.6`", "A2 of KR 500 MT", "-2.443 to 0.524", "degrees"],
    );
    refused(free(changed("-0.9,", "1.2,")), "2:11", &["widened by 10°", "another robot"]);
    assert!(free(FREE.replace("-0.9,", "0.5,")).is_ok(), "a little beyond the limit of 20°");
    refused(free(changed("1.6001", "91.7")), "2:40", &["`ql3_rad`", "degrees"]);
    refused(
        free(changed("2.1,", "2100,")),
        "2:55",
        &["`px_m` is `2100`", "at most 20 m", "millimetres", "leave the field"],
    );
    refused(free(changed("-2740.4", "-2740400")), "2:47", &["`tm2_nm`", "at most 1000000 N·m"]);
    let fixed =
        |from: &str, to: &str| parse(&log_toml("static-load", ""), STATIC.replacen(from, to, 1));
    refused(fixed("-36", "-9e9"), "2:37", &["`fz_n`", "at most 1000000 N "]);
    refused(fixed("2.8", "162"), "2:45", &["`ry_rad`", "degrees"]);
    refused(fixed("150,", "-150,"), "3:56", &["`payload_kg` is `-150`", "not below 0"]);
    refused(fixed("0.17,", "172,"), "3:60", &["`cx_m`", "millimetres"]);
    refused(fixed("150,", ","), "3:56", &["`payload_kg` is missing", "Write 0"]);
    refused(fixed("0.17,", ","), "3:60", &["`cx_m` is missing", "its centre is needed"]);
    let hung = |mass: &str| {
        let rows = WELD.replace('\n', &format!(",{mass},0,0,0\n"));
        parse(
            &weld_toml(),
            rows.replacen(&format!(",{mass},0,0,0\n"), ",payload_kg,cx_m,cy_m,cz_m\n", 1),
        )
    };
    assert!(matches!(hung("0").unwrap().notices[0], LogNotice::StaticLoadColumns { .. }));
    refused(hung("30"), "2:60", &["`payload_kg` is `30`", "static-load logs only", "robot file"]);
}

/// A table with the fields of each row changed.
fn edited(text: &str, change: impl Fn(usize, &mut [String])) -> String {
    let mut lines = text.lines();
    let mut edited = format!("{}\n", lines.next().unwrap());
    for (k, line) in lines.enumerate() {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        change(k, &mut fields);
        edited += &(fields.join(",") + "\n");
    }
    edited
}

#[test]
fn rows_that_nobody_can_have_recorded_are_refused() {
    let right = long(200, |_| false, |_| false);
    assert!(free(&right).is_ok());
    let copied = edited(&right, |_, row| row[8] = row[7].clone());
    refused(free(copied), "", &["`ql1_rad` and `ql3_rad` hold the same values", "copied"]);
    let frozen = edited(&right, |_, row| row[10] = "2.1".to_owned());
    refused(free(frozen), "", &["`px_m`, `py_m`, `pz_m` hold one value", "A1 turns by 5.7°"]);
    let frozen = edited(&right, |_, row| row[9] = "0".to_owned());
    refused(free(frozen), "", &["`tm2_nm` hold one value", "Leave out"]);
    // 0.2 rad in 4 ms are 64 times what A1 can do.
    let glitch = edited(&right, |k, row| {
        if k == 100 {
            row[1] = "0.3".to_owned();
        }
    });
    refused(
        free(glitch),
        "102:7",
        &["`qe1_rad` jumps by 0.", "in 4.0 ms", "A1 can reach at 0.785 rad/s"],
    );
    let standing = log_toml("static-load", "");
    let load = |row: &[String]| format!("{},{},{},{}", row[..7].join(","), 5, -38, -36);
    let moved = |each: &dyn Fn(&[String]) -> String| {
        let header = "t_s,qe1_rad,qe2_rad,qe3_rad,qe4_rad,qe5_rad,qe6_rad,fx_n,fy_n,fz_n,rx_rad,ry_rad,rz_rad";
        let long = long(600, |_| false, |_| false);
        let rows = long.lines().skip(1).map(|line| {
            each(&line.split(',').map(str::to_owned).collect::<Vec<_>>()) + ",0.9,2.8,0.4\n"
        });
        format!("{header}\n{}", rows.collect::<String>())
    };
    refused(parse(&standing, moved(&load)), "", &["the arm moves in ", "% of the rows", "`kind`"]);
    let at_rest = moved(&|row| {
        let mut row = row.to_vec();
        row[1] = "0.1".to_owned();
        load(&row)
    });
    assert!(parse(&standing, at_rest).is_ok());
}

#[test]
fn a_channel_that_is_needed_holds_values() {
    let text = WELD.replace(",62.8\n", ",\n").replace(",62.9\n", ",\n");
    refused(parse(&weld_toml(), text), "", &["`spindle_rad_s` holds no value"]);
    let ring = "t_s,qe1_rad,qe2_rad,qe3_rad,qe4_rad,qe5_rad,qe6_rad,px_m,py_m,pz_m\n0,0,0,0,0,0,0,,,\n1,0,0,0,0,0,0,,,\n";
    let error = parse(&log_toml("ring-down", ""), ring).unwrap_err();
    assert!(
        error.to_string().contains("nothing to compare")
            && error.to_string().contains("samples.csv"),
        "{error}"
    );
}

#[test]
fn the_snippet_shows_the_line_of_a_large_file() {
    let mut text = format!("{HEADER}\n");
    for i in 0..5000 {
        let note = if i == 4000 { "oops" } else { "1" };
        writeln!(
            text,
            "{:.3},0.1,-0.9,1.6,-0.2,0.6,0.4,0.1,1.6,{note},2.1,-0.1,0.6",
            f64::from(i) * 0.004
        )
        .unwrap();
    }
    let error = free(&text).unwrap_err();
    assert!(error.place().ends_with("samples.csv:4002:42"), "{error}");
    let mut shown = String::new();
    let theme = miette::GraphicalTheme::unicode_nocolor();
    miette::GraphicalReportHandler::new_themed(theme)
        .with_width(400)
        .render_report(&mut shown, &error)
        .unwrap();
    assert!(
        shown.contains("4002 │ 16.000,0.1") && shown.contains("samples.csv:4002:42]"),
        "{shown}"
    );
    // Of a long line, what stands around the mistake.
    let wide = |cells: &str| {
        text.lines()
            .take(3)
            .map(|line| format!("{}{line}\n", cells.repeat(200)))
            .collect::<String>()
    };
    let text = wide("µ,").replacen("-0.9", "oops", 1);
    let error = free(&text).unwrap_err();
    assert!(error.place().ends_with("samples.csv:2:411"), "{error}");
    let mut shown = String::new();
    let theme = miette::GraphicalTheme::unicode_nocolor();
    miette::GraphicalReportHandler::new_themed(theme)
        .with_width(400)
        .render_report(&mut shown, &error)
        .unwrap();
    assert!(shown.contains("oops") && !shown.contains(&"µ,".repeat(60)), "{shown}");
}

#[test]
fn log_toml_is_checked() {
    let kinds = ["\"static-load\"", "\"ring-down\"", "\"free-motion\"", "\"weld\""];
    let toml = log_toml("freemotion", "");
    refused_toml(
        &toml,
        FREE,
        "2:8",
        &[&kinds[..], &["`kind`", "Did you mean \"free-motion\"?"]].concat(),
    );
    refused_toml(
        &toml.replace("log/1", "robot/1"),
        FREE,
        "1:10",
        &["\"robot/1\", a robot", "expected \"log/1\""],
    );
    refused_toml(
        &toml.replace("kind", "kid"),
        FREE,
        "2:1",
        &["unknown key `kid`", "Did you mean `kind`?"],
    );
    refused_toml(
        "schema = \"log/1\"\nkind = \"weld\"\nrobot = \"none.toml\"\n",
        FREE,
        "3:9",
        &["dir/run/none.toml"],
    );
    refused_toml(&log_toml("weld", ""), WELD, "1:1", &["missing key `weld`"]);
    refused_toml(&log_toml("free-motion", "period_s = 0\n"), FREE, "4:12", &["above 0 in s"]);
    let noise = |entry: &str| log_toml("free-motion", &format!("[noise]\n{entry}\n"));
    refused_toml(
        &noise("tcp_pos_m = 3e-5"),
        FREE,
        "5:1",
        &["unknown key", "Did you mean `tcp_position_m`?"],
    );
    for value in ["0", "1e-300"] {
        let range = ["a number from 1e-10 to 0.1 in rad"];
        refused_toml(&noise(&format!("encoder_rad = {value}")), FREE, "5:15", &range);
    }
    refused_toml(&noise("tcp_position_m = 30"), FREE, "5:18", &["to 0.1 in m"]);
    refused_toml(
        &noise("tcp_position_m = [1e-5, 1e-5]"),
        FREE,
        "5:18",
        &["a list of 3, one a column"],
    );
    refused_toml(
        &noise("link_encoder_rad = [1e-5]"),
        FREE,
        "5:20",
        &["a list of 6", "or 2, as many as this log has"],
    );
    refused_toml(&noise("force_n = []"), FREE, "5:11", &["a list of 3"]);
    assert_eq!(parse(&log_toml("free-motion", ""), FREE).unwrap().noise, NoiseLevels::default());
}

/// A folder with a log of this kind; the robot stands one folder up.
fn write_log(folder: &Path, toml: &str, csv: &str) {
    fs::create_dir_all(folder).unwrap();
    fs::write(folder.join("log.toml"), toml).unwrap();
    fs::write(folder.join("samples.csv"), csv).unwrap();
}

/// A campaign with two logs, and a log of another robot beside it.
fn campaign() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let cell = folder.path().join("cell");
    fs::create_dir(&cell).unwrap();
    let robot = fs::read_to_string(fixture("robots/kr500-mt.toml")).unwrap();
    fs::write(cell.join("robot.toml"), &robot).unwrap();
    fs::write(
        folder.path().join("other.toml"),
        robot.replace("[0.400, 0.0, 0.0]", "[0.500, 0.0, 0.0]"),
    )
    .unwrap();
    let toml =
        |kind: &str| format!("schema = \"log/1\"\nkind = \"{kind}\"\nrobot = \"../robot.toml\"\n");
    write_log(&cell.join("free"), &toml("free-motion"), FREE);
    write_log(&cell.join("static"), &toml("static-load"), STATIC);
    write_log(
        &folder.path().join("stranger"),
        &toml("free-motion").replace("robot.toml", "other.toml"),
        FREE,
    );
    fs::write(cell.join("model.toml"), "schema = \"model/1\"\nrobot = \"robot.toml\"\n").unwrap();
    write_campaign(&cell, "[\"free\", \"static\"]");
    folder
}

fn write_campaign(cell: &Path, logs: &str) {
    let text = format!("schema = \"campaign/1\"\nmodel = \"model.toml\"\nlogs = {logs}\n");
    fs::write(cell.join("campaign.toml"), text).unwrap();
}

#[test]
fn a_campaign_reads_with_its_logs() {
    let folder = campaign();
    let cell = folder.path().join("cell");
    let read = Campaign::read(&cell).unwrap();
    assert_eq!((read.name.as_str(), &read.model), ("cell", &cell.join("model.toml")));
    assert_eq!(
        read.logs.iter().map(|log| log.name.as_str()).collect::<Vec<_>>(),
        ["free", "static"]
    );
    assert_eq!(read.logs[1].kind, LogKind::StaticLoad);

    let (model, logs) = read_logs(std::slice::from_ref(&cell)).unwrap();
    assert_eq!((model, logs.len()), (Some(cell.join("model.toml")), 2));
    let (model, logs) = read_logs(&[cell.join("static"), cell.join("free/log.toml")]).unwrap();
    assert_eq!(model, None);
    assert_eq!(logs.iter().map(|log| log.name.as_str()).collect::<Vec<_>>(), ["static", "free"]);
    assert_eq!(logs[1].path, cell.join("free"));
    assert_eq!(read_logs(&[]).unwrap().1.len(), 0);

    // A second campaign with a model of its own: the logs of both, and no model that could be
    // meant.
    let second = cell.join("holdout");
    fs::create_dir(&second).unwrap();
    fs::copy(cell.join("model.toml"), second.join("model.toml")).unwrap();
    let toml = "schema = \"log/1\"\nkind = \"free-motion\"\nrobot = \"../../robot.toml\"\n";
    write_log(&second.join("free-2"), toml, FREE);
    write_campaign(&second, "[\"free-2\"]");
    let (model, logs) = read_logs(&[cell.join("campaign.toml"), second]).unwrap();
    assert_eq!((model, logs.len()), (None, 3));
}

#[test]
fn mistakes_in_a_campaign_are_named() {
    let folder = campaign();
    let cell = folder.path().join("cell");
    let fails = |paths: &[PathBuf], place: &str, needles: &[&str]| {
        let error = read_logs(paths).map(|(_, logs)| logs.len()).expect_err(place);
        assert!(error.place().ends_with(place), "{}", told(&error));
        for needle in needles {
            assert!(told(&error).contains(needle), "`{needle}` is not in:\n{}", told(&error));
        }
    };
    let (stranger, only) = (folder.path().join("stranger"), std::slice::from_ref(&cell));
    fails(
        &[cell.clone(), stranger],
        "stranger/log.toml:3:9",
        &["a log of another robot", "the robot of the log `free`", "tool centre point"],
    );
    fails(&[cell.clone(), cell.join("static")], "cell/static", &["given twice"]);
    fails(
        &[folder.path().to_owned()],
        "",
        &["holds neither log.toml nor campaign.toml", "expected the folder of a log"],
    );
    fails(
        &[folder.path().join("none")],
        "none",
        &["does not exist", "expected the folder of a log"],
    );
    write_campaign(&cell, "[\"free\", \"statics\"]");
    fails(only, "campaign.toml:3:17", &["\"statics\" is no log", "cell/statics"]);
    write_campaign(&cell, "[\"free\", \"./free\"]");
    fails(only, "campaign.toml:3:17", &["listed twice"]);
    let rows = long(40, |_| false, |_| false);
    for name in ["first", "second"] {
        write_log(
            &cell.join(name),
            "schema = \"log/1\"\nkind = \"free-motion\"\nrobot = \"../robot.toml\"\n",
            &rows,
        );
    }
    write_campaign(&cell, "[\"free\", \"first\", \"second\"]");
    fails(only, "second/samples.csv", &["are those of the log `first`", "twice"]);
    write_campaign(&cell, "[]");
    fails(only, "campaign.toml:3:8", &["at least one"]);
    write_campaign(&cell, "[\"free\", 3]");
    fails(only, "campaign.toml:3:17", &["entry 2 of `logs`", "is 3; expected text"]);
    write_campaign(&cell, "[\"free\", \"../stranger\"]");
    fails(only, "../stranger/log.toml:3:9", &["a log of another robot"]);
    write_campaign(&cell, "[\"free\"]");
    fs::remove_file(cell.join("model.toml")).unwrap();
    fails(only, "campaign.toml:2:9", &["`model`", "a file that exists", "cell/model.toml"]);
    fs::remove_file(cell.join("free/samples.csv")).unwrap();
    fails(&[cell.join("free")], "free/samples.csv", &["cannot be read"]);
}

#[test]
fn a_log_knows_its_robot() {
    let log = free(FREE).unwrap();
    let mut robot = RobotFile::read(fixture("robots/kr500-mt.toml")).unwrap();
    robot.parameters.joints[2].stiffness *= 1.1;
    robot.parameters.friction.coulomb[0] = 0.0;
    assert!(log.must_be_of(&robot, "the model").is_ok(), "calibration does not make another robot");
    robot.parameters.joints[2].origin.x += 1e-3;
    let error = log.must_be_of(&robot, "the model").unwrap_err();
    assert!(
        error.place() == "dir/run/log.toml:3:9"
            && error.message().contains("A3 has another origin"),
        "{error}"
    );
    robot.joint_names[1] = "B2".to_owned();
    let error = log.must_be_of(&robot, "the model").unwrap_err();
    assert!(error.message().contains("\"A2\" instead of \"B2\""), "{error}");
}

/// Reads, or fails with a message that opens with one of the files.
fn reads_or_names_the_file(toml: &str, csv: &[u8]) {
    if let Err(error) = Log::parse(toml, csv, Path::new("dir/run")) {
        let text = error.to_string();
        assert!(
            text.starts_with("dir/run/samples.csv") || text.starts_with("dir/run/log.toml"),
            "{text}"
        );
        assert!(!error.help_text().is_empty());
        let mut shown = String::new();
        miette::GraphicalReportHandler::new().render_report(&mut shown, &error).unwrap();
    }
}

/// Of a long log the rows are thinned, not the years between them.
#[test]
fn a_clock_that_was_set_while_it_ran_leaves_a_gap() {
    let mut csv = HEADER.to_owned();
    for k in 0..120_000 {
        let set = if k < 50_000 { 0.0 } else { 1.7e9 };
        let time = set + 0.001 * f64::from(k);
        write!(csv, "\n{time:.3},0.1,-0.9,1.6,-0.2,0.6,0.4,0.1,1.6,-2740,2.1,-0.1,0.6").unwrap();
    }
    let log = parse(&log_toml("free-motion", ""), csv).unwrap();
    // The longer part, every fourth row.
    assert_eq!(log.samples.len(), 70_000 / 4);
    assert!(log.notices.iter().any(|notice| matches!(notice, LogNotice::Cut { pieces: 2, .. })));
}

/// A good table with some bytes replaced, put in or taken out, and perhaps cut.
fn mutated(good: &'static str) -> impl Strategy<Value = Vec<u8>> {
    let bytes = prop_oneof![
        any::<u8>(),
        prop::sample::select(b",;\t\n\r\"'.-+eE0159 #\xff\xc2\xb5".to_vec()),
    ];
    let edits = prop::collection::vec((0..good.len(), 0..3u8, bytes), 1..12);
    (edits, prop::option::weighted(0.2, 0..good.len())).prop_map(move |(edits, cut)| {
        let mut text = good.as_bytes().to_vec();
        for (at, how, byte) in edits {
            let at = at.min(text.len() - 1);
            match how {
                0 => text[at] = byte,
                1 => text.insert(at, byte),
                _ => drop(text.remove(at)),
            }
        }
        text.truncate(cut.unwrap_or(text.len()));
        text
    })
}

proptest! {
    #[test]
    fn no_bytes_as_samples_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        reads_or_names_the_file(&log_toml("free-motion", ""), &bytes);
        reads_or_names_the_file(&log_toml("free-motion", ""), &[HEADER.as_bytes(), b"\n", &bytes].concat());
    }

    #[test]
    fn no_text_as_log_toml_makes_it_panic(text in any::<String>(), tail in "[ -~\n]{0,80}") {
        reads_or_names_the_file(&text, FREE.as_bytes());
        reads_or_names_the_file(&log_toml("free-motion", &tail), FREE.as_bytes());
    }

    #[test]
    fn no_mutation_makes_it_panic(free in mutated(FREE), fixed in mutated(STATIC), weld in mutated(WELD)) {
        reads_or_names_the_file(&log_toml("free-motion", "period_s = 0.004\n"), &free);
        reads_or_names_the_file(&log_toml("static-load", ""), &fixed);
        reads_or_names_the_file(&weld_toml(), &weld);
    }

    #[test]
    fn numbers_come_out_as_they_went_in(
        rows in prop::collection::vec((-2.0..2.0f64, prop::option::of(-20.0..20.0f64)), 2..40),
        ending in prop::sample::select(vec!["\n", "\r\n"]),
    ) {
        let mut text = format!("{HEADER}{ending}");
        for (i, (angle, position)) in rows.iter().enumerate() {
            let position = position.map(|p| format!("{p:e}")).unwrap_or_default();
            write!(text, "{i},{angle},0,0,0,0,0,,,,{position},1,2{ending}").unwrap();
        }
        let log = parse(&log_toml("free-motion", ""), &text);
        if rows.iter().all(|(_, position)| position.is_none()) {
            // The tracker's other two columns still hold values.
            prop_assert!(log.is_ok());
        }
        let samples = log.unwrap().samples;
        prop_assert_eq!(samples.len(), rows.len());
        for (i, (angle, position)) in rows.iter().enumerate() {
            prop_assert_eq!(samples.encoder[i][0].to_bits(), angle.to_bits());
            let read = samples.position.as_ref().unwrap()[i].x;
            prop_assert_eq!(position.is_none(), read.is_nan());
            if let Some(p) = position { prop_assert_eq!(p.to_bits(), read.to_bits()); }
        }
    }
}

/// A controller's traces come in two files of even rows without a time, currents in one of them.
#[test]
fn files_without_a_time_go_row_by_row_and_a_current_needs_no_factor() {
    let folder = tempfile::tempdir().unwrap();
    let toml = |more: &str| {
        let mut text = log_toml("free-motion", "period_s = 0.004\n");
        text += "files = [ { path = \"pos.csv\" }, { path = \"curr.csv\" } ]\n[columns]\n";
        for i in 1..=6 {
            text += &format!("\"pos.csv:J{i}\" = {{ channel = \"qe{i}\", unit = \"deg\" }}\n");
        }
        text + more
    };
    let rows = |count: usize, of: &dyn Fn(usize, usize) -> f64| -> String {
        let line =
            |k: usize| (1..=6).map(|i| of(k, i).to_string()).collect::<Vec<_>>().join(",") + "\n";
        "J1,J2,J3,J4,J5,J6\n".to_owned() + &(0..count).map(line).collect::<String>()
    };
    let angle =
        |k: usize, i: usize| [0.0, -50.0, 90.0, 0.0, 35.0, 0.0][i - 1] + 1e-3 * (k * i) as f64;
    let current = |k: usize, i: usize| i as f64 + 0.01 * (k as f64).sin();
    let write = |toml: &str, count: usize| {
        fs::write(folder.path().join("log.toml"), toml).unwrap();
        fs::write(folder.path().join("pos.csv"), rows(300, &angle)).unwrap();
        fs::write(folder.path().join("curr.csv"), rows(count, &current)).unwrap();
        Log::read(folder.path())
    };
    let line = "\"curr.csv:J2\" = { channel = \"tm2\", unit = \"A\" }\n";
    let log = write(&toml(line), 300).unwrap();
    let torque = log.samples.motor_torque[1].as_ref().unwrap();
    assert_eq!(torque[7], current(7, 2));
    assert!((log.samples.time[7] - log.samples.time[0] - 0.028).abs() < 1e-12);
    let open = log.origin.currents[1].unwrap();
    assert_eq!((open.unit, open.factor), ("A", None));
    assert_eq!(log.origin.columns.iter().find(|c| c.open).unwrap().line(), line.trim());

    let stated = line.replace("\"A\"", "\"A\", factor = 1.0");
    let log = write(&toml(&stated), 300).unwrap();
    assert!(log.origin.currents[1].is_none());
    let entry = log.origin.columns.iter().find(|c| c.unit == "A").unwrap();
    assert_eq!(entry.line(), stated.trim(), "a factor of 1 that is stated stays one");

    let shown = told(&write(&toml(line), 299).unwrap_err());
    assert!(shown.contains("holds 299 rows, another file of the log 300"), "{shown}");
    // No other channel is a current.
    let moment = "\"curr.csv:J3\" = { channel = \"mx\", unit = \"A\" }\n";
    let shown = told(&write(&toml(moment), 300).unwrap_err());
    assert!(shown.contains("one with a `factor`"), "{shown}");
}
