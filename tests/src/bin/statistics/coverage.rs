//! The coverage experiment: how often a posterior holds the truth of a simulated campaign.

use clap::Args;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::fs::{OpenOptions, read_to_string};
use std::io::{ErrorKind, Write as _};
use std::path::PathBuf;
use trueweld_diagnose::posterior::of_fit;
use trueweld_estimate::fit::calibration::{calibrations, in_proportion, is_calibration};
use trueweld_estimate::fit::{self, SolverOptions};
use trueweld_evaluate::Rate;
use trueweld_laboratory::{Protocol, Recipe};
use trueweld_logs::HALF_95;
use trueweld_plant::effects::{CalibrationScope, Effect, EffectKind, Role, library};
use trueweld_plant::input::Posterior;
use trueweld_plant::random::Random;
use trueweld_tests::LABORATORY;
use trueweld_tests::corpus::ready;

/// Measures how often the 95 % intervals and ellipsoids of a posterior hold the truth.
///
/// Each campaign hides one effect of the library, which is fitted as if a diagnosis had named it, in
/// a cell whose stiffnesses, encoder zeros, links and tracker are off as they are expected to be.
/// Appends a line of JSON to OUT for each case; cases already there are not done again.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Seed of the campaigns.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of campaigns.
    #[arg(long, default_value_t = 40)]
    cases: usize,
    /// Factor on what the laboratory gets wrong: stiffnesses, encoder zeros, tracker, links.
    #[arg(long, default_value_t = 1.0)]
    nuisance: f64,
    /// Factor on how links are mounted off, beside that.
    #[arg(long, default_value_t = 1.0)]
    links: f64,
    /// File of results.
    #[arg(long)]
    out: PathBuf,
}

/// Standard deviations of what the laboratory gets wrong: stiffness, encoder zero (rad),
/// registration (m), links (m and rad): what is expected of each before, and for stiffness half.
const NUISANCE: [f64; 3] = [0.05, 1e-4, 1e-4];
const LINKS: f64 = 3e-4;

/// One number of one posterior.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Number {
    name: String,
    truth: f64,
    value: f64,
    deviation: f64,
}

/// What came of one campaign.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Case {
    index: usize,
    hidden: String,
    stated: bool,
    score: f64,
    at_bound: Vec<String>,
    numbers: Vec<Number>,
    /// Squared distance of the truth, in standard deviations of all numbers together, and their
    /// number: of all, and of the stiffnesses.
    joint: [(f64, usize); 2],
}

/// True for a number whose truth a campaign states as such: values of one log are drawn for each, and
/// how a link is mounted is in part a matter of where its frame is put.
fn is_stated(kind: &EffectKind) -> bool {
    kind.calibration.is_none_or(|c| matches!(c.scope, CalibrationScope::AllLogs { .. }))
}

/// The kinds that are hidden in turn.
fn kinds() -> Vec<&'static EffectKind> {
    library().filter(|kind| kind.drawn.is_some() && is_stated(kind)).collect()
}

/// Squared Mahalanobis distance of numbers that are off by so much, and how many these are. A phase is off
/// by less than half a turn where the others are: with another order it is another one at the same angle.
fn distance(posterior: &Posterior, of: &[(usize, f64)]) -> (f64, usize) {
    let covariance =
        DMatrix::from_fn(of.len(), of.len(), |i, j| posterior.covariance_of(of[i].0, of[j].0));
    let mut off = DVector::from_iterator(of.len(), of.iter().map(|(_, off)| *off));
    let Some(factor) = covariance.cholesky() else { return (f64::MAX, of.len()) };
    let is_phase = |i: &usize| {
        let number = &posterior.numbers[of[*i].0];
        number.kind.parameters[number.parameter].role == Role::Phase
    };
    for i in (0..of.len()).filter(is_phase) {
        let mut axis = DVector::zeros(of.len());
        axis[i] = 1.0;
        let along = factor.solve(&axis);
        off[i] -= TAU * (along.dot(&off) / (along[i] * TAU)).round();
    }
    (off.dot(&factor.solve(&off)), of.len())
}

fn examine(arguments: &Arguments, index: usize) -> Result<Case, Box<dyn std::error::Error>> {
    let kinds = kinds();
    let own = arguments.seed.wrapping_mul(1_000_003).wrapping_add(index as u64);
    let mut random = Random::new(own, 0);
    let kind = kinds[index % kinds.len()];
    let protocol = Protocol::short();
    let hidden = LABORATORY.draw(kind.id, 1.0, &protocol, own).ok_or("an effect that is drawn")?;
    let [stiffness, offset, registration] = NUISANCE.map(|sd| arguments.nuisance * sd);
    let recipe = Recipe {
        protocol,
        noise_stated: random.whole(0, 3) > 0,
        geometry_error: arguments.nuisance * arguments.links * LINKS,
        ..Recipe::plain(own)
    }
    .with_nuisance(stiffness, offset, registration)
    .with_effect(hidden.clone());
    let ready = ready(&recipe)?;
    let mut point = calibrations(&ready.problem);
    if !is_calibration(kind) {
        // From nearby: where a search would have left it.
        let near = |(p, v): (&trueweld_plant::effects::Parameter, &f64)| match p.role {
            Role::Size { neutral, .. } => neutral + 0.8 * (v - neutral),
            _ => *v,
        };
        let values = kind.parameters.iter().zip(&hidden.values).map(near).collect();
        point.add(Effect { values, ..hidden.clone() });
    }
    let blocks = fit::blocks_of(&ready.problem);
    let effort = SolverOptions::full(in_proportion(&point));
    let fitted = fit::fit(&ready.problem, &point, &blocks, &[], effort)?;
    let robot = &ready.logs[0].robot;
    let posterior = of_fit(&ready.problem, &ready.logs, &fitted, robot)?;
    let mut truth = recipe.miscalibrations(0);
    truth.push(hidden.clone());
    let (mut numbers, mut all, mut springs) = (Vec::new(), Vec::new(), Vec::new());
    for (k, number) in posterior.numbers.iter().enumerate().filter(|(_, n)| is_stated(n.kind)) {
        let parameter = &number.kind.parameters[number.parameter];
        let same = |e: &&Effect| e.place() == number.effect();
        let of = truth.iter().filter(same).map(|e| e.values[number.parameter]);
        // Shares of one stiffness multiply.
        let truth = match of.collect::<Vec<_>>()[..] {
            [] => parameter.neutral(),
            [one] => one,
            ref many => many.iter().map(|e| 1.0 + e).product::<f64>() - 1.0,
        };
        let mut off = number.value - truth;
        if parameter.role == Role::Phase {
            off = off.sin().atan2(off.cos());
        }
        all.push((k, off));
        if number.kind.id == "stiffness-error" {
            springs.push((k, off));
        }
        let of = if number.effect() == hidden.place() { "hidden" } else { "" };
        numbers.push(Number {
            name: format!("{} {of}", number.key()),
            truth: number.value - off,
            value: number.value,
            deviation: posterior.deviation(k),
        });
    }
    Ok(Case {
        index,
        hidden: format!("{} {}", kind.id, hidden.at.name(robot)),
        stated: recipe.noise_stated,
        score: posterior.score,
        at_bound: posterior.at_bound.clone(),
        numbers,
        joint: [distance(&posterior, &all), distance(&posterior, &springs)],
    })
}

/// A row of the table: what, how many of how many, and the share with its 95 % limits.
fn row(name: &str, rate: Rate) -> String {
    let [low, high] = rate.limits().map(|limit| 100.0 * limit);
    let share = 100.0 * rate.hits as f64 / rate.of.max(1) as f64;
    format!("| {name} | {} of {} | {share:.0} % ({low:.0}–{high:.0} %) |", rate.hits, rate.of)
}

/// Score up to which a fit explains its logs; a certificate says so where it does not.
const EXPLAINED: f64 = 1.1;

fn table(cases: &[Case]) -> String {
    let (cases, others): (Vec<&Case>, Vec<&Case>) =
        cases.iter().partition(|case| case.score <= EXPLAINED);
    let mut lines =
        vec!["| 95 % of | hold the truth | share |".to_owned(), "|---|---|---|".to_owned()];
    let held = |n: &Number| (n.value - n.truth).abs() <= HALF_95 * n.deviation;
    let mut kinds: BTreeMap<String, Vec<bool>> = BTreeMap::new();
    for number in cases.iter().flat_map(|case| &case.numbers) {
        let (name, hidden) = number.name.split_once(' ').unwrap_or((&number.name, ""));
        let name = if hidden.is_empty() { name } else { "parameters of the hidden effect" };
        kinds.entry(name.to_owned()).or_default().push(held(number));
    }
    let all: Vec<bool> = kinds.values().flatten().copied().collect();
    lines.extend(kinds.iter().map(|(name, held)| row(name, Rate::of(held, |held| *held))));
    lines.push(row("all intervals", Rate::of(&all, |held| *held)));
    for (k, name) in ["ellipsoid of all numbers", "ellipsoid of the stiffnesses"].iter().enumerate()
    {
        let joint: Vec<bool> = cases
            .iter()
            .map(|case| case.joint[k])
            .filter(|(_, count)| *count > 0)
            .map(|(distance, count)| {
                ChiSquared::new(count as f64).is_ok_and(|chi| distance <= chi.inverse_cdf(0.95))
            })
            .collect();
        lines.push(row(name, Rate::of(&joint, |held| *held)));
    }
    let others: Vec<String> =
        others.iter().map(|case| format!("{} ({:.2})", case.hidden, case.score)).collect();
    lines.push(format!(
        "\n{} campaigns; beside them {} that the fit does not explain, with its score: {}.",
        cases.len(),
        others.len(),
        others.join(", ")
    ));
    lines.join("\n")
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn std::error::Error>> {
    let text = match read_to_string(&arguments.out) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
        Err(error) => return Err(error.into()),
    };
    let mut cases: Vec<Case> = text.lines().map(serde_json::from_str).collect::<Result<_, _>>()?;
    let known: BTreeSet<usize> = cases.iter().map(|case| case.index).collect();
    let mut file = OpenOptions::new().create(true).append(true).open(&arguments.out)?;
    for index in (0..arguments.cases).filter(|index| !known.contains(index)) {
        match examine(arguments, index) {
            Ok(case) => {
                file.write_all((serde_json::to_string(&case)? + "\n").as_bytes())?;
                cases.push(case);
            }
            Err(error) => eprintln!("case {index}: {error}"),
        }
    }
    cases.retain(|case| case.index < arguments.cases);
    println!("{}", table(&cases));
    Ok(())
}
