//! The client's end of RSI: a law that drives a robot, simulated or real.
//!
//! A controller begins each RSI_ON with nothing corrected, and says of the cycles that it runs on
//! without an answer in `Delay`. So a client starts anew where RSI has, and goes on with the
//! correction in force where RSI has: either would otherwise ask for a step of millimetres.

use crate::counts::ClientCounts;
use crate::frame::{self, Frame, MM};
use crate::guard::CorrectionBounds;
use crate::packet::{PACKET_BYTES, PacketError, Rob, SeamReading, Sen, WeldChannels};
use nalgebra::Vector3;
use std::io::ErrorKind;
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::time::{Duration, Instant};
use trueweld_core::compensation::{Compensated, Compensator, DeviationMeasurement, Observation};
use trueweld_core::control::{
    DriveCommand, ForceSensorLimits, HybridController, InputCheck, Limited, SensorReadings,
    Setpoint,
};
use trueweld_core::monitor::{HealthMonitor, HealthSignals};
use trueweld_core::{Fault, JointVector, Robot, Twist, Wrench};
use trueweld_plant::input::{Control, Process, SeamSensor};
use trueweld_plant::process::planned;
use trueweld_plant::simulate::{Phase, RecordRow, Seam};

/// Packets in a row of another sequence of time stamps from which on it is the controller's: old
/// packets come back to front, and a single wrong time stamp stands alone.
const BELIEVED: u32 = 3;

/// How far the path goes back where another weld begins, m: more than a path that is measured wavers.
const BACK: f64 = 5e-3;

/// What a client knows of the cell.
#[derive(Debug, Clone)]
pub struct Knowledge {
    /// The robot as the law believes it is.
    pub model: Robot<f64>,
    /// The seam as it was taught; its frame W at its start is $BASE.
    pub seam: Seam,
    /// The process as the weld was planned with it.
    pub process: Process,
    /// The seam sensor that the packets' readings are of.
    pub sensor: Option<SeamSensor>,
    /// What a force sensor that is in order can read.
    pub force_sensor_limits: ForceSensorLimits<f64>,
}

/// A law at the end of a line: answers packets with its correction.
pub struct Client<'a> {
    knowledge: Knowledge,
    law: Compensated<f64, NoDrives, &'a mut dyn Compensator<f64>>,
    period: f64,
    silence: Duration,
    counts: ClientCounts,
    /// Of the first packet that cannot be answered.
    malformed: Option<PacketError>,
    /// The first fault, and when it was, s.
    fault: Option<(f64, Fault)>,
    inputs: InputCheck<f64>,
    /// When the encoders were good last, s.
    good: f64,
    last: Option<Last>,
    /// Newest time stamp of another sequence, and how many there are in a row.
    other: Option<(u64, u32)>,
    seen: Option<Seen>,
    monitor: Option<HealthMonitor>,
}

/// What the last packet that was answered said.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// The instruments.
    pub sensed: SensorReadings<f64>,
    /// The cell as the model has it from these: the real tool where encoders and load put it, the
    /// process' force as the sensor says. Time counts from the first packet.
    pub row: RecordRow,
}

/// The last packet that was answered.
#[derive(Debug)]
struct Last {
    ipoc: u64,
    /// Since the first packet, s.
    time: f64,
    delay: u32,
    /// Where the program was, m, and its feed, m/s.
    path: f64,
    feed: f64,
    answer: Vec<u8>,
}

/// How a packet follows on the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Begins {
    /// The next period of the weld.
    Period,
    /// Another weld, with RSI still on and the correction in force.
    Weld,
    /// RSI, with nothing corrected.
    Rsi,
}

/// The drives are the controller's.
#[derive(Debug, Clone, Copy)]
struct NoDrives;

impl NoDrives {
    fn command(fault: Option<Fault>) -> DriveCommand<f64> {
        DriveCommand {
            torque: JointVector::zeros(),
            fault,
            force_error: 0.0,
            depth_correction: 0.0,
            push: 0.0,
            limited: Limited::default(),
        }
    }
}

impl HybridController<f64> for NoDrives {
    fn start(&mut self, _: &Robot<f64>, _: &JointVector<f64>, _: &JointVector<f64>) {}

    fn cycle(
        &mut self,
        _: &Robot<f64>,
        _: &Setpoint<f64>,
        _: &SensorReadings<f64>,
    ) -> DriveCommand<f64> {
        Self::command(None)
    }
}

impl<'a> Client<'a> {
    /// A law with the limits of a control file, none larger than `authority_mm` and `authority_deg`:
    /// what the controller would cut off without a word. `silence`: after which the controller has
    /// gone; no gap between two of its packets is longer.
    pub fn new(
        knowledge: Knowledge,
        control: &Control,
        law: &'a mut dyn Compensator<f64>,
        [authority_mm, authority_deg]: [f64; 2],
        silence: Duration,
    ) -> Self {
        let limits = &control.compensation;
        let (mut lateral, mut orientation) = (limits.lateral, limits.orientation);
        lateral.size = lateral.size.min(authority_mm / MM);
        orientation.size = orientation.size.min(authority_deg.to_radians());
        let period = control.period;
        let law = Compensated::new(NoDrives, law, lateral, orientation, period)
            .with_force_sensor_limits(knowledge.force_sensor_limits);
        Self {
            knowledge,
            law,
            period,
            silence,
            counts: ClientCounts::default(),
            malformed: None,
            fault: None,
            inputs: InputCheck::new(&JointVector::zeros()),
            good: 0.0,
            last: None,
            other: None,
            seen: None,
            monitor: None,
        }
    }

    /// The last packet that was answered; `None` before one was.
    pub fn seen(&self) -> Option<Seen> {
        self.seen
    }

    /// What became of the packets.
    pub fn counts(&self) -> ClientCounts {
        self.counts
    }

    /// What is wrong with the first packet that cannot be answered.
    pub fn malformed(&self) -> Option<&PacketError> {
        self.malformed.as_ref()
    }

    /// The first fault, and its time since the first packet, s.
    pub fn fault(&self) -> Option<(f64, Fault)> {
        self.fault
    }

    /// What was left of the seam when the controller fell silent, m: 0 where the program would have
    /// come to its end since. `None` before a packet was answered.
    pub fn unwelded(&self) -> Option<f64> {
        let last = self.last.as_ref()?;
        let left = self.knowledge.seam.length - last.path;
        // A path is known to the packet's five digits.
        let since = last.feed * self.silence.as_secs_f64() + 1e-5 / MM;
        Some(if left <= since { 0.0 } else { left })
    }

    /// The correction in force, axes of W: m and rad.
    pub fn correction(&self) -> Twist<f64> {
        self.law.correction()
    }

    /// The answer to a packet, if it is to be answered.
    pub fn answer(&mut self, packet: &[u8]) -> Option<Vec<u8>> {
        let read = Rob::read(packet).and_then(|packet| match (&packet.weld, packet.commanded) {
            (Some(weld), Some(commanded)) => Ok((weld.clone(), commanded, packet)),
            (None, _) => Err(PacketError::Missing("Weld".to_owned())),
            (_, None) => Err(PacketError::Missing("RSol".to_owned())),
        });
        let (weld, commanded, packet) = match read {
            Ok(read) => read,
            Err(error) => {
                self.counts.malformed += 1;
                self.malformed.get_or_insert(error);
                return None;
            }
        };
        if let Some(last) = self.last.as_ref().filter(|last| last.ipoc == packet.ipoc) {
            self.counts.doubled += 1;
            return Some(last.answer.clone());
        }
        let begins = self.follows(packet.ipoc, packet.delay, weld.path / MM)?;
        let time = self.last.as_ref().map_or(0.0, |last| {
            let since = packet.ipoc.checked_sub(last.ipoc).filter(|_| begins != Begins::Rsi);
            last.time + since.map_or(self.period, |since| since as f64 * 1e-3)
        });
        let answer = self.step(&packet, &weld, &commanded, (begins, time));
        self.counts.answered += 1;
        self.last = Some(Last {
            ipoc: packet.ipoc,
            time,
            delay: packet.delay,
            path: weld.path / MM,
            feed: weld.feed / MM,
            answer: answer.clone(),
        });
        Some(answer)
    }

    /// How a packet with this time stamp, ms, follows on the last one; `None` for one that does not.
    /// `path`: m.
    fn follows(&mut self, ipoc: u64, delay: u32, path: f64) -> Option<Begins> {
        let Some(last) = &self.last else { return Some(Begins::Rsi) };
        let cycle = ((self.period * 1e3).round() as u64).max(1);
        let most_missed = u64::from(CorrectionBounds::default().timeout);
        // How far a time stamp is ahead of another, where it is by no more than so much.
        let ahead = |of: u64, most: u128| {
            ipoc.checked_sub(of).filter(|ahead| *ahead > 0 && u128::from(*ahead) <= most)
        };
        let Some(since) = ahead(last.ipoc, self.silence.as_millis()) else {
            let before = self
                .other
                .filter(|(newest, _)| ahead(*newest, u128::from(cycle * most_missed)).is_some());
            let in_a_row = before.map_or(1, |(_, in_a_row)| in_a_row + 1);
            self.other = (in_a_row < BELIEVED).then_some((ipoc, in_a_row));
            if self.other.is_some() {
                self.counts.out_of_order += 1;
                return None;
            }
            return Some(Begins::Rsi);
        };
        self.other = None;
        let missed = (since / cycle).saturating_sub(1);
        let back = path < last.path - BACK;
        // A controller that ran on missed as many answers, and says so.
        let ran = u64::from(delay) >= missed;
        if !ran && (missed > most_missed || back) {
            return Some(Begins::Rsi);
        }
        self.counts.lost += missed;
        self.counts.late += u64::from(delay > last.delay);
        Some(if back { Begins::Weld } else { Begins::Period })
    }

    /// One period of the law. `time`: since the first packet, s.
    fn step(
        &mut self,
        packet: &Rob,
        weld: &WeldChannels,
        commanded: &Frame,
        (begins, time): (Begins, f64),
    ) -> Vec<u8> {
        let Knowledge { model, seam, process, sensor, .. } = &self.knowledge;
        let encoder = JointVector::from(packet.axes).map(f64::to_radians);
        let torque = weld.torque.into();
        match begins {
            Begins::Period => {}
            Begins::Weld => self.law.start_weld(),
            Begins::Rsi => {
                self.law.start(model, &encoder, &torque);
                (self.inputs, self.good) = (InputCheck::new(&encoder), time);
            }
        }
        if begins != Begins::Period {
            self.monitor = HealthMonitor::new(self.period as f32);
        }
        let since_good = time - self.good;
        let rate = if since_good > 0.0 {
            (encoder - self.inputs.last_good()) / since_good
        } else {
            JointVector::zeros()
        };
        let [fx, fy, fz, mx, my, mz] = weld.wrench;
        let sensed = SensorReadings {
            encoder,
            encoder_rate: rate,
            motor_torque: torque,
            wrench: Wrench { force: Vector3::new(fx, fy, fz), moment: Vector3::new(mx, my, mz) },
        };
        let path = weld.path / MM;
        let base = seam.frame(0.0);
        let setpoint = Setpoint {
            pose: base * frame::to_pose(commanded),
            b_from_w: seam.axes(path),
            force: Some(weld.push),
            spindle_speed: process.spindle,
        };
        let seen: Vec<DeviationMeasurement<f64>> = sensor.as_ref().map_or(Vec::new(), |sensor| {
            weld.seam.iter().map(|reading| measurement(reading, sensor)).collect()
        });
        let observation = Observation {
            setpoint: &setpoint,
            nominal: &seam.nominal(path),
            sensed: &sensed,
            path,
            planned: Wrench {
                moment: Vector3::zeros(),
                force: planned(process, weld.push, weld.feed / MM),
            },
            measurements: &seen,
            taught: None,
        };
        let elapsed = self.last.as_ref().map_or(self.period, |last| time - last.time);
        let command = match self.inputs.check(model, &setpoint, &sensed, elapsed) {
            Ok(()) => self.law.cycle(model, &observation),
            Err(fault) => NoDrives::command(Some(fault)),
        };
        if *self.inputs.last_good() == encoder {
            self.good = time;
        }
        if let Some(fault) = command.fault {
            self.counts.faults += 1;
            self.fault.get_or_insert((time, fault));
        }
        let watch = |monitor: &mut HealthMonitor| monitor.watch(&setpoint, &sensed);
        let row = RecordRow {
            phase: if weld.feed > 0.0 { Phase::Steady } else { Phase::ForceRamp },
            correction_w: self.law.correction(),
            spindle_angle: process.spindle * time,
            health: self.monitor.as_mut().map(watch).unwrap_or_default(),
            limited: command.limited,
            fault: command.fault,
            ..estimated(model, &observation, time)
        };
        self.seen = Some(Seen { sensed, row });
        let to_base = base.rotation.transpose() * setpoint.b_from_w;
        let correction = frame::of_twist(&self.law.correction().rotated(&to_base));
        Sen { correction, ipoc: packet.ipoc, ..Sen::default() }.to_bytes()
    }
}

/// The cell as the model has it from encoders and load; what a controller adds is left empty.
fn estimated(model: &Robot<f64>, observation: &Observation<'_, f64>, time: f64) -> RecordRow {
    let Observation { setpoint, nominal, sensed, path, .. } = *observation;
    let axes = setpoint.b_from_w;
    let bent = model.deflected(&sensed.encoder, &sensed.wrench, 5);
    let deviation_w = nominal.error_to(&bent.real).rotated(&axes.transpose());
    let load = sensed.wrench.rotated(&bent.real.rotation);
    let frames = model.frames(&bent.link);
    let yields = frames.joint_torque(&load).component_div(model.stiffness());
    let across = frames.jacobian().0.fixed_rows::<3>(3).tr_mul(&axes.column(1));
    let force_w = axes.tr_mul(&load.force);
    RecordRow {
        time,
        phase: Phase::Steady,
        path,
        axes,
        nominal: *nominal,
        real: bent.real,
        encoder_pose: bent.encoder,
        deviation_w,
        tilt: deviation_w.angular.xy().norm(),
        lateral_by_joint: across.component_mul(&yields),
        force_w,
        force_sensed_w: force_w,
        force_desired: setpoint.force,
        link: bent.link,
        motor: sensed.encoder,
        torque: sensed.motor_torque,
        spindle_angle: 0.0,
        force_error: setpoint.force.map_or(0.0, |asked| asked + force_w.z),
        depth_correction: 0.0,
        push: 0.0,
        correction_w: Twist::zero(),
        limited: Limited::default(),
        health: HealthSignals::default(),
        fault: None,
    }
}

/// A packet's reading as a law takes it.
fn measurement(reading: &SeamReading, sensor: &SeamSensor) -> DeviationMeasurement<f64> {
    let (deviation, along, noise) = if reading.across {
        let along = Twist { angular: Vector3::z() * sensor.ahead, linear: Vector3::y() };
        (reading.value / MM, along, sensor.noise)
    } else {
        let along = Twist { angular: Vector3::x(), linear: Vector3::zeros() };
        (reading.value.to_radians(), along, sensor.tilt_noise)
    };
    DeviationMeasurement { deviation, along, noise, age: reading.age * 1e-3, ahead: sensor.ahead }
}

/// How serving ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Served {
    /// No packet came at all.
    Nothing,
    /// The controller fell silent.
    Silent,
    /// The socket failed.
    Socket(ErrorKind),
}

/// Answers a controller until no packet of it could be answered for the client's silence, or none at
/// all for `first`. `controller`: its address, at any port; without one the first address with a
/// packet that is answered is the controller's. `answered` is called after every answer.
pub fn serve(
    socket: &UdpSocket,
    client: &mut Client<'_>,
    first: Duration,
    controller: Option<IpAddr>,
    mut answered: impl FnMut(&Client<'_>),
) -> Served {
    let mut buffer = [0; PACKET_BYTES + 1];
    let mut heard: Option<SocketAddr> = None;
    let mut until = Instant::now() + first;
    loop {
        let over = if heard.is_some() { Served::Silent } else { Served::Nothing };
        let left = until.saturating_duration_since(Instant::now());
        // A socket takes no timeout of zero, which would mean for ever.
        if left.is_zero() {
            return over;
        }
        let received =
            socket.set_read_timeout(Some(left)).and_then(|()| socket.recv_from(&mut buffer));
        let (length, from) = match received {
            Ok(received) => received,
            Err(error) => match error.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut => return over,
                ErrorKind::ConnectionRefused | ErrorKind::Interrupted => continue,
                kind => return Served::Socket(kind),
            },
        };
        let is_controller = match controller {
            Some(named) => named.to_canonical() == from.ip().to_canonical(),
            None => heard.is_none_or(|known| known == from),
        };
        if !is_controller {
            client.counts.foreign += 1;
            continue;
        }
        if let Some(answer) = client.answer(&buffer[..length]) {
            heard = Some(from);
            until = Instant::now() + client.silence;
            // An answer that cannot be sent is one that the controller misses.
            let _ = socket.send_to(&answer, from);
            answered(client);
        }
    }
}
