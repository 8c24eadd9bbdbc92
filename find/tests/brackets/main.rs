//! Brackets of classical equations, found and proved, and equations that have none. Times of searches are printed.

#![allow(clippy::print_stdout)]

mod changes;
mod refusals;
mod signs;
mod systems;

use std::time::Instant;

use leafwise_core::diagnostics::{Verdict, check_casimir, check_jacobi};
use leafwise_core::system::{Convention, Parameter};
use leafwise_core::{PoissonSystem, SystemFormulas};
use leafwise_expression::algebra::{Elimination, quotient};
use leafwise_expression::syntax::{Formula, Scope};
use leafwise_expression::{Arithmetic, Expression, Polynomial, Rational, Ring};
use leafwise_find::{Equations, FindError, FoundBracket, Kind, Options, Report, casimirs_of, find};
use systems::{
    B5, HEAVY_TOP, HENON_HEILES, KIRCHHOFF, LAGRANGES_TOP, LOTKA_VOLTERRA, MAXWELL_BLOCH,
    MAY_LEONARD, RESCALED, ROTOR, THREE_WAVE, TODA,
};

fn equations(rows: &[(&str, &str)], parameters: &[(&str, Rational)]) -> Equations {
    let names: Vec<&str> = rows.iter().map(|(name, _)| *name).collect();
    let of: Vec<&str> = parameters.iter().map(|(name, _)| *name).collect();
    let scope = Scope::new().with_variables(&names).with_parameters(&of);
    let formula = |text: &str| {
        let parsed = Formula::parse(text).expect(text);
        parsed.resolve(&scope, None).expect(text).expect(text)
    };
    let field = rows.iter().map(|(_, text)| formula(text)).collect();
    let names = names.iter().map(|&name| name.to_owned()).collect();
    let parameters = parameters
        .iter()
        .map(|(name, value)| ((*name).to_owned(), value.clone()));
    Equations::new(names, parameters.collect(), field).expect("a formula for each variable")
}

type Rows = &'static [(&'static str, &'static str)];

fn search(equations: &Equations) -> Report {
    find(equations, Options::default()).expect("formulas of the algebra")
}

/// The bracket of equations, with Jacobi's identity, the motion and the Casimirs looked at once more: identities in a ring of their
/// own, the motion also by differences of H.
fn bracket(name: &str, equations: &Equations) -> FoundBracket {
    let report = search(equations);
    let refused = report.refused;
    let bracket = report
        .bracket
        .unwrap_or_else(|| panic!("{name}: {refused:?}"));
    let system = &bracket.system;
    let near = system.near().to_vec();
    let values = system.parameter_values();
    let checked = PoissonSystem::from(system.clone());
    let check = check_jacobi(&checked, &values, &near).expect(name);
    assert_eq!(check.verdict, Verdict::Proved, "{name}");
    for casimir in 0..system.casimirs().len() {
        let check = check_casimir(&checked, casimir, &values, &near).expect(name);
        let holds = matches!(check.verdict, Verdict::Proved | Verdict::NumericallyZero);
        assert!(holds, "{name}: {check:?}");
    }
    assert_eq!(
        defects(system, equations.field()),
        Vec::<usize>::new(),
        "{name}"
    );
    moves(name, system, equations);
    bracket
}

/// The components in which −Π ∇H of the paper's convention is not f in normal form.
fn defects(system: &SystemFormulas, field: &[Expression]) -> Vec<usize> {
    let mut ring = Ring::new(field.len());
    let x: Vec<_> = (0..field.len()).map(|i| ring.variable(i)).collect();
    let variable = &mut |_: &mut Ring, at: usize| Ok(x[at].clone());
    let energy = system.hamiltonian().evaluate_in(&mut ring, variable);
    let gradient = ring.gradient(&energy.expect("a formula")).expect("smooth");
    let rows = system
        .apply_tensor(&mut ring, &x, &gradient)
        .expect("formulas");
    let mut wrong = Vec::new();
    for (at, (row, f)) in rows.iter().zip(field).enumerate() {
        let f = f
            .evaluate_in(&mut ring, &mut |_, at| Ok(x[at].clone()))
            .expect("a formula");
        if !ring.add(row, &f).is_zero() {
            wrong.push(at);
        }
    }
    wrong
}

/// {x, H} = f to the error of central differences of H at three states: 1e-4² of its third derivatives, and round-off over 1e-4.
fn moves(name: &str, system: &SystemFormulas, equations: &Equations) {
    let d = system.dimension();
    let values: Vec<f64> = equations
        .parameters()
        .iter()
        .map(|(_, v)| v.to_f64())
        .collect();
    let of_system = system.parameter_values();
    let step = 1e-4;
    for shift in [0.0, 0.13, 0.29] {
        let x: Vec<f64> = system.near().iter().map(|v| v + shift).collect();
        let energy = |at: usize, by: f64| {
            let mut x = x.clone();
            x[at] += by;
            system.hamiltonian().evaluate(&x, &of_system)
        };
        let slopes: Vec<f64> = (0..d)
            .map(|k| (energy(k, step) - energy(k, -step)) / (2.0 * step))
            .collect();
        let mut motion = vec![0.0; d];
        let mut size = 1.0;
        for (&(i, j), entry) in system.tensor() {
            let entry = entry.evaluate(&x, &of_system);
            motion[i] -= entry * slopes[j];
            motion[j] += entry * slopes[i];
            size += entry.abs();
        }
        size *= 1.0 + slopes.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
        for (f, motion) in equations.field().iter().zip(motion) {
            let f = f.evaluate(&x, &values);
            assert!((f - motion).abs() <= 1e-6 * size, "{name}: {f} {motion}");
        }
    }
}

fn entries(bracket: &FoundBracket) -> Vec<String> {
    let rows = bracket.rows().into_iter();
    rows.map(|([x, y], entry)| format!("{{{x}, {y}}} = {entry}"))
        .collect()
}

fn hamiltonian(bracket: &FoundBracket) -> String {
    bracket.written(&bracket.hamiltonian)
}

/// Each classical system has a bracket of the kind that the books give it.
#[test]
fn classical_systems_have_brackets() {
    let cases: &[(&str, Rows, Kind, usize)] = &[
        ("Henon and Heiles", HENON_HEILES, Kind::Constant, 0),
        ("Lotka and Volterra", LOTKA_VOLTERRA, Kind::LogCanonical, 0),
        ("columns rescaled", RESCALED, Kind::LogCanonical, 0),
        ("DETEST B5", B5, Kind::Affine, 1),
        ("heavy top", HEAVY_TOP, Kind::Affine, 2),
        ("Lagrange's top", LAGRANGES_TOP, Kind::Affine, 2),
        ("Kirchhoff", KIRCHHOFF, Kind::Affine, 2),
        ("three waves", THREE_WAVE, Kind::Constant, 0),
        ("Toda", TODA, Kind::Affine, 1),
        ("May and Leonard", MAY_LEONARD, Kind::FirstIntegrals, 1),
        ("Maxwell and Bloch", MAXWELL_BLOCH, Kind::Affine, 1),
        ("rotor", ROTOR, Kind::Affine, 1),
        (
            "pendulum",
            &[("q", "p"), ("p", "-sin(q)")],
            Kind::Constant,
            0,
        ),
        (
            "Kepler",
            &[
                ("x", "u"),
                ("y", "v"),
                ("u", "-x/(x^2 + y^2)^(3/2)"),
                ("v", "-y/(x^2 + y^2)^(3/2)"),
            ],
            Kind::Constant,
            0,
        ),
        (
            "exponentials",
            &[("q", "p"), ("p", "exp(-q) - q*exp(q^2)")],
            Kind::Constant,
            0,
        ),
        (
            "tangents",
            &[("q", "tanh(p/2)"), ("p", "-tan(3*q) - 2*sin(q)/cos(q)")],
            Kind::Constant,
            0,
        ),
        (
            "two oscillators",
            &[("x", "u"), ("y", "v"), ("u", "-x"), ("v", "-y")],
            Kind::Constant,
            0,
        ),
        (
            "three species",
            &[("a", "a*(b - c)"), ("b", "b*(c - a)"), ("c", "c*(a - b)")],
            Kind::Constant,
            1,
        ),
        (
            "three species that grow",
            &[
                ("a", "a*(1 + b - 2*c)"),
                ("b", "b*(1 + 2*c - a)"),
                ("c", "c*(-4 + 2*a - 2*b)"),
            ],
            Kind::LogCanonical,
            1,
        ),
        (
            "epidemic",
            &[("s", "-s*i"), ("i", "s*i - i/2"), ("r", "i/2")],
            Kind::FirstIntegrals,
            1,
        ),
        (
            "a factor in the plane",
            &[("x", "y*(1 + x^2)"), ("y", "-x*(1 + x^2)")],
            Kind::FirstIntegrals,
            0,
        ),
    ];
    let mut count = 0;
    for (name, rows, kind, casimirs) in cases {
        let begin = Instant::now();
        let bracket = bracket(name, &equations(rows, &[]));
        println!("{name}: {:?}", begin.elapsed());
        assert_eq!(bracket.kind, *kind, "{name}: {:?}", entries(&bracket));
        assert_eq!(bracket.casimirs.len(), *casimirs, "{name}");
        count += 1;
    }
    assert_eq!(count, 21);
}

/// Entries and Hamiltonians as they are printed, of systems whose bracket of a kind is unique.
#[test]
fn brackets_that_are_unique_are_those_of_the_books() {
    let found = bracket("Henon and Heiles", &equations(HENON_HEILES, &[]));
    assert_eq!(entries(&found), ["{q1, p1} = 1", "{q2, p2} = 1"]);
    assert_eq!(
        hamiltonian(&found),
        "q1^2/2 + q1^2*q2 + q2^2/2 - q2^3/3 + p1^2/2 + p2^2/2"
    );
    assert_eq!(found.family, 1);
    let found = bracket("columns rescaled", &equations(RESCALED, &[]));
    let expected = [
        "{a, b} = a*b",
        "{a, c} = a*c",
        "{a, d} = a*d",
        "{b, c} = b*c",
        "{b, d} = b*d",
        "{c, d} = c*d",
    ];
    assert_eq!(entries(&found), expected);
    assert_eq!(
        hamiltonian(&found),
        "a + 2*b + c/2 + 3*d - ln(a) - 2*ln(b) - ln(c) - ln(d)"
    );
    // Squares alone, by a square of the Casimir.
    let found = bracket("Toda", &equations(TODA, &[]));
    assert_eq!(found.family, 1);
    assert_eq!(
        hamiltonian(&found),
        "a1^2 + a2^2 + b1^2/2 + b2^2/2 + b3^2/2"
    );
    // e(3)*, by its nine entries, and its Casimirs.
    for (rows, vector) in [(HEAVY_TOP, "g"), (KIRCHHOFF, "p")] {
        let found = bracket("e(3)", &equations(rows, &[]));
        let text =
            |names: [String; 2], entry: String| format!("{{{}, {}}} = {entry}", names[0], names[1]);
        let m = |i: usize| format!("m{i}");
        let v = |i: usize| format!("{vector}{i}");
        let mut expected = Vec::new();
        for (i, j, k, sign) in [(1, 2, 3, "-"), (1, 3, 2, ""), (2, 3, 1, "-")] {
            expected.push(text([m(i), m(j)], format!("{sign}{}", m(k))));
            let other = if sign.is_empty() { "-" } else { "" };
            expected.push(text([m(i), v(j)], format!("{sign}{}", v(k))));
            expected.push(text([m(j), v(i)], format!("{other}{}", v(k))));
        }
        let mut found = entries(&found);
        found.sort();
        expected.sort();
        assert_eq!(found, expected);
    }
}

/// Constant tensors hold the parameters as names, others their numbers.
#[test]
fn parameters_stay_where_the_tensor_does_not_need_them() {
    let number = |text: &str| Rational::parse_decimal(text).expect(text);
    let rows = [("q", "p/m"), ("p", "-k*sin(q)")];
    let parameters = [("m", number("1.5")), ("k", number("0.3"))];
    let equations_of = equations(&rows, &parameters);
    let found = search(&equations_of).bracket.expect("a pendulum");
    assert!(found.has_parameters);
    assert_eq!(hamiltonian(&found), "p^2/(2*m) - k*cos(q)");
    assert_eq!(
        defects(&found.system, equations_of.field()),
        Vec::<usize>::new()
    );
    let rows = [("x", "y*z"), ("y", "-x*z"), ("z", "-k*x*y")];
    let equations_of = equations(&rows, &[("k", number("0.51"))]);
    let found = search(&equations_of).bracket.expect("a rigid body");
    assert!(!found.has_parameters);
    assert_eq!(
        defects(&found.system, equations_of.with_numbers().field()),
        Vec::<usize>::new()
    );
}

/// Casimirs of written tensors, with parameters and logarithms.
#[test]
fn casimirs_of_any_tensor_are_found() {
    type Case = (
        &'static [&'static str],
        &'static [((usize, usize), &'static str)],
        &'static [&'static str],
    );
    let cases: &[Case] = &[
        (
            &["x", "y", "z"],
            &[((0, 1), "z"), ((1, 2), "x"), ((0, 2), "-y")],
            &["x^2 + y^2 + z^2"],
        ),
        (
            &["x", "y", "z"],
            &[((0, 1), "a*z"), ((1, 2), "b*x"), ((0, 2), "-b*y")],
            &["b*x^2 + b*y^2 + a*z^2"],
        ),
        (&["q", "p", "c"], &[((0, 1), "1")], &["c"]),
        (&["q", "p"], &[((0, 1), "1 + q^2")], &[]),
        (
            &["x", "y", "z"],
            &[((0, 1), "x*y"), ((1, 2), "2*y*z"), ((0, 2), "-x*z")],
            &["2*ln(x) + ln(y) + ln(z)"],
        ),
        (
            &["h", "e", "f"],
            &[((0, 1), "2*e"), ((0, 2), "-2*f"), ((1, 2), "h")],
            &["h^2 + 4*e*f"],
        ),
    ];
    for (names, tensor, expected) in cases {
        let scope = Scope::new()
            .with_variables(names)
            .with_parameters(&["a", "b"]);
        let formula = |text: &str| {
            let parsed = Formula::parse(text).expect(text);
            parsed.resolve(&scope, None).expect(text).expect(text)
        };
        let parameters = [("a", 2.0), ("b", 3.0)].map(|(name, value)| Parameter {
            name: name.to_owned(),
            value,
        });
        let system = SystemFormulas::new(
            names.iter().map(|&name| name.to_owned()).collect(),
            parameters.to_vec(),
            tensor.iter().map(|(pair, text)| (*pair, formula(text))),
            0.into(),
            Vec::new(),
            Convention::HamiltonianFirst,
        );
        let system = system.expect("entries above the diagonal");
        let found = casimirs_of(&system, 2).expect("formulas");
        let mut ring = Ring::new(names.len());
        let mut element = |formula: &Expression| {
            let value = formula.evaluate_in(&mut ring, &mut |ring, at| Ok(ring.variable(at)));
            value.expect("a formula")
        };
        assert_eq!(found.len(), expected.len(), "{names:?} {tensor:?}");
        for (found, expected) in found.iter().zip(*expected) {
            let (found, expected) = (element(found), element(&formula(expected)));
            // Up to a factor.
            let ratio = quotient(&found, &expected).and_then(|ratio| ratio.as_constant());
            assert!(ratio.is_some(), "{tensor:?}: {found:?}");
        }
    }
}

/// Forty species, whose monomials of degree 2 in x and ln x are too many: the bracket is found all the same.
#[test]
fn a_food_web_of_forty_species_has_its_bracket() {
    let names: Vec<String> = (0..40).map(|i| format!("x{i}")).collect();
    let rows: Vec<(String, String)> = (0..40)
        .map(|i| {
            let others = (0..40).filter(|j| *j != i);
            let sign = |j: usize| if j > i { '+' } else { '-' };
            let sum = others.map(|j| format!("{}(x{j} - 1)*{}", sign(j), 1 + (i * j) % 3));
            (
                format!("x{i}"),
                format!("x{i}*(0 {})", sum.collect::<String>()),
            )
        })
        .collect();
    let rows: Vec<(&str, &str)> = rows.iter().map(|(x, f)| (x.as_str(), f.as_str())).collect();
    let equations = equations(&rows, &[]);
    let found = search(&equations).bracket.expect("a bracket");
    assert_eq!(found.kind, Kind::LogCanonical);
    assert_eq!(found.entries.len(), 40 * 39 / 2);
    assert_eq!(
        defects(&found.system, equations.field()),
        Vec::<usize>::new()
    );
    assert_eq!(names.len(), found.system.dimension());
}

/// Equations that a bracket fits, whose Hamiltonian has no formula here, are told from those that none fits.
#[test]
fn a_hamiltonian_that_is_missing_is_said() {
    for (force, lacks_hamiltonian) in [("-exp(-q^2)", true), ("-q - p", false)] {
        let report = search(&equations(&[("q", "p"), ("p", force)], &[]));
        assert!(report.bracket.is_none(), "{force}");
        let mut refused = report.refused.iter();
        let lacks = refused.any(|kind| kind.lacks_hamiltonian && !kind.is_proved);
        assert_eq!(lacks, lacks_hamiltonian, "{force}");
    }
}
