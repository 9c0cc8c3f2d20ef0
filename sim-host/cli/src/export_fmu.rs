//! `trueweld export-fmu`: a law or the cell as a functional mock-up unit.

use crate::inputs::WeldArguments;
use crate::names::{ControllerParser, LawParser};
use crate::results::{check_outputs, check_targets};
use clap::{ArgGroup, Args, ValueEnum};
use miette::Result;
use std::path::PathBuf;
use trueweld_compensators::Entry;
use trueweld_fmu::{CellInput, FmiVersion, FmuExport, FmuLibrary, FmuModel};
use trueweld_output::write_file;
use trueweld_plant::controllers::ControllerKind;

/// Arguments of `export-fmu`.
#[derive(Args)]
#[command(group = ArgGroup::new("model_of_fmu").required(true).args(["law", "plant"]))]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: WeldArguments,
    /// A compensation law with its controller: what the instruments read goes in, torques and
    /// correction come out
    #[arg(long, value_name = "LAW", value_parser = LawParser)]
    law: Option<Entry>,
    /// The cell: torques or a correction go in, what the instruments read comes out
    #[arg(long)]
    plant: bool,
    /// What drives a plant
    #[arg(long, value_enum, default_value_t = PlantInput::Torque, requires = "plant")]
    input: PlantInput,
    /// Version of FMI
    #[arg(long, value_enum, default_value_t = FmiNumber::Two)]
    fmi: FmiNumber,
    /// Hybrid force/position controller of a law, and of a plant that a correction drives
    #[arg(long, value_parser = ControllerParser, default_value = ControllerKind::default().name())]
    controller: ControllerKind,
    /// Shared library of a platform, built from the sources of this program; may be given several
    /// times (default: that of this platform, which is in the wheel, or beside the program)
    #[arg(long, value_name = "F")]
    library: Vec<PathBuf>,
    /// File to write (default: out/NAME.fmu, with the law's name or plant)
    #[arg(long, value_name = "F")]
    out: Option<PathBuf>,
}

/// What drives a plant, on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PlantInput {
    /// Motor torques: the controller is outside
    Torque,
    /// A correction of the set-point: the controller is inside
    Correction,
}

/// Version of FMI on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FmiNumber {
    /// Scalars; read by every tool
    #[value(name = "2")]
    Two,
    /// Arrays
    #[value(name = "3")]
    Three,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let name = arguments.law.as_ref().map_or("plant", Entry::name);
    let own = || PathBuf::from("out").join(format!("{name}.fmu"));
    let out = arguments.out.clone().unwrap_or_else(own);
    let outputs = [("--out", out.as_path())];
    check_targets(&outputs)?;
    let cell = arguments.files.read()?;
    check_outputs(&outputs)?;
    let model = match &arguments.law {
        Some(law) => FmuModel::Law(law.clone()),
        None => FmuModel::Plant(match arguments.input {
            PlantInput::Torque => CellInput::Torque,
            PlantInput::Correction => CellInput::Correction,
        }),
    };
    let libraries = match &arguments.library[..] {
        [] => vec![FmuLibrary::of_program()?],
        given => given.iter().map(|path| FmuLibrary::read(path)).collect::<Result<_>>()?,
    };
    let export = FmuExport {
        files: &arguments.files.cell.files(),
        controller: arguments.controller,
        model,
        version: match arguments.fmi {
            FmiNumber::Two => FmiVersion::Fmi2,
            FmiNumber::Three => FmiVersion::Fmi3,
        },
    };
    let (bytes, summary) = export.package(&cell, &libraries)?;
    write_file(&out, bytes)?;
    say!(
        "wrote {}\nstep, s         {}\nplatforms       {}\ndigest          {}\n",
        out.display(),
        summary.step,
        summary.platforms.join(", "),
        summary.token
    );
    Ok(())
}
