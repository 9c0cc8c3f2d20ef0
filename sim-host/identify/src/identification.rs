//! What was identified: numbers with intervals, which of them the logs do not tell, and what shows
//! whether the model fits.

use crate::coordinates::{Asked, DAMPING, STIFFNESS};
use crate::curve::{StiffnessCurve, curves};
use crate::error::IdentifyError;
use crate::fit::{Fit, converge};
use nalgebra::DMatrix;
use trueweld_core::JOINTS;
use trueweld_measure::data::log::{Log, LogKind};
use trueweld_measure::fit::{chi_square, count};
use trueweld_measure::residuals::compare::Notice;
use trueweld_plant::effects::Location;
use trueweld_plant::input::ModelFile;

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// Stiffness of the joints, from loads at rest.
    Stiffness,
    /// Damping of the joints, from ring-downs.
    Damping,
}

impl Target {
    /// Its name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stiffness => "stiffness",
            Self::Damping => "damping",
        }
    }

    /// Kinds of logs that it is told by; the first is needed.
    pub fn kinds(self) -> &'static [LogKind] {
        match self {
            Self::Stiffness => &[LogKind::StaticLoad],
            Self::Damping => &[LogKind::RingDown, LogKind::StaticLoad],
        }
    }
}

/// One number.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// Key in its file.
    pub name: String,
    /// Name of the joint it is of; empty for one of the whole cell.
    pub at: String,
    /// The value found; the one given where the logs do not tell it.
    pub value: f64,
    /// 95 % interval; `None` where the logs do not tell the number.
    pub interval: Option<[f64; 2]>,
    /// The value given.
    pub given: f64,
    /// Unit.
    pub unit: &'static str,
}

impl Number {
    /// True where the logs tell it.
    pub fn is_identifiable(&self) -> bool {
        self.interval.is_some()
    }
}

/// What was identified.
#[derive(Debug)]
pub struct Identification {
    /// What was asked for.
    pub target: Target,
    /// The model with the numbers found.
    pub model: ModelFile,
    /// The numbers, in their order in the file.
    pub numbers: Vec<Number>,
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
    /// What a person should know besides.
    pub notices: Vec<Notice>,
}

/// Quantile of the normal distribution for 95 %.
pub(crate) const TWO_SIDED: f64 = 1.959_964;

/// Identifies numbers from logs. `logs`: as read, their trackers not yet registered. `done` gets what
/// is being done, and the share done of it.
///
/// # Errors
/// [`IdentifyError`].
pub fn identify(
    target: Target,
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
    let joints = |coordinate, told| (0..JOINTS).map(move |j| Asked::of_joint(coordinate, j, told));
    let asked: Vec<Asked> = match target {
        Target::Stiffness => joints(&STIFFNESS, true).collect(),
        Target::Damping => joints(&STIFFNESS, false).chain(joints(&DAMPING, true)).collect(),
    };
    let fit = converge(model, &used, &asked, &|share| done("fitting", share))?;
    let shown: Vec<usize> = (0..asked.len()).filter(|k| asked[*k].told).collect();
    let numbers = shown.iter().map(|k| number(&asked[*k], *k, &fit, model)).collect();
    let covariance = fit.covariance.select_rows(&shown).select_columns(&shown);
    let correlation = DMatrix::from_fn(shown.len(), shown.len(), |i, j| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        if scale > 0.0 && scale.is_finite() { covariance[(i, j)] / scale } else { f64::NAN }
    });
    let curves = match target {
        Target::Stiffness => curves(&fit, &asked),
        Target::Damping => Vec::new(),
    };
    let samples = count(&fit.fitted.at);
    let score = |sum: f64| (sum / samples.max(1) as f64).sqrt();
    let before = fit.score_of(model)?;
    Ok(Identification {
        target,
        numbers,
        correlation,
        score: score(chi_square(&fit.fitted.at)),
        score_before: before,
        samples,
        logs: fit.logs.iter().map(|log| log.name.clone()).collect(),
        left_out: others.into_iter().map(|log| log.name).collect(),
        curves,
        notices: fit.found.notices().collect(),
        model: fit.model,
    })
}

fn number(asked: &Asked, k: usize, fit: &Fit, model: &ModelFile) -> Number {
    let (given, found) = (asked.value(model), asked.value(&fit.model));
    let wide = TWO_SIDED * fit.covariance[(k, k)].sqrt();
    let at = match asked.at {
        Location::Joint(joint) => model.robot.joint_names[joint].clone(),
        _ => String::new(),
    };
    Number {
        name: asked.coordinate.name.to_owned(),
        at,
        value: if fit.told[k] { found } else { given },
        interval: fit.told[k].then(|| [found * (-wide).exp(), found * wide.exp()]),
        given,
        unit: asked.coordinate.unit,
    }
}
