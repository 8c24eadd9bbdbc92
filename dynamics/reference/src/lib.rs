//! Baselines: methods that need no realization, on the same compiled kernels as those that do.
//!
//! Comparisons then measure methods and not implementations. Each part says truthfully what it
//! preserves: most are not Poisson maps. All take εh as the time step of ẋ = X_H(x) = −Π(x) ∇H(x).
//!
//! - [`rk4`]: the classical Runge–Kutta method.
//! - `dop853`: Dormand and Prince's pair of order 8(5,3), adaptive inside a step.
//! - [`dormand_prince45`]: their pair of order 5(4), as `ode45`.
//! - [`taylor`]: the motion's Taylor series, of order and substeps from a tolerance.
//! - [`implicit_midpoint`], [`gauss`]: symplectic for tensors that are constant on each leaf.
//! - [`energy_preserving`]: Cohen and Hairer's methods of order 2 and 4.
//! - [`spherical_midpoint`]: a Poisson map on products of so(3)*.
//! - [`projection`]: a method followed by projection onto energy and Casimirs.
//!
//! - `reference_map`: a method as a step map.
//! - `allowed`: what the error of a coordinate may be, of those with a tolerance.
//! - `floors`: how little of each coordinate is not looked at, in units of its own.
//! - `adaptive`: what the embedded pairs share.
//! - `implicit`: what the implicit Runge–Kutta methods share.
//! - `step_equation`: the solve of the other implicit methods.

mod adaptive;
mod allowed;
pub mod dop853;
mod dop853_coefficients;
pub mod dormand_prince45;
pub mod energy_preserving;
mod floors;
pub mod gauss;
mod implicit;
pub mod implicit_midpoint;
pub mod projection;
mod reference_map;
pub mod rk4;
mod singular;
pub mod spherical_midpoint;
mod step_equation;
pub mod taylor;
