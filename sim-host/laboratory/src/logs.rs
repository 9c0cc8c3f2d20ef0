//! The logs of a campaign: postures and loads, stops, motions, welds.

use crate::error::CampaignError;
use crate::instruments::SimulatedLogKind;
use crate::motion::{BrakedStop, EncoderPath, Moves};
use crate::moving_arm::MovingArm;
use crate::protocol::Protocol;
use crate::protocol_file::{LoadRow, LogPlan, PlannedLog, PlannedWeld};
use crate::random;
use crate::samples::SampleTable;
use crate::static_arm::{AppliedLoad, StaticArm};
use crate::track::{Instant, TruthTrack, readings};
use crate::truth::Truth;
use crate::weld_file::weld_file;
use nalgebra::Vector3;
use std::path;
use trueweld_compensators::{Entry, Uncompensated};
use trueweld_core::{JOINTS, JointVector, Pose, Wrench};
use trueweld_plant::cell::Cell;
use trueweld_plant::input::{RealSeam, Weld, write_atomically};
use trueweld_plant::integrate::Integrator;
use trueweld_plant::random::Random;
use trueweld_plant::simulate::{
    ControllerKind, RecordRow, Recording, Scenario, Seam, WeldProgram, run,
};

/// Range of the postures of static loads and ring-downs, rad; A5 of either sign.
const POSTURE_RANGE: [[f64; 2]; JOINTS] =
    [[-0.8, 0.9], [-1.05, -0.65], [1.15, 2.2], [-1.2, 1.2], [0.25, 1.5], [-1.6, 1.6]];

/// Plant step of a weld, s.
const WELD_STEP: f64 = 5e-4;

/// Step of a motion without contact, s; of a ring-down, s, which divides the brake's time.
const FREE_STEP: f64 = 5e-4;
const RING_STEP: f64 = 2.5e-4;

/// Time that the arm runs at constant rate before the log of a ring-down begins, s.
const RUN_IN: f64 = 1.0;

/// Writes the logs of one campaign, or of the campaign held out beside it.
#[derive(Debug)]
pub(crate) struct LogWriter<'a> {
    pub truth: &'a Truth<'a>,
    pub protocol: &'a Protocol,
    pub held_out: bool,
}

/// One log about to be written.
struct NewLog {
    /// Its number, which all its streams of random numbers have added.
    number: u64,
    /// What is done in it.
    random: Random,
    folder: path::PathBuf,
}

/// Records logs of the true cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Recorder<'a> {
    pub truth: &'a Truth<'a>,
}

/// When the brake falls in a ring-down, and how long it takes, s.
const RING_DOWN_BRAKE_ONSET: f64 = 0.1;
const RING_DOWN_BRAKE_DURATION: f64 = 0.003;

impl Recorder<'_> {
    /// Records a log of a protocol, which has this number among them, into a folder.
    pub(crate) fn record(
        &self,
        number: u64,
        log: &PlannedLog,
        folder: &path::Path,
    ) -> Result<(), CampaignError> {
        let random = Random::new(self.truth.recipe.seed, random::PLAN_STREAM + number);
        let mut new = NewLog { number, random, folder: folder.to_owned() };
        match &log.plan {
            LogPlan::Loads(rows) => self.load(&new, rows),
            LogPlan::Stop { start, rate, lasts } => self.ring_down(new, *start, *rate, *lasts),
            LogPlan::Moves { start, waypoints } => {
                let path = Moves::through(*start, waypoints);
                let lasts = path.lasts();
                self.follow(new, SimulatedLogKind::Free, &path, 0.0, lasts, FREE_STEP)
            }
            LogPlan::Wander { lasts } => {
                let path = Moves::random(*lasts, &mut new.random);
                self.follow(new, SimulatedLogKind::Free, &path, 0.0, *lasts, FREE_STEP)
            }
            LogPlan::Weld(planned) => {
                let PlannedWeld { weld, text, spindle } = planned.as_ref();
                self.weld(&new, weld, text, *spindle)
            }
        }
    }

    fn load(&self, log: &NewLog, rows: &[LoadRow]) -> Result<(), CampaignError> {
        let cell = self.truth.cell(log.number, out_of_reach(), 0.0)?;
        let mut table = self.table(SimulatedLogKind::Static, log);
        let mut arm: Option<StaticArm<'_>> = None;
        for LoadRow { time, motor, load } in rows {
            let arm = match &mut arm {
                None => arm.insert(StaticArm::new(&cell, motor)?),
                Some(arm) => arm,
            };
            arm.lead(motor, load, *time)?;
            let read = readings(*time, motor, arm.link(), &load.wrench_in_t, &arm.pose(*time));
            let [x, y, z] = load.center.into();
            table.record(&cell, read, &[load.payload, x, y, z]);
        }
        Ok(table.write(&log.folder, "")?)
    }

    fn ring_down(
        &self,
        log: NewLog,
        start: JointVector<f64>,
        rate: JointVector<f64>,
        lasts: f64,
    ) -> Result<(), CampaignError> {
        let path = BrakedStop {
            start,
            rate,
            falls: RING_DOWN_BRAKE_ONSET,
            takes: RING_DOWN_BRAKE_DURATION,
        };
        self.follow(log, SimulatedLogKind::Ring, &path, -RUN_IN, lasts, RING_STEP)
    }

    /// The arm without contact, its motors on a path from `start` (before 0 to run in) to `end`, s.
    fn follow(
        &self,
        log: NewLog,
        kind: SimulatedLogKind,
        path: &impl EncoderPath,
        start: f64,
        end: f64,
        step: f64,
    ) -> Result<(), CampaignError> {
        let cell = self.truth.cell(log.number, out_of_reach(), 0.0)?;
        let foreign = self.truth.recipe.out_of_library.as_ref();
        let joint_names = &self.truth.laboratory.robot.joint_names;
        let arm = MovingArm { cell: &cell, joint_names, foreign, path };
        let instants = arm.run(start, end, step)?;
        let track = TruthTrack { start, step, instants };
        Ok(self.recorded(kind, &log, &cell, &track, end, &[]).write(&log.folder, "")?)
    }

    /// `text`: of the weld's file.
    fn weld(
        &self,
        log: &NewLog,
        weld: &Weld,
        text: &str,
        spindle: f64,
    ) -> Result<(), CampaignError> {
        let laboratory = self.truth.laboratory;
        let no_process = || CampaignError::NoProcess { log: log.folder.display().to_string() };
        let planned = laboratory.process.as_ref().ok_or_else(no_process)?;
        let cell = self.truth.cell(log.number, Seam::real(weld), spindle)?;
        let recording = run(
            &Scenario {
                name: "synthetic",
                cell: &cell,
                // The controller knows no more of the truth than the model file does.
                controller_model: &laboratory.robot.robot,
                planned,
                weld,
                program: WeldProgram::Weld,
                control: &laboratory.control,
                sensors: &laboratory.sensors,
                controller: ControllerKind::EXTERNAL,
                law: &Entry::of::<Uncompensated>(),
                integrator: Integrator::LinearlyImplicit,
                plant_step: WELD_STEP,
                seed: self.truth.recipe.seed.wrapping_add(log.number),
                fault: None,
            },
            |_| {},
        )?;
        let table = self.table(SimulatedLogKind::Weld, log);
        Ok(write_weld(table, &recording, &cell, spindle, (&log.folder, text))?)
    }

    fn table(&self, kind: SimulatedLogKind, log: &NewLog) -> SampleTable {
        SampleTable::new(kind, self.truth.recipe, log.number)
    }

    /// A log with even sampling from 0 to `length`, s, from a track of the truth; `given` are the
    /// columns that no instrument reads.
    fn recorded(
        &self,
        kind: SimulatedLogKind,
        log: &NewLog,
        cell: &Cell,
        track: &TruthTrack,
        length: f64,
        given: &[f64],
    ) -> SampleTable {
        let mut table = self.table(kind, log);
        fill(&mut table, kind, cell, track, (length, given));
        table
    }
}

/// Even sampling from 0 to `length`, s; `given`: the columns that no instrument reads.
fn fill(
    table: &mut SampleTable,
    kind: SimulatedLogKind,
    cell: &Cell,
    track: &TruthTrack,
    (length, given): (f64, &[f64]),
) {
    if let Some(period) = kind.period() {
        for row in 0..=(length / period + 1e-6) as usize {
            table.record(cell, track.read(cell, row as f64 * period), given);
        }
    }
}

/// Writes the log of a weld that was made: what the instruments read of it, into a folder, with the
/// text of the weld's file. `spindle`: its speed, rad/s.
pub(crate) fn write_weld(
    mut table: SampleTable,
    recording: &Recording,
    cell: &Cell,
    spindle: f64,
    (folder, text): (&path::Path, &str),
) -> std::io::Result<()> {
    let instants: Vec<_> = recording.rows.iter().map(instant).collect();
    let length = instants.len().saturating_sub(1) as f64 * recording.period;
    let track = TruthTrack { start: 0.0, step: recording.period, instants };
    fill(&mut table, SimulatedLogKind::Weld, cell, &track, (length, &[spindle]));
    table.write(folder, "weld = \"weld.toml\"\nprocess = \"../process.toml\"\n")?;
    write_atomically(folder.join("weld.toml"), text.as_bytes())
}

/// What the arm does at a row of a weld's recording.
fn instant(row: &RecordRow) -> Instant {
    let force = row.real.rotation.tr_mul(&(row.axes * row.force_w));
    Instant {
        motor: row.motor,
        link: row.link,
        torque: row.torque,
        pose: row.real,
        wrench: Wrench { moment: Vector3::zeros(), force },
    }
}

impl LogWriter<'_> {
    /// Writes every log into the campaign's folder and returns their names.
    pub(crate) fn write(&self, folder: &path::Path) -> Result<Vec<String>, CampaignError> {
        let mut names = Vec::new();
        // The logs held out carry numbers of their own.
        let (suffix, mut number) = if self.held_out { ("-2", 100) } else { ("", 0) };
        let mut next = |name: String| {
            number += 1;
            let folder = folder.join(&name);
            names.push(name);
            let random = Random::new(self.truth.recipe.seed, random::PLAN_STREAM + number);
            NewLog { number, random, folder }
        };
        let (protocol, recorder) = (self.protocol, Recorder { truth: self.truth });
        if protocol.postures > 0 {
            let mut log = next(format!("static{suffix}"));
            let rows = self.load(&mut log);
            recorder.load(&log, &rows)?;
        }
        let rings = protocol.rings.min(JOINTS);
        for ring in 0..rings {
            let joints: Vec<usize> = (ring..JOINTS).step_by(rings).collect();
            let digits: String = joints.iter().map(|j| (j + 1).to_string()).collect();
            let mut log = next(format!("ring-{digits}"));
            let [start, rate] = self.ring_down(&mut log, &joints);
            recorder.ring_down(log, start, rate, protocol.ring)?;
        }
        if protocol.free > 0.0 {
            let mut log = next(format!("free{suffix}"));
            let path = Moves::random(protocol.free, &mut log.random);
            recorder.follow(log, SimulatedLogKind::Free, &path, 0.0, protocol.free, FREE_STEP)?;
        }
        for weld in 0..protocol.welds {
            let number = if self.held_out { self.truth.recipe.protocol.welds } else { weld };
            let mut log = next(format!("weld-{}", number + 1));
            let (weld, spindle) = self.seam(weld, &mut log.random);
            recorder.weld(&log, &weld, &weld_file(&weld), spindle)?;
        }
        Ok(names)
    }

    fn load(&self, log: &mut NewLog) -> Vec<LoadRow> {
        let random = &mut log.random;
        let mut rows = Vec::new();
        let mut time = 0.0;
        for posture in 0..self.protocol.postures {
            let motor = draw_posture(random);
            for (row, load) in loads(posture, random).into_iter().enumerate() {
                let pause: f64 =
                    if row == 0 { random.between(50.0, 65.0) } else { random.between(12.0, 20.0) };
                if !rows.is_empty() {
                    time += (pause * 10.0).round() / 10.0;
                }
                rows.push(LoadRow { time, motor, load });
            }
        }
        rows
    }

    fn ring_down(&self, log: &mut NewLog, joints: &[usize]) -> [JointVector<f64>; 2] {
        let start = draw_posture(&mut log.random);
        let mut rate = JointVector::zeros();
        for &j in joints {
            let [low, high] = if j < 3 { [0.05, 0.08] } else { [0.12, 0.2] };
            rate[j] = log.random.either(low, high);
        }
        [start, rate]
    }

    /// A weld and its spindle speed, rad/s. The tool is upright and inclined in turn; the weld held
    /// out is a slanting seam elsewhere. Feeds, forces and speeds differ from weld to weld, so that
    /// an effect in proportion to one of them shows.
    fn seam(&self, number: usize, random: &mut Random) -> (Weld, f64) {
        let upright = Vector3::new(0.0, 0.0, -1.0);
        let inclined = Vector3::new(0.5_f64.sqrt(), 0.0, -0.5_f64.sqrt());
        let square = Vector3::y();
        let (x, y, z, axis, along, feed, force, spindle) = match (self.held_out, number % 2) {
            (false, 0) => {
                (1.7, random.between(-0.7, -0.2), 0.5, upright, square, 0.008, 18e3, -62.83185)
            }
            (false, _) => {
                (2.0, random.between(0.1, 0.5), 0.5, inclined, square, 0.012, 15e3, 75.39822)
            }
            (true, _) => {
                let along = Vector3::new(random.between(-0.2, 0.2), 1.0, 0.0).normalize();
                (1.9, random.between(-0.3, 0.1), 0.55, upright, along, 0.010, 17e3, -69.11504)
            }
        };
        // To a tenth of a millimetre, as a file would state it.
        let round = |p: Vector3<f64>| p.map(|v| (v * 1e4).round() / 1e4);
        let start = round(Vector3::new(x + random.between(-0.05, 0.05), y, z));
        let weld = Weld {
            start,
            end: round(start + along * self.protocol.seam),
            tool_axis: axis,
            feed,
            feed_ramp: 1.0,
            force,
            force_ramp: 3.0,
            initial_depth: 3e-4,
            settle: 2.0,
            path: None,
            lean: [0.0; 2],
            dwell: 0.0,
            run_out: 0.0,
            feeds: Vec::new(),
            real: RealSeam::as_taught(),
        };
        (weld, spindle)
    }
}

/// A plate far from the tool.
fn out_of_reach() -> Pose<f64> {
    Pose { position: Vector3::new(0.0, 0.0, 100.0), ..Pose::identity() }
}

fn draw_posture(random: &mut Random) -> JointVector<f64> {
    let mut posture =
        JointVector::from_fn(|i, _| random.between(POSTURE_RANGE[i][0], POSTURE_RANGE[i][1]));
    posture[4] *= random.sign();
    posture
}

/// Loads at one posture, in their order: up and down again, so that a hysteresis shows.
fn loads(posture: usize, random: &mut Random) -> Vec<AppliedLoad> {
    let pressed = |force: Vector3<f64>, moment: Vector3<f64>| AppliedLoad {
        wrench_in_t: Wrench { moment, force },
        ..AppliedLoad::none()
    };
    let turn = [0.0, 0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0];
    match posture % 4 {
        0 => {
            let force = random.direction() * random.between(5e3, 9e3);
            turn.map(|share| pressed(force * share, Vector3::zeros())).to_vec()
        }
        1 => {
            let center = Vector3::new(
                random.between(0.1, 0.2),
                random.between(-0.1, 0.1),
                random.between(-0.15, 0.1),
            );
            // Where it hangs is known to a tenth of a millimetre.
            let center = center.map(|v| (v * 1e4).round() / 1e4);
            let hung = |payload: f64| AppliedLoad {
                payload,
                center: if payload > 0.0 { center } else { Vector3::zeros() },
                ..AppliedLoad::none()
            };
            [0.0, 150.0, 300.0, 500.0, 300.0, 150.0, 0.0].map(hung).to_vec()
        }
        2 => {
            let moment = random.direction() * random.between(800.0, 1300.0);
            turn.map(|share| pressed(Vector3::zeros(), moment * share)).to_vec()
        }
        _ => (0..8)
            .map(|_| {
                let (force, moment) = (random.between(3e3, 7e3), random.between(200.0, 900.0));
                pressed(random.direction() * force, random.direction() * moment)
            })
            .collect(),
    }
}
