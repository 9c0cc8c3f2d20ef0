//! Faults of instruments are told and left out: none of them is left to be taken for physics, and
//! nothing that a cell does is taken for such a fault.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeMap;
use std::path::PathBuf;
use trueweld_estimate::fit::FitProblem;
use trueweld_estimate::log_faults::find;
use trueweld_estimate::residuals::compare::{
    Comparison, Notice, baseline, compare, experiments, of_comparable,
};
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::{Log, LogNotice};
use trueweld_plant::input::ModelFile;

pub(crate) fn fixture(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/campaigns").join(path)
}

/// A log of a campaign in which nothing is missing, with its files changed: the text of `log.toml`,
/// and a value by its column and row.
pub(crate) fn changed(
    name: &str,
    toml: &str,
    value: &mut dyn FnMut(&str, usize, f64) -> Option<f64>,
) -> Log {
    let folder = fixture("nothing-missing").join(name);
    let text = std::fs::read_to_string(folder.join("samples.csv")).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let names: Vec<&str> = header.trim().split(',').collect();
    let mut csv = format!("{header}\n");
    for (k, row) in rows.lines().enumerate() {
        let fields = names.iter().zip(row.split(',')).map(|(name, field)| {
            let read: f64 = field.parse().unwrap();
            match value(name, k, read) {
                Some(new) if new == read => field.to_owned(),
                Some(new) => new.to_string(),
                None => String::new(),
            }
        });
        csv += &(fields.collect::<Vec<_>>().join(",") + "\n");
    }
    Log::parse(toml, csv.as_bytes(), &folder).unwrap()
}

pub(crate) fn toml(name: &str) -> String {
    std::fs::read_to_string(fixture("nothing-missing").join(name).join("log.toml")).unwrap()
}

pub(crate) fn model() -> ModelFile {
    ModelFile::read(fixture("nothing-missing/model.toml")).unwrap()
}

fn compared(logs: &[Log]) -> Comparison {
    let model = model();
    let problem = FitProblem::new(&model, experiments(logs, &baseline(&model)).unwrap());
    compare(&model, logs, &problem, &|_| {}).unwrap()
}

/// As of the log as it was recorded: its score is 1.0, in every channel to what a dozen independent
/// values leave open.
fn at_the_floor(comparison: &Comparison) {
    assert!((comparison.score - 1.0).abs() < 0.1, "{}", comparison.score);
    for channel in comparison.logs.iter().flat_map(|log| &log.channels) {
        assert!((channel.score - 1.0).abs() < 0.25, "{} {}", channel.name, channel.score);
    }
}

#[test]
fn a_torque_and_a_force_at_the_end_of_their_range_are_not_compared() {
    let mut torque = Vec::new();
    changed("free", &toml("free"), &mut |name, _, v| {
        torque.extend((name == "tm2_nm").then_some(v.abs()));
        Some(v)
    });
    torque.sort_by(f64::total_cmp);
    let limit = torque[torque.len() * 3 / 4].round();
    let clip = &mut |name: &str, _, v: f64| {
        Some(if name == "tm2_nm" { v.clamp(-limit, limit) } else { v })
    };
    let log = changed("free", &toml("free"), clip);
    let [LogNotice::Clipped { column: "tm2_nm", limit: at, rows, .. }, ..] = log.notices[..] else {
        panic!("{:?}", log.notices);
    };
    assert_eq!(at.abs(), limit);
    assert!((torque.len() / 10..torque.len() / 3).contains(&rows), "{rows}");
    at_the_floor(&compared(&[log]));

    let log = changed("weld-1", &toml("weld-1"), &mut |name, _, v| {
        Some(if name == "fz_n" { v.max(-9000.0) } else { v })
    });
    let clipped = |n: &LogNotice| matches!(n, LogNotice::Clipped { column: "fz_n", .. });
    assert!(log.notices.iter().any(clipped), "{:?}", log.notices);
}

#[test]
fn single_readings_that_are_out_are_not_compared_and_many_are_told() {
    // One row in a hundred is off by 5 mm, then one in ten.
    for (every, few) in [(97, true), (10, false)] {
        let log = changed("free", &toml("free"), &mut |name, k, v| {
            let out = name.starts_with('p') && k % every == every / 2;
            Some(if out { v + 5e-3 } else { v })
        });
        let [LogNotice::Outliers { rows, largest, left_out, .. }] = log.notices[..] else {
            panic!("{:?}", log.notices);
        };
        assert_eq!(left_out, few);
        // The first and the last have no neighbours on one side.
        let all = (0..log.samples.len()).filter(|k| k % every == every / 2).count();
        assert!((all - 2..=all).contains(&rows), "{rows} of {all}");
        assert!((largest - 5e-3).abs() < 5e-4, "{largest}");
        let comparison = compared(&[log]);
        if few {
            at_the_floor(&comparison);
        } else {
            assert!(comparison.score > 3.0, "{}", comparison.score);
        }
    }
}

#[test]
fn noise_that_is_larger_than_stated_is_told_and_counts_and_smaller_is_told() {
    for (factor, larger) in [(1.0 / 3.0, true), (3.0, false)] {
        let stated = |line: &str| match line.split_once(" = ") {
            Some((key, value)) if !key.starts_with("period") && value.parse::<f64>().is_ok() => {
                format!("{key} = {:e}", factor * value.parse::<f64>().unwrap())
            }
            _ => line.to_owned(),
        };
        let of = |name: &str| {
            let text: Vec<String> = toml(name).lines().map(stated).collect();
            changed(name, &text.join("\n"), &mut |_, _, v| Some(v))
        };
        let comparison = compared(&[of("free"), of("static")]);
        let told = |n: &&Notice| match n {
            Notice::NoiseLarger(_) => larger,
            Notice::NoiseSmaller(_) => !larger,
            other => panic!("{other:?}"),
        };
        // Position, rotation, motor encoders, second encoders, torque.
        assert_eq!(comparison.notices.iter().filter(told).count(), 5);
        for notice in &comparison.notices {
            let (Notice::NoiseLarger(s) | Notice::NoiseSmaller(s)) = notice else { continue };
            assert!((s.stated / s.shown / factor - 1.0).abs() < 0.1, "{s:?}");
        }
        if larger {
            at_the_floor(&comparison);
        } else {
            assert!((comparison.score - 1.0 / factor).abs() < 0.1, "{}", comparison.score);
        }
    }
}

/// Its mean over the same time is of fewer readings.
#[test]
fn a_torque_that_is_read_every_third_row_is_as_noisy_as_its_readings() {
    // Noise of the torque alone, well above what the encoders make.
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let text = toml("free").replace("motor_torque_nm = 40.0", "motor_torque_nm = 205.0");
    let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
    let log = changed("free", &text, &mut |name, k, v| match name.starts_with("tm") {
        true => (k % 3 == 0).then(|| (v + 201.0 * noise()).round()),
        false => Some(v),
    });
    let comparison = compared(&[log]);
    let torque = comparison.logs[0].channels.iter().find(|c| c.name == "motor_torque").unwrap();
    // Some 300 independent values: 4 %.
    assert!((torque.score - 1.0).abs() < 0.12, "{}", torque.score);
}

/// What another program wrote beside its own rows: the last reading of a slower instrument.
#[test]
fn readings_that_stand_until_the_next_are_compared_where_they_are_new() {
    let instruments: [(&str, &[&str]); 6] = [
        ("free", &["p", "r"]),
        ("free", &["tm"]),
        ("free", &["qe"]),
        ("free", &["q", "tm", "p", "r"]),
        ("weld-1", &["p", "r"]),
        ("weld-1", &["f", "m"]),
    ];
    for (name, held) in instruments {
        let mut last = BTreeMap::new();
        let log = changed(name, &toml(name), &mut |column, k, v| {
            let is_held = held.iter().any(|prefix| column.starts_with(prefix));
            if k % 3 == 0 || !is_held {
                last.insert(column.to_owned(), v);
            }
            last.get(column).copied()
        });
        assert!(holds(&log, 3.0), "{name} {held:?}: {:?}", log.notices);
        for channel in &compared(&[log]).logs[0].channels {
            assert!(channel.score < 1.25, "{held:?}: {} {}", channel.name, channel.score);
        }
    }
}

/// True where instruments of a log are held, each for so many rows.
fn holds(log: &Log, rows: f64) -> bool {
    let held = |n: &LogNotice| match n {
        LogNotice::Held { every, .. } => Some((every - rows).abs() < 0.05),
        _ => None,
    };
    let all: Vec<bool> = log.notices.iter().filter_map(held).collect();
    !all.is_empty() && all.iter().all(|held| *held)
}

/// A tracker of 100 Hz in rows of 250 Hz: its readings are up to 2 ms older than their rows, in which
/// the tool moves by sixty times the noise.
#[test]
fn readings_between_the_rows_are_put_where_they_were_taken() {
    let mut seen: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    changed("free", &toml("free"), &mut |name, _, v| {
        seen.entry(name.to_owned()).or_default().push(v);
        Some(v)
    });
    let log = changed("free", &toml("free"), &mut |name, k, v| {
        if name.starts_with('r') {
            return None;
        }
        if !name.starts_with('p') {
            return Some(v);
        }
        let at = (k as f64 / 2.5).floor() * 2.5;
        let (row, share) = (at as usize, at.fract());
        let series = &seen[name];
        let next = series[(row + 1).min(series.len() - 1)];
        Some((1e7 * (series[row] * (1.0 - share) + next * share)).round() / 1e7)
    });
    assert!(holds(&log, 2.5), "{:?}", log.notices);
    let comparison = compared(&[log]);
    assert!(comparison.score < 1.2, "{}", comparison.score);
}

/// Every so many rows of a log.
fn seldom(name: &str, every: usize) -> Log {
    let folder = fixture("nothing-missing").join(name);
    let text = std::fs::read_to_string(folder.join("samples.csv")).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().step_by(every).collect();
    let csv = format!("{header}\n{}\n", rows.join("\n"));
    let line = |line: &str| match line.strip_prefix("period_s = ") {
        Some(period) => format!("period_s = {}\n", period.parse::<f64>().unwrap() * every as f64),
        None => format!("{line}\n"),
    };
    let toml: String = toml(name).lines().map(line).collect();
    Log::parse(&toml, csv.as_bytes(), &folder).unwrap()
}

/// Motors move on between rows that are far apart, and links swing.
#[test]
fn motions_and_ringing_in_rows_that_are_far_apart_are_at_the_floor() {
    let cases =
        [("free", 5), ("free", 10), ("free", 25), ("ring-14", 8), ("ring-25", 12), ("ring-36", 12)];
    for (name, every) in cases {
        for channel in &compared(&[seldom(name, every)]).logs[0].channels {
            let (channel, score) = (&channel.name, channel.score);
            assert!((score - 1.0).abs() < 0.2, "{name}, every {every} rows: {channel} {score}");
        }
    }
}

#[test]
fn rows_that_are_too_far_apart_are_left_out_and_are_no_mistake() {
    for (name, every) in [("free", 50), ("free", 100), ("ring-25", 40)] {
        let mut logs = [seldom(name, every)];
        let model = baseline(&model());
        assert!(find(&mut logs, &model).unwrap().mistakes.is_empty(), "{name} {every}");
        let error = experiments(&logs, &model).map(drop).unwrap_err().to_string();
        assert!(error.contains("too far apart"), "{name} {every}: {error}");
    }
}

/// At 600 rpm in rows of 96 ms the spindle turns by 0.96 of a turn from row to row.
#[test]
fn forces_in_which_the_spindle_looks_slow_are_left_out() {
    for (every, folds) in [(5, false), (8, true)] {
        let mut logs = vec![seldom("weld-1", every)];
        let experiments = of_comparable(&mut logs, &baseline(&model())).unwrap();
        let has = |channel| experiments[0].compared.iter().any(|c| c.quantity.channel() == channel);
        assert!(has("tcp_position") && has("force") != folds, "every {every} rows");
        let is_told = |n: &LogNotice| matches!(n, LogNotice::Folded { order: 1.0, .. });
        assert_eq!(logs[0].notices.iter().any(is_told), folds, "every {every} rows");
        let score = compared(&logs).score;
        assert!((score - 1.0).abs() < 0.15, "every {every} rows: {score}");
    }
}

/// The tool points down, where rotation vectors flip their sign from reading to reading, and the
/// spindle's side shows in newtons by where the tool was seen.
#[test]
fn rows_without_a_tracker_do_not_matter_in_a_weld() {
    let missing: [fn(usize) -> bool; 3] = [|k| k % 50 == 25, |k| k % 2 == 1, |k| k % 3 != 0];
    for missing in missing {
        let log = changed("weld-1", &toml("weld-1"), &mut |name, k, v| {
            let tracked = name.starts_with('p') || name.starts_with('r');
            (!tracked || !missing(k)).then_some(v)
        });
        let mut logs = [log];
        let found = find(&mut logs, &baseline(&model())).unwrap();
        assert!(found.mistakes.is_empty(), "{:?}", found.mistakes);
        at_the_floor(&compared(&logs));
    }
}

#[test]
fn a_log_with_nothing_to_compare_is_left_out_where_others_have() {
    let campaign = Campaign::read(fixture("nothing-missing")).unwrap();
    let model = baseline(&ModelFile::read(&campaign.model).unwrap());
    let whole = campaign.logs.iter().find(|log| log.name == "free").unwrap().clone();
    let mut short = changed("weld-1", &toml("weld-1"), &mut |_, _, v| Some(v));
    let s = &mut short.samples;
    s.time.truncate(20);
    s.encoder.truncate(20);
    s.spindle.iter_mut().for_each(|v| v.truncate(20));
    for series in [&mut s.force, &mut s.moment, &mut s.position, &mut s.rotation] {
        series.iter_mut().for_each(|v| v.truncate(20));
    }
    let mut logs = vec![short.clone(), whole.clone()];
    let made = of_comparable(&mut logs, &model).unwrap();
    assert_eq!((made.len(), logs.len()), (1, 1));
    let [LogNotice::LeftOut { log, .. }] = &logs[0].notices[..] else {
        panic!("{:?}", logs[0].notices);
    };
    assert_eq!(log, "weld-1");
    assert!(short.files.iter().all(|file| logs[0].files.contains(file)));
    assert!(of_comparable(&mut vec![short], &model).is_err());
}

/// Simulated by others, of a real robot, and with a gear that strikes through its play.
#[test]
fn nothing_that_a_cell_does_is_a_fault_of_an_instrument() {
    for name in ["nothing-missing", "backlash", "kr210-cut", "kr300-measured"] {
        let campaign = Campaign::read(fixture(name)).unwrap();
        for log in &campaign.logs {
            let fault = |n: &LogNotice| {
                use LogNotice::{Clipped, Held, Outliers};
                matches!(n, Clipped { .. } | Outliers { .. } | Held { .. })
            };
            assert!(!log.notices.iter().any(fault), "{name} {}: {:?}", log.name, log.notices);
        }
        let model = ModelFile::read(&campaign.model).unwrap();
        let made = experiments(&campaign.logs, &baseline(&model)).unwrap();
        let problem = FitProblem::new(&model, made);
        let comparison = compare(&model, &campaign.logs, &problem, &|_| {}).unwrap();
        let noise = |n: &Notice| matches!(n, Notice::NoiseLarger(_) | Notice::NoiseSmaller(_));
        assert!(!comparison.notices.iter().any(noise), "{name}: {:?}", comparison.notices);
    }
}
