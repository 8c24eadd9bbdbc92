//! The terms of H, of one site and of two sites, each with the brackets of these sites.
//!
//! Flows of terms are those of all sites or pairs: one that a splitting finds serves all.

use leafwise_expression::Expression;

use super::function::{BodySum, Weighted};
use super::system::BodySystem;
use crate::error::BuildError;
use crate::system::{BodyTerms, Convention, SystemFormulas};

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
            families: self.shape.families,
            sites: self.shape.sites,
            matrices: (self.shape.matrices.iter())
                .map(|matrix| matrix.numbers().clone())
                .collect(),
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
