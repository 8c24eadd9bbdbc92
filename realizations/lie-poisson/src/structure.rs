//! Structure constants c_ij^k of a linear tensor, and of an affine one with a further coordinate.

use std::collections::BTreeMap;
use std::sync::Arc;

use leafwise_core::{BuildError, SystemFormulas};
use leafwise_expression::graph::lift;
use leafwise_expression::{
    AlgebraError, Arithmetic, Graph, Kernel, Polynomial, Rational, Ring, Term,
};

/// The part's name.
pub(crate) const NAME: &str = "lie-poisson";

/// The nonzero c_ij^k, i < j, of Π_ij(x) = Σ_k c_ij^k x_k as functions of the parameters.
///
/// An affine tensor Σ_k c_ij^k x_k + a_ij is this one over (x, 1): a central extension of the algebra, whose further coordinate
/// is a Casimir.
#[derive(Clone, Debug)]
pub struct StructureConstants {
    dimension: usize,
    is_affine: bool,
    ring: Ring,
    places: Vec<[usize; 3]>,
    constants: Vec<Polynomial>,
    kernel: Arc<Kernel>,
}

impl StructureConstants {
    /// The structure constants of a system's tensor.
    ///
    /// # Errors
    /// Returns [`BuildError::DoesNotFit`] with the first entry whose normal form is not linear or affine in the
    /// variables. Returns it too where all entries are constant, and [`BuildError::Algebra`] where an entry has no
    /// normal form.
    pub fn new(system: &SystemFormulas) -> Result<Self, BuildError> {
        let d = system.dimension();
        let mut ring = Ring::new(d + 1);
        let (mut places, mut constants) = (Vec::new(), Vec::new());
        for (&(i, j), entry) in system.tensor() {
            let value = entry.evaluate_in(&mut ring, &mut |ring, at| Ok(ring.variable(at)))?;
            for (monomial, coefficient) in value.terms() {
                let factor = match monomial.factors() {
                    [] => d,
                    &[(symbol, 1)] if ring.generator(symbol).is_none() => symbol as usize,
                    _ => return Err(not_affine(system, i, j)),
                };
                places.push([i, j, factor]);
                constants.push(Polynomial::constant(coefficient.clone()));
            }
        }
        let is_affine = places.iter().any(|place| place[2] == d);
        if is_affine && places.iter().all(|place| place[2] == d) {
            return Err(BuildError::DoesNotFit {
                part: NAME,
                reason: "no entry depends on a variable: the tensor is constant".to_owned(),
            });
        }
        let mut graph = Graph::new();
        let code = as_code(&mut graph, &ring, &constants)?;
        let dimension = d + usize::from(is_affine);
        let kernel = Kernel::compile(&graph, &code, system.parameters().len(), dimension);
        Ok(Self {
            dimension,
            is_affine,
            ring,
            places,
            constants,
            kernel: Arc::new(kernel),
        })
    }

    /// The number of coordinates, with that which is 1.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Whether the last coordinate is 1.
    pub fn is_affine(&self) -> bool {
        self.is_affine
    }

    /// The ring the constants live in; its variables stand for p.
    pub fn ring(&self) -> &Ring {
        &self.ring
    }

    /// The columns of A(p), A_ik = Σ_j c_ij^k p_j, their zero entries left out.
    pub fn coadjoint_columns(&self, ring: &mut Ring) -> Vec<SparseVector> {
        let mut columns = vec![SparseVector::new(); self.dimension];
        for (&[i, j, k], c) in self.places.iter().zip(&self.constants) {
            for (row, momentum, sign) in [(i, j, 1), (j, i, -1)] {
                let p = ring.variable(momentum);
                let entry = ring.multiply(c, &p);
                accumulate(&mut columns[k], row, &Rational::from_integer(sign), &entry);
            }
        }
        columns
    }

    /// The constants as code, for [`apply`](Self::apply).
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a function of the parameters has no code.
    pub fn code(&self, graph: &mut Graph) -> Result<Vec<Term>, BuildError> {
        Ok(as_code(graph, &self.ring, &self.constants)?)
    }

    /// A(q) v as code.
    pub fn apply(
        &self,
        graph: &mut Graph,
        constants: &[Term],
        q: &[Term],
        v: &[Term],
    ) -> Vec<Term> {
        let mut rows = vec![Vec::new(); self.dimension];
        for (&[i, j, k], c) in self.places.iter().zip(constants) {
            for (row, momentum, sign) in [(i, j, 1), (j, i, -1)] {
                let product = graph.multiply(&v[k], &q[momentum]);
                let entry = graph.multiply(c, &product);
                rows[row].push((Rational::from_integer(sign), entry));
            }
        }
        rows.iter().map(|row| graph.combine(row)).collect()
    }

    /// The constants for these parameters.
    pub fn at(&self, parameters: &[f64]) -> LieAlgebra {
        let mut workspace = self.kernel.workspace(1);
        self.kernel
            .prepare(&mut workspace, parameters, &[1.0], &[1.0]);
        let mut values = vec![0.0; self.places.len()];
        let origin = vec![0.0; self.dimension];
        self.kernel.evaluate(&mut workspace, &origin, &mut values);
        LieAlgebra {
            dimension: self.dimension,
            constants: self.places.iter().copied().zip(values).collect(),
        }
    }
}

fn as_code(
    graph: &mut Graph,
    ring: &Ring,
    constants: &[Polynomial],
) -> Result<Vec<Term>, AlgebraError> {
    let one = graph.one();
    let outputs: Vec<_> = constants
        .iter()
        .map(|c| vec![(one.clone(), c.clone())])
        .collect();
    lift(graph, ring, &outputs, &[])
}

/// A vector of polynomials without its zero components.
pub type SparseVector = BTreeMap<usize, Polynomial>;

/// v_i ← v_i + c f.
pub(crate) fn accumulate(v: &mut SparseVector, i: usize, c: &Rational, f: &Polynomial) {
    let old = v.remove(&i).unwrap_or_default();
    let sum = Polynomial::combine(&[(Rational::one(), old), (c.clone(), f.clone())]);
    if !sum.is_zero() {
        v.insert(i, sum);
    }
}

fn not_affine(system: &SystemFormulas, i: usize, j: usize) -> BuildError {
    let [first, second] = [i, j].map(|at| &system.variables()[at]);
    BuildError::DoesNotFit {
        part: NAME,
        reason: format!(
            "{{{first}, {second}}} is not linear or affine in the variables with coefficients of the \
             parameters"
        ),
    }
}

/// Structure constants as numbers.
#[derive(Clone, Debug)]
pub struct LieAlgebra {
    dimension: usize,
    constants: Vec<([usize; 3], f64)>,
}

impl LieAlgebra {
    /// d.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Writes Π(v), Π_ij = Σ_k c_ij^k v_k, row-major.
    pub fn tensor(&self, v: &[f64], tensor: &mut [f64]) {
        tensor.fill(0.0);
        for &([i, j, k], c) in &self.constants {
            let value = c * v[k];
            tensor[i * self.dimension + j] += value;
            tensor[j * self.dimension + i] -= value;
        }
    }

    /// Operations of [`tensor`](Self::tensor), and of [`coadjoint`](Self::coadjoint).
    pub fn operations(&self) -> u64 {
        4 * self.constants.len() as u64
    }

    /// Writes the coadjoint map A(p), A_ik = Σ_j c_ij^k p_j, row-major, so that A(p) y = Π(y) p.
    pub fn coadjoint(&self, p: &[f64], map: &mut [f64]) {
        map.fill(0.0);
        for &([i, j, k], c) in &self.constants {
            map[i * self.dimension + k] += c * p[j];
            map[j * self.dimension + k] -= c * p[i];
        }
    }
}
