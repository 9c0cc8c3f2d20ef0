//! Messages of ROS 2, whatever they were recorded in: one topic of them as rows, with the stamps of
//! the messages' headers.
//!
//! | message | columns |
//! |---|---|
//! | `sensor_msgs/msg/JointState` | `time`, `position NAME`, `velocity NAME`, `effort NAME` |
//! | `geometry_msgs/msg/WrenchStamped` | `time`, `force.x` …, `torque.x` … |
//! | `geometry_msgs/msg/PointStamped` | `time`, `position.x` … |
//! | `geometry_msgs/msg/PoseStamped` | `time`, `position.x` …, `orientation.x` … `orientation.w` |
//! | `geometry_msgs/msg/TransformStamped` | as of a pose |
//! | `tf2_msgs/msg/TFMessage` | as of a pose; each frame is a topic of its own, `/tf FRAME` |
//!
//! Messages are in CDR, as ROS 2 writes them. Left out: other messages and encodings.

use super::blocks::{BlockRows, Blocks, damaged};
use super::rows::{MOST_COLUMNS, RowSource};
use std::collections::{BTreeSet, VecDeque};
use trueweld_plant::input::InputError;

/// Rows in a block.
const TOPIC_BLOCK_ROWS: usize = 4096;

/// Values of a message by their names.
type NamedValues = Vec<(String, f64)>;

/// A message that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Message {
    JointState,
    Wrench,
    Point,
    Pose,
    Transform,
    Transforms,
}

/// A message as it was recorded.
pub(super) struct RecordedMessage {
    pub topic: String,
    pub message: Message,
    pub data: Vec<u8>,
}

/// A recording that is read from its beginning.
pub(super) trait RosRecording {
    /// What errors call it.
    fn name(&self) -> &str;

    /// The next message that can be read of a topic that is wanted; nothing at the end.
    ///
    /// # Errors
    /// What is wrong with the file.
    fn next(
        &mut self,
        wanted: &dyn Fn(&str) -> bool,
    ) -> Result<Option<RecordedMessage>, InputError>;
}

impl Message {
    /// By the name of its type.
    pub(super) fn of(kind: &str) -> Option<Self> {
        match kind.replace("/msg/", "/").as_str() {
            "sensor_msgs/JointState" => Some(Self::JointState),
            "geometry_msgs/WrenchStamped" => Some(Self::Wrench),
            "geometry_msgs/PointStamped" => Some(Self::Point),
            "geometry_msgs/PoseStamped" => Some(Self::Pose),
            "geometry_msgs/TransformStamped" => Some(Self::Transform),
            "tf2_msgs/TFMessage" => Some(Self::Transforms),
            _ => None,
        }
    }

    /// Time and values of a message, and the frame that they are of where it holds several; `None`
    /// where it ends too early.
    fn decode(self, data: &[u8]) -> Option<Vec<(Option<String>, NamedValues)>> {
        let mut cdr = Cdr::new(data)?;
        if self != Self::Transforms {
            return Some(vec![(None, self.values(&mut cdr)?.1)]);
        }
        let count = cdr.u32()? as usize;
        if count > MOST_COLUMNS {
            return None;
        }
        let mut all = Vec::new();
        for _ in 0..count {
            let (frame, values) = Self::Transform.values(&mut cdr)?;
            all.push((Some(frame), values));
        }
        Some(all)
    }

    /// What stands behind a header, and the frame that it is of.
    fn values(self, cdr: &mut Cdr<'_>) -> Option<(String, NamedValues)> {
        let (seconds, nanoseconds) = (cdr.u32()? as i32, cdr.u32()?);
        let mut frame = cdr.text()?;
        let time = f64::from(seconds) + 1e-9 * f64::from(nanoseconds);
        let mut values = vec![("time".to_owned(), time)];
        let mut numbers = |cdr: &mut Cdr<'_>, what: &str, letters: &str| {
            for letter in letters.chars() {
                values.push((format!("{what}.{letter}"), cdr.f64()?));
            }
            Some(())
        };
        match self {
            Self::JointState => joint_state(cdr, &mut values)?,
            Self::Wrench => {
                numbers(cdr, "force", "xyz")?;
                numbers(cdr, "torque", "xyz")?;
            }
            Self::Point => numbers(cdr, "position", "xyz")?,
            Self::Pose | Self::Transform | Self::Transforms => {
                if self != Self::Pose {
                    frame = cdr.text()?;
                }
                numbers(cdr, "position", "xyz")?;
                numbers(cdr, "orientation", "xyzw")?;
            }
        }
        Some((frame, values))
    }
}

fn joint_state(cdr: &mut Cdr<'_>, values: &mut NamedValues) -> Option<()> {
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
    Some(())
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

/// The values of a message, with the topic of each.
fn published(of: &RecordedMessage, file: &str) -> Result<Vec<(String, NamedValues)>, InputError> {
    let RecordedMessage { topic, message, data } = of;
    let Some(all) = message.decode(data) else {
        let help =
            "Was it recorded by ROS 2? Bags of ROS 1 that were converted may hold its encoding.";
        return Err(damaged(file, format!("a message of {topic} ends too early"), help));
    };
    let named = |(frame, values): (Option<String>, NamedValues)| match frame {
        Some(frame) => (format!("{topic} {frame}"), values),
        None => (topic.clone(), values),
    };
    Ok(all.into_iter().map(named).collect())
}

/// Topics of a recording that can be read.
pub(super) fn topics(mut recording: impl RosRecording) -> Result<Vec<String>, InputError> {
    let mut topics = BTreeSet::new();
    // To the end: topics that begin late are seen too.
    while let Some(recorded) = recording.next(&|_| true)? {
        if recorded.message != Message::Transforms {
            topics.insert(recorded.topic);
            continue;
        }
        let frames = published(&recorded, recording.name())?;
        topics.extend(frames.into_iter().map(|(topic, _)| topic));
    }
    Ok(topics.into_iter().collect())
}

/// Opens one topic of a recording; `None` for the only one.
pub(super) fn open_topic<R: RosRecording + 'static>(
    open: &dyn Fn() -> Result<R, InputError>,
    topic: Option<&str>,
) -> Result<Box<dyn RowSource>, InputError> {
    let recording = open()?;
    let name = recording.name().to_owned();
    let Some(topic) = topic.map(str::to_owned) else {
        let all = topics(recording)?;
        return match all.as_slice() {
            [one] => open_topic(open, Some(one)),
            _ => {
                let list: Vec<String> = all.iter().map(|t| format!("{t:?}")).collect();
                let message = format!(
                    "holds {} topics of joint states, wrenches, points or poses; expected `topic` in its entry of `files`",
                    all.len()
                );
                let help = format!("Name one: {}. Each is an entry of its own.", list.join(", "));
                Err(damaged(&name, message, &help))
            }
        };
    };
    let mut rows = TopicRows { recording, topic, names: Vec::new(), pending: VecDeque::new() };
    rows.fill(NAMING_MESSAGES)?;
    if rows.pending.is_empty() {
        let message = format!("has no message of the topic {:?}; expected some", rows.topic);
        let list = topics(open()?)?.join(", ");
        return Err(damaged(&name, message, &format!("Topics that can be read: {list}.")));
    }
    for (name, _) in rows.pending.iter().flatten() {
        if !rows.names.contains(name) {
            rows.names.push(name.clone());
        }
    }
    Ok(Box::new(BlockRows::new(name, rows.names.clone(), rows)))
}

/// Messages by which the columns of a topic are named: an arm and its gripper may share one, and take
/// turns.
const NAMING_MESSAGES: usize = 100;

/// The messages of one topic.
struct TopicRows<R> {
    recording: R,
    topic: String,
    names: Vec<String>,
    pending: VecDeque<NamedValues>,
}

impl<R: RosRecording> TopicRows<R> {
    /// Reads on until so many messages are pending, or the recording ends.
    fn fill(&mut self, messages: usize) -> Result<(), InputError> {
        // A frame stands behind its topic, whose name has no blank.
        let whole = self.topic.split(' ').next().unwrap_or_default().to_owned();
        while self.pending.len() < messages {
            let Some(recorded) = self.recording.next(&|topic| topic == whole)? else { break };
            let all = published(&recorded, self.recording.name())?;
            let own = all.into_iter().filter(|(topic, _)| *topic == self.topic);
            self.pending.extend(own.map(|(_, values)| values));
        }
        Ok(())
    }
}

impl<R: RosRecording> Blocks for TopicRows<R> {
    fn next(&mut self) -> Result<Option<Vec<Vec<f64>>>, InputError> {
        let mut block: Vec<Vec<f64>> = vec![Vec::new(); self.names.len()];
        let mut rows = 0;
        while rows < TOPIC_BLOCK_ROWS {
            self.fill(1)?;
            let Some(values) = self.pending.pop_front() else { break };
            // By name: messages need not hold the joints in one order.
            let of = |(place, name): (usize, &String)| match values.get(place) {
                Some((n, value)) if n == name => *value,
                _ => values.iter().find(|(n, _)| n == name).map_or(f64::NAN, |(_, v)| *v),
            };
            let row: Vec<f64> = self.names.iter().enumerate().map(of).collect();
            block.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            rows += 1;
        }
        Ok((rows > 0).then_some(block))
    }
}
