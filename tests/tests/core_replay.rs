//! A recorded run of a core: the same core repeats it to the last bit, and a changed gain or a changed
//! reading is found in its period.

use std::fs;
use trueweld::{CellFiles, WeldingCell, law, read_core_log, record_core, write_core_log};
use trueweld_compensators::Configuration;
use trueweld_evaluate::{CoreOutput, CoreRun, CoreScalar};
use trueweld_plant::simulate::{ControllerKind, WeldProgram};
use trueweld_tests::fixture;

/// The first 3 cm of a weld.
fn cell(folder: &std::path::Path) -> WeldingCell {
    let weld = folder.join("weld.toml");
    let text = fs::read_to_string(fixture("welds/vertical.toml")).expect("a fixture");
    let line = |line: &str| match line.split(" = ").next() {
        Some("start_m") => "start_m = [1.7, -1.0, 0.5]\n".to_owned(),
        Some("end_m") => "end_m = [1.7, -0.97, 0.5]\n".to_owned(),
        _ => format!("{line}\n"),
    };
    fs::write(&weld, text.lines().map(line).collect::<String>()).expect("a weld file");
    CellFiles::new().weld(weld).expect("a cell")
}

fn recorded(cell: &WeldingCell, name: &str) -> (Configuration, CoreRun) {
    let law = law(name).expect("a law");
    let scenario = cell.scenario(WeldProgram::Weld, ControllerKind::EXTERNAL, &law);
    let configuration = scenario.constants().expect("a core").configuration;
    (configuration, record_core(cell, ControllerKind::EXTERNAL, &law).expect("a run"))
}

#[test]
fn a_simulated_controller_is_its_core_to_the_last_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let cell = cell(folder.path());
    for name in ["none", "elastostatic", "observer", "seam-tracking", "adaptive"] {
        let (core, run) = recorded(&cell, name);
        // Through its files, as a core of a controller would have written them.
        write_core_log(&folder.path().join(name), &run).expect("files");
        let (read, _) = read_core_log(&folder.path().join(name)).expect("a run");
        assert!(read == run, "{name}");
        let replay = read.replay(&core, CoreScalar::Double).expect("a core");
        assert!(replay.first.is_none() && replay.differing == 0, "{name}: {replay:?}");
        assert!(replay.periods > 800, "{}", replay.periods);
    }
}

#[test]
fn a_flipped_bit_of_a_reading_is_found_in_its_period() {
    let folder = tempfile::tempdir().expect("a folder");
    let (core, run) = recorded(&cell(folder.path()), "elastostatic");
    // Encoders and, 18 numbers on, the wrench come after 36 numbers of set-point; the 30th bit of 52 is
    // 2e-7 of a reading.
    for (period, number) in [(5, 36), (123, 38), (400, 40), (700, 59)] {
        let mut changed = run.clone();
        let reading = &mut changed.periods[period].numbers[number];
        *reading = f64::from_bits(reading.to_bits() ^ (1 << 30));
        let replay = changed.replay(&core, CoreScalar::Double).expect("a core");
        let first = replay.first.expect("a difference");
        assert_eq!((first.period, first.output), (period, CoreOutput::Torque), "number {number}");
        assert!((first.time_s - period as f64 * replay.period_s).abs() < 1e-12);
    }
}

#[test]
fn a_changed_gain_is_found_in_the_period_in_which_it_acts() {
    let folder = tempfile::tempdir().expect("a folder");
    let (core, run) = recorded(&cell(folder.path()), "elastostatic");
    let closed = run.periods.iter().position(|period| period.numbers[0] == 1.0);
    let first = |change: &dyn Fn(&mut Configuration)| {
        let mut changed = core;
        change(&mut changed);
        let replay = run.replay(&changed, CoreScalar::Double).expect("a core");
        replay.first.expect("a difference")
    };
    // The force loop acts from the period in which it closes, or the one after.
    let force = first(&|core| core.control.force_ki *= 1.0 + 1e-6).period;
    let closed = closed.expect("a force loop that closes");
    assert!((closed..closed + 2).contains(&force), "{force}, closed in {closed}");
    let joint = first(&|core| core.control.position_kp[1] *= 1.0 + 1e-9);
    assert!(joint.period < 3 && joint.index == 1, "{joint:?}");
}

#[test]
fn a_run_in_single_precision_is_its_own_core_and_no_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let (core, mut run) = recorded(&cell(folder.path()), "elastostatic");
    run.outputs = run.outputs_of(&core, CoreScalar::Float).expect("a core");
    let replay = |scalar| run.replay(&core, scalar).expect("a core");
    assert_eq!(replay(CoreScalar::Float).differing, 0);
    let other = replay(CoreScalar::Double);
    // As far as the two precisions are apart in this weld: 0.3 %.
    assert!(other.differing > 800 && other.torque_share_max < 1e-2, "{other:?}");
}
