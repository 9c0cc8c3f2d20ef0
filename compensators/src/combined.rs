//! Two laws as one: which owns which direction, what happens when one fails, and how far both may
//! go.
//!
//! Each direction of W takes its demand from the law that owns it, and from the other one while the
//! owner is at fault. Where the source of a direction changes, the output goes on from where it
//! was, and the difference fades:
//!
//! x = x_source + o,  o ← o e^(−T/τ),  at a change: o = x_last − x_source.
//!
//! The whole is held within an authority, displacement and rotation each; KUKA's sensor interface
//! clamps at 5 mm and 5° and stops the robot at 6 mm and 6°. More than two laws: combine a
//! combination.

use nalgebra::SVector;
use trueweld_core::compensation::{Compensator, Observation, shortened};
use trueweld_core::{Fault, Real, Robot, Twist};

/// What a combination may do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrectionLimits<T: Real> {
    /// Largest displacement, m.
    pub displacement: T,
    /// Largest rotation, rad.
    pub rotation: T,
    /// τ, s: time in which the step of a change fades.
    pub fade: T,
}

/// Two laws as one.
#[derive(Debug, Clone)]
pub struct Combined<T: Real, A, B> {
    first: A,
    second: B,
    owned: [bool; 6],
    authority: CorrectionLimits<T>,
    keep: T,
    /// By direction: true where the first law was its source, and what was demanded, in the last
    /// period.
    last: Option<([bool; 6], SVector<T, 6>)>,
    offset: SVector<T, 6>,
}

impl<T: Real, A, B> Combined<T, A, B> {
    /// `owned`: directions of the first law, angular x, y, z, then linear, axes of W; the second
    /// has the others. `period`: of control, s.
    ///
    /// `None` unless all of the authority and the period are positive and finite.
    pub fn new(
        first: A,
        second: B,
        owned: [bool; 6],
        authority: CorrectionLimits<T>,
        period: T,
    ) -> Option<Self> {
        let all = [authority.displacement, authority.rotation, authority.fade, period];
        all.iter().all(|v| v.is_finite() && *v > T::zero()).then(|| Self {
            first,
            second,
            owned,
            authority,
            keep: (-period / authority.fade).exp(),
            last: None,
            offset: SVector::zeros(),
        })
    }

    fn within(&self, demand: Twist<T>) -> Twist<T> {
        Twist {
            angular: shortened(demand.angular, self.authority.rotation).0,
            linear: shortened(demand.linear, self.authority.displacement).0,
        }
    }
}

impl<T: Real, A: Compensator<T>, B: Compensator<T>> Compensator<T> for Combined<T, A, B> {
    fn reset(&mut self) {
        self.first.reset();
        self.second.reset();
        self.last = None;
        self.offset = SVector::zeros();
    }

    fn freeze(&mut self) {
        self.first.freeze();
        self.second.freeze();
    }

    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault> {
        let first = self.first.demand(robot, observation);
        let second = self.second.demand(robot, observation);
        let (from_first, demands) = match (first, second) {
            (Ok(a), Ok(b)) => (self.owned, [a, b]),
            (Ok(a), Err(_)) => ([true; 6], [a, a]),
            (Err(_), Ok(b)) => ([false; 6], [b, b]),
            (Err(fault), Err(_)) => return Err(fault),
        };
        let [a, b] = demands.map(|d| d.to_vector());
        let source = SVector::from_fn(|i, _| if from_first[i] { a[i] } else { b[i] });
        self.offset *= self.keep;
        if let Some((before, demanded)) = self.last {
            for i in 0..6 {
                if before[i] != from_first[i] {
                    self.offset[i] = demanded[i] - source[i];
                }
            }
        }
        let demand = self.within(Twist::from_vector(&(source + self.offset)));
        self.last = Some((from_first, demand.to_vector()));
        Ok(demand)
    }
}
