//! What a compensation law must reach, and under what uncertainty: `requirements/1`.

use crate::certify::{FAULT_FIGURES, FaultSizes};
use crate::figure::{Figure, Limit, within};
use crate::margins::MARGIN_FIGURES;
use crate::uncertain::{NoSuchNumber, UncertainCell, UncertainEntry, Uncertainty};
use crate::weld::{ASKED_FIGURES, AskedWeld, WELD_FIGURES, WELD_PHASES};
use std::fmt;
use trueweld_plant::input::{
    Bounds, CompensationLimits, FileKind, InputError, InputFile, Process, RobotFile, Sensors, Text,
    TomlTable, Weld,
};
use trueweld_plant::sensors::fault_name;

/// Requirements of a certification.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirements {
    /// The most that figures of a weld may be, in the order of [`WELD_FIGURES`]: of its steady part,
    /// and of the phases beside it.
    pub limits: Vec<Limit>,
    /// Share of welds that may fail a requirement.
    pub failure_probability: f64,
    /// Confidence with which that must be shown.
    pub confidence: f64,
    /// What is not known of the cell, in short.
    pub uncertainty: Uncertainty,
    /// The same number by number, `[[uncertain]]`.
    pub uncertain: Vec<UncertainEntry>,
    /// Limits that the worst cell found within the uncertainty must keep, in the same order.
    pub worst_case: Vec<Limit>,
    /// Margins of the loop along the weld; `None` where none are asked for.
    pub margins: Option<MarginLimits>,
    /// Instruments that fail, and what the tool must keep to then; `None` where no fault is asked
    /// for.
    pub faults: Option<Faults>,
}

/// What the margins of the loop must be at least, wherever they are looked at. A loop that is not
/// stable keeps none.
#[derive(Debug, Clone, PartialEq)]
pub struct MarginLimits {
    /// Places along the steady part of the weld, both ends included.
    pub places: usize,
    /// Drawn cells, spread along it as well.
    pub draws: usize,
    /// The least that they may be there and in the ramps of push and feed: those that the file
    /// states, then what is asked of the drives where it states nothing of them.
    pub at_least: Vec<Limit>,
}

/// Margins of corrections and force, and the same of the drives at work.
const DRIVES_AT_WORK: [(&str, &str); 4] = [
    ("gain_margin", "drive_gain_margin_at_speed"),
    ("phase_margin_rad", "drive_phase_margin_at_speed_rad"),
    ("modulus_margin", "drive_modulus_margin_at_speed"),
    ("disk_margin", "drive_disk_margin_at_speed"),
];

impl MarginLimits {
    /// What is asked of the drives where the file asks nothing, at work and with friction at each
    /// drive's speed: half of the phase and of the distance, and half of the decibels, that are asked
    /// of corrections and force. The position loop of a heavy arm stands near its first mode, and
    /// keeps less than the loops around it. A drive's delay is a share of the period that it is
    /// sampled with anyway.
    fn of_drives(stated: &[Limit]) -> Vec<Limit> {
        let value = |key: &str| Some(stated.iter().find(|l| l.figure.key == key)?.value);
        let each = DRIVES_AT_WORK.iter().filter_map(|(key, at_work)| {
            let asked = value(key)?;
            if value(&format!("drive_{key}")).or(value(at_work)).is_some() {
                return None;
            }
            let of = MARGIN_FIGURES.iter().find(|of| of.figure.key == *at_work)?;
            let half = if key.contains("gain") { asked.sqrt() } else { 0.5 * asked };
            Some(Limit { figure: &of.figure, value: half })
        });
        each.collect()
    }
}

/// One instrument at a time that fails in the steady part of a weld and comes back, and what the
/// tool must keep to.
#[derive(Debug, Clone, PartialEq)]
pub struct Faults {
    /// Places along the steady part of the nominal weld.
    pub places: usize,
    /// Drawn cells, spread along it as well.
    pub draws: usize,
    /// How long a fault lasts, s.
    pub duration: f64,
    /// Time after its end in which the tool must be back within the limits of the steady part, s.
    pub recovery: f64,
    /// Largest lateral deviation from the beginning of the fault to the end of that time, m.
    pub lateral: f64,
    /// How far depth may go from its mean before the fault in the same time, m.
    pub depth: f64,
    /// What instruments are made to read.
    pub sizes: FaultSizes,
    /// What is not required of faults: it is run and told, and not judged.
    pub not_required: Vec<NotRequired>,
}

/// Figures of a fault that are not required, because no law can keep them.
#[derive(Debug, Clone, PartialEq)]
pub struct NotRequired {
    /// Name of the fault, as in "force-offset".
    pub fault: String,
    /// Keys of figures of [`FAULT_FIGURES`].
    pub figures: Vec<&'static str>,
    /// Why no law can keep them.
    pub reason: String,
}

impl Faults {
    /// What is not required of a figure of a fault; `None` where it is required.
    pub fn not_required(&self, fault: &str, figure: &str) -> Option<&NotRequired> {
        self.not_required.iter().find(|of| of.fault == fault && of.figures.contains(&figure))
    }
}

impl Requirements {
    /// All that is not known of a cell of this robot, process and these sensors.
    ///
    /// # Errors
    /// [`NoSuchNumber`] where the cell has not got a number that the file calls uncertain.
    pub fn uncertain_cell(
        &self,
        robot: &RobotFile,
        process: &Process,
        sensors: &Sensors,
    ) -> Result<UncertainCell, NoSuchNumber> {
        UncertainCell::of(&self.uncertainty, &self.uncertain, robot, process, sensors)
    }

    /// What is asked of one weld under a control file: the limits of the file, and that it is the
    /// weld that was asked for ([`AskedWeld`]) in every figure that the file does not limit itself.
    /// A limit that corrections are held to anyway shows nothing and is left out ([`held`]).
    ///
    /// # Errors
    /// [`IdleLimit`] where a limit of the file can show nothing.
    ///
    /// [`held`]: Self::held
    pub fn of_weld(
        &self,
        weld: &Weld,
        planned: &Process,
        authority: &CompensationLimits,
    ) -> Result<Self, IdleLimit> {
        let asked = AskedWeld::new(weld, planned);
        for (table, limits) in [("limits", &self.limits), ("worst_case", &self.worst_case)] {
            for Limit { figure, value } in limits {
                let idle = |why| IdleLimit { table, figure, value: *value, why };
                // Of all parts only the start may be left out.
                if figure.phase() == WELD_PHASES[0] && weld.settle <= 0.0 {
                    return Err(idle(WhyIdle::NoStart));
                }
                let most = asked.most(figure.key_in_phase());
                if let Some(most) = most.filter(|most| !within(*value, *most)) {
                    return Err(idle(WhyIdle::Loose(most)));
                }
            }
        }
        let exceedable = |limits: &[Limit]| -> Vec<Limit> {
            limits.iter().copied().filter(|limit| !is_held(limit, authority)).collect()
        };
        let implied = |figure: &'static Figure| {
            let is_asked = ASKED_FIGURES.contains(&figure.key);
            let value = asked.most(figure.key).filter(|_| is_asked)?;
            Some(Limit { figure, value })
        };
        let all = WELD_FIGURES.iter().filter_map(|of| {
            let stated = self.limits.iter().find(|limit| limit.figure.key == of.figure.key);
            stated.copied().or_else(|| implied(&of.figure))
        });
        Ok(Self {
            limits: exceedable(&all.collect::<Vec<_>>()),
            worst_case: exceedable(&self.worst_case),
            ..self.clone()
        })
    }

    /// Limits of corrections that [`of_weld`](Self::of_weld) leaves out of `self`: the authority of
    /// the control file is within them, and no correction comes beyond.
    pub fn held(&self, of_weld: &Self) -> Vec<Limit> {
        let left = |limit: &&Limit| !of_weld.limits.contains(limit);
        self.limits.iter().filter(left).copied().collect()
    }

    /// The limit of a figure of a weld, by its key.
    pub fn limit(&self, key: &str) -> Option<f64> {
        self.limits.iter().find(|limit| limit.figure.key == key).map(|limit| limit.value)
    }
}

/// True for a limit that corrections within their authority keep anyway.
fn is_held(limit: &Limit, authority: &CompensationLimits) -> bool {
    let most = match limit.figure.key {
        "correction_m" => authority.lateral.size,
        "correction_rad" => authority.orientation.size,
        _ => f64::INFINITY,
    };
    within(most, limit.value)
}

/// A limit of a requirements file that can show nothing of a weld.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IdleLimit {
    table: &'static str,
    figure: &'static Figure,
    value: f64,
    why: WhyIdle,
}

/// Why a limit can show nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
enum WhyIdle {
    /// The weld that was asked for does not come to more than this.
    Loose(f64),
    /// The weld has no part before its force loop closes.
    NoStart,
}

impl std::error::Error for IdleLimit {}

impl fmt::Display for IdleLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { table, figure, value, why } = self;
        let part = figure.phase();
        let dot = if part.is_empty() { "" } else { "." };
        let unit = if figure.unit == "1" { String::new() } else { format!(" {}", figure.unit) };
        write!(
            f,
            "`{}` in [{table}{dot}{part}] is {value}{unit}; expected ",
            figure.key_in_phase()
        )?;
        match why {
            WhyIdle::Loose(most) => write!(
                f,
                "at most {}{unit}: beyond that it is not the weld that was asked for, whatever \
                 the file says",
                (1e4 * most).round() / 1e4
            ),
            WhyIdle::NoStart => f.write_str(
                "no limit of the start: settle_s of the weld is 0, and nothing of it is before the \
                 force loop closes",
            ),
        }
    }
}

impl InputFile for Requirements {
    const KIND: FileKind = FileKind::Requirements;

    fn from_root(root: &TomlTable<'_>) -> Result<Self, InputError> {
        root.only(&[
            "schema",
            "failure_probability",
            "confidence",
            "limits",
            "uncertainty",
            "uncertain",
            "worst_case",
            "margins",
            "faults",
        ])?;
        Ok(Self {
            limits: of_weld(&root.table("limits")?)?,
            failure_probability: root.quantity("failure_probability")?,
            confidence: root.quantity("confidence")?,
            uncertainty: uncertainty(&root.table("uncertainty")?)?,
            uncertain: root.each_table("uncertain", UncertainEntry::read)?,
            worst_case: root.optional_table("worst_case", of_weld)?.unwrap_or_default(),
            margins: root.optional_table("margins", margins)?,
            faults: root.optional_table("faults", faults)?,
        })
    }
}

/// Limits of the steady part, and in tables of their names those of the phases beside it.
fn of_weld(table: &TomlTable<'_>) -> Result<Vec<Limit>, InputError> {
    let of_phase = |phase: &'static str| {
        WELD_FIGURES.iter().map(|of| &of.figure).filter(move |figure| figure.phase() == phase)
    };
    let mut all = limits(table, &WELD_PHASES, of_phase(""))?;
    for phase in WELD_PHASES.into_iter().filter(|phase| table.has(phase)) {
        all.extend(limits(&table.table(phase)?, &[], of_phase(phase))?);
    }
    Ok(all)
}

/// The limits of a table, whose other keys are given.
fn limits(
    table: &TomlTable<'_>,
    others: &[&'static str],
    figures: impl Iterator<Item = &'static Figure> + Clone,
) -> Result<Vec<Limit>, InputError> {
    let keys = figures.clone().map(Figure::key_in_phase);
    table.only(&others.iter().copied().chain(keys).collect::<Vec<_>>())?;
    figures
        .filter(|figure| table.has(figure.key_in_phase()))
        .map(|figure| Ok(Limit { figure, value: table.quantity(figure.key_in_phase())? }))
        .collect()
}

fn margins(table: &TomlTable<'_>) -> Result<MarginLimits, InputError> {
    let figures = MARGIN_FIGURES.iter().map(|of| &of.figure);
    let mut at_least = limits(table, &["places", "draws"], figures)?;
    at_least.extend(MarginLimits::of_drives(&at_least));
    let hint = "Such as 11: one every tenth of the weld.";
    Ok(MarginLimits { places: whole(table, "places", 2, hint)?, draws: draws(table)?, at_least })
}

/// A whole number, and no less than the least.
fn whole(table: &TomlTable<'_>, key: &str, least: usize, hint: &str) -> Result<usize, InputError> {
    let number = table.number(key, Bounds::UpTo(1000.0))?;
    if number < least as f64 || number.fract() != 0.0 {
        return Err(table.wrong(key, &format!("a whole number from {least} up"), hint));
    }
    Ok(number as usize)
}

/// Drawn cells, none where the table has no word of them.
fn draws(table: &TomlTable<'_>) -> Result<usize, InputError> {
    if table.has("draws") { whole(table, "draws", 0, "Such as 5.") } else { Ok(0) }
}

fn faults(table: &TomlTable<'_>) -> Result<Faults, InputError> {
    table.only(&[
        "places",
        "draws",
        "duration_s",
        "recovery_s",
        "lateral_max_m",
        "depth_max_m",
        "force_range_n",
        "force_range_nm",
        "force_offset_n",
        "force_offset_nm",
        "force_gain",
        "seam_range_m",
        "seam_range_rad",
        "seam_offset_m",
        "seam_offset_rad",
        "not_required",
    ])?;
    let at_most = |key, most| table.number(key, Bounds::PositiveUpTo(most));
    Ok(Faults {
        places: whole(table, "places", 1, "Such as 3: early in the weld, in its middle, late.")?,
        draws: draws(table)?,
        duration: at_most("duration_s", 1000.0)?,
        recovery: at_most("recovery_s", 1000.0)?,
        lateral: at_most("lateral_max_m", 1.0)?,
        depth: at_most("depth_max_m", 1.0)?,
        sizes: FaultSizes {
            force_range: [
                table.number("force_range_n", Bounds::Positive)?,
                table.number("force_range_nm", Bounds::Positive)?,
            ],
            force_offset: [
                table.number("force_offset_n", Bounds::Positive)?,
                table.number("force_offset_nm", Bounds::Positive)?,
            ],
            force_gain: at_most("force_gain", 1.0)?,
            seam_range: [at_most("seam_range_m", 1.0)?, at_most("seam_range_rad", 1.0)?],
            seam_offset: [at_most("seam_offset_m", 1.0)?, at_most("seam_offset_rad", 1.0)?],
        },
        not_required: table.each_table("not_required", not_required)?,
    })
}

fn not_required(table: &TomlTable<'_>) -> Result<NotRequired, InputError> {
    table.only(&["fault", "figures", "reason"])?;
    let fault = table.name("fault")?;
    let known = FaultSizes::default().failures([0.0; 2]).into_iter();
    let known: Vec<String> = known.map(|(of, failure)| fault_name(of, failure)).collect();
    if !known.contains(&fault) {
        let expected = format!("one of {}", known.join(", "));
        return Err(table.wrong("fault", &expected, "A certificate names each fault so."));
    }
    let figures = table.texts("figures")?;
    let key = |text: &Text<'_>| fault_figure(table, text);
    let figures = figures.iter().map(key).collect::<Result<_, _>>()?;
    Ok(NotRequired { fault, figures, reason: table.name("reason")? })
}

/// The key of the figure of a fault that a text names.
fn fault_figure(table: &TomlTable<'_>, text: &Text<'_>) -> Result<&'static str, InputError> {
    let keys = || FAULT_FIGURES.iter().map(|of| of.figure.key);
    keys().find(|key| *key == text.text).ok_or_else(|| {
        let keys: Vec<&str> = keys().collect();
        let message = format!("no figure of a fault; expected one of {}", keys.join(", "));
        table.error_at(text, message, "The page of a certificate lists them under faults.")
    })
}

fn uncertainty(table: &TomlTable<'_>) -> Result<Uncertainty, InputError> {
    table.only(&["stiffness", "process", "ripple", "crosstalk", "delay_periods"])?;
    let delay = table.numbers::<2>("delay_periods", Bounds::UpTo(20.0))?;
    if delay[0] > delay[1] {
        return Err(table.wrong(
            "delay_periods",
            "the least first, then the most",
            "Such as [1.0, 2.0].",
        ));
    }
    // A stiffness or a gain of nothing is no cell.
    let relative = |key| table.number(key, Bounds::UpTo(0.9));
    Ok(Uncertainty {
        stiffness: relative("stiffness")?,
        process: relative("process")?,
        ripple: table.number("ripple", Bounds::UpTo(1.0))?,
        crosstalk: table.number("crosstalk", Bounds::UpTo(0.2))?,
        delay,
    })
}
