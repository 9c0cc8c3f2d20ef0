//! How far along the seam every row is, and which rows lie on it.

use trueweld_plant::simulate::{Phase, RecordRow};

/// Distance that the nominal tool has gone since the first row, m, one value a row.
pub(crate) fn travelled(rows: &[RecordRow]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut before = None;
    rows.iter()
        .map(|row| {
            let here = row.nominal.position;
            sum += before.map_or(0.0, |b: nalgebra::Vector3<f64>| (here - b).norm());
            before = Some(here);
            sum
        })
        .collect()
}

/// True while the tool moves along the seam: only then does a path position say which instant is
/// meant.
pub(crate) fn moving(phase: Phase) -> bool {
    matches!(phase, Phase::FeedRamp | Phase::Steady | Phase::Stop)
}
