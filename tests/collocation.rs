//! Karasev's realization by collocation: its order in the number of nodes, its exactness, and the
//! fused step.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use leafwise::core::diagnostics::{RealizationInstrument, TensorDefect};
use leafwise::core::{
    Accuracy, Ends, Method, PartParameters, PoissonSystem, RealizationData, Registry, Walk,
    realization_evaluator,
};
use leafwise::prelude::SceneDocument;
use leafwise::scene::compose;
use leafwise_tests::library;
use leafwise_tests::numbers::{distance, largest};
use leafwise_tests::opaque::{values_only, with_derivatives};
use leafwise_tests::orders::measure;

fn collocated(system: &PoissonSystem, points: i64) -> Arc<dyn RealizationData> {
    let registry = Registry::with_builtin();
    let part = registry
        .realization("karasev-collocated")
        .expect("a built-in part");
    part.build(system, &PartParameters::new().with("points", points))
        .expect("nodes in range")
}

fn truncated(system: &PoissonSystem, n: i64) -> Arc<dyn RealizationData> {
    let registry = Registry::with_builtin();
    let part = registry
        .realization("karasev-truncated")
        .expect("a built-in part");
    part.build(system, &PartParameters::new().with("order", n))
        .expect("an order in range")
}

fn methods(system: &PoissonSystem, m: i64) -> (Method, Method) {
    let registry = Registry::with_builtin();
    let part = registry
        .dynamics("hamilton-jacobi")
        .expect("a built-in part");
    let dynamics = part
        .build(&PartParameters::new().with("order", m))
        .expect("an even order");
    let realization = collocated(system, 0);
    let fused = Method::compose(system, Arc::clone(&realization), Arc::clone(&dynamics));
    let generic = Method::compose_unfused(system, realization, dynamics);
    (
        fused.expect("a fused method"),
        generic.expect("a generic method"),
    )
}

/// α̂_ε(x, P).
fn source(
    realization: &Arc<dyn RealizationData>,
    parameters: &[f64],
    epsilon: f64,
    x: &[f64],
) -> Vec<f64> {
    let mut evaluator =
        realization_evaluator(realization.as_ref(), parameters, epsilon).expect("maps on T*M");
    let z: Vec<f64> = x.iter().chain(&P).copied().collect();
    let mut values = vec![0.0; 3 * x.len()];
    evaluator.values(&z, &mut values).expect("in the chart");
    let ends = Ends::of(&values);
    (0..x.len()).map(|i| ends.source(i)).collect()
}

const P: [f64; 3] = [0.3, -0.2, 0.1];

/// The bracket defect of α at q nodes is O(ε^{2q}); the next term is smaller by ε, or by ε² where
/// symmetry removes the odd one.
#[test]
fn the_bracket_defect_has_slope_2q() {
    for (id, largest_epsilon, gap) in [("rigid-body", 6.0, 2.0), ("lotka-volterra", 0.6, 1.0)] {
        let system = library(id).system;
        for q in 1..=6 {
            let realization = collocated(&system, q);
            assert_eq!(realization.accuracy(), Accuracy::Order(2 * q as usize - 1));
            let values = system.parameter_values();
            let mut instrument =
                RealizationInstrument::new(&system, &realization, &values).expect("numbers");
            let mut plateau = 0.0_f64;
            // The asymptotic regime: a defect below 1e-3 of the brackets.
            let points: Vec<_> = (0..336)
                .map(|k| largest_epsilon * libm::exp2(-f64::from(k) / 24.0))
                .filter_map(|epsilon| {
                    let error = instrument
                        .measure(epsilon, &[1.0, 3.0, 3.0], &P)
                        .expect("in the chart");
                    plateau = plateau.max(100.0 * f64::EPSILON * error.scale);
                    (error.source < 1e-3 * error.scale).then_some((epsilon, error.source))
                })
                .collect();
            let expected = 2.0 * q as f64;
            // The tolerance holds what the next term adds over the fitted range.
            let slope = measure(&points, plateau, gap).expect("points above round-off");
            println!("{id} q = {q}: slope {slope}");
            assert!(
                slope.slope.exponent > expected - slope.tolerance,
                "{id} q = {q}: {slope}: {points:?}"
            );
        }
    }
}

/// Y' = 1 + Y² of mean 0 is tan(s − ½): about the middle the field is even, and every second Legendre
/// coefficient vanishes. So it is for a coordinate that is small beside another.
#[test]
fn a_field_that_is_even_about_the_middle_takes_the_nodes_it_needs() {
    for (bracket, size) in [
        (r#"{ "q,p" = "1 + q^2" }"#, 1.0),
        (r#"{ "q,p" = "1e-4*(1 + 1e8*q^2)", "r,s" = "1" }"#, 1e-4),
    ] {
        let variables = if size == 1.0 { "q p" } else { "q p r s" };
        let variables: Vec<&str> = variables.split(' ').collect();
        let d = variables.len();
        let text = format!(
            "[system]\nvariables = {variables:?}\nbracket = {bracket}\nhamiltonian = \"p^2/2\"\n\
             [method]\nrealization = \"karasev-collocated\"\n\
             dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = 0.1\n\
             [run]\ninitial = {:?}\nsteps = 1\n",
            vec![0.0; d]
        );
        let document =
            SceneDocument::parse("even", &text, &Registry::with_builtin()).expect("a scene");
        let run = compose(&document, &Registry::with_builtin()).expect("a run");
        let realization = collocated(&run.system, 0);
        let mut evaluator =
            realization_evaluator(realization.as_ref(), &[], 1.0).expect("maps on T*M");
        let z: Vec<f64> = (0..2 * d)
            .map(|at| f64::from(u8::from(at >= d && at % 2 == 1)))
            .collect();
        let mut values = vec![0.0; 3 * d];
        evaluator.values(&z, &mut values).expect("in the chart");
        let ends = Ends::of(&values);
        let exact = size * libm::tan(0.5);
        let error = (ends.offset[0].abs() - exact).abs();
        assert!(error <= 16.0 * f64::EPSILON * exact, "{bracket}: {error:e}");
    }
}

/// With as many nodes as needed all three defects are round-off: 100 operations on the brackets.
#[test]
fn the_automatic_choice_is_exact() {
    for id in ["rigid-body", "lotka-volterra", "gradient"] {
        let problem = library(id);
        let values = problem.system.parameter_values();
        let realization = collocated(&problem.system, 0);
        let mut instrument =
            RealizationInstrument::new(&problem.system, &realization, &values).expect("numbers");
        for epsilon in [0.01, 0.1, 0.3] {
            let error = instrument
                .measure(epsilon, &problem.initial, &P)
                .expect("in the chart");
            println!("{id} eps = {epsilon}: {error:?}");
            let bound = 100.0 * f64::EPSILON * error.scale.max(epsilon);
            assert!(
                error.source < bound && error.target < bound,
                "{id}: {error:?}"
            );
            assert!(error.dual_pair < bound, "{id}: {error:?}");
        }
    }
}

/// Two solves of the same equations: each ends within a few ulp of the solution.
#[test]
fn the_fused_and_the_generic_step_agree() {
    for (id, m, t) in [
        ("rigid-body", 2, 0.1),
        ("rigid-body", 8, 0.1),
        ("lotka-volterra-periodic", 4, 0.05),
        ("heavy-top", 4, 0.1),
        ("gradient", 4, 0.1),
    ] {
        let problem = library(id);
        let values = problem.system.parameter_values();
        let (fused, generic) = methods(&problem.system, m);
        assert_eq!(
            (fused.path().as_str(), generic.path().as_str()),
            ("fused", "evaluators")
        );
        let mut a = Walk::new(&fused, &values, 1.0, t, &problem.initial);
        let mut b = Walk::new(&generic, &values, 1.0, t, &problem.initial);
        for _ in 0..10 {
            a.step().expect("a step");
            b.step().expect("a step");
        }
        let difference = distance(a.state(), b.state()) / largest(a.state());
        println!("{id} m = {m}: {difference:.1e}");
        assert!(
            difference < 10.0 * 16.0 * f64::EPSILON,
            "{id} m = {m}: {difference:e}"
        );
    }
}

/// A guiding centre's drift in a magnetic mirror, from the equations: B = 20 (−xz, −yz, 1 + z²), b = B/|B|,
/// B* = B + u ∇×b; {x_i, x_j} = −ε_ijk b_k/(b·B*), {x_i, u} = B*_i/(b·B*), H = u²/2 + |B|/20 (J. R. Cary,
/// A. J. Brizard, *Hamiltonian theory of guiding-center motion*, Rev. Mod. Phys. 81 (2009), section III).
fn guiding_centre() -> PoissonSystem {
    let field = ["(-20*x*z)", "(-20*y*z)", "(20*(1 + z^2))"];
    let [bx, by, bz] = field;
    let size = format!("sqrt({bx}^2 + {by}^2 + {bz}^2)");
    // ∇|B|, and ∇×b = (∇×B)/|B| − ∇|B| × B/|B|².
    let gradient = ["x*z^2", "y*z^2", "(x^2*z + y^2*z + 2*z*(1 + z^2))"]
        .map(|term| format!("(400*{term}/{size})"));
    let [gx, gy, gz] = &gradient;
    let curl = [
        format!("(20*y/{size} - ({gy}*{bz} - {gz}*{by})/{size}^2)"),
        format!("(-20*x/{size} - ({gz}*{bx} - {gx}*{bz})/{size}^2)"),
        format!("(0 - ({gx}*{by} - {gy}*{bx})/{size}^2)"),
    ];
    let unit = field.map(|component| format!("({component}/{size})"));
    let star: [String; 3] = std::array::from_fn(|i| format!("({} + u*{})", field[i], curl[i]));
    let along = format!(
        "({}*{} + {}*{} + {}*{})",
        unit[0], star[0], unit[1], star[1], unit[2], star[2]
    );
    let bracket = format!(
        r#""x,y" = "-{}/{along}", "y,z" = "-{}/{along}", "x,z" = "{}/{along}", "x,u" = "{}/{along}",
           "y,u" = "{}/{along}", "z,u" = "{}/{along}""#,
        unit[2], unit[0], unit[1], star[0], star[1], star[2]
    )
    .replace('\n', " ");
    let text = format!(
        "[system]\nvariables = [\"x\", \"y\", \"z\", \"u\"]\nbracket = {{ {bracket} }}\n\
         hamiltonian = \"u^2/2 + {size}/20\"\n\
         [method]\nrealization = \"karasev-collocated\"\n\
         dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = 0.1\n\
         [run]\ninitial = [0.3, 0.2, 0.1, 1.0]\nsteps = 1\n"
    );
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("guiding-centre", &text, &registry).expect("a scene");
    compose(&document, &registry).expect("a run").system
}

/// At typical steps the joint solve takes few evaluations, of V at every node and of θ once: Newton's method with
/// derivatives at one point for formulas, the acceleration for numbers, both from extrapolated curves. The bounds are
/// what 200 steps were measured to take, and half an evaluation; the plain iteration from a straight curve took 11 to 15.
#[test]
fn a_fused_step_takes_few_evaluations() {
    let [rigid_body, lotka_volterra, gradient] =
        ["rigid-body", "lotka-volterra-periodic", "gradient"].map(|id| library(id).system);
    let body = values_only(&rigid_body);
    let cases = [
        (rigid_body, vec![1.0, 1.5, -0.7], 2, 0.1, 4.5),
        (lotka_volterra, vec![1.0, 1.9, 0.5], 4, 0.05, 6.1),
        (gradient, vec![0.8, 0.5, -0.4], 4, 0.1, 5.4),
        (guiding_centre(), vec![0.3, 0.2, 0.1, 1.0], 2, 0.1, 4.5),
        (body, vec![1.0, 1.5, -0.7], 2, 0.1, 8.8),
    ];
    for (at, (system, initial, m, t, most)) in cases.into_iter().enumerate() {
        let (fused, _) = methods(&system, m);
        let values = system.parameter_values();
        let mut walk = Walk::new(&fused, &values, 1.0, t, &initial);
        (0..50).for_each(|_| walk.step().expect("a step"));
        let before = walk.statistics().evaluations;
        (0..200).for_each(|_| walk.step().expect("a step"));
        let mean = (walk.statistics().evaluations - before) as f64 / 200.0;
        println!("{at}: {mean} evaluations, {:?}", walk.statistics());
        assert!(mean <= most, "{at}: {mean} evaluations a step");
    }
}

/// Far from a fold a step over a system of numbers takes the evaluations of its solve alone: where the numbers offer
/// derivatives, and a branch could be followed, as many as where they offer none. The first step has no history to
/// start from, and follows its branch.
#[test]
fn steps_far_from_a_fold_follow_no_branch() {
    for (id, t) in [("rigid-body", 0.1), ("heavy-top", 0.05)] {
        let problem = library(id);
        let values = problem.system.parameter_values();
        let runs = [
            with_derivatives(&problem.system),
            values_only(&problem.system),
        ];
        let runs = runs.map(|system| {
            let (fused, _) = methods(&system, 2);
            let mut walk = Walk::new(&fused, &values, 1.0, t, &problem.initial);
            walk.step().expect("a step");
            let first = walk.statistics().evaluations;
            (0..500).for_each(|_| walk.step().expect("a step"));
            let later = walk.statistics().evaluations - first;
            (first, later, walk.state().to_vec())
        });
        println!("{id}: {runs:?}");
        let [derivatives, values] = runs;
        assert!(derivatives.0 > values.0, "{id}: the first step");
        assert_eq!(derivatives.1, values.1, "{id}: evaluations");
        assert_eq!(derivatives.2, values.2, "{id}: states");
    }
}

/// The step is a Poisson map: its tensor defect is round-off of the tensor's products with DΦ,
/// 64 u of the largest summand.
#[test]
fn collocated_steps_are_poisson_maps() {
    for (id, t) in [
        ("rigid-body", 0.1),
        ("lotka-volterra-periodic", 0.05),
        ("heavy-top", 0.1),
    ] {
        let problem = library(id);
        let values = problem.system.parameter_values();
        for m in [2, 4, 6, 8] {
            let (fused, generic) = methods(&problem.system, m);
            for method in [&fused, &generic] {
                let mut instrument = TensorDefect::new(&problem.system, method, &values, 1.0, t)
                    .expect("an instrument");
                let defect = instrument.measure(&problem.initial).expect("a step");
                let size = defect.tangent.iter().fold(1.0_f64, |s, v| s.max(v.abs()));
                let bound = 64.0 * f64::EPSILON * defect.scale * size * size;
                println!("{id} m = {m} {}: {:.1e}", method.path(), defect.norm);
                assert!(
                    defect.norm < bound,
                    "{id} m = {m}: {:e} > {bound:e}",
                    defect.norm
                );
            }
        }
    }
}

/// Collocation and truncation approximate one realization: they differ by O(εⁿ⁺¹), at least.
#[test]
fn truncations_approach_the_collocated_realization() {
    let problem = library("gradient");
    let system = &problem.system;
    let values = system.parameter_values();
    let exact = collocated(system, 0);
    for n in 1..=8 {
        let approximate = truncated(system, n);
        let points: Vec<_> = (0..20)
            .map(|k| 1.5 * libm::exp2(-f64::from(k) / 4.0))
            .map(|epsilon| {
                let [a, b] = [&exact, &approximate]
                    .map(|realization| source(realization, &values, epsilon, &problem.initial));
                (epsilon, distance(&a, &b))
            })
            .collect();
        let plateau = 20.0 * f64::EPSILON * largest(&problem.initial);
        let Some(slope) = measure(&points, plateau, 1.0) else {
            panic!("n = {n}: too few points above round-off: {points:?}");
        };
        println!("gradient n = {n}: slope {slope}");
        assert!(
            slope.slope.exponent > n as f64 + 0.7,
            "n = {n}: {slope}: {points:?}"
        );
    }
}

/// D²(λ·α̂) against fourth-order differences of λ·Dα̂ with steps of 2⁻⁸: they are exact to (2⁻⁸)⁴/30 of
/// its fourth derivative, a hundredfold its size at most, and to 2⁸ roundings of Dα̂.
#[test]
fn second_derivatives_are_exact_through_the_curve() {
    const STEP: f64 = 1.0 / 256.0;
    for id in [
        "rigid-body",
        "lotka-volterra-periodic",
        "three-wave",
        "heavy-top",
        "gradient",
    ] {
        let problem = library(id);
        let d = problem.initial.len();
        let parameters = problem.system.parameter_values();
        let p = (0..d).map(|i| 0.2 * libm::sin(1.0 + 2.3 * i as f64));
        let z: Vec<f64> = problem.initial.iter().copied().chain(p).collect();
        let covector: Vec<f64> = (0..d).map(|i| 1.0 / (1.0 + i as f64)).collect();
        let mut evaluator =
            realization_evaluator(collocated(&problem.system, 10).as_ref(), &parameters, 1.0)
                .expect("numbers");
        let mut hessian = vec![0.0; 4 * d * d];
        evaluator
            .hessian(&z, &covector, &mut hessian)
            .expect("second derivatives");
        let mut gradient = |at: usize, shift: f64| -> Vec<f64> {
            let mut moved = z.clone();
            moved[at] += shift;
            let mut tangents = vec![0.0; 4 * d * d];
            evaluator.jacobians(&moved, &mut tangents).expect("inside");
            let (target, increment) = tangents.split_at(2 * d * d);
            (0..2 * d)
                .map(|k| {
                    let rows = 0..d;
                    rows.map(|i| covector[i] * (target[2 * d * i + k] + increment[2 * d * i + k]))
                        .sum()
                })
                .collect()
        };
        let size = largest(&hessian);
        for at in 0..2 * d {
            let [near, back] = [STEP, -STEP].map(|shift| gradient(at, shift));
            let [far, far_back] = [2.0 * STEP, -2.0 * STEP].map(|shift| gradient(at, shift));
            let differences: Vec<f64> = (0..2 * d)
                .map(|k| {
                    let odd = 8.0 * (near[k] - back[k]) - (far[k] - far_back[k]);
                    odd / (12.0 * STEP)
                })
                .collect();
            let error = distance(&hessian[2 * d * at..][..2 * d], &differences);
            let bound = 100.0 / 30.0 * STEP * STEP * STEP * STEP * size + 256.0 * f64::EPSILON;
            assert!(
                error <= bound,
                "{id}, coordinate {at}: {error:e} > {bound:e}"
            );
        }
    }
}
