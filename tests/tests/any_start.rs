//! A log may begin anywhere: cut at a random time it scores as the whole one does there.

use std::path::Path;
use tempfile::TempDir;
use trueweld_diagnose::diagnose;
use trueweld_estimate::fit::FitProblem;
use trueweld_estimate::predict::{BaselineModel, ComparedQuantity, PreparedLog};
use trueweld_estimate::residuals::compare::{baseline, experiments};
use trueweld_laboratory::{Protocol, Recipe, effect};
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::noise::instruments;
use trueweld_plant::effects::{Effect, Location};
use trueweld_plant::input::ModelFile;
use trueweld_plant::random::Random;
use trueweld_tests::{LABORATORY, fixture};

/// The rows of a log from one on.
fn cut(log: &Log, from: usize) -> Log {
    fn rest<T: Clone>(series: &mut Vec<T>, from: usize) {
        series.drain(..from);
    }
    let mut log = log.clone();
    let samples = &mut log.samples;
    rest(&mut samples.time, from);
    rest(&mut samples.encoder, from);
    samples.link_encoder.iter_mut().flatten().for_each(|s| rest(s, from));
    samples.motor_torque.iter_mut().flatten().for_each(|s| rest(s, from));
    samples.spindle.iter_mut().for_each(|s| rest(s, from));
    samples.payload.iter_mut().for_each(|s| rest(s, from));
    let vectors =
        [&mut samples.force, &mut samples.moment, &mut samples.position, &mut samples.rotation];
    vectors.into_iter().flatten().for_each(|s| rest(s, from));
    log
}

/// Residuals of a log over their noise, each with its row.
fn residuals(log: &Log, model: &BaselineModel, effects: &[Effect]) -> Vec<(usize, f64)> {
    let noise = instruments(std::slice::from_ref(log));
    let experiment = PreparedLog::new(log, &noise[0], model).expect("compared");
    let prediction = experiment.predict(model, effects, None).expect("predicted");
    experiment.compared.iter().map(|c| c.row).zip(prediction.residual).collect()
}

fn score(residuals: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = residuals.collect();
    (all.iter().map(|r| r * r).sum::<f64>() / all.len() as f64).sqrt()
}

/// Cuts the logs of a campaign at random times and compares what is left with the truth's effects:
/// alone, and as a part of the whole log. `near`: by how much more a kind may score.
fn cut_logs_score_as_whole_ones(
    folder: &Path,
    effects: &[Effect],
    seed: u64,
    near: impl Fn(LogKind) -> f64,
) {
    let campaign = Campaign::read(folder).expect("a campaign");
    let model = baseline(&ModelFile::read(&campaign.model).expect("a model"));
    let mut random = Random::new(seed, 3);
    let mut off = Vec::new();
    for log in &campaign.logs {
        let whole = residuals(log, &model, effects);
        for _ in 0..4 {
            let from = (random.between(0.1, 0.6) * log.samples.len() as f64) as usize;
            let own = residuals(&cut(log, from), &model, effects);
            let (first, last) = (own[0].0 + from, own.iter().map(|r| r.0).max().unwrap() + from);
            let there = whole.iter().filter(|(row, _)| (first..=last).contains(row));
            let (alone, whole) = (score(own.iter().map(|r| r.1)), score(there.map(|r| r.1)));
            let line =
                format!("{} from row {from}: {alone:.3}, as a part of it {whole:.3}", log.name);
            println!("{line}");
            // A weld's rows are few, and those compared are others. A start that is fitted may take a
            // little of the noise with it.
            let few: f64 = if log.kind == LogKind::Weld { 0.1 } else { 0.05 };
            if alone / whole - 1.0 >= few.max(near(log.kind)) {
                off.push(line);
            }
        }
    }
    assert!(off.is_empty(), "{off:#?}");
}

/// A campaign of the laboratory.
fn campaign(recipe: Recipe) -> TempDir {
    let protocol = Protocol { postures: 8, rings: 2, ring: 1.2, free: 6.0, welds: 1, seam: 0.12 };
    let folder = tempfile::tempdir().expect("a folder");
    LABORATORY.write(&Recipe { protocol, ..recipe }, folder.path()).expect("a campaign");
    folder
}

#[test]
fn a_log_cut_at_a_random_time_scores_as_the_whole_one() {
    cut_logs_score_as_whole_ones(campaign(Recipe::plain(11)).path(), &[], 11, |_| 0.0);
}

#[test]
fn a_gear_with_memory_may_be_anywhere_in_it_when_a_log_begins() {
    let effects = [effect("hysteresis", Location::Joint(1), &[2000.0, 1e-4])];
    let recipe = Recipe::plain(12).with_effect(effects[0].clone());
    // A swing as large as the loop, and a load that is smoothed from one side, are told less exactly;
    // with the gears at nothing it would be 60 %.
    cut_logs_score_as_whole_ones(campaign(recipe).path(), &effects, 12, |kind| match kind {
        LogKind::StaticLoad | LogKind::FreeMotion => 0.0,
        LogKind::RingDown | LogKind::Weld => 0.2,
    });
}

#[test]
fn where_a_gear_begins_is_taken_from_the_poses_and_paid_for() {
    // What sticks: where it begins shows in every pose.
    let effects = [effect("hysteresis", Location::Joint(5), &[1e4, 1e-5])];
    let folder = campaign(Recipe::plain(13));
    let campaign = Campaign::read(folder.path()).expect("a campaign");
    let model = baseline(&ModelFile::read(&campaign.model).expect("a model"));
    let paid = |kind: LogKind, part: fn(&Log) -> Log| {
        let whole = campaign.logs.iter().find(|log| log.kind == kind).expect("a log of its kind");
        let log = part(whole);
        let noise = instruments(std::slice::from_ref(&log));
        let experiment = PreparedLog::new(&log, &noise[0], &model).expect("compared");
        let [with, without] = [&effects[..], &[]]
            .map(|effects| experiment.predict(&model, effects, None).expect("predicted"));
        with.not_evidence - without.not_evidence
    };
    assert_eq!(paid(LogKind::FreeMotion, Log::clone), 0.0, "it begins at rest without a load");
    let within = paid(LogKind::Weld, |log| cut(log, log.samples.len() / 3));
    assert!(within > 1.0, "{within}");
}

#[test]
fn a_link_may_be_anywhere_in_its_play_when_a_log_begins() {
    // Recorded on another engine's plant.
    let effects = [effect("backlash", Location::Joint(4), &[2.4e-4])];
    cut_logs_score_as_whole_ones(&fixture("campaigns/backlash"), &effects, 14, |_| 0.0);
}

#[test]
fn a_weld_cut_while_the_push_rises_does_not_say_where_its_channel_lies() {
    // Recorded on another engine's plant. The tool has been pushed 0.1 mm beside its channel there;
    // with the channel under the tool this column would score 1.96.
    let campaign = Campaign::read(fixture("campaigns/nothing-missing")).expect("a campaign");
    let model = baseline(&ModelFile::read(&campaign.model).expect("a model"));
    let weld = campaign.logs.iter().find(|log| log.name == "weld-2").expect("a weld");
    let log = cut(weld, 318);
    let noise = instruments(std::slice::from_ref(&log));
    let experiment = PreparedLog::new(&log, &noise[0], &model).expect("compared");
    let prediction = experiment.predict(&model, &[], None).expect("predicted");
    let across = experiment.compared.iter().zip(prediction.residual);
    let across = across.filter(|(c, _)| c.quantity == ComparedQuantity::Force && c.component == 0);
    let score = score(across.map(|(_, r)| r));
    assert!(score < 1.25, "{score}");
}

/// The first explanation of some logs: its effect with its place, the first value with its interval,
/// the score held out.
fn answer(logs: &[Log], file: &ModelFile) -> (String, f64, [f64; 2], f64) {
    let model = baseline(file);
    let problem = FitProblem::new(file, experiments(logs, &model).expect("experiments"));
    let found = diagnose(&problem, logs, &|_, _| ()).expect("a diagnosis").diagnosis;
    let best = &found.candidates[0];
    let names: Vec<String> = best.effects.iter().map(|f| f.effect.name(&file.robot)).collect();
    let first = &best.effects[0];
    println!(
        "{:?}: {best:?}",
        found.verdict,
        best = (&names, &first.effect.values, best.held_out_after)
    );
    (names.join(" and "), first.effect.values[0], first.interval[0], best.held_out_after)
}

/// Cut logs are explained by what explains the whole ones.
fn cut_logs_are_explained_alike(folder: &Path, names: &[&str], seed: u64) {
    let campaign = Campaign::read(folder).expect("a campaign");
    let file = ModelFile::read(&campaign.model).expect("a model");
    let whole: Vec<Log> =
        campaign.logs.into_iter().filter(|log| names.contains(&log.name.as_str())).collect();
    let mut random = Random::new(seed, 4);
    let mut from = |log: &Log| (random.between(0.1, 0.4) * log.samples.len() as f64) as usize;
    let parts: Vec<Log> = whole.iter().map(|log| cut(log, from(log))).collect();
    let (a, b) = (answer(&whole, &file), answer(&parts, &file));
    assert_eq!(a.0, b.0);
    // Both intervals hold the same value.
    assert!(a.2[0] < b.2[1] && b.2[0] < a.2[1], "{a:?} {b:?}");
    assert!((b.3 / a.3 - 1.0).abs() < 0.05, "{a:?} {b:?}");
}

#[test]
#[ignore = "release checklist"]
fn cut_logs_with_play_are_explained_as_whole_ones() {
    let logs = ["static", "ring-25", "free"];
    cut_logs_are_explained_alike(&fixture("campaigns/backlash"), &logs, 15);
}

#[test]
#[ignore = "fails: a loop three times as stiff as its spring is named with a gap beside it, and as nonlinear-stiffness once the logs are cut; a minute"]
fn cut_logs_with_hysteresis_are_explained_as_whole_ones() {
    let hidden = effect("hysteresis", Location::Joint(2), &[2000.0, 1e-4]);
    let folder = campaign(Recipe::plain(16).with_effect(hidden));
    let logs = ["static", "ring-135", "free", "weld-1"];
    cut_logs_are_explained_alike(folder.path(), &logs, 16);
}
