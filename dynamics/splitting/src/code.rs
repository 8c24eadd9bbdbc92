//! Flows as straight-line code.

use leafwise_expression::graph::lift;
use leafwise_expression::pairs::{
    EXPONENTIAL_MINUS_1, EXPONENTIAL_MINUS_1_MIRRORED, SINE, VERSINE,
};
use leafwise_expression::{AlgebraError, Arithmetic, Graph, Polynomial, Rational, Ring, Term};

use crate::entire::{PHI_1, STUMPFF_1, STUMPFF_2};
use crate::flow::Motion;
use crate::piece::{LieSeries, Piece};
use crate::rates::multiples;
use crate::schedule::Flow;

/// x(t) − x for the flow of a piece from the state `x` over the time `time`, coordinate by
/// coordinate; each of the size of the motion, formed without cancellation.
///
/// # Errors
/// [`AlgebraError`] where an adjoined function has no code.
pub fn flow_increment(
    graph: &mut Graph,
    ring: &Ring,
    piece: &Piece,
    time: &Term,
    x: &[Term],
) -> Result<Vec<Term>, AlgebraError> {
    if let Some(body) = piece.body() {
        return body.increment(graph, ring, time, x);
    }
    if let Some(series) = piece.code() {
        return polynomial_increment(graph, series, time, x);
    }
    let square = graph.multiply(time, time);
    let rates: Vec<&Polynomial> = piece.motions().filter_map(exponential_rate).collect();
    let multiples = multiples(&rates);
    let mut exponentials = multiples.iter();
    let mut wanted: Vec<Vec<(Term, Polynomial)>> = Vec::new();
    for motion in piece.motions() {
        match motion {
            Motion::Polynomial(series) => {
                let mut power = graph.one();
                let mut sum = Vec::with_capacity(series.len());
                for (k, term) in (1_i64..).zip(series) {
                    power = graph.multiply(&power, time);
                    power = graph.scale(&Rational::new(1, k), &power);
                    sum.push((power.clone(), term.clone()));
                }
                wanted.push(sum);
            }
            Motion::Exponential { base, .. } => {
                let multiple = exponentials.next().expect("one for each rate");
                wanted.push(vec![(graph.one(), base.clone())]);
                wanted.push(vec![(time.clone(), rates[multiple.of].clone())]);
            }
            Motion::Affine { velocity, rate } => {
                wanted.push(vec![(time.clone(), velocity.clone())]);
                wanted.push(vec![(time.clone(), rate.clone())]);
            }
            Motion::Rotation {
                frequency,
                sine,
                versine,
            } => {
                wanted.push(vec![(graph.one(), sine.clone())]);
                wanted.push(vec![(graph.one(), versine.clone())]);
                wanted.push(vec![(time.clone(), frequency.clone())]);
            }
            Motion::Oscillation {
                velocity,
                acceleration,
                square: lambda,
            } => {
                wanted.push(vec![(time.clone(), velocity.clone())]);
                wanted.push(vec![(square.clone(), acceleration.clone())]);
                wanted.push(vec![(square.clone(), lambda.clone())]);
            }
        }
    }
    let mut code = lift(graph, ring, &wanted, x)?.into_iter();
    let mut next = || code.next().expect("one term for each polynomial");
    let mut exponentials = multiples.iter();
    let mut increment = Vec::with_capacity(x.len());
    for motion in piece.motions() {
        let first = next();
        increment.push(match motion {
            Motion::Polynomial(_) => first,
            Motion::Exponential { .. } => {
                let multiple = exponentials.next().expect("one for each rate");
                let function = if multiple.factor > 0 {
                    EXPONENTIAL_MINUS_1
                } else {
                    EXPONENTIAL_MINUS_1_MIRRORED
                };
                let once = graph.apply_analytic(function, 0, &next());
                let factor = if multiple.factor.abs() == 2 {
                    // e^{2z} − 1 = u (2 + u), u = eᶻ − 1.
                    let two = graph.constant(&Rational::from_integer(2));
                    let sum = graph.add(&once, &two);
                    graph.multiply(&once, &sum)
                } else {
                    once
                };
                graph.multiply(&first, &factor)
            }
            Motion::Affine { .. } => {
                let factor = graph.apply_analytic(PHI_1, 0, &next());
                graph.multiply(&first, &factor)
            }
            Motion::Rotation { .. } => {
                let (second, angle) = (next(), next());
                let odd = graph.apply_analytic(SINE, 0, &angle);
                let even = graph.apply_analytic(VERSINE, 0, &angle);
                let (odd, even) = (graph.multiply(&first, &odd), graph.multiply(&second, &even));
                graph.add(&odd, &even)
            }
            Motion::Oscillation { .. } => {
                let (second, argument) = (next(), next());
                let odd = graph.apply_analytic(STUMPFF_1, 0, &argument);
                let even = graph.apply_analytic(STUMPFF_2, 0, &argument);
                let (odd, even) = (graph.multiply(&first, &odd), graph.multiply(&second, &even));
                graph.add(&odd, &even)
            }
        });
    }
    Ok(increment)
}

/// Σ_k tᵏ/k! v_k of each coordinate, with the v_k as code.
fn polynomial_increment(
    graph: &mut Graph,
    series: &LieSeries,
    time: &Term,
    x: &[Term],
) -> Result<Vec<Term>, AlgebraError> {
    let all: Vec<Term> = series.terms.iter().flatten().cloned().collect();
    let mut code = graph.import(&series.graph, &all, x)?.into_iter();
    let mut increment = Vec::with_capacity(x.len());
    for terms in &series.terms {
        let mut power = graph.one();
        let mut sum = Vec::with_capacity(terms.len());
        for (k, term) in (1_i64..).zip(code.by_ref().take(terms.len())) {
            power = graph.multiply(&power, time);
            power = graph.scale(&Rational::new(1, k), &power);
            sum.push((Rational::one(), graph.multiply(&power, &term)));
        }
        increment.push(graph.combine(&sum));
    }
    Ok(increment)
}

fn exponential_rate(motion: &Motion) -> Option<&Polynomial> {
    match motion {
        Motion::Exponential { rate, .. } => Some(rate),
        _ => None,
    }
}

/// The product of flows of `pieces`, each over its part of the time: its increment Φ(x) − x, the sum of
/// the flows'.
///
/// # Errors
/// Those of [`flow_increment`].
///
/// # Panics
/// Where a part is not finite.
pub fn product_increment(
    graph: &mut Graph,
    ring: &Ring,
    pieces: &[Piece],
    flows: &[Flow],
    time: &Term,
    x: &[Term],
) -> Result<Vec<Term>, AlgebraError> {
    let mut state = x.to_vec();
    let mut sums: Vec<Vec<(Rational, Term)>> = vec![Vec::new(); x.len()];
    for flow in flows {
        let part = Rational::from_f64(flow.part).expect("a part of the time is finite");
        let time = graph.scale(&part, time);
        let increment = flow_increment(graph, ring, &pieces[flow.piece], &time, &state)?;
        for ((value, sum), change) in state.iter_mut().zip(&mut sums).zip(increment) {
            *value = graph.add(value, &change);
            sum.push((Rational::one(), change));
        }
    }
    Ok(sums.iter().map(|sum| graph.combine(sum)).collect())
}
