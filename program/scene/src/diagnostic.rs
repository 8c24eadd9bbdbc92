//! Diagnostics of a scene: its errors, underlined where they stand.

use std::fmt;
use std::ops::Range;

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

/// A problem ready to print: message, text, the piece to underline, what to try.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneDiagnostic {
    /// Message: the error in words.
    pub message: String,
    /// Text under the underlined piece.
    pub label: String,
    /// The name of the text: a file, a library system, or `--set`.
    pub source_name: String,
    /// The whole text.
    pub source_text: String,
    /// The byte range to underline.
    pub span: Range<usize>,
    /// Advice: a remedy to try.
    pub help: Option<String>,
}

impl SceneDiagnostic {
    /// Line and column of the underlined piece, both from 1; columns count characters.
    pub fn line_column(&self) -> (usize, usize) {
        let before = &self.source_text[..self.clamped().start];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (
            before.matches('\n').count() + 1,
            before[line_start..].chars().count() + 1,
        )
    }

    /// The message and what to try, without the place.
    pub fn line(&self) -> String {
        match &self.help {
            Some(help) => format!("{} ({help})", self.message),
            None => self.message.clone(),
        }
    }

    /// The message with the piece of text underlined, as compilers print it.
    pub fn render(&self, color: bool) -> String {
        let span = self.clamped();
        let mut group = Level::ERROR.primary_title(self.message.as_str()).element(
            Snippet::source(self.source_text.as_str())
                .path(self.source_name.as_str())
                .annotation(
                    AnnotationKind::Primary
                        .span(span)
                        .label(self.label.as_str()),
                ),
        );
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        let renderer = if color {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        renderer.decor_style(DecorStyle::Ascii).render(&[group])
    }

    /// The span inside the text and on character boundaries.
    fn clamped(&self) -> Range<usize> {
        let start = floor_boundary(&self.source_text, self.span.start);
        let end = floor_boundary(&self.source_text, self.span.end);
        start..end.max(start)
    }
}

impl fmt::Display for SceneDiagnostic {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (line, column) = self.line_column();
        let said = self.line();
        write!(formatter, "{}:{line}:{column}: {said}", self.source_name)
    }
}

impl std::error::Error for SceneDiagnostic {}

fn floor_boundary(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}

/// The byte range of a TOML string's content when the content is its value byte for byte:
/// no escapes, no rewritten line ends. A bare key or a number is its own content.
pub fn string_content(text: &str, value: Range<usize>) -> Option<Range<usize>> {
    let written = text.get(value.clone())?;
    let (open, close, escapes) = if written.starts_with("\"\"\"") {
        (3, 3, true)
    } else if written.starts_with("'''") {
        (3, 3, false)
    } else if written.starts_with('"') {
        (1, 1, true)
    } else if written.starts_with('\'') {
        (1, 1, false)
    } else {
        (0, 0, false)
    };
    let inside = written.get(open..written.len().checked_sub(close)?)?;
    if (escapes && inside.contains('\\')) || inside.contains('\r') {
        return None;
    }
    let newline = usize::from(open == 3 && inside.starts_with('\n'));
    Some(value.start + open + newline..value.end - close)
}

/// Maps the bytes `inner` of a string's value to the text. The result is the exact piece where the string is written
/// plainly. It is the whole string where that has escapes or the range does not fit.
pub fn formula_span(text: &str, value: Range<usize>, inner: Range<usize>) -> Range<usize> {
    let Some(content) = string_content(text, value.clone()) else {
        return value;
    };
    let start = content.start.saturating_add(inner.start);
    let end = content.start.saturating_add(inner.end);
    if start > end || end > content.end {
        value
    } else {
        start..end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagnostic_prints_like_a_compiler() {
        let text = "[system]\nhamiltonian = \"x1^2/(2*I4)\"\n";
        let formula = 23..36;
        assert_eq!(&text[formula.clone()], "\"x1^2/(2*I4)\"");
        let diagnostic = SceneDiagnostic {
            message: "unknown name `I4`".to_owned(),
            label: "neither a variable nor a parameter".to_owned(),
            source_name: "scene.toml".to_owned(),
            source_text: text.to_owned(),
            span: formula_span(text, formula, 9..11),
            help: Some("did you mean `I1`?".to_owned()),
        };
        let expected = "\
error: unknown name `I4`
 --> scene.toml:2:25
  |
2 | hamiltonian = \"x1^2/(2*I4)\"
  |                         ^^ neither a variable nor a parameter
  |
  = help: did you mean `I1`?";
        assert_eq!(diagnostic.render(false), expected);
        assert_eq!(diagnostic.line_column(), (2, 25));
        assert_eq!(
            diagnostic.to_string(),
            "scene.toml:2:25: unknown name `I4` (did you mean `I1`?)"
        );
        assert!(diagnostic.render(true).contains("\u{1b}["));
    }

    #[test]
    fn plain_strings_map_exactly_and_escaped_ones_as_a_whole() {
        let piece = |text: &'static str, inner: Range<usize>| {
            let start = text.find('=').map_or(0, |equals| equals + 2);
            &text[formula_span(text, start..text.len(), inner)]
        };
        assert_eq!(piece("h = \"a + bc\"", 4..6), "bc");
        assert_eq!(piece("h = 'a + bc'", 4..6), "bc");
        assert_eq!(piece("h = \"\"\"\na +\n bc\"\"\"", 5..7), "bc");
        assert_eq!(piece("h = '''a + bc'''", 4..6), "bc");
        assert_eq!(piece("h = \"a\\t+ bc\"", 4..6), "\"a\\t+ bc\"");
        assert_eq!(
            piece("h = \"\"\"a \\\n + bc\"\"\"", 4..6),
            "\"\"\"a \\\n + bc\"\"\""
        );
        assert_eq!(piece("h = 1.25", 2..4), "25");
        assert_eq!(piece("h = \"ab\"", 1..9), "\"ab\"");
    }

    #[test]
    fn spans_outside_the_text_are_clamped() {
        let diagnostic = SceneDiagnostic {
            message: "m".to_owned(),
            label: "l".to_owned(),
            source_name: "s".to_owned(),
            source_text: "αβ".to_owned(),
            span: 3..99,
            help: None,
        };
        assert_eq!(diagnostic.line_column(), (1, 2));
        assert!(diagnostic.render(false).contains("s:1:2"));
    }
}
