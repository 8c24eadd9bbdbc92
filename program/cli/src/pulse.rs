//! How far a command is, as lines for a standard error that is no terminal.

use std::io::{self, Write};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::Builder;
use std::time::{Duration, Instant};

/// A line comes after so long, and each after so long again.
const EVERY: Duration = Duration::from_secs(20);

/// How a command shows how far it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// By a bar on a terminal.
    Bar,
    /// By a line every now and then.
    Lines,
    /// Not at all.
    Nothing,
}

/// Lines about how far a command is: the part that is done, and about how long the rest takes.
#[derive(Debug)]
pub struct Pulse {
    is_shown: bool,
    started: Instant,
    beats: Beats,
}

/// When lines are due, and what they say.
#[derive(Debug, Default)]
struct Beats {
    shown: u32,
    /// The part that was done when it was first known, and since when.
    begun: Option<(Duration, f64)>,
}

impl Pulse {
    /// Lines from now on, where they are shown.
    pub fn new(shown: Shown) -> Self {
        Self {
            is_shown: shown == Shown::Lines,
            started: Instant::now(),
            beats: Beats::default(),
        }
    }

    /// Writes a line where one is due; `part` of the whole is done, where that is known, and `what` goes on.
    pub fn beat(&mut self, part: Option<f64>, what: impl FnOnce() -> String) {
        if !self.is_shown {
            return;
        }
        if let Some(line) = self.beats.line(self.started.elapsed(), part, what) {
            // Nobody may read it.
            let _ = writeln!(io::stderr(), "{line}");
        }
    }
}

impl Beats {
    /// The line that is due after `elapsed`, if one is.
    fn line(
        &mut self,
        elapsed: Duration,
        part: Option<f64>,
        what: impl FnOnce() -> String,
    ) -> Option<String> {
        let part = part.filter(|part| part.is_finite());
        let begun = part.map(|part| *self.begun.get_or_insert((elapsed, part)));
        if elapsed < EVERY * (self.shown + 1) {
            return None;
        }
        self.shown = u32::try_from(elapsed.as_secs() / EVERY.as_secs()).unwrap_or(u32::MAX - 1);
        let mut line = String::from("  ");
        if let Some(part) = part {
            line.push_str(&format!("{:.0} %, ", 100.0 * part.clamp(0.0, 1.0)));
        }
        line.push_str(&format!(
            "{}, {} so far",
            what(),
            rough(elapsed.as_secs_f64())
        ));
        if let (Some(part), Some((since, before))) = (part, begun)
            && part > before
        {
            let rate = (part - before) / (elapsed - since).as_secs_f64();
            let left = (1.0 - part).max(0.0) / rate;
            line.push_str(&format!(", about {} left", rough(left)));
        }
        Some(line)
    }
}

/// A time as one says it.
fn rough(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..600 => format!("{} min {:02} s", whole / 60, whole % 60),
        600..7200 => format!("{} min", whole / 60),
        7200..172_800 => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
        _ => format!("{} days", whole / 86_400),
    }
}

/// Calls `work` and returns its result. A line tells every now and then that it goes on, where lines are shown and the
/// system grants a thread for them.
pub fn while_working<T>(shown: Shown, what: &'static str, work: impl FnOnce() -> T) -> T {
    if shown != Shown::Lines {
        return work();
    }
    let (done, waits) = mpsc::channel::<()>();
    let tell = move || {
        let mut pulse = Pulse::new(Shown::Lines);
        while waits.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
            pulse.beat(None, || what.to_owned());
        }
    };
    let teller = Builder::new().spawn(tell);
    let made = work();
    drop(done);
    if let Ok(teller) = teller {
        let _ = teller.join();
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(beats: &mut Beats, seconds: u64, part: Option<f64>) -> Option<String> {
        beats.line(Duration::from_secs(seconds), part, || {
            "of 100 steps".to_owned()
        })
    }

    #[test]
    fn a_line_comes_every_twenty_seconds_with_the_time_left() {
        let mut beats = Beats::default();
        assert_eq!(after(&mut beats, 0, Some(0.0)), None);
        assert_eq!(after(&mut beats, 19, Some(0.1)), None);
        let line = after(&mut beats, 20, Some(0.1)).expect("a line");
        assert_eq!(
            line,
            "  10 %, of 100 steps, 20 s so far, about 3 min 00 s left"
        );
        assert_eq!(after(&mut beats, 39, Some(0.2)), None);
        assert!(after(&mut beats, 40, Some(0.2)).is_some());
        // Nothing is made up for.
        assert!(after(&mut beats, 200, Some(0.5)).is_some());
        assert_eq!(after(&mut beats, 210, Some(0.5)), None);
        assert!(after(&mut beats, 220, Some(0.5)).is_some());
    }

    #[test]
    fn what_an_earlier_session_has_done_is_no_part_of_the_rate() {
        let mut beats = Beats::default();
        after(&mut beats, 0, Some(0.5));
        let line = after(&mut beats, 50, Some(0.75)).expect("a line");
        assert_eq!(line, "  75 %, of 100 steps, 50 s so far, about 50 s left");
    }

    #[test]
    fn times_are_told_as_one_says_them() {
        let said = [0.4, 59.6, 100.0, 1234.0, 9000.0, 1e6].map(rough);
        let words = [
            "0 s",
            "1 min 00 s",
            "1 min 40 s",
            "20 min",
            "2 h 30 min",
            "11 days",
        ];
        assert_eq!(said, words);
    }

    #[test]
    fn what_is_not_known_is_not_told() {
        let mut beats = Beats::default();
        let line = after(&mut beats, 30, None).expect("a line");
        assert_eq!(line, "  of 100 steps, 30 s so far");
        let line = after(&mut beats, 60, Some(f64::NAN)).expect("a line");
        assert_eq!(line, "  of 100 steps, 1 min 00 s so far");
    }
}
