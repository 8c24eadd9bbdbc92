//! A g-file of EFIT: the tokamak's equilibrium, and what is said of it.

use leafwise::equilibrium::{Equilibrium, EquilibriumError, Geqdsk, Ions, written};
use leafwise::scene::json::optional;
use serde::Serialize;

use super::Imported;
use crate::table::words;

/// Surfaces whose safety factor is printed, by their normalized flux.
const SURFACES: [f64; 4] = [0.0, 0.25, 0.5, 0.95];

/// An equilibrium as `import --json` has it.
#[derive(Serialize)]
struct EquilibriumJson<'a> {
    title: &'a str,
    nodes: [usize; 2],
    axis: [f64; 2],
    field_on_axis: [f64; 3],
    safety_factors: Vec<SafetyFactor>,
    /// Whether the edge is closed inside the grid.
    has_edge: bool,
    /// Where the table of F is smeared: the normalized flux, and the part of F's variation by which it is off.
    smeared: Option<[f64; 2]>,
    /// An estimate of the error of ψ's table within the edge, of ψ's range; null for a grid of few nodes.
    #[serde(serialize_with = "optional")]
    roughness: Option<f64>,
}

/// The largest such error without a warning.
const ROUGH: f64 = 1e-3;

/// The safety factor of a surface.
#[derive(Serialize)]
struct SafetyFactor {
    /// The normalized flux.
    s: f64,
    /// From the field; null where the surface is not closed within the grid.
    #[serde(serialize_with = "optional")]
    q: Option<f64>,
    /// As the file has it.
    #[serde(serialize_with = "optional")]
    in_file: Option<f64>,
}

/// The scene of a g-file's text.
///
/// # Errors
/// [`EquilibriumError`] for a text that is no equilibrium, and ions without a start.
pub(super) fn imported(
    text: &str,
    (ions, degree): (&Ions, u8),
    source: &str,
) -> Result<Imported, EquilibriumError> {
    let equilibrium = Equilibrium::new(Geqdsk::parse(text)?, degree)?;
    let written = written(&equilibrium, ions, source)?;
    let (factors, smeared) = (safety_factors(&equilibrium), equilibrium.smeared());
    let roughness = equilibrium.roughness();
    let mut warnings = Vec::new();
    if !equilibrium.has_edge() {
        warnings.push(
            "the edge, s = 1, is not closed inside the grid: particles leave the tables before they are lost\n  = change: \
             write the equilibrium on a larger grid"
                .to_owned(),
        );
    }
    if let Some(smeared) = smeared {
        warnings.push(format!(
            "F = R B_phi changes within a few cells of the grid: its table is off by {:.0} % of its variation at s = {:.3}\n  = change: \
             write the equilibrium on a finer grid",
            100.0 * smeared.part,
            smeared.surface
        ));
    }
    if let Some(roughness) = roughness.filter(|roughness| *roughness > ROUGH) {
        warnings.push(format!(
            "psi of the file is noisy, or its grid coarse: its table is off by about {:.1} % of psi's range within the edge\n  = change: \
             write the equilibrium on a finer grid, or smooth psi",
            100.0 * roughness
        ));
    }
    let json = EquilibriumJson {
        title: &equilibrium.file().title,
        nodes: equilibrium.file().nodes,
        axis: equilibrium.axis(),
        field_on_axis: equilibrium.field(equilibrium.axis()),
        has_edge: equilibrium.has_edge(),
        roughness,
        smeared: smeared.map(|smeared| [smeared.surface, smeared.part]),
        safety_factors: factors,
    };
    Ok(Imported {
        written,
        lines: lines(&equilibrium, &json),
        json: serde_json::to_value(&json).unwrap_or_default(),
        warnings,
    })
}

fn safety_factors(equilibrium: &Equilibrium) -> Vec<SafetyFactor> {
    let told = &equilibrium.file().q;
    let of = |s: f64| SafetyFactor {
        s,
        q: equilibrium.safety_factor(s).ok().filter(|q| q.is_finite()),
        in_file: (!told.is_empty()).then(|| {
            let place = s * (told.len() - 1) as f64;
            let below = (place as usize).min(told.len() - 2);
            told[below] + (place - below as f64) * (told[below + 1] - told[below])
        }),
    };
    SURFACES.map(of).into()
}

fn lines(equilibrium: &Equilibrium, json: &EquilibriumJson<'_>) -> Vec<String> {
    let file = equilibrium.file();
    let ([left, right], [low, high]) = (file.r, file.z);
    let [along_r, along_z] = file.nodes;
    let [r, z] = equilibrium.axis().map(without_dust);
    let [b_r, b_z, b_phi] = equilibrium.field(equilibrium.axis());
    let strength = equilibrium.strength(equilibrium.axis());
    let [axis, edge] = file.psi_range;
    let row = |name: &str, text: String| vec![name.to_owned(), text];
    let mut rows = vec![
        row(
            "grid",
            format!(
                "{along_r} × {along_z} nodes, R from {left} to {right} m, Z from {low} to {high} m"
            ),
        ),
        row(
            "axis",
            format!(
                "R = {r:.6} m, Z = {z:.6} m; the file gives {:.6}, {:.6}",
                file.axis[0], file.axis[1]
            ),
        ),
        row(
            "field there",
            format!(
                "|B| = {strength:.6} T: B_R = {b_r:.1e}, B_Z = {b_z:.1e}, B_phi = {b_phi:.6}, positive where phi grows"
            ),
        ),
        row(
            "flux",
            format!(
                "psi = {axis} on the axis, {edge} at the edge, in Wb/rad; B_R = -(dpsi/dZ)/R, B_Z = (dpsi/dR)/R"
            ),
        ),
    ];
    if let Some(roughness) = json.roughness {
        rows.push(row(
            "table",
            format!("psi is off by about {roughness:.1e} of its range within the edge, by splines through part of the nodes"),
        ));
    }
    for (at, factor) in json.safety_factors.iter().enumerate() {
        let number =
            |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.4}"));
        let name = if at == 0 { "safety factor" } else { "" };
        rows.push(row(
            name,
            format!(
                "s = {:<4}  q = {}; the file gives {}",
                factor.s,
                number(factor.q),
                number(factor.in_file)
            ),
        ));
    }
    words(&rows)
}

/// A length with what is below a tenth of a micrometre as 0, which is not printed as -0.
fn without_dust(length: f64) -> f64 {
    if length.abs() < 1e-7 { 0.0 } else { length }
}
