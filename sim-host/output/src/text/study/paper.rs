//! The published study beside ours: Bres et al., Industrial Robot 37(1), 2010, sections 5.2 and 5.3.

use crate::text::step::{SEARCHED_GAINS, milliseconds};
use crate::text::{PublishedStep, fixed, listed, share};
use crate::{MILLI, StudyPaperReport};
use schemars::JsonSchema;
use serde::Serialize;
use trueweld_evaluate::study::{EnvelopePoint, EnvelopeRun};
use trueweld_plant::named;
use trueweld_plant::simulate::{Phase, Recording};

/// Largest lateral deviation of the first sequence as published, m.
pub(crate) const PUBLISHED_LATERAL_MAX: f64 = 5e-3;

/// How far a figure may be from a published one to agree: as far as the figures of a printed curve
/// are read, and no gain is published.
const AGREES: f64 = 0.1;

/// Angle between the axes of A4 and A6 beyond which they are well apart, rad.
const WRIST_AXES_ANGLE_MIN: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// What is published of the push at 45°.
const WIDER: &str = "envelope is wider";

/// A published statement.
#[derive(Clone, Serialize, JsonSchema)]
#[schemars(rename = "PublishedStatement", deny_unknown_fields)]
pub(crate) struct Statement {
    /// What it is of.
    pub what: String,
    /// As published, in words.
    pub published: String,
    /// Ours, in words.
    pub ours: String,
    /// True where the gains were searched for it, so that it confirms nothing of the model.
    pub tuned: bool,
    /// Whether ours agrees; `null` where nothing measurable is published.
    pub agrees: Option<bool>,
}

named! {
    /// Which weld was moved.
    pub(crate) enum Kind {
        Vertical = "vertical",
        Inclined = "inclined",
    }
}

impl Kind {
    /// As pages show it.
    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::Vertical => "tool vertical",
            Self::Inclined => "tool at 45°",
        }
    }

    pub(crate) fn points<'a>(self, report: &StudyPaperReport<'a>) -> &'a [EnvelopePoint] {
        report.envelopes[self as usize]
    }
}

/// The runs of a kind in which nothing came to a limit, with their distances: a drive at its limit
/// holds no push, wherever its axes are.
pub(crate) fn runs<'a>(
    report: &StudyPaperReport<'a>,
    kind: Kind,
) -> impl Iterator<Item = (f64, &'a EnvelopeRun)> {
    let all = kind.points(report).iter();
    let ended = all.filter_map(|point| Some((point.x, point.outcome.as_ref().ok()?)));
    ended.filter(|(_, run)| run.figures.limited_rows == 0)
}

/// What came first to a limit in a run; nothing where none did.
pub(crate) fn held(run: &EnvelopeRun) -> String {
    let first = run.figures.limits.first();
    first.map_or(String::new(), |span| format!("{} at its limit", span.kind))
}

/// The run of a kind whose push swings most.
pub(crate) fn widest<'a>(
    report: &StudyPaperReport<'a>,
    kind: Kind,
) -> Option<(f64, &'a EnvelopeRun)> {
    runs(report, kind)
        .max_by(|a, b| a.1.figures.force.envelope.total_cmp(&b.1.figures.force.envelope))
}

/// How many statements agree of those that are judged, tuned or not, and which do not.
fn judged(statements: &[Statement], tuned: bool) -> ([usize; 2], String) {
    let of: Vec<_> = statements.iter().filter(|s| s.tuned == tuned && s.agrees.is_some()).collect();
    let missed: Vec<&str> =
        of.iter().filter(|s| s.agrees == Some(false)).map(|s| s.what.as_str()).collect();
    let not = match missed.as_slice() {
        [] => String::new(),
        missed => format!(" (not: {})", listed(missed, "and")),
    };
    ([of.len() - missed.len(), of.len()], not)
}

/// The finding: what was searched for counts apart from what came out.
pub(crate) fn headline(report: &StudyPaperReport<'_>) -> String {
    let statements = statements(report);
    let wide = widest(report, Kind::Inclined).map_or(String::new(), |(x, run)| {
        format!(
            " At 45° the push swings by {:.0} N where the seam lies at x = {} m and axes 4 and 6 come within {}° of a line.",
            run.figures.force.envelope,
            fixed(x, 2),
            fixed(run.collinearity.to_degrees(), 1),
        )
    });
    let ([found, of_found], not_found) = judged(&statements, false);
    let ([searched, of_searched], not_searched) = judged(&statements, true);
    format!(
        "{found} of {of_found} published statements that were not tuned hold here{not_found}. Of the step, for which the \
         gains were searched, {searched} of {of_searched} figures agree{not_searched}.{wide}"
    )
}

/// How the runs were made.
pub(crate) fn setting(report: &StudyPaperReport<'_>) -> String {
    let length = report.length * MILLI;
    format!(
        "Published: Bres et al., Industrial Robot 37(1), 2010, sections 5.2 and 5.3 with Figures 11 to 13. The printed \
         curves are not at hand: what the text states of them is marked. Steps and welds are the published ones; for the \
         push near collinear axes, {length:.0} mm of each weld are moved along x, without compensation; a weld with a \
         drive at its limit does not count. {SEARCHED_GAINS} The process file states the published forces, with the \
         spindle in the sense that adds to the first weld's deviation."
    )
}

/// Largest torsion of some joints over the steady part, rad.
fn torsion(recording: &Recording, joints: std::ops::Range<usize>) -> f64 {
    let steady = recording.rows.iter().filter(|row| row.phase == Phase::Steady);
    let largest = |row: &trueweld_plant::simulate::RecordRow| {
        let torsion = row.torsion();
        joints.clone().map(|joint| torsion[joint].abs()).fold(0.0, f64::max)
    };
    steady.map(largest).fold(0.0, f64::max)
}

/// Every published statement beside ours.
pub(crate) fn statements(report: &StudyPaperReport<'_>) -> Vec<Statement> {
    let of = |what: &str, published: &str, ours: String, agrees: Option<bool>| Statement {
        what: what.to_owned(),
        published: published.to_owned(),
        ours,
        tuned: false,
        agrees,
    };
    let tuned = |what: &str, published: &str, ours: String, agrees: Option<bool>| Statement {
        tuned: true,
        ..of(what, published, ours, agrees)
    };
    let near = |ours: f64, published: f64| (ours - published).abs() <= AGREES * published;
    let mut all = Vec::new();
    for run in report.steps {
        let figures = run.figures;
        let Some(theirs) = PublishedStep::of(figures.controller) else { continue };
        let name = format!("step, scheme {} ({})", theirs.scheme, figures.controller);
        let time = figures.settle_5pct_s;
        all.push(tuned(
            &format!("{name}: within 5 %"),
            &milliseconds(theirs.settle),
            time.map_or("never".to_owned(), milliseconds),
            Some(time.is_some_and(|time| near(time, theirs.settle))),
        ));
        let percent = |v: f64| format!("{} %", fixed(100.0 * v, 1));
        // A point of the step's height is what a printed curve is read to.
        let close = (figures.overshoot - theirs.overshoot).abs() <= 0.01;
        all.push(tuned(
            &format!("{name}: overshoot"),
            &percent(theirs.overshoot),
            percent(figures.overshoot),
            Some(close || near(figures.overshoot, theirs.overshoot)),
        ));
        all.push(tuned(
            &format!("{name}: static error"),
            theirs.static_error,
            format!("{} N", fixed(figures.static_error_n, 0)),
            None,
        ));
    }
    if let Some(first) = report.welds.first() {
        let lateral = first.figures.lateral.max_abs;
        all.push(of(
            "first weld: lateral, largest",
            "up to 5 mm",
            format!("{} mm", fixed(lateral * MILLI, 2)),
            Some(near(lateral, PUBLISHED_LATERAL_MAX)),
        ));
        let proximal: f64 = first.figures.joint_share.iter().take(3).sum();
        all.push(of(
            "first weld: lateral by A1 to A3",
            "most of it",
            share(proximal),
            Some(proximal > 0.5),
        ));
        let [near_base, wrist] = [0..3, 3..6].map(|joints| torsion(first.recording, joints));
        all.push(of(
            "first weld: torsion, wrist and A1 to A3",
            "of the same order",
            format!("{} and {} mrad", fixed(wrist * MILLI, 2), fixed(near_base * MILLI, 2)),
            Some((0.1..10.0).contains(&(wrist / near_base))),
        ));
    }
    if let [vertical, inclined] = report.welds {
        let [across, along] = [vertical, inclined].map(|run| run.figures.force.envelope);
        all.push(of(
            "push at 45°, at the published place",
            WIDER,
            format!("{along:.0} N; vertical {across:.0} N"),
            Some(along > (1.0 + AGREES) * across),
        ));
    }
    let of_push = |run: &EnvelopeRun| run.figures.force.envelope;
    // Beside the weld near collinear axes, those that keep away from them, whatever their tool.
    let away = Kind::ALL
        .into_iter()
        .flat_map(|kind| runs(report, kind))
        .filter(|(_, run)| run.collinearity > WRIST_AXES_ANGLE_MIN)
        .map(|(_, run)| of_push(run))
        .fold(0.0, f64::max);
    if let Some((x, run)) = widest(report, Kind::Inclined) {
        // Another seam than the published one: what it shows is not what is published.
        all.push(of(
            "push at 45°, where it is widest",
            WIDER,
            format!(
                "{:.0} N at x = {} m, {}° from a line; beyond {:.0}° at most {away:.0} N",
                of_push(run),
                fixed(x, 2),
                fixed(run.collinearity.to_degrees(), 1),
                WRIST_AXES_ANGLE_MIN.to_degrees(),
            ),
            None,
        ));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    fn headline_of(welds: &sample::Welds) -> String {
        let steps = sample::steps();
        headline(&StudyPaperReport {
            steps: &steps.runs(),
            at: sample::STEP_AT,
            height: sample::STEP_HEIGHT,
            welds: &welds.runs(),
            envelopes: [&[], &[]],
            length: 1.0,
            provenance: sample::provenance(),
        })
    }

    #[test]
    fn what_the_gains_were_searched_for_counts_apart() {
        let mut welds = sample::welds(400);
        // Both welds of the sample are one weld as far as the push is concerned.
        let place = "push at 45°, at the published place";
        let before = headline_of(&welds);
        let holds = |text: &str| text.split_once(" of 4 published").unwrap().0.parse::<u32>();
        assert!(before.contains(" of 6 figures agree") && before.contains(place), "{before}");
        welds.figures[1].force.envelope = 2.0 * welds.figures[0].force.envelope + 1.0;
        let after = headline_of(&welds);
        assert!(!after.contains(place), "{after}");
        assert_eq!(holds(&after), holds(&before).map(|count| count + 1), "{before} {after}");
    }

    #[test]
    fn kinds_stand_in_the_order_of_the_report() {
        assert_eq!(Kind::ALL.map(|kind| kind as usize), [0, 1]);
    }
}
