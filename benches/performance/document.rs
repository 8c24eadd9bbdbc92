//! Tables in a page, between markers.

use std::path::Path;

/// Replaces what stands between `<!-- begin NAME -->` and `<!-- end NAME -->`.
///
/// # Panics
/// When the page or the markers are not there.
pub fn write_section(page: &Path, name: &str, text: &str) {
    let before = std::fs::read_to_string(page).expect("the page");
    let (begin, end) = (
        format!("<!-- begin {name} -->\n"),
        format!("<!-- end {name} -->"),
    );
    let (head, rest) = before.split_once(&begin).expect("a begin marker");
    let (_, tail) = rest.split_once(&end).expect("an end marker");
    let after = format!("{head}{begin}{text}{end}{tail}");
    std::fs::write(page, after).expect("the page can be written");
}

/// A table of Markdown.
pub struct Table {
    columns: usize,
    text: String,
}

impl Table {
    /// With these headings.
    pub fn new(headings: &[&str]) -> Self {
        let rule = vec!["---"; headings.len()].join("|");
        Self {
            columns: headings.len(),
            text: format!("| {} |\n|{rule}|\n", headings.join(" | ")),
        }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// When it has not as many cells as there are headings.
    pub fn row(&mut self, cells: &[String]) {
        assert_eq!(cells.len(), self.columns, "one cell a column");
        self.text.push_str(&format!("| {} |\n", cells.join(" | ")));
    }

    /// The table's text.
    pub fn finish(self) -> String {
        self.text
    }
}

/// Seconds in a fitting unit.
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-6 => format!("{:.0} ns", s * 1e9),
        s if s < 1e-5 => format!("{:.2} µs", s * 1e6),
        s if s < 1e-3 => format!("{:.0} µs", s * 1e6),
        s if s < 1e-2 => format!("{:.2} ms", s * 1e3),
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s => format!("{s:.2} s"),
    }
}
