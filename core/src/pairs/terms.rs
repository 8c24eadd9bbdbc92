//! H as a sum of terms of one site and of two sites, each with the brackets of these sites.
//!
//! Flows of terms are those of all sites or pairs: what a splitting finds for one serves all.

use leafwise_expression::Expression;

use super::BodyShape;
use super::function::{BodySum, Weighted};
use super::matrix::PairEntry;
use super::system::BodySystem;
use crate::error::BuildError;
use crate::system::{Convention, SystemFormulas};

/// H = Σ_i s(x_i) + Σ_{i<j} p(x_i, x_j) as the systems of one site with H = s and of two with H = p.
///
/// Coordinates of both systems are the variables of a pair's formula, as [`BodyShape`] says: entries of matrices rest, and so
/// does the second site under s.
#[derive(Clone, Debug)]
pub struct BodyTerms {
    /// The numbers of families and sites.
    pub shape: BodyShape,
    /// H = s, where there is such a term.
    pub site: Option<SystemFormulas>,
    /// H = p, where there is such a term.
    pub pair: Option<SystemFormulas>,
}

impl BodyTerms {
    /// The values of the systems' coordinates of the sites i and j, from a state of all sites; the place of each in the state,
    /// or the entry of a matrix.
    pub fn places(&self, [i, j]: [usize; 2]) -> impl Iterator<Item = BodyPlace> {
        let BodyShape {
            families,
            sites,
            ref matrices,
        } = self.shape;
        let coordinates = [i, j].into_iter();
        let coordinates = coordinates.flat_map(move |site| {
            (0..families).map(move |family| BodyPlace::Coordinate(family * sites + site))
        });
        let entries = matrices.iter().flat_map(move |matrix| {
            (0..PairEntry::COUNT)
                .map(move |entry| BodyPlace::Entry(PairEntry::numbered(entry).of(matrix, [i, j])))
        });
        coordinates.chain(entries)
    }
}

/// Where a coordinate of one or two sites stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyPlace {
    /// In the state of all sites.
    Coordinate(usize),
    /// A number of a matrix.
    Entry(f64),
}

impl BodySystem {
    /// The terms of H; `None` where H is another function of sums than a sum of them, or forces act.
    ///
    /// # Errors
    /// [`BuildError`] where a formula has no derivative.
    pub(super) fn terms(&self) -> Result<Option<BodyTerms>, BuildError> {
        let weighted = Weighted::of(&self.hamiltonian)?;
        if !self.forces.is_empty() || !weighted.of_sums().is_empty() {
            return Ok(None);
        }
        Ok(Some(BodyTerms {
            shape: self.shape.clone(),
            site: self.term(&weighted, 1, |sum| &sum.site)?,
            pair: self.term(&weighted, 2, |sum| &sum.pair)?,
        }))
    }

    /// The system with the brackets of so many sites, and this part of all sums as H.
    fn term(
        &self,
        weighted: &Weighted<'_>,
        sites: usize,
        part: impl Fn(&BodySum) -> &Expression,
    ) -> Result<Option<SystemFormulas>, BuildError> {
        let hamiltonian = weighted.sum(part);
        if hamiltonian.variables().is_empty() {
            return Ok(None);
        }
        let (shape, families) = (&self.shape, self.shape.families);
        let own = |site: usize, family: usize| family * shape.sites + site;
        let mut variables = Vec::with_capacity(shape.variables());
        for site in 0..2 {
            let names = (0..families).map(|family| self.variables[own(site, family)].clone());
            variables.extend(names);
        }
        variables.extend((variables.len()..shape.variables()).map(|at| format!("entry{at}")));
        let mut bracket = Vec::new();
        for site in 0..sites {
            let places: Vec<usize> = (0..families).map(|at| at + site * families).collect();
            for ((a, b), entry) in &self.bracket {
                bracket.push(((places[*a], places[*b]), entry.with_variables(&places)));
            }
        }
        let system = SystemFormulas::new(
            variables,
            self.parameters.clone(),
            bracket,
            hamiltonian,
            Vec::new(),
            Convention::HamiltonianFirst,
        )?;
        if self.near.len() != shape.dimension() {
            return Ok(Some(system));
        }
        let mut near = system.near().to_vec();
        for site in 0..2 {
            for family in 0..families {
                near[site * families + family] = self.near[own(site, family)];
            }
        }
        system.with_near(&near).map(Some)
    }
}
