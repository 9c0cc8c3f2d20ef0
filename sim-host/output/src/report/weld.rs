//! Welds of a seam, side by side.

use super::{PublishedResult, Report};
use crate::color::{self, Dash, JOINT_COLOURS as JOINT_COLORS};
use crate::document::{
    Block, Document, Medium, Picture, Plot, PlotLine, Table, TableCell, number, reference, words,
};
use crate::path::{moving, travelled};
use crate::samples::{self, BlockTable};
use crate::text::replay::{not_taken, replayed, taken};
use crate::text::weld::{beyond_tolerance, headline, run_names, setting, speed};
use crate::text::{Scale, fixed};
use crate::{FromLog, MILLI, WeldReport, WeldRun};
use trueweld_core::monitor::WATCHED_ORDERS;
use trueweld_core::{JOINTS, JointVector};
use trueweld_evaluate::{DriveLoad, ReplayCheck, Spread, TrackFigures, WeldFigures};
use trueweld_plant::simulate::{Phase, RecordRow};

impl Report for WeldReport<'_> {
    const SCHEMA: &'static str = "weld-result/1";

    fn json(&self) -> impl PublishedResult {
        self
    }

    fn samples(&self) -> Option<BlockTable<'_>> {
        Some(samples::of_runs(self.runs.iter().map(|run| run.recording)))
    }

    fn document(&self) -> Document {
        let names = run_names(self.runs);
        let replay = self.from_log.map(|log| replayed(log) + " ").unwrap_or_default();
        let headline = replay + &headline(self.runs);
        let mut document = Document::new("Weld", headline, self.provenance);
        document.push(Block::Note(setting(self.runs)));
        document.push(Block::Table(table(self.runs, &names)));
        if let Some(log) = self.from_log {
            document.table("The record and its replay", beside_record(log));
            document.list("Taken from the log", taken(log));
            document.list("Not taken from it", not_taken(log));
        }
        document.push_on(Medium::Terminal, Block::Note(speed(self.runs)));
        let figures = figures(self.runs, &names, self.from_log);
        document.push_on(Medium::Page, Block::Figures(figures));
        document
    }
}

/// Three columns a run: mean, root mean square and largest magnitude.
fn table(runs: &[WeldRun], names: &[String]) -> Table {
    let mut head = vec![vec![words("")], vec![words("")]];
    for (k, name) in names.iter().enumerate() {
        head[0].push(number(name).over(3).colored(color::run(k)));
        head[1].extend(["mean", "RMS", "|max|"].map(number));
    }
    let mut rows = vec![
        spread(runs, "lateral", Scale::small("m"), |f| f.lateral),
        spread(runs, "longitudinal", Scale::small("m"), |f| f.longitudinal),
        spread(runs, "depth", Scale::small("m"), |f| f.depth),
        spread(runs, "tilt", Scale::large("rad"), |f| f.tilt),
    ];
    let mut text = |label: &str, of: &dyn Fn(&WeldRun) -> (String, bool)| {
        let cells = runs.iter().map(|run| {
            let (text, bad) = of(run);
            number(text).over(3).bad(bad)
        });
        rows.push(std::iter::once(words(label)).chain(cells).collect());
    };
    let limit = runs.first().map_or("", |run| run.recording.tolerance_name);
    text(&format!("within {limit}?"), &|run| {
        let met = !beyond_tolerance(run);
        let [largest, limit] =
            [run.figures.lateral.max_abs, run.recording.half_pin].map(|v| fixed(v * MILLI, 2));
        (format!("{largest} of ±{limit} mm: {}", if met { "yes" } else { "exceeded" }), !met)
    });
    text("the weld asked for?", &|run| {
        let judged = &run.figures.judged;
        match judged.iter().filter(|judged| !judged.met).count() {
            0 => ("yes".to_owned(), false),
            missed => (format!("no, {missed} of {} missed", judged.len()), true),
        }
    });
    text("before the steady part", &|run| {
        let largest = run.figures.lateral_before_m;
        (format!("{} mm lateral", fixed(largest * MILLI, 2)), largest >= run.recording.half_pin)
    });
    text("push, mean", &|run| (format!("{:.3} kN", run.figures.force.mean / MILLI), false));
    text("push, max − min", &|run| {
        let force = run.figures.force;
        (format!("{:.0} N, error RMS {:.0} N", force.envelope, force.error_rms), false)
    });
    text("lateral by A1…A6, %", &|run| {
        let shares: Vec<String> =
            run.figures.joint_share.iter().map(|share| fixed(100.0 * share, 0)).collect();
        (shares.join(" / "), false)
    });
    let drives = |run: &WeldRun, of: fn(&DriveLoad) -> f64| {
        let shares: Vec<String> =
            run.figures.drives.iter().map(|drive| fixed(100.0 * of(drive), 0)).collect();
        shares.join(" / ")
    };
    text("largest torque of A1…A6, %", &|run| {
        let held = run.figures.drives.iter().any(|drive| drive.at_torque_limit > 0.0);
        (drives(run, |drive| drive.torque_share), held)
    });
    text("largest speed of A1…A6, %", &|run| {
        let held = run.figures.drives.iter().any(|drive| drive.at_speed_limit > 0.0);
        (drives(run, |drive| drive.speed_share), held)
    });
    text("at a limit or faulted", &|run| match run.figures.limited_rows {
        0 => ("never".to_owned(), false),
        rows => {
            let first = run.figures.first_limit.as_ref().map_or(0.0, |first| first.time_s);
            (format!("{:.2} s, first at {first:.2} s", rows as f64 * run.recording.period), true)
        }
    });
    text("warnings", &|run| match run.figures.health.split_first() {
        None => ("none".to_owned(), false),
        Some((first, more)) => {
            let more =
                if more.is_empty() { String::new() } else { format!(", {} more", more.len()) };
            (format!("{} at {:.2} s{more}", first.kind, first.first_s), true)
        }
    });
    Table { head, rows }
}

/// Recorded and simulated figures of the steady part.
fn beside_record(log: &FromLog) -> Table {
    let ReplayCheck { recorded, replayed, apart, .. } = &log.check;
    let small = Scale::small("m");
    let row = |name: &str, values: [f64; 2], factor: f64, decimals: usize| {
        let values = values.map(|value| number(fixed(value * factor, decimals)));
        std::iter::once(words(name)).chain(values).collect()
    };
    let spread = |name: &str, of: fn(&Spread) -> f64| {
        let values = [recorded, replayed].map(|figures| of(&figures.lateral));
        row(&small.named(name), values, small.factor, 3)
    };
    let both = |of: fn(&TrackFigures) -> f64| [of(recorded), of(replayed)];
    let head = [words(""), number("recorded"), number("replayed")].to_vec();
    let along =
        format!("{} RMS, {} at most", small.quantity(apart.rms), small.quantity(apart.max_abs));
    let mut rows = vec![
        spread("lateral, mean", |f| f.mean),
        spread("lateral, RMS", |f| f.rms),
        spread("lateral, |max|", |f| f.max_abs),
        row(
            &small.named("lateral by the encoders, mean"),
            both(|f| f.encoder.mean),
            small.factor,
            3,
        ),
        row(&small.named("what the load bends, mean"), both(|f| f.bent.mean), small.factor, 3),
        row(&small.named("depth, mean"), both(|f| f.depth.mean), small.factor, 3),
        row("push, mean, kN", both(|f| f.push_n), 1.0 / MILLI, 3),
        row("speed along the seam, mm/s", both(|f| f.feed_m_s), MILLI, 3),
    ];
    rows.push(vec![words("lateral, apart"), number(along).over(2)]);
    Table { head: vec![head], rows }
}

/// Mean, root mean square and largest magnitude of every run.
fn spread(
    runs: &[WeldRun],
    label: &str,
    scale: Scale,
    of: fn(&WeldFigures) -> Spread,
) -> Vec<TableCell> {
    let mut row = vec![words(scale.named(label))];
    for run in runs {
        let Spread { mean, rms, max_abs } = of(run.figures);
        row.extend([mean, rms, max_abs].map(|v| number(fixed(v * scale.factor, 3))));
    }
    row
}

/// Signals over the position on the seam.
struct SeamSignals<'a> {
    runs: &'a [WeldRun<'a>],
    names: &'a [String],
    /// Distance gone, m, one value a row.
    positions: Vec<Vec<f64>>,
}

impl SeamSignals<'_> {
    /// One signal of one run, while the tool moves.
    fn over_path(&self, k: usize, of: impl Fn(&RecordRow) -> Option<f64>) -> Vec<(f64, f64)> {
        let rows = self.runs[k].recording.rows.iter().zip(&self.positions[k]);
        rows.filter(|(row, _)| moving(row.phase))
            .filter_map(|(row, s)| of(row).map(|value| (s * MILLI, value)))
            .collect()
    }

    fn of_run(&self, k: usize, of: impl Fn(&RecordRow) -> f64) -> PlotLine {
        PlotLine::new(&self.names[k], color::run(k), self.over_path(k, |row| Some(of(row))))
    }

    fn of_all(&self, of: impl Fn(&RecordRow) -> f64 + Copy) -> Vec<PlotLine> {
        (0..self.runs.len()).map(|k| self.of_run(k, of)).collect()
    }

    fn of_joints(&self, k: usize, of: impl Fn(&RecordRow) -> JointVector<f64>) -> Vec<PlotLine> {
        (0..JOINTS)
            .map(|joint| PlotLine {
                name: format!("A{}", joint + 1),
                color: JOINT_COLORS[joint],
                ..self.of_run(k, |row| of(row)[joint] * MILLI)
            })
            .collect()
    }

    fn plot(&self, y_label: &str, lines: Vec<PlotLine>) -> Plot {
        let ends = self.positions.iter().filter_map(|p| p.last());
        let length = MILLI * ends.fold(0.0, |longest: f64, end| longest.max(*end));
        Plot {
            x_range: (length > 0.0).then_some([0.0, length]),
            ..Plot::new("position on the seam, mm", y_label, lines)
        }
    }

    /// A signal with a ripple, about its steady part: the ramp to it may leave the picture.
    fn rippled(&self, y_label: &str, of: impl Fn(&RecordRow) -> f64 + Copy) -> Plot {
        let steady = self.runs.iter().flat_map(|run| &run.recording.rows);
        let [low, high] = steady
            .filter(|row| row.phase == Phase::Steady)
            .map(of)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        let room = 0.3 * (high - low);
        Plot {
            y_range: (low < high).then_some([low - room, high + room]),
            rippled: true,
            ..self.plot(y_label, self.of_all(of))
        }
    }
}

fn figures(runs: &[WeldRun], names: &[String], log: Option<&FromLog>) -> Vec<Picture> {
    if runs.is_empty() {
        return Vec::new();
    }
    let positions = runs.iter().map(|run| travelled(&run.recording.rows)).collect();
    let signals = SeamSignals { runs, names, positions };
    let lateral = |row: &RecordRow| row.deviation_w.linear.y * MILLI;
    let (limit, name) = (runs[0].recording.half_pin * MILLI, runs[0].recording.tolerance_name);
    let compensated: Vec<usize> =
        (0..runs.len()).filter(|k| runs[*k].recording.compensator != "none").collect();
    let mut push = signals.rippled("push, kN", |row| -row.force_w.z / MILLI);
    let asked_for = signals.over_path(0, |row| row.force_desired.map(|force| force / MILLI));
    push.lines.push(reference("asked for", asked_for));
    let mut laterals = signals.of_all(lateral);
    laterals.extend(log.map(|log| {
        let points = log.rows.iter().map(|row| (row.path * MILLI, row.lateral * MILLI));
        reference("recorded", points.collect())
    }));
    let all = Plot {
        band: Some([-limit, limit]),
        band_name: format!("within {name}").into(),
        wide: true,
        ..signals.plot("lateral deviation, mm", laterals)
    };
    let mut figures =
        vec![Picture::new(format!("Lateral deviation; {name} is ±{limit:.1} mm"), all)];
    if !compensated.is_empty() {
        // Enlarged about the steady part: the transient of the ramp may leave the picture.
        let rows = compensated.iter().flat_map(|k| &runs[*k].recording.rows);
        let steady = rows.filter(|row| row.phase == Phase::Steady);
        let extent = 1.3 * steady.map(|row| lateral(row).abs()).fold(0.01, f64::max);
        let lines = compensated.iter().map(|k| signals.of_run(*k, lateral)).collect();
        figures.push(Picture::new(
            "Lateral deviation with compensation, enlarged",
            Plot {
                y_range: Some([-extent, extent]),
                wide: true,
                ..signals.plot("lateral deviation, mm", lines)
            },
        ));
    }
    let mut add = |title: &str, plot: Plot| figures.push(Picture::new(title, plot));
    let longitudinal = signals.of_all(|row| row.deviation_w.linear.x * MILLI);
    add("Longitudinal deviation", signals.plot("longitudinal, mm", longitudinal));
    add(
        "Depth of the tool in the plate",
        signals.rippled("depth, mm", |row| row.deviation_w.linear.z * MILLI),
    );
    let tilt = signals.of_all(|row| row.tilt.to_degrees());
    add("Tilt of the tool axis", signals.plot("tilt, °", tilt));
    add("Push on the plate", push);
    let worst = (0..runs.len()).find(|k| !compensated.contains(k)).unwrap_or(0);
    add(
        &format!("Twist of the drives, {}", names[worst]),
        signals.plot("twist, mrad", signals.of_joints(worst, RecordRow::torsion)),
    );
    add(
        &format!("Lateral deviation by joint, {}", names[worst]),
        signals.plot("lateral, mm", signals.of_joints(worst, |row| row.lateral_by_joint)),
    );
    add("Controller: error of the push", signals.rippled("force error, N", |row| row.force_error));
    let lines = (0..runs.len()).flat_map(|k| {
        let of = |order: usize, dash| PlotLine {
            name: format!("{}, order {}", names[k], WATCHED_ORDERS[order]),
            dash,
            ..signals.of_run(k, |row| row.health.lines[order].amplitude.into())
        };
        [of(0, Dash::Solid), of(1, Dash::Dashed)]
    });
    add("Lines of the spindle in the push", signals.plot("amplitude, N", lines.collect()));
    add(
        &format!("Vibration of the drives, {}", names[worst]),
        signals.plot(
            "RMS of the rate, mrad/s",
            signals.of_joints(worst, |row| {
                JointVector::from_fn(|joint, _| row.health.drives[joint].rate.into())
            }),
        ),
    );
    let added = signals.of_all(|row| row.depth_correction * MILLI);
    add("Controller: depth added by the force loop", signals.plot("depth, mm", added));
    if !compensated.is_empty() {
        let shifts = compensated.iter().flat_map(|k| {
            let of = |direction: &str, dash, axis: usize| PlotLine {
                name: format!("{}, {direction}", names[*k]),
                dash,
                ..signals.of_run(*k, |row| row.correction_w.linear[axis] * MILLI)
            };
            [of("lateral", Dash::Solid, 1), of("longitudinal", Dash::Dashed, 0)]
        });
        add("Compensation: shift of the set-point", signals.plot("shift, mm", shifts.collect()));
        let turned = |row: &RecordRow| row.correction_w.angular.norm() * MILLI;
        let turns = compensated.iter().map(|k| signals.of_run(*k, turned)).collect();
        add("Compensation: turn of the set-point", signals.plot("turn, mrad", turns));
    }
    figures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::assert_self_contained;
    use crate::sample;

    fn report<'a>(runs: &'a [WeldRun<'a>]) -> WeldReport<'a> {
        WeldReport { runs, from_log: None, exaggeration: 50.0, provenance: sample::provenance() }
    }

    #[test]
    fn text_and_page_say_by_how_much_and_whether_that_is_allowed() {
        let welds = sample::welds(20_000);
        let runs = welds.runs();
        let (text, page) = (report(&runs).text(), report(&runs).page());
        assert_self_contained(&page);
        for (figures, verdict) in welds.figures.iter().zip(["exceeded", "yes"]) {
            let max = figures.lateral.max_abs * 1e3;
            for said in [
                format!("{max:.3}"),
                format!("{max:.2} of ±2.50 mm: {verdict}"),
                format!("{:.3} kN", figures.force.mean / 1e3),
                format!("{:.3}", figures.tilt.rms.to_degrees()),
            ] {
                assert!(text.contains(&said) && page.contains(&said), "{said}: {text}");
            }
        }
        assert_eq!(page.matches("<svg").count(), 14);
        assert_eq!(page.matches("application/json").count(), 14 + 1);
    }

    #[test]
    fn equal_runs_give_equal_pages_whatever_time_they_took() {
        let mut welds = sample::welds(200);
        let before = report(&welds.runs()).page();
        welds.recordings[0].wall *= 3.0;
        assert_eq!(report(&welds.runs()).page(), before);
        assert!(report(&welds.runs()).text().contains("× real time"));
    }

    #[test]
    fn a_single_uncompensated_weld_has_no_plots_of_a_correction() {
        let welds = sample::welds(100);
        let page = report(&welds.runs()[..1]).page();
        assert!(!page.contains("Compensation: ") && !page.contains("compensation, enlarged"));
    }
}
