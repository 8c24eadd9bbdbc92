//! Text in HTML.

/// The text with `&`, `<` and `>` replaced.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
