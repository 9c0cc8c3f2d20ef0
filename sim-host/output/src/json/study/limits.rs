//! How far a weld can be driven.

use crate::json::result;
use crate::text::study::limits::because;
use crate::{LimitsAt, StudyLimitsReport};
use trueweld_evaluate::study::{Driven, FoundLimit, LimitProbe, Placement};
use trueweld_plant::provenance::Provenance;

result! {
    /// The largest push, feed and offset that keep requirements, at one place or several.
    StudyLimitsResult<'a> of (report: &StudyLimitsReport<'a>) {
        /// What the result is of.
        provenance: &'a Provenance = report.provenance,
        /// Length that was welded, m.
        length_m: f64 = report.length,
        /// Place by place, the weld's own first.
        places: Vec<PlaceLimits<'a>> = report.places.iter().map(PlaceLimits::of).collect(),
        /// Places asked for that the arm does not reach.
        out_of_reach: usize = report.out_of_reach,
    }
}

result! {
    /// The limits at one place.
    PlaceLimits<'a> of (place: &'a LimitsAt) {
        /// Where.
        placement: Placement = place.at,
        /// What was driven.
        limits: Vec<LimitResult<'a>> = place.limits.iter().map(LimitResult::of).collect(),
    }
}

result! {
    /// How far something can be driven.
    LimitResult<'a> of (found: &'a FoundLimit) {
        /// What: `force_n`, `feed_m_s` or `offset_m`.
        driven: Driven = found.driven,
        /// What the weld's file states of it.
        nominal: f64 = found.nominal,
        /// The largest value that keeps the requirements, SI units; `null` where none looked at does.
        largest: Option<f64> = found.largest,
        /// The value just beyond it that does not; `null` where the whole range keeps them.
        beyond: Option<f64> = found.beyond.as_ref().map(|probe| probe.value),
        /// What limits, in words.
        because: String = because(found),
        /// Requirements are kept again at this value beyond the edge.
        kept_again: Option<f64> = found.kept_again,
        /// Every run.
        runs: &'a [LimitProbe] = &found.probes,
    }
}
