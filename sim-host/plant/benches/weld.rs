//! How fast the cell is simulated: one second of plant and control with both integrators, a whole
//! weld, and an effect stated as an expression.
//!
//! The work of a control period is in here too; `rigid_body` in the core has it by itself.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trueweld_compensators::{Elastostatic, Entry};
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::expression::Expression;
use trueweld_plant::input::{Control, InputFile, Process, RobotFile, Sensors, Weld};
use trueweld_plant::integrate::{Integrator, Tolerance};
use trueweld_plant::simulate::{ControllerKind, Scenario, Seam, WeldProgram, run};

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
    let cell = Cell::new(&robot.robot, &[], &process, Seam::of(&whole)).unwrap();
    let go = |weld: &Weld, integrator, plant_step| {
        let scenario = Scenario {
            name: "vertical",
            cell: &cell,
            controller_model: &robot.robot,
            planned: &process,
            weld,
            program: WeldProgram::Weld,
            control: &control,
            sensors: &sensors,
            controller: ControllerKind::EXTERNAL,
            law: &Entry::of::<Elastostatic<f64>>(),
            integrator,
            plant_step,
            seed: 1,
            fault: None,
        };
        run(&scenario, |_| {}).unwrap()
    };
    let simulated = go(&second, Integrator::LinearlyImplicit, 1e-3).simulated;
    let mut group = criterion.benchmark_group("cell");
    group.sample_size(20);
    group.bench_function(format!("{simulated:.2} s of weld, default integrator at 1 ms"), |b| {
        b.iter(|| black_box(go(&second, Integrator::LinearlyImplicit, 1e-3)));
    });
    group.sample_size(10);
    group.bench_function(format!("{simulated:.2} s of weld, Dormand-Prince reference"), |b| {
        b.iter(|| black_box(go(&second, Integrator::DormandPrince(Tolerance::REFERENCE), 1e-3)));
    });
    for (step, name) in [(1e-3, "1 ms"), (2e-3, "2 ms, as certification has it")] {
        group.bench_function(format!("whole weld of 2000 mm, 207 s, at {name}"), |b| {
            b.iter(|| black_box(go(&whole, Integrator::LinearlyImplicit, step)));
        });
    }
    group.finish();

    let text = "-(c * tanh(link_rate / 0.001) + s * link)";
    let expression = Expression::parse(text, &["link", "link_rate"], &["c", "s"]).unwrap();
    let (friction, stiffness) = (150.0_f64, 4000.0_f64);
    let at = [0.3, 5e-3];
    let mut group = criterion.benchmark_group("effect of the user's own");
    group.bench_function("expression", |b| {
        b.iter(|| expression.eval(black_box(&at), black_box(&[friction, stiffness])));
    });
    group.bench_function("the same in Rust", |b| {
        b.iter(|| {
            let [link, rate] = *black_box(&at);
            -(friction * (rate / 0.001).tanh() + stiffness * link)
        });
    });
    group.finish();
}

criterion_group!(weld, benches);
criterion_main!(weld);
