//! Results for programs: a type for each file, read as it is written. SI units, units in the keys.
//!
//! What does not exist (a time that was never reached, a bound that the data do not give) is
//! `null`. The schemas of all files are in `docs/schema`; [`schemas`](crate::schemas) makes them.

pub(crate) mod certify;
mod check;
pub(crate) mod compare;
pub(crate) mod compare_logs;
pub(crate) mod diagnose;
mod discover;
mod effects;
mod error;
pub(crate) mod identify;
pub(crate) mod import;
pub(crate) mod improve;
pub(crate) mod improve_fleet;
pub(crate) mod laws;
mod log_fault;
pub(crate) mod log_faults;
mod mountings;
pub(crate) mod plan;
pub(crate) mod register;
pub(crate) mod study;
pub(crate) mod tune;

pub use check::{CheckResult, CheckedFile};

use schemars::{JsonSchema, Schema, json_schema, schema_for};
use serde::Serialize;
use serde_json::{Map, Value};

/// A file: its name and version, and what it holds.
#[derive(Serialize)]
struct ResultFile<'a, T> {
    schema: &'a str,
    #[serde(flatten)]
    result: &'a T,
}

/// The text of a file.
pub fn text(schema: &str, result: &impl Serialize) -> String {
    let text = serde_json::to_string_pretty(&ResultFile { schema, result });
    text.expect("numbers, texts and lists are written as JSON") + "\n"
}

/// The name of a file's schema, and the schema: that of what the file holds, with name and version.
pub(crate) fn schema<T: JsonSchema>(name: &'static str) -> (&'static str, Schema) {
    let mut schema = schema_for!(T);
    let version = json_schema!({
        "type": "string",
        "description": "Name and version of this format.",
        "const": name,
    });
    let first = || ("schema".to_owned(), version.to_value());
    if let Some(Value::Object(of)) = schema.get_mut("properties") {
        *of = std::iter::once(first()).chain(std::mem::take(of)).collect::<Map<_, _>>();
    }
    if let Some(Value::Array(required)) = schema.get_mut("required") {
        required.insert(0, "schema".into());
    }
    (name.split('/').next().unwrap_or(name), schema)
}

/// Declares a part of a result: for each of its keys one row with what it is, its type, and how it
/// follows from what was computed. The file, its schema and the pages take it from there.
macro_rules! result {
    (
        $(#[$of:meta])*
        $name:ident $(<$life:lifetime>)? of ($($from:ident: $kind:ty),* $(,)?)
        $(with { $($known:tt)* })? {
            $($(#[$about:meta])* $key:ident: $type:ty = $value:expr,)+
        }
    ) => {
        $(#[$of])*
        #[derive(Clone, serde::Serialize, schemars::JsonSchema)]
        #[schemars(deny_unknown_fields)]
        pub(crate) struct $name $(<$life>)? {
            $($(#[$about])* pub(crate) $key: $type,)+
        }

        impl $(<$life>)? $name $(<$life>)? {
            pub(crate) fn of($($from: $kind),*) -> Self {
                $($($known)*)?
                Self { $($key: $value,)+ }
            }
        }
    };
}
use result;

/// A number that JSON can hold: `None` for what is infinite or no number.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
