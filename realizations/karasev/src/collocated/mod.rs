//! Karasev's realization by collocation at Gauss nodes: numerically exact, from values of Π(y)p
//! alone.
//!
//! Y is represented by its values at q Gauss–Legendre nodes, Y_j = x + ε Σ_k A_jk Π(Y_k) p. Here A
//! is the zero-mean antiderivative of the Lagrange basis. The bracket defect of α is O(ε^{2q})
//! (paper, the remark "Other approximations of K_ε", section 3.2).
//!
//! - [`rule`]: nodes, weights and the matrices A.
//! - `field`: Π(y)p and its derivatives as kernels.
//! - `curvature`: its second derivatives along a covector.
//! - `curve`: the nodal values solved for.
//! - `simplified`: their corrections, by Newton's method with derivatives at one point.
//! - `collocation`: a field with the nodes of its curves.
//! - `tangent`: derivatives through the curve's equations.
//! - `evaluator`: α̂, β̂ and their tangents at (x, p).
//! - `fused`: the step as one solve for curve, x̂ and p.
//! - `data`: [`CollocatedKarasev`].

mod collocation;
mod curvature;
mod curve;
mod data;
mod evaluator;
mod field;
mod fused;
pub mod rule;
mod simplified;
mod tangent;

pub use data::CollocatedKarasev;
pub use rule::CollocationRule;
