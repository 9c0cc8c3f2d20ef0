//! Counts over the corpus: rates with their limits, and what was named for what.

use super::{DiscoveredLaw, Judged, Named, Outcome};
use crate::outside::FreeFormEffect;
use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use trueweld_diagnose::rules;
use trueweld_evaluate::Rate;

/// Ranges of how well something shows, in multiples of the limit of detection, and what they are
/// called.
const BANDS: [(&str, f64, f64); 4] = [
    ("below the limit", 0.0, 0.7),
    ("about the limit", 0.7, 1.8),
    ("about 3 × the limit", 1.8, 5.5),
    ("about 10 × the limit and more", 5.5, f64::INFINITY),
];

/// What counts as right: all that is hidden is named at its place.
const RIGHT: [Outcome; 4] =
    [Outcome::Right, Outcome::RightTie, Outcome::RightAsCalibration, Outcome::RightAndMore];

/// Everything judged.
#[derive(Debug, Default)]
pub struct Tally {
    judged: Vec<Judged>,
}

impl Tally {
    /// Over these cases.
    pub fn new(judged: Vec<Judged>) -> Self {
        Self { judged }
    }

    fn with(&self, is: impl Fn(&Judged) -> bool) -> Vec<&Judged> {
        self.judged.iter().filter(|j| is(j)).collect()
    }

    /// The rates and what was named for what, as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = String::new();
        self.rates(&mut text)
            .and_then(|()| self.beside_discovery(&mut text))
            .and_then(|()| self.matrix(&mut text))
            .and_then(|()| self.laws(&mut text))
            .and_then(|()| self.reliability(&mut text))
            .expect("a string takes all");
        text
    }

    fn rates(&self, out: &mut String) -> fmt::Result {
        use Outcome::{
            FalseAlarm, Missed, NamedSomething, OneOfTwo, Right, SaidUnknown, WrongEffect,
            WrongPlace,
        };
        let was =
            |cases: &[&Judged], any: &[Outcome]| Rate::of(cases, |j| any.contains(&j.outcome));
        writeln!(
            out,
            "| one effect hidden | right | right effect, wrong place | wrong effect | \"unknown\" | \"adequate\" |"
        )?;
        writeln!(out, "|---|---|---|---|---|---|")?;
        for (band, low, high) in BANDS {
            let cases = self.with(|j| {
                !j.unknown && j.truth.len() == 1 && (low..high).contains(&j.seen[0].ratio)
            });
            writeln!(
                out,
                "| {band} | {} | {} | {} | {} | {} |",
                was(&cases, &RIGHT),
                was(&cases, &[WrongPlace]),
                was(&cases, &[WrongEffect]),
                was(&cases, &[SaidUnknown]),
                was(&cases, &[Missed])
            )?;
        }
        writeln!(
            out,
            "\n| something else hidden | right | a wrong effect | \"unknown\" | \"adequate\" |\n|---|---|---|---|---|"
        )?;
        let none = self.with(|j| j.truth.is_empty());
        writeln!(
            out,
            "| nothing | {} | {} | {} | |",
            was(&none, &[Right]),
            was(&none, &[FalseAlarm]),
            was(&none, &[SaidUnknown])
        )?;
        for (band, low, high) in BANDS {
            let cases = self.with(|j| j.unknown && (low..high).contains(&j.seen[0].ratio));
            writeln!(
                out,
                "| outside the library, {band} | {} | {} | | {} |",
                was(&cases, &[Right]),
                was(&cases, &[NamedSomething]),
                was(&cases, &[Missed])
            )?;
        }
        for (band, low, high) in BANDS {
            let two = self.with(|j| j.truth.len() == 2 && (low..high).contains(&weaker(j)));
            writeln!(
                out,
                "| two effects, the weaker {band} | {}; one of them: {} | {} | {} | {} |",
                was(&two, &RIGHT),
                was(&two, &[OneOfTwo]),
                was(&two, &[WrongPlace, WrongEffect]),
                was(&two, &[SaidUnknown]),
                was(&two, &[Missed])
            )?;
        }
        Ok(())
    }

    /// What looking outside the library makes of what it has: right answers of the library alone that
    /// stay, and others that become right.
    fn beside_discovery(&self, out: &mut String) -> fmt::Result {
        let cases = self.with(|j| !j.unknown && !j.truth.is_empty() && weaker(j) >= BANDS[2].1);
        if cases.is_empty() {
            return Ok(());
        }
        let right = |j: &&&Judged| RIGHT.contains(&j.outcome);
        let (alone, others): (Vec<&Judged>, Vec<&Judged>) =
            cases.into_iter().partition(|j| RIGHT.contains(&j.within));
        writeln!(
            out,
            "\nEffects of the library, from three times the limit on: right by the library alone {} of {}; of these \
             still right with discovery {}; right with it alone {}.",
            alone.len(),
            alone.len() + others.len(),
            Rate::of(&alone, |j| right(&j)),
            others.iter().filter(right).count()
        )?;
        let wrong = alone.iter().chain(&others).filter(|j| !right(j));
        let told = wrong.clone().filter(|j| told(j)).count();
        writeln!(
            out,
            "Not right: {}; of these what is hidden, had it been known, fits better than the answer by more than a \
             tie allows in {told}.",
            wrong.count()
        )
    }

    /// The confusion matrix, its rows written out: nearly all of its fields are empty.
    fn matrix(&self, out: &mut String) -> fmt::Result {
        writeln!(
            out,
            "\n| hidden, above the limit | cases | right | instead |\n|---|---|---|---|"
        )?;
        // One effect, then two, then what the library does not have.
        let mut rows: BTreeMap<(bool, usize, String), TallyRow> = BTreeMap::new();
        for j in self.with(|j| !j.truth.is_empty() && weaker(j) >= BANDS[1].1) {
            let key = (j.unknown, j.truth.len(), kinds_of(&j.truth));
            let row = rows.entry(key).or_default();
            row.cases += 1;
            if RIGHT.contains(&j.outcome) {
                row.right += 1;
            } else {
                *row.instead.entry(answer(j)).or_default() += 1;
            }
        }
        for ((unknown, _, truth), TallyRow { cases, right, instead }) in rows {
            let mut words = String::new();
            for (what, count) in instead {
                let separator = if words.is_empty() { "" } else { ", " };
                let times = if count > 1 { format!(" × {count}") } else { String::new() };
                write!(words, "{separator}{what}{times}")?;
            }
            let outside = if unknown { " (outside the library)" } else { "" };
            writeln!(out, "| {truth}{outside} | {cases} | {right} | {words} |")?;
        }
        Ok(())
    }

    /// What was found of the laws outside the library from three times the limit on, and where
    /// nothing is hidden.
    fn laws(&self, out: &mut String) -> fmt::Result {
        let none = self.with(|j| j.truth.is_empty());
        if !none.is_empty() {
            let found = Rate::of(&none, |j| j.discovered.is_some());
            writeln!(out, "\nA law found where nothing is hidden: {found}.")?;
        }
        let all = self.with(|j| law_of(j).is_some() && j.seen[0].ratio >= BANDS[2].1);
        if all.is_empty() {
            return Ok(());
        }
        writeln!(
            out,
            "\n| law | cases | named as an effect | though told from it | found | at its port, place and variables | or tied with that | median fall |\n\
             |---|---|---|---|---|---|---|---|"
        )?;
        let mut rows: BTreeMap<&str, Vec<&Judged>> = BTreeMap::new();
        for (law, j) in all.iter().filter_map(|j| Some((law_of(j)?, j))) {
            rows.entry(law.name).or_default().push(j);
        }
        for (law, cases) in &rows {
            let cells = Self::of_laws(cases).map(|rate| rate.hits.to_string()).join(" | ");
            writeln!(out, "| {law} | {} | {cells} | {} |", cases.len(), median_fall(cases))?;
        }
        let mut shown: Vec<f64> = all.iter().map(|j| j.target).collect();
        shown.sort_by(f64::total_cmp);
        shown.dedup();
        for target in shown {
            let cases: Vec<&Judged> = all.iter().copied().filter(|j| j.target == target).collect();
            let cells = Self::of_laws(&cases).map(|rate| rate.to_string()).join(" | ");
            let (count, fall) = (cases.len(), median_fall(&cases));
            writeln!(out, "| made to show {target} × the limit | {count} | {cells} | {fall} |")?;
        }
        let cells = Self::of_laws(&all).map(|rate| rate.to_string()).join(" | ");
        writeln!(out, "| all | {} | {cells} | {} |", all.len(), median_fall(&all))?;
        let held = |of: fn(&DiscoveredLaw) -> Option<[usize; 2]>| {
            let counts: Vec<[usize; 2]> =
                all.iter().filter_map(|j| of(j.discovered.as_ref()?)).collect();
            let sum = |k: usize| counts.iter().map(|c| c[k]).sum();
            (counts.len(), Rate { hits: sum(0), of: sum(1) })
        };
        let (curves, of_bands) = held(|law| law.band);
        let (formulas, of_values) = held(|law| law.values);
        writeln!(
            out,
            "\nBands of 95 % hold the law at {of_bands} places of {curves} curves; intervals of 95 % hold its values in \
             {of_values} of {formulas} formulas that can be it."
        )
    }

    /// How many were named as an effect, and that though the law itself, had it been known, fits better
    /// than a tie allows; how many were found, found as what they are, or tied with it.
    fn of_laws(cases: &[&Judged]) -> [Rate; 5] {
        let found = |is: fn(&DiscoveredLaw) -> bool| {
            Rate::of(cases, |j| j.discovered.as_ref().is_some_and(is))
        };
        let named = |j: &Judged| j.outcome == Outcome::NamedSomething;
        let all = Rate::of(cases, |j| named(j));
        let told = Rate::of(cases, |j| named(j) && told(j));
        [all, told, found(|_| true), found(|law| law.right), found(|law| law.right || law.tied)]
    }

    /// How often explanations are right, by the probability that they were given.
    fn reliability(&self, out: &mut String) -> fmt::Result {
        let stated: Vec<(f64, bool)> = self.judged.iter().flat_map(statements).collect();
        let bins = PROBABILITIES.windows(2).map(|ends| {
            let within = |(p, _): &&(f64, bool)| (ends[0]..ends[1]).contains(p);
            let within: Vec<&(f64, bool)> = stated.iter().filter(within).collect();
            let mean = within.iter().map(|s| s.0).sum::<f64>() / within.len() as f64;
            Bin { ends: [ends[0], ends[1].min(1.0)], mean, right: Rate::of(&within, |s| s.1) }
        });
        let bins: Vec<Bin> = bins.filter(|bin| bin.right.of > 0).collect();
        let list = |of: &dyn Fn(&Bin) -> String| bins.iter().map(of).collect::<Vec<_>>().join(", ");
        let share = |rate: &Rate| rate.hits as f64 / rate.of as f64;
        writeln!(
            out,
            "\n```mermaid\nxychart-beta\n    x-axis \"probability stated\" [{}]",
            list(&|b| format!("\"{:.2}\"", b.mean))
        )?;
        writeln!(out, "    y-axis \"share that is right\" 0 --> 1")?;
        writeln!(out, "    bar [{}]", list(&|b| format!("{:.2}", share(&b.right))))?;
        writeln!(out, "    line [{}]\n```\n", list(&|b| format!("{:.2}", b.mean)))?;
        writeln!(out, "| probability stated | on average | right |\n|---|---|---|")?;
        for Bin { ends: [low, high], mean, right } in &bins {
            writeln!(out, "| {low} to {high} | {mean:.2} | {right} |")?;
        }
        let square = |(p, right): &(f64, bool)| (p - f64::from(u8::from(*right))).powi(2);
        let brier = stated.iter().map(square).sum::<f64>() / self.judged.len().max(1) as f64;
        writeln!(
            out,
            "\nBrier score, summed over the explanations of a case and \"none of these\", mean over {} cases: {brier:.3}.",
            self.judged.len()
        )
    }
}

/// Ends of the ranges of probabilities that are told apart.
const PROBABILITIES: [f64; 7] = [0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.1];

/// What a diagnosis stated: the probability of each explanation, and that of none of them, each
/// with whether it is so. A calibration that it reported is none of them.
fn statements(judged: &Judged) -> Vec<(f64, bool)> {
    let left: Vec<&String> =
        judged.truth.iter().filter(|t| !judged.calibration.contains(t)).collect();
    let same = |named: &Named, truth: &[&String]| {
        named.effects.len() == truth.len() && truth.iter().all(|t| named.effects.contains(t))
    };
    let all: Vec<&String> = judged.truth.iter().collect();
    let right = |named: &Named| {
        !judged.unknown && !all.is_empty() && (same(named, &all) || same(named, &left))
    };
    let any = judged.named.iter().any(right);
    let calibrated = |named: &Named| {
        named.effects.iter().all(|e| judged.calibration.contains(e)) && !right(named)
    };
    let named = judged.named.iter().filter(|named| !calibrated(named));
    let mut stated: Vec<(f64, bool)> =
        named.map(|named| (named.probability, right(named))).collect();
    let sum: f64 = stated.iter().map(|s| s.0).sum();
    stated.push(((1.0 - sum).clamp(0.0, 1.0), !any));
    stated
}

/// True where what is hidden, had it been known, fits better than the answer by more than a tie allows.
fn told(j: &Judged) -> bool {
    j.truth_cost.is_some_and(|truth| {
        j.answer_cost - truth > rules::DECISIVE_FALL * trueweld_estimate::AUTOCORRELATION_INFLATION
    })
}

/// The law outside the library that is hidden, whatever joint it is at.
fn law_of(j: &Judged) -> Option<&'static FreeFormEffect> {
    FreeFormEffect::named(kind_of(j.truth.first()?)).filter(|_| j.unknown)
}

/// Median share by which the error above the floor falls where nothing was fitted. The floor is what the
/// law itself leaves there, calibrations fitted beside it.
fn median_fall(cases: &[&Judged]) -> String {
    let fall = |j: &&Judged| {
        let [before, after, floor] = j.scores;
        (before - after) / (before - floor)
    };
    let mut falls: Vec<f64> = cases.iter().map(fall).collect();
    falls.sort_by(f64::total_cmp);
    let middle = [falls[(falls.len() - 1) / 2], falls[falls.len() / 2]];
    format!("{:.0} %", 50.0 * (middle[0] + middle[1]))
}

/// Explanations that were given a probability between two ends.
struct Bin {
    ends: [f64; 2],
    /// Of the probabilities.
    mean: f64,
    right: Rate,
}

/// A row of the confusion matrix: so many cases, right ones, and what was answered to the others.
#[derive(Default)]
struct TallyRow {
    cases: usize,
    right: usize,
    instead: BTreeMap<String, usize>,
}

/// How well the part of the truth shows that shows least.
fn weaker(judged: &Judged) -> f64 {
    judged.seen.iter().map(|seen| seen.ratio).fold(f64::INFINITY, f64::min)
}

/// `backlash [A5]` without its place.
fn kind_of(effect: &str) -> &str {
    effect.split(' ').next().unwrap_or(effect)
}

/// The same of each, in one line.
fn kinds_of(effects: &[String]) -> String {
    effects.iter().map(|effect| kind_of(effect)).collect::<Vec<_>>().join(" + ")
}

fn answer(judged: &Judged) -> String {
    match (judged.outcome, judged.named.first()) {
        (Outcome::Missed, _) => "\"adequate\"".to_owned(),
        (Outcome::SaidUnknown, _) => "\"unknown\"".to_owned(),
        (Outcome::WrongPlace, _) => "wrong place".to_owned(),
        (_, Some(first)) => kinds_of(&first.effects),
        (_, None) => judged.verdict.clone(),
    }
}
