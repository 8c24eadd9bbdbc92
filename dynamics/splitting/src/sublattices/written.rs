//! Sublattices of a system that is written out: a step is one kernel.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use leafwise_core::part::PartParameters;
use leafwise_core::solver::{ExplicitMap, Factored, MapAbilities, MapProperties, StepMap, Stepper};
use leafwise_core::{BuildError, Differential, Inverse, PoissonSystem, SystemFormulas};
use leafwise_expression::{Arithmetic, Graph, Rational, StepSize, Term};

use super::colours::of_written;
use super::spins::Spins;
use super::{INFO, describe, properties};
use crate::product::{Product, Splits, evaluations, is_symmetric};
use crate::schedule::{STRANG, passes};

/// Parts of the time, as bits.
type Parts = Vec<u64>;

/// Strang's product over the colours of a system's spins.
#[derive(Clone)]
pub(super) struct Written {
    shared: Arc<Shared>,
}

struct Shared {
    system: SystemFormulas,
    /// The colour of each spin.
    colours: Vec<usize>,
    step: ExplicitMap,
    /// Products that were asked for.
    products: Mutex<BTreeMap<Parts, ExplicitMap>>,
}

pub(super) fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    let system = system.formulas(INFO.name)?;
    let spins = Spins::of(system)?;
    let colours = of_written(&spins.all, &spins.reads);
    let step = product(&spins, &colours, &STRANG)?;
    Ok(Arc::new(Written {
        shared: Arc::new(Shared {
            system: system.clone(),
            colours,
            step,
            products: Mutex::default(),
        }),
    }))
}

fn count(colours: &[usize]) -> usize {
    colours.iter().max().map_or(0, |last| last + 1)
}

/// … ∘ χ*_{α_2 h} ∘ χ_{α_1 h} over the colours.
fn product(spins: &Spins<'_>, colours: &[usize], parts: &[f64]) -> Result<ExplicitMap, BuildError> {
    let (d, parameters) = (spins.system.dimension(), spins.system.parameters().len());
    let mut graph = Graph::new();
    let mut state: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let sizes = [StepSize::Epsilon, StepSize::H].map(|size| graph.step_size(size));
    let whole = graph.multiply(&sizes[0], &sizes[1]);
    let mut sums: Vec<Vec<(Rational, Term)>> = vec![Vec::new(); d];
    let order: Vec<usize> = (0..count(colours)).collect();
    for flow in passes(&order, parts) {
        let part = Rational::from_f64(flow.part).expect("a part of the time is finite");
        let time = graph.scale(&part, &whole);
        let mut own = |_: &mut Graph, at: usize| (colours[at] == flow.piece).then(|| time.clone());
        let increments = spins.increments(&mut graph, &state, &mut own)?;
        for (spin, increment) in spins.all.iter().zip(increments) {
            let places = spin.places.into_iter();
            for (place, change) in places.zip(increment.into_iter().flatten()) {
                state[place] = graph.add(&state[place], &change);
                sums[place].push((Rational::one(), change));
            }
        }
    }
    let increment: Vec<Term> = sums.iter().map(|sum| graph.combine(sum)).collect();
    graph.unless_refused(())?;
    Ok(ExplicitMap::compile(graph, increment, parameters).counting(evaluations(parts)))
}

impl Written {
    fn product(&self, parts: &[f64]) -> ExplicitMap {
        let Shared {
            system,
            colours,
            products,
            ..
        } = self.shared.as_ref();
        let key: Parts = parts.iter().map(|part| part.to_bits()).collect();
        let mut products = products.lock().unwrap_or_else(PoisonError::into_inner);
        let make = || {
            let spins = Spins::of(system).expect("its spins were found before");
            product(&spins, colours, parts).expect("the code of a step was written before")
        };
        products.entry(key).or_insert_with(make).clone()
    }
}

impl StepMap for Written {
    fn dimension(&self) -> usize {
        self.shared.step.dimension()
    }

    fn properties(&self) -> MapProperties {
        properties()
    }

    fn describe(&self) -> String {
        describe(count(&self.shared.colours))
    }

    fn abilities(&self) -> MapAbilities<'_> {
        MapAbilities {
            kernels: vec![("step", self.shared.step.kernel())],
            factored: Some(Factored {
                factors: Product::factors(self),
                pieces: count(&self.shared.colours),
                arranged: None,
                product: Box::new(|parts| Some(Arc::new(Product::new(self, parts)))),
            }),
            ..MapAbilities::default()
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        self.shared.step.stepper(lanes, parameters, epsilon, h)
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        let step = &self.shared.step;
        step.differential(parameters, (epsilon, h), Inverse::Opposite)
    }
}

impl Splits for Written {
    fn passes_stepper(
        &self,
        parts: &[f64],
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Stepper> {
        self.product(parts).stepper(lanes, parameters, epsilon, h)
    }

    fn passes_differential(
        &self,
        parts: &[f64],
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Differential> {
        let inverse = match is_symmetric(parts) {
            true => Inverse::Opposite,
            false => Inverse::Solved,
        };
        self.product(parts)
            .differential(parameters, (epsilon, h), inverse)
    }
}
