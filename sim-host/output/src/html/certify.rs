//! The page of a certification: the verdict and what it hangs on first, then the figures behind it.

use super::page;
use crate::certified::{Certified, CertifiedWeld, runs, spoken, worst_found};
use maud::{Markup, html};
use trueweld_evaluate::WELD_FIGURES;
use trueweld_evaluate::certify::{
    Evidence, EvidenceKind, Requirement, Trial, Verdict, label, shown, within,
};
use trueweld_evaluate::margins::MARGIN_FIGURES;

/// One page that a certifying engineer can read.
pub fn certify_page(certified: &Certified<'_>) -> String {
    let (mark, verdict) = match certified.verdict() {
        Verdict::Pass => ("PASS", "meets its requirements"),
        Verdict::NotShown => ("NOT SHOWN", "is not shown to meet its requirements: too few runs"),
        Verdict::Fail => ("FAIL", "does not meet its requirements"),
    };
    let passes = certified.verdict() == Verdict::Pass;
    let whole = |p: f64| format!("{} %", 100.0 * p);
    let [probability, confidence] = certified.asked;
    let failed = || {
        certified
            .welds
            .iter()
            .flat_map(|w| w.requirements.iter().map(move |r| (w, r)))
            .filter(|(_, r)| r.verdict != Verdict::Pass)
    };
    let unshown = failed().filter(|(_, r)| r.verdict == Verdict::NotShown).count();
    let count = certified.welds.iter().map(|w| w.requirements.len()).sum::<usize>();
    let body = html! {
        h1 { span.verdict.failed[!passes] { (mark) } "The law " (certified.law) " " (verdict) }
        p.lead {
            @match failed().count() {
                0 => { "All " (count) " requirements are met." }
                n => {
                    (n - unshown) " of " (count) " requirements are not met, " (unshown) " are not shown to be met with so few runs."
                }
            }
        }
        (summary(certified))
        @if !passes {
            h2 { "Why it does not pass" }
            ul.reasons {
                @for (of, reason) in reasons(failed()) {
                    li { b { (of) } ": " (reason) "." }
                }
            }
        }
        p.setting {
            "Asked of drawn cells: no more than " (whole(probability)) " of welds beyond a limit, shown with a confidence of "
            (whole(confidence)) " (exact binomial bound). With " (certified.controller) " control, pass " (certified.passes)
            " of each run, seed " (certified.seed) ". Every drawn cell differs from what the law believes in, by as much as the "
            "requirements say is not known."
        }
        @for weld in &certified.welds { (one(weld, probability)) }
        p {
            "Stiffness and gains as shares of the believed ones (gains: depth, feed drag, lateral damping, lateral stiffness, "
            "lateral ratio); delay of force and seam sensor in control periods."
        }
        h2 { "What went in" }
        table {
            thead { tr { th { "" } th { "file" } th { "SHA-256" } } }
            tbody {
                @for file in &certified.provenance.files {
                    tr { th scope="row" { (file.role) } td { (file.file) } td { code { (file.sha256) } } }
                }
            }
        }
        p {
            "Program version " (certified.provenance.version) ". Every run comes out the same again with these inputs and this seed, whatever the "
            "number of runs and threads."
        }
    };
    page("Certification", &body)
}

/// The reasons, each once, and of what they are.
fn reasons<'a>(
    failed: impl Iterator<Item = (&'a CertifiedWeld, &'a Requirement)>,
) -> Vec<(String, &'a str)> {
    let mut said: Vec<(String, &str, Vec<&str>)> = Vec::new();
    for (weld, r) in failed {
        let of = format!("{}, {}", weld.name, title(r.case));
        let reason = r.reason.as_deref().unwrap_or_default();
        match said.last_mut().filter(|last| last.0 == of && last.1 == reason) {
            Some(last) => last.2.push(label(r.name)),
            None => said.push((of, reason, vec![label(r.name)])),
        }
    }
    said.into_iter()
        .map(|(of, reason, names)| (format!("{of}: {}", names.join("; ")), reason))
        .collect()
}

fn title(case: EvidenceKind) -> &'static str {
    match case {
        EvidenceKind::Nominal => "nominal cell",
        EvidenceKind::Draws => "drawn cells",
        EvidenceKind::WorstCase => "worst cell found",
        EvidenceKind::Margins => "margins",
        EvidenceKind::Faults => "faults",
    }
}

const CASES: [EvidenceKind; 5] = [
    EvidenceKind::Nominal,
    EvidenceKind::Draws,
    EvidenceKind::WorstCase,
    EvidenceKind::Margins,
    EvidenceKind::Faults,
];

/// Section by section, how many requirements are met.
fn summary(certified: &Certified<'_>) -> Markup {
    html! {
        table {
            thead { tr { th { "weld" } @for case in CASES { th { (title(case)) } } } }
            tbody {
                @for weld in &certified.welds {
                    tr {
                        th scope="row" { (weld.name) }
                        @for case in CASES {
                            @let of: Vec<&Requirement> = weld.requirements.iter().filter(|r| r.case == case).collect();
                            @let met = of.iter().filter(|r| r.verdict == Verdict::Pass).count();
                            @if of.is_empty() {
                                td.aside { "nothing required" }
                            } @else {
                                td.bad[met < of.len()] {
                                    (spoken(Verdict::of(of.iter().copied()))) ", " (met) " of " (of.len()) " met"
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn one(weld: &CertifiedWeld, probability: f64) -> Markup {
    let evidence = &weld.evidence;
    html! {
        h2 { "Weld " (weld.name) }
        h3 { "Steady part: " (runs(weld, EvidenceKind::Nominal)) "; " (runs(weld, EvidenceKind::Draws)) "; " (runs(weld, EvidenceKind::WorstCase)) }
        (steady(weld, probability))
        p {
            (worst_found(evidence)) ". A search shows how bad it may come, not that nothing is worse"
            @if !weld.requirements.iter().any(|r| r.case == EvidenceKind::WorstCase) { "; nothing is required of it here" }
            "."
        }
        @if !evidence.margins.is_empty() {
            h3 { "Margins of the sampled loop along the weld, the nominal cell" }
            (margins(weld))
            p {
                "The cell linear about the working tool, without ripple; instruments, controller and law as they run. Least of all "
                "channels: of the corrections and the force loop, and of the drives. Red: below the limit."
            }
        }
        @if !evidence.faults.is_empty() {
            h3 { "Faults of instruments, one at a time, in the nominal cell" }
            (faults(weld))
            p {
                "Largest correction of the whole run; deviations from the beginning of the fault to the time by which the tool must be "
                "over it; then the steady part again. Red: beyond the limit."
            }
        }
        h3 { "The worst cells" }
        (worst_cells(weld))
    }
}

fn steady(weld: &CertifiedWeld, probability: f64) -> Markup {
    let evidence = &weld.evidence;
    let judged = |case: EvidenceKind, name: &str| {
        weld.requirements.iter().find(|r| r.case == case && r.name == name)
    };
    let failed = |case, name| judged(case, name).is_some_and(|r| r.verdict != Verdict::Pass);
    // With a limit of its own the worst of every figure counts; else the cell that is worst as a
    // whole is shown.
    let rows = || {
        WELD_FIGURES.iter().map(|of| of.figure.key).filter(|name| {
            judged(EvidenceKind::Nominal, name).is_some()
                || judged(EvidenceKind::WorstCase, name).is_some()
        })
    };
    html! {
        table {
            thead { tr {
                th { "requirement" } th { "limit" } th { "nominal cell" }
                th { "reached by " (format!("{:.0} %", 100.0 * (1.0 - probability))) " of draws" }
                th { "draws beyond" } th { "probability at most" } th { "worst draw" } th { "worst found" } th { "" }
            } }
            tbody {
                @for name in rows() {
                    @let drawn = judged(EvidenceKind::Draws, name);
                    @let all_met = CASES.iter().all(|case| !failed(*case, name) || matches!(case, EvidenceKind::Margins | EvidenceKind::Faults));
                    @let limits = [EvidenceKind::Nominal, EvidenceKind::WorstCase].map(|case| judged(case, name).map(|r| r.limit));
                    tr {
                        th scope="row" { (label(name)) }
                        td {
                            @if let Some(limit) = limits[0] { (shown(name, limit)) }
                            @if let Some(limit) = limits[1].filter(|l| limits[0] != Some(*l)) {
                                @if limits[0].is_some() { br; }
                                span.aside { "worst " (shown(name, limit)) }
                            }
                        }
                        td.bad[failed(EvidenceKind::Nominal, name)] { (shown(name, evidence.nominal.figure(name))) }
                        @match drawn.and_then(|r| Some((r, r.draws?))) {
                            Some((r, counted)) => {
                                td.bad[r.verdict != Verdict::Pass] { (shown(name, r.achieved)) }
                                td.bad[r.verdict != Verdict::Pass] { (counted.beyond) }
                                td.bad[r.verdict != Verdict::Pass] { (format!("{:.2} %", 100.0 * counted.failure_probability)) }
                            }
                            None => { td {} td {} td {} }
                        }
                        td.aside { (shown(name, largest(&evidence.trials, name))) }
                        td.aside.bad[failed(EvidenceKind::WorstCase, name)] { (shown(name, found(evidence, name))) }
                        td.bad[!all_met] { (if all_met { "pass" } else { "fail" }) }
                    }
                }
            }
        }
    }
}

/// The largest of a figure in all runs; infinite where there are none.
fn largest(trials: &[Trial], key: &str) -> f64 {
    trials.iter().map(|t| t.figure(key)).reduce(f64::max).unwrap_or(f64::INFINITY)
}

/// The largest of a figure that draws or search came to.
fn found(evidence: &Evidence, key: &str) -> f64 {
    let all = evidence.trials.iter().chain(&evidence.worst.runs);
    all.map(|t| t.figure(key)).reduce(f64::max).unwrap_or(f64::INFINITY)
}

fn margins(weld: &CertifiedWeld) -> Markup {
    let limit = |name: &str| {
        weld.requirements
            .iter()
            .find(|r| r.case == EvidenceKind::Margins && r.name == name)
            .map(|r| r.limit)
    };
    html! {
        table.close {
            thead {
                tr { th { "path" } th { "spectral radius" } @for of in &MARGIN_FIGURES { th { (of.figure.label) } } }
                tr.units { th { "limit" } th { "1" } @for of in &MARGIN_FIGURES { th { @if let Some(l) = limit(of.figure.key) { (shown(of.figure.key, l)) } } } }
            }
            tbody {
                @for at in &weld.evidence.margins {
                    tr {
                        th scope="row" { (format!("{:.2} m", at.path)) }
                        td.bad[at.channels.is_none()] { (if at.held { "at a limit".to_owned() } else { format!("{:.4}", at.spectral_radius) }) }
                        @for of in &MARGIN_FIGURES {
                            @let name = of.figure.key;
                            @let least = (of.value)(at).0;
                            td.bad[limit(name).is_some_and(|l| least < l)] {
                                (if least.is_infinite() { "any".to_owned() } else { shown(name, least) })
                            }
                        }
                    }
                }
            }
        }
    }
}

fn faults(weld: &CertifiedWeld) -> Markup {
    let asked = weld.requirements.iter().filter(|r| r.case == EvidenceKind::Faults);
    let columns: Vec<(&str, f64)> = asked.map(|r| (r.name, r.limit)).collect();
    html! {
        table.close {
            thead {
                tr { th { "fault" } @for (name, _) in &columns { th { (label(name)) } } th { "" } }
                tr.units { th { "limit" } @for (name, limit) in &columns { th { (shown(name, *limit)) } } th {} }
            }
            tbody {
                @for trial in &weld.evidence.faults {
                    @let met = columns.iter().all(|(name, limit)| within(trial.figure(name), *limit));
                    tr {
                        th scope="row" { (trial.fault) }
                        @for (name, limit) in &columns {
                            td.bad[!within(trial.figure(name), *limit)] { (shown(name, trial.figure(name))) }
                        }
                        td.bad[!met] { (if met { "pass" } else { "fail" }) }
                    }
                }
            }
        }
    }
}

/// The cells behind the worst figures: of the draws by requirement, and the one that the search
/// found.
fn worst_cells(weld: &CertifiedWeld) -> Markup {
    let evidence = &weld.evidence;
    let mut cells: Vec<(&str, String, &Trial)> = Vec::new();
    for name in WELD_FIGURES.iter().map(|of| of.figure.key) {
        let required =
            weld.requirements.iter().any(|r| r.case == EvidenceKind::Draws && r.name == name);
        let worst = evidence
            .trials
            .iter()
            .reduce(|a, b| if b.figure(name) > a.figure(name) { b } else { a });
        if let Some(trial) = worst.filter(|_| required) {
            cells.push((name, format!("draw {}", trial.index), trial));
        }
    }
    if let Some(trial) = &evidence.worst.worst {
        let drawn = evidence.trials.contains(trial);
        cells.push((
            evidence.worst.name,
            format!("{} {}", if drawn { "draw" } else { "search" }, trial.index),
            trial,
        ));
    }
    html! {
        table.close {
            thead { tr {
                th { "requirement" } th { "run" } th { "figure" } th { "stiffness A1…A6" } th { "process gains" }
                th { "ripple" } th { "cross-talk" } th { "delay" }
            } }
            tbody {
                @for (name, run, t) in &cells {
                    tr {
                        th scope="row" { (label(name)) }
                        td { (run) }
                        td { (t.failed.clone().unwrap_or_else(|| shown(name, t.figure(name)))) }
                        td { (t.draw.stiffness.map(|k| format!("{k:.2}")).join(" ")) }
                        td { (t.draw.process.map(|k| format!("{k:.2}")).join(" ")) }
                        td { (format!("{:.2}", t.draw.ripple[0])) }
                        td { (t.draw.crosstalk.map(|c| format!("{:.1} %", 100.0 * c)).join(" ")) }
                        td { (format!("{:.1}", t.draw.delay)) }
                    }
                }
            }
        }
    }
}
