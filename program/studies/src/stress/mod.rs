//! The extremes: cases with their outcome written down before they are run.
//!
//! - [`cases`]: the table, by family;
//! - [`Case`], [`Outcome`]: what is asked and expected, what was measured;
//! - [`StressOptions`]: how long the long cases run;
//! - `setup`, `attempt`, `target`: systems and methods, single steps, the residual of a solve;
//! - the other modules: one family of cases each.
//!
//! What every case asks beside its own claim: never a wrong number without an error.

mod attempt;
mod case;
mod chaos;
mod degenerate;
mod dimensions;
mod fields;
mod lattices;
mod long;
mod nearly;
mod numbers;
mod orders;
mod setup;
mod sizes;
mod steps;
mod stiff;
mod target;
mod trivial;
mod underflow;
mod zeros;

pub use case::{Case, Outcome, StressError, StressOptions};
pub use fields::SCENES_FOR_FAULTS;

/// Every case, family by family.
pub fn cases() -> impl Iterator<Item = &'static Case> {
    FAMILIES.into_iter().flatten()
}

const FAMILIES: [&[Case]; 15] = [
    &trivial::CASES,
    &degenerate::CASES,
    &zeros::CASES,
    &nearly::CASES,
    &steps::CASES,
    &sizes::CASES,
    &numbers::CASES,
    &fields::CASES,
    &stiff::CASES,
    &underflow::CASES,
    &orders::CASES,
    &dimensions::CASES,
    &lattices::CASES,
    &chaos::CASES,
    &long::CASES,
];
