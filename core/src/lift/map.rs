//! Gauss steps in the coordinates of a lift.

use std::sync::Arc;

use leafwise_expression::{Graph, Term};
use nalgebra::DMatrix;

use super::slowing::slower;
use super::{End, Lift, LiftShape};
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::runge_kutta::smooth_map::MapAt;
use crate::runge_kutta::stage_lanes::{FixedPoint, StageLanes, Start, stage_lanes};
use crate::runge_kutta::{SmoothMap, SmoothMapEvaluator, Tableau};
use crate::solver::{
    Lanes, MapAbilities, MapProperties, StepMap, StepReport, Stepper, Structure, Trajectories,
    check_equations,
};
use crate::system::{PoissonSystem, SystemFormulas};

/// x ↦ x + J(z) − J(0), z the step of a Gauss method from 0 for ż = −Ω∇(H∘J).
pub(crate) struct LiftedMap {
    lift: Arc<dyn Lift>,
    code: Arc<Code>,
    tableau: Tableau,
    dimension: usize,
    properties: MapProperties,
    description: String,
}

/// ż and J(z) − J(0) of (z, base point), and their Jacobians.
struct Code {
    field: SmoothMap,
    increment: SmoothMap,
}

impl LiftedMap {
    /// The map of a Gauss method of so many stages.
    ///
    /// # Errors
    /// [`BuildError::Incompatible`] for a number of stages without coefficients; those of the lift's code.
    pub(crate) fn new(
        lift: Arc<dyn Lift>,
        realization: &str,
        system: &PoissonSystem,
        stages: usize,
        properties: MapProperties,
    ) -> Result<Self, BuildError> {
        if !(1..=Tableau::MOST_STAGES).contains(&stages) {
            return Err(BuildError::Incompatible {
                dynamics: format!("a Gauss method of {stages} stages"),
                realization: realization.to_owned(),
                reason: format!("the number of stages lies in 1 to {}", Tableau::MOST_STAGES),
            });
        }
        Ok(Self {
            code: Arc::new(Code::of(lift.as_ref(), system)?),
            lift,
            tableau: Tableau::gauss(stages),
            dimension: system.dimension(),
            // Gauss methods are symmetric, and begin at x itself whether a bisection is solved for or not.
            properties: MapProperties {
                structure: Structure::Exact,
                self_adjoint: Some(true),
                ..properties
            },
            description: format!("{realization} + collective gauss s = {stages}"),
        })
    }
}

impl Code {
    fn of(lift: &dyn Lift, system: &PoissonSystem) -> Result<Self, BuildError> {
        let system = system.formulas("a lift")?;
        let LiftShape {
            coordinates: n,
            base: m,
            ..
        } = lift.shape();
        let mut graph = Graph::compilable();
        let inputs: Vec<Term> = (0..n + m).map(|i| graph.input(i)).collect();
        let (z, base) = inputs.split_at(n);
        let field = field(lift, system, &mut graph, z, base)?;
        let increment = lift.increment(&mut graph, z, base)?;
        graph.unless_refused(())?;
        let parameters = system.parameters().len();
        let graph = Arc::new(graph);
        let compile = |terms: &[Term]| {
            SmoothMap::compile_unproven(Arc::clone(&graph), terms, parameters, n + m)
        };
        Ok(Self {
            field: compile(&field),
            increment: compile(&increment),
        })
    }
}

/// ż = −Ω∇(H∘J), of H less what slows it along fibres.
fn field(
    lift: &dyn Lift,
    system: &SystemFormulas,
    graph: &mut Graph,
    z: &[Term],
    base: &[Term],
) -> Result<Vec<Term>, BuildError> {
    let slower = slower(lift, system)?;
    let mut own = Graph::new();
    let inputs: Vec<Term> = (0..system.dimension()).map(|i| own.input(i)).collect();
    let slopes = slower
        .as_ref()
        .unwrap_or(system)
        .gradient(&mut own, &inputs)?;
    let covector = lift.covector(&mut own, &inputs, &slopes)?;
    let x = lift.image(graph, z, base)?;
    let covector = graph.import(&own, &covector, &x)?;
    lift.field(graph, z, base, &covector)
}

impl StepMap for LiftedMap {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn properties(&self) -> MapProperties {
        self.properties
    }

    fn describe(&self) -> String {
        self.description.clone()
    }

    fn abilities(&self) -> MapAbilities<'_> {
        let Code { field, increment } = &*self.code;
        let named = [("the lifted motion", field), ("the change of x", increment)];
        let kernels = named.map(|(name, map)| Some((name, map.value_kernel()?)));
        MapAbilities {
            kernels: kernels.into_iter().flatten().collect(),
            ..MapAbilities::default()
        }
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        let make =
            |parameters: &[f64], count| LiftedSteps::new(self, parameters, epsilon * h, count);
        let d = self.dimension;
        Box::new(Lanes::together(lanes, usize::MAX, d, parameters, make))
    }
}

/// Steps of several trajectories.
struct LiftedSteps {
    lift: Arc<dyn Lift>,
    code: Arc<Code>,
    parameters: Vec<f64>,
    tableau: Tableau,
    time_step: f64,
    stages: Box<dyn StageLanes>,
    increment: SmoothMapEvaluator,
    /// 0, and z at the end of a step, behind it the base point.
    nothing: Vec<f64>,
    end: Vec<f64>,
    sizes: Vec<f64>,
    /// z and base point of each trajectory's last step, and whether there was one.
    ends: Vec<f64>,
    has_end: Vec<bool>,
}

impl LiftedSteps {
    fn new(map: &LiftedMap, parameters: &[f64], time_step: f64, count: usize) -> Self {
        let (n, all) = (map.lift.shape().coordinates, map.code.field.inputs());
        let field = MapAt {
            map: &map.code.field,
            parameters,
            steps: [1.0; 2],
        };
        let stages = stage_lanes(field, &map.tableau, time_step, count, true);
        Self {
            lift: Arc::clone(&map.lift),
            code: Arc::clone(&map.code),
            parameters: parameters.to_vec(),
            tableau: map.tableau.clone(),
            time_step,
            stages: stages.expect("a field of formulas, of a Gauss method"),
            increment: map.code.increment.evaluator(parameters, 1.0, 1.0),
            nothing: vec![0.0; n],
            end: vec![0.0; all],
            sizes: vec![0.0; n],
            ends: vec![0.0; count * all],
            has_end: vec![false; count],
        }
    }

    /// A step of one trajectory: how its stages were solved, and by how much Casimirs were held.
    fn advance(
        &mut self,
        at: usize,
        (x, low): (&[f64], &[f64]),
        increment: &mut [f64],
    ) -> Result<(FixedPoint, f64), StepError> {
        let (n, all) = (self.nothing.len(), self.end.len());
        let (z, base) = self.end.split_at_mut(n);
        let (from, about) = self.ends[at * all..][..all].split_at(n);
        let before = self.has_end[at].then_some(End {
            z: from,
            base: about,
        });
        self.lift.place(x, low, before, base)?;
        self.lift.sizes(base, &mut self.sizes);
        let start = Start {
            point: &self.nothing,
            sizes: &self.sizes,
            beside: base,
        };
        let solved = match self.stages.solve(at, start, z) {
            Ok(solved) => solved,
            Err(unsettled) if !unsettled.correction.is_finite() => {
                return Err(StepError::NonFinite {
                    what: "a stage of the lifted motion",
                });
            }
            Err(unsettled) => {
                return Err(StepError::NoConvergence {
                    evaluations: unsettled.evaluations as usize,
                    correction: unsettled.correction,
                });
            }
        };
        self.ends[at * all..][..all].copy_from_slice(&self.end);
        self.has_end[at] = true;
        self.increment.values(&self.end, increment)?;
        let held = self.lift.hold(x, low, increment);
        Ok((solved, held))
    }
}

impl Trajectories for LiftedSteps {
    fn step(&mut self, x: &[f64], low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let d = x.len() / taken.len();
        for (at, taken) in taken.iter_mut().enumerate() {
            let own = at * d..(at + 1) * d;
            let start = (&x[own.clone()], &low[own.clone()]);
            let step = self.advance(at, start, &mut increment[own]);
            let (is_rounded, held) = match &step {
                Ok((solved, held)) => (solved.is_rounded, *held),
                Err(_) => (false, 0.0),
            };
            taken.held = held;
            let step = step.map(|(solved, _)| solved.evaluations as usize);
            taken.take(step, is_rounded);
        }
    }

    fn operations(&self) -> Option<u64> {
        Some(self.stages.operations() + self.increment.operations()?)
    }

    /// 1 + (∂_z(ΔJ) dz/db + ∂_b(ΔJ)) db/dx, b the base point: by the derivatives of the stage equations, which are linear.
    fn tangent(&mut self, at: usize) -> Option<Vec<f64>> {
        let (n, s, all) = (self.nothing.len(), self.tableau.stages(), self.end.len());
        let m = all - n;
        check_equations(s * n).ok()?;
        let [mut field, mut increment] = [&self.code.field, &self.code.increment]
            .map(|map| map.evaluator(&self.parameters, 1.0, 1.0));
        let end = &self.ends[at * all..][..all];
        let mut displacements = vec![0.0; s * n];
        self.stages.displacements(at, &mut displacements);
        // dZ_i = τ Σ_j a_ij (F_z dZ_j + F_b db).
        let mut by_z = vec![DMatrix::zeros(n, n); s];
        let mut by_base = vec![DMatrix::zeros(n, m); s];
        for (j, stage) in displacements.chunks_exact(n).enumerate() {
            let mut entries = vec![0.0; n * all];
            let place = [stage, &end[n..]].concat();
            field.jacobians(&place, &mut entries).ok()?;
            let jacobian = DMatrix::from_row_slice(n, all, &entries);
            by_z[j].copy_from(&jacobian.columns(0, n));
            by_base[j].copy_from(&jacobian.columns(n, m));
        }
        let mut matrix = DMatrix::identity(s * n, s * n);
        let mut right = DMatrix::zeros(s * n, m);
        for i in 0..s {
            for j in 0..s {
                let factor = self.time_step * self.tableau.matrix[i * s + j];
                let mut block = matrix.view_mut((i * n, j * n), (n, n));
                block -= &by_z[j] * factor;
                let mut row = right.rows_mut(i * n, n);
                row += &by_base[j] * factor;
            }
        }
        let stages = matrix.lu().solve(&right)?;
        let mut of_z = DMatrix::zeros(n, m);
        for (j, b) in self.tableau.weights.iter().enumerate() {
            let own = &by_z[j] * stages.rows(j * n, n) + &by_base[j];
            of_z += own * (self.time_step * b);
        }
        let d = self.increment.map().outputs();
        let mut entries = vec![0.0; d * all];
        increment.jacobians(end, &mut entries).ok()?;
        let jacobian = DMatrix::from_row_slice(d, all, &entries);
        let mut of_base = vec![0.0; m * d];
        self.lift.slopes_of_base(&end[n..], &mut of_base);
        let of_base = DMatrix::from_row_slice(m, d, &of_base);
        let mut tangent = (jacobian.columns(0, n) * of_z + jacobian.columns(n, m)) * of_base;
        for i in 0..d {
            tangent[(i, i)] += 1.0;
        }
        let is_finite = tangent.iter().all(|v| v.is_finite());
        is_finite.then(|| tangent.transpose().as_slice().to_vec())
    }

    fn restart(&mut self, at: usize) {
        self.stages.clear(at);
        self.has_end[at] = false;
    }

    fn memory(&self, at: usize) -> Vec<f64> {
        let stages = self.stages.memory(at);
        if !self.lift.shape().follows {
            return stages;
        }
        let all = self.end.len();
        let has_end = [f64::from(u8::from(self.has_end[at]))];
        [&has_end[..], &self.ends[at * all..][..all], &stages].concat()
    }

    fn restore(&mut self, at: usize, memory: &[f64]) {
        if !self.lift.shape().follows {
            return self.stages.restore(at, memory);
        }
        let all = self.end.len();
        let (end, stages) = memory.split_at(1 + all);
        self.has_end[at] = end[0] != 0.0;
        self.ends[at * all..][..all].copy_from_slice(&end[1..]);
        self.stages.restore(at, stages);
    }
}
