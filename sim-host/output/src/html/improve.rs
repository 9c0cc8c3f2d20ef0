//! The page of an improvement: how the error fell step by step, what changed in the measurements'
//! terms, and every value with where it comes from.

use super::page;
use super::residuals::before_and_after;
use crate::diagnosed::{Improved, REMAINS};
use crate::words::score;
use maud::{Markup, html};
use trueweld_measure::diagnose::Verdict;
use trueweld_measure::residuals::localize::foremost;

/// Columns drawn before and after.
const COLUMNS: usize = 5;

/// Bars begin at this score: their length is its logarithm's.
const SHORTEST: f64 = 0.8;

/// The page of an improvement.
pub fn improve_page(improved: &Improved<'_>) -> String {
    let improvement = improved.improvement;
    let remains = foremost(&improvement.diagnosis.unexplained, REMAINS);
    let fitted = improved.fitted();
    let body = html! {
        h1 { (improved.headline()) }
        p.lead { (improved.verdict()) }
        p.setting { (improved.setting()) " The improved model: " (improved.out.display()) "." }
        (waterfall(improved))
        @if improvement.fitted.is_some() {
            h2 { "Measured and predicted, before and after" }
            p.setting { "The columns that changed most, of the logs that were fitted." }
            (before_and_after(improved.before, improved.after, COLUMNS))
        }
        @if !fitted.is_empty() {
            h2 { "The values of the improved model" }
            table {
                thead { tr { th {} th.text { "parameter" } th.text { "value, 95 %" } th.text { "where it comes from" } } }
                tbody {
                    @for [name, parameter, value, from] in &fitted {
                        tr { th scope="row" { (name) } td.text { (parameter) } td.text { (value) } td.text { (from) } }
                    }
                }
            }
        }
        @if !improvement.rejected.is_empty() {
            h2 { "Tried and not kept" }
            table {
                thead { tr { th {} th { "held-out score" } th.text { "why not" } } }
                tbody {
                    @for rejected in &improvement.rejected {
                        @let [what, why] = improved.rejected(rejected);
                        tr {
                            th scope="row" { (what) }
                            td { @if rejected.held_out.is_finite() { (score(rejected.held_out)) } @else { "–" } }
                            td.text { (why) }
                        }
                    }
                }
            }
        }
        @if improvement.verdict == Verdict::UnknownEffect && !remains.is_empty() {
            h2 { "What remains" }
            ul { @for finding in &remains { li { (finding.sentence) } } }
        }
    };
    page("Improve", &body)
}

/// The score of every step, on the logs fitted and where nothing was fitted.
fn waterfall(improved: &Improved<'_>) -> Markup {
    let steps = &improved.improvement.steps;
    let highest = steps.iter().flat_map(|s| [s.score, s.held_out]).fold(2.0, f64::max);
    let percent =
        |score: f64| 100.0 * (score.max(SHORTEST) / SHORTEST).ln() / (highest / SHORTEST).ln();
    let bar = |score: f64, other: bool| {
        html! {
            div.floor style={ "left:" (format!("{:.1}%", percent(1.0))) } {}
            div.bar.other[other] style={ "width:" (format!("{:.1}%", percent(score))) } {}
        }
    };
    html! {
        h2 { "Step by step" }
        table.steps {
            thead {
                tr {
                    th {} th { "logs fitted" } th { "not fitted" }
                    th.bars { span.key { i.fit {} "logs fitted" } span.key { i.other {} "not fitted" } "logarithmic; the line: noise floor, 1.0" }
                }
            }
            tbody {
                @for (k, step) in steps.iter().enumerate() {
                    tr {
                        th scope="row" { (improved.step(k)) }
                        td { (score(step.score)) }
                        td { b { (score(step.held_out)) } }
                        td.bars { (bar(step.score, false)) (bar(step.held_out, true)) }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::tests::assert_self_contained;
    use crate::sample;
    use std::path::Path;

    #[test]
    fn the_page_has_a_bar_a_score_and_says_what_was_not_kept() {
        let parts = sample::diagnosis(Verdict::EffectFound);
        let improvement = sample::improvement(parts.diagnosis);
        let page = improve_page(&Improved {
            model: &parts.model,
            out: Path::new("improved.toml"),
            improvement: &improvement,
            before: &parts.before,
            after: &parts.after,
        });
        assert_self_contained(&page);
        assert!(page.contains(
            "<h1>With backlash at A5 the score falls from 3.37 to 1.07 where nothing was fitted."
        ));
        assert_eq!(page.matches("class=\"floor\"").count(), 4);
        assert!(
            page.contains("recalibration alone")
                && page.contains("the error elsewhere does not fall")
        );
    }
}
