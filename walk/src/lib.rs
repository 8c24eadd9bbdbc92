//! Trajectories in memory, watched between steps.
//!
//! [`Watched`] advances the lanes of a [`Walk`](leafwise_core::Walk) by what a [`Course`] says and hands each [`Look`] over to who
//! takes it. After each step it looks, in this order, at
//!
//! 1. the step itself: a lane whose step fails ends at its last good state; with [`Indicators`], the step's tangent;
//! 2. the [`Pace`]: a lane whose time does not advance as it should ends at the state before;
//! 3. [`Event`]s that act: each [`Act`] changes the state where it is, the rest of the step begins there, and what follows looks at that
//!    rest alone. Samples at times before are taken first;
//! 4. the condition of [`Stop`]: a lane ends at the first state at which it holds, between two steps;
//! 5. other [`Event`]s in the order of their times, up to one that ends the lane;
//! 6. invariants: a lane that has left the energy's domain ends;
//! 7. samples at steps or at times ([`SampleTimes`]);
//! 8. the end: all steps, or a time.
//!
//! States between two steps are ends of shorter steps from the first ([`LastStep`]). They are of the map's own order,
//! lie on the leaf of the trajectory, and do not influence later steps. A step in which a condition or a surface may be met
//! and left again is looked into by them. Where nobody looks between steps, many are made
//! before they are looked at, and invariants are evaluated at all of their states at once.

mod alone;
mod batch;
mod course;
mod domain;
mod events;
mod fault;
mod functions;
mod indicators;
mod layout;
mod look;
mod pace;
mod step;
mod times;
mod turns;
mod watched;

pub use course::Course;
pub use domain::outside;
pub use events::{Act, Direction, Event, Section, Side, Stop};
pub use fault::{Ended, Fault, StopPlace, Why};
pub use functions::{FunctionValues, StateFunctions};
pub use indicators::{Begins, Deviation, Indicator, Indicators};
pub use layout::{Clock, StateLayout};
pub use look::{At, Look, Steps};
pub use pace::{NoPace, Pace, PacedSteps};
pub use step::{LastStep, StepEnd, StepStart};
pub use times::{SampleTimes, is_same_time};
pub use turns::Past;
pub use watched::Watched;
pub use watched::memory::Memory;
