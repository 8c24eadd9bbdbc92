//! Poisson tensors by forms: Π = −(dϑ)⁻¹, Π = −ω⁻¹ of a closed ω, and Dirac's bracket.
//!
//! With (dϑ)_ij = ∂_i ϑ_j − ∂_j ϑ_i the motion ẋ = −Π ∇H is that of the action ∫ ϑ·dx − H dt:
//! dϑ ẋ = ∇H. Of ϑ = p dq it is q' = ∂H/∂p, p' = −∂H/∂q.
//!
//! Dirac's bracket of second-class constraints φ_a, with C_ab = {φ_a, φ_b}, is {f, g} − Σ {f, φ_a} (C⁻¹)_ab {φ_b, g}.
//! It satisfies Jacobi's identity where {·,·} does, and every φ_a is a Casimir of it (P. A. M. Dirac, *Lectures on
//! Quantum Mechanics*, Yeshiva University, 1964, lecture 1; J. E. Marsden, T. S. Ratiu, *Introduction to Mechanics and
//! Symmetry*, second edition, section 8.5).
//!
//! Inverses are adjugates over Pfaffians (`pfaffian`), formed twice: in the exact ring, which tells
//! what vanishes and where quotients end, and as code, which expands nothing. The shorter one is taken.

use std::collections::BTreeMap;

use leafwise_expression::bounded::BoundedNumbers;
use leafwise_expression::graph::lift;
use leafwise_expression::{
    AlgebraError, Arithmetic, DifferentialAlgebra, Expression, Graph, Kernel, Polynomial, Rational,
    Ring, Term,
};
use thiserror::Error;

use super::formulas::{SystemFormulas, TensorSource};
use super::pfaffian::{Antisymmetric, Inverse};
use super::{Agreement, Casimir};

/// Why a form makes no tensor.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FormError {
    /// As many components of a one-form as there are variables.
    #[error(
        "a one-form over {dimension} variables has {dimension} components, and this one has {found}"
    )]
    Components {
        /// The number of variables.
        dimension: usize,
        /// The number of components.
        found: usize,
    },
    /// An antisymmetric matrix of odd size has no inverse.
    #[error(
        "a two-form over {dimension} variables has no inverse: an odd number of them leaves one direction at rest"
    )]
    OddDimension {
        /// The number of variables.
        dimension: usize,
    },
    /// A two-form whose Pfaffian is 0 everywhere.
    #[error("the two-form has no inverse anywhere: its Pfaffian is identically 0")]
    Degenerate,
    /// A matrix that has no inverse at the state about which the system moves.
    #[error(
        "{what} has no inverse at this state: its Pfaffian is {pfaffian:e} there, and its determinant is the square of that"
    )]
    DegenerateAt {
        /// The two-form, or the matrix of the constraints' brackets.
        what: &'static str,
        /// Its value.
        pfaffian: f64,
        /// The state.
        at: Vec<f64>,
    },
    /// A two-form that is not closed.
    #[error(
        "the two-form is not closed: its derivative dω has a component that is {value:e} and not 0"
    )]
    NotClosed {
        /// The variables i < j < k of the component ∂_i ω_jk + ∂_j ω_ki + ∂_k ω_ij.
        triple: [usize; 3],
        /// Its value, NaN where no state near by has one.
        value: f64,
        /// The state.
        at: Vec<f64>,
    },
    /// Constraints whose brackets with each other have no inverse, as those of an odd number have not.
    #[error(
        "the constraints are not of second class: the matrix of their brackets has no inverse anywhere"
    )]
    FirstClass {
        /// A constraint whose brackets with all of them vanish, where there is one.
        constraint: Option<usize>,
        /// How many there are.
        count: usize,
    },
    /// A formula that has no derivative, or an inverse that is too long.
    #[error("{0}")]
    Algebra(#[from] AlgebraError),
}

/// The most products of terms for an inverse in the ring: about a second's.
const MOST_PRODUCTS: u64 = 1 << 22;

/// Differences within so many bounds are round-off.
const WITHIN: f64 = 4.0;

/// Name of a Pfaffian in messages, where a step crosses its zero.
const OF_FORM: &str = "the Pfaffian of the two-form";
const OF_CONSTRAINTS: &str = "the Pfaffian of the constraints' brackets";

/// Entries above the diagonal.
type Entries<E> = BTreeMap<(usize, usize), E>;

/// A component of a three-form along three variables.
type Component<E> = ([usize; 3], E);

/// A tensor and the Pfaffian it is divided by, in one algebra.
struct Made<E> {
    entries: Entries<E>,
    pfaffian: E,
}

impl SystemFormulas {
    /// The same system with Π = −(dϑ)⁻¹, whatever its convention.
    ///
    /// # Errors
    /// [`FormError`] where ϑ has the wrong number of components or dϑ no inverse.
    pub fn with_one_form(self, form: &[Expression]) -> Result<Self, FormError> {
        let dimension = self.dimension();
        if form.len() != dimension {
            return Err(FormError::Components {
                dimension,
                found: form.len(),
            });
        }
        let mut graph = Graph::compilable();
        let mut ring = Ring::limited(dimension, MOST_PRODUCTS);
        let code = exterior(&mut graph, form)?;
        let exact = unless_long(exterior(&mut ring, form), &ring)?;
        let form = self.shorter(&mut graph, code, exact.map(|exact| (&ring, exact)))?;
        let form = formulas(&graph, form)?;
        self.inverse_of(&form, TensorSource::OneForm)
    }

    /// The same system with Π = −ω⁻¹, whatever its convention; `form` holds ω_ij for i < j, absent entries
    /// being 0. With ω = dϑ it is the system of [`with_one_form`](Self::with_one_form).
    ///
    /// # Errors
    /// [`FormError`] where ω is not closed or has no inverse.
    pub fn with_two_form(self, form: &Entries<Expression>) -> Result<Self, FormError> {
        let is_proved = self.check_closed(form)?;
        self.inverse_of(form, TensorSource::TwoForm { is_proved })
    }

    /// The same system with Dirac's bracket of these constraints, its further Casimirs.
    ///
    /// # Errors
    /// [`FormError`] where the matrix of their brackets has no inverse.
    pub fn with_constraints(self, constraints: Vec<Casimir>) -> Result<Self, FormError> {
        if constraints.is_empty() {
            return Ok(self);
        }
        let mut graph = Graph::compilable();
        let mut ring = Ring::limited(self.dimension(), MOST_PRODUCTS);
        let code = dirac(&mut graph, &self, &constraints)?;
        let exact = unless_long(dirac(&mut ring, &self, &constraints), &ring)?;
        let of_second_class = |constraint| FormError::FirstClass {
            constraint,
            count: constraints.len(),
        };
        let code = code.map_err(of_second_class)?;
        let exact = exact.transpose().map_err(of_second_class)?;
        let source = TensorSource::Dirac(Box::new(self.clone()));
        self.made(graph, &ring, (code, exact), source, OF_CONSTRAINTS)
            .map(|system| system.with_casimirs(constraints))
    }

    /// −ω⁻¹.
    fn inverse_of(
        self,
        form: &Entries<Expression>,
        source: TensorSource,
    ) -> Result<Self, FormError> {
        let dimension = self.dimension();
        if dimension % 2 == 1 {
            return Err(FormError::OddDimension { dimension });
        }
        let mut graph = Graph::compilable();
        let mut ring = Ring::limited(dimension, MOST_PRODUCTS);
        let exact = unless_long(inverted(&mut ring, form, dimension), &ring)?;
        if let Some(None) = exact {
            return Err(FormError::Degenerate);
        }
        let code = inverted(&mut graph, form, dimension)?.ok_or(FormError::Degenerate)?;
        self.made(graph, &ring, (code, exact.flatten()), source, OF_FORM)
    }

    /// The system with this tensor, by the shorter of its two forms.
    fn made(
        self,
        mut graph: Graph,
        ring: &Ring,
        (code, exact): (Made<Term>, Option<Made<Polynomial>>),
        source: TensorSource,
        pfaffian: &'static str,
    ) -> Result<Self, FormError> {
        self.check_inverse(&graph, &code.pfaffian, &source)?;
        let exact = exact.map(|exact| (ring, exact.entries));
        let entries = self.shorter(&mut graph, code.entries, exact)?;
        let tensor = formulas(&graph, entries)?;
        let named = formulas(&graph, BTreeMap::from([((0, 0), code.pfaffian)]))?;
        let named = named.into_values();
        let named = named.map(|formula| (pfaffian.to_owned(), formula));
        Ok(self.with_tensor(tensor, source).with_names(named))
    }

    /// Shorter form of the same entries, code or elements of the ring. Those that the ring knows to be 0 are left out.
    /// The ring's elements are taken where they are shorter and no less accurate.
    fn shorter(
        &self,
        graph: &mut Graph,
        mut code: Entries<Term>,
        exact: Option<(&Ring, Entries<Polynomial>)>,
    ) -> Result<Entries<Term>, FormError> {
        let Some((ring, mut exact)) = exact else {
            return Ok(code);
        };
        exact.retain(|_, entry| !entry.is_zero());
        code.retain(|at, _| exact.contains_key(at));
        exact.retain(|at, _| code.contains_key(at));
        let one = graph.one();
        let outputs: Vec<_> = exact
            .into_values()
            .map(|f| vec![(one.clone(), f)])
            .collect();
        let d = self.dimension();
        let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
        let lifted = lift(graph, ring, &outputs, &x)?;
        graph.unless_refused(())?;
        let expected: Vec<Term> = code.values().cloned().collect();
        let operations = |terms: &[Term]| {
            let kernel = Kernel::compile(graph, terms, self.parameters().len(), d);
            kernel.step_operations().work()
        };
        let is_shorter = operations(&lifted) < operations(&expected);
        if is_shorter && self.agreement(graph, &lifted, &expected) == Agreement::Same {
            return Ok(code.into_keys().zip(lifted).collect());
        }
        Ok(code)
    }

    /// Refuses a Pfaffian that is 0 to round-off at the state about which the system moves.
    fn check_inverse(
        &self,
        graph: &Graph,
        pfaffian: &Term,
        source: &TensorSource,
    ) -> Result<(), FormError> {
        let mut numbers = BoundedNumbers {
            parameters: self.parameter_values(),
        };
        let values = numbers.values(graph, std::slice::from_ref(pfaffian), self.near())?;
        let [value] = values.as_slice() else {
            unreachable!("one value a term")
        };
        let is_away_from_0 = value.value.abs() > WITHIN * value.error;
        if is_away_from_0 && value.value.is_finite() {
            return Ok(());
        }
        Err(FormError::DegenerateAt {
            what: match source {
                TensorSource::Dirac(_) => "the matrix of the constraints' brackets",
                _ => "the two-form",
            },
            pfaffian: value.value,
            at: self.near().to_vec(),
        })
    }

    /// dω = 0: whether it is proved, or holds to round-off about the state about which the system moves.
    fn check_closed(&self, form: &Entries<Expression>) -> Result<bool, FormError> {
        let d = self.dimension();
        let mut ring = Ring::limited(d, MOST_PRODUCTS);
        let exact = unless_long(derivative(&mut ring, form, d), &ring)?;
        let is_open = |(_, sum): &(_, Polynomial)| !sum.is_zero();
        let open: Option<Vec<[usize; 3]>> = exact.map(|sums| {
            sums.into_iter()
                .filter(is_open)
                .map(|(triple, _)| triple)
                .collect()
        });
        if open.as_ref().is_some_and(Vec::is_empty) {
            return Ok(true);
        }
        let mut graph = Graph::compilable();
        let mut sums = derivative(&mut graph, form, d)?;
        graph.unless_refused(())?;
        sums.retain(|(triple, _)| open.as_ref().is_none_or(|open| open.contains(triple)));
        let terms: Vec<Term> = sums.iter().map(|(_, sum)| sum.clone()).collect();
        let mut numbers = BoundedNumbers {
            parameters: self.parameter_values(),
        };
        let mut has_value = vec![false; sums.len()];
        let mut worst: Option<(f64, usize, Vec<f64>)> = None;
        for x in self.points() {
            let Ok(values) = numbers.values(&graph, &terms, &x) else {
                continue;
            };
            for (which, sum) in values.iter().enumerate() {
                let is_known = sum.value.is_finite() && sum.error.is_finite();
                has_value[which] |= is_known;
                let is_larger = worst.as_ref().is_none_or(|w| sum.value.abs() > w.0.abs());
                if is_known && sum.value.abs() > WITHIN * sum.error && is_larger {
                    worst = Some((sum.value, which, x.clone()));
                }
            }
        }
        let unknown = has_value.iter().position(|has| !has);
        let unknown = unknown.map(|which| (f64::NAN, which, self.near().to_vec()));
        match worst.or(unknown) {
            None => Ok(false),
            Some((value, which, at)) => Err(FormError::NotClosed {
                triple: sums[which].0,
                value,
                at,
            }),
        }
    }
}

/// `None` for a computation of the ring that grew too long, or that it has no normal form for.
fn unless_long<T>(made: Result<T, FormError>, ring: &Ring) -> Result<Option<T>, FormError> {
    match made {
        _ if ring.refusal().is_some() => Ok(None),
        Err(FormError::Algebra(
            AlgebraError::ExpansionTooLong | AlgebraError::ExpandedExponent,
        )) => Ok(None),
        made => made.map(Some),
    }
}

fn formulas(graph: &Graph, entries: Entries<Term>) -> Result<Entries<Expression>, FormError> {
    graph.unless_refused(())?;
    let terms: Vec<Term> = entries.values().cloned().collect();
    let formulas = graph
        .shared_formulas(&terms)
        .ok_or(AlgebraError::NoSeries)?;
    Ok(entries.into_keys().zip(formulas).collect())
}

fn value<A: DifferentialAlgebra>(
    algebra: &mut A,
    formula: &Expression,
) -> Result<A::Element, AlgebraError> {
    formula.evaluate_in(algebra, &mut |algebra: &mut A, at| {
        Ok(algebra.coordinate(at))
    })
}

/// (dϑ)_ij = ∂_i ϑ_j − ∂_j ϑ_i.
fn exterior<A: DifferentialAlgebra>(
    algebra: &mut A,
    form: &[Expression],
) -> Result<Entries<A::Element>, FormError> {
    let d = form.len();
    let mut gradients = Vec::with_capacity(d);
    for component in form {
        let component = value(algebra, component)?;
        gradients.push(algebra.differential(&component, d)?);
    }
    let mut entries = BTreeMap::new();
    for i in 0..d {
        for j in i + 1..d {
            let entry = algebra.subtract(&gradients[j][i], &gradients[i][j]);
            if !algebra.is_zero(&entry) {
                entries.insert((i, j), entry);
            }
        }
    }
    Ok(entries)
}

/// −ω⁻¹; `None` where the Pfaffian is recognized as 0.
fn inverted<A: DifferentialAlgebra>(
    algebra: &mut A,
    form: &Entries<Expression>,
    size: usize,
) -> Result<Option<Made<A::Element>>, FormError> {
    let mut above = BTreeMap::new();
    for (at, entry) in form {
        let entry = value(algebra, entry)?;
        if !algebra.is_zero(&entry) {
            above.insert(*at, entry);
        }
    }
    let Some(Inverse { pfaffian, above }) = Antisymmetric { size, above }.inverse(algebra)? else {
        return Ok(None);
    };
    let minus = algebra.constant(&-Rational::one());
    let factor = algebra.divide(&minus, &pfaffian)?;
    let entries = above.into_iter();
    let entries = entries.map(|(at, entry)| (at, algebra.multiply(&entry, &factor)));
    let entries = entries.collect();
    Ok(Some(Made { entries, pfaffian }))
}

/// (dω)_ijk = ∂_i ω_jk + ∂_j ω_ki + ∂_k ω_ij for i < j < k, the components that are recognized as 0 left out.
fn derivative<A: DifferentialAlgebra>(
    algebra: &mut A,
    form: &Entries<Expression>,
    d: usize,
) -> Result<Vec<Component<A::Element>>, FormError> {
    let mut sums: BTreeMap<[usize; 3], Vec<(Rational, A::Element)>> = BTreeMap::new();
    for (&(j, k), entry) in form {
        let entry = value(algebra, entry)?;
        let gradient = algebra.differential(&entry, d)?;
        for (i, partial) in gradient.into_iter().enumerate() {
            if i == j || i == k || algebra.is_zero(&partial) {
                continue;
            }
            // The permutation that sorts i, j, k, of which j < k, is odd where i stands between them.
            let is_between = j < i && i < k;
            let sign = Rational::from_integer(if is_between { -1 } else { 1 });
            let mut triple = [i, j, k];
            triple.sort_unstable();
            sums.entry(triple).or_default().push((sign, partial));
        }
    }
    let sums = sums.into_iter();
    let sums = sums.map(|(triple, terms)| (triple, algebra.combine(&terms)));
    let sums: Vec<_> = sums.collect();
    Ok(sums
        .into_iter()
        .filter(|(_, sum)| !algebra.is_zero(sum))
        .collect())
}

/// Dirac's tensor, or, where the constraints' brackets have no inverse, the constraint whose brackets vanish, if
/// there is one.
type Brackets<E> = Result<Made<E>, Option<usize>>;

/// Π_ij + Σ_ab V_ai (C⁻¹)_ab V_bj with V_ai = {x_i, φ_a}.
fn dirac<A: DifferentialAlgebra>(
    algebra: &mut A,
    system: &SystemFormulas,
    constraints: &[Casimir],
) -> Result<Brackets<A::Element>, FormError> {
    let (d, size) = (system.dimension(), constraints.len());
    let x: Vec<A::Element> = (0..d).map(|at| algebra.coordinate(at)).collect();
    let (mut gradients, mut fields) = (Vec::with_capacity(size), Vec::with_capacity(size));
    for constraint in constraints {
        let constraint = value(algebra, &constraint.expression)?;
        let gradient = algebra.differential(&constraint, d)?;
        fields.push(system.apply_tensor(algebra, &x, &gradient)?);
        gradients.push(gradient);
    }
    let mut above = BTreeMap::new();
    for a in 0..size {
        for b in a + 1..size {
            let pairs = gradients[a].iter().zip(&fields[b]);
            let products: Vec<_> = pairs.map(|(g, v)| (Rational::one(), g, v)).collect();
            let bracket = algebra.sum_of_products(&products);
            if !algebra.is_zero(&bracket) {
                above.insert((a, b), bracket);
            }
        }
    }
    let matrix = Antisymmetric { size, above };
    let Some(Inverse { pfaffian, above }) = matrix.inverse(algebra)? else {
        let is_alone = |a: &usize| !matrix.above.keys().any(|(i, j)| i == a || j == a);
        let constraint = (0..size).find(is_alone);
        return Ok(Err(constraint));
    };
    let one = algebra.one();
    let factor = algebra.divide(&one, &pfaffian)?;
    let inverse: Vec<_> = above
        .into_iter()
        .map(|(at, entry)| (at, algebra.multiply(&entry, &factor)))
        .collect();
    let mut entries = BTreeMap::new();
    for i in 0..d {
        for j in i + 1..d {
            let mut terms = Vec::new();
            if let Some(entry) = system.tensor().get(&(i, j)) {
                terms.push((Rational::one(), value(algebra, entry)?));
            }
            for ((a, b), inverse) in &inverse {
                let minus = -Rational::one();
                let minor = algebra.sum_of_products(&[
                    (Rational::one(), &fields[*a][i], &fields[*b][j]),
                    (minus, &fields[*b][i], &fields[*a][j]),
                ]);
                terms.push((Rational::one(), algebra.multiply(inverse, &minor)));
            }
            let entry = algebra.combine(&terms);
            if !algebra.is_zero(&entry) {
                entries.insert((i, j), entry);
            }
        }
    }
    Ok(Ok(Made { entries, pfaffian }))
}
