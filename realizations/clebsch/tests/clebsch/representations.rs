//! Algebras by matrices that a user gives.

use leafwise_clebsch::{Clebsch, Matrices};
use leafwise_core::{BuildError, LiftedRealization, PoissonSystem, StepError};
use leafwise_tests::gauss::flow;
use leafwise_tests::library;
use leafwise_tests::methods::run;
use leafwise_tests::numbers::distance;
use leafwise_tests::structure::structure_error;
use leafwise_tests::systems::from_formulas;

use super::common::over;

fn represent(
    system: &PoissonSystem,
    representation: &str,
    symplectic_form: &str,
    copies: usize,
) -> Result<LiftedRealization, BuildError> {
    let given = Matrices {
        representation: representation.to_owned(),
        symplectic_form: symplectic_form.to_owned(),
        copies,
    };
    Clebsch::represent(system, &given)
}

/// sl(2)* as [h, e] = 2e, [h, f] = −2f, [e, f] = h.
fn sl2() -> PoissonSystem {
    from_formulas(
        &["h", "e", "f"],
        &[],
        &[("h,e", "2*e"), ("h,f", "-2*f"), ("e,f", "h")],
        "h^2/3 + e^2/2 + f^2 + e*h/5 + f/3",
        &[("killing", "h^2/4 + e*f")],
    )
}

const SL2: &str = "[[1, 0], [0, -1]]; [[0, 1], [0, 0]]; [[0, 0], [1, 0]]";

/// Turns of ℝ³, of the paper's {x1, x2} = −x3.
const TURNS: &str = "[[0, 0, 0], [0, 0, 1], [0, -1, 0]]; [[0, 0, -1], [0, 0, 0], [1, 0, 0]]; [[0, 1, 0], [-1, 0, 0], [0, 0, 0]]";

/// gl(2)* of the entries of a matrix, e_ij ↦ E_ij.
fn gl2() -> (PoissonSystem, String) {
    let mut bracket = Vec::new();
    let name = |i: usize, j: usize| format!("e{i}{j}");
    let all: Vec<(usize, usize)> = (0..2).flat_map(|i| (0..2).map(move |j| (i, j))).collect();
    for (at, &(i, j)) in all.iter().enumerate() {
        for &(k, l) in &all[at + 1..] {
            // [E_ij, E_kl] = δ_jk E_il − δ_li E_kj.
            let mut entry = String::from("0");
            if j == k {
                entry += &format!(" + {}", name(i, l));
            }
            if l == i {
                entry += &format!(" - {}", name(k, j));
            }
            if entry != "0" {
                bracket.push((format!("{},{}", name(i, j), name(k, l)), entry));
            }
        }
    }
    let bracket: Vec<(&str, &str)> = bracket
        .iter()
        .map(|(a, b)| (a.as_str(), b.as_str()))
        .collect();
    let system = from_formulas(
        &["e00", "e01", "e10", "e11"],
        &[],
        &bracket,
        "e00^2/2 + e01^2/3 + e10^2/4 + e11^2/5 + e01*e10/6 + e00*e11/7",
        &[
            ("trace", "e00 + e11"),
            ("square", "e00^2 + 2*e01*e10 + e11^2"),
        ],
    );
    let matrices = all.iter().map(|(i, j)| {
        let mut entries = [[0; 2]; 2];
        entries[*i][*j] = 1;
        format!("{entries:?}")
    });
    (system, matrices.collect::<Vec<_>>().join("; "))
}

#[test]
fn steps_in_a_representation_are_poisson_maps() {
    let (gl2, matrices) = gl2();
    let body = library("rigid-body").system;
    let sl2 = sl2();
    let form = "[[0, 1], [-1, 0]]";
    for (system, realization, x) in [
        (
            &gl2,
            represent(&gl2, &matrices, "", 0),
            vec![0.4, -0.3, 0.6, 0.2],
        ),
        (&sl2, represent(&sl2, SL2, form, 2), vec![0.4, -0.3, 0.6]),
        (&sl2, represent(&sl2, SL2, form, 0), vec![0.1, 0.7, -0.6]),
        (&sl2, represent(&sl2, SL2, form, 2), vec![0.1, -0.7, 0.6]),
        (&sl2, represent(&sl2, SL2, "", 1), vec![0.4, 0.3, 0.6]),
        (&body, represent(&body, TURNS, "", 1), vec![0.4, -0.3, 0.6]),
    ] {
        let realization = realization.expect("a representation");
        for stages in [1, 2, 4] {
            let method = over(system, realization.clone(), stages);
            let error = structure_error(system, &method, 0.3, &x).expect("a step");
            assert!(
                error.tensor <= 64.0 && error.casimirs <= 64.0,
                "{x:?}: {error:?}"
            );
        }
        let end = flow(system, &x, 1.0, 64);
        let found = run(system, &over(system, realization, 8), (1.0, 0.1), 10, &x).expect("steps");
        assert!(distance(&found, &end) <= 1e-12, "{found:?}, {end:?}");
    }
}

#[test]
fn matrices_that_are_none_are_refused() {
    let sl2 = sl2();
    let wrong = "[[1, 0], [0, -1]]; [[0, 1], [0, 0]]; [[0, 0], [1/2, 0]]";
    let refused = represent(&sl2, wrong, "", 2)
        .map(|_| ())
        .expect_err("not a representation");
    let BuildError::NoRepresentation {
        bracket,
        entry,
        values,
        ..
    } = &refused
    else {
        panic!("{refused:?}");
    };
    assert_eq!(bracket.as_ref(), &["e", "f"], "{refused}");
    assert_eq!(
        (*entry, values.as_ref()),
        ([0, 0], &["1/2".to_owned(), "1".to_owned()]),
        "{refused}"
    );
    for (text, form, copies) in [
        ("[[1, 0], [0, -1]]; [[0, 1], [0, 0]]", "", 1),
        ("[[1, 0], [0, -1]]; [[0, 1], [0, 0]]; [[0, 0], [1]]", "", 1),
        (SL2, "[[0, 1], [1, 0]]", 1),
        (SL2, "[[0, 0], [0, 0]]", 1),
    ] {
        let refused = represent(&sl2, text, form, copies).map(|_| ());
        assert!(
            matches!(refused, Err(BuildError::Parameter { .. })),
            "{refused:?}"
        );
    }
    // One copy reaches the cone alone.
    let refused = represent(&sl2, SL2, "[[0, 1], [-1, 0]]", 1).map(|_| ());
    assert!(
        matches!(refused, Err(BuildError::DoesNotFit { .. })),
        "{refused:?}"
    );
}

/// On cubic functions of two variables nothing commutes with sl(2) but multiples of the identity.
#[test]
fn representations_whose_fibres_are_no_orbits_are_refused() {
    let cubics = "[[3, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, -3]]; \
                  [[0, 3, 0, 0], [0, 0, 4, 0], [0, 0, 0, 3], [0, 0, 0, 0]]; \
                  [[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]";
    let refused = represent(&sl2(), cubics, "", 1)
        .map(|_| ())
        .expect_err("no orbits");
    let text = refused.to_string();
    assert!(
        text.contains("have 5 dimensions") && text.contains("in 1 of them"),
        "{text}"
    );
}

/// qpᵀ less its trace has real eigenvalues: a state with others is not reached.
#[test]
fn states_outside_the_image_are_refused() {
    let sl2 = sl2();
    let realization = represent(&sl2, SL2, "", 1).expect("a representation");
    let method = over(&sl2, realization, 4);
    let refused = run(&sl2, &method, (1.0, 0.1), 1, &[0.1, -0.7, 0.6]);
    assert!(
        matches!(refused, Err(StepError::OutsideImage { .. })),
        "{refused:?}"
    );
    let rests = run(&sl2, &method, (1.0, 0.1), 10, &[0.0; 3]).expect("steps");
    assert_eq!(rests, [0.0; 3]);
}
