//! How noise enters a step.

use std::sync::Arc;

use leafwise_core::lattice::{LatticeGeometry, Swept};
use leafwise_core::noise::{Noise, NoisyMap, Seed, SplitNoise, SweptNoise};
use leafwise_core::part::Family;
use leafwise_core::registry::StepperPart;
use leafwise_core::system::Forces;
use leafwise_core::{BuildError, PartParameters, PoissonSystem, Registry, StepMap};

use super::Refusal;
use super::channels::{Channel, RunNoise, refusal};
use super::domain::OutOfDomain;
use super::geometry::geometry;
use super::lattice::SceneLattice;
use super::lattice_noise::{SiteTerms, groups, site_channels};
use super::site_forces::Bodies;
use super::stepping::{LatticeStepping, MapStepping, Stepping};
use crate::document::{ForcesSpec, SceneDocument, StepSpec};

/// Steps of a scene with noise: the system that its parts are made for, and the noise that makes their map the map of
/// the scene.
pub(super) struct NoisySteps<'a> {
    pub noise: RunNoise,
    /// System whose steps the parts make: of H_w where increments enter with H, else of H alone. Increments stand behind its own
    /// parameters, on a long lattice behind its own coordinates.
    pub stepped: PoissonSystem,
    /// The long lattice that the system stands for.
    pub lattice: Option<SceneLattice<'a>>,
    /// The sites of many bodies, whose channels are templates.
    bodies: Option<LatticeGeometry>,
}

impl<'a> NoisySteps<'a> {
    /// Those of a scene that has noise.
    ///
    /// # Errors
    /// What is wrong with it, underlined in the scene.
    pub fn of(
        document: &'a SceneDocument,
        system: &PoissonSystem,
        channels: Vec<Channel>,
        (lattice, bodies): (Option<&SceneLattice<'a>>, Option<&Bodies>),
    ) -> Result<Option<Self>, Refusal> {
        check_forward(document)?;
        if channels.is_empty() {
            return Ok(None);
        }
        check_strengths(document, system, &channels)?;
        let noise = RunNoise {
            way: document
                .method
                .noise
                .as_ref()
                .map_or(Noise::default(), |way| way.value),
            seed: Seed {
                seed: document.run.seed,
                first: document.run.member,
            },
            channels,
        };
        let lattice = lattice.map(|lattice| {
            let terms = SiteTerms::of_steps(noise.way, noise.channels.len());
            lattice.with_noise(terms)
        });
        let of_bodies = bodies.and_then(|bodies| bodies.stepped.clone());
        let bodies = of_bodies.as_ref().map(|_| geometry(document));
        let stepped = match (of_bodies, &lattice, system.expressions()) {
            (Some(stepped), ..) => stepped,
            (None, Some(lattice), _) => lattice.trial()?.0,
            (None, None, None) => return Ok(None),
            (None, None, Some(formulas)) => {
                let stepped = noise.stepped(formulas).map_err(|error| {
                    let first = &document.system.noise[0].hamiltonian;
                    refusal(document, first, error.to_string(), "write another channel")
                })?;
                stepped.into()
            }
        };
        Ok(Some(Self {
            noise,
            stepped,
            lattice,
            bodies,
        }))
    }

    /// Adds increments that are drawn to the steps of `method`. Its parts are made for the [stepped](Self::stepped)
    /// system.
    ///
    /// # Errors
    /// A channel without an exact flow where the noise is split, underlined in the scene.
    pub fn enter(
        &self,
        document: &SceneDocument,
        registry: &Registry,
        method: Stepping,
    ) -> Result<Stepping, Refusal> {
        let is_composed = document.method.composition.is_some();
        let (map, method): (Arc<dyn StepMap>, _) = match method {
            Stepping::Written(method) => (Arc::new(method.as_ref().clone()), Some(method)),
            Stepping::Map(stepping) => (stepping.map, stepping.method),
            Stepping::Lattice(mut stepping) => {
                let map = self.enter_sites(document, registry, &stepping)?;
                stepping.stepped = Arc::new(map.clone());
                let channels = site_channels(document, &stepping.written)?;
                let noise = RunNoise {
                    channels,
                    ..self.noise.clone()
                };
                stepping.noise = Some((noise, map));
                return Ok(Stepping::Lattice(stepping));
            }
        };
        let map: Arc<dyn StepMap> = match (self.noise.way, &self.bodies) {
            (Noise::Joint, _) => map,
            (Noise::Split, None) => Arc::new(SplitNoise::new(map, self.flows(document, registry)?)),
            (Noise::Split, Some(_)) => {
                let flows = self.flows_of_bodies(document, registry)?;
                Arc::new(SplitNoise::new(map, flows))
            }
        };
        let RunNoise {
            way,
            seed,
            channels,
        } = &self.noise;
        let map = match &self.bodies {
            None => NoisyMap::new(map, *way, channels.len(), (*seed).into()),
            Some(geometry) => {
                NoisyMap::of_sites(map, *way, groups(document, geometry)?, (*seed).into())
            }
        };
        Ok(Stepping::Map(MapStepping {
            map: Arc::new(map.clone()),
            method,
            is_composed,
            noise: Some((self.noise.clone(), map)),
        }))
    }

    /// Steps of a long lattice with increments that are drawn for its sites.
    ///
    /// # Errors
    /// As [`enter`](Self::enter).
    fn enter_sites(
        &self,
        document: &SceneDocument,
        registry: &Registry,
        stepping: &LatticeStepping,
    ) -> Result<NoisyMap, Refusal> {
        let RunNoise { way, seed, .. } = &self.noise;
        let mut map = Arc::clone(&stepping.stepped);
        let mut swept = None;
        if let (Noise::Split, Some(lattice)) = (way, &self.lattice) {
            let flows = self.flows_of_sites(document, registry, lattice)?;
            let (flows, sweeps): (Vec<_>, Vec<_>) = flows.into_iter().unzip();
            let sweeps: Option<Vec<Swept>> = sweeps.into_iter().collect();
            let own = stepping.swept().zip(sweeps);
            swept = own.and_then(|(drift, flows)| SweptNoise::new(drift, flows));
            map = Arc::new(SplitNoise::new(map, flows));
        }
        let groups = groups(document, &stepping.geometry)?;
        Ok(NoisyMap::of_sites(map, *way, groups, (*seed).into()).by_sweeps(swept))
    }

    /// The flow of each family of increments of a lattice, and its sweeps.
    ///
    /// # Errors
    /// As [`single`](Self::single).
    fn flows_of_sites(
        &self,
        document: &SceneDocument,
        registry: &Registry,
        lattice: &SceneLattice<'_>,
    ) -> Result<Vec<SiteFlow>, Refusal> {
        let flows = SiteTerms::of_flows(self.noise.channels.len()).into_iter();
        let flow = |terms: SiteTerms| {
            let channel = terms.channel();
            let lattice = lattice.with_flow(terms);
            let mut swept = None;
            let flow = exact_flow(registry, |part| {
                let flow = part.build_on_lattice(&lattice, &PartParameters::new())?;
                swept = flow.swept;
                Ok(flow.map)
            });
            Ok((self.single(document, channel, flow)?, swept))
        };
        flows.map(flow).collect()
    }

    /// The same of many bodies: flows of the lattice of their sites without H.
    ///
    /// # Errors
    /// As [`single`](Self::single).
    fn flows_of_bodies(
        &self,
        document: &SceneDocument,
        registry: &Registry,
    ) -> Result<Vec<Arc<dyn StepMap>>, Refusal> {
        let alone = at_rest(document);
        let Some(lattice) = SceneLattice::of(&alone)? else {
            let first = &document.system.noise[0].hamiltonian;
            let message = "noise = \"split\" needs a bracket that repeats from site to site";
            let help = "write noise = \"joint\" into [method]";
            return Err(refusal(document, first, message.to_owned(), help));
        };
        let terms = SiteTerms::of_steps(self.noise.way, self.noise.channels.len());
        let lattice = lattice.with_noise(terms);
        let flows = self.flows_of_sites(document, registry, &lattice)?;
        Ok(flows.into_iter().map(|(flow, _)| flow).collect())
    }

    /// The flow of a channel, where it is one.
    ///
    /// # Errors
    /// Where there is none, and where it comes apart into several, underlined in the scene.
    fn single(
        &self,
        document: &SceneDocument,
        channel: usize,
        flow: Result<Arc<dyn StepMap>, BuildError>,
    ) -> Result<Arc<dyn StepMap>, Refusal> {
        let refuse = |reason: String| {
            let message = format!(
                "noise = \"split\" needs the exact flow of every channel, and `{}` has none: {reason}",
                self.noise.channels[channel].text
            );
            let is_of_sites = self.lattice.is_some() || self.bodies.is_some();
            let help = match is_of_sites {
                false => {
                    "write noise = \"joint\" into [method], or channels that are single pieces, such as coordinates"
                }
                true => {
                    "write noise = \"joint\" into [method], or channels that commute with those of other sites"
                }
            };
            let specs = &document.system.noise;
            let spec = &specs[channel.min(specs.len() - 1)].hamiltonian;
            refusal(document, spec, message, help)
        };
        match flow {
            Ok(map) if pieces(map.as_ref()) == 1 => Ok(map),
            Ok(map) => Err(refuse(match pieces(map.as_ref()) {
                0 => "nothing moves under it".to_owned(),
                pieces if self.lattice.is_some() => format!(
                    "its flows at neighbouring sites do not commute, and split into {pieces} pieces"
                ),
                pieces => {
                    format!("it splits into {pieces} pieces whose flows do not commute")
                }
            })),
            Err(error) => Err(refuse(error.to_string())),
        }
    }

    /// The flow of w_j σ_k H_k for every parameter w_j.
    fn flows(
        &self,
        document: &SceneDocument,
        registry: &Registry,
    ) -> Result<Vec<Arc<dyn StepMap>>, Refusal> {
        let channels = &self.noise.channels;
        let formulas = self.stepped.expressions();
        let formulas = formulas.expect("noise stands beside formulas");
        let count = Noise::Split.parameters(channels.len());
        let own = formulas.parameters().len() - count;
        let flow = |at: usize| {
            let channel = at.min(count - 1 - at);
            let term = channels[channel].times(own + at);
            let alone = formulas
                .with_forces(Forces::default())
                .and_then(|alone| alone.with_hamiltonian(term));
            let map = alone.and_then(|alone| {
                let alone = alone.into();
                exact_flow(registry, |part| part.build(&alone, &PartParameters::new()))
            });
            self.single(document, channel, map)
        };
        (0..count).map(flow).collect()
    }
}

/// A scene whose system nothing moves but noise.
fn at_rest(document: &SceneDocument) -> SceneDocument {
    let mut rests = document.clone();
    let system = &mut rests.system;
    system.hamiltonian.value = "0".to_owned();
    system.casimirs.clear();
    system.matrices.clear();
    system.forces = ForcesSpec::default();
    rests.run.record.observables.clear();
    rests
}

/// The flow of a family of increments, and its sweeps where it has any.
type SiteFlow = (Arc<dyn StepMap>, Option<Swept>);

/// How many flows a map is a product of.
fn pieces(map: &dyn StepMap) -> usize {
    map.abilities().factored.map_or(0, |own| own.pieces)
}

/// The map of the registry's stepper that is a product of exact flows.
fn exact_flow<M: ?Sized>(
    registry: &Registry,
    build: impl FnOnce(StepperPart) -> Result<Arc<M>, BuildError>,
) -> Result<Arc<M>, BuildError> {
    let parts = registry.parts();
    let splitting = parts
        .iter()
        .find(|info| info.family == Some(Family::Splitting));
    let missing = || BuildError::DoesNotFit {
        part: "noise",
        reason: "no stepper of this program is a product of exact flows".to_owned(),
    };
    let name = splitting.ok_or_else(missing)?.name;
    build(registry.stepper(name)?)
}

/// Refuses strengths that are not positive at the parameters' values.
fn check_strengths(
    document: &SceneDocument,
    system: &PoissonSystem,
    channels: &[Channel],
) -> Result<(), Refusal> {
    let parameters = system.parameter_values();
    for (channel, spec) in channels.iter().zip(&document.system.noise) {
        let value = channel.strength.evaluate(&[], &parameters);
        if !(value > 0.0 && value.is_finite()) {
            return Err(refusal(
                document,
                &spec.strength,
                OutOfDomain::Strength(value).to_string(),
                "remove the channel, or write a positive number or a formula of the parameters that is positive",
            ));
        }
    }
    Ok(())
}

/// Refuses steps backward in time, which has no meaning for noise.
fn check_forward(document: &SceneDocument) -> Result<(), Refusal> {
    let step = &document.method.step;
    if document.system.noise.is_empty() || step.time_step() > 0.0 {
        return Ok(());
    }
    let place = match step {
        StepSpec::TimeStep(step) => step.place(),
        StepSpec::Factors { h, .. } => h.place(),
    };
    Err(Box::new(document.diagnostic(
        &place,
        "noise runs forward in time, and this step is negative",
        "here",
        Some("write a positive step".to_owned()),
    )))
}

/// Refuses what a scene is asked for that its noise would make something else: `what` is not of random motion.
///
/// # Errors
/// Where the scene has noise.
pub fn refuse_noise(document: &SceneDocument, what: &str, help: &str) -> Result<(), Refusal> {
    match document.system.noise.first() {
        None => Ok(()),
        Some(first) => Err(refusal(
            document,
            &first.hamiltonian,
            format!("{what} of a system with noise"),
            help,
        )),
    }
}
