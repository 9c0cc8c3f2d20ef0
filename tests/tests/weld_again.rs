//! A recorded weld that is made again: with the force that its model does not explain it deviates as the
//! real one did, under the law that was recorded and under another.

use std::fs;
use std::path::Path;
use trueweld::{CellFiles, FoundInLog, LoggedWeld, SimulatedWelds, WeldingCell, law, simulate};
use trueweld_evaluate::ReplayCheck;
use trueweld_laboratory::WeldLog;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::ModelFile;
use trueweld_plant::simulate::{Phase, Recording};
use trueweld_tests::fixture;

const ROBOT: &str = "robots/kr500-mt.toml";
const PROCESS: &str = "processes/lap-weld-2024-t3.toml";

/// A seam of 0.3 m.
const WELD: &str = "schema = \"weld/1\"\nstart_m = [1.7, -0.6, 0.5]\nend_m = [1.7, -0.3, 0.5]\n\
                    tool_axis = [0.0, 0.0, -1.0]\nfeed_m_s = 0.01\nfeed_ramp_s = 1.0\nforce_n = 18000.0\n\
                    force_ramp_s = 3.0\ninitial_depth_m = 0.0003\nsettle_s = 2.0\n";

/// A force that waves across the seam, and one that grows along it.
fn hidden() -> Vec<Effect> {
    let force = |axis: &str, expression: &str| {
        format!(
            "[[effect]]\nid = \"hidden-{axis}\"\nport = \"process-force-{axis}\"\nexpression = \"a * {expression}\"\n\
             [effect.parameters.a]\nvalue = 600.0\nunit = \"N\"\nlow = -1e4\nhigh = 1e4\nstep = 10.0\n"
        )
    };
    let text = format!(
        "schema = \"model/1\"\nrobot = \"{ROBOT}\"\n{}{}",
        force("y", "(1 - cos(2 * pi * x / 0.15))"),
        force("x", "(1 - cos(pi * x / 0.3))")
    );
    let model = ModelFile::parse(&text, &fixture("model.toml")).expect("a model");
    model.cell_effects()
}

fn cell(folder: &Path, effects: Vec<Effect>) -> WeldingCell {
    let weld = folder.join("weld.toml");
    fs::write(&weld, WELD).expect("a weld file");
    let files = CellFiles::new().robot(fixture(ROBOT)).process(fixture(PROCESS));
    CellFiles { found: FoundInLog { effects, ..FoundInLog::default() }, ..files }
        .weld(weld)
        .expect("a cell")
}

fn welded(cell: &WeldingCell) -> SimulatedWelds {
    let laws = ["none", "elastostatic"].map(|name| law(name).expect("a law"));
    laws.into_iter().fold(simulate(cell), |all, law| all.law(law)).run().expect("welds")
}

/// Root mean square of the difference of the lateral deviations in the steady part, m. What acts in the
/// first centimetres of a log that begins in contact is not told from where the channel behind the tool
/// lay, and decays over some more.
fn apart(a: &Recording, b: &Recording) -> f64 {
    let rows =
        a.rows.iter().zip(&b.rows).filter(|(row, _)| row.phase == Phase::Steady && row.path > 0.06);
    let squares: Vec<f64> =
        rows.map(|(a, b)| (a.deviation_w.linear.y - b.deviation_w.linear.y).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn a_weld_made_again_deviates_as_the_real_one_under_its_law_and_under_another() {
    let folder = tempfile::tempdir().expect("a folder");
    let real = cell(folder.path(), hidden());
    let undisturbed = welded(&cell(folder.path(), Vec::new()));
    let recorded = welded(&real);
    let text = |name: &str| fs::read_to_string(fixture(name)).expect("a fixture");
    let files = WeldLog { robot: &text(ROBOT), process: &text(PROCESS), weld: WELD };
    let campaign = folder.path().join("campaign");
    files
        .write_simulated(&campaign, &recorded.runs[0].recording, &real.cell, real.planned.spindle)
        .expect("a log");
    let log =
        LoggedWeld::read(&campaign.join("weld"), None).expect("a log that can be welded again");
    let again = welded(&log.cell(&CellFiles::new()).expect("a cell"));
    // The tracker's noise comes through the contact as some 20 N. The law takes the deviation away, and
    // leaves that noise.
    for (k, (run, bound)) in again.runs.iter().zip([0.06, 0.3]).enumerate() {
        let [real, without] = [&recorded, &undisturbed].map(|welds| &welds.runs[k].recording);
        let (off, disturbed) = (apart(&run.recording, real), apart(without, real));
        println!("{}: {off:.2e} m of {disturbed:.2e} m", run.recording.compensator);
        assert!(off < bound * disturbed, "{}: {off} of {disturbed}", run.recording.compensator);
    }
    // What a user is told: the tracker's noise of 30 µm, smoothed, is in it as well.
    let check = ReplayCheck::of(&log.rows, &again.runs[0].recording).expect("a steady part");
    let disturbed = apart(&undisturbed.runs[0].recording, &recorded.runs[0].recording);
    assert!(check.apart.rms < 0.1 * disturbed, "{check:?}");
    let taught = |check: &ReplayCheck| check.recorded.encoder.mean - check.replayed.encoder.mean;
    assert!(taught(&check).abs() < 0.02 * check.recorded.bent.rms, "{check:?}");
    assert!((check.recorded.push_n - 18e3).abs() < 100.0, "{check:?}");
    assert!((check.recorded.feed_m_s / check.replayed.feed_m_s - 1.0).abs() < 0.01, "{check:?}");
    assert!(log.feeds.is_empty(), "{:?}", log.feeds);
    // A record of another law: its encoders go elsewhere, by what the law corrects.
    let other = folder.path().join("other");
    files
        .write_simulated(&other, &recorded.runs[1].recording, &real.cell, real.planned.spindle)
        .expect("a log");
    let log = LoggedWeld::read(&other.join("weld"), None).expect("a log that can be welded again");
    let check = ReplayCheck::of(&log.rows, &again.runs[0].recording).expect("a steady part");
    assert!(taught(&check).abs() > 0.8 * check.recorded.bent.rms, "{check:?}");
}
