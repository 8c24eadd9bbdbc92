//! The realization of a linear tensor is exact up to its wall, and Karasev's.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers are shown with --nocapture"
)]

use std::sync::Arc;

use crate::common::{ALGEBRAS, algebra};
use leafwise_core::diagnostics::fit_slope;
use leafwise_core::{BuildError, PoissonSystem, RealizationData, StepError};
use leafwise_karasev::TruncatedKarasev;
use leafwise_lie_poisson::LiePoisson;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::realizations::{
    assert_dual_pair, assert_orders, assert_poisson_steps, dual_pair_error,
    inversion_and_section_error, source_and_target,
};
use leafwise_tests::systems::from_formulas;
use proptest::collection::vec;
use proptest::prelude::*;

fn realization(system: &PoissonSystem) -> Arc<dyn RealizationData> {
    Arc::new(LiePoisson::new(system).expect("a linear or affine tensor"))
}

/// Z = Π(·)p column by column from the tensor's formulas.
fn coadjoint(system: &PoissonSystem, p: &[f64]) -> Vec<Vec<f64>> {
    let d = p.len();
    let formulas: Vec<_> = system
        .expressions()
        .expect("formulas")
        .tensor()
        .values()
        .collect();
    let kernel = system
        .expressions()
        .expect("formulas")
        .observable_kernel(&formulas)
        .expect("code");
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &system.parameter_values(), &[1.0], &[1.0]);
    let mut values = vec![0.0; formulas.len()];
    let mut columns = Vec::with_capacity(d);
    for k in 0..d {
        let unit: Vec<f64> = (0..d).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
        kernel.evaluate(&mut workspace, &unit, &mut values);
        let mut column = vec![0.0; d];
        for (&(i, j), value) in system
            .expressions()
            .expect("formulas")
            .tensor()
            .keys()
            .zip(&values)
        {
            column[i] += value * p[j];
            column[j] -= value * p[i];
        }
        columns.push(column);
    }
    columns
}

/// Shortens p to at most `fraction` of the chart's radius along it: eigenvalues are linear in p.
fn inside(
    system: &PoissonSystem,
    realization: &dyn RealizationData,
    fraction: f64,
    p: Vec<f64>,
) -> Vec<f64> {
    let x = vec![1.0; p.len()];
    match source_and_target(system, realization, 1.0, &x, &p) {
        Ok(_) => p,
        Err(StepError::LeftChart { ratio }) => p.iter().map(|p| p * fraction / ratio).collect(),
        Err(error) => panic!("{error}"),
    }
}

fn point() -> impl Strategy<Value = (usize, Vec<f64>, Vec<f64>, f64)> {
    let signed = || (0.2..2.0_f64, any::<bool>()).prop_map(|(v, s)| if s { -v } else { v });
    (
        0..ALGEBRAS.len(),
        vec(signed(), 10),
        vec(-8.0..8.0_f64, 10),
        0.05..1.0_f64,
    )
}

proptest! {
    #[test]
    fn the_maps_are_a_dual_pair((at, x, p, scale) in point()) {
        let system = algebra(ALGEBRAS[at]);
        let d = system.dimension();
        let realization = realization(&system);
        let p = inside(&system, realization.as_ref(), 0.9, p[..d].to_vec());
        let p: Vec<f64> = p.iter().map(|p| scale * p).collect();
        let error = dual_pair_error(&system, &realization, 1.0, &x[..d], &p);
        let error = error.expect("inside");
        prop_assert!(error <= 1e-13, "{}: {error:e} at {p:?}", ALGEBRAS[at]);
        let error = inversion_and_section_error(&system, realization.as_ref(), 1.0, &x[..d], &p);
        prop_assert!(error.expect("inside") <= 16.0 * UNIT_ROUNDOFF);
    }

    /// x = ∫₀¹ e^{sZ} α ds = Σ Zᵏ/(k+1)! α, the mean of the curve, summed as it stands.
    #[test]
    fn the_source_starts_a_curve_of_mean_x((at, x, p, scale) in point()) {
        let system = algebra(ALGEBRAS[at]);
        let d = system.dimension();
        let realization = realization(&system);
        let p = inside(&system, realization.as_ref(), 0.9, p[..d].to_vec());
        let p: Vec<f64> = p.iter().map(|p| scale * p).collect();
        let map = coadjoint(&system, &p);
        let ends = source_and_target(&system, realization.as_ref(), 1.0, &x[..d], &p);
        let (alpha, beta) = ends.expect("inside");
        let (mut term, mut mean, mut end) = (alpha.clone(), alpha.clone(), alpha.clone());
        // Round-off of the powers of Z, normal or not: e^‖Z‖ ‖α‖.
        let norm = largest((0..d).map(|i| (0..d).map(|j| map[j][i].abs()).sum::<f64>()));
        let bound = 64.0 * UNIT_ROUNDOFF * libm::exp(norm) * largest(alpha.clone());
        for k in 1..200 {
            let factor = 1.0 / f64::from(k);
            let image = |i: usize| (0..d).map(|j| map[j][i] * term[j]).sum::<f64>();
            term = (0..d).map(|i| factor * image(i)).collect();
            for i in 0..d {
                mean[i] += term[i] / f64::from(k + 1);
                end[i] += term[i];
            }
        }
        prop_assert!(distance(&mean, &x[..d]) <= bound, "{}: {mean:?} {x:?}", ALGEBRAS[at]);
        prop_assert!(distance(&end, &beta) <= bound, "{}: {end:?} {beta:?}", ALGEBRAS[at]);
    }
}

/// Rodrigues' formula with its coefficient c = (1 − (θ/2)cot(θ/2))/θ² is the closed form on so(3)*,
/// where Π(x)p = x × p.
#[test]
fn on_so3_it_is_the_exponential_chart() {
    let system = algebra("rigid-body");
    let realization = realization(&system);
    let x = [1.0, 3.0, -2.0];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    for theta in [0.5, 2.0, 4.0, 6.0] {
        let p = [0.48 * theta, -0.6 * theta, 0.64 * theta];
        let c = (1.0 - theta / 2.0 / libm::tan(theta / 2.0)) / (theta * theta);
        let once = cross(x, p);
        let twice = cross(once, p);
        let expected: Vec<f64> = (0..3)
            .map(|i| x[i] - 0.5 * once[i] + c * twice[i])
            .collect();
        let (alpha, _) =
            source_and_target(&system, realization.as_ref(), 1.0, &x, &p).expect("inside");
        let sine = libm::sin(theta / 2.0);
        let bound = 16.0 * UNIT_ROUNDOFF * largest(alpha.clone()) / (sine * sine).min(0.1);
        assert!(
            distance(&alpha, &expected) <= bound,
            "θ = {theta}: {alpha:?} {expected:?}"
        );
    }
}

#[test]
fn the_wall_is_an_error_with_its_distance() {
    let system = algebra("rigid-body");
    let realization = realization(&system);
    let at = |theta: f64| {
        source_and_target(
            &system,
            realization.as_ref(),
            theta,
            &[1.0, 3.0, 3.0],
            &[0.0, 1.0, 0.0],
        )
    };
    assert!(at(6.2).is_ok());
    let Err(StepError::LeftChart { ratio }) = at(9.0) else {
        panic!("{:?}", at(9.0));
    };
    assert!(
        (ratio - 9.0 / (2.0 * std::f64::consts::PI)).abs() <= 1e-14,
        "{ratio}"
    );
    assert!(matches!(at(f64::NAN), Err(StepError::NonFinite { .. })));
    assert!(matches!(
        at(1e200),
        Err(StepError::NonFinite { .. } | StepError::LeftChart { .. })
    ));
}

/// On sl(2)* with p along h the eigenvalues of Z are 0 and ±2|p|, real: α = (h, ±z/(e^z − 1) …).
#[test]
fn real_eigenvalues_are_harmless() {
    let system = algebra("sl2");
    let realization = realization(&system);
    let x = [0.3, 1.0, -2.0];
    for p in [1.0, 5.0, 20.0, 60.0] {
        let (alpha, _) = source_and_target(&system, realization.as_ref(), 1.0, &x, &[p, 0.0, 0.0])
            .expect("no wall");
        // {e, h} = −2e: Z e = −2p e, Z f = 2p f.
        let function = |z: f64| z / libm::expm1(z);
        let expected = [x[0], x[1] * function(-2.0 * p), x[2] * function(2.0 * p)];
        // The even part of α nearly cancels its odd one where z is large: relative to their size.
        let bound = 64.0 * UNIT_ROUNDOFF * 2.0 * p * 2.0;
        assert!(
            distance(&alpha, &expected) <= bound,
            "p = {p}: {alpha:?} {expected:?}"
        );
    }
}

/// |α_trunc,n − α| ∝ ε^{n+1}, or faster where a coefficient vanishes.
#[test]
fn truncations_approach_it_with_their_order() {
    for name in ALGEBRAS {
        let system = algebra(name);
        let d = system.dimension();
        let exact = realization(&system);
        let x: Vec<f64> = (0..d)
            .map(|i| 1.0 + 0.5 * libm::sin(2.3 * i as f64))
            .collect();
        let p: Vec<f64> = (0..d).map(|i| 0.8 * libm::cos(1.9 * i as f64)).collect();
        let mut slopes = Vec::new();
        for n in 1..=12 {
            let truncated = TruncatedKarasev::new(&system, n).expect("an order");
            let errors: Vec<(f64, f64)> = (0..8)
                .map(|k| {
                    let epsilon = 1.5 * libm::exp2(-0.4 * f64::from(k));
                    let sources = [exact.as_ref(), &truncated].map(|realization| {
                        source_and_target(&system, realization, epsilon, &x, &p)
                            .expect("inside")
                            .0
                    });
                    (epsilon, distance(&sources[0], &sources[1]))
                })
                .collect();
            match fit_slope(&errors, 1e3 * UNIT_ROUNDOFF * largest(x.clone())) {
                Some(slope) => {
                    slopes.push(format!("{:.2}", slope.exponent));
                    let least = (n + 1) as f64 - 3.0 * slope.standard_error - 0.1;
                    assert!(
                        slope.exponent >= least,
                        "{name}, n = {n}: {slope:?} {errors:?}"
                    );
                }
                // Z² = 0 on the Heisenberg algebra: every truncation is exact.
                None => {
                    slopes.push("-".to_owned());
                    let roundoff = 64.0 * UNIT_ROUNDOFF * largest(x.clone());
                    let exact = errors.iter().all(|e| e.1 <= roundoff);
                    assert!(exact || n >= 11, "{name}, n = {n}: {errors:?}");
                }
            }
        }
        println!(
            "{name}: slopes of the truncations n = 1 … 12: {}",
            slopes.join(" ")
        );
    }
}

#[test]
fn an_entry_that_is_not_affine_is_named() {
    for entry in ["x*y", "sin(x)", "1/x"] {
        let bracket = [("y,z", "y"), ("x,y", entry)];
        let system = from_formulas(&["x", "y", "z"], &[], &bracket, "x", &[]);
        let refusal = LiePoisson::new(&system).expect_err("not affine");
        let BuildError::DoesNotFit { part, reason } = refusal else {
            panic!("{refusal:?}");
        };
        assert_eq!(part, "lie-poisson");
        assert!(reason.contains("{x, y}"), "{reason}");
    }
}

/// Affine tensors by their linear extension: so(3)* about another origin, a central charge that only the constants show, and a
/// charge in the plane whose field grows along x, v = (−y', x') in the frame of the paper.
fn affine() -> [PoissonSystem; 3] {
    [
        from_formulas(
            &["x", "y", "z"],
            &[("a", 0.7)],
            &[("x,y", "-z - a"), ("y,z", "-x + 1/2"), ("z,x", "-y")],
            "x^2/2 + y^2/3 + z^2/5 + x*y*z/7",
            &[("spin", "(x - 1/2)^2 + y^2 + (z + a)^2")],
        ),
        from_formulas(
            &["x", "y", "z"],
            &[("a", 0.7)],
            &[("x,y", "a"), ("x,z", "y")],
            "x^2/2 + y^2/3 + z^2/5 + x*y*z/7",
            &[],
        ),
        from_formulas(
            &["x", "y", "u", "v"],
            &[],
            &[("x,u", "-1"), ("y,v", "-1"), ("u,v", "-1 - x/2")],
            "(u^2 + v^2)/2 + x^2/4 + x*y/8",
            &[],
        ),
    ]
}

#[test]
fn affine_tensors_have_exact_realizations() {
    for system in affine() {
        let exact = realization(&system);
        assert_dual_pair(&system, &exact, (-1.0..1.0, -0.6..0.6, 0.01..1.0), 16.0);
        assert_poisson_steps(&system, &exact, 0.2..1.0, 0.05);
    }
    let system = &affine()[2];
    let orders = [
        (2, [40, 57, 80, 113]),
        (4, [20, 28, 40, 57]),
        (6, [12, 16, 22, 30]),
    ];
    assert_orders(
        system,
        &realization(system),
        (&[0.5, 0.2, -0.3, 0.7], 1.0),
        &orders,
    );
}

/// A shift of the origin is a shift of α, and what is constant is not for this realization.
#[test]
fn the_affine_rotation_is_the_shifted_one() {
    let shifted = &affine()[0];
    let plain = from_formulas(
        &["x", "y", "z"],
        &[("a", 0.7)],
        &[("x,y", "-z"), ("y,z", "-x"), ("z,x", "-y")],
        "x",
        &[],
    );
    let (x, p, origin) = ([0.4, -0.3, 0.9], [0.5, 0.8, -0.2], [0.5, 0.0, -0.7]);
    let at: Vec<f64> = (0..3).map(|i| x[i] - origin[i]).collect();
    let here = source_and_target(shifted, realization(shifted).as_ref(), 0.7, &x, &p);
    let there = source_and_target(&plain, realization(&plain).as_ref(), 0.7, &at, &p);
    let (here, there) = (here.expect("inside"), there.expect("inside"));
    for i in 0..3 {
        for (here, there) in [(here.0[i], there.0[i]), (here.1[i], there.1[i])] {
            assert!(
                (here - there - origin[i]).abs() < 1e-15,
                "{i}: {here} {there}"
            );
        }
    }
    let constant = from_formulas(&["x", "y"], &[], &[("x,y", "2")], "x", &[]);
    let refused = LiePoisson::new(&constant).expect_err("constant");
    assert!(
        refused.to_string().contains("the tensor is constant"),
        "{refused}"
    );
}
