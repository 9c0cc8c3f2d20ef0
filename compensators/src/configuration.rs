//! All that a controller's core is built from, as plain numbers: what `trueweld export-core` writes
//! as a constant of Rust or C, so that the controller needs no parser.
//!
//! Laid out as C lays it out. Checked when a core is built from it; its digest covers every number.
//! Left out: combinations of laws.

use crate::gain::{GainError, positive};
use crate::gain_numbers::{GAIN_VALUES, GAINS, GainNumbers, NAME_BYTES, Name, gains};
use crate::law::{GainSet, Setup};
use crate::outer_integral::FollowingGains;
use nalgebra::{Matrix3, SVector};
use sha2::{Digest, Sha256};
use trueweld_core::compensation::LoopLimits;
use trueweld_core::control::{ExternalGains, ForceGains, ForceSensorLimits, JointGains};
use trueweld_core::scalar::lit;
use trueweld_core::{
    COUNTERBALANCE_POINTS, COUNTERBALANCE_TERMS, Counterbalance, Friction, JOINTS, JointParameters,
    ModelError, Real, RobotParameters, ToolParameters,
};

/// Version of the layout: a core takes its own alone.
pub const CONFIGURATION_VERSION: u32 = 3;

// The header of C has no names for these.
const _: () = assert!(
    JOINTS == 6
        && COUNTERBALANCE_TERMS == 8
        && COUNTERBALANCE_POINTS == 24
        && GAINS == 8
        && GAIN_VALUES == 6
        && NAME_BYTES == 32
);

/// What is wrong with a configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConfigurationError {
    /// It is of another version of the layout, or has a number where this one has 0.
    Version,
    /// It is of another size than this version has.
    Size,
    /// The robot cannot be one.
    Robot(ModelError),
    /// This number of the controller is out of range.
    Control(&'static str),
    /// The law is another, or unknown.
    Law,
    /// This gain of the law is out of range.
    Gain(GainError),
}

/// One joint, SI units and rad; see [`JointParameters`].
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointNumbers {
    /// Origin in the previous joint's frame, m.
    pub origin: [f64; 3],
    /// Unit vector of the axis, in the link frame.
    pub axis: [f64; 3],
    /// Lower and upper position limit, rad.
    pub limits: [f64; 2],
    /// Largest speed, rad/s.
    pub max_rate: f64,
    /// Largest drive torque seen from the joint, N·m.
    pub max_torque: f64,
    /// Stiffness of the drive train, N·m/rad.
    pub stiffness: f64,
    /// Damping of the drive train, N·m·s/rad.
    pub damping: f64,
    /// Inertia of motor and gear seen from the joint, kg·m².
    pub rotor_inertia: f64,
    /// Mass of the link, kg.
    pub mass: f64,
    /// Centre of mass in the link frame, m.
    pub center_of_mass: [f64; 3],
    /// Inertia about the centre of mass, axes of the link frame: xx, yy, zz, xy, xz, yz, kg·m².
    pub inertia: [f64; 6],
}

/// The robot as the controller believes it is, SI units and rad; see [`RobotParameters`].
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobotNumbers {
    /// Acceleration of gravity in B, m/s².
    pub gravity: [f64; 3],
    /// The joints, A1 first.
    pub joints: [JointNumbers; 6],
    /// Viscous friction of the motors, N·m·s/rad.
    pub viscous: [f64; 6],
    /// Coulomb friction of the motors, N·m.
    pub coulomb: [f64; 6],
    /// Rate over which the Coulomb friction turns round, rad/s.
    pub smoothing: f64,
    /// How many terms of the counterbalance's cosine series count.
    pub cosine_terms: u32,
    /// How many points of the counterbalance's table count.
    pub table_points: u32,
    /// Terms of the cosine series, N·m.
    pub cosine: [f64; 8],
    /// Angle of A2 that the series counts from, rad.
    pub phase: f64,
    /// Points of the table: angle of A2, rad, and torque, N·m.
    pub table: [[f64; 2]; 24],
    /// Flange centre in the A6 frame, m.
    pub flange_offset: [f64; 3],
    /// Mass of the tool, kg.
    pub tool_mass: f64,
    /// The tool's centre of mass from the flange, m.
    pub tool_center_of_mass: [f64; 3],
    /// The tool's inertia about its centre of mass: xx, yy, zz, xy, xz, yz, kg·m².
    pub tool_inertia: [f64; 6],
    /// Tool centre point from the flange, m.
    pub tcp_from_flange: [f64; 3],
    /// z axis of the tool frame T in axes of the A6 link.
    pub tool_z_axis: [f64; 3],
    /// y axis of the tool frame T in axes of the A6 link.
    pub tool_y_axis: [f64; 3],
}

/// Bounds and speed of a compensation loop; see [`LoopLimits`].
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitNumbers {
    /// Bandwidth, rad/s.
    pub bandwidth: f64,
    /// Largest correction, m or rad.
    pub size: f64,
    /// Largest rate, m/s or rad/s.
    pub rate: f64,
}

/// Which hybrid controller: its number in `ControlNumbers::scheme`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// (2.2).
    Parallel = 1,
    /// (2.3).
    Superposed = 2,
    /// (2.4)–(2.5).
    External = 3,
}

/// Gains and limits of the controller.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlNumbers {
    /// 1: parallel, 2: superposed, 3: external.
    pub scheme: u32,
    /// 0.
    pub reserved: u32,
    /// Control period, s.
    pub period: f64,
    /// K_p of the joint position loop, N·m/rad.
    pub position_kp: [f64; 6],
    /// K_i of the joint position loop, N·m/(rad·s).
    pub position_ki: [f64; 6],
    /// K_d of the joint position loop, N·m·s/rad.
    pub position_kd: [f64; 6],
    /// K_pf of the force loop: N/N, of the external controller m/N.
    pub force_kp: f64,
    /// K_if of the force loop: 1/s, of the external controller m/(N·s).
    pub force_ki: f64,
    /// K_df of the force loop: N·s/m, of the external controller s.
    pub force_kd: f64,
    /// Largest correction of the force loop: N, of the external controller m.
    pub force_max_correction: f64,
    /// Largest rate of the force loop: N/s, of the external controller m/s.
    pub force_max_rate: f64,
    /// Stiffness of the material against depth, N/m. External controller alone.
    pub material_stiffness: f64,
    /// Stiffness that the tool met where the gains were tuned, N/m. External controller alone.
    pub tuned_stiffness: f64,
    /// Of the correction's translation.
    pub lateral: LimitNumbers,
    /// Of the correction's rotation.
    pub orientation: LimitNumbers,
    /// Largest moment that the force sensor can measure, N·m: one that reads as much is at fault. 0:
    /// not known.
    pub force_sensor_moment: f64,
    /// Largest force that the force sensor can measure, N, likewise.
    pub force_sensor_force: f64,
    /// Largest difference between the push that the force sensor shows and the push that the drives
    /// bear, N: beyond it for four periods, the sensor is at fault. 0: not checked.
    pub force_sensor_disagreement: f64,
}

/// The law and its gains.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawNumbers {
    /// Its name, as on the command line.
    pub name: Name,
    /// Length of the weld, m.
    pub length: f64,
    /// Outer integral: μ across the seam, rad/s.
    pub following_rate: f64,
    /// Outer integral: μ along the seam, rad/s.
    pub following_along: f64,
    /// Outer integral: largest |c|, m.
    pub following_size: f64,
    /// How many of the gains count: all that the law has, or none for its defaults.
    pub gain_count: u32,
    /// 0.
    pub reserved: u32,
    /// The gains.
    pub gains: [GainNumbers; 8],
}

/// All that a controller's core is built from.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Configuration {
    /// [`CONFIGURATION_VERSION`].
    pub version: u32,
    /// Size of this struct in bytes.
    pub bytes: u32,
    /// The robot model, with what measurements improved in it.
    pub robot: RobotNumbers,
    /// The controller.
    pub control: ControlNumbers,
    /// The law.
    pub law: LawNumbers,
}

impl Configuration {
    /// Size of the struct in bytes.
    pub const BYTES: u32 = size_of::<Self>() as u32;

    /// Version and size: whether the rest means what it seems to.
    ///
    /// # Errors
    /// [`ConfigurationError::Version`], [`ConfigurationError::Size`].
    pub fn check(&self) -> Result<(), ConfigurationError> {
        let reserved = [self.control.reserved, self.law.reserved];
        let of_gains = self.law.gains.iter().map(|gain| gain.reserved);
        if self.version != CONFIGURATION_VERSION
            || reserved.into_iter().chain(of_gains).any(|r| r != 0)
        {
            return Err(ConfigurationError::Version);
        }
        if self.bytes != Self::BYTES {
            return Err(ConfigurationError::Size);
        }
        Ok(())
    }

    /// SHA-256 of all its numbers, in the order of the fields, little-endian.
    pub fn digest(&self) -> [u8; 32] {
        let Self { version, bytes: _, robot, control, law } = self;
        let mut hash = ConfigurationHash(Sha256::new());
        hash.integer(*version);
        robot.hash(&mut hash);
        control.hash(&mut hash);
        law.hash(&mut hash);
        hash.0.finalize().into()
    }
}

/// SHA-256 over numbers.
struct ConfigurationHash(Sha256);

impl ConfigurationHash {
    // Once in flash, not once a field.
    #[inline(never)]
    fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    fn integer(&mut self, integer: u32) {
        self.bytes(&integer.to_le_bytes());
    }

    #[inline(never)]
    fn numbers(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.bytes(&number.to_le_bytes());
        }
    }

    fn name(&mut self, name: &Name) {
        self.bytes(&name.0);
    }
}

impl RobotNumbers {
    /// The numbers of a robot.
    pub fn of(parameters: &RobotParameters<f64>) -> Self {
        let RobotParameters { gravity, joints, friction, counterbalance, tool } = parameters;
        let mut cosine = [0.0; COUNTERBALANCE_TERMS];
        let mut table = [[0.0; 2]; COUNTERBALANCE_POINTS];
        for (to, from) in cosine.iter_mut().zip(&counterbalance.cosine) {
            *to = *from;
        }
        for (to, from) in table.iter_mut().zip(&counterbalance.table) {
            *to = *from;
        }
        Self {
            gravity: (*gravity).into(),
            joints: joints.each_ref().map(JointNumbers::of),
            viscous: friction.viscous.into(),
            coulomb: friction.coulomb.into(),
            smoothing: friction.smoothing,
            cosine_terms: counterbalance.cosine.len() as u32,
            table_points: counterbalance.table.len() as u32,
            cosine,
            phase: counterbalance.phase,
            table,
            flange_offset: tool.flange_offset.into(),
            tool_mass: tool.mass,
            tool_center_of_mass: tool.com_from_flange.into(),
            tool_inertia: six(&tool.inertia),
            tcp_from_flange: tool.tcp_from_flange.into(),
            tool_z_axis: tool.z_axis.into(),
            tool_y_axis: tool.y_axis.into(),
        }
    }

    /// What a robot is built from, in the scalar `T`.
    ///
    /// # Errors
    /// A counterbalance of more terms or points than there are.
    pub fn parameters<T: Real>(&self) -> Result<RobotParameters<T>, ConfigurationError> {
        const TOO_MANY: ConfigurationError = ConfigurationError::Control("counterbalance");
        let mut counterbalance =
            Counterbalance { phase: lit(self.phase), ..Counterbalance::default() };
        for c in self.cosine.get(..self.cosine_terms as usize).ok_or(TOO_MANY)? {
            counterbalance.cosine.push(lit(*c)).map_err(|_| TOO_MANY)?;
        }
        for point in self.table.get(..self.table_points as usize).ok_or(TOO_MANY)? {
            counterbalance.table.push(point.map(lit)).map_err(|_| TOO_MANY)?;
        }
        Ok(RobotParameters {
            gravity: vector(&self.gravity),
            joints: self.joints.each_ref().map(JointNumbers::parameters),
            friction: Friction {
                viscous: vector(&self.viscous),
                coulomb: vector(&self.coulomb),
                smoothing: lit(self.smoothing),
            },
            counterbalance,
            tool: ToolParameters {
                flange_offset: vector(&self.flange_offset),
                mass: lit(self.tool_mass),
                com_from_flange: vector(&self.tool_center_of_mass),
                inertia: matrix(&self.tool_inertia),
                tcp_from_flange: vector(&self.tcp_from_flange),
                z_axis: vector(&self.tool_z_axis),
                y_axis: vector(&self.tool_y_axis),
            },
        })
    }

    fn hash(&self, hash: &mut ConfigurationHash) {
        let Self {
            gravity, joints, viscous, coulomb, smoothing, cosine_terms, table_points, ..
        } = self;
        let Self { cosine, phase, table, flange_offset, tool_mass, tool_center_of_mass, .. } = self;
        let Self { tool_inertia, tcp_from_flange, tool_z_axis, tool_y_axis, .. } = self;
        hash.numbers(gravity);
        for joint in joints {
            joint.hash(hash);
        }
        hash.numbers(viscous);
        hash.numbers(coulomb);
        hash.numbers(&[*smoothing]);
        hash.integer(*cosine_terms);
        hash.integer(*table_points);
        hash.numbers(cosine);
        hash.numbers(&[*phase]);
        hash.numbers(table.as_flattened());
        hash.numbers(flange_offset);
        hash.numbers(&[*tool_mass]);
        hash.numbers(tool_center_of_mass);
        hash.numbers(tool_inertia);
        hash.numbers(tcp_from_flange);
        hash.numbers(tool_z_axis);
        hash.numbers(tool_y_axis);
    }
}

impl JointNumbers {
    fn of(joint: &JointParameters<f64>) -> Self {
        Self {
            origin: joint.origin.into(),
            axis: joint.axis.into(),
            limits: joint.limits,
            max_rate: joint.max_rate,
            max_torque: joint.max_torque,
            stiffness: joint.stiffness,
            damping: joint.damping,
            rotor_inertia: joint.rotor_inertia,
            mass: joint.mass,
            center_of_mass: joint.center_of_mass.into(),
            inertia: six(&joint.inertia),
        }
    }

    fn parameters<T: Real>(&self) -> JointParameters<T> {
        JointParameters {
            origin: vector(&self.origin),
            axis: vector(&self.axis),
            limits: self.limits.map(lit),
            max_rate: lit(self.max_rate),
            max_torque: lit(self.max_torque),
            stiffness: lit(self.stiffness),
            damping: lit(self.damping),
            rotor_inertia: lit(self.rotor_inertia),
            mass: lit(self.mass),
            center_of_mass: vector(&self.center_of_mass),
            inertia: matrix(&self.inertia),
        }
    }

    fn hash(&self, hash: &mut ConfigurationHash) {
        let Self { origin, axis, limits, max_rate, max_torque, stiffness, damping, .. } = self;
        let Self { rotor_inertia, mass, center_of_mass, inertia, .. } = self;
        hash.numbers(origin);
        hash.numbers(axis);
        hash.numbers(limits);
        hash.numbers(&[*max_rate, *max_torque, *stiffness, *damping, *rotor_inertia, *mass]);
        hash.numbers(center_of_mass);
        hash.numbers(inertia);
    }
}

impl LimitNumbers {
    /// The numbers of limits.
    pub fn of(limits: &LoopLimits<f64>) -> Self {
        Self { bandwidth: limits.bandwidth, size: limits.size, rate: limits.rate }
    }

    pub(crate) fn limits<T: Real>(&self) -> LoopLimits<T> {
        LoopLimits { bandwidth: lit(self.bandwidth), size: lit(self.size), rate: lit(self.rate) }
    }

    fn numbers(&self) -> [f64; 3] {
        [self.bandwidth, self.size, self.rate]
    }
}

impl ControlNumbers {
    /// Which controller; checks all numbers as the scalar `T` has them.
    ///
    /// # Errors
    /// The first that is out of range.
    pub(crate) fn scheme<T: Real>(&self) -> Result<Scheme, ConfigurationError> {
        let all = |numbers: &[f64], good: fn(T) -> bool| numbers.iter().all(|n| good(lit(*n)));
        let usable = |numbers: &[f64]| all(numbers, |n| n.is_finite() && n >= T::zero());
        let above = |numbers: &[f64]| all(numbers, |n| n.is_finite() && n > T::zero());
        let force_sensor =
            [self.force_sensor_moment, self.force_sensor_force, self.force_sensor_disagreement];
        let external = [self.material_stiffness, self.tuned_stiffness];
        let scheme = match self.scheme {
            1 => Scheme::Parallel,
            2 => Scheme::Superposed,
            3 => Scheme::External,
            _ => return Err(ConfigurationError::Control("scheme")),
        };
        let checks = [
            (above(&[self.period]), "period"),
            (usable(&self.position_kp), "position_kp"),
            (usable(&self.position_ki), "position_ki"),
            (usable(&self.position_kd), "position_kd"),
            (usable(&[self.force_kp, self.force_ki, self.force_kd]), "force gains"),
            (above(&[self.force_max_correction, self.force_max_rate]), "force limits"),
            (scheme != Scheme::External || above(&external), "stiffness"),
            (above(&self.lateral.numbers()), "lateral"),
            (above(&self.orientation.numbers()), "orientation"),
            (usable(&force_sensor), "force sensor"),
        ];
        match checks.iter().find(|(good, _)| !good) {
            Some((_, key)) => Err(ConfigurationError::Control(key)),
            None => Ok(scheme),
        }
    }

    pub(crate) fn period<T: Real>(&self) -> T {
        lit(self.period)
    }

    pub(crate) fn joint_gains<T: Real>(&self) -> JointGains<T> {
        JointGains {
            kp: vector(&self.position_kp),
            ki: vector(&self.position_ki),
            kd: vector(&self.position_kd),
        }
    }

    pub(crate) fn force_gains<T: Real>(&self) -> ForceGains<T> {
        ForceGains {
            kp: lit(self.force_kp),
            ki: lit(self.force_ki),
            kd: lit(self.force_kd),
            max_correction: lit(self.force_max_correction),
            max_rate: lit(self.force_max_rate),
        }
    }

    pub(crate) fn external_gains<T: Real>(&self) -> ExternalGains<T> {
        ExternalGains {
            kp: lit(self.force_kp),
            ki: lit(self.force_ki),
            kd: lit(self.force_kd),
            material_stiffness: lit(self.material_stiffness),
            tuned_stiffness: lit(self.tuned_stiffness),
            max_correction: lit(self.force_max_correction),
            max_rate: lit(self.force_max_rate),
        }
    }

    pub(crate) fn force_sensor_limits<T: Real>(&self) -> ForceSensorLimits<T> {
        ForceSensorLimits {
            moment: lit(self.force_sensor_moment),
            force: lit(self.force_sensor_force),
            disagreement: lit(self.force_sensor_disagreement),
        }
    }

    fn hash(&self, hash: &mut ConfigurationHash) {
        let Self { scheme, reserved: _, period, position_kp, position_ki, position_kd, .. } = self;
        let Self { force_kp, force_ki, force_kd, force_max_correction, force_max_rate, .. } = self;
        let Self { material_stiffness, tuned_stiffness, lateral, orientation, .. } = self;
        let Self { force_sensor_moment, force_sensor_force, force_sensor_disagreement, .. } = self;
        hash.integer(*scheme);
        hash.numbers(&[*period]);
        hash.numbers(position_kp);
        hash.numbers(position_ki);
        hash.numbers(position_kd);
        hash.numbers(&[*force_kp, *force_ki, *force_kd, *force_max_correction, *force_max_rate]);
        hash.numbers(&[*material_stiffness, *tuned_stiffness]);
        hash.numbers(&lateral.numbers());
        hash.numbers(&orientation.numbers());
        hash.numbers(&[*force_sensor_moment, *force_sensor_force, *force_sensor_disagreement]);
    }
}

impl LawNumbers {
    /// The numbers of a law with these gains. `None` for more gains than fit.
    pub fn new(
        name: &str,
        gains: &[GainNumbers],
        length: f64,
        following: &FollowingGains,
    ) -> Option<Self> {
        let mut all = [GainNumbers::NONE; GAINS];
        all.get_mut(..gains.len())?.copy_from_slice(gains);
        Some(Self {
            name: Name::new(name),
            length,
            following_rate: following.rate,
            following_along: following.along,
            following_size: following.size,
            gain_count: gains.len() as u32,
            reserved: 0,
            gains: all,
        })
    }

    pub(crate) fn gains<G: GainSet>(&self) -> Result<G, ConfigurationError> {
        let all = self.gains.get(..self.gain_count as usize).ok_or(ConfigurationError::Law)?;
        gains(all).map_err(ConfigurationError::Gain)
    }

    pub(crate) fn setup<T: Real>(&self, period: T) -> Result<Setup<T>, ConfigurationError> {
        let length = lit::<T>(self.length);
        positive(length, "length").map_err(ConfigurationError::Gain)?;
        let following = FollowingGains {
            rate: self.following_rate,
            along: self.following_along,
            size: self.following_size,
        };
        Ok(Setup { period, length, following })
    }

    fn hash(&self, hash: &mut ConfigurationHash) {
        let Self { name, length, following_rate, following_along, following_size, .. } = self;
        let Self { gain_count, reserved: _, gains, .. } = self;
        hash.name(name);
        hash.numbers(&[*length, *following_rate, *following_along, *following_size]);
        hash.integer(*gain_count);
        for GainNumbers { key, count, reserved: _, values } in gains {
            hash.name(key);
            hash.integer(*count);
            hash.numbers(values);
        }
    }
}

fn vector<T: Real, const N: usize>(v: &[f64; N]) -> SVector<T, N> {
    SVector::from(v.map(lit::<T>))
}

fn matrix<T: Real>([xx, yy, zz, xy, xz, yz]: &[f64; 6]) -> Matrix3<T> {
    Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz).map(lit)
}

/// xx, yy, zz, xy, xz, yz of a symmetric matrix.
fn six(m: &Matrix3<f64>) -> [f64; 6] {
    [m.m11, m.m22, m.m33, m.m12, m.m13, m.m23]
}
