//! Numbers that stand for a value that was not measured, such as −9999.

/// From here on no channel reads, in any unit: the fill values of CF and NetCDF begin with it.
const FILL_VALUE_MIN: f64 = 1e20;

/// True for a number that programs write where they have none: nines, the end of a range of whole
/// numbers, a fill value.
pub(super) fn is_sentinel(number: f64) -> bool {
    const NINES: [f64; 5] = [999.0, 9999.0, 99_999.0, 999_999.0, 9_999_999.0];
    const WHOLE_NUMBER_ENDS: [f64; 4] = [-32_768.0, 32_767.0, -2_147_483_648.0, 2_147_483_647.0];
    NINES.contains(&number.abs())
        || WHOLE_NUMBER_ENDS.contains(&number)
        || number.abs() >= FILL_VALUE_MIN
}

/// True where a number lies farther from the others than they spread: it is none of them.
pub(super) fn is_apart(number: f64, others: &[f64]) -> bool {
    let finite = || others.iter().copied().filter(|x| x.is_finite());
    let (low, high) =
        finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    low <= high && (low - number).max(number - high) > high - low
}

/// Numbers of one column that may stand for none, in place of which NaN was read.
#[derive(Debug, Default)]
pub(super) struct Sentinels {
    /// Row and number.
    found: Vec<(usize, f64)>,
}

impl Sentinels {
    /// A number of a row: NaN where it may stand for none.
    pub(super) fn take(&mut self, row: usize, number: f64) -> f64 {
        if !is_sentinel(number) {
            return number;
        }
        self.found.push((row, number));
        f64::NAN
    }

    /// A row changes places with the one before.
    pub(super) fn swap(&mut self, row: usize) {
        for (at, _) in self.found.iter_mut().rev().take_while(|(at, _)| *at + 1 >= row) {
            *at = if *at == row { row - 1 } else { row };
        }
    }

    /// Sorts them out when all rows were read: puts back what is a value, `of` its number; gives the
    /// numbers that stand for none, and how often.
    pub(super) fn settle(
        self,
        column: &mut [f64],
        of: impl Fn(f64) -> f64,
    ) -> Option<(f64, usize)> {
        let is_none = |(_, number): &(usize, f64)| is_apart(of(*number), column);
        let (none, values): (Vec<_>, Vec<_>) = self.found.into_iter().partition(is_none);
        for (row, number) in values {
            if let Some(value) = column.get_mut(row) {
                *value = of(number);
            }
        }
        none.first().map(|(_, number)| (*number, none.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentinel_is_none_of_the_other_values() {
        assert!(is_sentinel(-9999.0) && is_sentinel(3.402_823_466e38) && is_sentinel(-32_768.0));
        assert!(!is_sentinel(-999.9) && !is_sentinel(0.0) && !is_sentinel(f64::NAN));
        assert!(is_apart(-9999.0, &[-120.0, f64::NAN, 80.0]));
        // A force that goes up to 1 kN.
        assert!(!is_apart(999.0, &[0.0, 400.0, 998.0]));
        assert!(!is_apart(999.0, &[f64::NAN]));
    }
}
