//! `trueweld import-urdf`: a robot file from a URDF.

use clap::Args;
use miette::Result;
use std::path::PathBuf;
use trueweld_plant::input;

/// Arguments of `import-urdf`.
#[derive(Args)]
pub struct Arguments {
    /// URDF of a serial arm with six revolute joints
    #[arg(value_name = "URDF")]
    urdf: PathBuf,
    /// Robot file to write (default: standard output)
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let text = input::import_urdf(&arguments.urdf)?;
    let Some(path) = &arguments.out else {
        say!("{text}");
        return Ok(());
    };
    trueweld_output::write_file(path, &text)?;
    say!("wrote {}\n", path.display());
    let left = text.matches(input::FILL_IN).count();
    if left > 0 {
        say!(
            "{left} values are marked {:?}: a URDF does not hold them. Fill them in, then: trueweld check {}\n",
            input::FILL_IN,
            path.display()
        );
    }
    Ok(())
}
