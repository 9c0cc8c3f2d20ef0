//! The text of a robot file, with markers where a URDF says nothing.

use super::arm::{Arm, FixedLink, UrdfBody, UrdfJoint};
use crate::input::{FILL_IN, toml_string};
use nalgebra::{Matrix3, Vector3};
use std::fmt::Write;

/// Words in the name of a fixed frame behind the last joint that make it the tool centre point, the
/// likeliest first.
const TCP_WORDS: &[&str] = &["tcp", "tool", "ee", "eef", "effector", "tool0", "flange"];

/// Words in the name of a fixed frame behind the last joint that make it the flange.
const FLANGE_WORDS: &[&str] = &["flange", "tool0"];

/// Beginning of a comment that is also told.
const NOTE: &str = "# Note: ";

impl Arm {
    /// The text of the robot file.
    pub(super) fn write(&self, name: &str, file: &str) -> String {
        let mut out = String::new();
        let mimics: String =
            self.mimics.iter().map(|said| format!("{NOTE}{}\n", said.escape_debug())).collect();
        let name = if name.trim().is_empty() {
            marker("the URDF has no name for the robot")
        } else {
            toml_string(name)
        };
        // Writing to a String cannot fail, so the results are dropped.
        let _ = writeln!(
            out,
            "# Imported from {}: geometry, masses, inertias, limits and ratings are the URDF's, in its root link's axes.\n\
             # Base B: the root link's frame. At zero every link frame is parallel to B. Units are in the names.\n\
             # What a URDF cannot say is marked {FILL_IN} and must be written before the file can be used.\n\
             {mimics}schema = \"robot/1\"\n\
             name = {name}\n\
             # With the root link upright on the floor: [0.0, 0.0, -9.80665].\n\
             gravity_m_s2 = {}",
            file.escape_debug(),
            marker("the mounting is not in a URDF"),
        );
        let mut before = Vector3::zeros();
        for stage in &self.stages {
            stage.write(&mut out, &before);
            before = stage.origin;
        }
        let unknown = marker("not in a URDF");
        let _ = writeln!(
            out,
            "\n[friction]\nviscous_nms_rad = {unknown}\ncoulomb_nm = {unknown}\nsmoothing_rad_s = {unknown}\n\
             \n# An arm without a counterbalance on A2: cos_nm = []; measured: angle_deg and torque_nm.\n[counterbalance]\ncos_nm = {unknown}",
        );
        if let Some(last) = self.stages.last() {
            last.write_tool(&mut out);
        }
        out
    }
}

impl UrdfJoint {
    fn write(&self, out: &mut String, before: &Vector3<f64>) {
        let unknown = marker("not in a URDF");
        let stiffness = marker(
            "not in a URDF; or rigid in quotes, without damping, where the drive hardly bends",
        );
        let rotor = marker("not in a URDF; or unknown in quotes, which has it fitted");
        let or_marker = |x: Option<f64>| x.map_or_else(|| marker("not stated in the URDF"), number);
        let or_no_inertial = |write: &dyn Fn(&UrdfBody) -> String| {
            self.body.as_ref().map_or_else(|| marker("no <inertial> in the URDF"), write)
        };
        let doubt = match self.body.as_ref().and_then(UrdfBody::doubt) {
            Some(InertiaDoubt::LessThanSteel) => format!(
                "{NOTE}{}: less inertia than a steel ball of its mass has; check its unit.\n",
                self.name.escape_debug()
            ),
            _ => String::new(),
        };
        let limits = match self.limits {
            Some([low, high]) => {
                format!("[{}, {}]", number(low.to_degrees()), number(high.to_degrees()))
            }
            None => marker("not stated in the URDF"),
        };
        let _ = writeln!(
            out,
            "\n[[joint]]\nname = {}\norigin_m = {}\naxis = {}\nlimits_deg = {limits}\nmax_speed_deg_s = {}\n\
             max_torque_nm = {}\nstiffness_nm_rad = {stiffness}\ndamping_nms_rad = {unknown}\n\
             rotor_inertia_kg_m2 = {rotor}\n{doubt}mass_kg = {}\ncom_m = {}\ninertia_kg_m2 = {}",
            if self.name.trim().is_empty() {
                marker("the URDF has no name for the joint")
            } else {
                toml_string(&self.name)
            },
            vector(&(self.origin - before)),
            vector(&self.axis),
            or_marker(self.max_rate.map(f64::to_degrees)),
            or_marker(self.max_torque),
            or_no_inertial(&|body| number(body.mass)),
            or_no_inertial(&|body| vector(&(body.center_of_mass - self.origin))),
            or_no_inertial(&|body| match body.doubt() {
                Some(InertiaDoubt::NoBody) => marker(NO_BODY),
                _ => inertia(&body.inertia),
            }),
        );
    }

    /// The fixed leaf frame that is the tool centre point, with the word that names it, and the frame
    /// that its name would come before, but whose z axis is square to the joint's.
    fn tool(&self) -> (Option<(&'static str, &FixedLink)>, Option<&FixedLink>) {
        let first = self.frame(TCP_WORDS, |f| f.is_bare_leaf);
        let square = first.map(|(_, frame)| frame).filter(|frame| self.is_square(frame));
        // A frame called flange says nothing of its axes.
        let fits = |frame: &FixedLink| frame.is_bare_leaf && !self.is_square(frame);
        match self.frame(TCP_WORDS, fits).filter(|(word, _)| *word != "flange") {
            Some(out) if square.is_some() => (Some(out), square),
            _ => (first, None),
        }
    }

    /// True where z of a frame, which points out of a tool, is square to the joint's axis, to a degree.
    fn is_square(&self, frame: &FixedLink) -> bool {
        let z = frame.b_from_frame.rotation * Vector3::z();
        z.dot(&self.axis).abs() < 1f64.to_radians().sin()
    }

    /// The first frame behind this joint with one of these words in its name, by the order of the
    /// words.
    fn frame(
        &self,
        words: &[&'static str],
        fits: impl Fn(&FixedLink) -> bool,
    ) -> Option<(&'static str, &FixedLink)> {
        // The link that carries the joint itself is no frame on it.
        let frames = self.frames.get(1..).unwrap_or_default();
        let has = |frame: &FixedLink, word: &str| {
            let name = frame.name.to_lowercase();
            name.split(|c: char| !c.is_alphanumeric()).any(|part| part == word)
        };
        let fitting = |word: &str| frames.iter().find(|frame| fits(frame) && has(frame, word));
        words.iter().find_map(|word| Some((*word, fitting(word)?)))
    }

    fn write_tool(&self, out: &mut String) {
        let (tcp, passed_over) = self.tool();
        let flange = self
            .frame(FLANGE_WORDS, |_| true)
            .map(|(_, f)| f.b_from_frame.translation.vector - self.origin);
        let missing = || marker("no fixed leaf frame named tcp, tool0, ee or flange in the URDF");
        let (tcp_from_flange, z_axis, y_axis) = match tcp {
            None => (missing(), missing(), missing()),
            Some((word, frame)) => {
                let at = frame.b_from_frame.translation.vector
                    - self.origin
                    - flange.unwrap_or_default();
                let axis = |a: Vector3<f64>| vector(&(frame.b_from_frame.rotation * a));
                // Makers differ in whether x or z of a frame called flange points out of it.
                let unclear =
                    || marker("a frame named flange does not say which of its axes points out");
                let is_flange = word == "flange";
                let square = || {
                    let name = &frame.name;
                    marker(&format!(
                        "z of {name} is square to the last axis; is it the direction out of the tool? It is {}",
                        axis(Vector3::z())
                    ))
                };
                let z = match (is_flange, self.is_square(frame)) {
                    (true, _) => unclear(),
                    (false, true) => square(),
                    (false, false) => axis(Vector3::z()),
                };
                (vector(&at), z, if is_flange { unclear() } else { axis(Vector3::y()) })
            }
        };
        let origin = match (flange, tcp) {
            (Some(_), _) => "the URDF's flange",
            (None, Some(_)) => {
                "the URDF names no flange, so that the last joint's origin stands in"
            }
            (None, None) => "to be filled in with the tool centre point",
        };
        let offset = match (flange, tcp) {
            (None, None) => missing(),
            _ => vector(&flange.unwrap_or_default()),
        };
        let chosen = match (tcp, passed_over) {
            (Some((_, frame)), Some(other)) => format!(
                "{NOTE}The tool is the URDF's {}. Its {} is passed over: its z axis is square to the last axis.\n",
                frame.name.escape_debug(),
                other.name.escape_debug()
            ),
            (Some((_, frame)), None) if !self.is_square(frame) => format!(
                "{NOTE}The tool is the URDF's {}, its z axis {}.\n",
                frame.name.escape_debug(),
                match self.axis.cross(&(frame.b_from_frame.rotation * Vector3::z())).norm() {
                    across if across < 1f64.to_radians().sin() => "along the last axis",
                    _ => "oblique to the last axis",
                }
            ),
            _ => String::new(),
        };
        let zero = Vector3::zeros();
        let _ = writeln!(
            out,
            "\n# Flange: {origin}.\n# The URDF's bodies behind the last joint are all in its link above, hence a tool\n\
             # without mass: add what the URDF leaves out.\n{chosen}\
             [tool]\nflange_offset_m = {offset}\nmass_kg = 0.0\ncom_from_flange_m = {}\ninertia_kg_m2 = {}\n\
             tcp_from_flange_m = {tcp_from_flange}\nz_axis = {z_axis}\ny_axis = {y_axis}",
            vector(&zero),
            inertia(&Matrix3::zeros()),
        );
    }
}

/// What the inertia of a body cannot be.
#[derive(PartialEq)]
enum InertiaDoubt {
    /// No body has it: none about an axis, or more about one than about the other two together.
    NoBody,
    /// Less than a steel ball of the mass has, the densest body of that mass in an arm.
    LessThanSteel,
}

/// Why an inertia is left open.
const NO_BODY: &str = "in the URDF it is one that no body of this mass has";

impl UrdfBody {
    fn doubt(&self) -> Option<InertiaDoubt> {
        /// kg/m³.
        const STEEL: f64 = 7850.0;
        let moments = self.inertia.symmetric_eigenvalues();
        let (most, all) = (moments.max(), moments.sum());
        // Rounding of printed inertias.
        if self.mass > 0.0 && (moments.min() <= 0.0 || most > (all - most) * 1.01) {
            return Some(InertiaDoubt::NoBody);
        }
        let radius = (0.75 * self.mass / (std::f64::consts::PI * STEEL)).cbrt();
        (all < 3.0 * 0.4 * self.mass * radius.powi(2)).then_some(InertiaDoubt::LessThanSteel)
    }
}

/// A value that the robot reader refuses, with its reason.
fn marker(why: &str) -> String {
    toml_string(&format!("{FILL_IN}: {why}"))
}

/// A number without the noise that turning by π/2 leaves in the last digits.
fn number(x: f64) -> String {
    let rounded = if x.abs() < 1e3 { (x * 1e12).round() / 1e12 } else { x };
    // Adding zero turns −0 into 0.
    format!("{:?}", rounded + 0.0)
}

fn vector(v: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", number(v.x), number(v.y), number(v.z))
}

fn inertia(m: &Matrix3<f64>) -> String {
    let [xx, yy, zz] = [m.m11, m.m22, m.m33].map(number);
    let [xy, xz, yz] = [m.m12, m.m13, m.m23].map(number);
    format!("{{ xx = {xx}, yy = {yy}, zz = {zz}, xy = {xy}, xz = {xz}, yz = {yz} }}")
}
