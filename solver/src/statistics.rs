//! The work of a solver.

/// Work of a solver since it was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverStatistics {
    /// Steps taken, summed over lanes.
    pub steps: u64,
    /// Evaluations of the step kernel, summed over lanes.
    pub evaluations: u64,
    /// Operations of all kernels, weighted as [`OperationCount::work`] says, and of the linear algebra around them:
    /// eliminations, substitutions, sums over stages or nodes. Norms, extrapolation and the compensated sum, a few
    /// operations a coordinate and step, are left out. Four operations on the stages of a Gauss method side by side
    /// in the lanes of vectors count as one, since they take its time. The count is `None` when a part does not count
    /// its own.
    ///
    /// [`OperationCount::work`]: leafwise_expression::OperationCount::work
    pub operations: Option<u64>,
    /// The most evaluations one step took.
    pub most_evaluations: u64,
    /// Steps that failed.
    pub failures: u64,
    /// Steps whose solve ended with the state as a whole at round-off while a component, smaller by far than the
    /// largest, still changed. The relative error of that component is not known to be small.
    pub rounded: u64,
    /// Largest part of Σ |c x_i x_j| that was taken off a step so that a quadratic Casimir Σ c x_i x_j is
    /// held; 0 where none is.
    pub held: f64,
}

impl Default for SolverStatistics {
    /// No work.
    fn default() -> Self {
        Self {
            steps: 0,
            evaluations: 0,
            operations: Some(0),
            most_evaluations: 0,
            failures: 0,
            rounded: 0,
            held: 0.0,
        }
    }
}

impl SolverStatistics {
    /// Cost that methods are compared by: operations, or evaluations where the parts do not count those.
    pub fn cost(&self) -> u64 {
        self.operations.unwrap_or(self.evaluations)
    }

    /// Counts a step, its evaluations and its outcome.
    pub fn count(&mut self, evaluations: u64, succeeded: bool) {
        self.steps += 1;
        self.evaluations += evaluations;
        self.most_evaluations = self.most_evaluations.max(evaluations);
        self.failures += u64::from(!succeeded);
    }

    /// Counts a step of each of so many lanes, of equal numbers of evaluations, that succeeded.
    pub fn count_all(&mut self, lanes: u64, evaluations: u64) {
        self.steps += lanes;
        self.evaluations += lanes * evaluations;
        self.most_evaluations = self.most_evaluations.max(evaluations);
    }

    /// This work and more.
    pub fn and(self, more: Self) -> Self {
        Self {
            steps: self.steps + more.steps,
            evaluations: self.evaluations + more.evaluations,
            operations: self.operations.zip(more.operations).map(|(a, b)| a + b),
            most_evaluations: self.most_evaluations.max(more.most_evaluations),
            failures: self.failures + more.failures,
            rounded: self.rounded + more.rounded,
            held: self.held.max(more.held),
        }
    }

    /// The mean number of operations a step, `None` when a part does not count its own.
    pub fn operations_per_step(&self) -> Option<f64> {
        let operations = self.operations? as f64;
        Some(if self.steps == 0 {
            0.0
        } else {
            operations / self.steps as f64
        })
    }

    /// One line for reports: evaluations, rounded steps where there are any, and how Casimirs are held where they are.
    pub fn summary(&self) -> String {
        let mut line = format!(
            "{:.2} evaluations a step, at most {}",
            self.evaluations_per_step(),
            self.most_evaluations
        );
        match self.rounded {
            0 => {}
            1 => line.push_str("; one step ended at the round-off of its largest components"),
            steps => line.push_str(&format!(
                "; {steps} steps ended at the round-off of their largest components"
            )),
        }
        if self.held > 0.0 {
            line.push_str(&format!(
                "; Casimirs held within {:.1e} of their size",
                self.held
            ));
        }
        line
    }

    /// The mean number of evaluations a step.
    pub fn evaluations_per_step(&self) -> f64 {
        if self.steps == 0 {
            0.0
        } else {
            self.evaluations as f64 / self.steps as f64
        }
    }
}
