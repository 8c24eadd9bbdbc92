//! How little of each coordinate is not looked at, in units of its own.

use leafwise_core::system::FieldRounding;

/// 2⁻¹⁰⁴: errors below this part of a coordinate's size are not looked at.
pub(crate) const LEAST_PART: f64 = f64::EPSILON * f64::EPSILON;

/// The part of a time by which a state is moved along its slope, to see what is driven by a coordinate that passes 0.
const AHEAD: f64 = 1.0 / 64.0;

/// A coordinate that is reached by all others, one after the other, grows a few times. One that is doubled more often
/// grows on and on.
const MOST_DOUBLINGS: u32 = 12;

/// A time for which the sizes do not settle is multiplied by this, at most so many times.
const SHORTER: f64 = 0.25;
const MOST_TIMES: usize = 16;

/// The sizes that coordinates come to within a time τ, those at rest too.
///
/// Each size u_i begins as |x_i| or τ|ẋ_i|, whichever is larger. Others may bring it to more: u_i ← max(u_i, τ b_i)
/// until no size is doubled. Here ε b_i bounds the rounding error of ẋ_i at coordinates that are known up to ε u_j.
/// The result is about τᵐ for a coordinate that begins as tᵐ, whatever the units of coordinates, time and energy.
/// Where sizes grow on and on, τ is longer than the motion's own times, and is shortened.
#[derive(Clone, Debug)]
pub(crate) struct Floors {
    /// τ, 0 while there are no floors; what is kept of them with a state.
    pub time: f64,
    sizes: Vec<f64>,
}

impl Floors {
    pub(crate) fn new(dimension: usize) -> Self {
        Self {
            time: 0.0,
            sizes: vec![0.0; dimension],
        }
    }

    /// Leaves no floors.
    pub(crate) fn clear(&mut self) {
        if self.time != 0.0 {
            self.time = 0.0;
            self.sizes.fill(0.0);
        }
    }

    /// Error of x_i below which nothing is looked at: 2⁻¹⁰⁴ of its size.
    #[inline(always)]
    pub(crate) fn least(&self, i: usize) -> f64 {
        LEAST_PART * self.sizes[i]
    }

    /// ε of the size.
    #[inline(always)]
    pub(crate) fn rough(&self, i: usize) -> f64 {
        f64::EPSILON * self.sizes[i]
    }

    /// Forms the sizes at x with slope ẋ for a time, in the unit of time that ẋ is in: the field's own times `unit`.
    pub(crate) fn form(
        &mut self,
        field: (&FieldRounding, &[f64], f64),
        x: &[f64],
        slope: &[f64],
        time: f64,
    ) {
        self.time = time.abs();
        for _ in 0..MOST_TIMES {
            if self.settle(field, x, slope, self.time.copysign(time)) {
                break;
            }
            self.time *= SHORTER;
        }
    }

    /// Whether the sizes settle for this time.
    fn settle(
        &mut self,
        (rounding, parameters, unit): (&FieldRounding, &[f64], f64),
        x: &[f64],
        slope: &[f64],
        time: f64,
    ) -> bool {
        let d = x.len();
        for ((size, x), slope) in self.sizes.iter_mut().zip(x).zip(slope) {
            *size = x.abs().max((time * slope).abs());
        }
        let rests: Vec<usize> = (0..d).filter(|i| self.sizes[*i] == 0.0).collect();
        let pairs = x.iter().zip(slope);
        let ahead: Vec<f64> = pairs.map(|(x, v)| x + AHEAD * time * v).collect();
        let (mut errors, mut bounds, mut bounds_ahead) = (vec![0.0; d], vec![0.0; d], vec![0.0; d]);
        let part = (time * unit).abs() / f64::EPSILON;
        let mut doublings = vec![0; d];
        // What the field's own rounding gives rise to comes to all others in as many, and then no longer grows.
        for _ in 0..=d {
            for (error, size) in errors.iter_mut().zip(&self.sizes) {
                *error = f64::EPSILON * size;
            }
            rounding.bounds(parameters, x, &errors, &mut bounds);
            if !rests.is_empty() {
                rounding.bounds(parameters, &ahead, &errors, &mut bounds_ahead);
                for &i in &rests {
                    bounds[i] = bounds[i].max(bounds_ahead[i]);
                }
            }
            let mut grows = false;
            let rows = self.sizes.iter_mut().zip(&mut doublings);
            for ((size, doublings), bound) in rows.zip(&bounds) {
                let reached = part * bound;
                // Products of errors grow on and on beyond all numbers.
                if reached == f64::INFINITY {
                    return false;
                }
                if reached > 2.0 * *size {
                    *doublings += 1;
                    if *doublings > MOST_DOUBLINGS {
                        return false;
                    }
                    grows = true;
                }
                *size = size.max(reached);
            }
            if !grows {
                return true;
            }
        }
        false
    }
}
