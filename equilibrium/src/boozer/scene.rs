//! A field in Boozer coordinates as a scene.

use std::f64::consts::PI;
use std::fmt::Write;

use super::field::Boozer;
use super::surfaces::LARGEST;
use crate::error::EquilibriumError;
use crate::ions::Ions;
use crate::written::{Written, array, rounded, states};

/// Steps in the way around a surface the short way, and along a field period, with all speed along B.
const STEPS: [f64; 2] = [400.0, 40.0];

/// Nodes of the tables of one variable.
const PROFILE_NODES: usize = 129;

/// Nodes and weights of Gauss's rule on [0, 1], exact to degree 5.
const GAUSS: [[f64; 2]; 3] = [
    [0.112_701_665_379_258_31, 5.0 / 18.0],
    [0.5, 8.0 / 18.0],
    [0.887_298_334_620_741_7, 5.0 / 18.0],
];

/// A function of s in formulas: a number, or a table of this name.
struct Profile {
    call: String,
    file: Option<(String, Vec<u8>)>,
}

impl Profile {
    fn new(name: &str, numbers: &[f64]) -> Self {
        let first = numbers[0];
        // What is interpolated between equal numbers is one up to round-off.
        let is_constant = |number: &f64| (number - first).abs() <= 1e-13 * first.abs();
        if numbers.iter().all(is_constant) {
            let call = format!("{first:?}");
            return Self { call, file: None };
        }
        let mut text = String::new();
        for number in numbers {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{number:?}");
        }
        Self {
            call: format!("{name}(s)"),
            file: Some((name.to_owned(), text.into_bytes())),
        }
    }
}

/// The guiding centres of `ions` in a field, in metres, seconds and tesla.
///
/// So many nodes stand across the disk of x and y. The splines have this degree. The file's name is `source`.
///
/// # Errors
/// [`EquilibriumError`] where the ions have no start.
pub fn written_in_boozer(
    field: &Boozer,
    ions: &Ions,
    (nodes, degree): (usize, u8),
    source: &str,
) -> Result<Written, EquilibriumError> {
    let start = field.start(ions)?;
    let step = time_step(field, ions)?;
    let data = field.data();
    let at = |i: usize| LARGEST * i as f64 / (PROFILE_NODES - 1) as f64;
    let of = |f: &dyn Fn(f64) -> f64| (0..PROFILE_NODES).map(|i| f(at(i))).collect::<Vec<f64>>();
    let profiles = [
        Profile::new("chi", &chi(field, at)),
        Profile::new("G", &of(&|s| field.g(s))),
        Profile::new("I_over_s", &of(&|s| field.i_over_s(s))),
    ];
    let [chi, g, i_over_s] = &profiles;
    let with_current = match i_over_s.call.as_str() {
        "0.0" => "psi_edge*charge_to_mass".to_owned(),
        call => format!("(psi_edge*charge_to_mass + rho*{call})"),
    };
    let is_axisymmetric = field.is_axisymmetric();
    let (strength, momentum) = match is_axisymmetric {
        true => (
            "modB(x, y)",
            format!(
                ", {{ momentum = \"rho*{} - charge_to_mass*{}\" }}",
                g.call, chi.call
            ),
        ),
        false => ("modB(x, y, zeta)", String::new()),
    };
    let ratio = ions.species.charge() / ions.species.mass();
    let source: String = source
        .chars()
        .filter(|letter| !letter.is_control())
        .collect();
    let [surfaces, along_theta, along_zeta] = [data.s.len(), data.nodes[0], data.nodes[1]];
    let mut scene = format!(
        r#"# Guiding centres of {name}s in the field of {source}, in Boozer coordinates: {surfaces} surfaces of {along_theta} × {along_zeta} nodes.
# x + i y = sqrt(s) exp(i theta), s = psi/psi_edge: 0 on the axis, 1 at the edge, where an ion is lost. rho = u/B with u the
# velocity along B, mu = v_perp^2/(2 B). Lengths are in m, times in s, fields in T. The one-form is
# ((q/m) psi + rho I) dtheta + (rho G - (q/m) chi) dzeta with chi' = iota, and s dtheta = x dy - y dx.

[system]
variables   = ["x", "y", "zeta", "rho"]
parameters  = {{ mu = {mu:?}, charge_to_mass = {ratio:?}, psi_edge = {psi:?} }}
convention  = "{{x,H}}"
hamiltonian = "rho^2*B^2/2 + mu*B"

[system.define]
s = "x^2 + y^2"
B = "{strength}"

[system.bracket]
one-form = [
    "-y*{with_current}",
    "x*{with_current}",
    "rho*{g} - charge_to_mass*{chi}",
    "0",
]

[system.tables]
"#,
        name = ions.species.name(),
        mu = start.moment,
        psi = data.edge_flux,
        g = g.call,
        chi = chi.call,
    );
    let mut files = Vec::new();
    for (name, bytes) in profiles.into_iter().filter_map(|profile| profile.file) {
        let _ = writeln!(
            scene,
            "{name} = {{ file = \"{name}.csv\", axes = {{ s = [0, {LARGEST:?}] }}, degree = {degree} }}"
        );
        files.push((format!("{name}.csv"), bytes));
    }
    let (disk, shape) = disk(field, nodes);
    let edge = libm::sqrt(LARGEST);
    let mut axes = format!("x = [{:?}, {edge:?}], y = [{:?}, {edge:?}]", -edge, -edge);
    let mut periodic = "";
    if !is_axisymmetric {
        let period = 2.0 * PI / f64::from(data.periods);
        let _ = write!(axes, ", zeta = [0, {period:?}]");
        periodic = ", periodic = [\"zeta\"]";
    }
    let _ = writeln!(
        scene,
        "modB = {{ file = \"modB.npy\", axes = {{ {axes} }}{periodic}, degree = {degree} }}"
    );
    files.push(("modB.npy".to_owned(), array(&shape, &disk)));
    let [x, y, zeta, rho] = start.state;
    let _ = write!(
        scene,
        r#"
[method]
realization = "auto"
dynamics    = {{ name = "hamilton-jacobi", order = 4 }}
time-step   = {step:?}

[run]
initial = [{x:?}, {y:?}, {zeta:?}, {rho:?}]
steps   = 4000
stop    = "s > 1"
record  = {{ every = 10, observables = ["energy", "s", "B", {{ u = "rho*B" }}{momentum}] }}
"#
    );
    if ions.members > 0 {
        let headings = "x,y,zeta,rho,mu";
        files.push((
            "ions.csv".to_owned(),
            states(headings, &field.starts(ions)?),
        ));
        scene.push_str(&Written::ensemble(ions.members));
    }
    Ok(Written { scene, files })
}

/// χ = ψ_edge ∫ ι ds at nodes, 0 on the axis.
fn chi(field: &Boozer, at: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut numbers = vec![0.0; PROFILE_NODES];
    for i in 1..PROFILE_NODES {
        let (from, to) = (at(i - 1), at(i));
        let sum: f64 = GAUSS
            .iter()
            .map(|[place, weight]| weight * field.iota(from + (to - from) * place))
            .sum();
        numbers[i] = numbers[i - 1] + field.data().edge_flux * (to - from) * sum;
    }
    numbers
}

/// |B| on a grid of x and y, and of twice the nodes of ζ; and the grid's shape.
fn disk(field: &Boozer, nodes: usize) -> (Vec<f64>, Vec<usize>) {
    let edge = libm::sqrt(LARGEST);
    let along = match field.is_axisymmetric() {
        true => 1,
        false => 2 * field.data().nodes[1],
    };
    let at = |i: usize| edge * (2.0 * i as f64 / (nodes - 1) as f64 - 1.0);
    let mut numbers = Vec::with_capacity(nodes * nodes * along);
    for i in 0..nodes {
        for j in 0..nodes {
            let (x, y) = (at(i), at(j));
            let (s, theta) = (x * x + y * y, libm::atan2(y, x));
            numbers.extend(field.strength_along_zeta(s, theta, along));
        }
    }
    let mut shape = vec![nodes, nodes];
    if along > 1 {
        shape.push(along);
    }
    (numbers, shape)
}

/// A part of the shortest time on the way: around the surface the short way, and along a field period. The length of field line in
/// a turn of ζ is 2π (G + ιI)/B.
fn time_step(field: &Boozer, ions: &Ions) -> Result<f64, EquilibriumError> {
    let (speed, s) = (ions.checked_speed()?, ions.checked_surface()?);
    let iota = field.iota(s).abs();
    let along = (field.g(s) + field.iota(s) * field.i_over_s(s) * s).abs();
    let turn = 2.0 * PI * along / (field.strength(s, 0.0, 0.0) * speed);
    let [around, period] = STEPS;
    // Of an ι of 0 the first is infinite.
    let around = turn / (iota * around);
    Ok(rounded(
        around.min(turn / (f64::from(field.data().periods) * period)),
    ))
}
