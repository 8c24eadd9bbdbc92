//! Forces and noise at one site of many bodies.

use leafwise_core::lattice::{LatticeGeometry, TemplateReach};
use leafwise_core::pairs::BodySystem;
use leafwise_core::system::Forces;
use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};
use leafwise_expression::Expression;

use super::Refusal;
use super::definitions::scope;
use super::forces::{check_forces, check_metric_of_sites, forces};
use super::geometry::{moving, one_site};
use super::lattice_noise::SiteTerms;
use super::names::{coordinate_names, function, parse};
use super::reach::entries_reach;
use crate::document::{ComponentsSpec, Located, MetricSpec, SceneDocument};

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

    /// The system whose steps are made with noise: `own` with increments as families at rest, and with their terms in H.
    /// `None` without noise.
    ///
    /// # Errors
    /// A channel that cannot be read.
    pub fn stepped(
        &self,
        document: &SceneDocument,
        own: &BodySystem,
    ) -> Result<Option<BodySystem>, Refusal> {
        let Some(noise) = &self.noise else {
            return Ok(None);
        };
        let site = one_site(document);
        let extended = noise.extended(&site);
        let scope = scope(document, &site, None)?;
        let refused = |error: BuildError| {
            let first = &document.system.noise[0].hamiltonian;
            let place = document.place_in_formula(first, 0..first.value.len());
            document.diagnostic(&place, error.to_string(), "here", None)
        };
        let terms = noise.at(document, &scope, &extended, 0).map_err(refused)?;
        let further = extended.families[own.shape.families..].iter();
        let names: Vec<String> = further.map(|(name, _)| name.clone()).collect();
        let stepped = own.clone().with_resting(&names, Expression::Sum(terms));
        Ok(Some(stepped.map_err(refused)?))
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

/// A formula that is no template of one site.
pub(super) struct Apart<'a> {
    pub formula: &'a Located<String>,
    /// The kind of it in words.
    pub kind: &'static str,
    /// A template of that kind.
    pub template: &'static str,
}

/// The first of a scene's forces and noise that is no template of single sites.
///
/// # Errors
/// A formula that cannot be read, underlined in the scene.
fn apart(document: &SceneDocument) -> Result<Option<Apart<'_>>, Refusal> {
    let found = |formula, kind, template| {
        Ok(Some(Apart {
            formula,
            kind,
            template,
        }))
    };
    let spec = &document.system.forces;
    let is_of_a_site = |entries: &[(Located<String>, Located<String>)]| {
        let reach = entries_reach(document, TemplateReach::default(), entries);
        reach.is_ok_and(|reach| reach.has_sites_apart())
    };
    let of_forces = "forces = { \"q[i]\" = \"0.1*p[i]\" }";
    let of_friction = "friction = { \"p[i]\" = \"-0.1*p[i]\" }";
    for (own, kind, template) in [
        (&spec.one_form, "a force of `forces`", of_forces),
        (&spec.friction, "`friction`", of_friction),
    ] {
        let Some(own) = own else { continue };
        let is_template = match &own.value {
            ComponentsSpec::Named(named) => is_of_a_site(named),
            ComponentsSpec::All(_) => false,
        };
        if let Some(first) = own.value.formulas().first().filter(|_| !is_template) {
            return found(first, kind, template);
        }
    }
    if let Some(torque) = &spec.torque {
        let own = [&torque.value.body, &torque.value.space];
        if let Some([first, ..]) = own.into_iter().flatten().next() {
            return found(first, "a torque", of_forces);
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
            let template = "damping = { rate = \"0.1\", metric = { \"q[i]\" = \"1\" } }";
            let metric = damping.metric.as_ref().map(|metric| &metric.value);
            let entry = match metric {
                Some(MetricSpec::Named(named)) if is_of_parameters => named
                    .iter()
                    .find(|entry| !is_of_a_site(std::slice::from_ref(entry))),
                _ => None,
            };
            let formula = entry.map_or(&damping.rate, |(_, formula)| formula);
            return found(formula, "`damping`", template);
        }
    }
    for channel in &document.system.noise {
        let parsed = parse(document, &channel.hamiltonian)?;
        let reach = TemplateReach::default().with_channel(&parsed);
        if !reach.is_ok_and(|reach| reach.has_sites_apart()) {
            let template = "noise = [{ hamiltonian = \"q[i]\", strength = \"0.1\" }]";
            return found(&channel.hamiltonian, "`noise`", template);
        }
    }
    Ok(None)
}
