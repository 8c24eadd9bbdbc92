//! `noise = [{ hamiltonian = "…", strength = "…" }]`: what moves the system at random.

use super::located::Located;
use super::reader::{Item, Problems, Table};
use super::system_schema::NOISE;

/// A channel σ {H_k, x} ∘ dW.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseSpec {
    /// H_k.
    pub hamiltonian: Located<String>,
    /// σ, a formula of the parameters.
    pub strength: Located<String>,
}

/// The channels of a `[system]` table; those of a library system that are not given anew stay.
pub(super) fn read_noise(
    table: &Table<'_>,
    known: Vec<NoiseSpec>,
    problems: &mut Problems,
) -> Option<Vec<NoiseSpec>> {
    match table.get("noise") {
        Some(item) => item.list_of("a list of channels", problems, read_channel),
        None => Some(known),
    }
}

fn read_channel(item: &Item<'_>, problems: &mut Problems) -> Option<NoiseSpec> {
    let expected = "a table such as { hamiltonian = \"x1\", strength = \"0.1\" }";
    let table = item.table("noise", expected, problems)?;
    table.only(&NOISE, problems);
    let hamiltonian = table
        .require("hamiltonian", "hamiltonian = \"x1\"", problems)
        .and_then(|item| item.formula(problems));
    let strength = table
        .require("strength", "strength = \"0.1\"", problems)
        .and_then(|item| item.formula(problems));
    Some(NoiseSpec {
        hamiltonian: hamiltonian?,
        strength: strength?,
    })
}
