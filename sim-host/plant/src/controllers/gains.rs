//! What the tables of a control file have in common, whichever controller they are of.

use crate::input::{
    CascadeGains, CompensationLimits, Control, InputError, ParallelGains, TomlTable,
};
use std::collections::BTreeMap;
use trueweld_core::JointVector;
use trueweld_core::control::{ExternalGains, ForceGains, JointGains};

/// The keys of the position loop, common to all schemes.
const JOINT_KEYS: [&str; 3] = ["position_kp_nm_rad", "position_ki_nm_rad_s", "position_kd_nms_rad"];

/// A control file before the controllers' tables are read: every gain 0.
pub(crate) fn blank(period: f64, compensation: CompensationLimits) -> Control {
    let none = JointVector::zeros();
    let joint = JointGains { kp: none, ki: none, kd: none };
    let force = ForceGains { kp: 0.0, ki: 0.0, kd: 0.0, max_correction: 0.0, max_rate: 0.0 };
    let parallel = ParallelGains { joint, force };
    let external = CascadeGains { joint, force: depth_gains(&force) };
    Control {
        period,
        superposed: parallel.clone(),
        parallel,
        external,
        others: BTreeMap::new(),
        compensation,
        laws: BTreeMap::new(),
    }
}

/// The gains of a force branch; it knows no stiffness.
pub(super) fn depth_gains(gains: &ForceGains<f64>) -> ExternalGains<f64> {
    ExternalGains {
        kp: gains.kp,
        ki: gains.ki,
        kd: gains.kd,
        material_stiffness: 0.0,
        tuned_stiffness: 0.0,
        max_correction: gains.max_correction,
        max_rate: gains.max_rate,
    }
}

fn joint(table: &TomlTable<'_>) -> Result<JointGains<f64>, InputError> {
    let [kp, ki, kd] = JOINT_KEYS;
    let gains = |key| table.quantities::<6>(key).map(JointVector::from);
    Ok(JointGains { kp: gains(kp)?, ki: gains(ki)?, kd: gains(kd)? })
}

/// A scheme whose force branch gives a force.
pub(super) fn parallel(table: &TomlTable<'_>) -> Result<ParallelGains, InputError> {
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

/// A scheme whose force loop gives a depth.
pub(super) fn cascade(table: &TomlTable<'_>) -> Result<CascadeGains, InputError> {
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
