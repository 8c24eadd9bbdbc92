//! Methods: realizations with dynamics, steppers, compositions of either.

use std::sync::LazyLock;

use leafwise::core::{PartKind, Registry};

use crate::source::Source;
use crate::tensor::{Family, Tensor};

/// A scene's method.
#[derive(Clone, Debug)]
pub struct Method {
    /// The lines of `[method]`, but the step.
    pub text: String,
    /// The tolerance of a stepper that has one, else 0.
    pub tolerance: f64,
}

/// A method, mostly one that suits the tensor.
pub fn method(source: &mut Source<'_>, tensor: &Tensor) -> Method {
    let mut tolerance = 0.0;
    let mut text = match source.below(2) {
        0 => format!("stepper = {}\n", stepper(source, tensor, &mut tolerance)),
        _ => {
            let realization = realization(source, tensor);
            let most = if tensor.names.len() > 3 { 2 } else { 3 };
            // Lifts are stepped by Gauss methods alone; others are refused, which is seen often enough.
            let is_lift = KNOWN.lifts.iter().any(|lift| realization.contains(lift));
            let dynamics = match is_lift && source.chance(224) {
                true => format!(
                    "{{ name = \"collective\", stages = {} }}",
                    1 + source.below(16)
                ),
                false => dynamics(source, most),
            };
            format!("realization = {realization}\ndynamics = {dynamics}\n")
        }
    };
    if source.chance(80) {
        let has_factors = text.contains("splitting") || source.chance(16);
        let [others, needing] = &KNOWN.compositions;
        let name = match has_factors {
            true => source.pick(&[needing.as_slice(), others].concat()),
            false => source.pick(others),
        };
        text.push_str(&format!("composition = \"{name}\"\n"));
    }
    Method { text, tolerance }
}

/// Names of parts by what they need, as the registry tells it.
struct Known {
    /// Every composition, by whether it needs the factors of a splitting.
    compositions: [Vec<&'static str>; 2],
    /// Realizations that are coordinates with a constant tensor.
    lifts: Vec<&'static str>,
}

static KNOWN: LazyLock<Known> = LazyLock::new(|| {
    let registry = Registry::with_builtin();
    let of_kind = |kind: PartKind| {
        let parts = registry.parts().into_iter();
        parts.filter(move |info| info.kind == kind)
    };
    let needs_factors = |name: &&str| {
        let part = registry.composition(name);
        part.is_ok_and(|part| part.factors.is_some())
    };
    let compositions = of_kind(PartKind::Composition).map(|info| info.name);
    let (others, needing) = compositions.partition(|name| !needs_factors(name));
    let lifts = of_kind(PartKind::Realization).filter(|info| info.is_lift);
    Known {
        compositions: [others, needing],
        lifts: lifts.map(|info| info.name).collect(),
    }
});

/// Every realization.
pub const REALIZATIONS: [&str; 11] = [
    "karasev-truncated",
    "karasev-collocated",
    "clebsch",
    "constant",
    "darboux-magnetic",
    "lie-poisson",
    "log-canonical",
    "logarithms",
    "so3-cayley",
    "so3-exponential",
    "so3-group",
];

/// Every stepper.
pub const STEPPERS: [&str; 10] = [
    "gauss",
    "dop853",
    "dormand-prince45",
    "energy-preserving",
    "implicit-midpoint",
    "projection",
    "rk4",
    "spherical-midpoint",
    "splitting",
    "taylor",
];

fn realization(source: &mut Source<'_>, tensor: &Tensor) -> String {
    let suited: &[&str] = match tensor.family {
        Family::Rotations => &[
            "clebsch",
            "so3-cayley",
            "so3-exponential",
            "so3-group",
            "lie-poisson",
        ],
        Family::Linear => &["lie-poisson"],
        Family::LogCanonical => &["log-canonical", "logarithms"],
        Family::Constant => &["constant"],
        Family::Magnetic => &["karasev-truncated", "darboux-magnetic"],
        Family::General => &["karasev-truncated"],
    };
    let name = match source.below(8) {
        0 => return "\"auto\"".to_owned(),
        1 => source.pick(&REALIZATIONS),
        2 => "karasev-collocated",
        3 | 4 => "karasev-truncated",
        _ => source.pick(suited),
    };
    match name {
        "karasev-truncated" => {
            let most = if tensor.names.len() > 3 { 3 } else { 6 };
            format!(
                "{{ name = \"{name}\", order = {} }}",
                1 + source.below(most)
            )
        }
        "karasev-collocated" if source.chance(64) => {
            format!("{{ name = \"{name}\", points = {} }}", 1 + source.below(8))
        }
        "darboux-magnetic" => {
            let potential = tensor.potential.as_deref().unwrap_or("0; 0");
            format!("{{ name = \"{name}\", potential = \"{potential}\" }}")
        }
        _ => format!("\"{name}\""),
    }
}

/// Orders to 2·`most`: series are dear where coordinates are many.
fn dynamics(source: &mut Source<'_>, most: usize) -> String {
    match source.below(8) {
        0 => "\"auto\"".to_owned(),
        1 | 2 => {
            let integrator = source.pick(&["gauss", "stormer-verlet", "implicit-midpoint"]);
            let stages = match integrator {
                "gauss" => format!(", stages = {}", 1 + source.below(4)),
                _ => String::new(),
            };
            let correction = if source.chance(64) {
                "none"
            } else {
                "bisection"
            };
            format!(
                "{{ name = \"collective\", integrator = \"{integrator}\"{stages}, correction = \"{correction}\" }}"
            )
        }
        _ => {
            let order = 2 * (1 + source.below(most));
            let hamiltonian = if source.chance(40) {
                "energy-casimir"
            } else {
                "given"
            };
            format!(
                "{{ name = \"hamilton-jacobi\", order = {order}, hamiltonian = \"{hamiltonian}\" }}"
            )
        }
    }
}

fn stepper(source: &mut Source<'_>, tensor: &Tensor, tolerance: &mut f64) -> String {
    let name = match (source.below(4), tensor.family) {
        // Of a general tensor hardly any piece has a flow, and it takes long to see that.
        (0, family) if family != Family::General => "splitting",
        (1, Family::Rotations) => "spherical-midpoint",
        _ => source.pick(&STEPPERS),
    };
    match name {
        "gauss" => format!("{{ name = \"gauss\", stages = {} }}", 1 + source.below(16)),
        "energy-preserving" => format!("{{ name = \"{name}\", order = {} }}", source.pick(&[2, 4])),
        "projection" => format!(
            "{{ name = \"{name}\", base = \"{}\" }}",
            source.pick(&["rk4", "gauss"])
        ),
        "dop853" | "dormand-prince45" | "taylor" => {
            *tolerance = source.pick(&[1e-4, 1e-8, 1e-12]);
            format!("{{ name = \"{name}\", tolerance = {tolerance:?} }}")
        }
        _ => format!("\"{name}\""),
    }
}
