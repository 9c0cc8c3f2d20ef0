//! What the tables of a control file have in common, whichever controller they are of.

use crate::input::{
    CascadeGains, CompensationLimits, Control, InputError, ParallelGains, TomlTable,
};
use std::collections::BTreeMap;
use trueweld_core::JointVector;
use trueweld_core::control::{ExternalGains, ForceGains, JointGains};

/// A key of a force branch, and the gain under it.
pub type GainKey<G> = (&'static str, fn(&mut G) -> &mut f64);

/// The keys of the position loop, common to all schemes: K_p, K_i, K_d.
pub const JOINT_KEYS: [&str; 3] =
    ["position_kp_nm_rad", "position_ki_nm_rad_s", "position_kd_nms_rad"];

/// The keys of a scheme whose force branch gives a force.
pub const FORCE_KEYS: [GainKey<ForceGains<f64>>; 5] = [
    ("force_kp", |gains| &mut gains.kp),
    ("force_ki_1_s", |gains| &mut gains.ki),
    ("force_kd_ns_m", |gains| &mut gains.kd),
    ("max_force_correction_n", |gains| &mut gains.max_correction),
    ("max_push_rate_n_s", |gains| &mut gains.max_rate),
];

/// The keys of a scheme whose force loop gives a depth.
pub const DEPTH_KEYS: [GainKey<ExternalGains<f64>>; 7] = [
    ("force_kp_m_n", |gains| &mut gains.kp),
    ("force_ki_m_ns", |gains| &mut gains.ki),
    ("force_kd_s", |gains| &mut gains.kd),
    ("material_stiffness_n_m", |gains| &mut gains.material_stiffness),
    ("tuned_stiffness_n_m", |gains| &mut gains.tuned_stiffness),
    ("max_depth_correction_m", |gains| &mut gains.max_correction),
    ("max_depth_rate_m_s", |gains| &mut gains.max_rate),
];

const NO_FORCE: ForceGains<f64> =
    ForceGains { kp: 0.0, ki: 0.0, kd: 0.0, max_correction: 0.0, max_rate: 0.0 };

/// A control file before the controllers' tables are read: every gain 0.
pub(crate) fn blank(period: f64, compensation: CompensationLimits) -> Control {
    let none = JointVector::zeros();
    let joint = JointGains { kp: none, ki: none, kd: none };
    let parallel = ParallelGains { joint, force: NO_FORCE };
    let external = CascadeGains { joint, force: depth_gains(&NO_FORCE) };
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

/// Gains of the position loop, and of a force branch with these keys. `force`: to be filled.
fn gains<G>(
    table: &TomlTable<'_>,
    keys: &[GainKey<G>],
    mut force: G,
) -> Result<(JointGains<f64>, G), InputError> {
    let own = keys.iter().map(|(key, _)| *key);
    table.only(&JOINT_KEYS.into_iter().chain(own).collect::<Vec<_>>())?;
    let joint = joint(table)?;
    for (key, gain) in keys {
        *gain(&mut force) = table.quantity(key)?;
    }
    Ok((joint, force))
}

/// A scheme whose force branch gives a force.
pub(super) fn parallel(table: &TomlTable<'_>) -> Result<ParallelGains, InputError> {
    let (joint, force) = gains(table, &FORCE_KEYS, NO_FORCE)?;
    Ok(ParallelGains { joint, force })
}

/// A scheme whose force loop gives a depth.
pub(super) fn cascade(table: &TomlTable<'_>) -> Result<CascadeGains, InputError> {
    let (joint, force) = gains(table, &DEPTH_KEYS, depth_gains(&NO_FORCE))?;
    Ok(CascadeGains { joint, force })
}
