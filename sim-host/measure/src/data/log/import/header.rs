//! Channels by the headers of columns, in the habits of several makers.

use super::proposal::{Doubt, Ground, LeftOut, ProposedColumn};
use super::raw::{ENCODER, POSITION, Raw, TIME, TORQUE};
use crate::data::channel::LogChannel;
use crate::data::log::columns::{
    ABC, ColumnMapping, QUATERNION, channel_named, dimension, reflector,
};
use crate::data::log::units::unit_named;
use trueweld_core::JOINTS;

/// Words of a header, in small letters: parted at blanks, marks, capitals and digits; and the unit
/// that stands in it.
fn words(header: &str) -> (Vec<String>, Option<&'static str>) {
    let mut unit = None;
    let mut rest = header.to_owned();
    for (open, close) in [('[', ']'), ('(', ')'), ('<', '>')] {
        if let (Some(a), Some(b)) = (rest.find(open), rest.rfind(close))
            && a < b
            && let Some(found) = unit_named(&rest[a + open.len_utf8()..b])
        {
            unit = Some(found.name);
            rest.replace_range(a..b + close.len_utf8(), " ");
        }
    }
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for c in rest.chars() {
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
    // A last word that is a unit: `px_mm`, `force N`.
    if unit.is_none()
        && words.len() > 1
        && let Some(found) = words.last().and_then(|word| unit_named(word))
        && !["a", "t", "c", "b", "h", "in", "1", "x", "y", "z", "g", "v", "m"]
            .contains(&words[words.len() - 1].as_str())
    {
        unit = Some(found.name);
        words.pop();
    }
    (words, unit)
}

/// What a header says.
enum Said {
    /// A channel's column, and what the word says besides: a current.
    Channel(usize, bool),
    LeftOut(LeftOut),
}

/// The channel that a header names, in the habits of several makers. `zero_based`: axes of this
/// file are counted from 0.
fn channel_of(words: &[String], zero_based: bool) -> Said {
    // `list`: words with a blank between them.
    let has = |list: &str| list.split(' ').any(|known| words.iter().any(|word| word == known));
    let number = words.iter().rev().find_map(|word| word.parse::<usize>().ok());
    let axis = number.and_then(|n| if zero_based { Some(n) } else { n.checked_sub(1) });
    let axis = axis.filter(|axis| *axis < JOINTS);
    let joined = words.concat();
    // The channels' own names.
    if let Some(column) = channel_named(&joined) {
        return Said::Channel(column, false);
    }
    let commanded =
        "cmd command commanded soll target set setpoint desired des nominal ref ipo nom";
    if has(commanded) && !has("reflector") {
        return Said::LeftOut(LeftOut::Commanded);
    }
    let other = "vel velocity geschwindigkeit qd acc acceleration qdd jerk temp temperature error \
                 status quality";
    if has(other) {
        return Said::LeftOut(LeftOut::Unknown);
    }
    if has("spindle spindel rpm") || joined.contains("drehzahl") {
        return Said::Channel(LogChannel::Spindle.columns().start, false);
    }
    let component = ["x", "y", "z"].iter().position(|c| has(c));
    let fused = |prefixes: &[&str]| {
        let at = |prefix: &&str| {
            words.iter().any(|w| w.len() == prefix.len() + 1 && w.starts_with(*prefix))
        };
        prefixes.iter().find(|p| at(p)).and_then(|prefix| {
            ["x", "y", "z"].iter().position(|c| words.iter().any(|w| *w == format!("{prefix}{c}")))
        })
    };
    if let Some(c) = fused(&["f"]).or(component.filter(|_| has("force kraft"))) {
        return Said::Channel(LogChannel::Force.columns().start + c, false);
    }
    let moment = "torque moment drehmoment";
    if let Some(c) = fused(&["m", "t"]).or(component.filter(|_| axis.is_none() && has(moment))) {
        return Said::Channel(LogChannel::Moment.columns().start + c, false);
    }
    let current = "current cur strom i";
    let torque = "torque trq tau effort drehmoment moment tm";
    if let Some(axis) = axis {
        let amperes = has(current) || joined.contains("macur") || joined.contains("strom");
        if amperes || has(torque) || joined.contains("trq") || joined.contains("torque") {
            return Said::Channel(TORQUE + axis, amperes);
        }
        if has("ql external second secondary link load abtrieb output") {
            return Said::Channel(LogChannel::LinkEncoder.columns().start + axis, false);
        }
        let marker = "r refl reflector smr marker t prism point p";
        if let Some(c) = component.filter(|_| axis < 3 && has(marker)) {
            return Said::Channel(reflector(axis).start + c, false);
        }
        let angle = "a axis axes achse joint j q qe pos position angle winkel encoder enc";
        if component.is_none()
            && (has(angle) || joined.contains("aipos") || joined.contains("axis"))
        {
            return Said::Channel(ENCODER + axis, false);
        }
    }
    let quaternion = "orientation quat quaternion q";
    let (w, c) = (has("w qw"), fused(&["q"]).or(component));
    if has(quaternion) || fused(&["q"]).is_some() || has("qw") {
        let first = QUATERNION.start;
        if w {
            return Said::Channel(first, false);
        }
        if let Some(c) = c {
            return Said::Channel(first + 1 + c, false);
        }
        if let Some(n) = number.filter(|n| *n < 4) {
            return Said::Channel(first + n, false);
        }
    }
    if let Some(c) = fused(&["r"]).or(component.filter(|_| has("rot rotvec rotation"))) {
        return Said::Channel(LogChannel::Rotation.columns().start + c, false);
    }
    if let Some(c) = fused(&["p"]).or(component) {
        return Said::Channel(POSITION + c, false);
    }
    let abc = ["a", "b", "c"].iter().position(|c| words.last().is_some_and(|word| word == c));
    if let (Some(c), None) = (abc, number) {
        return Said::Channel(ABC.start + c, false);
    }
    if has("payload mass masse last") {
        return Said::Channel(LogChannel::Payload.columns().start, false);
    }
    let time = "t time zeit timestamp stamp clock ipoc seconds sec";
    if has(time) {
        return Said::Channel(TIME, false);
    }
    Said::LeftOut(LeftOut::Unknown)
}

pub(super) fn of_file(file: usize, raw: &Raw) -> Vec<ProposedColumn> {
    // Axes from 0 to 5: no name ends in 6, and some in 0.
    let numbers: Vec<usize> =
        raw.names.iter().filter_map(|n| words(n).0.last()?.parse().ok()).collect();
    let zero_based = numbers.contains(&0) && !numbers.contains(&6);
    let column = |(k, header): (usize, &String)| {
        let (words, unit) = words(header);
        let values = raw.values[k].as_ref();
        let range = values.map(|v| {
            let finite = v.iter().copied().filter(|x| x.is_finite());
            finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
        });
        let rises = || {
            values
                .is_some_and(|v| v.windows(2).all(|w| w[1] > w[0] || w.iter().any(|x| x.is_nan())))
        };
        let mut said = channel_of(&words, zero_based);
        // A time rises; without a header that says so, the first column that does is it.
        if matches!(said, Said::Channel(TIME, _)) && !rises() {
            said = Said::LeftOut(LeftOut::Unknown);
        }
        if k == 0 && rises() && raw.rows > 2 && raw.entry.dialect.header == 0 {
            said = Said::Channel(TIME, false);
        }
        if values.is_none() {
            said = Said::LeftOut(LeftOut::NoNumbers);
        }
        let (mut grounds, mut doubts) = (vec![Ground::Header], Vec::new());
        let mapping = match said {
            Said::LeftOut(why) => Err(why),
            Said::Channel(column, current) => {
                let held = dimension(column);
                let of = unit.and_then(unit_named);
                let fits = of.filter(|u| u.dimension.is_none_or(|d| d == held));
                let unit = match fits {
                    Some(unit) => {
                        grounds.push(Ground::UnitInHeader);
                        unit.name
                    }
                    None if current => "A",
                    None => held.unit(),
                };
                let raw_unit = unit_named(unit).is_some_and(|u| u.dimension.is_none());
                if raw_unit {
                    doubts.push(Doubt::Factor);
                }
                let mapping = ColumnMapping {
                    header: header.clone(),
                    column,
                    unit,
                    factor: 1.0,
                    offset: 0.0,
                };
                Ok(mapping)
            }
        };
        ProposedColumn { file, header: header.clone(), range, mapping, grounds, doubts }
    };
    raw.names.iter().enumerate().map(column).collect()
}

/// A channel has one column, but for the time, of which every file has one. The first one wins.
pub(super) fn only_once(columns: &mut [ProposedColumn]) {
    for k in 0..columns.len() {
        let Ok(mapping) = &columns[k].mapping else { continue };
        let (column, file) = (mapping.column, columns[k].file);
        let same = |c: &ProposedColumn| c.is(column) && (column != TIME || c.file == file);
        if columns[..k].iter().any(same) {
            columns[k].mapping = Err(LeftOut::Twice);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::log::columns::channel_name;

    fn channel(header: &str) -> String {
        match channel_of(&words(header).0, false) {
            Said::Channel(column, _) => channel_name(column).to_owned(),
            Said::LeftOut(why) => format!("{why:?}"),
        }
    }

    #[test]
    fn headers_of_several_makers_are_understood() {
        for (header, expected) in [
            ("Zeit [s]", "t"),
            ("Timestamp", "t"),
            ("AXIS_ACT.A3", "qe3"),
            ("$AXIS_ACT_MEAS.A1", "qe1"),
            ("AIPos_A6", "qe6"),
            ("joint_2 (deg)", "qe2"),
            ("position joint_a5", "qe5"),
            ("effort joint_a5", "tm5"),
            ("MACur_A4", "tm4"),
            ("MOT_TRQ_1", "tm1"),
            ("Drehmoment A2 [Nm]", "tm2"),
            ("Fx (N)", "fx"),
            ("force.z", "fz"),
            ("torque.x", "mx"),
            ("Tz [Nm]", "mz"),
            ("X [mm]", "px"),
            ("orientation.w", "qw"),
            ("orientation.x", "qx"),
            ("R2_Y", "reflector2_y"),
            ("SMR3 Z [mm]", "reflector3_z"),
            ("B", "b"),
            ("Rz", "rz"),
            ("Spindeldrehzahl", "spindle"),
            ("Spindle speed [rpm]", "spindle"),
            ("AXIS_SOLL_A1", "Commanded"),
            ("velocity joint_a1", "Unknown"),
            ("gripper", "Unknown"),
            ("payload_kg", "payload"),
            ("tm1_nm", "tm1"),
            ("px_mm", "px"),
        ] {
            assert_eq!(channel(header), expected, "{header}");
        }
        assert_eq!(words("AXIS_1 [deg]").1, Some("deg"));
        assert_eq!(words("px_mm").1, Some("mm"));
    }
}
