//! MCAP recordings of ROS 2: chunks of messages, packed or not.

use super::blocks::damaged;
use super::format::FormatReader;
use super::ros::{Message, RecordedMessage, RosRecording, open_topic, topics};
use super::rows::ROW_FILE_BYTES_MAX;
use lz4_flex::frame::FrameDecoder;
use mcap::records::{ChunkHeader, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ruzstd::decoding::StreamingDecoder;
use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::Path;
use trueweld_plant::input::file::InputReader;
use trueweld_plant::input::{InputError, open};

/// How its files are read.
pub(super) const MCAP: FormatReader = FormatReader {
    open: |entry| open_topic(&|| Bag::open(&entry.path), entry.topic.as_deref()),
    topics: Some(|path| topics(Bag::open(path)?)),
};

/// Most bytes of one record, a chunk of messages, packed and unpacked: writers make them of some
/// megabytes.
const MOST_RECORD: usize = 64 << 20;

/// What is said of a file that cannot be read.
const MCAP_HELP: &str =
    "Is it a recording of ROS 2, and was it closed? `mcap recover FILE` mends one that was not.";

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
        })
    }
}

impl RosRecording for Bag {
    fn name(&self) -> &str {
        &self.name
    }

    fn next(
        &mut self,
        wanted: &dyn Fn(&str) -> bool,
    ) -> Result<Option<RecordedMessage>, InputError> {
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
                    let (topic, message) = (topic.clone(), *message);
                    return Ok(Some(RecordedMessage { topic, message, data: data.into_owned() }));
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
        "zstd" => {
            let decoder = StreamingDecoder::new(data).map_err(io::Error::other)?;
            decoder.take(most).read_to_end(&mut records)?;
        }
        "lz4" => {
            FrameDecoder::new(data).take(most).read_to_end(&mut records)?;
        }
        other => return Err(io::Error::other(format!("it is packed by {other:?}"))),
    }
    if records.len() as u64 == most || records.len() as u64 != header.uncompressed_size {
        let sizes = format!("{} bytes of {}", records.len(), header.uncompressed_size);
        return Err(io::Error::other(sizes));
    }
    // 0: the writer stated none.
    if ![0, crc32fast::hash(&records)].contains(&header.uncompressed_crc) {
        return Err(io::Error::other("its bytes are not those of its checksum"));
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
