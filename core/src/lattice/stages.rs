//! A method's maps as sweeps over sites.

use leafwise_expression::{Arithmetic, Graph, Term};

use crate::error::BuildError;

/// A field: one number a coordinate of the lattice, kept between stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field(pub(super) usize);

/// The fields a solver reads and writes.
#[derive(Clone, Copy, Debug)]
pub(super) struct MethodFields {
    pub(super) y: Field,
    pub(super) offset: Field,
    pub(super) increment: Field,
    pub(super) reach: Option<Field>,
}

/// Terms that a stage writes into a field: one term a proxy coordinate, `None` where the number stays.
pub(super) type Written = (Field, Vec<Option<Term>>);

/// Terms of one sweep.
#[derive(Debug)]
pub(super) struct StageTerms {
    pub(super) written: Vec<Written>,
    /// Whether every number that changes is read at its own site alone.
    pub(super) is_apart: bool,
}

/// Code over the proxy lattice, cut into stages.
///
/// Values that a later stage reads at neighbouring sites are stored as fields; what comes back is
/// code that reads the field. Code of a stage reads what stood in the fields when the stage began.
#[derive(Debug)]
pub struct StageBuilder {
    /// The code of all stages.
    pub graph: Graph,
    pub(super) dimension: usize,
    pub(super) fields: usize,
    pub(super) stages: Vec<StageTerms>,
    pub(super) current: Vec<Written>,
    pub(super) reach: Option<Field>,
}

impl StageBuilder {
    /// No stage yet, over a proxy of `dimension` coordinates.
    pub fn new(dimension: usize) -> Self {
        Self {
            graph: Graph::new(),
            dimension,
            fields: 0,
            stages: Vec::new(),
            current: Vec::new(),
            reach: None,
        }
    }

    /// A fresh field that no stage writes yet, such as the state, and the code that reads it.
    pub fn unwritten(&mut self) -> (Field, Vec<Term>) {
        let field = Field(self.fields);
        self.fields += 1;
        let start = field.0 * self.dimension;
        let code = (0..self.dimension)
            .map(|v| self.graph.input(start + v))
            .collect();
        (field, code)
    }

    /// Stores one value a proxy coordinate in a field at the end of the current stage; returns the
    /// code that reads it in later ones.
    pub fn store(&mut self, values: Vec<Term>) -> Vec<Term> {
        let (field, code) = self.unwritten();
        self.update(field, values.into_iter().map(Some).collect());
        code
    }

    /// Replaces the values of a field at the end of the current stage, where there are any: the
    /// same code reads the new ones in later stages.
    pub fn update(&mut self, field: Field, values: Vec<Option<Term>>) {
        self.current.push((field, values));
    }

    /// Stores values that are an output of the whole program.
    pub(super) fn output(&mut self, values: Vec<Term>) -> Field {
        let (field, _) = self.unwritten();
        self.update(field, values.into_iter().map(Some).collect());
        field
    }

    /// How far points reach in charts that end, 1 at the end, each at a coordinate of its chart: beyond, a step is refused.
    pub fn guard(&mut self, reaches: Vec<Option<Term>>) {
        let (field, _) = self.unwritten();
        self.update(field, reaches);
        self.reach = Some(field);
    }

    /// The same where no stage writes this field.
    pub fn without(mut self, field: Field) -> Self {
        let stages = self.stages.iter_mut().map(|stage| &mut stage.written);
        let stages = stages.chain([&mut self.current]);
        stages.for_each(|stage| stage.retain(|(written, _)| *written != field));
        self
    }

    /// Ends the current stage: what it stored can be read from here on.
    pub fn finish_stage(&mut self) {
        self.finish(false);
    }

    /// The same where every number that changes is read at its own site alone, as of one of several sublattices. What a site
    /// reads at others is written with the value that it has. Such a stage needs no place aside.
    pub fn finish_stage_apart(&mut self) {
        self.finish(true);
    }

    fn finish(&mut self, is_apart: bool) {
        if !self.current.is_empty() {
            let written = std::mem::take(&mut self.current);
            self.stages.push(StageTerms { written, is_apart });
        }
    }
}

/// β̂ − y and α̂ − β̂ as code of the last stage, one term a proxy coordinate, with y the base point.
#[derive(Clone, Debug)]
pub struct StageEnds {
    /// β̂ − y.
    pub offset: Vec<Term>,
    /// α̂ − β̂.
    pub increment: Vec<Term>,
}

impl StageEnds {
    /// The ends α and β about x. Where x is a summand of both it drops out, without cancellation.
    pub fn between(graph: &mut Graph, x: &[Term], alpha: &[Term], beta: &[Term]) -> Self {
        let mut offset = Vec::with_capacity(alpha.len());
        let mut increment = Vec::with_capacity(alpha.len());
        for ((alpha, beta), x) in alpha.iter().zip(beta).zip(x) {
            let below = graph.summands_beside(beta, x);
            let mut between = graph.summands_beside(alpha, x);
            between.extend(below.iter().map(|(factor, term)| (-factor, term.clone())));
            offset.push(graph.combine(&below));
            increment.push(graph.combine(&between));
        }
        Self { offset, increment }
    }
}

/// α̂_ε and β̂_ε stage by stage: of a builder, ε, y and p, both code over the proxy lattice.
///
/// It fails with [`BuildError::Algebra`] where the tensor has no code.
pub type StageCode<'a> =
    Box<dyn Fn(&mut StageBuilder, &Term, &[Term], &[Term]) -> Result<StageEnds, BuildError> + 'a>;
