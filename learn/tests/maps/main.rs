//! Maps learned from pairs of states: how well they step, what they keep, what is refused.

mod confidence;
mod refusals;
mod support;
mod tabulated;
mod times;
mod weights;

use leafwise_core::Walk;
use leafwise_learn::{BasisAxis, BasisDegree, FunctionFamily, LearnAdvice, LearnOptions};
use support::{Draws, PENDULUM, Place, RIGID_BODY, logarithms, orbit, polynomials, rms};

/// Root mean square of the errors of one learned step from these states.
fn one_step(place: &Place, learned: &leafwise_learn::Learned, states: &[Vec<f64>], h: f64) -> f64 {
    let (system, method) = place.method(learned);
    rms(states.iter().flat_map(|x| {
        let next = orbit(&method, &system, x, h, 1).remove(0);
        let errors = next.into_iter().zip(place.flow(x, h));
        errors.map(|(a, b)| a - b).collect::<Vec<_>>()
    }))
}

/// A rigid body at h = ½ from 150 pairs: the error of a step from 50 other states falls by the degree, and 3000 steps keep the Casimir
/// to round-off and the energy in bounds. The expected errors are those of another program with other draws, so a factor of 3 is left to them.
#[test]
fn a_rigid_body_is_learned_to_the_degree() {
    let body = Place::new(RIGID_BODY, "so3-exponential", "[1, 0, 0]");
    let h = 0.5;
    let mut draws = Draws(0);
    let pairs = body.pairs(&draws.on_spheres(150), h);
    let unseen = draws.on_spheres(50);
    for (degree, expected) in [(2, 2.5e-5), (4, 4.9e-8), (6, 1.3e-10), (8, 4.7e-13)] {
        let learned = body
            .learn(h, &pairs, &polynomials(3, degree))
            .expect("pairs");
        assert_eq!(learned.advice, []);
        // |x|², |x|⁴, … are the Casimirs of the basis.
        assert_eq!(learned.determined + degree / 2, learned.functions.len());
        let error = one_step(&body, &learned, &unseen, h);
        assert!(error < 3.0 * expected, "degree {degree}: {error:e}");
        let x = &unseen[0];
        let (system, method) = body.method(&learned);
        let states = orbit(&method, &system, x, h, 3000);
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let energy = |x: &[f64]| x[0] * x[0] / 2.0 + 2.0 * x[1] * x[1] / 3.0 + 0.4 * x[2] * x[2];
        let most = |states: &[Vec<f64>], f: &dyn Fn(&[f64]) -> f64| {
            let errors = states.iter().map(|y| (f(y) - f(x)).abs());
            errors.fold(0.0, f64::max)
        };
        // Random round-off of 3000 steps, half an ulp of |x|² each.
        assert!(most(&states, &square) < 9e-15, "degree {degree}");
        let (first, last) = (
            most(&states[..300], &energy),
            most(&states[2700..], &energy),
        );
        assert!(
            last < 1.5 * first + 1e-13,
            "degree {degree}: {first:e} {last:e}"
        );
    }
}

/// Errors of 1e-3 in both states of 1000 pairs: the learned step errs by less, its Casimir is round-off, and the noise is told: a difference of two
/// states has √2 times the deviation of one, to 3 % at 2000 equations (six standard deviations are 6/√4000 = 10 %).
#[test]
fn a_step_errs_less_than_its_noisy_pairs() {
    let body = Place::new(RIGID_BODY, "so3-exponential", "[1, 0, 0]");
    let (h, sigma) = (0.5, 1e-3);
    let mut draws = Draws(1);
    let mut pairs = body.pairs(&draws.on_spheres(1000), h);
    draws.noisy(&mut pairs.0, sigma);
    draws.noisy(&mut pairs.1, sigma);
    let unseen = draws.on_spheres(50);
    for has_noise in [false, true] {
        let options = LearnOptions {
            has_noise,
            ..polynomials(3, 5)
        };
        let learned = body.learn(h, &pairs, &options).expect("pairs");
        let error = one_step(&body, &learned, &unseen, h);
        assert!(error < 0.3 * sigma, "{error:e}");
        let ratio = learned.noise / (std::f64::consts::SQRT_2 * sigma);
        assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
        let (system, method) = body.method(&learned);
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let states = orbit(&method, &system, &unseen[0], h, 3000);
        let off = states
            .iter()
            .map(|y| (square(y) - square(&unseen[0])).abs());
        assert!(off.fold(0.0, f64::max) < 9e-15);
    }
}

/// The population model of Poisson neural networks, 3 orbits of 100 pairs, h = 0.1: mean squares of the errors of one step by the degree. H comes out with
/// its coefficients, to what differences and the basis leave. At degree 6 1500 steps stay as near to the flow as those of another program.
#[test]
fn populations_are_learned_to_the_degree() {
    let text = "[system]\nvariables = [\"u\", \"v\"]\nbracket = { \"u,v\" = \"u*v\" }\nconvention = \"{x,H}\"\nhamiltonian = \"u - ln(u) + v - 2*ln(v)\"\n";
    let place = Place::new(text, "log-canonical", "[1, 1]");
    let h = 0.1;
    let orbit_of = |x: [f64; 2], n: usize| {
        let mut states = vec![x.to_vec()];
        (0..n).for_each(|k| states.push(place.flow(&states[k], h)));
        states
    };
    let orbits = [0.8, 1.0, 1.2].map(|v| orbit_of([1.0, v], 100));
    let states: Vec<Vec<f64>> = orbits
        .iter()
        .flat_map(|orbit| orbit[..100].to_vec())
        .collect();
    let pairs = place.pairs(&states, h);
    let truth = orbit_of([1.0, 1.0], 1500);
    let squares = [
        (2, 7.5e-9),
        (3, 2.2e-13),
        (4, 6.6e-15),
        (5, 6.7e-19),
        (6, 8.7e-21),
    ];
    for (degree, expected) in squares {
        let learned = place
            .learn(h, &pairs, &logarithms(2, degree))
            .expect("pairs");
        let error = one_step(&place, &learned, &truth[..200], h);
        assert!(
            error * error < 2.0 * expected,
            "degree {degree}: {:e}",
            error * error
        );
        if degree == 6 {
            let (system, method) = place.method(&learned);
            let states = orbit(&method, &system, &truth[0], h, 1500);
            let errors = states.iter().zip(&truth[1..]).flat_map(|(x, exact)| {
                let errors = x.iter().zip(exact);
                errors.map(|(a, b)| (a - b).abs()).collect::<Vec<_>>()
            });
            let largest = errors.fold(0.0, f64::max);
            assert!(largest < 3.8e-8, "{largest:e}");
        }
        if degree == 3 {
            let of = |name: &str| {
                let mut functions = learned.functions.iter();
                let own = functions.find(|own| own.formula == name).expect(name);
                own.hamiltonian
            };
            for (name, expected) in [("u", 1.0), ("v", 1.0), ("ln(u)", -1.0), ("ln(v)", -2.0)] {
                assert!((of(name) - expected).abs() < 1e-5, "{name}: {}", of(name));
            }
        }
    }
}

/// An affine bracket, {q, p} = 1 + c: the pendulum of Poisson neural networks with a Casimir c, here in both. Cosines and sines of q make it, polynomials do
/// at a higher degree.
#[test]
fn an_affine_bracket_and_angles() {
    let place = Place::new(PENDULUM, "lie-poisson", "[1, 0, 0.3]");
    let h = 0.2;
    let mut draws = Draws(3);
    let ranges = [(-1.0, 1.0), (-1.0, 1.0), (-0.2, 0.2)];
    let pairs = place.pairs(&draws.in_box(300, &ranges), h);
    let unseen = draws.in_box(50, &ranges);
    let mut angles = polynomials(3, 4);
    angles.axes[0] = BasisAxis {
        family: FunctionFamily::Fourier {
            period: std::f64::consts::TAU,
        },
        has_logarithm: false,
    };
    let mut errors = Vec::new();
    for options in [angles, polynomials(3, 4), polynomials(3, 6)] {
        let learned = place.learn(h, &pairs, &options).expect("pairs");
        assert_eq!(learned.advice, []);
        errors.push(one_step(&place, &learned, &unseen, h));
        let (system, method) = place.method(&learned);
        let states = orbit(&method, &system, &unseen[0], h, 500);
        // c' = 0 to the last bit.
        assert!(states.iter().all(|y| y[2] == unseen[0][2]));
    }
    // Of h cos q degree 4 leaves h q^6/720, and degree 6 leaves h q^8/40320: their slopes at |q| below 1.2.
    let [angles, four, six] = errors[..] else {
        panic!("three bases");
    };
    assert!(
        four < h * 15.0 / 720.0 && six < h * 29.0 / 40320.0,
        "{errors:?}"
    );
    assert!(angles < four / 2.0, "{errors:?}");
}

/// The charged particle of Poisson neural networks: {v₁, v₂} = r depends on the place, H = |v|²/2 + 1/(100 r). The learned map has errors that fall by the degree, and
/// DΦ Π(x) DΦᵀ is Π(Φ(x)) to round-off at every degree. 1/r is analytic over the box, where centred powers converge by a factor of more than 4 a degree; √5 a degree
/// is left to slopes of few of them.
#[test]
fn a_charged_particle_is_learned() {
    let text = "[system]\nvariables = [\"x1\", \"x2\", \"v1\", \"v2\"]\nconvention = \"{x,H}\"\n\
                bracket = { \"x1,v1\" = \"1\", \"x2,v2\" = \"1\", \"v1,v2\" = \"sqrt(x1^2 + x2^2)\" }\n\
                hamiltonian = \"(v1^2 + v2^2)/2 + 0.01/sqrt(x1^2 + x2^2)\"\n";
    let realization = "{ name = \"darboux-magnetic\", potential = [\"sqrt(x1^2 + x2^2)*x2/3\", \"-sqrt(x1^2 + x2^2)*x1/3\"] }";
    let place = Place::new(text, realization, "[0.8, 0, 0.1, 0.1]");
    let h = 0.1;
    let mut draws = Draws(16);
    let ranges = [(0.7, 1.3), (-0.3, 0.3), (-0.3, 0.3), (-0.3, 0.3)];
    let pairs = place.pairs(&draws.in_box(300, &ranges), h);
    let unseen = draws.in_box(50, &ranges);
    let mut before = f64::INFINITY;
    for degree in [2, 4] {
        let mut options = polynomials(4, degree);
        for axis in &mut options.axes {
            axis.family = FunctionFamily::Centred;
        }
        let learned = place.learn(h, &pairs, &options).expect("pairs");
        assert_eq!(learned.advice, []);
        let error = one_step(&place, &learned, &unseen, h);
        assert!(
            error < before / 5.0,
            "degree {degree}: {error:e} {before:e}"
        );
        before = error;
        let (system, method) = place.method(&learned);
        let start = [0.8, 0.0, 0.1, 0.1];
        let mut walk = Walk::of(&method, &system, &start, h);
        walk.step().expect("a step");
        let tangent = walk.tangent(0).expect("a map of formulas");
        let tensor = |x: &[f64]| {
            let field = libm::hypot(x[0], x[1]);
            [
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
                [-1.0, 0.0, 0.0, field],
                [0.0, -1.0, -field, 0.0],
            ]
        };
        let (before, after) = (tensor(&start), tensor(walk.state()));
        for i in 0..4 {
            for j in 0..4 {
                let all = (0..4).flat_map(|k| (0..4).map(move |l| (k, l)));
                let moved: f64 = all
                    .map(|(k, l)| tangent[4 * i + k] * before[k][l] * tangent[4 * j + l])
                    .sum();
                // Sums of sixteen products of size 1.
                assert!(
                    (moved - after[i][j]).abs() < 1e-13,
                    "{i} {j}: {moved} {}",
                    after[i][j]
                );
            }
        }
    }
    assert!(before < 1e-5, "{before:e}");
}

/// Splines of degree 5 in q: slopes of cos 3q err by the fifth power of the distance of knots, 32 times less for half of it; a factor of 2 is left to what powers of p leave.
#[test]
fn splines_converge_by_the_distance_of_knots() {
    let text = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\nhamiltonian = \"p^2/2 + cos(3*q)\"\n";
    let place = Place::new(text, "constant", "[1, 0]");
    let h = 0.1;
    let mut draws = Draws(17);
    let ranges = [(-1.0, 1.0), (-0.5, 0.5)];
    let pairs = place.pairs(&draws.in_box(500, &ranges), h);
    let unseen = draws.in_box(50, &[(-0.9, 0.9), (-0.45, 0.45)]);
    let errors = [12, 20].map(|degree| {
        let mut options = polynomials(2, 1);
        options.axes[0].family = FunctionFamily::Spline;
        options.degree = Some(BasisDegree::Each(vec![degree, 4]));
        let learned = place.learn(h, &pairs, &options).expect("pairs");
        assert_eq!(learned.functions.len(), (degree + 1) * 5 - 1);
        one_step(&place, &learned, &unseen, h)
    });
    assert!(
        errors[0] > 16.0 * errors[1] && errors[1] < 1e-6,
        "{errors:?}"
    );
}

/// Held-out pairs choose a degree that is enough for exact pairs of a quadratic H over a constant bracket: 2, since Ŝ is quadratic. H of the flow's own
/// generating function tan(h/2) (q² + p²) is the oscillator's.
#[test]
fn the_degree_is_chosen_by_pairs_held_out() {
    let text = "[system]\nvariables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\nhamiltonian = \"(q^2 + p^2)/2\"\n";
    let place = Place::new(text, "constant", "[1, 0]");
    let h = 0.4;
    let pairs = place.pairs(&Draws(5).in_box(200, &[(-1.0, 1.0); 2]), h);
    let options = LearnOptions {
        degree: None,
        ..polynomials(2, 1)
    };
    let learned = place.learn(h, &pairs, &options).expect("pairs");
    assert_eq!(learned.degree, 2, "{:?}", learned.degrees);
    for own in &learned.functions {
        let is_square = own.formula == "q^2" || own.formula == "p^2";
        let [energy, generating] = match is_square {
            true => [0.5, libm::tan(h / 2.0) / h],
            false => [0.0, 0.0],
        };
        // 200 pairs of states of size 1, with round-off of the flow's 26 steps.
        assert!((own.generating - generating).abs() < 1e-13, "{own:?}");
        // Central differences over 8 steps to either side: (h/2)¹⁶.
        assert!((own.hamiltonian - energy).abs() < 1e-10, "{own:?}");
    }
}

/// Pairs of one leaf, and of the bracket with the other sign in one entry: told.
#[test]
fn pairs_that_tell_too_little_or_of_another_bracket_are_told() {
    let body = Place::new(RIGID_BODY, "so3-exponential", "[1, 0, 0]");
    let mut draws = Draws(6);
    let h = 0.3;
    let mut states = draws.on_spheres(200);
    for x in &mut states {
        let length = libm::sqrt(x.iter().map(|x| x * x).sum());
        x.iter_mut().for_each(|x| *x /= length);
    }
    let pairs = body.pairs(&states, h);
    let mut learned = body.learn(h, &pairs, &polynomials(3, 4)).expect("pairs");
    let largest = learned.largest_leverage;
    assert!(learned.leverage(&states[0]) < 4.0 * largest);
    assert!(learned.leverage(&[3.0, 1.0, 2.0]) > 1e3 * largest);
    // Functions of c that differ between its values alone, where all pairs have one.
    let place = Place::new(PENDULUM, "lie-poisson", "[1, 0, 0.3]");
    let leaf = [(-1.0, 1.0), (-1.0, 1.0), (0.1, 0.1)];
    let pairs = place.pairs(&draws.in_box(100, &leaf), h);
    let mut learned = place.learn(h, &pairs, &polynomials(3, 3)).expect("pairs");
    assert!(learned.leverage(&[0.3, 0.2, 0.1]) < 1.0);
    assert_eq!(learned.leverage(&[0.3, 0.2, 0.2]), f64::INFINITY);

    let other = RIGID_BODY.replace("\"x,y\" = \"-z\"", "\"x,y\" = \"z\"");
    let other = other.replace(&other[other.find("casimirs").expect("a key")..], "");
    let elsewhere = Place::new(&other, "lie-poisson", "[1, 0, 0]");
    let pairs = elsewhere.pairs(&draws.on_spheres(200), h);
    let learned = body.learn(h, &pairs, &polynomials(3, 4)).expect("pairs");
    let is_told = learned.advice.iter().any(|advice| {
        matches!(
            advice,
            LearnAdvice::OffLeaf { .. } | LearnAdvice::Unexplained { .. }
        )
    });
    assert!(is_told, "{:?}", learned.advice);
    // Half of them twice.
    let (mut before, mut after) = pairs;
    before.extend_from_within(..300);
    after.extend_from_within(..300);
    let learned = body
        .learn(h, &(before, after), &polynomials(3, 2))
        .expect("pairs");
    assert!(
        learned
            .advice
            .contains(&LearnAdvice::Duplicates { count: 100 })
    );
    assert_eq!(learned.pairs, 200);
}
