//! Claims about the mathematics and behaviour of the whole, a module each: `cargo test --test claims branches`.

mod advice;
mod branches;
mod checkpoint;
mod collocation;
mod drift;
mod energy_casimir;
mod exact_methods;
mod expansion;
mod flows;
mod jacobi;
mod kernels;
mod limits;
mod lockstep;
mod numbers;
mod opaque_checks;
mod opaque_methods;
mod opaque_steppers;
mod orders;
mod paper;
mod paper_slopes;
mod part_names;
mod poles;
mod reference;
mod stress;
mod theorems;
mod truncation_high;
