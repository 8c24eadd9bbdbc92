//! Lattices of templates.

use leafwise::core::lattice::{
    LatticeGeometry, LatticeSource, TemplateReach, observables::SiteDensity,
};
use leafwise::core::{BuildError, Convention, PoissonSystem};
use leafwise::expression::Expression;
use leafwise::expression::syntax::{Boundary, Formula, Scope, VariablePattern};

/// A bracket of templates, a Hamiltonian that is a sum over sites.
pub struct Chain {
    pub geometry: LatticeGeometry,
    pub bracket: Vec<(String, String)>,
    pub hamiltonian: String,
}

impl Chain {
    /// Families by name and length.
    pub fn new(
        families: &[(&str, usize)],
        periodic: bool,
        bracket: &[(&str, &str)],
        hamiltonian: &str,
    ) -> Self {
        let families = families.iter().map(|(name, n)| ((*name).to_owned(), *n));
        Self {
            geometry: LatticeGeometry::chain(families.collect(), periodic),
            bracket: (bracket.iter())
                .map(|(pair, entry)| ((*pair).to_owned(), (*entry).to_owned()))
                .collect(),
            hamiltonian: hamiltonian.to_owned(),
        }
    }

    /// The system with every site written out.
    pub fn whole(&self) -> PoissonSystem {
        self.write_out(&self.geometry).expect("fits")
    }

    fn scope(&self, geometry: &LatticeGeometry) -> Scope {
        let boundary = if geometry.is_periodic() {
            Boundary::Periodic
        } else {
            Boundary::Open
        };
        let mut scope = Scope::new()
            .with_boundary(boundary)
            .with_length(self.geometry.length())
            .with_rings(&self.geometry.lengths());
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

    fn reach(&self) -> Result<TemplateReach, BuildError> {
        let read = |text: &str| Formula::parse(text).expect("a formula");
        let bracket =
            self.bracket
                .iter()
                .try_fold(TemplateReach::default(), |reach, (pair, entry)| {
                    let (a, b) = VariablePattern::parse_pair(pair).expect("a pair");
                    reach.with_entry([&a, &b], &read(entry))
                });
        let hamiltonian = read(&self.hamiltonian);
        let reach = bracket.and_then(|reach| reach.with_hamiltonian(&hamiltonian));
        reach.map_err(|error| BuildError::Lattice {
            message: error.to_string(),
        })
    }

    fn write_out(&self, geometry: &LatticeGeometry) -> Result<PoissonSystem, BuildError> {
        let scope = self.scope(geometry);
        let mut entries = std::collections::BTreeMap::new();
        for (pair, entry) in &self.bracket {
            let (a, b) = VariablePattern::parse_pair(pair).expect("a pair");
            let entry = Formula::parse(entry).expect("a formula");
            for site in 0..geometry.length() {
                let at = Some((&["i"][..], site));
                let ends = [&a, &b].map(|end| end.resolve(&scope, at).expect("known names"));
                let [Some(a), Some(b)] = ends else {
                    continue;
                };
                // An entry that reaches outside is absent.
                let Some(value) = entry.resolve(&scope, at).expect("known names") else {
                    continue;
                };
                let value = if a < b {
                    value
                } else {
                    Expression::Negate(Box::new(value))
                };
                entries.insert((a.min(b), a.max(b)), value);
            }
        }
        let hamiltonian = Formula::parse(&self.hamiltonian).expect("a formula");
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
        let formula = Formula::parse(&self.hamiltonian).expect("a formula");
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
