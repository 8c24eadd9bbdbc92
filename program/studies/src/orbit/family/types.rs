//! Families of orbits as values: how one is followed, and what was found.

use super::super::{OrbitError, PeriodicOrbit};

/// The quantity that a family is continued in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Along {
    /// The energy.
    Energy,
    /// The period.
    Period,
    /// A parameter of the system, with the energy or the period held.
    Parameter(String),
}

/// How a family is followed.
#[derive(Clone, Debug)]
pub struct Following {
    /// The quantity.
    pub along: Along,
    /// The value where it ends.
    pub to: f64,
    /// Orbits, at most.
    pub most: usize,
    /// The branch point at which the other family is followed, from 1 on; with the other sign on its other side.
    pub branch: Option<i64>,
}

/// A mark of an orbit in its family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// The quantity that is continued turns back.
    Fold,
    /// Another family comes through: one more multiplier pair is 1.
    Branch,
    /// A multiplier pair is −1: a family of twice the period begins.
    Doubling,
    /// The energy turns back along the family, which no other meets.
    EnergyFold,
    /// Two multiplier pairs meet on the unit circle and leave it: their signatures are opposite (M. Krein 1950).
    Krein,
}

/// An orbit of a family.
#[derive(Clone, Debug)]
pub struct FamilyOrbit {
    /// The quantity that is continued.
    pub value: f64,
    /// The orbit.
    pub orbit: PeriodicOrbit,
    /// A mark, where it has one.
    pub mark: Option<Mark>,
}

/// Where a family ends.
#[derive(Debug)]
pub enum Ends {
    /// At the value that was asked for.
    Reached,
    /// Beyond its beginning, to which it came back by a fold.
    Returned,
    /// At the greatest number of orbits.
    Many,
    /// At an equilibrium, to which the orbits shrink.
    Equilibrium,
    /// Before as many branch points as were asked for.
    NoBranch,
    /// Where no further orbit closes.
    Lost(OrbitError),
}

/// Orbits in their order.
#[derive(Debug)]
pub struct OrbitFamily {
    /// The orbits, the first as it was closed.
    pub members: Vec<FamilyOrbit>,
    /// Where they end.
    pub ends: Ends,
}
