//! Realizations by a closed form: α is written once, for every algebra.
//!
//! In a cotangent chart about σ(x) = (x, 0) realization data is one map, α_ε(x, p): where (x, p) ↦ (x, −p) is the
//! inverse, β_ε(x, p) = α_ε(x, −p). The same lines give straight-line code, sweeps over a lattice and the
//! series of α along p(h), from which Hamilton–Jacobi coefficients are computed (paper, Example 1 and section 4).

use leafwise_expression::graph::lift;
use leafwise_expression::series::{Tape, TapeIndex, TaylorState};
use leafwise_expression::{
    AlgebraError, Arithmetic, DifferentialAlgebra, Graph, Polynomial, Ring, Term,
};

use crate::error::BuildError;
use crate::lattice::{StageBuilder, StageCode, StageEnds};
use crate::realization::{
    Abilities, Accuracy, EndMaps, MapCode, RealizationData, SourceRecursion, SourceSeries,
    SourceTarget,
};

/// A point of the chart, in the algebra of its elements.
#[derive(Debug)]
pub struct ChartPoint<'a, E> {
    /// The form's functions of x.
    pub functions: &'a [E],
    /// ε.
    pub epsilon: &'a E,
    /// x, d elements.
    pub x: &'a [E],
    /// p, d elements.
    pub p: &'a [E],
}

/// α_ε: T*M ⊃ U → M in closed form, with σ(x) = (x, 0).
pub trait ClosedForm: Send + Sync + std::fmt::Debug + 'static {
    /// d, the dimension of M.
    fn dimension(&self) -> usize;
    /// Functions of x and of the parameters that α is formed with, in normal form. Example: of {x₁, x₂} = λ x₃ the
    /// factor λ.
    ///
    /// # Errors
    /// [`BuildError`] where one has no normal form.
    fn functions(&self, ring: &mut Ring) -> Result<Vec<Polynomial>, BuildError> {
        let _ = ring;
        Ok(Vec::new())
    }
    /// α_ε(x, p), d elements.
    ///
    /// # Errors
    /// [`AlgebraError`] where an operation has no value.
    fn source<A: Arithmetic>(
        &self,
        algebra: &mut A,
        at: &ChartPoint<'_, A::Element>,
    ) -> Result<Vec<A::Element>, AlgebraError>;
    /// Offset β − x and increment α − β as code. By default β(x, p) = α(x, −p) and x [drops out](StageEnds::between) of
    /// sums. A form in which x stands in a product writes the differences itself. So does one whose parts odd and even in p both ends share.
    ///
    /// # Errors
    /// [`AlgebraError`] where an operation has no value.
    fn ends(
        &self,
        graph: &mut Graph,
        at: &ChartPoint<'_, Term>,
    ) -> Result<StageEnds, AlgebraError> {
        let alpha = self.source(graph, at)?;
        let minus: Vec<Term> = at.p.iter().map(|p| graph.negate(p)).collect();
        let beta = self.source(graph, &ChartPoint { p: &minus, ..*at })?;
        Ok(StageEnds::between(graph, at.x, &alpha, &beta))
    }
    /// The chart's radius and how far a point reaches in it, as [`SourceTarget::guard`].
    ///
    /// # Errors
    /// [`AlgebraError`] where an operation has no value.
    #[expect(clippy::type_complexity, reason = "the pair of SourceTarget::guard")]
    fn guard(
        &self,
        graph: &mut Graph,
        at: &ChartPoint<'_, Term>,
    ) -> Result<Option<(Vec<Term>, Vec<Term>)>, AlgebraError> {
        let _ = (graph, at);
        Ok(None)
    }
    /// Accuracy and symmetries: those of an exact form by default.
    fn properties(&self) -> FormProperties {
        FormProperties::default()
    }
}

/// Properties of a [`ClosedForm`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FormProperties {
    /// Exact, or the order of the truncation.
    pub accuracy: Accuracy,
    /// Whether β(x, p) = α(x, −p).
    pub is_reversible: bool,
    /// Whether α_ε(x, p) = α_1(x, εp), so that one series serves every ε.
    pub has_series: bool,
}

impl Default for FormProperties {
    fn default() -> Self {
        Self {
            accuracy: Accuracy::Exact,
            is_reversible: true,
            has_series: true,
        }
    }
}

/// The realization data (T*M ⊃ U, ω, α_ε, β_ε, σ) of a closed form.
#[derive(Clone, Debug)]
pub struct ClosedRealization<F> {
    name: &'static str,
    form: F,
    ring: Ring,
    functions: Vec<Polynomial>,
}

impl<F: ClosedForm> ClosedRealization<F> {
    /// The realization that the part of this name gives.
    ///
    /// # Errors
    /// Those of [`ClosedForm::functions`].
    pub fn new(name: &'static str, form: F) -> Result<Self, BuildError> {
        let mut ring = Ring::new(form.dimension());
        Ok(Self {
            functions: form.functions(&mut ring)?,
            name,
            form,
            ring,
        })
    }

    /// The functions of x as code.
    fn functions(&self, graph: &mut Graph, x: &[Term]) -> Result<Vec<Term>, AlgebraError> {
        let one = graph.one();
        let functions = self.functions.iter();
        let outputs: Vec<_> = functions.map(|f| vec![(one.clone(), f.clone())]).collect();
        lift(graph, &self.ring, &outputs, x)
    }
}

impl<F: ClosedForm> RealizationData for ClosedRealization<F> {
    fn dimension(&self) -> usize {
        self.form.dimension()
    }

    fn accuracy(&self) -> Accuracy {
        self.form.properties().accuracy
    }

    fn describe(&self) -> String {
        match self.accuracy() {
            Accuracy::Exact => self.name.to_owned(),
            Accuracy::Order(n) => format!("{} n = {n}", self.name),
        }
    }

    /// One stage on a lattice: α reads x and p at neighbouring sites.
    fn abilities(&self) -> Abilities<'_> {
        let ends: MapCode<'_> = Box::new(|graph, epsilon, z| {
            let (x, p) = z.split_at(self.form.dimension());
            let at = ChartPoint {
                functions: &self.functions(graph, x)?,
                epsilon,
                x,
                p,
            };
            let StageEnds { offset, increment } = self.form.ends(graph, &at)?;
            Ok(SourceTarget {
                base: x.to_vec(),
                offset,
                increment,
                guard: self.form.guard(graph, &at)?,
            })
        });
        let stages: StageCode<'_> = Box::new(|builder: &mut StageBuilder, epsilon, y, p| {
            let graph = &mut builder.graph;
            let at = ChartPoint {
                functions: &self.functions(graph, y)?,
                epsilon,
                x: y,
                p,
            };
            Ok(self.form.ends(graph, &at)?)
        });
        let FormProperties {
            is_reversible,
            has_series,
            ..
        } = self.form.properties();
        Abilities {
            is_reversible,
            ends: Some(EndMaps::Code(ends)),
            stages: Some(stages),
            series: (is_reversible && has_series).then(|| SourceSeries {
                in_ring: Box::new(|ring, coordinates| self.start(ring, coordinates)),
                in_graph: Box::new(|graph, coordinates| self.start(graph, coordinates)),
            }),
            ..Abilities::default()
        }
    }
}

impl<F: ClosedForm> ClosedRealization<F> {
    /// [hᵏ] α_1(x, Σ_{k≥1} pₖ hᵏ), one order after the other.
    fn start<A: DifferentialAlgebra>(
        &self,
        algebra: &mut A,
        coordinates: &[usize],
    ) -> Result<SourceRecursion<A>, BuildError> {
        let d = self.form.dimension();
        let x = coordinates.iter().map(|at| algebra.coordinate(*at));
        let mut constants: Vec<A::Element> = x.collect();
        constants.resize(2 * d, algebra.zero());
        constants.extend(algebra.formed(coordinates, |ring| self.form.functions(ring))?);
        let mut tape = Tape::new();
        let variables: Vec<TapeIndex> = (0..constants.len()).map(|at| tape.variable(at)).collect();
        let one = tape.one();
        let at = ChartPoint {
            functions: &variables[2 * d..],
            epsilon: &one,
            x: &variables[..d],
            p: &variables[d..2 * d],
        };
        let alpha = self.form.source(&mut tape, &at)?;
        let mut state = TaylorState::new(&tape);
        state.extend(&tape, algebra, |_, index| constants[index].clone())?;
        let (momenta, mut order) = (d..2 * d, 0);
        Ok(Box::new(move |algebra, p| {
            state.extend(&tape, algebra, |algebra, index| {
                match momenta.contains(&index) {
                    true => p[index - momenta.start].clone(),
                    false => algebra.zero(),
                }
            })?;
            order += 1;
            let coefficient = |index: &TapeIndex| state.coefficient(*index, order).clone();
            Ok(alpha.iter().map(coefficient).collect())
        }))
    }
}
