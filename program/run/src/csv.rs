//! Comma-separated values (RFC 4180): every heading and every text of a table goes through here.

use std::borrow::Cow;

/// A cell of text: in quotes where it holds a comma, a quote or a line break, and where a spreadsheet
/// would take it for a formula.
pub(crate) fn text_cell(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) || text.starts_with(['=', '+', '-', '@']) {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}

/// The headings of a table, each of them once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Headings(Vec<String>);

impl Headings {
    /// One more column. Where its name is taken, what it is stands behind it: `q (Casimir)`.
    pub fn push(&mut self, name: &str, kind: &str) {
        let mut heading = name.to_owned();
        let mut again = 1_u32;
        while self.0.contains(&heading) {
            heading = match again {
                1 => format!("{name} ({kind})"),
                again => format!("{name} ({kind} {again})"),
            };
            again += 1;
        }
        self.0.push(heading);
    }

    /// Several of a kind.
    pub fn extend(&mut self, names: impl IntoIterator<Item = impl AsRef<str>>, kind: &str) {
        for name in names {
            self.push(name.as_ref(), kind);
        }
    }

    /// The line of headings, its end included; of several lines where a name has several.
    pub fn line(&self) -> String {
        let cells: Vec<_> = self.0.iter().map(|heading| text_cell(heading)).collect();
        cells.join(",") + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_reads_back_and_is_no_formula() {
        for (text, cell) in [
            ("energy", "energy"),
            ("x[3]^2 + 1", "x[3]^2 + 1"),
            ("max(a, b)", "\"max(a, b)\""),
            ("q^2\n+ p^2", "\"q^2\n+ p^2\""),
            ("a\rb", "\"a\rb\""),
            ("say \"h\"", "\"say \"\"h\"\"\""),
            ("=HYPERLINK(1)", "\"=HYPERLINK(1)\""),
            ("-q", "\"-q\""),
        ] {
            assert_eq!(text_cell(text), cell);
        }
    }

    #[test]
    fn a_heading_that_is_taken_says_what_it_is() {
        let mut headings = Headings::default();
        headings.push("t", "time");
        headings.extend(["q", "t", "p (Casimir)"], "variable");
        headings.extend(["q", "p", "q"], "Casimir");
        let line = "t,q,t (variable),p (Casimir),q (Casimir),p,q (Casimir 2)\n";
        assert_eq!(headings.line(), line);
    }
}
