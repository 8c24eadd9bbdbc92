//! The eigenvalues of A(p)² that the coordinate vectors see.
//!
//! Let A² (A² − c)² e = δ A² e with c and δ polynomials in p. Then a function of A² without a
//! constant term acts on e through its value and slope at the two roots c ± √δ alone. No matrix is
//! inverted and no eigenvalue computed. The relation holds on these algebras: so(3) (one root,
//! c = −‖p‖²); se(3) and every other so(3) ⋉ ℝ³ᵏ (one root, twice); sl(2). It holds on so(4) and
//! so(3, 1) (two roots, δ a square or minus one), and on solvable algebras such as Toda's. It holds
//! on direct sums of all these, where every summand has its own roots. On larger simple algebras,
//! su(3) or so(5), it does not.

use std::collections::BTreeSet;

use leafwise_expression::{Arithmetic, Polynomial, Rational, Ring};
use nalgebra::{DMatrix, DVector};

use crate::structure::{SparseVector, StructureConstants, accumulate};

/// Coordinates whose unit vectors obey one relation.
#[derive(Clone, Debug)]
pub struct CoordinateClass {
    /// Which.
    pub coordinates: Vec<usize>,
    /// 0: A² e = 0. 1: A² (A² − c) e = 0. 2: A² ((A² − c)² − δ) e = 0.
    pub degree: usize,
    /// c(p), quadratic.
    pub centre: Polynomial,
    /// δ(p), quartic: the squared half distance of the roots, negative for a conjugate pair.
    pub split: Polynomial,
}

/// The classes of all coordinates; `None` where one obeys no such relation.
///
/// A relation is guessed from traces at one p and these `parameters`, and proved in the exact ring.
/// With n equal multiplicities of the roots, c = tr A²/n and δ = tr A⁴/n − c². The traces are taken
/// on the coordinates that powers of A² reach from e.
pub fn classes(structure: &StructureConstants, parameters: &[f64]) -> Option<Vec<CoordinateClass>> {
    let sample = sample(structure, parameters);
    let guesses: Option<Vec<Guess>> = (0..structure.dimension())
        .map(|i| guess(&sample, i))
        .collect();
    let guesses = guesses?;
    let mut ring = structure.ring().clone();
    let square = square(structure, &mut ring);
    let mut classes: Vec<CoordinateClass> = Vec::new();
    for (i, guess) in guesses.iter().enumerate() {
        let (centre, split) = prove(&mut ring, &square, i, guess)?;
        let degree = guess.degree;
        let same = classes
            .iter_mut()
            .find(|class| class.degree == degree && class.centre == centre && class.split == split);
        match same {
            Some(class) => class.coordinates.push(i),
            None => classes.push(CoordinateClass {
                coordinates: vec![i],
                degree,
                centre,
                split,
            }),
        }
    }
    Some(classes)
}

/// The columns of A(p)².
fn square(structure: &StructureConstants, ring: &mut Ring) -> Vec<SparseVector> {
    let columns = structure.coadjoint_columns(ring);
    let images = columns.iter().map(|column| image(ring, &columns, column));
    images.collect()
}

/// A² at a p without relations of its own, in numbers; round-off in place of a zero is taken away.
fn sample(structure: &StructureConstants, parameters: &[f64]) -> DMatrix<f64> {
    let d = structure.dimension();
    let p: Vec<f64> = (0..d)
        .map(|j| libm::sin(1.0 + 2.3 * j as f64 + 0.1 * (j * j) as f64))
        .collect();
    let mut map = vec![0.0; d * d];
    structure.at(parameters).coadjoint(&p, &mut map);
    let map = DMatrix::from_row_slice(d, d, &map);
    let square = &map * &map;
    let negligible = SMALL * square.amax();
    square.map(|entry| {
        if entry.abs() <= negligible {
            0.0
        } else {
            entry
        }
    })
}

/// Σ_k v_k columns_k.
fn image(ring: &mut Ring, columns: &[SparseVector], v: &SparseVector) -> SparseVector {
    let mut sum = SparseVector::new();
    for (&k, factor) in v {
        for (&i, entry) in &columns[k] {
            let product = ring.multiply(factor, entry);
            accumulate(&mut sum, i, &Rational::one(), &product);
        }
    }
    sum
}

/// The coordinates of e_i and of all its images under powers of the matrix.
fn reach(square: &DMatrix<f64>, i: usize) -> BTreeSet<usize> {
    let mut reached = BTreeSet::from([i]);
    let mut open = vec![i];
    while let Some(k) = open.pop() {
        let rows = (0..square.nrows()).filter(|&row| square[(row, k)] != 0.0);
        open.extend(rows.filter(|&row| reached.insert(row)));
    }
    reached
}

/// A relation guessed from numbers, to be proved in the exact ring.
#[derive(Clone, Debug)]
struct Guess {
    degree: usize,
    /// n, 0 where the only root is 0.
    multiplicity: usize,
    /// The coordinates whose traces count.
    reach: BTreeSet<usize>,
}

/// Largest residual of a guessed relation that counts as round-off, relative to its summands.
const SMALL: f64 = 1e-9;

fn guess(square: &DMatrix<f64>, i: usize) -> Option<Guess> {
    let reach = reach(square, i);
    let first: DVector<f64> = square.column(i).into();
    if first.iter().all(|v| *v == 0.0) {
        return Some(Guess {
            degree: 0,
            multiplicity: 0,
            reach,
        });
    }
    let second = square * &first;
    let third = square * &second;
    let trace: f64 = reach.iter().map(|&k| square[(k, k)]).sum();
    let rows = reach.iter();
    let trace_of_square: f64 = rows
        .flat_map(|&k| reach.iter().map(move |&l| square[(k, l)] * square[(l, k)]))
        .sum();
    for degree in 1..=2 {
        for multiplicity in 0..=reach.len() {
            let share = |trace: f64| match multiplicity {
                0 => 0.0,
                n => trace / n as f64,
            };
            let centre = share(trace);
            let (residual, size) = if degree == 1 {
                let size = second.norm() + centre.abs() * first.norm();
                ((&second - &first * centre).norm(), size)
            } else {
                let product = 2.0 * centre * centre - share(trace_of_square);
                let residual = &third - &second * (2.0 * centre) + &first * product;
                let size = third.norm() + 2.0 * centre.abs() * second.norm();
                (residual.norm(), size + product.abs() * first.norm())
            };
            if residual <= SMALL * size {
                return Some(Guess {
                    degree,
                    multiplicity,
                    reach,
                });
            }
        }
    }
    None
}

/// c and δ, if the relation is an identity in p.
fn prove(
    ring: &mut Ring,
    square: &[SparseVector],
    i: usize,
    guess: &Guess,
) -> Option<(Polynomial, Polynomial)> {
    let zero = Polynomial::zero();
    let first = &square[i];
    if guess.degree == 0 {
        return first.is_empty().then(|| (zero.clone(), zero));
    }
    let (mut centre, mut split) = (zero.clone(), zero.clone());
    if guess.multiplicity > 0 {
        let share = Rational::new(1, guess.multiplicity as i64);
        let (mut trace, mut trace_of_square) = (Vec::new(), Vec::new());
        for &k in &guess.reach {
            if let Some(entry) = square[k].get(&k) {
                trace.push((share.clone(), entry.clone()));
            }
            for (l, entry) in &square[k] {
                if let Some(back) = square[*l].get(&k) {
                    trace_of_square.push((share.clone(), ring.multiply(entry, back)));
                }
            }
        }
        centre = ring.combine(&trace);
        if guess.degree == 2 {
            let minus = ring.multiply(&centre, &centre);
            trace_of_square.push((-Rational::one(), minus));
            split = ring.combine(&trace_of_square);
        }
    }
    // (A² − c) A² e, and for degree 2 once more, less δ A² e.
    let mut left = shifted(ring, square, &centre, first);
    if guess.degree == 2 {
        left = shifted(ring, square, &centre, &left);
        for (&k, entry) in first {
            let product = ring.multiply(&split, entry);
            accumulate(&mut left, k, &-Rational::one(), &product);
        }
    }
    left.is_empty().then_some((centre, split))
}

/// (A² − c) v.
fn shifted(
    ring: &mut Ring,
    square: &[SparseVector],
    centre: &Polynomial,
    v: &SparseVector,
) -> SparseVector {
    let mut result = image(ring, square, v);
    for (&k, entry) in v {
        let product = ring.multiply(centre, entry);
        accumulate(&mut result, k, &-Rational::one(), &product);
    }
    result
}
