//! Species of log-canonical tensors keep their signs and their leaves.

use proptest::collection::vec;

use super::*;

/// Species of a log-canonical tensor keep their signs, and ln C changes by round-off: what a sum of
/// x and its increment keeps of a species that falls to x' is round-off of x over x'. `noise` is how
/// well x can be met by any solution: α̂ and β̂ keep ln C from one to the other.
fn keeps_leaves(x: &[f64], next: &[f64], exponents: &[f64], noise: &[f64]) -> Result<(), String> {
    let signs = x.iter().zip(next).all(|(x, next)| x * next > 0.0);
    if !signs {
        return Err(format!("{x:?} to {next:?}: a sign changed"));
    }
    let terms = || exponents.iter().zip(x.iter().zip(next));
    let change: f64 = terms().map(|(c, (x, next))| c * libm::log(next / x)).sum();
    let part = |(c, (x, next)): (&f64, (&f64, &f64))| c.abs() * (x / next).abs().max(1.0);
    let met = terms()
        .zip(noise)
        .map(|((c, (x, _)), noise)| (c / x).abs() * noise);
    let bound: f64 = 64.0 * f64::EPSILON * terms().map(part).sum::<f64>() + met.sum::<f64>();
    if change.abs() <= bound {
        return Ok(());
    }
    Err(format!(
        "{x:?} to {next:?}: ln C moved by {change:e}, more than {bound:e}"
    ))
}

const LOG_CANONICAL: [(&str, &[f64]); 3] = [
    (
        r#"
[system]
variables = ["x1", "x2"]
bracket = { log-canonical = [[0, -1], [1, 0]] }
hamiltonian = "0.3*x1*x1 - 0.0558*x1*x2 + 0.013*x2*x2 + 0.169*x1 - 0.204*x2"
[method]
realization = "auto"
dynamics = { name = "hamilton-jacobi", order = 2 }
time-step = 6.40008774264553
[run]
initial = [0.525, 1.8696]
steps = 1
"#,
        &[0.0, 0.0],
    ),
    (
        r#"
[system]
variables = ["x1", "x2", "x3"]
bracket = { log-canonical = [[0, 2, -1], [-2, 0, 1], [1, -1, 0]] }
hamiltonian = "0.3293*x1*x1 + 0.2923*x1*x2 + 0.1364*x1*x3 + 0.2863*x2*x2 + 0.1337*x3*x3 - 0.451*x1 + 0.226*x2 + 0.009*x3"
[method]
realization = "auto"
dynamics = { name = "hamilton-jacobi", order = 4 }
time-step = 1.21
[run]
initial = [1.943, 1.678, 0.536]
steps = 1
"#,
        &[1.0, 1.0, 2.0],
    ),
    (
        r#"
[system]
variables = ["x1", "x2", "x3", "x4"]
bracket = { log-canonical = [[0, 2, 1, 1], [-2, 0, 1, -1], [-1, -1, 0, 1], [-1, 1, -1, 0]] }
hamiltonian = "0.2929*x1*x1 + 0.0089*x1*x3 - 0.0097*x1*x4 + 0.3734*x2*x2 - 0.3271*x2*x4 + 0.3991*x3*x3 - 0.5386*x3*x4 + 0.1985*x4*x4 + 0.402*x1 + 0.314*x2 + 0.39*x3 - 0.045*x4"
[method]
realization = "auto"
dynamics = { name = "hamilton-jacobi", order = 6 }
time-step = 0.2689697438059661
[run]
initial = [1.518, 1.395, 1.797, 0.886]
steps = 1
"#,
        &[0.0, 0.0, 0.0, 0.0],
    ),
];

/// Iterates that overflowed were taken for solutions: corrections were judged against their increments.
#[test]
fn an_iterate_far_off_is_no_solution() {
    for (text, exponents) in LOG_CANONICAL {
        let run = composed(text);
        let (states, _) = steps(&run);
        if let [x, next] = &states[..] {
            keeps_leaves(x, next, exponents, &[]).unwrap_or_else(|why| panic!("{why}\n{text}"));
            assert!(largest(next.iter().copied()) < 100.0, "{next:?}");
        }
    }
}

/// A dying species stays positive, or its step is refused.
#[test]
fn no_species_turns_negative() {
    for realization in ["log-canonical", "karasev-collocated"] {
        let run = composed(&format!(
            r#"
[system]
variables = ["x1", "x2"]
bracket = {{ log-canonical = [[0, 1], [-1, 0]] }}
hamiltonian = "0.1438*x1*x1 + 0.6464*x2*x2 + 0.456*x1 - 0.375*x2"
[method]
realization = "{realization}"
dynamics = {{ name = "hamilton-jacobi", order = 6 }}
composition = "suzuki-umeno-8"
time-step = 1.447
[run]
initial = [1.678, 0.749]
steps = 20
"#
        ));
        let (states, _) = steps(&run);
        for state in &states {
            assert!(state.iter().all(|x| *x > 0.0), "{realization}: {state:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    /// One step of a log-canonical system, from tame to extreme: signs, Casimirs and the equation
    /// itself, by an evaluation of its own.
    #[test]
    fn log_canonical_steps_keep_signs_and_casimirs_or_are_refused(
        entries in vec(-2..=2_i32, 3),
        coefficients in vec(-60..=60_i32, 9),
        x in vec(0.3..2.0_f64, 3),
        (order, rate) in (1..=3_i32, 0.3..6.0_f64),
    ) {
        let [a, b, c] = [entries[0], entries[1], entries[2]];
        let pairs = [(1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3)];
        let mut terms: Vec<String> = pairs
            .iter()
            .zip(&coefficients)
            .map(|((i, j), k)| format!("({k})/100*x{i}*x{j}"))
            .collect();
        terms.extend((1..=3).map(|i| format!("({})/100*x{i}", coefficients[5 + i])));
        let hamiltonian = terms.join(" + ");
        let gradient: Vec<f64> = (1..=3)
            .map(|i| {
                let of_pairs = pairs.iter().zip(&coefficients).map(|((k, l), factor)| {
                    let mut slope = 0.0;
                    if *k == i {
                        slope += x[l - 1];
                    }
                    if *l == i {
                        slope += x[k - 1];
                    }
                    f64::from(*factor) / 100.0 * slope
                });
                of_pairs.sum::<f64>() + f64::from(coefficients[5 + i]) / 100.0
            })
            .collect();
        let matrix = [[0, a, b], [-a, 0, c], [-b, -c, 0]];
        let speed = largest(matrix.iter().map(|row| {
            let terms = row.iter().zip(&x).zip(&gradient);
            terms.map(|((m, x), g)| f64::from(*m) * x * g).sum::<f64>()
        }));
        prop_assume!(speed > 1e-3);
        let h = rate / speed;
        let run = composed(&format!(
            "[system]\nvariables = [\"x1\", \"x2\", \"x3\"]\nbracket = {{ log-canonical = {matrix:?} }}\n\
             hamiltonian = \"{hamiltonian}\"\n[method]\nrealization = \"log-canonical\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = {} }}\ntime-step = {h:?}\n\
             [run]\ninitial = {x:?}\nsteps = 1\n",
            2 * order
        ));
        let method = run.method.written().expect("a method");
        let parameters = run.system.parameter_values();
        let mut stepper = leafwise::core::StepMap::stepper(method, 1, &parameters, run.plan.epsilon, run.plan.h);
        let (mut increment, mut outcome) = (vec![0.0; 3], [Ok(())]);
        stepper.increment(&x, &[0.0; 3], &mut increment, &mut outcome);
        if outcome[0].is_ok() {
            let next: Vec<f64> = x.iter().zip(&increment).map(|(x, i)| x + i).collect();
            let casimir = [f64::from(c), -f64::from(b), f64::from(a)];
            let y = stepper.solution(0).expect("a solution");
            let mut evaluators = method.evaluators(&parameters, run.plan.epsilon, run.plan.h).expect("evaluators");
            // β̂(L(y)) at y with so many ulps added to each component.
            let mut target = |ulps: f64| -> Vec<f64> {
                let y: Vec<f64> = y.iter().map(|y| y * (1.0 + ulps * f64::EPSILON)).collect();
                let mut z = vec![0.0; 6];
                evaluators.points.values(&y, &mut z).expect("a point");
                let mut values = [0.0; 9];
                evaluators.maps.values(&z, &mut values).expect("ends");
                let ends = leafwise::core::Ends::of(&values);
                (0..3).map(|i| ends.target(i)).collect()
            };
            let found = target(0.0);
            let near = [-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0].map(&mut target);
            let noise: Vec<f64> = (0..3)
                .map(|i| largest(near.iter().map(|other| other[i] - found[i])))
                .collect();
            let kept = keeps_leaves(&x, &next, &casimir, &noise);
            prop_assert!(kept.is_ok(), "{}", kept.unwrap_err());
            let away = distance(&found, &x);
            let size = largest(x.iter().chain(&y).copied());
            prop_assert!(away <= 64.0 * (f64::EPSILON * size + largest(noise)), "{away:e}");
        }
    }
}
