//! The `[system]` table as a value.

use std::sync::Arc;

use leafwise_core::{PartParameters, PoissonSystem};

use super::bracket::BracketSpec;
use super::located::{Located, Number};

/// Sites beyond the ends of an indexed family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Indices are taken modulo the length.
    Periodic,
    /// Entries that reach outside are absent.
    Open,
}

/// Which of ẋ = {H, x} and ẋ = {x, H} the scene means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Convention {
    /// ẋ = {H, x}, the default (paper, section 2).
    #[default]
    HamiltonFirst,
    /// ẋ = {x, H}, most of the literature.
    HamiltonSecond,
}

/// The `[system]` table, with a library system's text already filled in.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemSection {
    /// The library system it was taken from.
    pub library: Option<Located<String>>,
    /// Single variables, in the order of the state.
    pub variables: Vec<Located<String>>,
    /// Indexed families with their lengths, of a family of vectors one for each component; their sites follow the single
    /// variables.
    pub families: Vec<(Located<String>, Located<usize>)>,
    /// Families of vectors, whose components are families `s.x`, `s.y`, ….
    pub vectors: Vec<VectorFamily>,
    /// Parameters with their values.
    pub parameters: Vec<(Located<String>, Located<Number>)>,
    /// Names for formulas, in the order of the text.
    pub define: Vec<(Located<String>, Located<String>)>,
    /// The Poisson tensor.
    pub bracket: Located<BracketSpec>,
    /// Second-class constraints, for Dirac's bracket.
    pub constraints: Vec<Located<String>>,
    /// What happens at the ends of a family.
    pub boundary: Option<Located<Boundary>>,
    /// The sign convention.
    pub convention: Convention,
    /// The Hamiltonian's formula.
    pub hamiltonian: Located<String>,
    /// Claimed Casimirs by name.
    pub casimirs: Vec<(Located<String>, Located<String>)>,
    /// A library system without formulas, in place of bracket, Hamiltonian and Casimirs.
    pub numbers: Option<NumbersSystem>,
}

/// A vector at every site.
#[derive(Clone, Debug, PartialEq)]
pub struct VectorFamily {
    /// The family's name.
    pub name: Located<String>,
    /// The components' names.
    pub components: Vec<Located<String>>,
}

impl VectorFamily {
    /// The name of the family of a component: `s.x`.
    pub fn family(&self, component: &str) -> String {
        format!("{}.{component}", self.name.value)
    }

    /// Whether a family is one of its components.
    pub fn has(&self, family: &str) -> bool {
        let mut components = self.components.iter();
        components.any(|component| self.family(&component.value) == family)
    }
}

impl SystemSection {
    /// The families that a name stands for: one, or the components of vectors.
    pub fn families_of<'a>(
        &'a self,
        name: &'a str,
    ) -> impl Iterator<Item = &'a (Located<String>, Located<usize>)> {
        let vector = self.vectors.iter().find(|vector| vector.name.value == name);
        self.families
            .iter()
            .filter(move |(family, _)| match vector {
                Some(vector) => vector.has(&family.value),
                None => family.value == name,
            })
    }

    /// The names that scenes give to variables and families.
    pub fn declared(&self) -> Vec<&Located<String>> {
        let families = self.families.iter().map(|(name, _)| name);
        let scalars = families.filter(|name| !self.vectors.iter().any(|v| v.has(&name.value)));
        let vectors = self.vectors.iter().map(|vector| &vector.name);
        self.variables
            .iter()
            .chain(scalars)
            .chain(vectors)
            .collect()
    }

    /// The dimension of the state: single variables and all sites of the families.
    pub fn dimension(&self) -> usize {
        self.families
            .iter()
            .fold(self.variables.len(), |sum, (_, length)| {
                sum.saturating_add(length.value)
            })
    }
}

/// A system that computes values and has no formulas, as the scene's parameters make it.
#[derive(Clone, Debug)]
pub struct NumbersSystem {
    /// (M, π, H).
    pub system: Arc<PoissonSystem>,
    /// Every parameter of its part that the scene gives.
    pub given: PartParameters,
}

/// Two documents are equal where they ask for the same: the text decides what the system is.
impl PartialEq for NumbersSystem {
    fn eq(&self, other: &Self) -> bool {
        self.given == other.given
    }
}
