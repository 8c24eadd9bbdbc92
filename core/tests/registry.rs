//! The registry holds built-in and loaded parts alike, one a name.

use std::path::PathBuf;

use leafwise_core::part::{Compared, Family, ParameterSetting, PartInfo, PartKind, ServesNumbers};
use leafwise_core::part_description::{ParameterDescription, PartDescription};
use leafwise_core::registry::{CompositionPart, DynamicsPart, StepperPart, SystemPart};
use leafwise_core::{
    BuildError, Convention, MotionClass, Origin, Part, PartParameters, Pieces, PoissonSystem,
    Registry, RegistryError,
};
use leafwise_expression::{Expression, Rational};

/// A canonical pair with H = k q²/2, k a parameter of the part.
fn spring(info: &'static PartInfo) -> Part {
    let make = move |parameters: &PartParameters| {
        let k = parameters.get(info, "stiffness")?;
        let square = Expression::Product(vec![
            Expression::Constant(Rational::new(k, 2)),
            Expression::Variable(0),
            Expression::Variable(0),
        ]);
        PoissonSystem::new(
            vec!["q".to_owned(), "p".to_owned()],
            Vec::new(),
            [((0, 1), Expression::Constant(Rational::one()))],
            square,
            Vec::new(),
            Convention::HamiltonianFirst,
        )
    };
    SystemPart::new(info, make).into()
}

fn description(name: &str, kind: PartKind) -> &'static PartInfo {
    PartDescription {
        name: name.to_owned(),
        kind,
        summary: "a spring".to_owned(),
        declares: "canonical".to_owned(),
        domain: "all states".to_owned(),
        literature: "Hooke (1678)".to_owned(),
        parameters: vec![ParameterDescription {
            name: "stiffness".to_owned(),
            summary: "k".to_owned(),
            default: ParameterSetting::Integer(3),
        }],
    }
    .leak(&[])
}

fn library() -> Origin {
    Origin::Library {
        path: PathBuf::from("/opt/acme/libspring.so"),
        sha256: "0123456789abcdef".repeat(4),
        version: "1.2.0".to_owned(),
        abi: "1.0".to_owned(),
    }
}

#[test]
fn a_loaded_part_is_found_and_built_as_any_other() {
    let mut registry = Registry::empty();
    let part = spring(description("acme/spring", PartKind::System));
    registry.register(part, library()).expect("a fresh name");
    let system = registry
        .system("acme/spring")
        .and_then(|part| part.build(&PartParameters::new().with("stiffness", 5)))
        .expect("a system");
    assert_eq!(system.dimension(), 2);
    assert_eq!(registry.origin("acme/spring"), Some(&library()));
    let (info, origin) = registry.listing()[0];
    assert_eq!(
        (info.name, info.summary, info.parameters.len()),
        ("acme/spring", "a spring", 1)
    );
    assert_eq!(
        origin.to_string(),
        "/opt/acme/libspring.so 1.2.0 (abi 1.0, sha256 0123456789ab)"
    );
}

#[test]
fn a_name_is_taken_once_whatever_its_kind() {
    let mut registry = Registry::empty();
    let origin = Origin::built_in("acme", "0.1.0");
    registry
        .register(
            spring(description("acme/spring", PartKind::System)),
            origin.clone(),
        )
        .expect("a fresh name");
    let refused = registry
        .register(
            spring(description("acme/spring", PartKind::System)),
            library(),
        )
        .expect_err("a name that is taken");
    assert_eq!(
        refused,
        RegistryError::Duplicate {
            name: "acme/spring",
            kind: "system",
            offered: Box::new(library()),
            taken: "system",
            origin: Box::new(origin.clone()),
        }
    );
    assert_eq!(
        refused.to_string(),
        "the system `acme/spring` from /opt/acme/libspring.so 1.2.0 (abi 1.0, sha256 0123456789ab) \
         cannot be registered: a system of this name is already registered, from acme 0.1.0 (built in); \
         load only one of them, or rename one"
    );
    assert_eq!(registry.parts().len(), 1);
    assert_eq!(registry.origin("acme/spring"), Some(&origin));
}

#[test]
fn a_part_is_registered_as_what_it_declares() {
    let mut registry = Registry::empty();
    let info = description("acme/spring", PartKind::Stepper);
    let refused = registry
        .register(spring(info), library())
        .expect_err("another kind");
    assert_eq!(
        refused.to_string(),
        "`acme/spring` from /opt/acme/libspring.so 1.2.0 (abi 1.0, sha256 0123456789ab) declares \
         itself a stepper and is offered as a system"
    );
    assert!(registry.parts().is_empty());
}

#[test]
fn an_unknown_name_suggests_one_of_its_kind() {
    let mut registry = Registry::empty();
    let part = spring(description("acme/spring", PartKind::System));
    registry.register(part, library()).expect("a fresh name");
    let Err(error) = registry.system("acme/sprig") else {
        panic!("no such part");
    };
    assert_eq!(
        error.to_string(),
        "no system is called `acme/sprig`; did you mean `acme/spring`?"
    );
    let Err(error) = registry.stepper("acme/spring") else {
        panic!("a system is no stepper");
    };
    assert_eq!(error.to_string(), "no stepper is called `acme/spring`");
}

/// One refusal of each kind that parts of a registry may cure.
fn refusals() -> [BuildError; 6] {
    let (dynamics, realization) = ("m = 2".to_owned(), "a lift".to_owned());
    [
        BuildError::NotOffered {
            part: "acme/part",
            system: "acme/spring".to_owned(),
            missing: "formulas of the system",
        },
        BuildError::Forces {
            part: "acme/part".to_owned(),
        },
        BuildError::TooManyVariables {
            variables: 9,
            most: 8,
        },
        BuildError::TooManyEquations {
            equations: 9,
            most: 8,
        },
        BuildError::NoFactors {
            composition: "acme/fine",
            map: "a map".to_owned(),
            is_self_adjoint: true,
        },
        BuildError::LiftAlone {
            dynamics,
            realization,
        },
    ]
}

fn stepper(name: &'static str, family: Family) -> Part {
    let info = Box::leak(Box::new(PartInfo {
        name,
        family: Some(family),
        compared: Some(Compared::at(1)),
        takes: match family {
            Family::Explicit => MotionClass::OffLeaves,
            _ => MotionClass::Hamiltonian,
        },
        serves_numbers: (family == Family::Explicit)
            .then_some(ServesNumbers { rank: 1, limit: "" }),
        ..PartInfo::of(PartKind::Stepper)
    }));
    StepperPart::new(info, |_, _| unreachable!("it is named alone")).into()
}

fn composition(name: &'static str, factors: Option<Pieces>) -> Part {
    let info = Box::leak(Box::new(PartInfo {
        name,
        compared: Some(Compared::at(1)),
        ..PartInfo::of(PartKind::Composition)
    }));
    CompositionPart::new(info, 4, factors, |_, _| unreachable!("it is named alone")).into()
}

fn dynamics(name: &'static str) -> Part {
    let info = Box::leak(Box::new(PartInfo {
        name,
        compared: Some(Compared {
            over_lifts: &[&[]],
            ..Compared::at(1)
        }),
        ..PartInfo::of(PartKind::Dynamics)
    }));
    DynamicsPart::new(info, |_| unreachable!("it is named alone")).into()
}

/// The same crates are linked whatever a registry holds.
#[test]
fn refusals_name_parts_of_the_registry_alone() {
    let empty = Registry::empty();
    let mut registry = Registry::empty();
    for part in [
        stepper("acme/classical", Family::Explicit),
        stepper("acme/implicit", Family::Implicit),
        stepper("acme/flows", Family::Splitting),
        composition("acme/stages", None),
        composition("acme/fine", Some(Pieces::Any)),
        dynamics("acme/gentle"),
    ] {
        registry.register(part, library()).expect("a fresh name");
    }
    let nothing = "what serves it: no part of this program";
    let serving = "what serves it: the steppers acme/classical";
    let solving = "steppers that solve nothing: acme/flows, acme/classical";
    let composing = "compose acme/flows with it, or take a composition of self-adjoint maps, such as acme/stages";
    let expected = [
        (Some(nothing), Some(serving)),
        (Some(nothing), Some(serving)),
        (None, Some(solving)),
        (None, Some(solving)),
        (None, Some(composing)),
        (None, Some("dynamics that step there: acme/gentle")),
    ];
    for (error, (without, with)) in refusals().iter().zip(expected) {
        for (registry, instead) in [(&empty, without), (&registry, with)] {
            assert_eq!(registry.instead(error).as_deref(), instead, "{error}");
            let told = registry.explain(error);
            let added = instead.map_or(String::new(), |instead| format!("; {instead}"));
            assert_eq!(told, format!("{error}{added}"));
        }
        assert!(!error.to_string().contains("acme/flows"), "{error}");
    }
}

/// Other compositions ask for a self-adjoint map too: they are named where it is one.
#[test]
fn compositions_are_named_to_a_map_that_they_take() {
    let mut registry = Registry::empty();
    let part = composition("acme/stages", None);
    registry.register(part, library()).expect("a fresh name");
    let refused = |is_self_adjoint: bool| BuildError::NoFactors {
        composition: "acme/fine",
        map: "a map".to_owned(),
        is_self_adjoint,
    };
    assert!(registry.explain(&refused(true)).contains("acme/stages"));
    assert_eq!(registry.instead(&refused(false)), None);
}
