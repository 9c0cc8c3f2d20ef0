//! Counts over the corpus: rates with their limits, and what was named for what.

use super::{Judged, Outcome};
use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
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
        self.rates(&mut text).and_then(|()| self.matrix(&mut text)).expect("a string takes all");
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

/// `backlash [A5]`, … without their places.
fn kinds_of(effects: &[String]) -> String {
    let kind = |words: &String| words.split(' ').next().unwrap_or(words).to_owned();
    effects.iter().map(kind).collect::<Vec<_>>().join(" + ")
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
