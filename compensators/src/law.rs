//! What a law states besides its equations.

use crate::FollowingGains;
use crate::gain::GainError;
use trueweld_core::Real;
use trueweld_core::compensation::Compensator;

/// A law as programs list it. The implementor is the type that the law's file is about;
/// [`Law::Built`] is that type with whatever stands below and above it.
pub trait Law<T: Real> {
    /// Its name on the command line, in control files and in results: lower case, with hyphens.
    const NAME: &'static str;

    /// What it does, in one line.
    const SUMMARY: &'static str;

    /// What it reads or keeps.
    const NEEDS: Needs = Needs::NOTHING;

    /// Those of its gains that set how fast it acts: with all of them multiplied by a factor the law
    /// is that much faster. What tunes laws turns these.
    const BANDWIDTH_GAINS: &'static [&'static str] = &[];

    /// Its gains, `[law.NAME]` of a control file: a struct with the unit in the name of each field.
    /// The default is what holds where the file is silent. [`NoGains`] for none.
    type Gains: GainSet;

    /// The law as it runs.
    type Built: Compensator<T> + Send + 'static;

    /// The law as it is before its first weld.
    ///
    /// # Errors
    /// The first gain that is out of range, or does not suit the control period.
    fn build(gains: &Self::Gains, setup: &Setup<T>) -> Result<Self::Built, GainError>;
}

/// Gains with defaults; with a configuration they are also read from its numbers or from a file.
#[cfg(not(feature = "configuration"))]
pub trait GainSet: Default {}
#[cfg(not(feature = "configuration"))]
impl<G: Default> GainSet for G {}

/// Gains with defaults that are read from a file, or from the numbers of a configuration.
#[cfg(feature = "configuration")]
pub trait GainSet: Default + serde::Serialize + serde::de::DeserializeOwned {}
#[cfg(feature = "configuration")]
impl<G: Default + serde::Serialize + serde::de::DeserializeOwned> GainSet for G {}

/// The gains of a law without gains.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "configuration", derive(serde::Serialize, serde::Deserialize))]
pub struct NoGains {}

/// What a law reads, besides encoders, set-point and planned load, and what it keeps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Needs {
    /// A six-axis force sensor. Such a law is a positive feedback through the material.
    pub force_sensor: bool,
    /// Motor torques. Such a law is a positive feedback through the material.
    pub motor_torque: bool,
    /// A seam sensor: without one the law is no better than the one inside it, and is refused.
    pub seam_sensor: bool,
    /// Several passes: it keeps something from one weld of a seam to the next.
    pub passes: bool,
}

impl Needs {
    /// Neither sensor nor passes.
    pub const NOTHING: Self =
        Self { force_sensor: false, motor_torque: false, seam_sensor: false, passes: false };
}

/// What a law is built for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup<T: Real> {
    /// Control period, s.
    pub period: T,
    /// Length of the weld, m.
    pub length: T,
    /// Gains of the outer integral, for laws that are built with one.
    pub following: FollowingGains,
}

impl<T: Real> Setup<T> {
    /// With the outer integral's defaults. `period`: of control, s; `length`: of the weld, m.
    pub fn new(period: T, length: T) -> Self {
        Self { period, length, following: FollowingGains::default() }
    }
}
