//! How often something happened, and what that says of its probability: exact binomial limits after
//! Clopper and Pearson.

use statrs::function::beta::beta_reg;
use std::fmt;

/// So many of so many.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Rate {
    /// How many did.
    pub hits: usize,
    /// Of how many.
    pub of: usize,
}

impl Rate {
    /// How many of some things are so.
    pub fn of<T>(all: &[T], is: impl Fn(&T) -> bool) -> Self {
        Self { hits: all.iter().filter(|t| is(t)).count(), of: all.len() }
    }

    /// Clopper and Pearson's 95 % interval of the probability behind it.
    pub fn limits(self) -> [f64; 2] {
        [self.at_least(0.975), self.at_most(0.975)]
    }

    /// The probability behind it is at most this, with so much confidence; 1 where nothing was
    /// seen.
    pub fn at_most(self, confidence: f64) -> f64 {
        if self.hits >= self.of { 1.0 } else { self.chance(self.hits, 1.0 - confidence) }
    }

    /// The probability behind it is at least this, with so much confidence; 0 where nothing was
    /// seen.
    pub fn at_least(self, confidence: f64) -> f64 {
        if self.hits == 0 { 0.0 } else { self.chance(self.hits - 1, confidence) }
    }

    /// The probability at which `hits` or fewer become as rare as `tail`.
    fn chance(self, hits: usize, tail: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let p = 0.5 * (low + high);
            if at_most_of(hits, self.of, p) > tail { low = p } else { high = p }
        }
        0.5 * (low + high)
    }
}

/// Probability of at most `k` of `n` at a chance of `p` each: the regularised incomplete beta
/// function I(1 − p; n − k, k + 1), whose cost does not grow with `k`.
fn at_most_of(k: usize, n: usize, p: f64) -> f64 {
    if k >= n { 1.0 } else { beta_reg((n - k) as f64, (k + 1) as f64, 1.0 - p) }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.of == 0 {
            return write!(f, "–");
        }
        let [low, high] = self.limits().map(|p| 100.0 * p);
        write!(f, "{} of {} ({low:.0}–{high:.0} %)", self.hits, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::Rate;

    #[test]
    fn limits_are_clopper_and_pearsons() {
        for (rate, expected) in [
            (Rate { hits: 8, of: 10 }, [0.4439045, 0.9747893]),
            (Rate { hits: 0, of: 20 }, [0.0, 0.1684335]),
        ] {
            for (found, expected) in rate.limits().iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6, "{rate:?}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn none_in_fifty_nine_shows_one_in_twenty_at_95_percent() {
        // 0.95⁵⁹ = 0.0485: the number that Wilks 1941 is known for.
        assert!(Rate { hits: 0, of: 59 }.at_most(0.95) < 0.05);
        assert!(Rate { hits: 0, of: 58 }.at_most(0.95) > 0.05);
        assert!((Rate { hits: 0, of: 0 }.at_most(0.95) - 1.0).abs() < 1e-12);
    }
}
