//! Temperature of spins by their own state.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

use leafwise_core::lattice::LatticeGeometry;
use leafwise_core::system::spins::turns;
use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};
use leafwise_expression::Expression;

/// The name of the observable.
pub(super) const SPIN_TEMPERATURE: &str = "spin-temperature";

/// Whether a text names the temperature of spins.
pub(super) fn is_spin_temperature(text: &str) -> bool {
    text.trim() == SPIN_TEMPERATURE
}

/// Spins of the sites of a lattice.
#[derive(Clone, Debug)]
pub(super) struct SiteSpins {
    /// The families of each spin's components.
    families: Vec<[usize; 3]>,
    /// H's terms at each site of the lattice that they were written on last.
    energies: RefCell<Option<(LatticeGeometry, Rc<Energies>)>>,
}

/// Terms with the coordinates that they name.
type Energies = Vec<(BTreeSet<usize>, Expression)>;

impl SiteSpins {
    /// Those of a system that is written out on this lattice.
    pub fn of(system: &PoissonSystem, geometry: &LatticeGeometry) -> Self {
        let spins = system.expressions().map(|formulas| formulas.spins());
        let middle = geometry.middle();
        let families = spins.unwrap_or_default().into_iter().filter_map(|places| {
            let located = places.map(|at| geometry.locate(at));
            let is_there = located.iter().all(|(_, site)| *site == middle);
            is_there.then(|| located.map(|(family, _)| family))
        });
        Self {
            families: families.collect(),
            energies: RefCell::default(),
        }
    }

    /// Σ (L_a H)² and Σ L_a L_a H over the spins of a site, H by its terms at each site.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where H has no derivative; those of `energy`.
    pub fn at(
        &self,
        geometry: &LatticeGeometry,
        site: usize,
        energy: impl Fn(usize) -> Result<Expression, BuildError>,
    ) -> Result<[Expression; 2], BuildError> {
        let offsets = geometry.offsets();
        let has_site = |families: &&[usize; 3]| {
            let mut families = families.iter();
            families.all(|family| site < geometry.families[*family].1)
        };
        let spins = self.families.iter().filter(has_site);
        let spins = spins.map(|families| families.map(|family| offsets[family] + site));
        let spins: Vec<[usize; 3]> = spins.collect();
        let mut known = self.energies.borrow_mut();
        if known
            .as_ref()
            .is_none_or(|(written, _)| written != geometry)
        {
            let terms = (0..geometry.length()).map(|site| {
                let energy = energy(site)?;
                Ok((energy.variables(), energy))
            });
            let terms: Energies = terms.collect::<Result<_, BuildError>>()?;
            *known = Some((geometry.clone(), Rc::new(terms)));
        }
        let terms = known.iter().flat_map(|(_, terms)| terms.iter());
        let names_one = |own: &BTreeSet<usize>| spins.iter().flatten().any(|at| own.contains(at));
        let near = terms.filter(|(own, _)| names_one(own));
        let near = near.map(|(_, energy)| energy.clone()).collect();
        Ok(turns(&Expression::Sum(near), &spins)?)
    }
}

/// Temperature of all spins of a system: Σ (L_a H)²/Σ L_a L_a H, see [`turns`].
///
/// # Errors
/// [`BuildError::Algebra`] where H has no derivative.
pub(super) fn spin_temperature(
    system: &SystemFormulas,
    energy: &Expression,
) -> Result<Expression, BuildError> {
    let [squares, curvature] = turns(energy, &system.spins())?;
    Ok(Expression::Quotient(Box::new(squares), Box::new(curvature)))
}
