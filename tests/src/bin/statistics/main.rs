//! What takes too long for a test: rates over many campaigns, coverage of intervals, amplitudes at
//! the spindle's order.

mod campaigns;
mod corpus;
mod coverage;
mod identified;
mod resonance;

use clap::Parser;
use std::process::ExitCode;
use trueweld_tests::ended;

/// Measures what the documentation states of many campaigns.
#[derive(Debug, Parser)]
enum Statistics {
    Campaigns(campaigns::Arguments),
    Corpus(corpus::Arguments),
    Coverage(coverage::Arguments),
    Identified(identified::Arguments),
    /// Prints amplitudes at the spindle's order with drives that are held, with and without notch.
    Resonance,
}

fn main() -> ExitCode {
    ended(match Statistics::parse() {
        Statistics::Campaigns(arguments) => campaigns::run(&arguments),
        Statistics::Corpus(arguments) => corpus::run(&arguments),
        Statistics::Coverage(arguments) => coverage::run(&arguments),
        Statistics::Identified(arguments) => identified::run(&arguments),
        Statistics::Resonance => {
            resonance::run();
            Ok(())
        }
    })
}
