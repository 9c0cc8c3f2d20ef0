//! `trueweld schema`: the JSON Schema of a result.

use clap::Args;
use miette::{Result, miette};
use trueweld_output::schemas;

/// Arguments of `schema`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Name of the schema, as a result has it before the slash (default: list the names)
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let all = schemas();
    let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
    let Some(asked) = &arguments.name else {
        say!("{}\n", names.join("\n"));
        return Ok(());
    };
    let found = all.iter().find(|(name, _)| name == asked).ok_or_else(|| {
        miette!("{asked}: there is no such schema; expected one of {}", names.join(", "))
    })?;
    say!("{:#}\n", found.1.as_value());
    Ok(())
}
