//! How an uncertain number is distributed: a quantile at every standard normal.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use trueweld_plant::input::{Bounds, InputError, TomlTable, did_you_mean};

/// Standard deviations at which a distribution without bounds is cut off: 6 in 100 000 lie beyond.
pub(super) const CUT: f64 = 4.0;

/// How an uncertain number is distributed. Every distribution is cut off at its ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "name", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)]
pub enum Distribution {
    /// Known: the same in every cell.
    Fixed { value: f64 },
    /// Evenly between the ends.
    Uniform { low: f64, high: f64 },
    /// Its logarithm evenly between those of the ends.
    LogUniform { low: f64, high: f64 },
    /// Rising from the low end to the mode and falling to the high end.
    Triangular { low: f64, mode: f64, high: f64 },
    /// Normal.
    Normal { mean: f64, sd: f64, low: f64, high: f64 },
    /// Its logarithm is normal; `spread` is the standard deviation of that.
    Lognormal { median: f64, spread: f64, low: f64, high: f64 },
}

impl Distribution {
    /// Names, as in files.
    const NAMES: [&str; 6] =
        ["fixed", "uniform", "log-uniform", "triangular", "normal", "lognormal"];

    /// Its name, as in files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Fixed { .. } => "fixed",
            Self::Uniform { .. } => "uniform",
            Self::LogUniform { .. } => "log-uniform",
            Self::Triangular { .. } => "triangular",
            Self::Normal { .. } => "normal",
            Self::Lognormal { .. } => "lognormal",
        }
    }

    /// Smallest and largest value.
    pub fn ends(&self) -> [f64; 2] {
        match *self {
            Self::Fixed { value } => [value, value],
            Self::Uniform { low, high }
            | Self::LogUniform { low, high }
            | Self::Triangular { low, high, .. }
            | Self::Normal { low, high, .. }
            | Self::Lognormal { low, high, .. } => [low, high],
        }
    }

    /// The value at a standard normal: the quantile at Φ(z).
    pub fn value(&self, z: f64) -> f64 {
        let standard = Normal::standard();
        let u = standard.cdf(z);
        let [low, high] = self.ends();
        // The part of a normal that is left between two ends.
        let cut = |[a, b]: [f64; 2]| {
            let [a, b] = [standard.cdf(a), standard.cdf(b)];
            standard.inverse_cdf((a + u * (b - a)).clamp(0.0, 1.0))
        };
        let value = match *self {
            Self::Fixed { value } => value,
            Self::Uniform { .. } => low + u * (high - low),
            Self::LogUniform { .. } => low * (high / low).powf(u),
            Self::Triangular { mode, .. } if u * (high - low) < mode - low => {
                low + (u * (high - low) * (mode - low)).sqrt()
            }
            Self::Triangular { mode, .. } => {
                high - ((1.0 - u) * (high - low) * (high - mode)).sqrt()
            }
            Self::Normal { mean, sd, .. } => {
                mean + sd * cut([(low - mean) / sd, (high - mean) / sd])
            }
            Self::Lognormal { median, spread, .. } => {
                median * (spread * cut([low, high].map(|end| (end / median).ln() / spread))).exp()
            }
        };
        value.clamp(low, high)
    }

    pub(super) fn read(
        table: &TomlTable<'_>,
    ) -> Result<(Self, &'static [&'static str]), InputError> {
        let number = |key| table.number(key, Bounds::Any);
        let positive = |key| table.number(key, Bounds::Positive);
        let end = |key, without: f64| table.number_or(key, Bounds::Any, without);
        let name = table.text("distribution")?.text;
        let (read, keys): (Self, &[&str]) = match name {
            "fixed" => (Self::Fixed { value: number("value")? }, &["value"]),
            "uniform" => {
                (Self::Uniform { low: number("low")?, high: number("high")? }, &["low", "high"])
            }
            "log-uniform" => (
                Self::LogUniform { low: positive("low")?, high: positive("high")? },
                &["low", "high"],
            ),
            "triangular" => (
                Self::Triangular {
                    low: number("low")?,
                    mode: number("mode")?,
                    high: number("high")?,
                },
                &["low", "mode", "high"],
            ),
            "normal" => {
                let (mean, sd) = (number("mean")?, positive("sd")?);
                let (low, high) = (end("low", mean - CUT * sd)?, end("high", mean + CUT * sd)?);
                (Self::Normal { mean, sd, low, high }, &["mean", "sd", "low", "high"])
            }
            "lognormal" => {
                let (median, spread) = (positive("median")?, positive("spread")?);
                let factor = (CUT * spread).exp();
                let low = table.number_or("low", Bounds::Positive, median / factor)?;
                let high = end("high", median * factor)?;
                (
                    Self::Lognormal { median, spread, low, high },
                    &["median", "spread", "low", "high"],
                )
            }
            _ => {
                let guess = did_you_mean(name, Self::NAMES);
                return Err(table.wrong(
                    "distribution",
                    &format!("one of {}{guess}", Self::NAMES.join(", ")),
                    "Each has its own keys: see docs/certify.md.",
                ));
            }
        };
        let [low, high] = read.ends();
        let within = match read {
            Self::Fixed { .. } => true,
            Self::Triangular { mode, .. } => low < high && (low..=high).contains(&mode),
            _ => low < high,
        };
        if !within {
            return Err(table.wrong(
                "distribution",
                "ends in their order, and what lies between them between them",
                "low < high, and mode between them.",
            ));
        }
        Ok((read, keys))
    }
}
