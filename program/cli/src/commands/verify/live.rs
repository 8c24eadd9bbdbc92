//! Rows as they are measured.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use leafwise::verify::{Progress, Refused, Row};

use super::row::{HEADINGS, cells, line};
use crate::bar::tick_steadily;
use crate::console::Console;
use crate::pulse::Pulse;

/// Prints rows on standard output, unless one JSON object is asked for, and tells on standard error
/// how far the survey is.
pub(super) struct Live<'a, 'b> {
    console: &'a mut Console<'b>,
    is_json: bool,
    bar: ProgressBar,
    pulse: Pulse,
}

impl<'a, 'b> Live<'a, 'b> {
    pub(super) fn new(console: &'a mut Console<'b>, is_json: bool) -> Self {
        let target = if console.is_terminal {
            ProgressDrawTarget::stderr_with_hz(8)
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(None, target);
        let template = "  {bar:20} {pos} of {len} combinations on {msg}  {elapsed}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("━━─"));
        }
        Self {
            pulse: Pulse::new(console.shown(false)),
            console,
            is_json,
            bar,
        }
    }

    /// Removes the bar.
    pub(super) fn finish(self) {
        self.bar.finish_and_clear();
    }

    /// After one more combination.
    fn advance(&mut self) {
        self.bar.inc(1);
        let (at, count) = (self.bar.position(), self.bar.length().unwrap_or(0));
        let part = at as f64 / count as f64;
        let bar = &self.bar;
        self.pulse.beat(Some(part), || {
            format!("{at} of {count} combinations on {}", bar.message())
        });
    }

    fn print(&mut self, text: &str) {
        if !self.is_json {
            let console = &mut *self.console;
            self.bar.suspend(|| console.result(text));
        }
    }
}

impl Progress for Live<'_, '_> {
    fn problem(&mut self, name: &str, combinations: usize) {
        // Each problem takes a time of its own.
        self.pulse = Pulse::new(self.console.shown(false));
        self.bar.set_length(combinations as u64);
        self.bar.set_position(0);
        self.bar.set_message(name.to_owned());
        tick_steadily(&self.bar);
        if self.bar.is_hidden() {
            self.console.prose(&format!(
                "measuring {combinations} combinations on {name} ..."
            ));
        }
        self.print(&format!("\n{name}\n{}", line(&HEADINGS)));
    }

    fn refused(&mut self, _: &Refused) {
        self.advance();
    }

    fn row(&mut self, row: &Row) {
        self.advance();
        self.print(&line(&cells(row)));
    }
}
