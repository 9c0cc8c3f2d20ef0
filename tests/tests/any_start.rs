//! A log may begin anywhere: cut at a random time it scores as the whole one does there.

use trueweld_laboratory::{Protocol, Recipe};
use trueweld_measure::data::campaign::Campaign;
use trueweld_measure::data::log::{Log, LogKind};
use trueweld_measure::data::noise::instruments;
use trueweld_measure::predict::{Experiment, Model};
use trueweld_measure::residuals::compare::baseline;
use trueweld_plant::input::ModelFile;
use trueweld_plant::random::Random;
use trueweld_tests::LABORATORY;

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
fn residuals(log: &Log, model: &Model) -> Vec<(usize, f64)> {
    let noise = instruments(std::slice::from_ref(log));
    let experiment = Experiment::new(log, &noise[0], model).expect("compared");
    let prediction = experiment.predict(model, &[], None).expect("predicted");
    experiment.compared.iter().map(|c| c.row).zip(prediction.residual).collect()
}

fn score(residuals: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = residuals.collect();
    (all.iter().map(|r| r * r).sum::<f64>() / all.len() as f64).sqrt()
}

#[test]
fn a_log_cut_at_a_random_time_scores_as_the_whole_one() {
    let protocol = Protocol { postures: 8, rings: 2, ring: 1.2, free: 6.0, welds: 1, seam: 0.12 };
    let folder = tempfile::tempdir().expect("a folder");
    LABORATORY.write(&Recipe { protocol, ..Recipe::plain(11) }, folder.path()).expect("a campaign");
    let campaign = Campaign::read(folder.path()).expect("a campaign");
    let model = baseline(&ModelFile::read(&campaign.model).expect("a model"));
    let mut random = Random::new(11, 3);
    for log in &campaign.logs {
        let whole = residuals(log, &model);
        for _ in 0..4 {
            let from = (random.between(0.1, 0.6) * log.samples.len() as f64) as usize;
            let own = residuals(&cut(log, from), &model);
            let (first, last) = (own[0].0 + from, own.iter().map(|r| r.0).max().unwrap() + from);
            let there = whole.iter().filter(|(row, _)| (first..=last).contains(row));
            let (alone, whole) = (score(own.iter().map(|r| r.1)), score(there.map(|r| r.1)));
            println!("{} from row {from}: {alone:.3}, as a part of the whole {whole:.3}", log.name);
            // A weld's rows are few, and those compared are others.
            let near = if log.kind == LogKind::Weld { 0.1 } else { 0.05 };
            assert!((alone / whole - 1.0).abs() < near, "{}: {alone} against {whole}", log.name);
        }
    }
}
