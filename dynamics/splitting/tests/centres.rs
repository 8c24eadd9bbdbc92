//! Which Hamiltonians have bodies about centres.

use crate::common::{canonical, distance, gauss, largest, library, run, whole};
use leafwise_composition::{Composed, Scheme};
use leafwise_core::BuildError;
use leafwise_core::solver::Structure;

/// Kepler's problem of the library, about a centre elsewhere, with a charge that another centre attracts, and beside a body that is free.
#[test]
fn bodies_about_centres_are_found() {
    let kepler = library("kepler");
    assert_eq!(whole(&kepler.system()).expect("a body").pieces(), 1);
    let pairs = [["x", "u"], ["y", "v"]].map(|pair| pair.map(str::to_owned));
    for (hamiltonian, pieces) in [
        ("(u^2 + v^2)/2 - 1/sqrt((x - c)^2 + (y + 0.3)^2)", 1),
        ("0.5*(u^2 + v^2) - (x^2 + 2*c*x + y^2 + c^2)^(-1/2)", 1),
        (
            "u^2 + v^2 - 1/sqrt(x^2 + y^2) - 0.2/sqrt((x - c)^2 + y^2)",
            2,
        ),
        ("(u^2 + v^2)/2 - 1/sqrt(x^2 + y^2) + c*(x*v - y*u)", 2),
        ("(u^2 + v^2)/2 - 1/sqrt(x^2 + y^2) + (u + c)^2/8", 2),
    ] {
        let initial = vec![0.8, 0.1, 0.2, 1.1];
        let problem = canonical(&pairs, &[("c", 0.25)], hamiltonian.to_owned(), initial);
        let system = problem.system();
        let map = whole(&system).unwrap_or_else(|error| panic!("{hamiltonian}: {error}"));
        assert_eq!(
            (map.pieces(), map.properties().structure),
            (pieces, Structure::Exact),
            "{hamiltonian}"
        );
        let exact = gauss(&system, &problem.initial, 0.5, 200);
        let composed = Composed::new(map, Scheme::find("suzuki-umeno-8").expect("a scheme"));
        let end = run(
            &system,
            &composed.expect("self-adjoint"),
            &problem.initial,
            0.5,
            40,
        );
        let error = distance(&end.expect("finite"), &exact) / largest(&exact);
        assert!(error <= 1e-13, "{hamiltonian}: {error:e}");
    }
}

#[test]
fn what_is_about_no_centre_is_refused() {
    let pairs = [["x", "u"], ["y", "v"]].map(|pair| pair.map(str::to_owned));
    for hamiltonian in [
        "(u^2 + 2*v^2)/2 - 1/sqrt(x^2 + y^2)",
        "(u^2 + v^2)/2 - 1/sqrt(x^2 + 2*y^2)",
        "(u^2 + v^2)/2 - 1/(x^2 + y^2)",
        "((u + v)^2 + u^2)/2 - 1/sqrt(x^2 + y^2)",
    ] {
        let problem = canonical(
            &pairs,
            &[],
            hamiltonian.to_owned(),
            vec![0.8, 0.1, 0.2, 1.1],
        );
        let refusal = whole(&problem.system()).err();
        assert!(
            matches!(&refusal, Some(BuildError::DoesNotFit { part: "splitting", reason }) if reason.contains("centre")),
            "{hamiltonian}: {refusal:?}"
        );
    }
}
