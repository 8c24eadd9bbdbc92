//! Equilibria on leaves, and known bounds of their stability.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::orbit::{Rest, RestError, Verdict, rest};
use leafwise_tests::scenes::until;

const METHOD: &str = "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }";

fn found(system: &str, initial: &[f64]) -> Result<Rest, RestError> {
    let run = until(system, METHOD, &format!("{initial:?}"), (1.0, 10));
    rest(&run)
}

/// Where a verdict changes, by halving.
fn bound(mut is_unstable: impl FnMut(f64) -> bool, mut unstable: f64, mut other: f64) -> f64 {
    assert!(is_unstable(unstable) && !is_unstable(other));
    for _ in 0..32 {
        let middle = 0.5 * (unstable + other);
        if is_unstable(middle) {
            unstable = middle;
        } else {
            other = middle;
        }
    }
    0.5 * (unstable + other)
}

/// Free bodies turn about their axes in the leaf of |m| as the start has it: about the first and the last for all times, about
/// the second with the exponents ±|m| √((1/I₁ − 1/I₂)(1/I₂ − 1/I₃)).
#[test]
fn a_free_body_turns_about_its_axes() {
    let inertia = [1.0, 2.0, 3.0];
    let system = "variables = [\"m1\", \"m2\", \"m3\"]\nconvention = \"{x,H}\"\n\
        bracket = { \"m1,m2\" = \"-m3\", \"m2,m3\" = \"-m1\", \"m3,m1\" = \"-m2\" }\n\
        casimirs = { C = \"(m1^2 + m2^2 + m3^2)/2\" }\nhamiltonian = \"m1^2/2 + m2^2/4 + m3^2/6\"";
    for axis in 0..3 {
        let mut initial = [0.1, -0.05, 0.08];
        initial[axis] = 1.5;
        let size = libm::sqrt(initial.iter().map(|m| m * m).sum());
        let found = found(system, &initial).expect("an equilibrium");
        println!("{found:?}");
        assert_eq!(found.leaf, 2);
        assert!((found.state[axis] - size).abs() < 1e-12);
        let multiples = found.multiples.expect("∇H is along ∇C");
        assert!((multiples[0] - 1.0 / inertia[axis]).abs() < 1e-12);
        let [a, b] = [1, 2].map(|next| 1.0 / inertia[axis] - 1.0 / inertia[(axis + next) % 3]);
        let rate = size * libm::sqrt((a * b).abs());
        let [one, other] = found.eigenvalues[..] else {
            panic!("two")
        };
        if axis == 1 {
            assert_eq!(found.verdict, Verdict::Unstable);
            assert!((one.re.abs() - rate).abs() < 1e-12 && (one.re + other.re).abs() < 1e-12);
        } else {
            assert_eq!(found.verdict, Verdict::Stable);
            assert!((one.im.abs() - rate).abs() < 1e-12 && one.re.abs() < 1e-12);
        }
        // In the leaf H is curved by −(1/I_axis − 1/I_other).
        let mut expected = [-a, -b];
        expected.sort_by(f64::total_cmp);
        for (own, expected) in found.curvatures.iter().zip(expected) {
            assert!((own - expected).abs() < 1e-12);
        }
    }
    let alone = found(system, &[0.0, 0.0, 0.0]).expect("an equilibrium");
    assert_eq!((alone.verdict, alone.leaf), (Verdict::Alone, 0));
}

/// A symmetric top that sleeps upright with the angular velocity w, (I₁, I₁, I₃), the weight times the distance of its centre g.
fn sleeping((i1, i3, g): (f64, f64, f64), w: f64) -> Rest {
    let system = format!(
        "library = \"heavy-top\"\nparameters = {{ I1 = {i1:?}, I2 = {i1:?}, I3 = {i3:?}, chi1 = 0.0, chi3 = {g:?} }}"
    );
    found(&system, &[0.0, 0.0, i3 * w, 0.0, 0.0, 1.0]).expect("an equilibrium")
}

/// A sleeping top is stable iff (I₃ω)² > 4 m g l I₁. Its energy alone is least in the leaf iff (I₃ − I₁)ω² > m g l:
/// with δγ, δm at right angles to the axis, H − λ₁ m·γ − λ₂|γ|²/2 has the form |δm|²/2I₁ − λ₁ δm·δγ − λ₂|δγ|²/2 with λ₁ = ω and
/// λ₂ = m g l − I₃ω².
#[test]
fn a_sleeping_top_wakes_at_the_known_bound() {
    for (i1, i3, g) in [(1.0, 0.6, 0.7), (0.8, 1.5, 1.0), (2.0, 0.3, 1.3)] {
        let top = (i1, i3, g);
        let exact = libm::sqrt(4.0 * g * i1) / i3;
        let own = bound(
            |w| sleeping(top, w).verdict == Verdict::Unstable,
            0.3 * exact,
            3.0 * exact,
        );
        println!("({i1}, {i3}, {g}): {own} and {exact}");
        assert!((own - exact).abs() < 1e-6, "{own} {exact}");
        let fast = sleeping(top, 40.0 * exact);
        if i3 > i1 {
            let exact = libm::sqrt(g / (i3 - i1));
            let own = bound(
                |w| sleeping(top, w).verdict != Verdict::Stable,
                0.3 * exact,
                3.0 * exact,
            );
            println!("energy: {own} and {exact}");
            assert!((own - exact).abs() < 1e-6, "{own} {exact}");
            assert_eq!(fast.verdict, Verdict::Stable);
        } else {
            assert_eq!(fast.verdict, Verdict::SpectrallyStable);
        }
        let multiples = fast.multiples.expect("both");
        // The library's Casimirs are |γ|² and m·γ.
        let w = 40.0 * exact;
        assert!((multiples[1] / w - 1.0).abs() < 1e-9);
        assert!((2.0 * multiples[0] / (g - i3 * w * w) - 1.0).abs() < 1e-9);
    }
}

/// The triangular points of the restricted problem are stable in the plane iff 27 μ(1 − μ) < 1 (E. Routh 1875).
#[test]
fn triangular_points_are_stable_up_to_rouths_value() {
    let at = |mu: f64| {
        let system = format!(
            "variables = [\"x\", \"y\", \"px\", \"py\"]\nparameters = {{ mu = {mu:?} }}\nbracket = \"canonical\"\n\
             hamiltonian = \"(px^2 + py^2)/2 + y*px - x*py - (1 - mu)/sqrt((x + mu)^2 + y^2) - mu/sqrt((x - 1 + mu)^2 + y^2)\""
        );
        let height = 0.5 * libm::sqrt(3.0);
        let near = [0.5 - mu + 0.01, height + 0.01, -height, 0.5 - mu];
        let found = found(&system, &near).expect("an equilibrium");
        assert!((found.state[0] - 0.5 + mu).abs() < 1e-10);
        found.verdict
    };
    let exact = 0.5 * (1.0 - libm::sqrt(23.0 / 27.0));
    let own = bound(|mu| at(mu) == Verdict::Unstable, 0.2, 0.01);
    println!("{own} and {exact}");
    assert!((own - exact).abs() < 1e-9, "{own} {exact}");
    assert_eq!(at(0.01), Verdict::SpectrallyStable);
}

#[test]
fn what_does_not_rest_is_refused() {
    let free = "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p + q^2\"";
    let refused = found(free, &[0.3, 0.2]);
    assert!(
        matches!(refused, Err(RestError::Moves { .. })),
        "{refused:?}"
    );
    let timed =
        "variables = [\"q\", \"p\"]\nbracket = \"canonical\"\nhamiltonian = \"p^2/2 + q*sin(t)\"";
    let refused = found(timed, &[0.3, 0.2]);
    assert!(matches!(refused, Err(RestError::NotOffered { .. })));
}
