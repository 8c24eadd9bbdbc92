//! What a step map declares about itself.

/// How well a map preserves the Poisson tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// Φ is a Poisson map, to round-off.
    Exact,
    /// Φ_* π − π = O(tⁿ⁺¹): the order n.
    Order(usize),
    /// Not a Poisson map.
    None,
}

/// What a step map promises; instruments measure it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapProperties {
    /// A lower bound of the order in t = εh.
    pub order: usize,
    /// How well it preserves the Poisson tensor.
    pub structure: Structure,
    /// Whether Φ_{−h} ∘ Φ_h = id; `None` where that is not known.
    pub self_adjoint: Option<bool>,
}
