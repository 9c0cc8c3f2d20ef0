//! A value of a file with its place.

use super::bounds::Bounds;
use super::error::{InputError, Source};
use super::quantity::{Judgement, quantity, warn};
use std::ops::Range;
use toml::Spanned;
use toml::de::DeValue;

/// Text that stands for a value still to be written, as [`import_urdf`](super::import_urdf) leaves
/// it.
pub const FILL_IN: &str = "FILL IN";

/// Text as TOML writes it.
pub fn toml_string(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A piece of text and where it stands.
#[derive(Debug, Clone)]
pub struct Text<'d> {
    /// The text.
    pub text: &'d str,
    /// Byte range in the file.
    pub span: Range<usize>,
}

/// A value, its place and how it is called in errors.
pub(super) struct TomlValue<'d> {
    pub source: &'d Source,
    pub value: &'d DeValue<'d>,
    pub span: Range<usize>,
    pub key_span: Range<usize>,
    pub what: String,
}

impl<'d> TomlValue<'d> {
    pub(crate) fn entry(&self, index: usize, item: &'d Spanned<DeValue<'d>>) -> TomlValue<'d> {
        TomlValue {
            source: self.source,
            value: item.get_ref(),
            span: item.span(),
            key_span: self.key_span.clone(),
            what: format!("entry {} of {}", index + 1, self.what),
        }
    }

    pub(crate) fn number(&self, bounds: Bounds<'_>, expected: &str) -> Result<f64, InputError> {
        let number = match self.value {
            DeValue::Integer(i) => {
                i128::from_str_radix(i.as_str(), i.radix()).ok().map(|i| i as f64)
            }
            DeValue::Float(f) => f.as_str().parse().ok(),
            DeValue::String(text) if text.starts_with(FILL_IN) => {
                return Err(self.unfilled(expected));
            }
            _ => None,
        };
        match number {
            Some(x) if bounds.hold(x) => {
                let of = match bounds {
                    Bounds::Of(key) => quantity(key),
                    Bounds::In(quantity) => Some(quantity),
                    _ => None,
                };
                if let Some(quantity) = of
                    && quantity.judge(x) == Judgement::Implausible
                {
                    let place = self.source.place(self.span.start);
                    let (what, read, usual) = (&self.what, self.read(), quantity.usual());
                    warn(format!("{place}: {what} is {read}; plausible are {usual}"));
                }
                Ok(x)
            }
            Some(x) if x.is_finite() && x.abs() > bounds.largest() => {
                let help = "No quantity of a welding cell in SI units is that large; check the exponent and the unit.";
                let most = bounds.largest();
                Err(self.wrong(&format!("{expected}, at most {most:e} in magnitude"), help))
            }
            Some(_) => Err(self.wrong(expected, format!("Write {expected}."))),
            None => {
                Err(self.wrong(expected, "Write the number without quotes and without its unit."))
            }
        }
    }

    pub(crate) fn unfilled(&self, expected: &str) -> InputError {
        let message =
            format!("{} is still to be filled in: {}; expected {expected}", self.what, self.read());
        let help = format!(
            "Write {expected}, from a data sheet, a measurement or an estimate (and say which in a comment). \
             It is not guessed, because a wrong value would pass unnoticed."
        );
        self.source.error(self.span.clone(), message, "to be filled in", help)
    }

    pub(crate) fn wrong(&self, expected: &str, help: impl Into<String>) -> InputError {
        let message = format!("{} is {}; expected {expected}", self.what, self.read());
        let span = if self.span.is_empty() { self.key_span.clone() } else { self.span.clone() };
        // What is long is said once, in the message.
        let label = if expected.len() <= 80 {
            format!("expected {expected}")
        } else {
            "not this".to_owned()
        };
        self.source.error(span, message, label, help)
    }

    fn read(&self) -> String {
        match self.value {
            // The place of a table is its header, unless it is written in braces.
            DeValue::Table(_) if !self.source.excerpt(self.span.clone()).starts_with('{') => {
                "a table".to_owned()
            }
            _ => self.source.excerpt(self.span.clone()),
        }
    }
}
