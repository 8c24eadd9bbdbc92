//! One part compiled in and loaded: the same bits along the same path, for the kinds that `parts` does
//! not try so.

#![cfg(unix)]

mod support;
#[path = "support/twins.rs"]
mod twins;

use std::sync::Arc;

use leafwise_core::evaluator::one_by_one;
use leafwise_core::part::ParameterSetting;
use leafwise_core::part_description::{ParameterDescription, PartDescription};
use leafwise_core::runge_kutta::SmoothMap;
use leafwise_core::system::SystemEvaluator;
use leafwise_core::{
    BuildError, DynamicApproximation, DynamicsProperties, Evaluator, LagrangianBisection, Method,
    OneForm, Origin, PartKind, PartParameters, PoissonSystem, RealizationData, Registry, StepError,
    StepMap, Walk,
};
use leafwise_plugin_abi::{
    LW_FLAG_NOT_SELF_ADJOINT, LW_FLAG_SELF_ADJOINT, LW_STRUCTURE_EXACT, LW_STRUCTURE_NONE,
};
use leafwise_plugin_loader::PartDeclaration;
use leafwise_plugin_loader::declaration::{Dimensions, Flags};
use support::build::{Workshop, rust_example};
use support::orbits::{method, orbit, orbits, realization, rigid_body};
use support::{built_in, load};
use twins::{RodriguesTwin, gyrostat_twin};

/// y ↦ (y, h ∇H(y)) of the C fixture `bisections`, as an embedding or as a one-form.
#[derive(Clone, Copy, Debug)]
struct Shear {
    is_one_form: bool,
}

impl DynamicApproximation for Shear {
    fn properties(&self) -> DynamicsProperties {
        DynamicsProperties::of_order(2, Some(true))
    }
    fn describe(&self) -> String {
        "shear".to_owned()
    }
    fn bisection(
        &self,
        system: &PoissonSystem,
        realization: &Arc<dyn RealizationData>,
    ) -> Result<LagrangianBisection, BuildError> {
        let (numbers, d) = (system.numbers().expect("formulas"), system.dimension());
        let shear = move |parameters: &[f64], h| ShearForm {
            numbers: numbers.evaluator(parameters),
            dimension: d,
            h,
        };
        if self.is_one_form {
            let form = SmoothMap::from_numbers(d, d, true, move |parameters, _, h| {
                Box::new(shear(parameters, h))
            });
            return LagrangianBisection::graph(OneForm::Numbers(form), realization, 0, "shear");
        }
        let map = SmoothMap::from_numbers(d, 2 * d, true, move |parameters, _, h| {
            Box::new(ShearPoint(shear(parameters, h)))
        })
        .for_one_trajectory();
        Ok(LagrangianBisection::Points {
            map,
            is_near_identity: false,
        })
    }
}

/// θ = h dH.
struct ShearForm {
    numbers: Box<dyn SystemEvaluator>,
    dimension: usize,
    h: f64,
}

impl ShearForm {
    /// h D²H(y) in the rows of a matrix from `first` on.
    fn hessian(&mut self, y: &[f64], first: usize, matrix: &mut [f64]) -> Result<(), StepError> {
        let d = y.len();
        let mut column = vec![0.0; d];
        for k in 0..d {
            let unit: Vec<f64> = (0..d).map(|j| f64::from(u8::from(j == k))).collect();
            self.numbers.hessian(y, &unit, &mut column)?;
            for (j, value) in column.iter().enumerate() {
                matrix[(first + j) * d + k] = self.h * value;
            }
        }
        Ok(())
    }
}

impl Evaluator for ShearForm {
    fn values(&mut self, y: &[f64], p: &mut [f64]) -> Result<(), StepError> {
        self.numbers.gradient(y, p)?;
        p.iter_mut().for_each(|p| *p *= self.h);
        Ok(())
    }
    fn jacobians(&mut self, y: &[f64], jacobians: &mut [f64]) -> Result<(), StepError> {
        one_by_one(self.dimension, y, jacobians, |y, jacobian| {
            self.hessian(y, 0, jacobian)
        })
    }

    fn operations(&self) -> Option<u64> {
        None
    }
}

/// y ↦ (y, θ(y)), one point at a time.
struct ShearPoint(ShearForm);

impl Evaluator for ShearPoint {
    fn values(&mut self, y: &[f64], z: &mut [f64]) -> Result<(), StepError> {
        let (x, p) = z.split_at_mut(y.len());
        x.copy_from_slice(y);
        self.0.values(y, p)
    }
    fn jacobians(&mut self, y: &[f64], tangent: &mut [f64]) -> Result<(), StepError> {
        let d = y.len();
        tangent.fill(0.0);
        (0..d).for_each(|i| tangent[i * d + i] = 1.0);
        self.0.hessian(y, d, tangent)
    }

    fn operations(&self) -> Option<u64> {
        None
    }
}

#[test]
fn dynamics_of_numbers_step_to_the_same_bits_loaded_or_compiled_in() {
    let workshop = Workshop::new();
    let mut registry = built_in();
    load(&workshop.compile("bisections"), None, &mut registry).expect("six parts");
    let system = rigid_body();
    for (name, is_one_form, on, path) in [
        ("bisections/embedding", false, "so3-cayley", "evaluators"),
        ("bisections/one-form", true, "so3-cayley", "evaluators"),
        ("bisections/one-form", true, "karasev-collocated", "fused"),
    ] {
        let on = || realization(&registry, on, &system, PartParameters::new()).expect("it fits");
        let here = Method::compose(&system, on(), Arc::new(Shear { is_one_form }));
        let here = here.expect("a method");
        let there = method(&registry, &system, on(), (name, None)).expect("a method");
        assert_eq!([here.path(), there.path()], [path, path]);
        let orbits = [&here, &there].map(|method| orbit(&system, method, 300));
        assert_eq!(orbits[0], orbits[1], "{name}");
    }
}

#[test]
fn a_system_of_numbers_serves_steppers_to_the_same_bits_loaded_or_compiled_in() {
    use leafwise_reference as _;
    let workshop = Workshop::new();
    let mut registry = Registry::with_builtin();
    let library = workshop.compile("../../../examples/c/gyrostat");
    load(&library, None, &mut registry).expect("the example");
    let part = registry.system("example-c/gyrostat").expect("the gyrostat");
    let loaded = part.build(&PartParameters::new()).expect("its defaults");
    let here = gyrostat_twin(&loaded);
    for name in ["rk4", "gauss", "implicit-midpoint", "dop853"] {
        let stepper = registry.stepper(name).expect("built in");
        let on = |system: &PoissonSystem| {
            let map = stepper.build(system, &PartParameters::new());
            map.expect("it serves numbers")
        };
        let (there, here_map) = (on(&loaded), on(&here));
        let alone = orbit(&here, here_map.as_ref(), 300);
        assert_eq!(orbit(&loaded, there.as_ref(), 300), alone, "{name}");
        let all = orbits(&loaded, there.as_ref(), 17, 300);
        assert_eq!(all, orbits(&here, here_map.as_ref(), 17, 300), "{name}");
        assert_eq!(all[0], alone, "{name}");
    }
}

#[test]
fn a_realization_of_numbers_steps_several_trajectories_to_the_same_bits() {
    let mut registry = built_in();
    load(&rust_example(), None, &mut registry).expect("the example");
    let system = rigid_body();
    let there = realization(
        &registry,
        "example/so3-rodrigues",
        &system,
        PartParameters::new().with("path", "numbers"),
    );
    let on = |realization| {
        let method = method(&registry, &system, realization, ("hamilton-jacobi", None));
        method.expect("a method")
    };
    let (there, here) = (on(there.expect("it fits")), on(Arc::new(RodriguesTwin)));
    assert_eq!([there.path(), here.path()], ["evaluators", "evaluators"]);
    let alone = orbit(&system, &here, 300);
    assert_eq!(orbit(&system, &there, 300), alone);
    let all = orbits(&system, &there, 17, 300);
    assert_eq!(all, orbits(&system, &here, 17, 300));
    assert_eq!(all[0], alone);
}

/// A part by formulas, written here and not read from a library.
fn declared(name: &str, kind: PartKind, formulas: &[(&str, &str)]) -> PartDeclaration {
    let strength = ParameterDescription {
        name: "strength".to_owned(),
        summary: "the pull at the lowest point".to_owned(),
        default: ParameterSetting::Real(1.5),
    };
    let (order, structure, most, flags) = match kind {
        PartKind::Dynamics => (2, LW_STRUCTURE_NONE, Some(2), LW_FLAG_SELF_ADJOINT),
        PartKind::Stepper => (1, LW_STRUCTURE_EXACT, None, LW_FLAG_NOT_SELF_ADJOINT),
        _ => (0, LW_STRUCTURE_NONE, None, 0),
    };
    PartDeclaration {
        description: PartDescription {
            name: name.to_owned(),
            kind,
            summary: String::new(),
            declares: String::new(),
            domain: String::new(),
            literature: String::new(),
            parameters: vec![strength],
        },
        order,
        structure,
        dimensions: Dimensions {
            least: most.unwrap_or(1),
            most,
        },
        flags: Flags::new(flags),
        formulas: formulas
            .iter()
            .map(|(key, text)| ((*key).to_owned(), (*text).to_owned()))
            .collect(),
        functions: None,
    }
}

/// The formulas of the C fixture `formulas`, once through its tables and once from this file.
#[test]
fn formulas_step_to_the_same_bits_loaded_or_compiled_in() {
    let workshop = Workshop::new();
    let mut loaded = built_in();
    load(&workshop.compile("formulas"), None, &mut loaded).expect("three parts");
    let mut here = built_in();
    let pendulum = [
        ("variables", "q, v"),
        ("bracket.q,v", "-1"),
        ("hamiltonian", "v^2/2 - strength*cos(q)"),
    ];
    let energy = [("S.1", "x2^2/2 - strength*cos(x1)")];
    let euler = [
        ("increment.1", "epsilon*h*(x2 - epsilon*h*strength*sin(x1))"),
        ("increment.2", "-epsilon*h*strength*sin(x1)"),
    ];
    for (name, kind, formulas) in [
        ("formulas/pendulum", PartKind::System, &pendulum[..]),
        ("formulas/energy", PartKind::Dynamics, &energy),
        ("formulas/euler", PartKind::Stepper, &euler),
    ] {
        let part = declared(name, kind, formulas).part();
        let origin = Origin::built_in("this test", "0");
        here.register(part.expect("its formulas"), origin)
            .expect("a new name");
    }
    for which in ["system", "dynamics", "step map"] {
        let orbit = pendulum_orbit(&loaded, which);
        assert_eq!(orbit, pendulum_orbit(&here, which), "{which}");
        assert_ne!(orbit[0], orbit[499], "{which}");
    }
}

/// Where the registry's pendulum goes: by built-in parts, by the registry's dynamics or by its step map.
fn pendulum_orbit(registry: &Registry, which: &str) -> Vec<[u64; 2]> {
    let strong = PartParameters::new().with("strength", 2.0);
    let part = registry.system("formulas/pendulum").expect("the pendulum");
    let system = part.build(&strong).expect("its formulas");
    let pair = |dynamics: &str, parameters: &PartParameters| -> Arc<dyn StepMap> {
        let defaults = PartParameters::new();
        let karasev = realization(registry, "karasev-truncated", &system, defaults);
        let dynamics = registry.dynamics(dynamics).expect("it is there");
        let dynamics = dynamics.build(parameters).expect("its parameters");
        let method = Method::compose(&system, karasev.expect("it fits"), dynamics);
        let method = method.expect("a method");
        assert_eq!(method.path(), "one kernel");
        Arc::new(method)
    };
    let map = match which {
        "system" => pair("hamilton-jacobi", &PartParameters::new().with("order", 4)),
        "dynamics" => pair("formulas/energy", &strong),
        _ => {
            let part = registry.stepper("formulas/euler").expect("the rule");
            part.build(&system, &strong).expect("dimension 2")
        }
    };
    let mut walk = Walk::new(map.as_ref(), &[2.0], 1.0, 0.05, &[0.4, 0.3]);
    (0..500)
        .map(|_| {
            walk.step().expect("a step");
            [0, 1].map(|i| walk.state()[i].to_bits())
        })
        .collect()
}
