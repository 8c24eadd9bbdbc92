//! The time that a search may take.

use std::time::{Duration, Instant};

use leafwise::trade::{Stage, Tuner, Tuning};

use crate::table::duration;

/// The part of the time that methods may be formed in: one that is not run tells nothing.
const TO_FORM: f64 = 0.5;

/// A search that takes longer than this many times what it may says so.
const OVER: f64 = 1.1;

/// Counts the seconds of a search, and which method took the longest to form.
pub(super) struct Clock {
    within: Option<f64>,
    start: Instant,
    /// Method that is being formed, and since when.
    forming: Option<(String, Instant)>,
    longest: Option<(String, Duration)>,
    /// How long the last one took.
    last: Duration,
}

impl Clock {
    /// A clock that starts now and allows so many seconds.
    pub(super) fn new(within: Option<f64>) -> Self {
        Self {
            within,
            start: Instant::now(),
            forming: None,
            longest: None,
            last: Duration::ZERO,
        }
    }

    /// Whether there is time for a stage; what is formed now is what it names.
    pub(super) fn allows(&mut self, stage: Stage<'_>) -> bool {
        let now = Instant::now();
        if let Some((method, since)) = self.forming.take() {
            let took = now - since;
            self.last = took;
            if self.longest.as_ref().is_none_or(|(_, most)| took > *most) {
                self.longest = Some((method, took));
            }
        }
        let spent = (now - self.start).as_secs_f64();
        let (part, ahead) = match stage {
            // What is being formed is not interrupted: the next one is taken to last as long as the one before.
            Stage::Building { .. } => (TO_FORM, self.last.as_secs_f64()),
            Stage::Reference | Stage::Running { .. } => (1.0, 0.0),
        };
        let is_allowed = self
            .within
            .is_none_or(|within| spent + ahead < part * within);
        // What is not allowed is not formed, the scene's own method apart, which comes first.
        if let Stage::Building { method } = stage
            && (is_allowed || self.longest.is_none())
        {
            self.forming = Some((method.to_owned(), now));
        }
        is_allowed
    }

    /// Message about a search that its time limit has ended: methods that were not formed, and how long the search took
    /// where that is far over. Returns `None` for a complete search, and without a limit.
    pub(super) fn ended(&self, tuner: &Tuner<'_>, tuning: &Tuning) -> Option<String> {
        let within = self.within.filter(|_| !tuning.is_complete)?;
        let unbuilt = match (tuner.unbuilt(), &self.longest) {
            (0, _) => String::new(),
            (count, None) => format!("; {count} methods were not formed"),
            (count, Some((method, took))) => format!(
                "; {count} methods were not formed, and the longest to form was {method}, {}",
                duration(took.as_secs_f64())
            ),
        };
        let took = self.start.elapsed().as_secs_f64();
        let over = match took > OVER * within {
            true => format!(
                "; it took {}, because neither a method being formed nor the reference is interrupted",
                duration(took)
            ),
            false => String::new(),
        };
        Some(format!(
            "not all methods were tried within {within} seconds{unbuilt}{over}: there may be a cheaper one; raise \
             --within, or name methods with --only"
        ))
    }
}
