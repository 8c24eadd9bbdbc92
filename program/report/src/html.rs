//! Text in HTML.

use minijinja::HtmlEscape;

/// Text with the characters replaced that mean something in HTML. A slash means nothing in text or between
/// quotes: it stays, so that paths can be searched for.
pub(super) fn escaped(text: &str) -> String {
    HtmlEscape(text).to_string().replace("&#x2f;", "/")
}

#[cfg(test)]
mod tests {
    use super::escaped;

    #[test]
    fn what_means_something_is_replaced_and_paths_stay() {
        let text = "<a href=\"x/y\">'&#x2f;'</a>";
        let html = "&lt;a href=&quot;x/y&quot;&gt;&#x27;&amp;#x2f;&#x27;&lt;/a&gt;";
        assert_eq!(escaped(text), html);
    }
}
