//! A certification as it is told: one JSON value, one page.

use crate::html::page;
use maud::html;
use serde::Serialize;
use serde_json::{Value, json};
use trueweld_evaluate::certify::{Requirement, Trial};
use trueweld_plant::input::LIMITS;

/// What one weld's trials came to.
#[derive(Debug, Clone)]
pub struct CertifiedWeld {
    /// Name of the weld.
    pub name: String,
    /// The cell as it is believed to be.
    pub nominal: Trial,
    /// All trials, in their order.
    pub trials: Vec<Trial>,
    /// The requirements, judged.
    pub requirements: Vec<Requirement>,
}

/// Something that went into a certification, and its SHA-256.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Input {
    /// What it is.
    pub what: String,
    /// SHA-256 of it, hexadecimal.
    pub sha256: String,
}

/// A whole certification.
#[derive(Debug, Clone)]
pub struct Certified {
    /// Name of the law.
    pub law: &'static str,
    /// Name of the controller.
    pub controller: &'static str,
    /// Passes of one trial.
    pub passes: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Share of welds that may fail, and the confidence with which that must be shown.
    pub asked: [f64; 2],
    /// Every weld.
    pub welds: Vec<CertifiedWeld>,
    /// What went in.
    pub inputs: Vec<Input>,
    /// Version of the program.
    pub version: &'static str,
}

impl Certified {
    /// True where every requirement of every weld is met, and there is one.
    pub fn passes(&self) -> bool {
        let all: Vec<&Requirement> = self.welds.iter().flat_map(|w| &w.requirements).collect();
        !all.is_empty() && all.iter().all(|r| r.pass)
    }

    /// The result as one JSON value, schema `certify/1`.
    pub fn json(&self) -> Value {
        let requirements: Vec<Value> = self
            .welds
            .iter()
            .flat_map(|weld| weld.requirements.iter().map(move |r| (weld, r)))
            .map(|(weld, r)| {
                json!({
                    "weld": weld.name, "name": r.name, "limit": r.limit, "achieved": r.achieved, "beyond": r.beyond,
                    "failure_probability": r.failure_probability, "confidence": r.confidence, "pass": r.pass,
                })
            })
            .collect();
        let welds: Vec<Value> = self
            .welds
            .iter()
            .map(|w| json!({ "name": w.name, "trials": w.trials.len(), "nominal": named(&w.nominal), "failed": failed(w) }))
            .collect();
        json!({
            "schema": "certify/1",
            "verdict": if self.passes() { "pass" } else { "fail" },
            "law": self.law,
            "controller": self.controller,
            "passes": self.passes,
            "seed": self.seed,
            "allowed_failure_probability": self.asked[0],
            "confidence": self.asked[1],
            "requirements": requirements,
            "welds": welds,
            "inputs": self.inputs,
            "version": self.version,
        })
    }

    /// One page that a certifying engineer can read.
    pub fn html(&self) -> String {
        let verdict = if self.passes() { "meets its requirements" } else { "does not meet its requirements" };
        let percent = |p: f64| format!("{:.3} %", 100.0 * p);
        let whole = |p: f64| format!("{} %", 100.0 * p);
        let body = html! {
            h1 { "The law " (self.law) " " (verdict) }
            p.setting {
                "Asked: no more than " (whole(self.asked[0])) " of welds beyond a limit, with a confidence of "
                (whole(self.asked[1])) ". With " (self.controller) " control, pass " (self.passes) " of each trial, seed " (self.seed)
                ". Every trial is a cell drawn from the uncertainties; the law believes in the nominal one."
            }
            @for weld in &self.welds {
                h2 { "Weld " (weld.name) ", " (weld.trials.len()) " trials" }
                table {
                    thead { tr {
                        th { "requirement" } th { "limit" } th { "nominal cell" }
                        th { "reached by " (format!("{:.0} %", 100.0 * (1.0 - self.asked[0]))) }
                        th { "worst" } th { "beyond" } th { "probability at most" } th { "" }
                    } }
                    tbody {
                        @for r in &weld.requirements {
                            tr {
                                th scope="row" { (label(r.name)) }
                                td { (shown(r.name, r.limit)) }
                                td { (shown(r.name, figure(&weld.nominal, r.name))) }
                                td { (shown(r.name, r.achieved)) }
                                td { (shown(r.name, worst(weld, r.name).map_or(f64::INFINITY, |t| figure(t, r.name)))) }
                                td { (r.beyond) }
                                td { (percent(r.failure_probability)) }
                                td.bad[!r.pass] { (if r.pass { "pass" } else { "fail" }) }
                            }
                        }
                    }
                }
                h3 { "The worst trials" }
                table {
                    thead { tr {
                        th { "requirement" } th { "trial" } th { "figure" } th { "stiffness A1…A6" } th { "process gains" }
                        th { "cross-talk" } th { "delay" }
                    } }
                    tbody {
                        @for r in &weld.requirements {
                            @if let Some(t) = worst(weld, r.name) {
                                tr {
                                    th scope="row" { (label(r.name)) }
                                    td { (t.index) }
                                    td { (t.failed.clone().unwrap_or_else(|| shown(r.name, figure(t, r.name)))) }
                                    td { (t.draw.stiffness.map(|k| format!("{k:.2}")).join(" ")) }
                                    td { (t.draw.process.map(|k| format!("{k:.2}")).join(" ")) }
                                    td { (t.draw.crosstalk.map(|c| format!("{:.1} %", 100.0 * c)).join(" ")) }
                                    td { (format!("{:.1}", t.draw.delay)) }
                                }
                            }
                        }
                    }
                }
            }
            p {
                "Stiffness and gains as shares of the believed ones (gains: depth, feed drag, lateral damping, lateral stiffness, "
                "lateral ratio); delay of force and seam sensor in control periods."
            }
            h2 { "What went in" }
            table {
                thead { tr { th { "" } th { "SHA-256" } } }
                tbody { @for input in &self.inputs { tr { th scope="row" { (input.what) } td { code { (input.sha256) } } } } }
            }
            p { "Program version " (self.version) ". Trial k of a seed is the same whatever the number of trials and threads." }
        };
        page("Certification", &body)
    }

    /// The verdict and the requirements as text.
    pub fn text(&self) -> String {
        let mut out = String::new();
        for weld in &self.welds {
            out += &format!("{}, {}: {} trials\n", weld.name, self.law, weld.trials.len());
            for r in &weld.requirements {
                out += &format!(
                    "  {:<34} limit {:>10}   reached {:>10}   beyond {:>4}   p ≤ {:>7.3} %   {}\n",
                    label(r.name),
                    shown(r.name, r.limit),
                    shown(r.name, r.achieved),
                    r.beyond,
                    100.0 * r.failure_probability,
                    if r.pass { "pass" } else { "FAIL" }
                );
            }
        }
        out + if self.passes() { "pass\n" } else { "fail\n" }
    }
}

fn figure(trial: &Trial, name: &str) -> f64 {
    let k = LIMITS.iter().position(|l| *l == name);
    k.zip(trial.figures).map_or(f64::INFINITY, |(k, figures)| figures[k])
}

fn worst<'a>(weld: &'a CertifiedWeld, name: &str) -> Option<&'a Trial> {
    weld.trials.iter().max_by(|a, b| figure(a, name).total_cmp(&figure(b, name)))
}

fn named(trial: &Trial) -> Value {
    let figures = trial.figures.map(|f| LIMITS.iter().zip(f).map(|(k, v)| ((*k).to_owned(), json!(v))).collect());
    figures.map_or_else(|| json!({ "failed": trial.failed }), Value::Object)
}

fn failed(weld: &CertifiedWeld) -> Vec<Value> {
    let all = weld.trials.iter().filter_map(|t| Some((t.index, t.failed.as_ref()?)));
    all.map(|(index, why)| json!({ "trial": index, "why": why })).collect()
}

fn label(name: &str) -> &str {
    match name {
        "lateral_rms_m" => "lateral, RMS",
        "lateral_max_m" => "lateral, largest",
        "depth_rms_m" => "depth about its mean, RMS",
        "tilt_rms_rad" => "tilt, RMS",
        "side_tilt_rms_rad" => "tilt across the seam, RMS",
        "travel_angle_rms_rad" => "tilt along the seam, RMS",
        "push_error_rms_n" => "push, RMS of its error",
        "lateral_before_m" => "lateral before the steady part",
        "correction_m" => "correction, translation",
        "correction_rad" => "correction, rotation",
        other => other,
    }
}

fn shown(name: &str, value: f64) -> String {
    match name {
        _ if !value.is_finite() => "none".to_owned(),
        n if n.ends_with("_m") => format!("{:.3} mm", 1e3 * value),
        n if n.ends_with("_rad") => format!("{:.3}°", value.to_degrees()),
        _ => format!("{value:.0} N"),
    }
}
