//! Every sentence of the program: the crates below return numbers, names and enums, and what a
//! terminal, a page, a recording or a JSON file says of them is written here, once.

pub(crate) mod certify;
pub(crate) mod compare;
pub(crate) mod control;
pub(crate) mod curve;
pub(crate) mod diagnose;
pub(crate) mod effects;
pub(crate) mod experiment;
pub(crate) mod finding;
pub(crate) mod import;
pub(crate) mod laws;
mod log;
pub(crate) mod mistakes;
mod model;
pub(crate) mod provenance;
mod published;
mod quantity;
pub(crate) mod register;
pub(crate) mod requirement;
pub(crate) mod step;
pub(crate) mod tune;
pub(crate) mod weld;

pub use model::model_comments;
pub(crate) use published::PublishedStep;
pub(crate) use quantity::{Scale, digits, fixed, probability, score, share, signed_share};

/// `a`, `a and b`, `a, b and c`; `last`: the word before the last one.
pub(crate) fn listed<T: AsRef<str>>(parts: &[T], last: &str) -> String {
    match parts {
        [] => String::new(),
        [one] => one.as_ref().to_owned(),
        [first @ .., end] => {
            let first: Vec<&str> = first.iter().map(T::as_ref).collect();
            format!("{} {last} {}", first.join(", "), end.as_ref())
        }
    }
}

/// `1 log`, `3 logs`.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}
