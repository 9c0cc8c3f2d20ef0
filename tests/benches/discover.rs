//! What discovery adds to the diagnosis of a campaign of some 40 000 values, on all cores.
//!
//! A strap that tightens about a wrist joint is in no library, so that every port and variable is
//! looked at, the best curves are fitted through the plant, and a formula is looked for.

use core::hint::black_box;
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use trueweld_diagnose::discover::discover;
use trueweld_diagnose::{Diagnosed, DiagnosisVerdict, diagnose};
use trueweld_laboratory::{Protocol, Recipe};
use trueweld_tests::corpus::{Ready, ready};
use trueweld_tests::outside::FreeFormEffect;

fn campaign() -> (Ready, Diagnosed) {
    let law = FreeFormEffect::named("strap").expect("a law").effect(1.0);
    let protocol = Protocol { postures: 14, rings: 6, ring: 1.0, free: 30.0, welds: 3, seam: 0.3 };
    let recipe = Recipe { protocol, ..Recipe::plain(5).with_effect(law) };
    let ready = ready(&recipe).expect("the campaign is made");
    let found = diagnose(&ready.problem, &ready.logs, &|_, _| ()).expect("diagnosed");
    let values: usize = ready.problem.logs.iter().map(|e| e.compared.len()).sum();
    println!("{values} values; {:?} by the library", found.diagnosis.verdict);
    assert_ne!(found.diagnosis.verdict, DiagnosisVerdict::Adequate, "there is nothing to discover");
    (ready, found)
}

fn benches(criterion: &mut Criterion) {
    let (ready, found) = campaign();
    let look =
        |found: Diagnosed| black_box(discover(&ready.problem, &ready.logs, found, &|_, _| ()).1);
    assert_eq!(look(found.clone()).len(), 1, "the strap is found");
    let mut group = criterion.benchmark_group("campaign");
    group.sample_size(10);
    group.bench_function("diagnose", |b| {
        b.iter(|| black_box(diagnose(&ready.problem, &ready.logs, &|_, _| ()).expect("diagnosed")))
    });
    group.bench_function("discover", |b| {
        b.iter_batched(|| found.clone(), look, BatchSize::PerIteration)
    });
    group.finish();
}

criterion_group!(all, benches);
criterion_main!(all);
