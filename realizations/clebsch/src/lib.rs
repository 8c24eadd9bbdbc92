//! Clebsch variables of linear tensors: quadratic momentum maps as coordinates with a constant tensor.
//!
//! With {z_a, z_b} = Ω_ab the functions x_k = ½ zᵀS_k z have the brackets {x_i, x_j} = ½ zᵀ(S_iΩS_j − S_jΩS_i)z. These
//! are brackets of a Lie algebra wherever the S_k span one under them. A Gauss method for H∘J commutes with every
//! affine symmetry of Ω that J does not see. Where fibres of J are orbits of such symmetries, the step is one of x, and
//! Poisson to round-off (R. McLachlan, K. Modin, O. Verdier, Collective symplectic integrators, Nonlinearity 27
//! (2014)).
//!
//! - [`forms`]: lists of quadratic forms.
//! - [`algebra`]: algebras, given by forms with their brackets and sections.
//! - [`algebras`]: so(3), e(3), so(4), sp(2m).
//! - [`constants`]: structure constants, of tensors and of forms.
//! - [`relabel`]: which variable of a system is which of an algebra's.
//! - [`representation`]: algebras by matrices that a user gives.
//! - [`orbits`]: whether fibres are orbits of linear symmetries.
//! - [`over`]: points over states where no section is known.
//! - [`casimirs`]: quadratic Casimirs, and their changes by rounding.
//! - [`slowing`]: which multiples of them are taken off H.
//! - [`across`]: the way to a fibre nearby, where that takes no matrix.
//! - [`least`]: least changes that do what is asked.
//! - [`quadratic`]: [`QuadraticLift`], the lift.
//! - [`part`]: [`Clebsch`], the part `clebsch`.

pub mod across;
pub mod algebra;
pub mod algebras;
pub mod casimirs;
pub mod constants;
pub mod forms;
pub mod least;
pub mod orbits;
pub mod over;
pub mod part;
pub mod quadratic;
pub mod relabel;
pub mod representation;
pub mod slowing;

pub use part::Clebsch;
pub use quadratic::QuadraticLift;
pub use representation::Matrices;
