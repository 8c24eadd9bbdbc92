//! The sites of a scene's families as pictures show them: places of a lattice, or bodies in a plane.

use leafwise_core::lattice::LatticeGeometry;
use leafwise_expression::syntax::Formula;

use super::geometry::geometry;
use crate::document::{
    AlgebraSpec, BracketSpec, LieAlgebraSpec, Located, SceneDocument, SystemSection, VectorFamily,
    is_pair,
};

/// Names of vectors that are no places: momenta and velocities.
const MOMENTA: [&str; 3] = ["p", "u", "v"];

/// The families that move, and what their sites are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sites {
    /// Families, axes and ends.
    pub geometry: LatticeGeometry,
    /// The place of the first family in a state: single variables stand before it.
    pub first: usize,
    /// Whether a formula names a neighbour at an offset, `q[i+1]`, as on a lattice.
    pub has_neighbours: bool,
    /// The families with the places x and y of bodies in a plane; `None` where sites are those of a lattice.
    pub plane: Option<[usize; 2]>,
    /// The families s.x, s.y and s.z of spins, so(3)* at every site, of each vector of spins.
    pub spins: Vec<[usize; 3]>,
}

/// A field on the sites: a family, or the components of a vector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SiteField {
    /// Its name, as `q` or `s`.
    pub name: String,
    /// Its families, one of each component.
    pub families: Vec<usize>,
    /// The families s.x, s.y and s.z where it is one of spins.
    pub spins: Option<[usize; 3]>,
    /// Whether its name is that of a momentum or a velocity: p, u, v, or the second of a canonical pair, as `pa` of `a`.
    pub is_momentum: bool,
}

impl Sites {
    /// The sites of a scene.
    ///
    /// They are bodies where the families have one axis, no formula names a neighbour, `q[i+1]`, and two families are
    /// places x and y. Formulas are those of the bracket, the motion and definitions. Places are called `x` and `y`, or
    /// are components of a vector whose name is none of p, u and v. Components of a Lie algebra are no places.
    /// Elsewhere sites are those of a lattice.
    pub(super) fn of(document: &SceneDocument) -> Self {
        let system = &document.system;
        let mut geometry = geometry(document);
        geometry.families.truncate(system.moving().len());
        let spins = spins(system, &geometry);
        let is_chain = geometry.axes.len() == 1;
        let has_neighbours = couples_neighbours(system);
        let plane = plane(system, &geometry).filter(|_| is_chain && !has_neighbours);
        Self {
            geometry,
            first: system.variables.len(),
            has_neighbours,
            plane,
            spins,
        }
    }

    /// The fields on the sites, in the order of their families.
    pub fn fields(&self) -> Vec<SiteField> {
        let mut fields: Vec<SiteField> = Vec::new();
        for (family, (whole, _)) in self.geometry.families.iter().enumerate() {
            let name = whole.split_once('.').map_or(&**whole, |(vector, _)| vector);
            match fields.iter_mut().find(|field| field.name == name) {
                Some(field) => field.families.push(family),
                None => fields.push(SiteField {
                    name: name.to_owned(),
                    families: vec![family],
                    spins: None,
                    is_momentum: false,
                }),
            }
        }
        let names: Vec<String> = fields.iter().map(|field| field.name.clone()).collect();
        for field in &mut fields {
            let own = |spins: &&[usize; 3]| field.families.contains(&spins[0]);
            field.spins = self.spins.iter().find(own).copied();
            field.is_momentum = MOMENTA.contains(&field.name.to_lowercase().as_str())
                || names.iter().any(|other| is_pair(other, &field.name));
        }
        fields
    }

    /// The place of each site of a family in a state, in their order.
    pub fn coordinates(&self, family: usize) -> std::ops::Range<usize> {
        let start = self.first + self.geometry.offsets()[family];
        start..start + self.geometry.families[family].1
    }
}

/// The place of a family among all.
fn place(geometry: &LatticeGeometry, name: &str) -> Option<usize> {
    let mut names = geometry.families.iter().map(|(name, _)| name);
    names.position(|known| known == name)
}

/// The families that are places x and y.
fn plane(system: &SystemSection, geometry: &LatticeGeometry) -> Option<[usize; 2]> {
    let is_moved_by_algebra = |name: &str| algebra_of(&system.bracket.value, name).is_some();
    let vectors = system.vectors.iter().map(|vector| &vector.name.value);
    let vectors = vectors.filter(|name| !MOMENTA.contains(&name.to_lowercase().as_str()));
    let prefixes = vectors.map(|name| (name.clone(), format!("{name}.")));
    let mut prefixes = std::iter::once(("x".to_owned(), String::new())).chain(prefixes);
    prefixes.find_map(|(whole, prefix)| {
        let [x, y] = ["x", "y"].map(|letter| place(geometry, &format!("{prefix}{letter}")));
        let (x, y) = x.zip(y)?;
        let is_same_length = geometry.families[x].1 == geometry.families[y].1;
        (is_same_length && !is_moved_by_algebra(&whole)).then_some([x, y])
    })
}

/// The families of vectors x, y, z with the bracket of so(3).
fn spins(system: &SystemSection, geometry: &LatticeGeometry) -> Vec<[usize; 3]> {
    let letters = |vector: &VectorFamily| -> Vec<String> {
        let letters = vector.components.iter();
        letters.map(|letter| letter.value.clone()).collect()
    };
    let is_spin = |vector: &&VectorFamily| {
        let algebra = algebra_of(&system.bracket.value, &vector.name.value);
        letters(vector) == ["x", "y", "z"] && algebra.is_some_and(is_so3)
    };
    let places = |vector: &VectorFamily| -> Option<[usize; 3]> {
        let [x, y, z] = ["x", "y", "z"].map(|letter| place(geometry, &vector.family(letter)));
        Some([x?, y?, z?])
    };
    let vectors = system.vectors.iter().filter(is_spin);
    vectors.filter_map(places).collect()
}

/// The Lie algebra by whose bracket a variable or a family moves, if it does.
fn algebra_of<'a>(bracket: &'a BracketSpec, name: &str) -> Option<&'a LieAlgebraSpec> {
    match bracket {
        BracketSpec::LieAlgebra(algebra) => Some(algebra),
        BracketSpec::Sum(summands) => summands.iter().find_map(|summand| {
            let mut own = summand.variables.iter();
            let has_it = own.any(|variable| variable.value == name);
            has_it.then(|| algebra_of(&summand.bracket.value, name))?
        }),
        _ => None,
    }
}

fn is_so3(algebra: &LieAlgebraSpec) -> bool {
    matches!(&algebra.algebra, AlgebraSpec::Named(name) if name.value == "so3")
        && algebra.representation.is_none()
}

/// Whether a formula couples a site with one at an offset from it.
fn couples_neighbours(system: &SystemSection) -> bool {
    let mut formulas: Vec<&Located<String>> = system.bracket.value.formulas();
    formulas.push(&system.hamiltonian);
    formulas.extend(&system.constraints);
    formulas.extend(system.define.iter().map(|(_, formula)| formula));
    formulas.extend(system.forces.formulas());
    formulas.extend(system.noise.iter().map(|channel| &channel.hamiltonian));
    let keys = entries(&system.bracket.value).into_iter();
    let keys = keys.flat_map(|key| key.value.split(','));
    let mut texts = formulas
        .iter()
        .map(|formula| formula.value.as_str())
        .chain(keys);
    texts.any(|text| Formula::parse(text).is_ok_and(|formula| formula.names_neighbours()))
}

/// The keys `x[i],y[i]` of a bracket by entries.
fn entries(bracket: &BracketSpec) -> Vec<&Located<String>> {
    match bracket {
        BracketSpec::Entries(entries)
        | BracketSpec::Contact(entries)
        | BracketSpec::TwoForm(entries) => entries.iter().map(|(key, _)| key).collect(),
        BracketSpec::Sum(summands) => (summands.iter())
            .flat_map(|summand| entries(&summand.bracket.value))
            .collect(),
        _ => Vec::new(),
    }
}
