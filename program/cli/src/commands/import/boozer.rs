//! A field in Boozer coordinates: a JSON object of arrays.

use std::path::Path;

use leafwise::equilibrium::{Boozer, EquilibriumError, Ions, written_in_boozer};
use serde::Serialize;

use super::Imported;
use super::boozer_file::read;
use crate::table::words;

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
    let field = Boozer::new(read(path, text)?)?;
    let written = written_in_boozer(&field, ions, tables, source)?;
    let [along_theta, along_zeta] = field.data().nodes;
    let json = BoozerJson {
        nodes: [field.data().s.len(), along_theta, along_zeta],
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
        warnings: warnings(&field),
    })
}

/// Nodes that were left out, and where the tables leave the numbers.
fn warnings(field: &Boozer) -> Vec<String> {
    let ends = [("theta", "a turn"), ("zeta", "a field period")];
    let repeated = ends.iter().zip(field.repeated());
    let repeated = repeated
        .filter(|(_, is_repeated)| *is_repeated)
        .map(|((angle, of), _)| {
            format!(
                "the last node of {angle} is the end of {of} and repeats the first one: it is left out\n  = change: end before it"
            )
        });
    let departures = field.departures().iter().map(|departure| {
        let [least, most] = departure.range;
        format!(
            "the table of {} has {:.4} at s = {:.3}, {}, where the numbers of the surfaces lie from {least:.4} to {most:.4}: it is a \
             guess there\n  = change: give surfaces there",
            departure.name, departure.value, departure.s, departure.place
        )
    });
    repeated.chain(departures).collect()
}

fn lines(field: &Boozer, json: &BoozerJson) -> Vec<String> {
    let row = |name: &str, text: String| vec![name.to_owned(), text];
    let [surfaces, along_theta, along_zeta] = json.nodes;
    let [least, largest] = json.field;
    let [minor, major] = field.data().radii();
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
                "psi = {} Wb/rad at the edge, as of a torus with radii of {minor:.3} and {major:.3} m; B = grad(psi) × grad(theta) + iota grad(zeta) × grad(psi)",
                field.data().edge_flux
            ),
        ),
    ])
}
