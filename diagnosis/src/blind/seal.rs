//! Hides the truth of a case from accidental reading.

use std::fmt::Write as _;

use super::noise::Random;

/// Seed of the random bytes that cover a truth.
const START: u64 = 0x5EA1_ED00;

/// Covers a text: XOR with random bytes, in hexadecimal digits. It hides the text from eyes and searches, not
/// from an attacker.
pub(super) fn seal(text: &str) -> String {
    covered(text.as_bytes()).iter().fold(String::new(), |mut digits, byte| {
        let _ = write!(digits, "{byte:02x}");
        digits
    })
}

/// Uncovers what `seal` covered; `None` for any other text.
pub fn unseal(sealed: &str) -> Option<String> {
    let digits = sealed.trim();
    if !digits.is_ascii() || !digits.len().is_multiple_of(2) {
        return None;
    }
    let bytes: Option<Vec<u8>> =
        (0..digits.len() / 2).map(|i| u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).ok()).collect();
    String::from_utf8(covered(&bytes?)).ok()
}

fn covered(bytes: &[u8]) -> Vec<u8> {
    let mut stream = Random::new(START);
    bytes.iter().map(|byte| byte ^ (stream.bits() >> 24) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_what_is_sealed_is_hidden_and_comes_back() {
        let text = "[{\"kind\": \"coulomb-friction\"}]";
        let sealed = seal(text);
        assert!(!sealed.contains("coulomb"));
        assert_eq!(unseal(&sealed).as_deref(), Some(text));
        assert_eq!(unseal("not sealed"), None);
    }
}
