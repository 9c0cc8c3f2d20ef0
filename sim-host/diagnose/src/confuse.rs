//! Which hypotheses these data cannot tell apart, whatever they say: what two effects do to the
//! residuals, beyond what calibrations mend, compared.

use super::screen::{ScreenedEffect, SearchContext};
use trueweld_estimate::fit::Slopes;
use trueweld_plant::effects::EffectPlace;

/// Two hypotheses that the data cannot tell apart, or only where they are large.
#[derive(Debug, Clone)]
pub struct Confusable {
    /// One effect.
    pub first: EffectPlace,
    /// The other.
    pub second: EffectPlace,
    /// Cosine between what the two do to the residuals beyond what calibrations mend: 1 where they
    /// do the same.
    pub alike: f64,
}

impl Confusable {
    /// How many times its detection limit an effect must be for the data to tell it from the other.
    pub fn factor(&self) -> f64 {
        (1.0 - self.alike * self.alike).max(1e-6).sqrt().recip()
    }
}

/// Cosine from which on two hypotheses are reported: told apart from ten times the detection limit
/// on.
const CONFUSABLE_COSINE: f64 = 0.995;

/// Pairs of hypotheses at their best shapes that do nearly the same, most alike first.
pub(super) fn confusable(ctx: &SearchContext<'_>, screened: &[ScreenedEffect]) -> Vec<Confusable> {
    let (columns, more): (Vec<usize>, Vec<&Slopes>) = screened
        .iter()
        .enumerate()
        .flat_map(|(h, s)| s.slopes.iter().map(move |slope| (h, slope)))
        .unzip();
    let SearchContext { null, blocks, .. } = ctx;
    let slopes: Vec<&Slopes> = null.slopes.iter().chain(more).collect();
    let all = null.linear.renewed(blocks, &null.residuals, &slopes, |_| false);
    let all = all.information(None, 1.0);
    // Without the shadow that each slope has on the calibrations.
    let (n, m) = (null.slopes.len(), columns.len());
    let cross = all.view((0, n), (n, m)).into_owned();
    let Some(factor) = null.linear.factor() else {
        return Vec::new();
    };
    let gram = all.view((n, n), (m, m)) - cross.tr_mul(&factor.solve(&cross));
    let of = |h: usize| -> Vec<usize> { (0..columns.len()).filter(|c| columns[*c] == h).collect() };
    let block = |a: &[usize], b: &[usize]| gram.select_rows(a).select_columns(b);
    let mut pairs = Vec::new();
    for a in 0..screened.len() {
        let Some(left) = block(&of(a), &of(a)).cholesky() else {
            continue;
        };
        for b in 0..a {
            let Some(right) = block(&of(b), &of(b)).cholesky() else {
                continue;
            };
            // Canonical correlation: the largest singular value of L⁻¹ C R⁻ᵀ.
            let cross = block(&of(a), &of(b));
            let Some(half) = left.l().solve_lower_triangular(&cross) else {
                continue;
            };
            let Some(whitened) = right.l().solve_lower_triangular(&half.transpose()) else {
                continue;
            };
            let alike = whitened.singular_values().max().min(1.0);
            if alike > CONFUSABLE_COSINE {
                let [first, second] = [b, a].map(|h: usize| screened[h].limit.effect);
                pairs.push(Confusable { first, second, alike });
            }
        }
    }
    pairs.sort_by(|a, b| b.alike.total_cmp(&a.alike));
    pairs
}
