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
    /// Indexed families with their lengths; their sites follow the single variables.
    pub families: Vec<(Located<String>, Located<usize>)>,
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

impl SystemSection {
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
