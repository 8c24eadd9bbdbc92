//! Starts at the edge of a formula's domain: powers and roots at 0, species that are extinct or rare.

use leafwise_tests::scenes::{composed, end};

/// p²/2 + V from (0, 1), over t = 1 in so many steps.
fn particle(potential: &str, method: &str, steps: usize) -> Vec<f64> {
    end(&composed(&format!(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"p^2/2 + {potential}\"\n[method]\n{method}\ntime-step = {:?}\n\
         [run]\ninitial = [0, 1]\nsteps = {steps}\n",
        1.0 / steps as f64
    )))
}

const METHODS: [&str; 9] = [
    "stepper = \"rk4\"",
    "stepper = \"dop853\"",
    "stepper = \"dormand-prince45\"",
    "stepper = \"splitting\"",
    "stepper = \"implicit-midpoint\"",
    "stepper = { name = \"gauss\", stages = 2 }",
    "stepper = \"energy-preserving\"",
    "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }",
    "realization = { name = \"karasev-truncated\", order = 2 }\ndynamics = \"collective\"",
];

/// √(q⁴) = q²: q = sin(√2 t)/√2, by every method as by the polynomial itself, to the bit.
#[test]
fn a_root_of_a_fourth_power_is_the_square() {
    for method in METHODS {
        let (root, square) = (
            particle("sqrt(q^4)", method, 64),
            particle("q^2", method, 64),
        );
        assert_eq!(root, square, "{method}");
        let omega = libm::sqrt(2.0);
        let exact = libm::sin(omega) / omega;
        // Methods of order 2 are off by (h ω)²/12 of the phase.
        let bound = (omega / 64.0) * (omega / 64.0) / 6.0;
        assert!(
            (root[0] - exact).abs() <= bound,
            "{method}: {root:?} for {exact}"
        );
    }
}

/// |q|ᵃ in three spellings from q = 0, where the derivative as it is written is 0·∞.
#[test]
fn powers_of_the_absolute_value_start_at_zero() {
    for (potential, a) in [
        ("(q^2)^0.9375", 1.875),
        ("(q^2)^0.5*q^2", 3.0),
        ("(q^2)^1.5", 3.0),
    ] {
        // q'² = 1 − 2 |q|ᵃ: q = t − t^(a+1)/(a+1) + (a − 1) t^(2a+1)/(2 (a+1)(2a+1)) …, at t = 1/4.
        let t: f64 = 0.25;
        let second = libm::pow(t, a + 1.0) / (a + 1.0);
        let third = (a - 1.0) * libm::pow(t, 2.0 * a + 1.0) / (2.0 * (a + 1.0) * (2.0 * a + 1.0));
        let exact = t - second + third;
        let next = libm::pow(t, 3.0 * a + 1.0);
        // Of |q|^1.875 the field has no derivative at 0: methods that take none step from there.
        let methods = if a < 2.0 { &METHODS[..4] } else { &METHODS };
        for method in methods {
            let run = end(&composed(&format!(
                "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"1\" }}\nconvention = \"{{x,H}}\"\n\
                 hamiltonian = \"p^2/2 + {potential}\"\n[method]\n{method}\ntime-step = 0.00390625\n\
                 [run]\ninitial = [0, 1]\nsteps = 64\n"
            )));
            // The motion turns at a rate below 2 about 0: a method of order 2 is off by (2h)²/12 of the way.
            let bound = next + 4.0 * 0.00390625 * 0.00390625 * t;
            assert!(
                (run[0] - exact).abs() <= bound,
                "{potential}, {method}: {} for {exact}",
                run[0]
            );
        }
    }
}

/// ẋ = x (a − b y), ẏ = y (d x − c) from so many species, over t = 1 in steps of 1/64.
fn species(method: &str, initial: [f64; 2]) -> Vec<f64> {
    end(&composed(&format!(
        "[system]\nvariables = [\"x\", \"y\"]\nbracket = {{ log-canonical = [[0, 1], [-1, 0]] }}\n\
         convention = \"{{x,H}}\"\nhamiltonian = \"1.5*ln(y) - y + 3*ln(x) - x\"\n[method]\n{method}\n\
         time-step = 0.015625\n[run]\ninitial = {initial:?}\nsteps = 64\n"
    )))
}

const OF_SPECIES: [&str; 8] = [
    "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }",
    "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }",
    "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 6 }",
    "stepper = { name = \"gauss\", stages = 2 }",
    "stepper = \"implicit-midpoint\"",
    "stepper = \"rk4\"",
    "stepper = \"dop853\"",
    "stepper = \"splitting\"",
];

/// Of x next to nothing y is e^(−3t), and x grows or falls in proportion to itself, however rare; an extinct one stays so.
#[test]
fn rare_and_extinct_species_move_as_the_system_without_them() {
    let reduced = libm::exp(-3.0);
    for method in OF_SPECIES {
        let often = species(method, [1e-100, 1.0]);
        // x = x₀ exp(1.5 t − (1 − e^(−3t))/3).
        let grown = libm::exp(1.5 - (1.0 - reduced) / 3.0);
        // An order of 2 leaves (3h)²/12 of a logarithm of 3.
        let bound = 9.0 / (64.0 * 64.0);
        assert!(
            (often[1] / reduced - 1.0).abs() <= bound,
            "{method}: {often:?}"
        );
        assert!(
            (often[0] / (1e-100 * grown) - 1.0).abs() <= bound,
            "{method}: {often:?}"
        );
        // Rarer ones by the same numbers, but for what each step rounds.
        let noise = 64.0 * 16.0 * f64::EPSILON;
        for rare in [1e-154, 1e-160, 1e-200, 1e-290] {
            let found = species(method, [rare, 1.0]);
            assert!(
                (found[1] / often[1] - 1.0).abs() <= noise,
                "{method}, {rare:e}: {found:?}"
            );
            let grown = (found[0] / rare) / (often[0] / 1e-100);
            assert!(
                (grown - 1.0).abs() <= noise,
                "{method}, {rare:e}: {found:?}"
            );
            let other = species(method, [1.0, rare]);
            assert!(
                other[1] > 0.0 && other[0].is_finite(),
                "{method}, {rare:e}: {other:?}"
            );
        }
        let extinct = species(method, [0.0, 1.0]);
        assert_eq!(extinct[0], 0.0, "{method}");
        assert!(
            (extinct[1] / often[1] - 1.0).abs() <= noise,
            "{method}: {extinct:?}"
        );
    }
}
