//! Gains of the three hybrid force/position controllers and limits of the compensation:
//! `control/1`.

use super::{FileKind, InputError, InputFile, TomlTable};
use trueweld_compensators::{Entry, FollowingGains, GainTables, Setup, find, library};
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
    /// Gains of the laws, as far as the file states them.
    pub laws: GainTables,
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
    /// What makes up for what the position loop lacks of a demand.
    pub following: FollowingGains,
}

/// The keys of the position loop, common to the three schemes.
const JOINT_KEYS: [&str; 3] = ["position_kp_nm_rad", "position_ki_nm_rad_s", "position_kd_nms_rad"];

impl InputFile for Control {
    const KIND: FileKind = FileKind::Control;

    fn from_root(root: &TomlTable<'_>) -> Result<Self, InputError> {
        root.only(&[
            "schema",
            "period_s",
            "parallel",
            "superposed",
            "external",
            "compensation",
            "law",
        ])?;
        let period = root.quantity("period_s")?;
        let compensation = compensation(&root.table("compensation")?)?;
        Ok(Self {
            period,
            parallel: parallel(&root.table("parallel")?)?,
            superposed: parallel(&root.table("superposed")?)?,
            external: external(&root.table("external")?)?,
            laws: laws(root, &Setup { period, length: 1.0, following: compensation.following })?,
            compensation,
        })
    }
}

impl Control {
    /// What laws are built for, to weld a seam of so many metres.
    pub fn setup(&self, length: f64) -> Setup<f64> {
        Setup { period: self.period, length, following: self.compensation.following }
    }
}

/// Where the range of a gain comes from.
const GAIN_RANGE_SOURCE: &str =
    "The law cannot be built with this gain at the control period of this file.";

/// The `[law.NAME]` tables: each must name a law and gains that the law has, with values that it
/// can be built with.
fn laws(root: &TomlTable<'_>, setup: &Setup<f64>) -> Result<GainTables, InputError> {
    let mut gains = GainTables::new();
    if !root.has("law") {
        return Ok(gains);
    }
    let laws = root.table("law")?;
    let combined = laws.keys().into_iter().filter(|name| find(name).is_ok());
    let known: Vec<&str> = library().iter().map(Entry::name).chain(combined).collect();
    laws.only(&known)?;
    for law in laws.keys().into_iter().flat_map(find) {
        let table = laws.table(law.name())?;
        gains.insert(law.name().to_owned(), table.like(&law.defaults())?);
        law.build(&gains, setup).map_err(|error| match error.key {
            Some(key) if table.has(key) => table.wrong(key, &error.problem, GAIN_RANGE_SOURCE),
            _ => laws.wrong(law.name(), "gains that suit the law", error.to_string()),
        })?;
    }
    Ok(gains)
}

fn joint(table: &TomlTable<'_>) -> Result<JointGains<f64>, InputError> {
    let [kp, ki, kd] = JOINT_KEYS;
    let gains = |key| table.quantities::<6>(key).map(JointVector::from);
    Ok(JointGains { kp: gains(kp)?, ki: gains(ki)?, kd: gains(kd)? })
}

fn parallel(table: &TomlTable<'_>) -> Result<ParallelGains, InputError> {
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
            kp: table.quantity("force_kp")?,
            ki: table.quantity("force_ki_1_s")?,
            kd: table.quantity("force_kd_ns_m")?,
            max_correction: table.quantity("max_force_correction_n")?,
            max_rate: table.quantity("max_push_rate_n_s")?,
        },
    })
}

fn external(table: &TomlTable<'_>) -> Result<CascadeGains, InputError> {
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
            kp: table.quantity("force_kp_m_n")?,
            ki: table.quantity("force_ki_m_ns")?,
            kd: table.quantity("force_kd_s")?,
            material_stiffness: table.quantity("material_stiffness_n_m")?,
            tuned_stiffness: table.quantity("tuned_stiffness_n_m")?,
            max_correction: table.quantity("max_depth_correction_m")?,
            max_rate: table.quantity("max_depth_rate_m_s")?,
        },
    })
}

fn compensation(table: &TomlTable<'_>) -> Result<CompensationLimits, InputError> {
    table.only(&[
        "bandwidth_hz",
        "max_translation_m",
        "max_rotation_rad",
        "max_translation_rate_m_s",
        "max_rotation_rate_rad_s",
        "following_rad_s",
        "following_along_rad_s",
        "following_max_m",
    ])?;
    let bandwidth = table.quantity("bandwidth_hz")? * std::f64::consts::TAU;
    Ok(CompensationLimits {
        lateral: LoopLimits {
            bandwidth,
            size: table.quantity("max_translation_m")?,
            rate: table.quantity("max_translation_rate_m_s")?,
        },
        orientation: LoopLimits {
            bandwidth,
            size: table.quantity("max_rotation_rad")?,
            rate: table.quantity("max_rotation_rate_rad_s")?,
        },
        following: FollowingGains {
            rate: table.quantity("following_rad_s")?,
            along: if table.has("following_along_rad_s") {
                table.quantity("following_along_rad_s")?
            } else {
                table.quantity("following_rad_s")?
            },
            size: table.quantity("following_max_m")?,
        },
    })
}
