//! Methods: realizations with dynamics, steppers, compositions of either.

use std::sync::LazyLock;

use leafwise::core::part::{ParameterDefault, PartInfo};
use leafwise::core::{PartKind, PartParameters, PoissonSystem, Registry};

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

/// Names of parts by what they need, as the registry tells it, each list sorted.
struct Known {
    /// Every composition, by whether it needs the factors of a splitting.
    compositions: [Vec<&'static str>; 2],
    /// Realizations whose parameters have defaults.
    realizations: Vec<&'static str>,
    /// Those of them that are coordinates with a constant tensor.
    lifts: Vec<&'static str>,
    /// Realizations that take a vector potential.
    of_potentials: Vec<&'static str>,
    /// The realization that serves every tensor.
    of_order: &'static str,
    /// The exact one of those that serve every tensor.
    exact: &'static str,
    /// Realizations made for tensors of a family and no others.
    suited: Vec<(Family, Vec<&'static str>)>,
    /// Steppers whose parameters have defaults.
    steppers: Vec<&'static str>,
    /// Steppers made for rotations and no others.
    of_rotations: Vec<&'static str>,
    /// Integrators that collective methods are compared by.
    integrators: Vec<&'static str>,
}

/// A system of the library for each family of tensors.
const OF_FAMILY: [(Family, &str); 6] = [
    (Family::Rotations, "rigid-body"),
    (Family::Linear, "heavy-top"),
    (Family::LogCanonical, "lotka-volterra-periodic"),
    (Family::Constant, "kepler"),
    (Family::Magnetic, "magnetic"),
    (Family::General, GENERAL),
];

const GENERAL: &str = "gradient";

static KNOWN: LazyLock<Known> = LazyLock::new(|| {
    let registry = Registry::with_builtin();
    let of_kind = |kind: PartKind| {
        let parts = registry.parts().into_iter();
        let mut parts: Vec<_> = parts
            .filter(|info| info.kind == kind && !info.is_written)
            .collect();
        parts.sort_by_key(|info| info.name);
        parts
    };
    let names = |parts: &[&'static PartInfo]| -> Vec<&'static str> {
        parts.iter().map(|info| info.name).collect()
    };
    let system = |library: &str| {
        let part = registry.system(library).expect("a system of the library");
        part.build(&PartParameters::new()).expect("a system")
    };
    let general = system(GENERAL);
    let (realizations, steppers) = (of_kind(PartKind::Realization), of_kind(PartKind::Stepper));
    let realizes = |name: &str, system: &PoissonSystem| {
        let part = registry.realization(name);
        part.is_ok_and(|part| part.build(system, &PartParameters::new()).is_ok())
    };
    let steps = |name: &str, system: &PoissonSystem| {
        let part = registry.stepper(name);
        part.is_ok_and(|part| part.build(system, &PartParameters::new()).is_ok())
    };
    let suited = OF_FAMILY.map(|(family, library)| {
        let own = system(library);
        let made_for = |info: &&&'static PartInfo| {
            realizes(info.name, &own)
                && (family == Family::General || !realizes(info.name, &general))
        };
        let made_for: Vec<_> = realizations.iter().filter(made_for).copied().collect();
        (family, names(&made_for))
    });
    let rotations = system("rigid-body");
    let of_rotations = |info: &&&'static PartInfo| {
        steps(info.name, &rotations)
            && !OF_FAMILY[2..]
                .iter()
                .any(|(_, other)| steps(info.name, &system(other)))
    };
    let of_rotations: Vec<_> = steppers.iter().filter(of_rotations).copied().collect();
    let needs_factors = |name: &&str| {
        let part = registry.composition(name);
        part.is_ok_and(|part| part.factors.is_some())
    };
    let compositions = of_kind(PartKind::Composition);
    let compositions = compositions.into_iter().map(|info| info.name);
    let (others, needing) = compositions.partition(|name| !needs_factors(name));
    let settings = of_kind(PartKind::Dynamics).into_iter();
    let settings = settings.flat_map(|info| info.surveyed.iter().copied().flatten());
    let mut integrators: Vec<&str> = settings
        .filter_map(|setting| match setting {
            ("integrator", ParameterDefault::Text(name)) => Some(*name),
            _ => None,
        })
        .collect();
    integrators.sort_unstable();
    integrators.dedup();
    let of_order = registry.of_order(PartKind::Realization);
    let exact = registry.exact_realization(&general, false);
    let some = |has: fn(&PartInfo) -> bool| {
        let some: Vec<_> = realizations
            .iter()
            .filter(|info| has(info))
            .copied()
            .collect();
        names(&some)
    };
    Known {
        compositions: [others, needing],
        lifts: some(|info| info.is_lift),
        of_potentials: some(|info| has(info, "potential")),
        of_order: of_order
            .expect("a realization that serves every tensor")
            .name,
        exact: exact
            .expect("an exact realization of every tensor")
            .info
            .name,
        suited: suited.into(),
        realizations: names(&realizations),
        steppers: names(&steppers),
        of_rotations: names(&of_rotations),
        integrators,
    }
});

/// Whether a part has a parameter of this name.
fn has(info: &PartInfo, parameter: &str) -> bool {
    info.parameters.iter().any(|own| own.name == parameter)
}

/// Declaration of a part.
fn info(name: &str) -> &'static PartInfo {
    let parts = Registry::with_builtin().parts().into_iter();
    let mut parts = parts.filter(|info| info.name == name);
    parts.next().expect("a part of the registry")
}

/// Every composition up to an order over a base of order 2, sorted.
pub fn compositions(most: usize) -> Vec<&'static str> {
    let registry = Registry::with_builtin();
    let mut names: Vec<&str> = KNOWN.compositions.concat();
    names.retain(|name| {
        registry
            .composition(name)
            .is_ok_and(|part| part.order <= most)
    });
    names.sort_unstable();
    names
}

/// Steppers made for rotations and no others, sorted.
pub fn steppers_of_rotations() -> &'static [&'static str] {
    &KNOWN.of_rotations
}

fn realization(source: &mut Source<'_>, tensor: &Tensor) -> String {
    let suited = KNOWN
        .suited
        .iter()
        .find(|(family, _)| *family == tensor.family);
    let mut suited = suited.map_or_else(Vec::new, |(_, names)| names.clone());
    if tensor.potential.is_some() {
        suited.extend(&KNOWN.of_potentials);
    }
    if suited.is_empty() {
        suited.push(KNOWN.of_order);
    }
    let name = match source.below(8) {
        0 => return "\"auto\"".to_owned(),
        1 => source.pick(&KNOWN.realizations),
        2 => KNOWN.exact,
        3 | 4 => KNOWN.of_order,
        _ => source.pick(&suited),
    };
    let info = info(name);
    if name == KNOWN.of_order {
        let most = if tensor.names.len() > 3 { 3 } else { 6 };
        format!(
            "{{ name = \"{name}\", order = {} }}",
            1 + source.below(most)
        )
    } else if has(info, "points") && source.chance(64) {
        format!("{{ name = \"{name}\", points = {} }}", 1 + source.below(8))
    } else if has(info, "potential") {
        let potential = tensor.potential.as_deref().unwrap_or("0; 0");
        format!("{{ name = \"{name}\", potential = \"{potential}\" }}")
    } else {
        format!("\"{name}\"")
    }
}

/// Orders to 2·`most`: series are dear where coordinates are many.
fn dynamics(source: &mut Source<'_>, most: usize) -> String {
    match source.below(8) {
        0 => "\"auto\"".to_owned(),
        1 | 2 => {
            let integrator = source.pick(&KNOWN.integrators);
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
        (1, Family::Rotations) => source.pick(&KNOWN.of_rotations),
        _ => source.pick(&KNOWN.steppers),
    };
    let info = info(name);
    if has(info, "tolerance") {
        *tolerance = source.pick(&[1e-4, 1e-8, 1e-12]);
        format!("{{ name = \"{name}\", tolerance = {tolerance:?} }}")
    } else if has(info, "stages") {
        format!("{{ name = \"{name}\", stages = {} }}", 1 + source.below(16))
    } else if has(info, "base") {
        let base = source.pick(&["rk4", "gauss"]);
        format!("{{ name = \"{name}\", base = \"{base}\" }}")
    } else if has(info, "order") {
        format!("{{ name = \"{name}\", order = {} }}", source.pick(&[2, 4]))
    } else {
        format!("\"{name}\"")
    }
}
