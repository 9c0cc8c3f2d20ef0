//! What the words of a header mean, by the table of known names in `names.csv`.
//!
//! A header is read whole: one word that is not in the table, and it says nothing. A name that only
//! looks like that of a channel is thus none.

use crate::log::units::{Dimension, Unit, unit_named};
use std::sync::LazyLock;
use trueweld_core::JOINTS;

/// What a word of a header names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NamedQuantity {
    Time,
    /// Counts of a clock.
    Counter,
    /// An axis, and nothing of it: its angle.
    Joint,
    Encoder,
    /// A second encoder on the link.
    Link,
    /// Outside of something: an encoder on the link, else no channel.
    External,
    /// A drive's torque, or a moment at the tool.
    Torque,
    Moment,
    /// A drive's current; beside an angle, its present value.
    Current,
    Force,
    /// Forces and moments.
    Wrench,
    /// Of an axis its angle, of the tool its position.
    Place,
    Angle,
    Point,
    /// Position and orientation.
    Pose,
    /// A rotation vector.
    Rotation,
    Quaternion,
    Reflector,
    Spindle,
    Speed,
    Payload,
}

/// How near to the instrument a value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) enum ReadingRole {
    /// Nothing is said.
    #[default]
    Plain,
    /// What the controller has as the actual value.
    Actual,
    /// Measured.
    Measured,
}

/// Why what a header names is no channel, worst last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum NoChannel {
    Other(&'static str),
    Limit,
    Computed,
    Commanded,
}

/// What the whole of a header says.
#[derive(Debug, Clone, Default)]
pub(super) struct HeaderReading {
    pub quantities: Vec<NamedQuantity>,
    pub role: ReadingRole,
    pub no_channel: Option<NoChannel>,
    /// 0 to 2 of x, y, z; 3 of the w of a quaternion.
    pub component: Option<usize>,
    pub number: Option<usize>,
    /// A joint by its name in the robot file, from 0.
    pub joint: Option<usize>,
    /// Sets of names that a word is one of, and which, from 0.
    pub sets: Vec<(&'static str, usize)>,
    /// The words without what counts: the same for all columns of a family.
    pub family: String,
    /// The unit that stands in the header.
    pub unit: Option<&'static Unit>,
}

impl HeaderReading {
    pub(super) fn has(&self, quantity: NamedQuantity) -> bool {
        self.quantities.contains(&quantity)
    }

    /// True where nothing else is named than some of these.
    pub(super) fn only(&self, of: &[NamedQuantity]) -> bool {
        self.quantities.iter().all(|quantity| of.contains(quantity))
    }

    /// True where a unit may be one of what is named.
    fn takes(&self, unit: &Unit) -> bool {
        use NamedQuantity::{
            Counter, Current, Force, Moment, Payload, Spindle, Time, Torque, Wrench,
        };
        let any = |of: &[NamedQuantity]| of.iter().any(|quantity| self.has(*quantity));
        let Some(dimension) = unit.dimension else {
            return any(&[Current, Torque, Moment, Force]);
        };
        let clock = any(&[Time, Counter]);
        let load = any(&[Torque, Moment, Force, Wrench, Current]);
        match dimension {
            Dimension::Time => clock,
            Dimension::Force => any(&[Force, Wrench]),
            Dimension::Torque => any(&[Torque, Moment, Wrench]),
            Dimension::Mass => any(&[Payload]),
            Dimension::AngularSpeed => any(&[Spindle]),
            Dimension::Angle => !clock && !load,
            Dimension::Length => self.component.is_some() && !clock && !load,
            Dimension::Number => false,
        }
    }
}

/// What one entry of the table means.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Meaning {
    Quantity(NamedQuantity),
    Role(ReadingRole),
    NoChannel(NoChannel),
    Component(usize),
    Set(&'static str, usize),
    Silent,
}

/// A word, a number or any component, as a pattern or in a header.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Token {
    Word(String),
    Number(usize),
}

struct HeaderWord {
    pattern: Vec<&'static str>,
    meanings: Vec<Meaning>,
}

/// The table; a line that begins with `#` is a comment, the first of the others the header.
static HEADER_WORDS: LazyLock<Vec<HeaderWord>> = LazyLock::new(|| {
    let lines = include_str!("names.csv").lines().filter(|line| !line.starts_with('#')).skip(1);
    let entry = |line: &'static str| {
        let mut fields = line.split(',');
        let pattern = fields.next()?.split(' ').collect();
        Some(HeaderWord { pattern, meanings: meanings(fields.next()?)? })
    };
    lines.filter_map(entry).collect()
});

/// Sets of names that the table holds, with how many each has.
pub(super) static SETS: LazyLock<Vec<(&'static str, usize)>> = LazyLock::new(|| {
    let mut sets: Vec<(&'static str, usize)> = Vec::new();
    for meaning in HEADER_WORDS.iter().flat_map(|entry| &entry.meanings) {
        let Meaning::Set(name, place) = meaning else { continue };
        match sets.iter_mut().find(|(known, _)| known == name) {
            Some((_, count)) => *count = (*count).max(place + 1),
            None => sets.push((name, place + 1)),
        }
    }
    sets
});

fn meanings(text: &'static str) -> Option<Vec<Meaning>> {
    use NamedQuantity as Q;
    if let Some(what) = text.strip_prefix("no ") {
        return Some(vec![Meaning::NoChannel(NoChannel::Other(what))]);
    }
    let mut words = text.split(' ');
    let mut all = Vec::new();
    while let Some(word) = words.next() {
        let quantity = Meaning::Quantity;
        all.push(match word {
            "time" => quantity(Q::Time),
            "counter" => quantity(Q::Counter),
            "joint" => quantity(Q::Joint),
            "encoder" => quantity(Q::Encoder),
            "link" => quantity(Q::Link),
            "external" => quantity(Q::External),
            "torque" => quantity(Q::Torque),
            "moment" => quantity(Q::Moment),
            "current" => quantity(Q::Current),
            "force" => quantity(Q::Force),
            "wrench" => quantity(Q::Wrench),
            "place" => quantity(Q::Place),
            "angle" => quantity(Q::Angle),
            "point" => quantity(Q::Point),
            "pose" => quantity(Q::Pose),
            "rotation" => quantity(Q::Rotation),
            "quaternion" => quantity(Q::Quaternion),
            "reflector" => quantity(Q::Reflector),
            "spindle" => quantity(Q::Spindle),
            "speed" => quantity(Q::Speed),
            "payload" => quantity(Q::Payload),
            "actual" => Meaning::Role(ReadingRole::Actual),
            "measured" => Meaning::Role(ReadingRole::Measured),
            "commanded" => Meaning::NoChannel(NoChannel::Commanded),
            "computed" => Meaning::NoChannel(NoChannel::Computed),
            "limit" => Meaning::NoChannel(NoChannel::Limit),
            "silent" => Meaning::Silent,
            "set" => {
                let (name, place) = (words.next()?, words.next()?.parse::<usize>().ok()?);
                Meaning::Set(name, place.checked_sub(1)?)
            }
            component => Meaning::Component(component_named(component)?),
        });
    }
    Some(all)
}

/// Place of a component: x, y, z, w.
fn component_named(word: &str) -> Option<usize> {
    ["x", "y", "z", "w"].iter().position(|name| *name == word)
}

/// What a header says; `None` where a word of it is not known. `joints`: names in the robot file.
pub(super) fn read(header: &str, joints: &[String]) -> Option<HeaderReading> {
    let (bare, unit) = without_unit(header);
    let tokens = tokens(&bare);
    let joints: Vec<Vec<Token>> = joints.iter().map(|name| self::tokens(name)).collect();
    // A last word that is a unit of what the others name: `px_mm`, `force N`.
    if unit.is_none()
        && let Some((Token::Word(last), others)) = tokens.split_last()
        && !others.is_empty()
        && let Some(unit) = unit_named(last)
        && let Some(mut reading) = whole(others, &joints)
        && (reading.takes(unit) || reading.no_channel.is_some())
    {
        reading.unit = Some(unit);
        return Some(reading);
    }
    let mut reading = whole(&tokens, &joints)?;
    reading.unit = unit;
    Some(reading)
}

/// A header without the unit in its brackets. Digits in brackets are an index.
fn without_unit(header: &str) -> (String, Option<&'static Unit>) {
    for (open, close) in [('[', ']'), ('(', ')'), ('<', '>')] {
        let Some((a, b)) = header.find(open).zip(header.rfind(close)).filter(|(a, b)| a < b) else {
            continue;
        };
        let inside = header[a + 1..b].trim();
        let index = !inside.is_empty() && inside.bytes().all(|byte| byte.is_ascii_digit());
        if let Some(unit) = unit_named(inside).filter(|_| !index) {
            return (format!("{} {}", &header[..a], &header[b + 1..]), Some(unit));
        }
    }
    (header.to_owned(), None)
}

/// Words in small letters and numbers: parted at blanks, marks, capitals and digits.
fn tokens(header: &str) -> Vec<Token> {
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for c in header.chars() {
        let starts = !last.is_alphanumeric()
            || (c.is_uppercase() && last.is_lowercase())
            || (c.is_ascii_digit() != last.is_ascii_digit());
        if c.is_alphanumeric() {
            match words.last_mut() {
                Some(word) if !starts => word.extend(c.to_lowercase()),
                _ => words.push(c.to_lowercase().collect()),
            }
        }
        last = c;
    }
    let token = |word: String| match word.parse() {
        Ok(number) => Token::Number(number),
        Err(_) => Token::Word(word),
    };
    words.into_iter().flat_map(parts).map(token).collect()
}

/// The parts of a word that is not in the table: a letter and its component (`fx`), or words that
/// are written as one (`istposition`). A word that has none is itself.
fn parts(word: String) -> Vec<String> {
    let known = |word: &str| HEADER_WORDS.iter().any(|entry| entry.pattern == [word]);
    if known(&word) {
        return vec![word];
    }
    let letters: Vec<char> = word.chars().collect();
    if let [letter, component] = letters[..]
        && component_named(&component.to_string()).is_some()
        && HEADER_WORDS.iter().any(|entry| entry.pattern == [letter.to_string().as_str(), "*"])
    {
        return vec![letter.to_string(), component.to_string()];
    }
    /// Parts are at least so long: shorter ones stand in any word.
    const WORD_PART_LENGTH_MIN: usize = 3;
    for (at, _) in word.char_indices().skip(WORD_PART_LENGTH_MIN) {
        let (first, rest) = word.split_at(at);
        if rest.chars().count() < WORD_PART_LENGTH_MIN || !known(first) {
            continue;
        }
        let rest = parts(rest.to_owned());
        if rest.iter().all(|part| known(part)) {
            return std::iter::once(first.to_owned()).chain(rest).collect();
        }
    }
    vec![word]
}

/// Reads every token, by the longest entry of the table that begins at each.
fn whole(tokens: &[Token], joints: &[Vec<Token>]) -> Option<HeaderReading> {
    let mut reading = HeaderReading::default();
    let mut at = 0;
    while at < tokens.len() {
        let rest = &tokens[at..];
        let named = joints
            .iter()
            .enumerate()
            .filter(|(_, name)| !name.is_empty() && rest.starts_with(name));
        if let Some((joint, name)) = named.max_by_key(|(_, name)| name.len()) {
            if reading.joint.replace(joint).is_some() {
                return None;
            }
            reading.family += "@ ";
            at += name.len();
            continue;
        }
        let entry = HEADER_WORDS
            .iter()
            .filter(|entry| begins(rest, &entry.pattern))
            .max_by_key(|entry| entry.pattern.len());
        let Some(entry) = entry else {
            let Token::Number(number) = rest[0] else { return None };
            reading.number(number)?;
            at += 1;
            continue;
        };
        reading.add(entry, rest)?;
        at += entry.pattern.len();
    }
    (!tokens.is_empty()).then_some(reading)
}

/// True where tokens begin with a pattern.
fn begins(tokens: &[Token], pattern: &[&str]) -> bool {
    pattern.len() <= tokens.len()
        && pattern.iter().zip(tokens).all(|(pattern, token)| match (*pattern, token) {
            ("#", token) => matches!(token, Token::Number(_)),
            ("*", Token::Word(word)) => component_named(word).is_some(),
            (word, Token::Word(token)) => word == token,
            (word, Token::Number(number)) => word.parse() == Ok(*number),
        })
}

impl HeaderReading {
    fn number(&mut self, number: usize) -> Option<()> {
        self.family += "# ";
        self.number.replace(number).is_none().then_some(())
    }

    fn component(&mut self, component: usize) -> Option<()> {
        self.component.replace(component).is_none().then_some(())
    }

    /// Takes note of an entry of the table and of the tokens that it stands for; `None` where a
    /// header has two numbers or two components.
    fn add(&mut self, entry: &HeaderWord, tokens: &[Token]) -> Option<()> {
        // The names of a set, and the components, stand for each other.
        let one_of_several = |meaning: &Meaning| match meaning {
            Meaning::Set(..) => true,
            Meaning::Component(_) => entry.pattern.len() == 1,
            _ => false,
        };
        let several = entry.meanings.iter().any(one_of_several);
        if several {
            self.family += "@ ";
        }
        for (pattern, token) in entry.pattern.iter().zip(tokens) {
            match (*pattern, token) {
                ("#", Token::Number(number)) => self.number(*number)?,
                ("*", Token::Word(word)) => {
                    self.family += "@ ";
                    self.component(component_named(word)?)?;
                }
                (word, _) if !several => {
                    self.family += word;
                    self.family += " ";
                }
                _ => {}
            }
        }
        for meaning in &entry.meanings {
            match *meaning {
                Meaning::Quantity(quantity) if !self.has(quantity) => {
                    self.quantities.push(quantity);
                }
                Meaning::Role(role) => self.role = self.role.max(role),
                Meaning::NoChannel(why) => self.no_channel = self.no_channel.max(Some(why)),
                Meaning::Component(component) => self.component(component)?,
                Meaning::Set(name, place) => self.sets.push((name, place)),
                Meaning::Quantity(_) | Meaning::Silent => {}
            }
        }
        Some(())
    }
}

/// The joint of a number, counted from 0 or from 1.
pub(super) fn joint_numbered(number: usize, from_zero: bool) -> Option<usize> {
    let joint = if from_zero { Some(number) } else { number.checked_sub(1) };
    joint.filter(|joint| *joint < JOINTS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_table_is_read_and_no_name_stands_in_it_twice() {
        let lines = include_str!("names.csv").lines().filter(|line| !line.starts_with('#'));
        assert_eq!(HEADER_WORDS.len(), lines.skip(1).count());
        for (k, entry) in HEADER_WORDS.iter().enumerate() {
            let again = HEADER_WORDS[..k].iter().any(|other| other.pattern == entry.pattern);
            assert!(!again, "{:?}", entry.pattern);
        }
    }

    #[test]
    fn a_unit_is_no_index_and_no_part_of_a_name() {
        let unit = |header: &str| read(header, &[]).and_then(|r| r.unit).map(|unit| unit.name);
        let number = |header: &str| read(header, &[]).and_then(|r| r.number);
        assert_eq!(unit("AXIS_1 [deg]"), Some("deg"));
        assert_eq!(unit("px_mm"), Some("mm"));
        assert_eq!(unit("t_s"), Some("s"));
        assert_eq!((unit("q[1]"), number("q[1]")), (None, Some(1)));
        assert_eq!(unit("position joint_s"), None);
        // The least torque, not one in minutes.
        let least = read("torque_A1_min", &[]).expect("known words");
        assert_eq!((least.no_channel, least.unit), (Some(NoChannel::Limit), None));
    }
}
