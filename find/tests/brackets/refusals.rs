//! Equations without a bracket, and those that are not searched.

use super::systems::HEAVY_TOP;
use super::*;

/// Damping, self-limitation and friction leave no bracket: constant ones are excluded by rank, affine ones since the motion preserves none, all of them where an
/// equilibrium is stable.
#[test]
fn dissipation_is_refused_with_a_certificate() {
    let cases: &[(&str, Rows, &[Kind], bool)] = &[
        (
            "Henon and Heiles, damped",
            &[
                ("q1", "p1"),
                ("q2", "p2"),
                ("p1", "-q1 - 2*q1*q2 - 0.1*p1"),
                ("p2", "-q2 - q1^2 + q2^2 - 0.1*p2"),
            ],
            &[Kind::Constant, Kind::Affine],
            true,
        ),
        (
            "pendulum, damped",
            &[("q", "p"), ("p", "-sin(q) - 0.1*p")],
            &[Kind::Constant, Kind::Affine],
            true,
        ),
        (
            "species that limit themselves",
            &[
                ("a", "a*(b + c + d - 4 - 0.1*a)"),
                ("b", "b*(-a + c + d - 1 - 0.1*b)"),
                ("c", "c*(-a - b + d + 2 - 0.1*c)"),
                ("d", "d*(-a - b - c + 4 - 0.1*d)"),
            ],
            &[Kind::Constant, Kind::LogCanonical, Kind::Affine],
            true,
        ),
        (
            "van der Pol",
            &[("x", "y"), ("y", "(1 - x^2)*y - x")],
            &[Kind::Constant, Kind::Affine],
            true,
        ),
        (
            "heavy top with friction",
            &[
                ("m1", "m2*m3/2 - m3*m2/1.5 + 0.9*g2 - 0.2*g3 - 0.1*m1"),
                ("m2", "m3*m1 - m1*m3/2 + 0.3*g3 - 0.9*g1 - 0.1*m2"),
                ("m3", "m1*m2/1.5 - m2*m1 + 0.2*g1 - 0.3*g2 - 0.1*m3"),
                ("g1", "g2*m3/2 - g3*m2/1.5"),
                ("g2", "g3*m1 - g1*m3/2"),
                ("g3", "g1*m2/1.5 - g2*m1"),
            ],
            &[Kind::Constant, Kind::Affine],
            false,
        ),
        (
            "Lorenz",
            &[
                ("x", "10*(y - x)"),
                ("y", "x*(28 - z) - y"),
                ("z", "x*y - 8*z/3"),
            ],
            &[Kind::Constant, Kind::Affine],
            false,
        ),
    ];
    for (name, rows, excluded, is_excluded_at_all) in cases {
        let report = search(&equations(rows, &[]));
        assert!(report.bracket.is_none(), "{name}");
        assert_eq!(
            report.never.is_some(),
            *is_excluded_at_all,
            "{name}: {:?}",
            report.never
        );
        assert_eq!(report.refused.len(), Kind::ALL.len(), "{name}");
        for refused in &report.refused {
            assert_eq!(
                refused.is_proved,
                excluded.contains(&refused.kind),
                "{name}: {refused:?}"
            );
        }
    }
}

/// A conservative saddle and a centre are no reason against a bracket; a damped oscillator is.
#[test]
fn an_equilibrium_excludes_brackets_only_where_it_attracts_or_repels() {
    for (damping, is_excluded) in [("", false), ("-0.1*p", true), ("+0.1*p", true)] {
        let text = format!("-q + q^3 {damping}");
        let rows = [("q", "p"), ("p", text.as_str())];
        let report = search(&equations(&rows, &[]));
        assert_eq!(report.never.is_some(), is_excluded, "{damping}");
        assert_eq!(report.bracket.is_none(), is_excluded, "{damping}");
    }
}

#[test]
fn equations_that_cannot_be_searched_are_refused_with_the_reason() {
    let one = equations(&[("x", "y"), ("y", "1/(x - x)")], &[]);
    let error = find(&one, Options::default()).expect_err("1/0");
    assert!(
        matches!(&error, FindError::Equation { variable, .. } if variable == "y"),
        "{error}"
    );
    let count = Equations::new(vec!["x".to_owned()], Vec::new(), Vec::new());
    assert!(matches!(
        count,
        Err(FindError::Count {
            equations: 0,
            variables: 1
        })
    ));
    let many = equations(HEAVY_TOP, &[]);
    let error = find(&many, Options { degree: Some(12) }).expect_err("18 563 monomials");
    assert!(
        matches!(error, FindError::TooMany { degree: 12, .. }),
        "{error}"
    );
}

/// Pieces are integrated each for itself, and H would jump between them.
#[test]
fn equations_in_pieces_are_not_searched() {
    for force in [
        "-if(q < 1, q, 1)",
        "-abs(q)",
        "-min(q, 1)",
        "-floor(q)",
        "-q + mod(q, 1)",
    ] {
        let found = find(
            &equations(&[("q", "p"), ("p", force)], &[]),
            Options::default(),
        );
        let error = found.expect_err(force);
        assert!(
            matches!(&error, FindError::Pieces { variable } if variable == "p"),
            "{error}"
        );
    }
}
