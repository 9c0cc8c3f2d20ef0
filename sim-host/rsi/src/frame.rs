//! KUKA's frames: X Y Z in mm, and A B C in degrees, rotations about z, the new y and the new x.

use nalgebra::{Matrix3, Rotation3, Vector3};
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{Pose, Twist};

/// Millimetres a metre.
pub const MM: f64 = 1e3;

/// X, Y, Z, mm, and A, B, C, degrees.
pub type Frame = [f64; 6];

fn angles(rotation: &Matrix3<f64>) -> [f64; 3] {
    // nalgebra's roll, pitch and yaw are the same three rotations, the first one last.
    let (c, b, a) = Rotation3::from_matrix_unchecked(*rotation).euler_angles();
    [a, b, c].map(f64::to_degrees)
}

fn rotation([a, b, c]: [f64; 3]) -> Matrix3<f64> {
    Rotation3::from_euler_angles(c.to_radians(), b.to_radians(), a.to_radians()).into_inner()
}

/// The frame of a pose.
pub fn of_pose(pose: &Pose<f64>) -> Frame {
    let [x, y, z]: [f64; 3] = (pose.position * MM).into();
    let [a, b, c] = angles(&pose.rotation);
    [x, y, z, a, b, c]
}

/// The pose of a frame.
pub(crate) fn to_pose(&[x, y, z, a, b, c]: &Frame) -> Pose<f64> {
    Pose { rotation: rotation([a, b, c]), position: Vector3::new(x, y, z) / MM }
}

/// The frame of a displacement: rotation vector, rad, and m.
pub(crate) fn of_twist(twist: &Twist<f64>) -> Frame {
    of_pose(&Pose { rotation: rotation_from_vector(&twist.angular), position: twist.linear })
}

/// The displacement of a frame.
pub(crate) fn to_twist(frame: &Frame) -> Twist<f64> {
    let pose = to_pose(frame);
    Twist { angular: rotation_vector(&pose.rotation), linear: pose.position }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turns_about_z_then_b_about_the_new_y_then_c_about_the_new_x() {
        let about =
            |axis: Vector3<f64>, degrees: f64| rotation_from_vector(&(axis * degrees.to_radians()));
        let expected =
            about(Vector3::z(), 30.0) * about(Vector3::y(), -20.0) * about(Vector3::x(), 50.0);
        let pose = to_pose(&[1.0, 2.0, 3.0, 30.0, -20.0, 50.0]);
        assert!((pose.rotation - expected).amax() < 1e-15);
        let back = of_pose(&pose);
        for (value, given) in back.iter().zip([1.0, 2.0, 3.0, 30.0, -20.0, 50.0]) {
            assert!((value - given).abs() < 1e-12, "{back:?}");
        }
    }

    #[test]
    fn a_small_displacement_comes_back() {
        let twist = Twist {
            angular: Vector3::new(1e-3, -2e-3, 3e-3),
            linear: Vector3::new(1e-3, 5e-3, 0.0),
        };
        let back = to_twist(&of_twist(&twist));
        assert!((back.to_vector() - twist.to_vector()).amax() < 1e-15);
    }
}
