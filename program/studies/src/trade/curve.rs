//! The reference solution between its steps.

use leafwise_core::Walk;
use leafwise_core::solver::judge::larger;
use leafwise_scene::ComposedRun;

use super::norm::{distance, norm};

/// x*(t) from 0 to the end time: states at equal steps, and the polynomial of degree 11 through the twelve nearest
/// between them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    dimension: usize,
    /// Whether the last coordinate is the time, of steps of a fictitious one.
    is_paced: bool,
    /// State after state.
    states: Vec<f64>,
    /// Error that interpolation may add.
    pub error: f64,
    /// max ‖x*(t)‖.
    pub norm: f64,
}

/// States of a polynomial.
const NODES: usize = 12;

/// (−1)ᵏ binom(11, k): the barycentric weights of equidistant nodes.
const WEIGHTS: [f64; NODES] = [
    1.0, -11.0, 55.0, -165.0, 330.0, -462.0, 462.0, -330.0, 165.0, -55.0, 11.0, -1.0,
];

/// Of twice the spacing the error is 2¹² times as large; four of that are left for higher terms.
const REDUCED: f64 = 1.0 / 1024.0;

/// Places that are tried where the time is looked for: a secant method at round-off in six or so.
const MOST_SECANTS: usize = 20;

/// Numbers that are kept, 128 megabytes.
const MOST_NUMBERS: usize = 1 << 24;

impl Curve {
    /// Runs a method over `time` in at least `steps` steps, in ever smaller ones until interpolation errs by no more
    /// than `wanted`. Stops before that where no more numbers can be kept or the next run would cost more than
    /// `budget`.
    ///
    /// # Errors
    /// Why a step fails, in words.
    pub fn of(
        run: &ComposedRun,
        time: f64,
        steps: u64,
        wanted: f64,
        budget: u64,
    ) -> Result<Self, String> {
        let is_paced = run.time_place().is_some();
        let d = (run.plan.layout.coordinates() + usize::from(is_paced)).max(1);
        let most = (MOST_NUMBERS / d).max(4 * NODES);
        let mut count = usize::try_from(steps)
            .unwrap_or(most)
            .clamp(4 * NODES, most)
            & !1;
        loop {
            // Where not every state can be kept, steps are still no larger than they were asked to be.
            let stride = steps.div_ceil(count as u64).max(1);
            let (states, spent) = states(run, time, count, stride)?;
            let mut curve = Self {
                dimension: d,
                is_paced,
                norm: states
                    .chunks_exact(d)
                    .map(|state| norm(&state[..d - usize::from(is_paced)]))
                    .fold(0.0, f64::max),
                states,
                error: 0.0,
            };
            curve.error = REDUCED * curve.error_of_every_second();
            let missing = curve.error / wanted.max(f64::MIN_POSITIVE);
            // Half the spacing makes 2¹² of it.
            let halvings = libm::ceil(libm::log2(missing) / 12.0).clamp(1.0, 16.0) as u32;
            let next = count.saturating_mul(1 << halvings);
            let is_dear = spent.saturating_mul(1 << halvings) > budget;
            if missing <= 1.0 || next > most || is_dear {
                return Ok(curve);
            }
            count = next;
        }
    }

    /// ‖x − x*‖ at this part of the steps, with a pace at this time; `buffer` holds a state and the time.
    pub fn distance(&self, part: f64, (x, time): (&[f64], Option<f64>), buffer: &mut [f64]) -> f64 {
        let last = (self.states.len() / self.dimension - 1) as f64;
        let buffer = &mut buffer[..self.dimension];
        let place = match time.filter(|_| self.is_paced) {
            Some(time) => self.place_of(time, part * last, buffer),
            None => part * last,
        };
        self.interpolate(place, 1, buffer);
        distance(x, &buffer[..x.len()])
    }

    /// Where the curve is at a time, near a place: by the secant method, since t rises along it.
    fn place_of(&self, time: f64, near: f64, buffer: &mut [f64]) -> f64 {
        let last = (self.states.len() / self.dimension - 1) as f64;
        // A polynomial is taken a little beyond its ends, where the run is a little before or behind.
        let within = |place: f64| place.clamp(-0.5, last + 0.5);
        let mut missed = |place: f64| {
            self.interpolate(place, 1, buffer);
            buffer[self.dimension - 1] - time
        };
        let (mut before, mut place) = (near, within(near + 1e-3));
        let mut value = missed(before);
        for _ in 0..MOST_SECANTS {
            let now = missed(place);
            if now == 0.0 || now == value {
                break;
            }
            let next = within(place - now * (place - before) / (now - value));
            (before, value, place) = (place, now, next);
            if (place - before).abs() <= f64::EPSILON * last {
                break;
            }
        }
        place
    }

    /// How far the states of odd number are from polynomials through those of even number.
    fn error_of_every_second(&self) -> f64 {
        let mut state = vec![0.0; self.dimension];
        let odd = self.states.chunks_exact(self.dimension).enumerate();
        let errors = odd.skip(1).step_by(2).map(|(at, own)| {
            self.interpolate(0.5 * at as f64, 2, &mut state);
            distance(own, &state)
        });
        // A NaN is no small error.
        errors.fold(0.0, larger)
    }

    /// The polynomial at `place`, in units of the nodes' spacing; the nodes are every `stride`-th state.
    fn interpolate(&self, place: f64, stride: usize, out: &mut [f64]) {
        let last = (self.states.len() / self.dimension - 1) / stride;
        let before = NODES / 2 - 1;
        let first = (libm::floor(place.max(0.0)) as usize)
            .saturating_sub(before)
            .min(last + 1 - NODES);
        let d = self.dimension;
        let node = |k: usize| &self.states[(first + k) * stride * d..][..d];
        let mut weights = WEIGHTS;
        let mut sum = 0.0;
        for (k, weight) in weights.iter_mut().enumerate() {
            let distance = place - (first + k) as f64;
            if distance == 0.0 {
                return out.copy_from_slice(node(k));
            }
            *weight /= distance;
            sum += *weight;
        }
        out.fill(0.0);
        for (k, weight) in weights.iter().enumerate() {
            for (out, state) in out.iter_mut().zip(node(k)) {
                *out += weight / sum * state;
            }
        }
    }
}

/// Every `stride`-th state of a run, `count` beside the first, and what it cost.
fn states(
    run: &ComposedRun,
    time: f64,
    count: usize,
    stride: u64,
) -> Result<(Vec<f64>, u64), String> {
    let values = run.system.parameter_values();
    let step = time / (count as f64 * stride as f64);
    let initial = &run.plan.initial;
    let mut walk = Walk::new(run.method.map(), &values, 1.0, step, initial);
    let mut states = Vec::with_capacity((count + 1) * initial.len());
    let place = run.time_place();
    let mut keep = |state: &[f64]| {
        states.extend_from_slice(run.own(state));
        states.extend(place.map(|place| state[place]));
    };
    keep(initial);
    for _ in 0..count {
        walk.advance(stride).map_err(|error| error.to_string())?;
        keep(walk.state());
    }
    Ok((states, walk.statistics().cost()))
}

#[cfg(test)]
mod tests {
    use super::Curve;

    fn circle(steps: usize) -> Curve {
        let angle = |k: usize| 7.0 * k as f64 / steps as f64;
        let mut curve = Curve {
            dimension: 2,
            is_paced: false,
            states: (0..=steps)
                .flat_map(|k| [libm::cos(angle(k)), libm::sin(angle(k))])
                .collect(),
            error: 0.0,
            norm: 1.0,
        };
        curve.error = super::REDUCED * curve.error_of_every_second();
        curve
    }

    /// Eleven intervals of the twelve nodes and both ends of the curve; 44 and 88 steps over 7 radians.
    #[test]
    fn interpolation_errs_by_what_it_says() {
        for steps in [44, 60, 88] {
            let curve = circle(steps);
            let error = |k: usize| {
                let part = k as f64 / 1e4;
                let state = [libm::cos(7.0 * part), libm::sin(7.0 * part)];
                curve.distance(part, (&state, None), &mut [0.0; 2])
            };
            let largest = (0..=10_000).map(error).fold(0.0, f64::max);
            // And the rounding of twelve terms, of alternating sign at the ends.
            assert!(
                largest <= curve.error + 1e-13,
                "{steps}: {largest:e} > {:e}",
                curve.error
            );
            assert!(
                curve.error <= 100.0 * largest + 1e-13,
                "{steps}: {largest:e}, {:e}",
                curve.error
            );
        }
    }
}
