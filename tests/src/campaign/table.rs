//! From the truth to the recorded table: delays, faulty channels, noise, columns.

use super::Recipe;
use super::links::Instant;
use super::random::Random;
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::path::Path;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JOINTS, JointVector, Pose, Wrench};
use trueweld_plant::cell::Cell;
use trueweld_plant::input::write_atomically;
use trueweld_plant::robot::{Channel, Readings};

/// Joints with a second encoder, where there are any.
const LINK_ENCODERS: usize = 3;

/// Standard deviations of a laboratory's instruments, SI units: what one thousand shots of a
/// tracker, and a rest of the others, would give.
const TRACKER_POSITION: f64 = 30e-6;
const TRACKER_ROTATION: f64 = 50e-6;
const ENCODER: f64 = 2e-6;
const LINK_ENCODER: f64 = 5e-6;
const FORCE: f64 = 25.0;
const MOMENT: f64 = 8.0;
const MOTOR_TORQUE: f64 = 40.0;

/// What was done in a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LogKind {
    Static,
    Ring,
    Free,
    Weld,
}

impl LogKind {
    fn name(self) -> &'static str {
        match self {
            Self::Static => "static-load",
            Self::Ring => "ring-down",
            Self::Free => "free-motion",
            Self::Weld => "weld",
        }
    }

    /// Time between rows, s, where it is even.
    pub fn period(self) -> Option<f64> {
        match self {
            Self::Static => None,
            Self::Ring => Some(0.001),
            Self::Free => Some(0.004),
            Self::Weld => Some(0.012),
        }
    }
}

/// The truth over time, evenly sampled.
#[derive(Debug)]
pub(super) struct Track {
    /// Time of the first sample, s.
    pub start: f64,
    /// Time between samples, s.
    pub step: f64,
    /// The samples.
    pub instants: Vec<Instant>,
}

impl Track {
    /// The truth at any time, by the cubic through the four samples around it; as it was at the
    /// ends beyond them.
    fn at(&self, time: f64) -> Instant {
        let last = self.instants.len() - 1;
        let place = ((time - self.start) / self.step).clamp(0.0, last as f64);
        // On the grid but for rounding: no sample beyond is asked for.
        let near = place.round();
        let place = if (place - near).abs() < 1e-6 { near } else { place };
        let first = place.floor() as usize;
        let x = place - first as f64;
        if x == 0.0 {
            return self.instants[first];
        }
        let at = |offset: isize| &self.instants[first.saturating_add_signed(offset).min(last)];
        let weight = [
            -x * (x - 1.0) * (x - 2.0) / 6.0,
            (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0,
            -(x + 1.0) * x * (x - 2.0) / 2.0,
            (x + 1.0) * x * (x - 1.0) / 6.0,
        ];
        let around = [at(-1), at(0), at(1), at(2)];
        let joints = |f: fn(&Instant) -> JointVector<f64>| -> JointVector<f64> {
            around.iter().zip(weight).map(|(i, w)| f(i) * w).sum()
        };
        let vector = |f: &dyn Fn(&Instant) -> Vector3<f64>| -> Vector3<f64> {
            around.iter().zip(weight).map(|(i, w)| f(i) * w).sum()
        };
        let here = at(0).pose.rotation;
        let turned = vector(&|i| rotation_vector(&(here.transpose() * i.pose.rotation)));
        Instant {
            motor: joints(|i| i.motor),
            link: joints(|i| i.link),
            torque: joints(|i| i.torque),
            pose: Pose {
                rotation: here * rotation_from_vector(&turned),
                position: vector(&|i| i.pose.position),
            },
            wrench: Wrench {
                moment: vector(&|i| i.wrench.moment),
                force: vector(&|i| i.wrench.force),
            },
        }
    }

    /// What instruments without noise read at a time, each as late as it is, and the motors'
    /// torque.
    pub fn read(&self, cell: &Cell, time: f64) -> (Readings, JointVector<f64>) {
        let late = |channel| self.at(time - cell.robot.ports.delay(channel));
        let (tracker, wrench) = (late(Channel::Tracker).pose, late(Channel::Wrench).wrench);
        let readings = readings(
            time,
            &self.at(time).motor,
            &late(Channel::LinkEncoder).link,
            &wrench,
            &tracker,
        );
        (readings, late(Channel::MotorTorque).torque)
    }
}

/// The truth as readings.
pub(super) fn readings(
    time: f64,
    motor: &JointVector<f64>,
    link: &JointVector<f64>,
    wrench_in_t: &Wrench<f64>,
    tcp: &Pose<f64>,
) -> Readings {
    Readings {
        force: wrench_in_t.force,
        moment: wrench_in_t.moment,
        ..Readings::of(time, motor, link, tcp)
    }
}

/// What a row has that no instrument of the cell reads.
#[derive(Debug, Clone, Copy)]
pub(super) enum Besides {
    /// Nothing.
    Nothing,
    /// Extra mass on the flange, kg, and its centre, m.
    Payload(f64, Vector3<f64>),
    /// Spindle speed, rad/s.
    Spindle(f64),
}

/// The instruments of one log.
#[derive(Debug)]
pub(super) struct CampaignNoise {
    random: Random,
    noise: f64,
    stated: bool,
    link_encoders: bool,
    motor_torque: bool,
}

/// A log being recorded.
#[derive(Debug)]
pub(super) struct SampleTable {
    kind: LogKind,
    instruments: CampaignNoise,
    text: String,
}

impl CampaignNoise {
    pub fn new(recipe: &Recipe, random: Random) -> Self {
        Self {
            random,
            noise: recipe.noise,
            stated: recipe.noise_stated,
            link_encoders: recipe.link_encoders,
            motor_torque: recipe.motor_torque,
        }
    }

    fn noisy(&mut self, value: f64, deviation: f64) -> f64 {
        value + self.noise * deviation * self.random.normal()
    }

    fn noisy_vector(&mut self, value: &Vector3<f64>, deviation: f64) -> Vector3<f64> {
        value.map(|v| self.noisy(v, deviation))
    }
}

impl SampleTable {
    pub fn new(kind: LogKind, instruments: CampaignNoise) -> Self {
        let mut columns = vec!["t_s".to_owned()];
        let mut each = |count: usize, before: &str, after: &str| {
            columns.extend((1..=count).map(|i| format!("{before}{i}{after}")));
        };
        each(JOINTS, "qe", "_rad");
        if kind == LogKind::Free {
            if instruments.link_encoders {
                each(LINK_ENCODERS, "ql", "_rad");
            }
            if instruments.motor_torque {
                each(JOINTS, "tm", "_nm");
            }
        }
        let mut more = |names: &str| columns.extend(names.split(' ').map(str::to_owned));
        if matches!(kind, LogKind::Static | LogKind::Weld) {
            more("fx_n fy_n fz_n mx_nm my_nm mz_nm");
        }
        more("px_m py_m pz_m");
        if kind != LogKind::Ring {
            more("rx_rad ry_rad rz_rad");
        }
        match kind {
            LogKind::Static => more("payload_kg cx_m cy_m cz_m"),
            LogKind::Weld => more("spindle_rad_s"),
            LogKind::Ring | LogKind::Free => {}
        }
        Self { kind, instruments, text: columns.join(",") + "\n" }
    }

    /// Records one row of what the cell's instruments read, faults of its effects included.
    pub fn record(
        &mut self,
        cell: &Cell,
        mut readings: Readings,
        torque: &JointVector<f64>,
        besides: Besides,
    ) {
        for term in &cell.robot.ports.sensor {
            term.sense(&mut readings);
        }
        let at = &mut self.instruments;
        let text = &mut self.text;
        write!(text, "{:.3}", readings.time).expect("a string takes all");
        let mut put = |value: f64, digits: usize| {
            write!(text, ",{value:.digits$}").expect("a string takes all")
        };
        for angle in readings.encoder {
            put(at.noisy(angle, ENCODER), 8);
        }
        if self.kind == LogKind::Free {
            if at.link_encoders {
                for angle in &readings.link_encoder[..LINK_ENCODERS] {
                    put(at.noisy(*angle, LINK_ENCODER), 8);
                }
            }
            if at.motor_torque {
                for torque in torque {
                    put(at.noisy(*torque, MOTOR_TORQUE), 2);
                }
            }
        }
        if matches!(self.kind, LogKind::Static | LogKind::Weld) {
            at.noisy_vector(&readings.force, FORCE).iter().for_each(|f| put(*f, 2));
            at.noisy_vector(&readings.moment, MOMENT).iter().for_each(|m| put(*m, 2));
        }
        at.noisy_vector(&readings.tcp_position, TRACKER_POSITION).iter().for_each(|p| put(*p, 7));
        if self.kind != LogKind::Ring {
            let off = rotation_from_vector(&at.noisy_vector(&Vector3::zeros(), TRACKER_ROTATION));
            rotation_vector(&(rotation_from_vector(&readings.tcp_rotation) * off))
                .iter()
                .for_each(|r| put(*r, 7));
        }
        match besides {
            Besides::Nothing => {}
            Besides::Payload(mass, center) => {
                put(mass, 4);
                center.iter().for_each(|c| put(*c, 4));
            }
            Besides::Spindle(rate) => put(rate, 5),
        }
        text.push('\n');
    }

    /// Writes the log's folder. `references` are further lines of its `log.toml`.
    pub fn write(&self, folder: &Path, references: &str) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let mut log = format!(
            "schema = \"log/1\"\nkind = \"{}\"\nrobot = \"../robot.toml\"\n",
            self.kind.name()
        );
        log += references;
        if let Some(period) = self.kind.period() {
            writeln!(log, "period_s = {period:?}").expect("a string takes all");
        }
        // An instrument without noise has none to state: nothing could be judged against it.
        if self.instruments.stated && self.instruments.noise > 0.0 {
            log += "\n[noise]\n";
            let wrench = matches!(self.kind, LogKind::Static | LogKind::Weld);
            let free = self.kind == LogKind::Free;
            for (there, name, deviation) in [
                (true, "tcp_position_m", TRACKER_POSITION),
                (self.kind != LogKind::Ring, "tcp_rotation_rad", TRACKER_ROTATION),
                (true, "encoder_rad", ENCODER),
                (free && self.instruments.link_encoders, "link_encoder_rad", LINK_ENCODER),
                (free && self.instruments.motor_torque, "motor_torque_nm", MOTOR_TORQUE),
                (wrench, "force_n", FORCE),
                (wrench, "moment_nm", MOMENT),
            ] {
                if there {
                    writeln!(log, "{name} = {:?}", self.instruments.noise * deviation)
                        .expect("a string takes all");
                }
            }
        }
        write_atomically(folder.join("log.toml"), log.as_bytes())?;
        write_atomically(folder.join("samples.csv"), self.text.as_bytes())
    }
}
