//! The pictures of a certificate: how the draws lie against a limit, what the worst runs did, and
//! the margins along the seam.

use crate::MILLI;
use crate::color::{self, Dash, LIMIT};
use crate::document::{Picture, Plot, PlotLine, reference};
use crate::text::certify::{drawn_label, run_name};
use crate::text::requirement::{label, scale};
use trueweld_evaluate::Rate;
use trueweld_evaluate::certify::{CertifiedWeld, EvidenceKind, Requirement, drawn_figure};
use trueweld_evaluate::margins::{MARGIN_FIGURES, Margins};
use trueweld_plant::simulate::RecordRow;

/// Least probability of a picture's axis: no more draws are made than show a tenth of it.
const RAREST: f64 = 1e-5;

/// A line that nothing may be beyond.
fn limit(name: &str, points: Vec<(f64, f64)>) -> PlotLine {
    PlotLine::new(name, LIMIT, points)
}

/// The same, upright at a figure; `ends`: of the axis of figures. The page's script knows one y for an
/// x, so that the line leans by less than its width.
fn upright(at: f64, ends: [f64; 2], bottom: f64) -> PlotLine {
    limit("limit", vec![(at, bottom), (at + 1e-3 * (ends[1] - ends[0]), 1.0)])
}

/// How often a draw is beyond a figure, one picture a requirement. `asked`: the share of welds that
/// may be beyond a limit, and the confidence.
pub(super) fn draws(weld: &CertifiedWeld, asked: [f64; 2]) -> Vec<Picture> {
    let required = weld.requirements.iter().filter(|r| r.case == EvidenceKind::Draws);
    required.filter_map(|requirement| exceedance(weld, requirement, asked)).collect()
}

fn exceedance(weld: &CertifiedWeld, of: &Requirement, asked: [f64; 2]) -> Option<Picture> {
    let [allowed, confidence] = asked;
    let scale = scale(of.name);
    let factor = scale.factor;
    let trials = &weld.evidence.trials;
    let mut sorted: Vec<f64> =
        trials.iter().map(|t| factor * drawn_figure(&weld.requirements, of, t)).collect();
    sorted.sort_by(f64::total_cmp);
    let finite: Vec<f64> = sorted.iter().copied().filter(|f| f.is_finite()).collect();
    let (first, last) = (*finite.first()?, *finite.last()?);
    let n = sorted.len();
    let limited = factor * of.limit;
    let right = 1.08 * limited.max(last);
    let left = if first > 0.5 * right { 0.9 * first.min(limited) } else { 0.0 };
    let bottom = (0.3 * (1.0 / n as f64).min(allowed)).max(RAREST);
    let (mut seen, mut at_most) = (vec![(left, 1.0)], vec![(left, 1.0)]);
    for (k, figure) in finite.iter().enumerate() {
        let before = Rate { hits: n - k, of: n };
        let after = Rate { hits: n - k - 1, of: n };
        for rate in [before, after] {
            let share = rate.hits as f64 / n as f64;
            seen.push((*figure, if rate.hits == 0 { f64::NAN } else { share }));
            at_most.push((*figure, rate.at_most(confidence)));
        }
    }
    at_most.push((right, at_most.last()?.1));
    let lines = vec![
        PlotLine::new(format!("{n} draws"), color::run(1), seen),
        PlotLine::new(drawn_label(confidence), color::run(1), at_most).dashed(Dash::Dashed),
        upright(limited, [left, right], bottom),
        reference("allowed share", vec![(left, allowed), (right, allowed)]),
    ];
    let plot = Plot {
        x_range: Some([left, right]),
        y_range: Some([bottom, 1.0]),
        logarithmic: true,
        ..Plot::new(scale.named(label(of.name)), "share of welds beyond", lines)
    };
    Some(Picture::new(label(of.name), plot))
}

/// How probable it is that the figure closest to its limit is beyond a share of it.
pub(super) fn rare(weld: &CertifiedWeld) -> Vec<Picture> {
    let Some(rare) = &weld.evidence.rare else {
        return Vec::new();
    };
    let points = rare.subset.curve();
    let last = points.last().map_or(1.0, |p| p.1).min(rare.allowed);
    let right = points.iter().map(|p| p.0).filter(|x| x.is_finite()).fold(1.0, f64::max);
    let ends = [points.first().map_or(0.0, |p| p.0.min(0.9)), 1.05 * right];
    let lines = vec![
        PlotLine::new("subset simulation", color::run(1), points),
        upright(1.0, ends, 0.3 * last),
        reference("allowed", ends.map(|x| (x, rare.allowed)).to_vec()),
    ];
    let plot = Plot {
        x_range: Some(ends),
        y_range: Some([0.3 * last, 1.0]),
        logarithmic: true,
        wide: true,
        ..Plot::new("largest share of any limit", "probability of a weld beyond", lines)
    };
    vec![Picture::new("Probability of a weld beyond a share of any of its limits", plot)]
}

/// A signal of a run over time, and a factor to the unit that it is shown in.
type Signal = (&'static str, &'static str, &'static str, fn(&RecordRow) -> f64);

/// What the worst runs are shown by, and the figure whose limit is drawn.
const SIGNALS: [Signal; 4] = [
    ("Lateral deviation", "lateral, mm", "lateral_max_m", |row| row.deviation_w.linear.y * MILLI),
    ("Tilt of the tool axis", "tilt, °", "tilt_max_rad", |row| row.tilt.to_degrees()),
    ("Depth of the tool in the plate", "depth, mm", "depth_max_m", |row| {
        row.deviation_w.linear.z * MILLI
    }),
    ("Lateral correction", "correction, mm", "correction_m", |row| {
        row.correction_w.linear.y * MILLI
    }),
];

/// What the tool did in the nominal cell and in the worst ones, over the whole run.
pub(super) fn worst_runs(weld: &CertifiedWeld) -> Vec<Picture> {
    if weld.shown.is_empty() {
        return Vec::new();
    }
    SIGNALS.iter().map(|signal| signal_of_worst_runs(weld, signal)).collect()
}

fn signal_of_worst_runs(weld: &CertifiedWeld, (title, y_label, key, value): &Signal) -> Picture {
    let lines = weld.shown.iter().enumerate().map(|(k, run)| {
        let points = run.recording.rows.iter().map(|row| (row.time, value(row)));
        PlotLine::new(run_name(run.kind), color::run(k), points.collect())
    });
    let limited = weld.limit(EvidenceKind::Draws, key).map(|of| scale(key).factor * of);
    let plot = Plot {
        band: limited.map(|limit| [-limit, limit]),
        band_name: "limit".into(),
        ..Plot::new("time, s", *y_label, lines.collect())
    };
    Picture::new(*title, plot)
}

/// Every margin along the nominal weld at work, the least over the slopes of friction, of the
/// corrections and of the drives, with its limit.
pub(super) fn margins(weld: &CertifiedWeld) -> Vec<Picture> {
    let same = |a: &Margins, b: &Margins| (a.of.at, a.of.draw) == (b.of.at, b.of.draw);
    let places = weld.evidence.margins.chunk_by(same);
    let map: Vec<&[Margins]> =
        places.filter(|at| !at[0].of.at.ramp && at[0].of.draw.is_none()).collect();
    let place = |at: &[Margins]| at[0].of.at.path * MILLI;
    let (Some(first), Some(last)) = (map.first(), map.last()) else {
        return Vec::new();
    };
    let ends = [first, last].map(|at| place(at));
    let of_corrections = MARGIN_FIGURES.iter().filter(|of| !of.figure.key.starts_with("drive_"));
    let figures = of_corrections.map(|of| {
        let scale = scale(of.figure.key);
        let factor = scale.factor;
        let drives = format!("drive_{}", of.figure.key);
        let pair =
            MARGIN_FIGURES.iter().filter(|f| [of.figure.key, &drives].contains(&f.figure.key));
        let mut lines = Vec::new();
        for (k, f) in pair.enumerate() {
            let least = |at: &[Margins]| at.iter().map(|at| (f.value)(at).0).reduce(f64::min);
            let value = |at: &[Margins]| least(at).map(|least| factor * least);
            let drawn = |at: &[Margins]| value(at).filter(|v| v.is_finite()).unwrap_or(f64::NAN);
            let points = map.iter().map(|at| (place(at), drawn(at))).collect();
            let name = ["corrections and force", "drives"][k];
            lines.push(PlotLine::new(name, color::run(k), points));
            if let Some(least) = weld.limit(EvidenceKind::Margins, f.figure.key) {
                let name = ["least asked for", "least asked of drives"][k];
                lines.push(limit(name, ends.map(|path| (path, factor * least)).to_vec()));
            }
        }
        let top = lines.iter().flat_map(|line| &line.points).map(|p| p.1).fold(0.0, f64::max);
        let plot = Plot {
            y_range: (top > 0.0).then_some([0.0, 1.08 * top]),
            ..Plot::new("position on the seam, mm", scale.named(of.figure.label), lines)
        };
        Picture::new(label(of.figure.key), plot)
    });
    figures.collect()
}
