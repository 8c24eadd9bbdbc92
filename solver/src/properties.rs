//! Properties that a step map declares about itself.

use std::fmt;

use serde::{Serialize, Serializer};

/// Preservation of the Poisson structure by a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// Φ is a Poisson map, to round-off.
    Exact,
    /// Φ_* π − π = O(tⁿ⁺¹): the order n.
    Order(usize),
    /// Φ maps every symplectic leaf into itself, to round-off, and keeps all Casimirs; it is not a Poisson map.
    Leaves,
    /// Φ multiplies a contact form by a function, to round-off.
    Contact,
    /// Not a Poisson map.
    None,
}

impl fmt::Display for Structure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact => f.write_str("exact"),
            Self::Order(n) => write!(f, "order {n}"),
            Self::Leaves => f.write_str("leaves"),
            Self::Contact => f.write_str("contact"),
            Self::None => f.write_str("none"),
        }
    }
}

impl Serialize for Structure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Properties that a step map promises; instruments measure them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapProperties {
    /// A lower bound of the order in t = εh; 0 where the error does not depend on the step.
    pub order: usize,
    /// Preservation of the Poisson structure.
    pub structure: Structure,
    /// Whether Φ_{−h} ∘ Φ_h = id; `None` where that is not known.
    pub self_adjoint: Option<bool>,
}

/// Demands of a composition on the pieces of a splitting, beyond χ and χ*.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pieces {
    /// Nothing.
    Any,
    /// Two, H = T + V with {V, {V, {V, T}}} = 0, as T = p²/2 and V(q); χ begins with the flow of V, or else of T.
    Nystrom {
        /// Whether it is V's.
        kick_first: bool,
    },
    /// Two, H = A + B with a small B; χ begins with the flow of A.
    Perturbed,
}

impl fmt::Display for Pieces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Any => "any pieces",
            Self::Nystrom { .. } => "two pieces T and V with {V, {V, {V, T}}} = 0",
            Self::Perturbed => "two pieces, one of them a small perturbation",
        })
    }
}
