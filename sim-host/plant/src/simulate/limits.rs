//! What stood at a limit in a run or was at fault: since when, and how long.

use super::{Phase, Recording};
use crate::serialize_as_text;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;
use trueweld_core::{Fault, JOINTS};

/// Something that is held at a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// The torque of this drive (0 = A1).
    Torque(usize),
    /// What the force loop adds, in size or rate.
    ForceLoop,
    /// The compensation, in size or rate.
    Compensation,
    /// A fault of the controller or the law.
    Fault(Fault),
}

impl fmt::Display for LimitKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Torque(joint) => write!(f, "torque of A{}", joint + 1),
            Self::ForceLoop => f.write_str("force loop"),
            Self::Compensation => f.write_str("compensation"),
            Self::Fault(Fault::Encoder(joint)) => write!(f, "fault: encoder of A{}", joint + 1),
            Self::Fault(Fault::Force) => f.write_str("fault: force sensor"),
            Self::Fault(Fault::Setpoint) => f.write_str("fault: set-point"),
            Self::Fault(Fault::Singular) => f.write_str("fault: singular"),
            Self::Fault(Fault::Limit(joint)) => write!(f, "fault: limits of A{}", joint + 1),
            Self::Fault(Fault::Compensation) => f.write_str("fault: compensation"),
        }
    }
}

serialize_as_text!(LimitKind::to_string);

/// How long something was at a limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "LimitSpanResult", deny_unknown_fields)]
pub struct LimitSpan {
    /// What: `torque of A1`, `force loop`, `compensation` or the fault.
    #[serde(rename = "what")]
    pub kind: LimitKind,
    /// For how long, s.
    pub time_s: f64,
    /// When first, s.
    pub first_s: f64,
    /// Where the run was in its program then.
    pub phase: Phase,
}

/// Everything that was at a limit, the longest first.
pub fn limit_spans(recording: &Recording) -> Vec<LimitSpan> {
    let Recording { rows, period, max_torque, .. } = recording;
    // In rows first: sums of the period round.
    let mut spans: Vec<LimitSpan> = Vec::new();
    for row in rows {
        let mut at = |kind: LimitKind| match spans.iter_mut().find(|span| span.kind == kind) {
            Some(span) => span.time_s += 1.0,
            None => {
                let (first_s, phase) = (row.time, row.phase);
                spans.push(LimitSpan { kind, time_s: 1.0, first_s, phase });
            }
        };
        // A controller at fault gives a safe torque, which is not its own.
        if let Some(fault) = row.fault {
            at(LimitKind::Fault(fault));
        } else if row.limited.torque {
            let held = |joint: &usize| row.torque[*joint].abs() >= max_torque[*joint];
            (0..JOINTS).filter(held).for_each(|joint| at(LimitKind::Torque(joint)));
        }
        if row.limited.force_loop {
            at(LimitKind::ForceLoop);
        }
        if row.limited.compensation {
            at(LimitKind::Compensation);
        }
    }
    spans.sort_by(|a, b| b.time_s.total_cmp(&a.time_s));
    spans.iter_mut().for_each(|span| span.time_s *= period);
    spans
}
