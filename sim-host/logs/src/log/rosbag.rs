//! Bags of ROS 2 in SQLite (`*.db3`): a table of topics, and one of their messages.

use super::blocks::damaged;
use super::files::FileEntry;
use super::format::FormatReader;
use super::ros::{Message, RecordedMessage, RosRecording, open_topic, topics};
use super::rows::{ROW_FILE_BYTES_MAX, RowSource};
use rusqlite::{Connection, OpenFlags, Row};
use std::collections::VecDeque;
use std::path::Path;
use trueweld_plant::input::{InputError, open};

/// How its files are read.
pub(super) const ROSBAG: FormatReader =
    FormatReader { open: open_bag, topics: Some(|path| topics(Database::open(path)?)) };

/// What is said of a file that cannot be read.
const ROSBAG_HELP: &str = "Is it a bag of ROS 2, and was it closed? `ros2 bag reindex` mends one that was not, \
                           `ros2 bag convert` writes it as MCAP.";

/// Messages that are fetched at a time.
const FETCHED_MESSAGES: usize = 256;

/// Most bytes of one message: they are of some hundred.
const MESSAGE_BYTES_MAX: usize = 1 << 20;

fn open_bag(entry: &FileEntry) -> Result<Box<dyn RowSource>, InputError> {
    open_topic(&|| Database::open(&entry.path), entry.topic.as_deref())
}

/// A bag that is read in the order in which its messages were written.
struct Database {
    name: String,
    connection: Connection,
    /// Topics that can be read: number, name, and what is in them.
    topics: Vec<(i64, String, Message)>,
    /// The last message that was fetched.
    last: i64,
    fetched: VecDeque<(i64, Vec<u8>)>,
}

impl Database {
    fn open(path: &Path) -> Result<Self, InputError> {
        let name = path.display().to_string();
        // Refuses what is no file, or longer than a recording may be.
        drop(open(path, ROW_FILE_BYTES_MAX)?);
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags).map_err(|e| failed(&name, &e))?;
        let topics = readable_topics(&connection).map_err(|e| failed(&name, &e))?;
        let fetched = VecDeque::new();
        Ok(Self { name, connection, topics, last: i64::MIN, fetched })
    }

    /// Fetches the next messages of the topics with these numbers.
    fn fetch(&mut self, topics: &[i64]) -> rusqlite::Result<()> {
        let list: Vec<String> = topics.iter().map(i64::to_string).collect();
        let mut query = self.connection.prepare_cached(&format!(
            "SELECT id, topic_id, data FROM messages WHERE id > ?1 AND topic_id IN ({}) \
             AND length(data) <= {MESSAGE_BYTES_MAX} ORDER BY id LIMIT {FETCHED_MESSAGES}",
            list.join(",")
        ))?;
        let of = |row: &Row<'_>| Ok((row.get::<_, i64>(0)?, row.get(1)?, row.get(2)?));
        for row in query.query_map([self.last], of)? {
            let (id, topic, data) = row?;
            if id <= self.last {
                // Of a damaged index: it would be read for ever.
                return Err(rusqlite::Error::IntegralValueOutOfRange(0, id));
            }
            self.last = id;
            self.fetched.push_back((topic, data));
        }
        Ok(())
    }
}

fn failed(name: &str, error: &rusqlite::Error) -> InputError {
    damaged(name, format!("cannot be read as a bag of ROS 2: {error}"), ROSBAG_HELP)
}

fn readable_topics(connection: &Connection) -> rusqlite::Result<Vec<(i64, String, Message)>> {
    let mut query = connection
        .prepare("SELECT id, name, type FROM topics WHERE serialization_format = 'cdr'")?;
    let of = |row: &Row<'_>| Ok((row.get(0)?, row.get(1)?, row.get::<_, String>(2)?));
    let mut topics = Vec::new();
    for row in query.query_map([], of)? {
        let (id, name, kind) = row?;
        topics.extend(Message::of(&kind).map(|message| (id, name, message)));
    }
    Ok(topics)
}

impl RosRecording for Database {
    fn name(&self) -> &str {
        &self.name
    }

    fn next(
        &mut self,
        wanted: &dyn Fn(&str) -> bool,
    ) -> Result<Option<RecordedMessage>, InputError> {
        let numbers: Vec<i64> =
            self.topics.iter().filter(|(_, name, _)| wanted(name)).map(|(id, ..)| *id).collect();
        if self.fetched.is_empty() {
            self.fetch(&numbers).map_err(|e| failed(&self.name, &e))?;
        }
        let Some((number, data)) = self.fetched.pop_front() else { return Ok(None) };
        let of = self.topics.iter().find(|(id, ..)| *id == number);
        Ok(of.map(|(_, topic, message)| RecordedMessage {
            topic: topic.clone(),
            message: *message,
            data,
        }))
    }
}
