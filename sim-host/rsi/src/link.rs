//! The simulated controller's end of RSI.
//!
//! A [`Link`] stands where a law stands: asked for a correction it sends `<Rob>`, waits for `<Sen>`,
//! and gives what the guard lets through of the answer to the cycle before: an answer acts in the
//! next cycle. RSI is on while the force loop is closed.

use crate::counts::{Answers, LinkCounts, Timing};
use crate::frame::{self, MM};
use crate::guard::{CorrectionBounds, Guard, StopReason};
use crate::packet::{Element, PACKET_BYTES, PacketError, Rob, SeamReading, Sen, WeldChannels};
use nalgebra::Vector3;
use std::cell::Cell;
use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::rc::Rc;
use std::time::{Duration, Instant};
use trueweld_core::compensation::{Compensator, LoopLimits, Observation};
use trueweld_core::{Fault, JointVector, Pose, Robot, Twist, Wrench};
use trueweld_plant::input::{CompensationLimits, Control};
use trueweld_plant::simulate::Seam;

/// Time stamp of the first packet, ms.
const FIRST_IPOC: u64 = 100_000;

/// How long a cycle is waited for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CycleTimeout {
    /// Each cycle takes its time, and an answer after its end is late.
    RealTime,
    /// A cycle ends with its answer; without one it ends after so long.
    LockStep(Duration),
}

/// Why there is no link.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// A cycle that RSI does not have.
    #[error("RSI has cycles of 4 ms and 12 ms; the control period is {0} ms")]
    Cycle(String),
    /// The socket cannot be used.
    #[error("{what}: {why}")]
    Socket {
        /// What was tried.
        what: String,
        /// What the system says.
        why: String,
    },
}

/// The controller's end of RSI.
#[derive(Debug)]
pub struct Link {
    socket: UdpSocket,
    client: SocketAddr,
    pace: CycleTimeout,
    cycle: Duration,
    /// What a packet has.
    elements: Vec<Element>,
    /// $BASE in B.
    base: Pose<f64>,
    guard: Guard,
    timeout: u32,
    counts: LinkCounts,
    /// Of the first answer that cannot be read.
    malformed: Option<PacketError>,
    answers: Answers,
    ipoc: u64,
    /// Cycles in a row without an answer.
    missed: u32,
    /// When the running cycle began, in real time.
    began: Option<Instant>,
    /// Path of the last cycle, m.
    path: Option<f64>,
    stopped: Rc<Cell<Option<StopReason>>>,
}

/// The file's gains without a law's own limits: what the guard lets through acts at once.
pub fn pass_through(control: &Control) -> Control {
    let free = LoopLimits { bandwidth: 1e9, size: 1.0, rate: 1e9 };
    let following = control.compensation.following;
    Control {
        compensation: CompensationLimits { lateral: free, orientation: free, following },
        ..control.clone()
    }
}

impl Link {
    /// A link from `socket` to a client. `seam`: as the weld was taught, whose frame W at its start
    /// is $BASE; `period`: of control, s; `elements`: what a packet has.
    ///
    /// # Errors
    /// A period that is no cycle of RSI.
    pub fn new(
        socket: UdpSocket,
        client: SocketAddr,
        seam: &Seam,
        period: f64,
        (bounds, pace, elements): (CorrectionBounds, CycleTimeout, &[Element]),
    ) -> Result<Self, LinkError> {
        let milliseconds = period * 1e3;
        let cycle = match milliseconds.round() {
            whole if (whole - milliseconds).abs() > 1e-9 => None,
            4.0 => Some(4),
            12.0 => Some(12),
            _ => None,
        };
        let cycle = cycle.ok_or_else(|| LinkError::Cycle(milliseconds.to_string()))?;
        Ok(Self {
            socket,
            client,
            pace,
            cycle: Duration::from_millis(cycle),
            elements: elements.to_vec(),
            base: seam.frame(0.0),
            guard: Guard::new(bounds),
            timeout: bounds.timeout,
            counts: LinkCounts::default(),
            malformed: None,
            answers: Answers::default(),
            ipoc: FIRST_IPOC,
            missed: 0,
            began: None,
            path: None,
            stopped: Rc::default(),
        })
    }

    /// What became of the packets.
    pub fn counts(&self) -> LinkCounts {
        self.counts
    }

    /// What is wrong with the first answer that cannot be read.
    pub fn malformed(&self) -> Option<&PacketError> {
        self.malformed.as_ref()
    }

    /// Set once RSI has stopped; shared, for whoever drives the run.
    pub fn stopped(&self) -> Rc<Cell<Option<StopReason>>> {
        Rc::clone(&self.stopped)
    }

    fn stop(&mut self, stop: StopReason) {
        if self.stopped.get().is_none() {
            self.stopped.set(Some(stop));
        }
    }

    /// What the controller says of this cycle.
    fn packet(&mut self, robot: &Robot<f64>, observation: &Observation<'_, f64>) -> Rob {
        let base_from_b = self.base.inverse();
        let in_base = |pose: &Pose<f64>| frame::of_pose(&(base_from_b * *pose));
        let sensed = observation.sensed;
        let feed =
            (observation.path - self.path.unwrap_or(observation.path)) / self.cycle.as_secs_f64();
        self.path = Some(observation.path);
        let commanded = &observation.setpoint.pose;
        // A pose out of reach has no axes: those of the encoders stand for it.
        let commanded_axes = robot.inverse_near(commanded, &sensed.encoder);
        let Wrench { force, moment } = sensed.wrench;
        let weld = WeldChannels {
            torque: sensed.motor_torque.into(),
            wrench: [force.x, force.y, force.z, moment.x, moment.y, moment.z],
            path: observation.path * MM,
            feed: feed * MM,
            push: observation.setpoint.force.unwrap_or(0.0),
            seam: observation.measurements.iter().map(reading).collect(),
        };
        let degrees = |axes: &JointVector<f64>| axes.map(f64::to_degrees).into();
        Rob {
            actual: in_base(&robot.forward_kinematics(&sensed.encoder)),
            commanded: Some(in_base(commanded)),
            axes: degrees(&sensed.encoder),
            commanded_axes: Some(degrees(commanded_axes.as_ref().unwrap_or(&sensed.encoder))),
            external: [0.0; 6],
            delay: self.missed,
            weld: Some(weld),
            ipoc: self.ipoc,
        }
    }

    /// Waits for the beginning of a cycle in real time; the end of it.
    fn begin(&mut self) -> Instant {
        let now = Instant::now();
        if let CycleTimeout::LockStep(longest) = self.pace {
            return now + longest;
        }
        let due = self.began.map_or(now, |began| began + self.cycle);
        match due.checked_duration_since(now) {
            Some(left) => std::thread::sleep(left),
            // Where an answer was missed it was waited for to the very end.
            None if self.began.is_some() && self.missed == 0 => self.counts.overruns += 1,
            None => {}
        }
        // A cycle that began late is not made up for.
        let began = due.max(now);
        self.began = Some(began);
        began + self.cycle
    }

    /// Reads what comes until the running cycle is answered or over.
    fn wait(&mut self, end: Instant) -> Option<Sen> {
        let mut buffer = [0; PACKET_BYTES + 1];
        loop {
            let left = end.saturating_duration_since(Instant::now());
            // A socket takes no timeout of zero, which would mean for ever.
            if left.is_zero() || self.socket.set_read_timeout(Some(left)).is_err() {
                return None;
            }
            let (length, from) = match self.socket.recv_from(&mut buffer) {
                Ok(received) => received,
                Err(error) => match error.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut => return None,
                    // Nobody listens at the client's port yet: the system says so here.
                    ErrorKind::ConnectionRefused | ErrorKind::Interrupted => continue,
                    _ => {
                        self.stop(StopReason::Socket);
                        return None;
                    }
                },
            };
            if from != self.client {
                self.counts.foreign += 1;
                continue;
            }
            let answer = match Sen::read(&buffer[..length]) {
                Ok(answer) => answer,
                Err(error) => {
                    self.counts.malformed += 1;
                    self.malformed.get_or_insert(error);
                    continue;
                }
            };
            match self.answers.came(answer.ipoc) {
                Timing::InTime => return Some(answer),
                Timing::Late => self.counts.late += 1,
                Timing::OutOfOrder => self.counts.out_of_order += 1,
                Timing::Doubled => self.counts.doubled += 1,
                Timing::Unknown => self.counts.malformed += 1,
            }
        }
    }

    /// One cycle: a packet out, the answer in.
    fn exchange(&mut self, robot: &Robot<f64>, observation: &Observation<'_, f64>) {
        let end = self.begin();
        let packet = self.packet(robot, observation).to_bytes(&self.elements);
        self.counts.cycles += 1;
        self.answers.sent(self.ipoc);
        // A packet that cannot be sent is one that is not answered.
        let _ = self.socket.send_to(&packet, self.client);
        match self.wait(end) {
            Some(answer) => {
                self.counts.answered += 1;
                self.missed = 0;
                match self.guard.take(&answer.correction, &answer.axes) {
                    Ok(cut) => self.counts.clamped += u64::from(cut),
                    Err(stop) => self.stop(stop),
                }
                if answer.stop {
                    self.stop(StopReason::Asked);
                }
            }
            None => {
                self.missed += 1;
                self.guard.miss();
                if self.missed > self.timeout {
                    self.stop(StopReason::Timeout);
                }
            }
        }
        self.ipoc += self.cycle.as_millis() as u64;
    }
}

/// A measurement as the packet has it.
fn reading(seen: &trueweld_core::compensation::DeviationMeasurement<f64>) -> SeamReading {
    let across = seen.along.linear.y != 0.0;
    let value = if across { seen.deviation * MM } else { seen.deviation.to_degrees() };
    SeamReading { across, value, age: seen.age * 1e3 }
}

/// The displacement that the guard's correction makes of a set-point, axes of W.
fn displacement(
    guard: &Guard,
    base: &Pose<f64>,
    robot: &Robot<f64>,
    observation: &Observation<'_, f64>,
) -> Result<Twist<f64>, Fault> {
    let setpoint = observation.setpoint;
    let to_w = setpoint.b_from_w.transpose();
    let correction = frame::to_twist(&guard.pose).rotated(&base.rotation);
    if guard.axes == [0.0; 6] {
        return Ok(correction.rotated(&to_w));
    }
    // The pose is corrected before the axes are.
    let corrected = setpoint.pose.displaced(&correction);
    let near = &observation.sensed.encoder;
    let angles = robot.inverse_near(&corrected, near).map_err(|_| Fault::Compensation)?;
    let axes = JointVector::from(guard.axes).map(f64::to_radians);
    let pose = robot.forward_kinematics(&(angles + axes));
    Ok(setpoint.pose.error_to(&pose).rotated(&to_w))
}

impl Compensator<f64> for Link {
    fn reset(&mut self) {}

    fn demand(
        &mut self,
        robot: &Robot<f64>,
        observation: &Observation<'_, f64>,
    ) -> Result<Twist<f64>, Fault> {
        // What came in the cycle before acts in this one.
        let acting = self.guard;
        if self.stopped.get().is_none() {
            self.exchange(robot, observation);
        }
        let mut demand = displacement(&acting, &self.base, robot, observation)?;
        // Depth stays with the force loop.
        demand.linear = Vector3::new(demand.linear.x, demand.linear.y, 0.0);
        Ok(demand)
    }
}
