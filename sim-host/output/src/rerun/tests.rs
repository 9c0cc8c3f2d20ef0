//! Recordings are read back with Rerun's own decoder.

use super::*;
use crate::{Recorded, StepRun, WeldRun, sample};
use re_chunk::Chunk;
use re_log_encoding::DecoderApp;
use re_log_types::{LogMsg, StoreKind};
use re_sdk_types::archetypes::Scalars;
use std::collections::BTreeMap;
use trueweld_plant::provenance::{EffectRecord, Provenance, SimulationRecord};

/// Rows of every entity of the recording, and the chunks of one of them.
fn read(path: &Path, entity: &str) -> (BTreeMap<String, usize>, Vec<Chunk>, usize) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let (mut rows, mut wanted, mut activations) = (BTreeMap::new(), Vec::new(), 0);
    for message in DecoderApp::decode_lazy(file) {
        match message.unwrap() {
            LogMsg::ArrowMsg(store, message) if store.kind() == StoreKind::Recording => {
                let chunk = Chunk::from_arrow_msg(&message).unwrap();
                let name = chunk.entity_path().to_string();
                *rows.entry(name.clone()).or_default() += chunk.num_rows();
                if name == entity && !chunk.is_static() {
                    wanted.push(chunk);
                }
            }
            LogMsg::BlueprintActivationCommand(_) => activations += 1,
            _ => {}
        }
    }
    (rows, wanted, activations)
}

/// The text of an entity.
fn text(path: &Path, entity: &str) -> String {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let component = TextDocument::descriptor_text().component;
    let chunks = DecoderApp::decode_lazy(file).filter_map(|message| match message.unwrap() {
        LogMsg::ArrowMsg(_, message) => Some(Chunk::from_arrow_msg(&message).unwrap()),
        _ => None,
    });
    let mut of_entity = chunks.filter(|chunk| chunk.entity_path().to_string() == entity);
    let chunk = of_entity.next().expect("a text");
    chunk.iter_slices::<String>(component).flatten().map(|t| t.to_string()).collect()
}

#[test]
fn a_recording_says_what_it_is_of_and_which_limit_was_hit_when() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("weld.rrd");
    let provenance = Provenance {
        effects: vec![EffectRecord {
            id: "backlash".to_owned(),
            at: "A5".to_owned(),
            values: [("half_gap_rad".to_owned(), 2e-4)].into(),
        }],
        simulation: Some(SimulationRecord {
            welds: vec!["vertical".to_owned()],
            controllers: vec!["external".to_owned()],
            laws: vec!["elastostatic".to_owned()],
            stiffness_error: 0.1,
            informed: false,
            spindle_rad_s: 62.8,
            control_period_s: 0.012,
            plant_step_s: 0.001,
            passes: 1,
            noise_seed: 7,
            draws_seed: None,
            force_step_n: None,
            cores: Vec::new(),
        }),
        warnings: vec!["feed_m_s = 0.1 is not plausible".to_owned()],
        ..sample::provenance().clone()
    };
    let mut welds = sample::welds(400);
    welds.recordings[1].rows.iter_mut().for_each(|row| row.limited.torque = false);
    let runs = welds.runs();
    WeldReport { provenance: &provenance, ..welded(&runs) }.record(&path).unwrap();
    let said = text(&path, ORIGIN);
    for part in [
        "trueweld 0.1.0 weld",
        "KR 500",
        "backlash at A5 (half_gap_rad 0.000200)",
        "elastostatic",
        "external",
        "seed of the noise | 7",
        "vertical.toml",
        &provenance.files[0].sha256,
        "is not plausible",
        "no compensation: torque of A2 for ",
        "first at 3.1",
        "elastostatic: never at a limit or faulted",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let steps = sample::steps();
    report(&steps.runs(), sample::STEP_AT).record(&path).unwrap();
    assert!(text(&path, ORIGIN).contains("external: never at a limit"));
    let (comparison, model) = (sample::comparison(), Path::new("model.toml"));
    let compared = CompareReport { model, comparison: &comparison, provenance: &provenance };
    compared.record(&path).unwrap();
    assert!(text(&path, ORIGIN).contains("backlash at A5"));
    let parts = sample::diagnosis(trueweld_diagnose::DiagnosisVerdict::EffectFound);
    parts.diagnosed().record(&path).unwrap();
    assert!(text(&path, ORIGIN).contains("vertical.toml"));
}

fn welded<'a>(runs: &'a [WeldRun<'a>]) -> WeldReport<'a> {
    WeldReport { runs, from_log: None, exaggeration: 50.0, provenance: sample::provenance() }
}

#[test]
fn a_recording_holds_every_signal_of_every_run() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("weld.rrd");
    let welds = sample::welds(12_000);
    welded(&welds.runs()).record(&path).unwrap();
    let (rows, chunks, activations) = read(&path, "/none/deviation/lateral");
    assert_eq!(activations, 1);
    for root in ["none", "elastostatic"] {
        // One static row for the style of every series.
        for signal in [
            "deviation/lateral",
            "deviation/longitudinal",
            "deviation/depth",
            "deviation/tilt",
            "force/real",
            "force/sensed",
            "twist",
            "lateral_by_joint",
            "controller/force_error",
            "controller/push",
            "controller/depth_correction",
            "controller/correction",
            "health/spindle_lines",
            "health/vibration",
            "health/drives",
        ] {
            assert_eq!(rows.get(&format!("/{root}/{signal}")), Some(&12_001), "{root}/{signal}");
        }
        // No push is asked for before the force loop is closed.
        assert!(rows[&format!("/{root}/force/desired")] < 12_001);
        // Six phases, a limit reached and left.
        assert_eq!(rows[&format!("/{root}/events")], 8);
        for link in 1..=6 {
            assert!(rows[&format!("/{root}/cell/real/a{link}")] > 600);
            assert!(rows[&format!("/{root}/cell/encoders/a{link}")] > 600);
        }
    }
    for entity in
        ["/about", ORIGIN, "/cell/plate", "/cell/seam", "/cell/half_pin", "/reference/half_pin"]
    {
        assert!(rows.contains_key(entity), "{entity}");
    }
    assert!(chunks.iter().all(|c| c.num_rows() <= 10_000));
    let component = Scalars::descriptor_scalars().component;
    let lateral: Vec<f64> =
        chunks.iter().flat_map(|c| c.iter_slices::<f64>(component).flatten().copied()).collect();
    let expected: Vec<f64> =
        welds.recordings[0].rows.iter().map(|r| r.deviation_w.linear.y * 1e3).collect();
    assert_eq!(lateral, expected);
    // Only rows on the seam have a position on it.
    let on_path: usize = chunks
        .iter()
        .filter(|c| c.timelines().contains_key(&"path_um".into()))
        .map(Chunk::num_rows)
        .sum();
    assert_eq!(
        on_path,
        welds.recordings[0].rows.iter().filter(|r| crate::path::moving(r.phase)).count()
    );
}

#[test]
fn the_same_runs_give_the_same_bytes() {
    let directory = tempfile::tempdir().unwrap();
    let welds = sample::welds(500);
    let [first, second] = ["a.rrd", "b.rrd"].map(|name| {
        let path = directory.path().join(name);
        welded(&welds.runs()).record(&path).unwrap();
        std::fs::read(path).unwrap()
    });
    assert!(first == second);
}

fn report<'a>(runs: &'a [StepRun<'a>], at: f64) -> StepReport<'a> {
    StepReport { runs, at, height: sample::STEP_HEIGHT, provenance: sample::provenance() }
}

#[test]
fn a_step_recording_holds_every_signal_of_every_controller_and_is_the_same_again() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("step.rrd");
    let steps = sample::steps();
    let runs = steps.runs();
    report(&runs, sample::STEP_AT).record(&path).unwrap();
    let (rows, chunks, activations) = read(&path, "/external/force/real");
    assert_eq!(activations, 1);
    for root in ["parallel", "superposed", "external"] {
        for signal in [
            "force/real",
            "force/desired",
            "controller/force_error",
            "controller/push",
            "twist",
            "torque",
        ] {
            assert_eq!(rows.get(&format!("/{root}/{signal}")), Some(&4001), "{root}/{signal}");
        }
    }
    // Style and two ends of the 5 % band.
    assert_eq!(rows["/reference/band"], 3);
    assert!(rows.contains_key("/about"));
    // Time counts from the step.
    let since: Vec<i64> = chunks
        .iter()
        .flat_map(|c| c.timelines()[&shown::SINCE_STEP.into()].times_raw().to_vec())
        .collect();
    assert_eq!((since[0], since[1000]), (-1_000_000_000, 0));
    let again = directory.path().join("again.rrd");
    report(&runs, sample::STEP_AT).record(&again).unwrap();
    assert!(std::fs::read(&path).unwrap() == std::fs::read(&again).unwrap());
    // Without a run, and with a step before everything, there is no band but still a recording.
    report(&[], sample::STEP_AT).record(&again).unwrap();
    report(&runs, 0.0).record(&again).unwrap();
    assert!(!read(&again, "").0.contains_key("/reference/band"));
}

#[test]
fn a_comparison_holds_the_way_and_the_difference_of_every_column_and_is_the_same_again() {
    let directory = tempfile::tempdir().unwrap();
    let [path, again] = ["a.rrd", "b.rrd"].map(|name| directory.path().join(name));
    let comparison = sample::comparison();
    let (model, provenance) = (Path::new("model.toml"), sample::provenance());
    let compared = CompareReport { model, comparison: &comparison, provenance };
    compared.record(&path).unwrap();
    let (rows, chunks, activations) = read(&path, "/1_free/difference/tcp_position");
    assert_eq!(activations, 1);
    // Names and colours, and a row a sample.
    assert_eq!(rows["/1_free/difference/tcp_position"], 501);
    for entity in ["/about", "/1_free/tool/predicted", "/1_free/tool/measured"] {
        assert!(rows.contains_key(entity), "{entity}");
    }
    let component = Scalars::descriptor_scalars().component;
    let drawn: Vec<f64> =
        chunks.iter().flat_map(|c| c.iter_slices::<f64>(component).flatten().copied()).collect();
    assert_eq!(drawn.len(), 1500);
    // x is off by 0.2 mm from the fiftieth row on.
    assert!((drawn[3 * 60] - 0.2).abs() < 1e-6 && drawn[1].abs() < 1e-9);
    compared.record(&again).unwrap();
    assert!(std::fs::read(&path).unwrap() == std::fs::read(&again).unwrap());
}

#[test]
fn a_diagnosis_holds_three_ways_of_the_tool_and_differences_before_and_after() {
    let directory = tempfile::tempdir().unwrap();
    let [path, again] = ["a.rrd", "b.rrd"].map(|name| directory.path().join(name));
    let parts = sample::diagnosis(trueweld_diagnose::DiagnosisVerdict::EffectFound);
    parts.diagnosed().record(&path).unwrap();
    let (rows, chunks, activations) = read(&path, "/1_free/difference/tcp_position/after");
    assert_eq!(activations, 1);
    for entity in [
        "/about",
        "/verdict",
        "/1_free/tool/predicted",
        "/1_free/tool/measured",
        "/1_free/tool/improved",
    ] {
        assert!(rows.contains_key(entity), "{entity}");
    }
    assert_eq!(rows["/1_free/difference/tcp_position/before"], 501);
    let component = Scalars::descriptor_scalars().component;
    let mut drawn = chunks.iter().flat_map(|c| c.iter_slices::<f64>(component).flatten().copied());
    assert!(drawn.all(|v| v == 0.0));
    parts.diagnosed().record(&again).unwrap();
    assert!(std::fs::read(&path).unwrap() == std::fs::read(&again).unwrap());
}

#[test]
fn a_missing_directory_is_named_and_nothing_is_left() {
    let directory = tempfile::tempdir().unwrap();
    let welds = sample::welds(50);
    let error =
        welded(&welds.runs()).record(&directory.path().join("absent/weld.rrd")).unwrap_err();
    assert!(error.to_string().contains("absent"), "{error}");
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
}

#[test]
fn no_run_at_all_is_a_recording_of_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("weld.rrd");
    welded(&[]).record(&path).unwrap();
    let entities: Vec<String> = read(&path, "").0.into_keys().collect();
    assert_eq!(entities, [ORIGIN]);
}
