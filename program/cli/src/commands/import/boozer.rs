//! A field in Boozer coordinates: a JSON object of arrays.

use std::path::Path;

use leafwise::equilibrium::{Boozer, BoozerData, EquilibriumError, Ions, written_in_boozer};
use leafwise::scene::read_npy;
use serde::{Deserialize, Serialize};

use super::Imported;
use crate::table::words;

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoozerFile {
    periods: u32,
    psi: f64,
    s: Vec<f64>,
    iota: Vec<f64>,
    #[serde(rename = "G")]
    g: Vec<f64>,
    #[serde(rename = "I", default)]
    i: Vec<f64>,
    #[serde(rename = "B")]
    strength: StrengthFile,
}

/// |B| on surfaces, of θ and of ζ.
#[derive(Deserialize)]
#[serde(untagged)]
enum StrengthFile {
    /// An array of NumPy's beside the file.
    File(String),
    Numbers(Vec<Vec<Vec<f64>>>),
}

/// A field as `import --json` has it.
#[derive(Serialize)]
struct BoozerJson {
    /// Surfaces, and nodes of θ and ζ on each.
    nodes: [usize; 3],
    periods: u32,
    /// On the axis.
    field_on_axis: f64,
    /// The least and the largest.
    field: [f64; 2],
    /// On the axis and at the edge.
    iota: [f64; 2],
    is_axisymmetric: bool,
}

/// The scene of a file's text.
///
/// # Errors
/// [`EquilibriumError`] for a text that is no field, and ions without a start.
pub(super) fn imported(
    path: &Path,
    text: &str,
    (ions, tables): (&Ions, (usize, u8)),
    source: &str,
) -> Result<Imported, EquilibriumError> {
    let file: BoozerFile = serde_json::from_str(text).map_err(|error| {
        EquilibriumError::Odd(format!(
            "no field in Boozer coordinates, {{\"periods\": 5, \"psi\": …, \"s\": […], \"iota\": […], \"G\": […], \"I\": […], \
             \"B\": \"B.npy\"}}: {error}"
        ))
    })?;
    let (nodes, strength) = numbers(path, file.strength)?;
    let field = Boozer::new(BoozerData {
        periods: file.periods,
        edge_flux: file.psi,
        s: file.s,
        iota: file.iota,
        g: file.g,
        i: file.i,
        nodes,
        strength,
    })?;
    let written = written_in_boozer(&field, ions, tables, source)?;
    let json = BoozerJson {
        nodes: [field.data().s.len(), nodes[0], nodes[1]],
        periods: field.data().periods,
        field_on_axis: field.strength(0.0, 0.0, 0.0),
        field: field.range(),
        iota: [field.iota(0.0), field.iota(1.0)],
        is_axisymmetric: field.is_axisymmetric(),
    };
    Ok(Imported {
        written,
        lines: lines(&field, &json),
        json: serde_json::to_value(&json).unwrap_or_default(),
        warnings: Vec::new(),
    })
}

/// |B| as one list, and its nodes of θ and ζ.
fn numbers(
    path: &Path,
    strength: StrengthFile,
) -> Result<([usize; 2], Vec<f64>), EquilibriumError> {
    let odd = EquilibriumError::Odd;
    match strength {
        StrengthFile::File(name) => {
            let beside = path.parent().unwrap_or(Path::new("")).join(name);
            let array = read_npy(&beside).map_err(odd)?;
            match array.shape[..] {
                [_, along_theta, along_zeta] => Ok(([along_theta, along_zeta], array.numbers)),
                _ => Err(odd(format!(
                    "{} has the shape {:?}: `B` has three axes, of surfaces, theta and zeta",
                    beside.display(),
                    array.shape
                ))),
            }
        }
        StrengthFile::Numbers(numbers) => {
            let row = numbers.first().and_then(|surface| surface.first());
            let nodes = [numbers.first().map_or(0, Vec::len), row.map_or(0, Vec::len)];
            let is_even = numbers.iter().all(|surface| {
                surface.len() == nodes[0] && surface.iter().all(|row| row.len() == nodes[1])
            });
            match is_even {
                true => Ok((nodes, numbers.into_iter().flatten().flatten().collect())),
                false => Err(odd(
                    "`B` has rows of different lengths: it is an array over surfaces, theta and zeta"
                        .to_owned(),
                )),
            }
        }
    }
}

fn lines(field: &Boozer, json: &BoozerJson) -> Vec<String> {
    let row = |name: &str, text: String| vec![name.to_owned(), text];
    let [surfaces, along_theta, along_zeta] = json.nodes;
    let [least, largest] = json.field;
    let kind = match (json.is_axisymmetric, json.periods) {
        (true, _) => "axisymmetric".to_owned(),
        (false, 1) => "1 field period".to_owned(),
        (false, periods) => format!("{periods} field periods"),
    };
    words(&[
        row(
            "surfaces",
            format!(
                "{surfaces}, s from {} to {}, each with {along_theta} × {along_zeta} nodes of theta and zeta; {kind}",
                field.data().s[0],
                field.data().s[surfaces - 1]
            ),
        ),
        row(
            "field",
            format!(
                "|B| = {:.6} T on the axis, {least:.6} to {largest:.6} T on the surfaces",
                json.field_on_axis
            ),
        ),
        row(
            "iota",
            format!(
                "{:.4} on the axis, {:.4} at the edge",
                json.iota[0], json.iota[1]
            ),
        ),
        row(
            "currents",
            format!(
                "G = {:.6}, I = {:.6} T·m at the edge; B = G grad(zeta) + I grad(theta)",
                field.g(1.0),
                field.i_over_s(1.0)
            ),
        ),
        row(
            "flux",
            format!(
                "psi = {} Wb/rad at the edge; B = grad(psi) × grad(theta) + iota grad(zeta) × grad(psi)",
                field.data().edge_flux
            ),
        ),
    ])
}
