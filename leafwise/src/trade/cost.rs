//! What runs are compared by while they are searched through.

use leafwise_core::SolverStatistics;

/// The cost of a solver's work.
pub(super) fn cost(statistics: &SolverStatistics) -> u64 {
    statistics.operations.unwrap_or(statistics.evaluations)
}
