//! The physical effects a cell may have beyond the baseline: one file each, and the table of them.
//!
//! An effect is a [`Term`](crate::robot::Term) at one named port of the plant
//! ([`Port`](crate::robot::Port)), or another number of the robot or the process. Its file holds
//! all that is known of it: equation, parameters with units and plausible ranges, what it looks
//! like in data, and the term. To add one, write its file, and its line in the
//! table below; a crate of one's own hands its effects to [`install`]. What a model file defines
//! itself is in [`custom`].

mod advancing_side;
mod asymmetric_friction;
mod backlash;
mod base_compliance;
mod bearing_tilt;
mod channel_delay;
mod counterbalance_loss;
pub mod curve;
pub mod custom;
mod damping_error;
mod drag_error;
mod draw;
pub mod drive_compliance;
pub mod encoder_offset;
pub mod expression;
mod feed_power_law;
mod fixture_compliance;
pub mod force_crosstalk;
mod force_offset;
mod force_scale;
pub mod formula;
mod friction_error;
pub mod geometry_error;
mod gravity_direction;
mod hysteresis;
mod joint_friction;
mod kind;
mod link_encoder_offset;
mod link_encoder_ripple;
mod load_friction;
mod location;
mod material_step;
pub mod memory;
mod nonlinear_stiffness;
mod parameter;
mod payload_error;
mod plate_waviness;
mod process_stiffness_error;
mod rotor_inertia_error;
mod spindle_harmonic;
pub mod stiffness_error;
mod stribeck;
pub mod table;
mod thermal_drift;
mod thermal_softening;
mod torque_constant;
mod torque_ripple;
mod torque_scale;
pub mod tracker_registration;
mod transmission_error;
mod wrist_coupling;

pub use draw::Draw;
pub use kind::{
    Action, Calibration, CalibrationScope, Effect, EffectError, EffectKind, EffectPlace,
};
pub use location::{Location, LocationKind};
pub use parameter::{Parameter, Role};

use crate::input::{RobotFile, did_you_mean};
use std::sync::OnceLock;

/// The effects of this crate: one line each.
static EFFECTS: &[&EffectKind] = &[
    &stiffness_error::STIFFNESS_ERROR_EFFECT,
    &damping_error::DAMPING_ERROR_EFFECT,
    &nonlinear_stiffness::NONLINEAR_STIFFNESS_EFFECT,
    &backlash::BACKLASH_EFFECT,
    &hysteresis::HYSTERESIS_EFFECT,
    &joint_friction::JOINT_FRICTION_EFFECT,
    &stribeck::STRIBECK_EFFECT,
    &asymmetric_friction::ASYMMETRIC_FRICTION_EFFECT,
    &transmission_error::TRANSMISSION_ERROR_EFFECT,
    &wrist_coupling::WRIST_COUPLING_EFFECT,
    &bearing_tilt::BEARING_TILT_EFFECT,
    &base_compliance::BASE_COMPLIANCE_EFFECT,
    &counterbalance_loss::COUNTERBALANCE_LOSS_EFFECT,
    &payload_error::PAYLOAD_ERROR_EFFECT,
    &encoder_offset::ENCODER_OFFSET_EFFECT,
    &link_encoder_offset::LINK_ENCODER_OFFSET_EFFECT,
    &link_encoder_ripple::LINK_ENCODER_RIPPLE_EFFECT,
    &tracker_registration::TRACKER_REGISTRATION_EFFECT,
    &thermal_drift::THERMAL_DRIFT_EFFECT,
    &force_crosstalk::FORCE_CROSSTALK_EFFECT,
    &force_offset::FORCE_OFFSET_EFFECT,
    &channel_delay::CHANNEL_DELAY_EFFECT,
    &process_stiffness_error::PROCESS_STIFFNESS_ERROR_EFFECT,
    &drag_error::DRAG_ERROR_EFFECT,
    &thermal_softening::THERMAL_SOFTENING_EFFECT,
    &feed_power_law::FEED_POWER_LAW_EFFECT,
    &advancing_side::ADVANCING_SIDE_EFFECT,
    &spindle_harmonic::SPINDLE_HARMONIC_EFFECT,
    &plate_waviness::PLATE_WAVINESS_EFFECT,
    &fixture_compliance::FIXTURE_COMPLIANCE_EFFECT,
    &material_step::MATERIAL_STEP_EFFECT,
    &load_friction::LOAD_FRICTION_EFFECT,
    &torque_ripple::TORQUE_RIPPLE_EFFECT,
    &torque_scale::TORQUE_SCALE_EFFECT,
    &force_scale::FORCE_SCALE_EFFECT,
    &gravity_direction::GRAVITY_DIRECTION_EFFECT,
    &geometry_error::GEOMETRY_ERROR_EFFECT,
    &torque_constant::TORQUE_CONSTANT_EFFECT,
    &rotor_inertia_error::ROTOR_INERTIA_ERROR_EFFECT,
    &friction_error::FRICTION_ERROR_EFFECT,
    &drive_compliance::DRIVE_COMPLIANCE_EFFECT,
];

/// Effects from outside this crate.
static INSTALLED: OnceLock<Vec<&'static EffectKind>> = OnceLock::new();

/// Effects that cannot join the library.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EffectInstallError {
    /// An effect without an identifier.
    #[error("an effect has no identifier: expected `id` to be stated")]
    NoId,
    /// An effect that would do nothing.
    #[error(
        "the effect `{0}` does not state its `action`: expected a term, or a change of robot or process"
    )]
    NoAction(&'static str),
    /// Two effects of one identifier.
    #[error("two effects have the identifier `{0}`")]
    SameId(&'static str),
    /// The library is fixed once something was installed.
    #[error("effects were installed before: a program installs all of its own at once")]
    Again,
}

/// Adds a program's own effects to the library, once and before the library is used: model files,
/// command lines, diagnosis and plans then know them beside this crate's.
///
/// # Errors
/// [`EffectInstallError`].
pub fn install(kinds: Vec<&'static EffectKind>) -> Result<(), EffectInstallError> {
    for (i, kind) in kinds.iter().enumerate() {
        if kind.id.is_empty() {
            return Err(EffectInstallError::NoId);
        }
        if matches!(kind.action, Action::Unstated) {
            return Err(EffectInstallError::NoAction(kind.id));
        }
        if EFFECTS.iter().chain(&kinds[..i]).any(|known| known.id == kind.id) {
            return Err(EffectInstallError::SameId(kind.id));
        }
    }
    INSTALLED.set(kinds).map_err(|_| EffectInstallError::Again)
}

/// Every effect that there is, this crate's first.
pub fn library() -> impl Iterator<Item = &'static EffectKind> + Clone {
    EFFECTS.iter().chain(INSTALLED.get().into_iter().flatten()).copied()
}

impl EffectKind {
    /// The effect of the library with this identifier.
    pub fn of(id: &str) -> Option<&'static Self> {
        library().find(|k| k.id == id)
    }
}

impl Effect {
    /// Reads an effect from a command line, `ID:AT:NAME=VALUE,…`; AT is a joint's name, or empty
    /// for an effect of the whole cell.
    ///
    /// # Errors
    /// [`EffectError`], with what was read and what was expected.
    pub fn parse(text: &str, robot: &RobotFile) -> Result<Self, EffectError> {
        let form = || EffectError::Form { read: text.to_owned() };
        let mut parts = text.splitn(3, ':');
        let (Some(id), Some(at), Some(values)) = (parts.next(), parts.next(), parts.next()) else {
            return Err(form());
        };
        let kind = EffectKind::of(id).ok_or_else(|| EffectError::Unknown {
            read: id.to_owned(),
            known: library().map(|k| k.id).collect::<Vec<_>>().join(", "),
            guess: did_you_mean(id, library().map(|k| k.id)),
        })?;
        let place = kind.at(at, robot)?;
        let mut found = vec![None; kind.parameters.len()];
        for pair in values.split(',') {
            let (name, value) = pair.split_once('=').ok_or_else(form)?;
            let index = kind.parameters.iter().position(|p| p.name == name).ok_or_else(|| {
                let guess = did_you_mean(name, kind.parameters.iter().map(|p| p.name));
                kind.wrong(format!("no parameter `{name}`{guess}"))
            })?;
            let number: f64 =
                value.parse().map_err(|_| kind.wrong(format!("`{value}` is not a number")))?;
            if !number.is_finite() {
                return Err(kind.wrong(format!("{name} = {value} is not finite")));
            }
            let [low, high] = kind.range(index, place, robot.robot.parameters());
            if !(low..=high).contains(&number) {
                return Err(kind.wrong(format!(
                    "{name} = {value} is outside its range here, {low:e} to {high:e}"
                )));
            }
            if found[index].replace(number).is_some() {
                return Err(kind.wrong(format!("{name} is given twice")));
            }
        }
        let missing = |(value, p): (Option<f64>, &Parameter)| {
            value.ok_or_else(|| kind.wrong(format!("{} is missing", p.name)))
        };
        let values =
            found.into_iter().zip(kind.parameters).map(missing).collect::<Result<_, _>>()?;
        Ok(Self { kind, at: place, values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::InputFile;

    #[test]
    fn a_joint_may_have_less_friction_by_all_that_it_has() {
        let text = include_str!("../../../../fixtures/robots/kr500-mt.toml");
        let robot = RobotFile::parse(text, "kr500-mt.toml").unwrap();
        let own = robot.robot.parameters().friction.viscous[1];
        assert!(own > 1000.0, "{own}: more than the parameter's own range");
        let viscous = |share: f64| {
            let value = share * own;
            Effect::parse(
                &format!("joint-friction:A2:coulomb_nm=0,viscous_nms_rad={value}"),
                &robot,
            )
        };
        assert_eq!(viscous(-0.5).unwrap().values[1], -0.5 * own);
        let error = viscous(-1.1).unwrap_err().to_string();
        assert!(error.contains("outside its range here"), "{error}");
    }

    #[test]
    fn an_effect_that_states_too_little_does_not_join() {
        static NAMELESS: EffectKind =
            EffectKind { action: Action::Process(|_, _| {}), ..EffectKind::DEFAULT };
        static IDLE: EffectKind = EffectKind { id: "idle", ..EffectKind::DEFAULT };
        assert_eq!(install(vec![&NAMELESS]), Err(EffectInstallError::NoId));
        assert_eq!(install(vec![&IDLE]), Err(EffectInstallError::NoAction("idle")));
        assert!(library().all(|kind| !matches!(kind.action, Action::Unstated)));
    }
}
