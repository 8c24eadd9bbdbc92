//! Whether flows that exact algebra found serve in numbers.

use leafwise_core::system::Agreement;
use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::graph::lift;
use leafwise_expression::{AlgebraError, Arithmetic, Graph, Polynomial, Rational, Ring, Term};

use crate::flow::Motion;
use crate::piece::{LieSeries, NAME, Piece};

/// The series of a piece's flows.
fn lie_series(system: &SystemFormulas, piece: &Piece) -> Result<LieSeries, AlgebraError> {
    let (mut graph, x) = inputs(system);
    let field = field_of(&mut graph, system, piece, &x)?;
    let mut terms = Vec::with_capacity(x.len());
    for (first, flow) in field.iter().zip(piece.flows()) {
        let mut series = vec![first.clone(); length(&flow.motion).min(1)];
        while series.len() < length(&flow.motion) {
            let last = series[series.len() - 1].clone();
            let mut sum = Vec::new();
            for &j in &flow.reads {
                let slope = graph.derivative(&last, j)?;
                sum.push((Rational::one(), graph.multiply(&field[j], &slope)));
            }
            series.push(graph.combine(&sum));
        }
        terms.push(series);
    }
    Ok(LieSeries { graph, terms })
}

fn inputs(system: &SystemFormulas) -> (Graph, Vec<Term>) {
    let mut graph = Graph::new();
    let x = (0..system.dimension()).map(|i| graph.input(i)).collect();
    (graph, x)
}

/// X_K of a piece as its terms are written.
fn field_of(
    graph: &mut Graph,
    system: &SystemFormulas,
    piece: &Piece,
    x: &[Term],
) -> Result<Vec<Term>, AlgebraError> {
    let mut sum = Vec::new();
    for formula in piece.formulas() {
        let value = formula.evaluate_in(graph, &mut |_, at| Ok(x[at].clone()))?;
        sum.push((Rational::one(), value));
    }
    let energy = graph.combine(&sum);
    let gradient = graph.gradient(&energy, x.len())?;
    let field = system.apply_tensor(graph, x, &gradient)?;
    Ok(field.iter().map(|f| graph.negate(f)).collect())
}

/// The terms of a Lie series that make a motion.
fn length(motion: &Motion) -> usize {
    match motion {
        Motion::Polynomial(series) => series.len(),
        Motion::Exponential { .. } | Motion::Affine { .. } => 2,
        Motion::Rotation { .. } | Motion::Oscillation { .. } => 3,
    }
}

/// The same terms from what the algebra found.
fn found_series(
    graph: &mut Graph,
    ring: &Ring,
    motion: &Motion,
    x: &[Term],
) -> Result<Vec<Term>, AlgebraError> {
    let lifted = |graph: &mut Graph, elements: &[&Polynomial]| {
        let one = graph.one();
        let elements = elements.iter().map(|f| vec![(one.clone(), (*f).clone())]);
        let outputs: Vec<_> = elements.collect();
        lift(graph, ring, &outputs, x)
    };
    let product = |graph: &mut Graph, factors: &[&Term]| {
        let one = graph.one();
        let factors = factors.iter();
        factors.fold(one, |product, factor| graph.multiply(&product, factor))
    };
    Ok(match motion {
        Motion::Polynomial(series) => lifted(graph, &series.iter().collect::<Vec<_>>())?,
        Motion::Exponential { base, rate } => {
            let [base, rate] = &lifted(graph, &[base, rate])?[..] else {
                unreachable!("one term for each polynomial")
            };
            vec![
                product(graph, &[base, rate]),
                product(graph, &[base, rate, rate]),
            ]
        }
        Motion::Affine { velocity, rate } => {
            let [velocity, rate] = &lifted(graph, &[velocity, rate])?[..] else {
                unreachable!("one term for each polynomial")
            };
            vec![velocity.clone(), product(graph, &[velocity, rate])]
        }
        Motion::Rotation {
            frequency,
            sine,
            versine,
        } => {
            let [omega, w, u] = &lifted(graph, &[frequency, sine, versine])?[..] else {
                unreachable!("one term for each polynomial")
            };
            let third = product(graph, &[omega, omega, omega, w]);
            vec![
                product(graph, &[omega, w]),
                product(graph, &[omega, omega, u]),
                graph.negate(&third),
            ]
        }
        Motion::Oscillation {
            velocity,
            acceleration,
            square,
        } => {
            let [v, a, lambda] = &lifted(graph, &[velocity, acceleration, square])?[..] else {
                unreachable!("one term for each polynomial")
            };
            let third = product(graph, &[lambda, v]);
            vec![v.clone(), a.clone(), graph.negate(&third)]
        }
    })
}

/// The pieces with flows that round like the formulas at points about the system's state. The algebra's expansions may
/// cancel, such as those of a power of q − 10. A motion polynomial in time is then computed from the formulas.
///
/// # Errors
/// [`BuildError::DoesNotFit`] where another motion cancels, or the pieces do not sum up to the field.
pub(crate) fn settled(
    system: &SystemFormulas,
    ring: &Ring,
    pieces: Vec<Piece>,
) -> Result<Vec<Piece>, BuildError> {
    let refusal = || BuildError::DoesNotFit {
        part: NAME,
        reason:
            "when its Hamiltonian is expanded, the terms of its flows cancel to round-off near \
                 the initial state: shift the coordinates to the region of the motion, such as y = \
                 q - 10, or take gauss, collective or hamilton-jacobi, which expand nothing there"
                .to_owned(),
    };
    let mut all = Vec::with_capacity(pieces.len());
    for piece in pieces {
        if let Some(motion) = piece.whole() {
            let (mut graph, x) = inputs(system);
            let made = motion.field(&mut graph, ring, &x)?;
            let expected = field_of(&mut graph, system, &piece, &x)?;
            if system.agreement(&graph, &made, &expected) != Agreement::Same {
                return Err(refusal());
            }
            all.push(piece);
            continue;
        }
        let series = lie_series(system, &piece)?;
        let mut graph = series.graph.clone();
        let (_, x) = inputs(system);
        let (mut made, mut expected) = (Vec::new(), Vec::new());
        for (flow, terms) in piece.flows().iter().zip(&series.terms) {
            made.extend(found_series(&mut graph, ring, &flow.motion, &x)?);
            expected.extend_from_slice(terms);
        }
        all.push(match system.agreement(&graph, &made, &expected) {
            Agreement::Same => piece,
            Agreement::Cancels | Agreement::Differs => {
                piece.computed_by(series).ok_or_else(refusal)?
            }
        });
    }
    let (mut graph, x) = inputs(system);
    let expected = system.vector_field(&mut graph, &x)?;
    let mut sums = vec![Vec::new(); x.len()];
    for piece in &all {
        let field = field_of(&mut graph, system, piece, &x)?;
        for (sum, component) in sums.iter_mut().zip(field) {
            sum.push((Rational::one(), component));
        }
    }
    let made: Vec<Term> = sums.iter().map(|sum| graph.combine(sum)).collect();
    match system.agreement(&graph, &made, &expected) {
        Agreement::Same => Ok(all),
        Agreement::Cancels | Agreement::Differs => Err(refusal()),
    }
}
