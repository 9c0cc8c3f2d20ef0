//! A law outside the library is found with its port, place and variables, and nothing is found
//! where nothing is missing. The laws and the laboratory's errors were chosen before they were run.

use trueweld_laboratory::{Protocol, Recipe};
use trueweld_measure::diagnose::{Verdict, diagnose};
use trueweld_measure::discover::{Discovery, discover};
use trueweld_tests::corpus::ready;
use trueweld_tests::outside::LAWS;

/// Motion alone, with a laboratory's usual errors, and one law outside the library in the cell.
fn found(name: Option<&str>, seed: u64) -> (Verdict, f64, Vec<Discovery>) {
    let protocol = Protocol { postures: 0, rings: 0, welds: 0, free: 8.0, ..Protocol::usual() };
    let recipe = Recipe { protocol, ..Recipe::plain(seed) }.with_nuisance(0.03, 1e-4, 1e-4);
    let law = LAWS.iter().find(|law| Some(law.name) == name);
    let ready = ready(&law.into_iter().fold(recipe, |r, law| r.with_effect(law.effect(1.0))));
    let ready = ready.expect("the campaign is made");
    let mut diagnosis = diagnose(&ready.bench, &ready.logs, &|_, _| ()).expect("diagnosed");
    let found = discover(&ready.bench, &ready.logs, &mut diagnosis, &|_, _| ());
    (diagnosis.verdict, trueweld_measure::diagnose::score(&diagnosis.improved.at), found)
}

#[test]
fn a_hose_that_is_slack_is_found_at_its_joint_over_its_angle() {
    let (verdict, score, found) = found(Some("hose"), 11);
    assert_eq!(verdict, Verdict::UnknownEffect);
    let [hose] = found.as_slice() else { panic!("{} laws", found.len()) };
    let law = LAWS.iter().find(|law| law.name == "hose").expect("in the list");
    assert_eq!((hose.hypothesis.port.name, hose.effect.effect.at), (law.port, law.effect(1.0).at));
    assert_eq!(hose.hypothesis.variables(), law.over);
    // At the floor, as far as it is known: a few hundred values that follow each other.
    assert!(score < 1.1, "{score}");
    // The band holds the truth as it says, but where straight lines round its corners.
    let truth = |x: f64| -700.0 * (x - 0.3 - (x - 0.3).clamp(-0.2, 0.2));
    let curve = &hose.curve;
    let within = curve.x.iter().zip(&curve.band).filter(|(x, [low, high])| {
        let truth = truth(**x);
        *low - 5.0 <= truth && truth <= *high + 5.0
    });
    let share = within.count() as f64 / curve.x.len() as f64;
    assert!(share > 0.8, "{share} of the band: {curve:?}");
}

#[test]
fn where_nothing_is_missing_nothing_is_found() {
    for seed in [21, 22] {
        let (_, _, found) = found(None, seed);
        assert!(found.is_empty(), "{:?}", found[0].hypothesis);
    }
}
