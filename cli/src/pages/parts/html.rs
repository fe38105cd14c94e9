//! Text in HTML.

/// Text with HTML's special characters escaped.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Escaped text of sentences, with text between backticks as code.
pub(crate) fn prose(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    // If the number of backticks is odd, the last one is an ordinary character.
    let pairs = (parts.len() - 1) / 2;
    let mut html = String::with_capacity(text.len());
    for (i, part) in parts.iter().enumerate() {
        let mark = match (i, i % 2) {
            (0, _) => "",
            (i, _) if i > 2 * pairs => "`",
            (_, 1) => "<code>",
            _ => "</code>",
        };
        html += mark;
        html += &escape(part);
    }
    html
}

#[cfg(test)]
mod tests {
    use super::{escape, prose};

    #[test]
    fn truth_markup_in_a_text_stays_text() {
        assert_eq!(escape("<script>\"a\" & 'b'"), "&lt;script&gt;&quot;a&quot; &amp; &#39;b&#39;");
    }

    #[test]
    fn truth_what_is_quoted_is_code() {
        assert_eq!(prose("set `a < b` and `c`"), "set <code>a &lt; b</code> and <code>c</code>");
        assert_eq!(prose("`all`"), "<code>all</code>");
        assert_eq!(prose("`a` and ` alone"), "<code>a</code> and ` alone");
        assert_eq!(prose("none"), "none");
    }
}
