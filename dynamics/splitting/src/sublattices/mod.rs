//! Damped spins, sublattice after sublattice.
//!
//! Where no spin of a sublattice is in the field of another, all of them turn and fall into fields at rest: the motion has
//! a closed form, along the leaves. Strang's product over the sublattices is explicit, of order 2 and self-adjoint, and a
//! Poisson map without damping (J. Frank, W. Huang, B. Leimkuhler, *Geometric integrators for classical spin systems*,
//! Journal of Computational Physics 133 (1997); M. Krech, A. Bunker, D. P. Landau, *Fast spin dynamics algorithms for
//! classical spin systems*, Computer Physics Communications 111 (1998)).
//!
//! - [`flow`]: the damped precession of one spin.
//! - [`spins`]: which systems are of spins.
//! - [`colours`]: sublattices.
//! - [`lattice`]: sweeps over long lattices.

mod colours;
mod flow;
mod lattice;
mod spins;

use std::sync::Arc;

use leafwise_core::part::{Elsewhere, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::StepperPart;
use leafwise_core::solver::{CodeStepMap, ExplicitMap, MapProperties, StepMap, Structure};
use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};
use leafwise_expression::{Arithmetic, Graph, Rational, StepSize, Term};

use crate::schedule::{STRANG, passes};
use spins::Spins;

static INFO: PartInfo = PartInfo {
    name: "sublattices",
    summary: "exact flows of damped spins in the field of the others, sublattice after sublattice",
    declares: "order 2; self-adjoint; explicit; exactly Poisson without damping, leaf-preserving with it: every length of \
               a spin to round-off",
    domain: "spins, so(3)* for each, with H linear in every one: exchange, fields, not anisotropies; damping of one rate a \
             spin",
    literature: "Frank, Huang, Leimkuhler, Geometric integrators for classical spin systems, J. Comput. Phys. 133 (1997); \
                 Krech, Bunker, Landau, Fast spin dynamics algorithms for classical spin systems, Comput. Phys. Commun. \
                 111 (1998)",
    takes_forces: true,
    elsewhere: Some(Elsewhere {
        names: &[
            "checkerboard",
            "even-odd",
            "odd-even",
            "staggered-red-black",
        ],
        is: "the product over sublattices of spins",
    }),
    ..PartInfo::of(PartKind::Stepper)
};

fn unfit(reason: impl Into<String>) -> BuildError {
    BuildError::DoesNotFit {
        part: INFO.name,
        reason: reason.into(),
    }
}

/// What the product promises.
fn properties(system: &SystemFormulas) -> MapProperties {
    MapProperties {
        order: 2,
        structure: match system.forces().damping {
            None => Structure::Exact,
            Some(_) => Structure::Leaves,
        },
        self_adjoint: Some(true),
    }
}

fn describe(count: usize) -> String {
    format!("{} of {count} colours", INFO.name)
}

/// The step of a system that is written out, as one kernel.
fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    let system = system.formulas(INFO.name)?;
    let spins = Spins::of(system)?;
    let colours = colours::of_written(&spins.all, &spins.reads);
    let count = colours.iter().max().map_or(0, |last| last + 1);
    let mut graph = Graph::new();
    let x: Vec<Term> = (0..system.dimension()).map(|i| graph.input(i)).collect();
    let (epsilon, h) = (
        graph.step_size(StepSize::Epsilon),
        graph.step_size(StepSize::H),
    );
    let whole = graph.multiply(&epsilon, &h);
    let mut state = x.clone();
    let mut sums: Vec<Vec<(Rational, Term)>> = vec![Vec::new(); x.len()];
    let order: Vec<usize> = (0..count).collect();
    for flow in passes(&order, &STRANG) {
        let part = Rational::from_f64(flow.part).expect("a part of the time is finite");
        let time = graph.scale(&part, &whole);
        let mut own = |_: &mut Graph, at: usize| (colours[at] == flow.piece).then(|| time.clone());
        let increments = spins.increments(&mut graph, &state, &mut own)?;
        for (spin, increment) in spins.all.iter().zip(increments) {
            for (place, change) in spin.places.into_iter().zip(increment.into_iter().flatten()) {
                state[place] = graph.add(&state[place], &change);
                sums[place].push((Rational::one(), change));
            }
        }
    }
    let increment: Vec<Term> = sums.iter().map(|sum| graph.combine(sum)).collect();
    graph.unless_refused(())?;
    let step = ExplicitMap::compile(graph, increment, system.parameters().len());
    Ok(Arc::new(CodeStepMap::new(
        describe(count),
        properties(system),
        step,
    )))
}

leafwise_core::built_in!(StepperPart::new(&INFO, build).with_sweeps(lattice::build));
