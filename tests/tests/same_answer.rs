//! A campaign is given the same answer however it was written down: cut, raw files of two
//! instruments, three reflectors instead of a pose, a tracker that stands elsewhere, an arm whose
//! links are mounted off by tenths of a millimetre.
//!
//! The files are changed here, not by the code under test.

use nalgebra::Vector3;
use std::fs;
use std::path::Path;
use trueweld::MeasuredLogs;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_diagnose::{DiagnosisVerdict, FittedEffect, diagnose};
use trueweld_laboratory::{Protocol, Recipe};
use trueweld_logs::campaign::Campaign;
use trueweld_plant::random::Random;
use trueweld_tests::corpus::in_words;
use trueweld_tests::raw_files::{PoseForm, raw};
use trueweld_tests::{LABORATORY, fixture};

/// The answer to a campaign: its best explanations, none where nothing is missing.
pub(crate) fn answer(folder: &Path) -> Vec<String> {
    let MeasuredLogs { logs, found, problem, .. } = MeasuredLogs::read(folder).expect("a campaign");
    assert!(found.mistakes.is_empty(), "{:?}", found.mistakes);
    let diagnosis = diagnose(&problem, &logs, &|_, _| {}).expect("a diagnosis").diagnosis;
    let words = |effects: &[FittedEffect]| -> Vec<String> {
        effects.iter().map(|fitted| in_words(&fitted.effect)).collect()
    };
    println!("{:?}, besides {:?}", diagnosis.verdict, words(&diagnosis.calibration));
    for candidate in &diagnosis.candidates {
        println!("{:.2} {:?}", candidate.probability, words(&candidate.effects));
    }
    match diagnosis.verdict {
        DiagnosisVerdict::Adequate => Vec::new(),
        DiagnosisVerdict::UnknownEffect => vec!["unknown".to_owned()],
        DiagnosisVerdict::EffectFound => {
            // With what it says that the data do not tell from it.
            let first = &diagnosis.candidates[0];
            let ties = first.indistinguishable.iter().map(|k| &diagnosis.candidates[*k]);
            let all = std::iter::once(first).chain(ties);
            all.map(|candidate| words(&candidate.effects).join(" and ")).collect()
        }
    }
}

/// Names of the logs of a campaign.
pub(crate) fn logs(folder: &Path) -> Vec<String> {
    let logs = Campaign::list(folder).expect("a campaign").logs;
    logs.into_iter().map(|(name, _)| name).collect()
}

/// Copies a campaign, all but its held-out part.
pub(crate) fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder").map(|entry| entry.expect("an entry")) {
        let (path, there) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &there);
        } else {
            fs::copy(&path, &there).expect("a copy");
        }
    }
}

type Rows = Vec<Vec<f64>>;

/// Rewrites the samples of every log: header and rows in, rows out.
pub(crate) fn rewrite(folder: &Path, change: &mut dyn FnMut(&str, &[&str], Rows) -> Rows) {
    for name in logs(folder) {
        let file = folder.join(&name).join("samples.csv");
        let text = fs::read_to_string(&file).expect("samples");
        let mut lines = text.lines();
        let first = lines.next().expect("a header");
        let header: Vec<&str> = first.split(',').collect();
        let row = |line: &str| line.split(',').map(|v| v.parse().unwrap_or(f64::NAN)).collect();
        let rows = change(&name, &header, lines.map(row).collect());
        let mut text = first.to_owned();
        for row in rows {
            let field = |v: &f64| if v.is_finite() { format!("{v:.9}") } else { String::new() };
            text += "\n";
            text += &row.iter().map(field).collect::<Vec<_>>().join(",");
        }
        fs::write(&file, text + "\n").expect("samples");
    }
}

/// Every log but the static one begins somewhere in its first half.
fn cut(folder: &Path) {
    let mut random = Random::new(8, 1);
    rewrite(folder, &mut |name, _, rows| {
        if name.starts_with("static") {
            return rows;
        }
        let from = (random.between(0.1, 0.5) * rows.len() as f64) as usize;
        rows[from..].to_vec()
    });
}

/// Two instruments' files in place of the plain ones; each log's poses in the next of these forms.
fn raw_files(folder: &Path, forms: &[PoseForm]) {
    for (k, name) in logs(folder).iter().enumerate() {
        let log = folder.join(name);
        let files = folder.join("raw");
        raw(&log, &files, forms[k % forms.len()], true);
        fs::remove_file(log.join("samples.csv")).expect("was there");
        for file in ["krc.csv", "tracker.txt", "log.toml"] {
            fs::rename(files.join(file), log.join(file)).expect("written");
        }
    }
}

/// The tracker turned by 130° and moved by 4 m.
fn elsewhere(folder: &Path) {
    let axis = Vector3::new(0.3, -0.5, 0.8).normalize();
    let turn = rotation_from_vector(&(axis * 130_f64.to_radians()));
    let away: Vector3<f64> = Vector3::new(3.0, -2.2, 1.4);
    assert!((away.norm() - 4.0).abs() < 0.1);
    rewrite(folder, &mut |_, header, mut rows| {
        let place = |name: &str| header.iter().position(|h| *h == name);
        for row in &mut rows {
            let position = ["px_m", "py_m", "pz_m"].map(place);
            if let [Some(x), Some(y), Some(z)] = position {
                let moved = turn * Vector3::new(row[x], row[y], row[z]) + away;
                (row[x], row[y], row[z]) = (moved.x, moved.y, moved.z);
            }
            if let [Some(x), Some(y), Some(z)] = ["rx_rad", "ry_rad", "rz_rad"].map(place) {
                let rotation = rotation_from_vector(&Vector3::new(row[x], row[y], row[z]));
                let turned = rotation_vector(&(turn * rotation));
                (row[x], row[y], row[z]) = (turned.x, turned.y, turned.z);
            }
        }
        rows
    });
}

/// A change of a campaign's files.
type Change = fn(&Path);

/// What becomes of the files, by name.
const CHANGES: [(&str, Change); 4] = [
    ("cut", cut),
    ("raw", |folder| raw_files(folder, &[PoseForm::Abc, PoseForm::Quaternion])),
    ("reflectors", |folder| raw_files(folder, &[PoseForm::Reflectors])),
    ("elsewhere", elsewhere),
];

/// What is hidden is in the answer to the clean campaign, and in that to every other. What is left of
/// logs that were cut may show too little of it; then nothing is named in its place.
fn same_answer(clean: &Path, hidden: Option<&str>) {
    let is_right = |answer: &[String]| match hidden {
        Some(hidden) => answer.iter().any(|one| one == hidden),
        None => answer.is_empty(),
    };
    let found = answer(clean);
    assert!(is_right(&found), "clean: {found:?}");
    for (name, change) in CHANGES {
        let folder = tempfile::tempdir().expect("a folder");
        copy(clean, folder.path());
        change(folder.path());
        println!("{name}");
        let found = answer(folder.path());
        let may_be_silent = name == "cut" && found.is_empty();
        assert!(is_right(&found) || may_be_silent, "{name}: {found:?}");
    }
}

/// A short campaign of an arm on a soft base.
pub(crate) fn soft_base(geometry_error: f64) -> (tempfile::TempDir, String) {
    let protocol = Protocol { postures: 6, welds: 0, ..Protocol::short() };
    let hidden = LABORATORY.draw("base-compliance", 1.0, &protocol, 19).expect("drawn");
    let words = in_words(&hidden);
    let recipe = Recipe { protocol, geometry_error, ..Recipe::plain(19) };
    let folder = tempfile::tempdir().expect("a folder");
    LABORATORY.write(&recipe.with_effect(hidden), folder.path()).expect("a campaign");
    (folder, words)
}

#[test]
fn a_campaign_of_other_files_has_the_same_answer() {
    let (folder, hidden) = soft_base(0.0);
    same_answer(folder.path(), Some(&hidden));
}

#[test]
#[ignore = "release checklist"]
fn a_tracker_elsewhere_is_no_finding() {
    let protocol = Protocol { postures: 6, welds: 1, ..Protocol::short() };
    let recipe = Recipe { protocol, ..Recipe::plain(23) };
    let folder = tempfile::tempdir().expect("a folder");
    LABORATORY.write(&recipe, folder.path()).expect("a campaign");
    elsewhere(folder.path());
    assert_eq!(answer(folder.path()), Vec::<String>::new());
}

#[test]
#[ignore = "release checklist"]
fn an_arm_with_links_mounted_off_has_the_same_answer() {
    let (folder, hidden) = soft_base(3e-4);
    let found = answer(folder.path());
    assert!(found.contains(&hidden), "{found:?}");
}

#[test]
#[ignore = "two recorded campaigns, each clean, cut, in raw files, with reflectors and with the tracker elsewhere: ten minutes"]
fn recorded_campaigns_of_other_files_have_the_same_answer() {
    for (name, hidden) in [("backlash", Some("backlash [A5]")), ("nothing-missing", None)] {
        same_answer(&fixture(&format!("campaigns/{name}")), hidden);
    }
}
