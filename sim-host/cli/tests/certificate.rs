//! From what was measured of a cell to a certificate, and from a certificate to the weld that it is
//! of: neither passes for another.

use crate::support::{Workspace, fixture, requirements};
use std::fs;
use std::process::Command;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{Comments, MeasuredNumber, ModelFile, Posterior};
use trueweld_plant::provenance::sha256;

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

/// The certificate of the plain cell.
fn certified(place: &Workspace, more: &[&'static str]) -> String {
    place.done(&[&CERTIFY[..], more, &["--evidence", "plain"]].concat())
}

/// A certificate with its own digest, whatever it says.
fn sealed(text: &str) -> String {
    let (before, seal) = text.rsplit_once("\"sha256\": \"").unwrap();
    let end = seal.split_once('"').unwrap().1;
    let digest = sha256(format!("{before}\"sha256\": \"\"{end}").as_bytes());
    format!("{before}\"sha256\": \"{digest}\"{end}")
}

#[test]
fn evidence_and_certificates_are_of_one_build() {
    let place = workspace();
    certified(&place, &[]);
    let text = String::from_utf8(place.bytes("plain/certify.json")).unwrap();
    assert_eq!(sealed(&text), text);
    let sources = place.json("plain/certify.json")["provenance"]["sources"].clone();
    let sources = sources.as_str().unwrap();
    assert!(place.done(&["--version"]).contains(sources));
    let page = String::from_utf8(place.bytes("plain/certify.html")).unwrap();
    assert!(page.contains(sources));

    let other = sealed(&text.replacen(sources, "abc", 1));
    fs::write(place.path().join("other.json"), other).unwrap();
    let said = place.refused(&[&WELD[..], &["--certificate", "other.json"]].concat());
    let both = format!("made by a build of the sources abc, and this is one of {sources}");
    assert!(said.contains(&both), "{said}");

    let kept = place.path().join("plain/trials-short.jsonl");
    let text = fs::read_to_string(&kept).unwrap();
    fs::write(&kept, text.replacen(sources, "abc", 1)).unwrap();
    let said = place.refused(&[&CERTIFY[..], &["--evidence", "plain"]].concat());
    let both = format!("of the sources abc; this program is built from {sources}");
    assert!(said.contains("runs of another build") && said.contains(&both), "{said}");
}

#[test]
fn the_digest_of_the_sources_is_what_the_documented_command_computes() {
    let root = format!("{}/../..", env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(format!("{root}/docs/certify.md")).unwrap();
    let command = page.lines().find(|line| line.starts_with("find Cargo.lock")).unwrap();
    let output = Command::new("sh").args(["-c", command]).current_dir(root).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let digest = printed.split_whitespace().next().unwrap();
    let version = Workspace::new().done(&["--version"]);
    assert!(version.contains(&format!("(sources {digest})")), "{version} against {digest}");
}

#[test]
fn every_kept_run_is_made_again_where_that_is_asked_for() {
    let place = workspace();
    certified(&place, &[]);
    // Three draws and the nominal cell.
    let said = certified(&place, &["--verify"]);
    assert!(said.contains("4 of 4 kept runs were made again, and came out as"), "{said}");
    let said = certified(&place, &[]);
    assert!(said.contains("2 of 4 kept runs were made again"), "{said}");
    let said = place.refused(&[&CERTIFY[..], &["--verify", "--evidence", "none"]].concat());
    assert!(said.contains("none holds no run"), "{said}");
}

#[test]
fn the_seed_of_the_draws_follows_from_the_inputs_and_one_that_does_not_is_told() {
    let place = workspace();
    let seed = |more: &[&'static str], given: bool| {
        let said = certified(&place, more);
        let result = place.json("plain/certify.json");
        assert_eq!(result["seed_given"], given);
        let page = String::from_utf8(place.bytes("plain/certify.html")).unwrap();
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        for told in [said, page] {
            assert_eq!(told.contains("was chosen and does not follow"), given, "{told}");
        }
        fs::remove_dir_all(place.path().join("plain")).unwrap();
        result["seed"].as_u64().unwrap()
    };
    let first = seed(&[], false);
    assert_eq!(seed(&["--draws", "7"], true), 7);
    // Neither the path of a file, the weld nor the number of runs changes it; a file and an option do.
    place.weld("longer.toml", "[1.700, -1.000, 0.500]", "[1.700, -0.930, 0.500]");
    fs::copy(place.path().join("requirements.toml"), place.path().join("copy.toml")).unwrap();
    let mut other = CERTIFY;
    (other[5], other[7], other[9]) = ("longer.toml", "copy.toml", "4");
    place.done(&[&other[..], &["--evidence", "plain"]].concat());
    assert_eq!(place.json("plain/certify.json")["seed"], first);
    fs::remove_dir_all(place.path().join("plain")).unwrap();
    assert_ne!(seed(&["--stiffness-error", "0.01"], false), first);
    let path = place.path().join("requirements.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text + "# Another one.\n").unwrap();
    assert_ne!(seed(&[], false), first);
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
