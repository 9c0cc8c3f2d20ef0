//! Every sentence of the program: the crates below return numbers, names and enums, and what a
//! terminal, a page, a recording or a JSON file says of them is written here, once.

pub(crate) mod certify;
pub(crate) mod compare;
pub(crate) mod compare_logs;
pub(crate) mod control;
pub(crate) mod curve;
pub(crate) mod diagnose;
pub(crate) mod discover;
pub(crate) mod effects;
pub(crate) mod error;
pub(crate) mod experiment;
pub(crate) mod finding;
pub(crate) mod identify;
pub(crate) mod import;
pub(crate) mod improve;
pub(crate) mod improve_fleet;
pub(crate) mod laws;
pub(crate) mod log;
pub(crate) mod log_faults;
mod model;
pub(crate) mod provenance;
mod published;
mod quantity;
pub(crate) mod register;
pub(crate) mod replay;
pub(crate) mod requirement;
pub(crate) mod step;
pub(crate) mod study;
pub(crate) mod tune;
pub(crate) mod weld;

use std::collections::BTreeMap;

pub use model::model_comments;
pub(crate) use published::PublishedStep;
pub(crate) use quantity::{
    Scale, digits, fixed, probability, score, score_change, share, signed_share,
};

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

/// Words in lines that fit.
pub(crate) fn lines_of(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.last_mut().expect("there is always a line");
        let (length, more) = (last.chars().count(), word.chars().count());
        if length > 0 && length + 1 + more > width {
            lines.push(word.to_owned());
        } else {
            if length > 0 {
                last.push(' ');
            }
            last.push_str(word);
        }
    }
    lines
}

/// Names of numbers, those of one parameter at several places together.
pub(crate) fn condensed(names: &[String]) -> String {
    let mut together: BTreeMap<(&str, &str), Vec<&str>> = BTreeMap::new();
    for name in names {
        let (what, parameter) = name.split_once(": ").unwrap_or((name, ""));
        let (what, at) = what.split_once(" at ").unwrap_or((what, ""));
        together.entry((what, parameter)).or_default().push(at);
    }
    let one = |((what, parameter), at): ((&str, &str), Vec<&str>)| {
        let parameter = if parameter.is_empty() { "" } else { &format!(" {parameter}") };
        match at.join(", ") {
            at if at.is_empty() => format!("{what}{parameter}"),
            at => format!("{what}{parameter} at {at}"),
        }
    };
    together.into_iter().map(one).collect::<Vec<_>>().join("; ")
}
