//! Curves that show effects: a quantity of the plant, as the measurements have it and as the effect
//! has it, over a variable that the effect follows.

/// The curve that shows an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve {
    /// The column of the logs that the effect improves most, over whatever it follows there.
    Column,
    /// The amplitude of the force over the orders of the spindle.
    SpindleOrders,
    /// The quantity over the variable in which the effect stands out most; no variables stand for
    /// all that there are.
    Quantity(&'static [ShownQuantity], &'static [CurveAxis]),
    /// The same in order of time, from the one log in which the effect does most: a loop.
    Loop(&'static [ShownQuantity], &'static [CurveAxis]),
}

/// A quantity that measurements can be asked for without the effect's equation.
///
/// Its `name` is that of the ordinate; `{joint}` in it stands for the name of the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ShownQuantity {
    /// What is added at a port of the plant, in the port's unit.
    Port {
        /// The port, by its name in [`super::formula::PORTS`].
        port: &'static str,
        /// The joint whose port it is, from 0, where the effect is of the whole cell.
        joint: Option<usize>,
        /// −1 where the quantity shown is that much less.
        sign: f64,
        /// Name.
        name: &'static str,
    },
    /// One factor for several ports: what is added at each is the factor times an expression over
    /// the port's variables.
    Factor {
        /// Ports and expressions.
        terms: &'static [(&'static str, &'static str)],
        /// Name.
        name: &'static str,
    },
    /// The effect's own parameter of this index.
    Parameter {
        /// Index.
        index: usize,
        /// Name.
        name: &'static str,
    },
}

/// A variable that an effect may follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CurveAxis {
    /// Time from the start of the log.
    Time,
    /// Time up to five of the time constants that the parameter of this index is.
    TimeTo {
        /// Index of the parameter.
        constant: usize,
    },
    /// Spring torque of the joint.
    SpringTorque,
    /// Angle of the joint; over one period where the effect is a wave of many periods.
    Angle,
    /// Angle of the joint before.
    AngleBefore,
    /// Angle of a joint, from 0.
    AngleOf(usize),
    /// Rate of the joint.
    Rate,
    /// Position along the weld.
    Path,
    /// Speed along the weld.
    Feed,
    /// F_z in the tool's frame.
    AxialForce,
    /// −F_z, with the sign of the spindle's speed.
    PushBySpindle,
    /// Size of the force on the tool.
    Load,
    /// TCP in B along one axis, from 0.
    Tool(usize),
    /// How fast changes what the instrument measures.
    OfInstrument,
}

impl ShownQuantity {
    /// What is added at a port.
    pub const fn port(port: &'static str, name: &'static str) -> Self {
        Self::Port { port, joint: None, sign: 1.0, name }
    }

    /// The effect's own parameter.
    pub const fn parameter(index: usize, name: &'static str) -> Self {
        Self::Parameter { index, name }
    }
}

/// Twist that the linear spring does not explain.
pub const TWIST_BEYOND_SPRING: ShownQuantity = ShownQuantity::Port {
    port: "twist",
    joint: None,
    sign: -1.0,
    name: "twist of {joint} beyond the linear spring's",
};

/// Angle that the encoder does not read.
pub const ANGLE_BEYOND_ENCODER: ShownQuantity =
    ShownQuantity::port("twist", "angle of {joint} beyond its encoder's");

/// Friction torque that the model does not have.
pub const MORE_FRICTION: ShownQuantity =
    ShownQuantity::port("motor-friction", "more friction torque of {joint}");

/// Error of a second encoder.
pub const LINK_ENCODER_READS_MORE: ShownQuantity =
    ShownQuantity::port("link-encoder", "what the second encoder of {joint} reads more");

/// Error of the tracker along each axis of B.
pub const TRACKER_READS_MORE: [ShownQuantity; 3] = [
    ShownQuantity::port("tracker-x", "what the tracker reads more along x"),
    ShownQuantity::port("tracker-y", "what the tracker reads more along y"),
    ShownQuantity::port("tracker-z", "what the tracker reads more along z"),
];

/// Displacement of the arm along each axis of B.
pub const TOOL_DRIFTS: [ShownQuantity; 3] = [
    ShownQuantity::port("tool-shift-x", "drift of the tool along x"),
    ShownQuantity::port("tool-shift-y", "drift of the tool along y"),
    ShownQuantity::port("tool-shift-z", "drift of the tool along z"),
];

/// Error of the force sensor along each axis of T.
pub const FORCE_SENSOR_READS_MORE: [ShownQuantity; 3] = [
    ShownQuantity::port("force-sensor-x", "what the force sensor reads more along x"),
    ShownQuantity::port("force-sensor-y", "what the force sensor reads more along y"),
    ShownQuantity::port("force-sensor-z", "what the force sensor reads more along z"),
];

/// Height of the plate.
pub const SURFACE_HEIGHT: ShownQuantity =
    ShownQuantity::port("surface-height", "height of the surface towards the tool");

/// Force along the seam, relative to what it is.
pub const SEAM_FORCE: ShownQuantity = ShownQuantity::Factor {
    terms: &[("process-force-x", "fx")],
    name: "relative change of the force along the seam",
};

/// All process forces, relative to what they are.
pub const ALL_FORCES: ShownQuantity = ShownQuantity::Factor {
    terms: &[("process-force-x", "fx"), ("process-force-y", "fy"), ("process-force-z", "fz")],
    name: "relative change of the process forces",
};
