//! Lattices of templates.

use leafwise::core::lattice::{LatticeGeometry, LatticeSource, observables::SiteDensity};
use leafwise::core::{BuildError, Convention, PoissonSystem};
use leafwise::expression::Expression;
use leafwise::expression::syntax::{Boundary, Formula, Scope, VariablePattern};

/// A bracket of templates, a Hamiltonian that is a sum over sites.
pub struct Chain {
    pub geometry: LatticeGeometry,
    pub bracket: Vec<(&'static str, &'static str)>,
    pub hamiltonian: &'static str,
}

impl Chain {
    /// Families by name and length.
    pub fn new(
        families: &[(&str, usize)],
        periodic: bool,
        bracket: &[(&'static str, &'static str)],
        hamiltonian: &'static str,
    ) -> Self {
        let families = families.iter().map(|(name, n)| ((*name).to_owned(), *n));
        Self {
            geometry: LatticeGeometry {
                families: families.collect(),
                periodic,
            },
            bracket: bracket.to_vec(),
            hamiltonian,
        }
    }

    /// The system with every site written out.
    pub fn whole(&self) -> PoissonSystem {
        self.write_out(&self.geometry).expect("fits")
    }

    fn scope(&self, geometry: &LatticeGeometry) -> Scope {
        let boundary = if geometry.periodic {
            Boundary::Periodic
        } else {
            Boundary::Open
        };
        let mut scope = Scope::new()
            .with_boundary(boundary)
            .with_length(self.geometry.length());
        for ((name, length), offset) in geometry.families.iter().zip(geometry.offsets()) {
            scope = scope.with_family(name, offset, *length);
        }
        scope
    }
}

impl LatticeSource for Chain {
    fn geometry(&self) -> &LatticeGeometry {
        &self.geometry
    }

    fn write_out(&self, geometry: &LatticeGeometry) -> Result<PoissonSystem, BuildError> {
        let scope = self.scope(geometry);
        let mut entries = std::collections::BTreeMap::new();
        for (pair, entry) in &self.bracket {
            let (a, b) = VariablePattern::parse_pair(pair).expect("a pair");
            let entry = Formula::parse(entry).expect("a formula");
            for site in 0..geometry.length() {
                let at = Some(("i", site));
                let ends = (a.resolve(&scope, at), b.resolve(&scope, at));
                let (Ok(Some(a)), Ok(Some(b))) = ends else {
                    continue;
                };
                let value = entry
                    .resolve(&scope, at)
                    .expect("known names")
                    .expect("inside");
                let value = if a < b {
                    value
                } else {
                    Expression::Negate(Box::new(value))
                };
                entries.insert((a.min(b), a.max(b)), value);
            }
        }
        let hamiltonian = Formula::parse(self.hamiltonian).expect("a formula");
        let hamiltonian = hamiltonian
            .resolve(&scope, None)
            .expect("names")
            .expect("inside");
        let names = (0..geometry.dimension())
            .map(|c| geometry.name(c))
            .collect();
        PoissonSystem::new(
            names,
            Vec::new(),
            entries,
            hamiltonian,
            Vec::new(),
            Convention::HamiltonianFirst,
        )
    }

    fn densities(
        &self,
        geometry: &LatticeGeometry,
        site: usize,
    ) -> Result<Vec<SiteDensity>, BuildError> {
        let formula = Formula::parse(self.hamiltonian).expect("a formula");
        let density = formula
            .density(&self.scope(geometry), site)
            .map_err(|error| BuildError::Lattice {
                message: error.to_string(),
            })?;
        Ok(vec![SiteDensity {
            constant: density.constant,
            site: density.site,
        }])
    }
}
