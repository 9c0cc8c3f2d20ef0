//! A certification as it is told: one JSON value, and text for the terminal.

use serde_json::{Value, json};
use trueweld_evaluate::certify::{
    Evidence, EvidenceKind, Requirement, Trial, Verdict, label, shown,
};
use trueweld_evaluate::margins::{CHANNEL_NAMES, Margins};
use trueweld_plant::provenance::Provenance;

/// What one weld's runs came to.
#[derive(Debug, Clone)]
pub struct CertifiedWeld {
    /// Name of the weld.
    pub name: String,
    /// Every run.
    pub evidence: Evidence,
    /// The requirements, judged.
    pub requirements: Vec<Requirement>,
}

/// A whole certification.
#[derive(Debug, Clone)]
pub struct Certified<'a> {
    /// Name of the law.
    pub law: String,
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
    /// What it is of.
    pub provenance: &'a Provenance,
}

impl Certified<'_> {
    /// Of every requirement of every weld together.
    pub fn verdict(&self) -> Verdict {
        Verdict::of(self.welds.iter().flat_map(|w| &w.requirements))
    }

    /// The result as one JSON value, schema `certify/1`.
    pub fn json(&self) -> Value {
        let requirements: Vec<Value> = self
            .welds
            .iter()
            .flat_map(|weld| weld.requirements.iter().map(|r| of_weld(&weld.name, r)))
            .collect();
        let welds: Vec<Value> = self.welds.iter().map(told).collect();
        json!({
            "schema": "certify/1",
            "verdict": self.verdict(),
            "law": self.law,
            "controller": self.controller,
            "passes": self.passes,
            "seed": self.seed,
            "allowed_failure_probability": self.asked[0],
            "confidence": self.asked[1],
            "requirements": requirements,
            "welds": welds,
        })
    }

    /// The verdict and the requirements as text.
    pub fn text(&self) -> String {
        let mut out = String::new();
        for weld in &self.welds {
            let mut case = None;
            for r in &weld.requirements {
                if case != Some(r.case) {
                    out += &format!("{}, {}: {}\n", weld.name, self.law, runs(weld, r.case));
                    case = Some(r.case);
                }
                let counted = r.draws.map_or(String::new(), |d| {
                    format!("beyond {:>4}   p ≤ {:>7.3} %", d.beyond, 100.0 * d.failure_probability)
                });
                out += &format!(
                    "  {:<36} limit {:>10}   reached {:>10}   {counted:<28} {}\n",
                    label(r.name),
                    shown(r.name, r.limit),
                    shown(r.name, r.achieved),
                    spoken(r.verdict)
                );
                if let Some(reason) = &r.reason {
                    out += &format!("      {reason}\n");
                }
            }
            out += &format!("{}, {}: {}\n", weld.name, self.law, worst_found(&weld.evidence));
        }
        out + spoken(self.verdict()) + "\n"
    }
}

/// How many runs a section has, and of what.
pub(crate) fn runs(weld: &CertifiedWeld, case: EvidenceKind) -> String {
    let evidence = &weld.evidence;
    match case {
        EvidenceKind::Nominal => "the cell as it is believed to be, one run".to_owned(),
        EvidenceKind::Draws => {
            format!("{} cells drawn from what is not known", evidence.trials.len())
        }
        EvidenceKind::WorstCase => {
            format!("the worst cell found in {} runs", evidence.worst.runs.len())
        }
        EvidenceKind::Margins => {
            format!("margins of the loop at {} places along the weld", evidence.margins.len())
        }
        EvidenceKind::Faults => format!("{} faults of instruments", evidence.faults.len()),
    }
}

/// The worst cell found, in a sentence.
pub(crate) fn worst_found(evidence: &Evidence) -> String {
    let worst = &evidence.worst;
    let runs = worst.runs.len();
    let Some(trial) = &worst.worst else {
        return "no search for the worst cell was made".to_owned();
    };
    match &trial.failed {
        Some(why) => {
            format!("in the worst cell found ({runs} runs of search) the weld is not made: {why}")
        }
        None => {
            let share = 100.0 * worst.of_limit;
            let value = shown(worst.name, trial.figure(worst.name));
            format!(
                "worst cell found, {runs} runs of search: {} {value}, {share:.0} % of its limit",
                label(worst.name)
            )
        }
    }
}

fn of_weld(name: &str, requirement: &Requirement) -> Value {
    let mut value = json!(requirement);
    value["weld"] = json!(name);
    value["pass"] = json!(requirement.verdict == Verdict::Pass);
    value
}

/// A verdict in a line of text.
pub(crate) fn spoken(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "pass",
        Verdict::NotShown => "not shown",
        Verdict::Fail => "FAIL",
    }
}

fn told(weld: &CertifiedWeld) -> Value {
    let evidence = &weld.evidence;
    let failed = evidence.trials.iter().filter_map(|t| Some((t.index, t.failed.as_ref()?)));
    let worst = &evidence.worst;
    let faults: Vec<Value> = evidence
        .faults
        .iter()
        .map(|f| {
            json!({
                "fault": f.fault, "from_s": f.time[0], "until_s": f.time[1],
                "figures": f.figures, "failed": f.failed,
            })
        })
        .collect();
    let margins: Vec<Value> = evidence.margins.iter().map(place).collect();
    json!({
        "name": weld.name,
        "trials": evidence.trials.len(),
        "nominal": trial(&evidence.nominal),
        "failed": failed.map(|(index, why)| json!({ "trial": index, "why": why })).collect::<Vec<_>>(),
        "worst_case": {
            "runs": worst.runs.len(),
            "figure": worst.name,
            "of_limit": worst.of_limit,
            "cell": worst.worst.as_ref().map(|t| json!(t.draw)),
            "figures": worst.worst.as_ref().map(trial),
        },
        "margins": margins,
        "faults": faults,
    })
}

/// One place of the margin map; what has no end is null.
fn place(at: &Margins) -> Value {
    let channels = at.channels.map(|channels| {
        let named = CHANNEL_NAMES.iter().zip(channels).map(|(name, m)| {
            let told = json!({ "gain": m.gain, "fall": m.fall, "phase_rad": m.phase, "modulus": m.modulus, "delay_s": m.delay });
            ((*name).to_owned(), told)
        });
        Value::Object(named.collect())
    });
    json!({
        "path_m": at.path, "spectral_radius": at.spectral_radius, "held_at_a_limit": at.held, "channels": channels,
        "disk": at.disk[0], "drive_disk": at.disk[1], "passivity": at.passivity,
    })
}

fn trial(trial: &Trial) -> Value {
    trial
        .figures
        .as_ref()
        .map_or_else(|| json!({ "failed": trial.failed }), |figures| json!(figures))
}
