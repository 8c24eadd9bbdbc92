//! Choice of exact realizations that fit a tensor, by rank and by operations, where a scene leaves the realization
//! open.

use std::sync::Arc;

use leafwise_expression::{Expression, Quantity};

use crate::dynamics::DynamicApproximation;
use crate::error::BuildError;
use crate::method::Method;
use crate::part::{Auto, PartInfo, PartKind, PartParameters, Settings};
use crate::realization::{Accuracy, RealizationData};
use crate::registry::Registry;
use crate::system::{Forces, PoissonSystem};
use crate::walk::Walk;

/// An exact realization of a system, found by its tensor.
pub struct Exact {
    /// The realization.
    pub realization: Arc<dyn RealizationData>,
    /// Declaration of the realization's part.
    pub info: &'static PartInfo,
    /// Why it is taken.
    pub reason: String,
}

/// A method in coordinates in which a tensor is constant.
#[derive(Clone, Copy, Debug)]
pub struct OverLift {
    /// The realization, at its defaults.
    pub realization: &'static PartInfo,
    /// The dynamic approximation.
    pub dynamics: &'static PartInfo,
    /// Its settings.
    pub settings: Settings,
}

/// The steps by which realizations that are no code are compared, and εh of each.
const STEPS: u64 = 8;
const TIME_STEP: f64 = 0.1;

impl Registry {
    /// The exact realizations that a choice left open tries, and why each is taken.
    pub fn exact_realizations(&self) -> Vec<(&'static PartInfo, &'static str)> {
        let mut exact: Vec<(u32, &'static PartInfo, &'static str)> = self
            .parts()
            .into_iter()
            .filter_map(|info| match info.auto {
                Some(Auto::Exact { rank, reason }) => Some((rank, info, reason)),
                _ => None,
            })
            .collect();
        exact.sort_by_key(|(rank, ..)| *rank);
        exact
            .into_iter()
            .map(|(_, info, reason)| (info, reason))
            .collect()
    }

    /// Exact realization for a choice left open, under a dynamic approximation. If the dynamics step in coordinates in
    /// which the system's tensor is constant, it is a realization that has such coordinates: its step solves nothing
    /// for its start. Otherwise it is that of [`exact_realization`](Self::exact_realization).
    pub fn exact_realization_under(
        &self,
        dynamics: &Arc<dyn DynamicApproximation>,
        system: &PoissonSystem,
        is_long: bool,
    ) -> Option<Exact> {
        let serves = |exact: &Exact| dynamics.bisection(system, &exact.realization).is_ok();
        let mut lifts = Vec::new();
        if dynamics.properties().serves_lifts && !is_long {
            lifts = self.lifts(system);
            lifts.retain(serves);
        }
        let lift = self.fewest_operations(system, lifts, Some(dynamics));
        lift.or_else(|| self.exact_realization(system, is_long))
    }

    /// Exact realization for a choice left open. Of those that fit the system's tensor it is the first, by rank, whose
    /// maps are code. Where there is none, it is the one whose steps take the fewest operations. Of a long lattice,
    /// only those that can be swept are considered.
    ///
    /// Code is compiled with its derivatives into one kernel and costs a fraction of the numbers of the same maps.
    /// Realizations without code are compared by the operations of steps of order 2 of H = ½ Σ x_i²/i, which depend on
    /// the tensor alone. The cost of the system's own H is the same over each.
    pub fn exact_realization(&self, system: &PoissonSystem, is_long: bool) -> Option<Exact> {
        let exact = self.exact_realizations().into_iter();
        let fitting = exact.filter_map(|(info, reason)| {
            let part = self.realization(info.name).ok()?;
            let realization = part.build(system, &PartParameters::new()).ok()?;
            (!is_long || realization.abilities().stages.is_some()).then(|| Exact {
                realization,
                info,
                reason: reason.to_owned(),
            })
        });
        let mut others = Vec::new();
        for exact in fitting {
            if exact.realization.abilities().code().is_some() {
                return Some(exact);
            }
            others.push(exact);
        }
        self.fewest_operations(system, others, None)
    }

    /// Takes the first of those whose steps take the fewest operations, and the first of all where none counts them.
    /// The steps are by the dynamics given or, without any, by those of order 2 that serve every system.
    fn fewest_operations(
        &self,
        system: &PoissonSystem,
        exact: Vec<Exact>,
        dynamics: Option<&Arc<dyn DynamicApproximation>>,
    ) -> Option<Exact> {
        if exact.len() < 2 {
            return exact.into_iter().next();
        }
        let of_order = || {
            let part = self.of_order(PartKind::Dynamics)?;
            let order = PartParameters::new().with("order", 2);
            self.dynamics(part.name)?.build(&order)
        };
        let dynamics = dynamics.map_or_else(of_order, |dynamics| Ok(Arc::clone(dynamics)));
        let count = |exact: &Exact| {
            let dynamics = Arc::clone(dynamics.as_ref().ok()?);
            operations_of_steps(system, &exact.realization, dynamics)
        };
        let counted: Vec<Option<u64>> = exact.iter().map(count).collect();
        let numbers = counted.iter().enumerate();
        let least = numbers.filter_map(|(at, count)| Some((at, (*count)?)));
        let (at, count) = least.min_by_key(|(_, count)| *count).unwrap_or_default();
        let dearer = exact.iter().zip(&counted);
        let dearer = dearer.filter_map(|(other, found)| {
            let name = other.info.name;
            found.filter(|found| *found > count).map(|found| {
                format!(
                    "its steps take {:.2} of the operations of {name}",
                    count as f64 / found as f64
                )
            })
        });
        let dearer: Vec<String> = dearer.collect();
        let mut exact = exact.into_iter().nth(at)?;
        if !dearer.is_empty() {
            exact.reason = dearer.join(", ");
        }
        Some(exact)
    }

    /// Exact realizations by coordinates in which the system's tensor is constant ([`Abilities::lift`](crate::Abilities::lift)).
    fn lifts(&self, system: &PoissonSystem) -> Vec<Exact> {
        let parts = self.parts().into_iter();
        let lifts = parts.filter(|info| info.is_lift);
        let lifts = lifts.filter_map(|info| {
            let part = self.realization(info.name).ok()?;
            let realization = part.build(system, &PartParameters::new()).ok()?;
            let is_exact = realization.accuracy() == Accuracy::Exact;
            (is_exact && realization.abilities().lift.is_some()).then(|| Exact {
                realization,
                info,
                reason: "the tensor is constant in its coordinates, and these dynamics step there"
                    .to_owned(),
            })
        });
        lifts.collect()
    }

    /// The lift of a system's tensor by the first part that is one, at its defaults, and fits; `but` is not asked.
    pub fn lift(&self, system: &PoissonSystem, but: &str) -> Option<Arc<dyn RealizationData>> {
        let mut parts = self.parts().into_iter();
        parts.find_map(|info| {
            let is_asked = info.is_lift && info.name != but;
            let part = self.realization(info.name).ok().filter(|_| is_asked)?;
            part.build(system, &PartParameters::new()).ok()
        })
    }

    /// Methods that comparisons try in coordinates in which the system's tensor is constant. They are the exact
    /// realizations that have such coordinates, each with every dynamic approximation for them and its settings.
    pub fn over_lifts(&self, system: &PoissonSystem) -> Vec<OverLift> {
        let lifts = self.lifts(system).into_iter().map(|exact| exact.info);
        let dynamics = self.compared(PartKind::Dynamics);
        let tried = lifts.flat_map(|realization| {
            dynamics.iter().flat_map(move |dynamics| {
                let settings = dynamics.compared.map_or(&[][..], |c| c.over_lifts);
                settings.iter().map(move |settings| OverLift {
                    realization,
                    dynamics,
                    settings,
                })
            })
        });
        tried.collect()
    }

    /// Method of a scene whose realization is `auto`, of order m. The dynamic approximation is the one that serves
    /// every system; with forces it is that of order 2 which takes them. The realization is
    /// [`exact_realization`](Self::exact_realization). Where none fits, it is the one that serves every system, of
    /// order m too.
    ///
    /// # Errors
    /// [`BuildError::UnknownPart`] where the registry has no such part. An odd order gives [`BuildError::Parameter`].
    /// For a system with forces any order but 2 gives [`BuildError::NotMade`]. Further errors are those of
    /// [`Method::compose`].
    pub fn automatic(&self, system: &PoissonSystem, m: u32) -> Result<Method, BuildError> {
        let order = PartParameters::new().with("order", i64::from(m));
        let dynamics = if system.has_forces() {
            let part = self.of_forces()?;
            if m != 2 {
                return Err(BuildError::NotMade {
                    part: part.name,
                    reason: format!(
                        "it has order 2, not {m}: take order 2, and a composition for a higher order"
                    ),
                });
            }
            self.dynamics(part.name)?.build(&PartParameters::new())?
        } else {
            let part = self.of_order(PartKind::Dynamics)?;
            self.dynamics(part.name)?.build(&order)?
        };
        let realization = match self.exact_realization(system, false) {
            Some(exact) => exact.realization,
            None => {
                let general = self.of_order(PartKind::Realization)?;
                self.realization(general.name)?.build(system, &order)?
            }
        };
        Method::compose(system, realization, dynamics)
    }
}

/// Operations of some steps over a realization; `None` where they fail or are not counted.
fn operations_of_steps(
    system: &PoissonSystem,
    realization: &Arc<dyn RealizationData>,
    dynamics: Arc<dyn DynamicApproximation>,
) -> Option<u64> {
    let d = system.dimension();
    let squares = (1_i32..).zip(0..d).map(|(i, at)| {
        let x = Quantity::Variable(at);
        x * x / (2 * i)
    });
    let hamiltonian = Expression::Sum(squares.collect());
    let probe = system.expressions()?.with_hamiltonian(hamiltonian);
    let probe = probe.and_then(|probe| probe.with_forces(Forces::default()));
    let probe = PoissonSystem::from(probe.ok()?);
    let method = Method::compose(&probe, Arc::clone(realization), dynamics).ok()?;
    // Of size 1 and in general position.
    let state: Vec<f64> = (0..d).map(|i| 1.0 / (1.0 + 0.1 * i as f64)).collect();
    let parameters = probe.parameter_values();
    let mut walk = Walk::new(&method, &parameters, 1.0, TIME_STEP, &state);
    for _ in 0..STEPS {
        walk.step().ok()?;
    }
    walk.statistics().operations
}
