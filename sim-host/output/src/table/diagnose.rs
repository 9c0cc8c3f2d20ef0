//! A diagnosis and an improvement for a terminal.

use super::{WIDTH, left, push_line, right, wrapped};
use crate::diagnosed::{
    Diagnosed, Improved, REMAINS, confusable, in_a_line, limits, none_of_these, ranked, values,
};
use crate::words::{probability, score, share};
use trueweld_measure::diagnose::{FittedEffect, Verdict};
use trueweld_measure::residuals::localize::foremost;

/// Width of a column of figures.
const FIGURE: usize = 16;
/// Width of the names of explanations and steps.
const NAME: usize = WIDTH - 3 * FIGURE;
/// Pairs of effects that are hard to tell apart, told at most.
const PAIRS: usize = 5;

/// What a diagnosis found: the verdict, the explanations, calibrations apart, what could not be
/// seen or told apart, and what to record next.
pub fn diagnose_table(diagnosed: &Diagnosed<'_>) -> String {
    let Diagnosed { diagnosis, account, .. } = diagnosed;
    let robot = &diagnosed.model.robot;
    let mut out = wrapped(&diagnosed.headline());
    if let Some(explanation) = diagnosed.explanation() {
        out += &wrapped(&explanation);
    }
    out += &wrapped(&diagnosed.setting());
    let candidates = ranked(diagnosis);
    if !candidates.is_empty() {
        out += "\n";
        push_line(
            &mut out,
            &row("explanations tried", ["held-out score", "still unexplained", "probability"]),
        );
        for (k, c) in candidates.iter().enumerate() {
            let left = share(c.left.clamp(0.0, 1.0));
            let cells = [score(c.held_out_after), left, probability(c.probability)];
            push_line(
                &mut out,
                &row(
                    &format!("{}  {}", k + 1, c.name(robot)),
                    cells.each_ref().map(String::as_str),
                ),
            );
            for (name, value) in c.effects.iter().flat_map(values) {
                push_line(&mut out, &format!("     {name} {value}"));
            }
        }
        push_line(
            &mut out,
            &row("   none of these", ["", "", &probability(none_of_these(diagnosis))]),
        );
    }
    out += &calibration(&diagnosis.calibration, diagnosed);
    if diagnosis.verdict != Verdict::EffectFound {
        out += "\n";
        out += &wrapped("Smallest size of each effect that these logs would have shown:");
        for line in limits(diagnosis, robot) {
            let places: Vec<String> =
                line.places.iter().map(|(at, size)| format!("{at} {size}")).collect();
            out += &indented(&format!(
                "{} ({}): {}",
                line.kind.id,
                line.size,
                places.join("; ").trim()
            ));
        }
        for pair in diagnosis.confusable.iter().take(PAIRS) {
            let [first, second, apart] = confusable(pair, robot);
            out += &wrapped(&match apart.parse::<f64>() {
                Ok(_) => format!(
                    "These logs tell {first} from {second} only from {apart} × that size on."
                ),
                Err(_) => format!("These logs cannot tell {first} from {second} {apart}.")
                    .replace("not at", "at"),
            });
        }
    }
    let remains = foremost(&diagnosis.unexplained, REMAINS);
    if !remains.is_empty() {
        out += &format!("\nWhat remains (score {:.2}) goes with:\n", diagnosed.score_after());
        for finding in remains {
            out += &indented(&finding.sentence);
        }
    }
    if let Some(plan) = &account.next_experiment {
        out += "\n";
        out += &wrapped(&format!(
            "Next experiment: {}, about {:.0} minutes. {}",
            plan.title, plan.minutes, plan.reason
        ));
        for (k, step) in plan.steps.iter().enumerate() {
            out += &indented(&format!("{}. {step}", k + 1));
        }
    }
    out
}

/// How a model was improved: step by step, what was not kept, and every value fitted.
pub fn improve_table(improved: &Improved<'_>) -> String {
    let improvement = improved.improvement;
    let mut out = wrapped(&improved.headline())
        + &wrapped(&improved.verdict())
        + &wrapped(&improved.setting());
    out += "\n";
    push_line(&mut out, &row("", ["score", "held-out score", ""]));
    for (k, step) in improvement.steps.iter().enumerate() {
        let cells = [score(step.score), score(step.held_out)];
        push_line(&mut out, &row(&improved.step(k), [&cells[0], &cells[1], ""]));
    }
    for rejected in &improvement.rejected {
        let [what, why] = improved.rejected(rejected);
        let held_out =
            if rejected.held_out.is_finite() { score(rejected.held_out) } else { "–".to_owned() };
        push_line(&mut out, &row(&format!("not kept: {what}"), ["", &held_out, ""]));
        out += &indented(&format!("because {why}"));
    }
    let fitted = improved.fitted();
    if !fitted.is_empty() {
        out += "\n";
        for [name, parameter, value, from] in fitted {
            let cells =
                format!("{}{}{from}", left(&name, 34), left(&format!("{parameter} {value}"), 42));
            push_line(&mut out, &cells);
        }
    }
    let remains = foremost(&improvement.diagnosis.unexplained, REMAINS);
    if improvement.verdict == Verdict::UnknownEffect && !remains.is_empty() {
        out += "\nWhat remains goes with:\n";
        for finding in remains {
            out += &indented(&finding.sentence);
        }
    }
    out
}

fn row(name: &str, cells: [&str; 3]) -> String {
    cells.iter().fold(left(name, NAME), |line, cell| line + &right(cell, FIGURE + 2))
}

/// What is a little off besides.
fn calibration(all: &[FittedEffect], diagnosed: &Diagnosed<'_>) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut out = "\nA little off besides, as calibration:\n".to_owned();
    for found in all {
        let of = found.log.map_or(String::new(), |log| format!(" in {}", diagnosed.log(log)));
        out += &indented(&format!("{}{of}", in_a_line(found, &diagnosed.model.robot)));
    }
    out
}

/// A line of a list, set in.
fn indented(text: &str) -> String {
    wrapped(text)
        .lines()
        .enumerate()
        .map(|(k, line)| format!("{}{line}\n", if k == 0 { "  " } else { "     " }))
        .collect()
}
