//! Channels by the headers of columns: families of columns with one name are taken as a set.

use super::names::{
    HeaderReading, NamedQuantity, NoChannel, ReadingRole, SETS, joint_numbered, read,
};
use super::proposal::{Doubt, LeftOut, ProposalBasis, ProposedColumn};
use super::raw::{ENCODER_COLUMN, POSITION, Raw, TORQUE};
use crate::channel::{COUNT, LogChannel, column_name};
use crate::log::columns::TIME_COLUMN;
use crate::log::columns::{
    ABC, ColumnMapping, MATRIX, QUATERNION, REFLECTOR_COUNT, channel_name, dimension, reflector,
};
use crate::log::units::{Dimension, Unit, unit_named};
use std::cmp::{Ordering, Reverse};
use trueweld_core::JOINTS;

/// How far the length of four numbers may be from 1 for a quaternion.
const QUATERNION_LENGTH_TOLERANCE: f64 = 1e-3;

/// What a column claims to be.
#[derive(Debug, Clone, PartialEq)]
struct Claim {
    column: usize,
    /// A drive's current, which becomes a torque by a factor.
    amperes: bool,
    role: ReadingRole,
    /// The same for all columns of a set.
    family: String,
    unit: Option<&'static Unit>,
    basis: ProposalBasis,
}

/// The columns of a file, with the claims of those that a channel is named by.
#[derive(Clone)]
pub(super) struct NamedColumns {
    claims: Vec<Result<Claim, LeftOut>>,
}

impl NamedColumns {
    /// By the headers of a file. `joints`: names in the robot file.
    pub(super) fn of(raw: &Raw, joints: &[String]) -> Self {
        let readings: Vec<Option<HeaderReading>> =
            raw.titles.iter().map(|title| read(title, joints)).collect();
        // Where one set counts from 0, the file does.
        let file_from_zero = families(&readings)
            .iter()
            .any(|family| counts_from_zero(&readings, family) == Some(true));
        let mut claims = vec![Err(LeftOut::Unknown); readings.len()];
        for family in families(&readings) {
            let of_axes = family
                .iter()
                .all(|k| readings[*k].as_ref().is_some_and(|reading| reading.component.is_none()));
            let from_zero =
                counts_from_zero(&readings, &family).unwrap_or(of_axes && file_from_zero);
            let set = full_set(&readings, &family);
            let first = quaternion(raw, &readings, &family);
            // Seven axes, of which none is known to be the first.
            let seven = has_number(&readings, &family, 0) && has_number(&readings, &family, JOINTS);
            for k in family {
                let Some(reading) = &readings[k] else { continue };
                if !seven || reading.no_channel.is_some() {
                    claims[k] = claim(reading, from_zero, set, first);
                }
            }
        }
        for (k, header) in raw.names.iter().enumerate() {
            if let Some(column) = plain(header) {
                let unit = header.split_once('_').and_then(|(_, unit)| unit_named(unit));
                let unit = unit.filter(|unit| unit.dimension == Some(dimension(column)));
                claims[k] = Ok(Claim::plain(column, unit));
            }
            if raw.titles[k] != *header
                && let Ok(claim) = &mut claims[k]
            {
                claim.basis = ProposalBasis::Comment;
            }
            if raw.values[k].is_none() {
                claims[k] = Err(LeftOut::NoNumbers);
            }
        }
        let mut named = Self { claims };
        named.check_units(raw);
        named.check_times(raw, &readings);
        named.only_whole_vectors();
        named
    }
}

/// Column of a header that is written as in a plain log.
fn plain(header: &str) -> Option<usize> {
    let small = header.to_lowercase();
    let payload = LogChannel::Payload.columns();
    (0..COUNT)
        .find(|column| column_name(*column) == header)
        .or_else(|| payload.chain(MATRIX).find(|column| channel_name(*column) == small))
}

/// Columns of one name, but for its number, component or the like.
fn families(readings: &[Option<HeaderReading>]) -> Vec<Vec<usize>> {
    let mut families: Vec<(&str, Vec<usize>)> = Vec::new();
    for (k, reading) in readings.iter().enumerate() {
        let Some(reading) = reading else { continue };
        match families.iter_mut().find(|(name, _)| *name == reading.family) {
            Some((_, members)) => members.push(k),
            None => families.push((&reading.family, vec![k])),
        }
    }
    families.into_iter().map(|(_, members)| members).collect()
}

/// True where a family counts axes from 0; `None` where it may do either.
fn counts_from_zero(readings: &[Option<HeaderReading>], family: &[usize]) -> Option<bool> {
    match [0, JOINTS].map(|number| has_number(readings, family, number)) {
        [true, _] => Some(true),
        [false, true] => Some(false),
        [false, false] => None,
    }
}

fn has_number(readings: &[Option<HeaderReading>], family: &[usize], number: usize) -> bool {
    family.iter().any(|k| readings[*k].as_ref().is_some_and(|r| r.number == Some(number)))
}

/// The set of names that a family has every name of, once.
fn full_set(readings: &[Option<HeaderReading>], family: &[usize]) -> Option<&'static str> {
    let times = |name: &str, place: usize| {
        let of = |reading: &HeaderReading| reading.sets.contains(&(name, place));
        family.iter().filter(|k| readings[**k].as_ref().is_some_and(of)).count()
    };
    let full =
        |(name, count): &&(&'static str, usize)| (0..*count).all(|place| times(name, place) == 1);
    SETS.iter().filter(full).max_by_key(|(_, count)| *count).map(|(name, _)| *name)
}

/// The first number of a family of four numbered columns, from 0 or 1, that are of length 1 in every
/// row.
fn quaternion(raw: &Raw, readings: &[Option<HeaderReading>], family: &[usize]) -> Option<usize> {
    let numbers: Vec<usize> =
        family.iter().filter_map(|k| readings[*k].as_ref().and_then(|r| r.number)).collect();
    let columns: Vec<&Vec<f64>> = family.iter().filter_map(|k| raw.values[*k].as_ref()).collect();
    if !(numbers == [0, 1, 2, 3] || numbers == [1, 2, 3, 4]) || columns.len() != numbers.len() {
        return None;
    }
    let is_one = |row: usize| {
        let square: f64 = columns.iter().map(|column| column[row].powi(2)).sum();
        square.is_nan() || (square.sqrt() - 1.0).abs() < QUATERNION_LENGTH_TOLERANCE
    };
    (0..raw.rows).all(is_one).then_some(numbers[0])
}

/// What a header claims, among its family. `first`: number of the first of a quaternion.
fn claim(
    reading: &HeaderReading,
    from_zero: bool,
    set: Option<&'static str>,
    first: Option<usize>,
) -> Result<Claim, LeftOut> {
    if let Some(why) = reading.no_channel {
        return Err(match why {
            NoChannel::Other(what) => LeftOut::NoChannel(what),
            NoChannel::Limit => LeftOut::Limit,
            NoChannel::Computed => LeftOut::Computed,
            NoChannel::Commanded => LeftOut::Commanded,
        });
    }
    let place = reading.sets.iter().find(|(name, _)| Some(*name) == set).map(|(_, place)| *place);
    let of_number = || reading.number.and_then(|number| joint_numbered(number, from_zero));
    let (column, amperes) = match (set, place) {
        // FANUC's pose, W P R beside X Y Z, is the controller's.
        (Some("wpr"), _) if reading.component.is_some() || place.is_some() => {
            return Err(LeftOut::Computed);
        }
        (Some("abc"), Some(place)) => {
            let of_pose =
                reading.only(&[NamedQuantity::Pose, NamedQuantity::Place, NamedQuantity::Point]);
            (of_pose.then_some(ABC.start + place), false)
        }
        (_, Some(place)) => {
            let mut named = reading.clone();
            // A letter of a set is no time.
            named.quantities.retain(|quantity| *quantity != NamedQuantity::Time);
            named.joint = Some(place);
            column_of(&named, Some(place))?
        }
        // A name of a set whose others are not there.
        (_, None) if !reading.sets.is_empty() && !has_meaning_alone(reading) => (None, false),
        (_, None) => match first.zip(reading.number) {
            Some((first, number))
                if reading.only(&[NamedQuantity::Encoder, NamedQuantity::Quaternion]) =>
            {
                (number.checked_sub(first).map(|place| QUATERNION.start + place), false)
            }
            _ => column_of(reading, reading.joint.or_else(of_number))?,
        },
    };
    let column = column.ok_or(LeftOut::Unknown)?;
    let pose = [LogChannel::Position.columns(), LogChannel::Rotation.columns(), ABC, QUATERNION];
    if reading.role == ReadingRole::Actual && pose.iter().any(|of| of.contains(&column)) {
        return Err(LeftOut::Computed);
    }
    Ok(Claim {
        column,
        amperes,
        role: reading.role,
        family: reading.family.clone(),
        unit: reading.unit,
        basis: ProposalBasis::Header,
    })
}

/// True of a letter that means something without its set: a time, the w of a quaternion.
fn has_meaning_alone(reading: &HeaderReading) -> bool {
    let is_time = reading.has(NamedQuantity::Time) && reading.only(&[NamedQuantity::Time]);
    is_time || (reading.component == Some(3) && reading.has(NamedQuantity::Quaternion))
}

/// The column that quantities, with a component or a joint, are; and whether a current stands for
/// it.
fn column_of(
    reading: &HeaderReading,
    joint: Option<usize>,
) -> Result<(Option<usize>, bool), LeftOut> {
    use NamedQuantity::{
        Angle, Counter, Current, Encoder, External, Force, Joint, Link, Moment, Payload, Place,
        Point, Pose, Quaternion, Reflector, Rotation, Speed, Spindle, Time, Torque, Wrench,
    };
    let HeaderReading { component, number, .. } = *reading;
    let named = !reading.quantities.is_empty() || reading.joint.is_some();
    let of = |quantity: NamedQuantity, others: &[NamedQuantity]| {
        reading.has(quantity)
            && reading.quantities.iter().all(|q| *q == quantity || others.contains(q))
    };
    let start = |channel: LogChannel| channel.columns().start;
    let is_bare = component.is_none() && joint.is_none() && number.is_none();
    if reading.has(Speed) && !(of(Spindle, &[Speed]) && is_bare) {
        return Err(LeftOut::NoChannel("speed"));
    }
    let of_angle = [Joint, Encoder, Angle, Place];
    if reading.has(External) {
        let beside = [Joint, Encoder, Angle, Place, External];
        let is_link = [Encoder, Angle].into_iter().any(|quantity| of(quantity, &beside));
        return match joint.filter(|_| is_link) {
            Some(joint) => Ok((Some(start(LogChannel::LinkEncoder) + joint), false)),
            None => Err(LeftOut::NoChannel("external axis, force or torque")),
        };
    }
    let column = match (component, joint) {
        (Some(c), Some(r)) => {
            let is_point = of(Reflector, &[Point, Place]) && reading.joint.is_none();
            (is_point && r < REFLECTOR_COUNT && c < 3).then(|| reflector(r).start + c)
        }
        (Some(_), None) if number.is_some() => None,
        (Some(3), None) => of(Quaternion, &[Pose]).then_some(QUATERNION.start),
        (Some(c), None) => {
            if of(Force, &[Wrench]) {
                Some(start(LogChannel::Force) + c)
            } else if of(Moment, &[Torque, Wrench]) || of(Torque, &[Wrench]) {
                Some(start(LogChannel::Moment) + c)
            } else if of(Quaternion, &[Pose]) {
                Some(QUATERNION.start + 1 + c)
            } else if of(Rotation, &[Angle, Pose]) {
                Some(start(LogChannel::Rotation) + c)
            } else {
                reading.only(&[Place, Point, Pose]).then_some(POSITION + c)
            }
        }
        (None, Some(joint)) => {
            if of(Current, &[Joint]) {
                return Ok((Some(TORQUE + joint), true));
            }
            // "The current position" is the present one.
            let drive = [Torque, Moment, Joint, Current];
            if of(Torque, &drive) || of(Moment, &drive) {
                Some(TORQUE + joint)
            } else if of(Link, &of_angle) {
                Some(start(LogChannel::LinkEncoder) + joint)
            } else {
                let angle = [Joint, Encoder, Angle, Place, Current];
                (named && reading.only(&angle)).then_some(ENCODER_COLUMN + joint)
            }
        }
        (None, None) if number.is_some() => None,
        (None, None) => {
            if of(Time, &[]) || of(Counter, &[]) {
                Some(TIME_COLUMN)
            } else if of(Spindle, &[Speed]) {
                Some(start(LogChannel::Spindle))
            } else {
                of(Payload, &[]).then_some(start(LogChannel::Payload))
            }
        }
    };
    Ok((column, false))
}

impl NamedColumns {
    /// A unit in the header, or in the row below it, is one of what the header names.
    fn check_units(&mut self, raw: &Raw) {
        for (claim, below) in self.claims.iter_mut().zip(&raw.units) {
            let Ok(own) = claim else { continue };
            own.unit = own.unit.or(*below);
            let Some(unit) = own.unit else { continue };
            // `TX` in mm is a translation, not a torque.
            if let Some(place) = own.place_of_moment()
                && unit.dimension == Some(Dimension::Length)
            {
                own.column = POSITION + place;
            }
            let held = dimension(own.column);
            let factored = matches!(held, Dimension::Torque | Dimension::Force | Dimension::Angle);
            if !unit.dimension.map_or(factored, |dimension| dimension == held) {
                *claim = Err(LeftOut::OtherUnit(unit.name));
            } else if unit.dimension.is_some() {
                own.amperes = false;
            }
            // What trackers and controllers write in degrees are angles about one axis after another.
            if let Ok(own) = claim
                && LogChannel::Rotation.columns().contains(&own.column)
                && own.unit.is_some_and(|unit| unit.name == "deg")
            {
                own.basis = ProposalBasis::Degrees;
            }
        }
    }

    /// A time rises. Without a header the first column that does may be it; of several the first
    /// one that is no mere count is.
    fn check_times(&mut self, raw: &Raw, readings: &[Option<HeaderReading>]) {
        // A row that was written twice, two that were exchanged, and bursts are told when it is read.
        let rises = |k: usize| {
            let Some(values) = raw.values[k].as_ref() else { return false };
            let changes = || values.windows(2).filter(|pair| pair[1] != pair[0]);
            2 * changes().filter(|pair| pair[1] > pair[0]).count() > changes().count()
        };
        let is_strict = |k: usize| {
            raw.values[k].as_ref().is_some_and(|v| v.windows(2).all(|pair| pair[1] > pair[0]))
        };
        let numbered = raw.names.iter().enumerate().all(|(k, name)| *name == (k + 1).to_string());
        let headed = if raw.text { raw.entry.dialect.header > 0 } else { !numbered };
        if let Some(first) = self.claims.first_mut()
            && *first == Err(LeftOut::Unknown)
            && (!headed && raw.rows > 2 && is_strict(0))
        {
            let unit = raw.units[0];
            *first = Ok(Claim { basis: ProposalBasis::Rises, ..Claim::plain(TIME_COLUMN, unit) });
        }
        let is_time =
            |claim: &Result<Claim, LeftOut>| claim.as_ref().is_ok_and(|c| c.column == TIME_COLUMN);
        let times: Vec<usize> =
            (0..self.claims.len()).filter(|k| is_time(&self.claims[*k])).collect();
        let counts =
            |k: &usize| readings[*k].as_ref().is_some_and(|r| r.has(NamedQuantity::Counter));
        // A stamp that the sensor's message has is nearer to it than the time of receipt.
        let role = |k: usize| readings[k].as_ref().map_or(ReadingRole::Plain, |r| r.role);
        let rising = times.iter().copied().filter(|k| rises(*k));
        let chosen = rising.min_by_key(|k| (counts(k), Reverse(role(*k))));
        for k in times {
            // How long a tick lasts no header says; KUKA's counts milliseconds.
            let ticks = counts(&k) && !raw.names[k].to_lowercase().contains("ipoc");
            if let Some(claim) = self.claims[k].as_mut().ok().filter(|_| ticks) {
                claim.basis = ProposalBasis::Rises;
            }
            if !rises(k) {
                self.claims[k] = Err(LeftOut::NotRising);
            } else if let Some(chosen) = chosen.filter(|chosen| *chosen != k) {
                self.claims[k] = Err(LeftOut::Twice(raw.names[chosen].clone()));
            }
        }
    }

    /// Vectors of which a part is nothing.
    fn only_whole_vectors(&mut self) {
        let mut vectors = vec![LogChannel::Position.columns(), LogChannel::Rotation.columns()];
        vectors.extend([ABC, QUATERNION, MATRIX]);
        vectors.extend((0..REFLECTOR_COUNT).map(reflector));
        for vector in vectors {
            let of_vector = |claim: &Claim| vector.contains(&claim.column);
            let claims = self.claims.iter().filter_map(|claim| claim.as_ref().ok());
            let mut there: Vec<(String, usize)> = claims
                .filter(|claim| of_vector(claim))
                .map(|claim| (claim.family.clone(), claim.column))
                .collect();
            there.sort_unstable();
            there.dedup();
            for claim in &mut self.claims {
                let Ok(own) = claim else { continue };
                let count = there.iter().filter(|(family, _)| *family == own.family).count();
                if of_vector(own) && count < vector.len() {
                    *claim = Err(LeftOut::Incomplete);
                }
            }
        }
    }

    /// True where a column claims this one of a log.
    pub(super) fn has(&self, column: usize) -> bool {
        self.claims.iter().flatten().any(|claim| claim.column == column)
    }

    /// Names of the families that claim a tracker's position.
    pub(super) fn positions(&self) -> Vec<String> {
        let claims = self.claims.iter().filter_map(|claim| claim.as_ref().ok());
        let of = claims.filter(|claim| LogChannel::Position.columns().contains(&claim.column));
        let mut families: Vec<String> = of.map(|claim| claim.family.clone()).collect();
        families.sort_unstable();
        families.dedup();
        families
    }

    /// Leaves out all claims of a position, but those of `family`.
    pub(super) fn keep_position(&mut self, family: Option<&str>) {
        for claim in &mut self.claims {
            let Ok(own) = claim else { continue };
            let position = LogChannel::Position.columns().contains(&own.column);
            if position && Some(own.family.as_str()) != family {
                *claim = Err(LeftOut::Unknown);
            }
        }
    }

    /// Leaves out a pose: the position of this family, and a rotation of the same name.
    pub(super) fn leave_out_pose(&mut self, position: &str, why: &LeftOut) {
        for claim in &mut self.claims {
            let Ok(own) = claim else { continue };
            let is_position = LogChannel::Position.columns().contains(&own.column);
            if (is_position || own.is_rotation()) && own.family == position {
                *claim = Err(why.clone());
            }
        }
    }

    /// The columns of a file as they are proposed.
    pub(super) fn proposed(&self, file: usize, raw: &Raw) -> Vec<ProposedColumn> {
        (0..raw.names.len()).map(|k| self.proposed_column(file, raw, k)).collect()
    }

    /// The column of that index, as it is proposed.
    fn proposed_column(&self, file: usize, raw: &Raw, k: usize) -> ProposedColumn {
        let header = &raw.names[k];
        let range = raw.values[k].as_ref().map(|values| {
            let finite = values.iter().copied().filter(|x| x.is_finite());
            finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
        });
        let (mut bases, mut doubts) = (Vec::new(), Vec::new());
        let mapping = self.claims[k].clone().map(|claim| {
            bases.push(claim.basis);
            if claim.basis != ProposalBasis::Header {
                doubts.push(Doubt::Channel);
            }
            let unit = match claim.unit {
                Some(unit) => {
                    bases.push(ProposalBasis::UnitInHeader);
                    unit.name
                }
                None if claim.amperes => "A",
                None => dimension(claim.column).unit(),
            };
            let column = claim.column;
            let raw = unit_named(unit).is_some_and(|unit| unit.dimension.is_none());
            let open = raw && LogChannel::MotorTorque.columns().contains(&column);
            if raw && !open {
                doubts.push(Doubt::Factor);
            }
            let (header, plus) = (header.clone(), Vec::new());
            ColumnMapping { header, column, unit, factor: 1.0, open, offset: 0.0, plus }
        });
        bases.extend(raw.sentinels[k].map(|(value, rows)| ProposalBasis::Sentinel { value, rows }));
        let header = header.clone();
        ProposedColumn { file, header, range, mapping, bases, doubts, preview: None }
    }
}

impl Claim {
    fn plain(column: usize, unit: Option<&'static Unit>) -> Self {
        Self {
            column,
            amperes: false,
            role: ReadingRole::Plain,
            family: String::new(),
            unit,
            basis: ProposalBasis::Header,
        }
    }

    /// The component of a moment that is named by the letter T alone.
    fn place_of_moment(&self) -> Option<usize> {
        let moment = LogChannel::Moment.columns();
        let is_letter = self.family.starts_with("t ") && moment.contains(&self.column);
        is_letter.then(|| self.column - moment.start)
    }

    /// Which of two claims stands: a torque before a current, what was measured before the rest.
    fn rank(&self) -> (bool, ReadingRole) {
        (!self.amperes, self.role)
    }

    /// True where a log has room for one of two.
    fn rivals(&self, other: &Self) -> bool {
        self.column == other.column || (self.is_rotation() && other.is_rotation())
    }

    fn is_rotation(&self) -> bool {
        let forms = [LogChannel::Rotation.columns(), ABC, QUATERNION, MATRIX];
        forms.iter().any(|form| form.contains(&self.column))
    }

    /// True of columns that are taken together: of one file, name and channel.
    fn is_with(&self, other: &Self) -> bool {
        let channel =
            |claim: &Self| (claim.column < COUNT).then(|| LogChannel::of(claim.column).0.id);
        self.family == other.family && channel(self) == channel(other)
    }
}

/// Several columns of one channel: a set that was measured stands before one that was not; where
/// nothing tells which, neither is taken, unless both say the same.
pub(super) fn settle(named: &mut [NamedColumns], raws: &[Raw]) {
    let all: Vec<(usize, usize, Claim)> = named
        .iter()
        .enumerate()
        .flat_map(|(file, columns)| {
            let claims = columns.claims.iter().enumerate();
            claims.filter_map(move |(k, claim)| Some((file, k, claim.as_ref().ok()?.clone())))
        })
        .filter(|(.., claim)| claim.column != TIME_COLUMN)
        .collect();
    let same = |a: (usize, usize), b: (usize, usize)| {
        let (Some(a), Some(b)) = (&raws[a.0].values[a.1], &raws[b.0].values[b.1]) else {
            return false;
        };
        let equal = |(a, b): (&f64, &f64)| a == b || (a.is_nan() && b.is_nan());
        a.len() == b.len() && a.iter().zip(b).all(equal)
    };
    let mut verdicts: Vec<Option<LeftOut>> = vec![None; all.len()];
    for (i, (file, k, claim)) in all.iter().enumerate() {
        for (j, (other_file, other_k, other)) in all.iter().enumerate() {
            let together = file == other_file && claim.is_with(other);
            if i == j || !claim.rivals(other) || (together && claim.column != other.column) {
                continue;
            }
            let header = || raws[*other_file].names[*other_k].clone();
            // Of forms of one rotation the quaternion, which needs no convention, else the first.
            let form = |claim: &Claim| u8::from(!QUATERNION.contains(&claim.column));
            let forms = file == other_file && claim.column != other.column;
            let first = |same: bool| same && (form(claim), i) < (form(other), j);
            let is_same = forms || same((*file, *k), (*other_file, *other_k));
            let verdict = match claim.rank().cmp(&other.rank()) {
                Ordering::Greater => continue,
                Ordering::Equal if first(is_same) => continue,
                Ordering::Equal if !is_same => LeftOut::Rival(header()),
                _ => LeftOut::Twice(header()),
            };
            verdicts[i].get_or_insert(verdict);
        }
    }
    // A set is taken or left as a whole.
    let sets: Vec<Option<LeftOut>> = all
        .iter()
        .map(|(file, _, claim)| {
            let mut members = all
                .iter()
                .zip(&verdicts)
                .filter(|((other_file, _, other), _)| file == other_file && claim.is_with(other));
            members.find_map(|(_, verdict)| verdict.clone())
        })
        .collect();
    for ((file, k, _), (own, of_set)) in all.into_iter().zip(verdicts.into_iter().zip(sets)) {
        if let Some(verdict) = own.or(of_set) {
            named[file].claims[k] = Err(verdict);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::files::FileEntry;
    use crate::log::text::Dialect;

    /// A file of columns that rise.
    fn raw(headers: &[&str]) -> Raw {
        let names: Vec<String> = headers.iter().map(|header| (*header).to_owned()).collect();
        let rising = |k: usize| Some((0..8).map(|row| (row + k) as f64).collect());
        Raw::of_values(
            FileEntry {
                written: "a.csv".to_owned(),
                path: "a.csv".into(),
                clock: None,
                dialect: Dialect::PLAIN,
                topic: None,
            },
            names,
            (0..headers.len()).map(rising).collect(),
        )
    }

    /// What the columns of a file with these headers become.
    fn settled(raw: Raw, joints: &[&str]) -> Vec<String> {
        let joints: Vec<String> = joints.iter().map(|name| (*name).to_owned()).collect();
        let raws = [raw];
        let mut named = [NamedColumns::of(&raws[0], &joints)];
        settle(&mut named, &raws);
        let columns = named[0].proposed(0, &raws[0]);
        let shown = |column: &ProposedColumn| match &column.mapping {
            Ok(mapping) => channel_name(mapping.column).to_owned(),
            Err(why) => format!("{why:?}"),
        };
        columns.iter().map(shown).collect()
    }

    fn channels(headers: &[&str]) -> Vec<String> {
        settled(raw(headers), &[])
    }

    /// Six headers, `#` counting from a number.
    fn six(pattern: &str, from: usize) -> Vec<String> {
        (from..from + JOINTS).map(|n| pattern.replace('#', &n.to_string())).collect()
    }

    fn are_read_as(headers: &[impl AsRef<str>], expected: &[impl AsRef<str>]) {
        let headers: Vec<&str> = headers.iter().map(AsRef::as_ref).collect();
        let expected: Vec<&str> = expected.iter().map(AsRef::as_ref).collect();
        assert_eq!(channels(&headers), expected, "{headers:?}");
    }

    #[test]
    fn axes_of_several_makers_are_taken_as_sets_of_six() {
        for (pattern, from, channel) in [
            ("A#", 1, "qe"),
            ("J# [deg]", 1, "qe"),
            ("$AXIS_ACT_MEAS.A#", 1, "qe"),
            ("AIPos_A#", 1, "qe"),
            ("Receive.AIPos.A#", 1, "qe"),
            ("actual_q_#", 0, "qe"),
            ("q[#]", 0, "qe"),
            ("q[#]", 1, "qe"),
            ("position joint_a#", 1, "qe"),
            ("joint_states.position[#]", 0, "qe"),
            ("rax_#", 1, "qe"),
            ("theta#", 1, "qe"),
            ("JT#", 1, "qe"),
            ("Axe #", 1, "qe"),
            ("Achse # Istwinkel [Grad]", 1, "qe"),
            ("Istposition A#", 1, "qe"),
            ("轴#", 1, "qe"),
            ("current joint position #", 1, "qe"),
            ("Link encoder #", 1, "ql"),
            ("External encoder A#", 1, "ql"),
            ("effort joint_a#", 1, "tm"),
            ("MOT_TRQ_#", 1, "tm"),
            ("tau_J[#]", 0, "tm"),
            ("Motor torque A# [Nm]", 1, "tm"),
            ("Istmoment A#", 1, "tm"),
            ("Drehmoment A# [Nm]", 1, "tm"),
            ("MACur_A#", 1, "tm"),
            ("actual_current_#", 0, "tm"),
        ] {
            let expected: Vec<String> = (1..=JOINTS).map(|n| format!("{channel}{n}")).collect();
            are_read_as(&six(pattern, from), &expected);
        }
    }

    #[test]
    fn vectors_and_single_channels_are_known_by_their_names() {
        for (headers, expected) in [
            (vec!["Zeit [s]"], vec!["t"]),
            (vec!["Uhrzeit"], vec!["t"]),
            (vec!["epoch"], vec!["t"]),
            (vec!["X_Value"], vec!["t"]),
            (vec!["Fx (N)", "Fy (N)", "F_z [kN]"], vec!["fx", "fy", "fz"]),
            (vec!["wrench.force.x", "wrench.torque.y", "Tz [Nm]"], vec!["fx", "my", "mz"]),
            (vec!["Axial force"], vec!["fz"]),
            (vec!["Axialkraft"], vec!["fz"]),
            (vec!["X [mm]", "Y [mm]", "Z [mm]"], vec!["px", "py", "pz"]),
            (vec!["X", "Y", "Z", "A", "B", "C"], vec!["px", "py", "pz", "a", "b", "c"]),
            (
                vec!["orientation.x", "orientation.y", "orientation.z", "orientation.w"],
                vec!["qx", "qy", "qz", "qw"],
            ),
            (vec!["Rx", "Ry", "Rz"], vec!["rx", "ry", "rz"]),
            (vec!["R2_X", "R2_Y", "R2_Z"], vec!["reflector2_x", "reflector2_y", "reflector2_z"]),
            (
                vec!["SMR3 Z", "SMR3 Y", "SMR3 X"],
                vec!["reflector3_z", "reflector3_y", "reflector3_x"],
            ),
            (vec!["Spindeldrehzahl"], vec!["spindle"]),
            (vec!["Spindle speed [rpm]"], vec!["spindle"]),
            (vec!["spindle_rad_s"], vec!["spindle"]),
            (vec!["payload_kg", "tm1_nm", "t_s"], vec!["payload", "tm1", "t"]),
        ] {
            are_read_as(&headers, &expected);
        }
    }

    /// No channel is any of these, whatever letters and numbers it has.
    #[test]
    fn other_quantities_of_the_same_axes_are_no_channels() {
        for header in [
            "Sollposition A1",
            "AXIS_SOLL_A1",
            "target_q_0",
            "Send.RKorr.X",
            "AKorr.A1",
            "ASPos_A1",
            "RSol.X",
            "q_d[1]",
            "tau_J_d[1]",
            "J1 setpoint",
            "Axis 1 reference",
            "Nominal angle 1",
            "RIst.X",
            "$POS_ACT.X",
            "X_act",
            "actual_TCP_pose_0",
            "Robot X",
            "Istposition X",
            "Max torque 1",
            "Torque limit A1",
            "torque_A1_min",
            "Holding torque 1",
            "External torque 1",
            "tau_ext[1]",
            "Load ratio A1",
            "Auslastung A1",
            "Motor speed axis 1",
            "Drehzahl A1",
            "velocity joint_a1",
            "actual_qd_0",
            "Tool speed x",
            "gyro_x",
            "std_x",
            "Motortemperatur A1",
            "joint_temperatures_0",
            "Motor temperature 1",
            "PWM 1",
            "Brake A1",
            "Schleppfehler A1",
            "Following error A1",
            "joint_control_output_0",
            "Voltage A1",
            "E1",
            "status A1",
            "Override",
        ] {
            let [told] = &channels(&[header])[..] else { panic!("{header}") };
            let reasons = ["Commanded", "Computed", "Limit", "NoChannel"];
            assert!(reasons.iter().any(|reason| told.starts_with(reason)), "{header}: {told}");
        }
        for header in [
            "gripper",
            "A7",
            "digital output 3",
            "Sensor 4",
            "M1",
            "T1",
            "x1",
            "S",
            "B",
            "elbow_joint",
            "temp_ratio_foo",
            "Comment",
            "Samples",
            "flow rate 2",
            "A1 B2",
            "1",
        ] {
            assert_eq!(channels(&[header]), ["Unknown"], "{header}");
        }
        // A vector is taken whole.
        assert_eq!(channels(&["X [mm]", "Y [mm]"]), ["Incomplete", "Incomplete"]);
        // An angular speed under the name of an angle.
        assert_eq!(channels(&["A1 [deg/s]"]), ["OtherUnit(\"deg/s\")"]);
        // Seven axes.
        let seven: Vec<String> = (0..=JOINTS).map(|n| format!("q[{n}]")).collect();
        are_read_as(&seven, &["Unknown"; JOINTS + 1]);
        let pose = channels(&["X", "Y", "Z", "W", "P", "R"]);
        assert!(pose.iter().all(|told| told == "Computed"), "FANUC: {pose:?}");
    }

    #[test]
    fn joints_are_known_by_their_names() {
        let qe: Vec<String> = (1..=JOINTS).map(|n| format!("qe{n}")).collect();
        let ur = [
            "shoulder_pan_joint",
            "shoulder_lift_joint",
            "elbow_joint",
            "wrist_1_joint",
            "wrist_2_joint",
            "wrist_3_joint",
        ];
        are_read_as(&ur, &qe);
        let motoman = ["s", "l", "u", "r", "b", "t"];
        are_read_as(&motoman.map(|name| format!("position joint_{name}")), &qe);
        are_read_as(&motoman.map(str::to_uppercase), &qe);
        // A part of the names says nothing, and gives no wrong number.
        assert!(channels(&ur[2..]).iter().all(|told| told == "Unknown"));
        // The robot file's names lead, in whatever order they count.
        let mut joints = ur;
        joints.reverse();
        let told = settled(raw(&["wrist_3_joint", "effort elbow_joint"]), &joints);
        assert_eq!(told, ["qe1", "tm4"]);
    }

    #[test]
    fn four_numbers_of_length_one_are_a_quaternion() {
        let headers = ["rax_1", "x", "y", "z", "q1", "q2", "q3", "q4"];
        let mut file = raw(&headers);
        let half = |row: f64| [(0.1 * row).cos(), 0.0, (0.1 * row).sin(), 0.0];
        for c in 0..4 {
            file.values[4 + c] = Some((0..8).map(|row| half(f64::from(row))[c]).collect());
        }
        assert_eq!(settled(file, &[]), ["qe1", "px", "py", "pz", "qw", "qx", "qy", "qz"]);
        assert_eq!(channels(&headers)[4], "Rival(\"rax_1\")");
    }

    #[test]
    fn of_several_sets_the_measured_one_is_taken_and_equal_ones_are_told() {
        let told = channels(&["torque_1", "actual_current_1", "A1", "Measured angle A1"]);
        assert_eq!(told, ["tm1", "Twice(\"torque_1\")", "Twice(\"Measured angle A1\")", "qe1"]);
        let told = channels(&["A1", "A2", "J1", "J2"]);
        assert!(told.iter().all(|told| told.starts_with("Rival")), "{told:?}");
        // The same numbers twice are no question.
        let mut file = raw(&["A1", "J1"]);
        file.values[1] = file.values[0].clone();
        assert_eq!(settled(file, &[]), ["qe1", "Twice(\"A1\")"]);
    }
}
