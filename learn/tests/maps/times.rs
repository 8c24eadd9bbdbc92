//! How long fits take, printed: the claim is about a machine, so no test holds it.

use std::time::Instant;

use leafwise_learn::FunctionFamily;

use crate::support::{Draws, PENDULUM, Place, RIGID_BODY, logarithms, polynomials};

/// The fits of the guide and of the other tests, the whole of each: coefficients, Hamiltonian, errors.
#[test]
#[ignore = "a measurement"]
#[expect(clippy::print_stdout, reason = "a measurement")]
fn fits_are_timed() {
    let mut draws = Draws(19);
    let body = Place::new(RIGID_BODY, "so3-exponential", "[1, 0, 0]");
    let few = body.pairs(&draws.on_spheres(150), 0.5);
    let mut many = body.pairs(&draws.on_spheres(1000), 0.5);
    draws.noisy(&mut many.0, 1e-3);
    draws.noisy(&mut many.1, 1e-3);
    let text = "[system]\nvariables = [\"u\", \"v\"]\nbracket = { \"u,v\" = \"u*v\" }\nconvention = \"{x,H}\"\nhamiltonian = \"u - ln(u) + v - 2*ln(v)\"\n";
    let populations = Place::new(text, "log-canonical", "[1, 1]");
    let species = populations.pairs(&draws.in_box(300, &[(0.4, 2.5), (0.8, 4.0)]), 0.1);
    let pendulum = Place::new(PENDULUM, "lie-poisson", "[1, 0, 0.3]");
    let ranges = [(-1.0, 1.0), (-1.0, 1.0), (-0.2, 0.2)];
    let turns = pendulum.pairs(&draws.in_box(300, &ranges), 0.2);
    let mut angles = polynomials(3, 4);
    angles.axes[0].family = FunctionFamily::Fourier {
        period: std::f64::consts::TAU,
    };
    let mut noisy = polynomials(3, 5);
    noisy.has_noise = true;
    let cases = [
        (
            "body, 150 pairs, degree 8",
            &body,
            &few,
            polynomials(3, 8),
            0.5,
        ),
        (
            "body, 1000 noisy pairs, degree 5",
            &body,
            &many,
            polynomials(3, 5),
            0.5,
        ),
        ("the same, both ends corrected", &body, &many, noisy, 0.5),
        (
            "populations, 300 pairs, degree 6",
            &populations,
            &species,
            logarithms(2, 6),
            0.1,
        ),
        (
            "pendulum, 300 pairs, angles, degree 4",
            &pendulum,
            &turns,
            angles,
            0.2,
        ),
    ];
    let mut count = 0;
    for (name, place, pairs, options, h) in &cases {
        let begin = Instant::now();
        let learned = place.learn(*h, pairs, options).expect("pairs");
        println!(
            "{name}: {} functions, {:?}",
            learned.functions.len(),
            begin.elapsed()
        );
        count += 1;
    }
    assert_eq!(count, cases.len());
}
