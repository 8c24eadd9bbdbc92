//! Spins: summands of a tensor that are so(3)*, in fields that do not depend on themselves.

use std::collections::BTreeSet;

use leafwise_core::system::Metric;
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Expression, Graph, Polynomial, Ring, Term};

use super::{flow, unfit};

/// One spin: {s1,s2} = −κ s3 and cyclic.
#[derive(Clone, Debug)]
pub(super) struct Spin {
    /// Its three coordinates.
    pub(super) places: [usize; 3],
    /// κ, a constant of the ring.
    factor: Polynomial,
    /// a of its damping λ a.
    metric: Option<Expression>,
}

/// All spins of a system, with the code of what moves them.
pub(super) struct Spins<'a> {
    pub(super) system: &'a SystemFormulas,
    ring: Ring,
    pub(super) all: Vec<Spin>,
    /// The coordinates that each spin's field depends on.
    pub(super) reads: Vec<BTreeSet<usize>>,
}

impl<'a> Spins<'a> {
    /// Those of a system whose moving coordinates all are of spins.
    ///
    /// # Errors
    /// [`BuildError::DoesNotFit`] for another tensor, for a spin whose field depends on itself, and for forces that are no
    /// damping of one rate a spin.
    pub(super) fn of(system: &'a SystemFormulas) -> Result<Self, BuildError> {
        let mut ring = Ring::new(system.dimension());
        let moving: BTreeSet<usize> = system.tensor().keys().flat_map(|(i, j)| [*i, *j]).collect();
        let mut all = Vec::new();
        for block in system.summands() {
            if !block.iter().any(|at| moving.contains(at)) {
                continue;
            }
            let places = <[usize; 3]>::try_from(block).map_err(|block| {
                unfit(format!(
                    "a summand of its tensor has {} coordinates, and a spin has 3",
                    block.len()
                ))
            })?;
            let factor = system.spin_factor(&mut ring, places)?.ok_or_else(|| {
                let names = places.map(|at| system.variables()[at].as_str());
                unfit(format!(
                    "the brackets of {} are not those of a spin, a constant times so(3)*",
                    names.join(", ")
                ))
            })?;
            let metric = metric(system, places, &moving)?;
            all.push(Spin {
                places,
                factor,
                metric,
            });
        }
        if all.is_empty() {
            return Err(unfit("nothing moves in it"));
        }
        let mut spins = Self {
            system,
            ring,
            all,
            reads: Vec::new(),
        };
        spins.reads = spins.fields_read()?;
        Ok(spins)
    }

    /// dH + η without damping, as code.
    fn one_form(&self, graph: &mut Graph, x: &[Term]) -> Result<Vec<Term>, BuildError> {
        let mut form = self.system.gradient(graph, x)?;
        for (slope, force) in form.iter_mut().zip(&self.system.forces().one_form) {
            let force = force.evaluate_in(graph, &mut |_, at| Ok(x[at].clone()))?;
            *slope = graph.add(slope, &force);
        }
        Ok(form)
    }

    /// The coordinates that each spin's field depends on.
    fn fields_read(&self) -> Result<Vec<BTreeSet<usize>>, BuildError> {
        let mut graph = Graph::new();
        let x: Vec<Term> = (0..self.system.dimension())
            .map(|i| graph.input(i))
            .collect();
        let form = self.one_form(&mut graph, &x)?;
        let names = self.system.variables();
        let mut reads = Vec::with_capacity(self.all.len());
        for spin in &self.all {
            let field = spin.places.map(|at| form[at].clone());
            let read: BTreeSet<usize> = graph.inputs_read(&field).into_iter().collect();
            if let Some(at) = spin.places.iter().find(|at| read.contains(at)) {
                return Err(unfit(format!(
                    "the field at a spin depends on the spin itself, on {}: H must be linear in every spin, as \
                     exchange and fields are and anisotropies are not",
                    names[*at]
                )));
            }
            reads.push(read);
        }
        Ok(reads)
    }

    /// s(t) − s of every spin over its own time, from the state `x`.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub(super) fn increments(
        &self,
        graph: &mut Graph,
        x: &[Term],
        time: &mut dyn FnMut(&mut Graph, usize) -> Option<Term>,
    ) -> Result<Vec<Option<[Term; 3]>>, BuildError> {
        let mut own = Graph::new();
        let inputs: Vec<Term> = (0..x.len()).map(|i| own.input(i)).collect();
        let form = self.one_form(&mut own, &inputs)?;
        let form = graph.import(&own, &form, x)?;
        let rate = self.system.forces().damping.as_ref().map(|d| &d.rate);
        let mut increments = Vec::with_capacity(self.all.len());
        for (at, spin) in self.all.iter().enumerate() {
            let Some(time) = time(graph, at) else {
                increments.push(None);
                continue;
            };
            let one = graph.one();
            let factor = lift(graph, &self.ring, &[vec![(one, spin.factor.clone())]], x)?;
            let turn = graph.multiply(&factor[0], &time);
            let q = spin.places.map(|place| graph.multiply(&turn, &form[place]));
            let s = spin.places.map(|place| x[place].clone());
            let damping = match (&spin.metric, rate) {
                (Some(metric), Some(rate)) => {
                    let mut value = |formula: &Expression| {
                        formula.evaluate_in(graph, &mut |_, at| Ok(x[at].clone()))
                    };
                    let (rate, metric) = (value(rate)?, value(metric)?);
                    let product = graph.multiply(&rate, &metric);
                    Some(graph.multiply(&product, &factor[0]))
                }
                _ => None,
            };
            let increment = flow::increment(graph, &s, &q, damping.as_ref())?;
            increments.push(<[Term; 3]>::try_from(increment).ok());
        }
        Ok(increments)
    }
}

/// a of a spin's damping λ a; `None` where it has none.
fn metric(
    system: &SystemFormulas,
    places: [usize; 3],
    moving: &BTreeSet<usize>,
) -> Result<Option<Expression>, BuildError> {
    let forces = system.forces();
    let Some(damping) = &forces.damping else {
        return Ok(None);
    };
    let is_zero = |force: &Expression| *force == Expression::from(0);
    if !forces.one_form.iter().all(is_zero) {
        return Err(unfit(
            "with a damping it takes neither other forces nor noise within a step: write noise = \"split\"",
        ));
    }
    let Metric::Diagonal(entries) = &damping.metric else {
        return Err(unfit("the metric of its damping is not diagonal"));
    };
    let [a, b, c] = places.map(|at| &entries[at]);
    if a != b || b != c {
        return Err(unfit(
            "the metric of its damping has different entries for the components of one spin",
        ));
    }
    let moves = |formula: &Expression| formula.variables().iter().any(|at| moving.contains(at));
    if moves(a) || moves(&damping.rate) {
        return Err(unfit("the rate of its damping depends on the spins"));
    }
    Ok((!is_zero(a)).then(|| a.clone()))
}
