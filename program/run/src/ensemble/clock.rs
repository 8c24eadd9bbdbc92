//! When members are looked at.

use leafwise_scene::compose::ComposedRun;
use leafwise_walk::SampleTimes;

/// Marks on the way of every member: numbers of steps where all members make the same, |t| where samples lie at times or
/// steps differ in length. All begin at 0.
pub(super) struct Clock {
    /// Of a mark, in t: ε h for steps, ±1 for times.
    unit: f64,
    /// Whether marks are times.
    pub is_of_time: bool,
    /// Where observables are reduced: 0 and the end among them.
    pub samples: Vec<f64>,
}

impl Clock {
    /// The marks of a run; without samples at times, every so many steps.
    pub fn of(run: &ComposedRun, every: u64) -> Self {
        let plan = &run.plan;
        let step = plan.epsilon * plan.h;
        if run.pace().is_none() && plan.samples.are_steps() {
            let mut samples: Vec<f64> = (0..=plan.steps / every)
                .map(|k| (k * every) as f64)
                .collect();
            if !plan.steps.is_multiple_of(every) {
                samples.push(plan.steps as f64);
            }
            return Self {
                unit: step,
                is_of_time: false,
                samples,
            };
        }
        let end = plan.until.unwrap_or(plan.steps as f64 * step).abs();
        let mut samples = vec![0.0];
        let given = (1..).map_while(|number| plan.samples.time(number, 1.0));
        let given = given.map(f64::abs);
        let is_end = |time: f64| plan.samples.is_end(time, end, plan.until);
        samples.extend(given.take_while(|time| *time < end && !is_end(*time)));
        samples.push(end);
        Self {
            unit: 1.0_f64.copysign(step),
            is_of_time: true,
            samples,
        }
    }

    /// How many samples there are at most, without writing them down.
    pub fn count(run: &ComposedRun, every: u64) -> u64 {
        let plan = &run.plan;
        match &plan.samples {
            SampleTimes::Given(times) => times.len() as u64,
            SampleTimes::Interval(interval) => (plan.until.unwrap_or(0.0) / interval).abs() as u64,
            SampleTimes::Every(_) if run.pace().is_some() => 0,
            SampleTimes::Every(_) => plan.steps / every,
        }
        .saturating_add(2)
    }

    /// The mark of the end.
    pub fn end(&self) -> f64 {
        self.samples.last().copied().unwrap_or(0.0)
    }

    /// t at a mark.
    pub fn time(&self, mark: f64) -> f64 {
        // −0 is 0.
        mark * self.unit + 0.0
    }

    /// The mark of a member at a time after so many steps.
    pub fn mark(&self, steps: u64, time: f64) -> f64 {
        match self.is_of_time {
            true => time * self.unit,
            false => steps as f64,
        }
    }

    /// The ends of at most so many windows of the way, all of one width but the last.
    pub fn windows(&self, most: u64) -> Vec<f64> {
        let end = self.end();
        if self.is_of_time {
            return (1..=most)
                .map(|k| {
                    if k == most {
                        end
                    } else {
                        end * (k as f64 / most as f64)
                    }
                })
                .collect();
        }
        let width = libm::ceil(end / most as f64).max(1.0);
        let count = libm::ceil(end / width) as u64;
        (1..=count).map(|k| (k as f64 * width).min(end)).collect()
    }
}

/// The window, by the marks of their ends, in which a mark lies: the end of a window is its own.
pub(super) fn window(ends: &[f64], mark: f64) -> usize {
    let before = ends.partition_point(|end| *end < mark);
    before.min(ends.len().saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_lies_in_one_window() {
        let clock = Clock {
            unit: 0.1,
            is_of_time: false,
            samples: vec![0.0, 43.0],
        };
        let ends = clock.windows(4);
        assert_eq!(ends, [11.0, 22.0, 33.0, 43.0]);
        let lies = [0.0, 1.0, 11.0, 12.0, 43.0, 44.0].map(|mark| window(&ends, mark));
        assert_eq!(lies, [0, 0, 0, 1, 3, 3]);
        let clock = Clock {
            unit: -1.0,
            is_of_time: true,
            samples: vec![0.0, 2.0],
        };
        assert_eq!(clock.windows(4), [0.5, 1.0, 1.5, 2.0]);
        assert_eq!((clock.time(0.5), clock.mark(3, -0.5)), (-0.5, 0.5));
    }
}
