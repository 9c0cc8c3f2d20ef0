//! Controllers and laws on the command line.

use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command, ValueEnum};
use std::ffi::OsStr;
use trueweld_compensators::{Entry, find, library};
use trueweld_plant::input::nearest;
use trueweld_plant::simulate;

/// A hybrid controller.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Controller {
    /// Parallel hybrid control with selection matrix (2.2)
    Parallel,
    /// Superposed hybrid control (2.3)
    Superposed,
    /// External hybrid control: force loop around a position loop (2.4), (2.5)
    External,
}

impl Controller {
    pub(crate) fn controller(self) -> simulate::ControllerKind {
        match self {
            Self::Parallel => simulate::ControllerKind::Parallel,
            Self::Superposed => simulate::ControllerKind::Superposed,
            Self::External => simulate::ControllerKind::External,
        }
    }
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
        find(&name).map_err(|unknown| {
            let known = library().iter().map(Entry::name);
            let text = |text: &str| ContextValue::String(text.to_owned());
            let mut error = clap::Error::new(ErrorKind::InvalidValue).with_cmd(command);
            if let Some(argument) = argument {
                error.insert(ContextKind::InvalidArg, text(&argument.to_string()));
            }
            error.insert(ContextKind::InvalidValue, text(unknown));
            if let Some(near) = nearest(unknown, known.clone()) {
                error.insert(ContextKind::SuggestedValue, text(near));
            }
            let known = known.map(str::to_owned).collect();
            error.insert(ContextKind::ValidValue, ContextValue::Strings(known));
            error
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let value = |law: &'static Entry| PossibleValue::new(law.name()).help(law.summary());
        Some(Box::new(library().iter().map(value)))
    }
}
