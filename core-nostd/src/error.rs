//! What can go wrong, as small values: the core never panics and never formats text.

/// A robot description that cannot be a robot. Returned by [`Robot::new`](crate::Robot::new), so
/// that nothing built later can fail for a bad model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelError {
    /// A number is NaN or infinite.
    NotFinite,
    /// The axis of this joint (0 = A1) is not a unit vector to 1e-6.
    AxisNotUnit(usize),
    /// Lower limit not below the upper limit of this joint.
    Limits(usize),
    /// Speed or torque limit of this joint is not positive.
    Rating(usize),
    /// Stiffness or rotor inertia of this joint is not positive, or its damping is negative.
    Drive(usize),
    /// Mass of this link is negative, or its inertia is not positive semi-definite with the
    /// triangle inequality.
    Inertia(usize),
    /// The tool's mass or inertia is negative or impossible.
    ToolInertia,
    /// The last moving link (with the tool) has no rotational inertia about some axis: M would be
    /// singular.
    Massless,
    /// The tool's `z_axis` and `y_axis` are not orthonormal to 1e-6.
    ToolAxes,
    /// Friction values negative, or the smoothing rate not positive.
    Friction,
}

/// Why a pose has no joint angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KinematicsError {
    /// The arm is not of the decoupled-wrist family that the closed form covers
    /// (A1 vertical, A2 ∥ A3 horizontal, A4 A5 A6 through one point).
    NotDecoupled,
    /// The wrist centre lies outside the reach of this branch; or Newton's method does not come to
    /// the pose from where it began.
    Unreachable,
    /// A4 and A6 are in line (or the wrist centre is on axis A1): the angles are not unique.
    Singular,
    /// This joint (0 = A1) would leave its limits.
    Limit(usize),
    /// A number given is NaN or infinite.
    NotFinite,
}

/// Why a control cycle could not do its work. The cycle still returns a defined safe command beside
/// it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Encoder of this joint (0 = A1) is NaN or infinite, or jumped by more than the joint can move
    /// in one period.
    Encoder(usize),
    /// The force sensor gave NaN or infinity in any of its six channels, is stuck, is beyond its
    /// range, or the drives bear another push.
    Force,
    /// The set-point is NaN or infinite, its axes are no rotation, or it is so large that the joint
    /// error it asks for is infinite.
    Setpoint,
    /// The Jacobian cannot be inverted here.
    Singular,
    /// This joint (0 = A1) is outside its position limits.
    Limit(usize),
    /// The compensation law could not form a correction: the nominal pose is no pose, unreachable or
    /// singular, or the path is not finite or moved faster than the arm can.
    Compensation,
}
