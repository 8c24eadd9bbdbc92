//! A Hamiltonian with an exact flow.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use leafwise_expression::{
    AlgebraError, Arithmetic, Expression, Graph, Polynomial, Rational, Ring, Term,
};

use crate::body::FreeBody;
use crate::field::Field;
use crate::flow::{CoordinateFlow, Motion, coordinate_flow};
use crate::kepler::KeplerMotions;
use crate::probe::Probe;
use crate::turning::{TurningPair, TurningPairs};

/// The part's name.
pub(crate) const NAME: &str = "splitting";

/// A term of the Hamiltonian with its field.
pub(crate) struct Atom {
    pub(crate) hamiltonian: Polynomial,
    /// The same as it is written.
    pub(crate) formula: Expression,
    pub(crate) field: Field,
    /// The two vectors that it turns, where no motion of a coordinate is one of [`Motion`].
    pub(crate) turning: Option<TurningPair>,
}

impl Atom {
    /// Whether it has an exact flow; the coordinate whose motion is none of [`Motion`] otherwise.
    pub(crate) fn flows(
        &self,
        ring: &mut Ring,
        probe: &Probe,
    ) -> Result<Result<(), usize>, AlgebraError> {
        for &index in self.field.keys() {
            if coordinate_flow(ring, probe, &self.field, index)?.is_none() {
                return Ok(Err(index));
            }
        }
        Ok(Ok(()))
    }
}

/// Dx_i, D²x_i, … of each coordinate under a piece, as code of the formulas: nothing is expanded.
#[derive(Clone, Debug)]
pub(crate) struct LieSeries {
    /// The code; its inputs are the coordinates.
    pub(crate) graph: Graph,
    /// As many terms as the coordinate's motion is made of.
    pub(crate) terms: Vec<Vec<Term>>,
}

/// A motion with a flow as a whole, in the place of motions of coordinates.
#[derive(Clone, Debug)]
pub(crate) enum WholeMotion {
    /// A free rigid body.
    Body(FreeBody),
    /// Bodies about centres.
    Kepler(KeplerMotions),
    /// Pairs of vectors.
    Turning(TurningPairs),
}

impl WholeMotion {
    /// x(t) − x from the state `x` over the time `time`.
    ///
    /// # Errors
    /// [`AlgebraError`] where a parameter's function has no code.
    pub(crate) fn increment(
        &self,
        graph: &mut Graph,
        ring: &Ring,
        time: &Term,
        x: &[Term],
    ) -> Result<Vec<Term>, AlgebraError> {
        match self {
            Self::Body(body) => body.increment(graph, ring, time, x),
            Self::Kepler(bodies) => bodies.increment(graph, ring, time, x),
            Self::Turning(pairs) => pairs.increment(graph, ring, time, x),
        }
    }

    /// ẋ at the state `x`.
    ///
    /// # Errors
    /// [`AlgebraError`] where a parameter's function has no code.
    pub(crate) fn field(
        &self,
        graph: &mut Graph,
        ring: &Ring,
        x: &[Term],
    ) -> Result<Vec<Term>, AlgebraError> {
        match self {
            Self::Body(body) => body.field(graph, ring, x),
            Self::Kepler(bodies) => bodies.field(graph, ring, x),
            Self::Turning(pairs) => pairs.field(graph, ring, x),
        }
    }
}

/// A Hamiltonian K, its field X_K and the flow of X_K, coordinate by coordinate.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The terms of K.
    terms: Vec<Polynomial>,
    /// The same as they are written.
    formulas: Vec<Expression>,
    field: Field,
    flows: Vec<CoordinateFlow>,
    /// The Lie series computed from the formulas, where their expansions cancel.
    code: Option<Arc<LieSeries>>,
    /// The motion whose flow it is, in the place of motions of coordinates.
    whole: Option<Arc<WholeMotion>>,
}

impl Piece {
    /// K = 0 in dimension d.
    pub(crate) fn empty(dimension: usize) -> Self {
        let still = |index| CoordinateFlow {
            motion: Motion::Polynomial(Vec::new()),
            reads: BTreeSet::from([index]),
        };
        Self {
            terms: Vec::new(),
            formulas: Vec::new(),
            code: None,
            whole: None,
            field: Field::new(),
            flows: (0..dimension).map(still).collect(),
        }
    }

    /// A motion as a whole with its energy K.
    pub(crate) fn of_whole(motion: WholeMotion, atom: Atom) -> Self {
        Self {
            terms: vec![atom.hamiltonian],
            formulas: vec![atom.formula],
            field: atom.field,
            flows: Vec::new(),
            code: None,
            whole: Some(Arc::new(motion)),
        }
    }

    /// K.
    pub fn hamiltonian(&self, ring: &mut Ring) -> Polynomial {
        let terms = self.terms.iter();
        let terms: Vec<_> = terms.map(|term| (Rational::one(), term.clone())).collect();
        ring.combine(&terms)
    }

    /// X_K, the components that are not zero.
    pub(crate) fn field(&self) -> &Field {
        &self.field
    }

    /// The terms of K as they are written.
    pub(crate) fn formulas(&self) -> &[Expression] {
        &self.formulas
    }

    /// The motions, with what they were concluded from.
    pub(crate) fn flows(&self) -> &[CoordinateFlow] {
        &self.flows
    }

    /// The Lie series that the flow is computed from in the place of the motions', which are polynomial.
    pub(crate) fn code(&self) -> Option<&LieSeries> {
        self.code.as_deref()
    }

    /// The same flow computed from its Lie series as code; `None` where a motion is not polynomial in
    /// time.
    pub(crate) fn computed_by(self, series: LieSeries) -> Option<Self> {
        let is_polynomial = |motion: &Motion| matches!(motion, Motion::Polynomial(_));
        let all = self.motions().all(is_polynomial);
        all.then(|| Self {
            code: Some(Arc::new(series)),
            ..self
        })
    }

    /// The motion as a whole, if it is one.
    pub(crate) fn whole(&self) -> Option<&WholeMotion> {
        self.whole.as_deref()
    }

    /// The motion of each coordinate; none of a motion as a whole.
    pub fn motions(&self) -> impl Iterator<Item = &Motion> {
        self.flows.iter().map(|flow| &flow.motion)
    }

    /// Turns two vectors more, where the piece turns pairs alone, and none of these vectors; whether it does.
    fn turns(&mut self, pair: &TurningPair) -> bool {
        match self.whole.as_mut().map(Arc::make_mut) {
            None if self.terms.is_empty() => {
                let pairs = TurningPairs::of(pair.clone());
                self.whole = Some(Arc::new(WholeMotion::Turning(pairs)));
                self.flows.clear();
                true
            }
            Some(WholeMotion::Turning(pairs)) => pairs.add(pair),
            _ => false,
        }
    }

    /// Adds a Hamiltonian with its field, where the sum still has an exact flow; the coordinate
    /// whose motion is none of [`Motion`] otherwise, the piece being unchanged.
    pub(crate) fn add(
        &mut self,
        ring: &mut Ring,
        probe: &Probe,
        atom: &Atom,
    ) -> Result<Result<(), usize>, AlgebraError> {
        if let Some(pair) = &atom.turning
            && self.turns(pair)
        {
            self.terms.push(atom.hamiltonian.clone());
            self.formulas.push(atom.formula.clone());
            self.field.extend(atom.field.clone());
            return Ok(Ok(()));
        }
        self.add_all(ring, probe, &[atom])
    }

    /// The same of several Hamiltonians at once, which move coordinates one by one.
    pub(crate) fn add_all(
        &mut self,
        ring: &mut Ring,
        probe: &Probe,
        atoms: &[&Atom],
    ) -> Result<Result<(), usize>, AlgebraError> {
        let of_pairs = atoms.iter().find(|atom| atom.turning.is_some());
        if let Some(atom) = of_pairs.or(atoms.first().filter(|_| self.whole.is_some())) {
            return Ok(Err(atom.field.keys().next().copied().unwrap_or(0)));
        }
        let mut parts: BTreeMap<usize, Vec<(Rational, Polynomial)>> = BTreeMap::new();
        for (i, velocity) in atoms.iter().flat_map(|atom| &atom.field) {
            let sum = parts.entry(*i).or_default();
            sum.push((Rational::one(), velocity.clone()));
        }
        let mut before = Vec::with_capacity(parts.len());
        for (i, mut sum) in parts {
            let present = self.field.entry(i).or_insert_with(Polynomial::zero);
            sum.push((Rational::one(), present.clone()));
            let sum = ring.combine(&sum);
            before.push((i, std::mem::replace(present, sum)));
        }
        let moved = |flow: &CoordinateFlow| before.iter().any(|(i, _)| flow.reads.contains(i));
        let affected: Vec<usize> = (0..self.flows.len())
            .filter(|i| moved(&self.flows[*i]))
            .collect();
        let mut flows: Vec<CoordinateFlow> = Vec::with_capacity(affected.len());
        for &index in &affected {
            // Coordinates of one velocity have one motion, as those of all bodies under the square of their momentum.
            let own = self.field.get(&index);
            let mut known = affected.iter().zip(&flows);
            let known = known.find(|(other, _)| own.is_some() && self.field.get(other) == own);
            if let Some((_, flow)) = known {
                let mut flow = flow.clone();
                flow.reads.insert(index);
                flows.push(flow);
                continue;
            }
            let Some(flow) = coordinate_flow(ring, probe, &self.field, index)? else {
                self.field.extend(before);
                return Ok(Err(index));
            };
            flows.push(flow);
        }
        for (index, flow) in affected.into_iter().zip(flows) {
            self.flows[index] = flow;
        }
        for atom in atoms {
            self.terms.push(atom.hamiltonian.clone());
            self.formulas.push(atom.formula.clone());
        }
        Ok(Ok(()))
    }
}
