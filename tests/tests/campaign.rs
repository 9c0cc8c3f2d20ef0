//! Synthetic campaigns: their form, that a seed gives the same bytes, and that the physics in them
//! is the plant's.

use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use trueweld_core::{JointVector, Wrench};
use trueweld_laboratory::{OutOfLibrary, OutOfLibraryKind, Protocol, Recipe, effect};
use trueweld_plant::effects::{EffectKind, Location, library};
use trueweld_plant::input::{InputFile, Process, RobotFile, Weld};
use trueweld_plant::integrate::rest;
use trueweld_plant::robot::Channel;
use trueweld_tests::cell::free_cell;
use trueweld_tests::{KR500, LABORATORY};

/// One log's columns by name.
type Samples = BTreeMap<String, Vec<f64>>;

fn made(recipe: &Recipe) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    LABORATORY.write(recipe, folder.path()).expect("the campaign is made");
    folder
}

/// Nothing recorded but what is asked for, and the held-out campaign likewise.
fn nothing() -> Protocol {
    Protocol { postures: 0, rings: 0, free: 0.0, welds: 0, ..Protocol::short() }
}

fn samples(log: impl AsRef<Path>) -> Samples {
    let text = std::fs::read_to_string(log.as_ref().join("samples.csv")).expect("the log is there");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let mut samples: Samples = names.iter().map(|n| ((*n).to_owned(), Vec::new())).collect();
    for line in lines {
        let fields: Vec<f64> = line.split(',').map(|f| f.parse().expect("a number")).collect();
        assert_eq!(fields.len(), names.len(), "{line}");
        for (name, value) in names.iter().zip(fields) {
            samples.get_mut(*name).expect("a column").push(value);
        }
    }
    samples
}

fn joints(samples: &Samples, row: usize) -> JointVector<f64> {
    JointVector::from_fn(|i, _| samples[&format!("qe{}_rad", i + 1)][row])
}

fn vector(samples: &Samples, names: [&str; 3], row: usize) -> Vector3<f64> {
    Vector3::from(names.map(|n| samples[n][row]))
}

const POSITION: [&str; 3] = ["px_m", "py_m", "pz_m"];
const FORCE: [&str; 3] = ["fx_n", "fy_n", "fz_n"];
const MOMENT: [&str; 3] = ["mx_nm", "my_nm", "mz_nm"];

/// Every file below a folder with its bytes.
fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()) {
        if entry.is_dir() {
            found.extend(
                bytes(&entry)
                    .into_iter()
                    .map(|(p, b)| (Path::new(entry.file_name().expect("a name")).join(p), b)),
            );
        } else {
            found.insert(
                entry.file_name().expect("a name").into(),
                std::fs::read(&entry).expect("a file"),
            );
        }
    }
    found
}

#[test]
fn a_campaign_has_the_documented_form() {
    let folder = made(&Recipe { protocol: Protocol::short(), ..Recipe::plain(11) });
    let pose = "px_m,py_m,pz_m,rx_rad,ry_rad,rz_rad";
    let motors = "qe1_rad,qe2_rad,qe3_rad,qe4_rad,qe5_rad,qe6_rad";
    let torques = "tm1_nm,tm2_nm,tm3_nm,tm4_nm,tm5_nm,tm6_nm";
    let wrench = "fx_n,fy_n,fz_n,mx_nm,my_nm,mz_nm";
    let links = "ql1_rad,ql2_rad,ql3_rad";
    let expected = [
        ("static", 33, format!("t_s,{motors},{wrench},{pose},payload_kg,cx_m,cy_m,cz_m")),
        ("ring-123456", 601, format!("t_s,{motors},px_m,py_m,pz_m")),
        ("free", 501, format!("t_s,{motors},{links},{torques},{pose}")),
        ("weld-1", 792, format!("t_s,{motors},{wrench},{pose},spindle_rad_s")),
        ("holdout/static-2", 16, format!("t_s,{motors},{wrench},{pose},payload_kg,cx_m,cy_m,cz_m")),
        ("holdout/free-2", 301, format!("t_s,{motors},{links},{torques},{pose}")),
        ("holdout/weld-2", 750, format!("t_s,{motors},{wrench},{pose},spindle_rad_s")),
    ];
    for (log, rows, header) in &expected {
        let folder = folder.path().join(log);
        let text = std::fs::read_to_string(folder.join("samples.csv")).expect("the log is there");
        assert_eq!(text.lines().next(), Some(header.as_str()), "{log}");
        let time = &samples(&folder)["t_s"];
        assert_eq!(time.len(), *rows, "{log}");
        assert!(
            time[0] == 0.0 && time.windows(2).all(|t| t[1] > t[0]),
            "{log}: time runs forwards from 0"
        );
        let about = std::fs::read_to_string(folder.join("log.toml")).expect("the log is described");
        let about: toml::Table = about.parse().expect("TOML");
        assert_eq!(about["schema"].as_str(), Some("log/1"));
        assert!(folder.join(about["robot"].as_str().expect("a path")).exists());
        assert_eq!(about["noise"]["tcp_position_m"].as_float(), Some(30e-6));
        if let Some(weld) = about.get("weld") {
            Weld::read(folder.join(weld.as_str().expect("a path"))).expect("a weld");
            Process::read(folder.join(about["process"].as_str().expect("a path")))
                .expect("a process");
        }
    }
    for (campaign, logs) in [
        (folder.path().to_owned(), &expected[..4]),
        (folder.path().join("holdout"), &expected[4..]),
    ] {
        let text = std::fs::read_to_string(campaign.join("campaign.toml")).expect("a campaign");
        let table: toml::Table = text.parse().expect("TOML");
        let listed: Vec<_> =
            table["logs"].as_array().expect("a list").iter().filter_map(|l| l.as_str()).collect();
        let there: Vec<_> = logs.iter().map(|(l, ..)| l.trim_start_matches("holdout/")).collect();
        assert_eq!(listed, there);
        RobotFile::read(campaign.join("robot.toml")).expect("a robot");
        assert!(campaign.join(table["model"].as_str().expect("a path")).exists());
    }
}

#[test]
fn a_seed_gives_the_same_bytes_and_another_seed_other_ones() {
    let recipe = |seed| {
        let protocol = Protocol { welds: 0, ..Protocol::short() };
        Recipe { protocol, ..Recipe::plain(seed) }.with_nuisance(0.03, 5e-5, 5e-5).with_effect(
            LABORATORY.draw("hysteresis", 1.0, &Protocol::short(), seed).expect("drawn"),
        )
    };
    let (first, again, other) = (made(&recipe(5)), made(&recipe(5)), made(&recipe(6)));
    assert_eq!(bytes(first.path()), bytes(again.path()));
    assert_ne!(
        bytes(first.path())[Path::new("static/samples.csv")],
        bytes(other.path())[Path::new("static/samples.csv")]
    );
}

#[test]
fn static_rows_of_the_baseline_stand_where_the_rest_solver_says() {
    // Without noise but for the last digits written: forces to 0.01 N, positions to 0.1 µm, and
    // angles to 10 nrad, which at 3 m and over six joints are some hundredths of a micrometre.
    let folder = made(&Recipe {
        noise: 1e-6,
        protocol: Protocol { postures: 4, ..nothing() },
        ..Recipe::plain(21)
    });
    let samples = samples(folder.path().join("static"));
    let cell = free_cell(&KR500, None);
    let parameters = KR500.parameters();
    for row in 0..samples["t_s"].len() {
        let motor = joints(&samples, row);
        let (force, moment) = (vector(&samples, FORCE, row), vector(&samples, MOMENT, row));
        let weight = parameters.gravity * samples["payload_kg"][row];
        let center =
            parameters.tool.flange_offset + vector(&samples, ["cx_m", "cy_m", "cz_m"], row);
        let mut link = motor;
        // The load turns with the tool as it bends: by 5 mrad at first, by nanoradians after three
        // rounds.
        for _ in 0..4 {
            let frames = KR500.frames(&link);
            let mut wrench = Wrench { moment, force }.rotated(&frames.tcp.rotation);
            let lever = frames.origin[5] + frames.rotation[5] * center - frames.tcp.position;
            wrench.force += weight;
            wrench.moment += lever.cross(&weight);
            link = rest::under_wrench(&cell, &motor, &wrench).expect("a rest");
        }
        let off =
            (KR500.forward_kinematics(&link).position - vector(&samples, POSITION, row)).norm();
        assert!(off < 3e-7, "row {row}: {off} m");
    }
}

#[test]
fn noise_is_as_stated() {
    let protocol = Protocol { postures: 4, ..nothing() };
    let quiet = made(&Recipe { noise: 1e-6, protocol: protocol.clone(), ..Recipe::plain(22) });
    let loud = made(&Recipe { noise: 2.0, protocol, ..Recipe::plain(22) });
    let [quiet, loud] = [quiet, loud].map(|f| samples(f.path().join("static")));
    for (column, deviation) in [("px_m", 60e-6), ("qe3_rad", 4e-6), ("fy_n", 50.0), ("mz_nm", 16.0)]
    {
        let square: f64 =
            quiet[column].iter().zip(&loud[column]).map(|(a, b)| (a - b) * (a - b)).sum();
        let measured = (square / quiet[column].len() as f64).sqrt() / deviation;
        // 33 rows: the standard error of a standard deviation is 12 %.
        assert!((measured - 1.0).abs() < 0.4, "{column}: {measured} of what is stated");
    }
}

#[test]
fn a_loop_of_load_leaves_a_trace_of_hysteresis_and_of_a_gap_and_of_nothing_else() {
    // The first posture's loop: unloaded rows 0, 4 and 8, after loads to one side and to the other.
    let moved = |recipe: Recipe| {
        let folder = made(&Recipe {
            noise: 1e-6,
            protocol: Protocol { postures: 1, ..nothing() },
            ..recipe
        });
        let samples = samples(folder.path().join("static"));
        let at = |row| vector(&samples, POSITION, row);
        [(at(4) - at(0)).norm(), (at(8) - at(4)).norm()]
    };
    // The position's last digit.
    assert!(moved(Recipe::plain(23)).iter().all(|m| *m < 4e-7));
    let stiff = effect("stiffness-error", Location::Joint(0), &[0.2]);
    assert!(moved(Recipe::plain(23).with_effect(stiff)).iter().all(|m| *m < 4e-7));
    let hysteresis = effect("hysteresis", Location::Joint(0), &[2400.0, 1e-4]);
    // A tracker's noise; T/K = 0.18 mrad at A1 over some 2 m would be all that could be left.
    let trace = moved(Recipe::plain(23).with_effect(hysteresis));
    assert!(trace[1] > 3e-5 && trace[1] < 1.5e-3, "{trace:?}");
    // A1 carries no weight: its link is left at the end of the gap that the load came from.
    let gap = moved(Recipe::plain(23).with_effect(effect("backlash", Location::Joint(0), &[2e-4])));
    assert!(gap[1] > 4e-4 && gap[1] < 1.2e-3, "{gap:?}");
}

#[test]
fn a_stopped_arm_rings_at_the_modes_with_its_motors_locked() {
    let folder = made(&Recipe {
        noise: 1e-6,
        protocol: Protocol { rings: 1, ring: 1.5, ..nothing() },
        ..Recipe::plain(31)
    });
    let samples = samples(folder.path().join("ring-123456"));
    let (first, last) = (110, samples["t_s"].len());
    let frames = KR500.frames(&joints(&samples, last - 1));
    let modes =
        KR500.natural_frequencies(&frames).expect("the arm has modes").map(|omega| omega / TAU);
    let count = last - first;
    for column in POSITION {
        let signal = &samples[column][first..];
        let mean = signal.iter().sum::<f64>() / count as f64;
        let power = |frequency: f64| {
            let (mut re, mut im) = (0.0, 0.0);
            for (k, v) in signal.iter().enumerate() {
                let hann = 0.5 - 0.5 * (TAU * k as f64 / count as f64).cos();
                let (s, c) = (TAU * frequency * k as f64 * 1e-3).sin_cos();
                (re, im) = (re + hann * (v - mean) * c, im + hann * (v - mean) * s);
            }
            re * re + im * im
        };
        let peak =
            (200..6000).map(|k| f64::from(k) * 0.01).max_by(|a, b| power(*a).total_cmp(&power(*b)));
        let peak = peak.expect("a peak");
        let nearest = modes.iter().map(|m| (m - peak).abs()).fold(f64::INFINITY, f64::min);
        // Neighbours and decay pull a peak by a fraction of the line's width, about 1 Hz.
        assert!(nearest < 0.3, "{column}: {peak} Hz, modes {modes:?} Hz");
    }
}

#[test]
fn a_weld_is_pushed_as_hard_as_it_is_set() {
    let folder = made(&Recipe {
        protocol: Protocol { welds: 1, seam: 0.05, ..nothing() },
        ..Recipe::plain(41)
    });
    for weld in ["weld-1", "holdout/weld-2"] {
        let folder = folder.path().join(weld);
        let (samples, file) =
            (samples(&folder), Weld::read(folder.join("weld.toml")).expect("a weld"));
        // From 2 s after full feed to its end.
        let begins = file.settle + file.force_ramp + file.feed_ramp + 2.0;
        let ends = file.settle + file.force_ramp + 0.05 / file.feed;
        let steady = samples["t_s"]
            .iter()
            .zip(&samples["fz_n"])
            .filter(|(t, _)| (begins..ends).contains(*t));
        let pushes: Vec<f64> = steady.map(|(_, f)| -f).collect();
        let mean = pushes.iter().sum::<f64>() / pushes.len() as f64;
        assert!((mean / file.force - 1.0).abs() < 0.01, "{weld}: {mean} N, set {} N", file.force);
        assert!(samples["spindle_rad_s"].iter().all(|s| s.abs() > 50.0));
    }
}

#[test]
fn a_late_tracker_shows_what_was() {
    let protocol = Protocol { free: 2.0, ..nothing() };
    let quiet = Recipe { noise: 1e-6, protocol, ..Recipe::plain(51) };
    let late = effect("channel-delay", Location::Channel(Channel::Tracker), &[0.008]);
    let [prompt, late] =
        [quiet.clone(), quiet.with_effect(late)].map(|r| samples(made(&r).path().join("free")));
    for row in 2..prompt["t_s"].len() {
        // Two rows of 4 ms.
        assert_eq!(vector(&late, POSITION, row), vector(&prompt, POSITION, row - 2), "row {row}");
        assert_eq!(joints(&late, row), joints(&prompt, row));
    }
}

#[test]
fn every_effect_that_is_drawn_is_plausible_and_grows_with_its_size() {
    // What files leave open hides in no campaign, which states all of it.
    let open = |kind: &&EffectKind| kind.is_of_open_file();
    assert!(library().all(|kind| kind.drawn.is_some() != open(&kind)));
    for kind in library().filter(|kind| !open(kind)) {
        for seed in 0..20 {
            let draw = |size| {
                LABORATORY.draw(kind.id, size, &Protocol::usual(), seed).expect("drawn").values
            };
            let drawn = draw(1.0);
            for (parameter, value) in kind.parameters.iter().zip(&drawn) {
                let inside = (parameter.low..=parameter.high).contains(value);
                assert!(
                    inside,
                    "{}: {} = {value}, plausible {}..{}",
                    kind.id, parameter.name, parameter.low, parameter.high
                );
            }
            assert_ne!(draw(0.3), drawn, "{}", kind.id);
        }
    }
}

#[test]
fn every_effect_outside_the_library_shows_in_some_log() {
    // Whatever is strange at all is so without a weld too.
    let protocol = Protocol { welds: 0, free: 1.0, ..Protocol::short() };
    let recipe = || Recipe { noise: 1e-6, protocol: protocol.clone(), ..Recipe::plain(61) };
    let bare = made(&recipe());
    for kind in OutOfLibraryKind::ALL {
        let strange =
            made(&recipe().with_out_of_library(OutOfLibrary { kind, joint: 1, size: 1.0 }));
        let seen = ["static", "ring-123456", "free"].iter().any(|log| {
            let [bare, strange] = [&bare, &strange].map(|f| samples(f.path().join(log)));
            let mean = |column: &str, noise: f64| -> f64 {
                let Some(bare) = bare.get(column) else {
                    return 0.0;
                };
                let square: f64 =
                    bare.iter().zip(&strange[column]).map(|(a, b)| (a - b) * (a - b)).sum();
                (square / bare.len() as f64).sqrt() / noise
            };
            let worst = [
                ("px_m", 3e-5),
                ("pz_m", 3e-5),
                ("fz_n", 25.0),
                ("tm2_nm", 40.0),
                ("ql2_rad", 5e-6),
            ];
            worst.iter().any(|(column, noise)| mean(column, *noise) > 1.0)
        });
        assert!(seen, "{}: {} is lost in the noise", kind.name(), kind.equation());
    }
}
