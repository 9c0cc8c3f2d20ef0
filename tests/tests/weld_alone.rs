//! A single log of a weld, as it is recorded first: what is wrong with the material or the force
//! sensor is named, or stands in a tie that is declared. The tool's depth goes through the contact
//! with all of the tracker's noise, and the push rises within the first seconds.

use trueweld_laboratory::ProtocolFile;
use trueweld_measure::diagnose::{Verdict, diagnose};
use trueweld_measure::discover::discover;
use trueweld_tests::corpus::recorded;
use trueweld_tests::fixture;

/// A weld of `fixtures/welds` in a cell with this effect.
fn weld(name: &str, effect: &str, seed: u64) -> ProtocolFile {
    let text = format!(
        "schema = \"protocol/1\"\nrobot = \"robots/kr500-mt.toml\"\nprocess = \"processes/lap-weld-2024-t3.toml\"\n\
         seed = {seed}\n[[effect]]\n{effect}\n[[log]]\nname = \"weld\"\nkind = \"weld\"\nweld = \"welds/{name}.toml\"\n"
    );
    ProtocolFile::parse(&text, &fixture("protocol.toml")).expect("a protocol")
}

/// Effects of the first explanation and of those tied with it, with the first value of each.
fn answer(protocol: &ProtocolFile) -> Vec<(&'static str, f64)> {
    let ready = recorded(protocol).expect("the campaign is made");
    let mut diagnosis = diagnose(&ready.bench, &ready.logs, &|_, _| ()).expect("diagnosed");
    let discovered = discover(&ready.bench, &ready.logs, &mut diagnosis, &|_, _| ());
    let laws: Vec<_> = discovered.iter().map(|law| (law.hypothesis, &law.expression)).collect();
    assert!(laws.is_empty() && diagnosis.verdict == Verdict::EffectFound, "{laws:?}");
    let first = &diagnosis.candidates[0];
    let tied = first.indistinguishable.iter().map(|k| &diagnosis.candidates[*k]);
    let effects = std::iter::once(first).chain(tied).flat_map(|c| &c.effects);
    effects.map(|e| (e.effect.kind.id, e.effect.values[0])).collect()
}

/// Three coupons in a cell whose joints are softer or firmer than the file has them by these shares.
fn coupons(stiffness: [f64; 6], seed: u64) -> ProtocolFile {
    let mut text = format!(
        "schema = \"protocol/1\"\nrobot = \"robots/kr500-mt.toml\"\nprocess = \"processes/lap-weld-2024-t3.toml\"\n\
         seed = {seed}\n"
    );
    for (joint, relative) in stiffness.iter().enumerate() {
        let at = joint + 1;
        text += &format!(
            "[[effect]]\nid = \"stiffness-error\"\nat = \"A{at}\"\nrelative = {relative}\n"
        );
    }
    for weld in 1..=3 {
        text += &format!(
            "[[log]]\nname = \"weld-{weld}\"\nkind = \"weld\"\nweld = \"welds/coupon.toml\"\n"
        );
    }
    ProtocolFile::parse(&text, &fixture("protocol.toml")).expect("a protocol")
}

#[test]
fn what_is_not_known_of_the_arm_at_the_spindle_s_orders_makes_no_effect_likely() {
    // The lines are off alike in all rows by what the joints are: a loop of A3 that is a hundredth of
    // its torque makes up for it.
    let protocol = coupons([0.09, -0.1, 0.08, 0.12, -0.11, 0.1], 11);
    let ready = recorded(&protocol).expect("the campaign is made");
    let mut diagnosis = diagnose(&ready.bench, &ready.logs, &|_, _| ()).expect("diagnosed");
    let discovered = discover(&ready.bench, &ready.logs, &mut diagnosis, &|_, _| ());
    assert!(discovered.is_empty() && diagnosis.verdict == Verdict::Adequate);
    let likely: Vec<_> =
        diagnosis.candidates.iter().filter(|c| c.probability > 0.01).map(|c| &c.effects).collect();
    assert!(likely.is_empty(), "{likely:?}");
}

fn named(weld_name: &str, id: &str, value: (&str, f64), seed: u64) {
    let effect = format!("id = \"{id}\"\n{} = {}", value.0, value.1);
    let found = answer(&weld(weld_name, &effect, seed));
    let own = found.iter().find(|(named, _)| *named == id);
    // Within a tenth: intervals of the tied ones are some per cent wide.
    let is_near = |found: f64| (found - value.1).abs() < 0.1 * value.1.abs();
    assert!(own.is_some_and(|(_, found)| is_near(*found)), "{weld_name}, {id}: {found:?}");
}

#[test]
fn a_material_that_is_softer_or_firmer_is_not_taken_for_a_sensor_or_a_law() {
    named("coupon", "process-stiffness-error", ("relative", -0.25), 21);
    named("coupon", "process-stiffness-error", ("relative", 0.3), 22);
    named("panel-stringer", "process-stiffness-error", ("relative", 0.3), 23);
}

#[test]
fn a_drag_that_hardly_grows_with_the_feed_is_named() {
    named("coupon", "feed-power-law", ("exponent", 0.6), 31);
}

#[test]
fn a_force_sensor_that_reads_too_little_is_named() {
    named("coupon", "force-scale", ("relative", -0.2), 24);
}

#[test]
#[ignore = "fails: along a curved seam a law of the push, with five joints stiffer by a fifth, predicts blocks left out by a hundredth better"]
fn a_force_sensor_that_reads_too_much_along_a_curved_seam_is_named() {
    named("panel-stringer", "force-scale", ("relative", 0.2), 25);
}
