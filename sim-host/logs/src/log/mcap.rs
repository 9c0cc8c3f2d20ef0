//! MCAP recordings of ROS 2: one topic of joint states, wrenches or poses, with the stamps of the
//! messages' headers.
//!
//! | message | columns |
//! |---|---|
//! | `sensor_msgs/msg/JointState` | `time`, `position NAME`, `velocity NAME`, `options NAME` |
//! | `geometry_msgs/msg/WrenchStamped` | `time`, `force.x` …, `torque.x` … |
//! | `geometry_msgs/msg/PoseStamped` | `time`, `position.x` …, `orientation.x` … `orientation.w` |
//!
//! Messages are in CDR, as ROS 2 writes them. Left out: other messages and encodings.

use super::blocks::{BlockRows, Blocks, damaged};
use super::format::FormatReader;
use super::rows::{MOST_COLUMNS, ROW_FILE_BYTES_MAX, RowSource};
use mcap::records::{ChunkHeader, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::Path;
use trueweld_plant::input::file::InputReader;
use trueweld_plant::input::{InputError, open};

/// A message's topic, its kind, and its values by name.
type Published = (String, Message, Vec<(String, f64)>);

/// How its files are read.
pub(super) const MCAP: FormatReader = FormatReader {
    open: |entry| open_mcap(&entry.path, entry.topic.as_deref()),
    topics: Some(topics),
};

/// Most bytes of one record, a chunk of messages, packed and unpacked: writers make them of some
/// megabytes.
const MOST_RECORD: usize = 64 << 20;

/// Rows in a block.
const MCAP_BLOCK_ROWS: usize = 4096;

/// What is said of a file that cannot be read.
const MCAP_HELP: &str =
    "Is it a recording of ROS 2, and was it closed? `mcap recover FILE` mends one that was not.";

/// A message that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Message {
    JointState,
    Wrench,
    Pose,
}

impl Message {
    fn of(schema: &str) -> Option<Self> {
        match schema.replace("/msg/", "/").as_str() {
            "sensor_msgs/JointState" => Some(Self::JointState),
            "geometry_msgs/WrenchStamped" => Some(Self::Wrench),
            "geometry_msgs/PoseStamped" => Some(Self::Pose),
            _ => None,
        }
    }

    /// Time and values of a message, each with its name; `None` where it ends too early.
    fn decode(self, data: &[u8]) -> Option<Vec<(String, f64)>> {
        let mut cdr = Cdr::new(data)?;
        let (seconds, nanoseconds) = (cdr.u32()? as i32, cdr.u32()?);
        cdr.text()?;
        let time = f64::from(seconds) + 1e-9 * f64::from(nanoseconds);
        let mut values = vec![("time".to_owned(), time)];
        match self {
            Self::JointState => {
                let count = cdr.u32()? as usize;
                if count > MOST_COLUMNS {
                    return None;
                }
                let names: Vec<String> = (0..count).map(|_| cdr.text()).collect::<Option<_>>()?;
                for what in ["position", "velocity", "effort"] {
                    let count = cdr.u32()? as usize;
                    if count > names.len() {
                        return None;
                    }
                    for name in names.iter().take(count) {
                        values.push((format!("{what} {name}"), cdr.f64()?));
                    }
                }
            }
            Self::Wrench => {
                for name in ["force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"] {
                    values.push((name.to_owned(), cdr.f64()?));
                }
            }
            Self::Pose => {
                let position = ["position.x", "position.y", "position.z"];
                let turn = ["orientation.x", "orientation.y", "orientation.z", "orientation.w"];
                for name in position.into_iter().chain(turn) {
                    values.push((name.to_owned(), cdr.f64()?));
                }
            }
        }
        Some(values)
    }
}

/// Reads CDR: numbers stand at multiples of their size behind a header of four bytes.
struct Cdr<'d> {
    data: &'d [u8],
    at: usize,
    little: bool,
}

impl<'d> Cdr<'d> {
    fn new(data: &'d [u8]) -> Option<Self> {
        let little = data.get(1)? & 1 == 1;
        Some(Self { data: data.get(4..)?, at: 0, little })
    }

    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let start = self.at.next_multiple_of(N);
        let bytes: [u8; N] = self.data.get(start..start + N)?.try_into().ok()?;
        self.at = start + N;
        Some(bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        let bytes = self.bytes()?;
        Some(if self.little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    fn f64(&mut self) -> Option<f64> {
        let bytes = self.bytes()?;
        Some(if self.little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) })
    }

    fn text(&mut self) -> Option<String> {
        let length = self.u32()? as usize;
        let text = self.data.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        Some(String::from_utf8_lossy(text.strip_suffix(b"\0").unwrap_or(text)).into_owned())
    }
}

/// A recording that is read from its beginning.
struct Bag {
    name: String,
    input: InputReader,
    reader: LinearReader,
    /// The chunk that is being read, unpacked, and how far.
    chunk: Vec<u8>,
    at: usize,
    schemas: BTreeMap<u16, String>,
    /// Topics of channels, with what is in them.
    channels: BTreeMap<u16, (String, Option<Message>)>,
    topic: String,
    message: Message,
    names: Vec<String>,
    pending: Option<Vec<f64>>,
}

impl Bag {
    fn open(path: &Path) -> Result<Self, InputError> {
        let options = LinearReaderOptions::default()
            .with_record_length_limit(MOST_RECORD)
            // The crate unpacks damaged chunks for ever.
            .with_emit_chunks(true);
        Ok(Self {
            name: path.display().to_string(),
            input: open(path, ROW_FILE_BYTES_MAX)?,
            reader: LinearReader::new_with_options(options),
            chunk: Vec::new(),
            at: 0,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            topic: String::new(),
            message: Message::Pose,
            names: Vec::new(),
            pending: None,
        })
    }

    /// The next message of a topic that is wanted, with its topic; nothing at the end.
    fn next_message(
        &mut self,
        wanted: &dyn Fn(&str) -> bool,
    ) -> Result<Option<Published>, InputError> {
        loop {
            let unpacked = self.at < self.chunk.len();
            let (data, opcode) = if unpacked {
                let Some((opcode, data)) = record_at(&self.chunk, &mut self.at) else {
                    let message = "a chunk of messages ends within one";
                    return Err(damaged(&self.name, message, MCAP_HELP));
                };
                (data, opcode)
            } else {
                match self.reader.next_event() {
                    None => return Ok(None),
                    Some(Err(error)) => {
                        let message = format!("cannot be read as MCAP: {error}");
                        return Err(damaged(&self.name, message, MCAP_HELP));
                    }
                    Some(Ok(LinearReadEvent::ReadRequest(need))) => {
                        let buffer = self.reader.insert(need.min(MOST_RECORD));
                        let read = self.input.read(buffer).map_err(|error| {
                            damaged(&self.name, format!("cannot be read: {error}"), MCAP_HELP)
                        })?;
                        self.reader.notify_read(read);
                        continue;
                    }
                    Some(Ok(LinearReadEvent::Record { data, opcode })) => (data, opcode),
                }
            };
            let record = mcap::parse_record(opcode, data).map_err(|error| {
                damaged(&self.name, format!("cannot be read as MCAP: {error}"), MCAP_HELP)
            })?;
            match record {
                Record::Chunk { header, data } if !unpacked => {
                    let chunk = unpack(&header, &data).map_err(|error| {
                        let message = format!("a chunk of messages cannot be unpacked: {error}");
                        damaged(&self.name, message, MCAP_HELP)
                    })?;
                    (self.chunk, self.at) = (chunk, 0);
                }
                Record::Schema { header, .. } => {
                    self.schemas.insert(header.id, header.name);
                }
                Record::Channel(channel) => {
                    let schema = self.schemas.get(&channel.schema_id);
                    let of_ros = channel.message_encoding == "cdr";
                    let message = schema.and_then(|s| Message::of(s)).filter(|_| of_ros);
                    self.channels.insert(channel.id, (channel.topic, message));
                }
                Record::Message { header, data } => {
                    let Some((topic, Some(message))) = self.channels.get(&header.channel_id) else {
                        continue;
                    };
                    if !wanted(topic) {
                        continue;
                    }
                    let Some(values) = message.decode(&data) else {
                        let text = format!("a message of {topic} ends too early");
                        return Err(damaged(&self.name, text, MCAP_HELP));
                    };
                    return Ok(Some((topic.clone(), *message, values)));
                }
                _ => {}
            }
        }
    }
}

/// The records of a chunk.
fn unpack(header: &ChunkHeader, data: &[u8]) -> io::Result<Vec<u8>> {
    let most = MOST_RECORD as u64;
    let mut records = Vec::new();
    match header.compression.as_str() {
        "" => records.extend_from_slice(data),
        "zstd" => drop(zstd::Decoder::new(data)?.take(most).read_to_end(&mut records)?),
        "lz4" => drop(lz4::Decoder::new(data)?.take(most).read_to_end(&mut records)?),
        other => return Err(io::Error::other(format!("it is packed by {other:?}"))),
    }
    if records.len() as u64 == most || records.len() as u64 != header.uncompressed_size {
        let sizes = format!("{} bytes of {}", records.len(), header.uncompressed_size);
        return Err(io::Error::other(sizes));
    }
    Ok(records)
}

/// The record at a place of a chunk: its code and its bytes. Moves on behind it.
fn record_at<'c>(chunk: &'c [u8], at: &mut usize) -> Option<(u8, &'c [u8])> {
    let (code, rest) = chunk.get(*at..)?.split_first()?;
    let (length, rest) = rest.split_first_chunk()?;
    let data = rest.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    *at += 9 + data.len();
    Some((*code, data))
}

/// Topics of a recording that can be read.
fn topics(path: &Path) -> Result<Vec<String>, InputError> {
    let mut bag = Bag::open(path)?;
    // Every message is passed over, so that channels that begin late are seen too.
    while bag.next_message(&|_| false)?.is_some() {}
    let mut topics: Vec<String> =
        bag.channels.into_values().filter(|(_, m)| m.is_some()).map(|(topic, _)| topic).collect();
    topics.sort();
    topics.dedup();
    Ok(topics)
}

/// Opens one topic of a recording.
fn open_mcap(path: &Path, topic: Option<&str>) -> Result<Box<dyn RowSource>, InputError> {
    let mut bag = Bag::open(path)?;
    let name = bag.name.clone();
    let Some(topic) = topic.map(str::to_owned) else {
        let all = topics(path)?;
        return match all.as_slice() {
            [one] => open_mcap(path, Some(one)),
            _ => {
                let list: Vec<String> = all.iter().map(|t| format!("{t:?}")).collect();
                let message = format!(
                    "holds {} topics of joint states, wrenches or poses; expected `topic` in its entry of `files`",
                    all.len()
                );
                let help = format!("Name one: {}. Each is an entry of its own.", list.join(", "));
                Err(damaged(&name, message, &help))
            }
        };
    };
    let Some((_, message, values)) = bag.next_message(&|t| t == topic)? else {
        let message = format!("has no message of the topic {topic:?}; expected some");
        let list = topics(path)?.join(", ");
        return Err(damaged(&name, message, &format!("Topics that can be read: {list}.")));
    };
    let (names, first): (Vec<String>, Vec<f64>) = values.into_iter().unzip();
    (bag.topic, bag.message, bag.names) = (topic, message, names.clone());
    bag.pending = Some(first);
    Ok(Box::new(BlockRows::new(name, names, bag)))
}

impl Blocks for Bag {
    fn next(&mut self) -> Result<Option<Vec<Vec<f64>>>, InputError> {
        let mut block: Vec<Vec<f64>> = vec![Vec::new(); self.names.len()];
        let topic = self.topic.clone();
        let mut rows = 0;
        while rows < MCAP_BLOCK_ROWS {
            let row = match self.pending.take() {
                Some(row) => row,
                None => {
                    let Some((_, _, values)) = self.next_message(&|t| t == topic)? else {
                        break;
                    };
                    // By name: messages need not hold the joints in one order.
                    let of = |(place, name): (usize, &String)| match values.get(place) {
                        Some((n, value)) if n == name => *value,
                        _ => values.iter().find(|(n, _)| n == name).map_or(f64::NAN, |(_, v)| *v),
                    };
                    self.names.iter().enumerate().map(of).collect()
                }
            };
            block.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            rows += 1;
        }
        Ok((rows > 0).then_some(block))
    }
}
