//! Functions of a squared angle s = θ², 0 ≤ θ < 2π, with all their derivatives.

use leafwise_expression::{AnalyticFunction, Arithmetic, Graph, Rational, Term};

/// c(s) = (1 − (θ/2) cot(θ/2))/θ², the even coefficient of the exponential chart, as code without calls.
///
/// One formula serves from s = 0 to the wall s = 4π². By Mittag-Leffler's expansion of the cotangent,
/// c(s) = Σ_{n≥1} 2/(4π²n² − s), a sum of positive terms without cancellation. The poles n = 1, 2 are taken one by one,
/// 4π² − s to more than a double. The others are a polynomial, even and odd powers apart: half as long a chain of
/// operations that wait for each other. Everywhere below the wall c is within 2 ulps, c′ within 4, c″ within 8; past it
/// the values mean nothing.
pub fn cotangent_coefficient(graph: &mut Graph, s: &Term) -> Term {
    let number = |value: f64| Rational::from_f64(value).expect("a finite number");
    let one = graph.one();
    let mut inverse_distance = |square: f64| {
        let wall = number(square * WALL);
        let distance = graph.combine(&[(wall, one.clone()), (-Rational::one(), s.clone())]);
        let inverse = graph.divide(&one, &distance);
        inverse.expect("the distance is not the number 0")
    };
    let (first, second) = (inverse_distance(1.0), inverse_distance(4.0));
    // 1/(w + l − s) = f − l f² with f = 1/(w − s), to more digits than f has.
    let lower = graph.multiply(&first, &first);
    let square = graph.multiply(s, s);
    let mut horner = |from: usize| {
        let mut coefficients = TAIL[from..].iter().step_by(2).rev();
        let last = number(*coefficients.next().expect("six coefficients"));
        let last = graph.constant(&last);
        coefficients.fold(last, |sum, c| {
            let rest = graph.multiply(&sum, &square);
            graph.combine(&[(number(*c), one.clone()), (Rational::one(), rest)])
        })
    };
    let (even, odd) = (horner(0), horner(1));
    let odd = graph.multiply(&odd, s);
    let two = Rational::from_integer(2);
    graph.combine(&[
        (two.clone(), first),
        (two.clone(), second),
        (-&(&two * &number(WALL_LOW)), lower),
        (Rational::one(), even),
        (Rational::one(), odd),
    ])
}

/// cos(θ/2), the scalar part of the quaternion of a rotation by θ. Past the chart's end at θ = 2π it stays −1, its
/// value there, so that a guard sees where the chart was left.
pub const HALF_COSINE: AnalyticFunction =
    AnalyticFunction::new("cos(r/2), r = sqrt(s)", half_cosine);

/// sin(θ/2)/θ, the vector part over the rotation vector; NaN outside [0, 4π²).
///
/// Its derivatives are ½ (−1/8)ᵏ j_k(z)/zᵏ at z = θ/2 with spherical Bessel functions j_k. Their series loses less than
/// a factor 8 to cancellation up to z = π (NIST DLMF, 10.51 and 10.53).
pub const HALF_SINE: AnalyticFunction = AnalyticFunction::new("sin(r/2)/r, r = sqrt(s)", half_sine);

/// 4π² as the sum of two doubles.
const WALL: f64 = 39.478_417_604_357_43;
const WALL_LOW: f64 = 2.506_118_203_495_884_5e-15;

/// Σ_{n≥3} 2/(4π²n² − s) on [0, 4π²] by powers of s: the polynomial through its values at the twelve Chebyshev nodes
/// (mpmath, 60 digits). Its errors are at most 2e-18 in c, 8e-18 in c′ and 1.4e-15 in c″.
const TAIL: [f64; 12] = [
    0.020007593556872226,
    2.5438120688625658e-05,
    5.584568390490224e-08,
    1.4088241576735347e-10,
    3.7567161522597697e-13,
    1.0280132230994054e-15,
    2.849960204599238e-18,
    7.959240343088898e-21,
    2.214566406277551e-23,
    6.624914069253056e-26,
    1.1769318588536008e-28,
    9.92019650226768e-31,
];

fn inside(s: f64) -> bool {
    (0.0..WALL).contains(&s)
}

fn half_cosine(order: u32, s: f64) -> f64 {
    match order {
        0 if s >= WALL => -1.0,
        0 => libm::cos(0.5 * libm::sqrt(s)),
        k => -0.25 * half_sine(k - 1, s),
    }
}

fn half_sine(order: u32, s: f64) -> f64 {
    if !inside(s) {
        return f64::NAN;
    }
    if order == 0 {
        let theta = libm::sqrt(s);
        return if theta == 0.0 {
            0.5
        } else {
            libm::sin(0.5 * theta) / theta
        };
    }
    // j_k(z)/zᵏ = Σ_m (−z²/2)ᵐ/(m! (2m+2k+1)!!) with z² = s/4.
    let x = s / 8.0;
    let mut series = 1.0;
    for m in (1..=SINE_TERMS).rev() {
        series = 1.0 - x * series / f64::from(m * (2 * m + 2 * order + 1));
    }
    let odd: f64 = (0..=order).map(|i| f64::from(2 * i + 1)).product();
    0.5 * power(-0.125, order) * series / odd
}

/// (π²/2)¹⁸/(18!·37!!) is below 1e-26.
const SINE_TERMS: u32 = 18;

fn power(base: f64, exponent: u32) -> f64 {
    (0..exponent).fold(1.0, |product, _| product * base)
}

#[cfg(test)]
#[allow(
    clippy::excessive_precision,
    reason = "values with more digits than a double holds, rounded once by the compiler"
)]
mod tests {
    use leafwise_expression::{Graph, Kernel, Term};

    use super::{HALF_COSINE, HALF_SINE, WALL, cotangent_coefficient};

    /// (k, s, c⁽ᵏ⁾(s)), computed with 60 digits from the nested sums (mpmath).
    const COTANGENT_VALUES: &[(u32, f64, f64)] = &[
        (0, 0.0, 0.08333333333333333333),
        (1, 0.0, 0.001388888888888888889),
        (2, 0.0, 0.00006613756613756613757),
        (0, 1e-08, 0.08333333334722222223),
        (1, 1e-08, 0.001388888889550264551),
        (2, 1e-08, 0.00006613756618716931219),
        (0, 0.1, 0.08347255373886546009),
        (1, 0.1, 0.001395527530861989881),
        (2, 0.1, 0.00006663611370310716373),
        (0, 4.0, 0.08947684601641732425),
        (1, 4.0, 0.0016992357303663318),
        (2, 4.0, 0.00009078316894333242116),
        (0, 16.0, 0.1197071942950357205),
        (1, 16.0, 0.003754856717835117477),
        (2, 16.0, 0.000310593636947341186),
        (0, 32.5, 0.3234437648986127771),
        (1, 32.5, 0.04122591460749703462),
        (2, 32.5, 0.01177251573994992514),
        (0, 39.4, 25.54245903934020239),
        (1, 39.4, 325.2393508333887915),
        (2, 39.4, 8295.055188262839911),
        (0, 39.4784, 113608.2743376415944),
        (1, 39.4784, 6453415682.39284795),
        (2, 39.4784, 733161174059731.9025),
    ];

    /// (k, s, dᵏ/dsᵏ cos(√s/2), dᵏ/dsᵏ sin(√s/2)/√s), 60 digits of their power series (mpmath).
    const HALF_VALUES: &[(u32, f64, f64, f64)] = &[
        (0, 0.0, 1.0, 0.5),
        (1, 0.0, -0.125, -0.02083333333333333333),
        (2, 0.0, 0.005208333333333333333, 0.0005208333333333333333),
        (5, 0.0, -3.229373346560846561e-8, -1.467896975709475709e-9),
        (0, 1e-20, 1.0, 0.5),
        (0, 1e-08, 0.9999999987500000003, 0.4999999997916666667),
        (1, 1e-08, -0.1249999999479166667, -0.020833333328125),
        (2, 1e-08, 0.00520833333203125, 0.000520833333240327381),
        (5, 1e-08, -3.229373346193872317e-8, -1.46789697556833177e-9),
        (0, 1.0, 0.8775825618903727161, 0.4794255386042030003),
        (1, 1.0, -0.1198563846510507501, -0.02031712882950832111),
        (2, 1.0, 0.005079282207377080277, 0.0005115970814997941443),
        (5, 1.0, -3.19285186290965374e-8, -1.45384124778195585e-9),
        (0, 9.0, 0.07073720166770291009, 0.3324983288680181436),
        (1, 9.0, -0.08312458221700453591, -0.01650720711300926048),
        (2, 9.0, 0.004126801778252315119, 0.000442185012806972971),
        (5, 9.0, -2.913035921702305706e-8, -1.345527497044842816e-9),
        (0, 25.0, -0.8011436155469337148, 0.1196944288207912988),
        (1, 25.0, -0.0299236072051978247, -0.01040532473188516312),
        (2, 25.0, 0.002601331182971290781, 0.0003250834118611315404),
        (5, 25.0, -2.414889506080140539e-8, -1.149631052776396295e-9),
        (0, 38.0, -0.9982371903219421642, 0.009627963464708052348),
        (1, 38.0, -0.002406990866177013087, -0.006694033666127357032),
        (2, 38.0, 0.001673508416531839258, 0.0002484027048064942704),
        (5, 38.0, -2.064532179294349433e-8, -1.009034964451945132e-9),
        (0, 39.4, -0.9999951275350520342, 0.0004973254905274272884),
        (1, 39.4, -0.0001243313726318568221, -0.006351457985508292671),
        (2, 39.4, 0.001587864496377073168, 0.000241017871449352161),
        (5, 39.4, -2.029465336775340788e-8, -9.94813387578402915e-10),
    ];

    /// c, c′ and c″ as code.
    fn cotangent_kernel() -> Kernel {
        let mut graph = Graph::new();
        let s = graph.input(0);
        let mut derivative = cotangent_coefficient(&mut graph, &s);
        let mut outputs: Vec<Term> = Vec::new();
        for _ in 0..3 {
            outputs.push(derivative.clone());
            derivative = graph.derivative(&derivative, 0).expect("code");
        }
        Kernel::compile(&graph, &outputs, 0, 1)
    }

    fn cotangent(kernel: &Kernel, s: f64) -> [f64; 3] {
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
        let mut values = [0.0; 3];
        kernel.evaluate(&mut workspace, &[s], &mut values);
        values
    }

    /// The poles' distance is exact to an ulp, its power has k more roundings; the sums have positive terms. At 0
    /// the polynomial is off by 5 ulp in c″.
    #[test]
    fn the_cotangent_s_function_is_accurate_from_0_to_the_wall() {
        let kernel = cotangent_kernel();
        for &(k, s, expected) in COTANGENT_VALUES {
            let found = cotangent(&kernel, s)[k as usize];
            let error = (found - expected).abs() / expected / f64::EPSILON;
            let most = if k < 2 { f64::from(2 * (k + 1)) } else { 8.0 };
            assert!(error <= most, "c^({k})({s}): {error} ulp");
        }
    }

    /// Two divisions, and a polynomial of twelve terms: nothing is called.
    #[test]
    fn the_cotangent_s_function_takes_few_operations() {
        let mut graph = Graph::new();
        let s = graph.input(0);
        let c = cotangent_coefficient(&mut graph, &s);
        let slope = graph.derivative(&c, 0).expect("code");
        let count = |outputs: &[Term]| Kernel::compile(&graph, outputs, 0, 1).step_operations();
        let (alone, both) = (count(std::slice::from_ref(&c)), count(&[c, slope]));
        assert_eq!((alone.functions, both.functions), (0, 0));
        assert_eq!((alone.divisions, both.divisions), (2, 2));
        assert_eq!((alone.total(), both.total()), (33, 69));
    }

    #[test]
    fn the_half_angle_functions_are_accurate_from_0_to_the_wall() {
        for &(k, s, cosine, sine) in HALF_VALUES {
            for (found, expected, function) in [
                (HALF_COSINE.derivative(k, s), cosine, HALF_COSINE),
                (HALF_SINE.derivative(k, s), sine, HALF_SINE),
            ] {
                // Where a function passes through 0 its error is that of its argument.
                let scale = expected.abs().max(0.25 * function.derivative(k, 0.0).abs());
                let error = (found - expected).abs() / scale / f64::EPSILON;
                assert!(error <= 8.0, "{function:?}^({k})({s}): {error} ulp");
            }
        }
    }

    #[test]
    fn outside_the_chart_there_is_no_value() {
        for k in 0..10 {
            for s in [-1.0, WALL, 40.0, 1e300, f64::INFINITY, f64::NAN] {
                assert!(HALF_SINE.derivative(k, s).is_nan());
            }
        }
        let last = f64::from_bits(WALL.to_bits() - 1);
        assert!(cotangent(&cotangent_kernel(), last)[0] > 1e14);
        assert_eq!(HALF_COSINE.derivative(0, WALL), -1.0);
        assert_eq!(HALF_COSINE.derivative(0, f64::INFINITY), -1.0);
    }
}
