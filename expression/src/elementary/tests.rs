//! Every function has the bits of `libm` on every instruction set of this machine.

use std::f64::consts::{FRAC_PI_4, LN_2};

use super::lanes::{Elementary, Lanes, PairLanes};
use super::{
    Atan, Cos, Exp, ExpMinus1, Ln, Roots, Sin, SinCos, Tan, atan_lanes, cos_lanes, exp_lanes,
    exp_m1_lanes, ln_lanes, sin_cos_lanes, sin_lanes, sqrt_lanes, tan_lanes,
};
use crate::vector::InstructionSet;

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
fn exp_m1_has_libm_s_bits() {
    agrees_with_libm("expm1", libm::expm1, on::<ExpMinus1>);
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
    let all: [Pair; 8] = [
        (exp_lanes, libm::exp),
        (exp_m1_lanes, libm::expm1),
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
