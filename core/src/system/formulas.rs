//! Poisson systems as formulas.

use std::collections::BTreeMap;

use leafwise_expression::{AlgebraError, Arithmetic, Expression, Graph, Kernel, Rational, Term};

use super::forces::Forces;
use super::formula_kernel::kernel;
use super::{Casimir, Convention, Parameter};
use crate::error::BuildError;

/// Source of a tensor, which tells whether it is Poisson: entries, a one-form, a two-form, constraints or a direct sum.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum TensorSource {
    /// Entries: Jacobi's identity holds for them or not.
    #[default]
    Entries,
    /// Π = −(dϑ)⁻¹, and d(dϑ) = 0.
    OneForm,
    /// Π = −ω⁻¹ with dω = 0.
    TwoForm {
        /// In exact algebra, or to round-off about the state about which the system moves.
        is_proved: bool,
    },
    /// Dirac's bracket of constraints, Poisson where this system's tensor is.
    Dirac(Box<SystemFormulas>),
    /// A direct sum, Poisson where every summand is.
    Sum {
        /// The tensor of the coordinates of no summand below, by its entries.
        entries: Box<SystemFormulas>,
        /// The coordinates of every other summand, and their tensor.
        summands: Vec<(Vec<usize>, SystemFormulas)>,
    },
}

/// A Poisson system whose tensor, Hamiltonian and Casimirs are formulas.
///
/// The tensor is held in the paper's convention whatever the author's: Π_ij = {x_i, x_j} with
/// ẋ = −Π ∇H.
#[derive(Clone, Debug)]
pub struct SystemFormulas {
    variables: Vec<String>,
    pub(super) parameters: Vec<Parameter>,
    tensor: BTreeMap<(usize, usize), Expression>,
    hamiltonian: Expression,
    casimirs: Vec<Casimir>,
    convention: Convention,
    near: Vec<f64>,
    source: TensorSource,
    names: Vec<(String, Expression)>,
    forces: Forces,
}

impl SystemFormulas {
    /// System over named variables. The entries of `bracket` are {x_i, x_j} for i < j as its author wrote them under
    /// `convention`. Absent ones are zero.
    ///
    /// # Errors
    /// [`BuildError::Dimension`] when an entry names a variable that does not exist or is not above the diagonal. A
    /// formula that uses an index out of range gives the same error.
    pub fn new(
        variables: Vec<String>,
        parameters: Vec<Parameter>,
        bracket: impl IntoIterator<Item = ((usize, usize), Expression)>,
        hamiltonian: Expression,
        casimirs: Vec<Casimir>,
        convention: Convention,
    ) -> Result<Self, BuildError> {
        let mut tensor = BTreeMap::new();
        for ((i, j), entry) in bracket {
            if i >= j || j >= variables.len() {
                return Err(BuildError::Dimension {
                    what: format!("bracket entry ({i}, {j})"),
                    expected: variables.len(),
                    found: j + 1,
                });
            }
            let entry = match convention {
                Convention::HamiltonianFirst => entry,
                Convention::HamiltonianSecond => Expression::Negate(Box::new(entry)),
            };
            tensor.insert((i, j), entry);
        }
        // Of no special value in any coordinate.
        let near = (1..=variables.len()).map(|i| 0.5 + (i as f64 * 0.618_033_988_749_894_9) % 1.0);
        let near = near.collect();
        let system = Self {
            variables,
            parameters,
            tensor,
            hamiltonian,
            casimirs,
            convention,
            near,
            source: TensorSource::Entries,
            names: Vec::new(),
            forces: Forces::default(),
        };
        system.check_indices()?;
        Ok(system)
    }

    /// The same system with another Hamiltonian, a function of the same variables and parameters.
    ///
    /// # Errors
    /// [`BuildError::Dimension`] where it uses an index out of range.
    pub fn with_hamiltonian(&self, hamiltonian: Expression) -> Result<Self, BuildError> {
        let system = Self {
            hamiltonian,
            ..self.clone()
        };
        system.check_indices()?;
        Ok(system)
    }

    /// The same system with these forces: ẋ = −Π(dH + η) + f in place of ẋ = {H, x}.
    ///
    /// # Errors
    /// [`BuildError::Dimension`] for another number of them than d or 0. A metric that is not d×d or an index out of
    /// range gives the same error.
    pub fn with_forces(&self, forces: Forces) -> Result<Self, BuildError> {
        forces.check(self.dimension())?;
        let system = Self {
            forces,
            ..self.clone()
        };
        system.check_indices()?;
        Ok(system)
    }

    /// η and f; empty for ẋ = {H, x}.
    pub fn forces(&self) -> &Forces {
        &self.forces
    }

    /// The same system with the state about which it is going to move. There the code made of its formulas is compared
    /// with them.
    ///
    /// # Errors
    /// [`BuildError::Dimension`] unless there is a number for each variable.
    pub fn with_near(&self, near: &[f64]) -> Result<Self, BuildError> {
        if near.len() != self.dimension() {
            return Err(BuildError::Dimension {
                what: "the state about which the system moves".to_owned(),
                expected: self.dimension(),
                found: near.len(),
            });
        }
        Ok(Self {
            near: near.to_vec(),
            ..self.clone()
        })
    }

    /// The state about which the system moves.
    pub fn near(&self) -> &[f64] {
        &self.near
    }

    /// The same system with this tensor in the paper's convention.
    pub(super) fn with_tensor(
        self,
        tensor: BTreeMap<(usize, usize), Expression>,
        source: TensorSource,
    ) -> Self {
        Self {
            tensor,
            source,
            ..self
        }
    }

    /// The same system with the tensors of these summands, and with their Casimirs and names. Each summand is over the
    /// coordinates beside it. No entry of this system's own tensor may depend on those.
    ///
    /// # Panics
    /// When a summand has another number of coordinates than stand beside it.
    pub fn with_summands(mut self, summands: Vec<(Vec<usize>, Self)>) -> Self {
        let entries = Box::new(self.clone());
        for (places, summand) in &summands {
            assert_eq!(
                places.len(),
                summand.dimension(),
                "a place for each coordinate"
            );
            for (&(i, j), entry) in &summand.tensor {
                let (i, j, entry) = (places[i], places[j], entry.with_variables(places));
                let _ = match i < j {
                    true => self.tensor.insert((i, j), entry),
                    false => self
                        .tensor
                        .insert((j, i), Expression::Negate(Box::new(entry))),
                };
            }
            self.casimirs
                .extend(summand.casimirs.iter().map(|casimir| Casimir {
                    name: casimir.name.clone(),
                    expression: casimir.expression.with_variables(places),
                }));
            for (name, formula) in &summand.names {
                let named = (name.clone(), formula.with_variables(places));
                if !self.names.contains(&named) {
                    self.names.push(named);
                }
            }
        }
        self.source = TensorSource::Sum { entries, summands };
        self
    }

    /// The same system with further Casimirs.
    pub(super) fn with_casimirs(mut self, casimirs: Vec<Casimir>) -> Self {
        self.casimirs.extend(casimirs);
        self
    }

    /// The same system with further names for formulas of it, by which messages call them.
    pub fn with_names(mut self, names: impl IntoIterator<Item = (String, Expression)>) -> Self {
        self.names.extend(names);
        self
    }

    /// Names for formulas, by which messages call them.
    pub fn names(&self) -> &[(String, Expression)] {
        &self.names
    }

    /// Source of the tensor: entries, a form, constraints or a direct sum.
    pub fn source(&self) -> &TensorSource {
        &self.source
    }

    fn check_indices(&self) -> Result<(), BuildError> {
        let formulas = self
            .tensor
            .values()
            .chain(std::iter::once(&self.hamiltonian))
            .chain(self.casimirs.iter().map(|c| &c.expression))
            .chain(self.forces.formulas());
        for formula in formulas {
            let used = [
                (
                    "variable",
                    formula.variables().last().copied(),
                    self.variables.len(),
                ),
                (
                    "parameter",
                    formula.parameters().last().copied(),
                    self.parameters.len(),
                ),
            ];
            for (what, last, count) in used {
                if let Some(index) = last.filter(|index| *index >= count) {
                    return Err(BuildError::Dimension {
                        what: format!("{what} number {index} in a formula"),
                        expected: count,
                        found: index + 1,
                    });
                }
            }
        }
        Ok(())
    }

    /// d, the dimension of M.
    pub fn dimension(&self) -> usize {
        self.variables.len()
    }

    /// The variables' names.
    pub fn variables(&self) -> &[String] {
        &self.variables
    }

    /// The parameters.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    pub(super) fn parameters_mut(&mut self) -> &mut [Parameter] {
        &mut self.parameters
    }

    /// The parameters' values, in order.
    pub fn parameter_values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }

    /// The nonzero entries Π_ij = {x_i, x_j}, i < j, in the paper's convention.
    pub fn tensor(&self) -> &BTreeMap<(usize, usize), Expression> {
        &self.tensor
    }

    /// H.
    pub fn hamiltonian(&self) -> &Expression {
        &self.hamiltonian
    }

    /// H, the entries of the tensor, and the formulas of the forces.
    pub fn parts(&self) -> impl Iterator<Item = &Expression> {
        let entries = self.tensor.values().chain([&self.hamiltonian]);
        entries.chain(self.forces().formulas())
    }

    /// Whether H, the tensor or the forces are smooth in pieces.
    pub fn has_seams(&self) -> bool {
        self.parts().any(Expression::has_seams)
    }

    /// The Casimirs.
    pub fn casimirs(&self) -> &[Casimir] {
        &self.casimirs
    }

    /// The convention of the system's author.
    pub fn convention(&self) -> Convention {
        self.convention
    }

    /// (Π(x)·v)_i = Σ_j Π_ij(x) v_j in any algebra: the rows of the tensor on a covector.
    ///
    /// # Errors
    /// [`AlgebraError`] where an entry has no value.
    pub fn apply_tensor<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        x: &[A::Element],
        v: &[A::Element],
    ) -> Result<Vec<A::Element>, AlgebraError> {
        let one = Rational::one();
        let mut rows: Vec<Vec<(Rational, A::Element)>> = vec![Vec::new(); self.dimension()];
        for (&(i, j), entry) in &self.tensor {
            let entry = entry.evaluate_in(arithmetic, &mut |_, at| Ok(x[at].clone()))?;
            if arithmetic.is_zero(&entry) {
                continue;
            }
            // {x_i, x_j} may have a factor that stands below in ∂H, as x in x·∂(ln x): nothing is divided by it.
            rows[i].push((one.clone(), arithmetic.multiply_reduced(&entry, &v[j])));
            rows[j].push((-&one, arithmetic.multiply_reduced(&entry, &v[i])));
        }
        Ok(rows
            .into_iter()
            .map(|row| arithmetic.combine(&row))
            .collect())
    }

    /// dH + η at x, given dH there; in any algebra.
    ///
    /// # Errors
    /// [`AlgebraError`] where a formula has no value.
    fn with_forces_added<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        x: &[A::Element],
        gradient: Vec<A::Element>,
    ) -> Result<Vec<A::Element>, AlgebraError> {
        let forces = self.forces();
        if forces.is_empty() {
            return Ok(gradient);
        }
        let one = Rational::one();
        let mut sums: Vec<Vec<(Rational, A::Element)>> = (gradient.iter())
            .map(|slope| vec![(one.clone(), slope.clone())])
            .collect();
        for (sum, force) in sums.iter_mut().zip(&forces.one_form) {
            let force = force.evaluate_in(arithmetic, &mut |_, at| Ok(x[at].clone()))?;
            sum.push((one.clone(), force));
        }
        if let Some(damping) = &forces.damping {
            let rate = &damping.rate;
            let rate = rate.evaluate_in(arithmetic, &mut |_, at| Ok(x[at].clone()))?;
            // −ẋ_H.
            let rows = self.apply_tensor(arithmetic, x, &gradient)?;
            for (i, j, entry) in damping.metric.entries() {
                let entry = entry.evaluate_in(arithmetic, &mut |_, at| Ok(x[at].clone()))?;
                if arithmetic.is_zero(&entry) {
                    continue;
                }
                let factor = arithmetic.multiply(&rate, &entry);
                sums[i].push((-&one, arithmetic.multiply(&factor, &rows[j])));
            }
        }
        Ok(sums.iter().map(|sum| arithmetic.combine(sum)).collect())
    }

    /// −ẋ = Π(dH + η) − f at x, given dH there; in any algebra.
    ///
    /// # Errors
    /// [`AlgebraError`] where a formula has no value.
    pub fn motion_reversed<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        x: &[A::Element],
        gradient: Vec<A::Element>,
    ) -> Result<Vec<A::Element>, AlgebraError> {
        let one_form = self.with_forces_added(arithmetic, x, gradient)?;
        let mut reversed = self.apply_tensor(arithmetic, x, &one_form)?;
        let one = Rational::one();
        for (own, friction) in reversed.iter_mut().zip(&self.forces().friction) {
            let friction = friction.evaluate_in(arithmetic, &mut |_, at| Ok(x[at].clone()))?;
            *own = arithmetic.combine(&[(one.clone(), own.clone()), (-&one, friction)]);
        }
        Ok(reversed)
    }

    /// The kernel x ↦ (f₁(x), …) of any formulas of this system.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula has no code.
    pub fn observable_kernel(&self, formulas: &[&Expression]) -> Result<Kernel, BuildError> {
        kernel(formulas, self.dimension(), self.parameters.len())
    }

    /// ∇H(x) as code; `x` are the graph's first inputs.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where H or its derivative has no code.
    pub fn gradient(&self, graph: &mut Graph, x: &[Term]) -> Result<Vec<Term>, BuildError> {
        let energy = self
            .hamiltonian
            .evaluate_in(graph, &mut |_, at| Ok(x[at].clone()))?;
        let mut gradient = Vec::with_capacity(x.len());
        for i in 0..x.len() {
            gradient.push(graph.derivative(&energy, i)?);
        }
        Ok(gradient)
    }

    /// ∇H at any `x` of the graph.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where H or its derivative has no code.
    pub fn gradient_at(&self, graph: &mut Graph, x: &[Term]) -> Result<Vec<Term>, BuildError> {
        let mut own = Graph::new();
        let inputs: Vec<Term> = (0..x.len()).map(|i| own.input(i)).collect();
        let gradient = self.gradient(&mut own, &inputs)?;
        Ok(graph.import(&own, &gradient, x)?)
    }

    /// (dH + η)(x) as code, the one-form that moves the system; `x` are the graph's first inputs.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or its derivative has no code.
    pub fn one_form(&self, graph: &mut Graph, x: &[Term]) -> Result<Vec<Term>, BuildError> {
        let gradient = self.gradient(graph, x)?;
        Ok(self.with_forces_added(graph, x, gradient)?)
    }

    /// Field ẋ = −Π(x)(dH + η)(x) + f(x) as code, X_H where there are no forces. The terms `x` are the graph's first inputs.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or its derivative has no code.
    pub fn vector_field(&self, graph: &mut Graph, x: &[Term]) -> Result<Vec<Term>, BuildError> {
        let gradient = self.gradient(graph, x)?;
        let field = self.motion_reversed(graph, x, gradient)?;
        Ok(field.iter().map(|f| graph.negate(f)).collect())
    }

    /// The kernel of the [field](Self::vector_field).
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or its derivative has no code.
    pub fn vector_field_kernel(&self) -> Result<Kernel, BuildError> {
        let mut graph = Graph::new();
        let x: Vec<Term> = (0..self.dimension()).map(|i| graph.input(i)).collect();
        let field = self.vector_field(&mut graph, &x)?;
        Ok(Kernel::compile(
            &graph,
            &field,
            self.parameters.len(),
            x.len(),
        ))
    }
}
