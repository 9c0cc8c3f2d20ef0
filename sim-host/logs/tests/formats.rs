//! Every format of samples reads as the same log, and no bytes whatever make a reader panic, hang or
//! take a gigabyte.
//!
//! A short run of damaged files is part of the ordinary tests. The long one, 10⁷ a reader, in memory:
//!
//! ```text
//! BOLERO_RANDOM_ITERATIONS=10000000 TMPDIR=/dev/shm cargo test --profile bench -p trueweld-logs \
//!     --features mcap,parquet --test all damaged
//! ```

#[path = "../../../tests/src/mutation.rs"]
mod mutation;

use mutation::never_breaks;
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use trueweld_logs::log::Log;
use trueweld_logs::log::import::propose;

const ROWS: usize = 12;

fn fixture(path: &str) -> PathBuf {
    let fixtures = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    fixtures.join(path).canonicalize().expect("a fixture")
}

/// Time, six encoder angles in degrees, and a torque: what every format holds.
fn row(k: usize) -> [f64; 8] {
    let t = 0.004 * k as f64;
    let angle = |i: f64| 10.0 * i + 3.0 * (t * (1.0 + i)).sin();
    [t, angle(1.0), -angle(3.0), angle(5.0), angle(0.3), angle(2.0), angle(0.7), 100.0 * t - 3.0]
}

fn header(k: usize) -> String {
    match k {
        0 => "Zeit [s]".to_owned(),
        7 => "torque_2 [Nm]".to_owned(),
        k => format!("AXIS_ACT.A{k} [deg]"),
    }
}

/// The `log.toml` that maps columns of these names in a file.
fn log_toml(file: &str, topic: &str, header: impl Fn(usize) -> String) -> String {
    let mut text = format!(
        "schema = \"log/1\"\nkind = \"free-motion\"\nrobot = \"robot.toml\"\nperiod_s = 0.004\n\
         files = [ {{ path = {file:?}{topic} }} ]\n[columns]\n"
    );
    for k in 0..8 {
        let (channel, unit) = match k {
            0 => ("t".to_owned(), "s"),
            7 => ("tm2".to_owned(), "Nm"),
            k => (format!("qe{k}"), "deg"),
        };
        writeln!(text, "{:?} = {{ channel = \"{channel}\", unit = \"{unit}\" }}", header(k))
            .expect("text");
    }
    text
}

/// A folder with the same log in one format; the files whose bytes may be mutated.
struct Case {
    name: &'static str,
    folder: tempfile::TempDir,
    files: Vec<&'static str>,
}

fn case(name: &'static str, toml: String, files: Vec<(&'static str, Vec<u8>)>) -> Case {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("log.toml"), toml).expect("log.toml");
    // Without comments: it is read with every damaged file.
    let robot = fs::read_to_string(fixture("robots/kr500-mt.toml")).expect("a robot");
    let lines = robot.lines().map(|line| line.split(" #").next().unwrap_or(line).trim_end());
    let robot: Vec<&str> = lines.filter(|line| !line.starts_with('#')).collect();
    fs::write(folder.path().join("robot.toml"), robot.join("\n")).expect("a robot");
    let names = files.iter().map(|(name, _)| *name).collect();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("a file");
    }
    Case { name, folder, files: names }
}

fn text() -> Case {
    let mut text = (0..8).map(header).collect::<Vec<_>>().join(",");
    for k in 0..ROWS {
        text += "\n";
        text += &row(k).map(|v| v.to_string()).join(",");
    }
    case("text", log_toml("a.csv", "", header), vec![("a.csv", text.into_bytes())])
}

fn german() -> Case {
    let mut text = format!("Messung 7\n{}\n", (0..8).map(header).collect::<Vec<_>>().join(";"));
    for k in 0..ROWS {
        text += &row(k).map(|v| v.to_string().replace('.', ",")).join(";");
        text += ";\r\n";
    }
    let topic = ", delimiter = \";\", decimal = \",\", header = 2";
    case("german", log_toml("a.txt", topic, header), vec![("a.txt", text.into_bytes())])
}

fn kuka() -> Case {
    let mut head =
        "DIAEXTENDED  {@:ENGLISH\r\n#BEGINGLOBALHEADER\r\n1,x\r\n#ENDGLOBALHEADER\r\n".to_owned();
    let title = |k: usize| header(k).split(' ').next().unwrap_or_default().to_owned();
    let unit = |k: usize| ["s", "deg", "deg", "deg", "deg", "deg", "deg", "Nm"][k];
    for k in 0..8 {
        write!(head, "#BEGINCHANNELHEADER\r\n200,{}\r\n202,{}\r\n", title(k), unit(k))
            .expect("text");
        if k == 0 {
            head += "210,IMPLIZIT\r\n220,12\r\n240,0\r\n241,0.004\r\n";
        } else {
            // Stored at half their size, so that the factor is seen to act.
            write!(
                head,
                "210,EXPLIZIT\r\n211,C:\\KRC\\trace.r64\r\n213,BLOCK\r\n214,REAL64\r\n220,12\r\n221,{k}\r\n240,0\r\n241,2\r\n"
            )
            .expect("text");
        }
        head += "#ENDCHANNELHEADER\r\n";
    }
    let numbers = (0..ROWS).flat_map(|k| row(k)[1..].to_vec());
    let bytes = numbers.flat_map(|v| (0.5 * v).to_le_bytes()).collect();
    let files = vec![("trace.dat", head.into_bytes()), ("trace.r64", bytes)];
    case("kuka", log_toml("trace.dat", "", header), files)
}

#[cfg(feature = "parquet")]
fn parquet() -> Case {
    use parquet::data_type::DoubleType;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;
    use std::sync::Arc;
    let fields: String = (0..8).map(|k| format!("OPTIONAL DOUBLE c{k}; ")).collect();
    let schema =
        Arc::new(parse_message_type(&format!("message log {{ {fields} }}")).expect("a schema"));
    let properties =
        WriterProperties::builder().set_compression(parquet::basic::Compression::SNAPPY).build();
    let mut bytes = Vec::new();
    let mut writer =
        SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties)).expect("a writer");
    // Two groups, as a long table has.
    for rows in [0..8, 8..ROWS] {
        let mut group = writer.next_row_group().expect("a group");
        for k in 0..8 {
            let mut column = group.next_column().expect("a column").expect("a column");
            let values: Vec<f64> = rows.clone().map(|r| row(r)[k]).collect();
            let levels = vec![1; values.len()];
            column.typed::<DoubleType>().write_batch(&values, Some(&levels), None).expect("values");
            column.close().expect("a column");
        }
        group.close().expect("a group");
    }
    writer.close().expect("a file");
    case("parquet", log_toml("a.parquet", "", |k| format!("c{k}")), vec![("a.parquet", bytes)])
}

#[cfg(feature = "mcap")]
fn mcap() -> Case {
    use std::collections::BTreeMap;
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut bytes).expect("a writer");
    let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", b"").expect("a schema");
    let other = writer.add_schema("std_msgs/msg/String", "ros2msg", b"").expect("a schema");
    let channel =
        writer.add_channel(schema, "/joint_states", "cdr", &BTreeMap::new()).expect("a channel");
    let chat = writer.add_channel(other, "/chat", "cdr", &BTreeMap::new()).expect("a channel");
    for k in 0..ROWS {
        let values = row(k);
        let mut cdr = vec![0, 1, 0, 0];
        let pad = |cdr: &mut Vec<u8>, to: usize| {
            while !(cdr.len() - 4).is_multiple_of(to) {
                cdr.push(0);
            }
        };
        let stamp = (values[0] * 1e9).round() as u64;
        cdr.extend(((stamp / 1_000_000_000) as u32).to_le_bytes());
        cdr.extend(((stamp % 1_000_000_000) as u32).to_le_bytes());
        let text = |cdr: &mut Vec<u8>, text: &str| {
            pad(cdr, 4);
            cdr.extend((text.len() as u32 + 1).to_le_bytes());
            cdr.extend(text.as_bytes());
            cdr.push(0);
        };
        text(&mut cdr, "base");
        pad(&mut cdr, 4);
        cdr.extend(6u32.to_le_bytes());
        for joint in 1..=6 {
            text(&mut cdr, &format!("joint_a{joint}"));
        }
        for list in [&values[1..7], &[], &[0.0, values[7], 0.0, 0.0, 0.0, 0.0]] {
            pad(&mut cdr, 4);
            cdr.extend((list.len() as u32).to_le_bytes());
            for value in list {
                pad(&mut cdr, 8);
                cdr.extend(value.to_le_bytes());
            }
        }
        for (channel_id, data) in [(channel, cdr.as_slice()), (chat, b"\0\x01\0\0\x01\0\0\0\0")] {
            let header = mcap::records::MessageHeader {
                channel_id,
                sequence: k as u32,
                log_time: stamp,
                publish_time: stamp,
            };
            writer.write_to_known_channel(&header, data).expect("a message");
        }
    }
    writer.finish().expect("a file");
    drop(writer);
    let name = |k: usize| match k {
        0 => "time".to_owned(),
        7 => "effort joint_a2".to_owned(),
        k => format!("position joint_a{k}"),
    };
    let topic = ", topic = \"/joint_states\"";
    case("mcap", log_toml("a.mcap", topic, name), vec![("a.mcap", bytes.into_inner())])
}

fn cases() -> Vec<Case> {
    vec![
        text(),
        german(),
        kuka(),
        #[cfg(feature = "parquet")]
        parquet(),
        #[cfg(feature = "mcap")]
        mcap(),
    ]
}

#[test]
fn every_format_reads_as_the_same_log() {
    for case in cases() {
        let log = Log::read(case.folder.path()).unwrap_or_else(|e| panic!("{}: {e}", case.name));
        assert_eq!(log.samples.len(), ROWS, "{}", case.name);
        for k in 0..ROWS {
            let expected = row(k);
            // Stamps are of whole nanoseconds.
            assert!((log.samples.time[k] - expected[0]).abs() < 1e-9, "{}", case.name);
            for i in 0..6 {
                let angle = expected[1 + i].to_radians();
                assert!((log.samples.encoder[k][i] - angle).abs() < 1e-12, "{}", case.name);
            }
            let torque = log.samples.motor_torque[1].as_ref().expect("a torque")[k];
            assert!((torque - expected[7]).abs() < 1e-12, "{}", case.name);
        }
    }
}

#[test]
fn every_format_is_recognised() {
    for case in cases() {
        let file = case.folder.path().join(case.files[0]);
        let found = propose(&[file], None, None).unwrap_or_else(|e| panic!("{}: {e}", case.name));
        let mapped: Vec<String> = found
            .columns
            .iter()
            .filter_map(|c| c.mapping.as_ref().ok())
            .map(|m| m.line())
            .collect();
        // Columns named c0 … c7 say nothing.
        if case.name != "parquet" {
            let encoders = mapped.iter().filter(|line| line.contains("channel = \"qe"));
            assert_eq!(encoders.count(), 6, "{}: {mapped:?}", case.name);
        }
    }
}

/// Every file of a log, damaged in turn.
fn damaged(case: &Case, words: &[&str]) {
    let folder = case.folder.path();
    for name in &case.files {
        let (path, first) = (folder.join(name), folder.join(case.files[0]));
        let good = fs::read(&path).expect("a file");
        never_breaks(&format!("{} {name}", case.name), &good, words, |bytes| {
            fs::write(&path, bytes).expect("a file");
            // Reads every row, and needs no robot, whose file takes longer than such a log.
            let mut errors = vec![propose(std::slice::from_ref(&first), None, None).err()];
            if bytes.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte)) % 4 == 0 {
                errors.push(Log::read(folder).err());
            }
            for error in errors.into_iter().flatten() {
                assert!(!error.help_text().is_empty(), "{error}");
            }
        });
        fs::write(&path, &good).expect("a file");
    }
}

#[test]
fn damaged_text_is_read_or_refused() {
    damaged(&text(), &["AXIS_ACT.A1 [deg]", "Zeit [s]"]);
}

#[test]
fn damaged_text_of_another_dialect_is_read_or_refused() {
    damaged(&german(), &["AXIS_ACT.A1 [deg]", "Zeit [s]"]);
}

#[test]
fn damaged_traces_are_read_or_refused() {
    damaged(&kuka(), &["IMPLIZIT", "EXPLIZIT", "221,9", "220,999999999", "#ENDCHANNELHEADER"]);
}

#[cfg(feature = "parquet")]
#[test]
fn damaged_parquet_is_read_or_refused() {
    damaged(&parquet(), &["PAR1"]);
}

#[cfg(feature = "mcap")]
#[test]
fn damaged_mcap_is_read_or_refused() {
    damaged(&mcap(), &["MCAP0", "sensor_msgs/msg/JointState", "cdr"]);
}

/// Sizes of chunks and records stand at the front.
#[cfg(feature = "mcap")]
#[test]
fn any_bit_of_a_recording_may_be_wrong() {
    let case = mcap();
    let path = case.folder.path().join(case.files[0]);
    let good = fs::read(&path).expect("a file");
    for bit in 0..8 * good.len().min(1000) {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        fs::write(&path, &bytes).expect("a file");
        let _ = propose(std::slice::from_ref(&path), None, None);
    }
}

/// Found by fuzzing: no room may be made for what the file cannot hold.
#[cfg(feature = "parquet")]
#[test]
fn a_table_that_claims_a_schema_longer_than_itself_is_refused() {
    // Version 1, and a list of 2³¹ − 1 structures, of which none follows.
    let footer = [0x15, 0x02, 0x19, 0xfc, 0xff, 0xff, 0xff, 0xff, 0x07, 0x00];
    let length = (footer.len() as u32).to_le_bytes();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.parquet");
    fs::write(&path, [b"PAR1".as_slice(), &footer, &length, b"PAR1"].concat()).expect("a file");
    let error = propose(&[path], None, None).map(drop).expect_err("it is damaged");
    assert!(error.message().contains("cannot be read as Parquet"), "{error}");
}
