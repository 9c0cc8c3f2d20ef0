//! `[posterior]` of a model: what measurements leave open of its numbers, all of them together.
//!
//! A number is a parameter of an effect at a place; its value is that of the whole effect, in place
//! of the one in `[[effect]]`, and an effect that the model does not list is one of the cell
//! nevertheless. The seal is a digest of the robot, the process, the effects and the table itself: a
//! posterior does not outlive a change of what it belongs to.
//!
//! ```toml
//! [posterior]
//! logs = ["static", "free"]
//! names = ["stiffness-error.relative", "backlash.half_gap_rad"]
//! at = ["A2", "A5"]
//! values = [0.013, 2.4e-4]
//! between_logs = [0.0, 0.0]        # standard deviation from log to log
//! covariance = [1e-6, 0.0, 4e-12]  # lower triangle, row by row
//! ```

use super::place::place_of;
use super::table::TomlTable;
use super::{Bounds, InputError, RobotFile, did_you_mean};
use crate::effects::{EffectKind, EffectPlace, Location};
use schemars::JsonSchema;
use serde::Serialize;

/// Most numbers of a posterior.
const POSTERIOR_NUMBERS_MAX: usize = 400;

/// One measured number: a parameter of an effect.
#[derive(Debug, Clone)]
pub struct MeasuredNumber {
    /// Kind of the effect.
    pub kind: &'static EffectKind,
    /// Where the effect is.
    pub at: Location,
    /// Which of the effects of this kind at this place, from 0, in the order of the model file.
    pub occurrence: usize,
    /// Which of its parameters.
    pub parameter: usize,
    /// Mean, in the parameter's unit; of a number that varies from log to log, over the logs.
    pub value: f64,
    /// Standard deviation from log to log, in the parameter's unit; 0 for a number of the cell.
    pub between_logs: f64,
}

// What measurements leave open of the numbers of a cell, jointly normal.
/// What was measured of a cell.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "MeasurementRecord", deny_unknown_fields)]
pub struct Posterior {
    /// The numbers.
    #[serde(skip)]
    pub numbers: Vec<MeasuredNumber>,
    /// Covariance of the values, lower triangle row by row.
    #[serde(skip)]
    pub covariance: Vec<f64>,
    /// Names of the logs.
    pub logs: Vec<String>,
    /// SHA-256 of the SHA-256 of every file of the logs, in their order.
    #[serde(rename = "campaign_sha256")]
    pub campaign: String,
    /// Score of the model where nothing was fitted; 1.0 is the noise floor.
    pub score: f64,
    // Beyond there is no distribution.
    /// Numbers whose values stand at the bound of what is possible.
    pub at_bound: Vec<String>,
    // Of effects, as wide as they are stated, or wider.
    /// Numbers that the logs hardly determine.
    pub undetermined: Vec<String>,
    /// Numbers of which the logs say next to nothing: they are not among those measured.
    pub not_measured: Vec<String>,
    /// Digest of what this belongs to, as the file states it.
    #[serde(skip)]
    pub seal: String,
}

impl MeasuredNumber {
    /// The effect that it is of, and where.
    pub fn effect(&self) -> EffectPlace {
        EffectPlace { kind: self.kind, at: self.at }
    }

    /// Its name in files: kind, parameter, and which of several alike.
    pub fn key(&self) -> String {
        let name = format!("{}.{}", self.kind.id, self.kind.parameters[self.parameter].name);
        match self.occurrence {
            0 => name,
            n => format!("{name}.{}", n + 1),
        }
    }
}

impl Posterior {
    /// Covariance of two of the values, by their indices.
    pub fn covariance_of(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.max(j), i.min(j));
        self.covariance[i * (i + 1) / 2 + j]
    }

    /// Standard deviation of a value, by its index; that from log to log is no part of it.
    pub fn deviation(&self, i: usize) -> f64 {
        self.covariance_of(i, i).sqrt()
    }

    /// Reads the table. `kind`: the effect of an identifier.
    pub(super) fn read(
        table: &TomlTable<'_>,
        kind: impl Fn(&str) -> Option<&'static EffectKind>,
        robot: &RobotFile,
    ) -> Result<Self, InputError> {
        table.only(&[
            "logs",
            "campaign_sha256",
            "score",
            "names",
            "at",
            "values",
            "between_logs",
            "covariance",
            "at_bound",
            "undetermined",
            "not_measured",
            "sha256",
        ])?;
        let texts = |key: &str| -> Result<Vec<String>, InputError> {
            let texts = table.optional(key, TomlTable::texts)?.unwrap_or_default();
            Ok(texts.into_iter().map(|text| text.text.to_owned()).collect())
        };
        let names = texts("names")?;
        let places = texts("at")?;
        let count = names.len();
        let values = list(table, "values", Bounds::Any, [count, count])?;
        let between = list(table, "between_logs", Bounds::NonNegative, [count, count])?;
        let triangle = [count * (count + 1) / 2, count];
        let covariance = list(table, "covariance", Bounds::Product, triangle)?;
        if places.len() != count || count > POSTERIOR_NUMBERS_MAX {
            let expected = format!(
                "{count} places, one for each of `names`, and at most {POSTERIOR_NUMBERS_MAX}"
            );
            return Err(table.wrong("at", &expected, "\"\" for an effect of the whole cell."));
        }
        let mut numbers: Vec<MeasuredNumber> = Vec::new();
        for (k, (name, place)) in names.iter().zip(&places).enumerate() {
            let wrong = |what: &str| {
                table.wrong(
                    "names",
                    &format!("{what} (read {name:?} at {place:?})"),
                    "ID.PARAMETER",
                )
            };
            let mut parts = name.splitn(3, '.');
            let (id, of) = (parts.next().unwrap_or(""), parts.next().unwrap_or(""));
            let kind = kind(id).ok_or_else(|| wrong("an effect of the library or of this file"))?;
            let parameter = kind.parameters.iter().position(|p| p.name == of);
            let parameter = parameter.ok_or_else(|| {
                let guess = did_you_mean(of, kind.parameters.iter().map(|p| p.name));
                wrong(&format!("a parameter of {id}{guess}"))
            })?;
            let occurrence = match parts.next().map(str::parse::<usize>) {
                None => 0,
                Some(Ok(n)) if n > 1 => n - 1,
                Some(_) => return Err(wrong("a number from 2 on behind the parameter")),
            };
            let at = place_of(kind, place, robot).map_err(|expected| wrong(&expected))?;
            let number = MeasuredNumber {
                kind,
                at,
                occurrence,
                parameter,
                value: values[k],
                between_logs: between[k],
            };
            if !kind.parameters[parameter].holds(number.value) {
                return Err(wrong("a value that the parameter may have"));
            }
            if numbers.iter().any(|n| n.key() == number.key() && n.at == at) {
                return Err(wrong("every number once"));
            }
            numbers.push(number);
        }
        let read = Self {
            numbers,
            covariance,
            logs: texts("logs")?,
            campaign: table.name("campaign_sha256")?,
            score: table.number("score", Bounds::NonNegative)?,
            at_bound: texts("at_bound")?,
            undetermined: texts("undetermined")?,
            not_measured: texts("not_measured")?,
            seal: table.name("sha256")?,
        };
        // NaN is refused as a number already.
        match (0..count).find(|k| read.covariance_of(*k, *k) < 0.0) {
            Some(k) => Err(table.wrong(
                "covariance",
                &format!("no variance below zero, as number {} has", k + 1),
                "The lower triangle, row by row.",
            )),
            None => Ok(read),
        }
    }
}

/// So many numbers, for so many names; where there are none the key may be left out.
fn list(
    table: &TomlTable<'_>,
    key: &str,
    bounds: Bounds<'_>,
    [count, names]: [usize; 2],
) -> Result<Vec<f64>, InputError> {
    if count == 0 && !table.has(key) {
        return Ok(Vec::new());
    }
    let most = POSTERIOR_NUMBERS_MAX * (POSTERIOR_NUMBERS_MAX + 1) / 2;
    let list = table.list(key, most, bounds)?;
    if list.len() == count {
        return Ok(list);
    }
    let expected = format!("{count} numbers, for {names} names");
    Err(table.wrong(key, &expected, "One for each of `names`, in their order."))
}
