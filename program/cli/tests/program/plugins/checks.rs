//! `plugin check`: the conformance suite on examples and on parts that break their word.

use std::path::Path;

use super::build::{Workshop, rust_example};
use super::leafwise;
use crate::support::Place;

/// What is wrong with a part's mathematics is reported, with the instrument that found it.
#[test]
fn a_check_finds_what_a_part_declares_and_is_not() {
    let (here, workshop) = (Place::new(), Workshop::new());
    for (name, quantity) in [
        ("still", "order"),
        ("not_poisson", "Jacobi's identity"),
        ("not_exact", "alpha is Poisson"),
        // Right at the first state, and wrong where an orbit leads.
        ("wrong_elsewhere", "Jacobi's identity"),
        ("sloped_elsewhere", "gradient of H by differences"),
    ] {
        let library = workshop.compile(name);
        let path = library.to_str().expect("UTF-8");
        let said = leafwise(&here, &["plugin", "check", path, "--json"]);
        assert_eq!(said.code, Some(5), "{}{}", said.out, said.err);
        let json = said.json();
        assert_eq!(json["outcome"], "not met");
        let findings = json["parts"][0]["findings"].as_array().expect("findings");
        let broken = findings.iter().find(|f| f["judgement"] == "not-met");
        assert_eq!(
            broken.expect("one is broken")["quantity"],
            quantity,
            "{json:#}"
        );
        let said = leafwise(&here, &["plugin", "check", path]);
        assert_eq!(said.code, Some(5));
        assert!(said.out.contains("FAILS  "), "{}", said.out);
    }
    let library = workshop.compile("wrong_maths");
    let path = library.to_str().expect("UTF-8");
    let said = leafwise(&here, &["plugin", "check", path, "--json"]);
    assert_eq!(said.code, Some(4), "{}", said.err);
    let said = leafwise(&here, &["plugin", "check", path, "--no-plugins"]);
    assert_eq!(said.code, Some(4), "{}", said.err);
}

#[test]
fn the_examples_pass_their_check() {
    let (here, workshop) = (Place::new(), Workshop::new());
    let c = workshop.compile("../../../examples/c/gyrostat");
    let rust = rust_example();
    let check = |library: &Path| {
        let path = library.to_str().expect("UTF-8");
        let said = leafwise(&here, &["plugin", "check", path]);
        assert_eq!(said.code, Some(0), "{}{}", said.out, said.err);
        said.out
    };
    let has = |text: &str, pieces: &[&str]| {
        for piece in pieces {
            assert!(text.contains(piece), "`{piece}` is missing from:\n{text}");
        }
    };
    let pieces = [
        "example-c 1.0.0",
        "Jacobi's identity",
        "Casimir spin",
        "Hessian of H",
    ];
    has(&check(&c), &pieces);
    let pieces = [
        "example/so3-rodrigues, a realization",
        "alpha is Poisson",
        "{alpha, beta} = 0",
        "rigid-body (numbers)",
        "rigid-body (expressions)",
        "the same bits on 16 lanes",
        "Casimir population",
    ];
    has(&check(&rust), &pieces);
}
