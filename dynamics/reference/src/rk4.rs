//! The classical Runge–Kutta method of order 4: the part `rk4`. Over formulas a step is one kernel, of any number of
//! trajectories; over numbers, and over formulas whose step is too long a kernel, a call for each stage.

use std::sync::Arc;

use leafwise_core::part::{
    Compared, Elsewhere, Family, PartInfo, PartKind, PartParameters, ServesNumbers,
};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::solver::{CodeStepMap, ExplicitMap, StepReport, Trajectories};
use leafwise_core::{
    BuildError, Evaluator, MapProperties, MotionClass, PoissonSystem, StepMap, Structure,
    SystemFormulas,
};
use leafwise_expression::{Arithmetic, Graph, Rational, StepSize, Term};
use nalgebra::DMatrix;

use crate::reference_map::{ReferenceMap, row_major};

static INFO: PartInfo = PartInfo {
    name: "rk4",
    summary: "the classical Runge-Kutta method, explicit",
    declares: "order 4; not a Poisson map; not self-adjoint; exact tangent up to 256 variables",
    domain: "any system, of formulas or of numbers",
    literature: "W. Kutta, Z. Math. Phys. 46 (1901); Hairer, Norsett, Wanner, Solving Ordinary \
                 Differential Equations I, table II.1.2",
    family: Some(Family::Explicit),
    takes: MotionClass::OffLeaves,
    serves_numbers: Some(ServesNumbers { rank: 1, limit: "" }),
    compared: Some(Compared::at(5)),
    elsewhere: Some(Elsewhere {
        names: &["runge-kutta", "runge-kutta-4", "classical-runge-kutta"],
        is: "the classical method of Runge and Kutta",
    }),
    ..PartInfo::of(PartKind::Stepper)
};

/// Beyond this dimension no tangent is offered: its matrix takes longer to compile than a run.
const LARGEST_TANGENT: usize = 256;

/// Operations of a step that is one kernel, times d: what compiling its tangent takes.
const LONGEST: usize = 1 << 18;

/// RK4 by calls, for several trajectories.
pub(crate) struct Rk4 {
    field: SmoothMapEvaluator,
    time_step: f64,
    /// The four stages and the slopes there, one trajectory behind the other.
    stages: [Vec<f64>; 4],
    slopes: [Vec<f64>; 4],
    /// Operations of the sums.
    linear: u64,
}

/// c_i = a_{i,i−1}.
const NODES: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
/// 6 b_i.
const WEIGHTS: [f64; 4] = [1.0, 2.0, 2.0, 1.0];

impl Rk4 {
    pub(crate) fn new(field: &SmoothMap, parameters: &[f64], time_step: f64, count: usize) -> Self {
        let room = || std::array::from_fn(|_| vec![0.0; count * field.inputs()]);
        Self {
            field: field.evaluator(parameters, 1.0, 1.0),
            time_step,
            stages: room(),
            slopes: room(),
            linear: 0,
        }
    }

    fn dimension(&self) -> usize {
        self.field.map().inputs()
    }
}

impl Trajectories for Rk4 {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let (d, all) = (self.dimension(), x.len());
        for i in 0..4 {
            let size = self.time_step * NODES[i];
            let stage = &mut self.stages[i][..all];
            if let Some(before) = i.checked_sub(1).map(|i| &self.slopes[i][..all]) {
                for c in 0..all {
                    stage[c] = x[c] + size * before[c];
                }
            } else {
                // x itself; a zero loses its sign.
                for c in 0..all {
                    stage[c] = x[c] + size * 0.0;
                }
            }
            let slopes = &mut self.slopes[i];
            let mut fails = false;
            self.field.each_value(&self.stages[i], slopes, |at, error| {
                taken[at].fail(error);
                fails = true;
            });
            if fails {
                if taken.iter().all(|taken| taken.outcome.is_err()) {
                    return;
                }
                // A trajectory that failed rests where it started.
                for (slope, taken) in slopes.chunks_exact_mut(d).zip(&*taken) {
                    if taken.outcome.is_err() {
                        slope.fill(0.0);
                    }
                }
            }
        }
        let [first, second, third, fourth] = self.slopes.each_ref().map(|slope| &slope[..all]);
        for (c, increment) in increment.iter_mut().enumerate() {
            let slopes = [first[c], second[c], third[c], fourth[c]];
            let sum: f64 = (0..4).map(|i| WEIGHTS[i] * slopes[i]).sum();
            *increment = self.time_step / 6.0 * sum;
        }
        for taken in taken.iter_mut().filter(|taken| taken.outcome.is_ok()) {
            taken.evaluations += 1;
            // Two for each of three stages, eight and a factor for the sum.
            self.linear += 15 * d as u64;
        }
    }

    fn operations(&self) -> Option<u64> {
        Some(self.field.operations()? + self.linear)
    }

    fn tangent(&mut self, at: usize) -> Option<Vec<f64>> {
        let d = self.dimension();
        let mut tangent = DMatrix::identity(d, d);
        let mut before = DMatrix::zeros(d, d);
        let mut entries = vec![0.0; d * d];
        for i in 0..4 {
            let stage = &self.stages[i][at * d..][..d];
            self.field.jacobians(stage, &mut entries).ok()?;
            let stage = DMatrix::identity(d, d) + before * (self.time_step * NODES[i]);
            before = DMatrix::from_row_slice(d, d, &entries) * stage;
            tangent += &before * (self.time_step * WEIGHTS[i] / 6.0);
        }
        Some(row_major(&tangent))
    }
}

/// x ↦ t/6 (k₁ + 2k₂ + 2k₃ + k₄) with t = εh; `None` where that is too long, or has no code: calls then say why.
fn code(system: &SystemFormulas) -> Option<ExplicitMap> {
    let d = system.dimension();
    let mut field = Graph::limited(LONGEST / d);
    let inputs: Vec<Term> = (0..d).map(|i| field.input(i)).collect();
    let slopes = system.vector_field(&mut field, &inputs).ok()?;
    field.unless_refused(()).ok()?;
    let mut graph = Graph::limited(LONGEST / d);
    let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let sizes = [StepSize::Epsilon, StepSize::H].map(|size| graph.step_size(size));
    let step = graph.multiply(&sizes[0], &sizes[1]);
    let mut stages: Vec<Vec<Term>> = Vec::new();
    for node in [(0, 1), (1, 2), (1, 2), (1, 1)] {
        let size = graph.scale(&Rational::new(node.0, node.1), &step);
        let stage: Vec<Term> = match stages.last() {
            None => x.clone(),
            Some(slopes) => (x.iter().zip(slopes))
                .map(|(x, slope)| {
                    let change = graph.multiply(&size, slope);
                    graph.add(x, &change)
                })
                .collect(),
        };
        stages.push(graph.import(&field, &slopes, &stage).ok()?);
    }
    let sixth = graph.scale(&Rational::new(1, 6), &step);
    let weights = [1, 2, 2, 1].map(Rational::from_integer);
    let increment = (0..d).map(|i| {
        let slopes = weights.iter().zip(&stages);
        let slopes: Vec<_> = slopes.map(|(b, k)| (b.clone(), k[i].clone())).collect();
        let sum = graph.combine(&slopes);
        graph.multiply(&sixth, &sum)
    });
    let increment: Vec<Term> = increment.collect();
    graph.unless_refused(()).ok()?;
    let parameters = system.parameters().len();
    Some(ExplicitMap::compile(graph, increment, parameters))
}

const PROPERTIES: MapProperties = MapProperties {
    order: 4,
    structure: Structure::None,
    self_adjoint: Some(false),
};

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    if let Some(formulas) = system.expressions()
        && formulas.dimension() <= LARGEST_TANGENT
        && let Some(code) = code(formulas)
    {
        let description = INFO.name.to_owned();
        return Ok(Arc::new(CodeStepMap::new(description, PROPERTIES, code)));
    }
    let field = if system.dimension() <= LARGEST_TANGENT {
        system.field_map()?
    } else {
        system.field_values()?
    };
    Ok(Arc::new(ReferenceMap {
        dimension: system.dimension(),
        properties: PROPERTIES,
        description: INFO.name.to_owned(),
        together: usize::MAX,
        kept_signs: Vec::new(),
        make: Box::new(move |parameters, time_step, count| {
            Box::new(Rk4::new(&field, parameters, time_step, count))
        }),
    }))
}

leafwise_core::built_in!(StepperPart::new(&INFO, build));
