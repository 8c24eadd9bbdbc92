//! The exact realization of a linear Poisson tensor, whatever the Lie algebra.
//!
//! For Π_ij(x) = Σ_k c_ij^k x_k let Z = ε A(p), A(p) y = Π(y) p, the coadjoint map of p. Then α = Z/(e^Z − 1) x,
//! β = e^Z α = α(x, −p), σ(x) = (x, 0). This is Karasev's realization in closed form, the exponential chart of T*G for
//! a Lie group G of the algebra.
//!
//! With W = Z²/4 and g(w) = (√w coth √w − 1)/w both ends are x + W g(W) x ∓ ½ Z x.
//!
//! - [`structure`]: the structure constants, exact, as code and as numbers.
//! - [`relations`]: algebras on which W has one or two roots a coordinate, proved in the exact ring.
//! - [`doubling`]: g as code, on numbers, dual numbers and pairs of roots alike.
//! - [`closed_form`]: α and β of such algebras as straight-line code.
//! - [`even_part`]: W g(W) by partial fractions of a continued fraction, for every other algebra.
//! - `chart`: bounds of W, and the end of the chart.
//! - [`evaluator`]: α, β and their tangents from them as numbers.
//! - [`realization`]: [`LiePoisson`], the realization data.

mod chart;
pub mod closed_form;
pub mod doubling;
pub mod evaluator;
pub mod even_part;
pub mod realization;
pub mod relations;
pub mod structure;

pub use realization::LiePoisson;
