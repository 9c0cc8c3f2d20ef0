//! Why a run did not come to its end.

use super::LimitSpan;
use crate::integrate::Diverged;
use crate::integrate::rest::EquilibriumError;
use crate::process::ProcessMisfit;
use trueweld_compensators::BuildError;

/// What was at a limit before a run broke off, the first first.
fn before(limits: &[LimitSpan]) -> String {
    let mut limits = limits.to_vec();
    limits.sort_by(|a, b| a.first_s.total_cmp(&b.first_s));
    let since = |span: &LimitSpan| format!("{} from {:.2} s on", span.kind, span.first_s);
    match &limits.iter().map(since).collect::<Vec<_>>()[..] {
        [] => String::new(),
        limits => format!("; at a limit before: {}", limits.join(", ")),
    }
}

/// Why a run did not come to its end.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// The tool cannot be brought to some point of the seam.
    #[error("the robot cannot hold the tool {path:.3} m along the seam: {reason}")]
    Reach {
        /// Path position, m.
        path: f64,
        /// In words.
        reason: &'static str,
    },
    /// A joint would have to turn faster than it can at some point of the seam.
    #[error(
        "the robot cannot weld {path:.3} m along the seam: A{} would have to turn at {:.1}°/s of its {:.0}, \
         near a singular posture",
        joint + 1, rate.to_degrees(), most.to_degrees()
    )]
    TooFast {
        /// Path position, m.
        path: f64,
        /// Which joint (0 = A1).
        joint: usize,
        /// How fast, rad/s.
        rate: f64,
        /// How fast it can turn, rad/s.
        most: f64,
    },
    /// A weld that is not one of the process.
    #[error(transparent)]
    Process(#[from] ProcessMisfit),
    /// A controller that the control file has no gains for.
    #[error(
        "the control file has no gains of the controller {controller}; expected a table [{controller}]"
    )]
    NoGains {
        /// Its name.
        controller: &'static str,
    },
    /// No deformed start.
    #[error(transparent)]
    Rest(#[from] EquilibriumError),
    /// A run whose state left the finite numbers, and what was at a limit before.
    #[error("{source}{}", before(limits))]
    RanAway {
        /// When.
        source: Diverged,
        /// What was at a limit before, the longest first; empty where the run had not begun.
        limits: Vec<LimitSpan>,
    },
    /// A gain that does not suit the control period.
    #[error("at a control period of {period} s {source}")]
    Law {
        /// The law and its gain.
        source: BuildError,
        /// Control period, s.
        period: f64,
    },
    /// A cell that cannot be built from what was drawn for it.
    #[error("the cell cannot be built")]
    Cell,
    /// A law that learns from a seam sensor, in a cell without one.
    #[error("the law {law} needs a seam sensor, and the sensor file has no [seam]")]
    NoSeamSensor {
        /// Its name.
        law: String,
    },
}

impl From<Diverged> for RunError {
    fn from(source: Diverged) -> Self {
        Self::RanAway { source, limits: Vec::new() }
    }
}
