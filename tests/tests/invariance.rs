//! An answer does not depend on how a campaign is written down: the order and the names of its logs,
//! the time origin, units and stated factors, a log in two, a few wild rows.
//!
//! The files are changed here, not by the code under test.

use crate::same_answer::{answer, copy, logs, rewrite, soft_base};
use proptest::prelude::*;
use proptest::sample::subsequence;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;
use trueweld_laboratory::{Protocol, Recipe};
use trueweld_plant::random::Random;
use trueweld_tests::LABORATORY;

/// How a campaign is written down otherwise.
#[derive(Debug, Clone, Copy)]
enum Rewriting {
    Reversed,
    Renamed,
    LaterOrigin,
    InTwo,
    Millimetres,
    DoubledByFactor,
    WildRows,
}

const REWRITINGS: [Rewriting; 7] = [
    Rewriting::Reversed,
    Rewriting::Renamed,
    Rewriting::LaterOrigin,
    Rewriting::InTwo,
    Rewriting::Millimetres,
    Rewriting::DoubledByFactor,
    Rewriting::WildRows,
];

impl Rewriting {
    fn apply(self, folder: &Path, random: &mut Random) {
        match self {
            Self::Reversed => list(folder, logs(folder).into_iter().rev()),
            Self::Renamed => renamed(folder),
            Self::LaterOrigin => {
                let origin = random.between(-1e3, 1e5).round();
                rewrite(folder, &mut |_, _, mut rows| {
                    rows.iter_mut().for_each(|row| row[0] += origin);
                    rows
                });
            }
            Self::InTwo => in_two(folder),
            Self::Millimetres => mapped(folder, &["px", "py", "pz"], "m", "mm", 1e3, None),
            Self::DoubledByFactor => {
                let torques: Vec<String> = (1..=6).map(|joint| format!("tm{joint}")).collect();
                let torques: Vec<&str> = torques.iter().map(String::as_str).collect();
                mapped(folder, &torques, "nm", "raw", 2.0, Some(0.5));
            }
            Self::WildRows => wild_rows(folder, random),
        }
    }
}

/// Writes which logs a campaign has.
fn list(folder: &Path, names: impl Iterator<Item = String>) {
    let names: Vec<String> = names.map(|name| format!("{name:?}")).collect();
    let file = folder.join("campaign.toml");
    let text = fs::read_to_string(&file).expect("a campaign");
    let others = text.lines().filter(|line| !line.starts_with("logs"));
    let mut lines: Vec<String> = others.map(str::to_owned).collect();
    lines.push(format!("logs = [{}]\n", names.join(", ")));
    fs::write(&file, lines.join("\n")).expect("a campaign");
}

fn renamed(folder: &Path) {
    let names = logs(folder);
    let new = |k: usize| format!("{} Meßreihe", names.len() - k);
    for (k, name) in names.iter().enumerate() {
        fs::rename(folder.join(name), folder.join(new(k))).expect("a log");
    }
    list(folder, (0..names.len()).map(new));
}

/// The loads at rest in two logs, each with half of the rows.
fn in_two(folder: &Path) {
    let mut names = logs(folder);
    let Some(at_rest) = names.iter().find(|name| name.contains("static")).cloned() else { return };
    let second = format!("{at_rest}-evening");
    copy(&folder.join(&at_rest), &folder.join(&second));
    names.push(second.clone());
    list(folder, names.into_iter());
    rewrite(folder, &mut |name, _, rows| {
        let half = rows.len() / 2;
        match name {
            _ if name == at_rest => rows[..half].to_vec(),
            _ if name == second => rows[half..].to_vec(),
            _ => rows,
        }
    });
}

/// Columns in another unit, which `log.toml` states.
fn mapped(folder: &Path, channels: &[&str], si: &str, unit: &str, times: f64, factor: Option<f64>) {
    rewrite(folder, &mut |_, header, mut rows| {
        let is_of = |h: &&str| channels.iter().any(|channel| **h == format!("{channel}_{si}"));
        let places: Vec<usize> = (0..header.len()).filter(|k| is_of(&header[*k])).collect();
        for row in &mut rows {
            places.iter().for_each(|k| row[*k] *= times);
        }
        rows
    });
    for name in logs(folder) {
        let [samples, toml] = ["samples.csv", "log.toml"].map(|file| folder.join(&name).join(file));
        let mut text = fs::read_to_string(&samples).expect("samples");
        let mut table = String::new();
        for channel in channels {
            let (from, to) = (format!("{channel}_{si}"), format!("{channel}_{unit}"));
            if text.lines().next().is_some_and(|header| header.split(',').any(|h| h == from)) {
                text = text.replacen(&from, &to, 1);
                let stated = match factor {
                    Some(factor) => format!("unit = \"N·m\", factor = {factor:?}"),
                    None => format!("unit = {unit:?}"),
                };
                table += &format!("{to} = {{ channel = {channel:?}, {stated} }}\n");
            }
        }
        if !table.is_empty() {
            fs::write(&samples, text).expect("samples");
            let stated = fs::read_to_string(&toml).expect("a log");
            // Other columns may be mapped already, in the last table of the file.
            let head = if stated.contains("[columns]") { "" } else { "\n[columns]\n" };
            fs::write(&toml, format!("{stated}{head}{table}")).expect("a log");
        }
    }
}

/// Two rows of every log in which the tracker is off by centimetres.
fn wild_rows(folder: &Path, random: &mut Random) {
    rewrite(folder, &mut |_, header, mut rows| {
        let places = ["px_m", "py_m", "pz_m"].map(|name| header.iter().position(|h| *h == name));
        for _ in 0..2 {
            let row = (random.between(0.05, 0.95) * rows.len() as f64) as usize;
            for place in places.into_iter().flatten() {
                rows[row][place] += random.between(0.01, 0.05);
            }
        }
        rows
    });
}

static SOFT_BASE: LazyLock<(tempfile::TempDir, Vec<String>)> = LazyLock::new(|| {
    let (folder, hidden) = soft_base(0.0);
    let found = answer(folder.path());
    assert!(found.contains(&hidden), "{found:?}");
    (folder, found)
});

static SOUND: LazyLock<(tempfile::TempDir, Vec<String>)> = LazyLock::new(|| {
    let protocol = Protocol { postures: 6, welds: 0, ..Protocol::short() };
    let folder = tempfile::tempdir().expect("a folder");
    LABORATORY.write(&Recipe { protocol, ..Recipe::plain(29) }, folder.path()).expect("a campaign");
    let found = answer(folder.path());
    assert!(found.is_empty(), "{found:?}");
    (folder, found)
});

proptest! {
    // Each is a diagnosis of two campaigns.
    #![proptest_config(ProptestConfig { cases: 4, max_shrink_iters: 4, ..ProptestConfig::default() })]

    #[test]
    fn the_answer_is_the_same_however_a_campaign_is_written(
        rewritings in subsequence(REWRITINGS.to_vec(), 1..=4),
        seed: u64,
    ) {
        let [(found, expected), sound] = answers(&rewritings, seed);
        prop_assert_eq!(found, expected, "{:?}", rewritings);
        prop_assert_eq!(sound.0, sound.1, "{:?}", rewritings);
    }
}

#[test]
fn a_wild_load_alone_at_its_posture_changes_no_answer() {
    // The second half of the loads begins with one of a posture whose others are in the first half.
    let seed = 15_842_010_985_178_766_906;
    for (found, expected) in answers(&[Rewriting::InTwo, Rewriting::WildRows], seed) {
        assert_eq!(found, expected);
    }
}

/// The answer to what a campaign became, and to the campaign: of one on a soft base, and of one with
/// nothing missing. Those that the logs do not tell apart are one answer, in whichever order.
fn answers(rewritings: &[Rewriting], seed: u64) -> [(Vec<String>, Vec<String>); 2] {
    [&*SOFT_BASE, &*SOUND].map(|(clean, expected)| {
        let folder = tempfile::tempdir().expect("a folder");
        copy(clean.path(), folder.path());
        let mut random = Random::new(seed, 0);
        let is_unit =
            |one: &Rewriting| matches!(one, Rewriting::Millimetres | Rewriting::DoubledByFactor);
        // Units last: what is rewritten before is in those of the plain file.
        let others = rewritings.iter().rev().filter(|one| !is_unit(one));
        let units = rewritings.iter().filter(|one| is_unit(one));
        others.chain(units).for_each(|one| one.apply(folder.path(), &mut random));
        let (mut found, mut expected) = (answer(folder.path()), expected.clone());
        found.sort_unstable();
        expected.sort_unstable();
        (found, expected)
    })
}
