//! Tables of an effect of the user's own: values at places along a variable, or at those of a grid over
//! two, and what is between them.

/// The straight line between the values `y` at the places `x`, which rise; held beyond their ends.
pub fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    along(x, at, |k| y[k])
}

/// The same of values that are asked for by the index of their place.
fn along(x: &[f64], at: f64, value: impl Fn(usize) -> f64) -> f64 {
    match between(x, at) {
        _ if at.is_nan() => at,
        (before, after, _) if before == after => value(before),
        (before, after, share) => {
            let (before, after) = (value(before), value(after));
            before + (after - before) * share
        }
    }
}

/// Indices of the places to either side, and how far it is from one to the other, as a share; beyond the
/// ends both are the last place.
fn between(x: &[f64], at: f64) -> (usize, usize, f64) {
    let above = x.partition_point(|x| *x <= at);
    match (above, x.len()) {
        (0, _) => (0, 0, 0.0),
        (k, n) if k == n => (n - 1, n - 1, 0.0),
        (k, _) => (k - 1, k, (at - x[k - 1]) / (x[k] - x[k - 1])),
    }
}

/// Indices of the places to either side, and the share of each in what is between them.
fn shares(x: &[f64], at: f64) -> [(usize, f64); 2] {
    let (before, after, share) = between(x, at);
    [(before, 1.0 - share), (after, share)]
}

/// Where a table has its values: along one variable, or over two, those at all `x` for each place across
/// in turn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Places {
    /// Places of the first variable, rising, in its unit.
    pub x: Vec<f64>,
    /// Those of the second; none where the table is over one.
    pub across: Vec<f64>,
}

impl Places {
    /// Number of values.
    pub fn count(&self) -> usize {
        self.x.len() * self.across.len().max(1)
    }

    /// Value between the values `y`, at one number of each variable; the second counts where there are
    /// places for it.
    pub fn value(&self, y: &[f64], at: [f64; 2]) -> f64 {
        let n = self.x.len();
        match self.across.is_empty() {
            true => interpolate(&self.x, y, at[0]),
            false => along(&self.across, at[1], |row| {
                interpolate(&self.x, &y[row * n..(row + 1) * n], at[0])
            }),
        }
    }

    /// Indices of the values that have a share in what is there, with that share; one may come twice.
    pub fn shares(&self, at: [f64; 2]) -> impl Iterator<Item = (usize, f64)> {
        let n = self.x.len();
        let rows = match self.across.is_empty() {
            true => [(0, 1.0), (0, 0.0)],
            false => shares(&self.across, at[1]),
        };
        let columns = shares(&self.x, at[0]);
        let of_row = move |(row, much): (usize, f64)| {
            columns.into_iter().map(move |(k, share)| (row * n + k, much * share))
        };
        rows.into_iter().flat_map(of_row).filter(|(_, share)| *share > 0.0)
    }

    /// Which of the second variable's places is in the middle.
    pub fn middle(&self) -> usize {
        self.across.len() / 2
    }

    /// The place of a value.
    pub fn place(&self, index: usize) -> [f64; 2] {
        let n = self.x.len();
        [self.x[index % n], self.across.get(index / n).copied().unwrap_or(0.0)]
    }
}

/// What `table(…)` in an expression interpolates; the values at its places are the last parameters
/// of the effect, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct DefinedTable {
    /// Where its values are.
    pub places: Places,
    /// How far a value is expected to be off the straight line through its neighbours, one standard
    /// deviation at places of equal distance, in the unit of the values; infinite where nothing is
    /// known.
    pub bend: f64,
}

/// Most places of one table.
pub const TABLE_PLACES_MAX: usize = 64;

/// Names of the values of a table: `y1` and so on.
const VALUE: &str = "y";

impl DefinedTable {
    /// Name of a value.
    pub(super) fn name_of(index: usize) -> String {
        format!("{VALUE}{}", index + 1)
    }

    /// True for a name that a table needs itself.
    pub fn needs_name(name: &str) -> bool {
        let number = name.strip_prefix(VALUE).is_some_and(|n| n.parse::<usize>().is_ok());
        number || name == "table"
    }

    /// How the table bends at each inner place, along each variable, in what is expected of it: weights
    /// of the values before, at and after it, by their index. Along one variable their squares sum up to
    /// ∫ y″² dx, with places of equal distance to Σ (y₋ − 2 y + y₊)²/bend².
    pub fn bends(&self) -> Vec<[(usize, f64); 3]> {
        let Places { x, across } = &self.places;
        let n = x.len();
        let rows = (0..across.len().max(1)).flat_map(|row| self.bends_of(x, move |k| row * n + k));
        let columns = (0..n).flat_map(|k| self.bends_of(across, move |row| row * n + k));
        rows.chain(columns).collect()
    }

    /// The same along a line of its values, whose index `index` tells.
    fn bends_of(
        &self,
        x: &[f64],
        index: impl Fn(usize) -> usize,
    ) -> impl Iterator<Item = [(usize, f64); 3]> {
        let intervals = x.len().saturating_sub(1).max(1) as f64;
        let mean = (x.last().unwrap_or(&0.0) - x.first().unwrap_or(&0.0)) / intervals;
        x.windows(3).enumerate().map(move |(k, x)| {
            let (before, after) = (x[1] - x[0], x[2] - x[1]);
            let weight = (mean.powi(3) / (0.5 * (before + after))).sqrt() / self.bend;
            let weights = [weight / before, -weight * (1.0 / before + 1.0 / after), weight / after];
            [0, 1, 2].map(|i| (index(k + i), weights[i]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shares_of_its_values_are_the_value_between_them() {
        let x = vec![-1.0, 0.5, 2.0];
        let curve = Places { x: x.clone(), across: Vec::new() };
        let surface = Places { x, across: vec![0.0, 10.0, 30.0, 31.0] };
        for places in [curve, surface] {
            let y: Vec<f64> = (0..places.count()).map(|k| ((k * k) as f64).sin()).collect();
            for at in [[-2.0, -1.0], [-0.3, 4.0], [0.5, 10.0], [1.9, 30.5], [3.0, 40.0]] {
                let shared: f64 = places.shares(at).map(|(k, share)| share * y[k]).sum();
                assert!((shared - places.value(&y, at)).abs() < 1e-12, "{at:?} in {places:?}");
            }
        }
    }

    #[test]
    fn what_is_straight_along_both_variables_bends_nowhere() {
        let places = Places { x: vec![-1.0, 0.5, 2.0, 2.5], across: vec![0.0, 10.0, 30.0] };
        let of = |[u, v]: [f64; 2]| 2.0 - 3.0 * u + 0.1 * v + 0.7 * u * v;
        let y: Vec<f64> = (0..places.count()).map(|k| of(places.place(k))).collect();
        assert!((places.value(&y, [0.1, 22.0]) - of([0.1, 22.0])).abs() < 1e-12);
        let bends = DefinedTable { places, bend: 0.1 }.bends();
        assert_eq!(bends.len(), 2 * 3 + 4);
        for bend in bends {
            let sum: f64 = bend.iter().map(|(k, weight)| weight * y[*k]).sum();
            assert!(sum.abs() < 1e-9, "{bend:?}");
        }
    }
}
