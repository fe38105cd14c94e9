//! What to write instead.

use feeler_plant::names::nearest;

/// Names less alike than this are no misspelling of each other.
const ALIKE: f64 = 0.65;

/// "did you mean `mass`?", or the choice where nothing is alike.
pub(crate) fn did_you_mean<'a>(written: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    match nearest_of(written, candidates.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if candidates.is_empty() => "there is none".into(),
        None => format!("there is {}", list(candidates)),
    }
}

/// What was meant, where anything is alike.
pub(crate) fn nearest_of<'a>(written: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    nearest(written, candidates).filter(|near| strsim::jaro_winkler(written, near) >= ALIKE)
}

/// "`a`, `b`, `c`", shortened where long.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const MOST: usize = 16;
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    let shown = names[..names.len().min(MOST)].join(", ");
    if names.len() > MOST { format!("{shown}, ...") } else { shown }
}
