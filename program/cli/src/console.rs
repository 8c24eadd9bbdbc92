//! Where text goes: results to standard output, prose to standard error.

use std::borrow::Cow;
use std::io::{self, ErrorKind, Write};

use leafwise::scene::json::pretty;
use serde::Serialize;

use crate::pulse::Shown;

/// The two streams of a program. A reader that has gone away is not an error; a result that could
/// not be written for another reason is [`lost`](Self::lost).
pub struct Console<'a> {
    out: &'a mut dyn Write,
    err: &'a mut dyn Write,
    /// Why a line of the result was not written.
    pub lost: Option<io::Error>,
    /// Whether prose may be colored.
    pub color: bool,
    /// Whether prose goes to a terminal, where a progress bar makes sense.
    pub is_terminal: bool,
}

impl<'a> Console<'a> {
    /// A console over two streams.
    pub fn new(
        out: &'a mut dyn Write,
        err: &'a mut dyn Write,
        color: bool,
        is_terminal: bool,
    ) -> Self {
        Self {
            out,
            err,
            lost: None,
            color,
            is_terminal,
        }
    }

    /// How a command shows how far it is, if it is not to be quiet.
    pub fn shown(&self, is_quiet: bool) -> Shown {
        match (is_quiet, self.is_terminal) {
            (true, _) => Shown::Nothing,
            (false, true) => Shown::Bar,
            (false, false) => Shown::Lines,
        }
    }

    /// A line of the result, without what would steer a terminal.
    pub fn result(&mut self, text: &str) {
        let text = visible(text, self.color);
        self.verbatim(&text);
    }

    /// A line of the result, to the byte.
    pub fn verbatim(&mut self, text: &str) {
        let written = writeln!(self.out, "{text}").and_then(|()| self.out.flush());
        match written {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => self.lost = Some(error),
            _ => {}
        }
    }

    /// The one JSON object of a command.
    pub fn json(&mut self, value: &impl Serialize) {
        match pretty(value) {
            Ok(text) => self.verbatim(&escaped(&text)),
            Err(error) => self.lost = Some(error),
        }
    }

    /// A line for the reader at the terminal, without what would steer it.
    pub fn prose(&mut self, text: &str) {
        let text = visible(text, self.color);
        let _ = writeln!(self.err, "{text}").and_then(|()| self.err.flush());
    }

    /// `text` in bold where prose is colored.
    pub fn bold(&self, text: &str) -> String {
        if self.color {
            format!("\u{1b}[1m{text}\u{1b}[0m")
        } else {
            text.to_owned()
        }
    }

    /// Prints a warning.
    pub fn warn(&mut self, text: &str) {
        self.prose(&format!("{} {text}", self.warning_word()));
    }

    /// `warning:` in the color of warnings.
    pub fn warning_word(&self) -> &'static str {
        if self.color {
            "\u{1b}[1;33mwarning:\u{1b}[0m"
        } else {
            "warning:"
        }
    }

    /// `error:` in the color of errors.
    pub fn error_word(&self) -> &'static str {
        if self.color {
            "\u{1b}[1;31merror:\u{1b}[0m"
        } else {
            "error:"
        }
    }
}

/// Whether a terminal obeys the character and it does not lay out a text: controls but for line ends and tabs, and what
/// turns the direction of writing.
fn steers(c: char) -> bool {
    let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && c != '\n' && c != '\t')
}

/// JSON in which, beside what JSON asks for, what steers a terminal is escaped: it occurs in strings alone.
fn escaped(json: &str) -> String {
    let mut text = String::new();
    for c in json.chars() {
        if steers(c) {
            text.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            text.push(c);
        }
    }
    text
}

/// The text with signs in place of control characters: a name, a file or a plugin's words may hold some,
/// and a terminal obeys them. Lines and tabs stay; so do colors, where there are any.
fn visible(text: &str, has_color: bool) -> Cow<'_, str> {
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let behind = &rest[c.len_utf8()..];
        match color(rest).filter(|_| has_color) {
            Some(length) => {
                shown.push_str(&rest[..length]);
                rest = &rest[length..];
                continue;
            }
            None if !steers(c) => shown.push(c),
            None if c == '\u{7f}' => shown.push('\u{2421}'),
            None => {
                let picture = char::from_u32(0x2400 + u32::from(c)).filter(|_| c < ' ');
                shown.push(picture.unwrap_or('\u{fffd}'));
            }
        }
        rest = behind;
    }
    Cow::Owned(shown)
}

/// The length of an escape that sets colors and nothing else, where the text begins with one.
fn color(text: &str) -> Option<usize> {
    let numbers = text.strip_prefix("\u{1b}[")?;
    let end = numbers.find(|c: char| !c.is_ascii_digit() && c != ';')?;
    numbers[end..].starts_with('m').then_some(2 + end + 1)
}

#[cfg(test)]
mod tests {
    use super::{escaped, visible};

    #[test]
    fn what_steers_a_terminal_is_shown_as_a_sign() {
        let text = "a\u{1b}[2J\rb\u{7f}\u{9b}c\u{202e}d\ttab\nline ẋ";
        let shown = "a\u{241b}[2J\u{240d}b\u{2421}\u{fffd}c\u{fffd}d\ttab\nline ẋ";
        assert_eq!(visible(text, false), shown);
        assert_eq!(visible(text, true), shown);
        // Colors stay where there are any.
        let red = "\u{1b}[1;31merror:\u{1b}[0m x";
        assert_eq!(visible(red, true), red);
        assert_eq!(visible(red, false), "\u{241b}[1;31merror:\u{241b}[0m x");
        assert_eq!(visible("\u{1b}[1", true), "\u{241b}[1");
    }

    #[test]
    fn json_escapes_what_steers_a_terminal_and_means_the_same() {
        let name = "a\u{1b}\r\u{7f}\u{9b}\u{202e}\u{2066}\n\tẋ";
        let value = serde_json::json!({ "name": name });
        let text = escaped(&format!("{value:#}"));
        assert_eq!(
            text,
            "{\n  \"name\": \"a\\u001b\\r\\u007f\\u009b\\u202e\\u2066\\n\\tẋ\"\n}"
        );
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&text).ok(),
            Some(value)
        );
    }
}
