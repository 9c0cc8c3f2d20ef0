//! How fast measurements are made ready, predicted and diagnosed, and a model improved: the campaign
//! with a backlash, seven logs.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trueweld_diagnose::diagnose;
use trueweld_diagnose::improve::improve;
use trueweld_estimate::fit::FitProblem;
use trueweld_estimate::residuals::compare::{baseline, experiments};
use trueweld_logs::campaign::read_logs;
use trueweld_plant::input::ModelFile;

fn benches(criterion: &mut Criterion) {
    let folder = format!("{}/../../fixtures/campaigns/backlash", env!("CARGO_MANIFEST_DIR"));
    let (model, logs) = read_logs(&[folder.into()]).unwrap();
    let file = ModelFile::read(model.unwrap()).unwrap();
    let model = baseline(&file);
    let problem = FitProblem::new(&file, experiments(&logs, &model).unwrap());

    let mut group = criterion.benchmark_group("log");
    for (log, experiment) in logs.iter().zip(&problem.logs) {
        if ["static", "ring-14", "free", "weld-1"].contains(&log.name.as_str()) {
            group.bench_function(format!("predict {}, {}", log.kind, log.name), |b| {
                b.iter(|| black_box(experiment.predict(&model, &[], None).unwrap()));
            });
        }
    }
    group.finish();

    let mut group = criterion.benchmark_group("campaign");
    group.sample_size(10);
    group.bench_function("make ready", |b| {
        b.iter(|| black_box(experiments(&logs, &model).unwrap()))
    });
    // Calibrations, screening of every effect at every place, full fits of the best, and the
    // verdict; all cores.
    group.bench_function("diagnose", |b| {
        b.iter(|| black_box(diagnose(&problem, &logs, &|_, _| {}).unwrap()))
    });
    group.bench_function("improve", |b| {
        b.iter(|| black_box(improve(&problem, &logs, None, &|_, _| {}).unwrap()))
    });
    group.finish();
}

criterion_group!(all, benches);
criterion_main!(all);
