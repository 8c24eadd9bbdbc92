//! The `[system]` table as a value.

use leafwise_expression::syntax::{SiteNames, Vector};

use std::sync::Arc;

use leafwise_core::{PartParameters, PoissonSystem};

use super::bracket::BracketSpec;
use super::field::{FieldSpec, family_of};
use super::forces::ForcesSpec;
use super::located::{Located, Number};
use super::matrices::MatrixSpec;
use super::noise::NoiseSpec;
use super::tables::TableSpec;

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
    /// variables. The last are those of [`sites`](Self::sites).
    pub families: Vec<(Located<String>, Located<usize>)>,
    /// The lengths of the axes that all families have, where these are several; none where each family has its own.
    pub axes: Vec<usize>,
    /// Names of the sites of a chain; none where they are numbers.
    pub site_names: SiteNames,
    /// Families of vectors, whose components are families `s.x`, `s.y`, ….
    pub vectors: Vec<VectorFamily>,
    /// Vectors of single variables, whose components are variables `r.x`, `r.y`, ….
    pub variable_vectors: Vec<VectorFamily>,
    /// Vectors of definitions `L.x`, `L.y`, ….
    pub defined_vectors: Vec<VectorFamily>,
    /// Parameters with their values.
    pub parameters: Vec<(Located<String>, Located<Number>)>,
    /// Parameters of every site by their keys, `J[i]` or `J[3]`: families at rest, which nothing outside shows.
    pub sites: Vec<(Located<String>, FieldSpec)>,
    /// Parameters of every two sites of a chain.
    pub matrices: Vec<MatrixSpec>,
    /// Names for formulas, in the order of the text.
    pub define: Vec<(Located<String>, Located<String>)>,
    /// Tables that formulas call as functions.
    pub tables: Vec<(Located<String>, TableSpec)>,
    /// The Poisson tensor.
    pub bracket: Located<BracketSpec>,
    /// Second-class constraints, for Dirac's bracket.
    pub constraints: Vec<Located<String>>,
    /// How families go on at their ends: one for all axes, or one for each.
    pub boundary: Option<Located<Vec<Boundary>>>,
    /// The sign convention.
    pub convention: Convention,
    /// Whether the scene names it, or has pairs that are Hamilton's under either.
    pub tells_sign: bool,
    /// The Hamiltonian's formula.
    pub hamiltonian: Located<String>,
    /// Claimed Casimirs by name.
    pub casimirs: Vec<(Located<String>, Located<String>)>,
    /// Forces that move the system beside its Hamiltonian.
    pub forces: ForcesSpec,
    /// Channels of noise, which move the system at random.
    pub noise: Vec<NoiseSpec>,
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
    /// How families go on at the ends of an axis.
    pub fn boundary_along(&self, axis: usize) -> Boundary {
        let boundaries = self.boundary.as_ref().map(|boundary| &boundary.value[..]);
        match boundaries {
            None | Some([]) => Boundary::Periodic,
            Some([one]) => *one,
            Some(each) => each.get(axis).copied().unwrap_or(Boundary::Periodic),
        }
    }

    /// Vectors of families, of single variables and of definitions.
    pub fn all_vectors(&self) -> impl Iterator<Item = &VectorFamily> {
        let moving = self.vectors.iter().chain(&self.variable_vectors);
        moving.chain(&self.defined_vectors)
    }

    /// The vectors that formulas may name.
    pub fn named_vectors(&self) -> Vec<Vector> {
        let named = self.all_vectors().map(|vector| Vector {
            name: vector.name.value.clone(),
            components: (vector.components.iter())
                .map(|component| vector.family(&component.value))
                .collect(),
        });
        named.collect()
    }

    /// The keys of the components of a vector that moves: of `p` `p.x`, `p.y` and `p.z`, of `s[i]` `s.x[i]`, `s.y[i]` and `s.z[i]`.
    pub fn components_of_key(&self, key: &str) -> Option<Vec<String>> {
        let (name, site) = key.split_at(key.find('[').unwrap_or(key.len()));
        let mut moving = self.vectors.iter().chain(&self.variable_vectors);
        let vector = moving.find(|vector| vector.name.value == name.trim())?;
        let components = vector.components.iter();
        let keys = components.map(|letter| format!("{}{site}", vector.family(&letter.value)));
        Some(keys.collect())
    }

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

    /// The names that scenes give to variables and families that move.
    pub fn declared(&self) -> Vec<&Located<String>> {
        let families = self.families.iter().map(|(name, _)| name);
        let scalars = families.filter(|name| !self.vectors.iter().any(|v| v.has(&name.value)));
        let vectors = self.vectors.iter().map(|vector| &vector.name);
        self.variables
            .iter()
            .chain(scalars)
            .chain(vectors)
            .filter(|name| !self.is_at_rest(&name.value))
            .collect()
    }

    /// The families that move: all but the parameters of sites.
    pub fn moving(&self) -> &[(Located<String>, Located<usize>)] {
        let is_at_rest = |(name, _): &(Located<String>, _)| self.is_at_rest(&name.value);
        let count = self.families.iter().position(is_at_rest);
        &self.families[..count.unwrap_or(self.families.len())]
    }

    /// Options of the command line that make a lattice one of at most so many coordinates:
    /// `--set system.families.x=8`.
    pub fn shortening(&self, coordinates: usize) -> String {
        let families = self.moving().len().max(1);
        let sites = (coordinates / families).min(8);
        let length = match self.axes.len() {
            0 | 1 => sites.to_string(),
            axes => {
                let others = 1 << (axes - 1);
                let mut lengths = vec![2; axes];
                lengths[axes - 1] = (sites / others).max(1);
                format!("{lengths:?}").replace(' ', "")
            }
        };
        let vectors = self
            .vectors
            .iter()
            .map(|vector| format!("{}.length", vector.name.value));
        let is_scalar = |name: &str| !self.vectors.iter().any(|vector| vector.has(name));
        let names = self.moving().iter().map(|(name, _)| name.value.clone());
        let names = names.filter(|name| is_scalar(name)).chain(vectors);
        let options = names.map(|name| format!("--set system.families.{name}={length}"));
        options.collect::<Vec<_>>().join(" ")
    }

    /// Whether a family is a parameter of every site.
    pub fn is_at_rest(&self, family: &str) -> bool {
        let mut keys = self.sites.iter().map(|(key, _)| &key.value);
        keys.any(|key| family_of(key) == Some(family))
    }

    /// The number of coordinates that a user sees: single variables and the families that move.
    pub fn coordinates(&self) -> usize {
        let lengths = self.moving().iter().map(|(_, length)| length.value);
        lengths.fold(self.variables.len(), usize::saturating_add)
    }

    /// The dimension of the state: its coordinates and the parameters of sites.
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
