//! Samples of simulated runs, wide: a row for every control period and a column for every signal.
//! And what comparisons of laws and certifications consist of: a row for every weld.

use super::{BlockTable, ColumnValues};
use crate::LawsReport;
use crate::path::travelled;
use crate::text::laws::{axis, label};
use nalgebra::Rotation3;
use std::borrow::Cow;
use trueweld_core::{JOINTS, JointVector, Pose};
use trueweld_evaluate::certify::{CertifiedWeld, EvidenceKind, FAULT_FIGURES, FigureValues, Trial};
use trueweld_evaluate::{Figure, WELD_FIGURES, WeldFigures};
use trueweld_plant::simulate::{RecordRow, Recording};

/// A group of signals: what their names begin and end with, what tells them apart, and their values.
struct SignalGroup {
    name: &'static str,
    parts: &'static [&'static str],
    unit: &'static str,
    of: fn(&RecordRow) -> Vec<f64>,
}

const fn signals(
    name: &'static str,
    parts: &'static [&'static str],
    unit: &'static str,
    of: fn(&RecordRow) -> Vec<f64>,
) -> SignalGroup {
    SignalGroup { name, parts, unit, of }
}

const XYZ: &[&str] = &["_x", "_y", "_z"];
const AXIS_SUFFIXES: &[&str] = &["_a1", "_a2", "_a3", "_a4", "_a5", "_a6"];
/// Longitudinal, lateral, depth.
const OF_WELD: &[&str] = &["_longitudinal", "_lateral", "_depth"];

/// Poses in B, rotations as rotation vectors; what is of the weld in axes of W.
static SIGNAL_GROUPS: [SignalGroup; 25] = [
    signals("nominal", XYZ, "_m", |r| r.nominal.position.as_slice().to_vec()),
    signals("nominal", &["_rx", "_ry", "_rz"], "_rad", |r| rotation(&r.nominal)),
    signals("real", XYZ, "_m", |r| r.real.position.as_slice().to_vec()),
    signals("real", &["_rx", "_ry", "_rz"], "_rad", |r| rotation(&r.real)),
    signals("encoder", XYZ, "_m", |r| r.encoder_pose.position.as_slice().to_vec()),
    signals("encoder", &["_rx", "_ry", "_rz"], "_rad", |r| rotation(&r.encoder_pose)),
    signals("deviation", OF_WELD, "_m", |r| r.deviation_w.linear.as_slice().to_vec()),
    signals("deviation", &["_rx", "_ry", "_rz"], "_rad", |r| {
        r.deviation_w.angular.as_slice().to_vec()
    }),
    signals("tilt", &[""], "_rad", |r| vec![r.tilt]),
    signals("lateral_by", AXIS_SUFFIXES, "_m", |r| joints(&r.lateral_by_joint)),
    signals("force", XYZ, "_n", |r| r.force_w.as_slice().to_vec()),
    signals("force_sensed", XYZ, "_n", |r| r.force_sensed_w.as_slice().to_vec()),
    signals("push_desired", &[""], "_n", |r| vec![r.force_desired.unwrap_or(f64::NAN)]),
    signals("link", AXIS_SUFFIXES, "_rad", |r| joints(&r.link)),
    signals("motor", AXIS_SUFFIXES, "_rad", |r| joints(&r.motor)),
    signals("torque", AXIS_SUFFIXES, "_nm", |r| joints(&r.torque)),
    signals("spindle_angle", &[""], "_rad", |r| vec![r.spindle_angle]),
    signals("force_error", &[""], "_n", |r| vec![r.force_error]),
    signals("depth_correction", &[""], "_m", |r| vec![r.depth_correction]),
    signals("push_added", &[""], "_n", |r| vec![r.push]),
    signals("correction", OF_WELD, "_m", |r| r.correction_w.linear.as_slice().to_vec()),
    signals("correction", &["_rx", "_ry", "_rz"], "_rad", |r| {
        r.correction_w.angular.as_slice().to_vec()
    }),
    signals("limited", &["_torque"], "", |r| vec![f64::from(u8::from(r.limited.torque))]),
    signals("limited", &["_force_loop"], "", |r| vec![f64::from(u8::from(r.limited.force_loop))]),
    signals("limited", &["_compensation"], "", |r| {
        vec![f64::from(u8::from(r.limited.compensation))]
    }),
];

fn rotation(pose: &Pose<f64>) -> Vec<f64> {
    Rotation3::from_matrix_unchecked(pose.rotation).scaled_axis().as_slice().to_vec()
}

fn joints(values: &JointVector<f64>) -> Vec<f64> {
    values.as_slice()[..JOINTS].to_vec()
}

/// Rows in one block.
const SIMULATED_BLOCK_ROWS: usize = 100_000;

/// Runs, every recorded signal of each.
pub(crate) fn of_runs<'a>(runs: impl Iterator<Item = &'a Recording> + 'a) -> BlockTable<'a> {
    let words = ["weld", "controller", "law", "phase", "fault"].map(str::to_owned);
    let of_group = |s: &SignalGroup| {
        let name = |part: &&str| format!("{}{part}{}", s.name, s.unit);
        s.parts.iter().map(name).collect::<Vec<_>>()
    };
    let numbers = ["time_s", "path_m"].map(str::to_owned);
    let numbers = numbers.into_iter().chain(SIGNAL_GROUPS.iter().flat_map(of_group));
    let blocks = runs.flat_map(|run| {
        let path = travelled(&run.rows);
        let starts = (0..run.rows.len()).step_by(SIMULATED_BLOCK_ROWS);
        starts.map(move |start| {
            let rows = &run.rows[start..run.rows.len().min(start + SIMULATED_BLOCK_ROWS)];
            let path = path[start..start + rows.len()].to_vec();
            block(run, rows, path)
        })
    });
    BlockTable::new(words, numbers, blocks)
}

fn block<'a>(run: &'a Recording, rows: &'a [RecordRow], path: Vec<f64>) -> Vec<ColumnValues<'a>> {
    let mut block: Vec<ColumnValues<'a>> =
        [run.weld.as_str(), run.controller, &run.compensator].map(ColumnValues::Word).into();
    let fault = |row: &RecordRow| row.fault.map_or("".into(), |fault| format!("{fault:?}").into());
    block.push(ColumnValues::Words(rows.iter().map(|row| row.phase.name().into()).collect()));
    block.push(ColumnValues::Words(rows.iter().map(fault).collect()));
    block.push(ColumnValues::Numbers(rows.iter().map(|row| row.time).collect()));
    block.push(ColumnValues::Numbers(path));
    for group in &SIGNAL_GROUPS {
        let mut columns = vec![Vec::with_capacity(rows.len()); group.parts.len()];
        for row in rows {
            columns.iter_mut().zip((group.of)(row)).for_each(|(column, v)| column.push(v));
        }
        block.extend(columns.into_iter().map(ColumnValues::Numbers));
    }
    block
}

/// Welds of a comparison of laws: what was varied, and the figures that may be limited.
pub(crate) fn of_laws<'a>(report: &LawsReport<'a>) -> BlockTable<'a> {
    let (laws, sweeps) = (report.comparison.laws, report.sweeps);
    let steady = || WELD_FIGURES.iter().filter(|of| of.figure.phase().is_empty());
    let blocks = sweeps.iter().flat_map(move |sweep| {
        laws.iter().zip(&sweep.points).map(move |(law, points)| {
            let changes = sweep.quantity.changes().iter();
            let failed = |point: &Result<WeldFigures, _>| match point {
                Ok(_) => "".into(),
                Err(error) => Cow::from(ToString::to_string(error)),
            };
            let words = [
                ColumnValues::Word(law.name()),
                ColumnValues::Word(axis(sweep.quantity)),
                ColumnValues::Words(changes.map(|change| label(*change).into()).collect()),
                ColumnValues::Words(points.iter().map(failed).collect()),
            ];
            let numbers = steady().map(|of| {
                let value = |p: &Result<_, _>| p.as_ref().map_or(f64::NAN, |f| (of.value)(f));
                ColumnValues::Numbers(points.iter().map(value).collect())
            });
            words.into_iter().chain(numbers).collect()
        })
    });
    let words = ["law", "varied", "value", "failed"];
    BlockTable::new(words, steady().map(|of| of.figure.key), blocks)
}

/// Runs of a certification, with their figures.
pub(crate) fn of_trials(welds: &[CertifiedWeld]) -> BlockTable<'_> {
    let blocks = welds.iter().flat_map(move |weld| {
        let evidence = &weld.evidence;
        let of_trials = |case: EvidenceKind, trials: &'_ [Trial]| {
            let of_trial = |t: &Trial| (t.index as f64, t.figures.clone(), t.failed.clone());
            (case, "", trials.iter().map(of_trial).collect::<Vec<_>>())
        };
        let faults = evidence.faults.iter().map(|trial| {
            let cell = trial.draw.map_or(f64::NAN, |index| index as f64);
            let run = (cell, trial.figures.clone(), trial.failed.clone());
            (EvidenceKind::Faults, trial.fault.as_str(), vec![run])
        });
        let sections = [
            of_trials(EvidenceKind::Nominal, std::slice::from_ref(&evidence.nominal)),
            of_trials(EvidenceKind::Draws, &evidence.trials),
            of_trials(EvidenceKind::WorstCase, &evidence.worst.runs),
        ];
        sections.into_iter().chain(faults).map(move |(case, fault, runs)| {
            let words = [weld.name.as_str(), case.name(), fault].map(ColumnValues::Word);
            let failed =
                |(_, _, why): &(f64, _, Option<String>)| Cow::from(why.clone().unwrap_or_default());
            let failed = ColumnValues::Words(runs.iter().map(failed).collect());
            let trial = ColumnValues::Numbers(runs.iter().map(|run| run.0).collect());
            let numbers = keys(welds).map(|key| {
                let value = |figures: &FigureValues| figures.get(key).copied();
                let of_run = |run: &(f64, Option<FigureValues>, _)| {
                    run.1.as_ref().and_then(value).unwrap_or(f64::NAN)
                };
                ColumnValues::Numbers(runs.iter().map(of_run).collect())
            });
            let words = words.into_iter().chain([failed, trial]);
            words.chain(numbers).collect()
        })
    });
    let words = ["weld", "case", "fault", "failed"];
    BlockTable::new(words, ["trial"].into_iter().chain(keys(welds)), blocks)
}

/// Figures of welds and of faults, of phases beside the steady one those that are limited.
fn keys(welds: &[CertifiedWeld]) -> impl Iterator<Item = &'static str> {
    let limited = |key: &str| welds.iter().any(|w| w.requirements.iter().any(|r| r.name == key));
    let kept = move |figure: &Figure| figure.phase().is_empty() || limited(figure.key);
    let weld = WELD_FIGURES.iter().map(|of| &of.figure).filter(move |figure| kept(figure));
    let weld = weld.map(|figure| figure.key);
    let more = FAULT_FIGURES.iter().map(|of| of.figure.key);
    weld.chain(more.filter(|key| !WELD_FIGURES.iter().any(|of| of.figure.key == *key)))
}
