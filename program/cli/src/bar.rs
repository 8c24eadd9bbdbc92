//! The progress bar.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread::Builder;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use leafwise::run::{Progress, Status};

use crate::interrupt::is_raised;

/// Redraws a bar that is seen four times a second, where the system grants a thread for it.
pub fn tick_steadily(bar: &ProgressBar) {
    if !bar.is_hidden() && Builder::new().spawn(|| ()).is_ok() {
        bar.enable_steady_tick(Duration::from_millis(250));
    }
}

/// What `build` makes; a line with the time it takes is drawn meanwhile, if `is_shown`.
pub fn while_building<T>(is_shown: bool, build: impl FnOnce() -> T) -> T {
    let line = Steps::new("building: from formulas to code", is_shown);
    if let Ok(style) = ProgressStyle::with_template("  {spinner} {elapsed}  {msg}") {
        line.0.set_style(style);
    }
    let built = build();
    line.finish();
    built
}

/// Shows a run on the terminal and stops it when asked to.
pub struct Bar {
    bar: ProgressBar,
    interrupt: Arc<AtomicBool>,
}

impl Bar {
    /// A bar for `steps` steps, drawn only if `is_shown`.
    pub fn new(steps: u64, is_shown: bool, interrupt: &Arc<AtomicBool>) -> Self {
        let target = if is_shown {
            ProgressDrawTarget::stderr_with_hz(8)
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(Some(steps), target);
        let template = "  {bar:20} {percent:>3} %  {human_pos} of {human_len} steps  {msg}  {eta}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("━━─"));
        }
        // A run that is over at once shows no bar.
        tick_steadily(&bar);
        Self {
            bar,
            interrupt: Arc::clone(interrupt),
        }
    }

    /// Removes the bar.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

/// Shows how far a survey of methods is.
pub struct Steps(ProgressBar);

impl Steps {
    /// A line, drawn only if `is_shown`.
    pub fn new(message: &str, is_shown: bool) -> Self {
        let target = if is_shown {
            ProgressDrawTarget::stderr_with_hz(8)
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(Some(1), target);
        if let Ok(style) = ProgressStyle::with_template("  {bar:20} {pos} of {len}  {msg}") {
            bar.set_style(style.progress_chars("━━─"));
        }
        bar.set_message(message.to_owned());
        tick_steadily(&bar);
        Self(bar)
    }

    /// A spinner, drawn only if `is_shown`, for a search of unknown length.
    pub fn unmeasured(message: &str, is_shown: bool) -> Self {
        let line = Self::new(message, is_shown);
        if let Ok(style) = ProgressStyle::with_template("  {spinner} {pos} runs  {msg}") {
            line.0.set_style(style);
        }
        line
    }

    /// Before the next run.
    pub fn tick(&mut self, method: &str, runs: u64) {
        self.0.set_position(runs);
        self.0.set_message(method.to_owned());
    }

    /// Before something that is no run.
    pub fn say(&mut self, message: String) {
        self.0.set_message(message);
    }

    /// Where the line is, and what it says.
    #[cfg(test)]
    pub fn shown(&self) -> (u64, String) {
        (self.0.position(), self.0.message())
    }

    /// Before the next method.
    pub fn show(&mut self, method: &str, at: usize, count: usize) {
        self.0.set_length(count as u64);
        self.0.set_position(at as u64);
        self.0.set_message(method.to_owned());
    }

    /// Removes the line.
    pub fn finish(self) {
        self.0.finish_and_clear();
    }
}

impl Progress for Bar {
    fn show(&mut self, status: &Status) {
        if self.bar.is_hidden() {
            return;
        }
        let energy = format!("energy {:.1e}", status.energy_drift);
        let Some(until) = status.until else {
            self.bar.set_position(status.steps);
            return self.bar.set_message(energy);
        };
        // How many steps it takes is not known.
        let total = (status.steps as f64 * (until / status.time)).max(1.0);
        self.bar.set_length(total as u64);
        self.bar.set_position(status.steps);
        self.bar
            .set_message(format!("t = {:.4e}  {energy}", status.time));
    }

    fn is_interrupted(&self) -> bool {
        is_raised(&self.interrupt)
    }
}
