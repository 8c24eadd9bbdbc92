//! Poles of a lattice's equations of motion, which no step crosses.
//!
//! Denominators are written and evaluated site by site. Where one changes its sign, the field of a proxy
//! that holds the neighbourhood of the site tells whether there is a pole.

use std::sync::Arc;

use leafwise_expression::syntax::AXES;
use leafwise_expression::{Graph, Term};

use super::geometry::{LatticeGeometry, Proxy, SiteClass, site_classes};
use super::observables::code;
use super::program::LatticeEvaluator;
use super::sites::{SiteNumbers, proxy_of_numbers};
use super::source::LatticeSource;
use crate::error::{BuildError, StepError};
use crate::solver::{Crossing, MakeCheck, StepCheck, StepMap, WithoutPoles, looks};
use crate::system::PoissonSystem;

/// Longest text of a denominator in a message.
const MOST_PARTS: usize = 60;

/// The denominators of every site's energy and tensor whose signs can change.
#[derive(Debug)]
struct LatticePoles {
    geometry: LatticeGeometry,
    proxy: LatticeGeometry,
    classes: Vec<SiteClass>,
    graph: Graph,
    /// The field of the proxy.
    field: Vec<Term>,
    /// Of each site of the proxy.
    denominators: Vec<Vec<Term>>,
    numbers: SiteNumbers,
    looks: &'static [f64],
    parameters: Vec<String>,
}

impl LatticePoles {
    /// `None` where all denominators are of one sign.
    ///
    /// # Errors
    /// [`BuildError`] where the energy is no sum over sites, or has no code.
    fn of(source: &dyn LatticeSource) -> Result<Option<Self>, BuildError> {
        let geometry = source.geometry().clone();
        // The sites of a denominator, and those that move by it.
        let reach = source.reach()?.of_times(1, [true; AXES]);
        let (proxy, width) = proxy_of_numbers(&geometry, reach)?;
        let system = source.write_out(&proxy)?;
        let mut graph = Graph::compilable();
        let x: Vec<Term> = (0..proxy.dimension()).map(|i| graph.input(i)).collect();
        let mut all = Vec::new();
        for site in 0..proxy.length() {
            all.extend(functions_of_site(
                source,
                &system,
                &proxy,
                site,
                (&mut graph, &x),
            )?);
        }
        if graph.denominators(&all)?.is_empty() {
            return Ok(None);
        }
        let mut graph = Graph::compilable();
        let x: Vec<Term> = (0..proxy.dimension()).map(|i| graph.input(i)).collect();
        let mut denominators = Vec::with_capacity(proxy.length());
        for site in 0..proxy.length() {
            let functions = functions_of_site(source, &system, &proxy, site, (&mut graph, &x))?;
            denominators.push(graph.denominators(&functions)?);
        }
        let all: Vec<Term> = denominators.iter().flatten().cloned().collect();
        let parameters = system.parameters().iter().map(|p| p.name.clone());
        let parameters: Vec<String> = parameters.collect();
        let mut of_site = |_: &_, site: usize, own: &mut Graph, x: &[Term]| {
            Ok(own.import(&graph, &denominators[site], x)?)
        };
        let numbers = SiteNumbers::compile((&geometry, reach), parameters.len(), &mut of_site)?;
        let field = match system.expressions() {
            Some(formulas) => formulas.vector_field(&mut graph, &x)?,
            None => Vec::new(),
        };
        graph.unless_refused(())?;
        let written = Proxy {
            geometry: &proxy,
            width,
        };
        let classes = site_classes(&geometry, written);
        Ok(Some(Self {
            classes,
            looks: looks(&graph, &all),
            geometry,
            proxy,
            graph,
            field,
            denominators,
            numbers,
            parameters,
        }))
    }

    /// The site of the proxy that stands for a site.
    fn proxy_site(&self, site: usize) -> usize {
        let (mut classes, place) = (self.classes.iter(), self.geometry.place(site));
        let class = classes.find(|class| class.sites.has(place));
        class.expect("every site is in a class").proxy
    }

    /// The coordinate that stands at one of the proxy's when its site `here` stands at `site`; `None` beyond an
    /// open end.
    fn coordinate(&self, of_proxy: usize, here: usize, site: usize) -> Option<usize> {
        let (family, at) = self.proxy.locate(of_proxy);
        let (start, length) = (
            self.geometry.offsets()[family],
            self.geometry.families[family].1,
        );
        let other = self.geometry.beside(site, self.proxy.shift(here, at));
        other.filter(|at| *at < length).map(|at| start + at)
    }

    fn written(&self, denominator: &Term, here: usize, site: usize) -> String {
        let name = |of_proxy| match self.coordinate(of_proxy, here, site) {
            Some(coordinate) => self.geometry.name(coordinate),
            None => String::new(),
        };
        let names: Vec<String> = (0..self.proxy.dimension()).map(name).collect();
        match self.graph.formula(denominator, MOST_PARTS) {
            Some(formula) => formula.written(&names, &self.parameters),
            None => format!(
                "a long denominator of site {}",
                self.geometry.site_name(site)
            ),
        }
    }
}

/// The energy of a site, and the entries of the tensor in the rows of its coordinates.
fn functions_of_site(
    source: &dyn LatticeSource,
    system: &PoissonSystem,
    proxy: &LatticeGeometry,
    site: usize,
    (graph, x): (&mut Graph, &[Term]),
) -> Result<Vec<Term>, BuildError> {
    let densities = source.densities(proxy, site)?;
    let energy = densities.first().map(|energy| &energy.site);
    let entries = system.expressions().into_iter().flat_map(|s| s.tensor());
    let entries = entries.filter(|((row, _), _)| proxy.locate(*row).1 == site);
    let functions = energy.into_iter().chain(entries.map(|(_, entry)| entry));
    functions.map(|function| code(graph, function, x)).collect()
}

impl WithoutPoles {
    /// [`WithoutPoles::of`] for a long lattice.
    ///
    /// # Errors
    /// [`BuildError`] where the energy is no sum over sites, or has no code.
    pub fn of_lattice(
        source: &dyn LatticeSource,
        map: Arc<dyn StepMap>,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        Ok(match LatticePoles::of(source)? {
            None => map,
            Some(poles) => Self::checked(map, Arc::new(poles)),
        })
    }
}

impl MakeCheck for LatticePoles {
    fn make(self: Arc<Self>, lanes: usize, parameters: &[f64]) -> Box<dyn StepCheck> {
        let of_lane = |lane: usize| {
            let own = parameters.iter().skip(lane).step_by(lanes).copied();
            let own: Vec<f64> = own.collect();
            (self.numbers.evaluator(&own), own)
        };
        Box::new(Crossings {
            evaluators: (0..lanes).map(of_lane).collect(),
            before: vec![0.0; self.numbers.sites() * self.numbers.count()],
            poles: self,
        })
    }
}

/// The denominators at two parts of a step, one after the other.
struct Crossings {
    poles: Arc<LatticePoles>,
    /// With the parameters of the lane.
    evaluators: Vec<(LatticeEvaluator, Vec<f64>)>,
    before: Vec<f64>,
}

/// x and Δ of all lanes.
type Way<'a> = (&'a [f64], &'a [f64]);

impl Crossings {
    /// Evaluates the denominators of a lane at a part of its step.
    fn look(&mut self, lane: usize, (x, increment): Way<'_>, part: f64) {
        let lanes = self.evaluators.len();
        let at = (0..x.len() / lanes).map(|row| {
            let at = row * lanes + lane;
            x[at] + part * increment[at]
        });
        self.poles
            .numbers
            .evaluate(&mut self.evaluators[lane].0, at);
    }

    fn keep(&mut self, lane: usize) {
        let numbers = &self.poles.numbers;
        let sites = numbers.sites();
        for (which, before) in self.before.chunks_exact_mut(sites).enumerate() {
            before.copy_from_slice(numbers.of_sites(&self.evaluators[lane].0, which));
        }
    }

    /// The first denominator at whose change of sign the field has a pole.
    fn pole(&mut self, lane: usize, way: Way<'_>) -> Option<StepError> {
        let looks = self.poles.looks;
        self.look(lane, way, looks[0]);
        for parts in looks.windows(2) {
            self.keep(lane);
            self.look(lane, way, parts[1]);
            let numbers = &self.poles.numbers;
            let sites = numbers.sites();
            for (which, before) in self.before.chunks_exact(sites).enumerate() {
                let after = numbers.of_sites(&self.evaluators[lane].0, which);
                for site in 0..sites {
                    let keeps = before[site].signum() == after[site].signum();
                    if !keeps && self.is_pole(lane, way, (site, which), (parts[0], parts[1])) {
                        let here = self.poles.proxy_site(site);
                        let denominator = &self.poles.denominators[here][which];
                        return Some(StepError::Pole {
                            denominator: self.poles.written(denominator, here, site),
                            before: before[site],
                            after: after[site],
                        });
                    }
                }
            }
        }
        None
    }

    fn is_pole(
        &self,
        lane: usize,
        (x, increment): Way<'_>,
        (site, which): (usize, usize),
        between: (f64, f64),
    ) -> bool {
        let poles = &self.poles;
        let (lanes, here) = (self.evaluators.len(), poles.proxy_site(site));
        let around = |values: &[f64]| {
            let of_proxy = 0..poles.proxy.dimension();
            let value = |coordinate: usize| values[coordinate * lanes + lane];
            of_proxy
                .map(|at| poles.coordinate(at, here, site).map_or(0.0, value))
                .collect()
        };
        let crossing = Crossing {
            graph: &poles.graph,
            field: &poles.field,
            denominator: &poles.denominators[here][which],
            parameters: self.evaluators[lane].1.clone(),
            start: around(x),
            increment: around(increment),
        };
        crossing.is_pole(between)
    }
}

impl StepCheck for Crossings {
    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            if outcome.is_ok()
                && let Some(pole) = self.pole(lane, (x, increment))
            {
                *outcome = Err(pole);
            }
        }
    }
}
