//! Times of several contestants, taken in turn, and their ratios within each round.

use std::ops::Range;
use std::time::Instant;

/// What a contestant does once.
pub type Run<'a> = Box<dyn FnMut() + 'a>;

/// One sample lasts at least this many seconds, by repeating a short run.
const SHORTEST: f64 = 2e-4;

/// The quartiles of a sample.
#[derive(Clone, Copy, Debug)]
pub struct Quartiles {
    pub low: f64,
    pub median: f64,
    pub high: f64,
}

impl Quartiles {
    /// Of numbers that are all finite.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |part: f64| values[((values.len() - 1) as f64 * part).round() as usize];
        Self {
            low: at(0.25),
            median: at(0.5),
            high: at(0.75),
        }
    }
}

/// Seconds of each contestant in each round: `times[contestant][round]`.
pub struct Times(Vec<Vec<f64>>);

impl Times {
    /// Seconds of a contestant.
    pub fn seconds(&self, contestant: usize) -> Quartiles {
        Quartiles::of(self.0[contestant].clone())
    }

    /// A contestant's time over another's, each round by itself.
    pub fn ratio(&self, contestant: usize, to: usize) -> Quartiles {
        let rounds = self.0[contestant].iter().zip(&self.0[to]);
        Quartiles::of(rounds.map(|(own, other)| own / other).collect())
    }

    /// A contestant's time over the sum of others', each round by itself.
    pub fn over_sum(&self, contestant: usize, others: Range<usize>) -> Quartiles {
        let ratios = (self.0[contestant].iter().enumerate())
            .map(|(round, own)| own / self.0[others.clone()].iter().map(|t| t[round]).sum::<f64>());
        Quartiles::of(ratios.collect())
    }
}

/// Runs the contestants one after the other, `rounds` times, every other round backwards: what the
/// machine does meanwhile strikes them alike.
pub fn interleaved(contestants: &mut [Run<'_>], rounds: usize) -> Times {
    let repeats: Vec<usize> = contestants
        .iter_mut()
        .map(|run| {
            run();
            let once = seconds(run, 1);
            ((SHORTEST / once).ceil() as usize).clamp(1, 1_000_000)
        })
        .collect();
    let mut times = vec![Vec::with_capacity(rounds); contestants.len()];
    let mut order: Vec<usize> = (0..contestants.len()).collect();
    for _ in 0..rounds {
        for &at in &order {
            times[at].push(seconds(&mut contestants[at], repeats[at]));
        }
        order.reverse();
    }
    Times(times)
}

/// What a contestant does once; its seconds, by its own clock.
pub type Clocked<'a> = Box<dyn FnMut() -> f64 + 'a>;

/// The same of contestants that take their own time, each once a round.
pub fn alternating(contestants: &mut [Clocked<'_>], rounds: usize) -> Times {
    let mut times = vec![Vec::with_capacity(rounds); contestants.len()];
    let mut order: Vec<usize> = (0..contestants.len()).collect();
    for _ in 0..rounds {
        for &at in &order {
            times[at].push(contestants[at]());
        }
        order.reverse();
    }
    Times(times)
}

/// Seconds a run, the mean of `repeats`.
fn seconds(run: &mut Run<'_>, repeats: usize) -> f64 {
    let started = Instant::now();
    for _ in 0..repeats {
        run();
    }
    started.elapsed().as_secs_f64() / repeats as f64
}
