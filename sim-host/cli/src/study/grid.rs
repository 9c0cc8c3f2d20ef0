//! Ranges on the command line: `1.4:2.4:0.1`, or one value.

use std::str::FromStr;
use trueweld_evaluate::study::Range;

/// A range, in the unit of its option.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GridArgument(pub Range);

/// Most values of one range.
const MOST: f64 = 100_000.0;

impl GridArgument {
    /// The range in SI units.
    pub(crate) fn scaled(self, by: f64) -> Range {
        let Range { low, high, step } = self.0;
        Range { low: low * by, high: high * by, step: step * by }
    }
}

impl FromStr for GridArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected VALUE, or LOW:HIGH:STEP with LOW below HIGH and a STEP above 0 that is no longer than \
                        the range, as 1.4:2.4:0.1";
        let numbers: Result<Vec<f64>, _> =
            text.split(':').map(|part| part.trim().parse()).collect();
        let numbers = numbers.map_err(|_| expected.to_owned())?;
        let range = match numbers[..] {
            [value] => Range::at(value),
            [low, high, step] => Range { low, high, step },
            _ => return Err(expected.to_owned()),
        };
        let Range { low, high, step } = range;
        let sound = numbers.iter().all(|v| v.is_finite())
            && (numbers.len() == 1
                || low < high
                    && step > 0.0
                    && step <= (high - low) * (1.0 + 1e-9)
                    && (high - low) / step < MOST);
        if sound { Ok(Self(range)) } else { Err(expected.to_owned()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_that_leads_nowhere_is_refused() {
        let values = |text: &str| text.parse::<GridArgument>().map(|g| g.0.values().len());
        assert_eq!(values("1.4:2.4:0.1"), Ok(11));
        assert_eq!(values("-90:90:30"), Ok(7));
        assert_eq!(values("0.5"), Ok(1));
        for text in
            ["2:1:0.1", "1:2:-0.1", "1:2:0", "1:2", "a", "", "1:2:5", "nan", "0:1:1e-12", "1:2:3:4"]
        {
            assert!(text.parse::<GridArgument>().is_err(), "{text}");
        }
    }
}
