//! The numbers of a field in Boozer coordinates.

/// The fewest surfaces, and nodes of an angle, that make a field.
const FEWEST: usize = 4;

/// The most field periods: fields of coils have some dozens.
const MOST_PERIODS: u32 = 1000;

/// Relative difference of numbers at 0 and at the end of a period: cos 2πm is off by less for m of some hundreds.
const SAME: f64 = 1e-12;

/// Relative difference of |B| along θ on the axis: numbers of seven digits have it.
const ON_AXIS: f64 = 1e-6;

/// The smallest ratio of the minor to the major radius, and one over the largest.
const LEAST_RATIO: f64 = 1e-6;

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

impl BoozerData {
    /// The numbers without nodes that repeat the first one at the end of a turn, or of a field period, and whether θ and ζ had one.
    pub(super) fn without_repeats(mut self) -> (Self, [bool; 2]) {
        let [along_theta, along_zeta] = self.nodes;
        let each = along_theta.checked_mul(along_zeta);
        if each.and_then(|each| each.checked_mul(self.s.len())) != Some(self.strength.len()) {
            return (self, [false; 2]);
        }
        let mut repeated = [false; 2];
        for angle in [0, 1] {
            // Blocks of lines, each of numbers at one node of the angle.
            let line = if angle == 0 { along_zeta } else { 1 };
            let block = line * self.nodes[angle];
            if self.nodes[angle] > 1 && ends_meet(&self.strength, block, line) {
                repeated[angle] = true;
                self.nodes[angle] -= 1;
                let kept = self.strength.chunks(block);
                self.strength = kept.flat_map(|own| own[..block - line].to_vec()).collect();
            }
        }
        (self, repeated)
    }

    /// I on a surface.
    fn current(&self, at: usize) -> f64 {
        self.i.get(at).copied().unwrap_or(0.0)
    }

    /// Radii of the torus with this flux and field: √(2|ψ|/B) and |G + ιI|/B, in m, with B of the first surface's first node.
    pub fn radii(&self) -> [f64; 2] {
        let strength = self.strength[0];
        let along = self.g[0] + self.iota[0] * self.current(0);
        [
            libm::sqrt(2.0 * self.edge_flux.abs() / strength),
            along.abs() / strength,
        ]
    }
}

/// Whether the last line of every block is its first one, and not all lines are alike.
fn ends_meet(numbers: &[f64], block: usize, line: usize) -> bool {
    let is_same = |one: &[f64], other: &[f64]| {
        let pairs = one.iter().zip(other);
        pairs
            .into_iter()
            .all(|(a, b)| (a - b).abs() <= SAME * a.abs())
    };
    let blocks = || numbers.chunks(block);
    blocks().all(|own| is_same(&own[..line], &own[block - line..]))
        && blocks().any(|own| !own.chunks(line).all(|other| is_same(&own[..line], other)))
}

/// Refuses numbers that are no field; those that had repeated nodes of θ and ζ are told so.
///
/// # Errors
/// The reason, in words.
pub(super) fn check(data: &BoozerData, repeated: [bool; 2]) -> Result<(), String> {
    let surfaces = data.s.len();
    let [along_theta, along_zeta] = data.nodes;
    if !(1..=MOST_PERIODS).contains(&data.periods) {
        return Err(format!(
            "`periods` is {}: a torus has 1 to {MOST_PERIODS} field periods",
            data.periods
        ));
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
            "`B` has {along_theta} nodes of theta and {along_zeta} of zeta{}: {FEWEST} of each are needed at least, or 1 of zeta in \
             an axisymmetric field",
            if repeated == [false; 2] {
                ""
            } else {
                " but for the last one, which repeats the first"
            }
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
    check_finite(data)?;
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
    let along = |at: usize| data.g[at] + data.iota[at] * data.current(at);
    if let Some(at) = (0..surfaces).find(|&at| along(at) * along(0) <= 0.0) {
        return Err(format!(
            "`G + iota I` is {} on surface {} and {} on the first: the volume B² dtheta dzeta keeps one sign",
            along(at),
            at + 1,
            along(0)
        ));
    }
    if data.s[0] == 0.0 && data.current(0) != 0.0 {
        return Err(format!(
            "`I` is {} on the axis, s = 0, where no current is enclosed: it must be 0 there",
            data.current(0)
        ));
    }
    if data.s[0] == 0.0 {
        check_axis(&data.strength[..along_theta * along_zeta], along_zeta)?;
    }
    check_size(data)
}

/// Refuses profiles and a flux that are not finite.
fn check_finite(data: &BoozerData) -> Result<(), String> {
    for (name, numbers) in [("iota", &data.iota), ("G", &data.g), ("I", &data.i)] {
        if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
            return Err(format!(
                "`{name}` is {} on surface {}: it must be finite",
                numbers[at],
                at + 1
            ));
        }
    }
    if !data.edge_flux.is_finite() {
        return Err(format!("`psi` is {}: it must be finite", data.edge_flux));
    }
    Ok(())
}

/// Refuses a flux that no torus with this field has.
fn check_size(data: &BoozerData) -> Result<(), String> {
    let [minor, major] = data.radii();
    let slenderness = minor / major;
    if !(LEAST_RATIO..=1.0 / LEAST_RATIO).contains(&slenderness) {
        return Err(format!(
            "`psi` is {:?} Wb/rad: with |B| = {} T and G = {} T·m a torus would have the minor radius sqrt(2 psi/B) = {minor:.1e} m and \
             the major radius G/B = {major:.1e} m",
            data.edge_flux, data.strength[0], data.g[0]
        ));
    }
    Ok(())
}

/// Refuses |B| on the axis that depends on θ, which has no value there.
fn check_axis(numbers: &[f64], along_zeta: usize) -> Result<(), String> {
    for (node, strength) in numbers.iter().enumerate() {
        let first = numbers[node % along_zeta];
        if (strength - first).abs() > ON_AXIS * first {
            return Err(format!(
                "`B` on the axis, s = 0, is {strength} at the node {} of theta and {first} at the first one: the axis is one point for \
                 all theta; leave that surface out, or give the field of the axis",
                node / along_zeta + 1
            ));
        }
    }
    Ok(())
}
