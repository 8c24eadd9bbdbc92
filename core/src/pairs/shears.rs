//! H = T + V in which each part moves coordinates that it does not depend on.

use std::collections::BTreeSet;

use leafwise_expression::{Arithmetic, Graph, Term};

use super::BodyShape;
use super::function::{BodyFunction, Weighted, families_of};
use crate::error::BuildError;

/// Families that move in one part of H.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ShearPart {
    /// The families that it moves.
    pub(super) moves: Vec<usize>,
    /// Those that it depends on, by which its gradient is taken.
    pub(super) by: Vec<usize>,
    /// Whether its field is affine in these.
    pub(super) is_affine: bool,
}

/// The two parts of H, where there are such.
///
/// Families are coloured: the ends of an entry of the tensor differ, and a family differs from all that its motion
/// depends on. The coordinates a of one colour alone move by T(b) = H(a₀, b), b those of the other. Their field
/// −Π_ab ∂H/∂b does not depend on a. So its flow is x + tX(x).
///
/// # Errors
/// [`BuildError::Algebra`] where a formula has no derivative.
pub(super) fn parts(
    function: &BodyFunction,
    shape: &BodyShape,
    entries: &[((usize, usize), BTreeSet<usize>)],
) -> Result<Option<[ShearPart; 2]>, BuildError> {
    let moving: BTreeSet<usize> = entries.iter().flat_map(|((a, b), _)| [*a, *b]).collect();
    let slopes = Dependences::of(function, shape)?;
    // Families that are of another colour.
    let mut apart: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); shape.families];
    for ((a, b), reads) in entries {
        for (family, other) in [(*a, *b), (*b, *a)] {
            let mut read = slopes.reads(other);
            read.extend(reads);
            read.insert(other);
            for read in read.intersection(&moving) {
                apart[family].insert(*read);
                apart[*read].insert(family);
            }
        }
    }
    let mut colours: Vec<Option<usize>> = vec![None; shape.families];
    for start in &moving {
        let mut pending = vec![(*start, colours[*start].unwrap_or(0))];
        while let Some((family, colour)) = pending.pop() {
            match colours[family] {
                Some(own) if own == colour => continue,
                Some(_) => return Ok(None),
                None => colours[family] = Some(colour),
            }
            pending.extend(apart[family].iter().map(|other| (*other, 1 - colour)));
        }
    }
    let of = |colour: usize| -> Vec<usize> {
        let own = moving
            .iter()
            .filter(|family| colours[**family] == Some(colour));
        own.copied().collect()
    };
    let mut parts = Vec::new();
    for colour in [0, 1] {
        let by = of(1 - colour);
        parts.push(ShearPart {
            moves: of(colour),
            is_affine: slopes.are_affine(&by, &moving)?,
            by,
        });
    }
    let [second, first] = [parts.pop(), parts.pop()];
    Ok(first.zip(second).map(|(first, second)| [first, second]))
}

/// ∂H/∂x_a of one site and one pair as code, to tell what it depends on.
struct Dependences {
    graph: Graph,
    /// By the coordinates of site i, then of site j.
    gradient: Vec<Term>,
    families: usize,
    /// The first input that is a weight: before them are coordinates, then entries of matrices.
    weights_from: usize,
    /// The families that each weight depends on.
    of_weights: Vec<BTreeSet<usize>>,
}

impl Dependences {
    fn of(function: &BodyFunction, shape: &BodyShape) -> Result<Self, BuildError> {
        let weighted = Weighted::of(function)?;
        let mut graph = Graph::compilable();
        let variables = shape.variables();
        let inputs = variables + function.sums.len();
        let inputs: Vec<Term> = (0..inputs).map(|at| graph.input(at)).collect();
        let (x, weights) = inputs.split_at(variables);
        let site = weighted.total(&mut graph, |sum| &sum.site, x, weights)?;
        let pair = weighted.total(&mut graph, |sum| &sum.pair, x, weights)?;
        let total = graph.add(&site, &pair);
        let gradient = graph.gradient(&total, 2 * shape.families)?;
        graph.unless_refused(())?;
        Ok(Self {
            graph,
            gradient,
            families: shape.families,
            weights_from: variables,
            of_weights: (weighted.of_sums().into_iter())
                .map(|slope| {
                    let sums = slope.variables().into_iter().map(|k| &function.sums[k]);
                    let formulas = sums.flat_map(|sum| [&sum.site, &sum.pair]);
                    families_of(formulas, shape)
                })
                .collect(),
        })
    }

    fn of_family(&self, family: usize) -> [Term; 2] {
        [family, self.families + family].map(|at| self.gradient[at].clone())
    }

    /// The families that ∂H/∂x_a depends on.
    fn reads(&self, family: usize) -> BTreeSet<usize> {
        let mut read = BTreeSet::new();
        for input in self.graph.inputs_read(&self.of_family(family)) {
            if input < 2 * self.families {
                read.insert(input % self.families);
            } else if let Some(weight) = input.checked_sub(self.weights_from) {
                // It is of sums over all sites.
                read.extend(&self.of_weights[weight]);
            }
        }
        read
    }

    /// Whether the second derivatives by these families do not depend on what moves.
    fn are_affine(&self, by: &[usize], moving: &BTreeSet<usize>) -> Result<bool, BuildError> {
        let mut graph = self.graph.clone();
        for family in by {
            for slope in self.of_family(*family) {
                let moving_inputs =
                    (0..2 * self.families).filter(|at| moving.contains(&(at % self.families)));
                for at in moving_inputs {
                    let second = graph.derivative(&slope, at)?;
                    let mut read = graph.inputs_read(&[second]).into_iter();
                    let moves = |input: usize| {
                        let is_coordinate = input < 2 * self.families;
                        input >= self.weights_from
                            || is_coordinate && moving.contains(&(input % self.families))
                    };
                    if read.any(moves) {
                        return Ok(false);
                    }
                }
                let read = graph.inputs_read(&[slope]);
                if read.into_iter().any(|input| input >= self.weights_from) {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }
}
