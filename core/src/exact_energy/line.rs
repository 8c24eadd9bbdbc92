//! The search for a root along a line of multiples: secants, then a bracket.

use super::lane::{Begin, FIRST_CHANGE, LARGEST_SECANT, LaneOfEnergy, MOST_ROUNDINGS};

/// Secants of one search, at most.
const MOST_SECANTS: usize = 12;

/// Secants that may not halve the error.
const MOST_SLOW: usize = 2;

/// Halvings and secants in a bracket, at most.
const MOST_IN_BRACKET: usize = 60;

/// The largest change of the multiples that is looked at, over their units.
const LARGEST_CHANGE: f64 = 8.0;

/// A change of the multiples along a line, and the energy's error of the step there.
#[derive(Clone, Copy)]
pub(super) struct ErrorAt {
    pub change: f64,
    pub error: f64,
}

/// Multiples along a line.
pub(super) struct Line<'a, 'b> {
    pub of: &'a mut LaneOfEnergy,
    pub from: &'a [f64],
    pub direction: &'a [f64],
    /// The error that is taken for none.
    pub least: f64,
    pub begin: Begin<'b>,
    pub increment: &'a mut [f64],
}

impl Line<'_, '_> {
    pub fn multiples(&self, change: f64) -> Vec<f64> {
        let places = self.from.iter().zip(self.direction);
        places.map(|(from, along)| from + change * along).collect()
    }

    /// `None` where the step cannot be made.
    fn at(&mut self, change: f64) -> Option<ErrorAt> {
        let multiples = self.multiples(change);
        let error = self
            .of
            .attempt(&multiples, self.begin, self.increment)
            .ok()?;
        Some(ErrorAt { change, error })
    }

    /// The change with the smallest error that is found from no change, where it is `error`.
    pub fn search(&mut self, error: f64) -> ErrorAt {
        let start = ErrorAt { change: 0.0, error };
        let near = self.by_secants(start);
        if near.error.abs() <= MOST_ROUNDINGS * self.least {
            return near;
        }
        let far = self.by_looking_around(start);
        match far.error.abs() < near.error.abs() {
            true => far,
            false => near,
        }
    }

    /// Secants from a small change on, while they are short and halve the error.
    fn by_secants(&mut self, start: ErrorAt) -> ErrorAt {
        let (mut before, mut best, mut slow) = (start, start, 0);
        let Some(mut last) = self.at(FIRST_CHANGE) else {
            return best;
        };
        for _ in 0..MOST_SECANTS {
            if last.error.abs() < best.error.abs() {
                best = last;
            }
            let change = zero_between(before, last);
            let is_short = change.abs() <= LARGEST_SECANT;
            if best.error.abs() <= self.least || slow > MOST_SLOW || !is_short {
                break;
            }
            let Some(next) = self.at(change) else { break };
            slow += usize::from(next.error.abs() > 0.5 * last.error.abs());
            (before, last) = (last, next);
        }
        best
    }

    /// Changes that double on both sides, until the error has another sign; then what is between.
    fn by_looking_around(&mut self, start: ErrorAt) -> ErrorAt {
        let mut sides = [Some(start); 2];
        let mut change = FIRST_CHANGE;
        while change <= LARGEST_CHANGE {
            for (side, sign) in sides.iter_mut().zip([1.0, -1.0]) {
                let Some(last) = *side else { continue };
                let next = self.at(sign * change);
                if let Some(next) = next
                    && (next.error > 0.0) != (last.error > 0.0)
                {
                    return self.between(last, next);
                }
                *side = next;
            }
            change *= 2.0;
        }
        start
    }

    /// The zero between two changes with errors of two signs: secants whose resting end counts half, and halvings.
    fn between(&mut self, mut a: ErrorAt, mut b: ErrorAt) -> ErrorAt {
        let mut best = match a.error.abs() < b.error.abs() {
            true => a,
            false => b,
        };
        for round in 0..MOST_IN_BRACKET {
            let change = match round % 3 {
                2 => 0.5 * (a.change + b.change),
                _ => zero_between(a, b),
            };
            if best.error.abs() <= self.least || change == a.change || change == b.change {
                break;
            }
            let Some(next) = self.at(change) else { break };
            if next.error.abs() < best.error.abs() {
                best = next;
            }
            if (next.error > 0.0) == (b.error > 0.0) {
                a.error *= 0.5;
            } else {
                a = b;
            }
            b = next;
        }
        best
    }
}

/// Where the line through two errors is 0.
fn zero_between(a: ErrorAt, b: ErrorAt) -> f64 {
    b.change - b.error * (b.change - a.change) / (b.error - a.error)
}
