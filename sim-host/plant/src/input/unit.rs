//! Units by the endings of keys and columns.

/// Endings of keys and the units they stand for, longer endings before those they end in.
const KEY_UNITS: &[(&str, &str)] = &[
    ("_nm_rad_s", "N·m/(rad·s)"),
    ("_nms_rad", "N·m·s/rad"),
    ("_nm_rad", "N·m/rad"),
    ("_rad_nm", "rad/(N·m)"),
    ("_kg_m2", "kg·m²"),
    ("_deg_s", "deg/s"),
    ("_rad_s", "rad/s"),
    ("_m_s2", "m/s²"),
    ("_n_m2", "N/m²"),
    ("_ns_m", "N·s/m"),
    ("_m_ns", "m/(N·s)"),
    ("_s_m", "s/m"),
    ("_m_s", "m/s"),
    ("_n_m", "N/m"),
    ("_m_n", "m/N"),
    ("_1_s", "1/s"),
    ("_deg", "deg"),
    ("_rad", "rad"),
    ("_rpm", "1/min"),
    ("_kg", "kg"),
    ("_nm", "N·m"),
    ("_hz", "Hz"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
];

/// A name without the ending that states its unit, and the unit as messages write it.
pub fn unit_suffix(name: &str) -> Option<(&str, &'static str)> {
    KEY_UNITS.iter().find_map(|(suffix, unit)| Some((name.strip_suffix(suffix)?, *unit)))
}

/// The unit that a key or a column states by its ending, as messages write it.
pub fn unit_of(key: &str) -> Option<&'static str> {
    unit_suffix(key).map(|(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_ending_hides_a_longer_one() {
        for (k, (long, unit)) in KEY_UNITS.iter().enumerate() {
            assert_eq!(unit_suffix(&format!("x{long}")), Some(("x", *unit)), "entry {k}");
        }
    }
}
