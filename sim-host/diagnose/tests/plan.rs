//! Plans: rivals that the logs leave open are told apart by what is planned, and equals are not.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::path::PathBuf;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_diagnose::experiment::{Plan, next_experiment};
use trueweld_estimate::fit::calibration::calibrations;
use trueweld_estimate::fit::{self, EffectScope, FitProblem, SolverOptions};
use trueweld_estimate::predict::{BaselineModel, ComparedQuantity, PreparedLog};
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::noise::{NoiseLevels, instruments};
use trueweld_plant::effects::Effect;

/// A recorded campaign.
struct Laboratory {
    logs: Vec<Log>,
    noise: Vec<NoiseLevels>,
    problem: FitProblem,
}

impl Laboratory {
    fn new(name: &str) -> Self {
        let folder =
            PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/campaigns").join(name);
        let logs = Campaign::read(folder).unwrap().logs;
        let process = logs.iter().find_map(|l| l.process.clone());
        let model = BaselineModel {
            robot: logs[0].robot.robot.clone(),
            process,
            accuracy: Default::default(),
            torque_constants: [None; 6],
            rigid: [false; 6],
            unknown_rotor: [false; 6],
        };
        let noise = instruments(&logs);
        let experiments = logs
            .iter()
            .zip(&noise)
            .map(|(log, noise)| PreparedLog::new(log, noise, &model).unwrap())
            .collect();
        Self {
            logs,
            noise,
            problem: FitProblem {
                model,
                known: Vec::new(),
                declared: Vec::new(),
                per_log: Vec::new(),
                own: Vec::new(),
                logs: experiments,
                deadline: None,
            },
        }
    }

    fn effect(&self, text: &str) -> Effect {
        Effect::parse(text, &self.logs[0].robot).unwrap()
    }

    fn plan(&self, rivals: &[&str]) -> Option<Plan> {
        let rivals: Vec<_> =
            rivals.iter().map(|r| ((*r).to_owned(), vec![self.effect(r)])).collect();
        next_experiment(&self.problem, &self.logs, &rivals)
    }
}

fn print(plan: &Plan) {
    println!("{:?} ({} min): {:.1}", plan.procedure, plan.minutes, plan.separation);
}

/// What friction and a late channel do to torque goes with speed in different ways: a motion at two
/// speeds tells.
#[test]
fn friction_and_a_delay_are_told_apart_by_motion() {
    let laboratory = Laboratory::new("backlash");
    let rivals = [
        "joint-friction:A3:coulomb_nm=150,viscous_nms_rad=100",
        "channel-delay:torque:delay_s=0.01",
    ];
    let plan = laboratory.plan(&rivals).unwrap();
    print(&plan);
    assert_eq!(plan.log.kind, LogKind::FreeMotion);
    assert!(plan.separation > 5.0, "{}", plan.separation);
    assert!(rivals.iter().all(|r| plan.rivals.iter().any(|name| name == r)));
}

#[test]
fn a_gap_and_a_loop_are_told_apart() {
    let laboratory = Laboratory::new("backlash");
    let plan = laboratory
        .plan(&["backlash:A5:half_gap_rad=2.4e-4", "hysteresis:A5:torque_nm=150,twist_rad=2e-4"])
        .unwrap();
    print(&plan);
    assert!(plan.separation > 5.0, "{}", plan.separation);
    // What is planned stays within the joints' limits.
    let robot = &laboratory.problem.model.robot;
    assert!(plan.log.samples.encoder.iter().all(|q| robot.beyond_limits(q).is_none()));
}

#[test]
fn equals_need_no_experiment() {
    let laboratory = Laboratory::new("backlash");
    let same = "backlash:A5:half_gap_rad=2.4e-4";
    assert!(laboratory.plan(&[same, same]).is_none());
    assert!(laboratory.plan(&[]).is_none());
}

/// A robot that carries no tracker and no force sensor is not asked for either.
#[test]
fn only_what_the_laboratory_has_is_asked_for() {
    let laboratory = Laboratory::new("kr300-measured");
    let plan = laboratory
        .plan(&["hysteresis:A2:torque_nm=150,twist_rad=2e-4", "backlash:A2:half_gap_rad=5e-5"])
        .unwrap();
    print(&plan);
    assert!(matches!(plan.log.kind, LogKind::FreeMotion | LogKind::RingDown));
    assert!(plan.log.samples.position.is_none() && plan.log.samples.link_encoder[1].is_some());
    assert!(!plan.channels.position && !plan.channels.rotation);
}

/// A plate that gives way and a softer material push the tool alike, whatever is done.
#[test]
fn what_cannot_be_told_apart_is_said_to_be() {
    let laboratory = Laboratory::new("backlash");
    let rivals =
        ["fixture-compliance::stiffness_n_m=6e8", "process-stiffness-error::relative=-0.05"];
    if let Some(plan) = laboratory.plan(&rivals) {
        print(&plan);
        assert!(plan.separation < 3.0, "{}", plan.separation);
    }
}

/// The planned experiment, made in a cell where the first rival is the truth, is explained worse by
/// the second by as much as was expected.
#[test]
fn the_planned_experiment_tells() {
    let laboratory = Laboratory::new("backlash");
    let rivals = ["force-crosstalk::fx_per_fz=0.0,fy_per_fz=0.02", "advancing-side::ratio=0.02"];
    let plan = laboratory.plan(&rivals).unwrap();
    print(&plan);
    assert_eq!(plan.log.kind, LogKind::StaticLoad);
    let index = laboratory.logs.iter().position(|l| l.kind == LogKind::StaticLoad).unwrap();
    let model = &laboratory.problem.model;
    let made = |log: &Log| PreparedLog::new(log, &laboratory.noise[index], model).unwrap();
    let truth = [laboratory.effect(rivals[0])];

    // Measured: what the truth predicts, with noise.
    let mut log = plan.log.clone();
    let experiment = made(&log);
    let residual = experiment.predict(model, &truth, None).unwrap().residual;
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut turned = vec![Vector3::zeros(); log.samples.len()];
    for (c, r) in experiment.compared.iter().zip(&residual) {
        let noise: f64 = StandardNormal.sample(&mut random);
        let by = (noise - r) * c.deviation;
        match c.quantity {
            ComparedQuantity::Position => {
                log.samples.position.as_mut().unwrap()[c.row][usize::from(c.component)] += by
            }
            _ => turned[c.row][usize::from(c.component)] = by,
        }
    }
    for (r, by) in log.samples.rotation.as_mut().unwrap().iter_mut().zip(&turned) {
        *r = rotation_vector(&(rotation_from_vector(r) * rotation_from_vector(by)));
    }

    let problem = FitProblem {
        model: model.clone(),
        known: Vec::new(),
        per_log: Vec::new(),
        own: Vec::new(),
        declared: Vec::new(),
        logs: vec![made(&log)],
        deadline: None,
    };
    // The logs so far know something of the calibrations: all, or nothing, bounds what is found.
    let found = |calibrated: bool| {
        let [right, wrong] = rivals.map(|rival| {
            let mut point = calibrations(&problem);
            point.free.retain(|f| calibrated || matches!(f.of, EffectScope::Log(..)));
            point.shared.push(laboratory.effect(rival));
            fit::fit(&problem, &point, &fit::blocks_of(&problem), &[], SolverOptions::steps(4, 0))
                .unwrap()
                .cost
        });
        (wrong - right).max(0.0).sqrt()
    };
    let (least, most) = (found(true), found(false));
    println!("expected {:.1}, found {least:.1} to {most:.1}", plan.separation);
    // Noise makes a difference of two and a half standard deviations once in a hundred times.
    assert!(least > 3.0 && least < plan.separation + 2.5 && most > plan.separation - 2.5);
}
