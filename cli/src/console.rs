//! Where text goes: results to standard output, prose to standard error.

use std::io::{self, ErrorKind, Write};

use serde_json::Value;

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

    /// A line of the result.
    pub fn result(&mut self, text: &str) {
        let written = writeln!(self.out, "{text}").and_then(|()| self.out.flush());
        match written {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => self.lost = Some(error),
            _ => {}
        }
    }

    /// The one JSON object of a command.
    pub fn json(&mut self, value: &Value) {
        self.result(&format!("{value:#}"));
    }

    /// A line for the reader at the terminal.
    pub fn prose(&mut self, text: &str) {
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
