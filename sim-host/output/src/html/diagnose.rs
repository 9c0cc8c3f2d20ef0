//! The page of a diagnosis: the verdict, the curve that shows the best explanation, what it mends,
//! the others, what could not be seen or told apart, and what to record next.

use super::residuals::before_and_after;
use super::{figure, page};
use crate::color;
use crate::diagnosed::{
    Diagnosed, REMAINS, confusable, in_a_line, limits, none_of_these, ranked, values,
};
use crate::plot::{Line, Marked, Plot};
use crate::words::{self, Scale, score, share};
use maud::{Markup, html};
use trueweld_measure::diagnose::evidence::EffectCurve;
use trueweld_measure::diagnose::{Reason, Verdict};
use trueweld_measure::experiment::Plan;
use trueweld_measure::residuals::localize::foremost;
use trueweld_plant::input::RobotFile;

/// Columns drawn before and after.
const COLUMNS: usize = 4;
/// Pairs of effects that are hard to tell apart, shown at most.
const PAIRS: usize = 12;

/// The page of a diagnosis.
pub fn diagnose_page(diagnosed: &Diagnosed<'_>) -> String {
    let Diagnosed { diagnosis, account, .. } = diagnosed;
    let robot = &diagnosed.model.robot;
    let missing = diagnosis.verdict != Verdict::Adequate;
    let remains = foremost(&diagnosis.unexplained, REMAINS);
    let body = html! {
        h1 { (diagnosed.headline()) }
        @if let Some(explanation) = diagnosed.explanation() { p.lead { (explanation) } }
        p.setting { (diagnosed.setting()) }
        @if let Some(reason) = diagnosed.reason() { (evidences(reason)) }
        @if let Some(plan) = &account.next_experiment { (next(plan)) }
        @if missing && !diagnosis.chosen.is_empty() {
            h2 { "Measured and predicted, before and after" }
            p.setting { "Before: the model as it was given. After: with the best explanation and the calibrations that count." }
            (before_and_after(diagnosed.before, diagnosed.after, COLUMNS))
        }
        (ranking(diagnosed))
        @if !diagnosis.calibration.is_empty() {
            h2 { "A little off besides" }
            p.setting { "Calibrations of what the model already has: no missing effect." }
            ul {
                @for found in &diagnosis.calibration {
                    li {
                        (in_a_line(found, robot))
                        @if let Some(log) = found.log { " in " (diagnosed.log(log)) }
                    }
                }
            }
        }
        @if !remains.is_empty() {
            h2 { "What remains above the noise" }
            p.setting { "With the best explanation and the calibrations that count the score is " (format!("{:.2}", diagnosed.score_after())) ". What is left goes with:" }
            ul { @for finding in &remains { li { (finding.sentence) } } }
        }
        (blind_spots(diagnosed, robot))
    };
    page("Diagnose", &body)
}

/// The curves that show an explanation's effects.
fn evidences(reason: &Reason) -> Markup {
    let curves: Vec<&EffectCurve> = reason.evidence.iter().flatten().collect();
    html! {
        @if !curves.is_empty() {
            h2 { "The curve that shows it" }
            p.setting { "Points: what the measurements ask for, with standard errors, and without knowing the form of the effect. Line or rings: the effect as fitted." }
            @for curve in curves { (evidence(curve)) }
        }
    }
}

/// What the measurements draw of an effect, and the effect itself.
fn evidence(evidence: &EffectCurve) -> Markup {
    // A twist is a thousandth of what a joint turns by.
    let x = match evidence.points.iter().all(|p| p.x.abs() < 0.05) {
        true => Scale::small(evidence.x_unit),
        false => Scale::large(evidence.x_unit),
    };
    let y = Scale::small(evidence.y_unit);
    let label = |name: &str, scale: Scale| {
        if scale.unit.is_empty() { name.to_owned() } else { format!("{name}, {}", scale.unit) }
    };
    let marked = |p: &trueweld_measure::residuals::localize::CurvePoint| Marked {
        x: p.x * x.factor,
        y: p.y * y.factor,
        error: p.error * y.factor,
    };
    let fitted: Vec<(f64, f64)> =
        evidence.fitted.iter().map(|p| (p[0] * x.factor, p[1] * y.factor)).collect();
    // A loop comes in order of time, from posture to posture: a line through it would be a
    // scribble.
    let winding = !fitted.is_sorted_by(|a, b| a.0 <= b.0);
    let plot = Plot {
        x_label: label(&evidence.x_name, x),
        y_label: label(&evidence.y_name, y),
        lines: vec![Line {
            name: if winding { "ringed: the effect as fitted" } else { "the effect as fitted" }
                .to_owned(),
            color: color::run(1),
            dashed: false,
            points: if winding { Vec::new() } else { fitted.clone() },
        }],
        rings: if winding { fitted } else { Vec::new() },
        marked: evidence.points.iter().map(marked).collect(),
        wide: true,
        ..Plot::default()
    };
    figure(&evidence.title, &plot)
}

/// What to record next.
fn next(plan: &Plan) -> Markup {
    html! {
        h2 { "What to record next" }
        p { b { (plan.title) } ", about " (format!("{:.0}", plan.minutes.ceil())) " minutes. " (plan.reason) }
        ol { @for step in &plan.steps { li { (step) } } }
    }
}

/// The explanations that were fitted, best first.
fn ranking(diagnosed: &Diagnosed<'_>) -> Markup {
    let diagnosis = diagnosed.diagnosis;
    let robot = &diagnosed.model.robot;
    let candidates = ranked(diagnosis);
    html! {
        @if !candidates.is_empty() {
            h2 { "Explanations that were fitted" }
            p.setting {
                "Every effect of the library was tried at every place; these came out best. The held-out score is on blocks in time \
                 that were left out of the fit; " (score(diagnosis.score_before)) " without any of them."
            }
            table {
                thead {
                    tr {
                        th {} th.text { "values, 95 %" } th { "held-out score" } th { "still unexplained" }
                        th.bars { "probability" } th.text { "cannot be told from" }
                    }
                }
                tbody {
                    @for candidate in candidates {
                        tr {
                            th scope="row" { (candidate.name(robot)) }
                            td.values {
                                @for (name, value) in candidate.effects.iter().flat_map(values) { div { (name) " " (value) } }
                            }
                            td { (score(candidate.held_out_after)) }
                            td { (share(candidate.left.clamp(0.0, 1.0))) }
                            (probability(candidate.probability))
                            td.text {
                                @for k in &candidate.indistinguishable {
                                    @if let Some(other) = diagnosis.candidates.get(*k) { div { (other.name(robot)) } }
                                }
                            }
                        }
                    }
                    tr {
                        th scope="row" { "none of these" }
                        td {} td {} td {}
                        (probability(none_of_these(diagnosis)))
                        td {}
                    }
                }
            }
        }
    }
}

/// A cell with a probability, and a bar of its length.
fn probability(share: f64) -> Markup {
    html! {
        td.share {
            div.bar style={ "width:" (format!("{:.1}%", 60.0 * share)) } {}
            span { (words::probability(share)) }
        }
    }
}

/// What these logs would not have shown, or not told apart.
fn blind_spots(diagnosed: &Diagnosed<'_>, robot: &RobotFile) -> Markup {
    let diagnosis = diagnosed.diagnosis;
    let limits = limits(diagnosis, robot);
    html! {
        @if !limits.is_empty() {
            h2 { "The smallest effects that these logs would have shown" }
            p.setting { "By place, each in the unit of its line; a smaller one passes for noise. Nothing stands where these logs show nothing of it." }
            table {
                tbody {
                    @for line in &limits {
                        tr {
                            th scope="row" { (line.kind.id) }
                            td.text { (line.size) }
                            td.text {
                                @for (at, size) in &line.places { span.place { @if !at.is_empty() { i { (at) } " " } (size) } }
                            }
                        }
                    }
                }
            }
        }
        @if !diagnosis.confusable.is_empty() {
            h2 { "What these logs hardly tell apart" }
            p.setting { "Two effects that do nearly the same to these measurements; told apart only from so many times the smallest size above." }
            table {
                thead { tr { th { "one" } th.text { "the other" } th { "from × its limit" } } }
                tbody {
                    @for pair in diagnosis.confusable.iter().take(PAIRS) {
                        @let [first, second, apart] = confusable(pair, robot);
                        tr { th scope="row" { (first) } td.text { (second) } td { (apart) } }
                    }
                }
            }
            @if diagnosis.confusable.len() > PAIRS {
                p.setting { (diagnosis.confusable.len() - PAIRS) " more pairs stand in the JSON." }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::tests::assert_self_contained;
    use crate::sample;

    #[test]
    fn the_page_says_the_verdict_and_draws_what_shows_it() {
        let page = diagnose_page(&sample::diagnosis(Verdict::EffectFound).diagnosed());
        assert_self_contained(&page);
        assert!(page.contains("<h1>What is missing: backlash at A5"));
        // The evidence; measured with both predictions, and the differences.
        assert_eq!(page.matches("<svg").count(), 3);
        assert!(
            page.contains("What these logs hardly tell apart")
                && !page.contains("What to record next")
        );
    }

    #[test]
    fn where_nothing_is_missing_nothing_is_drawn_as_found() {
        let mut parts = sample::diagnosis(Verdict::Adequate);
        parts.diagnosis.unexplained.clear();
        let page = diagnose_page(&parts.diagnosed());
        assert!(page.contains("<h1>Nothing is missing above the noise floor"));
        assert!(page.contains("The smallest effects that these logs would have shown"));
        assert_eq!(page.matches("<svg").count(), 0);
    }
}
