//! Poisson integrators assembled from symplectic realizations and Lagrangian bisections.

pub use leafwise_core as core;
pub use leafwise_expression as expression;
pub use leafwise_systems as systems;

use leafwise_hamilton_jacobi as _;
use leafwise_karasev as _;
