//! Gains of the three hybrid force/position controllers and limits of the compensation:
//! `control/1`.

use super::document::Table;
use super::{Bounds, Document, FileKind, InputError, read_text};
use nalgebra::Vector2;
use std::path::Path;
use trueweld_compensators::{FollowingGains, Prior, TrackingGains};
use trueweld_core::JointVector;
use trueweld_core::compensation::LoopLimits;
use trueweld_core::control::{ExternalGains, ForceGains, JointGains};

/// What the controllers of one cell are set to.
#[derive(Debug, Clone, PartialEq)]
pub struct Control {
    /// Control period, s.
    pub period: f64,
    /// Parallel hybrid control (2.2).
    pub parallel: ParallelGains,
    /// Superposed hybrid control (2.3).
    pub superposed: ParallelGains,
    /// External hybrid control (2.4), (2.5).
    pub external: CascadeGains,
    /// Bounds of the compensation.
    pub compensation: CompensationLimits,
}

/// Gains of a scheme whose force branch gives a force, (2.2) and (2.3).
#[derive(Debug, Clone, PartialEq)]
pub struct ParallelGains {
    /// Position loop.
    pub joint: JointGains<f64>,
    /// Force branch.
    pub force: ForceGains<f64>,
}

/// Gains of the scheme whose force loop gives a depth, (2.4) and (2.5).
#[derive(Debug, Clone, PartialEq)]
pub struct CascadeGains {
    /// Inner position loop.
    pub joint: JointGains<f64>,
    /// Outer force loop.
    pub force: ExternalGains<f64>,
}

/// How far and how fast a compensation law may move the pose set-point.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensationLimits {
    /// Of the translation.
    pub lateral: LoopLimits<f64>,
    /// Of the rotation.
    pub orientation: LoopLimits<f64>,
    /// Corner of the low-pass filter on the measured wrench, Hz.
    pub wrench_filter: f64,
    /// What the force sensor gives along x and y of T per axial force, as it was calibrated.
    pub crosstalk: Vector2<f64>,
    /// Bandwidth of the observer of spring torques, rad/s.
    pub observer: f64,
    /// What makes up for what the position loop lacks of a demand.
    pub following: FollowingGains<f64>,
    /// Seam tracking.
    pub tracking: TrackingGains<f64>,
    /// How well the adaptive law believes the model to be known.
    pub prior: Prior<f64>,
    /// Share of what a pass lacked that the next one gets.
    pub learning: f64,
}

/// The keys of the position loop, common to the three schemes.
const JOINT_KEYS: [&str; 3] = ["position_kp_nm_rad", "position_ki_nm_rad_s", "position_kd_nms_rad"];

impl Control {
    /// Reads a file of gains.
    ///
    /// # Errors
    /// The first thing in it that does not fit, with its place.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, InputError> {
        let (name, text) = read_text(path.as_ref())?;
        Self::parse(&text, &name)
    }

    /// Reads gains from text; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`Control::read`].
    pub fn parse(text: &str, name: &str) -> Result<Self, InputError> {
        let document = Document::parse(text, name)?;
        let root = document.root_of(FileKind::Control.schema())?;
        root.only(&["schema", "period_s", "parallel", "superposed", "external", "compensation"])?;
        Ok(Self {
            period: root.number("period_s", Bounds::PositiveUpTo(1.0))?,
            parallel: parallel(&root.table("parallel")?)?,
            superposed: parallel(&root.table("superposed")?)?,
            external: external(&root.table("external")?)?,
            compensation: compensation(&root.table("compensation")?)?,
        })
    }
}

fn joint(table: &Table<'_>) -> Result<JointGains<f64>, InputError> {
    let [kp, ki, kd] = JOINT_KEYS;
    let gains = |key| table.numbers::<6>(key, Bounds::NonNegative).map(JointVector::from);
    Ok(JointGains { kp: gains(kp)?, ki: gains(ki)?, kd: gains(kd)? })
}

fn parallel(table: &Table<'_>) -> Result<ParallelGains, InputError> {
    let own = [
        "force_kp",
        "force_ki_1_s",
        "force_kd_ns_m",
        "max_force_correction_n",
        "max_push_rate_n_s",
    ];
    table.only(&[&JOINT_KEYS[..], &own].concat())?;
    Ok(ParallelGains {
        joint: joint(table)?,
        force: ForceGains {
            kp: table.number("force_kp", Bounds::NonNegative)?,
            ki: table.number("force_ki_1_s", Bounds::NonNegative)?,
            kd: table.number("force_kd_ns_m", Bounds::NonNegative)?,
            max_correction: table.number("max_force_correction_n", Bounds::Positive)?,
            max_rate: table.number("max_push_rate_n_s", Bounds::Positive)?,
        },
    })
}

fn external(table: &Table<'_>) -> Result<CascadeGains, InputError> {
    let own = [
        "force_kp_m_n",
        "force_ki_m_ns",
        "force_kd_s",
        "material_stiffness_n_m",
        "tuned_stiffness_n_m",
        "max_depth_correction_m",
        "max_depth_rate_m_s",
    ];
    table.only(&[&JOINT_KEYS[..], &own].concat())?;
    Ok(CascadeGains {
        joint: joint(table)?,
        force: ExternalGains {
            kp: table.number("force_kp_m_n", Bounds::NonNegative)?,
            ki: table.number("force_ki_m_ns", Bounds::NonNegative)?,
            kd: table.number("force_kd_s", Bounds::NonNegative)?,
            material_stiffness: table.number("material_stiffness_n_m", Bounds::Positive)?,
            tuned_stiffness: table.number("tuned_stiffness_n_m", Bounds::Positive)?,
            max_correction: table.number("max_depth_correction_m", Bounds::PositiveUpTo(1.0))?,
            max_rate: table.number("max_depth_rate_m_s", Bounds::PositiveUpTo(10.0))?,
        },
    })
}

fn compensation(table: &Table<'_>) -> Result<CompensationLimits, InputError> {
    table.only(&[
        "bandwidth_hz",
        "max_translation_m",
        "max_rotation_rad",
        "max_translation_rate_m_s",
        "max_rotation_rate_rad_s",
        "wrench_filter_hz",
        "following_rad_s",
        "following_max_m",
        "crosstalk",
        "observer_hz",
        "tracking_rad_s",
        "seam_shape_s_m",
        "prior_compliance",
        "prior_force",
        "prior_tilt_rad",
        "prior_lateral_m",
        "learning",
    ])?;
    let bandwidth = table.number("bandwidth_hz", Bounds::Positive)? * std::f64::consts::TAU;
    Ok(CompensationLimits {
        lateral: LoopLimits {
            bandwidth,
            size: table.number("max_translation_m", Bounds::PositiveUpTo(1.0))?,
            rate: table.number("max_translation_rate_m_s", Bounds::PositiveUpTo(10.0))?,
        },
        orientation: LoopLimits {
            bandwidth,
            size: table.number("max_rotation_rad", Bounds::PositiveUpTo(1.0))?,
            rate: table.number("max_rotation_rate_rad_s", Bounds::PositiveUpTo(10.0))?,
        },
        wrench_filter: table.number("wrench_filter_hz", Bounds::Positive)?,
        crosstalk: table.numbers::<2>("crosstalk", Bounds::Any)?.into(),
        observer: table.number("observer_hz", Bounds::Positive)? * std::f64::consts::TAU,
        following: FollowingGains {
            rate: table.number("following_rad_s", Bounds::Positive)?,
            size: table.number("following_max_m", Bounds::PositiveUpTo(1.0))?,
        },
        tracking: TrackingGains {
            rate: table.number("tracking_rad_s", Bounds::Positive)?,
            shape: table.number("seam_shape_s_m", Bounds::NonNegative)?,
        },
        prior: Prior {
            compliance: table.number("prior_compliance", Bounds::PositiveUpTo(10.0))?,
            force: table.number("prior_force", Bounds::PositiveUpTo(10.0))?,
            tilt: table.number("prior_tilt_rad", Bounds::PositiveUpTo(1.0))?,
            lateral: table.number("prior_lateral_m", Bounds::PositiveUpTo(1.0))?,
        },
        learning: table.number("learning", Bounds::PositiveUpTo(1.0))?,
    })
}
