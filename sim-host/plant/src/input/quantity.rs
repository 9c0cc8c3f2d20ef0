//! The quantities that input files and options hold, each with its ranges: one table.
//!
//! A value outside the possible range is refused: nothing good can come of it. One outside the
//! plausible range is taken with a warning, since it is more often a slip or another unit than a
//! cell. The plausible ranges are those of friction stir welding on serial robots from 5 kg to
//! 1000 kg of payload, with room to either side. What a single number cannot tell, numbers together
//! do: [`Relation`](super::relation::Relation).

use std::cell::RefCell;

/// A quantity, by the key under which files state it.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    /// Its key, which ends in the unit. Where one key stands for several quantities: table, dot,
    /// key.
    pub key: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Least and largest value that is taken.
    pub possible: [f64; 2],
    /// Least and largest value that is taken without a warning; of the magnitude, where the value
    /// may be negative. Zero, where it is possible, stands for something that is not there.
    pub plausible: [f64; 2],
}

/// What a range says of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Judgement {
    /// Within the plausible range.
    Plausible,
    /// Within the possible range only.
    Implausible,
    /// Outside the possible range, or not a number.
    Impossible,
}

impl Quantity {
    /// A quantity with its possible and its plausible range.
    pub const fn new(
        key: &'static str,
        possible: [f64; 2],
        plausible: [f64; 2],
        meaning: &'static str,
    ) -> Self {
        Self { key, meaning, possible, plausible }
    }
}

const fn row(
    key: &'static str,
    possible: [f64; 2],
    plausible: [f64; 2],
    meaning: &'static str,
) -> Quantity {
    Quantity::new(key, possible, plausible, meaning)
}

/// No coordinate, direction or product of inertia is refused for its sign.
const fn signed(
    key: &'static str,
    possible: f64,
    plausible: f64,
    meaning: &'static str,
) -> Quantity {
    row(key, [-possible, possible], [0.0, plausible], meaning)
}

/// Every quantity but those of one process alone, which stand with the process.
#[rustfmt::skip]
pub static QUANTITIES: &[Quantity] = &[
    // Robot.
    signed("gravity_m_s2", 100.0, 10.0, "acceleration of gravity"),
    signed("origin_m", 20.0, 5.0, "origin of a joint in the frame before"),
    signed("axis", 1e3, 1.0, "direction of a joint's axis"),
    signed("limits_deg", 1e5, 1080.0, "position limit of a joint"),
    row("max_speed_deg_s", [1e-2, 1e4], [1.0, 1e3], "largest speed of a joint"),
    row("max_torque_nm", [1e-2, 1e7], [1.0, 2e5], "largest torque of a drive, at the joint"),
    row("stiffness_nm_rad", [1.0, 1e11], [1e3, 1e9], "stiffness of a drive train, at the joint"),
    row("damping_nms_rad", [0.0, 1e9], [0.0, 1e6], "damping of a drive train, at the joint"),
    row("rotor_inertia_kg_m2", [1e-6, 1e6], [1e-3, 2e4], "inertia of motor and gear, at the joint"),
    row("mass_kg", [0.0, 1e6], [0.0, 5e3], "mass of a link or of the tool"),
    signed("com_m", 20.0, 5.0, "centre of mass in the link frame"),
    row("xx", [0.0, 1e7], [0.0, 1e4], "moment of inertia, kg·m²"),
    row("yy", [0.0, 1e7], [0.0, 1e4], "moment of inertia, kg·m²"),
    row("zz", [0.0, 1e7], [0.0, 1e4], "moment of inertia, kg·m²"),
    signed("xy", 1e7, 1e4, "product of inertia, kg·m²"),
    signed("xz", 1e7, 1e4, "product of inertia, kg·m²"),
    signed("yz", 1e7, 1e4, "product of inertia, kg·m²"),
    row("viscous_nms_rad", [0.0, 1e8], [0.0, 1e5], "viscous friction of a motor, at the joint"),
    row("coulomb_nm", [0.0, 1e7], [0.0, 2e4], "Coulomb friction of a motor, at the joint"),
    row("smoothing_rad_s", [1e-6, 10.0], [1e-5, 1.0], "rate over which friction turns round"),
    signed("cos_nm", 1e7, 1e5, "cosine term of the counterbalance"),
    signed("angle_deg", 720.0, 360.0, "angle of A2 in the table of the counterbalance"),
    signed("torque_nm", 1e7, 1e5, "torque in the table of the counterbalance"),
    signed("flange_offset_m", 20.0, 3.0, "flange in the frame of the last joint"),
    signed("com_from_flange_m", 20.0, 3.0, "centre of mass of the tool from the flange"),
    signed("tcp_from_flange_m", 20.0, 3.0, "tool centre point from the flange"),
    signed("z_axis", 1e3, 1.0, "axis of the tool"),
    signed("y_axis", 1e3, 1.0, "axis across the tool"),
    // Process.
    // 100 to 4000 turns a minute: a number of these in rad/s is a slip.
    row("spindle_rad_s", [-3200.0, 3200.0], [10.0, 420.0], "speed of the spindle"),
    row("order", [1e-3, 1e4], [0.1, 100.0], "periods of a ripple per turn of the spindle"),
    row("axial", [0.0, 1.0], [0.0, 0.5], "relative ripple of the depth force"),
    row("in_plane", [0.0, 1.0], [0.0, 0.5], "relative ripple of the forces in the plane"),
    signed("phase_rad", 1e4, 7.0, "phase of a ripple or of the counterbalance"),
    // Weld.
    signed("start_m", 1e3, 10.0, "start of the weld"),
    signed("end_m", 1e3, 10.0, "end of the weld"),
    signed("tool_axis", 1e3, 1.0, "direction of the tool"),
    // 30 mm/min to 3 m/min.
    row("feed_m_s", [1e-6, 1.0], [5e-4, 0.05], "speed along the weld"),
    row("feed_ramp_s", [0.0, 1e4], [0.0, 60.0], "time in which the feed rises"),
    // What a robot bears; machines for thick plates push harder.
    row("force_n", [1.0, 1e7], [500.0, 5e4], "depth force"),
    row("force_ramp_s", [0.0, 1e4], [0.0, 60.0], "time in which the force rises"),
    row("initial_depth_m", [0.0, 0.05], [0.0, 5e-3], "depth of the tool at the start"),
    row("settle_s", [0.0, 1e4], [0.0, 60.0], "time before the force loop closes"),
    signed("at_m", 1e3, 10.0, "point of a seam in the part's frame"),
    signed("position_m", 1e3, 10.0, "origin of the part's frame"),
    signed("abc_deg", 360.0, 180.0, "rotation of the part's frame about z, y and x"),
    row("corner_radius_m", [1e-3, 100.0], [0.02, 10.0], "radius of a corner of the seam"),
    signed("lead_deg", 20.0, 5.0, "by how much the spindle leans back along the seam"),
    signed("tilt_deg", 20.0, 5.0, "by how much the spindle leans across the seam"),
    row("dwell_s", [0.0, 1e4], [0.0, 60.0], "time under full push before the feed begins"),
    row("run_out_m", [0.0, 1.0], [0.0, 0.2], "way beyond the end of the seam"),
    row("from_m", [0.0, 1e3], [0.0, 100.0], "where the feed changes"),
    signed("wave_m", 0.02, 5e-3, "amplitude of the real seam's wave"),
    row("wave_length_m", [0.02, 1e3], [0.05, 10.0], "length of the real seam's wave"),
    signed("wave_phase_rad", 1e4, 7.0, "phase of the real seam's wave at the start"),
    // Sensors.
    row("resolution_rad", [0.0, 0.1], [0.0, 1e-3], "step of an encoder"),
    row("noise_n", [0.0, 1e6], [0.0, 1e3], "noise of a force"),
    row("noise_nm", [0.0, 1e6], [0.0, 1e3], "noise of a moment"),
    row("filter_hz", [0.0, 1e6], [0.0, 1e4], "corner of the force sensor's filter"),
    row("delay_s", [0.0, 1.0], [0.0, 0.1], "age of a reading of the force sensor"),
    row("resolution_n", [0.0, 1e5], [0.0, 100.0], "step of a force"),
    row("range_n", [0.0, 1e7], [0.0, 1e6], "largest force that the force sensor reads"),
    row("range_nm", [0.0, 1e7], [0.0, 1e5], "largest moment that the force sensor reads"),
    row("disagreement_n", [0.0, 1e7], [0.0, 1e5], "push by which drives may contradict the force sensor"),
    row("ahead_m", [0.0, 1.0], [0.0, 0.3], "how far ahead the seam sensor looks"),
    row("noise_m", [1e-9, 0.1], [1e-7, 5e-3], "noise of the seam sensor across the seam"),
    row("tilt_noise_rad", [1e-9, 0.1], [1e-6, 0.02], "noise of the seam sensor in tilt"),
    row("seam.period_s", [1e-4, 10.0], [1e-3, 1.0], "time between readings of the seam sensor"),
    row("seam.delay_s", [0.0, 0.3], [0.0, 0.2], "age of a reading of the seam sensor"),
    row("lost", [0.0, 1.0], [0.0, 0.5], "share of readings that are lost"),
    row("noise_factor", [0.0, 100.0], [0.1, 10.0], "real noise of the seam sensor over the stated"),
    signed("zero_m", 0.1, 5e-3, "reading of the seam sensor without a deviation"),
    signed("tilt_zero_rad", 0.5, 0.05, "tilt that the seam sensor reads without one"),
    signed("scale", 0.9, 0.2, "relative error of an instrument's scale"),
    signed("zero_nm", 1e5, 1e3, "moment that the force sensor reads without load"),
    signed("misalignment_rad", 0.5, 0.1, "rotation by which an instrument is mounted off"),
    row("jitter_s", [0.0, 0.5], [0.0, 0.05], "by how much the age of readings varies"),
    row("hidden_delay_s", [0.0, 0.5], [0.0, 0.1], "age of a reading that it does not state"),
    signed("shift_x_m", 0.1, 0.01, "displacement of the real seam from the taught one"),
    signed("shift_y_m", 0.1, 0.01, "displacement of the real seam from the taught one"),
    signed("shift_z_m", 0.1, 0.01, "displacement of the real seam from the taught one"),
    signed("turn_x_rad", 0.1, 0.02, "rotation of the real seam against the taught one"),
    signed("turn_y_rad", 0.1, 0.02, "rotation of the real seam against the taught one"),
    signed("turn_z_rad", 0.1, 0.02, "rotation of the real seam against the taught one"),
    // Controllers.
    row("period_s", [1e-4, 1.0], [5e-4, 0.05], "control period"),
    row("position_kp_nm_rad", [0.0, 1e11], [1e2, 1e9], "proportional gain of a joint"),
    row("position_ki_nm_rad_s", [0.0, 1e12], [0.0, 1e10], "integral gain of a joint"),
    row("position_kd_nms_rad", [0.0, 1e10], [0.0, 1e8], "derivative gain of a joint"),
    row("force_kp", [0.0, 1e3], [0.0, 10.0], "proportional gain of the force"),
    row("force_ki_1_s", [0.0, 1e4], [1e-2, 100.0], "integral gain of the force"),
    row("force_kd_ns_m", [0.0, 1e9], [0.0, 1e7], "derivative gain of the force"),
    row("max_force_correction_n", [1.0, 1e7], [100.0, 1e5], "limit of the force correction"),
    row("max_push_rate_n_s", [1.0, 1e9], [1e3, 1e7], "limit of the rate of the push"),
    row("force_kp_m_n", [0.0, 1e-3], [0.0, 1e-6], "proportional gain of the force loop"),
    row("force_ki_m_ns", [0.0, 1e-2], [1e-9, 1e-4], "integral gain of the force loop"),
    row("force_kd_s", [0.0, 1e3], [0.0, 10.0], "derivative gain of the force loop"),
    row("material_stiffness_n_m", [1e3, 1e11], [1e6, 1e9], "material that the force loop believes in"),
    row("tuned_stiffness_n_m", [1e3, 1e11], [1e5, 1e9], "stiffness that the force loop is tuned for"),
    row("max_depth_correction_m", [1e-6, 1.0], [1e-4, 0.1], "limit of the depth correction"),
    row("max_depth_rate_m_s", [1e-6, 10.0], [1e-4, 1.0], "limit of the rate of the depth correction"),
    row("bandwidth_hz", [1e-3, 1e4], [0.01, 100.0], "bandwidth of the corrections"),
    row("max_translation_m", [1e-6, 1.0], [1e-4, 0.1], "limit of the lateral correction"),
    row("max_rotation_rad", [1e-6, 1.0], [1e-4, 0.2], "limit of the correction of orientation"),
    row("max_translation_rate_m_s", [1e-6, 10.0], [1e-4, 1.0], "limit of its rate"),
    row("max_rotation_rate_rad_s", [1e-6, 10.0], [1e-4, 2.0], "limit of its rate"),
    row("following_rad_s", [1e-3, 1e4], [0.01, 500.0], "bandwidth of following"),
    row("following_along_rad_s", [1e-3, 1e4], [0.01, 500.0], "bandwidth of following"),
    row("following_max_m", [1e-6, 1.0], [1e-5, 0.1], "limit of following"),
    // Options of the command line.
    row("spindle_rpm", [0.0, 3e4], [100.0, 4000.0], "speed of the spindle"),
    row("stiffness_error", [-0.9, 2.0], [0.0, 1.0], "relative error of the stiffness believed in"),
    // Requirements. A limit beyond what a sound weld can ever be off by is refused: nothing fails it.
    row("failure_probability", [1e-6, 0.999], [1e-4, 0.5], "share of welds that may fail"),
    row("confidence", [0.5, 0.999_999], [0.8, 0.9999], "confidence of a certification"),
    // Across and along the seam: half the largest pin, and all of it.
    row("lateral_rms_m", [1e-9, 0.01], [1e-6, 5e-3], "limit of the lateral deviation"),
    row("lateral_max_m", [1e-9, 0.01], [1e-6, 5e-3], "limit of the lateral deviation"),
    row("lateral_before_m", [1e-9, 0.01], [1e-6, 5e-3], "limit of the lateral deviation"),
    row("longitudinal_max_m", [1e-9, 0.02], [1e-5, 0.01], "limit of the deviation along the seam"),
    // The thickest plate.
    row("depth_max_m", [1e-9, 0.025], [1e-5, 5e-3], "limit of the depth"),
    row("depth_rms_m", [1e-9, 0.025], [1e-6, 5e-3], "limit of the deviation in depth"),
    row("depth_error_max_m", [1e-9, 0.025], [1e-5, 5e-3], "limit of the deviation in depth"),
    // Tools are tilted by up to 5°.
    row("tilt_max_rad", [1e-9, 0.175], [1e-6, 0.0875], "limit of the tilt"),
    row("tilt_rms_rad", [1e-9, 0.175], [1e-6, 0.0875], "limit of the tilt"),
    row("side_tilt_rms_rad", [1e-9, 0.175], [1e-6, 0.0875], "limit of the tilt across the seam"),
    row("travel_angle_rms_rad", [1e-9, 0.175], [1e-6, 0.0875], "limit of the tilt along the seam"),
    row("push_error_max_n", [1e-3, 5e4], [1.0, 1e4], "limit of the error of the push"),
    row("push_error_rms_n", [1e-3, 5e4], [1.0, 5e3], "limit of the error of the push"),
    row("correction_m", [1e-9, 0.2], [1e-5, 0.1], "limit of the correction"),
    row("correction_rad", [1e-9, 0.5], [1e-5, 0.2], "limit of the correction"),
    row("measured_push_error_rms_n", [1e-3, 5e4], [1.0, 5e3], "limit of the error of the push as measured"),
    row("push_reading_error_n", [1e-3, 5e4], [1.0, 1e4], "limit of the error of the force sensor"),
    row("push_error_mean_n", [1e-3, 1e7], [1.0, 1e4], "limit of the error of the mean push"),
    row("speed_error_share", [1e-6, 1.0], [1e-4, 0.1], "limit of the relative error of the speed"),
    row("torque_share_max", [1e-3, 1.0], [0.1, 1.0], "limit of a drive's torque over what it may give"),
    row("speed_share_max", [1e-3, 1.0], [0.01, 1.0], "limit of a drive's speed over what it may do"),
    row("at_limit_s", [0.0, 1e4], [0.0, 1e3], "time that a drive may stand at a limit"),
    row("gain_margin", [1e-3, 1e6], [1.0, 100.0], "least gain margin"),
    row("phase_margin_rad", [1e-6, 3.2], [1e-3, 2.0], "least phase margin"),
    row("modulus_margin", [1e-6, 1.0], [1e-3, 1.0], "least modulus margin"),
    row("delay_margin_s", [1e-9, 10.0], [1e-5, 1.0], "least delay margin"),
    row("disk_margin", [1e-6, 10.0], [1e-3, 2.0], "least disk margin"),
    row("drive_gain_margin", [1e-3, 1e6], [1.0, 100.0], "least gain margin of the drives"),
    row("drive_phase_margin_rad", [1e-6, 3.2], [1e-3, 2.0], "least phase margin of the drives"),
    row("drive_modulus_margin", [1e-6, 1.0], [1e-3, 1.0], "least modulus margin of the drives"),
    row("drive_delay_margin_s", [1e-9, 10.0], [1e-5, 1.0], "least delay margin of the drives"),
    row("drive_disk_margin", [1e-6, 10.0], [1e-3, 2.0], "least disk margin of the drives"),
    row("drive_gain_margin_at_speed", [1e-3, 1e6], [1.0, 100.0], "least gain margin of the drives"),
    row("drive_phase_margin_at_speed_rad", [1e-6, 3.2], [1e-3, 2.0], "least phase margin of the drives"),
    row("drive_modulus_margin_at_speed", [1e-6, 1.0], [1e-3, 1.0], "least modulus margin of the drives"),
    row("drive_disk_margin_at_speed", [1e-6, 10.0], [1e-3, 2.0], "least disk margin of the drives"),
];

/// The row of a key.
pub fn quantity(key: &str) -> Option<&'static Quantity> {
    QUANTITIES.iter().find(|q| q.key == key)
}

impl Quantity {
    /// What the ranges say of a value.
    pub fn judge(&self, x: f64) -> Judgement {
        let [least, most] = self.possible;
        let [low, high] = self.plausible;
        if !(x >= least && x <= most) {
            Judgement::Impossible
        } else if x.abs() <= high && (x.abs() >= low || (x == 0.0 && low == 0.0)) {
            Judgement::Plausible
        } else {
            Judgement::Implausible
        }
    }

    /// The possible range in words, with the unit.
    pub fn expected(&self) -> String {
        let [least, most] = self.possible.map(short);
        let unit = self.unit().map(|u| format!(" in {u}")).unwrap_or_default();
        format!("a number from {least} to {most}{unit}")
    }

    /// The plausible range in words.
    pub fn usual(&self) -> String {
        let [low, high] = self.plausible.map(short);
        let of = if self.possible[0] < 0.0 { "a magnitude from " } else { "" };
        let unit = self.unit().map(|u| format!(" {u}")).unwrap_or_default();
        format!("{of}{low} to {high}{unit} ({})", self.meaning)
    }

    fn unit(&self) -> Option<&'static str> {
        super::unit::unit_of(self.key)
    }
}

/// A number with an exponent where it would be long without.
pub(super) fn short(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}

thread_local! {
    /// Values outside their plausible range, as this thread read them. A command reads its inputs on
    /// one thread; its result has its own warnings, whatever else the process reads.
    static WARNINGS: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Notes what a reader of the result should know of its inputs, such as a value outside its plausible
/// range; what is noted again is noted once.
pub fn warn(warning: String) {
    WARNINGS.with_borrow_mut(|warnings| {
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    });
}

/// Checks the value of an option of the command line, as files' values are checked.
///
/// # Errors
/// In words, where the value is outside the possible range.
pub fn check_option(flag: &str, key: &str, value: f64) -> Result<f64, String> {
    let Some(quantity) = quantity(key) else {
        return Err(format!("{flag}: {key} is not in the table of quantities"));
    };
    match quantity.judge(value) {
        Judgement::Plausible => {}
        Judgement::Implausible => {
            warn(format!("{flag} is {}; plausible are {}", short(value), quantity.usual()));
        }
        Judgement::Impossible => {
            return Err(format!("{flag} {value}: expected {}", quantity.expected()));
        }
    }
    Ok(value)
}

/// Every value outside its plausible range that this thread has read: where it stands, what it is,
/// and the range.
pub fn warnings() -> Vec<String> {
    WARNINGS.with_borrow(Clone::clone)
}
