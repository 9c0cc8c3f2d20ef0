//! The slope that dry friction shows a vibration: its describing function, and the sector of all
//! slopes.
//!
//! Friction f of a drive that turns at rate r and vibrates about it with amplitude a shows the
//! vibration the slope N = (2/a) mean over φ of f(r + a sin φ) sin φ (sinusoid with bias; Gelb and
//! Vander Velde 1968). A small vibration sees f'(r); a large one sees viscous friction alone; where
//! the drive reverses, the vibration that is smaller than the smoothing sees Coulomb friction as a
//! damper that is larger than the controller's own.

use std::f64::consts::TAU;
use trueweld_core::JointVector;
use trueweld_plant::cell::{Cell, State};
use trueweld_plant::{named, serialize_as_text};

/// Points of a turn at which friction is taken.
const FRICTION_PHASES: usize = 256;

/// Amplitudes at which a sector is looked at, rad/s, evenly in their logarithm.
const SECTOR_AMPLITUDES: (f64, f64, usize) = (1e-5, 1.0, 26);

named! {
    /// What friction is taken for in a linear loop.
    pub enum FrictionSlope {
        /// A large vibration: viscous friction alone.
        Viscous = "viscous",
        /// A small vibration: the slope at each drive's own rate.
        AtSpeed = "at-speed",
        /// The largest slope that a vibration of any size sees about each drive's own rate; of a drive
        /// at rest all of its Coulomb friction over the smoothing.
        Full = "full",
    }
}

serialize_as_text!(FrictionSlope::name);

impl FrictionSlope {
    /// Slopes of the drives' friction at a state of the cell, N·m·s/rad.
    pub fn of(self, cell: &Cell, point: &State) -> JointVector<f64> {
        match self {
            Self::AtSpeed => slopes(cell, point, &JointVector::zeros()),
            Self::Viscous => {
                let mut fast = *point;
                for i in 0..6 {
                    let rate = &mut fast.0[18 + i];
                    let most = cell.robot.model.parameters().joints[i].max_rate;
                    *rate = most.copysign(*rate);
                }
                slopes(cell, &fast, &JointVector::zeros())
            }
            Self::Full => {
                let (least, most, count) = SECTOR_AMPLITUDES;
                let step = (most / least).powf(1.0 / (count - 1) as f64);
                (0..count).fold(Self::AtSpeed.of(cell, point), |largest, k| {
                    let amplitude = least * step.powi(k as i32);
                    largest.sup(&slopes(cell, point, &JointVector::repeat(amplitude)))
                })
            }
        }
    }
}

/// Slopes of the drives' friction for vibrations of these amplitudes, rad/s, about a state at the
/// start: N·m·s/rad.
pub(crate) fn slopes(cell: &Cell, point: &State, amplitude: &JointVector<f64>) -> JointVector<f64> {
    let drives = point.drives();
    let spring = cell.robot.spring_torque(&drives, point.internal());
    JointVector::from_fn(|i, _| {
        let at = |by: f64| {
            let mut drives = drives;
            drives.motor_rate[i] += by;
            cell.robot.friction(&drives, i, spring[i], point.internal(), 0.0)
        };
        if amplitude[i] < SECTOR_AMPLITUDES.0 {
            return at(0.0).slope;
        }
        equivalent_slope(|by| at(by).value, amplitude[i])
    })
}

/// (2/a) mean over φ of f(a sin φ) sin φ.
fn equivalent_slope(f: impl Fn(f64) -> f64, amplitude: f64) -> f64 {
    let turn = (0..FRICTION_PHASES).map(|k| TAU * (k as f64 + 0.5) / FRICTION_PHASES as f64);
    let mean =
        turn.map(|phi| f(amplitude * phi.sin()) * phi.sin()).sum::<f64>() / FRICTION_PHASES as f64;
    2.0 * mean / amplitude
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_describing_function_of_coulomb_friction_is_the_textbooks() {
        // Gelb and Vander Velde 1968: of a drive at rest N = 4 c/(π a); of one that turns at rate r
        // nothing below a = r, and above it N = 4 c/(π a) √(1 − (r/a)²).
        let (coulomb, rate) = (900.0, 5e-3);
        let about = |rate: f64, a: f64| {
            equivalent_slope(|by| coulomb * (rate + by).signum(), a) * PI * a / (4.0 * coulomb)
        };
        // The sum over midpoints misplaces a step of the sign by up to half of its width 2π/256.
        assert!((about(0.0, 1e-2) - 1.0).abs() < 0.02);
        assert!((about(rate, 1e-2) - f64::sqrt(0.75)).abs() < 0.02);
        assert!(about(rate, 0.9 * rate).abs() < 1e-12);
    }
}
