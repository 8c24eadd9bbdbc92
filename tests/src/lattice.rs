//! A long lattice stepped by templates beside the same one written out site by site.

use std::sync::Arc;

use leafwise_core::LatticeMethod;
use leafwise_core::lattice::observables::SiteDensity;
use leafwise_core::lattice::{LatticeGeometry, LatticeSource, TemplateReach};
use leafwise_core::{BuildError, Convention, PoissonSystem, RealizationData, StepMap, Walk};
use leafwise_expression::Expression;
use leafwise_expression::syntax::{Boundary, Formula, Scope, VariablePattern};
use leafwise_hamilton_jacobi::HamiltonJacobi;

use crate::methods::hamilton_jacobi;

/// A chain `x[0]` … `x[N−1]` with one bracket template.
#[derive(Clone, Debug)]
pub struct Chain {
    geometry: LatticeGeometry,
    pair: &'static str,
    entry: &'static str,
    hamiltonian: &'static str,
}

impl Chain {
    /// {pair} = entry at every site, as in `"x[i],x[i+1]"`.
    pub fn new(
        (length, periodic): (usize, bool),
        (pair, entry): (&'static str, &'static str),
        hamiltonian: &'static str,
    ) -> Self {
        Self {
            geometry: LatticeGeometry::chain(vec![("x".to_owned(), length)], periodic),
            pair,
            entry,
            hamiltonian,
        }
    }
}

impl LatticeSource for Chain {
    fn geometry(&self) -> &LatticeGeometry {
        &self.geometry
    }

    fn reach(&self) -> Result<TemplateReach, BuildError> {
        let (a, b) = VariablePattern::parse_pair(self.pair).expect("a pair");
        let entry = Formula::parse(self.entry).expect("a formula");
        let hamiltonian = Formula::parse(self.hamiltonian).expect("a formula");
        let bracket = TemplateReach::default().with_entry([&a, &b], &entry);
        let reach = bracket.and_then(|reach| reach.with_hamiltonian(&hamiltonian));
        reach.map_err(|error| BuildError::Lattice {
            message: error.to_string(),
        })
    }

    fn write_out(&self, geometry: &LatticeGeometry) -> Result<PoissonSystem, BuildError> {
        let boundary = if geometry.is_periodic() {
            Boundary::Periodic
        } else {
            Boundary::Open
        };
        let scope = Scope::new()
            .with_boundary(boundary)
            .with_length(self.geometry.length())
            .with_family("x", 0, geometry.length());
        let (a, b) = VariablePattern::parse_pair(self.pair).expect("a pair");
        let template = Formula::parse(self.entry).expect("a formula");
        let mut entries = Vec::new();
        for site in 0..geometry.length() {
            let at = Some((&["i"][..], site));
            let (Ok(Some(a)), Ok(Some(b))) = (a.resolve(&scope, at), b.resolve(&scope, at)) else {
                continue;
            };
            let entry = template.resolve(&scope, at).expect("known names");
            let entry = entry.expect("inside, as its pair");
            entries.push(if a < b {
                ((a, b), entry)
            } else {
                ((b, a), Expression::Negate(Box::new(entry)))
            });
        }
        let hamiltonian = Formula::parse(self.hamiltonian).expect("a formula");
        let hamiltonian = hamiltonian.resolve(&scope, None).expect("known names");
        PoissonSystem::new(
            (0..geometry.dimension())
                .map(|c| geometry.name(c))
                .collect(),
            Vec::new(),
            entries,
            hamiltonian.expect("no free index"),
            Vec::new(),
            Convention::HamiltonianFirst,
        )
    }

    fn densities(
        &self,
        _geometry: &LatticeGeometry,
        _site: usize,
    ) -> Result<Vec<SiteDensity>, BuildError> {
        Ok(Vec::new())
    }
}

/// The states after `steps` steps of εh = `time_step` with `hamilton-jacobi` of order m from
/// `initial`: by templates, and written out.
///
/// # Panics
/// When a method cannot be built or a step fails.
pub fn by_templates_and_written_out(
    chain: &Chain,
    realize: fn(&PoissonSystem) -> Arc<dyn RealizationData>,
    m: usize,
    (time_step, steps): (f64, usize),
    initial: &[f64],
) -> (Vec<f64>, Vec<f64>) {
    let dynamics = Arc::new(HamiltonJacobi::new(m).expect("an even order"));
    let lattice = LatticeMethod::compose(chain, &|system| Ok(realize(system)), dynamics);
    let system = chain.write_out(&chain.geometry).expect("fits");
    let dense = hamilton_jacobi(&system, &realize(&system), m);
    let run = |map: &dyn StepMap| {
        let mut walk = Walk::new(map, &[], 1.0, time_step, initial);
        for _ in 0..steps {
            walk.step().expect("a step");
        }
        walk.state().to_vec()
    };
    let lattice = lattice.expect("a lattice method");
    (run(lattice.map().map.as_ref()), run(&dense))
}
