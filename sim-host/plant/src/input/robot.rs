//! The robot with its tool: `robot/1`.

use super::{Bounds, FileKind, InputError, InputFile, TomlTable};
use nalgebra::{Matrix3, Vector3};
use trueweld_core::{
    COUNTERBALANCE_POINTS, COUNTERBALANCE_TERMS, Counterbalance, Friction, JOINTS, JointParameters,
    ModelError, Robot, RobotParameters, ToolParameters,
};

/// A robot file: the model and the names that reports show.
#[derive(Debug, Clone)]
pub struct RobotFile {
    /// Name of the robot.
    pub name: String,
    /// Names of the joints, from the base on.
    pub joint_names: [String; JOINTS],
    /// Joints whose drives are stated to be rigid: their springs only follow from that.
    pub rigid: [bool; JOINTS],
    /// Joints whose rotor inertia is stated to be unknown: it is taken to match that of their links.
    pub unknown_rotor: [bool; JOINTS],
    /// What the file states, in SI units and rad, and what follows from that.
    pub parameters: RobotParameters<f64>,
    /// The checked model built from the parameters.
    pub robot: Robot<f64>,
}

/// The model follows from the parameters, so that equal names and parameters are equal files.
impl PartialEq for RobotFile {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
            && self.joint_names == other.joint_names
            && self.parameters == other.parameters
    }
}

impl InputFile for RobotFile {
    const KIND: FileKind = FileKind::Robot;

    fn from_root(root: &TomlTable<'_>) -> Result<Self, InputError> {
        root.only(&[
            "schema",
            "name",
            "gravity_m_s2",
            "joint",
            "friction",
            "counterbalance",
            "tool",
        ])?;
        let robot_name = root.name("name")?;
        let gravity = root.vector("gravity_m_s2")?;

        let unnamed = root.tables("joint")?;
        if unnamed.len() != JOINTS {
            // At the first joint too many, or at the last one there is.
            let at = unnamed.get(JOINTS).or(unnamed.last()).unwrap_or(root);
            let message = format!(
                "ends a list of {} joints; expected {JOINTS} [[joint]] tables",
                unnamed.len()
            );
            return Err(
                at.error(&message, "The arm has six revolute joints, A1 to A6, from the base on.")
            );
        }
        let mut tables = Vec::with_capacity(JOINTS);
        let mut joint_names: [String; JOINTS] = Default::default();
        for (i, table) in unnamed.into_iter().enumerate() {
            let joint_name = table.name("name")?;
            if joint_names[..i].contains(&joint_name) {
                return Err(table.wrong(
                    "name",
                    "a name that no other joint has",
                    "Name the joints A1 to A6.",
                ));
            }
            tables.push(table.called(&joint_name));
            joint_names[i] = joint_name;
        }
        let joints = tables.iter().map(joint).collect::<Result<Vec<_>, _>>()?;
        let Ok(joints) = <[_; JOINTS]>::try_from(joints) else {
            return Err(root.error(
                "has another number of joints than six",
                "The arm has six revolute joints.",
            ));
        };

        let friction_table = root.table("friction")?;
        let counterbalance_table = root.table("counterbalance")?;
        let tool_table = root.table("tool")?;
        let rigid = [0, 1, 2, 3, 4, 5].map(|i| says(&tables[i], "stiffness_nm_rad", RIGID));
        let unknown_rotor =
            [0, 1, 2, 3, 4, 5].map(|i| says(&tables[i], "rotor_inertia_kg_m2", UNKNOWN));
        let mut parameters = RobotParameters {
            gravity,
            joints,
            friction: friction(&friction_table)?,
            counterbalance: counterbalance(&counterbalance_table)?,
            tool: tool(&tool_table)?,
        };
        let build = |parameters: &RobotParameters<f64>| {
            Robot::new(parameters.clone()).map_err(|error| {
                explain(error, parameters, root, &tables, &friction_table, &tool_table)
            })
        };
        let mut robot = build(&parameters)?;
        if rigid.contains(&true) || unknown_rotor.contains(&true) {
            let inertia = felt_inertia(&robot);
            for (i, joint) in parameters.joints.iter_mut().enumerate() {
                if rigid[i] {
                    joint.stiffness = inertia[i] * RIGID_RATE * RIGID_RATE;
                    joint.damping = inertia[i] * RIGID_RATE;
                }
                if unknown_rotor[i] {
                    joint.rotor_inertia = inertia[i];
                }
            }
            robot = build(&parameters)?;
        }
        Ok(Self { name: robot_name, joint_names, rigid, unknown_rotor, parameters, robot })
    }
}

/// What a robot file says of a drive without a spring worth the name, and of a rotor whose inertia
/// nobody stated.
const RIGID: &str = "rigid";
const UNKNOWN: &str = "unknown";

/// Rate at which a link swings on a rigid drive by itself, rad/s: at the 8 Hz below which torques are
/// compared it is off by (8/500)², less than any instrument.
const RIGID_RATE: f64 = std::f64::consts::TAU * 500.0;

/// True where a value is this word.
fn says(table: &TomlTable<'_>, key: &str, word: &str) -> bool {
    table.has(key) && table.text(key).is_ok_and(|text| text.text == word)
}

/// The inertia of links that each joint feels with the other joints free, 1/(M⁻¹)_jj, kg·m²: the
/// least of it at postures between the limits.
fn felt_inertia(robot: &Robot<f64>) -> [f64; JOINTS] {
    const INERTIA_POSTURES: usize = 8;
    let mut least = [f64::INFINITY; JOINTS];
    for k in 0..=INERTIA_POSTURES {
        let share = k as f64 / INERTIA_POSTURES as f64;
        let posture = trueweld_core::JointVector::from_fn(|i, _| {
            let [low, high] = robot.parameters().joints[i].limits;
            low + (high - low) * share
        });
        if let Some(inverse) = robot.crba(&robot.frames(&posture)).try_inverse() {
            for (j, least) in least.iter_mut().enumerate() {
                *least = least.min(1.0 / inverse[(j, j)]);
            }
        }
    }
    least
}

fn joint(table: &TomlTable<'_>) -> Result<JointParameters<f64>, InputError> {
    table.only(&[
        "name",
        "origin_m",
        "axis",
        "limits_deg",
        "max_speed_deg_s",
        "max_torque_nm",
        "stiffness_nm_rad",
        "damping_nms_rad",
        "rotor_inertia_kg_m2",
        "mass_kg",
        "com_m",
        "inertia_kg_m2",
    ])?;
    // Placeholders, until the inertia of the links is known.
    let is_rigid = says(table, "stiffness_nm_rad", RIGID);
    if is_rigid && table.has("damping_nms_rad") {
        let help = "A rigid drive has neither spring nor damper: take it out.";
        return Err(table.wrong("damping_nms_rad", "nothing beside a rigid drive", help));
    }
    let [stiffness, damping] = match is_rigid {
        true => [1.0; 2],
        false => [table.quantity("stiffness_nm_rad")?, table.quantity("damping_nms_rad")?],
    };
    let rotor_inertia = match says(table, "rotor_inertia_kg_m2", UNKNOWN) {
        true => 1.0,
        false => table.quantity("rotor_inertia_kg_m2")?,
    };
    Ok(JointParameters {
        origin: table.vector("origin_m")?,
        axis: table.vector("axis")?,
        limits: table.quantities("limits_deg")?.map(f64::to_radians),
        max_rate: table.quantity("max_speed_deg_s")?.to_radians(),
        max_torque: table.quantity("max_torque_nm")?,
        stiffness,
        damping,
        rotor_inertia,
        mass: table.quantity("mass_kg")?,
        center_of_mass: table.vector("com_m")?,
        inertia: inertia(table)?,
    })
}

fn inertia(table: &TomlTable<'_>) -> Result<Matrix3<f64>, InputError> {
    let t = table.table("inertia_kg_m2")?;
    t.only(&["xx", "yy", "zz", "xy", "xz", "yz"])?;
    let [xx, yy, zz] = [t.quantity("xx")?, t.quantity("yy")?, t.quantity("zz")?];
    let [xy, xz, yz] = [t.quantity("xy")?, t.quantity("xz")?, t.quantity("yz")?];
    Ok(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}

fn friction(table: &TomlTable<'_>) -> Result<Friction<f64>, InputError> {
    table.only(&["viscous_nms_rad", "coulomb_nm", "smoothing_rad_s"])?;
    Ok(Friction {
        viscous: table.quantities("viscous_nms_rad")?.into(),
        coulomb: table.quantities("coulomb_nm")?.into(),
        smoothing: table.quantity("smoothing_rad_s")?,
    })
}

fn counterbalance(table: &TomlTable<'_>) -> Result<Counterbalance<f64>, InputError> {
    table.only(&["cos_nm", "phase_rad", "angle_deg", "torque_nm"])?;
    let list = |key, most| {
        let read = table.optional(key, |table, key| table.list(key, most, Bounds::Of(key)));
        read.map(Option::unwrap_or_default)
    };
    let angles = list("angle_deg", COUNTERBALANCE_POINTS)?;
    let torques = list("torque_nm", COUNTERBALANCE_POINTS)?;
    if angles.len() != torques.len() || angles.len() == 1 {
        let expected = format!("as many numbers as the other, from 2 to {COUNTERBALANCE_POINTS}");
        let key = if table.has("torque_nm") { "torque_nm" } else { "angle_deg" };
        return Err(table.wrong(key, &expected, "`angle_deg` and `torque_nm` make one table."));
    }
    if !angles.is_sorted_by(|a, b| a < b) {
        return Err(table.wrong("angle_deg", "rising angles", "Sort the table by angle."));
    }
    // What is in a table needs no series; without either the arm says so: cos_nm = [].
    let cosine = if angles.is_empty() || table.has("cos_nm") {
        table.list("cos_nm", COUNTERBALANCE_TERMS, Bounds::Of("cos_nm"))?
    } else {
        Vec::new()
    };
    let phase = table.quantity_or("phase_rad", 0.0)?;
    let points = angles.iter().zip(torques).map(|(angle, torque)| [angle.to_radians(), torque]);
    Ok(Counterbalance { cosine: cosine.into_iter().collect(), phase, table: points.collect() })
}

fn tool(table: &TomlTable<'_>) -> Result<ToolParameters<f64>, InputError> {
    table.only(&[
        "flange_offset_m",
        "mass_kg",
        "com_from_flange_m",
        "inertia_kg_m2",
        "tcp_from_flange_m",
        "z_axis",
        "y_axis",
    ])?;
    Ok(ToolParameters {
        flange_offset: table.vector("flange_offset_m")?,
        mass: table.quantity("mass_kg")?,
        com_from_flange: table.vector("com_from_flange_m")?,
        inertia: inertia(table)?,
        tcp_from_flange: table.vector("tcp_from_flange_m")?,
        z_axis: table.vector("z_axis")?,
        y_axis: table.vector("y_axis")?,
    })
}

/// A mass and an inertia that no body has.
fn no_body(table: &TomlTable<'_>, mass: f64, inertia: &Matrix3<f64>) -> InputError {
    if mass < 0.0 {
        return table.wrong("mass_kg", "a mass not below 0", "Check its sign.");
    }
    let mut moments: [f64; 3] = inertia.symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    let [low, middle, high] = moments;
    let expected = format!(
        "principal moments that a body can have (none negative, the largest at most the sum of the other two), \
         not {low:.4}, {middle:.4}, {high:.4} kg·m²"
    );
    let help = "The inertia is about the centre of mass, in axes of the link frame. Check its signs, its units \
                and whether it was stated about another point.";
    table.wrong("inertia_kg_m2", &expected, help)
}

/// What the core refused, at the value in the file that made it so.
fn explain(
    error: ModelError,
    parameters: &RobotParameters<f64>,
    root: &TomlTable<'_>,
    joints: &[TomlTable<'_>],
    friction: &TomlTable<'_>,
    tool: &TomlTable<'_>,
) -> InputError {
    let unit = |v: &Vector3<f64>| (v.norm() - 1.0).abs() <= 1e-6;
    match error {
        ModelError::NotFinite => root.error("holds a number that is not finite", "Check the numbers in this file."),
        ModelError::AxisNotUnit(i) => {
            let expected = format!("a vector of length 1, not {}", parameters.joints[i].axis.norm());
            joints[i].wrong("axis", &expected, "Divide the axis by its length.")
        }
        ModelError::Limits(i) => {
            let help = "Write the lower limit first: `limits_deg = [lower, upper]`.";
            joints[i].wrong("limits_deg", "a lower limit below the upper limit", help)
        }
        ModelError::Rating(i) => {
            let key = if parameters.joints[i].max_rate > 0.0 { "max_torque_nm" } else { "max_speed_deg_s" };
            joints[i].wrong(key, "a rating above 0", "Take it from the data sheet.")
        }
        ModelError::Drive(i) => {
            let p = &parameters.joints[i];
            let key = if p.stiffness <= 0.0 {
                "stiffness_nm_rad"
            } else if p.rotor_inertia <= 0.0 {
                "rotor_inertia_kg_m2"
            } else {
                "damping_nms_rad"
            };
            joints[i].wrong(key, "a drive train's value above 0", "Check its sign and its unit.")
        }
        ModelError::Inertia(i) => {
            let p = &parameters.joints[i];
            no_body(&joints[i], p.mass, &p.inertia)
        }
        ModelError::ToolInertia => no_body(tool, parameters.tool.mass, &parameters.tool.inertia),
        ModelError::Massless => joints[JOINTS - 1].wrong(
            "inertia_kg_m2",
            "an inertia about the last axis above 0, the tool included",
            "Give the last link or the tool its inertia; without one the equations of motion have no solution.",
        ),
        ModelError::ToolAxes => {
            let t = &parameters.tool;
            let key = if unit(&t.z_axis) { "y_axis" } else { "z_axis" };
            tool.wrong(key, "`z_axis` and `y_axis` of length 1 and square to each other", "Both to 1e-6.")
        }
        ModelError::Friction => {
            friction.error("holds a value below 0, or a smoothing of 0", "Friction takes energy out: not below 0.")
        }
    }
}
