//! The progress bar.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread::Builder;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use leafwise::run::{Progress, Status};

use crate::interrupt::is_raised;
use crate::pulse::{Pulse, Shown, while_working};
use crate::table::grouped;

/// Redraws a bar that is seen four times a second, where the system grants a thread for it.
pub fn tick_steadily(bar: &ProgressBar) {
    if !bar.is_hidden() && Builder::new().spawn(|| ()).is_ok() {
        bar.enable_steady_tick(Duration::from_millis(250));
    }
}

/// Where a bar is drawn.
fn target(shown: Shown) -> ProgressDrawTarget {
    match shown {
        Shown::Bar => ProgressDrawTarget::stderr_with_hz(8),
        Shown::Lines | Shown::Nothing => ProgressDrawTarget::hidden(),
    }
}

/// Message shown while a scene is built.
const BUILDING: &str = "building: from formulas to code";

/// Calls `build` and returns its result. A line with the time it takes is shown meanwhile.
pub fn while_building<T>(shown: Shown, build: impl FnOnce() -> T) -> T {
    let line = Steps::new(
        BUILDING,
        if shown == Shown::Bar {
            shown
        } else {
            Shown::Nothing
        },
    );
    if let Ok(style) = ProgressStyle::with_template("  {spinner} {elapsed}  {msg}") {
        line.bar.set_style(style);
    }
    let built = while_working(shown, BUILDING, build);
    line.finish();
    built
}

/// Shows a run on the terminal and stops it when asked to.
pub struct Bar {
    bar: ProgressBar,
    pulse: Pulse,
    interrupt: Arc<AtomicBool>,
}

impl Bar {
    /// A bar for `steps` steps.
    pub fn new(steps: u64, shown: Shown, interrupt: &Arc<AtomicBool>) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps), target(shown));
        let template = "  {bar:20} {percent:>3} %  {human_pos} of {human_len} steps  {msg}  {eta}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("━━─"));
        }
        // A run that is over at once shows no bar.
        tick_steadily(&bar);
        Self {
            bar,
            pulse: Pulse::new(shown),
            interrupt: Arc::clone(interrupt),
        }
    }

    /// Removes the bar.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

/// Shows how far a survey of methods is.
pub struct Steps {
    bar: ProgressBar,
    pulse: Pulse,
    /// Whether it is known how much there is to do.
    is_measured: bool,
    /// Noun behind a count without a total, with its leading space, as in ` runs`; empty where there is none.
    unit: &'static str,
}

impl Steps {
    /// A line.
    pub fn new(message: &str, shown: Shown) -> Self {
        let bar = ProgressBar::with_draw_target(Some(1), target(shown));
        if let Ok(style) = ProgressStyle::with_template("  {bar:20} {pos} of {len}  {msg}") {
            bar.set_style(style.progress_chars("━━─"));
        }
        bar.set_message(message.to_owned());
        tick_steadily(&bar);
        Self {
            bar,
            pulse: Pulse::new(shown),
            is_measured: false,
            unit: "",
        }
    }

    /// A spinner for a search of unknown length.
    pub fn unmeasured(message: &str, shown: Shown) -> Self {
        let line = Self::new(message, shown);
        if let Ok(style) = ProgressStyle::with_template("  {spinner} {pos} runs  {msg}") {
            line.bar.set_style(style);
        }
        Self {
            unit: " runs",
            ..line
        }
    }

    /// Before the next run.
    pub fn tick(&mut self, method: &str, runs: u64) {
        self.bar.set_position(runs);
        self.say(method.to_owned());
    }

    /// Before something that is no run.
    pub fn say(&mut self, message: String) {
        self.bar.set_message(message);
        let (bar, unit) = (&self.bar, self.unit);
        let (at, count) = (bar.position(), bar.length().unwrap_or(1));
        let part = self.is_measured.then(|| at as f64 / count.max(1) as f64);
        self.pulse.beat(part, || match part {
            Some(_) => format!("{at} of {count}, {}", bar.message()),
            None if unit.is_empty() => bar.message(),
            None => format!("{at}{unit}, {}", bar.message()),
        });
    }

    /// Where the line is, and what it says.
    #[cfg(test)]
    pub fn shown(&self) -> (u64, String) {
        (self.bar.position(), self.bar.message())
    }

    /// Before the next method.
    pub fn show(&mut self, method: &str, at: usize, count: usize) {
        self.bar.set_length(count as u64);
        self.bar.set_position(at as u64);
        self.is_measured = true;
        self.say(method.to_owned());
    }

    /// Removes the line.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn show(&mut self, status: &Status) {
        let part = match status.until {
            None => status.steps as f64 / status.total.max(1) as f64,
            Some(until) => status.time / until,
        };
        self.pulse.beat(Some(part), || match status.until {
            None => format!(
                "{} of {} steps",
                grouped(status.steps),
                grouped(status.total)
            ),
            Some(until) => format!("t = {:.4e} of {until:.4e}", status.time),
        });
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
