//! What is said of files of unknown make, and the `log.toml` that reads them.

use super::{Scale, counted, listed};
use trueweld_logs::HALF_95;
use trueweld_logs::log::import::{Doubt, LeftOut, Proposal, ProposalBasis, ProposedColumn};
use trueweld_logs::log::units::unit_named;
use trueweld_logs::log::{channel_name, dimension};
use trueweld_plant::input::{FILL_IN, toml_string};

/// What to do about what is not known.
const LOG_KINDS: &str = "static-load, ring-down, free-motion or weld";

/// The finding in a sentence or two.
pub(crate) fn headline(proposal: &Proposal) -> String {
    let mapped = proposal.columns.iter().filter(|c| c.mapping.is_ok());
    let open = open(proposal);
    let todo = match open {
        0 => "nothing is left to fill in".to_owned(),
        n => format!("{} left to fill in", counted(n, "entry").replace("entrys", "entries")),
    };
    let missing = match proposal.missing.as_slice() {
        [] => String::new(),
        names => format!(
            " A {} log also needs {}, which no column seems to be.",
            proposal.kind,
            listed(names, "and")
        ),
    };
    let unknown = match unknown(proposal).len() {
        0 => String::new(),
        n => format!(
            " {} not recognised: write a line for each that is a channel.",
            counted(n, "column")
        ),
    };
    format!(
        "{} of {} in {} mapped; {todo}.{missing}{unknown}",
        mapped.count(),
        counted(proposal.columns.len(), "column"),
        counted(proposal.files.len(), "file")
    )
}

/// Columns whose headers say nothing that is known.
fn unknown(proposal: &Proposal) -> Vec<&ProposedColumn> {
    proposal.columns.iter().filter(|c| c.mapping == Err(LeftOut::Unknown)).collect()
}

/// Entries of the `log.toml` that are still to be filled in, but for the robot's.
fn open(proposal: &Proposal) -> usize {
    let columns = proposal.columns.iter().filter(|c| c.mapping.is_ok());
    let doubts: usize = columns.map(|c| c.doubts.len()).sum();
    doubts + usize::from(!proposal.kind_sure) + usize::from(proposal.period_open)
}

/// How sure a column's mapping is; nothing where there is none.
pub(crate) fn certainty(column: &ProposedColumn) -> String {
    let of = |doubt: &Doubt| match doubt {
        Doubt::Channel => "channel",
        Doubt::Unit | Doubt::Scale => "unit",
        Doubt::Sign => "sign",
        Doubt::Factor => "factor",
    };
    if column.mapping.is_err() {
        return String::new();
    }
    match column.doubts.iter().map(of).collect::<Vec<_>>().as_slice() {
        [] if column.bases.contains(&ProposalBasis::Magnitude) => "likely".to_owned(),
        [] => "sure".to_owned(),
        open => format!("guess: {}", listed(open, "and")),
    }
}

/// What else a column was recognised by; nothing where its header or a comment says it.
fn basis(of: &ProposalBasis) -> String {
    match of {
        ProposalBasis::Header
        | ProposalBasis::Rises
        | ProposalBasis::Degrees
        | ProposalBasis::Comment
        | ProposalBasis::UnitInHeader => String::new(),
        ProposalBasis::Coupling => {
            "counted from the horizontal, by the motion that the tracker saw".to_owned()
        }
        ProposalBasis::Sentinel { value, rows } => {
            format!("{value} in {} is read as missing", counted(*rows, "row"))
        }
        ProposalBasis::Magnitude => "unit by magnitude".to_owned(),
        ProposalBasis::Limits => "sign by the axis' limits".to_owned(),
        ProposalBasis::Motion { left, others } => format!(
            "sign by the tracker: {:.1} mm left, with the other sign at least {:.0} mm",
            1e3 * left,
            1e3 * others.min(99.0)
        ),
        ProposalBasis::ModelTorque(correlation) => {
            format!("sign by the model's torque (correlation {correlation:.2})")
        }
    }
}

/// What a column's mapping rests on.
pub(crate) fn bases(column: &ProposedColumn) -> String {
    match &column.mapping {
        Ok(_) => {
            let stated = column.bases.contains(&ProposalBasis::UnitInHeader);
            let and_unit = if stated { " and unit" } else { "" };
            let named = match column.bases.first() {
                Some(ProposalBasis::Rises) => "it rises as a time does".to_owned(),
                Some(ProposalBasis::Degrees) => {
                    "in degrees: a rotation vector, or a, b, c?".to_owned()
                }
                Some(ProposalBasis::Comment) => {
                    format!("channel{and_unit} by a comment above the rows")
                }
                _ => format!("channel{and_unit} by its header"),
            };
            let others = column.bases.iter().map(basis).filter(|basis| !basis.is_empty());
            std::iter::once(named).chain(others).collect::<Vec<_>>().join("; ")
        }
        Err(why) => left_out(why),
    }
}

/// Why a column is left out.
pub(crate) fn left_out(why: &LeftOut) -> String {
    match why {
        LeftOut::Unknown => "not recognised".to_owned(),
        LeftOut::Commanded => "left out: commanded, not measured".to_owned(),
        LeftOut::Computed => "left out: the controller computes it from its encoders".to_owned(),
        LeftOut::Rigid(found) => {
            let scale = Scale::small(found.channel.unit());
            format!(
                "left out: computed from the encoders, with which and a rigid robot it agrees to {}; \
                 gravity bends the arm by {}",
                scale.quantity(found.left),
                scale.quantity(found.bent)
            )
        }
        LeftOut::Limit => "left out: a limit, not a reading".to_owned(),
        LeftOut::NoChannel(what) => format!("left out: {what}, which is no channel"),
        LeftOut::OtherUnit(unit) => {
            format!("left out: its unit, {unit}, is none of what its header names")
        }
        LeftOut::NotRising => "left out: its header names a time, but it does not rise".to_owned(),
        LeftOut::Incomplete => "left out: its vector is not whole".to_owned(),
        LeftOut::Twice(other) => format!("left out: {other:?} is this channel"),
        LeftOut::Rival(other) => format!(
            "left out: {other:?} claims the same channel, and nothing tells which was measured"
        ),
        LeftOut::NoNumbers => "left out: it holds no numbers".to_owned(),
    }
}

/// What of a column's mapping is a guess, and why.
pub(crate) fn doubts(column: &ProposedColumn) -> String {
    let of = |doubt: &Doubt| match doubt {
        Doubt::Channel => "the channel: it has no header",
        Doubt::Unit => "the unit: values of this size fit several",
        Doubt::Scale => "the unit: against the encoders' motion it is off by a thousand",
        Doubt::Sign => "the sign: nothing in these files tells it",
        Doubt::Factor => "the factor: it stands in the drive's data, not in the file",
    };
    if column.mapping.is_err() {
        return String::new();
    }
    column.doubts.iter().map(of).collect::<Vec<_>>().join("; ")
}

/// The `log.toml` of a proposal. `paths`: of its files, from the folder it is written to; `robot`:
/// of the robot file, likewise; `accepted`: guesses are written as if they were known.
pub fn log_toml(
    proposal: &Proposal,
    paths: &[String],
    robot: Option<&str>,
    accepted: bool,
) -> String {
    let mut text = format!(
        "# Proposed by `trueweld import-log`. Entries that begin with \"{FILL_IN}\" are guesses: put the value in their place.\n\
         # `trueweld check FOLDER` lists what is left.\n\
         schema = \"log/1\"\n"
    );
    if proposal.kind_sure || accepted {
        text += &format!("kind = \"{}\"\n", proposal.kind);
    } else {
        text += &format!("kind = \"{FILL_IN}: {LOG_KINDS}? {} fits\"\n", proposal.kind);
    }
    if proposal.period_open {
        text += &format!(
            "period_s = \"{FILL_IN}: time from row to row, s; no column is the time of the encoders\"\n"
        );
    }
    if let Some(period) = proposal.period {
        text += &format!("period_s = {period:?}\n");
    }
    match robot {
        Some(path) => text += &format!("robot = {}\n", toml_string(path)),
        None => text += &format!("robot = \"{FILL_IN}: path of the robot file\"\n"),
    }
    if proposal.kind.name() == "weld" {
        text += &format!(
            "weld = \"{FILL_IN}: path of the weld file\"\nprocess = \"{FILL_IN}: path of the process file\"\n"
        );
    }
    text += "files = [\n";
    for (k, (file, path)) in proposal.files.iter().zip(paths).enumerate() {
        // A file of which nothing is read has no time that would be missed.
        let is_read = proposal.columns.iter().any(|c| c.file == k && c.mapping.is_ok());
        let hidden = if is_read { "" } else { "# no column of it is known: " };
        let mut entry = format!("  {hidden}{{ path = {}", toml_string(path));
        if let Some(topic) = &file.topic {
            entry += &format!(", topic = {}", toml_string(topic));
        }
        if let Some(clock) = &file.clock {
            entry += &format!(", clock = {}", toml_string(clock));
        }
        if file.text && file.delimiter != ',' {
            entry += &format!(", delimiter = {}", toml_string(&file.delimiter.to_string()));
        }
        if file.text && file.decimal != '.' {
            entry += &format!(", decimal = {}", toml_string(&file.decimal.to_string()));
        }
        if file.text && file.header != 1 {
            entry += &format!(", header = {}", file.header);
        }
        if file.text && file.first_row != file.header + 1 {
            entry += &format!(", rows = {}", file.first_row);
        }
        text += &format!("{entry} }},\n");
    }
    text += "]\n\n# [noise]               # one standard deviation, as the instruments' makers state it; else it is estimated\n\
             # tcp_position_m = 3e-5\n";
    let clocks: Vec<_> = proposal.files.iter().filter(|f| f.clock.is_some()).collect();
    for file in clocks {
        let name = file.clock.as_deref().unwrap_or_default();
        text += &format!(
            "\n[clock.{name}]    # offset and drift are fitted to the motion that both saw\n"
        );
        match &file.fitted {
            Some(fitted) => {
                text += &format!(
                    "# offset_s = {:.6}    # ± {:.1e} s by the encoders' motion; {:.1} mm left\n# drift = {:.2e}\n",
                    fitted.map.offset,
                    HALF_95 * fitted.deviation[0],
                    1e3 * fitted.left,
                    fitted.map.drift
                );
            }
            None => {
                text += "# offset_s = …           # its time where the log's own is 0, where it is known\n";
            }
        }
    }
    text += "\n[columns]\n";
    for (k, file) in proposal.files.iter().enumerate() {
        let shown = file.path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
        text += &format!("# {shown}\n");
        let columns: Vec<_> = proposal.columns.iter().filter(|c| c.file == k).collect();
        for column in columns.iter().filter(|c| c.mapping.is_ok()) {
            text += &line(column, proposal, &paths[k], accepted);
        }
        let (unknown, others): (Vec<_>, Vec<_>) = columns
            .iter()
            .filter_map(|c| Some((c, c.mapping.as_ref().err()?)))
            .partition(|(_, why)| **why == LeftOut::Unknown);
        for (column, why) in others {
            text += &format!("# {:?}    {}\n", column.header, left_out(why));
        }
        if !unknown.is_empty() {
            let headers: Vec<String> =
                unknown.iter().map(|(column, _)| format!("{:?}", column.header)).collect();
            text += &format!(
                "# not recognised: {}\n# Write a line for each of them that is a channel.\n",
                headers.join(", ")
            );
        }
    }
    text
}

/// The line of a column, its doubts to be filled in.
fn line(column: &ProposedColumn, proposal: &Proposal, path: &str, accepted: bool) -> String {
    let Ok(mapping) = &column.mapping else { return String::new() };
    // A header that two files have is told apart by the file.
    let twice = proposal.columns.iter().any(|c| c.file != column.file && c.header == column.header);
    let header = if twice { format!("{path}:{}", mapping.header) } else { mapping.header.clone() };
    let open = |doubt: &Doubt| matches!(doubt, Doubt::Unit | Doubt::Scale);
    let unit = match !accepted && column.doubts.iter().any(open) {
        true => format!("{FILL_IN}: {}?", mapping.unit),
        false => mapping.unit.to_owned(),
    };
    let channel = match !accepted && column.doubts.contains(&Doubt::Channel) {
        true => format!("{FILL_IN}: {}?", channel_name(mapping.column)),
        false => channel_name(mapping.column).to_owned(),
    };
    let mut line =
        format!("{} = {{ channel = \"{channel}\", unit = \"{unit}\"", toml_string(&header));
    let raw = unit_named(mapping.unit).is_some_and(|u| u.dimension.is_none());
    let held = dimension(mapping.column).unit();
    if column.doubts.contains(&Doubt::Factor) || (raw && !mapping.open) {
        line += &format!(", factor = \"{FILL_IN}: {held} per {}, at the joint\"", mapping.unit);
    } else if !accepted && column.doubts.contains(&Doubt::Sign) {
        line += &format!(", factor = \"{FILL_IN}: 1.0 or -1.0?\"");
    } else if mapping.factor != 1.0 {
        line += &format!(", factor = {:?}", mapping.factor);
    }
    line += &mapping.sum();
    let doubts = doubts(column);
    let fitted =
        if mapping.open { "; its factor is fitted, state it where it is known" } else { "" };
    let remark =
        if doubts.is_empty() { bases(column) + fitted } else { format!("not sure of {doubts}") };
    format!("{line} }}    # {remark}\n")
}
