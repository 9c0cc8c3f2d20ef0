//! The coverage experiment of `identify`: how often a 95 % interval holds the truth of a simulated
//! campaign whose stiffness, damping or process is off by up to a factor of two.

use clap::{Args, ValueEnum};
use trueweld_evaluate::Rate;
use trueweld_tests::identified::{Case, Seen, examine};

/// Which numbers are identified.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum What {
    Stiffness,
    Damping,
    Process,
}

/// Measures how often the intervals of `identify` hold the truth.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// What is identified.
    #[arg(value_enum)]
    what: What,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of campaigns.
    #[arg(long, default_value_t = 200)]
    cases: u64,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn std::error::Error>> {
    let (mut all, mut without) = (Seen::default(), 0);
    for seed in arguments.seed..arguments.seed + arguments.cases {
        let case = match arguments.what {
            What::Stiffness => Case::stiffness(seed),
            What::Damping => Case::damping(seed),
            What::Process => Case::process(seed),
        };
        let seen = match examine(&case) {
            Ok(seen) => seen,
            Err(why) => {
                println!("{seed}: {why}");
                without += 1;
                continue;
            }
        };
        all.held += seen.held;
        all.told += seen.told;
        all.untold += seen.untold;
        println!(
            "{seed}: {} of {} hold, {} not told, score {:.3}",
            seen.held, seen.told, seen.untold, seen.score
        );
    }
    let [low, high] = Rate { hits: all.held, of: all.told }.limits();
    println!(
        "{} of {} intervals hold the truth: {:.1} % (95 %: {:.1} to {:.1} %); {} not told, {without} campaigns without an answer",
        all.held,
        all.told,
        100.0 * all.held as f64 / all.told as f64,
        100.0 * low,
        100.0 * high,
        all.untold
    );
    Ok(())
}
