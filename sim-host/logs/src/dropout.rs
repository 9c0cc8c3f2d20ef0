//! Stretches in which an instrument read nothing.

use std::ops::Range;

/// Runs of rows without a reading that are longer than `bridged` rows, and longer than those between
/// two readings of an instrument that is read more seldom than the log has rows. `read`: whether
/// there is a reading, row by row.
pub fn dropouts(read: impl Iterator<Item = bool>, bridged: usize) -> Vec<Range<usize>> {
    let (mut runs, mut next, mut rows) = (Vec::new(), 0, 0);
    for (row, read) in read.enumerate() {
        rows = row + 1;
        if read {
            runs.push(next..row);
            next = rows;
        }
    }
    runs.push(next..rows);
    runs.retain(|run| !run.is_empty());
    let readings = rows - runs.iter().map(Range::len).sum::<usize>();
    let mut bridged = bridged;
    if 2 * runs.len() > readings {
        let mut lengths: Vec<usize> = runs.iter().map(Range::len).collect();
        let usual = *lengths.select_nth_unstable(runs.len() / 2).1;
        // Times that are not those of the rows are up to a row further apart.
        bridged = bridged.max(usual + 1);
    }
    runs.retain(|run| run.len() > bridged);
    runs
}

#[cfg(test)]
mod tests {
    use super::dropouts;

    #[test]
    fn a_long_gap_is_a_dropout_and_the_rows_between_readings_are_none() {
        let ends = |rows: usize, read: &dyn Fn(usize) -> bool| -> Vec<[usize; 2]> {
            dropouts((0..rows).map(read), 3).iter().map(|run| [run.start, run.end]).collect()
        };
        let gap = |k: usize| !(40..60).contains(&k);
        assert_eq!(ends(100, &|k| gap(k) && !(70..73).contains(&k)), [[40, 60]]);
        assert_eq!(ends(101, &|k| k % 5 == 0 && gap(k)), [[36, 60]]);
        assert_eq!(ends(100, &|k| k < 50), [[50, 100]], "at the end");
        assert!(ends(100, &|_| true).is_empty());
    }
}
