//! Every function has the bits of `libm` on every instruction set of this machine; pairs of our own are as
//! accurate as they say.

use std::f64::consts::{FRAC_PI_4, LN_2};

use super::lanes::{Elementary, ElementaryPair, First, Lanes, PairLanes, Second};
use super::{
    Atan, Cos, Exp, Ln, Mirrored, Roots, Sin, SinCos, Tan, Turn, atan_lanes, cos_lanes, exp_lanes,
    exp_m1_mirrored, ln_lanes, sin_and_versine, sin_cos, sin_cos_lanes, sin_lanes, sqrt_lanes,
    tan_lanes,
};
use crate::vector::{Baseline, InstructionSet};

/// Steele, Lea and Flood's SplitMix64: the arguments are the same in every run.
struct Numbers(u64);

impl Numbers {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in −1 … 1.
    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Any double, NaN and infinities too.
    fn any(&mut self) -> f64 {
        f64::from_bits(self.bits())
    }

    /// centre ± up to 2⁻ᵏ of it with k of 1 … 60: from far away to the neighbouring doubles.
    fn near(&mut self, centre: f64) -> f64 {
        let k = 1 + self.bits() % 60;
        centre * (1.0 + self.unit() / (1_u64 << k) as f64)
    }

    /// ± a size between 2⁻ᵃ and 2ᵇ, the exponent uniform.
    fn spread(&mut self, a: u64, b: u64) -> f64 {
        let exponent = 1023 - a + self.bits() % (a + b);
        let sign_and_mantissa = self.bits() & 0x800f_ffff_ffff_ffff;
        f64::from_bits(sign_and_mantissa | (exponent << 52))
    }
}

/// Numbers where something changes in one of the algorithms or in the format.
const EDGES: [f64; 26] = [
    0.0,
    f64::MIN_POSITIVE,
    f64::MIN_POSITIVE / 4.0,
    5e-324,
    f64::EPSILON,
    1e-300,
    3.725_290_298_461_914e-9,
    1.490_116_119_384_765_6e-8,
    0.25,
    0.4375,
    0.5,
    0.6744,
    0.6875,
    std::f64::consts::FRAC_1_SQRT_2,
    1.0,
    1.1875,
    std::f64::consts::SQRT_2,
    2.4375,
    708.396_418_532_264_1,
    709.782_712_893_384,
    745.133_219_101_941_1,
    1_647_099.0,
    7.378_697_629_483_821e19,
    f64::MAX,
    f64::INFINITY,
    f64::NAN,
];

/// 2²⁰ arguments at a time.
const CHUNK: usize = 1 << 20;

/// Ten chunks: the doubles alike, the edges and their neighbours, the special points of
/// each function, and ordinary numbers.
fn arguments(chunk: usize, numbers: &mut Numbers) -> Vec<f64> {
    let mut next = |at: usize| -> f64 {
        let sign = if numbers.bits() & 1 == 0 { 1.0 } else { -1.0 };
        let multiple = (numbers.bits() >> (1 + at % 60)) as f64;
        match chunk {
            0 => numbers.any(),
            1 => {
                let edge = EDGES[at % EDGES.len()];
                let neighbour = numbers.bits() % 5;
                sign * f64::from_bits(edge.to_bits().wrapping_add(neighbour).wrapping_sub(2))
            }
            2 => sign * numbers.near(EDGES[at % EDGES.len()]),
            3 => numbers.near(multiple * FRAC_PI_4) * sign,
            4 => {
                let few = (numbers.bits() % 16) as f64;
                numbers.near(few * FRAC_PI_4) * sign
            }
            5 => {
                let halves = (numbers.bits() % 2100) as f64;
                numbers.near(halves * 0.5 * LN_2) * sign
            }
            6 => numbers.near(1.0),
            7 => numbers.spread(60, 11),
            8 => numbers.spread(4, 4),
            _ => 40.0 * numbers.unit(),
        }
    };
    (0..CHUNK).map(&mut next).collect()
}

const CHUNKS: usize = 10;

/// Equal bits; which NaN a function returns is not specified.
fn agree(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

fn check(name: &str, arguments: &[f64], values: &[f64], expected: &[f64], set: InstructionSet) {
    for ((x, value), expected) in arguments.iter().zip(values).zip(expected) {
        assert!(
            agree(*value, *expected),
            "{name}({x:e} = {:#018x}) on {set:?}: {value:e}, libm {expected:e}",
            x.to_bits()
        );
    }
}

fn agrees_with_libm(
    name: &str,
    scalar: fn(f64) -> f64,
    lanes: impl Fn(InstructionSet, &mut [f64]),
) {
    let mut numbers = Numbers(20_260_401);
    for chunk in 0..CHUNKS {
        let arguments = arguments(chunk, &mut numbers);
        let expected: Vec<f64> = arguments.iter().map(|x| scalar(*x)).collect();
        let mut values = vec![0.0; arguments.len()];
        for set in InstructionSet::available() {
            values.copy_from_slice(&arguments);
            lanes(set, &mut values);
            check(name, &arguments, &values, &expected, set);
        }
    }
}

/// Runs one of the functions on an instruction set.
fn on<F: Elementary>(set: InstructionSet, values: &mut [f64]) {
    set.run_registers(Lanes::<F>::new(values));
}

#[test]
fn exp_has_libm_s_bits() {
    agrees_with_libm("exp", libm::exp, on::<Exp>);
}

#[test]
fn ln_has_libm_s_bits() {
    agrees_with_libm("ln", libm::log, on::<Ln>);
}

#[test]
fn sqrt_has_libm_s_bits() {
    agrees_with_libm("sqrt", libm::sqrt, |set, values| set.run(Roots(values)));
}

#[test]
fn sin_has_libm_s_bits() {
    agrees_with_libm("sin", libm::sin, on::<Sin>);
}

#[test]
fn cos_has_libm_s_bits() {
    agrees_with_libm("cos", libm::cos, on::<Cos>);
}

#[test]
fn tan_has_libm_s_bits() {
    agrees_with_libm("tan", libm::tan, on::<Tan>);
}

#[test]
fn atan_has_libm_s_bits() {
    agrees_with_libm("atan", libm::atan, on::<Atan>);
}

#[test]
fn sine_and_cosine_together_have_libm_s_bits() {
    let mut numbers = Numbers(20_260_402);
    for chunk in 0..CHUNKS {
        let arguments = arguments(chunk, &mut numbers);
        let sines: Vec<f64> = arguments.iter().map(|x| libm::sin(*x)).collect();
        let cosines: Vec<f64> = arguments.iter().map(|x| libm::cos(*x)).collect();
        for (at, x) in arguments.iter().enumerate() {
            let (sine, cosine) = sin_cos(*x);
            assert!(
                agree(sine, sines[at]) && agree(cosine, cosines[at]),
                "sincos({x:e})"
            );
        }
        let mut first = vec![0.0; arguments.len()];
        let mut second = vec![0.0; arguments.len()];
        for set in InstructionSet::available() {
            first.copy_from_slice(&arguments);
            set.run_registers(PairLanes::<SinCos>::new(&mut first, &mut second));
            check("sin", &arguments, &first, &sines, set);
            check("cos", &arguments, &second, &cosines, set);
        }
    }
}

/// Blocks and what is left of them: every length gives each argument the same value, next to
/// arguments that are not ordinary too.
#[test]
fn every_number_of_lanes_gives_the_same_bits() {
    type Pair = (fn(&mut [f64]), fn(f64) -> f64);
    let all: [Pair; 7] = [
        (exp_lanes, libm::exp),
        (ln_lanes, libm::log),
        (sqrt_lanes, libm::sqrt),
        (sin_lanes, libm::sin),
        (cos_lanes, libm::cos),
        (tan_lanes, libm::tan),
        (atan_lanes, libm::atan),
    ];
    let mut numbers = Numbers(20_260_403);
    for length in 0..40 {
        for trial in 0..8 {
            let arguments: Vec<f64> = (0..length)
                .map(|at| match (at + trial) % 5 {
                    0 => numbers.any(),
                    _ => 3.0 * numbers.unit(),
                })
                .collect();
            for (lanes, scalar) in all {
                let mut values = arguments.clone();
                lanes(&mut values);
                assert!(
                    arguments
                        .iter()
                        .zip(values)
                        .all(|(x, v)| agree(v, scalar(*x)))
                );
            }
            let (mut sines, mut cosines) = (arguments.clone(), vec![0.0; length]);
            sin_cos_lanes(&mut sines, &mut cosines);
            assert!(
                arguments
                    .iter()
                    .zip(sines)
                    .all(|(x, v)| agree(v, libm::sin(*x)))
            );
            assert!(
                arguments
                    .iter()
                    .zip(cosines)
                    .all(|(x, v)| agree(v, libm::cos(*x)))
            );
        }
    }
}

/// The largest distance of two functions of one argument from exact ones, in ulps of the value.
fn largest_error(
    arguments: &[f64],
    values: fn(f64) -> (f64, f64),
    exact: fn(f64) -> [TwoDoubles; 2],
) -> f64 {
    let error = |value: f64, exact: TwoDoubles| {
        let ulp = f64::from_bits(exact.0.abs().to_bits() + 1) - exact.0.abs();
        ((value - exact.0) - exact.1).abs() / ulp
    };
    let errors = arguments.iter().flat_map(|x| {
        let ((first, second), exact) = (values(*x), exact(*x));
        [error(first, exact[0]), error(second, exact[1])]
    });
    errors.fold(0.0, f64::max)
}

/// An unevaluated sum, to about 100 bits.
#[derive(Clone, Copy)]
struct TwoDoubles(f64, f64);

impl TwoDoubles {
    fn sum(a: f64, b: f64) -> Self {
        let sum = a + b;
        let part = sum - a;
        Self(sum, (a - (sum - part)) + (b - part))
    }

    fn product(a: f64, b: f64) -> Self {
        let halves = |x: f64| {
            let scaled = 134_217_729.0 * x;
            let high = scaled - (scaled - x);
            (high, x - high)
        };
        let ((a1, a2), (b1, b2)) = (halves(a), halves(b));
        let product = a * b;
        Self(product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2)
    }

    fn plus(self, other: Self) -> Self {
        let Self(high, low) = Self::sum(self.0, other.0);
        Self::sum(high, low + (self.1 + other.1))
    }

    fn times(self, other: Self) -> Self {
        let Self(high, low) = Self::product(self.0, other.0);
        Self::sum(high, low + (self.0 * other.1 + self.1 * other.0))
    }

    fn over(self, divisor: f64) -> Self {
        let first = self.0 / divisor;
        let Self(high, low) = Self::product(first, divisor);
        let rest = ((self.0 - high) - low) + self.1;
        Self::sum(first, rest / divisor)
    }

    fn negative(self) -> Self {
        Self(-self.0, -self.1)
    }
}

/// Σ_{j ≥ 1} xʲ/j!, and the sums over odd and over even j with alternating signs: eˣ − 1, sin x, 1 − cos x.
fn taylor(x: f64) -> [TwoDoubles; 3] {
    let mut term = TwoDoubles(1.0, 0.0);
    let mut sums = [TwoDoubles(0.0, 0.0); 3];
    for j in 1..60 {
        term = term.times(TwoDoubles(x, 0.0)).over(f64::from(j));
        let signed = if (j - 1) / 2 % 2 == 0 {
            term
        } else {
            term.negative()
        };
        sums[0] = sums[0].plus(term);
        let which = if j % 2 == 1 { 1 } else { 2 };
        sums[which] = sums[which].plus(signed);
    }
    sums
}

/// Positive arguments up to `most`: dense ones, and small ones of every size.
fn sizes(most: f64) -> Vec<f64> {
    let mut numbers = Numbers(20_260_404);
    let mut next = |at: usize| match at % 2 {
        0 => (most * numbers.unit()).abs(),
        _ => most * numbers.spread(60, 1).abs() / 2.0,
    };
    (0..200_000).map(&mut next).collect()
}

/// Both against their series in double the precision, whose terms cancel by at most e⁸.
#[test]
fn mirrored_exponentials_are_within_2_ulps() {
    let exact = |x: f64| {
        let [up, ..] = taylor(x);
        // e⁻ˣ − 1 = −(eˣ − 1)/eˣ, without cancellation, by one step of division.
        let whole = up.plus(TwoDoubles(1.0, 0.0));
        let first = up.over(whole.0);
        let rest = up.plus(whole.times(first).negative());
        [up, first.plus(rest.over(whole.0)).negative()]
    };
    for (most, ulps) in [(0.3465, 1.0), (0.55, 2.0), (8.0, 2.0)] {
        let found = largest_error(&sizes(most), exp_m1_mirrored, exact);
        assert!(found <= ulps, "{found} ulps up to {most}");
    }
}

#[test]
fn sine_and_versine_are_within_2_ulps() {
    let exact = |x: f64| {
        let [_, sine, versine] = taylor(x);
        [sine, versine]
    };
    for most in [0.785, 8.0] {
        let ulps = largest_error(&sizes(most), sin_and_versine, exact);
        assert!(ulps <= 2.0, "{ulps} ulps up to {most}");
    }
}

/// What the mirrored exponential is of −x the other is of x, and far out both are `libm`'s.
#[test]
fn pairs_end_as_libm_does() {
    for x in [700.0, 709.0, 710.0, 745.0, 1e300, f64::INFINITY, f64::NAN] {
        for x in [x, -x] {
            let (up, down) = exp_m1_mirrored(x);
            assert!(agree(up, libm::expm1(x)) && agree(down, libm::expm1(-x)));
        }
    }
    for x in [1e7, 1e22, f64::MAX, f64::INFINITY, f64::NAN] {
        let (sine, versine) = sin_and_versine(x);
        assert!(agree(sine, libm::sin(x)));
        let exact = 1.0 - libm::cos(x);
        let is_near = (versine - exact).abs() <= 4.0 * f64::EPSILON;
        assert!(is_near || (versine.is_nan() && exact.is_nan()));
    }
    for x in sizes(40.0) {
        let ((up, down), (other_down, other_up)) = (exp_m1_mirrored(x), exp_m1_mirrored(-x));
        assert_eq!((up, down), (other_up, other_down));
    }
}

/// On every instruction set and beside every neighbour the bits of one argument alone.
#[test]
fn pairs_have_the_same_bits_in_lanes() {
    fn check_pair<F: ElementaryPair>(values: fn(f64) -> (f64, f64)) {
        let mut numbers = Numbers(20_260_405);
        for chunk in 0..CHUNKS {
            let arguments = arguments(chunk, &mut numbers);
            let expected: Vec<(f64, f64)> = arguments.iter().map(|x| values(*x)).collect();
            let (first, second): (Vec<f64>, Vec<f64>) = expected.into_iter().unzip();
            for set in InstructionSet::available() {
                let (mut a, mut b) = (arguments.clone(), vec![0.0; arguments.len()]);
                set.run_registers(PairLanes::<F>::new(&mut a, &mut b));
                check("the first", &arguments, &a, &first, set);
                check("the second", &arguments, &b, &second, set);
                a.copy_from_slice(&arguments);
                b.copy_from_slice(&arguments);
                on::<First<F>>(set, &mut a);
                on::<Second<F>>(set, &mut b);
                check("the first alone", &arguments, &a, &first, set);
                check("the second alone", &arguments, &b, &second, set);
            }
        }
    }
    check_pair::<Mirrored>(exp_m1_mirrored);
    check_pair::<Turn>(sin_and_versine);
}

/// Fused products by the instruction, where this machine has it, and by whole numbers.
#[test]
fn pairs_have_the_same_bits_without_the_instruction() {
    let mut numbers = Numbers(20_260_406);
    for chunk in 0..CHUNKS {
        for x in &arguments(chunk, &mut numbers)[..CHUNK / 32] {
            let found = [Mirrored::any::<Baseline>(*x), Turn::any::<Baseline>(*x)];
            let expected = [exp_m1_mirrored(*x), sin_and_versine(*x)];
            for (found, expected) in found.iter().zip(expected) {
                assert!(
                    agree(found.0, expected.0) && agree(found.1, expected.1),
                    "{x:e}"
                );
            }
        }
    }
}
