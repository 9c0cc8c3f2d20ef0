//! The client's end of RSI: a law that drives a robot, simulated or real.

use crate::counts::ClientCounts;
use crate::frame::{self, MM};
use crate::packet::{PACKET_BYTES, Rob, SeamReading, Sen, WeldChannels};
use nalgebra::Vector3;
use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;
use trueweld_core::compensation::{Compensated, Compensator, DeviationMeasurement, Observation};
use trueweld_core::control::{Command, HybridController, Limited, SensorReadings, Setpoint};
use trueweld_core::monitor::{HealthMonitor, HealthSignals};
use trueweld_core::{JointVector, Robot, Twist, Wrench};
use trueweld_plant::input::{Control, Process, SeamSensor};
use trueweld_plant::process::planned;
use trueweld_plant::simulate::{Phase, RecordRow, Seam};

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
}

/// A law at the end of a line: answers packets with its correction.
pub struct Client<'a> {
    knowledge: Knowledge,
    law: Compensated<f64, NoDrives, &'a mut dyn Compensator<f64>>,
    period: f64,
    counts: ClientCounts,
    last: Option<Last>,
    seen: Option<Seen>,
    monitor: Option<HealthMonitor>,
    /// Time stamp of the first packet, ms.
    first: Option<u64>,
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
    encoder: JointVector<f64>,
    delay: u32,
    answer: Vec<u8>,
}

/// The drives are the controller's.
#[derive(Debug, Clone, Copy)]
struct NoDrives;

impl HybridController<f64> for NoDrives {
    fn start(&mut self, _: &Robot<f64>, _: &JointVector<f64>, _: &JointVector<f64>) {}

    fn cycle(
        &mut self,
        _: &Robot<f64>,
        _: &Setpoint<f64>,
        _: &SensorReadings<f64>,
    ) -> Command<f64> {
        Command {
            torque: JointVector::zeros(),
            fault: None,
            force_error: 0.0,
            depth_correction: 0.0,
            push: 0.0,
            limited: Limited::default(),
        }
    }
}

impl<'a> Client<'a> {
    /// A law with the limits of a control file, none larger than `authority_mm` and `authority_deg`:
    /// what the controller would cut off without a word.
    pub fn new(
        knowledge: Knowledge,
        control: &Control,
        law: &'a mut dyn Compensator<f64>,
        [authority_mm, authority_deg]: [f64; 2],
    ) -> Self {
        let limits = &control.compensation;
        let (mut lateral, mut orientation) = (limits.lateral, limits.orientation);
        lateral.size = lateral.size.min(authority_mm / MM);
        orientation.size = orientation.size.min(authority_deg.to_radians());
        let period = control.period;
        Self {
            knowledge,
            law: Compensated::new(NoDrives, law, lateral, orientation, period),
            period,
            counts: ClientCounts::default(),
            last: None,
            seen: None,
            monitor: HealthMonitor::new(period as f32),
            first: None,
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

    /// The correction in force, axes of W: m and rad.
    pub fn correction(&self) -> Twist<f64> {
        self.law.correction()
    }

    /// The answer to a packet, if it is to be answered.
    pub fn answer(&mut self, packet: &[u8]) -> Option<Vec<u8>> {
        let Ok(packet) = Rob::read(packet) else {
            self.counts.malformed += 1;
            return None;
        };
        let Some(weld) = &packet.weld else {
            self.counts.malformed += 1;
            return None;
        };
        let cycle = (self.period * 1e3).round() as u64;
        if let Some(last) = &self.last {
            if packet.ipoc == last.ipoc {
                self.counts.doubled += 1;
                return Some(last.answer.clone());
            }
            if packet.ipoc < last.ipoc {
                self.counts.out_of_order += 1;
                return None;
            }
            self.counts.lost += ((packet.ipoc - last.ipoc) / cycle.max(1)).saturating_sub(1);
            self.counts.late += u64::from(packet.delay > last.delay);
        }
        let answer = self.step(&packet, weld);
        self.counts.answered += 1;
        self.last = Some(Last {
            ipoc: packet.ipoc,
            encoder: JointVector::from(packet.axes).map(f64::to_radians),
            delay: packet.delay,
            answer: answer.clone(),
        });
        Some(answer)
    }

    /// One period of the law.
    fn step(&mut self, packet: &Rob, weld: &WeldChannels) -> Vec<u8> {
        let Knowledge { model, seam, process, sensor } = &self.knowledge;
        let encoder = JointVector::from(packet.axes).map(f64::to_radians);
        let (rate, first) = match &self.last {
            Some(last) => {
                let time = (packet.ipoc - last.ipoc) as f64 * 1e-3;
                ((encoder - last.encoder) / time, false)
            }
            None => (JointVector::zeros(), true),
        };
        let [fx, fy, fz, mx, my, mz] = weld.wrench;
        let sensed = SensorReadings {
            encoder,
            encoder_rate: rate,
            motor_torque: weld.torque.into(),
            wrench: Wrench { force: Vector3::new(fx, fy, fz), moment: Vector3::new(mx, my, mz) },
        };
        if first {
            self.law.start(model, &encoder, &sensed.motor_torque);
        }
        let path = weld.path / MM;
        let base = seam.frame(0.0);
        let setpoint = Setpoint {
            pose: base * frame::to_pose(&weld.commanded),
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
        let command = self.law.cycle(model, &observation);
        self.counts.faults += u64::from(command.fault.is_some());
        let watch = |monitor: &mut HealthMonitor| monitor.watch(&setpoint, &sensed);
        let time = (packet.ipoc - *self.first.get_or_insert(packet.ipoc)) as f64 * 1e-3;
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

/// Answers a controller until it has been silent for `silence`, or none was heard for `first`. The
/// first address with a packet that is answered is the controller's. `answered` is called after
/// every answer.
pub fn serve(
    socket: &UdpSocket,
    client: &mut Client<'_>,
    [first, silence]: [Duration; 2],
    mut answered: impl FnMut(&Client<'_>),
) -> Served {
    let mut buffer = [0; PACKET_BYTES + 1];
    let mut controller: Option<SocketAddr> = None;
    loop {
        let patience = if controller.is_some() { silence } else { first };
        let received =
            socket.set_read_timeout(Some(patience)).and_then(|()| socket.recv_from(&mut buffer));
        let (length, from) = match received {
            Ok(received) => received,
            Err(error) => match (error.kind(), controller) {
                (ErrorKind::WouldBlock | ErrorKind::TimedOut, Some(_)) => return Served::Silent,
                (ErrorKind::WouldBlock | ErrorKind::TimedOut, None) => return Served::Nothing,
                (ErrorKind::ConnectionRefused | ErrorKind::Interrupted, _) => continue,
                (kind, _) => return Served::Socket(kind),
            },
        };
        if controller.is_some_and(|known| known != from) {
            client.counts.foreign += 1;
            continue;
        }
        if let Some(answer) = client.answer(&buffer[..length]) {
            controller = Some(from);
            // An answer that cannot be sent is one that the controller misses.
            let _ = socket.send_to(&answer, from);
            answered(client);
        }
    }
}
