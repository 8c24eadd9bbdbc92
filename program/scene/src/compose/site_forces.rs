//! Forces and noise at one site of many bodies.

use leafwise_core::lattice::{LatticeGeometry, TemplateReach};
use leafwise_core::pairs::{BodyFunction, BodySum, BodySystem};
use leafwise_core::system::Forces;
use leafwise_core::{PoissonSystem, SystemFormulas};
use leafwise_expression::Expression;

use super::Refusal;
use super::definitions::scope;
use super::forces::{check_forces, check_metric_of_sites, forces};
use super::geometry::{moving, one_site};
use super::lattice_noise::SiteTerms;
use super::names::{coordinate_names, function, parse};
use super::reach::entries_reach;
use crate::document::{ByCoordinate, ComponentsSpec, Located, MetricSpec, SceneDocument};

/// Many bodies beside their sums over pairs.
#[derive(Clone, Debug)]
pub struct Bodies {
    /// Tensor and forces of one site.
    pub site: SystemFormulas,
    /// With noise, the system whose steps are made: increments are families at rest behind the scene's own.
    pub stepped: Option<PoissonSystem>,
}

/// Forces and noise of a scene, each of the coordinates of one site.
pub(super) struct SiteForces {
    /// η, damping and friction, in the coordinates of a site.
    pub forces: Forces,
    /// Terms of noise within H's steps, and its increments as families at rest.
    noise: Option<SiteTerms>,
}

impl SiteForces {
    /// Those of a scene, or the first formula that looks at other sites, with its kind in words.
    ///
    /// # Errors
    /// A formula that cannot be read, underlined in the scene.
    pub fn of(document: &SceneDocument) -> Result<Result<Self, Apart<'_>>, Refusal> {
        if let Some(apart) = apart(document)? {
            return Ok(Err(apart));
        }
        let site = one_site(document);
        let scope = scope(document, &site, None)?;
        let names = coordinate_names(document, &site);
        let moving = moving(document, &site);
        let way = document.method.noise.as_ref();
        let way = way.map(|way| way.value).unwrap_or_default();
        let channels = document.system.noise.len();
        Ok(Ok(Self {
            forces: forces(document, &scope, &names[..moving], names.len())?,
            noise: (channels > 0).then(|| SiteTerms::of_steps(way, channels)),
        }))
    }

    /// The system whose steps are made with noise: `own` with increments as families at rest, and their terms in H.
    ///
    /// H itself is that of `hamiltonian`, with so many families behind the others.
    ///
    /// # Errors
    /// A channel that cannot be read.
    pub fn stepped(
        &self,
        document: &SceneDocument,
        own: &BodySystem,
        hamiltonian: impl FnOnce(usize) -> Result<Option<BodyFunction>, Refusal>,
    ) -> Result<Option<BodySystem>, Refusal> {
        let Some(noise) = &self.noise else {
            return Ok(None);
        };
        let site = one_site(document);
        let extended = noise.extended(&site);
        let further = extended.families.len() - own.shape.families;
        let scope = scope(document, &site, None)?;
        let terms = noise.at(document, &scope, &extended, 0).map_err(|error| {
            let first = &document.system.noise[0].hamiltonian;
            let place = document.place_in_formula(first, 0..first.value.len());
            Box::new(document.diagnostic(&place, error.to_string(), "here", None))
        })?;
        let Some(mut hamiltonian) = hamiltonian(further)? else {
            return Ok(None);
        };
        if !terms.is_empty() {
            let all = Expression::Variable(hamiltonian.sums.len());
            hamiltonian.sums.push(BodySum {
                site: Expression::Sum(terms),
                pair: 0.into(),
            });
            hamiltonian.outer = Expression::Sum(vec![hamiltonian.outer, all]);
        }
        let mut stepped = own.clone();
        stepped.hamiltonian = hamiltonian;
        stepped.shape.families += further;
        for family in own.shape.families..stepped.shape.families {
            let name = &extended.families[family].0;
            let sites = 0..own.shape.sites;
            stepped
                .variables
                .extend(sites.map(|i| format!("{name}[{i}]")));
        }
        // Casimirs are those of the system that is watched.
        stepped.casimirs.clear();
        stepped.forces = self.forces.clone().with_resting(stepped.shape.families);
        Ok(Some(stepped))
    }

    /// Refuses damping whose rate or metric is negative in the initial state.
    ///
    /// # Errors
    /// The formula underlined in the scene.
    pub fn check(
        &self,
        document: &SceneDocument,
        site: &SystemFormulas,
        (initial, lattice): (&[f64], &LatticeGeometry),
    ) -> Result<(), Refusal> {
        let first = initial.iter().step_by(lattice.length()).copied();
        let first: Vec<f64> = first.collect();
        let site = PoissonSystem::from(site.clone());
        check_forces(document, &site, &first)?;
        let whole = scope(document, lattice, None)?;
        let at_start = (initial, &*site.parameter_values());
        check_metric_of_sites(document, &whole, at_start, lattice)
    }
}

/// A formula of forces or noise, and its kind in words.
pub(super) type Apart<'a> = (&'a Located<String>, &'static str);

/// The first of a scene's forces and noise that is no template of single sites.
///
/// # Errors
/// A formula that cannot be read, underlined in the scene.
fn apart(document: &SceneDocument) -> Result<Option<Apart<'_>>, Refusal> {
    let spec = &document.system.forces;
    let is_of_a_site = |entries: &ByCoordinate| {
        let reach = entries_reach(document, TemplateReach::default(), entries);
        reach.is_ok_and(|reach| reach.has_sites_apart())
    };
    let (one_form, friction) = (spec.one_form.as_ref(), spec.friction.as_ref());
    let components = [(one_form, "a force of `forces`"), (friction, "`friction`")];
    for (own, kind) in components {
        let Some(own) = own else { continue };
        let is_template = match &own.value {
            ComponentsSpec::Named(named) => is_of_a_site(named),
            ComponentsSpec::All(_) => false,
        };
        if let Some(first) = own.value.formulas().first().filter(|_| !is_template) {
            return Ok(Some((first, kind)));
        }
    }
    if let Some(torque) = &spec.torque {
        let own = [&torque.value.body, &torque.value.space];
        if let Some([first, ..]) = own.into_iter().flatten().next() {
            return Ok(Some((first, "a torque")));
        }
    }
    if let Some(damping) = &spec.damping {
        let is_template = match damping.metric.as_ref().map(|metric| &metric.value) {
            None => true,
            Some(MetricSpec::Named(named)) => is_of_a_site(named),
            Some(MetricSpec::Diagonal(_) | MetricSpec::Rows(_)) => false,
        };
        let scope = scope(document, &one_site(document), None)?;
        let is_of_parameters = parse(document, &damping.rate)?.offsets_from(&[]).is_ok()
            && function(document, &scope, &damping.rate)?
                .variables()
                .is_empty();
        if !(is_template && is_of_parameters) {
            return Ok(Some((&damping.rate, "`damping`")));
        }
    }
    for channel in &document.system.noise {
        let parsed = parse(document, &channel.hamiltonian)?;
        let reach = TemplateReach::default().with_channel(&parsed);
        if !reach.is_ok_and(|reach| reach.has_sites_apart()) {
            return Ok(Some((&channel.hamiltonian, "`noise`")));
        }
    }
    Ok(None)
}
