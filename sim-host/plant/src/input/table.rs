//! One table of a TOML file: its keys, its values, and errors at their places.

use super::bounds::Bounds;
use super::error::{InputError, Source};
use super::nearest::nearest;
use super::quantity::{Quantity, quantity};
use super::unit::unit_of;
use super::value::{FILL_IN, Text, TomlValue};
use nalgebra::Vector3;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// One table of a [`TomlDocument`](super::TomlDocument).
#[derive(Debug, Clone)]
pub struct TomlTable<'d> {
    pub(super) source: &'d Source,
    pub(super) table: &'d DeTable<'d>,
    pub(super) place: String,
    /// Of the header; empty at the file's start for the top level.
    pub(super) span: Range<usize>,
}

impl<'d> TomlTable<'d> {
    /// Refuses every key that is not listed.
    ///
    /// # Errors
    /// The first unknown key, with the known one it resembles.
    pub fn only(&self, known: &[&str]) -> Result<(), InputError> {
        let mut unknown: Vec<_> =
            self.table.keys().filter(|key| !known.contains(&key.get_ref().as_ref())).collect();
        unknown.sort_by_key(|key| key.span().start);
        let Some(key) = unknown.first() else {
            return Ok(());
        };
        let help = match nearest(key.get_ref(), known.iter().copied()) {
            Some(near) => format!("Did you mean `{near}`?"),
            None => format!("The keys here are {}.", quoted(known)),
        };
        let name = key.get_ref().escape_debug();
        let message =
            format!("unknown key `{name}` {}; expected one of {}", self.place, quoted(known));
        Err(self.source.error(key.span(), message, "unknown key", help))
    }

    /// Adds a name to how this table is called in errors, for tables that come in lists.
    #[must_use]
    pub fn called(mut self, name: &str) -> Self {
        self.place = format!("{} ({name})", self.place);
        self
    }

    /// Entries still to be filled in here and in the tables below, each with where it stands.
    pub(super) fn open_entries(&self) -> Vec<(usize, InputError)> {
        let mut open = Vec::new();
        for key in self.keys() {
            let below = self.tables(key).or_else(|_| self.table(key).map(|table| vec![table]));
            for table in below.unwrap_or_default() {
                let table = match table.name("name") {
                    Ok(name) => table.called(&name),
                    Err(_) => table,
                };
                open.append(&mut table.open_entries());
            }
            if let Some((_, value)) = self.table.get_key_value(key)
                && let DeValue::String(text) = value.get_ref()
                && text.starts_with(FILL_IN)
            {
                let expected = quantity(key)
                    .map_or("a value".to_owned(), |q| format!("{} ({})", q.expected(), q.meaning));
                open.extend(self.value(key, &expected).err().map(|e| (value.span().start, e)));
            }
        }
        open
    }

    /// True where the key is written.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// What `read` makes of a key; `None` where the key is left out.
    ///
    /// # Errors
    /// Those of `read`.
    pub fn optional<T>(
        &self,
        key: &str,
        read: impl FnOnce(&Self, &str) -> Result<T, InputError>,
    ) -> Result<Option<T>, InputError> {
        self.has(key).then(|| read(self, key)).transpose()
    }

    /// The same of the table under a key.
    ///
    /// # Errors
    /// As [`TomlTable::table`], and those of `read`.
    pub fn optional_table<T>(
        &self,
        key: &str,
        read: impl FnOnce(&TomlTable<'d>) -> Result<T, InputError>,
    ) -> Result<Option<T>, InputError> {
        self.optional(key, |table, key| read(&table.table(key)?))
    }

    /// What `read` makes of each `[[key]]` table; nothing where there are none, which is how TOML writes
    /// an empty list of tables.
    ///
    /// # Errors
    /// As [`TomlTable::tables`], and those of `read`.
    pub fn each_table<T>(
        &self,
        key: &str,
        read: impl FnMut(&TomlTable<'d>) -> Result<T, InputError>,
    ) -> Result<Vec<T>, InputError> {
        let tables = self.optional(key, Self::tables)?.unwrap_or_default();
        tables.iter().map(read).collect()
    }

    /// The number under a key; `otherwise` where the key is left out.
    ///
    /// # Errors
    /// As [`TomlTable::number`].
    pub fn number_or(
        &self,
        key: &str,
        bounds: Bounds<'_>,
        otherwise: f64,
    ) -> Result<f64, InputError> {
        if self.has(key) { self.number(key, bounds) } else { Ok(otherwise) }
    }

    /// The quantity under a key; `otherwise` where the key is left out.
    ///
    /// # Errors
    /// As [`TomlTable::quantity`].
    pub fn quantity_or(&self, key: &str, otherwise: f64) -> Result<f64, InputError> {
        if self.has(key) { self.quantity(key) } else { Ok(otherwise) }
    }

    /// The keys, in the file's order.
    pub fn keys(&self) -> Vec<&'d str> {
        let mut keys: Vec<_> = self.table.keys().collect();
        keys.sort_by_key(|key| key.span().start);
        keys.into_iter().map(|key| key.get_ref().as_ref()).collect()
    }

    fn value(&self, key: &str, expected: &str) -> Result<TomlValue<'d>, InputError> {
        let Some((name, value)) = self.table.get_key_value(key) else {
            let message = format!("missing key `{key}` {}; expected {expected}", self.place);
            let help = format!("Add `{key} = …` {}: {expected}.", self.place);
            return Err(self.source.error(
                self.span.clone(),
                message,
                format!("`{key}` is missing here"),
                help,
            ));
        };
        let value = TomlValue {
            source: self.source,
            value: value.get_ref(),
            span: value.span(),
            key_span: name.span(),
            what: format!("`{key}` {}", self.place),
        };
        match value.value {
            DeValue::String(text) if text.starts_with(FILL_IN) => Err(value.unfilled(expected)),
            _ => Ok(value),
        }
    }

    /// The table under a key.
    ///
    /// # Errors
    /// Missing, or not a table.
    pub fn table(&self, key: &str) -> Result<TomlTable<'d>, InputError> {
        let value = self.value(key, "a table")?;
        match value.value {
            DeValue::Table(table) => {
                let place = if self.place.starts_with("in ") {
                    format!("in `{key}` {}", self.place)
                } else {
                    format!("in [{key}]")
                };
                // A table made by dotted keys has no header of its own; its key stands in.
                let span = if value.span.is_empty() { value.key_span } else { value.span };
                Ok(TomlTable { source: self.source, table, place, span })
            }
            _ => {
                Err(value
                    .wrong("a table", format!("Write a [{key}] header with its keys below it.")))
            }
        }
    }

    /// The `[[key]]` tables, in the file's order.
    ///
    /// # Errors
    /// Missing, or not a list of tables.
    pub fn tables(&self, key: &str) -> Result<Vec<TomlTable<'d>>, InputError> {
        let expected = format!("[[{key}]] tables");
        let help = format!("Write each as a [[{key}]] header with its keys below it.");
        let value = self.value(key, &expected)?;
        let DeValue::Array(items) = value.value else {
            return Err(value.wrong(&expected, help));
        };
        let tables = items.iter().enumerate().map(|(i, item)| match item.get_ref() {
            DeValue::Table(table) => {
                let place = format!("in [[{key}]] {}", i + 1);
                Ok(TomlTable { source: self.source, table, place, span: item.span() })
            }
            _ => Err(value.entry(i, item).wrong(&expected, help.clone())),
        });
        tables.collect()
    }

    /// The text under a key.
    ///
    /// # Errors
    /// Missing, or not text.
    pub fn text(&self, key: &str) -> Result<Text<'d>, InputError> {
        let value = self.value(key, "text")?;
        match value.value {
            DeValue::String(text) => Ok(Text { text, span: value.span }),
            _ => Err(value.wrong("text", "Put text in double quotes.")),
        }
    }

    /// The text under a key, which must be fit to be shown: a name.
    ///
    /// # Errors
    /// Missing, not text, blank, or with control characters.
    pub fn name(&self, key: &str) -> Result<String, InputError> {
        let name = self.text(key)?;
        if name.text.trim().is_empty() || name.text.contains(char::is_control) {
            return Err(self.wrong(
                key,
                "a name on one line that is not blank",
                "Give it the name that reports should show.",
            ));
        }
        Ok(name.text.to_owned())
    }

    /// The number under a key.
    ///
    /// # Errors
    /// Missing, not a number, not finite, or outside the bounds.
    pub fn number(&self, key: &str, bounds: Bounds<'_>) -> Result<f64, InputError> {
        let expected = bounds.describe(unit_of(key));
        self.value(key, &expected)?.number(bounds, &expected)
    }

    /// The number under a key of the table of quantities.
    ///
    /// # Errors
    /// Missing, not a number, or outside the quantity's possible range. One outside its plausible
    /// range is noted as a warning.
    pub fn quantity(&self, key: &str) -> Result<f64, InputError> {
        self.quantity_as(key, key)
    }

    /// As [`TomlTable::quantity`], of a quantity that goes by another name than its key.
    ///
    /// # Errors
    /// As [`TomlTable::quantity`].
    pub fn quantity_as(&self, key: &str, name: &str) -> Result<f64, InputError> {
        let expected = Bounds::Of(name).describe(unit_of(key));
        self.value(key, &expected)?.number(Bounds::Of(name), &expected)
    }

    /// The number under a key of `rows`; of the table of quantities where they have no such key.
    ///
    /// # Errors
    /// As [`TomlTable::quantity`].
    pub fn quantity_in(&self, rows: &[Quantity], key: &str) -> Result<f64, InputError> {
        match rows.iter().find(|row| row.key == key) {
            Some(row) => self.number(key, Bounds::In(row)),
            None => self.quantity(key),
        }
    }

    /// Exactly `N` numbers under a key of the table of quantities.
    ///
    /// # Errors
    /// As [`TomlTable::numbers`] and [`TomlTable::quantity`].
    pub fn quantities<const N: usize>(&self, key: &str) -> Result<[f64; N], InputError> {
        self.numbers(key, Bounds::Of(key))
    }

    /// The whole number, zero or above, under a key.
    ///
    /// # Errors
    /// Missing, or not such a number.
    pub fn integer(&self, key: &str) -> Result<u64, InputError> {
        let expected = "a whole number, 0 or above";
        let value = self.value(key, expected)?;
        let read = match value.value {
            DeValue::Integer(i) => u64::from_str_radix(i.as_str(), i.radix()).ok(),
            _ => None,
        };
        // TOML promises whole numbers only up to this size, and other tools hold to it.
        read.filter(|i| i64::try_from(*i).is_ok())
            .ok_or_else(|| value.wrong(expected, "Write digits only, at most 9223372036854775807."))
    }

    /// The list of numbers under a key, of any length up to `most`.
    ///
    /// # Errors
    /// Missing, not a list, longer than `most`, or an entry that is not a number within the bounds.
    pub fn list(&self, key: &str, most: usize, bounds: Bounds<'_>) -> Result<Vec<f64>, InputError> {
        let expected = format!("a list of at most {most} numbers");
        self.entries(key, &expected, |n| n <= most, bounds)
    }

    /// Exactly `N` numbers under a key.
    ///
    /// # Errors
    /// Missing, not a list, of another length, or an entry that is not a number within the bounds.
    pub fn numbers<const N: usize>(
        &self,
        key: &str,
        bounds: Bounds<'_>,
    ) -> Result<[f64; N], InputError> {
        let expected = format!("a list of {N} numbers");
        let entries = self.entries(key, &expected, |n| n == N, bounds)?;
        let mut numbers = [0.0; N];
        numbers.copy_from_slice(&entries);
        Ok(numbers)
    }

    /// Three numbers under a key: a vector's x, y, z.
    ///
    /// # Errors
    /// As [`TomlTable::numbers`].
    pub fn vector(&self, key: &str) -> Result<Vector3<f64>, InputError> {
        self.quantities::<3>(key).map(Vector3::from)
    }

    fn entries(
        &self,
        key: &str,
        expected: &str,
        length: impl Fn(usize) -> bool,
        bounds: Bounds<'_>,
    ) -> Result<Vec<f64>, InputError> {
        let unit = unit_of(key);
        let expected =
            format!("{expected}{}", unit.map(|u| format!(" in {u}")).unwrap_or_default());
        let value = self.value(key, &expected)?;
        let help = || format!("Write it as `{key} = [first, second, …]`.");
        let DeValue::Array(items) = value.value else {
            return Err(value.wrong(&expected, help()));
        };
        if !length(items.len()) {
            let message =
                format!("{} has {} entries; expected {expected}", value.what, items.len());
            return Err(self.source.error(
                value.span,
                message,
                format!("expected {expected}"),
                help(),
            ));
        }
        let each = bounds.describe(unit);
        items
            .iter()
            .enumerate()
            .map(|(i, item)| value.entry(i, item).number(bounds, &each))
            .collect()
    }

    /// The texts of the list under a key, at least one.
    ///
    /// # Errors
    /// Missing, not a list, empty, or an entry that is not text.
    pub fn texts(&self, key: &str) -> Result<Vec<Text<'d>>, InputError> {
        let expected = "a list of texts, at least one";
        let help = || format!("Write it as `{key} = [\"first\", \"second\"]`.");
        let value = self.value(key, expected)?;
        let DeValue::Array(items) = value.value else {
            return Err(value.wrong(expected, help()));
        };
        if items.is_empty() {
            return Err(value.wrong(expected, help()));
        }
        let texts = items.iter().enumerate().map(|(i, item)| match item.get_ref() {
            DeValue::String(text) => Ok(Text { text, span: item.span() }),
            _ => Err(value.entry(i, item).wrong("text", help())),
        });
        texts.collect()
    }

    /// The path under a key, taken from `folder` where it is relative, of a file that exists.
    ///
    /// # Errors
    /// Missing, not text, or no such file.
    pub fn file(&self, key: &str, folder: &Path) -> Result<PathBuf, InputError> {
        let path = folder.join(self.text(key)?.text);
        if path.is_file() {
            return Ok(path);
        }
        let help = format!(
            "A path is taken from the folder of the file it stands in: here {}.",
            path.display()
        );
        Err(self.wrong(key, "the path of a file that exists", help))
    }

    /// True where the value of a key is a list.
    pub fn is_list(&self, key: &str) -> bool {
        self.table.get(key).is_some_and(|value| matches!(value.get_ref(), DeValue::Array(_)))
    }

    /// An error at a piece of text of this file.
    pub fn error_at(
        &self,
        text: &Text<'_>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> InputError {
        self.source.error(text.span.clone(), message, "here", help)
    }

    /// The values of this table, each under a key of `defaults` and of its type there: a finite
    /// number, a whole number, a truth value, a text, as many numbers as there, or texts.
    ///
    /// # Errors
    /// A key that `defaults` does not have, or a value of another type.
    pub(crate) fn like(&self, defaults: &toml::Table) -> Result<toml::Table, InputError> {
        self.only(&defaults.keys().map(String::as_str).collect::<Vec<_>>())?;
        let mut values = toml::Table::new();
        for (key, default) in defaults.iter().filter(|(key, _)| self.has(key)) {
            let value = match default {
                toml::Value::Float(_) => self.number(key, Bounds::Any)?.into(),
                toml::Value::Integer(_) => toml::Value::try_from(self.integer(key)?)
                    .map_err(|error| self.wrong(key, "a whole number", error.to_string()))?,
                toml::Value::Boolean(_) => self.truth(key)?.into(),
                toml::Value::Array(list) if list.iter().all(toml::Value::is_float) => {
                    let (n, expected) = (list.len(), format!("a list of {} numbers", list.len()));
                    self.entries(key, &expected, |given| given == n, Bounds::Any)?.into()
                }
                toml::Value::Array(_) => {
                    let texts = self.texts(key)?;
                    texts.iter().map(|text| text.text).collect::<Vec<_>>().into()
                }
                toml::Value::Table(inner) => self.table(key)?.like(inner)?.into(),
                toml::Value::String(_) | toml::Value::Datetime(_) => self.text(key)?.text.into(),
            };
            values.insert(key.clone(), value);
        }
        Ok(values)
    }

    /// True or false under a key.
    ///
    /// # Errors
    /// A key that is missing; another kind of value.
    pub fn truth(&self, key: &str) -> Result<bool, InputError> {
        let value = self.value(key, "true or false")?;
        match value.value {
            DeValue::Boolean(truth) => Ok(*truth),
            _ => Err(value.wrong("true or false", "Write it without quotes.")),
        }
    }

    /// An error at the value of a key: what was read there is not what was expected.
    pub fn wrong(&self, key: &str, expected: &str, help: impl Into<String>) -> InputError {
        match self.value(key, expected) {
            Ok(value) => value.wrong(expected, help),
            Err(missing) => missing,
        }
    }

    /// Where a key stands, as errors name it: `file:line:column`.
    pub fn place_of(&self, key: &str) -> String {
        let span = self.table.get_key_value(key).map_or(self.span.clone(), |(key, _)| key.span());
        self.source.place(span.start)
    }

    /// An error at a key: it is not what was expected.
    pub fn wrong_key(&self, key: &str, expected: &str, help: impl Into<String>) -> InputError {
        let span = self.table.get_key_value(key).map_or(self.span.clone(), |(key, _)| key.span());
        let message = format!("`{}` {}; expected {expected}", key.escape_debug(), self.place);
        self.source.error(span, message, "not this", help)
    }

    /// An error within the text under a key, at a byte range of that text; at all of it where the
    /// file writes it with escapes.
    pub(crate) fn error_in_text(
        &self,
        key: &str,
        within: Range<usize>,
        message: &str,
        help: impl Into<String>,
    ) -> InputError {
        let Text { text, span } = match self.text(key) {
            Ok(text) => text,
            Err(missing) => return missing,
        };
        let found = self.source.text().get(span.clone()).and_then(|raw| raw.find(text));
        let at = found.map_or(span.clone(), |start| {
            let start = span.start + start;
            start + within.start..start + within.end
        });
        let message = format!("`{key}` {}: {message}", self.place);
        self.source.error(at, message, "here", help)
    }

    /// An error at the header of this table.
    pub fn error(&self, message: &str, help: impl Into<String>) -> InputError {
        self.source.error(self.span.clone(), format!("{} {message}", self.place), "here", help)
    }
}

fn quoted(keys: &[&str]) -> String {
    keys.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ")
}
