//! Jacobi's identity and Casimirs: proved in exact algebra, or sampled near a state.

use std::collections::BTreeSet;

use leafwise_expression::{
    Arithmetic, Expression, Graph, Kernel, Polynomial, Rational, Ring, Term,
};

use super::numeric_identity;
use super::verdict::{IdentityCheck, ROUND_OFF, Verdict, sample_states};
use crate::error::BuildError;
use crate::system::{PoissonSystem, SystemFormulas, TensorSource};

/// Triples of coordinates up to which Jacobi's identity is looked at one by one: some seconds.
const MOST_TRIPLES: usize = 1 << 16;

/// Jacobi's identity Σ_cyc Σ_l Π_il ∂_l Π_jk = 0 for every triple that nonzero entries link. The inverse of a form
/// that is proved to be closed is not looked at, and Dirac's bracket is Poisson where the bracket is that it is made
/// of. A system of numbers is sampled instead, for linear functions of all coordinates. So is one in which more than
/// 65 536 triples are linked.
///
/// # Errors
/// [`BuildError::Algebra`] where an entry has no code at all.
pub fn check_jacobi(
    system: &PoissonSystem,
    parameters: &[f64],
    near: &[f64],
) -> Result<IdentityCheck, BuildError> {
    if let Some(opaque) = system.opaque() {
        return Ok(numeric_identity::jacobi(opaque, parameters, near));
    }
    let formulas = system.formulas("the check of Jacobi's identity")?;
    if let Some(check) = by_construction(formulas, parameters, near)? {
        return Ok(check);
    }
    let Some(triples) = linked_triples(formulas) else {
        let numbers = system.without_formulas("the check of Jacobi's identity")?;
        return check_jacobi(&numbers, parameters, near);
    };
    let system = formulas;
    let components = |arithmetic: &mut dyn FnMut(&[usize]) -> Result<(), BuildError>| {
        triples.iter().try_for_each(|triple| arithmetic(triple))
    };
    let mut ring = Ring::new(system.dimension());
    let x: Vec<Polynomial> = (0..system.dimension()).map(|i| ring.variable(i)).collect();
    let mut undecided: Vec<Vec<usize>> = Vec::new();
    let exact = components(&mut |triple| {
        let terms = jacobi_terms(system, &mut ring, &x, triple, &mut |ring, f, l| {
            ring.derivative(f, l)
        })?;
        let terms: Vec<_> = terms.into_iter().map(|t| (Rational::one(), t)).collect();
        if !ring.combine(&terms).is_zero() {
            undecided.push(triple.to_vec());
        }
        Ok(())
    });
    let all: Vec<Vec<usize>> = triples.iter().cloned().collect();
    let code = |graph: &mut Graph, x: &[Term], triple: &[usize]| {
        jacobi_terms(system, graph, x, triple, &mut |graph, f, l| {
            graph.derivative(f, l)
        })
    };
    let is_refused = exact.is_err() || ring.refusal().is_some();
    if is_refused || undecided.is_empty() && !are_zero(system, near, &all, code)? {
        undecided = all;
    }
    sample(system, parameters, near, &undecided, code)
}

/// Verdict on Jacobi's identity that follows from how a tensor was made; `None` for one given by its entries.
fn by_construction(
    system: &SystemFormulas,
    parameters: &[f64],
    near: &[f64],
) -> Result<Option<IdentityCheck>, BuildError> {
    let holds = IdentityCheck {
        verdict: Verdict::ByConstruction,
        ..IdentityCheck::proved()
    };
    match system.source() {
        TensorSource::Entries => Ok(None),
        TensorSource::OneForm | TensorSource::TwoForm { is_proved: true } => Ok(Some(holds)),
        // Its derivative was within the bounds of its rounding errors when the tensor was made.
        TensorSource::TwoForm { is_proved: false } => Ok(Some(IdentityCheck {
            verdict: Verdict::NumericallyZero,
            ..holds
        })),
        TensorSource::Sum { entries, summands } => {
            let mut checks = vec![check_jacobi(
                &SystemFormulas::clone(entries).into(),
                parameters,
                near,
            )?];
            for (places, summand) in summands {
                let near: Vec<f64> = places.iter().map(|at| near[*at]).collect();
                let own = check_jacobi(&summand.clone().into(), parameters, &near)?;
                let worst = own.worst.iter().map(|at| places[*at]).collect();
                checks.push(IdentityCheck { worst, ..own });
            }
            let is_certain = |check: &IdentityCheck| {
                matches!(check.verdict, Verdict::Proved | Verdict::ByConstruction)
            };
            let is_violated = |check: &&IdentityCheck| check.verdict == Verdict::Violated;
            let least = checks.iter().find(is_violated);
            let least = least.or_else(|| checks.iter().find(|check| !is_certain(check)));
            Ok(Some(least.cloned().unwrap_or(holds)))
        }
        TensorSource::Dirac(base) => {
            let base = check_jacobi(&SystemFormulas::clone(base).into(), parameters, near)?;
            Ok(Some(match base.verdict {
                Verdict::Proved | Verdict::ByConstruction => holds,
                _ => base,
            }))
        }
    }
}

/// Π ∇C = 0 for the Casimir with this index.
///
/// # Errors
/// [`BuildError::Algebra`] where the Casimir has no derivative.
///
/// # Panics
/// When the system has no Casimir of this index.
pub fn check_casimir(
    system: &PoissonSystem,
    casimir: usize,
    parameters: &[f64],
    near: &[f64],
) -> Result<IdentityCheck, BuildError> {
    if let Some(opaque) = system.opaque() {
        return Ok(numeric_identity::casimir(opaque, casimir, parameters, near));
    }
    let system = system.formulas("the check of a Casimir")?;
    let formula = &system.casimirs()[casimir].expression;
    let rows: Vec<Vec<usize>> = (0..system.dimension()).map(|i| vec![i]).collect();
    let mut ring = Ring::new(system.dimension());
    let x: Vec<Polynomial> = (0..system.dimension()).map(|i| ring.variable(i)).collect();
    let mut undecided = Vec::new();
    let exact = rows.iter().try_for_each(|row| {
        let terms = casimir_terms(system, formula, &mut ring, &x, row[0], &mut |ring, f, l| {
            ring.derivative(f, l)
        })?;
        let terms: Vec<_> = terms.into_iter().map(|t| (Rational::one(), t)).collect();
        if !ring.combine(&terms).is_zero() {
            undecided.push(row.clone());
        }
        Ok::<(), BuildError>(())
    });
    let code = |graph: &mut Graph, x: &[Term], row: &[usize]| {
        casimir_terms(system, formula, graph, x, row[0], &mut |graph, f, l| {
            graph.derivative(f, l)
        })
    };
    let is_refused = exact.is_err() || ring.refusal().is_some();
    if is_refused || undecided.is_empty() && !are_zero(system, near, &rows, code)? {
        undecided = rows;
    }
    sample(system, parameters, near, &undecided, code)
}

/// Components of an identity that are looked at in numbers where the algebra has decided.
const LOOKED_AT: usize = 256;

/// Whether the components that exact algebra finds to be 0 are 0 to round-off in code that knows nothing
/// of it; of many some.
fn are_zero(
    system: &SystemFormulas,
    near: &[f64],
    all: &[Vec<usize>],
    mut terms: impl FnMut(&mut Graph, &[Term], &[usize]) -> Result<Vec<Term>, BuildError>,
) -> Result<bool, BuildError> {
    let mut graph = Graph::new();
    let x: Vec<Term> = (0..system.dimension()).map(|i| graph.input(i)).collect();
    let mut sums = Vec::new();
    for indices in all.iter().step_by(all.len().div_ceil(LOOKED_AT).max(1)) {
        let terms = terms(&mut graph, &x, indices)?;
        let terms: Vec<_> = terms.into_iter().map(|t| (Rational::one(), t)).collect();
        sums.push(graph.combine(&terms));
    }
    Ok(system.with_near(near)?.are_zero(&graph, &sums))
}

type Differentiate<'a, A> = dyn FnMut(
        &mut A,
        &<A as Arithmetic>::Element,
        usize,
    ) -> Result<<A as Arithmetic>::Element, leafwise_expression::AlgebraError>
    + 'a;

/// Π_ij in any algebra, `None` where it is structurally zero.
pub(super) fn entry<A: Arithmetic>(
    system: &SystemFormulas,
    arithmetic: &mut A,
    x: &[A::Element],
    i: usize,
    j: usize,
) -> Result<Option<A::Element>, BuildError> {
    let Some(formula) = system.tensor().get(&(i.min(j), i.max(j))) else {
        return Ok(None);
    };
    let value = formula.evaluate_in(arithmetic, &mut |_, at| Ok(x[at].clone()))?;
    Ok(Some(if i < j {
        value
    } else {
        arithmetic.negate(&value)
    }))
}

fn jacobi_terms<A: Arithmetic>(
    system: &SystemFormulas,
    arithmetic: &mut A,
    x: &[A::Element],
    triple: &[usize],
    differentiate: &mut Differentiate<'_, A>,
) -> Result<Vec<A::Element>, BuildError> {
    let mut terms = Vec::new();
    for (i, j, k) in
        [(0, 1, 2), (1, 2, 0), (2, 0, 1)].map(|(a, b, c)| (triple[a], triple[b], triple[c]))
    {
        let Some(inner) = entry(system, arithmetic, x, j, k)? else {
            continue;
        };
        let formula = &system.tensor()[&(j.min(k), j.max(k))];
        for l in formula.variables() {
            let Some(outer) = entry(system, arithmetic, x, i, l)? else {
                continue;
            };
            let derivative = differentiate(arithmetic, &inner, l)?;
            terms.push(arithmetic.multiply(&outer, &derivative));
        }
    }
    Ok(terms)
}

fn casimir_terms<A: Arithmetic>(
    system: &SystemFormulas,
    casimir: &Expression,
    arithmetic: &mut A,
    x: &[A::Element],
    row: usize,
    differentiate: &mut Differentiate<'_, A>,
) -> Result<Vec<A::Element>, BuildError> {
    let value = casimir.evaluate_in(arithmetic, &mut |_, at| Ok(x[at].clone()))?;
    let mut terms = Vec::new();
    for j in casimir.variables() {
        let Some(outer) = entry(system, arithmetic, x, row, j)? else {
            continue;
        };
        let derivative = differentiate(arithmetic, &value, j)?;
        terms.push(arithmetic.multiply(&outer, &derivative));
    }
    Ok(terms)
}

/// The triples i < j < k for which some term Π_il ∂_l Π_jk is not structurally zero; `None` for more
/// than [`MOST_TRIPLES`].
fn linked_triples(system: &SystemFormulas) -> Option<BTreeSet<Vec<usize>>> {
    let mut neighbours = vec![BTreeSet::new(); system.dimension()];
    for &(i, j) in system.tensor().keys() {
        neighbours[i].insert(j);
        neighbours[j].insert(i);
    }
    let mut triples = BTreeSet::new();
    for (&(j, k), formula) in system.tensor() {
        for l in formula.variables() {
            for &i in &neighbours[l] {
                let mut triple = vec![i, j, k];
                triple.sort_unstable();
                triple.dedup();
                if triple.len() == 3 {
                    triples.insert(triple);
                }
            }
            if triples.len() > MOST_TRIPLES {
                return None;
            }
        }
    }
    Some(triples)
}

fn sample(
    system: &SystemFormulas,
    parameters: &[f64],
    near: &[f64],
    undecided: &[Vec<usize>],
    mut terms: impl FnMut(&mut Graph, &[Term], &[usize]) -> Result<Vec<Term>, BuildError>,
) -> Result<IdentityCheck, BuildError> {
    if undecided.is_empty() {
        return Ok(IdentityCheck::proved());
    }
    let d = system.dimension();
    let mut graph = Graph::new();
    let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let mut outputs = Vec::new();
    let mut lengths = Vec::with_capacity(undecided.len());
    for indices in undecided {
        let terms = terms(&mut graph, &x, indices)?;
        lengths.push(terms.len());
        outputs.extend(terms);
    }
    let kernel = Kernel::compile(&graph, &outputs, parameters.len(), d);
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, parameters, &[1.0], &[1.0]);
    let mut values = vec![0.0; outputs.len()];
    let mut check = IdentityCheck {
        verdict: Verdict::Undecided,
        residual: 0.0,
        worst: undecided[0].clone(),
        at: near.to_vec(),
        floor: None,
    };
    for state in sample_states(near) {
        kernel.evaluate(&mut workspace, &state, &mut values);
        if values.iter().any(|v| !v.is_finite()) {
            continue;
        }
        if check.verdict == Verdict::Undecided {
            check.verdict = Verdict::NumericallyZero;
        }
        let mut rest = values.as_slice();
        for (indices, &length) in undecided.iter().zip(&lengths) {
            let (terms, others) = rest.split_at(length);
            rest = others;
            let size: f64 = terms.iter().map(|t| t.abs()).sum();
            let residual = terms.iter().sum::<f64>().abs() / size;
            if size > 0.0 && residual > check.residual {
                check.residual = residual;
                check.worst.clone_from(indices);
                check.at.clone_from(&state);
            }
        }
    }
    if check.residual > ROUND_OFF {
        check.verdict = Verdict::Violated;
    }
    Ok(check)
}
