//! The structs of the boundary. A vector of six has its angular part first; matrices are row by row.

use core::ffi::CStr;
use nalgebra::{Matrix3, SVector, Vector3};
use trueweld_compensators::ConfigurationError;
use trueweld_core::compensation::DeviationMeasurement;
use trueweld_core::control::{DriveCommand, SensorReadings, Setpoint};
use trueweld_core::{Fault, Real, Twist, Wrench};

/// Version of the structs and functions.
pub const INTERFACE_VERSION: u32 = 1;

/// Most readings of a seam sensor in one period.
pub const MEASUREMENTS: usize = 8;

/// Alignment of the memory, bytes.
pub const MEMORY_ALIGNMENT: usize = 8;

/// Bytes of memory that are enough for any law in `float`.
pub const MEMORY_BYTES_F32: usize = 32768;

/// Bytes of memory that are enough for any law in `double`.
pub const MEMORY_BYTES_F64: usize = 65536;

/// How a call went. 0: as it should. Above 0: a fault in this period; the outputs hold a torque that
/// is safe to apply. Below 0: the call was wrong; nothing was changed.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// As it should.
    Ok = 0,
    /// The encoder `joint` is no number, or jumped by more than the joint can move.
    FaultEncoder = 1,
    /// The force sensor gave no number, is stuck, is beyond its range, or the drives contradict it.
    FaultForce = 2,
    /// The set-point is no number, its axes are no rotation, or it is far out of reach.
    FaultSetpoint = 3,
    /// The arm is singular here.
    FaultSingular = 4,
    /// The joint `joint` is outside its limits.
    FaultLimit = 5,
    /// The law cannot form a correction, or `nominal` or `path` cannot be; the last one is held.
    FaultCompensation = 6,
    /// A pointer is null.
    Null = -1,
    /// A pointer is not aligned for what it points to; memory: TRUEWELD_MEMORY_ALIGNMENT.
    Alignment = -2,
    /// The memory is too small.
    MemorySize = -3,
    /// The memory holds no core of this scalar: `initialise` comes first.
    NotInitialised = -4,
    /// The core was not started: `start` comes before `cycle`.
    NotStarted = -5,
    /// A struct is of another version.
    Version = -6,
    /// A struct is of another size: compiler or header do not fit the library.
    StructSize = -7,
    /// A count is above its bound, or a flag is neither 0 nor 1.
    Count = -8,
    /// A number is NaN or infinite.
    NotFinite = -9,
    /// The robot of the configuration cannot be one.
    Robot = -10,
    /// A number of the controller's configuration is out of range.
    Control = -11,
    /// The law of the configuration is unknown.
    Law = -12,
    /// A gain of the law is missing, unknown or out of range.
    Gain = -13,
    /// The pose is out of reach.
    Unreachable = -14,
}

/// Every status with its text.
const TEXTS: [(Status, &CStr); 21] = [
    (Status::Ok, c"ok"),
    (Status::FaultEncoder, c"fault: an encoder gave no number, or jumped"),
    (Status::FaultForce, c"fault: the force sensor gave no number, is stuck, beyond its range, or contradicted by the drives"),
    (Status::FaultSetpoint, c"fault: the set-point is no number, no rotation, or far out of reach"),
    (Status::FaultSingular, c"fault: the arm is singular here"),
    (Status::FaultLimit, c"fault: a joint is outside its limits"),
    (Status::FaultCompensation, c"fault: the law cannot form a correction"),
    (Status::Null, c"a pointer is null"),
    (Status::Alignment, c"a pointer is not aligned"),
    (Status::MemorySize, c"the memory is too small"),
    (Status::NotInitialised, c"the memory holds no core of this scalar: call initialise first"),
    (Status::NotStarted, c"the core was not started: call start first"),
    (Status::Version, c"a struct is of another version"),
    (Status::StructSize, c"a struct is of another size: header and library do not fit"),
    (Status::Count, c"a count is above its bound, or a flag is neither 0 nor 1"),
    (Status::NotFinite, c"a number is NaN or infinite"),
    (Status::Robot, c"the robot of the configuration cannot be one"),
    (Status::Control, c"a number of the controller's configuration is out of range"),
    (Status::Law, c"the law of the configuration is unknown"),
    (Status::Gain, c"a gain of the law is missing, unknown or out of range"),
    (Status::Unreachable, c"the pose is out of reach"),
];

/// The text of a status by its number.
pub fn text_of(status: i32) -> &'static CStr {
    let known = TEXTS.iter().find(|(known, _)| *known as i32 == status);
    known.map_or(c"unknown status", |(_, text)| text)
}

impl From<Result<Status, Status>> for Status {
    fn from(result: Result<Status, Status>) -> Self {
        match result {
            Ok(status) | Err(status) => status,
        }
    }
}

impl From<ConfigurationError> for Status {
    fn from(error: ConfigurationError) -> Self {
        match error {
            ConfigurationError::Version => Self::Version,
            ConfigurationError::Size => Self::StructSize,
            ConfigurationError::Robot(_) => Self::Robot,
            ConfigurationError::Control(_) => Self::Control,
            ConfigurationError::Law => Self::Law,
            ConfigurationError::Gain(_) => Self::Gain,
        }
    }
}

/// A struct that begins with its version and its size.
pub trait Versioned {
    /// What it says of itself.
    fn version_and_bytes(&self) -> (u32, u32);
}

/// That a struct is of this interface.
pub fn check<V: Versioned>(given: &V) -> Result<(), Status> {
    let (version, bytes) = given.version_and_bytes();
    if version != INTERFACE_VERSION {
        return Err(Status::Version);
    }
    if bytes as usize != size_of::<V>() {
        return Err(Status::StructSize);
    }
    Ok(())
}

/// A pose: b_from_t, of the tool frame T in the base frame B.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose<T> {
    /// Rotation matrix, row by row.
    pub rotation: [T; 9],
    /// Position, m.
    pub position: [T; 3],
}

/// What an instrument outside the robot saw of the tool's deviation.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement<T> {
    /// What was seen, m or rad.
    pub deviation: T,
    /// The direction that it sees, axes of W: per rad of rotation, then per m of displacement.
    pub along: [T; 6],
    /// Standard deviation of its noise, m or rad.
    pub noise: T,
    /// How long ago it was seen, s.
    pub age: T,
    /// How far ahead of the tool along the seam, m.
    pub ahead: T,
}

/// What one control period is given.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs<T> {
    /// TRUEWELD_INTERFACE_VERSION.
    pub version: u32,
    /// Size of this struct in bytes.
    pub bytes: u32,
    /// 1: the force loop is closed and holds `force`. 0: depth under position control.
    pub force_closed: u32,
    /// How many of the measurements count.
    pub measurement_count: u32,
    /// The set-point of the encoders' pose before correction.
    pub setpoint: Pose<T>,
    /// Where the real tool should be.
    pub nominal: Pose<T>,
    /// Axes of the weld frame W in B, row by row: x along the weld, z into the material.
    pub b_from_w: [T; 9],
    /// Push into the material, N.
    pub force: T,
    /// Rate of the spindle, rad/s; 0 where it stands or is not known.
    pub spindle_speed: T,
    /// Encoder angles, rad.
    pub encoder: [T; 6],
    /// Encoder rates, rad/s.
    pub encoder_rate: [T; 6],
    /// Motor torque of the last period, seen from the joint, N·m; all 0 where it is not known.
    pub motor_torque: [T; 6],
    /// What the environment applies to the tool at the TCP, axes of T: moment N·m, then force N.
    pub wrench: [T; 6],
    /// Where the tool is along the seam, m.
    pub path: T,
    /// The load that the weld is planned with here, axes of W: moment N·m, then force N.
    pub planned: [T; 6],
    /// Readings of a seam sensor since the last period.
    pub measurements: [Measurement<T>; MEASUREMENTS],
}

/// What one control period gives.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs<T> {
    /// TRUEWELD_INTERFACE_VERSION, set by the caller.
    pub version: u32,
    /// Size of this struct in bytes, set by the caller.
    pub bytes: u32,
    /// The joint of a fault, 0 = A1; 6 where a fault is of none.
    pub joint: u32,
    /// What was held at a limit: 1 a drive's torque, 2 the force loop, 4 the compensation, or a sum.
    pub limited: u32,
    /// Motor torque, seen from the joint, N·m.
    pub torque: [T; 6],
    /// Correction of the set-point in force, axes of W: rad, then m.
    pub correction: [T; 6],
    /// Force error as the force loop sees it, N.
    pub force_error: T,
    /// Depth that the external controller adds, m.
    pub depth_correction: T,
    /// Push that the parallel and the superposed controller add, N.
    pub push: T,
}

impl<T> Versioned for Inputs<T> {
    fn version_and_bytes(&self) -> (u32, u32) {
        (self.version, self.bytes)
    }
}

impl<T> Versioned for Outputs<T> {
    fn version_and_bytes(&self) -> (u32, u32) {
        (self.version, self.bytes)
    }
}

impl<T: Real> Pose<T> {
    /// As the core has it.
    pub(crate) fn to_core(self) -> trueweld_core::Pose<T> {
        trueweld_core::Pose {
            rotation: Matrix3::from_row_slice(&self.rotation),
            position: Vector3::from(self.position),
        }
    }

    /// From the core's.
    pub(crate) fn of(pose: &trueweld_core::Pose<T>) -> Self {
        let m = &pose.rotation;
        Self {
            rotation: [m.m11, m.m12, m.m13, m.m21, m.m22, m.m23, m.m31, m.m32, m.m33],
            position: pose.position.into(),
        }
    }
}

fn wrench<T: Real>(six: [T; 6]) -> Wrench<T> {
    Wrench::from_vector(&SVector::from(six))
}

impl<T: Real> Inputs<T> {
    pub(crate) fn setpoint(&self) -> Setpoint<T> {
        Setpoint {
            pose: self.setpoint.to_core(),
            b_from_w: Matrix3::from_row_slice(&self.b_from_w),
            force: (self.force_closed == 1).then_some(self.force),
            spindle_speed: self.spindle_speed,
        }
    }

    pub(crate) fn sensed(&self) -> SensorReadings<T> {
        SensorReadings {
            encoder: self.encoder.into(),
            encoder_rate: self.encoder_rate.into(),
            motor_torque: self.motor_torque.into(),
            wrench: wrench(self.wrench),
        }
    }

    pub(crate) fn planned(&self) -> Wrench<T> {
        wrench(self.planned)
    }

    /// Those of the measurements that count, followed by empty ones.
    pub(crate) fn measurements(&self) -> [DeviationMeasurement<T>; MEASUREMENTS] {
        let zero = T::zero();
        let none = DeviationMeasurement {
            deviation: zero,
            along: Twist::zero(),
            noise: zero,
            age: zero,
            ahead: zero,
        };
        let mut all = [none; MEASUREMENTS];
        let count = self.measurement_count as usize;
        for (to, m) in all.iter_mut().zip(&self.measurements).take(count) {
            *to = DeviationMeasurement {
                deviation: m.deviation,
                along: Twist::from_vector(&SVector::from(m.along)),
                noise: m.noise,
                age: m.age,
                ahead: m.ahead,
            };
        }
        all
    }
}

impl<T: Real> Outputs<T> {
    /// A command with the correction in force.
    pub(crate) fn of(command: &DriveCommand<T>, correction: &Twist<T>) -> (Self, Status) {
        let (status, joint) = match command.fault {
            None => (Status::Ok, 6),
            Some(Fault::Encoder(joint)) => (Status::FaultEncoder, joint),
            Some(Fault::Force) => (Status::FaultForce, 6),
            Some(Fault::Setpoint) => (Status::FaultSetpoint, 6),
            Some(Fault::Singular) => (Status::FaultSingular, 6),
            Some(Fault::Limit(joint)) => (Status::FaultLimit, joint),
            Some(Fault::Compensation) => (Status::FaultCompensation, 6),
        };
        let limited = command.limited;
        let outputs = Self {
            version: INTERFACE_VERSION,
            bytes: size_of::<Self>() as u32,
            joint: joint as u32,
            limited: u32::from(limited.torque)
                | u32::from(limited.force_loop) << 1
                | u32::from(limited.compensation) << 2,
            torque: command.torque.into(),
            correction: correction.to_vector().into(),
            force_error: command.force_error,
            depth_correction: command.depth_correction,
            push: command.push,
        };
        (outputs, status)
    }
}
