//! Noise on a lattice: increments as families of sites at rest.

use leafwise_core::lattice::LatticeGeometry;
use leafwise_core::noise::{Noise, SiteNoise};
use leafwise_core::system::Forces;
use leafwise_core::{BuildError, PoissonSystem};
use leafwise_expression::Expression;
use leafwise_expression::syntax::Scope;

use super::Refusal;
use super::channels::{Channel, strength};
use super::definitions::scope;
use super::names::{check_code, function, of_lattice, parse, refusal};
use crate::document::{NoiseSpec, SceneDocument};

/// Terms w_f[i] σ_k H_k(i) of channels k and families f of increments that a map of a lattice steps.
#[derive(Clone, Debug)]
pub(super) struct SiteTerms {
    /// How many families of increments stand behind the scene's own.
    families: usize,
    /// Channels and the families of their increments.
    terms: Vec<(usize, usize)>,
    /// Whether H itself moves the system.
    has_energy: bool,
}

impl SiteTerms {
    /// Those of H, and of every channel where noise enters [with it](Noise::Joint).
    pub fn of_steps(way: Noise, channels: usize) -> Self {
        let all = (0..channels).map(|channel| (channel, channel));
        Self {
            families: way.parameters(channels),
            terms: match way {
                Noise::Joint => all.collect(),
                Noise::Split => Vec::new(),
            },
            has_energy: true,
        }
    }

    /// Those of the flow of each family of increments, 1 … K … 1.
    pub fn of_flows(channels: usize) -> Vec<Self> {
        let families = Noise::Split.parameters(channels);
        let flow = |family: usize| Self {
            families,
            terms: vec![(family.min(families - 1 - family), family)],
            has_energy: false,
        };
        (0..families).map(flow).collect()
    }

    /// The channel of a flow.
    pub fn channel(&self) -> usize {
        self.terms.first().map_or(0, |(channel, _)| *channel)
    }

    /// Whether H itself moves the system.
    pub fn has_energy(&self) -> bool {
        self.has_energy
    }

    /// A lattice with the families of increments behind its own.
    pub fn extended(&self, geometry: &LatticeGeometry) -> LatticeGeometry {
        let mut extended = geometry.clone();
        let length = geometry.length();
        let further = (0..self.families).map(|family| (format!("dW{}/dt", family + 1), length));
        extended.families.extend(further);
        extended
    }

    /// The terms at a site of a lattice that is extended; `scope` is of its own families.
    ///
    /// # Errors
    /// Of a formula that cannot be read there.
    pub fn at(
        &self,
        document: &SceneDocument,
        scope: &Scope,
        geometry: &LatticeGeometry,
        site: usize,
    ) -> Result<Vec<Expression>, BuildError> {
        let offsets = geometry.offsets();
        let first = offsets.len() - self.families;
        let mut terms = Vec::new();
        for (channel, family) in &self.terms {
            let spec = &document.system.noise[*channel];
            let own = share(document, scope, spec, site).map_err(of_lattice)?;
            let Some(own) = own else { continue };
            let strength = function(document, scope, &spec.strength).map_err(of_lattice)?;
            let w = Expression::Variable(offsets[first + family] + site);
            terms.push(Expression::Product(vec![w, strength, own]));
        }
        Ok(terms)
    }

    /// The system that these terms, all sites together, move beside H or in its place.
    ///
    /// # Errors
    /// [`BuildError`] where they have no derivative.
    pub fn moved(
        &self,
        system: &PoissonSystem,
        terms: Expression,
    ) -> Result<PoissonSystem, BuildError> {
        let formulas = system.formulas("noise")?;
        Ok(match self.has_energy {
            true if self.terms.is_empty() => system.clone(),
            true => formulas.with_perturbation(terms)?.into(),
            false => {
                let alone = formulas.with_forces(Forces::default())?;
                alone.with_hamiltonian(terms)?.into()
            }
        })
    }
}

/// H_k's share at a site: of a template of its own index what it is there, of a sum its term; `None` where nothing is left at an open end.
///
/// # Errors
/// What cannot be read, underlined in the scene.
pub(super) fn share(
    document: &SceneDocument,
    scope: &Scope,
    spec: &NoiseSpec,
    site: usize,
) -> Result<Option<Expression>, Refusal> {
    let parsed = parse(document, &spec.hamiltonian)?;
    let names = parsed.free_indices();
    let own = match names.is_empty() {
        false => parsed.resolve_summand(scope, Some((&names, site))),
        true => (parsed.density(scope, site)).map(|density| Some(density.site)),
    };
    own.map_err(|error| refusal(document, &spec.hamiltonian, &error))
}

/// The channels of a long lattice, each with its Hamiltonian at all sites of one that stands for it.
///
/// # Errors
/// A channel that is neither a template nor a sum over sites, and as [`channels`](super::channels::channels).
pub(super) fn site_channels(
    document: &SceneDocument,
    written: &LatticeGeometry,
) -> Result<Vec<Channel>, Refusal> {
    let scope = scope(document, written, None)?;
    let channel = |spec: &NoiseSpec| {
        let mut all = Vec::new();
        for site in 0..written.length() {
            all.extend(share(document, &scope, spec, site)?);
        }
        let hamiltonian = Expression::Sum(all);
        check_code(document, &spec.hamiltonian, &hamiltonian)?;
        Ok(Channel {
            text: spec.hamiltonian.value.trim().to_owned(),
            hamiltonian,
            strength: strength(document, &scope, spec)?,
        })
    };
    document.system.noise.iter().map(channel).collect()
}

/// Where the increments of each channel enter a lattice.
///
/// # Errors
/// A channel that cannot be read at its ends.
pub(super) fn groups(
    document: &SceneDocument,
    geometry: &LatticeGeometry,
) -> Result<Vec<SiteNoise>, Refusal> {
    let (scope, sites) = (scope(document, geometry, None)?, geometry.length());
    let group = |spec: &NoiseSpec| {
        let parsed = parse(document, &spec.hamiltonian)?;
        if parsed.free_indices().is_empty() {
            return Ok(SiteNoise { sites, apart: None });
        }
        // Beyond open ends there is nothing to move.
        let (mut start, mut end) = (0, sites);
        while start < end && share(document, &scope, spec, start)?.is_none() {
            start += 1;
        }
        while start < end && share(document, &scope, spec, end - 1)?.is_none() {
            end -= 1;
        }
        Ok(SiteNoise {
            sites,
            apart: Some(start..end),
        })
    };
    document.system.noise.iter().map(group).collect()
}
