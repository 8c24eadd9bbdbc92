//! Which systems split, into what, and that the pieces' flows are exact.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use crate::common::{Problem, distance, gauss, largest, library, step, toda, volterra};
use leafwise_core::diagnostics::TensorDefect;
use leafwise_core::{BuildError, Convention, StepMap};
use leafwise_splitting::Splitting;

/// The systems that split, with the number of their pieces.
fn systems() -> Vec<(Problem, usize)> {
    vec![
        // H less |x|²/(2 I1): about two axes.
        (library("rigid-body"), 2),
        (library("lotka-volterra-periodic"), 3),
        (library("lotka-volterra"), 3),
        (library("heavy-top"), 4),
        (library("magnetic"), 3),
        (library("so4"), 5),
        (library("se3"), 4),
        (library("point-vortices"), 3),
        (volterra(8), 2),
        (toda(6), 2),
    ]
}

#[test]
fn hamiltonians_split_into_few_pieces() {
    for (problem, expected) in systems() {
        let splitting = Splitting::new(&problem.system()).expect("a system that splits");
        let formulas = splitting.formulas();
        println!(
            "{}: {} operations, {}",
            problem.id,
            splitting.operations().total(),
            formulas.join(" | ")
        );
        assert_eq!(formulas.len(), expected, "{}", problem.id);
    }
}

/// Merging looks only at coordinates that a new term can affect, so that a lattice takes a time
/// near that of its terms.
#[test]
fn a_lattice_of_256_sites_splits_into_even_and_odd() {
    let splitting = Splitting::new(&volterra(256).system()).expect("a system that splits");
    assert_eq!(splitting.pieces().len(), 2);
}

/// Every piece, as a system of its own, is one piece; its flow over a large step agrees with Gauss's
/// method of order 12, is a Poisson map and has the flow backwards as its inverse.
///
/// The oracle is good to 1e-14 relative; the tangent of the flow sums products of size ‖DΦ‖², the
/// inverse loses the growth of the flow: 64 units of round-off for each.
#[test]
fn flows_of_pieces_are_exact_and_poisson() {
    for (problem, _) in systems() {
        let splitting = Splitting::new(&problem.system()).expect("a system that splits");
        for formula in splitting.formulas() {
            let name = format!("{}: {formula}", problem.id);
            let system = problem.with_hamiltonian(&formula);
            let flow = Splitting::new(&system).expect("a piece splits");
            assert_eq!(flow.pieces().len(), 1, "{name}");
            let parameters = system.parameter_values();
            let t = 2.0 * problem.time_step;
            let exact = gauss(&system, &problem.initial, t, 20);
            let size = largest(&exact);
            let mut forward = flow.stepper(1, &parameters, 0.5, 2.0 * t);
            let end = step(forward.as_mut(), &problem.initial).expect("finite");
            let error = distance(&end, &exact) / size;
            let mut backward = flow.stepper(1, &parameters, 0.5, -2.0 * t);
            let back = step(backward.as_mut(), &end).expect("finite");
            let inverse = distance(&back, &problem.initial) / size;
            let mut instrument =
                TensorDefect::new(&system, &flow, &parameters, 1.0, t).expect("a tensor");
            let defect = instrument.measure(&problem.initial).expect("finite");
            let growth = largest(&defect.tangent);
            println!(
                "{name}: error {error:.1e}, inverse {inverse:.1e}, defect {:.1e}",
                defect.norm
            );
            assert!(error <= 64.0 * f64::EPSILON, "{name}: {error:e}");
            assert!(
                inverse <= 64.0 * f64::EPSILON * growth,
                "{name}: {inverse:e}"
            );
            let bound = 64.0 * f64::EPSILON * defect.scale * growth * growth;
            assert!(
                defect.norm <= bound,
                "{name}: {:e} > {bound:e}",
                defect.norm
            );
        }
    }
}

fn refusal(problem: &Problem) -> String {
    match Splitting::new(&problem.system()) {
        Err(BuildError::DoesNotFit { part, reason }) => {
            assert_eq!(part, "splitting");
            reason
        }
        other => panic!("{}: {other:?}", problem.id),
    }
}

/// Three waves: with K = coupling·x the n_k are elliptic functions. The gradient bracket: with
/// K = x1² the other two coordinates move as a nonlinear pendulum.
#[test]
fn a_hamiltonian_that_does_not_split_is_refused_with_its_term() {
    for (id, term, coordinate) in [
        ("three-wave", "`coupling*x`", " y "),
        ("gradient", "`w1*x1^2/2`", " x2 "),
    ] {
        let reason = refusal(&library(id));
        println!("{id}: {reason}");
        assert!(
            reason.contains(term) && reason.contains(coordinate),
            "{reason}"
        );
    }
    let mut problem = library("rigid-body");
    problem.hamiltonian = "x1^2/2 + (x1 + I2*x2)^2*x3/7 + sin(x1*x2)".to_owned();
    let reason = refusal(&problem);
    println!("{reason}");
    assert!(reason.contains("`2*I2*x1*x2*x3/7`"), "{reason}");
}

/// A square of a linear function is a rotation about a tilted axis, though its monomials are none.
#[test]
fn summands_that_flow_as_a_whole_are_kept_whole() {
    let mut problem = library("rigid-body");
    problem.hamiltonian = "(x1 + I2*x2 - x3/2)^2/3 + x3^2".to_owned();
    let splitting = Splitting::new(&problem.system()).expect("two rotations");
    println!("{:?}", splitting.formulas());
    assert_eq!(splitting.pieces().len(), 2);
}

/// The harmonic oscillator with either sign, and with none, of its constant: one formula.
#[test]
fn rotations_and_hyperbolic_motions_are_one_formula() {
    let problem = Problem {
        id: "oscillator",
        variables: vec!["q".to_owned(), "p".to_owned()],
        parameters: vec![("k".to_owned(), 1.0)],
        bracket: vec![("q".to_owned(), "p".to_owned(), "1".to_owned())],
        hamiltonian: "p^2/2 + k*q^2/2".to_owned(),
        casimirs: Vec::new(),
        convention: Convention::HamiltonianSecond,
        initial: vec![0.3, 1.1],
        time_step: 0.5,
    };
    let splitting = Splitting::new(&problem.system()).expect("a rotation");
    assert_eq!(splitting.pieces().len(), 1);
    for (k, expected) in [
        (
            4.0,
            [
                0.3 * libm::cos(1.0) + 0.55 * libm::sin(1.0),
                1.1 * libm::cos(1.0) - 0.6 * libm::sin(1.0),
            ],
        ),
        (0.0, [0.3 + 0.55, 1.1]),
        (
            -4.0,
            [
                0.3 * libm::cosh(1.0) + 0.55 * libm::sinh(1.0),
                1.1 * libm::cosh(1.0) + 0.6 * libm::sinh(1.0),
            ],
        ),
    ] {
        let end = step(
            splitting.stepper(1, &[k], 1.0, 0.5).as_mut(),
            &problem.initial,
        );
        assert!(
            distance(&end.expect("finite"), &expected) <= 4.0 * f64::EPSILON,
            "{k}"
        );
    }
}

/// Rates and squared frequencies that are functions of the state, y, of either sign or zero: no
/// division by them is exact, so the entire functions are used. Against Gauss's method; their
/// derivatives against the tensor.
#[test]
fn rates_that_do_not_divide_may_vanish() {
    let mut problem = Problem {
        id: "central",
        variables: ["q", "p", "y"].map(str::to_owned).into(),
        parameters: Vec::new(),
        bracket: vec![("q".to_owned(), "p".to_owned(), "1".to_owned())],
        hamiltonian: String::new(),
        casimirs: Vec::new(),
        convention: Convention::HamiltonianSecond,
        initial: Vec::new(),
        time_step: 0.5,
    };
    problem.parameters = vec![("a".to_owned(), 0.0)];
    for hamiltonian in ["y*q*p + p", "p^2/2 + y*q^2/2 + q", "a*q*p + y*p"] {
        problem.hamiltonian = hamiltonian.to_owned();
        let system = problem.system();
        let splitting = Splitting::new(&system).expect("one piece");
        assert_eq!(splitting.pieces().len(), 1);
        let mut instrument =
            TensorDefect::new(&system, &splitting, &[0.0], 1.0, 0.5).expect("a tensor");
        for y in [-1.3, 0.0, 1e-7, 0.9, 30.0] {
            problem.initial = vec![0.3, 1.1, y];
            let exact = gauss(&system, &problem.initial, 0.5, 40);
            let defect = instrument.measure(&problem.initial).expect("finite");
            let error = distance(&defect.next, &exact) / largest(&exact[..2]);
            println!(
                "{hamiltonian}, y = {y}: error {error:.1e}, defect {:.1e}",
                defect.norm
            );
            assert!(
                error <= 64.0 * f64::EPSILON,
                "{hamiltonian}, y = {y}: {error:e}"
            );
            let growth = largest(&defect.tangent);
            assert!(defect.norm <= 16.0 * f64::EPSILON * growth * growth);
        }
    }
}

/// A Hamiltonian of Casimirs moves nothing.
#[test]
fn casimirs_are_no_pieces() {
    let mut problem = library("rigid-body");
    problem.hamiltonian = "3 + I1".to_owned();
    let splitting = Splitting::new(&problem.system()).expect("nothing to split");
    assert!(splitting.pieces().is_empty());
    let system = problem.system();
    let mut stepper = splitting.stepper(1, &system.parameter_values(), 1.0, 0.1);
    assert_eq!(
        step(stepper.as_mut(), &problem.initial),
        Ok(problem.initial.clone())
    );
    assert!(step(stepper.as_mut(), &[1.0, f64::NAN, 0.0]).is_err());
}

/// H = Σ p²/2 + √(1 + S²), S = Σ_{i<j} (q_i − q_j)²: two pieces however many monomials S² has, and one step is the leapfrog written
/// by hand.
#[test]
fn functions_of_sums_over_pairs_are_one_piece() {
    const SITES: usize = 12;
    let mut pairs = Vec::new();
    for i in 0..SITES {
        for j in i + 1..SITES {
            pairs.push(format!("(q{i} - q{j})^2"));
        }
    }
    let kinetic: Vec<String> = (0..SITES).map(|i| format!("p{i}^2/2")).collect();
    let of = |letter: &'static str| (0..SITES).map(move |i| format!("{letter}{i}"));
    let q: Vec<f64> = (0..SITES).map(|i| libm::sin(i as f64)).collect();
    let p: Vec<f64> = (0..SITES)
        .map(|i| 0.1 * libm::cos(3.0 * i as f64))
        .collect();
    let problem = Problem {
        id: "a function of pairs",
        variables: of("q").chain(of("p")).collect(),
        parameters: Vec::new(),
        bracket: of("q")
            .zip(of("p"))
            .map(|(q, p)| (q, p, "1".to_owned()))
            .collect(),
        hamiltonian: format!(
            "{} + sqrt(1 + ({})^2)",
            kinetic.join(" + "),
            pairs.join(" + ")
        ),
        casimirs: Vec::new(),
        convention: Convention::HamiltonianSecond,
        initial: [q.clone(), p.clone()].concat(),
        time_step: 0.01,
    };
    let system = problem.system();
    let splitting = Splitting::new(&system).expect("a system that splits");
    assert_eq!(splitting.pieces().len(), 2);
    let h = problem.time_step;
    let mut stepper = splitting.stepper(1, &[], 1.0, h);
    let found = step(stepper.as_mut(), &problem.initial).expect("finite");
    let drift =
        |q: &mut [f64], p: &[f64], h: f64| q.iter_mut().zip(p).for_each(|(q, p)| *q += h * p);
    let kick = |q: &[f64], p: &mut [f64], h: f64| {
        let differences = |i: usize| q.iter().map(move |other| q[i] - other);
        let s: f64 = (0..SITES).flat_map(differences).map(|d| d * d / 2.0).sum();
        for (i, p) in p.iter_mut().enumerate() {
            let slope = 2.0 * differences(i).sum::<f64>() * s / libm::sqrt(1.0 + s * s);
            *p -= h * slope;
        }
    };
    let orders = [true, false].map(|drifts_first| {
        let (mut q, mut p) = (q.clone(), p.clone());
        if drifts_first {
            drift(&mut q, &p, h / 2.0);
            kick(&q, &mut p, h);
            drift(&mut q, &p, h / 2.0);
        } else {
            kick(&q, &mut p, h / 2.0);
            drift(&mut q, &p, h);
            kick(&q, &mut p, h / 2.0);
        }
        distance(&found, &[q, p].concat())
    });
    let error = orders[0].min(orders[1]);
    assert!(error <= 64.0 * f64::EPSILON * largest(&found), "{orders:?}");
}
