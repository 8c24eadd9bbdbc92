//! The equation of a step, β̂(L(y)) = x, as code.

use leafwise_expression::Term;

/// β̂ = base + offset and α̂ = β̂ + increment, each a list of d terms.
///
/// The split keeps round-off small: offset and increment are of the size of a step and are formed
/// without cancellation.
#[derive(Clone, Debug)]
pub struct SourceTarget {
    /// A point near both ends: x in a chart of T*M.
    pub base: Vec<Term>,
    /// β̂ − base.
    pub offset: Vec<Term>,
    /// α̂ − β̂.
    pub increment: Vec<Term>,
    /// Guard of the chart: first and last term of a truncated series, or the radius of a closed form's chart and how
    /// far the point reaches in it. Where the last is not the smaller one, the point is outside the chart. Both lists
    /// have equal lengths and are compared by their largest entries. Where these say outside, terms of series are
    /// compared also coordinate by coordinate, in units of their own. Closed forms that hold everywhere have `None`.
    pub guard: Option<(Vec<Term>, Vec<Term>)>,
}

/// Treatment of the equation β̂(L(y)) = x_k by a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Correction {
    /// Solves it: the map is α̂ ∘ (β̂|_L)⁻¹, Poisson over an exact realization.
    Bisection,
    /// Takes y = x_k (paper, Algorithm 2): Poisson to the order of the integrator only.
    None,
}
