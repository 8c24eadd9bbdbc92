//! Functions of a squared angle s = θ², 0 ≤ θ < 2π, with all their derivatives.

use leafwise_expression::AnalyticFunction;

/// c(s) = (1 − (θ/2) cot(θ/2))/θ², the even coefficient of the exponential chart.
///
/// One formula serves from s = 0 to the wall s = 4π²: by Mittag-Leffler's expansion of the
/// cotangent, c⁽ᵏ⁾(s) = Σ_{n≥1} 2 k!/(4π²n² − s)^{k+1}, a sum of positive terms without
/// cancellation. The poles n = 1, 2, 3 are taken one by one, 4π² − s to more than a double; the
/// others are a power series in s/(64π²) < 1/16. A few ulp everywhere; NaN outside
/// [0, 4π²).
pub const COTANGENT: AnalyticFunction =
    AnalyticFunction::new("(1 - (r/2) cot(r/2))/r^2, r = sqrt(s)", cotangent);

/// cos(θ/2), the scalar part of the quaternion of a rotation by θ; past the chart's end at θ = 2π
/// it stays −1, its value there, so that a guard sees where the chart was left.
pub const HALF_COSINE: AnalyticFunction =
    AnalyticFunction::new("cos(r/2), r = sqrt(s)", half_cosine);

/// sin(θ/2)/θ, the vector part over the rotation vector; NaN outside [0, 4π²).
///
/// Its derivatives are ½ (−1/8)ᵏ j_k(z)/zᵏ at z = θ/2 with spherical Bessel functions j_k, whose
/// series loses less than a factor 8 to cancellation up to z = π (NIST DLMF, 10.51 and 10.53).
pub const HALF_SINE: AnalyticFunction = AnalyticFunction::new("sin(r/2)/r, r = sqrt(s)", half_sine);

/// 4π² as the sum of two doubles.
const WALL: f64 = 39.478_417_604_357_43;
const WALL_LOW: f64 = 2.506_118_203_495_884_5e-15;

/// Σ_{n≥4} n^{−2j−2}.
const TAIL: [f64; 20] = [
    0.2838229557371153,
    0.0074775546987925125,
    0.0003463198719662865,
    1.86904076684668e-05,
    1.0775400096550504e-06,
    6.425188488937789e-08,
    3.903650576060287e-09,
    2.397730264529579e-10,
    1.482458312665928e-11,
    9.202674668690208e-13,
    5.727071724065572e-14,
    3.5697073824626706e-15,
    2.227216658569063e-16,
    1.3904796422568963e-17,
    8.684400483856269e-19,
    5.425318486488028e-20,
    3.3898532848726575e-21,
    2.1182705362215143e-22,
    1.3237641280762792e-23,
    8.272906386819633e-25,
];

/// Terms of the tail's power series, in pairs: the next one is 16⁻¹⁴ of the sum.
const TAIL_TERMS: usize = 14;

/// Derivatives from here on sum the poles directly: past the last one they are below an ulp.
const DIRECT: u32 = (TAIL.len() - TAIL_TERMS + 1) as u32;
const LAST_POLE: u32 = 40;

/// The coefficients of the k-th derivative of Σ_{n≥4} 1/(n² − w) = Σ_j TAIL_j wʲ in powers of w,
/// (j+1)…(j+k) TAIL_{j+k}: the tail of c⁽ᵏ⁾(s) is 2/(4π²)ᵏ⁺¹ of it at w = s/4π².
const DIFFERENTIATED: [[f64; TAIL_TERMS]; DIRECT as usize] = {
    let mut rows = [[0.0; TAIL_TERMS]; DIRECT as usize];
    let mut k = 0;
    while k < rows.len() {
        let mut j = 0;
        while j < TAIL_TERMS {
            let mut coefficient = TAIL[j + k];
            let mut factor = j + 1;
            while factor <= j + k {
                coefficient *= factor as f64;
                factor += 1;
            }
            rows[k][j] = coefficient;
            j += 1;
        }
        k += 1;
    }
    rows
};

fn inside(s: f64) -> bool {
    (0.0..WALL).contains(&s)
}

fn cotangent(order: u32, s: f64) -> f64 {
    if !inside(s) {
        return f64::NAN;
    }
    let factorial: f64 = (1..=order).map(f64::from).product();
    let pole = |n: u32| {
        let square = f64::from(n * n);
        let inverse = 1.0 / ((square * WALL - s) + square * WALL_LOW);
        2.0 * factorial * power(inverse, order + 1)
    };
    if order >= DIRECT {
        return (1..=LAST_POLE).rev().map(pole).sum();
    }
    // Even and odd powers apart: half as long a chain of operations that wait for each other.
    let w = s / WALL;
    let [square, mut even, mut odd] = [w * w, 0.0, 0.0];
    for pair in DIFFERENTIATED[order as usize].rchunks_exact(2) {
        odd = odd * square + pair[1];
        even = even * square + pair[0];
    }
    let tail = 2.0 * (even + odd * w) * power(1.0 / WALL, order + 1);
    tail + pole(3) + pole(2) + pole(1)
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
    use super::{COTANGENT, HALF_COSINE, HALF_SINE, WALL};

    /// (k, s, c⁽ᵏ⁾(s)), computed with 60 digits from the nested sums (mpmath).
    const COTANGENT_VALUES: &[(u32, f64, f64)] = &[
        (0, 0.0, 0.08333333333333333333),
        (1, 0.0, 0.001388888888888888889),
        (2, 0.0, 0.00006613756613756613757),
        (5, 0.0, 6.341028166424991822e-8),
        (9, 0.0, 7.892163533327494925e-11),
        (0, 1e-08, 0.08333333334722222223),
        (1, 1e-08, 0.001388888889550264551),
        (2, 1e-08, 0.00006613756618716931219),
        (5, 1e-08, 6.341028176060418132e-8),
        (9, 1e-08, 7.892163553318564416e-11),
        (0, 0.1, 0.08347255373886546009),
        (1, 0.1, 0.001395527530861989881),
        (2, 0.1, 0.00006663611370310716373),
        (5, 0.1, 6.438242431765680601e-8),
        (9, 0.1, 8.094887768647052597e-11),
        (0, 4.0, 0.08947684601641732425),
        (1, 4.0, 0.0016992357303663318),
        (2, 4.0, 0.00009078316894333242116),
        (5, 4.0, 1.203625592511884154e-7),
        (9, 4.0, 2.296946072933512416e-10),
        (0, 16.0, 0.1197071942950357205),
        (1, 16.0, 0.003754856717835117477),
        (2, 16.0, 0.000310593636947341186),
        (5, 16.0, 1.432871543890457261e-6),
        (9, 16.0, 1.425951665815849144e-8),
        (0, 32.5, 0.3234437648986127771),
        (1, 32.5, 0.04122591460749703462),
        (2, 32.5, 0.01177251573994992514),
        (5, 32.5, 0.0020781147471595117),
        (9, 32.5, 0.0026498633466372849),
        (0, 39.4, 25.54245903934020239),
        (1, 39.4, 325.2393508333887915),
        (2, 39.4, 8295.055188262839911),
        (5, 39.4, 1032119108.008704701),
        (9, 39.4, 82538642721324508.4),
        (0, 39.4784, 113608.2743376415944),
        (1, 39.4784, 6453415682.39284795),
        (2, 39.4784, 733161174059731.9025),
        (5, 39.4784, 8.062879607229667493e+30),
        (9, 39.4784, 2.538582318505998909e+53),
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

    /// k + 1 multiplications, k of the factorial, two divisions and four sums; the poles' distance
    /// is exact to an ulp.
    #[test]
    fn the_cotangent_s_function_is_accurate_from_0_to_the_wall() {
        let mut worst = 0.0_f64;
        for &(k, s, expected) in COTANGENT_VALUES {
            let error = (COTANGENT.derivative(k, s) - expected).abs() / expected / f64::EPSILON;
            worst = worst.max(error / f64::from(k + 1));
            assert!(error <= f64::from(4 + 2 * k), "c^({k})({s}): {error} ulp");
        }
        assert!(worst <= 2.0, "{worst} ulp an order");
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
                assert!(COTANGENT.derivative(k, s).is_nan());
                assert!(HALF_SINE.derivative(k, s).is_nan());
            }
        }
        let last = f64::from_bits(WALL.to_bits() - 1);
        assert!(COTANGENT.derivative(0, last) > 1e14);
        assert_eq!(HALF_COSINE.derivative(0, WALL), -1.0);
        assert_eq!(HALF_COSINE.derivative(0, f64::INFINITY), -1.0);
    }
}
