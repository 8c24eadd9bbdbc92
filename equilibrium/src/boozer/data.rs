//! The numbers of a field in Boozer coordinates.

/// The fewest surfaces, and nodes of an angle, that make a field.
const FEWEST: usize = 4;

/// Numbers of a field in Boozer coordinates, on K surfaces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoozerData {
    /// Field periods in a turn of ζ.
    pub periods: u32,
    /// ψ at s = 1, the toroidal flux over 2π, in Wb/rad.
    pub edge_flux: f64,
    /// s = ψ/ψ_edge of the surfaces, rising, from 0 to 1.
    pub s: Vec<f64>,
    /// ι on each surface.
    pub iota: Vec<f64>,
    /// G on each surface, in T·m.
    pub g: Vec<f64>,
    /// I on each surface, in T·m; empty where there is no toroidal current.
    pub i: Vec<f64>,
    /// Nodes of θ over a turn, and of ζ over a field period, the first at 0 and the last one before the period's end.
    pub nodes: [usize; 2],
    /// |B| in T, of surface after surface, and on each of θ after θ.
    pub strength: Vec<f64>,
}

/// Refuses numbers that are no field.
///
/// # Errors
/// The reason, in words.
pub(super) fn check(data: &BoozerData) -> Result<(), String> {
    let surfaces = data.s.len();
    let [along_theta, along_zeta] = data.nodes;
    if data.periods == 0 {
        return Err("`periods` is 0: a torus has 1 field period at least".to_owned());
    }
    if surfaces < FEWEST {
        return Err(format!(
            "`s` has {surfaces} surfaces: {FEWEST} are needed at least"
        ));
    }
    for (name, numbers) in [("iota", &data.iota), ("G", &data.g), ("I", &data.i)] {
        if numbers.len() != surfaces && !(name == "I" && numbers.is_empty()) {
            return Err(format!(
                "`{name}` has {} numbers where `s` has {surfaces} surfaces",
                numbers.len()
            ));
        }
    }
    let count = surfaces
        .checked_mul(along_theta)
        .and_then(|count| count.checked_mul(along_zeta));
    if count != Some(data.strength.len()) {
        return Err(format!(
            "`B` has {} numbers where {surfaces} surfaces with {along_theta} × {along_zeta} nodes of theta and zeta have another \
             count",
            data.strength.len()
        ));
    }
    if along_theta < FEWEST || along_zeta == 0 || (2..FEWEST).contains(&along_zeta) {
        return Err(format!(
            "`B` has {along_theta} nodes of theta and {along_zeta} of zeta: {FEWEST} of each are needed at least, or 1 of zeta in \
             an axisymmetric field"
        ));
    }
    if let Some(at) = (0..surfaces).find(|&at| {
        let s = data.s[at];
        !(0.0..=1.0).contains(&s) || (at > 0 && s <= data.s[at - 1])
    }) {
        return Err(format!(
            "`s` is {} at surface {} of {surfaces}: it rises from 0, the axis, to 1, the edge",
            data.s[at],
            at + 1
        ));
    }
    if data.s[surfaces - 1] < 0.5 {
        return Err(format!(
            "`s` ends at {}: without surfaces near the edge, s = 1, the field there would be a guess",
            data.s[surfaces - 1]
        ));
    }
    let profiles = data.iota.iter().chain(&data.g).chain(&data.i);
    if profiles.chain([&data.edge_flux]).any(|x| !x.is_finite()) {
        return Err("`iota`, `G`, `I` or `psi` has a number that is not finite".to_owned());
    }
    if data.edge_flux == 0.0 {
        return Err("`psi`, the toroidal flux at the edge over 2 pi, is 0".to_owned());
    }
    if let Some(at) = data
        .strength
        .iter()
        .position(|b| !(*b > 0.0 && b.is_finite()))
    {
        let (surface, node) = (
            at / (along_theta * along_zeta),
            at % (along_theta * along_zeta),
        );
        return Err(format!(
            "`B` is {} on surface {}, at the node {} of theta and {} of zeta: it is a field strength, above 0",
            data.strength[at],
            surface + 1,
            node / along_zeta + 1,
            node % along_zeta + 1
        ));
    }
    let current = |at: usize| data.i.get(at).copied().unwrap_or(0.0);
    let along = |at: usize| data.g[at] + data.iota[at] * current(at);
    if let Some(at) = (0..surfaces).find(|&at| along(at) * along(0) <= 0.0) {
        return Err(format!(
            "`G + iota I` is {} on surface {} and {} on the first: the volume B² dtheta dzeta keeps one sign",
            along(at),
            at + 1,
            along(0)
        ));
    }
    if data.s[0] == 0.0 && current(0) != 0.0 {
        return Err(format!(
            "`I` is {} on the axis, s = 0, where no current is enclosed: it must be 0 there",
            current(0)
        ));
    }
    Ok(())
}
