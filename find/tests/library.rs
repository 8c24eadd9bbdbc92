//! The library's systems, found from their motion, and what is written of them read back.

use leafwise_core::SystemFormulas;
use leafwise_expression::{Arithmetic, Expression, Polynomial, Rational, Ring};
use leafwise_find::{Equations, Kind, Options, find};
use leafwise_scene::compose::system_of_fragment;
use leafwise_tests::library;

/// ẋ in the ring, in the paper's convention.
fn field(ring: &mut Ring, system: &SystemFormulas) -> Vec<Polynomial> {
    let x: Vec<Polynomial> = (0..system.dimension()).map(|i| ring.variable(i)).collect();
    let energy = system
        .hamiltonian()
        .evaluate_in(ring, &mut |_, at| Ok(x[at].clone()));
    let gradient = ring.gradient(&energy.expect("a formula")).expect("smooth");
    let rows = system.apply_tensor(ring, &x, &gradient).expect("formulas");
    rows.iter().map(|row| ring.negate(row)).collect()
}

/// The equations of a system with exact decimals for its parameters.
fn motion(system: &SystemFormulas) -> Equations {
    let mut ring = Ring::new(system.dimension());
    let field = field(&mut ring, system);
    let field: Vec<Expression> = field.iter().map(|f| ring.formula(f)).collect();
    let exact = |value: f64| Rational::parse_decimal(&format!("{value:?}")).expect("a double");
    let parameters = system.parameters().iter();
    let parameters = parameters.map(|p| (p.name.clone(), exact(p.value)));
    // Sites of families are names of their own.
    let names = system.variables().iter();
    let names: Vec<String> = names.map(|name| name.replace(['[', ']'], "")).collect();
    Equations::new(names, parameters.collect(), field).expect("a formula for each")
}

/// x after 200 steps of Runge and Kutta's method of order 4 over the time 2.
fn orbit(field: &[Expression], parameters: &[f64], initial: &[f64]) -> Vec<f64> {
    let step = 0.01;
    let values =
        |x: &[f64]| -> Vec<f64> { field.iter().map(|f| f.evaluate(x, parameters)).collect() };
    let moved = |x: &[f64], k: &[f64], by: f64| -> Vec<f64> {
        x.iter().zip(k).map(|(x, k)| x + by * k).collect()
    };
    let mut x = initial.to_vec();
    for _ in 0..200 {
        let k1 = values(&x);
        let k2 = values(&moved(&x, &k1, step / 2.0));
        let k3 = values(&moved(&x, &k2, step / 2.0));
        let k4 = values(&moved(&x, &k3, step));
        for (at, x) in x.iter_mut().enumerate() {
            *x += step / 6.0 * (k1[at] + 2.0 * k2[at] + 2.0 * k3[at] + k4[at]);
        }
    }
    x
}

/// Each system's bracket is found from its motion alone, with all Casimirs that the library knows. The text of a scene that is written of it
/// reads back to the same motion: exactly in the ring, and along an orbit to the roundings of 200 steps.
#[test]
fn systems_of_the_library_are_found_from_their_equations() {
    let cases = [
        ("gradient", Kind::Affine),
        ("heavy-top", Kind::Affine),
        ("kepler", Kind::Constant),
        ("lotka-volterra", Kind::LogCanonical),
        ("maxwell-bloch", Kind::Affine),
        ("may-leonard", Kind::Constant),
        ("nambu", Kind::Affine),
        ("point-vortices", Kind::Constant),
        ("rigid-body", Kind::Affine),
        ("se3", Kind::Affine),
        ("so4", Kind::Affine),
        ("three-wave", Kind::Constant),
        ("toda", Kind::Affine),
        ("volterra-lattice", Kind::LogCanonical),
        ("restricted-three-body", Kind::Constant),
    ];
    let mut count = 0;
    for (id, kind) in cases {
        let problem = library(id);
        let system = problem.system.expressions().expect("formulas");
        let equations = motion(system);
        let report = find(&equations, Options::default()).expect(id);
        let bracket = report
            .bracket
            .unwrap_or_else(|| panic!("{id}: {:?}", report.refused));
        assert_eq!(bracket.kind, kind, "{id}: {}", bracket.fragment());
        // A ring of four Volterra sites has one more than the library names.
        let known = system.casimirs().len();
        assert!(
            bracket.casimirs.len() >= known,
            "{id}: {}",
            bracket.fragment()
        );
        let read = system_of_fragment("found", &bracket.fragment()).expect(id);
        let read = read.expressions().expect("formulas");
        let target = match bracket.has_parameters {
            true => equations.clone(),
            false => equations.with_numbers(),
        };
        let mut ring = Ring::new(system.dimension());
        let found = field(&mut ring, read);
        let of = |ring: &mut Ring, f: &Expression| {
            f.evaluate_in(ring, &mut |ring, at| Ok(ring.variable(at)))
                .expect("a formula")
        };
        for (found, f) in found.iter().zip(target.field()) {
            let f = of(&mut ring, f);
            assert_eq!(*found, f, "{id}");
        }
        let formulas: Vec<Expression> = found.iter().map(|f| ring.formula(f)).collect();
        let values = system.parameter_values();
        let ends = [
            orbit(&formulas, &read.parameter_values(), &problem.initial),
            orbit(equations.field(), &values, &problem.initial),
        ];
        let size = ends[1].iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (one, other) in ends[0].iter().zip(&ends[1]) {
            // 200 steps of some dozen roundings, which an orbit over the time 2 stretches by less than 100.
            assert!(
                (one - other).abs() <= 2e5 * f64::EPSILON * size,
                "{id}: {one} {other}"
            );
        }
        count += 1;
    }
    assert_eq!(count, 15);
}
