//! Default folders of results.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Parent of default folders of results.
const RESULTS: &str = "out";

/// Largest number of letters in a folder's name.
const LONGEST: usize = 120;

/// `out/NAME` for the name `name`.
pub(crate) fn folder(name: &str, otherwise: &str) -> PathBuf {
    Path::new(RESULTS).join(safe_name(name, otherwise))
}

/// `out/NAME,controllers.force.kp=0.4` for the name `name` with some keys set on the command line. Each set
/// of settings has a folder of its own.
pub(crate) fn variant(name: &str, settings: &[String], otherwise: &str) -> PathBuf {
    let tidy = |setting: &String| {
        let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
        format!("{}={}", key.trim(), value.trim())
    };
    let words: Vec<String> = std::iter::once(name.to_owned()).chain(settings.iter().map(tidy)).collect();
    let words = words.join(",");
    let safe = |c: char| if c.is_alphanumeric() || "-_.,=+".contains(c) { c } else { '-' };
    let mut folder: String = words.chars().map(safe).take(LONGEST).collect();
    // A cut name may be that of another variant.
    if words.chars().count() > LONGEST {
        let _ = write!(folder, ",{:016x}", digest(&words));
    }
    let folder = folder.trim_matches('.');
    Path::new(RESULTS).join(if folder.is_empty() { otherwise } else { folder })
}

/// FNV-1a, which is the same in every version.
fn digest(text: &str) -> u64 {
    text.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// A name that is valid on every file system and contains no path; `otherwise` if no valid character remains.
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

    #[test]
    fn truth_a_variant_has_a_folder_of_its_own() {
        let of = |settings: &[&str]| {
            let settings: Vec<String> = settings.iter().map(|s| (*s).to_owned()).collect();
            variant("press", &settings, "run")
        };
        assert_eq!(of(&[]), folder("press", "run"));
        assert_eq!(
            of(&["controllers.force.kp=0.4", "contacts.tool.gap=5 mm"]),
            Path::new("out/press,controllers.force.kp=0.4,contacts.tool.gap=5-mm")
        );
        assert_eq!(of(&["a=../../b"]), Path::new("out/press,a=..-..-b"));
        let lead = format!("controllers.force.lead={{ zero = 20, pole = 200, {} }}", "x".repeat(LONGEST));
        for [a, b] in [
            ["controllers.a.kp=1", "controllers.b.kp=1"],
            ["a.k=1e+3", "a.k=1e-3"],
            [&lead, &format!("{lead} ")],
            [&format!("{lead}1"), &format!("{lead}2")],
        ] {
            assert_eq!(of(&[a]) == of(&[b]), a.trim() == b.trim(), "{a} {b}");
        }
    }
}
