//! Every format of samples reads as the same log, and no bytes whatever make a reader panic, hang or
//! take a gigabyte.
//!
//! A short run of damaged files is part of the ordinary tests. The long one, 10⁷ a reader, in memory:
//!
//! ```text
//! BOLERO_RANDOM_ITERATIONS=10000000 TMPDIR=/dev/shm cargo test --profile bench -p trueweld-logs \
//!     --features mcap,parquet,rosbag --test all damaged
//! ```

#[path = "../../../tests/src/mutation.rs"]
mod mutation;

use mutation::never_breaks;
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use trueweld_logs::log::Log;
use trueweld_logs::log::import::{Stated, propose};

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

/// A message of ROS 2 in CDR: numbers stand at multiples of their size.
#[cfg(any(feature = "mcap", feature = "rosbag"))]
struct CdrWriter(Vec<u8>);

#[cfg(any(feature = "mcap", feature = "rosbag"))]
impl CdrWriter {
    /// With a header of that time, s, and frame.
    fn stamped(time: f64, frame: &str) -> Self {
        let mut cdr = Self(vec![0, 1, 0, 0]);
        cdr.header(time, frame);
        cdr
    }

    fn header(&mut self, time: f64, frame: &str) {
        let stamp = (time * 1e9).round() as u64;
        self.whole((stamp / 1_000_000_000) as u32);
        self.whole((stamp % 1_000_000_000) as u32);
        self.text(frame);
    }

    fn pad(&mut self, to: usize) {
        while !(self.0.len() - 4).is_multiple_of(to) {
            self.0.push(0);
        }
    }

    fn whole(&mut self, number: u32) {
        self.pad(4);
        self.0.extend(number.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.whole(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    fn numbers(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.pad(8);
            self.0.extend(number.to_le_bytes());
        }
    }

    fn joint_state(values: [f64; 8]) -> Vec<u8> {
        let mut cdr = Self::stamped(values[0], "base");
        cdr.whole(6);
        (1..=6).for_each(|joint| cdr.text(&format!("joint_a{joint}")));
        for list in [&values[1..7], &[], &[0.0, values[7], 0.0, 0.0, 0.0, 0.0]] {
            cdr.whole(list.len() as u32);
            cdr.numbers(list);
        }
        cdr.0
    }

    /// What a transform or a pose holds, by rows.
    fn transforms(frames: &[(&str, f64, [f64; 7])]) -> Vec<u8> {
        let mut cdr = Self(vec![0, 1, 0, 0]);
        cdr.whole(frames.len() as u32);
        for (frame, time, numbers) in frames {
            cdr.header(*time, "world");
            cdr.text(frame);
            cdr.numbers(numbers);
        }
        cdr.0
    }
}

#[cfg(any(feature = "mcap", feature = "rosbag"))]
fn ros_name(k: usize) -> String {
    match k {
        0 => "time".to_owned(),
        7 => "effort joint_a2".to_owned(),
        k => format!("position joint_a{k}"),
    }
}

/// Messages with their times, s.
#[cfg(feature = "mcap")]
type Messages = Vec<(f64, Vec<u8>)>;

/// A recording of these topics: name, type, and messages.
#[cfg(feature = "mcap")]
fn mcap_of(topics: &[(&str, &str, Messages)]) -> Vec<u8> {
    use std::collections::BTreeMap;
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut bytes).expect("a writer");
    for (topic, kind, messages) in topics {
        let schema = writer.add_schema(kind, "ros2msg", b"").expect("a schema");
        let channel_id =
            writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).expect("a channel");
        for (sequence, (time, data)) in (0..).zip(messages) {
            let stamp = (time * 1e9).round() as u64;
            let header = mcap::records::MessageHeader {
                channel_id,
                sequence,
                log_time: stamp,
                publish_time: stamp,
            };
            writer.write_to_known_channel(&header, data).expect("a message");
        }
    }
    writer.finish().expect("a file");
    drop(writer);
    bytes.into_inner()
}

/// The recording with its chunks packed.
#[cfg(feature = "mcap")]
fn packed(bytes: &[u8], name: &str, pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let (mut out, mut at) = (bytes[..8].to_vec(), 8);
    while at + 9 < bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("a length"));
        let data = &bytes[at + 9..at + 9 + length as usize];
        // Times, size and checksum, then what packs it: nothing.
        let chunk = match bytes[at] {
            6 => {
                let records = pack(&data[40..]);
                let mut chunk = data[..28].to_vec();
                chunk.extend((name.len() as u32).to_le_bytes());
                chunk.extend(name.as_bytes());
                chunk.extend((records.len() as u64).to_le_bytes());
                chunk.extend(records);
                chunk
            }
            _ => data.to_vec(),
        };
        out.push(bytes[at]);
        out.extend((chunk.len() as u64).to_le_bytes());
        out.extend(chunk);
        at += 9 + data.len();
    }
    out.extend(&bytes[at..]);
    out
}

#[cfg(feature = "mcap")]
fn mcap() -> Case {
    let joints = (0..ROWS).map(|k| (row(k)[0], CdrWriter::joint_state(row(k)))).collect();
    let chat = (0..ROWS).map(|k| (row(k)[0], b"\0\x01\0\0\x01\0\0\0\0".to_vec())).collect();
    let bytes = mcap_of(&[
        ("/joint_states", "sensor_msgs/msg/JointState", joints),
        ("/chat", "std_msgs/msg/String", chat),
    ]);
    let topic = ", topic = \"/joint_states\"";
    case("mcap", log_toml("a.mcap", topic, ros_name), vec![("a.mcap", bytes)])
}

/// The tables that `rosbag2_storage_sqlite3` writes: topics, and messages with their time of receipt.
#[cfg(feature = "rosbag")]
fn rosbag() -> Case {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.db3");
    let bag = rusqlite::Connection::open(&path).expect("a database");
    bag.execute_batch(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, \
         serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL); \
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, \
         timestamp INTEGER NOT NULL, data BLOB NOT NULL); \
         CREATE INDEX timestamp_idx ON messages (timestamp ASC); \
         INSERT INTO topics VALUES(1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr', ''); \
         INSERT INTO topics VALUES(2, '/chat', 'std_msgs/msg/String', 'cdr', '');",
    )
    .expect("tables");
    for k in 0..ROWS {
        let data = CdrWriter::joint_state(row(k));
        let stamp = (row(k)[0] * 1e9) as i64;
        let insert = "INSERT INTO messages(topic_id, timestamp, data) VALUES(?1, ?2, ?3)";
        bag.execute(insert, (1, stamp, data)).expect("a message");
        bag.execute(insert, (2, stamp, vec![0u8, 1, 0, 0, 1, 0, 0, 0, 0])).expect("a message");
    }
    drop(bag);
    let bytes = fs::read(&path).expect("a file");
    case("rosbag", log_toml("a.db3", "", ros_name), vec![("a.db3", bytes)])
}

/// An array as `numpy.save` writes it.
fn npy_of(kind: &str, shape: &str, numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
    let mut header = format!("{{'descr': {kind}, 'fortran_order': False, 'shape': {shape}, }}");
    header += &" ".repeat(63 - (10 + header.len()) % 64);
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
    bytes
}

fn npy() -> Case {
    let numbers = (0..ROWS).flat_map(row);
    let bytes = npy_of("'<f8'", &format!("({ROWS}, 8)"), numbers);
    let number = |k: usize| (k + 1).to_string();
    case("npy", log_toml("a.npy", "", number), vec![("a.npy", bytes)])
}

/// Columns with names, as `DataFrame.to_records` gives them.
fn records() -> Case {
    let kind = "[('t', '<f8'), ('q', '<f8', (6,)), ('tau2', '<f8')]";
    let bytes = npy_of(kind, &format!("({ROWS},)"), (0..ROWS).flat_map(row));
    let name = |k: usize| match k {
        0 => "t".to_owned(),
        7 => "tau2".to_owned(),
        k => format!("q[{}]", k - 1),
    };
    case("records", log_toml("a.npy", "", name), vec![("a.npy", bytes)])
}

fn npz() -> Case {
    npz_packed(zip::CompressionMethod::Deflated)
}

fn npz_packed(by: zip::CompressionMethod) -> Case {
    use std::io::Write as _;
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let packed = zip::write::SimpleFileOptions::default().compression_method(by);
    let vector =
        |place: usize| npy_of("'<f8'", &format!("({ROWS},)"), (0..ROWS).map(|k| row(k)[place]));
    let angles =
        npy_of("'<f8'", &format!("({ROWS}, 6)"), (0..ROWS).flat_map(|k| row(k)[1..7].to_vec()));
    for (name, bytes) in [("t.npy", vector(0)), ("q.npy", angles), ("tau2.npy", vector(7))] {
        archive.start_file(name, packed).expect("a file");
        archive.write_all(&bytes).expect("a file");
    }
    let bytes = archive.finish().expect("an archive").into_inner();
    let name = |k: usize| match k {
        0 => "t".to_owned(),
        7 => "tau2".to_owned(),
        k => format!("q[{}]", k - 1),
    };
    case("npz", log_toml("a.npz", "", name), vec![("a.npz", bytes)])
}

/// An element of a MAT file, filled up to a multiple of 8.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// An array of doubles by columns, as `save` writes it.
fn mat_array(name: &str, rows: usize, columns: &[Vec<f64>]) -> Vec<u8> {
    let sizes = [rows as i32, columns.len() as i32].map(i32::to_le_bytes).concat();
    let numbers: Vec<u8> = columns.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let parts = [
        element(6, &[6, 0, 0, 0, 0, 0, 0, 0]),
        element(5, &sizes),
        element(1, name.as_bytes()),
        element(9, &numbers),
    ];
    element(14, &parts.concat())
}

fn mat_header() -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file, Platform: GLNXA64".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1, b'I', b'M']);
    bytes
}

/// Arrays of a recording, each an element.
fn mat_arrays() -> [Vec<u8>; 3] {
    let column = |place: usize| (0..ROWS).map(|k| row(k)[place]).collect::<Vec<_>>();
    let angles: Vec<Vec<f64>> = (1..7).map(column).collect();
    // Of 1 × N the time, as `0:dt:T` makes it.
    let time: Vec<Vec<f64>> = column(0).into_iter().map(|t| vec![t]).collect();
    [mat_array("t", 1, &time), mat_array("q", ROWS, &angles), mat_array("tau2", ROWS, &[column(7)])]
}

fn mat_name(k: usize) -> String {
    match k {
        0 => "t".to_owned(),
        7 => "tau2".to_owned(),
        k => format!("q({k})"),
    }
}

fn mat() -> Case {
    let bytes = [mat_header(), mat_arrays().concat()].concat();
    case("mat", log_toml("a.mat", "", mat_name), vec![("a.mat", bytes)])
}

/// Packed, as MATLAB saves by default.
fn mat_packed() -> Case {
    use std::io::Write as _;
    let mut bytes = mat_header();
    for array in mat_arrays() {
        let mut packer =
            flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        packer.write_all(&array).expect("an array");
        let packed = packer.finish().expect("an array");
        bytes.extend([15u32.to_le_bytes(), (packed.len() as u32).to_le_bytes()].concat());
        bytes.extend(packed);
    }
    case("mat packed", log_toml("a.mat", "", mat_name), vec![("a.mat", bytes)])
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
        #[cfg(feature = "rosbag")]
        rosbag(),
        npy(),
        records(),
        npz(),
        mat(),
        mat_packed(),
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
        let found = propose(&[file], None, Stated::default())
            .unwrap_or_else(|e| panic!("{}: {e}", case.name));
        let mapped: Vec<String> = found
            .columns
            .iter()
            .filter_map(|c| c.mapping.as_ref().ok())
            .map(|m| m.line())
            .collect();
        // Columns named c0 … c7, or by their numbers, say nothing.
        if !["parquet", "npy"].contains(&case.name) {
            let encoders = mapped.iter().filter(|line| line.contains("channel = \"qe"));
            assert_eq!(encoders.count(), 6, "{}: {mapped:?}", case.name);
        }
    }
}

/// What a case says with one file of it changed.
fn read_with(case: &Case, change: impl Fn(&mut Vec<u8>)) -> Result<Log, String> {
    let path = case.folder.path().join(case.files[0]);
    let mut bytes = fs::read(&path).expect("a file");
    change(&mut bytes);
    fs::write(&path, bytes).expect("a file");
    Log::read(case.folder.path()).map_err(|error| error.to_string())
}

#[test]
fn a_bit_that_a_checksum_tells_is_wrong_is_no_number() {
    let cases = [
        npz_packed(zip::CompressionMethod::Stored),
        #[cfg(feature = "mcap")]
        mcap(),
    ];
    for case in cases {
        let torque = row(5)[7].to_le_bytes();
        let read = read_with(&case, |bytes| {
            let at = bytes.windows(8).position(|w| w == torque).expect("a torque");
            bytes[at] ^= 1;
        });
        let error = read.expect_err(case.name).to_lowercase();
        assert!(error.contains("checksum"), "{}: {error}", case.name);
    }
}

#[test]
fn a_file_of_two_arrays_is_none_of_one() {
    let error = read_with(&npy(), |bytes| bytes.extend(bytes.clone())).expect_err("two arrays");
    assert!(error.contains("goes on behind its numbers"), "{error}");
}

#[test]
fn times_are_in_seconds_whatever_their_unit_or_refused() {
    let of = |unit: &str| {
        let stamps = (0..ROWS).map(|k| f64::from_bits(4 * k as u64));
        let time = npy_of(&format!("'<M8[{unit}]'"), &format!("({ROWS},)"), stamps);
        let case = npz();
        read_with(&case, |bytes| {
            use std::io::{Cursor, Write as _};
            let mut old = zip::ZipArchive::new(Cursor::new(bytes.clone())).expect("an archive");
            let mut new = zip::ZipWriter::new(Cursor::new(Vec::new()));
            let options = zip::write::SimpleFileOptions::default();
            new.start_file("t.npy", options).expect("a file");
            new.write_all(&time).expect("a file");
            for name in ["q.npy", "tau2.npy"] {
                new.raw_copy_file(old.by_name(name).expect("a file")).expect("a file");
            }
            *bytes = new.finish().expect("an archive").into_inner();
        })
    };
    for (unit, factor) in [("ms", 1e-3), ("10us", 1e-5), ("ns", 1e-9), ("m", 60.0)] {
        let time = of(unit).map(|log| log.samples.time);
        // Rows that are a minute apart are refused as such, not read as others.
        match time {
            Ok(time) => assert!((time[1] - time[0] - 4.0 * factor).abs() < 1e-12, "{unit}"),
            Err(error) => assert!(!error.contains("not known"), "{unit}: {error}"),
        }
    }
    for unit in ["Y", "M", "generic"] {
        assert!(of(unit).expect_err(unit).contains("not known"));
    }
}

#[test]
fn a_dot_beside_decimal_commas_parts_thousands_and_is_refused() {
    let read = read_with(&german(), |bytes| {
        let text = String::from_utf8(bytes.clone()).expect("text").replace("-2,6", "-2.600");
        *bytes = text.into_bytes();
    });
    assert!(read.expect_err("a dot").contains("-2.600"));
}

#[test]
fn gains_beside_an_array_do_not_turn_it_over() {
    use std::io::{Cursor, Write as _};
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let angles =
        npy_of("'<f8'", &format!("({ROWS}, 6)"), (0..ROWS).flat_map(|k| row(k)[1..7].to_vec()));
    for (name, bytes) in [("q.npy", angles), ("kp.npy", npy_of("'<f8'", "(6,)", [1.0; 6]))] {
        archive.start_file(name, zip::write::SimpleFileOptions::default()).expect("a file");
        archive.write_all(&bytes).expect("a file");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.npz");
    fs::write(&path, archive.finish().expect("an archive").into_inner()).expect("a file");
    let found = propose(&[path], None, Stated::default()).expect("a proposal");
    let angles = found.files.iter().find(|f| f.rows == ROWS).expect("a table of all rows");
    assert_eq!(angles.topic.as_deref(), Some("12 rows"));
}

#[cfg(feature = "parquet")]
#[test]
fn a_value_that_its_group_has_not_is_missing_in_its_own_row() {
    use parquet::data_type::DoubleType;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;
    use std::sync::Arc;
    let fields: String = (0..8).map(|k| format!("OPTIONAL DOUBLE c{k}; ")).collect();
    let text = format!("message log {{ OPTIONAL group s {{ {fields} }} }}");
    let schema = Arc::new(parse_message_type(&text).expect("a schema"));
    let properties = Arc::new(WriterProperties::builder().build());
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, properties).expect("a writer");
    let mut group = writer.next_row_group().expect("a group");
    for k in 0..8 {
        let mut column = group.next_column().expect("a column").expect("a column");
        // One torque is missing in a group that is there.
        let is_there = |r: &usize| k != 7 || *r != 4;
        let levels: Vec<i16> = (0..ROWS).map(|r| if is_there(&r) { 2 } else { 1 }).collect();
        let values: Vec<f64> = (0..ROWS).filter(is_there).map(|r| row(r)[k]).collect();
        column.typed::<DoubleType>().write_batch(&values, Some(&levels), None).expect("values");
        column.close().expect("a column");
    }
    group.close().expect("a group");
    writer.close().expect("a file");
    let toml = log_toml("a.parquet", "", |k| format!("s.c{k}"));
    let log = Log::read(case("nested", toml, vec![("a.parquet", bytes)]).folder.path());
    let torque = log.expect("a log").samples.motor_torque[1].clone().expect("a torque");
    for (r, torque) in torque.iter().enumerate() {
        assert!(if r == 4 { torque.is_nan() } else { (torque - row(r)[7]).abs() < 1e-12 }, "{r}");
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
            let mut errors =
                vec![propose(std::slice::from_ref(&first), None, Stated::default()).err()];
            if bytes.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte)) % 16 == 0 {
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

#[cfg(feature = "rosbag")]
#[test]
fn damaged_bags_are_read_or_refused() {
    damaged(&rosbag(), &["SQLite format 3", "CREATE TABLE topics", "cdr"]);
}

#[test]
fn damaged_arrays_are_read_or_refused() {
    damaged(&npy(), &["'<f8'", "'|O'", "(12, 8)", "'fortran_order': True"]);
}

#[test]
fn damaged_records_are_read_or_refused() {
    damaged(&records(), &["('q', '<f8', (6,))", "'<M8[ns]'", "(12,)"]);
}

#[test]
fn damaged_archives_of_arrays_are_read_or_refused() {
    damaged(&npz(), &["PK\x01\x02", "PK\x05\x06", ".npy"]);
}

#[test]
fn damaged_mat_files_are_read_or_refused() {
    damaged(&mat(), &["MATLAB 5.0", "MI", "\x0e\0\0\0"]);
}

#[test]
fn damaged_packed_mat_files_are_read_or_refused() {
    damaged(&mat_packed(), &["MATLAB 5.0", "\x0f\0\0\0"]);
}

/// Every message that is read, in chunks that are packed either way.
#[cfg(feature = "mcap")]
#[test]
fn messages_of_instruments_are_read_whatever_packs_them() {
    let pose = [0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0];
    let stamped = |time: f64, numbers: &[f64]| {
        let mut cdr = CdrWriter::stamped(time, "base");
        cdr.numbers(numbers);
        cdr.0
    };
    let transform = |time: f64| {
        let mut cdr = CdrWriter::stamped(time, "base");
        cdr.text("tool0");
        cdr.numbers(&pose);
        cdr.0
    };
    // As `robot_state_publisher` and a tracker's driver share `/tf`.
    let frames = |time: f64| CdrWriter::transforms(&[("tool0", time, pose), ("smr", time, pose)]);
    let all = |of: &dyn Fn(f64) -> Vec<u8>| {
        (0..5).map(|k| (0.01 * f64::from(k), of(0.01 * f64::from(k)))).collect()
    };
    let bytes = mcap_of(&[
        ("/wrench", "geometry_msgs/msg/WrenchStamped", all(&|t| stamped(t, &pose[..6]))),
        ("/point", "geometry_msgs/msg/PointStamped", all(&|t| stamped(t, &pose[..3]))),
        ("/pose", "geometry_msgs/msg/PoseStamped", all(&|t| stamped(t, &pose))),
        ("/transform", "geometry_msgs/msg/TransformStamped", all(&transform)),
        ("/tf", "tf2_msgs/msg/TFMessage", all(&frames)),
    ]);
    let zstd = |data: &[u8]| {
        ruzstd::encoding::compress_to_vec(data, ruzstd::encoding::CompressionLevel::Fastest)
    };
    let lz4 = |data: &[u8]| {
        use std::io::Write as _;
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        encoder.write_all(data).expect("a chunk");
        encoder.finish().expect("a chunk")
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.mcap");
    for bytes in [bytes.clone(), packed(&bytes, "zstd", zstd), packed(&bytes, "lz4", lz4)] {
        fs::write(&path, bytes).expect("a file");
        let found = propose(std::slice::from_ref(&path), None, Stated::default()).expect("topics");
        let topics: Vec<_> = found.files.iter().filter_map(|f| f.topic.as_deref()).collect();
        assert_eq!(topics, ["/point", "/pose", "/tf smr", "/tf tool0", "/transform", "/wrench"]);
        assert!(found.files.iter().all(|file| file.rows == 5));
        let of = |file: usize| found.columns.iter().filter(|c| c.file == file).count();
        assert_eq!([0, 1, 2, 3, 4, 5].map(of), [4, 8, 8, 8, 8, 7]);
    }
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
        let _ = propose(std::slice::from_ref(&path), None, Stated::default());
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
    let error = propose(&[path], None, Stated::default()).map(drop).expect_err("it is damaged");
    assert!(error.message().contains("cannot be read as Parquet"), "{error}");
}
