//! Gains of any law as plain constants: a key with its numbers.
//!
//! A law's gains are a struct that it defines itself, read here through its `Deserialize`: no law
//! is named, and no law needs a line for it. Left out: gains that are no numbers.

use crate::gain::GainError;
use core::fmt;
use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{self, DeserializeOwned, Deserializer, IntoDeserializer, Visitor};

/// Bytes of a name, with the zero that ends it.
pub const NAME_BYTES: usize = 32;

/// Most gains of a law.
pub const GAINS: usize = 8;

/// Most numbers of one gain.
pub const GAIN_VALUES: usize = 6;

/// A character of a [`Name`]: `char` in C.
pub type Character = u8;

/// A name of ASCII characters, filled up with zeros.
#[repr(transparent)]
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Name(pub [Character; 32]);

impl Name {
    /// The first 31 bytes of a text: what is longer is the name of nothing.
    pub const fn new(text: &str) -> Self {
        let mut bytes = [0; NAME_BYTES];
        let mut from = text.as_bytes();
        let mut to: &mut [u8] = &mut bytes;
        // A const function has no iterators.
        while let ([byte, left @ ..], [place, free @ ..]) = (from, to) {
            if free.is_empty() {
                break;
            }
            *place = *byte;
            (from, to) = (left, free);
        }
        Self(bytes)
    }

    /// Its text; empty where it is none.
    pub fn as_str(&self) -> &str {
        let text = self.0.split(|byte| *byte == 0).next().unwrap_or_default();
        core::str::from_utf8(text).unwrap_or_default()
    }
}

impl fmt::Debug for Name {
    /// As Rust reads it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Name::new({:?})", self.as_str())
    }
}

/// One gain of a law.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainNumbers {
    /// Its key, as in a control file; the unit is its last part.
    pub key: Name,
    /// How many of the numbers count: 1, or as many as the gain has.
    pub count: u32,
    /// 0.
    pub reserved: u32,
    /// Its numbers.
    pub values: [f64; 6],
}

impl GainNumbers {
    /// A gain that is not there.
    pub const NONE: Self =
        Self { key: Name::new(""), count: 0, reserved: 0, values: [0.0; GAIN_VALUES] };

    /// A gain of these numbers; `None` where there are more than fit, or the key is too long.
    pub fn new(key: &str, numbers: &[f64]) -> Option<Self> {
        let mut gain = Self { key: Name::new(key), count: numbers.len() as u32, ..Self::NONE };
        gain.values.get_mut(..numbers.len())?.copy_from_slice(numbers);
        (gain.key.as_str() == key).then_some(gain)
    }

    fn numbers(&self) -> &[f64] {
        self.values.get(..self.count as usize).unwrap_or_default()
    }
}

/// The gains of a law from their numbers: all of them, or none for the law's defaults.
///
/// # Errors
/// A gain that is missing, unknown or of another shape.
pub(crate) fn gains<G: Default + DeserializeOwned>(
    numbers: &[GainNumbers],
) -> Result<G, GainError> {
    if numbers.is_empty() {
        return Ok(G::default());
    }
    G::deserialize(Gains(numbers)).map_err(|Refused(error)| error)
}

/// Why serde refused.
#[derive(Debug)]
struct Refused(GainError);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl core::error::Error for Refused {}

impl de::Error for Refused {
    fn custom<M: fmt::Display>(_: M) -> Self {
        Self(GainError { key: "gain", expected: "a number, or as many as the gain has" })
    }

    fn missing_field(key: &'static str) -> Self {
        Self(GainError { key, expected: "a number beside the other gains of its law" })
    }
}

/// A law's gains as serde's input.
struct Gains<'a>(&'a [GainNumbers]);

impl<'de> Deserializer<'de> for Gains<'_> {
    type Error = Refused;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        let entries = self.0.iter().map(|gain| (gain.key.as_str(), GainValues(gain.numbers())));
        visitor.visit_map(MapDeserializer::new(entries))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        keys: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refused> {
        if !self.0.iter().all(|gain| keys.contains(&gain.key.as_str())) {
            return Err(Refused(GainError { key: "gain", expected: "a gain that the law has" }));
        }
        self.deserialize_any(visitor)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option
        unit unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

/// The numbers of one gain as serde's input.
#[derive(Clone, Copy)]
struct GainValues<'a>(&'a [f64]);

impl<'de> IntoDeserializer<'de, Refused> for GainValues<'_> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for GainValues<'_> {
    type Error = Refused;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        match self.0 {
            [one] => visitor.visit_f64(*one),
            _ => Err(de::Error::custom("")),
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Refused> {
        if self.0.len() != length {
            return Err(de::Error::custom(""));
        }
        visitor.visit_seq(SeqDeserializer::new(self.0.iter().copied()))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option
        unit unit_struct newtype_struct seq tuple_struct map struct enum identifier ignored_any
    }
}
