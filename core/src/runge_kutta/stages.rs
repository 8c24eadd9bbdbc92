//! The stage equations of an implicit, possibly partitioned, Runge–Kutta method.

use nalgebra::DMatrix;

use super::smooth_map::SmoothMapEvaluator;
use super::stage_lanes::{StageLanes, Start, stage_lanes};
use super::stage_solve::{Coefficients, StageSolve};
use super::tableau::PartitionedTableau;
use crate::error::StepError;
use crate::evaluator::Evaluator;
use leafwise_solver::judge::all_finite;
use leafwise_solver::{Branch, MANY_EQUATIONS, StepReport};

/// So many steps are taken by Newton's iteration after the plain one has failed.
pub(super) const UNTIL_LANES: u32 = 15;

/// Solves Z_i = z + τ Σ_j a_ij F(Z_j) and returns τ Σ_j b_j F(Z_j), for ż = F(z) and a step τ. It takes one
/// trajectory or several in lockstep: F is evaluated at once at all stages of all that iterate.
///
/// Newton's iteration on the displacements Z_i − z keeps its Jacobian while it contracts fast. It ends where a
/// further correction is negligible against |Z_i| + |τ DF(Z_i)| |Z_i|, componentwise: the effect of round-off in Z.
/// It starts from the displacements of the last solve.
///
/// Where F has no Jacobian, the iteration is Z_i ← z + τ Σ_j a_ij F(Z_j) with Anderson's acceleration. It ends where
/// corrections and residuals are negligible against |Z_i| and |Z_i − z|. It asks for a shorter step than Newton's
/// iteration.
///
/// A solver made [`by_lanes`](Self::by_lanes) first tries the plain iteration Z_i ← z + τ Σ_j a_ij F(Z_j), all stages
/// at once in the lanes of vectors. Where its corrections halve on the average, its solution is that connected with
/// z. Elsewhere Newton's iteration takes the step, and the next few.
///
/// [`MANY_EQUATIONS`] are tried by the accelerated iteration instead, whose matrix costs most. Its solution is taken where the
/// rate without acceleration is at most 1/2.
pub struct StageSolver {
    field: SmoothMapEvaluator,
    coefficients: Coefficients,
    trajectories: Vec<StageSolve>,
    lanes: Option<Box<dyn StageLanes>>,
    /// The accelerated iteration of each trajectory, where it is tried first.
    accelerated: Vec<StageSolve>,
    /// Steps of each trajectory until that is tried, and whether the last one was taken so.
    pub(super) until_lanes: Vec<u32>,
    pub(super) is_by_lanes: Vec<bool>,
    /// Those that iterate.
    active: Vec<usize>,
    /// Z_i and F(Z_i) of those, one trajectory behind the other; those that want DF, their Z_i and
    /// DF(Z_i).
    stages: Vec<f64>,
    slopes: Vec<f64>,
    wanting: Vec<usize>,
    linearized: Vec<f64>,
    jacobians: Vec<f64>,
    /// Room for 1 − τ a_ij DF(Z_j), and how single solves went.
    matrix: Vec<f64>,
    alone: [StepReport; 1],
    /// Whether the corrections of a solve with its start converge plainly.
    is_plain: bool,
    /// Room for the path to the stages that are connected with z, and its start.
    branch: Branch,
    nothing: Vec<f64>,
}

impl StageSolver {
    /// For the field F, coefficients, the step τ and `count` trajectories; cold. F depends on the point
    /// alone where there are several.
    ///
    /// # Panics
    /// When F has not as many components as coordinates.
    pub fn new(
        field: SmoothMapEvaluator,
        tableau: impl Into<PartitionedTableau>,
        time_step: f64,
        count: usize,
    ) -> Self {
        let n = field.map().inputs();
        assert_eq!(field.map().outputs(), n, "a vector field");
        let tableau = tableau.into();
        let s = tableau.stages();
        let has_jacobian = field.map().has_jacobian();
        let size = if has_jacobian { s * n } else { 0 };
        let trajectories = (0..count).map(|_| StageSolve::new(n, s, has_jacobian));
        Self {
            trajectories: trajectories.collect(),
            lanes: None,
            accelerated: Vec::new(),
            until_lanes: vec![0; count],
            is_by_lanes: vec![false; count],
            active: Vec::with_capacity(count),
            stages: vec![0.0; count * s * n],
            slopes: vec![0.0; count * s * n],
            wanting: Vec::with_capacity(count),
            linearized: vec![0.0; count * size],
            jacobians: vec![0.0; count * size * n],
            matrix: vec![0.0; size * size],
            alone: [StepReport::NOTHING],
            is_plain: false,
            branch: Branch::new(size),
            nothing: vec![0.0; size],
            coefficients: Coefficients { tableau, time_step },
            field,
        }
    }

    /// The same, trying an iteration without Jacobians first. Gauss methods of three stages and more whose F has a kernel take the
    /// plain one, with the stages in lanes. Many equations take the accelerated one.
    #[must_use]
    pub fn by_lanes(mut self) -> Self {
        let Coefficients { tableau, time_step } = &self.coefficients;
        let (s, n) = (tableau.stages(), self.field.map().inputs());
        if self.has_tangent() && s * n >= MANY_EQUATIONS {
            let accelerated = (0..self.trajectories.len()).map(|_| StageSolve::new(n, s, false));
            self.accelerated = accelerated.collect();
        } else if tableau.split == 0 {
            let count = self.trajectories.len();
            self.lanes = stage_lanes(self.field.at(), &tableau.second, *time_step, count, false);
        }
        self
    }

    /// The number of coordinates of z.
    pub fn dimension(&self) -> usize {
        self.field.map().inputs()
    }

    /// Writes τ Σ_j b_j F(Z_j) for the step of a single trajectory from `start`. Returns how often the stages' slopes
    /// were evaluated.
    ///
    /// # Errors
    /// [`StepError::NoConvergence`], [`StepError::NonFinite`]; the next solve then starts cold.
    pub fn solve(&mut self, start: &[f64], change: &mut [f64]) -> Result<usize, StepError> {
        let mut taken = std::mem::replace(&mut self.alone, [StepReport::NOTHING]);
        self.solve_all(start, change, &mut taken);
        let [
            StepReport {
                evaluations,
                outcome,
                ..
            },
        ] = taken;
        outcome.map(|()| evaluations as usize)
    }

    /// Z_i − z of a single trajectory: of the last solve, and where the next one starts.
    pub fn displacements(&mut self) -> &mut [f64] {
        self.trajectories[0].displacements_mut()
    }

    /// The same by one correction, where `begins` of a new solve: for a `start` that converges itself. Tells whether the
    /// change is that of [`solve`](Self::solve), to round-off. Where corrections do not converge plainly, it is.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn approach(
        &mut self,
        begins: bool,
        start: &[f64],
        change: &mut [f64],
    ) -> Result<bool, StepError> {
        if begins {
            self.is_plain = self.has_tangent();
            self.trajectories[0].begin(start);
        } else {
            self.trajectories[0].move_to(start);
        }
        if self.is_plain {
            let mut taken = [StepReport::NOTHING];
            self.active.clear();
            self.active.push(0);
            self.round(change, &mut taken);
            let own = &self.trajectories[0];
            self.is_plain = taken[0].outcome.is_ok() && !own.iteration.wanders();
            if self.is_plain {
                own.change(&self.coefficients, change);
                self.trajectories[0].keep_jacobians();
                return Ok(self.active.is_empty());
            }
        }
        self.solve(start, change).map(|_| true)
    }

    /// The same for every trajectory, from contiguous starts; where one fails, its `change` is
    /// unspecified and its next solve starts cold.
    pub fn solve_all(&mut self, starts: &[f64], changes: &mut [f64], taken: &mut [StepReport]) {
        let n = self.dimension();
        self.active.clear();
        for (at, start) in starts.chunks_exact(n).enumerate() {
            if self.is_solved_by_lanes(at, start, &mut changes[at * n..][..n], &mut taken[at]) {
                continue;
            }
            self.trajectories[at].begin(start);
            self.active.push(at);
        }
        if self.active.is_empty() {
            return;
        }
        self.iterate(changes, taken);
        if !self.has_tangent() {
            return;
        }
        for at in 0..self.trajectories.len() {
            if self.is_by_lanes[at] {
                continue;
            }
            let is_open = match &taken[at].outcome {
                Ok(()) => self.trajectories[at].iteration.wanders(),
                Err(error) => error.is_of_a_solve(),
            };
            if is_open {
                self.settle(at, changes, taken);
            }
        }
    }

    /// Tries the plain iteration where it is offered and its turn; it writes the change where it succeeds.
    fn is_solved_by_lanes(
        &mut self,
        at: usize,
        start: &[f64],
        change: &mut [f64],
        taken: &mut StepReport,
    ) -> bool {
        self.is_by_lanes[at] = false;
        if self.until_lanes[at] > 0 {
            self.until_lanes[at] -= 1;
            return false;
        }
        if !self.accelerated.is_empty() {
            return self.is_solved_by_acceleration(at, start, change, taken);
        }
        let Some(lanes) = &mut self.lanes else {
            return false;
        };
        let begin = Start {
            point: start,
            sizes: start,
            beside: &[],
        };
        match lanes.solve(at, begin, change) {
            Ok(solved) => {
                taken.evaluations += solved.evaluations;
                taken.is_rounded = solved.is_rounded;
                self.is_by_lanes[at] = true;
                self.trajectories[at].move_to(start);
                true
            }
            Err(unsettled) => {
                taken.evaluations += unsettled.evaluations;
                self.until_lanes[at] = UNTIL_LANES;
                self.trajectories[at].clear();
                false
            }
        }
    }

    /// Tries the accelerated iteration; it writes the change where it succeeds, and leaves the trajectory as it was elsewhere.
    fn is_solved_by_acceleration(
        &mut self,
        at: usize,
        start: &[f64],
        change: &mut [f64],
        taken: &mut StepReport,
    ) -> bool {
        let (own, trajectory) = (&mut self.accelerated[at], &mut self.trajectories[at]);
        own.restore(trajectory.displacements());
        own.begin(start);
        let all = own.displacements().len();
        let (stages, slopes) = (&mut self.stages[..all], &mut self.slopes[..all]);
        let solved = loop {
            own.place(stages);
            let mut outcome = Ok(());
            let field = &mut self.field;
            field.each_value(stages, slopes, |_, error| outcome = Err(error));
            let taken = outcome.and_then(|()| own.take_slopes(&self.coefficients, slopes));
            match taken {
                Ok(None) => {}
                Ok(Some(evaluations)) => break Some(evaluations),
                Err(_) => break None,
            }
        };
        let solved = solved.filter(|_| own.iteration.is_plain());
        taken.evaluations += solved.unwrap_or(own.iteration.evaluations()) as u64;
        self.is_by_lanes[at] = solved.is_some();
        if solved.is_none() {
            self.until_lanes[at] = UNTIL_LANES;
            return false;
        }
        taken.is_rounded = own.iteration.is_rounded();
        own.change(&self.coefficients, change);
        trajectory.restore(own.displacements());
        trajectory.move_to(start);
        true
    }

    fn iterate(&mut self, changes: &mut [f64], taken: &mut [StepReport]) {
        while !self.active.is_empty() {
            self.round(changes, taken);
        }
    }

    fn round(&mut self, changes: &mut [f64], taken: &mut [StepReport]) {
        self.evaluate_slopes(taken);
        self.evaluate_jacobians(taken);
        self.advance(changes, taken);
    }

    /// Makes sure that the stages are those connected with z, and takes these where the solve found
    /// others or none.
    #[cold]
    fn settle(&mut self, at: usize, changes: &mut [f64], taken: &mut [StepReport]) {
        let (s, n) = (self.coefficients.tableau.stages(), self.dimension());
        let all = s * n;
        let Self {
            field,
            coefficients,
            trajectories,
            stages,
            slopes,
            jacobians,
            matrix,
            branch,
            nothing,
            ..
        } = self;
        let own = &trajectories[at];
        // What the displacements are measured against is z, in the room of the matrix.
        let sizes = &mut matrix[..all];
        for (row, size) in sizes.iter_mut().enumerate() {
            *size = own.start()[row % n];
        }
        let solved = std::mem::replace(&mut taken[at].outcome, Ok(()));
        let settled = {
            let (stages, slopes) = (&mut stages[..all], &mut slopes[..all]);
            let jacobians = &mut jacobians[..all * n];
            let evaluate = |part: f64, point: &[f64], residual: &mut [f64], matrix: &mut [f64]| {
                for (row, stage) in stages.iter_mut().enumerate() {
                    *stage = own.start()[row % n] + point[row];
                }
                field.values(stages, slopes)?;
                field.jacobians(stages, jacobians)?;
                let at = (point, &*slopes, &*jacobians);
                own.equation(coefficients, part, at, residual, matrix);
                all_finite(residual, matrix, "a correction of the stages")
            };
            let solved = solved.map(|()| own.displacements());
            let spent = &mut taken[at].evaluations;
            branch.settle(nothing, sizes, solved, spent, evaluate)
        };
        match settled {
            Ok(true) => {}
            Ok(false) => {
                self.trajectories[at].begin_at(self.branch.end());
                self.active.clear();
                self.active.push(at);
                self.iterate(changes, taken);
                let found = self.trajectories[at].displacements();
                if taken[at].outcome.is_ok() {
                    taken[at].outcome = self.branch.confirm_end(found);
                }
            }
            Err(error) => taken[at].outcome = Err(error),
        }
        if taken[at].outcome.is_err() {
            self.clear(at);
        }
    }

    /// The stages of those that iterate, and F there.
    fn evaluate_slopes(&mut self, taken: &mut [StepReport]) {
        let (s, n) = (self.coefficients.tableau.stages(), self.dimension());
        let all = self.active.len() * s * n;
        let (stages, slopes) = (&mut self.stages[..all], &mut self.slopes[..all]);
        for (at, stages) in self.active.iter().zip(stages.chunks_exact_mut(s * n)) {
            self.trajectories[*at].place(stages);
        }
        let active = &self.active;
        let fail = |point: usize, error| taken[active[point / s]].fail(error);
        self.field.each_value(stages, slopes, fail);
    }

    /// DF there, for those that want it.
    fn evaluate_jacobians(&mut self, taken: &mut [StepReport]) {
        let (s, n) = (self.coefficients.tableau.stages(), self.dimension());
        self.wanting.clear();
        for (place, at) in self.active.iter().enumerate() {
            if taken[*at].outcome.is_ok() && self.trajectories[*at].wants_jacobians() {
                let own = &self.stages[place * s * n..][..s * n];
                self.linearized[self.wanting.len() * s * n..][..s * n].copy_from_slice(own);
                self.wanting.push(*at);
            }
        }
        if self.wanting.is_empty() {
            return;
        }
        let (wanting, all) = (&self.wanting, self.wanting.len() * s * n);
        let jacobians = &mut self.jacobians[..all * n];
        let fail = |point: usize, error| taken[wanting[point / s]].fail(error);
        self.field
            .each_jacobian(&self.linearized[..all], jacobians, fail);
        for (at, jacobians) in wanting.iter().zip(jacobians.chunks_exact(s * n * n)) {
            if taken[*at].outcome.is_ok() {
                let trajectory = &mut self.trajectories[*at];
                taken[*at].outcome =
                    trajectory.take_jacobians(&self.coefficients, jacobians, &mut self.matrix);
            }
        }
    }

    /// A correction of every trajectory that iterates; those that are solved or fail do so no longer.
    fn advance(&mut self, changes: &mut [f64], taken: &mut [StepReport]) {
        let (s, n) = (self.coefficients.tableau.stages(), self.dimension());
        let mut slopes = self.slopes.chunks_exact(s * n);
        self.active.retain(|&at| {
            let slopes = slopes.next().unwrap_or_default();
            let (trajectory, taken) = (&mut self.trajectories[at], &mut taken[at]);
            if taken.outcome.is_ok() {
                match trajectory.take_slopes(&self.coefficients, slopes) {
                    Ok(None) => return true,
                    Ok(Some(evaluations)) => {
                        taken.evaluations += evaluations as u64;
                        taken.is_rounded = trajectory.iteration.is_rounded();
                        trajectory.change(&self.coefficients, &mut changes[at * n..][..n]);
                        return false;
                    }
                    Err(error) => taken.fail(error),
                }
            }
            trajectory.clear();
            self.field.restart();
            false
        });
    }

    /// Whether [`tangent`](Self::tangent) is offered: F has a Jacobian.
    pub fn has_tangent(&self) -> bool {
        self.field.map().has_jacobian()
    }

    /// D(z + τ Σ b_j F(Z_j)) · V at the last solve of a trajectory, exact through the stage equations. The matrix V
    /// has as many rows as there are coordinates. Returns `None` where the equations are singular or F has no
    /// Jacobian.
    pub fn tangent(&mut self, at: usize, seeds: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        if !self.has_tangent() {
            return None;
        }
        let (s, n) = (self.coefficients.tableau.stages(), self.dimension());
        let trajectory = &mut self.trajectories[at];
        if self.is_by_lanes[at]
            && let Some(lanes) = &self.lanes
        {
            lanes.displacements(at, trajectory.displacements_mut());
        }
        let (stages, jacobians) = (&mut self.stages[..s * n], &mut self.jacobians[..s * n * n]);
        trajectory.place(stages);
        let mut is_defined = true;
        self.field
            .each_jacobian(stages, jacobians, |_, _| is_defined = false);
        if !is_defined || !trajectory.factor(&self.coefficients, jacobians, &mut self.matrix) {
            return None;
        }
        let mut displacements = DMatrix::zeros(s * n, seeds.ncols());
        for (column, seed) in seeds.column_iter().enumerate() {
            for (row, value) in trajectory.correction.iter_mut().enumerate() {
                *value = seed[row % n];
            }
            trajectory.solve_linear();
            displacements
                .column_mut(column)
                .copy_from_slice(&trajectory.correction);
        }
        let mut tangent = seeds.clone();
        for (j, b) in self.coefficients.tableau.weights().iter().enumerate() {
            let jacobian = DMatrix::from_row_slice(n, n, &jacobians[j * n * n..][..n * n]);
            let through = jacobian * displacements.rows(j * n, n);
            tangent += through * (self.coefficients.time_step * b);
        }
        tangent.iter().all(|v| v.is_finite()).then_some(tangent)
    }

    /// Weighted operations of all solves so far; `None` for a field that does not count.
    pub fn operations(&self) -> Option<u64> {
        let linear: u64 = self.trajectories.iter().map(|solve| solve.linear).sum();
        let lanes = self.lanes.as_ref().map_or(0, |lanes| lanes.operations());
        let accelerated = self.accelerated.iter();
        let accelerated: u64 = accelerated
            .map(|solve| solve.linear + solve.iteration.operations())
            .sum();
        Some(self.field.operations()? + linear + lanes + accelerated)
    }

    /// Forgets a trajectory's earlier solves.
    pub fn clear(&mut self, at: usize) {
        self.trajectories[at].clear();
        self.field.restart();
        self.until_lanes[at] = 0;
        if let Some(lanes) = &mut self.lanes {
            lanes.clear(at);
        }
    }

    /// Numbers that a trajectory's next solve depends on: the displacements of the last one, its slopes in lanes, and
    /// the field's memory. Before them stand the memory of the iteration and the steps until lanes are tried.
    pub fn memory(&self, at: usize) -> Vec<f64> {
        let own = &self.trajectories[at];
        let watch = [own.iteration.memory(), f64::from(self.until_lanes[at])];
        let lanes = self.lanes.as_ref().map(|lanes| lanes.memory(at));
        let lanes = lanes.unwrap_or_default();
        [
            &watch[..],
            own.displacements(),
            &lanes,
            &self.field.memory(),
        ]
        .concat()
    }

    /// Restores [`memory`](Self::memory).
    ///
    /// # Panics
    /// When `memory` has another length.
    pub fn restore(&mut self, at: usize, memory: &[f64]) {
        let own = &mut self.trajectories[at];
        own.iteration.restore(memory[0]);
        self.until_lanes[at] = memory[1] as u32;
        let (displacements, mut field) = memory[2..].split_at(own.displacements().len());
        own.restore(displacements);
        if let Some(lanes) = &mut self.lanes {
            let own = lanes.memory(at).len();
            lanes.restore(at, &field[..own]);
            field = &field[own..];
        }
        self.field.restore(field);
    }
}
