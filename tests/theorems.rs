//! Statements of the theory, each on random systems or on every system of the library.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use std::sync::Arc;

use leafwise::core::{Method, PoissonSystem, RealizationData, StepMap, Structure};
use leafwise::expression::{Arithmetic, Expression, Graph, Kernel, Rational, Ring, StepSize, Term};
use leafwise_hamilton_jacobi::coefficients::all_coefficients;
use leafwise_hamilton_jacobi::generating_function;
use leafwise_tests::methods::{increment, observe, run};
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::strategies::{decimal, polynomial, positive_state, state};
use leafwise_tests::systems::from_formulas;
use leafwise_tests::{library, method, realization};
use proptest::collection::vec;
use proptest::prelude::*;

/// Relative to the state, what two solves of one equation in different units may differ by: the
/// residual of each is a few hundred roundings of the increment, times a condition number below
/// ten at these steps; increments are below the state.
const TWO_SOLVES: f64 = 50.0 * UNIT_ROUNDOFF;

fn next(x: &[f64], increment: &[f64]) -> Vec<f64> {
    x.iter().zip(increment).map(|(x, i)| x + i).collect()
}

/// A method on a library system with a strategy for states where it is at home.
struct Subject {
    system: PoissonSystem,
    method: Method,
}

impl Subject {
    fn new(id: &str, n: usize, m: usize) -> Self {
        let system = library(id).system;
        let method = method(&system, n, m);
        Self { system, method }
    }

    fn step(&self, epsilon: f64, h: f64, x: &[f64]) -> Vec<f64> {
        increment(
            &self.method,
            &self.system.parameter_values(),
            (epsilon, h),
            x,
        )
        .expect("a step")
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// M_{ε,h} = M_{λε,h/λ} (paper, section 3.1): only t = εh matters.
    #[test]
    fn only_the_product_of_epsilon_and_h_matters(
        lambda in (-3.0..3.0_f64).prop_map(libm::exp2),
        t in 0.01..0.1_f64,
        body in state(3),
        species in positive_state(3),
        top in state(6),
    ) {
        for (id, x) in [("rigid-body", &body), ("gradient", &body), ("heavy-top", &top),
            ("lotka-volterra-periodic", &species), ("lotka-volterra", &species)] {
            let subject = Subject::new(id, 5, 4);
            let (one, other) = (subject.step(1.0, t, x), subject.step(lambda, t / lambda, x));
            let error = distance(&one, &other) / largest(x);
            prop_assert!(error <= TWO_SOLVES, "{id}: {error:e}");
        }
    }

    /// K-HJ is self-adjoint (paper, Corollary): Φ_{−h}∘Φ_h = id to the round-off of two solves.
    #[test]
    fn a_step_back_undoes_a_step(
        t in 0.01..0.1_f64,
        body in state(3),
        species in positive_state(3),
        top in state(6),
    ) {
        for (id, n, m, x) in [("rigid-body", 4, 2, &body), ("gradient", 3, 4, &body),
            ("heavy-top", 2, 6, &top), ("lotka-volterra-periodic", 5, 4, &species)] {
            let subject = Subject::new(id, n, m);
            let forth = subject.step(1.0, t, x);
            let back = subject.step(1.0, -t, &next(x, &forth));
            let error = forth.iter().zip(&back).map(|(f, b)| (f + b).abs()).fold(0.0, f64::max);
            prop_assert!(error <= TWO_SOLVES * largest(x), "{id}: {error:e}");
        }
    }

    /// With constant Π, S_1 alone gives the implicit midpoint rule, whatever n: β = y + ½ εhΠ∇H(y)
    /// and α = y − ½ εhΠ∇H(y), so that y is the mean of both.
    #[test]
    fn over_a_constant_tensor_m_2_is_the_implicit_midpoint_rule(
        entries in vec(decimal(), 10),
        hamiltonian in polynomial(&["x1", "x2", "x3", "x4", "x5"]),
        x in state(5),
        n in 1..=4_usize,
    ) {
        let names = ["x1", "x2", "x3", "x4", "x5"];
        let mut bracket = Vec::new();
        let mut rest = entries.iter();
        for i in 0..5 {
            for j in i + 1..5 {
                let value = rest.next().expect("ten entries");
                bracket.push((format!("{},{}", names[i], names[j]), format!("{value}")));
            }
        }
        let bracket: Vec<_> = bracket.iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
        let system = from_formulas(&names, &[], &bracket, &hamiltonian, &[]);
        let t = 0.01;
        let map = method(&system, n, 2);
        prop_assert_eq!(map.properties().structure, Structure::Exact);
        let found = increment(&map, &[], (0.5, t / 0.5), &x).expect("a step");
        let expected = midpoint_increment(&system, &x, t);
        let error = distance(&found, &expected) / largest(&x);
        prop_assert!(error <= TWO_SOLVES, "{error:e}: {found:?} {expected:?}");
    }

    /// β̂∘σ = α̂∘σ = id and β̂(x, p) = α̂(x, −p), both to the bit: the two differ in the signs of the
    /// same odd and even parts.
    #[test]
    fn the_section_is_one_and_the_target_is_the_source_of_minus_p(
        body in state(3),
        p in state(3),
        species in positive_state(3),
        epsilon in 0.01..0.3_f64,
    ) {
        for (id, x) in [("rigid-body", &body), ("gradient", &body),
            ("lotka-volterra-periodic", &species)] {
            let system = library(id).system;
            let part = realization(&system, 6);
            let mut ends = Ends::new(&system, &part);
            let mut z = vec![f64::NAN; part.space_dimension()];
            part.section(x, &mut z);
            let (source, target) = ends.at(epsilon, &z);
            prop_assert_eq!((&source, &target), (x, x));
            let minus: Vec<f64> = p.iter().map(|p| -p).collect();
            let (source, target) = ends.at(epsilon, &[x.as_slice(), &p].concat());
            let (mirrored_source, mirrored_target) =
                ends.at(epsilon, &[x.as_slice(), &minus].concat());
            // base + offset + increment is rounded twice.
            let bound = 4.0 * UNIT_ROUNDOFF * (largest(x) + largest(&source) + largest(&target));
            prop_assert!(distance(&target, &mirrored_source) <= bound);
            prop_assert!(distance(&source, &mirrored_target) <= bound);
            prop_assert!(distance(&source, &target) > 0.0, "p moves the point");
        }
    }

    /// |x|² on so(3)* is conserved by every truncation and every m: the even part of α̂ is
    /// orthogonal to its odd part. The round-off of one step, which enters C as 2 x·δ.
    #[test]
    fn on_so3_every_truncation_keeps_the_casimir(
        x in state(3),
        t in 0.01..0.3_f64,
        n in 1..=10_usize,
        m in prop::sample::select(vec![2_usize, 4, 6]),
    ) {
        let subject = Subject::new("rigid-body", n, m);
        let change = subject.step(1.0, t, &x);
        let casimir: f64 = x.iter().map(|x| x * x).sum();
        // C(x + δ) − C(x), formed without cancellation.
        let growth: f64 = x.iter().zip(&change).map(|(x, d)| d * (2.0 * x + d)).sum();
        prop_assert!(growth.abs() <= TWO_SOLVES * casimir, "n = {n}, m = {m}: {growth:e}");
    }
}

/// δ = −t Π∇H(x + δ/2), by fixed-point iteration.
fn midpoint_increment(system: &PoissonSystem, x: &[f64], t: f64) -> Vec<f64> {
    let kernel = system
        .expressions()
        .expect("formulas")
        .vector_field_kernel()
        .expect("a vector field");
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
    let mut increment = vec![0.0; x.len()];
    // The contraction is t/2 times the Jacobian of the field, here below 0.4.
    for _ in 0..80 {
        let middle: Vec<f64> = x.iter().zip(&increment).map(|(x, i)| x + 0.5 * i).collect();
        kernel.evaluate(&mut workspace, &middle, &mut increment);
        increment.iter_mut().for_each(|i| *i *= t);
    }
    increment
}

/// α̂ and β̂ of a realization, compiled.
struct Ends {
    kernel: Kernel,
    parameters: Vec<f64>,
    dimension: usize,
}

impl Ends {
    fn new(system: &PoissonSystem, part: &Arc<dyn RealizationData>) -> Self {
        let d = part.dimension();
        let mut graph = Graph::new();
        let z: Vec<Term> = (0..part.space_dimension())
            .map(|i| graph.input(i))
            .collect();
        let epsilon = graph.step_size(StepSize::Epsilon);
        let code = part.abilities().code().expect("code");
        let ends = code(&mut graph, &epsilon, &z).expect("code");
        let outputs = [ends.base, ends.offset, ends.increment].concat();
        let parameters = system.parameter_values();
        let kernel = Kernel::compile(&graph, &outputs, parameters.len(), z.len());
        Self {
            kernel,
            parameters,
            dimension: d,
        }
    }

    /// (α̂, β̂) at z.
    fn at(&mut self, epsilon: f64, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut workspace = self.kernel.workspace(1);
        self.kernel
            .prepare(&mut workspace, &self.parameters, &[epsilon], &[1.0]);
        let mut values = vec![0.0; 3 * self.dimension];
        self.kernel.evaluate(&mut workspace, z, &mut values);
        let (base, rest) = values.split_at(self.dimension);
        let (offset, increment) = rest.split_at(self.dimension);
        let target = next(base, offset);
        (next(&target, increment), target)
    }
}

/// Proposition 1, exactly: S_2, S_4, … are 0 in the ring. Functions in H or Π and dimension cost
/// terms, so that the last order differs.
#[test]
fn even_coefficients_vanish_identically() {
    for (id, last) in [
        ("rigid-body", 8),
        ("lotka-volterra", 8),
        ("lotka-volterra-periodic", 8),
        ("magnetic", 6),
        ("heavy-top", 6),
        ("se3", 6),
        ("so4", 6),
        ("three-wave", 6),
        ("gradient", 6),
        ("toda", 4),
        ("volterra-lattice", 6),
        ("point-vortices", 2),
    ] {
        let system = library(id).system;
        let part = realization(&system, 1);
        let series = part.abilities().series.expect("a series");
        let (_, all) = all_coefficients(&system, &series, last).expect("the exact algebra");
        let terms: Vec<usize> = all.iter().map(|s| s.terms().len()).collect();
        println!("{id}: terms of S_1 ... S_{last}: {terms:?}");
        assert!(terms[0] > 0, "{id}: S_1 = H");
        for l in (2..=last).step_by(2) {
            assert!(all[l - 1].is_zero(), "{id}: S_{l} = {:?}", all[l - 1]);
        }
    }
}

/// S_3 = (1/24) D²H(X_H, X_H) at ε = 1, exactly, in the ring.
#[test]
fn the_third_coefficient_is_the_hessian_of_h_along_its_field() {
    for id in [
        "rigid-body",
        "lotka-volterra-periodic",
        "heavy-top",
        "three-wave",
        "gradient",
    ] {
        let system = library(id).system;
        let part = realization(&system, 1);
        let series = part.abilities().series.expect("a series");
        let generating = generating_function(&system, &series, 4).expect("the exact algebra");
        let mut ring: Ring = generating.ring;
        let x: Vec<_> = (0..system.dimension()).map(|i| ring.variable(i)).collect();
        let gradient = generating.gradients[0].clone();
        let field = system
            .expressions()
            .expect("formulas")
            .apply_tensor(&mut ring, &x, &gradient)
            .expect("the exact algebra");
        let mut terms = vec![(-Rational::one(), generating.coefficients[1].clone())];
        for (i, slope) in gradient.iter().enumerate() {
            for (j, second) in ring
                .gradient(slope)
                .expect("derivatives")
                .iter()
                .enumerate()
            {
                let square = ring.multiply(&field[i], &field[j]);
                terms.push((Rational::new(1, 24), ring.multiply(second, &square)));
            }
        }
        let difference = ring.combine(&terms);
        assert!(difference.is_zero(), "{id}: {difference:?}");
    }
}

/// The value three independent derivations gave.
#[test]
fn the_seventh_coefficient_of_the_rigid_body_has_its_value() {
    let bracket = [("x1,x2", "-x3"), ("x2,x3", "-x1"), ("x3,x1", "-x2")];
    let system = from_formulas(
        &["x1", "x2", "x3"],
        &[],
        &bracket,
        "x1^2/2 + x2^2/1.5 + x3^2/2.5",
        &[],
    );
    let part = realization(&system, 1);
    let series = part.abilities().series.expect("a series");
    let generating = generating_function(&system, &series, 8).expect("the exact algebra");
    let point = [1, 3, 3].map(Rational::from_integer);
    let mut value = Rational::zero();
    for (monomial, coefficient) in generating.coefficients[3].terms() {
        let constant = coefficient.as_constant().expect("no parameters");
        value += &monomial
            .factors()
            .iter()
            .fold(constant, |product, &(symbol, exponent)| {
                &product * &point[symbol as usize].powi(exponent.into())
            });
    }
    assert_eq!(value, Rational::new(69_204_901, 265_781_250));
}

/// With linear H, H∘α − H∘β is the derivative of H along the curve in the direction dH: Π is
/// antisymmetric, so that every order of it vanishes (paper, Lotka–Volterra example). Round-off of
/// a compensated step is u times its increments; 100 steps of relative size below 1/2.
#[test]
fn a_linear_hamiltonian_is_conserved_at_every_n() {
    let problem = library("lotka-volterra");
    let energy: &Expression = problem
        .system
        .expressions()
        .expect("formulas")
        .hamiltonian();
    let start = observe(&problem.system, &[energy], &problem.initial)[0];
    for n in 1..=10 {
        let method = method(&problem.system, n, 2);
        let end = run(&problem.system, &method, (0.01, 2.0), 100, &problem.initial);
        let end = observe(
            &problem.system,
            &[energy],
            &end.expect("every step converges"),
        )[0];
        let drift = (end - start).abs() / start;
        println!("n = {n}: energy drift {drift:.1e} after 100 steps");
        assert!(drift <= 100.0 * 0.5 * UNIT_ROUNDOFF, "n = {n}: {drift:e}");
    }
}

/// The claims above take a method's dimension from its realization.
#[test]
fn a_method_has_the_dimension_of_its_system() {
    for id in ["rigid-body", "heavy-top", "three-wave"] {
        let subject = Subject::new(id, 2, 2);
        assert_eq!(subject.method.dimension(), subject.system.dimension());
    }
}
