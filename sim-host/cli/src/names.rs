//! Controllers and laws on the command line.

use crate::session;
use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};
use std::ffi::OsStr;
use trueweld_compensators::{Entry, library};
use trueweld_plant::controllers::{ControllerEntry, ControllerKind, controllers};
use trueweld_plant::input::nearest;

/// Reads the name of a controller.
#[derive(Clone)]
pub(crate) struct ControllerParser;

impl TypedValueParser for ControllerParser {
    type Value = ControllerKind;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<ControllerKind, clap::Error> {
        let name = value.to_string_lossy();
        let known = controllers().iter().map(|controller| controller.name.to_owned()).collect();
        ControllerKind::find(&name).map_err(|near| unknown(command, argument, &name, near, known))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let value = |of: &&ControllerEntry| PossibleValue::new(of.name).help(of.about);
        Some(Box::new(controllers().iter().map(value)))
    }
}

/// A value that is none of those known.
fn unknown(
    command: &Command,
    argument: Option<&Arg>,
    value: &str,
    near: Option<&str>,
    known: Vec<String>,
) -> clap::Error {
    let text = |text: &str| ContextValue::String(text.to_owned());
    let mut error = clap::Error::new(ErrorKind::InvalidValue).with_cmd(command);
    if let Some(argument) = argument {
        error.insert(ContextKind::InvalidArg, text(&argument.to_string()));
    }
    error.insert(ContextKind::InvalidValue, text(value));
    if let Some(near) = near {
        error.insert(ContextKind::SuggestedValue, text(near));
    }
    error.insert(ContextKind::ValidValue, ContextValue::Strings(known));
    error
}

/// Reads the name of a law, or the names of several with a plus between them.
#[derive(Clone)]
pub(crate) struct LawParser;

impl TypedValueParser for LawParser {
    type Value = Entry;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<Entry, clap::Error> {
        let name = value.to_string_lossy();
        session::find_law(&name).map_err(|read| {
            let known = library().iter().map(Entry::name);
            let near = nearest(read, known.clone());
            unknown(command, argument, read, near, known.map(str::to_owned).collect())
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let value = |law: &'static Entry| PossibleValue::new(law.name()).help(law.summary());
        Some(Box::new(library().iter().map(value)))
    }
}

/// Laws that are simulated one beside the other.
#[derive(Clone)]
pub(crate) struct LawList(pub Vec<Entry>);

/// Reads the names of laws, with commas between them, each as [`LawParser`] does.
#[derive(Clone)]
pub(crate) struct LawListParser;

impl TypedValueParser for LawListParser {
    type Value = LawList;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<LawList, clap::Error> {
        let names = value.to_string_lossy();
        let law = |name: &str| LawParser.parse_ref(command, argument, name.trim().as_ref());
        names.split(',').map(law).collect::<Result<_, _>>().map(LawList)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        LawParser.possible_values()
    }
}
