//! What stood at a limit in a run or was at fault: since when, and how long.

use super::{Phase, RecordRow};
use std::fmt;
use trueweld_core::{Fault, JOINTS, JointVector};

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
            Self::Fault(fault) => write!(f, "fault {fault:?}"),
        }
    }
}

/// How long something was at a limit in a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitSpan {
    /// What.
    pub kind: LimitKind,
    /// When first, s.
    pub first: f64,
    /// Where the run was in its program then.
    pub phase: Phase,
    /// In how many rows of the run.
    pub rows: usize,
}

/// Everything that was at a limit, the longest first. `max_torque`: of the drives, N·m.
pub fn limit_spans(rows: &[RecordRow], max_torque: &JointVector<f64>) -> Vec<LimitSpan> {
    let mut spans: Vec<LimitSpan> = Vec::new();
    for row in rows {
        let mut at = |kind: LimitKind| match spans.iter_mut().find(|span| span.kind == kind) {
            Some(span) => span.rows += 1,
            None => spans.push(LimitSpan { kind, first: row.time, phase: row.phase, rows: 1 }),
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
    spans.sort_by_key(|span| std::cmp::Reverse(span.rows));
    spans
}
