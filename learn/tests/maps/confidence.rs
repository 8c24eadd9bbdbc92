//! Whether the truth lies as often within the reported errors as these say.

use leafwise_learn::{LearnAdvice, LearnOptions, StatePairs, learn};

use crate::support::{Draws, Place, RIGID_BODY, orbit, polynomials, rms};

const SEEDS: u64 = 120;

/// Within 1.96 standard errors lie 95 % of normal deviates; of n such trials, independent over the seeds, six standard deviations of the
/// binomial are 6 √(n 0.95 0.05). Errors in y bias by σ² and are far below.
fn assert_covers(within: f64, trials: f64) {
    let spread = 6.0 * libm::sqrt(trials * 0.95 * 0.05);
    assert!(
        (within - 0.95 * trials).abs() < spread,
        "{within} of {trials}, ± {spread:.1}"
    );
}

/// Coefficients of Ŝ = tan(h/2) (q² + p²) of an oscillator, errors of 1e-3 in both states. The five of a seed are nearly independent; one is taken each.
#[test]
fn standard_errors_cover_the_coefficients() {
    let text = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\nhamiltonian = \"(q^2 + p^2)/2\"\n";
    let place = Place::new(text, "constant", "[1, 0]");
    let h = 0.4;
    let mut within = [0.0; 5];
    let mut energies = 0.0;
    for seed in 0..SEEDS {
        let mut draws = Draws(1000 + seed);
        let states = draws.in_box(60, &[(-1.0, 1.0); 2]);
        // The flow is a rotation.
        let (sin, cos) = (libm::sin(h), libm::cos(h));
        let mut after: Vec<f64> = states
            .iter()
            .flat_map(|x| [cos * x[0] + sin * x[1], cos * x[1] - sin * x[0]])
            .collect();
        let mut before = states.concat();
        draws.noisy(&mut before, 1e-3);
        draws.noisy(&mut after, 1e-3);
        let learned = place
            .learn(h, &(before, after), &polynomials(2, 2))
            .expect("pairs");
        for (own, within) in learned.functions.iter().zip(&mut within) {
            let is_square = own.formula == "q^2" || own.formula == "p^2";
            let truth = if is_square {
                libm::tan(h / 2.0) / h
            } else {
                0.0
            };
            *within += f64::from(u8::from(
                (own.generating - truth).abs() < 1.96 * own.generating_error,
            ));
        }
        // H less its mean at the pairs, in units of its error: of mean square 1.
        let of = |x: &[f64]| -> f64 {
            let functions = [x[0], x[1], x[0] * x[0], x[0] * x[1], x[1] * x[1]];
            let named = |name: &str| {
                let mut own = learned.functions.iter();
                own.find(|own| own.formula == name).expect(name).generating
            };
            let names = ["q", "p", "q^2", "q*p", "p^2"];
            let sum = names.iter().zip(functions).map(|(name, f)| named(name) * f);
            sum.sum::<f64>() - libm::tan(h / 2.0) / h * (x[0] * x[0] + x[1] * x[1])
        };
        let errors: Vec<f64> = states.iter().map(|x| of(x)).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let error = rms(errors.iter().map(|e| e - mean)) / learned.energy_error;
        energies += error * error / SEEDS as f64;
    }
    within
        .iter()
        .for_each(|within| assert_covers(*within, SEEDS as f64));
    // A mean of SEEDS squares of five deviates, whose weights differ: at most a variance of 2 each.
    assert!(
        (energies - 1.0).abs() < 6.0 * libm::sqrt(2.0 / SEEDS as f64),
        "{energies}"
    );
}

/// Steps of a noisy rigid body from a state that no pair has, in the two directions of its leaf.
#[test]
fn step_errors_cover_the_steps() {
    let body = Place::new(RIGID_BODY, "so3-exponential", "[1, 0, 0]");
    let h = 0.2;
    let states = Draws(8).on_spheres(80);
    let exact = body.pairs(&states, h);
    let truth = body.learn(h, &exact, &polynomials(3, 3)).expect("pairs");
    let x = [0.6, 0.5, 0.6];
    let next = |learned: &leafwise_learn::Learned| {
        let (system, method) = body.method(learned);
        orbit(&method, &system, &x, h, 1).remove(0)
    };
    let truth = next(&truth);
    let mut squares = 0.0;
    for seed in 0..SEEDS {
        let mut draws = Draws(2000 + seed);
        let mut pairs = exact.clone();
        draws.noisy(&mut pairs.0, 1e-3);
        draws.noisy(&mut pairs.1, 1e-3);
        let mut learned = body.learn(h, &pairs, &polynomials(3, 3)).expect("pairs");
        let error = next(&learned)
            .iter()
            .zip(&truth)
            .map(|(a, b)| (a - b) * (a - b))
            .sum::<f64>();
        let worst = learned.step_error_at(&x);
        squares += error / (worst * worst) / SEEDS as f64;
    }
    // The error along both directions in units of that along the worse: 1 to 2 in the mean, of a variance of at most 4 a seed.
    let spread = 6.0 * libm::sqrt(4.0 / SEEDS as f64);
    assert!(
        squares > 1.0 - spread && squares < 2.0 + spread,
        "{squares}"
    );
}

/// Exact pairs of an oscillator at steps from ½ to 3, of at most half a turn. Differences over 8 steps to either side find H to s¹⁶ with s = sin(h/2),
/// and all further ones add less than s²/(1 − s²) times the last. A coefficient is within that bound; a factor of 2 is left to
/// round-off of the pairs, which s² is found from. A warning says so from h = 2 on: s¹⁶/3 is 0.02 there, and 5e-6 at h = 1.
#[test]
fn errors_of_h_cover_what_long_steps_leave() {
    let text = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\nhamiltonian = \"(q^2 + p^2)/2\"\n";
    let place = Place::new(text, "constant", "[1, 0]");
    for h in [0.5, 1.0, 1.5, 2.0, 2.5, 3.0] {
        let states = Draws(9).in_box(60, &[(-1.0, 1.0); 2]);
        let (sin, cos) = (libm::sin(h), libm::cos(h));
        let after = states
            .iter()
            .flat_map(|x| [cos * x[0] + sin * x[1], cos * x[1] - sin * x[0]]);
        let after: Vec<f64> = after.collect();
        let learned = place
            .learn(h, &(states.concat(), after), &polynomials(2, 2))
            .expect("pairs");
        let mut own = learned.functions.iter();
        let square = own.find(|own| own.formula == "q^2").expect("q^2");
        let missed = (square.hamiltonian - 0.5).abs();
        assert!(missed < 2.0 * square.error, "h = {h}: {square:?}");
        // The energy of states in the box varies by less than 1.
        let missed = missed / 0.5;
        assert!(learned.energy_error < square.error, "h = {h}");
        assert!(learned.energy_error > square.error / 10.0, "h = {h}");
        let flow = learned.hamiltonian_error.expect("H");
        assert!(missed < 2.0 * flow, "h = {h}: {missed:e} {flow:e}");
        let is_told = learned
            .advice
            .iter()
            .any(|advice| matches!(advice, LearnAdvice::Coarse { .. }));
        match h {
            ..=1.0 => assert!(!is_told, "h = {h}: {:?}", learned.advice),
            2.0.. => assert!(is_told, "h = {h}: {:?}", learned.advice),
            _ => {}
        }
    }
}

/// The leverage of a pair's own state is that of its rows, at the point y = (x + x')/2 of its step: of the length cos(h/2) = 0.54 of x. The learned step
/// is the pair's to 1e-13, and leverages are smooth.
#[test]
fn leverages_of_the_pairs_are_those_of_their_rows() {
    let text = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\nhamiltonian = \"(q^2 + p^2)/2\"\n";
    let place = Place::new(text, "constant", "[1, 0]");
    let (sin, cos) = (libm::sin(2.0), libm::cos(2.0));
    let states = Draws(10).in_box(60, &[(-1.0, 1.0); 2]);
    let after = states
        .iter()
        .flat_map(|x| [cos * x[0] + sin * x[1], cos * x[1] - sin * x[0]]);
    let pairs = (states.concat(), after.collect());
    let mut learned = place.learn(2.0, &pairs, &polynomials(2, 2)).expect("pairs");
    let own = states.iter().map(|x| learned.leverage(x));
    let largest = own.fold(0.0, f64::max);
    let ratio = largest / learned.largest_leverage;
    assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
}

/// A ridge λ pulls coefficients of exact pairs by λ² of them or so, and no noise tells of it: the errors do. The estimate leaves out the third order, so errors are within
/// a factor of 1 + 4λ² of the pull.
#[test]
fn errors_cover_the_pull_of_a_ridge() {
    let text = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\nhamiltonian = \"(q^2 + p^2)/2\"\n";
    let place = Place::new(text, "constant", "[1, 0]");
    let h = 0.4;
    let pairs = place.pairs(&Draws(13).in_box(80, &[(-1.0, 1.0); 2]), h);
    for ridge in [0.02, 0.1, 0.2] {
        let options = LearnOptions {
            ridge,
            ..polynomials(2, 2)
        };
        let mut learned = place.learn(h, &pairs, &options).expect("pairs");
        let mut functions = learned.functions.iter();
        let square = functions.find(|own| own.formula == "q^2").expect("q^2");
        let missed = (square.generating - libm::tan(h / 2.0) / h).abs();
        let ratio = square.generating_error / missed;
        assert!(
            (0.9..1.0 + 8.0 * ridge).contains(&ratio),
            "λ = {ridge}: {ratio}"
        );
        assert!(
            (square.hamiltonian - 0.5).abs() < 1.1 * square.error,
            "λ = {ridge}: {square:?}"
        );
        // A step in the mean, with both coefficients off by as much: h 2c x has the size of h c.
        let states = Draws(14).in_box(50, &[(-1.0, 1.0); 2]);
        let (system, method) = place.method(&learned);
        let errors = states.iter().flat_map(|x| {
            let next = orbit(&method, &system, x, h, 1).remove(0);
            let exact = place.flow(x, h);
            next.into_iter()
                .zip(exact)
                .map(|(a, b)| a - b)
                .collect::<Vec<_>>()
        });
        let error = rms(errors);
        assert!(
            error < 1.5 * learned.step_error,
            "λ = {ridge}: {error:e} {:e}",
            learned.step_error
        );
        assert!(learned.leverage(&states[0]).is_finite());
    }
}

/// Weights of pairs do not stand in the leverage of a state: the largest one is that of a state of light pairs, by its own rows without their weights.
#[test]
fn the_largest_leverage_has_no_weights() {
    let text = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\nhamiltonian = \"(q^2 + p^2)/2\"\n";
    let place = Place::new(text, "constant", "[1, 0]");
    let states = Draws(15).in_box(60, &[(-1.0, 1.0); 2]);
    let (before, after) = place.pairs(&states, 0.4);
    // Those far from the middle count for a hundredth.
    let weights: Vec<f64> = states
        .iter()
        .map(|x| if x[0].abs() > 0.5 { 0.01 } else { 1.0 })
        .collect();
    let pairs = StatePairs::new(2, &before, &after, Some(&weights)).expect("pairs");
    let learned = learn(
        &place.system,
        &place.realization,
        (1.0, 0.4),
        &pairs,
        &polynomials(2, 2),
    );
    let mut learned = learned.expect("pairs");
    let own = states.iter().map(|x| learned.leverage(x));
    let largest = own.fold(0.0, f64::max);
    let ratio = largest / learned.largest_leverage;
    assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
}
