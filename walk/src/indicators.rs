//! Indicators of chaos along a trajectory, from vectors that the exact tangent DΦ of each step carries.
//!
//! The vector v_0 = Π(x_0)a lies in the symplectic leaf of x_0, and v_k = DΦ v_{k−1} in that of x_k. Over n steps and the time
//! t = n ε h, g_k = |v_k|/|v_{k−1}| gives:
//!
//! - λ = Σ_k ln g_k / |t|, which tends to the largest Lyapunov exponent. Vectors kept at right angles give the others
//!   (G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980)).
//! - MEGNO, Ȳ_n = (1/n) Σ_{m≤n} (2/m) Σ_{k≤m} k ln g_k. It is 2 on tori and λ|t|/2 along chaotic motion (P. Cincotta, C. Simó,
//!   Astronomy and Astrophysics Supplement 147 (2000)).
//! - SALI = min(|v̂ + ŵ|, |v̂ − ŵ|) of two vectors at right angles at first. Along chaotic motion it falls as e^{−(λ_1 − λ_2) t}
//!   (Ch. Skokos, Journal of Physics A 34 (2001)).
//!
//! Between steps vectors have length 1, so that nothing overflows. Lengths and angles may be those of the leading coordinates
//! alone. In the phase space extended by (t, e), e is the energy that the motion takes up. Its δe grows like the product of
//! the others with the orbit, twice as fast along an unbounded one.

use leafwise_core::solver::Differential;
use leafwise_core::walk::column;
use leafwise_core::{BuildError, StepError, Walk};
use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::functions::{FunctionValues, StateFunctions};
use crate::step::StepStart;

mod flag;
mod vectors;

use vectors::{dot, normalise, orthonormal, take_out};

/// A number that tells chaotic motion from regular.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Indicator {
    /// Ȳ, the mean exponential growth of nearby orbits.
    Megno,
    /// λ_k, the k-th largest Lyapunov exponent, from 1 on. Up to half of the leaf's dimension vectors are in the leaf. Those that
    /// shrink would not stay there: round-off across it, which does not, would outgrow them. Further exponents are those of all
    /// directions: of a Poisson map zeros for the energy and each Casimir, and the negatives of the first.
    Lyapunov(usize),
    /// The smaller alignment index.
    Sali,
}

/// Where vectors begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begins {
    /// In the symplectic leaf, twice as many as exponents.
    InLeaf,
    /// In the whole space: exponents are those of all directions.
    Anywhere,
}

/// Indicators that a walk follows, and where their vectors begin.
#[derive(Clone)]
pub struct Indicators {
    /// Which ones.
    pub which: Vec<Indicator>,
    /// Where the vectors begin.
    pub begins: Begins,
    /// So many [vectors](Self::vectors_of) in the leaf of a state, d numbers each, one after the other; or the columns of the tensor.
    pub directions: StateFunctions,
    /// Lengths and angles are those of so many coordinates, the first.
    pub measured: usize,
    /// Whether these depend on the coordinates behind them. Where they do not, vectors are 0 there.
    pub has_feedback: bool,
}

impl Indicators {
    /// Whether vectors of d numbers each are independent.
    pub fn are_independent(vectors: Vec<f64>, d: usize) -> bool {
        let count = vectors.len() / d.max(1);
        orthonormal(vectors, (d, d), count).is_some()
    }

    /// Takes out of vectors of d numbers what no measured coordinate depends on.
    fn drop_unmeasured(&self, vectors: &mut [f64], d: usize) {
        if !self.has_feedback {
            let unmeasured = vectors
                .chunks_exact_mut(d)
                .flat_map(|v| &mut v[self.measured..]);
            unmeasured.for_each(|v| *v = 0.0);
        }
    }

    /// The number of vectors that indicators are begun with: two for each exponent up to the last, since exponents come in pairs, one
    /// more for SALI.
    pub fn vectors_of(which: &[Indicator]) -> usize {
        2 * Self::exponents_of(which) + usize::from(which.contains(&Indicator::Sali))
    }

    /// Vectors that are orthogonalised: those of Lyapunov exponents up to the last.
    pub fn exponents_of(which: &[Indicator]) -> usize {
        let exponent = |indicator: &Indicator| match indicator {
            Indicator::Lyapunov(k) => *k,
            Indicator::Megno | Indicator::Sali => 1,
        };
        which.iter().map(exponent).max().unwrap_or(0)
    }

    /// The vectors of a lane from what its [directions](Self::directions) are at its state; `None` where these are too few.
    fn begin(&self, directions: Vec<f64>, d: usize) -> Option<Vec<f64>> {
        let count = Self::exponents_of(&self.which);
        if self.begins == Begins::Anywhere {
            let is_apart = self.which.contains(&Indicator::Sali);
            return flag::begin(&directions, d, (count, is_apart));
        }
        let mut vectors = orthonormal(directions, (d, d), 2 * count)?;
        // The other exponent of each pair belongs to the leaf's other directions.
        vectors.drain(count * d..2 * count * d);
        if self.measured < d {
            self.drop_unmeasured(&mut vectors, d);
            vectors = orthonormal(vectors, (d, self.measured), count)?;
        }
        Some(vectors)
    }
}

/// The derivative DΦ of a step that was taken.
pub(crate) enum Tangent<'a> {
    /// Row-major d × d.
    Matrix(&'a [f64]),
    /// The same step, taken again with its derivative.
    Step(&'a mut dyn Differential),
}

/// Everything that later indicators of one lane depend on, beside its state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Deviation {
    /// n, the steps followed.
    steps: u64,
    /// The vectors, d numbers each, of length 1.
    vectors: Vec<f64>,
    /// Σ ln g of each of the orthogonalised ones.
    growth: Vec<f64>,
    /// Σ_k k ln g_k of the first.
    weighted: f64,
    /// Σ_m Y_m.
    sum: f64,
}

impl Deviation {
    /// Whether it may be of so many vectors of d numbers.
    fn is_of(&self, vectors: usize, growth: usize) -> bool {
        self.vectors.len() == vectors && self.growth.len() == growth
    }

    /// Carries the vectors over a step.
    fn carry(
        &mut self,
        (tangent, d): (Tangent<'_>, usize),
        of: &Indicators,
        room: &mut Vec<f64>,
    ) -> Result<(), StepError> {
        const LOST: StepError = StepError::NonFinite {
            what: "a vector carried by the tangent of the step",
        };
        match tangent {
            Tangent::Matrix(tangent) => {
                room.clear();
                for vector in self.vectors.chunks_exact(d) {
                    let rows = tangent.chunks_exact(d);
                    room.extend(rows.map(|row| dot(row, vector)));
                }
                self.vectors.copy_from_slice(room);
            }
            Tangent::Step(step) => step.push(&mut self.vectors, &[])?,
        }
        of.drop_unmeasured(&mut self.vectors, d);
        self.steps += 1;
        let (ordered, rest) = self.vectors.split_at_mut(self.growth.len() * d);
        for k in 0..self.growth.len() {
            let (before, own) = ordered.split_at_mut(k * d);
            let own = &mut own[..d];
            before
                .chunks_exact(d)
                .for_each(|one| take_out(own, one, of.measured));
            let logarithm = libm::log(normalise(own, of.measured).ok_or(LOST)?);
            self.growth[k] += logarithm;
            if k == 0 {
                let n = self.steps as f64;
                self.weighted += n * logarithm;
                self.sum += 2.0 * self.weighted / n;
            }
        }
        for own in rest.chunks_exact_mut(d) {
            normalise(own, of.measured).ok_or(LOST)?;
        }
        Ok(())
    }

    /// An indicator after the time |t|: 0 before the first step, but for SALI.
    fn value(&self, which: Indicator, time: f64, (d, measured): (usize, usize)) -> f64 {
        match which {
            Indicator::Megno if self.steps == 0 => 0.0,
            Indicator::Megno => self.sum / self.steps as f64,
            Indicator::Lyapunov(_) if self.steps == 0 => 0.0,
            Indicator::Lyapunov(k) => self.growth[k - 1] / time.abs(),
            Indicator::Sali => {
                let v = &self.vectors[..measured];
                let w = &self.vectors[self.growth.len() * d..][..measured];
                let size = |sign: f64| {
                    let squares = v
                        .iter()
                        .zip(w)
                        .map(|(v, w)| (v + sign * w) * (v + sign * w));
                    libm::sqrt(squares.sum())
                };
                size(1.0).min(size(-1.0))
            }
        }
    }
}

/// The vectors of all lanes, and the indicators.
pub(crate) struct Deviations<'a> {
    of: &'a Indicators,
    directions: FunctionValues,
    own: Vec<Deviation>,
    dimension: usize,
    /// Indicator i of lane w at `[i*lanes + w]`.
    values: Vec<f64>,
    /// Where the last step began.
    start: StepStart,
    room: Vec<f64>,
}

impl<'a> Deviations<'a> {
    /// Of lanes of so many coordinates that begin nowhere yet.
    pub fn new(
        of: &'a Indicators,
        dimension: usize,
        (lanes, parameters): (usize, &[f64]),
    ) -> Result<Self, BuildError> {
        Ok(Self {
            of,
            directions: of.directions.values(lanes, parameters)?,
            own: vec![Deviation::default(); lanes],
            dimension,
            values: vec![0.0; of.which.len() * lanes],
            start: StepStart::default(),
            room: Vec::new(),
        })
    }

    /// Takes other parameters.
    pub fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), BuildError> {
        self.directions.set_parameters(parameters)
    }

    /// Begins at states, a structure of arrays. Returns the lanes whose leaf has fewer directions than are asked for.
    pub fn begin(&mut self, states: &[f64]) -> Vec<usize> {
        let (lanes, d) = (self.own.len(), self.dimension);
        let all = self.directions.at(states);
        let mut flat = Vec::new();
        for (lane, own) in self.own.iter_mut().enumerate() {
            let count = Indicators::exponents_of(&self.of.which);
            let sali = usize::from(self.of.which.contains(&Indicator::Sali));
            let begun = self.of.begin(column(all, lane, lanes), d);
            if begun.is_none() {
                flat.push(lane);
            }
            let vectors = begun.unwrap_or_else(|| vec![0.0; (count + sali) * d]);
            *own = Deviation {
                vectors,
                growth: vec![0.0; count],
                ..Deviation::default()
            };
        }
        (0..lanes).for_each(|lane| self.evaluate(lane, 0.0));
        flat
    }

    /// Keeps the states that the next step begins at.
    pub fn keep(&mut self, walk: &Walk) {
        self.start.keep(walk);
    }

    /// Follows a lane over the last step, which ends at a time: with the stepper's tangent, or by a step of the map from
    /// where the last one began.
    pub fn follow(
        &mut self,
        lane: usize,
        tangent: Option<Vec<f64>>,
        again: impl FnOnce() -> Box<dyn Differential>,
        time: f64,
    ) -> Result<(), Fault> {
        let (lanes, d) = (self.own.len(), self.dimension);
        let room = &mut self.room;
        match tangent {
            Some(matrix) => {
                self.own[lane].carry((Tangent::Matrix(&matrix), d), self.of, room)?;
            }
            None => {
                let mut step = again();
                let [state, low] = [&self.start.state, &self.start.compensation]
                    .map(|all| column(all, lane, lanes));
                room.resize(d, 0.0);
                step.step(&state, &low, room)?;
                self.own[lane].carry((Tangent::Step(step.as_mut()), d), self.of, room)?;
            }
        }
        self.evaluate(lane, time);
        Ok(())
    }

    fn evaluate(&mut self, lane: usize, time: f64) {
        let (lanes, sizes) = (self.own.len(), (self.dimension, self.of.measured));
        for (i, which) in self.of.which.iter().enumerate() {
            self.values[i * lanes + lane] = self.own[lane].value(*which, time, sizes);
        }
    }

    /// The indicators of all lanes.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Everything that those of the first lane depend on.
    pub fn memory(&self) -> Deviation {
        self.own[0].clone()
    }

    /// Continues the first lane at a time.
    ///
    /// # Errors
    /// Returns the expected length of a list that belongs to another walk.
    pub fn restore(&mut self, memory: &Deviation, time: f64) -> Result<(), usize> {
        let (vectors, growth) = (self.own[0].vectors.len(), self.own[0].growth.len());
        if !memory.is_of(vectors, growth) {
            return Err(vectors);
        }
        self.own[0].clone_from(memory);
        self.evaluate(0, time);
        Ok(())
    }
}
