//! The registry holds built-in and loaded parts alike, one a name.

use std::path::PathBuf;

use leafwise_core::part::{ParameterSetting, PartInfo, PartKind};
use leafwise_core::part_description::{ParameterDescription, PartDescription};
use leafwise_core::registry::SystemPart;
use leafwise_core::{
    Convention, Origin, Part, PartParameters, PoissonSystem, Registry, RegistryError,
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
         cannot be registered: a system of this name is there already, from acme 0.1.0 (built in); \
         load one of them only, or rename one"
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
