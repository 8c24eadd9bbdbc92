//! Karasev's symplectic realization, truncated to any order.
//!
//! Given (x, p), let Y: [0, 1] → M solve Y′ = ε Π(Y) p with mean ∫₀¹ Y ds = x. Then
//! α_ε(x, p) = Y(0), β_ε(x, p) = Y(1) = α_ε(x, −p) and σ(x) = (x, 0). Sources: paper, section 3.1;
//! Karasev 1987; Cabrera, *Generating functions for local symplectic groupoids and non-perturbative
//! semiclassical quantization*, section 3.3.
//!
//! - [`curve`]: the curve's series, order by order, over any algebra.
//! - [`truncated`]: [`TruncatedKarasev`], R̂_ε = τⁿK_ε (paper, section 3.2).
//! - [`stages`]: the same over a long lattice, one sweep an order.
//! - [`collocated`]: [`CollocatedKarasev`], the defining relation solved at Gauss nodes.
//! - `ends`: the order at which the series ends, so that a truncation is exact.
//! - [`series`]: α along p(h) in the exact ring, for Hamilton–Jacobi coefficients.

pub mod collocated;
pub mod curve;
mod ends;
pub mod series;
pub mod stages;
pub mod truncated;

pub use collocated::CollocatedKarasev;
pub use curve::KarasevCurve;
pub use truncated::TruncatedKarasev;
