//! Gains of the three hybrid force/position controllers and limits of the compensation: `control/1`.

use super::document::Table;
use super::{Bounds, Document, InputError, Kind, read_text};
use std::path::Path;

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
    pub external: ExternalGains,
    /// Bounds of the compensation.
    pub compensation: CompensationLimits,
}

/// Gains of the joint position loop, A1 first.
#[derive(Debug, Clone, PartialEq)]
pub struct JointGains {
    /// K_p, N·m/rad.
    pub kp: [f64; 6],
    /// K_i, N·m/(rad·s).
    pub ki: [f64; 6],
    /// K_d, N·m·s/rad.
    pub kd: [f64; 6],
}

/// Gains of the schemes whose force loop gives a force, (2.2) and (2.3).
#[derive(Debug, Clone, PartialEq)]
pub struct ParallelGains {
    /// Position loop.
    pub joint: JointGains,
    /// K_pf, N of command per N of error.
    pub force_kp: f64,
    /// K_if, 1/s.
    pub force_ki: f64,
    /// K_df against the tool's velocity along its axis, N·s/m.
    pub force_kd: f64,
    /// Largest force that the loop may add to the one asked for, N.
    pub max_force_correction: f64,
}

/// Gains of the scheme whose force loop gives a depth, (2.4) and (2.5).
#[derive(Debug, Clone, PartialEq)]
pub struct ExternalGains {
    /// Inner position loop.
    pub joint: JointGains,
    /// K_pf, m/N.
    pub force_kp: f64,
    /// K_if, m/(N·s).
    pub force_ki: f64,
    /// K_df against the tool's velocity along its axis, s.
    pub force_kd: f64,
    /// Largest depth correction, m.
    pub max_depth_correction: f64,
    /// Largest rate of the depth correction, m/s.
    pub max_depth_rate: f64,
}

/// How far and how fast a compensation law may move the pose set-point.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensationLimits {
    /// Bandwidth of the correction, Hz.
    pub bandwidth: f64,
    /// Largest translation, m.
    pub max_translation: f64,
    /// Largest rotation, rad.
    pub max_rotation: f64,
    /// Largest rate of translation, m/s.
    pub max_translation_rate: f64,
    /// Largest rate of rotation, rad/s.
    pub max_rotation_rate: f64,
    /// Cut-off of the low-pass filter on the measured wrench, Hz.
    pub wrench_filter: f64,
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
        let root = document.root_of(Kind::Control.schema())?;
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

fn joint(table: &Table<'_>) -> Result<JointGains, InputError> {
    let [kp, ki, kd] = JOINT_KEYS;
    Ok(JointGains {
        kp: table.numbers(kp, Bounds::NonNegative)?,
        ki: table.numbers(ki, Bounds::NonNegative)?,
        kd: table.numbers(kd, Bounds::NonNegative)?,
    })
}

fn parallel(table: &Table<'_>) -> Result<ParallelGains, InputError> {
    let own = ["force_kp", "force_ki_1_s", "force_kd_ns_m", "max_force_correction_n"];
    table.only(&[&JOINT_KEYS[..], &own].concat())?;
    Ok(ParallelGains {
        joint: joint(table)?,
        force_kp: table.number("force_kp", Bounds::NonNegative)?,
        force_ki: table.number("force_ki_1_s", Bounds::NonNegative)?,
        force_kd: table.number("force_kd_ns_m", Bounds::NonNegative)?,
        max_force_correction: table.number("max_force_correction_n", Bounds::Positive)?,
    })
}

fn external(table: &Table<'_>) -> Result<ExternalGains, InputError> {
    let own = ["force_kp_m_n", "force_ki_m_ns", "force_kd_s", "max_depth_correction_m", "max_depth_rate_m_s"];
    table.only(&[&JOINT_KEYS[..], &own].concat())?;
    Ok(ExternalGains {
        joint: joint(table)?,
        force_kp: table.number("force_kp_m_n", Bounds::NonNegative)?,
        force_ki: table.number("force_ki_m_ns", Bounds::NonNegative)?,
        force_kd: table.number("force_kd_s", Bounds::NonNegative)?,
        max_depth_correction: table.number("max_depth_correction_m", Bounds::PositiveUpTo(1.0))?,
        max_depth_rate: table.number("max_depth_rate_m_s", Bounds::PositiveUpTo(10.0))?,
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
    ])?;
    Ok(CompensationLimits {
        bandwidth: table.number("bandwidth_hz", Bounds::Positive)?,
        max_translation: table.number("max_translation_m", Bounds::PositiveUpTo(1.0))?,
        max_rotation: table.number("max_rotation_rad", Bounds::PositiveUpTo(1.0))?,
        max_translation_rate: table.number("max_translation_rate_m_s", Bounds::PositiveUpTo(10.0))?,
        max_rotation_rate: table.number("max_rotation_rate_rad_s", Bounds::PositiveUpTo(10.0))?,
        wrench_filter: table.number("wrench_filter_hz", Bounds::Positive)?,
    })
}
