//! Flows as straight-line code.

use leafwise_expression::graph::lift;
use leafwise_expression::pairs::{
    EXPONENTIAL_MINUS_1, EXPONENTIAL_MINUS_1_MIRRORED, SINE, VERSINE,
};
use leafwise_expression::{
    AlgebraError, AnalyticFunction, Arithmetic, Graph, Polynomial, Rational, Ring, StepSize, Term,
};

use crate::entire::{PHI_1, STUMPFF_1, STUMPFF_2};
use crate::flow::Motion;
use crate::piece::{LieSeries, Piece};
use crate::rates::multiples;
use crate::schedule::Flow;

/// x(t) − x for the flow of a piece from the state `x` over the time `time`, coordinate by coordinate. Each has the
/// size of the motion and is formed without cancellation.
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
    increment_by(graph, ring, piece, time, x, Graph::apply_analytic)
}

/// The same with the functions of a flow over the opposite time: f(z) by a function of −z.
fn opposite_increment(
    graph: &mut Graph,
    ring: &Ring,
    piece: &Piece,
    time: &Term,
    x: &[Term],
) -> Result<Vec<Term>, AlgebraError> {
    let minus = Rational::from_integer(-1);
    increment_by(graph, ring, piece, time, x, |graph, function, order, z| {
        let mirrored = graph.scale(&minus, z);
        if function == SINE {
            let sine = graph.apply_analytic(SINE, order, &mirrored);
            graph.scale(&minus, &sine)
        } else if function == VERSINE {
            graph.apply_analytic(VERSINE, order, &mirrored)
        } else if function == EXPONENTIAL_MINUS_1 {
            graph.apply_analytic(EXPONENTIAL_MINUS_1_MIRRORED, order, &mirrored)
        } else if function == EXPONENTIAL_MINUS_1_MIRRORED {
            graph.apply_analytic(EXPONENTIAL_MINUS_1, order, &mirrored)
        } else {
            graph.apply_analytic(function, order, z)
        }
    })
}

/// The increment by this way of applying functions.
fn increment_by(
    graph: &mut Graph,
    ring: &Ring,
    piece: &Piece,
    time: &Term,
    x: &[Term],
    apply: impl Fn(&mut Graph, AnalyticFunction, u32, &Term) -> Term,
) -> Result<Vec<Term>, AlgebraError> {
    if let Some(motion) = piece.whole() {
        return motion.increment(graph, ring, time, x);
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
                let once = apply(graph, function, 0, &next());
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
                let factor = apply(graph, PHI_1, 0, &next());
                graph.multiply(&first, &factor)
            }
            Motion::Rotation { .. } => {
                let (second, angle) = (next(), next());
                let odd = apply(graph, SINE, 0, &angle);
                let even = apply(graph, VERSINE, 0, &angle);
                let (odd, even) = (graph.multiply(&first, &odd), graph.multiply(&second, &even));
                graph.add(&odd, &even)
            }
            Motion::Oscillation { .. } => {
                let (second, argument) = (next(), next());
                let odd = apply(graph, STUMPFF_1, 0, &argument);
                let even = apply(graph, STUMPFF_2, 0, &argument);
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

/// Increment Φ(x) − x of the product of flows of `pieces`, each over its part of the time. It is the sum of the flows'
/// increments.
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

/// Step back: the product of flows over −t from `x`, where these are the same from both ends. With it goes the
/// pull-back of the covector `w` through the inverse, the product over t. Returns x' − x, w' and the gradient by so
/// many parameters.
///
/// Each flow over −part, from z to z', is followed by the pull-back through the flow over part at z',
/// w ← w + ∂_z' (w·δ(z')). Coordinates that a flow does not move are the same at z and z'. Functions of these are
/// computed once.
///
/// # Errors
/// As [`flow_increment`]; those of derivatives.
///
/// # Panics
/// As [`product_increment`].
pub fn return_increment(
    graph: &mut Graph,
    ring: &Ring,
    pieces: &[Piece],
    flows: &[Flow],
    [x, w]: [&[Term]; 2],
    parameters: usize,
) -> Result<Vec<Term>, AlgebraError> {
    let d = x.len();
    let (mut state, mut covector) = (x.to_vec(), w.to_vec());
    let mut sums: Vec<Vec<(Rational, Term)>> = vec![Vec::new(); d + parameters];
    for flow in flows {
        let part = Rational::from_f64(flow.part).expect("a part of the time is finite");
        let piece = &pieces[flow.piece];
        let time = time_of(graph, &part);
        let increment = flow_increment(graph, ring, piece, &time, &state)?;
        for (value, change) in state.iter_mut().zip(&increment) {
            *value = graph.add(value, change);
        }
        let mut own = Graph::new();
        let z: Vec<Term> = (0..d).map(|i| own.input(i)).collect();
        let opposite = time_of(&mut own, &-part);
        let back = opposite_increment(&mut own, ring, piece, &opposite, &z)?;
        let mut pairing = Vec::with_capacity(d);
        for (i, change) in back.iter().enumerate() {
            let covector = own.input(d + i);
            pairing.push((Rational::one(), own.multiply(&covector, change)));
        }
        let pairing = own.combine(&pairing);
        let gradient = own.gradients(&pairing, [d, parameters])?.concat();
        own.unless_refused(())?;
        let here = [&state[..], &covector[..]].concat();
        let gradient = graph.import(&own, &gradient, &here)?;
        for (value, change) in covector.iter_mut().zip(&gradient) {
            *value = graph.add(value, change);
        }
        let by_parameters = gradient.into_iter().skip(d);
        for (sum, change) in sums
            .iter_mut()
            .zip(increment.into_iter().chain(by_parameters))
        {
            sum.push((Rational::one(), change));
        }
    }
    let mut sums = sums.iter().map(|sum| graph.combine(sum));
    let mut outputs: Vec<Term> = sums.by_ref().take(d).collect();
    outputs.append(&mut covector);
    outputs.extend(sums);
    Ok(outputs)
}

/// `part` of t = εh.
fn time_of(graph: &mut Graph, part: &Rational) -> Term {
    let (epsilon, h) = (
        graph.step_size(StepSize::Epsilon),
        graph.step_size(StepSize::H),
    );
    let time = graph.multiply(&epsilon, &h);
    graph.scale(part, &time)
}
