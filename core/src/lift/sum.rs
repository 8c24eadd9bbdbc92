//! Lifts of a direct sum's summands side by side.

use std::ops::Range;
use std::sync::Arc;

use leafwise_expression::{Arithmetic, Graph, Polynomial, Term};

use super::{End, Lift, LiftShape, Slowing};
use crate::error::{BuildError, StepError};

/// The lift of a summand.
#[derive(Clone, Debug)]
pub struct Summand {
    /// The summand's coordinates.
    pub places: Vec<usize>,
    /// Its lift.
    pub lift: Arc<dyn Lift>,
}

/// J₁ × J₂ × …: Poisson where every factor is, and the fibres are products of theirs. H couples the summands at will.
#[derive(Clone, Debug)]
pub struct LiftSum {
    summands: Vec<Summand>,
}

/// Summands of so many coordinates are gathered without allocation.
const SMALL: usize = 48;

impl LiftSum {
    /// The lift of the sum of these.
    pub fn of(summands: Vec<Summand>) -> Self {
        Self { summands }
    }

    /// Each summand with its own of z and of the base point.
    fn parts<'a, T>(
        &'a self,
        mut z: &'a [T],
        mut base: &'a [T],
    ) -> impl Iterator<Item = (&'a Summand, &'a [T], &'a [T])> {
        self.summands.iter().map(move |summand| {
            let (own, rest) = z.split_at(summand.lift.shape().coordinates);
            let (own_base, base_rest) = base.split_at(summand.lift.shape().base);
            (z, base) = (rest, base_rest);
            (summand, own, own_base)
        })
    }

    /// Each summand with where its own of a base point lies.
    fn bases(&self) -> impl Iterator<Item = (&Summand, Range<usize>)> {
        let mut at = 0;
        self.summands.iter().map(move |summand| {
            let from = at;
            at += summand.lift.shape().base;
            (summand, from..at)
        })
    }

    fn dimension_of_x(&self) -> usize {
        self.summands.iter().map(|s| s.places.len()).sum()
    }
}

impl Summand {
    /// Where its coordinates lie side by side.
    fn range(&self) -> Option<Range<usize>> {
        let first = *self.places.first()?;
        let mut pairs = self.places.iter().zip(first..);
        pairs
            .all(|(at, next)| *at == next)
            .then(|| first..first + self.places.len())
    }

    /// Its share of a list over all coordinates.
    fn of<T: Clone>(&self, all: &[T]) -> Vec<T> {
        self.places.iter().map(|at| all[*at].clone()).collect()
    }
}

/// Room for a summand's share of numbers over all coordinates.
struct Room {
    small: [f64; SMALL],
    large: Vec<f64>,
}

impl Room {
    const EMPTY: Self = Self {
        small: [0.0; SMALL],
        large: Vec::new(),
    };

    /// The numbers of a summand.
    fn gather(&mut self, summand: &Summand, all: &[f64]) -> &mut [f64] {
        let count = summand.places.len();
        let numbers = match self.small.get_mut(..count) {
            Some(small) => small,
            None => {
                self.large.resize(count, 0.0);
                &mut self.large
            }
        };
        let pairs = numbers.iter_mut().zip(&summand.places);
        pairs.for_each(|(own, at)| *own = all[*at]);
        numbers
    }

    /// The same, without a copy where they lie side by side.
    fn share<'a>(&'a mut self, summand: &Summand, all: &'a [f64]) -> &'a [f64] {
        match summand.range() {
            Some(range) => &all[range],
            None => self.gather(summand, all),
        }
    }
}

impl Lift for LiftSum {
    fn shape(&self) -> LiftShape {
        let shapes = self.summands.iter().map(|summand| summand.lift.shape());
        shapes.fold(LiftShape::default(), |sum, own| LiftShape {
            coordinates: sum.coordinates + own.coordinates,
            base: sum.base + own.base,
            follows: sum.follows || own.follows,
        })
    }

    fn place(
        &self,
        x: &[f64],
        low: &[f64],
        before: Option<End<'_>>,
        base: &mut [f64],
    ) -> Result<(), StepError> {
        let mut of_z = 0;
        for (summand, at) in self.bases() {
            let from = of_z;
            of_z += summand.lift.shape().coordinates;
            let before = before.map(|end| End {
                z: &end.z[from..of_z],
                base: &end.base[at.clone()],
            });
            let (mut of_x, mut of_low) = (Room::EMPTY, Room::EMPTY);
            let (x, low) = (of_x.share(summand, x), of_low.share(summand, low));
            summand.lift.place(x, low, before, &mut base[at])?;
        }
        Ok(())
    }

    fn sizes(&self, base: &[f64], sizes: &mut [f64]) {
        let mut rest = sizes;
        for (summand, at) in self.bases() {
            let (own, after) = rest.split_at_mut(summand.lift.shape().coordinates);
            summand.lift.sizes(&base[at], own);
            rest = after;
        }
    }

    fn slowing(
        &self,
        slowing: &mut Slowing<'_>,
        places: &[usize],
    ) -> Result<Polynomial, BuildError> {
        let mut sum = Polynomial::zero();
        for summand in &self.summands {
            let taken = summand.lift.slowing(slowing, &summand.of(places))?;
            sum = slowing.ring.add(&sum, &taken);
        }
        Ok(sum)
    }

    fn image(&self, graph: &mut Graph, z: &[Term], base: &[Term]) -> Result<Vec<Term>, BuildError> {
        let mut x = vec![graph.zero(); self.dimension_of_x()];
        for (summand, z, base) in self.parts(z, base) {
            let own = summand.lift.image(graph, z, base)?;
            for (at, own) in summand.places.iter().zip(own) {
                x[*at] = own;
            }
        }
        Ok(x)
    }

    fn covector(
        &self,
        graph: &mut Graph,
        x: &[Term],
        slopes: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let mut covector = slopes.to_vec();
        for summand in &self.summands {
            let own = summand
                .lift
                .covector(graph, &summand.of(x), &summand.of(slopes))?;
            for (at, own) in summand.places.iter().zip(own) {
                covector[*at] = own;
            }
        }
        Ok(covector)
    }

    fn field(
        &self,
        graph: &mut Graph,
        z: &[Term],
        base: &[Term],
        covector: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let mut field = Vec::with_capacity(z.len());
        for (summand, z, base) in self.parts(z, base) {
            field.extend(summand.lift.field(graph, z, base, &summand.of(covector))?);
        }
        Ok(field)
    }

    fn increment(
        &self,
        graph: &mut Graph,
        z: &[Term],
        base: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let mut change = vec![graph.zero(); self.dimension_of_x()];
        for (summand, z, base) in self.parts(z, base) {
            let own = summand.lift.increment(graph, z, base)?;
            for (at, own) in summand.places.iter().zip(own) {
                change[*at] = own;
            }
        }
        Ok(change)
    }

    fn slopes_of_base(&self, base: &[f64], slopes: &mut [f64]) {
        let d = self.dimension_of_x();
        slopes.fill(0.0);
        for (summand, at) in self.bases() {
            let count = summand.places.len();
            let mut own = vec![0.0; at.len() * count];
            summand.lift.slopes_of_base(&base[at.clone()], &mut own);
            for (row, own) in at.zip(own.chunks_exact(count)) {
                for (place, own) in summand.places.iter().zip(own) {
                    slopes[row * d + place] = *own;
                }
            }
        }
    }

    fn hold(&self, x: &[f64], low: &[f64], increment: &mut [f64]) -> f64 {
        let mut held = 0.0_f64;
        for summand in &self.summands {
            let (mut of_x, mut of_low) = (Room::EMPTY, Room::EMPTY);
            let (x, low) = (of_x.share(summand, x), of_low.share(summand, low));
            if let Some(range) = summand.range() {
                held = held.max(summand.lift.hold(x, low, &mut increment[range]));
                continue;
            }
            let mut room = Room::EMPTY;
            let own = room.gather(summand, increment);
            held = held.max(summand.lift.hold(x, low, own));
            for (at, own) in summand.places.iter().zip(own) {
                increment[*at] = *own;
            }
        }
        held
    }
}
