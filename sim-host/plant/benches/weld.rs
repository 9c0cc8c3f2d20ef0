//! How fast the cell is simulated: one second of plant and control with both integrators, and a whole weld.
//!
//! The work of a control period is in here too; `rigid_body` in the core has it by itself.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trueweld_plant::cell::Cell;
use trueweld_plant::input::{Control, Process, RobotFile, Sensors, Weld};
use trueweld_plant::integrate::{Integrator, Tolerance};
use trueweld_plant::simulate::{Controller, Law, Program, Scenario, Seam, run};

fn fixture(path: &str) -> String {
    format!("{}/../../fixtures/{path}", env!("CARGO_MANIFEST_DIR"))
}

fn benches(criterion: &mut Criterion) {
    let robot = RobotFile::read(fixture("robots/kr500-mt.toml")).unwrap();
    let process = Process::read(fixture("processes/lap-weld-2024-t3.toml")).unwrap();
    let control = Control::read(fixture("control/kr500-mt.toml")).unwrap();
    let sensors = Sensors::read(fixture("sensors/kr500-mt.toml")).unwrap();
    let whole = Weld::read(fixture("welds/vertical.toml")).unwrap();
    // One second of feed at full force: a short seam, entered without waiting.
    let along = (whole.end - whole.start).normalize();
    let second = Weld {
        end: whole.start + along * 0.005,
        settle: 0.0,
        force_ramp: 0.0,
        feed_ramp: 0.0,
        feed: 0.01,
        ..whole.clone()
    };
    let cell = Cell::new(&robot.robot, &[], &process, Seam::of(&whole).b_from_w).unwrap();
    let go = |weld: &Weld, integrator| {
        let scenario = Scenario {
            name: "vertical",
            cell: &cell,
            belief: &robot.robot,
            weld,
            program: Program::Weld,
            control: &control,
            sensors: &sensors,
            controller: Controller::External,
            law: Law::Elastostatic,
            integrator,
            plant_step: 1e-3,
            seed: 1,
        };
        run(&scenario, |_| {}).unwrap()
    };
    let simulated = go(&second, Integrator::LinearlyImplicit).simulated;
    let mut group = criterion.benchmark_group("cell");
    group.sample_size(20);
    group.bench_function(format!("{simulated:.2} s of weld, default integrator at 1 ms"), |b| {
        b.iter(|| black_box(go(&second, Integrator::LinearlyImplicit)));
    });
    group.sample_size(10);
    group.bench_function(format!("{simulated:.2} s of weld, Dormand-Prince reference"), |b| {
        b.iter(|| black_box(go(&second, Integrator::DormandPrince(Tolerance::REFERENCE))));
    });
    group.bench_function("whole weld of 2000 mm, 207 s", |b| {
        b.iter(|| black_box(go(&whole, Integrator::LinearlyImplicit)));
    });
    group.finish();
}

criterion_group!(weld, benches);
criterion_main!(weld);
