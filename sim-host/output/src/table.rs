//! Tables for a terminal, read in ten seconds: millimetres, degrees, kilonewtons, one column a run.

mod diagnose;

pub use diagnose::{diagnose_table, improve_table};

use crate::WeldRun;
use crate::compared;
use crate::figures::{
    FigureCell, STEP_HEADINGS, headline, run_names, setting, step_headline, step_lines, weld_lines,
};
use std::path::Path;
use trueweld_evaluate::StepFigures;
use trueweld_measure::residuals::compare::Comparison;
use trueweld_measure::residuals::localize::foremost;

/// Width of the first column.
const LABEL: usize = 24;
/// Width of one run: three numbers.
const RUN: usize = 30;
/// Width of the names of logs and channels.
const COMPARED: usize = 28;
/// Width of one of their figures.
const FIGURE: usize = 16;
/// Longest line of text.
const WIDTH: usize = 110;
/// Runs side by side before a second block begins.
const ACROSS: usize = 3;

/// How welds came out: the result in words, then deviations, push, joints' shares and time taken,
/// run by run.
pub fn weld_table(runs: &[WeldRun]) -> String {
    let mut out = wrapped(&headline(runs)) + &wrapped(&setting(runs));
    let names = run_names(runs);
    for (block, names) in runs.chunks(ACROSS).zip(names.chunks(ACROSS)) {
        let mut line = " ".repeat(LABEL);
        for name in names {
            line += &right(name, RUN);
        }
        push_line(&mut out, "");
        push_line(&mut out, &line);
        push_line(
            &mut out,
            &(" ".repeat(LABEL) + &three("mean", "RMS", "|max|").repeat(block.len())),
        );
        for row in weld_lines(block) {
            line = left(&row.label, LABEL);
            for cell in &row.cells {
                line += &match cell {
                    FigureCell::Spread([mean, rms, max]) => three(mean, rms, max),
                    FigureCell::Text { text, .. } => right(text, RUN),
                };
            }
            push_line(&mut out, &line);
        }
    }
    out
}

/// How force steps came out, the published figure below each of ours.
pub fn step_table(controllers: &[StepFigures]) -> String {
    let lines = step_lines(controllers);
    let width = |column: usize| {
        let cells = lines.iter().map(|l| l.cells[column].chars().count());
        cells.chain([STEP_HEADINGS[column].chars().count()]).max().unwrap_or(0) + 3
    };
    let mut out = wrapped(&step_headline(controllers)) + "\n";
    let headings = STEP_HEADINGS.map(str::to_owned);
    for cells in std::iter::once(&headings).chain(lines.iter().map(|l| &l.cells)) {
        let mut line = left(&cells[0], width(0));
        for (column, cell) in cells.iter().enumerate().skip(1) {
            line += &right(cell, width(column));
        }
        push_line(&mut out, &line);
    }
    out
}

/// How far a model is from measurements: the score, every channel of every log, where it is worst
/// in words. `model`: where the model was read from.
pub fn compare_table(model: &Path, comparison: &Comparison) -> String {
    let mut out = wrapped(&compared::headline(comparison))
        + &wrapped(&compared::setting(model, comparison))
        + "\n";
    let row = |first: &str, cells: &[&str]| {
        cells.iter().fold(left(first, COMPARED), |line, cell| line + &right(cell, FIGURE))
    };
    push_line(&mut out, &row(compared::HEADINGS[0], &compared::HEADINGS[1..]));
    for log in &comparison.logs {
        let name = format!("{}, {}", log.name, log.kind);
        push_line(&mut out, &row(&name, &["", "", "", &format!("{:.2}", log.score)]));
        for channel in &log.channels {
            let cells = compared::cells(channel);
            push_line(
                &mut out,
                &row(&format!("  {}", channel.name), &cells.each_ref().map(String::as_str)),
            );
        }
    }
    for finding in foremost(&comparison.worst, compared::TOLD) {
        out += "\n";
        out += &wrapped(&finding.sentence);
    }
    for notice in &comparison.notices {
        out += &wrapped(&format!("Note: {notice}."));
    }
    out
}

/// A sentence in lines that fit beside the tables.
pub(crate) fn wrapped(sentence: &str) -> String {
    let (mut out, mut width) = (String::new(), 0);
    for word in sentence.split(' ') {
        let length = word.chars().count();
        if width > 0 && width + 1 + length > WIDTH {
            out.push('\n');
            width = 0;
        } else if width > 0 {
            out.push(' ');
            width += 1;
        }
        out.push_str(word);
        width += length;
    }
    out + "\n"
}

fn push_line(out: &mut String, line: &str) {
    out.push_str(line.trim_end());
    out.push('\n');
}

fn three(a: &str, b: &str, c: &str) -> String {
    format!("{:>12}{:>9}{:>9}", a, b, c)
}

fn left(text: &str, width: usize) -> String {
    format!("{text:<width$}")
}

fn right(text: &str, width: usize) -> String {
    // A name too long for its column keeps its end, which tells runs apart.
    let length = text.chars().count();
    if length < width {
        format!("{text:>width$}")
    } else {
        let tail: String = text.chars().skip(length + 3 - width).collect();
        format!("  …{tail}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    #[test]
    fn a_weld_table_says_by_how_much_and_whether_that_is_allowed() {
        let welds = sample::welds(400);
        let table = weld_table(&welds.runs());
        println!("{table}");
        let line = |label: &str| table.lines().find(|l| l.starts_with(label)).unwrap().to_owned();
        for (figures, verdict) in welds.figures.iter().zip(["exceeded", "yes"]) {
            let max = format!("{:.3}", figures.lateral.max_abs * 1e3);
            assert!(line("lateral, mm").contains(&max), "{table}");
            let largest = format!("{:.2} of ±2.50 mm: {verdict}", figures.lateral.max_abs * 1e3);
            assert!(line("within half the pin?").contains(&largest), "{table}");
            assert!(
                line("push, mean").contains(&format!("{:.3} kN", figures.force.mean / 1e3)),
                "{table}"
            );
            assert!(
                line("lateral by A1").contains(&format!("{:.0}", 100.0 * figures.joint_share[0])),
                "{table}"
            );
        }
        assert!(line("tilt").contains(&format!("{:.3}", welds.figures[0].tilt.rms.to_degrees())));
        assert!(line("simulated, × real time").contains("207 s in 2.5 s, 83 ×"));
        assert!(table.starts_with("At full feed the tool leaves the seam by up to "));
        assert!(table.lines().all(|l| l.chars().count() <= 120), "{table}");
    }

    #[test]
    fn columns_hold_however_many_runs_there_are() {
        let welds = sample::welds(50);
        let runs = welds.runs();
        let many: Vec<WeldRun> = (0..5).map(|i| runs[i % 2]).collect();
        let table = weld_table(&many);
        assert!(table.lines().all(|l| l.chars().count() <= 120), "{table}");
        assert!(table.contains("#3"), "{table}");
    }

    #[test]
    fn a_step_table_has_the_published_figure_below_ours() {
        let figures = sample::steps().figures;
        let table = step_table(&figures);
        println!("{table}");
        assert!(
            table.starts_with("The push settles within 5 % of the step: parallel in "),
            "{table}"
        );
        let lines: Vec<&str> = table.lines().skip(2).collect();
        assert_eq!(lines.len(), 7);
        for (k, (published, overshoot)) in
            [("370 ms", "24.0 %"), ("580 ms", "20.0 %"), ("860 ms", "4.5 %")].iter().enumerate()
        {
            assert!(lines[1 + 2 * k].starts_with(figures[k].controller));
            assert!(lines[1 + 2 * k].contains(&format!("{:.1} %", 100.0 * figures[k].overshoot)));
            assert!(
                lines[2 + 2 * k].contains(published) && lines[2 + 2 * k].contains(overshoot),
                "{table}"
            );
        }
    }

    #[test]
    fn a_comparison_says_its_score_its_channels_and_where_it_fails() {
        let table = compare_table(Path::new("model.toml"), &sample::comparison());
        println!("{table}");
        assert!(
            table.starts_with("Score 2.72: the model is off by more than the noise"),
            "{table}"
        );
        let line = table.lines().find(|l| l.starts_with("  tcp_position")).unwrap();
        for figure in ["0.0816 mm", "0.200 mm", "0.0300 mm", "2.72"] {
            assert!(line.contains(figure), "{figure} is not in {line}");
        }
        assert!(
            table.contains("62 % of the squared residual goes with the sign of A5's spring torque")
        );
        assert!(table.contains("Note: free: the column"));
        assert!(table.lines().all(|l| l.chars().count() <= 120), "{table}");
    }
}
