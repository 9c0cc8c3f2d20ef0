//! Forward and inverse kinematics: each undoes the other on all eight branches, through the wrist
//! singularity and at the edges of what exists; the Jacobian is the derivative.

use nalgebra::Vector3;
use proptest::prelude::*;
use trueweld_core::scalar::{Real, lit};
use trueweld_core::spatial::rotation_from_vector;
use trueweld_core::{Branch, Displacement, JOINTS, JointVector, KinematicsError, Pose, Robot};
use trueweld_plant::simulate::postures_at;
use trueweld_tests::{
    KR500, cases, cast, configuration, kr500, kr500_parameters, number, pose_difference, rate,
    regular_configuration, seen, vertical_weld_pose, widen, within, wrapped,
};

/// Largest difference of two configurations when whole turns do not count, rad.
fn apart(a: &JointVector<f64>, b: &JointVector<f64>) -> f64 {
    (a - b).map(wrapped).amax()
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn every_branch_returned_reaches_the_pose(q in regular_configuration()) {
        let robot = &*KR500;
        let pose = robot.forward_kinematics(&q);
        let all = robot.inverse_all(&pose).unwrap();
        // The wrist flips for every arm posture, so branches come in pairs.
        prop_assert!(all.len() >= 2 && all.len().is_multiple_of(2), "{} branches", all.len());
        for (branch, found) in &all {
            // The requirement: 1e-9 m and rad.
            let off = seen("f64 inverse, pose", pose_difference(&robot.forward_kinematics(found), &pose));
            prop_assert!(off < 1e-9, "{branch:?} misses the pose by {off:e}");
            prop_assert!(found.iter().all(|a| (-core::f64::consts::PI..=core::f64::consts::PI).contains(a)));
            prop_assert_eq!(robot.branch_of(found).unwrap(), *branch, "branch_of names another branch");
        }
        // Angles lose what the geometry near the filtered singularities amplifies, at most about
        // 1/0.2².
        let nearest = all.iter().map(|(_, found)| apart(found, &q)).fold(f64::MAX, f64::min);
        prop_assert!(seen("f64 inverse, angles", nearest) < 1e-9, "the nearest solution is {nearest:e} rad away");
    }

    #[test]
    fn any_decoupled_arm_is_covered(q in configuration(), offsets in within(JointVector::repeat(0.3)),
                                    turned in prop::array::uniform6(any::<bool>())) {
        // Offsets along and across the arm, a foot away from B, a wrist of some length and axes of
        // either sense.
        let mut parameters = kr500_parameters::<f64>();
        parameters.joints[0].origin += Vector3::new(offsets[0], offsets[1], offsets[2]);
        parameters.joints[1].origin.y += offsets[3];
        parameters.joints[2].origin += Vector3::new(0.0, offsets[4], offsets[5]);
        parameters.joints[3].origin += Vector3::new(offsets[1], offsets[2], offsets[0]);
        parameters.joints[5].origin.x += offsets[3];
        for (joint, turned) in parameters.joints.iter_mut().zip(turned) {
            if turned {
                joint.axis = -joint.axis;
            }
        }
        let robot = Robot::new(parameters).unwrap();
        let frames = robot.frames(&q);
        // Away from singular poses, where the angles are not known to 1e-9: by the singular values
        // of J.
        let values = frames.jacobian().0.svd(false, false).singular_values;
        prop_assume!(values.min() > 1e-2 * values.max());
        let branch = robot.branch_of(&q).unwrap();
        let back = robot.inverse_kinematics(&frames.tcp, branch).unwrap();
        prop_assert!(apart(&back, &q) < 1e-9, "{branch:?} leads to {back} instead of {q}");
        for (branch, found) in robot.inverse_all(&frames.tcp).unwrap() {
            let off = pose_difference(&robot.forward_kinematics(&found), &frames.tcp);
            prop_assert!(off < 1e-9, "{branch:?} misses the pose by {off:e}");
        }
    }

    #[test]
    fn branch_of_names_the_branch_that_leads_back(q in regular_configuration()) {
        let branch = KR500.branch_of(&q).unwrap();
        let back = KR500.inverse_kinematics(&KR500.forward_kinematics(&q), branch).unwrap();
        prop_assert!(apart(&back, &q) < 1e-9, "{branch:?} leads to {back} instead of {q}");
    }

    #[test]
    fn single_precision_reaches_the_pose(q in regular_configuration()) {
        let robot = kr500::<f32>();
        let q = cast::<f32, 6, 1>(&q);
        let pose = robot.forward_kinematics(&q);
        for (branch, found) in robot.inverse_all(&pose).unwrap() {
            // 3.5 m of reach are 2e-7 m an ulp, and the elbow near stretched amplifies it by up to
            // 1/0.2: measured 1.8e-6.
            let off = seen("f32 inverse, pose", pose_difference(&robot.forward_kinematics(&found), &pose));
            prop_assert!(off < 6e-6, "{branch:?} misses the pose by {off:e}");
        }
        let back = robot.inverse_near(&pose, &q).unwrap();
        prop_assert!(seen("f32 inverse, angles", number((back - q).amax())) < 1e-5, "off by {:e} rad", (back - q).amax());
    }

    #[test]
    fn track_follows_a_path_through_every_turn(q in regular_configuration(), rate in rate()) {
        let robot = &*KR500;
        // 20 steps of 1/200 s at up to full speed: at most 0.2 rad from the start, inside the
        // regular region but for its rim; a path that leaves the limits or comes near a singularity
        // is not this test's subject.
        let mut near = q;
        for step in 1..=20 {
            let truth = q + rate * (0.005 * f64::from(step));
            if robot.beyond_limits(&truth).is_some() || robot.branch_of(&truth) != robot.branch_of(&q) {
                break;
            }
            near = robot.inverse_near(&robot.forward_kinematics(&truth), &near).unwrap();
            // No wrapping: A4 and A6 must come back on their own turn.
            prop_assert!((near - truth).amax() < 1e-8, "step {step}: {near} instead of {truth}");
        }
    }

    #[test]
    fn track_goes_straight_through_the_wrist_singularity(
        q in regular_configuration(), down in any::<bool>(), offset in 0.0..1.0_f64,
    ) {
        let robot = &*KR500;
        let sign = if down { -1.0 } else { 1.0 };
        // A5 from one side to the other in steps of 1/50 rad; with offset 0 a step lands on the
        // singularity itself.
        for offset in [offset, 0.0] {
            let at = |k: f64| {
                let mut at = q;
                at[4] = sign * 0.02 * (k + offset);
                at
            };
            let mut near = at(-10.0);
            for k in -9..=9 {
                let truth = at(f64::from(k));
                let pose = robot.forward_kinematics(&truth);
                near = robot.inverse_near(&pose, &near).unwrap();
                prop_assert!(pose_difference(&robot.forward_kinematics(&near), &pose) < 1e-8, "step {k} misses the pose");
                // Close to the singularity A4 is known to 1e-16/sin A5; at it, it is held.
                prop_assert!(seen("through the singularity", (near - truth).amax()) < 1e-8, "step {k}: {near} instead of {truth}");
            }
        }
    }

    #[test]
    fn track_holds_a4_at_the_singularity(q in regular_configuration()) {
        let mut q = q;
        q[4] = 0.0;
        let pose = KR500.forward_kinematics(&q);
        prop_assert_eq!(KR500.inverse_kinematics(&pose, KR500.branch_of(&q).unwrap()), Err(KinematicsError::Singular));
        let found = KR500.inverse_near(&pose, &q).unwrap();
        // Held by wrapping the difference, one rounding at 2π.
        prop_assert!((found[3] - q[3]).abs() < 1e-14);
        prop_assert!((found - q).amax() < 1e-9);

        let (robot, q) = (kr500::<f32>(), cast::<f32, 6, 1>(&q));
        let found = robot.inverse_near(&robot.forward_kinematics(&q), &q).unwrap();
        prop_assert!(seen("f32 A4 held", f64::from((found[3] - q[3]).abs())) < 1e-5, "f32: A4 went from {} to {}", q[3], found[3]);
    }

    #[test]
    fn jacobian_is_the_derivative_of_the_pose(q in configuration()) {
        let h = 1e-5;
        let jacobian = KR500.frames(&q).jacobian().0;
        for i in 0..JOINTS {
            let mut step = JointVector::zeros();
            step[i] = h;
            let (before, after) = (KR500.forward_kinematics(&(q - step)), KR500.forward_kinematics(&(q + step)));
            let numeric = before.error_to(&after).to_vector() / (2.0 * h);
            // Central differences: h²/6 · 3.5 m = 6e-11 of truncation, 3.5 ε/h = 8e-11 of rounding.
            let off = seen("Jacobian", (numeric - jacobian.column(i)).amax());
            prop_assert!(off < 1e-9, "column {i} is off by {off:e}");
        }
    }

    #[test]
    fn twist_is_the_jacobian_times_the_rates(q in configuration(), rate in rate()) {
        let frames = KR500.frames(&q);
        // Six terms of at most 3.5 m · 2 rad/s.
        prop_assert!((frames.twist(&rate).to_vector() - frames.jacobian().0 * rate).amax() < 1e-13);
    }

    #[test]
    fn displaced_frames(q in configuration(), tilt in within(JointVector::repeat(0.01)),
                        base in within(JointVector::repeat(0.01))) {
        let robot = &*KR500;
        let ideal = robot.frames(&q);
        let none = robot.frames_displaced(&q, &Displacement::none());
        prop_assert_eq!(none.tcp, ideal.tcp);
        prop_assert_eq!(none.origin, ideal.origin);
        prop_assert_eq!(none.axis, ideal.axis);
        // A tilt about a joint's own axis is a rotation of the joint.
        let own = Displacement {
            base: Pose::identity(),
            tilt: core::array::from_fn(|i| robot.parameters().joints[i].axis * tilt[i]),
        };
        // One more rotation of rounding a joint over 3.5 m.
        prop_assert!(pose_difference(&robot.frames_displaced(&q, &own).tcp, &robot.forward_kinematics(&(q + tilt))) < 1e-13);
        // A displaced base carries everything with it.
        let foot = Pose {
            rotation: rotation_from_vector(&Vector3::new(base[0], base[1], base[2])),
            position: Vector3::new(base[3], base[4], base[5]),
        };
        let moved = robot.frames_displaced(&q, &Displacement { base: foot, ..Displacement::none() });
        prop_assert!(pose_difference(&moved.tcp, &(foot * ideal.tcp)) < 1e-13);
    }

    #[test]
    fn a_pose_beyond_a_limit_names_the_joint(q in regular_configuration(), joint in 0..JOINTS, upper in any::<bool>()) {
        let robot = &*KR500;
        let [low, high] = robot.parameters().joints[joint].limits;
        let mut inside = q;
        inside[joint] = if upper { high - 0.005 } else { low + 0.005 };
        let mut outside = inside;
        outside[joint] = if upper { high + 0.005 } else { low - 0.005 };
        // A limit that coincides with another branch's rim (A3 near stretched) is another test's
        // subject.
        prop_assume!(robot.branch_of(&inside) == robot.branch_of(&outside));
        prop_assert!(robot.inverse_near(&robot.forward_kinematics(&inside), &inside).is_ok());
        prop_assert_eq!(robot.inverse_near(&robot.forward_kinematics(&outside), &inside), Err(KinematicsError::Limit(joint)));
        prop_assert_eq!(robot.beyond_limits(&outside), Some(joint));
    }

    #[test]
    fn numbers_that_are_none_are_refused(q in regular_configuration(), place in 0..12_usize,
                                         bad in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY])) {
        let mut pose = KR500.forward_kinematics(&q);
        if place < 9 { pose.rotation[place] = bad } else { pose.position[place - 9] = bad }
        prop_assert_eq!(KR500.inverse_all(&pose).unwrap_err(), KinematicsError::NotFinite);
        prop_assert_eq!(KR500.inverse_near(&pose, &q), Err(KinematicsError::NotFinite));
        let mut near = q;
        near[place % JOINTS] = bad;
        prop_assert_eq!(KR500.inverse_near(&KR500.forward_kinematics(&q), &near), Err(KinematicsError::NotFinite));
    }
}

#[test]
fn out_of_reach_is_unreachable() {
    // Reach of the wrist centre from A2: 1.3 m and √(1.025² + 0.055²) m; tool 0.69 m; A2 0.5 m out:
    // 3.6 m in all.
    for pose in [
        Pose { position: Vector3::new(4.0, 0.0, 1.0), ..vertical_weld_pose(0.0) },
        Pose { position: Vector3::new(0.1, 0.0, 5.0), ..vertical_weld_pose(0.0) },
        // Too near: the wrist centre inside the ring that the folded arm cannot enter, shoulder
        // front and back.
        Pose { position: Vector3::new(0.5, 0.0, 1.045 - 0.69), ..vertical_weld_pose(0.0) },
    ] {
        let all = KR500.inverse_all(&pose);
        let front = Branch { shoulder_back: false, elbow_flipped: false, wrist_flipped: false };
        assert_eq!(
            KR500.inverse_kinematics(&pose, front),
            Err(KinematicsError::Unreachable),
            "{all:?}"
        );
    }
    let far = Pose { position: Vector3::new(4.0, 0.0, 1.0), ..vertical_weld_pose(0.0) };
    assert_eq!(KR500.inverse_all(&far).unwrap_err(), KinematicsError::Unreachable);
    assert_eq!(
        KR500.inverse_near(&far, &JointVector::from([0.0, -1.0, 1.5, 0.0, 0.5, 0.0])),
        Err(KinematicsError::Unreachable)
    );
}

#[test]
fn wrist_centre_on_the_first_axis_is_singular() {
    // Tool vertical: the wrist centre lies 0.69 m above the TCP, and here on A1, within reach of
    // A2.
    let pose = Pose { position: Vector3::new(0.0, 0.0, 2.0), ..vertical_weld_pose(0.0) };
    for branch in Branch::ALL {
        assert_eq!(KR500.inverse_kinematics(&pose, branch), Err(KinematicsError::Singular));
    }
    assert_eq!(KR500.inverse_all(&pose).unwrap_err(), KinematicsError::Singular);
}

#[test]
fn another_kind_of_arm_is_refused() {
    let mut parameters = kr500_parameters::<f64>();
    parameters.joints[3].axis = Vector3::new(-0.8, 0.0, 0.6);
    let tilted = Robot::new(parameters).unwrap();
    assert_eq!(
        tilted.inverse_all(&vertical_weld_pose(0.0)).unwrap_err(),
        KinematicsError::NotDecoupled
    );
    assert_eq!(tilted.branch_of(&JointVector::zeros()), Err(KinematicsError::NotDecoupled));
}

/// The KR 500 with A5 beside axis A4 and A6 beside axis A5: no wrist centre.
fn offset_wrist<T: Real>() -> Robot<T> {
    let mut parameters = kr500_parameters::<T>();
    parameters.joints[4].origin += Vector3::new(lit(0.0), lit(0.12), lit(0.05));
    parameters.joints[5].origin += Vector3::new(lit(0.0), lit(-0.08), lit(0.10));
    Robot::new(parameters).unwrap()
}

/// An arm with the axes and lengths of a UR10e (its data sheet: 0.1807, 0.6127, 0.57155, 0.17415,
/// 0.11985 and 0.11655 m): A2, A3 and A4 parallel, no two wrist axes through one point with a third.
fn three_parallel_axes() -> Robot<f64> {
    let mut parameters = kr500_parameters::<f64>();
    let (y, z) = (Vector3::y(), Vector3::z());
    let origins = [
        Vector3::zeros(),
        Vector3::new(0.0, 0.0, 0.1807),
        Vector3::new(0.6127, 0.0, 0.0),
        Vector3::new(0.57155, 0.17415, 0.0),
        Vector3::new(0.0, 0.0, -0.11985),
        Vector3::new(0.0, 0.11655, 0.0),
    ];
    for (k, (origin, axis)) in origins.into_iter().zip([z, y, y, y, -z, y]).enumerate() {
        (parameters.joints[k].origin, parameters.joints[k].axis) = (origin, axis);
        parameters.joints[k].limits = [-6.2, 6.2];
    }
    Robot::new(parameters).unwrap()
}

proptest! {
    #[test]
    fn without_a_spherical_wrist_the_inverse_leads_back_from_nearby(
        share in prop::array::uniform6(0.1..0.9_f64),
        away in prop::array::uniform6(-0.05..0.05_f64),
    ) {
        for robot in [offset_wrist::<f64>(), three_parallel_axes()] {
            let q = JointVector::from_fn(|i, _| {
                let [low, high] = robot.parameters().joints[i].limits;
                low + share[i] * (high - low)
            });
            let near = q + JointVector::from_column_slice(&away);
            let pose = robot.forward_kinematics(&q);
            // Next to a singular posture another way to reach the pose may be as near.
            let back = robot.inverse_near(&pose, &near);
            match back {
                Ok(back) => {
                    prop_assert!(pose_difference(&robot.forward_kinematics(&back), &pose) < 1e-11);
                    let jacobian = robot.frames(&q).jacobian().0;
                    if jacobian.svd(false, false).singular_values.min() > 0.15 {
                        prop_assert!((back - q).amax() < 1e-9, "{}", (back - q).amax());
                    }
                }
                Err(error) => prop_assert!(matches!(error, KinematicsError::Limit(_)), "{error:?}"),
            }
        }
    }

    #[test]
    fn where_there_is_a_closed_form_newtons_method_agrees_with_it(
        share in prop::array::uniform6(0.1..0.9_f64),
        away in prop::array::uniform6(-0.02..0.02_f64),
    ) {
        let q = JointVector::from_fn(|i, _| {
            let [low, high] = KR500.parameters().joints[i].limits;
            low + share[i] * (high - low)
        });
        prop_assume!(KR500.frames(&q).jacobian().0.svd(false, false).singular_values.min() > 0.15);
        let near = q + JointVector::from_column_slice(&away);
        let pose = KR500.forward_kinematics(&q);
        let (closed, newton) = (KR500.inverse_near(&pose, &near), KR500.inverse_from(&pose, &near));
        prop_assert!((closed.unwrap() - newton.unwrap()).amax() < 1e-9);
    }
}

#[test]
fn an_offset_wrist_follows_the_weld_in_either_precision() {
    let (double, single) = (offset_wrist::<f64>(), offset_wrist::<f32>());
    let start = vertical_weld_pose(-1.0);
    let mut q = postures_at(&double, &start).unwrap()[0];
    let mut q32 = cast::<f32, 6, 1>(&q);
    for step in 0..=200 {
        let pose = vertical_weld_pose(-1.0 + 0.01 * f64::from(step));
        q = double.inverse_near(&pose, &q).unwrap();
        q32 = single.inverse_near(&trueweld_tests::cast_pose(&pose), &q32).unwrap();
        assert!(pose_difference(&double.forward_kinematics(&q), &pose) < 1e-11);
        // 64 roundings of f32, and those of the forward kinematics of 3.5 m.
        assert!(pose_difference(&double.forward_kinematics(&widen(&q32)), &pose) < 2e-5);
    }
}

#[test]
fn a_pose_out_of_reach_is_told_as_such_without_a_closed_form() {
    let far = Pose { position: Vector3::new(9.0, 0.0, 1.0), ..vertical_weld_pose(0.0) };
    let robot = offset_wrist::<f64>();
    assert_eq!(robot.inverse_from(&far, &JointVector::zeros()), Err(KinematicsError::Unreachable));
    let nothing = Pose { position: Vector3::repeat(f64::NAN), ..far };
    assert_eq!(
        robot.inverse_from(&nothing, &JointVector::zeros()),
        Err(KinematicsError::NotFinite)
    );
}

#[test]
fn forward_of_inverse_is_the_weld() {
    // Published weld, 2 m along Y: the arm follows it within its limits from start to end.
    let robot = &*KR500;
    let start = vertical_weld_pose(-1.0);
    let mut q = robot
        .inverse_all(&start)
        .unwrap()
        .iter()
        .map(|(_, q)| *q)
        .find(|q| robot.beyond_limits(q).is_none())
        .expect("some branch lies within the limits");
    let branch = robot.branch_of(&q).unwrap();
    for step in 0..=200 {
        let pose = vertical_weld_pose(-1.0 + 0.01 * f64::from(step));
        let next = robot.inverse_near(&pose, &q).unwrap();
        assert!(pose_difference(&robot.forward_kinematics(&next), &pose) < 1e-9);
        // 10 mm at 1.5 m or more from every axis that must turn, a few times as much for the wrist.
        assert!((next - q).amax() < if step == 0 { 1e-9 } else { 0.1 }, "a jump at step {step}");
        assert_eq!(robot.branch_of(&next).unwrap(), branch);
        q = next;
    }
}

#[test]
fn single_precision_weld_path() {
    // The whole weld tracked in f32 stays on the pose to 3.5 m · some ε.
    let (robot, double) = (kr500::<f32>(), &*KR500);
    let all = double.inverse_all(&vertical_weld_pose(-1.0)).unwrap();
    let start = all.iter().map(|(_, q)| *q).find(|q| double.beyond_limits(q).is_none()).unwrap();
    let mut q = cast::<f32, 6, 1>(&start);
    let mut worst = 0.0_f64;
    for step in 0..=200 {
        let pose = vertical_weld_pose(-1.0 + 0.01 * f64::from(step));
        q = robot.inverse_near(&trueweld_tests::cast_pose(&pose), &q).unwrap();
        worst = worst.max(pose_difference(&double.forward_kinematics(&widen(&q)), &pose));
    }
    println!("f32 inverse kinematics along the weld: {worst:.1e} m or rad");
    assert!(worst < 5e-6, "{worst:e}");
}
