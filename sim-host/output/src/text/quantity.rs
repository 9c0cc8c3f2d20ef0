//! Numbers as people read them: one way to write a quantity with its unit and interval, one to
//! write a share.

use trueweld_plant::effects::Parameter;

/// Most digits after the point.
const MOST_DECIMALS: f64 = 6.0;

/// The unit that a quantity in SI units is shown in, and the factor to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    /// Shown value over SI value.
    pub factor: f64,
    /// The unit shown; empty for a number without one.
    pub unit: &'static str,
}

impl Scale {
    /// Of deviations, residuals and small motions: millimetres and milliradians.
    pub(crate) fn small(si: &'static str) -> Self {
        let (factor, unit) = match si {
            "m" => (1e3, "mm"),
            "rad" => (1e3, "mrad"),
            "rad/s" => (1e3, "mrad/s"),
            "rad/(N·m)" => (1e9, "nrad/(N·m)"),
            "1" => (1.0, ""),
            other => (1.0, other),
        };
        Self { factor, unit }
    }

    /// Of postures, motions and tilts: millimetres and degrees.
    pub(crate) fn large(si: &'static str) -> Self {
        let (factor, unit) = match si {
            "rad" => (1f64.to_degrees(), "°"),
            "rad/s" => (1f64.to_degrees(), "°/s"),
            "rad/s²" => (1f64.to_degrees(), "°/s²"),
            _ => return Self::small(si),
        };
        Self { factor, unit }
    }

    /// Of a parameter of an effect.
    pub(crate) fn of_parameter(parameter: &Parameter) -> Self {
        let (factor, unit) = match (parameter.unit, parameter.name) {
            ("rad", name) if name.starts_with("phase") => return Self::large("rad"),
            ("s", name) if name.starts_with("delay") => (1e3, "ms"),
            ("N/m", _) => (1e-6, "kN/mm"),
            ("1", "exponent" | "order") => (1.0, ""),
            ("1", _) => (1e2, "%"),
            (unit, _) => return Self::small(unit),
        };
        Self { factor, unit }
    }

    /// The number alone, three digits that count: `0.240`.
    pub(crate) fn number(self, value: f64) -> String {
        digits(value * self.factor, 3)
    }

    /// The number with its unit: `0.240 mm`.
    pub(crate) fn quantity(self, value: f64) -> String {
        self.with_unit(self.number(value))
    }

    /// The number with its sign and unit: `+0.240 mm`.
    pub(crate) fn signed(self, value: f64) -> String {
        let sign = if value > 0.0 { "+" } else { "" };
        format!("{sign}{}", self.quantity(value))
    }

    /// The number with its 95 % interval and unit: `0.2400 ± 0.0020 mm`, as many digits as the
    /// interval leaves; without an interval where that has no width or no bounds.
    pub(crate) fn with_interval(self, value: f64, [low, high]: [f64; 2]) -> String {
        let (value, half) = (value * self.factor, 0.5 * (high - low).abs() * self.factor);
        if !(half > 0.0 && half.is_finite()) {
            return self.with_unit(digits(value, 3));
        }
        let decimals = decimals(half, 2);
        self.with_unit(format!("{} ± {half:.decimals$}", fixed(value, decimals)))
    }

    /// The name of an axis or a row, with the unit: `lateral, mm`.
    pub(crate) fn named(self, name: &str) -> String {
        match self.unit {
            "" => name.to_owned(),
            unit => format!("{name}, {unit}"),
        }
    }

    /// A number that is written already, with the unit.
    pub(crate) fn with_unit(self, number: String) -> String {
        match self.unit {
            "" => number,
            "°" | "°/s" | "°/s²" => number + self.unit,
            unit => format!("{number} {unit}"),
        }
    }
}

/// A score, three digits that count: `0.979`.
pub(crate) fn score(score: f64) -> String {
    digits(score, 3)
}

/// From one score to another, as far as the numbers that are shown differ: `the score falls from
/// 3.79 to 1.02`.
pub(crate) fn score_change(before: f64, after: f64) -> String {
    match [before, after].map(score) {
        [from, to] if from == to => format!("the score stays at {to}"),
        [from, to] if after < before => format!("the score falls from {from} to {to}"),
        [from, to] => format!("the score rises from {from} to {to}"),
    }
}

/// A share of a whole in per cent, two digits of it or of what is left of the whole: `62 %`,
/// `0.13 %`, `99.8 %`.
pub(crate) fn share(share: f64) -> String {
    let percent = 100.0 * share;
    let nearest = percent.abs().min((100.0 - percent).abs());
    let text = fixed(percent, if nearest == 0.0 { 0 } else { decimals(nearest, 2) });
    let trimmed = match text.split_once('.') {
        Some((whole, rest)) if rest.bytes().all(|b| b == b'0') => whole,
        Some(_) => text.trim_end_matches('0'),
        None => &text,
    };
    format!("{trimmed} %")
}

/// A change as a share, with its sign: `+20 %`.
pub(crate) fn signed_share(change: f64) -> String {
    let sign = match change {
        c if c > 0.0 => "+",
        c if c < 0.0 => "−",
        _ => "",
    };
    format!("{sign}{}", share(change.abs()))
}

/// A probability that was fitted to data: never certain, never out of the question.
pub(crate) fn probability(p: f64) -> String {
    match p {
        p if p > 0.99 => "> 99 %".to_owned(),
        p if p < 0.01 => "< 1 %".to_owned(),
        p => format!("{:.0} %", 100.0 * p),
    }
}

/// A number with so many decimals; no "-0.00" where it rounds to zero.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    let zero = value.abs() < 0.5 * 10f64.powi(-(decimals as i32));
    format!("{:.decimals$}", if zero { 0.0 } else { value })
}

/// A number with so many digits that count.
pub(crate) fn digits(value: f64, count: usize) -> String {
    if value.abs() < 0.5 * 10f64.powf(-MOST_DECIMALS) {
        return "0".to_owned();
    }
    fixed(value, decimals(value, count))
}

/// Decimals that leave so many digits that count.
fn decimals(value: f64, count: usize) -> usize {
    (count as f64 - 1.0 - value.abs().log10().floor()).clamp(0.0, MOST_DECIMALS) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantity_has_three_digits_and_its_unit() {
        let mm = Scale::small("m");
        assert_eq!(mm.quantity(5.2154e-3), "5.22 mm");
        assert_eq!(mm.quantity(2.43e-4), "0.243 mm");
        assert_eq!(mm.quantity(-1e-12), "0 mm");
        assert_eq!(Scale::large("rad").quantity(0.5), "28.6°");
        assert_eq!(Scale::small("N").quantity(0.0), "0 N");
    }

    #[test]
    fn an_interval_says_how_many_digits_count() {
        let mrad = Scale::small("rad");
        assert_eq!(mrad.with_interval(2.4e-4, [2.38e-4, 2.42e-4]), "0.2400 ± 0.0020 mrad");
        assert_eq!(mrad.with_interval(2.4e-4, [1e-4, 3.8e-4]), "0.24 ± 0.14 mrad");
        let torque = Scale::small("N·m");
        assert_eq!(torque.with_interval(310.0, [310.0; 2]), "310 N·m");
        assert_eq!(torque.with_interval(310.0, [f64::NEG_INFINITY, f64::INFINITY]), "310 N·m");
    }

    #[test]
    fn a_score_falls_only_where_its_number_does() {
        assert_eq!(score_change(3.791, 1.0204), "the score falls from 3.79 to 1.02");
        assert_eq!(score_change(0.9161, 0.9178), "the score rises from 0.916 to 0.918");
        assert_eq!(score_change(0.91799, 0.91801), "the score stays at 0.918");
    }

    #[test]
    fn a_share_keeps_what_tells_it_from_nothing_and_from_all() {
        let shares = [0.0, 0.62, 0.045, 0.0013, 0.95, 0.998, 1.0, 1.3, -0.25];
        let texts = ["0 %", "62 %", "4.5 %", "0.13 %", "95 %", "99.8 %", "100 %", "130 %", "-25 %"];
        assert_eq!(shares.map(share), texts);
        assert_eq!([0.2, 0.0, -0.1].map(signed_share), ["+20 %", "0 %", "−10 %"]);
        assert_eq!([0.999, 0.6, 0.001].map(probability), ["> 99 %", "60 %", "< 1 %"]);
    }
}
