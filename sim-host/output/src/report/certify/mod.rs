//! What many welds of uncertain cells show of a compensation law.

mod figures;

use super::{PublishedResult, Report};
use crate::CertifyReport;
use crate::document::{Block, Column, Document, Medium, Table, TableCell, Tone, number, words};
use crate::json::certify::{
    CertifyResult, DrawnFigure, MEASURED, UncertainRecord, ValueOfMeasurement,
};
use crate::samples::{self, BlockTable};
use crate::text::certify::{
    SIGNED_BY, accepted, distribution, headline, lead, measured, not_asked, not_explained, of_case,
    planned, reasons, reported, sensitivity, setting, simulated, trend, verdict, verdict_word,
    weak_point, worst_cell, worst_found,
};
use crate::text::requirement::{label, shown};
use crate::text::{condensed, fixed, share};
use trueweld_evaluate::certify::{
    AcceptedFault, CertifiedWeld, DriveUse, EvidenceKind, FaultTrial, Influence, Level,
    Sensitivity, Trial, Verdict, within, worst,
};
use trueweld_evaluate::margins::{LeastMargin, MARGIN_FIGURES, Margins, OperatingPoint};
use trueweld_evaluate::{FigureOf, ReplacedAssumption, UncertainCell, WELD_FIGURES};
use trueweld_plant::provenance::FileDigest;

impl Report for CertifyReport {
    const SCHEMA: &'static str = CertifyResult::SCHEMA;

    fn json(&self) -> impl PublishedResult {
        CertifyResult::of(self).sealed()
    }

    fn samples(&self) -> Option<BlockTable<'_>> {
        Some(samples::of_trials(&self.certificate.welds))
    }

    fn document(&self) -> Document {
        let mut document =
            Document::new("Certification", headline(self), &self.certificate.provenance)
                .judged(verdict(self), self.certificate.verdict() == Verdict::Pass);
        document.push(Block::Lead(lead(self)));
        document.list("Why it does not pass", reasons(self));
        document.push(Block::Note(setting(self)));
        for said in
            [measured(&self.certificate.uncertain), not_explained(&self.certificate.uncertain)]
                .into_iter()
                .flatten()
        {
            document.push(Block::Note(said));
        }
        for weld in &self.certificate.welds {
            let heading = format!("Weld {}", weld.name);
            document.section(Medium::All, &heading, Block::Note(planned(&weld.planned)));
            document.push(Block::Table(requirements_table(weld)));
            document.push(Block::Note(worst_found(&weld.evidence)));
            let weak = weld.weak_points.iter().map(weak_point).collect();
            document.list("Weak, though no limit forbids it", weak);
            let accepted = weld.accepted_faults.iter().map(accepted).collect();
            document.list("Not required of failing instruments", accepted);
            let failures = weld.sensitivities.iter().map(sensitivity).collect();
            let heading = match weld.sensitivities.iter().any(|of| of.beyond > 0) {
                true => "What would most reduce the failures",
                false => "What the figure closest to its limit follows from",
            };
            document.list(heading, failures);
            document.push_on(Medium::Page, Block::Table(influences_table(weld)));
            document.figures(
                "How often a weld is beyond a figure, in drawn cells",
                figures::draws(weld, self.certificate.asked),
            );
            document.figures("How rare a weld beyond any limit is", figures::rare(weld));
            document.push_on(Medium::Page, Block::Table(levels_table(weld)));
            document.figures("The worst runs beside the nominal one", figures::worst_runs(weld));
            document.table(
                "What the measurement brought: drawn cells as assumed, and as measured",
                value_of_measurement(weld),
            );
            document.figures(
                "Margins of the sampled loop along the weld, the least over all slopes of friction",
                figures::margins(weld),
            );
            for (ends, of_drives) in [("corrections and push", false), ("the drives", true)] {
                let heading = format!("Margins of {ends}");
                let table = Block::Table(margins_table(weld, of_drives));
                document.section(Medium::Page, &heading, table);
            }
            document.section(
                Medium::Page,
                "Drives in the steady part, as shares of what each may give",
                Block::Table(drives(weld)),
            );
            document.section(
                Medium::Page,
                "Faults of instruments, one at a time: the worst of all places and cells, in parentheses what is not required",
                Block::Table(faults_table(weld)),
            );
            document.section(
                Medium::Page,
                "The worst cells, as shares of the believed one",
                Block::Table(worst_cells(weld)),
            );
        }
        document.section(
            Medium::Page,
            "What is not known of the cell, and drawn",
            Block::Table(uncertain(self)),
        );
        document.section(
            Medium::Terminal,
            "What is not known of the cell, and drawn",
            Block::List(sources(self)),
        );
        document.table(
            "Assumed in the requirements, and measured: the measurement stands",
            replaced(&self.certificate.uncertain),
        );
        let not_shown = simulated(self).into_iter().chain(not_asked(self)).collect();
        let heading = "What this certificate does not show";
        document.section(Medium::Page, heading, Block::List(not_shown));
        document.section(Medium::Page, "To repeat it", Block::Note(self.repeat.clone()));
        document.push_on(Medium::Page, Block::Table(self.kept_table()));
        document.section(Medium::Page, "Signed", Block::Table(signed()));
        let known = condensed(self.certificate.uncertain.left_out());
        document.section(
            Medium::Page,
            "Appendix: taken as known, and not drawn",
            Block::Note(known),
        );
        document
    }
}

impl CertifyReport {
    /// The files of every run.
    fn kept_table(&self) -> Table {
        let row = |file: &FileDigest| [&file.file, &file.sha256].map(words).to_vec();
        Table {
            head: vec![["runs are kept in", "SHA-256"].map(words).to_vec()],
            rows: self.certificate.files.iter().map(row).collect(),
        }
    }
}

/// Who signs, with room to write.
fn signed() -> Table {
    let rows = SIGNED_BY.iter().map(|what| vec![words(*what), words("\u{2003}".repeat(24))]);
    Table { head: Vec::new(), rows: rows.collect() }
}

/// Every number that the draws differ in.
fn uncertain(report: &CertifyReport) -> Table {
    let columns: [Column<'_, UncertainRecord>; 7] = [
        (words("number"), &|of| words(&of.number)),
        (words("distribution"), &|of| words(distribution(&of.distribution))),
        (words("unit"), &|of| words(if of.relative { "share of the believed" } else { of.unit })),
        (words("together with, correlation"), &|of| match &of.group {
            _ if of.basis == MEASURED => words("all measured ones"),
            None => words(""),
            Some(group) if group.correlation == 1.0 => words(&group.name),
            Some(group) => words(format!("{}, {}", group.name, group.correlation)),
        }),
        (words(""), &|of| words(of.basis)),
        (words("by whom or what"), &|of| words(&of.source)),
        (words("file"), &|of| words(&of.file)),
    ];
    Table::of(UncertainRecord::all(report), &columns)
}

/// The same by who assumed the numbers, or what measured them, in sentences.
fn sources(report: &CertifyReport) -> Vec<String> {
    let mut rows: Vec<([String; 3], Vec<String>)> = Vec::new();
    for of in UncertainRecord::all(report) {
        let key = [of.basis.to_owned(), of.source, of.file];
        match rows.iter_mut().find(|row| row.0 == key) {
            Some(row) => row.1.push(of.number),
            None => rows.push((key, vec![of.number])),
        }
    }
    let sentence = |([basis, source, file], all): ([String; 3], Vec<String>)| {
        let file = if file.is_empty() { file } else { format!(", {file}") };
        format!("{basis} ({source}{file}): {}", condensed(&all))
    };
    rows.into_iter().map(sentence).collect()
}

/// What requirements assume of numbers that were measured.
fn replaced(cell: &UncertainCell) -> Table {
    let row = |of: &ReplacedAssumption| {
        let share = if of.relative { " of the believed" } else { "" };
        let assumed = format!("{}{share}", distribution(&of.distribution));
        [of.number.clone(), assumed, of.source.clone()].map(words).to_vec()
    };
    let head = ["number", "assumed", "by whom"].map(words).to_vec();
    Table { head: vec![head], rows: cell.replaced.iter().map(row).collect() }
}

/// What the trials come to as assumed and as measured.
fn value_of_measurement(weld: &CertifiedWeld) -> Table {
    let probability = |figure: &DrawnFigure| number(share(figure.failure_probability));
    let spread = |name: &str, figure: &DrawnFigure| {
        let [low, high] = figure.spread.map(|v| shown(name, v));
        number(format!("{low} to {high}"))
    };
    let columns: [Column<'_, ValueOfMeasurement>; 5] = [
        (words("probability beyond the limit"), &|of| words(label(of.name))),
        (number("assumed ≤"), &|of| probability(&of.assumed)),
        (number("90 % of draws"), &|of| spread(of.name, &of.assumed)),
        (number("measured ≤"), &|of| probability(&of.measured)),
        (number("90 % of draws"), &|of| spread(of.name, &of.measured)),
    ];
    Table::of(ValueOfMeasurement::all(weld), &columns)
}

/// What each drive gave, in the nominal cell and at most in drawn ones.
fn drives(weld: &CertifiedWeld) -> Table {
    let head = [
        "drive",
        "torque, nominal",
        "speed, nominal",
        "torque, drawn cells",
        "speed, drawn cells",
        "drawn cells at a limit",
        "longest, share of the time",
    ];
    Table {
        head: vec![head.map(number).to_vec()],
        rows: DriveUse::all(&weld.evidence).into_iter().map(drive_row).collect(),
    }
}

fn drive_row(of: DriveUse) -> Vec<TableCell> {
    let DriveUse { drive, nominal, drawn, cells_at_limit } = of;
    let loads = [
        (nominal.torque_share, nominal.at_torque_limit > 0.0),
        (nominal.speed_share, nominal.at_speed_limit > 0.0),
        (drawn.torque_share, drawn.at_torque_limit > 0.0),
        (drawn.speed_share, drawn.at_speed_limit > 0.0),
    ];
    let loads = loads.map(|(load, bad)| number(share(load)).bad(bad));
    let longest = drawn.at_torque_limit.max(drawn.at_speed_limit);
    let cells = number(cells_at_limit.to_string()).bad(cells_at_limit > 0);
    let first = [words(drive)].into_iter();
    first.chain(loads).chain([cells, number(share(longest))]).collect()
}

/// Every requirement with its verdict, by what it is judged by.
fn requirements_table(weld: &CertifiedWeld) -> Table {
    let mut rows = Vec::new();
    let mut case = None;
    for r in &weld.requirements {
        if case != Some(r.case) {
            rows.push(vec![words(of_case(weld, r.case)).tone(Tone::Strong).over(6)]);
            case = Some(r.case);
        }
        let not = r.verdict != Verdict::Pass;
        let of_draws = r.draws.map_or([number(""), number("")], |draws| {
            let probability = match r.case {
                EvidenceKind::Rare => format!("{:.1e}", draws.failure_probability),
                _ => share(draws.failure_probability),
            };
            [number(draws.beyond.to_string()), number(probability)]
        });
        let [beyond, probability] = of_draws.map(|cell| cell.bad(not));
        rows.push(vec![
            words(format!("  {}", label(r.name))),
            number(shown(r.name, r.limit)),
            // A margin without end is met; anything else without end is none.
            number(if r.achieved.is_infinite() && !not {
                "any".to_owned()
            } else {
                shown(r.name, r.achieved)
            })
            .bad(not),
            beyond,
            probability,
            words(verdict_word(r.verdict)).bad(not),
        ]);
    }
    let head = vec![
        words(""),
        number("limit"),
        number("reached"),
        number("beyond"),
        number("probability ≤"),
        words("verdict"),
    ];
    Table { head: vec![head], rows }
}

/// The uncertain numbers that the figures follow from.
fn influences_table(weld: &CertifiedWeld) -> Table {
    let columns: [Column<'_, (&Sensitivity, &Influence)>; 6] = [
        (words("requirement"), &|(of, _)| words(label(of.name))),
        (words("number"), &|(_, by)| words(by.number.clone())),
        (words("the figure is larger"), &|(_, by)| words(trend(by.trend))),
        (number("share of its spread"), &|(_, by)| number(share(by.share))),
        (number("draws beyond"), &|(of, _)| number(of.beyond.to_string())),
        (number("were it always in the middle"), &|(of, by)| match of.beyond {
            0 => number(""),
            _ => number(by.beyond_without.to_string()),
        }),
    ];
    let all = weld.sensitivities.iter();
    Table::of(all.flat_map(|of| of.influences.iter().map(move |by| (of, by))), &columns)
}

/// The levels of the subset simulation.
fn levels_table(weld: &CertifiedWeld) -> Table {
    let mut probability = 1.0;
    let levels = weld.evidence.rare.iter().flat_map(|rare| &rare.subset.levels);
    let levels = levels.map(|level| {
        probability *= level.share;
        (level, probability)
    });
    let columns: [Column<'_, (&Level, f64)>; 6] = [
        (number("from, share of a limit"), &|(level, _)| match level.from.is_finite() {
            true => number(fixed(level.from, 3)),
            false => number("–"),
        }),
        (number("cells"), &|(level, _)| number(level.cells.to_string())),
        (number("beyond the next"), &|(level, _)| number(share(level.share))),
        (number("probability so far"), &|(_, so_far)| number(format!("{so_far:.1e}"))),
        (number("moves accepted"), &|(level, _)| number(share(level.acceptance))),
        (number("variance added by correlation"), &|(level, _)| {
            number(fixed(level.correlation, 1))
        }),
    ];
    Table::of(levels, &columns)
}

/// One row for every operating point and cell, with the least over the slopes of friction. Of
/// corrections and push, or of the drives: all in one row are more than a page is wide.
fn margins_table(weld: &CertifiedWeld, of_drives: bool) -> Table {
    let figures: Vec<_> = MARGIN_FIGURES
        .iter()
        .filter(|of| of.figure.key.starts_with("drive_") == of_drives)
        // Those of the drives at work are the drives' under one of the slopes.
        .filter(|of| !of.figure.key.contains("at_speed"))
        .collect();
    let heads = ["path, push and feed", "cell", "friction", "spectral radius"];
    let names = heads.map(words).into_iter();
    let names = names.chain(figures.iter().map(|of| number(of.figure.label)));
    let limits = figures.iter().map(|of| {
        let limit = weld.limit(EvidenceKind::Margins, of.figure.key);
        number(limit.map_or(String::new(), |limit| shown(of.figure.key, limit)))
    });
    let limits = ["limit", "", "", "1"].map(words).into_iter().chain(limits).collect();
    let same = |a: &Margins, b: &Margins| (a.of.at, a.of.draw) == (b.of.at, b.of.draw);
    let rows = weld.evidence.margins.chunk_by(same);
    let rows = rows.map(|slopes| margins_row(weld, slopes, &figures)).collect();
    Table { head: vec![names.collect(), limits], rows }
}

/// One condition, the least over the slopes of friction.
fn margins_row(
    weld: &CertifiedWeld,
    slopes: &[Margins],
    figures: &[&FigureOf<Margins, LeastMargin>],
) -> Vec<TableCell> {
    let of = slopes[0].of;
    let modulus = figures.iter().find(|of| of.figure.key.ends_with("modulus_margin"));
    let modulus = |at: &Margins| modulus.map_or(0.0, |of| (of.value)(at).0);
    let least = slopes.iter().min_by(|a, b| modulus(a).total_cmp(&modulus(b)));
    let largest = slopes.iter().map(|at| at.spectral_radius).fold(0.0, f64::max);
    let held = slopes.iter().any(|at| at.held_at_a_limit);
    let radius = if held { "at a limit".to_owned() } else { fixed(largest, 4) };
    let OperatingPoint { path, push, feed, .. } = of.at;
    let first = [
        words(format!("{path:.2} m, {:.1} kN, {:.0} mm/s", push / 1e3, feed * 1e3)),
        words(of.draw.map_or("nominal".to_owned(), |index| format!("drawn {index}"))),
        words(least.map_or("", |at| at.of.friction.name())),
        number(radius).bad(slopes.iter().any(|at| at.channels.is_none())),
    ];
    let margins = figures.iter().map(|of| {
        let name = of.figure.key;
        let each = slopes.iter().map(|at| (of.value)(at).0);
        let least = each.fold(f64::INFINITY, f64::min);
        let text = if least.is_infinite() { "any".to_owned() } else { shown(name, least) };
        let limit = weld.limit(EvidenceKind::Margins, name);
        number(text).bad(limit.is_some_and(|limit| least < limit))
    });
    first.into_iter().chain(margins).collect()
}

fn faults_table(weld: &CertifiedWeld) -> Table {
    let limited = weld.requirements.iter().filter(|r| r.case == EvidenceKind::Faults);
    let columns: Vec<(&str, f64)> = limited.map(|r| (r.name, r.limit)).collect();
    let row = |first: [&str; 2], of: &dyn Fn(&(&str, f64)) -> TableCell| -> Vec<TableCell> {
        first.map(words).into_iter().chain(columns.iter().map(of)).collect()
    };
    let head = vec![
        row(["fault", "reported"], &|(name, _)| number(label(name))),
        row(["limit", ""], &|(name, limit)| number(shown(name, *limit))),
    ];
    let mut kinds: Vec<&str> = Vec::new();
    for trial in &weld.evidence.faults {
        if !kinds.contains(&trial.name.as_str()) {
            kinds.push(&trial.name);
        }
    }
    let rows = kinds.into_iter().map(|kind| {
        let is_it = |trial: &&FaultTrial| trial.name == kind;
        let trials: Vec<&FaultTrial> = weld.evidence.faults.iter().filter(is_it).collect();
        let first = [trials[0].fault.as_str(), &reported(&trials)];
        row(first, &|(name, limit)| fault_cell(weld, &trials, name, *limit))
    });
    Table { head, rows: rows.collect() }
}

/// The worst of a figure over the trials of one fault; in brackets where it is not required.
fn fault_cell(weld: &CertifiedWeld, trials: &[&FaultTrial], name: &str, limit: f64) -> TableCell {
    let figure = trials.iter().map(|t| t.figure(name)).fold(0.0, f64::max);
    let fault = &trials[0].name;
    let is_accepted = |of: &AcceptedFault| of.fault == *fault && of.judged.name == name;
    match weld.accepted_faults.iter().any(is_accepted) {
        true => number(format!("({})", shown(name, figure))),
        false => number(shown(name, figure)).bad(!within(figure, limit)),
    }
}

/// The cells behind the worst figures: of the draws by requirement, and the one that the search
/// found.
fn worst_cells(weld: &CertifiedWeld) -> Table {
    let trials = &weld.evidence.trials;
    let mut cells: Vec<(&str, String, &Trial)> = Vec::new();
    for name in WELD_FIGURES.iter().map(|of| of.figure.key) {
        let worst = worst(trials, |t| t.figure(name));
        let required = weld.limit(EvidenceKind::Draws, name).is_some();
        if let Some(trial) = worst.filter(|_| required) {
            cells.push((name, format!("draw {}", trial.index), trial));
        }
    }
    if let Some(trial) = &weld.evidence.worst.worst {
        let run = if trials.contains(trial) { "draw" } else { "search" };
        cells.push((weld.evidence.worst.name, format!("{run} {}", trial.index), trial));
    }
    let rows = cells.into_iter().map(|(name, run, trial)| {
        let figure = trial.failed.clone().unwrap_or_else(|| shown(name, trial.figure(name)));
        let cell = worst_cell(&trial.draw).map(words);
        [words(label(name)), words(run), words(figure)].into_iter().chain(cell).collect()
    });
    let head = [
        "requirement",
        "run",
        "figure",
        "stiffness A1…A6",
        "depth, drag, lateral damping, stiffness, ratio",
        "ripple",
        "cross-talk",
        "delay, periods",
    ];
    Table { head: vec![head.map(words).to_vec()], rows: rows.collect() }
}
