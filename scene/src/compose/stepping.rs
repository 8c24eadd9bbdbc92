//! The integrator of a scene: written out, or by templates over a lattice.

use leafwise_core::lattice::{LatticeGeometry, LatticeMethod, LatticeObservables};
use leafwise_core::{DynamicApproximation, Method, RealizationData, StepMap};

/// How a scene's steps are taken.
#[derive(Clone, Debug)]
pub enum Stepping {
    /// Every coordinate has code of its own; the solver is Newton's.
    Written(Box<Method>),
    /// One template a class of sites; the solver is the linear iteration.
    Lattice(Box<LatticeStepping>),
}

/// A lattice's method and its observers.
#[derive(Clone, Debug)]
pub struct LatticeStepping {
    /// The method.
    pub method: LatticeMethod,
    /// Energy and Casimirs.
    pub invariants: LatticeObservables,
    /// Formulas of the state that the scene records.
    pub formulas: LatticeObservables,
}

impl Stepping {
    /// The step map.
    pub fn map(&self) -> &dyn StepMap {
        match self {
            Self::Written(method) => method.as_ref(),
            Self::Lattice(lattice) => &lattice.method,
        }
    }

    /// The method of a system that is written out.
    pub fn written(&self) -> Option<&Method> {
        match self {
            Self::Written(method) => Some(method),
            Self::Lattice(_) => None,
        }
    }

    /// The geometric approximation.
    pub fn realization(&self) -> &dyn RealizationData {
        match self {
            Self::Written(method) => method.realization(),
            Self::Lattice(lattice) => lattice.method.realization(),
        }
    }

    /// The dynamic approximation.
    pub fn dynamics(&self) -> &dyn DynamicApproximation {
        match self {
            Self::Written(method) => method.dynamics(),
            Self::Lattice(lattice) => lattice.method.dynamics(),
        }
    }

    /// Theorem 2's bound on the order in t.
    pub fn declared_order(&self) -> usize {
        self.map().properties().order
    }

    /// The lattice, if it is one.
    pub fn lattice(&self) -> Option<&LatticeGeometry> {
        match self {
            Self::Written(_) => None,
            Self::Lattice(lattice) => Some(lattice.method.geometry()),
        }
    }

    /// What one iteration of the solver costs: labels and counts.
    pub fn costs(&self) -> Vec<(&'static str, String)> {
        match self {
            Self::Written(method) => match method.newton() {
                None => vec![("Path", method.path())],
                Some(newton) => vec![
                    ("One Newton iteration", newton.operations().to_string()),
                    ("Residual alone", newton.residual_operations().to_string()),
                    (
                        "Coefficients, once",
                        newton.coefficient_operations().to_string(),
                    ),
                ],
            },
            Self::Lattice(lattice) => {
                let program = lattice.method.program();
                let sites = lattice.method.geometry().length();
                vec![
                    (
                        "One iteration",
                        format!(
                            "{} operations, {:.1} a site",
                            program.operations(),
                            program.operations() as f64 / sites as f64
                        ),
                    ),
                    (
                        "Fields",
                        format!("{} numbers a coordinate", program.fields()),
                    ),
                ]
            }
        }
    }
}
