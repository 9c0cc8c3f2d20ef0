//! `trueweld`: simulate robotic friction stir welding, with and without compensation of the tool's
//! deviation.
//!
//! One short file per subcommand; the work is done in the crates below.

/// Prints text for people, in a function that returns a [`miette::Result`].
macro_rules! say {
    ($($text:tt)*) => { $crate::terminal::say(&format!($($text)*))? };
}

mod certify;
mod check;
mod compare;
mod compare_laws;
mod diagnose;
mod import_urdf;
mod improve;
mod inputs;
mod measured;
mod names;
mod results;
mod step;
mod terminal;
mod weld;

use clap::{Parser, Subcommand};

/// Keeps a robot's welding tool true while the robot bends under it.
///
/// Without a command: the first published weld, with and without compensation, written to
/// out/weld.html and out/weld.rrd.
#[derive(Parser)]
#[command(version, max_term_width = 110)]
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
    CompareLaws(compare_laws::Arguments),
    /// Prove by many welds of uncertain cells that a compensation law meets its requirements
    Certify(certify::Arguments),
    /// Show how far a model is from measurements, and where
    Compare(compare::Arguments),
    /// Find out which physical effect is missing in a model
    Diagnose(diagnose::Arguments),
    /// Add what is missing to a model, refit it, and write it
    Improve(improve::Arguments),
    /// Check input files of any kind
    Check(check::Arguments),
    /// Turn a URDF into a robot file; what a URDF cannot know is marked to be filled in
    ImportUrdf(import_urdf::Arguments),
}

fn main() -> miette::Result<()> {
    run().map_err(terminal::shown)
}

fn run() -> miette::Result<()> {
    match Arguments::parse().command {
        None => weld::run(&weld::Arguments::first_published()),
        Some(Command::Weld(arguments)) => weld::run(&arguments),
        Some(Command::Step(arguments)) => step::run(&arguments),
        Some(Command::CompareLaws(arguments)) => compare_laws::run(&arguments),
        Some(Command::Certify(arguments)) => certify::run(&arguments),
        Some(Command::Compare(arguments)) => compare::run(&arguments),
        Some(Command::Diagnose(arguments)) => diagnose::run(&arguments),
        Some(Command::Improve(arguments)) => improve::run(&arguments),
        Some(Command::Check(arguments)) => check::run(&arguments),
        Some(Command::ImportUrdf(arguments)) => import_urdf::run(&arguments),
    }
}
