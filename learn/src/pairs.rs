//! States before and after a step.

use crate::error::LearnError;

/// Sizes of coordinates in one sum of squares are alike down to this part: of equations that count so little only some digits are met.
const ALIKE: f64 = 1e-6;

/// N pairs (x, x') of states of d coordinates, x' one step after x, with a weight each. The mean of the weights is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct StatePairs {
    dimension: usize,
    before: Vec<f64>,
    after: Vec<f64>,
    weights: Vec<f64>,
    /// The place of every pair among those given, from 1.
    numbers: Vec<usize>,
    duplicates: usize,
}

impl StatePairs {
    /// Pairs of arrays of shape (N, d), the last axis fastest. A pair that stands twice is counted once, and one of weight 0 not at all.
    /// Only ratios of weights count.
    ///
    /// # Errors
    /// [`LearnError::Shape`], [`LearnError::NotFinite`] and [`LearnError::Weights`].
    pub fn new(
        dimension: usize,
        before: &[f64],
        after: &[f64],
        weights: Option<&[f64]>,
    ) -> Result<Self, LearnError> {
        let found = before.len() + after.len();
        let is_whole = dimension > 0 && before.len().is_multiple_of(dimension);
        if !is_whole || before.len() != after.len() || before.is_empty() {
            return Err(LearnError::Shape { dimension, found });
        }
        let count = before.len() / dimension;
        for (side, numbers) in [("before", before), ("after", after)] {
            if let Some(at) = numbers.iter().position(|value| !value.is_finite()) {
                return Err(LearnError::NotFinite {
                    pair: at / dimension + 1,
                    side,
                    value: numbers[at],
                });
            }
        }
        let weights = match weights {
            None => vec![1.0; count],
            Some(weights) => checked(weights, count)?,
        };
        // By the largest first: equal weights are 1 to the last bit, and no sum overflows.
        let largest = weights.iter().fold(0.0_f64, |most, w| most.max(*w));
        let mut own = Self {
            dimension,
            before: Vec::with_capacity(before.len()),
            after: Vec::with_capacity(after.len()),
            weights: Vec::with_capacity(count),
            numbers: Vec::with_capacity(count),
            duplicates: 0,
        };
        let mut known = std::collections::BTreeSet::new();
        let states = before
            .chunks(dimension)
            .zip(after.chunks(dimension))
            .zip(weights);
        for (at, ((x, next), weight)) in states.enumerate() {
            let weight = weight / largest;
            if weight == 0.0 {
                continue;
            }
            let bits: Vec<u64> = x.iter().chain(next).map(|v| v.to_bits()).collect();
            if !known.insert(bits) {
                own.duplicates += 1;
                continue;
            }
            own.before.extend(x);
            own.after.extend(next);
            own.weights.push(weight);
            own.numbers.push(at + 1);
        }
        let mean = own.weights.iter().sum::<f64>() / own.weights.len() as f64;
        own.weights.iter_mut().for_each(|w| *w /= mean);
        Ok(own)
    }

    /// N, each pair of a weight above 0 counted once.
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// d.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// How many pairs were left out because they stand twice.
    pub fn duplicates(&self) -> usize {
        self.duplicates
    }

    /// x of pair k.
    pub fn before(&self, k: usize) -> &[f64] {
        &self.before[k * self.dimension..(k + 1) * self.dimension]
    }

    /// x' of pair k.
    pub fn after(&self, k: usize) -> &[f64] {
        &self.after[k * self.dimension..(k + 1) * self.dimension]
    }

    /// The place of pair k among those given, from 1.
    pub fn number(&self, k: usize) -> usize {
        self.numbers[k]
    }

    /// Weight of pair k in the sum of squares, 1 in the mean.
    pub fn weight(&self, k: usize) -> f64 {
        self.weights[k]
    }

    /// Whether one sum of squares can hold all coordinates: none that is not 0 measures less than the part [`ALIKE`] of what another varies by. The
    /// size of one and not its range counts here, so that constants pass.
    pub(crate) fn checked_units(&self, names: &[String]) -> Result<(), LearnError> {
        let ranges = self.ranges();
        let spreads = ranges.iter().map(|(least, most)| most - least).enumerate();
        let sizes = ranges
            .iter()
            .map(|(least, most)| least.abs().max(most.abs()));
        let sizes = sizes.enumerate().filter(|(_, size)| *size > 0.0);
        let by_number = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
        match (spreads.max_by(by_number), sizes.min_by(by_number)) {
            (Some((large, spread)), Some((small, size))) if size < ALIKE * spread => {
                Err(LearnError::UnlikeUnits {
                    large: names[large].clone(),
                    spread,
                    small: names[small].clone(),
                    size,
                    unit: libm::pow(10.0, libm::floor(libm::log10(size / spread))),
                })
            }
            _ => Ok(()),
        }
    }

    /// The least and the largest value of each coordinate.
    pub(crate) fn ranges(&self) -> Vec<(f64, f64)> {
        let d = self.dimension;
        let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); d];
        let states = self.before.chunks(d).chain(self.after.chunks(d));
        for state in states {
            for (range, x) in ranges.iter_mut().zip(state) {
                *range = (range.0.min(*x), range.1.max(*x));
            }
        }
        ranges
    }
}

fn checked(weights: &[f64], pairs: usize) -> Result<Vec<f64>, LearnError> {
    let problem = if weights.len() != pairs {
        format!("there are {}", weights.len())
    } else if let Some(odd) = weights.iter().find(|w| !(w.is_finite() && **w >= 0.0)) {
        format!("one is {odd:?}")
    } else if weights.iter().all(|w| *w == 0.0) {
        "all are 0".to_owned()
    } else {
        return Ok(weights.to_vec());
    };
    Err(LearnError::Weights { pairs, problem })
}
