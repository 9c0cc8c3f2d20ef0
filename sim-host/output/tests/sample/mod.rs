//! Made-up results for the tests of this crate. Recordings: a robot of the KR 500's geometry whose drives
//! twist under a constant load, so that poses, twists and deviations agree with each other. Not a
//! simulation.

// Each test uses its part of it.
#![allow(dead_code, unreachable_pub)]

use nalgebra::{Matrix3, Vector3};
use std::sync::LazyLock;
use trueweld_compensators::Entry;
use trueweld_core::control::Limited;
use trueweld_core::monitor::HealthSignals;
use trueweld_core::{
    Counterbalance, Friction, JointParameters, JointVector, Pose, Robot, RobotParameters,
    ToolParameters, Twist, Wrench,
};
use trueweld_diagnose::evidence::{Abscissa, EffectCurve, Ordinate};
use trueweld_diagnose::experiment::{Channels, Excitation, Plan, PlanRow, Procedure};
use trueweld_diagnose::improve::{Improvement, ImprovementStep, Rejected, Rejection};
use trueweld_diagnose::{
    Candidate, Confusable, Diagnosis, DiagnosisErrors, DiagnosisVerdict, EffectLimit, Explanation,
    ExplanationReason, FittedEffect, ImprovedChannel,
};
use trueweld_estimate::predict::ComparedQuantity;
use trueweld_estimate::residuals::compare::{
    ChannelComparison, Comparison, LogComparison, Notice, Trace,
};
use trueweld_estimate::residuals::error::ChannelError;
use trueweld_estimate::residuals::localize::{
    Category, ConditionBin, ConditionCurve, Finding, MapAxis, ResidualMap, RowCondition, Statistic,
};
use trueweld_evaluate::certify::{
    Certificate, CertifiedWeld, Evidence, FAULT_FIGURES, FaultTrial, Influence, LimitedFigure,
    Oscillation, SampledCell, Sensitivity, ShownKind, ShownRun, Symptoms, Trend, Trial, WeldPlan,
    WorstCase, accepted_faults, judge, weak_points,
};
use trueweld_evaluate::laws::{
    LawComparison, NoFigures, ScenarioChange, ScenarioSweep, VariedQuantity,
};
use trueweld_evaluate::margins::{
    Condition, FrictionSlope, LOOP_CHANNELS, Margin, Margins, OperatingPoint, Passivity,
};
use trueweld_evaluate::{Requirements, StepFigures, UncertainCell, WELD_FIGURES, WeldFigures};
use trueweld_logs::log::{Log, LogKind, LogNotice};
use trueweld_output::{CertifyReport, DiagnoseReport, StepRun, WeldRun};
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::{Effect, EffectKind, EffectPlace, Location};
use trueweld_plant::input::{
    Control, InputFile, MeasuredNumber, ModelFile, Posterior, Process, RobotFile, Sensors, Weld,
};
use trueweld_plant::integrate::Integrator;
use trueweld_plant::provenance::{FileDigest, Provenance};
use trueweld_plant::simulate::{
    ControllerKind, Phase, RecordRow, Recording, RunError, Scenario, Seam, WeldProgram,
};

/// When the push steps, s, and by how much, N.
pub const STEP_AT: f64 = 1.0;
/// Height of the step, N.
pub const STEP_HEIGHT: f64 = 11_000.0;

/// Welds with the parts that a [`WeldRun`] borrows.
pub struct Welds {
    pub robot: Robot<f64>,
    pub recordings: Vec<Recording>,
    pub figures: Vec<WeldFigures>,
}

impl Welds {
    pub fn runs(&self) -> Vec<WeldRun<'_>> {
        let both = self.recordings.iter().zip(&self.figures);
        both.map(|(recording, figures)| WeldRun::new(recording, figures, &self.robot)).collect()
    }
}

/// Steps with the parts that a [`StepRun`] borrows.
pub struct Steps {
    pub recordings: Vec<Recording>,
    pub figures: Vec<StepFigures>,
}

impl Steps {
    pub fn runs(&self) -> Vec<StepRun<'_>> {
        let both = self.recordings.iter().zip(&self.figures);
        both.map(|(recording, figures)| StepRun { recording, figures }).collect()
    }
}

/// Geometry of a KR 500 with a tool 0.4 m long.
pub fn robot() -> Robot<f64> {
    let origins = [
        [0.0, 0.0, 0.0],
        [0.5, 0.0, 1.045],
        [1.3, 0.0, 0.0],
        [0.0, 0.0, -0.055],
        [1.025, 0.0, 0.0],
        [0.0, 0.0, 0.0],
    ];
    let axes =
        [-Vector3::z(), Vector3::y(), Vector3::y(), -Vector3::x(), Vector3::y(), -Vector3::x()];
    let limits = [[-3.2, 3.2], [-2.27, 0.35], [-1.75, 2.52], [-6.1, 6.1], [-2.1, 2.1], [-6.1, 6.1]];
    let stiffness = [13.0e6, 15.0e6, 6.2e6, 0.5e6, 0.6e6, 0.4e6];
    let joint = |i: usize| JointParameters {
        origin: Vector3::from(origins[i]),
        axis: axes[i],
        limits: limits[i],
        max_rate: 1.0,
        max_torque: 30_000.0,
        stiffness: stiffness[i],
        damping: 1000.0,
        rotor_inertia: 100.0,
        mass: 100.0,
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::identity(),
    };
    Robot::new(RobotParameters {
        gravity: Vector3::zeros(),
        joints: std::array::from_fn(joint),
        friction: Friction {
            viscous: JointVector::zeros(),
            coulomb: JointVector::zeros(),
            smoothing: 1e-3,
        },
        counterbalance: Counterbalance::default(),
        tool: ToolParameters {
            flange_offset: Vector3::new(0.29, 0.0, 0.0),
            mass: 0.0,
            com_from_flange: Vector3::zeros(),
            inertia: Matrix3::zeros(),
            tcp_from_flange: Vector3::new(0.4, 0.0, 0.0),
            z_axis: Vector3::x(),
            y_axis: Vector3::y(),
        },
    })
    .unwrap()
}

/// Two welds of 2 m along +Y, `rows` rows each: without compensation, and with the drives turned
/// back by their twist.
pub fn welds(rows: usize) -> Welds {
    let robot = robot();
    let recordings = vec![weld(&robot, "none", rows), weld(&robot, "elastostatic", rows)];
    let figures = recordings.iter().map(|r| WeldFigures::of(r).unwrap()).collect();
    Welds { robot, recordings, figures }
}

/// Largest torque of the drives, N·m, and their largest speed, rad/s.
const DRIVES: [f64; 2] = [1e5, 1.0];

fn weld(robot: &Robot<f64>, compensator: &'static str, count: usize) -> Recording {
    let total = 207.0;
    let period = total / count as f64;
    let w_axes = Matrix3::from_columns(&[Vector3::y(), Vector3::x(), -Vector3::z()]);
    let mut near = JointVector::from_column_slice(&[0.53, -0.84, 1.73, 0.0, 0.69, 0.53]);
    let rows = (0..count)
        .map(|k| {
            let time = k as f64 * period;
            let (phase, travel) = match time {
                t if t < 2.0 => (Phase::Settle, 0.0),
                t if t < 5.0 => (Phase::ForceRamp, 0.0),
                t if t < 6.0 => (Phase::FeedRamp, 0.005 * (t - 5.0) * (t - 5.0)),
                t if t < 205.0 => (Phase::Steady, 0.005 + 0.01 * (t - 6.0)),
                t if t < 206.0 => (Phase::Stop, 2.0 - 0.005 * (206.0 - t) * (206.0 - t)),
                _ => (Phase::Hold, 2.0),
            };
            let limited = Limited { torque: (3.0..3.2).contains(&time), ..Limited::default() };
            let load = ((time - 2.0) / 3.0).clamp(0.0, 1.0);
            let feed = if phase >= Phase::FeedRamp { (time - 5.0).clamp(0.0, 1.0) } else { 0.0 };
            let turn = 20.0 * std::f64::consts::PI * time;
            let push = 18_000.0 * load * (1.0 + 0.01 * turn.sin());
            let force_w =
                Vector3::new(-4000.0 * feed, 1000.0 * feed * (1.0 + 0.1 * turn.sin()), -push);
            let nominal = Pose {
                rotation: Matrix3::from_columns(&[Vector3::x(), -Vector3::y(), -Vector3::z()]),
                position: Vector3::new(1.7, -1.0 + travel, 0.5),
            };
            near = robot.inverse_near(&nominal, &near).unwrap();
            let frames = robot.frames(&near);
            let wrench = Wrench { moment: Vector3::zeros(), force: w_axes * force_w };
            let twist = -frames.joint_torque(&wrench).component_div(robot.stiffness());
            let correction = if compensator == "none" { 0.0 } else { 0.98 };
            // The force loop keeps the real depth whatever the law does.
            let sunk = frames.twist(&-twist).linear.z;
            let up = frames.jacobian().0.try_inverse().unwrap()
                * nalgebra::Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 1.0);
            let motor =
                near + twist * correction - up * (sunk * (1.0 - correction) + 3.0e-4 * load);
            let link = motor - twist;
            let (real, encoder_pose) =
                (robot.forward_kinematics(&link), robot.forward_kinematics(&motor));
            let error = nominal.error_to(&real).rotated(&w_axes.transpose());
            let jacobian = frames.jacobian().0;
            let lateral = jacobian.row(3).transpose();
            RecordRow {
                time,
                phase,
                path: travel,
                axes: w_axes,
                nominal,
                real,
                encoder_pose,
                deviation_w: error,
                tilt: error.angular.xy().norm(),
                lateral_by_joint: -lateral.component_mul(&twist),
                force_w,
                force_sensed_w: force_w * (1.0 + 0.002 * (3.0 * turn).cos()),
                force_desired: (phase >= Phase::ForceRamp).then_some(18_000.0 * load),
                link,
                motor,
                torque: match limited.torque {
                    // It is A2.
                    true => JointVector::from_fn(|i, _| if i == 1 { DRIVES[0] } else { 0.0 }),
                    false => twist.component_mul(robot.stiffness()),
                },
                spindle_angle: turn,
                force_error: 18_000.0 * load - push,
                depth_correction: -sunk * (1.0 - correction) + 3.0e-4 * load,
                push: 0.0,
                correction_w: Twist {
                    linear: w_axes.transpose() * frames.twist(&(twist * correction)).linear,
                    angular: frames.twist(&(twist * correction)).angular,
                },
                limited,
                health: HealthSignals::default(),
                fault: None,
            }
        })
        .collect();
    Recording {
        weld: "vertical".to_owned(),
        controller: "external",
        compensator: compensator.to_owned(),
        rows,
        period,
        half_pin: 0.0025,
        tolerance_name: "half the pin",
        force: 18_000.0,
        planned_force: Vector3::zeros(),
        planned_depth: 3e-4,
        max_torque: JointVector::repeat(DRIVES[0]),
        max_rate: JointVector::repeat(DRIVES[1]),
        seed: 7,
        simulated: total,
        wall: 2.5,
    }
}

/// Three responses of second order to a step of the push, with a ripple of the spindle.
pub fn steps() -> Steps {
    let robot = robot();
    let still = weld(&robot, "none", 2).rows[0];
    let recordings: Vec<Recording> =
        [("parallel", 0.414, 20.2), ("superposed", 0.456, 9.1), ("external", 0.703, 3.4)]
            .into_iter()
            .map(|(controller, damping, omega): (&str, f64, f64)| {
                let rows = (0..4000)
                    .map(|k| {
                        let time = 0.001 * k as f64;
                        let t = time - STEP_AT;
                        let damped = omega * (1.0 - damping * damping).sqrt();
                        let rest =
                            (damped * t).cos() + damping * omega / damped * (damped * t).sin();
                        let share =
                            if t < 0.0 { 0.0 } else { 1.0 - (-damping * omega * t).exp() * rest };
                        let push = 7000.0 + STEP_HEIGHT * share + 40.0 * (62.8 * time).sin();
                        let mut row = still;
                        row.time = time;
                        row.phase = Phase::ForceRamp;
                        row.force_w = Vector3::new(0.0, 0.0, -push);
                        row.force_desired =
                            Some(if t < 0.0 { 7000.0 } else { 7000.0 + STEP_HEIGHT });
                        row
                    })
                    .collect();
                let weld = "vertical".to_owned();
                let (period, half_pin, force, seed, simulated, wall) =
                    (0.001, 0.0025, 18_000.0, 7, 4.0, 0.1);
                Recording {
                    weld,
                    controller,
                    compensator: "none".to_owned(),
                    rows,
                    period,
                    half_pin,
                    tolerance_name: "half the pin",
                    force,
                    planned_force: Vector3::zeros(),
                    planned_depth: 3e-4,
                    max_torque: JointVector::repeat(DRIVES[0]),
                    max_rate: JointVector::repeat(DRIVES[1]),
                    seed,
                    simulated,
                    wall,
                }
            })
            .collect();
    let figures =
        recordings.iter().map(|r| StepFigures::of(r, STEP_AT, STEP_HEIGHT).unwrap()).collect();
    Steps { recordings, figures }
}

/// A comparison with one log of 500 rows, whose x is off by 0.2 mm while a torque is positive.
pub fn comparison() -> Comparison {
    let rows = 500;
    let time: Vec<f64> = (0..rows).map(|k| 0.004 * k as f64).collect();
    let off = |k: usize, column: u8| {
        if column == 0 && (k / 50) % 2 == 1 { 2e-4 } else { 0.0 }
    };
    let trace = |column: u8| {
        let measured: Vec<f64> =
            (0..rows).map(|k| 1.0 + (0.01 * k as f64).sin() + off(k, column)).collect();
        let predicted = measured.iter().enumerate().map(|(k, m)| m - off(k, column)).collect();
        let label = ["x", "y", "z"][usize::from(column)].to_owned();
        let deviation = vec![3e-5; rows];
        Trace {
            channel: "tcp_position",
            column,
            label,
            unit: "m",
            time: time.clone(),
            measured,
            predicted,
            deviation,
        }
    };
    let figures = |name: &str, label: &str, score: f64, samples: usize| ChannelComparison {
        name: name.to_owned(),
        label: label.to_owned(),
        unit: "m",
        rmse: 3e-5 * score,
        max: 2e-4,
        noise: 3e-5,
        accuracy: 0.0,
        stated: true,
        score,
        samples,
        columns: Vec::new(),
    };
    let columns = ["x", "y", "z"].iter().enumerate().map(|(c, label)| {
        let score = if c == 0 { 4.71 } else { 0.0 };
        figures(&format!("tcp_position[{c}]"), label, score, rows)
    });
    let channel = ChannelComparison {
        columns: columns.collect(),
        ..figures("tcp_position", "", 2.72, 3 * rows)
    };
    let point = |x: f64, y: f64| ConditionBin { x, y, error: 1e-5 };
    let finding = Finding {
        kind: LogKind::FreeMotion,
        channel: "tcp_position",
        logs: vec!["free".to_owned()],
        score: 2.72,
        joints: ["A1", "A2", "A3", "A4", "A5", "A6"].map(str::to_owned),
        variable: RowCondition::SpringSign(4),
        how: Statistic::Mean,
        share: 0.62,
        by_chance: 0.02,
        p: 0.005,
        low: 1.0,
        high: 1.0,
        category: Some(Category::Positive),
        share_there: 0.9,
        samples_there: 0.5,
        similar: Vec::new(),
        curve: ConditionCurve {
            categories: vec![Category::Negative, Category::Positive],
            series: Some((ComparedQuantity::Position, 0)),
            y_unit: "m",
            points: vec![point(0.0, 0.0), point(1.0, 2e-4)],
        },
        map: Some(ResidualMap {
            x: MapAxis {
                variable: RowCondition::SpringTorque(4),
                categories: Vec::new(),
                values: vec![-100.0, 100.0],
            },
            y: MapAxis {
                variable: RowCondition::Motion(4),
                categories: vec![Category::Negative, Category::Positive],
                values: vec![0.0, 1.0],
            },
            series: (ComparedQuantity::Position, 0),
            mean: vec![vec![1e-4, -1e-4], vec![-1e-4, f64::NAN]],
            share: 0.8,
            by_chance: 0.02,
            p: 0.005,
        }),
    };
    let log = LogComparison {
        path: "campaign/free".into(),
        name: "free".to_owned(),
        kind: LogKind::FreeMotion,
        score: 2.72,
        samples: 3 * rows,
        channels: vec![channel],
        traces: (0..3).map(trace).collect(),
        lines: Vec::new(),
    };
    Comparison {
        score: 2.72,
        samples: 3 * rows,
        logs: vec![log],
        worst: vec![finding],
        notices: vec![Notice::Log {
            log: "free".to_owned(),
            notice: LogNotice::UnknownColumns(vec!["temperature_c".to_owned()]),
        }],
    }
}

/// The parts of a diagnosis that a [`DiagnoseReport`] borrows.
pub struct Parts {
    pub model: ModelFile,
    pub diagnosis: Diagnosis,
    pub explanation: Explanation,
    pub before: Vec<LogComparison>,
    pub after: Vec<LogComparison>,
}

impl Parts {
    pub fn diagnosed(&self) -> DiagnoseReport<'_> {
        let Self { model, diagnosis, explanation, before, after } = self;
        DiagnoseReport {
            model,
            diagnosis,
            explanation,
            discovered: &[],
            before,
            after,
            notices: &[],
            provenance: provenance(),
        }
    }
}

/// A fixture of the repository.
fn fixture(name: &str) -> String {
    format!("{}/../../fixtures/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A diagnosis that found 0.24 mrad of play in A5 before the same of a loop; in the first log,
/// which [`comparison`] gives. One bound is not known.
pub fn diagnosis(verdict: DiagnosisVerdict) -> Parts {
    let found = |id: &str, values: &[f64], half: f64| {
        let kind = EffectKind::of(id).unwrap();
        let interval = values.iter().map(|v| [v - half, v + half]).collect();
        FittedEffect {
            effect: Effect { kind, at: Location::Joint(4), values: values.to_vec() },
            log: None,
            interval,
            turns: None,
        }
    };
    let candidate = |effect: FittedEffect, after: f64, probability: f64, left: f64| Candidate {
        held_out_before: 3.79,
        held_out_after: after,
        probability,
        evidence: 40.0,
        left,
        may_be_named: effect.is_told_from_nothing(),
        effects: vec![effect],
        indistinguishable: Vec::new(),
    };
    let play = found("backlash", &[2.4e-4], 2e-6);
    let comparison = comparison();
    let mut after = comparison.logs.clone();
    after[0].traces.iter_mut().for_each(|t| t.predicted.clone_from(&t.measured));
    let kind = EffectKind::of("backlash").unwrap();
    let limit = |joint: usize| EffectLimit {
        effect: EffectPlace { kind, at: Location::Joint(joint) },
        parameter: 0,
        value: 5.3e-6,
    };
    let curve = EffectCurve {
        x: Abscissa::SpringTorque(4),
        y: Ordinate::Named("twist of {joint} beyond the linear spring's", 4),
        y_unit: "rad",
        points: (-3..4)
            .map(|k: i32| ConditionBin {
                x: f64::from(k),
                y: 2.4e-4 * f64::from(k.signum()),
                error: 1e-5,
            })
            .collect(),
        fitted: (-3..4).map(|k: i32| [f64::from(k), 2.4e-4 * f64::from(k.signum())]).collect(),
    };
    let reason = |evidence: Option<EffectCurve>| ExplanationReason {
        improved: Some(ImprovedChannel {
            kind: LogKind::RingDown,
            channel: "tcp_position",
            before: 3.8,
            after: 1.0,
        }),
        evidence: vec![evidence],
    };
    Parts {
        model: ModelFile {
            accuracy: trueweld_plant::input::Accuracy::default(),
            path: "model.toml".into(),
            ..ModelFile::read(fixture("campaigns/backlash/model.toml")).unwrap()
        },
        diagnosis: Diagnosis {
            verdict,
            score_before: 3.79,
            score_calibrated: 2.9,
            score_after: 1.016,
            held_out_calibrated: 2.9,
            errors: DiagnosisErrors {
                before: errors(1.55e-4),
                calibrated: errors(9.2e-5),
                after: errors(3.08e-5),
            },
            chosen: usize::from(verdict != DiagnosisVerdict::Adequate),
            candidates: vec![
                candidate(play, 1.015, 0.98, 0.01),
                candidate(found("hysteresis", &[310.0, 2e-4], f64::INFINITY), 1.02, 0.01, 0.02),
            ],
            calibration: vec![FittedEffect {
                log: Some(0),
                ..found("encoder-offset", &[1e-5], 1e-6)
            }],
            mountings: None,
            limits: vec![limit(4), limit(0)],
            confusable: vec![Confusable {
                first: EffectPlace { kind, at: Location::Joint(4) },
                second: EffectPlace { kind, at: Location::Joint(3) },
                alike: 0.999,
            }],
            unexplained: comparison.worst,
            incomplete: Vec::new(),
            ports_alike: Vec::new(),
        },
        explanation: Explanation {
            reasons: vec![reason(Some(curve)), reason(None)],
            next_experiment: None,
        },
        before: comparison.logs,
        after,
    }
}

/// A plan for an experiment.
pub fn plan() -> Plan {
    let row = |(k, payload)| PlanRow { time: 20.0 * f64::from(k), payload, ..PlanRow::default() };
    Plan {
        procedure: Procedure::Load { at: JointVector::zeros(), how: Excitation::Hung },
        channels: Channels { position: true, ..Channels::default() },
        rivals: ["backlash at A5".to_owned(), "hysteresis at A5".to_owned()],
        so_far: 0.5,
        others: Vec::new(),
        separation: 12.0,
        minutes: 14.0,
        rows: [(0u8, 0.0), (1, 20.0), (2, 0.0)].map(row).to_vec(),
        log: Log {
            accuracy: trueweld_plant::input::Accuracy::default(),
            kind: LogKind::StaticLoad,
            ..Log::read(fixture("campaigns/backlash/ring-25")).unwrap()
        },
    }
}

/// Errors of a tracker's position whose noise is 0.03 mm.
fn errors(rmse: f64) -> Vec<ChannelError> {
    let (channel, unit) = ("tcp_position", "m");
    let [noise, accuracy] = [3e-5, 0.0];
    vec![ChannelError { channel, ripple: false, unit, rmse, noise, accuracy, samples: 1500 }]
}

/// An improvement by what [`diagnosis`] found, its steps judged by a log held out.
pub fn improvement(diagnosis: Diagnosis) -> Improvement {
    let effects = diagnosis.candidates[0].effects.clone();
    let step = |added: &[FittedEffect], score: f64, held_out: f64| ImprovementStep {
        added: added.to_vec(),
        effects: added.to_vec(),
        calibration: Vec::new(),
        score,
        held_out,
        errors: errors(3.1e-5 * held_out),
    };
    Improvement {
        discovered: Vec::new(),
        steps: vec![step(&[], 3.79, 3.37), step(&effects, 1.015, 1.07)],
        rejected: vec![Rejected { added: Vec::new(), held_out: f64::NAN, why: Rejection::NoGain }],
        verdict: diagnosis.verdict,
        unexplained: diagnosis.unexplained.clone(),
        incomplete: Vec::new(),
        diagnosis,
        held_out_logs: vec!["weld-3".to_owned()],
    }
}

/// What a comparison of laws borrows.
pub struct Laws {
    robot: RobotFile,
    process: Process,
    weld: Weld,
    control: Control,
    sensors: Sensors,
    cell: Cell,
    laws: Vec<Entry>,
    pub sweeps: Vec<ScenarioSweep>,
}

impl Laws {
    pub fn comparison(&self) -> LawComparison<'_> {
        let scenario = Scenario {
            name: "vertical",
            cell: &self.cell,
            controller_model: &self.robot.robot,
            planned: &self.process,
            weld: &self.weld,
            program: WeldProgram::Weld,
            control: &self.control,
            sensors: &self.sensors,
            controller: ControllerKind::EXTERNAL,
            law: &self.laws[0],
            integrator: Integrator::LinearlyImplicit,
            plant_step: 2e-3,
            seed: 7,
            fault: None,
        };
        LawComparison {
            scenario,
            robot: &self.robot.robot,
            stiffness_error: 0.2,
            laws: &self.laws,
            passes: 2,
        }
    }
}

/// Three laws side by side: the first far off, the second within 0.05 mm but for the last noise, the
/// third too, where it comes to an end.
pub fn laws(names: &[&str]) -> Laws {
    let read = |name: &str| fixture(&format!("{name}.toml"));
    let robot = RobotFile::read(read("robots/kr500-mt")).unwrap();
    let process = Process::read(read("processes/lap-weld-2024-t3")).unwrap();
    let weld = Weld::read(read("welds/vertical")).unwrap();
    let cell = Cell::new(&robot.robot, &[], &process, Seam::of(&weld)).unwrap();
    let figures = welds(100).figures.remove(1);
    let point = |law: usize, change: &ScenarioChange| {
        let lateral = match (law, change) {
            (0, _) => 4e-3,
            (1, ScenarioChange::Noise(8.0)) => 6e-5,
            (1, _) => 4e-5,
            (_, ScenarioChange::DeadInLastPass) => return Err(NoFigures::NotSteady),
            (_, ScenarioChange::Delay(4.0 | 8.0)) => return Err(RunError::Cell.into()),
            (law, _) => 3e-5 - 1e-6 * law as f64,
        };
        let mut figures = figures.clone();
        (figures.lateral.rms, figures.lateral.max_abs) = (lateral, 3.0 * lateral);
        Ok(figures)
    };
    let sweep = |quantity: VariedQuantity| {
        let points = |k| quantity.changes().iter().map(|change| point(k, change)).collect();
        ScenarioSweep { quantity, points: (0..names.len()).map(points).collect() }
    };
    Laws {
        process,
        weld,
        control: Control::read(read("control/kr500-mt")).unwrap(),
        sensors: Sensors::read(read("sensors/kr500-mt")).unwrap(),
        cell,
        laws: names.iter().map(|name| trueweld_compensators::find(name).unwrap()).collect(),
        sweeps: VariedQuantity::ALL.map(sweep).to_vec(),
        robot,
    }
}

/// A certification of one weld with three drawn cells, one of them beyond the limits and one in
/// which no weld is made; with a loop that is not stable at its end, and a fault that it does not
/// bear.
pub fn certificate() -> CertifyReport {
    let stated = Requirements::read(fixture("requirements/lap-weld.toml")).unwrap();
    let weld = Weld::read(fixture("welds/vertical.toml")).unwrap();
    let process = Process::read(fixture("processes/lap-weld-2024-t3.toml")).unwrap();
    let control = Control::read(fixture("control/kr500-mt.toml")).unwrap();
    let requirements = stated.of_weld(&weld, &process, &control.compensation).unwrap();
    let figures = welds(100).figures.remove(1);
    let trial = |index: u64, times: f64| {
        let value = |of: &trueweld_evaluate::FigureOf<WeldFigures>| {
            (of.figure.key.to_owned(), times * (of.value)(&figures))
        };
        Trial {
            index,
            draw: SampledCell { stiffness: [0.9 * times; 6], ..SampledCell::nominal(7) },
            figures: Some(
                WELD_FIGURES.iter().filter(|f| f.figure.phase().is_empty()).map(value).collect(),
            ),
            symptoms: Some(Symptoms {
                given: [Some(0.4), None, Some(0.9)],
                lateral: [2e-5, 1e-5, 3e-5],
                swing: Oscillation {
                    amplitude: 1e-5,
                    frequency: 2.0,
                    regularity: 0.1,
                    growth: 1.0,
                },
                at_authority: 0.0,
                compensation: 0.2,
                force_loop: 0.0,
                fault: 0.0,
                drives: Default::default(),
            }),
            failed: None,
        }
    };
    let unfinished = Trial {
        figures: None,
        symptoms: None,
        failed: Some("the seam is out of reach".to_owned()),
        ..trial(2, 1.0)
    };
    let margin = Margin {
        gain: 2.5,
        fall: f64::INFINITY,
        phase_rad: 0.6,
        modulus: 0.55,
        delay_s: f64::INFINITY,
    };
    let condition = |path: f64| Condition {
        at: OperatingPoint { path, push: 18e3, feed: 0.01, ramp: false },
        friction: FrictionSlope::AtSpeed,
        draw: None,
    };
    let place = |path: f64| Margins {
        of: condition(path),
        spectral_radius: 0.991,
        held_at_a_limit: false,
        channels: Some([margin; LOOP_CHANNELS]),
        disk: 0.5,
        drive_disk: 0.7,
        passivity: Passivity { needed_ns_m: 9e4, there_ns_m: 1e3 },
    };
    let stuck = Margins {
        of: Condition { friction: FrictionSlope::Full, ..condition(0.0) },
        channels: Some([Margin { modulus: 0.52, ..margin }; LOOP_CHANNELS]),
        ..place(0.0)
    };
    let drawn = Margins { of: Condition { draw: Some(1), ..condition(1.0) }, ..place(1.0) };
    let standing = OperatingPoint { feed: 0.0, ramp: true, ..condition(2.0).at };
    let ramp = Margins { of: Condition { at: standing, ..condition(2.0) }, ..place(2.0) };
    let away =
        Margins { spectral_radius: 1.02, channels: None, disk: 0.0, drive_disk: 0.0, ..place(2.0) };
    let figures = |value: f64| FAULT_FIGURES.iter().map(move |f| (f.figure.key.to_owned(), value));
    let is_reported = |name: &str| name == "force-stuck";
    let undetected = |name: &str, value: f64| {
        (!is_reported(name)).then(|| ("undetected_of_limit".to_owned(), value / 1e-4))
    };
    let fault = |name: &str, fault: &str, value: f64| FaultTrial {
        name: name.to_owned(),
        fault: fault.to_owned(),
        draw: None,
        time: [85.6, 88.6],
        detected: is_reported(name).then_some(0.048),
        worst: Some(LimitedFigure { name: "lateral_max_m".to_owned(), value, limit: 1e-4 }),
        figures: Some(figures(value).chain(undetected(name, value)).collect()),
        symptoms: None,
        failed: None,
    };
    let worst = trial(17, 30.0);
    let evidence = Evidence {
        nominal: trial(0, 0.1),
        trials: vec![trial(0, 0.1), trial(1, 25.0), unfinished],
        rare: None,
        worst: WorstCase {
            name: "lateral_rms_m",
            of_limit: worst.figure("lateral_rms_m") / 5e-5,
            beyond: 1,
            runs: vec![worst.clone()],
            worst: Some(worst),
        },
        margins: vec![place(0.0), stuck, away, ramp, drawn],
        faults: vec![
            fault("force-stuck", "force sensor stuck at its last value", 1e-5),
            fault("seam-dropped", "seam sensor that gives nothing", 0.02),
            fault("seam-offset", "seam sensor with an offset", 7e-4),
        ],
    };
    let judged = judge(&requirements, &evidence);
    let certificate = Certificate {
        law: "elastostatic".to_owned(),
        controller: "external",
        passes: 1,
        seed: 1,
        asked: [requirements.failure_probability, requirements.confidence],
        welds: vec![CertifiedWeld {
            name: "vertical".to_owned(),
            held: stated.held(&requirements),
            planned: WeldPlan::of(
                &Weld::read(fixture("welds/vertical.toml")).unwrap(),
                &Process::read(fixture("processes/lap-weld-2024-t3.toml")).unwrap(),
            ),
            sensitivities: vec![Sensitivity {
                name: "lateral_rms_m",
                beyond: 2,
                of: 3,
                explained: 0.8,
                influences: vec![
                    Influence {
                        number: "stiffness.A2".to_owned(),
                        share: 0.6,
                        trend: Trend::Falls,
                        beyond_without: 1,
                    },
                    Influence {
                        number: "seam shift_y_m".to_owned(),
                        share: 0.2,
                        trend: Trend::AtEnds,
                        beyond_without: 2,
                    },
                ],
            }],
            weak_points: weak_points(&judged, &evidence.margins[..1]),
            shown: vec![ShownRun {
                kind: ShownKind::Nominal,
                recording: welds(100).recordings.remove(1),
            }],
            requirements: judged,
            accepted_faults: accepted_faults(&requirements, &evidence.faults),
            evidence,
            assumed: None,
        }],
        uncertain: uncertain(),
        files: vec![FileDigest::new("evidence", "trials-vertical.jsonl", b"abc")],
        kept: 0,
        repeated: 0,
        provenance: provenance().clone(),
    };
    CertifyReport {
        certificate,
        seed_given: true,
        robot_grade: "A KR 500: research estimate.".to_owned(),
        repeat: "trueweld certify --compensator elastostatic".to_owned(),
    }
}

/// What the logs of the improvement measure: two numbers of the cell, and one of each log at its
/// bound.
pub fn posterior() -> Posterior {
    let kind = |id: &str| EffectKind::of(id).unwrap();
    let number = |id: &str, joint: usize, value: f64, between_logs: f64| MeasuredNumber {
        kind: kind(id),
        at: Location::Joint(joint),
        occurrence: 0,
        parameter: 0,
        value,
        between_logs,
    };
    Posterior {
        numbers: vec![
            number("backlash", 4, 2.4e-4, 0.0),
            number("stiffness-error", 1, 0.01, 0.0),
            number("encoder-offset", 2, 0.005, 1e-5),
        ],
        covariance: vec![1e-12, 0.0, 1e-6, 0.0, 0.0, 1e-12],
        logs: vec!["static".to_owned(), "free".to_owned()],
        campaign: "0123456789abcdef".to_owned(),
        score: 1.02,
        at_bound: vec!["encoder-offset at A3: offset_rad".to_owned()],
        undetermined: Vec::new(),
        not_measured: vec!["damping-error at A6: relative".to_owned()],
        seal: String::new(),
    }
}

/// What is not known of the cell of the certificate: the short keys, and three numbers of one kind
/// each.
fn uncertain() -> UncertainCell {
    let text = std::fs::read_to_string(fixture("requirements/lap-weld.toml")).unwrap();
    let more = r#"
            [[uncertain]]
            effect = "joint-friction"
            at = "A2"
            parameter = "coulomb_nm"
            distribution = "triangular"
            low = -0.5
            mode = 0.0
            high = 1.0
            relative = true
            source = "estimated"
            [[uncertain]]
            sensor = "seam.zero_m"
            distribution = "normal"
            mean = 0.0
            sd = 2e-5
            group = "mounting"
            correlation = 0.5
            source = "data sheet"
            [[uncertain]]
            seam = "shift_y_m"
            distribution = "uniform"
            low = -5e-4
            high = 5e-4
            source = "estimated"
        "#;
    let requirements = Requirements::parse(&format!("{text}{more}"), "requirements").unwrap();
    let robot = RobotFile::read(fixture("robots/kr500-mt.toml")).unwrap();
    let process = Process::read(fixture("processes/lap-weld-2024-t3.toml")).unwrap();
    let sensors = Sensors::read(fixture("sensors/kr500-mt.toml")).unwrap();
    requirements.uncertain_cell(&robot, &process, &sensors).unwrap()
}

/// What the samples are of.
pub fn provenance() -> &'static Provenance {
    static OF: LazyLock<Provenance> = LazyLock::new(|| Provenance {
        version: "0.1.0".to_owned(),
        sources: "5eed".repeat(16),
        command: "weld".to_owned(),
        robot: "KR 500".to_owned(),
        effects: Vec::new(),
        simulation: None,
        files: vec![FileDigest::new("weld", "vertical.toml", b"abc")],
        warnings: Vec::new(),
    });
    &OF
}
