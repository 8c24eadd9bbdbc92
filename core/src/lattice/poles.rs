//! Poles of a lattice's energy, which no step crosses.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Graph, Term};

use super::observables::code;
use super::program::LatticeWorker;
use super::sites::SiteNumbers;
use super::source::LatticeSource;
use crate::error::{BuildError, StepError};
use crate::solver::{LOOKS, MakeCheck, StepCheck, StepMap, WithoutPoles, is_pole};

/// Of every site the product of its energy's denominators, and the squares of its gradient.
#[derive(Debug)]
struct LatticePoles {
    numbers: SiteNumbers,
}

const DENOMINATOR: usize = 0;
const SQUARES: usize = 1;

impl LatticePoles {
    /// Those of a lattice's energy; `None` where all denominators are of one sign.
    ///
    /// # Errors
    /// [`BuildError`] where the energy is no sum over sites, or has no code.
    fn of(source: &dyn LatticeSource, parameters: usize) -> Result<Option<Self>, BuildError> {
        let mut has_poles = false;
        let mut of_site = |proxy: &_, site: usize, graph: &mut Graph, x: &[Term]| {
            let densities = source.densities(proxy, site)?;
            let mut product = graph.one();
            let mut squares = graph.zero();
            if let Some(energy) = densities.first() {
                let energy = code(graph, &energy.site, x)?;
                let factors = graph.denominators(std::slice::from_ref(&energy))?;
                for factor in &factors {
                    product = graph.multiply(&product, factor);
                }
                if !factors.is_empty() {
                    has_poles = true;
                    for slope in graph.gradient(&energy, x.len())? {
                        let square = graph.multiply(&slope, &slope);
                        squares = graph.add(&squares, &square);
                    }
                }
            }
            Ok(vec![product, squares])
        };
        let numbers = SiteNumbers::compile(source.geometry(), parameters, &mut of_site)?;
        Ok(has_poles.then_some(Self { numbers }))
    }
}

impl WithoutPoles {
    /// [`WithoutPoles::of`] for a long lattice.
    ///
    /// # Errors
    /// [`BuildError`] where the energy is no sum over sites, or has no code.
    pub fn of_lattice(
        source: &dyn LatticeSource,
        parameters: usize,
        map: Arc<dyn StepMap>,
    ) -> Result<Arc<dyn StepMap>, BuildError> {
        Ok(match LatticePoles::of(source, parameters)? {
            None => map,
            Some(poles) => Self::checked(map, Arc::new(poles)),
        })
    }
}

impl MakeCheck for LatticePoles {
    fn make(self: Arc<Self>, lanes: usize, parameters: &[f64]) -> Box<dyn StepCheck> {
        let worker = |lane: usize| {
            let own = parameters.iter().skip(lane).step_by(lanes).copied();
            self.numbers.worker(&own.collect::<Vec<_>>())
        };
        Box::new(Crossings {
            workers: (0..lanes).map(worker).collect(),
            before: vec![0.0; self.numbers.sites()],
            poles: self,
        })
    }
}

/// The denominators before and after a step.
struct Crossings {
    poles: Arc<LatticePoles>,
    workers: Vec<LatticeWorker>,
    before: Vec<f64>,
}

impl Crossings {
    /// Evaluates the numbers of a lane's sites at a part of its way.
    fn look(&mut self, lane: usize, (x, increment): (&[f64], &[f64]), part: f64) {
        let lanes = self.workers.len();
        let at = (0..x.len() / lanes).map(|row| {
            let at = row * lanes + lane;
            x[at] + part * increment[at]
        });
        self.poles.numbers.evaluate(&mut self.workers[lane], at);
    }

    fn of_sites(&self, lane: usize, number: usize) -> &[f64] {
        self.poles.numbers.of_sites(&self.workers[lane], number)
    }

    /// Sites whose denominators changed their sign.
    fn changed(&mut self, lane: usize, way: (&[f64], &[f64])) -> Vec<usize> {
        self.look(lane, way, 0.0);
        let numbers = &self.poles.numbers;
        let before = numbers.of_sites(&self.workers[lane], DENOMINATOR);
        self.before.copy_from_slice(before);
        self.look(lane, way, 1.0);
        let signs = self.before.iter().zip(self.of_sites(lane, DENOMINATOR));
        let changed = signs
            .enumerate()
            .filter(|(_, (a, b))| a.signum() != b.signum());
        changed.map(|(site, _)| site).collect()
    }
}

impl StepCheck for Crossings {
    fn check(&mut self, x: &[f64], increment: &[f64], outcome: &mut [Result<(), StepError>]) {
        let way = (x, increment);
        for (lane, outcome) in outcome.iter_mut().enumerate() {
            if outcome.is_err() {
                continue;
            }
            let crossed = self.changed(lane, way).into_iter().find(|site| {
                // Without bounds of its rounding errors the gradient is not looked at any nearer.
                is_pole(&LOOKS[..2], |part| {
                    self.look(lane, way, part);
                    let squares = self.of_sites(lane, SQUARES)[*site];
                    (self.of_sites(lane, DENOMINATOR)[*site], libm::sqrt(squares))
                })
            });
            if let Some(site) = crossed {
                *outcome = Err(StepError::Pole {
                    denominator: format!("a denominator of the energy of site {site}"),
                });
            }
        }
    }
}
