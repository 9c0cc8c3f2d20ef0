//! A recorded weld beside its simulation: how far what is simulated of it can be trusted.

use crate::Spread;
use schemars::JsonSchema;
use serde::Serialize;
use trueweld_plant::simulate::{Phase, RecordRow, Recording};

/// What was recorded of a weld at one instant, below the spindle's frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedRow {
    /// Time, s.
    pub time: f64,
    /// Path position, m.
    pub path: f64,
    /// Deviation across the seam, m.
    pub lateral: f64,
    /// Depth below the plate's surface, m.
    pub depth: f64,
    /// Push on the plate as the force sensor read it, N.
    pub push: f64,
    /// Across the seam by the encoders alone, as if nothing bent, m.
    pub encoder: f64,
}

/// Figures of a recorded weld, or of its simulation at the same places.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "TrackFiguresResult", deny_unknown_fields)]
pub struct TrackFigures {
    /// Deviation across the seam, m.
    #[serde(rename = "lateral_m")]
    pub lateral: Spread,
    /// The same by the encoders alone, as if nothing bent, m: what was commanded, not what it became.
    #[serde(rename = "encoder_lateral_m")]
    pub encoder: Spread,
    /// The deviation less that: what the load bends, m.
    #[serde(rename = "bent_m")]
    pub bent: Spread,
    /// Depth below the plate's surface, m.
    #[serde(rename = "depth_m")]
    pub depth: Spread,
    /// Mean push, N.
    pub push_n: f64,
    /// Mean speed along the seam, m/s.
    pub feed_m_s: f64,
}

/// A recorded weld beside the simulation of the law that it was recorded under.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "ReplayCheckResult", deny_unknown_fields)]
pub struct ReplayCheck {
    /// The law.
    pub compensator: String,
    /// By the log's tracker and force sensor.
    pub recorded: TrackFigures,
    /// As simulated.
    pub replayed: TrackFigures,
    // Place by place along the steady part.
    /// Recorded less simulated deviation across the seam, m.
    #[serde(rename = "lateral_apart_m")]
    pub apart: Spread,
}

impl TrackFigures {
    fn of(rows: &[RecordedRow]) -> Option<Self> {
        let (first, last) = (rows.first()?, rows.last()?);
        let push = rows.iter().map(|row| row.push).filter(|push| push.is_finite());
        Some(Self {
            lateral: Spread::of(rows.iter().map(|row| row.lateral)),
            encoder: Spread::of(rows.iter().map(|row| row.encoder)),
            bent: Spread::of(rows.iter().map(|row| row.lateral - row.encoder)),
            depth: Spread::of(rows.iter().map(|row| row.depth)),
            push_n: Spread::of(push).mean,
            feed_m_s: (last.path - first.path) / (last.time - first.time),
        })
    }
}

impl ReplayCheck {
    /// Of the places that the simulation passes in its steady part; `None` where the record has none of
    /// them.
    pub fn of(recorded: &[RecordedRow], recording: &Recording) -> Option<Self> {
        let steady: Vec<&RecordRow> =
            recording.rows.iter().filter(|row| row.phase == Phase::Steady).collect();
        let range = tool_path(steady.first()?)..=tool_path(steady.last()?);
        let recorded: Vec<RecordedRow> =
            recorded.iter().filter(|row| range.contains(&row.path)).copied().collect();
        let replayed: Vec<RecordedRow> =
            recorded.iter().map(|row| simulated_at(&steady, row.path)).collect();
        let both = recorded.iter().zip(&replayed);
        Some(Self {
            compensator: recording.compensator.clone(),
            apart: Spread::of(both.map(|(a, b)| a.lateral - b.lateral)),
            recorded: TrackFigures::of(&recorded)?,
            replayed: TrackFigures::of(&replayed)?,
        })
    }
}

/// Where the tool is along the seam, m: it lags behind the program, as the recorded one does.
fn tool_path(row: &RecordRow) -> f64 {
    row.path + row.deviation_w.linear.x
}

/// The simulation where it was at a place: between the two rows about it. `steady` is not empty.
fn simulated_at(steady: &[&RecordRow], path: f64) -> RecordedRow {
    let after = steady.partition_point(|row| tool_path(row) < path).min(steady.len() - 1);
    let (a, b) = (steady[after.saturating_sub(1)], steady[after]);
    let span = tool_path(b) - tool_path(a);
    let share = if span > 0.0 { ((path - tool_path(a)) / span).clamp(0.0, 1.0) } else { 1.0 };
    let between = |of: fn(&RecordRow) -> f64| of(a) + share * (of(b) - of(a));
    RecordedRow {
        time: between(|row| row.time),
        path,
        lateral: between(|row| row.deviation_w.linear.y),
        depth: between(|row| row.deviation_w.linear.z),
        push: between(|row| -row.force_w.z),
        encoder: between(|row| {
            let from_nominal = row.encoder_pose.position - row.nominal.position;
            row.axes.column(1).dot(&from_nominal)
        }),
    }
}
