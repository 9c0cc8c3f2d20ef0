//! A file of gains: `control/1`. Each controller of the table reads its own.

use super::control::{CompensationLimits, Control};
use super::{FileKind, InputError, InputFile, TomlTable};
use crate::controllers::{blank, controllers};
use trueweld_compensators::{Entry, FollowingGains, GainTables, Setup, find, library};
use trueweld_core::compensation::LoopLimits;

impl InputFile for Control {
    const KIND: FileKind = FileKind::Control;

    fn from_root(root: &TomlTable<'_>) -> Result<Self, InputError> {
        let names = controllers().iter().map(|controller| controller.name);
        let keys = ["schema", "period_s"].into_iter().chain(names).chain(["compensation", "law"]);
        root.only(&keys.collect::<Vec<_>>())?;
        let period = root.quantity("period_s")?;
        let compensation = compensation(&root.table("compensation")?)?;
        let mut control = blank(period, compensation);
        for controller in controllers() {
            if !controller.optional || root.has(controller.name) {
                (controller.read)(&root.table(controller.name)?, &mut control)?;
            }
        }
        control.laws = laws(root, &control.setup(1.0))?;
        Ok(control)
    }
}

/// Where the range of a gain comes from.
const GAIN_RANGE_SOURCE: &str =
    "The law cannot be built with this gain at the control period of this file.";

/// The `[law.NAME]` tables: each must name a law and gains that the law has, with values that it
/// can be built with.
fn laws(root: &TomlTable<'_>, setup: &Setup<f64>) -> Result<GainTables, InputError> {
    let mut gains = GainTables::new();
    if !root.has("law") {
        return Ok(gains);
    }
    let laws = root.table("law")?;
    let combined = laws.keys().into_iter().filter(|name| find(name).is_ok());
    let known: Vec<&str> = library().iter().map(Entry::name).chain(combined).collect();
    laws.only(&known)?;
    for law in laws.keys().into_iter().flat_map(find) {
        let table = laws.table(law.name())?;
        gains.insert(law.name().to_owned(), table.like(&law.defaults())?);
        law.build(&gains, setup).map_err(|error| match error.key {
            Some(key) if table.has(key) => table.wrong(key, &error.problem, GAIN_RANGE_SOURCE),
            _ => laws.wrong(law.name(), "gains that suit the law", error.to_string()),
        })?;
    }
    Ok(gains)
}

fn compensation(table: &TomlTable<'_>) -> Result<CompensationLimits, InputError> {
    table.only(&[
        "bandwidth_hz",
        "max_translation_m",
        "max_rotation_rad",
        "max_translation_rate_m_s",
        "max_rotation_rate_rad_s",
        "following_rad_s",
        "following_along_rad_s",
        "following_max_m",
    ])?;
    let bandwidth = table.quantity("bandwidth_hz")? * std::f64::consts::TAU;
    let rate = table.quantity("following_rad_s")?;
    Ok(CompensationLimits {
        lateral: LoopLimits {
            bandwidth,
            size: table.quantity("max_translation_m")?,
            rate: table.quantity("max_translation_rate_m_s")?,
        },
        orientation: LoopLimits {
            bandwidth,
            size: table.quantity("max_rotation_rad")?,
            rate: table.quantity("max_rotation_rate_rad_s")?,
        },
        following: FollowingGains {
            rate,
            along: table.quantity_or("following_along_rad_s", FollowingGains::default().along)?,
            size: table.quantity("following_max_m")?,
        },
    })
}
