//! What was probably meant by an unknown word.

/// Most bytes of a word that was meant to be another: no key or name is longer.
const MOST_WORD: usize = 200;

/// The candidate that a word resembles, if one does: what was probably meant.
pub fn nearest<'k>(word: &str, candidates: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    candidates
        .into_iter()
        .filter(|c| word.len().max(c.len()) <= MOST_WORD)
        .map(|c| (strsim::normalized_damerau_levenshtein(word, c), c))
        .filter(|(likeness, _)| *likeness > 0.6)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, c)| c)
}

/// What was probably meant by an unknown word, as a question in brackets; nothing where it
/// resembles none of the candidates.
pub fn did_you_mean<'k>(word: &str, candidates: impl IntoIterator<Item = &'k str>) -> String {
    nearest(word, candidates).map_or(String::new(), |near| format!(" (did you mean `{near}`?)"))
}
