//! What discovery makes of laws outside the library: a line a case.

use clap::Parser;
use std::process::ExitCode;
use std::time::Instant;
use trueweld_laboratory::{Protocol, Recipe};
use trueweld_measure::diagnose::{Verdict, diagnose};
use trueweld_measure::discover::discover;
use trueweld_tests::LABORATORY;
use trueweld_tests::corpus::{CorpusError, in_words, ready};
use trueweld_tests::outside::{LAWS, OutsideLaw};

/// Hides laws outside the library in synthetic campaigns, and tells what is found.
#[derive(Debug, Parser)]
struct Arguments {
    /// Names of laws; all where none is given.
    names: Vec<String>,
    /// Factor on their size.
    #[arg(long, default_value_t = 1.0)]
    size: f64,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn examine(law: &OutsideLaw, size: f64, seed: u64) -> Result<String, CorpusError> {
    let protocol = Protocol { free: 10.0, seam: 0.1, welds: 1, ..Protocol::usual() };
    let recipe = Recipe { protocol, ..Recipe::plain(seed) }.with_nuisance(0.03, 1e-4, 1e-4);
    let ready = ready(&recipe.with_effect(law.effect(size)))?;
    let start = Instant::now();
    let mut diagnosis = diagnose(&ready.bench, &ready.logs, &|_, _| ())?;
    let diagnosed = start.elapsed().as_secs_f64();
    let verdict = diagnosis.verdict;
    let named = diagnosis.candidates.first().filter(|_| verdict != Verdict::Adequate);
    let named = named.map_or(String::new(), |candidate| {
        let effects: Vec<String> = candidate.effects.iter().map(|f| in_words(&f.effect)).collect();
        format!("{} {:.2}", effects.join(" + "), candidate.held_out_after)
    });
    let found = discover(&ready.bench, &ready.logs, &mut diagnosis, &|_, _| ());
    let found: Vec<String> = found
        .iter()
        .map(|d| {
            let h = &d.hypothesis;
            let at = LABORATORY.at_name(&d.effect.effect);
            let right = h.port.name == law.port
                && d.effect.effect.at == law.effect(1.0).at
                && law.over.iter().all(|v| h.variables().contains(v));
            let tied: Vec<&str> = d.tied.iter().map(|t| t.hypothesis.port.name).collect();
            format!(
                "{} {} [{at}] {} → {:.2}, {}; tied {tied:?}",
                if right { "RIGHT" } else { "wrong" },
                h.port.name,
                h.expression(&format!("f({})", h.over)),
                d.held_out_after,
                d.expression.as_deref().unwrap_or("a curve"),
            )
        })
        .collect();
    Ok(format!(
        "{:12} {:14} {:6.2} | {named} | {} | {diagnosed:.0} + {:.0} s",
        law.name,
        verdict.name(),
        diagnosis.score_before,
        found.join("; "),
        start.elapsed().as_secs_f64() - diagnosed
    ))
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let wanted = |law: &&OutsideLaw| {
        arguments.names.is_empty() || arguments.names.iter().any(|name| name == law.name)
    };
    for law in LAWS.iter().filter(wanted) {
        match examine(law, arguments.size, arguments.seed) {
            Ok(line) => println!("{line}"),
            Err(error) => {
                eprintln!("{}: {error}", law.name);
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}
