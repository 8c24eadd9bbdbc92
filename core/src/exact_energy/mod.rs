//! Steps that keep the energy of the first state, by multiples of Casimirs.
//!
//! H − Σ λ_c C_c has the motion of H for all λ; its steps differ. Each step takes λ with H(x_{k+1}(λ)) = H(x_0).
//!
//! Each is a Poisson map, so that the orbit keeps H and every Casimir to round-off. λ depends on the state: as a whole this
//! is no Poisson map. Cf. E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, section IV.4: a projection keeps the
//! same values, and not the leaf's geometry.

mod lane;
mod line;
mod search;

use std::sync::Arc;

use leafwise_expression::Expression;

use crate::error::{BuildError, StepError};
use crate::solver::{MapAbilities, MapProperties, SolverStatistics, StepMap, Stepper, Structure};
use crate::system::{Parameter, PoissonSystem, SystemFormulas, SystemInvariants};
use crate::walk::column;
use lane::LaneOfEnergy;

/// The name of the key, in messages.
const NAME: &str = "energy = \"exact\"";

/// The system whose steps are taken: H less a multiple of each Casimir, whose multiples are parameters behind its own, all 0.
/// H itself is less the multiples of [`SystemFormulas::energy_casimir`], from where the search begins.
///
/// # Errors
/// [`BuildError::NotMade`] without a Casimir, or with forces.
pub fn with_multiples(system: &SystemFormulas) -> Result<SystemFormulas, BuildError> {
    let refuse = |reason: &str| {
        Err(BuildError::NotMade {
            part: NAME,
            reason: reason.to_owned(),
        })
    };
    if system.casimirs().is_empty() {
        return refuse(
            "the system declares no Casimirs whose multiples could correct the energy; take a shorter step or a \
             higher order",
        );
    }
    if !system.forces().is_empty() {
        return refuse("forces change the energy; take them out, or leave `energy` out");
    }
    let own = system.parameters().len();
    let base = match system.energy_casimir()? {
        Some(shorter) => system.with_hamiltonian(shorter)?,
        None => system.clone(),
    };
    let casimirs = system.casimirs().iter();
    let terms = casimirs.enumerate().map(|(at, casimir)| {
        let multiple = Expression::Parameter(own + at);
        let product = Expression::Product(vec![multiple, casimir.expression.clone()]);
        Expression::Negate(Box::new(product))
    });
    let terms: Vec<Expression> = terms.collect();
    let further = (0..terms.len()).map(|at| Parameter {
        name: format!("multiple of Casimir {}", at + 1),
        // Of no special value: what parts are chosen by has to see every Casimir.
        value: 0.0625 * (at + 1) as f64,
    });
    base.with_parameters(further)
        .with_perturbation(Expression::Sum(terms))
}

/// A map of the system [with multiples](with_multiples), which finds them in each step.
pub struct ExactEnergy {
    map: Arc<dyn StepMap>,
    system: PoissonSystem,
    multiples: usize,
}

impl ExactEnergy {
    /// Steps of `map`, whose last parameters are the multiples of the Casimirs of `system`.
    ///
    /// # Errors
    /// [`BuildError::NotMade`] for a map that is no Poisson map.
    pub fn new(map: Arc<dyn StepMap>, system: PoissonSystem) -> Result<Self, BuildError> {
        if map.properties().structure != Structure::Exact {
            return Err(BuildError::NotMade {
                part: NAME,
                reason: format!(
                    "the steps of {} do not keep Casimirs to round-off; take an exact realization",
                    map.describe()
                ),
            });
        }
        let multiples = system.casimir_names().len();
        Ok(Self {
            map,
            system,
            multiples,
        })
    }
}

impl StepMap for ExactEnergy {
    fn dimension(&self) -> usize {
        self.map.dimension()
    }

    fn properties(&self) -> MapProperties {
        let MapProperties { order, .. } = self.map.properties();
        MapProperties {
            order,
            structure: Structure::Leaves,
            self_adjoint: Some(false),
        }
    }

    fn describe(&self) -> String {
        let which = match self.multiples {
            1 => "a multiple of the Casimir",
            _ => "multiples of the Casimirs",
        };
        format!("{} with exact energy by {which}", self.map.describe())
    }

    fn abilities(&self) -> MapAbilities<'_> {
        self.map.abilities().kernels_alone()
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let lane = |lane: usize| {
            let mut own = column(parameters, lane, lanes);
            let invariants = SystemInvariants::new(&self.system, &own);
            own.resize(own.len() + self.multiples, 0.0);
            LaneOfEnergy {
                stepper: self.map.stepper(1, &own, epsilon, h),
                map: Arc::clone(&self.map),
                step_sizes: (epsilon, h),
                invariants: invariants.expect("it was evaluated when the map was made"),
                own: own.len() - self.multiples,
                parameters: own,
                target: f64::NAN,
                values: vec![0.0; 1 + self.multiples],
                state: vec![0.0; self.map.dimension()],
                spent: SolverStatistics::default(),
                signs: [false; 2],
            }
        };
        Box::new(ExactEnergyStepper {
            lanes: (0..lanes).map(lane).collect(),
            statistics: SolverStatistics::default(),
        })
    }
}

/// One thread's steps, lane after lane.
struct ExactEnergyStepper {
    lanes: Vec<LaneOfEnergy>,
    statistics: SolverStatistics,
}

impl Stepper for ExactEnergyStepper {
    fn increment(
        &mut self,
        x: &[f64],
        low: &[f64],
        increment: &mut [f64],
        outcome: &mut [Result<(), StepError>],
    ) {
        let lanes = self.lanes.len();
        let d = x.len() / lanes;
        let mut change = vec![0.0; d];
        for (at, lane) in self.lanes.iter_mut().enumerate() {
            let own = [x, low].map(|all| column(all, at, lanes));
            let before = lane.work().evaluations;
            outcome[at] = lane.step(&own[0], &own[1], &mut change);
            if outcome[at].is_err() {
                change.fill(0.0);
            }
            let evaluations = lane.work().evaluations - before;
            self.statistics.count(evaluations, outcome[at].is_ok());
            let places = increment.iter_mut().skip(at).step_by(lanes);
            places.zip(&change).for_each(|(place, own)| *place = *own);
        }
    }

    fn solution(&self, lane: usize) -> Option<Vec<f64>> {
        self.lanes[lane].stepper.solution(0)
    }

    fn restart(&mut self) {
        self.lanes.iter_mut().for_each(LaneOfEnergy::restart);
    }

    fn statistics(&self) -> SolverStatistics {
        let work = self.lanes.iter().map(LaneOfEnergy::work);
        let work = work.fold(SolverStatistics::default(), SolverStatistics::and);
        SolverStatistics {
            operations: work.operations,
            rounded: work.rounded,
            held: work.held,
            ..self.statistics
        }
    }

    fn memory(&self) -> Vec<f64> {
        self.lanes.iter().flat_map(LaneOfEnergy::memory).collect()
    }

    fn restore(&mut self, memory: &[f64]) -> Result<(), usize> {
        let lengths: Vec<usize> = self.lanes.iter().map(|lane| lane.memory().len()).collect();
        let expected = lengths.iter().sum();
        if memory.len() != expected {
            return Err(expected);
        }
        let mut rest = memory;
        for (lane, length) in self.lanes.iter_mut().zip(lengths) {
            let (own, others) = rest.split_at(length);
            lane.restore(own)?;
            rest = others;
        }
        Ok(())
    }
}
