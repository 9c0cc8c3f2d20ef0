//! Two laws as one: each owns directions of W and stands in for the other at a fault; both together
//! are limited.
//!
//! Each direction takes its demand from the law that owns it, and from the other one while the
//! owner is at fault. Where the source of a direction changes, the output continues from its last
//! value and the difference decays:
//!
//! x = x_source + o,  o ← o e^(−T/τ),  at a change: o = x_last − x_source.
//!
//! Displacement and rotation of the whole are limited. KUKA's sensor interface clamps at 5 mm and
//! 5° and stops the robot at 6 mm and 6°. More than two laws: combine a combination.

use crate::gain::{GainError, positive, usable_period};
use nalgebra::SVector;
use trueweld_core::compensation::{Compensator, Observation, shortened};
use trueweld_core::scalar::lit;
use trueweld_core::state::{StateResult, StateVisitor};
use trueweld_core::{Fault, Real, Robot, Twist};

/// Gains of a combination: `[law."FIRST+SECOND"]` of a control file.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "host", derive(serde::Serialize, serde::Deserialize))]
pub struct CombinedGains {
    /// Directions that the first law owns: angular x, y, z, then linear, axes of W; the second has
    /// the others. In a file a list of "rx", "ry", "rz", "x", "y", "z". All six: the second law
    /// stands by.
    #[cfg_attr(feature = "host", serde(with = "directions"))]
    pub first_owns: [bool; 6],
    /// Largest displacement, m. 0.010.
    pub max_translation_m: f64,
    /// Largest rotation, rad. 0.015.
    pub max_rotation_rad: f64,
    /// τ, s: time constant in which the step of a change of source decays. 0.5.
    pub fade_s: f64,
}

impl Default for CombinedGains {
    fn default() -> Self {
        Self {
            first_owns: [true; 6],
            max_translation_m: 0.010,
            max_rotation_rad: 0.015,
            fade_s: 0.5,
        }
    }
}

/// Directions in a file: the names of those that are true.
#[cfg(feature = "host")]
mod directions {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    const CORRECTION_AXES: [&str; 6] = ["rx", "ry", "rz", "x", "y", "z"];

    pub(crate) fn serialize<S: Serializer>(
        owned: &[bool; 6],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(
            CORRECTION_AXES.iter().zip(owned).filter(|(_, owned)| **owned).map(|(n, _)| n),
        )
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<[bool; 6], D::Error> {
        let mut owned = [false; 6];
        for name in Vec::<String>::deserialize(deserializer)? {
            let k = CORRECTION_AXES.iter().position(|n| *n == name).ok_or_else(|| {
                D::Error::custom(format!(
                    "{name:?} is no direction; expected some of {CORRECTION_AXES:?}"
                ))
            })?;
            owned[k] = true;
        }
        Ok(owned)
    }
}

/// Two laws as one.
#[derive(Debug, Clone)]
pub struct Combined<T: Real, A, B> {
    first: A,
    second: B,
    owned: [bool; 6],
    /// Largest displacement, m, and rotation, rad.
    limits: [T; 2],
    keep: T,
    /// By direction: true where the first law was its source, and what was demanded, in the last
    /// period.
    last: Option<([bool; 6], SVector<T, 6>)>,
    offset: SVector<T, 6>,
}

impl<T: Real, A, B> Combined<T, A, B> {
    /// Two laws as one, each within its limits. `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless limits, fade and period are positive and finite.
    pub fn new(first: A, second: B, gains: &CombinedGains, period: T) -> Result<Self, GainError> {
        positive(gains.max_translation_m, "max_translation_m")?;
        positive(gains.max_rotation_rad, "max_rotation_rad")?;
        positive(gains.fade_s, "fade_s")?;
        usable_period(period)?;
        Ok(Self {
            first,
            second,
            owned: gains.first_owns,
            limits: [lit(gains.max_translation_m), lit(gains.max_rotation_rad)],
            keep: (-period / lit(gains.fade_s)).exp(),
            last: None,
            offset: SVector::zeros(),
        })
    }

    fn within(&self, demand: Twist<T>) -> Twist<T> {
        let [displacement, rotation] = self.limits;
        Twist {
            angular: shortened(demand.angular, rotation).0,
            linear: shortened(demand.linear, displacement).0,
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

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.first.visit_state(visitor)?;
        self.second.visit_state(visitor)?;
        visitor.option(
            &mut self.last,
            ([false; 6], SVector::zeros()),
            |visitor, (from_first, last)| {
                from_first.iter_mut().try_for_each(|flag| visitor.flag(flag))?;
                visitor.matrix(last)
            },
        )?;
        visitor.matrix(&mut self.offset)
    }
}
