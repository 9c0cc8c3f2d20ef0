//! What is said of a certification.

use super::requirement::{label, place_of, reason, shown};
use super::{Scale, condensed, counted, digits, fixed, listed, score, share};
use crate::CertifyReport;
use trueweld_estimate::residuals::compare::NOISE_FLOOR_SCORE;
use trueweld_evaluate::WELD_PHASES;
use trueweld_evaluate::certify::{
    AcceptedFault, CertifiedWeld, Evidence, EvidenceKind, FaultTrial, Reason, Requirement,
    SampledCell, Sensitivity, ShownKind, Trend, Trial, Verdict, WeakPoint, WeldPlan,
};
use trueweld_evaluate::{Distribution, UncertainCell};

/// The verdict in a sentence.
pub(crate) fn headline(report: &CertifyReport) -> String {
    let verdict = match report.certificate.verdict() {
        Verdict::Pass => "meets its requirements",
        Verdict::NotShown => not_shown(report),
        Verdict::Fail => "does not meet its requirements",
    };
    let cell = match report.certificate.uncertain.is_one_cell() {
        true => ", of one cell alone: they leave nothing of it uncertain".to_owned(),
        false => format!(
            ", with {} drawn and {} taken as known",
            counted(drawn(&report.certificate.uncertain), "uncertain number"),
            report.certificate.uncertain.left_out().len()
        ),
    };
    format!("The law {} {verdict}{cell}", report.certificate.law)
}

/// Why nothing is decided.
fn not_shown(report: &CertifyReport) -> &'static str {
    let open = || {
        let all = report.certificate.welds.iter().flat_map(|weld| &weld.requirements);
        all.filter(|r| r.verdict == Verdict::NotShown).filter_map(|r| r.reason.as_ref())
    };
    if open().any(|reason| matches!(reason, Reason::NoRun)) {
        "is not shown to meet its requirements: not all that they ask for was run"
    } else if open().any(|reason| matches!(reason, Reason::Draws { .. })) {
        "is not shown to meet its requirements: a larger share of the drawn cells is beyond a limit than is \
         allowed, and more of them are not expected to help"
    } else {
        "is not shown to meet its requirements: there are too few runs"
    }
}

/// The verdict before the headline: of a pass with what is weak although no requirement forbids it.
pub(crate) fn verdict(report: &CertifyReport) -> String {
    let (word, weak) = (verdict_word(report.certificate.verdict()), weak(report));
    match report.certificate.verdict() {
        Verdict::Pass if !weak.is_empty() => {
            format!("{word}, with {}: {}", counted(weak.len(), "weak point"), weak.join("; "))
        }
        _ => word.to_owned(),
    }
}

/// What is weak although no requirement forbids it, in short: margins below what is customary, and
/// searched cells beyond a limit.
pub(crate) fn weak(report: &CertifyReport) -> Vec<String> {
    let named = report.certificate.welds.len() > 1;
    report.certificate.welds.iter().flat_map(|weld| weak_of_weld(weld, named)).collect()
}

/// The same of one weld, with its name where there are several.
fn weak_of_weld(weld: &CertifiedWeld, named: bool) -> Vec<String> {
    let of = if named { format!(" on weld {}", weld.name) } else { String::new() };
    let margin = |at: &WeakPoint| {
        format!("{} {} of {}{of}", label(at.name), shown(at.name, at.least), at.channel)
    };
    let worst = &weld.evidence.worst;
    let searched = (worst.beyond > 0).then(|| {
        let farthest = match &worst.worst {
            Some(Trial { failed: Some(_), .. }) => "in the worst the weld is not made".to_owned(),
            _ => format!("{} up to {} of its limit", label(worst.name), share(worst.of_limit)),
        };
        format!("{} of {} beyond a limit{of}, {farthest}", worst.beyond, searched(weld))
    });
    weld.weak_points.iter().map(margin).chain(searched).collect()
}

/// How many cells were searched.
fn searched(weld: &CertifiedWeld) -> String {
    counted(weld.evidence.worst.runs.len(), "searched cell")
}

/// How many numbers the draws differ in.
fn drawn(cell: &UncertainCell) -> usize {
    let is_drawn = |of: &Distribution| !matches!(of, Distribution::Fixed { .. });
    let stated = cell.numbers.iter().filter(|number| is_drawn(&number.distribution)).count();
    short_numbers(cell).len() + stated
}

/// How a weld is planned, in a sentence or two.
pub(crate) fn planned(weld: &WeldPlan) -> String {
    let mm = |m: f64| Scale::large("m").quantity(m);
    let kn = |n: f64| format!("{} kN", digits(n * 1e-3, 3));
    let [low, high] = weld.feed.map(|feed| digits(feed * 1e3, 3));
    let feed = if low == high { high } else { format!("{low} to {high}") };
    let turns = weld.spindle * 60.0 / std::f64::consts::TAU;
    // The tool's axis points into the material: away from who looks at it from the spindle.
    let sense = if turns < 0.0 { "counter-clockwise" } else { "clockwise" };
    let lean = match weld.lean.map(f64::to_degrees) {
        [0.0, 0.0] => "square to the surface".to_owned(),
        [lead, tilt] => {
            format!("with {} ° of lead and {} ° of tilt", fixed(lead, 1), fixed(tilt, 1))
        }
    };
    format!(
        "{:.0} mm at {feed} mm/s under a push of {}. Pin of {}, {:.0} rev/min {sense} seen from the spindle, \
         tool {lean} and {} deep at the start. Planned with a drag of {} along the seam and {} across it.",
        weld.length * 1e3,
        kn(weld.push),
        mm(weld.pin),
        turns.abs(),
        mm(weld.depth),
        kn(weld.drag[0]),
        kn(weld.drag[1]),
    )
}

/// A verdict in a cell.
pub(crate) fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "PASS",
        Verdict::NotShown => "NOT SHOWN",
        Verdict::Fail => "FAIL",
    }
}

/// How many requirements are met.
pub(crate) fn lead(report: &CertifyReport) -> String {
    let all = || report.certificate.welds.iter().flat_map(|weld| &weld.requirements);
    let count = |verdict: Verdict| all().filter(|r| r.verdict == verdict).count();
    let of = |count: usize, what: &str| match count {
        0 => String::new(),
        count => format!(", {count} {what}"),
    };
    format!(
        "{} of {} met{}{}.",
        count(Verdict::Pass),
        counted(all().count(), "requirement"),
        of(count(Verdict::Fail), "not met"),
        of(count(Verdict::NotShown), "not shown"),
    )
}

/// Why requirements are not met or not shown, each reason once with the requirements that it is of.
pub(crate) fn reasons(report: &CertifyReport) -> Vec<String> {
    let mut told: Vec<(String, String, Vec<&str>)> = Vec::new();
    let failed = |r: &&Requirement| r.verdict != Verdict::Pass;
    for weld in &report.certificate.welds {
        for r in weld.requirements.iter().filter(failed) {
            let of = format!("{}, {}", weld.name, case_name(r.case));
            let reason = reason(r).unwrap_or_default();
            match told.last_mut().filter(|last| last.0 == of && last.1 == reason) {
                Some(last) => last.2.push(label(r.name)),
                None => told.push((of, reason, vec![label(r.name)])),
            }
        }
    }
    let sentence = |(of, reason, names): (String, String, Vec<&str>)| {
        format!("{of}: {}: {reason}.", names.join("; "))
    };
    told.into_iter().map(sentence).collect()
}

/// How the runs were made.
pub(crate) fn setting(report: &CertifyReport) -> String {
    let [probability, confidence] = report.certificate.asked.map(share);
    let drawn = match report.certificate.uncertain.is_one_cell() {
        true => "Drawn cells differ in the phase of the spindle and in noise alone.",
        false => {
            "Every drawn cell differs from what the law assumes by as much as the requirements say is not known."
        }
    };
    format!(
        "Asked of every weld, whatever the requirements say: that it is the one that was asked for, across and along \
         the seam, in depth, tilt, mean push and mean speed, with no drive at its limit. Asked of drawn cells: no more than {probability} of welds beyond a limit, of each limit and of \
         all together, shown with a confidence of {confidence} (exact binomial bound, for a number of \
         trials that was fixed beforehand). With {} control, pass {} of each run, {}. {drawn}",
        report.certificate.controller,
        report.certificate.passes,
        seed(report)
    )
}

/// The seed of the draws, and who chose it.
fn seed(report: &CertifyReport) -> String {
    let seed = report.certificate.seed;
    match report.seed_given {
        true => format!(
            "draws of the seed {seed}, which was chosen and does not follow from the inputs"
        ),
        false => format!("draws of the seed {seed}, which follows from the inputs"),
    }
}

fn case_name(case: EvidenceKind) -> &'static str {
    match case {
        EvidenceKind::Nominal => "nominal cell",
        EvidenceKind::Draws => "drawn cells",
        EvidenceKind::Rare => "rare failures",
        EvidenceKind::WorstCase => "worst cell found",
        EvidenceKind::Margins => "margins",
        EvidenceKind::Faults => "faults",
    }
}

/// How many runs a section has, and of what.
pub(crate) fn of_case(weld: &CertifiedWeld, case: EvidenceKind) -> String {
    let evidence = &weld.evidence;
    match case {
        EvidenceKind::Nominal => "Nominal cell, one run".to_owned(),
        EvidenceKind::Draws => counted(evidence.trials.len(), "drawn cell"),
        EvidenceKind::Rare => {
            let (runs, levels) = evidence
                .rare
                .as_ref()
                .map_or((0, 0), |rare| (rare.subset.runs, rare.subset.levels.len()));
            format!("Rare failures, {} more at {}", counted(runs, "run"), counted(levels, "level"))
        }
        EvidenceKind::WorstCase => {
            format!("Worst cell found in {}", counted(evidence.worst.runs.len(), "run"))
        }
        EvidenceKind::Margins => {
            format!("Margins of the loop in {}", counted(evidence.margins.len(), "condition"))
        }
        EvidenceKind::Faults => {
            format!("Instruments that fail, {}", counted(evidence.faults.len(), "run"))
        }
    }
}

/// The worst cell found, in a sentence.
pub(crate) fn worst_found(evidence: &Evidence) -> String {
    let worst = &evidence.worst;
    let runs = counted(worst.runs.len(), "run");
    let Some(trial) = &worst.worst else {
        return "No search for the worst cell was made.".to_owned();
    };
    if let Some(why) = &trial.failed {
        return format!("In the worst cell found ({runs} of search) the weld is not made: {why}.");
    }
    let found = match worst.runs.is_empty() {
        true => "No search for the worst cell was made. The worst of the others".to_owned(),
        false => format!("Worst cell found in {runs} of search"),
    };
    let beyond = match (worst.runs.len(), worst.beyond) {
        (0, _) => String::new(),
        (_, 0) => ", none of them beyond a limit".to_owned(),
        (_, n) => format!(", {n} of them beyond a limit"),
    };
    format!(
        "{found}{beyond}: {} {}, {} of its limit. A search shows how bad it can \
         be, not that nothing is worse.",
        label(worst.name),
        shown(worst.name, trial.figure(worst.name)),
        share(worst.of_limit)
    )
}

/// What a cell differs in: stiffness, process gains, ripple, cross-talk, delay.
pub(crate) fn worst_cell(cell: &SampledCell) -> [String; 5] {
    let factors =
        |all: &[f64]| all.iter().map(|factor| format!("{factor:.2}")).collect::<Vec<_>>().join(" ");
    [
        factors(&cell.stiffness),
        factors(&cell.process),
        format!("{:.2}", cell.ripple[0]),
        cell.crosstalk.map(share).join(" "),
        format!("{:.1}", cell.delay),
    ]
}

/// What the short keys of a requirements file draw: names, units and ends. What is known is left
/// out, but for the ripple's phase.
pub(crate) fn short_numbers(cell: &UncertainCell) -> Vec<(String, &'static str, [f64; 2])> {
    let short = &cell.short;
    let half = |half: f64| [-half, half];
    let left = cell.assumed_stiffness.join(", ");
    let (stiffness, process) = match &cell.posterior {
        None => ("stiffness of each joint".to_owned(), ""),
        Some(_) => (format!("stiffness of {left}"), ", but for those measured"),
    };
    let stiffness_half = if left.is_empty() { 0.0 } else { short.stiffness };
    let process = format!(
        "each gain of the process (depth, drag, lateral damping, stiffness and ratio{process})"
    );
    let all = [
        (stiffness.as_str(), "1", half(stiffness_half)),
        (process.as_str(), "1", half(short.process)),
        ("amplitude of the spindle's ripple", "1", half(short.ripple)),
        ("phase of the spindle's ripple", "rad", half(std::f64::consts::PI)),
        ("cross-talk of the force sensor, along x and along y", "N/N", half(short.crosstalk)),
        ("least delay of force sensor and seam sensor together", "periods", short.delay),
    ];
    let drawn = all.into_iter().filter(|(.., ends)| ends[0] < ends[1]);
    drawn.map(|(name, unit, ends)| (name.to_owned(), unit, ends)).collect()
}

/// A distribution in words, in its unit.
pub(crate) fn distribution(of: &Distribution) -> String {
    let [low, high] = of.ends().map(short);
    let ends = format!("from {low} to {high}");
    match *of {
        Distribution::Fixed { value } => format!("{} in every cell", short(value)),
        Distribution::Uniform { .. } | Distribution::LogUniform { .. } => {
            format!("{}, {ends}", of.name())
        }
        Distribution::Triangular { mode, .. } => {
            format!("{}, {ends}, most often {}", of.name(), short(mode))
        }
        Distribution::Normal { mean, sd, .. } => {
            format!("{}, {} ± {}, {ends}", of.name(), short(mean), short(sd))
        }
        Distribution::Lognormal { median, spread, .. } => {
            format!("{}, median {}, spread {}, {ends}", of.name(), short(median), short(spread))
        }
    }
}

/// A number with three digits.
fn short(x: f64) -> String {
    if x == 0.0 || (1e-2..1e5).contains(&x.abs()) {
        let digits = (2.0 - x.abs().max(1e-2).log10().floor()).max(0.0) as usize;
        let text = format!("{x:.digits$}");
        match text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => text,
        }
    } else {
        format!("{x:.2e}")
    }
}

/// What the failures of a requirement follow from, in a sentence or two.
pub(crate) fn sensitivity(of: &Sensitivity) -> String {
    let beyond = match of.beyond {
        0 => format!("{}, which came closest to its limit", label(of.name)),
        beyond => format!("{}, beyond its limit in {beyond} of {}", label(of.name), of.of),
    };
    let Some(first) = of.influences.first() else {
        return format!(
            "{beyond}: no number stands out among those drawn, with {}.",
            counted(of.of, "draw")
        );
    };
    let numbers: Vec<String> =
        of.influences.iter().map(|by| format!("{} ({})", by.number, share(by.share))).collect();
    let best = of.influences.iter().min_by_key(|by| by.beyond_without).unwrap_or(first);
    let without = match of.beyond {
        0 => String::new(),
        beyond if best.beyond_without < beyond => format!(
            " Were {} in the middle of its range in every cell, {} would be beyond.",
            best.number, best.beyond_without
        ),
        _ => " No one of them in the middle of its range would leave fewer beyond.".to_owned(),
    };
    format!(
        "{beyond}: {} of its spread follows from {}.{without}",
        share(of.explained),
        listed(&numbers, "and")
    )
}

/// How a figure follows a number: where it is larger.
pub(crate) fn trend(of: Trend) -> &'static str {
    match of {
        Trend::Grows => "the larger the number",
        Trend::Falls => "the smaller the number",
        Trend::AtEnds => "at either end of its range",
        Trend::InMiddle => "in the middle of its range",
    }
}

/// A margin that is weak and not limited.
pub(crate) fn weak_point(of: &WeakPoint) -> String {
    let [least, customary] = [of.least, of.customary].map(|value| shown(of.name, value));
    format!(
        "{}: {least}, of {}, {}; customary is {customary} at least.",
        label(of.name),
        of.channel,
        place_of(&of.of)
    )
}

/// What a run is in a picture.
pub(crate) fn run_name(of: ShownKind) -> String {
    match of {
        ShownKind::Nominal => "nominal".to_owned(),
        ShownKind::Draw(index, name) => format!("draw {index}, worst: {}", label(name)),
        ShownKind::Search(index) => format!("worst of the search, {index}"),
    }
}

/// What the upper bound of a probability is called.
pub(crate) fn drawn_label(confidence: f64) -> String {
    format!("at most, with {} confidence", share(confidence))
}

/// What the requirements ask nothing of, a sentence each.
pub(crate) fn not_asked(report: &CertifyReport) -> Vec<String> {
    let all = || report.certificate.welds.iter().flat_map(|weld| &weld.requirements);
    let none = |case: EvidenceKind| !all().any(|r| r.case == case);
    let cases = [
        (EvidenceKind::Margins, "No margin of the loop is required, and none was determined."),
        (EvidenceKind::Faults, "No instrument was made to fail."),
        (EvidenceKind::WorstCase, "The worst cell of the search is told; nothing limits it."),
    ];
    let cases = cases.into_iter().filter(|(case, _)| none(*case)).map(|(_, text)| text.to_owned());
    let free: Vec<&str> = WELD_PHASES
        .into_iter()
        .filter(|phase| !all().any(|r| r.name.split_once('.').is_some_and(|(p, _)| p == *phase)))
        .collect();
    let held = report.certificate.welds.iter().flat_map(|weld| &weld.held).map(|limit| {
        format!(
            "{}: the control file allows no more than the limit of {}, so that no weld is beyond it and it shows \
             nothing of the law. Whether a correction stands at that limit is told by what it leaves.",
            label(limit.figure.key),
            shown(limit.figure.key, limit.value)
        )
    });
    // Of several welds under one control file each once.
    let mut held: Vec<String> = held.collect();
    held.dedup();
    let passes = (report.certificate.passes > 1).then(|| {
        let (before, are) = match report.certificate.passes {
            2 => ("Pass 1".to_owned(), "is not certified: it is a part, too"),
            n => (format!("Passes 1 to {}", n - 1), "are not certified: they are parts, too"),
        };
        format!(
            "{before} of each run {are}, and only pass {} is judged.",
            report.certificate.passes
        )
    });
    let phases = (!free.is_empty())
        .then(|| format!("Nothing limits the {} of the weld.", listed(&free, "and the")));
    passes.into_iter().chain(cases).chain(phases).chain(held).collect()
}

/// What is not required of a fault, and what it came to.
pub(crate) fn accepted(of: &AcceptedFault) -> String {
    let came_to = reason(&of.judged).unwrap_or_else(|| {
        let [reached, limit] =
            [of.judged.achieved, of.judged.limit].map(|value| shown(of.judged.name, value));
        format!("{}: {}: {reached}, within {limit} all the same", of.fault, label(of.judged.name))
    });
    format!("{came_to}. Not required: {}.", of.reason)
}

/// When faults were reported: the latest, or of how many.
pub(crate) fn reported(trials: &[&FaultTrial]) -> String {
    let after: Vec<f64> = trials.iter().filter_map(|trial| trial.detected).collect();
    match after.len() {
        0 => "not".to_owned(),
        all if all == trials.len() => {
            format!("after {:.2} s", after.iter().copied().fold(0.0, f64::max))
        }
        some => format!("in {some} of {}", trials.len()),
    }
}

/// What is filled in by hand: what no file knows, and who signs.
pub(crate) const SIGNED_BY: [&str; 10] = [
    "part, and number of the procedure",
    "cell, serial number of the robot",
    "tool: pin and shoulder",
    "material and thickness",
    "sensors: class, last calibration",
    "valid until, or until what changes",
    "name, date",
    "signature",
    "second name, date",
    "second signature",
];

/// What was measured and by which logs, in a sentence; nothing where all is assumed.
pub(crate) fn measured(cell: &UncertainCell) -> Option<String> {
    let of = cell.posterior.as_ref()?;
    let mut text = format!(
        "Measured: {}, jointly, by {} ({}) of the campaign {}; score {} where nothing was fitted, 1.0 is the noise floor.",
        counted(of.numbers.len(), "number"),
        counted(of.logs.len(), "log"),
        of.logs.join(", "),
        of.campaign.get(..12).unwrap_or(&of.campaign),
        score(of.score)
    );
    let mut also = |names: &[String], what: &str| {
        if !names.is_empty() {
            text += &format!(" {what}: {}.", condensed(names));
        }
    };
    also(&of.at_bound, "At the bound of what is possible, where no distribution is normal");
    also(&of.undetermined, "Hardly determined by the logs");
    also(&of.not_measured, "Not measured, and left to what is assumed or stated");
    Some(text)
}

/// That a model does not explain its logs, and what is measured with it is not all; nothing where it
/// does.
pub(crate) fn not_explained(cell: &UncertainCell) -> Option<String> {
    let score = cell.posterior.as_ref()?.score;
    (score > NOISE_FLOOR_SCORE).then(|| {
        format!(
            "The model does not explain its logs: the error is {score:.2} times the noise. What is \
             missing in it is not in the draws."
        )
    })
}

/// What this stands on: simulation, a robot file, and what is taken as known; a sentence each.
pub(crate) fn simulated(report: &CertifyReport) -> Vec<String> {
    let robot = match report.robot_grade.as_str() {
        "" => "The robot file does not say where its numbers come from.".to_owned(),
        grade => format!("The robot file says of its numbers: “{grade}”"),
    };
    let known = match report.certificate.uncertain.left_out().len() {
        0 => "The draws leave nothing out that the library knows.".to_owned(),
        known => format!(
            "Taken as known, and not drawn: {known} effects and numbers (appendix). What of them the real \
             cell has, this certificate does not cover."
        ),
    };
    vec!["Every weld of it is simulated: no real one was made.".to_owned(), robot, known]
}
