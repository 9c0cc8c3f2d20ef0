//! The intervals that a diagnosis states of the calibrations it keeps hold what is true, although it
//! leaves out those that do not count.

use trueweld_diagnose::diagnose;
use trueweld_laboratory::{Protocol, Recipe};
use trueweld_plant::effects::Effect;
use trueweld_tests::corpus::ready;

/// Values of stiffness that are told over so many cells, and how many of the intervals hold the
/// truth.
fn told(seeds: std::ops::Range<u64>) -> (usize, usize) {
    let (mut of, mut hold) = (0, 0);
    for seed in seeds {
        let recipe =
            Recipe { protocol: Protocol::short(), geometry_error: 3e-4, ..Recipe::plain(seed) }
                .with_nuisance(0.05, 1e-4, 1e-4);
        let ready = ready(&recipe).expect("a campaign");
        let diagnosis =
            diagnose(&ready.problem, &ready.logs, &|_, _| {}).expect("a diagnosis").diagnosis;
        let truth = recipe.miscalibrations(0);
        for told in diagnosis.calibration.iter().filter(|f| f.effect.kind.id == "stiffness-error") {
            let same = |e: &&Effect| (e.kind.id, e.at) == (told.effect.kind.id, told.effect.at);
            let all = truth.iter().filter(same).map(|e| 1.0 + e.values[0]);
            let truth = all.product::<f64>() - 1.0;
            let [low, high] = told.interval[0];
            of += 1;
            hold += usize::from((low..=high).contains(&truth));
        }
    }
    (of, hold)
}

#[test]
#[ignore = "release checklist"]
fn intervals_hold_the_truth_beside_calibrations_that_are_left_out() {
    let (of, hold) = told(1..7);
    // Nine in ten: where what is left out counts as known, 23 of these 27 hold it.
    assert!(of >= 15 && 10 * hold >= 9 * of, "{hold} of {of}");
}
