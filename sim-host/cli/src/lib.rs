//! The program `trueweld` as a library: its commands, with laws and effects of one's own beside
//! those that it has.
//!
//! One short file a command: arguments, the front door (`trueweld`), output. A program of one's own
//! is a `main` that adds what it has and runs:
//!
//! ```no_run
//! # use trueweld::laws::Uncompensated as MyLaw;
//! # use trueweld::effects::{Action, EffectKind};
//! # static MY_EFFECT: EffectKind =
//! #     EffectKind { id: "my-effect", action: Action::Process(|_, _| {}), ..EffectKind::DEFAULT };
//! fn main() -> trueweld_cli::Result<()> {
//!     trueweld_cli::run(trueweld::Program::new().law::<MyLaw>().effect(&MY_EFFECT))
//! }
//! ```

/// Prints text for people, in a function that returns a [`miette::Result`].
macro_rules! say {
    ($($text:tt)*) => { $crate::terminal::say(&format!($($text)*))? };
}

mod certify;
mod check;
mod compare;
mod compare_laws;
mod diagnose;
mod export_core;
mod export_fmu;
mod folder;
mod identify;
mod import_log;
mod import_urdf;
mod improve;
mod improve_fleet;
mod init;
mod inputs;
mod measured;
mod names;
mod new_law;
mod plan;
mod record;
mod register;
mod repeat;
mod replay;
mod results;
mod rsi_compensate;
mod rsi_counts;
mod rsi_live;
mod rsi_log;
mod rsi_robot;
mod schema;
mod session;
mod step;
mod study;
mod terminal;
mod tune;
mod weld;

pub use miette::Result;
pub use session::{CommandResult, Outcome, Session};

use clap::{CommandFactory, Parser, Subcommand};
use std::ffi::OsString;
use trueweld::Program;

/// Keeps a robot's welding tool true while the robot bends under it.
///
/// Without a command: the first published weld, with and without compensation, written to
/// out/weld.html and out/weld.rrd.
#[derive(Parser)]
#[command(name = "trueweld", version = trueweld::VERSION, max_term_width = 110)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Simulate a weld and show how far the tool leaves its line
    Weld(weld::Arguments),
    /// Simulate a step of the force set-point with all three controllers
    Step(step::Arguments),
    /// Show what every compensation law makes of a wrong stiffness, noise, delay and a lost sensor
    ///
    /// The page goes to out/compare-laws.html where --html does not say otherwise.
    CompareLaws(compare_laws::Arguments),
    /// Prove by many welds of uncertain cells that a compensation law meets its requirements
    Certify(certify::Arguments),
    /// Find gains for a robot from its model, and confirm them by a step and a weld
    ///
    /// The control file goes to out/control.toml where --out does not say otherwise.
    Tune(tune::Arguments),
    /// Study a cell: what its welds depend on, and what the published study shows
    #[command(subcommand)]
    Study(study::Study),
    /// Show how far a model is from measurements, or a log from another, and where
    ///
    /// Two logs of one experiment are compared with each other where no model is given: is the cell as it was?
    Compare(compare::Arguments),
    /// Find out which physical effect is missing in a model
    Diagnose(diagnose::Arguments),
    /// Add what is missing to a model, refit it, and write it
    ///
    /// Campaigns of several units of one type (`unit` in campaign.toml): also what they share, how far they
    /// spread and which is an outlier.
    Improve(improve::Arguments),
    /// Identify stiffness, damping or process from logs, with intervals
    Identify(identify::Arguments),
    /// Find where the tracker stands and what it sees of the tool, whatever the size
    Register(register::Arguments),
    /// Show what experiments would tell of each effect, before any is made
    Plan(plan::Arguments),
    /// Record logs of a simulated cell, as a laboratory would
    Record(record::Arguments),
    /// Check input files of any kind, and folders of logs and campaigns
    Check(check::Arguments),
    /// Write a crate with a law and an effect of your own, beside those of this program
    NewLaw(new_law::Arguments),
    /// Write the folder of a campaign, with what is to be filled in
    Init(init::Arguments),
    /// Propose how files of any make are read as a log, and write its log.toml
    ImportLog(import_log::Arguments),
    /// Turn a URDF into a robot file; what a URDF cannot know is marked to be filled in
    ImportUrdf(import_urdf::Arguments),
    /// Write what a controller's core is built from as constants of Rust and C
    ExportCore(export_core::Arguments),
    /// Feed a recorded run of a controller's core to the same core on this machine, and show the first
    /// period in which they differ
    Replay(replay::Arguments),
    /// Write a law or the cell as an FMU, for Simulink, OpenModelica and other tools
    ExportFmu(export_fmu::Arguments),
    /// Simulate a KUKA controller with the elastic robot behind it, which a client corrects over RSI
    RsiRobot(rsi_robot::Arguments),
    /// Run a law as a client of a KUKA controller over RSI, simulated or real
    RsiCompensate(rsi_compensate::Arguments),
    /// Print the JSON Schema of a result, or list the schemas
    Schema(schema::Arguments),
}

/// Runs the command of this process's arguments, with the laws and effects of a program. Wrong
/// arguments, and a command that ends with another status than 0, end the process.
///
/// # Errors
/// What the command cannot do, to be shown to the user.
pub fn run(program: Program) -> Result<()> {
    program.install()?;
    match Arguments::parse().run().map_err(terminal::shown)? {
        0 => Ok(()),
        status => std::process::exit(status.into()),
    }
}

/// Runs a command as the program does, and returns its status: for a program that is more than this
/// one. `arguments`: with the name of the program first.
pub fn run_from(arguments: Vec<OsString>) -> u8 {
    session::set_arguments(&arguments);
    let parsed = match Arguments::try_parse_from(arguments) {
        Ok(parsed) => parsed,
        Err(error) => {
            // Where this cannot be printed, nobody is there to read it, and the status tells.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    parsed.run().map_err(terminal::shown).unwrap_or_else(|error| {
        terminal::complain(&format!("Error: {error:?}\n"));
        1
    })
}

/// Why a command of a session has no outcome.
#[derive(Debug)]
pub enum SessionError {
    /// Wrong arguments.
    Arguments(clap::Error),
    /// What the command cannot do.
    Command(miette::Report),
}

/// Runs a command inside another program, on this thread: nothing is printed, and its results are
/// handed over. A thread that has run a command remembers its input files; give each a new one.
/// `arguments`: with the name of the program first.
///
/// # Errors
/// [`SessionError`].
pub fn run_in(session: Session, arguments: Vec<OsString>) -> Result<Outcome, SessionError> {
    session::set_arguments(&arguments);
    session::run(session, || {
        let parsed = Arguments::try_parse_from(arguments).map_err(SessionError::Arguments)?;
        parsed.run().map_err(SessionError::Command)
    })
}

/// The commands with their arguments, as the command line has them.
pub fn commands() -> clap::Command {
    Arguments::command()
}

impl Arguments {
    /// Runs the command. Its status: 0, or 1 where what was asked for is not reached.
    fn run(&self) -> Result<u8> {
        match &self.command {
            Some(Command::Certify(arguments)) => return certify::run(arguments),
            Some(Command::Tune(arguments)) => return tune::run(arguments),
            Some(Command::Check(arguments)) => return check::run(arguments),
            Some(Command::Replay(arguments)) => return replay::run(arguments),
            None => weld::run(&weld::Arguments::first_published())?,
            Some(Command::Weld(arguments)) => weld::run(arguments)?,
            Some(Command::Step(arguments)) => step::run(arguments)?,
            Some(Command::CompareLaws(arguments)) => compare_laws::run(arguments)?,
            Some(Command::Study(study)) => study::run(study)?,
            Some(Command::Compare(arguments)) => compare::run(arguments)?,
            Some(Command::Diagnose(arguments)) => diagnose::run(arguments)?,
            Some(Command::Improve(arguments)) => improve::run(arguments)?,
            Some(Command::Identify(arguments)) => identify::run(arguments)?,
            Some(Command::Register(arguments)) => register::run(arguments)?,
            Some(Command::Plan(arguments)) => plan::run(arguments)?,
            Some(Command::Record(arguments)) => record::run(arguments)?,
            Some(Command::NewLaw(arguments)) => new_law::run(arguments)?,
            Some(Command::Init(arguments)) => init::run(arguments)?,
            Some(Command::ImportLog(arguments)) => import_log::run(arguments)?,
            Some(Command::ImportUrdf(arguments)) => import_urdf::run(arguments)?,
            Some(Command::ExportCore(arguments)) => export_core::run(arguments)?,
            Some(Command::ExportFmu(arguments)) => export_fmu::run(arguments)?,
            Some(Command::RsiRobot(arguments)) => rsi_robot::run(arguments)?,
            Some(Command::RsiCompensate(arguments)) => rsi_compensate::run(arguments)?,
            Some(Command::Schema(arguments)) => schema::run(arguments)?,
        }
        Ok(0)
    }
}
