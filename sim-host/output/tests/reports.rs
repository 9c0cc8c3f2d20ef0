//! What every report says on a terminal, word for word, and that its file is valid by its published
//! schema.

use crate::sample;
use serde_json::Value;
use std::path::PathBuf;
use trueweld_diagnose::DiagnosisVerdict;
use trueweld_evaluate::certify::{self, WeakPoint};
use trueweld_output::{
    CompareReport, ImproveReport, LawsReport, Report, StepReport, WeldReport, schemas,
};
use trueweld_plant::effects::Location;
use trueweld_plant::effects::formula::PORTS;

fn published(name: &str) -> PathBuf {
    PathBuf::from(format!("{}/../../docs/schema/{name}.json", env!("CARGO_MANIFEST_DIR")))
}

/// The text of a report, whose file is tested by the way.
fn told(report: &impl Report) -> String {
    let text = report.json_text();
    let value: Value = serde_json::from_str(&text).unwrap();
    let name = value["schema"].as_str().unwrap().split('/').next().unwrap();
    let schema: Value =
        serde_json::from_str(&std::fs::read_to_string(published(name)).unwrap()).unwrap();
    jsonschema::validate(&schema, &value).unwrap_or_else(|error| panic!("{name}: {error}"));
    let mut wrong = value.clone();
    wrong["a_key_that_no_one_wrote"] = Value::Null;
    assert!(!jsonschema::is_valid(&schema, &wrong), "{name} takes any key");
    report.text()
}

#[test]
fn the_published_schemas_are_those_that_the_program_prints() {
    let mut files: Vec<String> = std::fs::read_dir(published("x").parent().unwrap())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    let mut names = Vec::new();
    for (name, schema) in schemas() {
        let file = std::fs::read_to_string(published(name)).unwrap_or_default();
        let printed = format!("{:#}\n", schema.as_value());
        assert!(file == printed, "trueweld schema {name} > docs/schema/{name}.json");
        names.push(format!("{name}.json"));
    }
    names.sort();
    assert_eq!(files, names);
}

#[test]
fn weld() {
    let mut welds = sample::welds(400);
    welds.figures[0].limited_rows = 0;
    welds.figures[0].limits.clear();
    let report = WeldReport {
        runs: &welds.runs(),
        from_log: None,
        exaggeration: 50.0,
        provenance: sample::provenance(),
    };
    insta::assert_snapshot!(told(&report));
}

#[test]
fn a_pass_names_what_is_weak_in_its_headline_and_what_it_does_not_certify() {
    let mut report = sample::certificate();
    report.certificate.passes = 2;
    let weld = &mut report.certificate.welds[0];
    for requirement in &mut weld.requirements {
        (requirement.verdict, requirement.reason) = (certify::Verdict::Pass, None);
    }
    let of = weld.evidence.margins[0].of;
    weld.weak_points = vec![WeakPoint {
        name: "drive_gain_margin",
        least: 1.57,
        customary: 2.0,
        of,
        channel: "A2",
    }];
    let said = told(&report);
    let headline = said.split("The law").next().unwrap().split_whitespace().collect::<Vec<_>>();
    let headline = headline.join(" ");
    let expected = "PASS, with 2 weak points: gain margin, drives 1.57 of A2; 1 of 1 searched cell beyond a \
                    limit, lateral, RMS up to 5067 % of its limit.";
    assert_eq!(headline, expected);
    let value = serde_json::to_value(report.json()).unwrap();
    assert_eq!(value["verdict"], "pass");
    assert_eq!(value["weak"].as_array().unwrap().len(), 2);
    let page = report.page();
    assert!(page.contains("Pass 1 of each run is not certified"), "{page}");
    // The control file allows 13 mm, which is all that the requirements limit.
    assert!(page.contains("allows no more than the limit of 13.000 mm"), "{page}");

    report.certificate.welds[0].weak_points.clear();
    report.certificate.welds[0].evidence.worst.beyond = 0;
    assert!(told(&report).starts_with("PASS. "));
}

#[test]
fn step() {
    let mut steps = sample::steps();
    steps.figures[1].settle_5pct_s = None;
    let report = StepReport {
        runs: &steps.runs(),
        at: sample::STEP_AT,
        height: sample::STEP_HEIGHT,
        provenance: sample::provenance(),
    };
    insta::assert_snapshot!(told(&report));
}

#[test]
fn compare() {
    let comparison = sample::comparison();
    let report = CompareReport {
        model: "model.toml".as_ref(),
        comparison: &comparison,
        provenance: sample::provenance(),
    };
    insta::assert_snapshot!(told(&report));
}

#[test]
fn diagnosis_of_one_effect() {
    insta::assert_snapshot!(told(&sample::diagnosis(DiagnosisVerdict::EffectFound).diagnosed()));
}

#[test]
fn diagnosis_of_two_that_the_logs_do_not_separate() {
    let mut parts = sample::diagnosis(DiagnosisVerdict::EffectFound);
    parts.diagnosis.candidates[0].indistinguishable = vec![1];
    parts.explanation.next_experiment = Some(sample::plan());
    insta::assert_snapshot!(told(&parts.diagnosed()));
}

#[test]
fn diagnosis_of_an_unknown_effect() {
    let mut parts = sample::diagnosis(DiagnosisVerdict::UnknownEffect);
    parts.diagnosis.candidates[0].held_out_after = 2.5;
    parts.diagnosis.candidates[0].probability = 0.49;
    insta::assert_snapshot!(told(&parts.diagnosed()));
}

#[test]
fn diagnosis_of_a_faint_effect() {
    let mut parts = sample::diagnosis(DiagnosisVerdict::UnknownEffect);
    parts.diagnosis.candidates[0].probability = 0.76;
    insta::assert_snapshot!(told(&parts.diagnosed()));
}

/// A diagnosis of what laws outside the library explain about as well as its effects, which are so
/// probable.
fn beside_laws(probability: f64) -> String {
    let mut parts = sample::diagnosis(DiagnosisVerdict::UnknownEffect);
    parts.diagnosis.candidates[0].probability = probability;
    parts.diagnosis.candidates[0].indistinguishable = vec![1];
    let port = |name| PORTS.iter().find(|port| port.name == name).expect("a port");
    let at = Location::Joint(4);
    parts.diagnosis.ports_alike = vec![(port("motor-friction"), at), (port("link-torque"), at)];
    parts.explanation.next_experiment = Some(sample::plan());
    told(&parts.diagnosed())
}

#[test]
fn diagnosis_of_what_laws_outside_the_library_explain_about_as_well() {
    insta::assert_snapshot!(beside_laws(0.76));
}

#[test]
fn diagnosis_of_what_laws_outside_the_library_explain_better() {
    let told = beside_laws(0.16);
    let first = told.split_once(" To tell them apart").expect("the experiment follows").0;
    insta::assert_snapshot!(first);
}

#[test]
fn diagnosis_of_nothing() {
    let mut parts = sample::diagnosis(DiagnosisVerdict::Adequate);
    (parts.diagnosis.score_before, parts.diagnosis.held_out_calibrated) = (1.02, 1.02);
    parts.diagnosis.calibration.clear();
    insta::assert_snapshot!(told(&parts.diagnosed()));
}

#[test]
fn diagnosis_of_a_calibration() {
    insta::assert_snapshot!(told(&sample::diagnosis(DiagnosisVerdict::Adequate).diagnosed()));
}

#[test]
fn improvement() {
    let parts = sample::diagnosis(DiagnosisVerdict::EffectFound);
    let improvement = sample::improvement(parts.diagnosis);
    let report = ImproveReport {
        model: &parts.model,
        out: "improved.toml".as_ref(),
        improvement: &improvement,
        posterior: Some(&sample::posterior()),
        before: &parts.before,
        after: &parts.after,
        held_out: [&parts.before, &parts.after],
        reason: parts.explanation.reasons.first(),
        notices: &[],
        provenance: sample::provenance(),
    };
    insta::assert_snapshot!(told(&report));
}

#[test]
fn a_certificate_says_what_is_signed_on_pages_that_hold_it() {
    let page = sample::certificate().page();
    for said in [
        "2000 mm at 10.0 mm/s under a push of 18.0 kN",
        "Pin of 5.00 mm, 600 rev/min counter-clockwise",
        "a drag of 4.00 kN along the seam and 1.00 kN across it",
        "is simulated",
        "research estimate",
        "serial number of the robot",
        "second signature",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // A sheet of paper holds some twelve columns of numbers.
    let cells = |row: &str| {
        ["<th>", "<th ", "<td>", "<td "].map(|cell| row.matches(cell).count()).iter().sum::<usize>()
    };
    let widest = page.split("<tr").map(cells).max();
    assert!(widest <= Some(12), "{widest:?}");
}

#[test]
fn certificate() {
    insta::assert_snapshot!(told(&sample::certificate()));
}

#[test]
fn comparison_of_laws() {
    let laws = sample::laws(&["none", "elastostatic", "learning"]);
    let report = LawsReport {
        comparison: &laws.comparison(),
        sweeps: &laws.sweeps,
        limit: Some(5e-5),
        provenance: sample::provenance(),
    };
    insta::assert_snapshot!(told(&report));
}
