//! α and β as straight-line code.

use leafwise_core::BuildError;
use leafwise_core::realization::SourceTarget;
use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Function, Graph, Polynomial, Rational, Term};

use crate::doubling::{Pair, even_factor};
use crate::even_part::LARGEST;
use crate::relations::CoordinateClass;
use crate::structure::StructureConstants;

/// α, β = x + f(W) x ∓ ½ Z x, W = Z²/4, for algebras whose coordinates obey the relations of
/// [`relations`](crate::relations). On a class with roots c ± √δ of W, f(W) x = (G₀ + G₁ (W −
/// c)) W x. Here G₀ + G₁ u = g(c + u) modulo u² = δ.
#[derive(Clone, Debug)]
pub struct ClosedForm {
    structure: StructureConstants,
    classes: Vec<CoordinateClass>,
}

impl ClosedForm {
    /// That of an algebra with these classes of coordinates.
    pub fn new(structure: StructureConstants, classes: Vec<CoordinateClass>) -> Self {
        Self { structure, classes }
    }
}

impl ClosedForm {
    /// α and β at z = (x, p).
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the structure constants have no code.
    pub fn source_and_target(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        z: &[Term],
    ) -> Result<SourceTarget, BuildError> {
        let structure = &self.structure;
        let d = z.len() / 2;
        let (mut x, mut p) = (z[..d].to_vec(), z[d..].to_vec());
        if structure.is_affine() {
            x.push(graph.one());
            p.push(graph.zero());
        }
        let q: Vec<Term> = p.iter().map(|p| graph.multiply(epsilon, p)).collect();
        let constants = structure.code(graph)?;
        let mut moments = vec![Vec::new(); x.len()];
        let mut offsets = vec![Vec::new(); x.len()];
        let mut reaches = Vec::new();
        for class in &self.classes {
            let own = restricted(graph, &x, &class.coordinates);
            let moment = structure.apply(graph, &constants, &q, &own);
            for (sum, entry) in moments.iter_mut().zip(&moment) {
                sum.push((Rational::one(), entry.clone()));
            }
            if class.degree == 0 {
                continue;
            }
            let [centre, split] = roots(graph, structure, class, &q)?;
            reaches.push(reach(graph, &centre, &split)?);
            let w = Pair {
                constant: centre.clone(),
                slope: if class.degree == 2 {
                    graph.one()
                } else {
                    graph.zero()
                },
            };
            let factor = even_factor(graph, &w, &split)?;
            // 4 W x, and 16 W² x where there are two roots.
            let twice = structure.apply(graph, &constants, &q, &moment);
            let through = graph.multiply(&factor.slope, &centre);
            let plain = graph.subtract(&factor.constant, &through);
            for (sum, entry) in offsets.iter_mut().zip(&twice) {
                sum.push((Rational::new(1, 4), graph.multiply(&plain, entry)));
            }
            if class.degree == 2 {
                let thrice = structure.apply(graph, &constants, &q, &twice);
                let four_times = structure.apply(graph, &constants, &q, &thrice);
                for (sum, entry) in offsets.iter_mut().zip(&four_times) {
                    sum.push((Rational::new(1, 16), graph.multiply(&factor.slope, entry)));
                }
            }
        }
        let moment: Vec<Term> = moments.iter().map(|sum| graph.combine(sum)).collect();
        let offset = offsets.iter_mut().zip(&moment).map(|(sum, moment)| {
            sum.push((Rational::new(1, 2), moment.clone()));
            graph.combine(sum)
        });
        let offset: Vec<Term> = offset.take(d).collect();
        let increment = moment.iter().take(d).map(|entry| graph.negate(entry));
        Ok(SourceTarget {
            base: z[..d].to_vec(),
            offset,
            increment: increment.collect(),
            guard: guard(graph, reaches),
        })
    }
}

/// v on some coordinates, 0 on the others.
fn restricted(graph: &mut Graph, v: &[Term], coordinates: &[usize]) -> Vec<Term> {
    let mut own = vec![graph.zero(); v.len()];
    for &i in coordinates {
        own[i] = v[i].clone();
    }
    own
}

/// c and δ of W = A(q)²/4.
fn roots(
    graph: &mut Graph,
    structure: &StructureConstants,
    class: &CoordinateClass,
    q: &[Term],
) -> Result<[Term; 2], BuildError> {
    let one = graph.one();
    let scaled =
        |f: &Polynomial, factor: i64| vec![(one.clone(), f.scaled(&Rational::new(1, factor)))];
    let outputs = [scaled(&class.centre, 4), scaled(&class.split, 16)];
    let mut code = lift(graph, structure.ring(), &outputs, q)?;
    let split = code.pop().expect("two outputs");
    let centre = code.pop().expect("two outputs");
    Ok([centre, split])
}

/// Part of the way to the chart's end at which the point is, 1 at the end. It is the larger of
/// |Im λ|/2π and |λ|/(2 √[`LARGEST`]) over the eigenvalues λ = 2√w of Z, w = c ± √δ.
///
/// With real roots c ± σ, or a pair c ± √τ, τ < 0: 2 (Im √w)² = |w| − Re w and |w|² = (Re w)² − τ.
fn reach(graph: &mut Graph, centre: &Term, split: &Term) -> Result<Term, BuildError> {
    let (one, half) = (Rational::one(), Rational::new(1, 2));
    let size = absolute(graph, split)?;
    let real = graph.combine(&[(half.clone(), split.clone()), (half.clone(), size.clone())]);
    let tau = graph.combine(&[(half.clone(), split.clone()), (-&half, size)]);
    let sigma = graph.apply(Function::Sqrt, &real)?;
    let modulus = |graph: &mut Graph, re: &Term| {
        let square = graph.multiply(re, re);
        let sum = graph.subtract(&square, &tau);
        graph.apply(Function::Sqrt, &sum)
    };
    let lower = graph.subtract(centre, &sigma);
    let lower_size = modulus(graph, &lower)?;
    let pi = graph.pi();
    let wall = graph.multiply(&pi, &pi);
    let imaginary = graph.combine(&[(half.clone(), lower_size), (-&half, lower)]);
    let imaginary = graph.divide(&imaginary, &wall)?;
    let centre_size = absolute(graph, centre)?;
    let largest = graph.add(&centre_size, &sigma);
    let largest = modulus(graph, &largest)?;
    let limit = Rational::from_f64(1.0 / LARGEST).expect("a power of two");
    let largest = graph.scale(&limit, &largest);
    let difference = graph.subtract(&imaginary, &largest);
    let difference = absolute(graph, &difference)?;
    let sum = graph.combine(&[
        (one.clone(), imaginary),
        (one.clone(), largest),
        (one, difference),
    ]);
    let larger = graph.scale(&half, &sum);
    Ok(graph.apply(Function::Sqrt, &larger)?)
}

/// |v| = √(v²).
fn absolute(graph: &mut Graph, v: &Term) -> Result<Term, BuildError> {
    let square = graph.multiply(v, v);
    Ok(graph.apply(Function::Sqrt, &square)?)
}

/// The radius 1 against the classes' reaches.
fn guard(graph: &mut Graph, reaches: Vec<Term>) -> Option<(Vec<Term>, Vec<Term>)> {
    if reaches.is_empty() {
        return None;
    }
    Some((vec![graph.one(); reaches.len()], reaches))
}
