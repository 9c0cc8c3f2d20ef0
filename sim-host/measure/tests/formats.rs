//! Every format of samples reads as the same log, and no bytes whatever make a reader panic, hang or
//! take a gigabyte.
//!
//! A short run of mutated files is part of the ordinary tests. The long one, 10⁷ a reader:
//!
//! ```text
//! TRUEWELD_FUZZ=10000000 cargo test --release -p trueweld-measure --features mcap,parquet --test formats mutated
//! ```

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use trueweld_measure::data::log::Log;
use trueweld_measure::data::log::import::propose;

const ROWS: usize = 40;

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
        "schema = \"log/1\"\nkind = \"free-motion\"\nrobot = {:?}\nperiod_s = 0.004\n\
         files = [ {{ path = {file:?}{topic} }} ]\n[columns]\n",
        fixture("robots/kr500-mt.toml")
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
            head += "210,IMPLIZIT\r\n220,40\r\n240,0\r\n241,0.004\r\n";
        } else {
            // Stored at half their size, so that the factor is seen to act.
            write!(
                head,
                "210,EXPLIZIT\r\n211,C:\\KRC\\trace.r64\r\n213,BLOCK\r\n214,REAL64\r\n220,40\r\n221,{k}\r\n240,0\r\n241,2\r\n"
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
    for rows in [0..25, 25..ROWS] {
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
            while (cdr.len() - 4) % to != 0 {
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

/// Some bytes replaced, put in or taken out, or a piece of the file somewhere else.
fn mutate(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    const LIKELY: &[u8] = b",;\t\n\r\"'.-+eE0159 #\xff\x00\x7f\x80";
    for _ in 0..random.random_range(1..8) {
        if bytes.is_empty() {
            return;
        }
        let at = random.random_range(0..bytes.len());
        let byte = match random.random_range(0..2) {
            0 => random.random(),
            _ => LIKELY[random.random_range(0..LIKELY.len())],
        };
        match random.random_range(0..7) {
            0 | 1 => bytes[at] = byte,
            2 => bytes.insert(at, byte),
            3 => drop(bytes.remove(at)),
            4 => bytes.truncate(at),
            5 => {
                // A number of eight bytes.
                let number: u64 = [0, 1, u64::MAX, 1 << 31, 1 << 40][random.random_range(0..5)];
                let end = (at + 8).min(bytes.len());
                bytes[at..end].copy_from_slice(&number.to_le_bytes()[..end - at]);
            }
            _ => {
                let to = random.random_range(0..bytes.len());
                let length = random.random_range(1..64).min(bytes.len() - at);
                let piece: Vec<u8> = bytes[at..at + length].to_vec();
                bytes.splice(to..to, piece);
            }
        }
    }
}

/// Most memory that this process took so far, bytes, where the system tells.
fn peak() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kilobytes| kilobytes << 10)
}

fn reads_or_refuses(folder: &Path, import: bool, file: &str) {
    if let Err(error) = Log::read(folder) {
        assert!(!error.help_text().is_empty(), "{error}");
    }
    if import {
        let _ = propose(&[folder.join(file)], None, None);
    }
}

fn mutated(case: &Case) {
    let count: u64 =
        std::env::var("TRUEWELD_FUZZ").ok().and_then(|n| n.parse().ok()).unwrap_or(300);
    let good: Vec<Vec<u8>> = case
        .files
        .iter()
        .map(|name| fs::read(case.folder.path().join(name)).expect("a file"))
        .collect();
    let begun = Instant::now();
    for seed in 0..count {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let which = random.random_range(0..good.len());
        let path = case.folder.path().join(case.files[which]);
        let mut bytes = good[which].clone();
        mutate(&mut bytes, &mut random);
        fs::write(&path, &bytes).expect("a file");
        let start = Instant::now();
        let read = || reads_or_refuses(case.folder.path(), seed % 8 == 0, case.files[0]);
        if let Err(panic) = std::panic::catch_unwind(read) {
            println!("{}: seed {seed}", case.name);
            std::panic::resume_unwind(panic);
        }
        assert!(start.elapsed() < Duration::from_secs(10), "{}: seed {seed} hangs", case.name);
        fs::write(&path, &good[which]).expect("a file");
    }
    if let Some(peak) = peak() {
        assert!(peak < 1 << 30, "{}: {peak} bytes", case.name);
        println!(
            "{}: {count} inputs in {:.0?}, at most {} MB",
            case.name,
            begun.elapsed(),
            peak >> 20
        );
    }
}

#[test]
fn mutated_text_is_read_or_refused() {
    mutated(&text());
    mutated(&german());
}

#[test]
fn mutated_traces_are_read_or_refused() {
    mutated(&kuka());
}

#[cfg(feature = "parquet")]
#[test]
fn mutated_parquet_is_read_or_refused() {
    mutated(&parquet());
}

#[cfg(feature = "mcap")]
#[test]
fn mutated_mcap_is_read_or_refused() {
    mutated(&mcap());
}
