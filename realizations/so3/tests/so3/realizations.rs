//! Claims about the maps: dual pairs, sections, charts that agree, Karasev's series.

use std::f64::consts::TAU;

use crate::common::{
    UNIT, all, body, bracket, constant, distance, ends_at, largest, momentum, norm, on_cotangent,
    parts_at, state, system,
};
use leafwise_core::Convention;
use leafwise_core::diagnostics::{RealizationInstrument, fit_slope};
use leafwise_core::realization::RealizationData;
use leafwise_expression::Expression;
use leafwise_karasev::TruncatedKarasev;
use leafwise_so3::{Chart, So3Exponential, So3Group};
use proptest::prelude::*;

/// 0.9 of the exponential chart's radius; the Cayley chart has none.
const LONGEST: f64 = 0.9 * TAU;

/// The brackets' errors over the size of what they sum: |α_x| |α_p| against the brackets alone
/// grows to a few tens towards the wall.
const RELATIVE: f64 = 1e-13;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// α Poisson, β anti-Poisson, {α_i, β_j} = 0, for every sign and factor of the tensor.
    #[test]
    fn every_realization_is_an_exact_dual_pair(
        x in state(),
        q in momentum(1e-3, LONGEST),
        epsilon in 0.05..2.0_f64,
    ) {
        let p: Vec<f64> = q.iter().map(|q| q / epsilon).collect();
        for (lambda, convention, factor) in [
            (constant(1, 1), Convention::HamiltonianFirst, 1.0),
            (constant(1, 1), Convention::HamiltonianSecond, 1.0),
            (constant(-5, 2), Convention::HamiltonianFirst, 2.5),
            (Expression::Parameter(0), Convention::HamiltonianFirst, 1.5),
        ] {
            let system = system(3, bracket(&lambda), convention).expect("a system");
            let p: Vec<f64> = p.iter().map(|p| p / factor).collect();
            for realization in all(&system) {
                let seen = on_cotangent(&realization);
                let mut instrument =
                    RealizationInstrument::new(&system, &seen, &[1.5]).expect("code");
                let error = instrument.measure(epsilon, &x, &p).expect("inside the chart");
                let worst = error.source.max(error.target).max(error.dual_pair) / error.scale;
                prop_assert!(worst <= RELATIVE, "{}: {error:?}", realization.describe());
            }
        }
    }

    /// α∘σ = β∘σ = id to the bit; β(x, p) = α(x, −p) to the roundings of base + offset + increment.
    #[test]
    fn the_section_is_one_and_the_target_is_the_source_of_minus_p(
        x in state(),
        p in momentum(1e-3, LONGEST),
    ) {
        for realization in all(&body()) {
            let mut z = vec![f64::NAN; realization.space_dimension()];
            realization.section(&x, &mut z);
            for end in ends_at(realization.as_ref(), 1.0, &z) {
                prop_assert_eq!(&end, &x);
            }
            let seen = on_cotangent(&realization);
            let minus: Vec<f64> = p.iter().map(|p| -p).collect();
            let [source, target] = ends_at(seen.as_ref(), 1.0, &[x.as_slice(), &p].concat());
            let [mirrored, mirrored_target] =
                ends_at(seen.as_ref(), 1.0, &[x.as_slice(), &minus].concat());
            // The group multiplies out a rotation: a dozen roundings instead of three.
            let bound = 16.0 * UNIT * (largest(&x) + largest(&source) + largest(&target));
            prop_assert!(distance(&target, &mirrored) <= bound);
            prop_assert!(distance(&source, &mirrored_target) <= bound);
            prop_assert!(distance(&source, &target) > 0.0, "p moves the point");
        }
    }

    /// α∘χ and β∘χ of the group are the maps on T*M, and its points have unit quaternions; the
    /// condition of the exponential chart in θ is below 20 at 0.9 of its radius.
    #[test]
    fn the_group_through_its_chart_is_the_realization_on_the_cotangent_bundle(
        x in state(),
        p in momentum(1e-6, LONGEST),
        epsilon in 0.5..1.0_f64,
    ) {
        let z = [x.as_slice(), &p].concat();
        for chart in [Chart::Exponential, Chart::Cayley] {
            let flat = chart.realize(&body()).expect("so(3)*");
            let group: std::sync::Arc<dyn RealizationData> =
                std::sync::Arc::new(So3Group::new(&body(), chart).expect("so(3)*"));
            let expected = ends_at(flat.as_ref(), epsilon, &z);
            let found = ends_at(on_cotangent(&group).as_ref(), epsilon, &z);
            let scale = largest(&x) + largest(&expected[0]) + largest(&expected[1]);
            for (found, expected) in found.iter().zip(&expected) {
                let error = distance(found, expected) / scale;
                prop_assert!(error <= 64.0 * UNIT, "{chart:?}: {error:e}");
            }
            // The increment is of the size of the step, and so is its error.
            let increments = [
                parts_at(flat.as_ref(), epsilon, &z),
                parts_at(on_cotangent(&group).as_ref(), epsilon, &z),
            ]
            .map(|[_, _, increment]| increment);
            let size = scale * epsilon * norm(&p);
            let error = distance(&increments[0], &increments[1]) / size;
            prop_assert!(error <= 64.0 * UNIT, "{chart:?}: increment {error:e}");
        }
    }

    /// Beyond order 24 the series adds (θ/2π)²⁶ of x: nothing at θ ≤ 1.
    #[test]
    fn the_exponential_chart_is_karasev_s_series_summed(
        x in state(),
        p in momentum(1e-9, 1.0),
    ) {
        let z = [x.as_slice(), &p].concat();
        let flat = So3Exponential::new(&body()).expect("so(3)*");
        for n in [24, 30] {
            let series = TruncatedKarasev::new(&body(), n).expect("an order");
            let (found, expected) = (parts_at(&flat, 1.0, &z), parts_at(&series, 1.0, &z));
            for (found, expected) in found.iter().zip(&expected) {
                let error = distance(found, expected) / (norm(&x) * norm(&p));
                prop_assert!(error <= 8.0 * UNIT, "n = {n}: {error:e}");
            }
        }
    }
}

#[test]
fn karasev_s_truncations_approach_the_exponential_chart_at_order_n_plus_1_or_better() {
    let flat = So3Exponential::new(&body()).expect("so(3)*");
    let (x, p) = ([1.0, 3.0, 3.0], [0.3, -0.2, 0.1]);
    for n in 1..=12 {
        let series = TruncatedKarasev::new(&body(), n).expect("an order");
        let points: Vec<(f64, f64)> = (0..16)
            .map(|k| 10.0 * libm::exp2(-0.25 * f64::from(k)))
            .map(|epsilon| {
                let z = [x, p].concat();
                let [found, _] = ends_at(&series, epsilon, &z);
                let [expected, _] = ends_at(&flat, epsilon, &z);
                (epsilon, distance(&found, &expected))
            })
            .collect();
        let slope = fit_slope(&points, 1e3 * UNIT).expect("points above round-off");
        println!(
            "n = {n}: slope {:.3} from {} points",
            slope.exponent, slope.points
        );
        // The next term (θ/2π)² larger makes the fitted slope the larger.
        assert!(slope.exponent >= (n + 1) as f64 - 0.05, "{n}: {slope:?}");
    }
}

#[test]
fn the_errors_of_the_dual_pairs() {
    let system = body();
    let x = [1.0, 1.5, -0.7];
    for realization in all(&system) {
        let seen = on_cotangent(&realization);
        let mut instrument = RealizationInstrument::new(&system, &seen, &[1.5]).expect("code");
        for radius in [1e-8, 1e-3, 0.1, 0.5, 0.9] {
            let direction = [0.48, -0.64, 0.6];
            let p: Vec<f64> = direction.iter().map(|d| d * radius * TAU).collect();
            let error = instrument.measure(1.0, &x, &p).expect("inside the chart");
            println!(
                "{} at {radius} of 2 pi: source {:.1e}, target {:.1e}, dual pair {:.1e} of {:.1}",
                realization.describe(),
                error.source,
                error.target,
                error.dual_pair,
                error.scale
            );
            let worst = error.source.max(error.target).max(error.dual_pair);
            assert!(worst <= RELATIVE * error.scale, "{error:?}");
        }
    }
}
