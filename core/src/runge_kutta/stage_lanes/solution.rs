//! One solve of stage equations: its start and its outcome.

/// A solve that ended.
pub(crate) struct FixedPoint {
    /// Evaluations of all stages.
    pub evaluations: u64,
    /// Whether corrections stopped to fall before they were negligible.
    pub is_rounded: bool,
}

/// A solve whose corrections did not fall by one half each.
pub(crate) struct Unsettled {
    /// Evaluations of all stages.
    pub evaluations: u64,
    /// The last correction, in units of the coordinates.
    pub correction: f64,
}

/// Where a step begins.
#[derive(Clone, Copy)]
pub(crate) struct Start<'a> {
    /// z.
    pub point: &'a [f64],
    /// Sizes that corrections are measured against beside |Z_i − z|.
    pub sizes: &'a [f64],
    /// Numbers that F reads beside Z.
    pub beside: &'a [f64],
}

/// Solves Z_i = z + τ Σ_j a_ij F(Z_j) by Z_i ← z + τ Σ_j a_ij F(Z_j) for several trajectories, each by itself.
pub(crate) trait StageLanes: Send {
    /// Writes τ Σ_j b_j F(Z_j) for a trajectory's step from z. The stages start from the polynomial of its last step.
    /// Where that does not lead to the solution that is connected with z, they start from z, and then go by parts.
    ///
    /// # Errors
    /// [`Unsettled`] where there is none.
    fn solve(
        &mut self,
        at: usize,
        start: Start<'_>,
        change: &mut [f64],
    ) -> Result<FixedPoint, Unsettled>;
    /// Z_i − z of a trajectory's last solve, one stage after the other.
    fn displacements(&self, at: usize, out: &mut [f64]);
    /// Forgets a trajectory's earlier solves.
    fn clear(&mut self, at: usize);
    /// The numbers that a trajectory's next solve depends on; always of the same length.
    fn memory(&self, at: usize) -> Vec<f64>;
    /// Restores [`memory`](Self::memory).
    fn restore(&mut self, at: usize, memory: &[f64]);
    /// Operations of all solves so far.
    fn operations(&self) -> u64;
}
