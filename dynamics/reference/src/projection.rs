//! A method followed by projection onto energy and Casimirs: the part `projection`.

use std::sync::Arc;

use leafwise_core::part::{
    ParameterDefault, ParameterInfo, PartInfo, PartKind, PartParameters, ServesNumbers,
};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::{SmoothMapEvaluator, Tableau};
use leafwise_core::solver::judge::{Verdict, reach};
use leafwise_core::solver::{
    CorrectionMethod, Iteration, StepReport, Trajectories, check_equations,
};
use leafwise_core::{
    BuildError, Evaluator, MapProperties, PoissonSystem, StepError, StepMap, Structure,
};

use crate::gauss::{STAGES, stages};
use crate::implicit::ImplicitRungeKutta;
use crate::reference_map::ReferenceMap;
use crate::rk4::Rk4;
use crate::singular::SingularSystem;

static INFO: PartInfo = PartInfo {
    name: "projection",
    summary: "a Runge-Kutta step, then the nearest state with the energy and Casimirs of before",
    declares: "the order of its base, 4 or 2s; keeps H and the Casimirs; not a Poisson map; not \
               self-adjoint",
    domain: "any system whose Casimirs have gradients, of formulas or of numbers",
    literature: "Hairer, Lubich, Wanner, Geometric Numerical Integration, section IV.4",
    parameters: &[
        ParameterInfo {
            name: "base",
            summary: "the method that is projected: rk4 or gauss",
            default: ParameterDefault::Text("rk4"),
        },
        STAGES,
    ],
    serves_numbers: Some(ServesNumbers { rank: 7, limit: "" }),
    surveyed: &[
        &[("base", ParameterDefault::Text("rk4"))],
        &[("base", ParameterDefault::Text("gauss"))],
    ],
    ..PartInfo::of(PartKind::Stepper)
};

/// Budget of one projection.
const MOST_EVALUATIONS: usize = 50;

/// y = x̃ + Dg(x̃)ᵀλ with g(y) = g(x), g = (H, C_1, …) and x̃ the base's next state.
struct Projection {
    base: Box<dyn Trajectories>,
    taken: [StepReport; 1],
    invariants: SmoothMapEvaluator,
    /// g(x); g and Dg at a state; Dg(x̃) in units of its slopes, and these units.
    kept: Vec<f64>,
    values: Vec<f64>,
    rows: Vec<f64>,
    normals: Vec<f64>,
    units: Vec<f64>,
    state: Vec<f64>,
    /// Dg(y) Dg(x̃)ᵀ, and g(x) − g(y), then λ.
    gram: SingularSystem,
    multipliers: Vec<f64>,
    iteration: Iteration,
    /// Operations of the normal equations.
    linear: u64,
}

impl Projection {
    fn new(base: Box<dyn Trajectories>, invariants: SmoothMapEvaluator) -> Self {
        let (count, d) = (invariants.map().outputs(), invariants.map().inputs());
        Self {
            base,
            taken: [StepReport::NOTHING],
            invariants,
            kept: vec![0.0; count],
            values: vec![0.0; count],
            rows: vec![0.0; count * d],
            normals: vec![0.0; count * d],
            units: vec![0.0; count],
            state: vec![0.0; d],
            gram: SingularSystem::new(count),
            multipliers: vec![0.0; count],
            iteration: Iteration::new(CorrectionMethod::Newton, 0),
            linear: 0,
        }
    }

    /// Values and derivatives of the invariants at x + change.
    fn evaluate(&mut self, x: &[f64], change: &[f64]) -> Result<(), StepError> {
        for (c, state) in self.state.iter_mut().enumerate() {
            *state = x[c] + change[c];
        }
        self.invariants.values(&self.state, &mut self.values)?;
        self.invariants.jacobians(&self.state, &mut self.rows)
    }

    /// Takes the derivatives at x̃, each invariant in units of its slope, so that their sizes do not
    /// enter the rank.
    fn take_normals(&mut self) {
        let d = self.state.len();
        for (k, unit) in self.units.iter_mut().enumerate() {
            let row = &self.rows[k * d..][..d];
            let slope = libm::sqrt(row.iter().map(|v| v * v).sum());
            *unit = if slope > 0.0 { 1.0 / slope } else { 0.0 };
            for (normal, value) in self.normals[k * d..].iter_mut().zip(row) {
                *normal = *unit * value;
            }
        }
    }

    /// λ at the state evaluated last.
    fn solve(&mut self) -> Result<(), StepError> {
        let (count, d) = (self.kept.len(), self.state.len());
        for i in 0..count {
            self.multipliers[i] = self.units[i] * (self.kept[i] - self.values[i]);
            let row = &self.rows[i * d..][..d];
            for j in 0..count {
                let normal = &self.normals[j * d..][..d];
                let product: f64 = row.iter().zip(normal).map(|(a, b)| a * b).sum();
                self.gram.matrix[i * count + j] = self.units[i] * product;
            }
        }
        // The normal matrix, its elimination, the change.
        self.linear += (2 * count * count * (d + count) + 2 * count * d) as u64;
        if self.gram.solve(&mut self.multipliers) {
            return Ok(());
        }
        Err(StepError::NonFinite {
            what: "the invariants of a projection",
        })
    }
}

impl Projection {
    fn advance(&mut self, x: &[f64], increment: &mut [f64]) -> Result<usize, StepError> {
        let d = x.len();
        self.taken[0] = StepReport::NOTHING;
        // The base steps from the doubles x alone.
        self.base.step(x, &[], increment, &mut self.taken);
        self.taken[0].outcome.clone()?;
        let evaluations = self.taken[0].evaluations as usize;
        self.invariants.values(x, &mut self.kept)?;
        self.evaluate(x, increment)?;
        self.take_normals();
        self.iteration.begin(MOST_EVALUATIONS, |_| 0.0);
        loop {
            self.solve()?;
            for (lambda, normal) in self.multipliers.iter().zip(self.normals.chunks_exact(d)) {
                for (change, n) in increment.iter_mut().zip(normal) {
                    *change += lambda * n;
                }
            }
            for (k, kept) in self.kept.iter().enumerate() {
                let scale = kept.abs() + reach(&self.rows[k * d..][..d], &self.state);
                self.iteration.take(kept - self.values[k], scale);
            }
            if self.iteration.judge()? == Verdict::Converged {
                return Ok(evaluations + self.iteration.evaluations());
            }
            self.evaluate(x, increment)?;
        }
    }
}

impl Trajectories for Projection {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let step = self.advance(x, increment);
        taken[0].take(step, false);
    }

    fn operations(&self) -> Option<u64> {
        Some(self.base.operations()? + self.invariants.operations()? + self.linear)
    }

    fn restart(&mut self, _: usize) {
        self.base.restart(0);
    }

    fn memory(&self, _: usize) -> Vec<f64> {
        self.base.memory(0)
    }

    fn restore(&mut self, _: usize, memory: &[f64]) {
        self.base.restore(0, memory);
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    let base = parameters.word(&INFO, "base", &["rk4", "gauss"])?;
    let stages = stages(&INFO, parameters)?;
    let (order, tableau) = match base {
        "gauss" => (2 * stages, Some(Tableau::gauss(stages))),
        _ => (4, None),
    };
    if system.expressions().is_some() && tableau.is_some() {
        check_equations(stages * system.dimension())?;
    }
    let (field, invariants) = (system.field_map()?, system.invariants_map()?);
    if let (false, Some(system)) = (invariants.has_jacobian(), system.opaque()) {
        return Err(system.not_offered(INFO.name, "the gradients of the Casimirs"));
    }
    Ok(Arc::new(ReferenceMap {
        dimension: system.dimension(),
        properties: MapProperties {
            order,
            structure: Structure::None,
            self_adjoint: Some(false),
        },
        description: match tableau {
            None => format!("{} of {base}", INFO.name),
            Some(_) => format!("{} of {base} s = {stages}", INFO.name),
        },
        together: 1,
        kept_signs: Vec::new(),
        make: Box::new(move |parameters, time_step, _| {
            let base: Box<dyn Trajectories> = match tableau.clone() {
                None => Box::new(Rk4::new(&field, parameters, time_step, 1)),
                Some(tableau) => Box::new(ImplicitRungeKutta::new(
                    &field, tableau, parameters, time_step, 1,
                )),
            };
            let invariants = invariants.evaluator(parameters, 1.0, 1.0);
            Box::new(Projection::new(base, invariants))
        }),
    }))
}

leafwise_core::built_in!(StepperPart::new(&INFO, build));
