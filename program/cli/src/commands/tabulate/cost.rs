//! The cost of a table's step, beside the steps that it stands for.

use leafwise::learn::{ManySteps, Tabulated};

use crate::table::{duration, short};

/// Seconds for each state over the time of the table.
pub(super) struct Cost {
    /// Of the table.
    pub table: f64,
    /// Of the scene's own steps, N of them.
    pub own: Steps,
    /// Of the fewest steps of the scene's method whose error is no larger than the table's.
    pub fewest: Steps,
}

/// Steps over the time of the table.
#[derive(Clone, Copy)]
pub(super) struct Steps {
    pub count: u64,
    /// Root mean square of a coordinate less the N steps.
    pub error: f64,
    pub seconds: f64,
}

impl Cost {
    /// Measured over the states that no pair has.
    pub fn of(table: &Tabulated, steps: &ManySteps<'_>) -> Self {
        let states: Vec<Vec<f64>> = table.unseen.iter().map(|(x, _)| x.clone()).collect();
        let of = |steps: ManySteps<'_>, error: f64| Steps {
            count: steps.count,
            error,
            seconds: steps.seconds(&states),
        };
        let own = of(*steps, 0.0);
        let as_good = |count: u64| {
            let larger = steps.in_steps(count);
            let error = error(&larger, table).filter(|error| *error <= table.error)?;
            Some((larger, error))
        };
        // Halves until one is worse, then by bisection between this and the last good one.
        let (mut worse, mut good) = (0, (*steps, 0.0));
        while good.0.count > worse + 1 {
            let count = match worse {
                0 => good.0.count.div_ceil(2).min(good.0.count - 1),
                _ => worse + (good.0.count - worse) / 2,
            };
            match as_good(count) {
                Some(found) => good = found,
                None => worse = count,
            }
        }
        let fewest = match good.0.count == steps.count {
            true => own,
            false => of(good.0, good.1),
        };
        let one = ManySteps {
            map: table.learned.method(),
            step: (1.0, steps.duration()),
            count: 1,
            beside: &[],
            ..*steps
        };
        let parameters = table.learned.parameters();
        Self {
            table: ManySteps { parameters, ..one }.seconds(&states),
            own,
            fewest,
        }
    }

    /// Says so where steps of the method are as good and no dearer.
    pub fn does_not_pay(&self) -> Option<String> {
        if self.fewest.seconds > self.table {
            return None;
        }
        let Steps {
            count,
            error,
            seconds,
        } = self.fewest;
        Some(format!(
            "the table does not pay: {} of the scene's method over the same time err by {}, no more than the table, and take {} a state, the table {}; \
             raise method.time-step, or keep the table if its error suffices",
            if count == 1 {
                "1 step".to_owned()
            } else {
                format!("{count} steps")
            },
            short(error),
            duration(seconds),
            duration(self.table)
        ))
    }
}

/// Root mean square of the error of these steps at the unseen states; `None` where a step fails.
fn error(steps: &ManySteps<'_>, table: &Tabulated) -> Option<f64> {
    let states: Vec<Vec<f64>> = table.unseen.iter().map(|(x, _)| x.clone()).collect();
    let (mut sum, mut count) = (0.0, 0);
    for (end, (_, exact)) in steps.after(&states).into_iter().zip(&table.unseen) {
        for (a, b) in end?.iter().zip(exact) {
            sum += (a - b) * (a - b);
            count += 1;
        }
    }
    let error = libm::sqrt(sum / f64::from(count.max(1)));
    error.is_finite().then_some(error)
}
