//! How the compliance of each joint displaces the tool: what laws that estimate compliances share.

use nalgebra::{Matrix3, SMatrix};
use trueweld_core::compensation::Observation;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{Frames, JOINTS, JointVector, Real, Robot, Wrench};

/// A column a joint, rows angular first.
pub(crate) type ByJoint<T> = SMatrix<T, 6, JOINTS>;

/// Δ(J diag(K⁻¹ τ_s)): the displacement of the encoders' pose that the planned load asks for through
/// each joint, per relative error of its compliance, less that of the unloaded arm where the
/// set-point was taught.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ByCompliance<T: Real> {
    /// J, in B, and K⁻¹ τ_s of the unloaded arm where the set-point was taught.
    taught: Option<(ByJoint<T>, JointVector<T>)>,
}

impl<T: Real> ByCompliance<T> {
    /// With nothing taught yet.
    pub(crate) fn new() -> Self {
        Self { taught: None }
    }

    /// In axes of W at the nominal pose, where the arm has the angles `link` and the frames
    /// `frames`.
    pub(crate) fn columns(
        &mut self,
        robot: &Robot<T>,
        frames: &Frames<T>,
        link: &JointVector<T>,
        observation: &Observation<'_, T>,
    ) -> ByJoint<T> {
        let w = observation.setpoint.b_from_w;
        let jacobian = frames.jacobian().0;
        let torsion = |load: &Wrench<T>| {
            robot.spring_torque_at_rest(frames, link, load).component_div(robot.stiffness())
        };
        if observation.taught.is_some() && self.taught.is_none() {
            self.taught = Some((jacobian, torsion(&Wrench::zero())));
        }
        let taught = self.taught.as_ref();
        in_w(&w, &jacobian, &torsion(&observation.planned.rotated(&w)))
            - taught.map_or_else(ByJoint::zeros, |(j, torsion)| in_w(&w, j, torsion))
    }
}

/// J diag(torsion) in axes of W. As products: no index is left to check.
fn in_w<T: Real>(
    b_from_w: &Matrix3<T>,
    jacobian: &ByJoint<T>,
    torsion: &JointVector<T>,
) -> ByJoint<T> {
    let each = ByJoint::<T>::from_diagonal(torsion);
    let turned = |first| b_from_w.transpose() * jacobian.fixed_rows::<3>(first) * each;
    let mut columns = ByJoint::<T>::zeros();
    columns.fixed_rows_mut::<3>(0).copy_from(&turned(0));
    columns.fixed_rows_mut::<3>(3).copy_from(&turned(3));
    columns
}

impl<T: Real> Stateful for ByCompliance<T> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        let blank = (ByJoint::zeros(), JointVector::zeros());
        visitor.option(&mut self.taught, blank, |visitor, (jacobian, torsion)| {
            visitor.matrix(jacobian)?;
            visitor.matrix(torsion)
        })
    }
}
