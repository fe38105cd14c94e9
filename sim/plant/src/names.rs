//! Suggestions for misspelt names.

/// The candidate most like `written`, if any exists.
pub fn nearest<'a>(written: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let score = |candidate: &str| strsim::jaro_winkler(written, candidate);
    candidates.into_iter().map(|candidate| (score(candidate), candidate)).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, candidate)| candidate)
}
