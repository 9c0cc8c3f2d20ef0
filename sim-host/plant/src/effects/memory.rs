//! Operators with a memory, which make loops: what they give depends on the way that a variable `u`
//! has come, not on how fast.
//!
//! ```text
//! dahl(u, w):  z,          dz/du = (1 − z sgn u̇)/w       friction that turns round over w
//! play(u, w):  u − w s,    ds/du = 1/w, −1 ≤ s ≤ 1       follows u with a slack w to either side
//! ```
//!
//! Both states lie between −1 and 1 and begin at 0. u − play(u, w) is the deflection of a spring whose
//! friction gives way at w (Jenkins); dahl is P. R. Dahl's, *A solid friction model* (1968).

/// How fast a state turns round at most, 1/s: what a loop far narrower than the way of a millisecond
/// does is not resolved in time.
const MEMORY_RATE_MAX: f64 = 1e3;

/// An operator with a memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loop {
    /// `dahl`.
    Dahl,
    /// `play`.
    Play,
}

/// Their names in expressions.
pub(super) const LOOP_NAMES: [(&str, Loop); 2] = [("dahl", Loop::Dahl), ("play", Loop::Play)];

impl Loop {
    /// What it gives at `u` with this state.
    #[inline]
    pub fn value(self, u: f64, width: f64, state: f64) -> f64 {
        match self {
            Self::Dahl => state,
            Self::Play => u - width * state.clamp(-1.0, 1.0),
        }
    }

    /// Rate of the state at a rate of `u`.
    #[inline]
    pub fn rate(self, u_rate: f64, width: f64, state: f64) -> f64 {
        let way = (u_rate / width).clamp(-MEMORY_RATE_MAX, MEMORY_RATE_MAX);
        match self {
            Self::Dahl => way - state * way.abs(),
            // At its end it stays there, where a step may have taken it a little beyond.
            Self::Play if state.abs() >= 1.0 && state * way >= 0.0 => {
                (state.signum() - state) * MEMORY_RATE_MAX
            }
            Self::Play => way,
        }
    }

    /// The state after an even way of `u`.
    #[inline]
    pub fn after(self, way: f64, width: f64, state: f64) -> f64 {
        match self {
            Self::Dahl if way == 0.0 => state,
            Self::Dahl => way.signum() - (way.signum() - state) * (-way.abs() / width).exp(),
            Self::Play => (state + way / width).clamp(-1.0, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// However a way is cut into pieces, and as the rates have it.
        #[test]
        fn a_state_depends_on_the_way_alone(
            dahl in any::<bool>(),
            from in -1.0..1.0,
            ways in proptest::collection::vec(-1.0..1.0, 1..6),
            width in 0.05..2.0,
        ) {
            const PARTS: usize = 20_000;
            let law = if dahl { Loop::Dahl } else { Loop::Play };
            let (mut whole, mut halved, mut followed) = (from, from, from);
            for way in ways {
                whole = law.after(way, width, whole);
                halved = law.after(0.5 * way, width, law.after(0.5 * way, width, halved));
                for _ in 0..PARTS {
                    followed += law.rate(way, width, followed) / PARTS as f64;
                }
            }
            prop_assert!((whole - halved).abs() < 1e-12);
            prop_assert!((whole - followed).abs() < 1e-2);
            prop_assert!(whole.abs() <= 1.0);
        }
    }

    #[test]
    fn play_follows_its_variable_behind_a_slack_and_dahl_turns_round_over_its_width() {
        let (mut u, mut s, mut z) = (0.0, 0.0, 0.0);
        for way in [0.1, 0.3, -0.05, -0.3] {
            u += way;
            (s, z) = (Loop::Play.after(way, 0.1, s), Loop::Dahl.after(way, 0.1, z));
        }
        assert!((Loop::Play.value(u, 0.1, s) - 0.15).abs() < 1e-12);
        let before = 1.0 - (-4.0_f64).exp();
        let back = -1.0 + (1.0 + before) * (-3.5_f64).exp();
        assert!((Loop::Dahl.value(u, 0.1, z) - back).abs() < 1e-12);
    }
}
