//! What a table's step costs, beside the steps that it stands for.

use std::time::{Duration, Instant};

use leafwise::core::{StepMap, Walk};
use leafwise::learn::{ManySteps, Tabulated};

use crate::table::{duration, short};

/// States that are stepped side by side.
const LANES: usize = 64;

/// The time that is measured at least.
const LEAST: Duration = Duration::from_millis(40);

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
            seconds: seconds(&steps, &states),
        };
        let own = of(*steps, 0.0);
        let mut fewest = own;
        let mut count = steps.count;
        while count.is_multiple_of(2) {
            count /= 2;
            let larger = steps.in_steps(count);
            let Some(error) = error(&larger, table) else {
                break;
            };
            if error > table.error {
                break;
            }
            fewest = of(larger, error);
        }
        let one = ManySteps {
            map: table.learned.method(),
            step: (1.0, steps.duration()),
            count: 1,
            beside: &[],
            ..*steps
        };
        let parameters = table.learned.parameters();
        Self {
            table: seconds(&ManySteps { parameters, ..one }, &states),
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
             raise method.time-step, or keep the table for what its error leaves",
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

/// The time of all steps for each state: the shortest of several.
fn seconds(steps: &ManySteps<'_>, states: &[Vec<f64>]) -> f64 {
    let map: &dyn StepMap = steps.map;
    let lanes = states.len().min(LANES);
    let states: Vec<Vec<f64>> = states[..lanes]
        .iter()
        .map(|x| x.iter().chain(steps.beside).copied().collect())
        .collect();
    let values = vec![steps.parameters.to_vec(); lanes];
    let own = (
        leafwise::core::walk::side_by_side(&values),
        leafwise::core::walk::side_by_side(&states),
    );
    let (epsilon, h) = steps.step;
    let mut walk = Walk::side_by_side(map, lanes, (&own.0, &own.1), epsilon, h);
    let begin = Instant::now();
    let mut least = f64::INFINITY;
    while begin.elapsed() < LEAST || least.is_infinite() {
        walk.start_again(map, (&own.0, &own.1));
        let at = Instant::now();
        for _ in 0..steps.count {
            // A lane that fails rests.
            let _ = walk.step();
        }
        least = least.min(at.elapsed().as_secs_f64() / lanes as f64);
    }
    least
}
