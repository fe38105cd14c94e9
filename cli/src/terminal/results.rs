//! Where results go unless a folder is named.

use std::path::{Path, PathBuf};

/// Results go under this folder unless another is named.
const RESULTS: &str = "out";

/// `out/NAME` for what is called `name`.
pub(crate) fn folder(name: &str, otherwise: &str) -> PathBuf {
    Path::new(RESULTS).join(safe_name(name, otherwise))
}

/// A name that every file system takes and that leads nowhere else; `otherwise` where nothing of it is left.
pub(crate) fn safe_name(name: &str, otherwise: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let name: String = name.chars().map(safe).collect();
    let name = name.trim_matches('.');
    if name.is_empty() { otherwise } else { name }.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_name_stays_within_the_folder_of_results() {
        for (name, expected) in [
            ("two masses", "two-masses"),
            ("../../etc", "-..-etc"),
            ("...", "run"),
            ("", "run"),
            ("Prüfstand_1.5", "Prüfstand_1.5"),
        ] {
            assert_eq!(folder(name, "run"), Path::new(RESULTS).join(expected));
        }
    }
}
