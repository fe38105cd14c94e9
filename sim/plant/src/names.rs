//! Suggestions for misspelt names.

/// The most similar candidate to `written`, if any is similar: at most half of its letters differ, ignoring
/// case.
pub fn nearest<'a>(written: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let score = |candidate: &str| strsim::jaro_winkler(written, candidate);
    let alike = candidates.into_iter().filter(|candidate| are_alike(written, candidate));
    alike
        .map(|candidate| (score(candidate), candidate))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// "did you mean `mass`?", or the choice if nothing is similar; without a choice, what to do first.
pub fn did_you_mean<'a>(written: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    match nearest(written, candidates.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if candidates.is_empty() => "add one first".into(),
        None if candidates.len() == 1 => format!("there is only {}", list(candidates)),
        None => format!("there are {}", list(candidates)),
    }
}

/// "`a`, `b`, `c`", shortened if long.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const MOST: usize = 16;
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    let shown = names[..names.len().min(MOST)].join(", ");
    if names.len() > MOST { format!("{shown}, ...") } else { shown }
}

/// Whether one may be a misspelling of the other.
fn are_alike(written: &str, candidate: &str) -> bool {
    let length = written.chars().count().max(candidate.chars().count());
    2 * strsim::damerau_levenshtein(&written.to_lowercase(), &candidate.to_lowercase()) <= length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_only_what_is_alike_is_suggested() {
        let names = ["motor", "tip", "base"];
        for (written, near) in [
            ("moter", Some("motor")),
            ("TIP", Some("tip")),
            ("bsae", Some("base")),
            ("gripper", None),
            ("x", None),
        ] {
            assert_eq!(nearest(written, names), near, "{written}");
        }
        assert_eq!(did_you_mean("gripper", names), "there are `motor`, `tip`, `base`");
        assert_eq!(did_you_mean("gripper", ["motor"]), "there is only `motor`");
        assert_eq!(did_you_mean("gripper", []), "add one first");
    }
}
