//! Self-contained pages: one file with text, table and pictures, that needs no network and prints
//! as it stands.

mod certify;
mod compare;
mod diagnose;
mod improve;
mod residuals;

pub use certify::certify_page;
pub use compare::compare_page;
pub use diagnose::diagnose_page;
pub use improve::improve_page;

use crate::color::{self, css};
use crate::figures::{
    FigureCell, MILLI, STEP_HEADINGS, headline, run_names, setting, step_headline, step_lines,
    weld_lines,
};
use crate::path::{moving, travelled};
use crate::plot::{Line, Plot, reference};
use crate::{StepRun, WeldRun};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use trueweld_core::{JOINTS, JointVector};
use trueweld_evaluate::StepFigures;
use trueweld_plant::simulate::{Phase, RecordRow};

/// The page of one or several welds of a seam, figures and plots over the position on the seam.
pub fn weld_page(runs: &[WeldRun]) -> String {
    let names = run_names(runs);
    let lines = weld_lines(runs);
    let table = html! {
        table {
            thead {
                tr {
                    th {}
                    @for (k, name) in names.iter().enumerate() {
                        th.run colspan="3" style={ "border-color:" (css(color::run(k))) } { (name) }
                    }
                }
                tr.units { th {} @for _ in runs { th { "mean" } th { "RMS" } th { "|max|" } } }
            }
            tbody {
                @for line in &lines {
                    tr {
                        th scope="row" { (line.label) }
                        @for cell in &line.cells {
                            @match cell {
                                FigureCell::Spread(three) => { @for v in three { td { (v) } } }
                                FigureCell::Text { text, bad } => { td.bad[*bad] colspan="3" { (text) } }
                            }
                        }
                    }
                }
            }
        }
    };
    let body = html! {
        h1 { (headline(runs)) }
        p.setting { (setting(runs)) }
        (table)
        (weld_plots(runs, &names))
    };
    page("Weld", &body)
}

/// The page of the responses of several controllers to one step of the push by `height`, N, at time
/// `at`, s.
pub fn step_page(runs: &[StepRun], at: f64, height: f64) -> String {
    let figures: Vec<StepFigures> = runs.iter().map(|r| r.figures.clone()).collect();
    let goal = runs
        .first()
        .and_then(|r| r.recording.rows.last())
        .and_then(|r| r.force_desired)
        .unwrap_or(0.0);
    let since = |of: &dyn Fn(&RecordRow) -> Option<f64>, run: &StepRun| -> Vec<(f64, f64)> {
        let rows = run.recording.rows.iter().filter(|r| r.time >= at - 0.2);
        rows.filter_map(|r| of(r).map(|v| (r.time - at, v / MILLI))).collect()
    };
    let mut lines: Vec<Line> = runs
        .iter()
        .enumerate()
        .map(|(k, run)| Line {
            name: run.recording.controller.to_owned(),
            color: color::run(k),
            dashed: false,
            points: since(&|r| Some(-r.force_w.z), run),
        })
        .collect();
    lines.extend(
        runs.first()
            .map(|run| reference("push asked for", stepped(&since(&|r| r.force_desired, run)))),
    );
    let errors: Vec<Line> = runs
        .iter()
        .enumerate()
        .map(|(k, run)| Line {
            name: run.recording.controller.to_owned(),
            color: color::run(k),
            dashed: false,
            points: since(&|r| r.force_desired.map(|d| -r.force_w.z - d), run)
                .into_iter()
                .map(|(t, v)| (t, v * MILLI))
                .collect(),
        })
        .collect();
    let near = 0.05 * height.abs();
    let response = Plot {
        x_label: "time since the step, s".to_owned(),
        y_label: "push, kN".to_owned(),
        lines,
        band: Some([(goal - near) / MILLI, (goal + near) / MILLI]),
        band_name: "±5 % of the step",
        wide: true,
        ..Plot::default()
    };
    let rest = Plot {
        x_label: "time since the step, s".to_owned(),
        y_label: "push less push asked for, N".to_owned(),
        lines: errors,
        band: Some([-near, near]),
        band_name: "±5 % of the step",
        y_range: Some([-3.0 * near, 3.0 * near]),
        wide: true,
        ..Plot::default()
    };
    let body = html! {
        h1 { (step_headline(&figures)) }
        p.setting {
            "Step of the push by " (format!("{:.1}", height / MILLI)) " kN; 5 % and overshoot are of its height, taken from the "
            "real push with its ripple. Published figures: Bres et al., Industrial Robot 37(1), 2010."
        }
        table {
            thead { tr { @for heading in STEP_HEADINGS { th { (heading) } } } }
            tbody {
                @for line in step_lines(&figures) {
                    tr.published[line.published] {
                        th scope="row" { (line.cells[0].trim()) }
                        @for cell in &line.cells[1..] { td { (cell) } }
                    }
                }
            }
        }
        (figure("Response", &response))
        (figure("The same near its end value, less the push asked for: static error and ripple", &rest))
    };
    page("Force step", &body)
}

/// A line that holds each value until the next one.
fn stepped(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let corner = |pair: &[(f64, f64)]| [pair[0], (pair[1].0, pair[0].1)];
    points.windows(2).flat_map(corner).chain(points.last().copied()).collect()
}

fn weld_plots(runs: &[WeldRun], names: &[String]) -> Markup {
    let positions: Vec<Vec<f64>> = runs.iter().map(|r| travelled(&r.recording.rows)).collect();
    let length = positions.iter().filter_map(|p| p.last()).fold(0.0, |a: f64, b| a.max(*b)) * MILLI;
    // One signal of one run over the position on the seam, mm, while the tool moves.
    let over_path = |k: usize, of: &dyn Fn(&RecordRow) -> Option<f64>| -> Vec<(f64, f64)> {
        let rows = runs[k].recording.rows.iter().zip(&positions[k]);
        rows.filter(|(r, _)| moving(r.phase))
            .filter_map(|(r, s)| of(r).map(|v| (s * MILLI, v)))
            .collect()
    };
    let of_run = |k: usize, of: &dyn Fn(&RecordRow) -> Option<f64>| Line {
        name: names[k].clone(),
        color: color::run(k),
        dashed: false,
        points: over_path(k, of),
    };
    let of_all = |of: &dyn Fn(&RecordRow) -> Option<f64>| -> Vec<Line> {
        (0..runs.len()).map(|k| of_run(k, of)).collect()
    };
    let of_joints = |k: usize, of: &dyn Fn(&RecordRow) -> JointVector<f64>| -> Vec<Line> {
        (0..JOINTS)
            .map(|j| Line {
                name: format!("A{}", j + 1),
                color: color::JOINTS[j],
                dashed: false,
                points: over_path(k, &|r| Some(of(r)[j] * MILLI)),
            })
            .collect()
    };
    let plot = |y_label: &str, lines: Vec<Line>| Plot {
        x_label: "position on the seam, mm".to_owned(),
        y_label: y_label.to_owned(),
        lines,
        x_range: (length > 0.0).then_some([0.0, length]),
        ..Plot::default()
    };
    // A ripple, about the steady part: the ramp to it may leave the picture.
    let rippled = |y_label: &str, lines: Vec<Line>, of: &dyn Fn(&RecordRow) -> f64| {
        let steady =
            runs.iter().flat_map(|r| r.recording.rows.iter()).filter(|r| r.phase == Phase::Steady);
        let [low, high] = steady
            .map(of)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        let room = 0.3 * (high - low);
        Plot {
            y_range: (low < high).then_some([low - room, high + room]),
            rippled: true,
            ..plot(y_label, lines)
        }
    };
    let lateral = |r: &RecordRow| Some(r.deviation_w.linear.y * MILLI);
    let depth = |r: &RecordRow| r.deviation_w.linear.z * MILLI;
    let limit = runs.first().map_or(0.0, |r| r.recording.half_pin * MILLI);

    let all_lateral = Plot {
        band: Some([-limit, limit]),
        band_name: "within half the pin",
        wide: true,
        ..plot("lateral deviation, mm", of_all(&lateral))
    };
    let compensated: Vec<usize> =
        (0..runs.len()).filter(|&k| runs[k].recording.compensator != "none").collect();
    let zoomed: Vec<Line> = compensated.iter().map(|&k| of_run(k, &lateral)).collect();
    // The zoom is on the steady part: the transient of the ramp may leave the picture.
    let extent = compensated
        .iter()
        .flat_map(|&k| runs[k].recording.rows.iter())
        .filter(|r| r.phase == Phase::Steady)
        .map(|r| r.deviation_w.linear.y.abs() * MILLI)
        .fold(0.01, f64::max);
    let zoom = Plot {
        y_range: Some([-1.3 * extent, 1.3 * extent]),
        wide: true,
        ..plot("lateral deviation, mm", zoomed)
    };
    let mut push = of_all(&|r| Some(-r.force_w.z / MILLI));
    if !runs.is_empty() {
        push.push(reference("asked for", over_path(0, &|r| r.force_desired.map(|f| f / MILLI))));
    }
    let worst = (0..runs.len()).find(|k| !compensated.contains(k)).unwrap_or(0);
    let correction: Vec<Line> = compensated
        .iter()
        .flat_map(|&k| {
            [
                Line {
                    name: format!("{}, lateral", names[k]),
                    ..of_run(k, &|r| Some(r.correction_w.linear.y * MILLI))
                },
                Line {
                    name: format!("{}, longitudinal", names[k]),
                    dashed: true,
                    ..of_run(k, &|r| Some(r.correction_w.linear.x * MILLI))
                },
            ]
        })
        .collect();
    let turned = compensated
        .iter()
        .map(|&k| of_run(k, &|r| Some(r.correction_w.angular.norm() * MILLI)))
        .collect();
    html! {
        (figure(&format!("Lateral deviation; half the pin is ±{limit:.1} mm"), &all_lateral))
        @if !compensated.is_empty() { (figure("Lateral deviation with compensation, enlarged", &zoom)) }
        div.pairs {
            (figure("Longitudinal deviation", &plot("longitudinal, mm", of_all(&|r| Some(r.deviation_w.linear.x * MILLI)))))
            (figure(
                "Depth of the tool in the plate",
                &rippled("depth, mm", of_all(&|r| Some(depth(r))), &depth),
            ))
            (figure("Tilt of the tool axis", &plot("tilt, °", of_all(&|r| Some(r.tilt.to_degrees())))))
            (figure("Push on the plate", &rippled("push, kN", push, &|r| -r.force_w.z / MILLI)))
            @if let Some(name) = names.get(worst) {
                (figure(&format!("Twist of the drives, {name}"), &plot("twist, mrad", of_joints(worst, &RecordRow::twist))))
                (figure(
                    &format!("Lateral deviation by joint, {name}"),
                    &plot("lateral, mm", of_joints(worst, &|r| r.lateral_by_joint)),
                ))
            }
            (figure(
                "Controller: error of the push",
                &rippled("force error, N", of_all(&|r| Some(r.force_error)), &|r| r.force_error),
            ))
            (figure("Controller: depth added by the force loop", &plot("depth, mm", of_all(&|r| Some(r.depth_correction * MILLI)))))
            @if !compensated.is_empty() {
                (figure("Compensation: shift of the set-point", &plot("shift, mm", correction)))
                (figure("Compensation: turn of the set-point", &plot("turn, mrad", turned)))
            }
        }
    }
}

/// A picture with its title and the meaning of its lines.
pub(crate) fn figure(title: &str, plot: &Plot) -> Markup {
    html! {
        figure {
            figcaption {
                b { (title) }
                @for line in plot.lines.iter().filter(|line| !line.name.is_empty() && !plot.named) {
                    span.key {
                        i.dashed[line.dashed] style={ "border-color:" (css(line.color)) } {}
                        (line.name)
                    }
                }
                @if plot.rippled { span.key { "pale: ripple" @if plot.lines.iter().filter(|l| !l.dashed).count() > 1 { " of the first" } } }
                @if plot.band.is_some() { span.key { i.band {} (plot.band_name) } }
            }
            (PreEscaped(plot.svg()))
        }
    }
}

pub(crate) fn page(title: &str, body: &Markup) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) " – Trueweld" }
                style { (PreEscaped(include_str!("page.css"))) }
            }
            body { main { (body) } }
        }
    }
    .into_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    /// The only address in a page is the name of the SVG name space.
    pub(super) fn assert_self_contained(page: &str) {
        let outside = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!outside.contains("http"), "an address in the page");
        for word in ["<script", "<link", "@import", "src="] {
            assert!(!page.contains(word), "{word}");
        }
        assert!(page.len() < 2_000_000, "{} bytes", page.len());
    }

    #[test]
    fn a_weld_page_is_small_self_contained_and_says_the_result() {
        let welds = sample::welds(20_000);
        let page = weld_page(&welds.runs());
        assert_self_contained(&page);
        assert!(page.contains("<h1>At full feed the tool leaves the seam by up to "));
        assert!(page.contains("exceeded") && page.contains("elastostatic"));
        let max = format!("{:.3}", welds.figures[0].lateral.max_abs * 1e3);
        assert!(page.contains(&max));
        assert_eq!(page.matches("<svg").count(), 12);
    }

    #[test]
    fn a_single_uncompensated_weld_has_no_plots_of_a_correction() {
        let welds = sample::welds(100);
        let page = weld_page(&welds.runs()[..1]);
        assert!(!page.contains("Compensation: ") && !page.contains("enlarged"));
    }

    #[test]
    fn a_step_page_sets_the_published_figures_beside_ours() {
        let steps = sample::steps();
        let page = step_page(&steps.runs(), sample::STEP_AT, sample::STEP_HEIGHT);
        assert_self_contained(&page);
        for text in
            ["370 ms", "580 ms", "860 ms", "parallel", "superposed", "external", "24.0 %", "≤ 50 N"]
        {
            assert!(page.contains(text), "{text}");
        }
    }
}
