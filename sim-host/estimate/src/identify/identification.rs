//! What was identified: numbers with intervals, which of them the logs do not tell, and what shows
//! whether the model fits.

use crate::fit::{chi_square, count};
use crate::identify::coordinates::{FreeCoordinate, JOINT_DAMPING, PROCESS_COORDINATES, STIFFNESS};
use crate::identify::curve::{StiffnessCurve, curves};
use crate::identify::error::IdentifyError;
use crate::identify::fit::{IdentificationFit, converge};
use crate::identify::modes::{ByDecrement, Mode, modes};
use crate::identify::number::{Number, TWO_SIDED};
use crate::identify::process::{self, Section};
use crate::residuals::compare::{Notice, baseline, of_comparable, of_reading};
use crate::residuals::single_load::single_loads;
use nalgebra::DMatrix;
use trueweld_core::{JOINTS, Robot};
use trueweld_logs::log::{Log, LogKind};
use trueweld_plant::effects::Location;
use trueweld_plant::effects::drive_compliance::{SPRING_DAMPING_RATIO, damping};
use trueweld_plant::input::ModelFile;
use trueweld_plant::named;

named! {
    /// What is asked for.
    pub enum IdentificationTarget {
        /// Stiffness of the joints, from loads at rest.
        Stiffness = "stiffness",
        /// Damping of the joints, from ring-downs.
        Damping = "damping",
        /// The welding process, from the forces of welds.
        Process = "process",
    }
}

impl IdentificationTarget {
    /// Kinds of logs that it is told by; the first is needed.
    pub fn kinds(self) -> &'static [LogKind] {
        match self {
            Self::Stiffness => &[LogKind::StaticLoad],
            Self::Damping => &[LogKind::RingDown, LogKind::StaticLoad],
            Self::Process => &[LogKind::Weld],
        }
    }
}

/// What was identified.
#[derive(Debug)]
pub struct Identification {
    /// What was asked for.
    pub target: IdentificationTarget,
    /// The model with the numbers found.
    pub model: ModelFile,
    /// The numbers, in their order in the file.
    pub numbers: Vec<Number>,
    /// Numbers that were free because these hang on them; the model keeps the values given.
    pub beside: Vec<Number>,
    /// Correlation of the numbers' logarithms.
    pub correlation: DMatrix<f64>,
    /// √mean((residual/noise)²) of the logs used, with the numbers found.
    pub score: f64,
    /// The same with the numbers given and calibrations as they are.
    pub score_before: f64,
    /// Compared values.
    pub samples: usize,
    /// Names of the logs used.
    pub logs: Vec<String>,
    /// Names of the logs that show nothing of it.
    pub left_out: Vec<String>,
    /// Stiffness over torque, a curve a joint that the logs tell.
    pub curves: Vec<StiffnessCurve>,
    /// Modes of the arm, seen in ring-downs.
    pub modes: Vec<Mode>,
    /// Damping of each joint by the decrements of the modes alone.
    pub decrements: [Option<ByDecrement>; JOINTS],
    /// How well the forces are met in the parts of every weld.
    pub sections: Vec<Section>,
    /// What a person should know besides.
    pub notices: Vec<Notice>,
}

/// Identifies numbers from logs. `logs`: as read, their trackers not yet registered. `done` gets what
/// is being done, and the share done of it.
///
/// # Errors
/// [`IdentifyError`].
pub fn identify(
    target: IdentificationTarget,
    model: &ModelFile,
    logs: Vec<Log>,
    done: &dyn Fn(&'static str, f64),
) -> Result<Identification, IdentifyError> {
    let kinds = target.kinds();
    let given: Vec<LogKind> = logs.iter().map(|log| log.kind).collect();
    if !given.contains(&kinds[0]) {
        return Err(IdentifyError::no_logs(target.name(), &kinds[..1], &given));
    }
    let (used, others): (Vec<Log>, Vec<Log>) =
        logs.into_iter().partition(|log| kinds.contains(&log.kind));
    let joints =
        |coordinate, told| (0..JOINTS).map(move |j| FreeCoordinate::of_joint(coordinate, j, told));
    // A drive that is stated to be rigid has no spring, unless that is what is asked.
    let rigid = model.robot.rigid;
    let bending = |coordinate, told| {
        let bends = move |j: &usize| !rigid[*j];
        (0..JOINTS).filter(bends).map(move |j| FreeCoordinate::of_joint(coordinate, j, told))
    };
    let mut orders = Vec::new();
    let asked: Vec<FreeCoordinate> = match target {
        IdentificationTarget::Stiffness => joints(&STIFFNESS, true).collect(),
        IdentificationTarget::Damping => {
            bending(&STIFFNESS, false).chain(bending(&JOINT_DAMPING, true)).collect()
        }
        IdentificationTarget::Process => {
            let process = model.process.as_ref().ok_or(IdentifyError::NoProcess)?.kind();
            if PROCESS_COORDINATES.iter().any(|of| !process.keys.contains(&of.name)) {
                return Err(IdentifyError::OtherProcess { process: process.name });
            }
            orders = process::orders(&of_comparable(&mut used.clone(), &baseline(model))?);
            if orders.is_empty() {
                return Err(IdentifyError::NoForces);
            }
            process::asked(&orders).into_iter().chain(bending(&STIFFNESS, false)).collect()
        }
    };
    let start = match target {
        IdentificationTarget::Stiffness => with_springs(model)?,
        _ => model.clone(),
    };
    let mut fit = converge(&start, &used, &asked, &|share| done("fitting", share))?;
    let shown: Vec<usize> =
        (0..asked.len()).filter(|k| asked[*k].told && asked[*k].order == 0.0).collect();
    let mut numbers: Vec<Number> =
        shown.iter().map(|k| number(&asked[*k], *k, &fit, model)).collect();
    let covariance = fit.covariance.select_rows(&shown).select_columns(&shown);
    let correlation = DMatrix::from_fn(shown.len(), shown.len(), |i, j| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        if scale > 0.0 && scale.is_finite() { covariance[(i, j)] / scale } else { f64::NAN }
    });
    let beside = (0..asked.len())
        .filter(|k| !asked[*k].told)
        .map(|k| number(&asked[k], k, &fit, model))
        .collect();
    let (mut over_torque, mut seen, mut sections) = (Vec::new(), Vec::new(), Vec::new());
    let mut decrements = [None; JOINTS];
    match target {
        IdentificationTarget::Stiffness => over_torque = curves(&fit, &asked),
        IdentificationTarget::Damping => (seen, decrements) = modes(&fit),
        IdentificationTarget::Process => {
            sections = process::sections(&fit);
            let (mut of_ripple, file) = process::ripple(&fit, &orders, shown.len());
            if let (Some(process), Some(given)) = (&mut fit.model.process, &model.process) {
                process.ripple = file;
                of_ripple.iter_mut().for_each(|n| n.given = process::given(given, n));
            }
            numbers.append(&mut of_ripple);
        }
    }
    // A file has the numbers that were asked for, and no other changed.
    let robot = &mut fit.model.robot;
    for (j, given) in model.robot.parameters.joints.iter().enumerate() {
        let own = &mut robot.parameters.joints[j];
        match target {
            IdentificationTarget::Stiffness if !rigid[j] => {}
            IdentificationTarget::Stiffness if fit.told[j] => {
                robot.rigid[j] = false;
                own.damping = damping(given, own.stiffness, SPRING_DAMPING_RATIO);
            }
            IdentificationTarget::Stiffness => *own = *given,
            _ => own.stiffness = given.stiffness,
        }
    }
    robot.robot = Robot::new(robot.parameters.clone()).map_err(IdentifyError::Model)?;
    let samples = count(&fit.fitted.residuals);
    let score = |sum: f64| (sum / samples.max(1) as f64).sqrt();
    let before = fit.score_of(model)?;
    Ok(Identification {
        target,
        numbers,
        beside,
        correlation,
        score: score(chi_square(&fit.fitted.residuals)),
        score_before: before,
        samples,
        logs: fit.logs.iter().map(|log| log.name.clone()).collect(),
        left_out: others.into_iter().map(|log| log.name).collect(),
        curves: over_torque,
        modes: seen,
        decrements,
        sections,
        notices: of_reading(&fit.logs)
            .chain(single_loads(&fit.logs, &fit.problem.logs, &fit.fitted.residuals))
            .chain(fit.found.notices())
            .collect(),
        model: fit.model,
    })
}

/// Share of a rigid drive's stiffness from which a spring is looked for: its link would swing at some
/// 20 Hz in place of 500, and moves by it as far as logs show.
const SEARCHED_STIFFNESS_SHARE: f64 = 1.0 / 625.0;

/// The model with springs where its drives are stated to be rigid: what does not bend shows no slope
/// by which to bend more.
fn with_springs(model: &ModelFile) -> Result<ModelFile, IdentifyError> {
    let mut model = model.clone();
    let robot = &mut model.robot;
    for (joint, rigid) in robot.parameters.joints.iter_mut().zip(&mut robot.rigid) {
        if std::mem::take(rigid) {
            let stiffness = SEARCHED_STIFFNESS_SHARE * joint.stiffness;
            joint.damping = damping(joint, stiffness, SPRING_DAMPING_RATIO);
            joint.stiffness = stiffness;
        }
    }
    robot.robot = Robot::new(robot.parameters.clone()).map_err(IdentifyError::Model)?;
    Ok(model)
}

fn number(asked: &FreeCoordinate, k: usize, fit: &IdentificationFit, model: &ModelFile) -> Number {
    let (used, found) = (asked.value(model), asked.value(&fit.model));
    let is_rigid = matches!(asked.at, Location::Joint(joint) if model.robot.rigid[joint]);
    let wide = TWO_SIDED * fit.covariance[(k, k)].sqrt();
    let at = match asked.at {
        Location::Joint(joint) => model.robot.joint_names[joint].clone(),
        _ => String::new(),
    };
    Number {
        name: asked.coordinate.name.to_owned(),
        at,
        value: if fit.told[k] { found } else { used },
        interval: fit.told[k].then(|| [found * (-wide).exp(), found * wide.exp()]),
        given: if is_rigid { f64::NAN } else { used },
        unit: asked.coordinate.unit,
    }
}
