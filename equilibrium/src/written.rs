//! An equilibrium as a scene.

use std::f64::consts::PI;
use std::fmt::Write;

use crate::equilibrium::Equilibrium;
use crate::error::EquilibriumError;
use crate::ions::{Ions, Start};

/// A scene with the files that belong beside it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The text of `scene.toml`.
    pub scene: String,
    /// Names and contents of the files: the tables, and the starts of an ensemble's members.
    pub files: Vec<(String, Vec<u8>)>,
}

impl Written {
    /// The table of an ensemble that starts at the states of `ions.csv`.
    pub(crate) fn ensemble(members: u32) -> String {
        format!(
            "\n[ensemble]\nmembers      = {members}\ninitial      = {{ file = \"ions.csv\" }}\nrecord       = {{ every = 200 }}\nfinal-states = \"csv\"\n"
        )
    }
}

/// Steps in the time that a particle with all its speed along B takes around the surface the short way.
const STEPS: f64 = 400.0;

/// The guiding centres of `ions` in an equilibrium, in metres, seconds and tesla; `source` is the name of the file.
///
/// # Errors
/// [`EquilibriumError`] where the ions have no start.
pub fn written(
    equilibrium: &Equilibrium,
    ions: &Ions,
    source: &str,
) -> Result<Written, EquilibriumError> {
    let start = ions.start(equilibrium)?;
    let [_, along_z] = equilibrium.file().nodes;
    let grid = |numbers: &[f64]| rows(numbers, along_z).into_bytes();
    let stream = equilibrium.stream_numbers();
    let mut files = vec![("psi.csv".to_owned(), grid(&equilibrium.file().psi))];
    files.extend(
        stream
            .iter()
            .map(|numbers| ("G.csv".to_owned(), grid(numbers))),
    );
    let source: String = source
        .chars()
        .filter(|letter| !letter.is_control())
        .collect();
    let mut scene = head(equilibrium, ions, start, &source);
    scene.push_str(&tables(equilibrium, stream.is_some()));
    scene.push_str(&motion(equilibrium, ions, start)?);
    if ions.members > 0 {
        let starts = states("R,Z,phi,u,mu", &ions.starts(equilibrium)?);
        files.push(("ions.csv".to_owned(), starts));
        scene.push_str(&Written::ensemble(ions.members));
    }
    Ok(Written { scene, files })
}

/// Comment, variables, Hamiltonian and one-form.
fn head(equilibrium: &Equilibrium, ions: &Ions, start: Start, source: &str) -> String {
    let file = equilibrium.file();
    let [axis, edge] = file.psi_range;
    let title = match file.title.chars().all(|letter| !letter.is_control()) {
        true => format!(" ({})", file.title),
        false => String::new(),
    };
    let [potential, field, told] = match equilibrium.stream_numbers() {
        Some(_) => [
            "(F_edge*ln(R) + G(R, Z))",
            "F_edge/R + D(G(R, Z), R)",
            "\n# A_Z = -(F_edge ln R + G); G is the integral of (F - F_edge)/R.",
        ],
        None => [
            "F_edge*ln(R)",
            "F_edge/R",
            "\n# A_Z = -F_edge ln R, since F is constant.",
        ],
    };
    let (species, ratio) = (ions.species, ions.species.charge() / ions.species.mass());
    format!(
        r#"# Guiding centres of {name}s in the equilibrium of {source}{title}, {r} × {z} nodes.
# Lengths are in m, times in s, fields in T. u is the velocity along B, mu = v_perp^2/(2 B), and s the normalized flux:
# 0 on the axis, 1 at the edge, where an ion is lost. The one-form is (q/m) A + u b with A_phi = psi and{told}

[system]
variables   = ["R", "Z", "phi", "u"]
parameters  = {{ mu = {mu:?}, charge_to_mass = {ratio:?}, F_edge = {f:?}, psi_axis = {axis:?}, psi_edge = {edge:?} }}
convention  = "{{x,H}}"
hamiltonian = "u^2/2 + mu*B"

[system.define]
BR   = "-D(psi(R, Z), Z)/R"
BZ   = "D(psi(R, Z), R)/R"
Bphi = "{field}"
B    = "sqrt(BR^2 + BZ^2 + Bphi^2)"
s    = "(psi(R, Z) - psi_axis)/(psi_edge - psi_axis)"

[system.bracket]
one-form = [
    "u*BR/B",
    "-charge_to_mass*{potential} + u*BZ/B",
    "charge_to_mass*psi(R, Z) + u*R*Bphi/B",
    "0",
]
"#,
        name = species.name(),
        r = file.nodes[0],
        z = file.nodes[1],
        mu = start.moment,
        f = equilibrium.edge_f(),
    )
}

/// The tables of ψ and G.
fn tables(equilibrium: &Equilibrium, has_stream: bool) -> String {
    let file = equilibrium.file();
    let axes = format!("{{ R = {:?}, Z = {:?} }}", file.r, file.z);
    let degree = equilibrium.degree();
    let mut text = "\n[system.tables]\n".to_owned();
    for name in ["psi", "G"]
        .into_iter()
        .take(if has_stream { 2 } else { 1 })
    {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{name:<3} = {{ file = \"{name}.csv\", axes = {axes}, degree = {degree} }}"
        );
    }
    text
}

/// Method, step and run.
fn motion(
    equilibrium: &Equilibrium,
    ions: &Ions,
    start: Start,
) -> Result<String, EquilibriumError> {
    let q = equilibrium.safety_factor(ions.surface)?.abs();
    let [r, _] = equilibrium.axis();
    let transit = 2.0 * PI * q * r / ions.species.speed(ions.energy)?;
    let step = rounded(transit / STEPS);
    let [r, z, turn, u] = start.state;
    Ok(format!(
        r#"
[method]
realization = "auto"
dynamics    = {{ name = "hamilton-jacobi", order = 4 }}
time-step   = {step:?}

[run]
initial = [{r:?}, {z:?}, {turn:?}, {u:?}]
steps   = 4000
stop    = "s > 1"
record  = {{ every = 10, observables = ["energy", "s", "B", {{ momentum = "charge_to_mass*psi(R, Z) + u*R*Bphi/B" }}] }}
"#
    ))
}

/// A number with its first digit alone.
pub(crate) fn rounded(number: f64) -> f64 {
    format!("{number:.0e}").parse().unwrap_or(number)
}

/// A grid, a line for each node along R.
fn rows(numbers: &[f64], along_z: usize) -> String {
    let mut text = String::new();
    for row in numbers.chunks(along_z) {
        let row: Vec<String> = row.iter().map(|number| format!("{number:?}")).collect();
        text.push_str(&row.join(","));
        text.push('\n');
    }
    text
}

/// The starts of members, a line each below their headings.
pub(crate) fn states(headings: &str, starts: &[Start]) -> Vec<u8> {
    let mut text = format!("{headings}\n");
    for Start { state, moment } in starts {
        let [a, b, c, d] = state;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{a:?},{b:?},{c:?},{d:?},{moment:?}");
    }
    text.into_bytes()
}

/// An array in NumPy's format.
pub(crate) fn array(shape: &[usize], numbers: &[f64]) -> Vec<u8> {
    let shape: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}");
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    // The header and what stands before it have 128 bytes.
    bytes.extend(format!("{header:<117}\n").bytes());
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    bytes
}
