//! A single log of a weld, as it is recorded first: what is wrong with the material or the force
//! sensor is named, or stands in a tie that is declared. The tool's depth goes through the contact
//! with all of the tracker's noise, and the push rises within the first seconds.

use trueweld_diagnose::discover::discover;
use trueweld_diagnose::{DiagnosisVerdict, diagnose};
use trueweld_estimate::fit::FitProblem;
use trueweld_estimate::residuals::compare::{baseline, experiments};
use trueweld_laboratory::ProtocolFile;
use trueweld_logs::campaign::Campaign;
use trueweld_plant::input::ModelFile;
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
    let found = diagnose(&ready.problem, &ready.logs, &|_, _| ()).expect("diagnosed");
    let (found, discovered) = discover(&ready.problem, &ready.logs, found, &|_, _| ());
    let diagnosis = found.diagnosis;
    let laws: Vec<_> = discovered.iter().map(|law| (law.hypothesis, &law.expression)).collect();
    assert!(laws.is_empty() && diagnosis.verdict == DiagnosisVerdict::EffectFound, "{laws:?}");
    let first = &diagnosis.candidates[0];
    let tied = first.indistinguishable.iter().map(|k| &diagnosis.candidates[*k]);
    let effects = std::iter::once(first).chain(tied).flat_map(|c| &c.effects);
    effects.map(|e| (e.effect.kind.id, e.effect.values[0])).collect()
}

#[test]
fn in_welds_of_a_sound_cell_a_tracker_that_was_moved_is_told_and_no_effect() {
    // The force at the spindle's order is off alike in all rows, and a harmonic makes up for it.
    let folder = fixture("campaigns/tracker-moved");
    let campaign = Campaign::read(&folder).expect("a campaign");
    let file = ModelFile::read(&campaign.model).expect("a model");
    let logs = campaign.logs;
    let ready = experiments(&logs, &baseline(&file)).expect("logs that can be compared");
    let problem = FitProblem::new(&file, ready);
    let found = diagnose(&problem, &logs, &|_, _| ()).expect("diagnosed");
    let (found, discovered) = discover(&problem, &logs, found, &|_, _| ());
    let diagnosis = found.diagnosis;
    assert!(discovered.is_empty() && diagnosis.verdict == DiagnosisVerdict::Adequate);
    let likely: Vec<_> =
        diagnosis.candidates.iter().filter(|c| c.probability > 0.01).map(|c| &c.effects).collect();
    assert!(likely.is_empty(), "{likely:?}");
    let told = diagnosis.calibration.iter().filter(|f| f.is_told_from_nothing());
    let told: Vec<_> = told.map(|f| f.effect.kind.id).collect();
    assert_eq!(told, ["tracker-registration"]);
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
#[ignore = "release checklist"]
fn a_material_that_is_softer_or_firmer_is_not_taken_for_a_sensor_or_a_law() {
    named("coupon", "process-stiffness-error", ("relative", -0.25), 21);
    named("coupon", "process-stiffness-error", ("relative", 0.3), 22);
    named("panel-stringer", "process-stiffness-error", ("relative", 0.3), 23);
}

#[test]
#[ignore = "release checklist"]
fn a_drag_that_hardly_grows_with_the_feed_is_named() {
    named("coupon", "feed-power-law", ("exponent", 0.6), 31);
}

#[test]
#[ignore = "release checklist"]
fn a_force_sensor_that_reads_too_little_is_named() {
    named("coupon", "force-scale", ("relative", -0.2), 24);
}

#[test]
#[ignore = "fails: along a curved seam a law of the push, with five joints stiffer by a fifth, predicts blocks left out by a hundredth better"]
fn a_force_sensor_that_reads_too_much_along_a_curved_seam_is_named() {
    named("panel-stringer", "force-scale", ("relative", 0.2), 25);
}
