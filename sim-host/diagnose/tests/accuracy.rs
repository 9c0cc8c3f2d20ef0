//! What is asked of a model decides what is missing in it; a real robot is told in parts.

use trueweld_diagnose::improve::{HeldOut, improve};
use trueweld_diagnose::{DiagnosisVerdict, ExplainedPart, diagnose};
use trueweld_estimate::fit::FitProblem;
use trueweld_estimate::residuals::compare::{baseline, experiments};
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::Log;
use trueweld_plant::input::{Accuracy, ModelFile};

fn campaign(name: &str) -> (ModelFile, Vec<Log>) {
    let folder = format!("{}/../../fixtures/campaigns/{name}", env!("CARGO_MANIFEST_DIR"));
    let campaign = Campaign::read(folder).unwrap();
    (ModelFile::read(&campaign.model).unwrap(), campaign.logs)
}

#[test]
fn a_gap_counts_where_it_is_more_than_is_asked_for() {
    let (model, mut logs) = campaign("backlash");
    logs.retain(|log| log.name == "static");
    let verdict = |asked: f64| {
        let mut logs = logs.clone();
        for log in &mut logs {
            log.accuracy.tcp_position = Some(asked);
            log.accuracy.tcp_rotation = Some(asked);
        }
        let ready = experiments(&logs, &baseline(&model)).unwrap();
        let told = diagnose(&FitProblem::new(&model, ready), &logs, &|_, _| ()).unwrap();
        let diagnosis = told.diagnosis;
        let named = diagnosis.candidates.first().map(|c| c.effects[0].effect.kind.id);
        (diagnosis.verdict, named.filter(|_| diagnosis.chosen > 0))
    };
    // The tool is off by some tenths of a millimetre.
    assert_eq!(verdict(2e-3).0, DiagnosisVerdict::Adequate);
    assert_eq!(verdict(1e-6), (DiagnosisVerdict::EffectFound, Some("backlash")));
}

#[test]
fn what_a_campaign_asks_for_stands_before_its_model() {
    let (mut model, mut logs) = campaign("nothing-missing");
    logs.retain(|log| log.name == "static");
    model.accuracy =
        Accuracy { tcp_position: Some(1e-3), force: Some(50.0), ..Accuracy::default() };
    logs[0].accuracy.tcp_position = Some(2e-3);
    let ready = experiments(&logs, &baseline(&model)).unwrap();
    assert!(ready[0].compared.iter().any(|c| c.accuracy == 2e-3));
    // Neither asked for, and noise stated: the noise alone.
    assert!(ready[0].compared.iter().all(|c| [0.0, 2e-3].contains(&c.accuracy)));
}

/// The KUKA KR 300 of the fixture: its second encoders are zeroed otherwise and read late, and the
/// friction of its wrist is more than its model has. Fitted to one run, judged on the other.
#[test]
fn a_real_robot_is_explained_in_part_on_a_run_that_nothing_was_fitted_to() {
    let (model, logs) = campaign("kr300-measured");
    let ready = |log: &Log| experiments(std::slice::from_ref(log), &baseline(&model)).unwrap();
    let [fitted, judge] = &logs[..] else { panic!("{} logs", logs.len()) };
    let held_out = HeldOut::new(&model, std::slice::from_ref(judge), ready(judge));
    let problem = FitProblem::new(&model, ready(fitted));
    let logs = std::slice::from_ref(fitted);
    let improvement = improve(&problem, logs, Some(&held_out), &|_, _| ()).unwrap().improvement;
    assert_eq!(improvement.verdict, DiagnosisVerdict::UnknownEffect);
    assert_eq!(improvement.explained(), ExplainedPart::Part);
    assert!(improvement.discovered.is_empty());
    let last = improvement.last();
    for found in &last.effects {
        assert!(found.is_told_from_nothing(), "{found:?}");
    }
    let delay = last.effects.iter().find(|f| f.effect.kind.id == "channel-delay").unwrap();
    // The other run says 3.07 ms.
    assert!((3.0e-3..3.1e-3).contains(&delay.effect.values[0]), "{delay:?}");
    let error = |step: &trueweld_diagnose::improve::ImprovementStep| {
        step.errors.iter().find(|e| e.channel == "link_encoder").unwrap().rmse
    };
    assert!(error(improvement.first()) > 1.4e-3 && error(last) < 5e-5, "{}", error(last));
}
