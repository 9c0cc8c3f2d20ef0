//! What is done in each log: postures and loads, stops, motions, seams.

use super::links::{Follower, HeldArm, Instant, Load};
use super::motion::{Moves, Stop};
use super::random::{PLAN, Random};
use super::table::{Besides, LogKind, SampleTable, Track, readings};
use super::{CampaignError, Laboratory, Logs};
use nalgebra::Vector3;
use std::path::Path;
use trueweld_core::{JOINTS, JointVector, Pose, Wrench};
use trueweld_plant::cell::Cell;
use trueweld_plant::input::{Weld, write_atomically};
use trueweld_plant::integrate::Integrator;
use trueweld_plant::simulate::{Controller, Law, Program, RecordRow, Scenario, Seam, run};

/// Where the postures of static loads and stops lie, rad; A5 of either sign.
const RANGE: [[f64; 2]; JOINTS] =
    [[-0.8, 0.9], [-1.05, -0.65], [1.15, 2.2], [-1.2, 1.2], [0.25, 1.5], [-1.6, 1.6]];

/// Plant step of a weld, s.
const WELD_STEP: f64 = 5e-4;

/// Step of a motion without contact, s; a stop's own, s, which its brake is a multiple of.
const FREE_STEP: f64 = 5e-4;
const RING_STEP: f64 = 2.5e-4;

/// Time that an arm runs evenly before a stop's log begins, s.
const RUN_IN: f64 = 1.0;

/// The logs of one campaign.
#[derive(Debug)]
pub(super) struct Plan {
    pub logs: Logs,
    /// True for the held-out campaign.
    pub held_out: bool,
}

impl Plan {
    /// Writes every log into the campaign's folder and gives their names.
    pub fn write(
        &self,
        laboratory: &Laboratory<'_>,
        folder: &Path,
    ) -> Result<Vec<String>, CampaignError> {
        let mut names = Vec::new();
        // The held-out logs carry numbers on from those of the campaign.
        let (extra, mut log) = if self.held_out { ("-2", 100) } else { ("", 0) };
        let mut next = |name: String| {
            log += 1;
            names.push(name.clone());
            (log, Random::new(laboratory.recipe.seed, PLAN + log), folder.join(name))
        };
        if self.logs.postures > 0 {
            let (log, mut random, folder) = next(format!("static{extra}"));
            self.load(laboratory, log, &mut random, &folder)?;
        }
        let rings = self.logs.rings.min(JOINTS);
        for ring in 0..rings {
            let joints: Vec<usize> = (ring..JOINTS).step_by(rings).collect();
            let which: String = joints.iter().map(|j| (j + 1).to_string()).collect();
            let (log, mut random, folder) = next(format!("ring-{which}"));
            self.stop(laboratory, log, &mut random, &joints, &folder)?;
        }
        if self.logs.free > 0.0 {
            let (log, mut random, folder) = next(format!("free{extra}"));
            self.move_freely(laboratory, log, &mut random, &folder)?;
        }
        for weld in 0..self.logs.welds {
            let number = if self.held_out { laboratory.recipe.logs.welds + 1 } else { weld + 1 };
            let (log, mut random, folder) = next(format!("weld-{number}"));
            self.weld(laboratory, log, weld, &mut random, &folder)?;
        }
        Ok(names)
    }

    fn load(
        &self,
        laboratory: &Laboratory<'_>,
        log: u64,
        random: &mut Random,
        folder: &Path,
    ) -> Result<(), CampaignError> {
        let cell = laboratory.cell(log, out_of_reach(), 0.0)?;
        let mut table = SampleTable::new(LogKind::Static, laboratory.instruments(log));
        let mut arm: Option<HeldArm<'_>> = None;
        let mut time = 0.0;
        for posture in 0..self.logs.postures {
            let motor = posture_within(random);
            for (row, load) in loads(posture, random).iter().enumerate() {
                let takes =
                    if row == 0 { random.between(50.0, 65.0) } else { random.between(12.0, 20.0) };
                match &mut arm {
                    None => {
                        let mut first = HeldArm::new(&cell, &motor)?;
                        first.lead(&motor, load, time)?;
                        arm = Some(first);
                    }
                    Some(arm) => {
                        time += (takes * 10.0).round() / 10.0;
                        arm.lead(&motor, load, time)?;
                    }
                }
                if let Some(arm) = &arm {
                    let read =
                        readings(time, &motor, arm.link(), &load.wrench_in_t, &arm.pose(time));
                    table.record(
                        &cell,
                        read,
                        &JointVector::zeros(),
                        Besides::Payload(load.payload, load.center),
                    );
                }
            }
        }
        Ok(table.write(folder, "")?)
    }

    fn stop(
        &self,
        laboratory: &Laboratory<'_>,
        log: u64,
        random: &mut Random,
        joints: &[usize],
        folder: &Path,
    ) -> Result<(), CampaignError> {
        let cell = laboratory.cell(log, out_of_reach(), 0.0)?;
        let start = posture_within(random);
        let mut rate = JointVector::zeros();
        for &j in joints {
            rate[j] = if j < 3 { random.either(0.05, 0.08) } else { random.either(0.12, 0.2) };
        }
        let path = Stop { start, rate, falls: 0.1, takes: 0.003 };
        let follower =
            Follower { cell: &cell, stranger: laboratory.recipe.stranger.as_ref(), path: &path };
        let instants = follower.run(-RUN_IN, self.logs.ring, RING_STEP)?;
        let track = Track { start: -RUN_IN, step: RING_STEP, instants };
        let table = recorded(
            laboratory,
            log,
            &cell,
            LogKind::Ring,
            &track,
            self.logs.ring,
            Besides::Nothing,
        );
        Ok(table.write(folder, "")?)
    }

    fn move_freely(
        &self,
        laboratory: &Laboratory<'_>,
        log: u64,
        random: &mut Random,
        folder: &Path,
    ) -> Result<(), CampaignError> {
        let cell = laboratory.cell(log, out_of_reach(), 0.0)?;
        let path = Moves::random(self.logs.free, random);
        let follower =
            Follower { cell: &cell, stranger: laboratory.recipe.stranger.as_ref(), path: &path };
        let instants = follower.run(0.0, self.logs.free, FREE_STEP)?;
        let track = Track { start: 0.0, step: FREE_STEP, instants };
        let table = recorded(
            laboratory,
            log,
            &cell,
            LogKind::Free,
            &track,
            self.logs.free,
            Besides::Nothing,
        );
        Ok(table.write(folder, "")?)
    }

    fn weld(
        &self,
        laboratory: &Laboratory<'_>,
        log: u64,
        number: usize,
        random: &mut Random,
        folder: &Path,
    ) -> Result<(), CampaignError> {
        let (weld, spindle) = self.seam(number, random);
        let cell = laboratory.cell(log, Seam::of(&weld).b_from_w, spindle)?;
        let recording = run(
            &Scenario {
                name: "synthetic",
                cell: &cell,
                // The controller knows no more of the truth than the model file does.
                controller_model: &laboratory.robot.robot,
                planned: &laboratory.process,
                weld: &weld,
                program: Program::Weld,
                control: &laboratory.control,
                sensors: &laboratory.sensors,
                controller: Controller::External,
                law: &Law::None,
                integrator: Integrator::LinearlyImplicit,
                plant_step: WELD_STEP,
                seed: laboratory.recipe.seed.wrapping_add(log),
                fault: None,
            },
            |_| {},
        )?;
        let instant = |row: &RecordRow| {
            let force = row.real.rotation.tr_mul(&(cell.b_from_w.rotation * row.force_w));
            Instant {
                motor: row.motor,
                link: row.link,
                torque: row.torque,
                pose: row.real,
                wrench: Wrench { moment: Vector3::zeros(), force },
            }
        };
        let instants: Vec<_> = recording.rows.iter().map(instant).collect();
        let length = (instants.len() - 1) as f64 * recording.period;
        let track = Track { start: 0.0, step: recording.period, instants };
        let table = recorded(
            laboratory,
            log,
            &cell,
            LogKind::Weld,
            &track,
            length,
            Besides::Spindle(spindle),
        );
        table.write(folder, "weld = \"weld.toml\"\nprocess = \"../process.toml\"\n")?;
        Ok(write_atomically(folder.join("weld.toml"), weld_file(&weld).as_bytes())?)
    }

    /// A weld and its spindle speed: the tool upright and inclined by turns, and held out a
    /// slanting seam elsewhere. Feeds, pushes and speeds differ from weld to weld, so that what
    /// scales with them shows.
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
            end: round(start + along * self.logs.seam),
            tool_axis: axis,
            feed,
            feed_ramp: 1.0,
            force,
            force_ramp: 3.0,
            initial_depth: 3e-4,
            settle: 2.0,
        };
        (weld, spindle)
    }
}

/// A plate far from the tool.
fn out_of_reach() -> Pose<f64> {
    Pose { position: Vector3::new(0.0, 0.0, 100.0), ..Pose::identity() }
}

fn posture_within(random: &mut Random) -> JointVector<f64> {
    let mut posture = JointVector::from_fn(|i, _| random.between(RANGE[i][0], RANGE[i][1]));
    posture[4] *= random.sign();
    posture
}

/// Loads at one posture, in their order: up and down again, so that what remembers shows.
fn loads(posture: usize, random: &mut Random) -> Vec<Load> {
    let pressed = |force: Vector3<f64>, moment: Vector3<f64>| Load {
        wrench_in_t: Wrench { moment, force },
        ..Load::none()
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
            let hung = |payload: f64| Load {
                payload,
                center: if payload > 0.0 { center } else { Vector3::zeros() },
                ..Load::none()
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

/// A log with even sampling up to `length`, s, from a track of the truth.
fn recorded(
    laboratory: &Laboratory<'_>,
    log: u64,
    cell: &Cell,
    kind: LogKind,
    track: &Track,
    length: f64,
    besides: Besides,
) -> SampleTable {
    let mut table = SampleTable::new(kind, laboratory.instruments(log));
    if let Some(period) = kind.period() {
        for row in 0..=(length / period + 1e-6) as usize {
            let (read, torque) = track.read(cell, row as f64 * period);
            table.record(cell, read, &torque, besides);
        }
    }
    table
}

fn weld_file(weld: &Weld) -> String {
    let list = |v: &Vector3<f64>| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    format!(
        "schema = \"weld/1\"\nstart_m = {}\nend_m = {}\ntool_axis = {}\nfeed_m_s = {:?}\nfeed_ramp_s = {:?}\n\
         force_n = {:?}\nforce_ramp_s = {:?}\ninitial_depth_m = {:?}\nsettle_s = {:?}\n",
        list(&weld.start),
        list(&weld.end),
        list(&weld.tool_axis),
        weld.feed,
        weld.feed_ramp,
        weld.force,
        weld.force_ramp,
        weld.initial_depth,
        weld.settle
    )
}
