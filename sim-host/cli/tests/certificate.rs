//! From what was measured of a cell to a certificate, and from a certificate to the weld that it is
//! of: neither passes for another.

mod support;

use std::fs;
use support::{Workspace, fixture, requirements};
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{Comments, MeasuredNumber, ModelFile, Posterior};

/// What any law keeps to: of 3 draws none beyond shows a half at 75 %, 0.5³ = 0.125.
const CERTIFY: [&str; 12] = [
    "certify",
    "-q",
    "--compensator",
    "seam-tracking",
    "--weld",
    "short.toml",
    "--requirements",
    "requirements.toml",
    "--trials",
    "3",
    "--worst",
    "0",
];

const WELD: [&str; 6] = ["weld", "-q", "--compensator", "seam-tracking", "--weld", "short.toml"];

/// A folder with a model of the default cell whose gap at A5 and stiffness of A2 were measured.
fn workspace() -> Workspace {
    let place = Workspace::new();
    fs::write(place.path().join("requirements.toml"), requirements(0.5, 0.75, 0.0025)).unwrap();
    let robot = fixture("robots/kr500-mt.toml");
    let process = fixture("processes/lap-weld-2024-t3.toml");
    let text = format!(
        "schema = \"model/1\"\nrobot = '{robot}'\nprocess = '{process}'\n\
         [[effect]]\nid = \"backlash\"\nat = \"A5\"\nhalf_gap_rad = 2.4e-4\n\
         [[effect]]\nid = \"stiffness-error\"\nat = \"A2\"\nrelative = 0.1\n"
    );
    let path = place.path().join("improved.toml");
    let model = ModelFile::parse(&text, &path).unwrap();
    let number = |effect: &Effect| MeasuredNumber {
        kind: effect.kind,
        at: effect.at,
        occurrence: 0,
        parameter: 0,
        value: effect.values[0],
        between_logs: 0.0,
    };
    let posterior = Posterior {
        numbers: model.effects.iter().map(|e| number(&e.effect)).collect(),
        covariance: vec![1e-12, 1e-9, 1e-5],
        logs: vec!["static".to_owned(), "free".to_owned()],
        campaign: "00112233445566778899".to_owned(),
        score: 1.0,
        at_bound: Vec::new(),
        undetermined: Vec::new(),
        not_measured: Vec::new(),
        seal: String::new(),
    };
    model.with_posterior(posterior).unwrap().write(&path, &Comments::default()).unwrap();
    place
}

#[test]
fn a_certificate_says_of_every_number_who_measured_or_assumed_it_and_is_of_one_cell() {
    let place = workspace();
    let with = |of: &[&'static str], more: &[&'static str]| [of, more].concat();
    let model = ["--model", "improved.toml"];
    let measured = with(&CERTIFY, &["--model", "improved.toml", "--evidence", "measured"]);
    let said = place.done(&[&measured[..], &["--compare-assumed"]].concat());
    for part in ["measured (logs static, free", "improved.toml", "assumed (", "requirements.toml"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let result = place.json("measured/certify.json");
    // What was certified is what `export-core` writes for the controller.
    let core = &result["provenance"]["simulation"]["cores"][0]["sha256"];
    let export = ["export-core", "--compensator", "seam-tracking", "--weld", "short.toml"];
    let said = place.done(&[&export[..], &model].concat());
    assert!(said.contains(core.as_str().unwrap()), "{core}: {said}");
    let other = place.done(&[&export[..], &model, &["--stiffness-error", "0.01"]].concat());
    assert!(!other.contains(core.as_str().unwrap()), "a controller that believes something else");
    let uncertain = result["uncertain"].as_array().unwrap();
    let of = |number: &str| uncertain.iter().find(|u| u["number"] == number);
    let stiffness = of("stiffness-error at A2: relative").unwrap();
    assert_eq!(stiffness["basis"], "measured");
    assert_eq!(stiffness["file"], "improved.toml");
    assert!((stiffness["distribution"]["sd"].as_f64().unwrap() - 1e-5_f64.sqrt()).abs() < 1e-12);
    let short = of("stiffness of A1, A3, A4, A5, A6").unwrap();
    assert_eq!((&short["basis"], &short["file"]), (&"assumed".into(), &"requirements.toml".into()));
    assert_eq!(result["replaced"][0]["number"], "stiffness of A2");
    assert_eq!(result["measurement"]["campaign_sha256"], "00112233445566778899");
    // The same seeds: what a narrower stiffness of one joint leaves differs, and no more than that.
    let bought = &result["welds"][0]["bought"][0];
    assert_eq!(bought["name"], "lateral_max_m");
    assert_eq!(bought["assumed"]["failure_probability"], bought["measured"]["failure_probability"]);
    assert_ne!(bought["assumed"]["spread"], bought["measured"]["spread"]);

    // A certificate of the plain cell is none of this one, and the other way round.
    place.done(&with(&CERTIFY, &["--evidence", "plain"]));
    let of_plain = ["--certificate", "plain/certify.json"];
    let of_measured = ["--certificate", "measured/certify.json"];
    assert!(place.done(&with(&WELD, &of_plain)).contains("certified: seam-tracking"));
    place.done(&[&WELD[..], &model, &of_measured].concat());
    for arguments in [[&WELD[..], &model, &of_plain].concat(), with(&WELD, &of_measured)] {
        let said = place.refused(&arguments);
        assert!(said.contains("of something else than this run"), "{said}");
    }
    let mut other = [&WELD[..], &of_plain].concat();
    other[3] = "elastostatic";
    assert!(place.refused(&other).contains("laws was"));
}

#[test]
fn what_was_measured_of_another_model_is_refused() {
    let place = workspace();
    let path = place.path().join("improved.toml");
    let text = fs::read_to_string(&path).unwrap();
    assert!(place.done(&["check", "improved.toml"]).contains("in order"));
    fs::write(&path, text.replace("half_gap_rad = 0.00024", "half_gap_rad = 0.00012")).unwrap();
    let said = place.refused(&["check", "improved.toml"]);
    assert!(said.contains("expected the digest of this model"), "{said}");
    let said = place.refused(&[&CERTIFY[..], &["--model", "improved.toml"]].concat());
    assert!(said.contains("measured is of another model"), "{said}");
    let said = place.refused(&[&CERTIFY[..], &["--compare-assumed"]].concat());
    assert!(said.contains("nothing of this cell is measured"), "{said}");
}

#[test]
fn margins_are_of_arms_whose_links_are_not_as_the_controller_has_them() {
    let place = Workspace::new();
    let drawn = "uncertain = [{ effect = \"geometry-error\", at = \"all\", parameter = \"y_m\", \
                 distribution = \"uniform\", low = 4e-4, high = 6e-4, source = \"assumed\" }]\n";
    let margins = "[margins]\nplaces = 2\ndraws = 1\nmodulus_margin = 0.1\n";
    let text = requirements(0.5, 0.75, 0.0025).replace("[limits]", &format!("{drawn}[limits]"));
    fs::write(place.path().join("requirements.toml"), text + margins).unwrap();
    let _ = place.run(&CERTIFY);
    let result = place.json("out/certify/certify.json");
    let margins = result["welds"][0]["margins"].as_array().unwrap();
    let drawn = margins.iter().filter(|at| !at["draw"].is_null());
    assert!(
        drawn.clone().count() > 0 && drawn.clone().all(|at| at["channels"].is_object()),
        "{result}"
    );
}
