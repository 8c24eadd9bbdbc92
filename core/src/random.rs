//! Random numbers that depend on a seed, a member and a purpose alone.
//!
//! Every number has a counter of its own under the key of the seed: it is the same on any machine, in any order, and
//! whatever else is drawn.

use leafwise_expression::elementary;
use leafwise_expression::vector::{Work, run_loops};

/// Philox4x32-10: ten rounds that scatter a counter under a key (J. Salmon, M. Moraes, R. Dror,
/// D. Shaw, *Parallel random numbers: as easy as 1, 2, 3*, SC11).
#[inline(always)]
fn philox(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let [mut a, mut b, mut c, mut d] = counter;
    let [mut first, mut second] = key;
    for _ in 0..10 {
        let left = 0xD251_1F53 * u64::from(a);
        let right = 0xCD9E_8D57 * u64::from(c);
        (a, b, c, d) = (
            (right >> 32) as u32 ^ b ^ first,
            right as u32,
            (left >> 32) as u32 ^ d ^ second,
            left as u32,
        );
        first = first.wrapping_add(0x9E37_79B9);
        second = second.wrapping_add(0xBB67_AE85);
    }
    [a, b, c, d]
}

/// No normal number is larger in size: √(2·53·ln 2), rounded up.
pub const LARGEST_NORMAL: f64 = 8.572;

/// One stream of numbers: any member's can be drawn without those before it.
#[derive(Clone, Debug)]
pub struct Random {
    key: [u32; 2],
    /// Block of the stream, stream, member.
    counter: [u32; 4],
    waiting: Option<u64>,
}

impl Random {
    /// The numbers of a member for one purpose, by a number below 2³¹.
    pub fn new(seed: u64, member: u64, stream: u32) -> Self {
        Self::from_counter(seed, [0, stream, member as u32, (member >> 32) as u32])
    }

    /// The two numbers of the step, below 2⁴⁸, of a member below 2⁴⁷, for a channel of noise: no stream of another purpose
    /// shares their counter.
    pub fn of_step(seed: u64, member: u64, channel: u32, step: u64) -> Self {
        Self::from_counter(seed, counter_of_step(member, channel, step))
    }

    fn from_counter(seed: u64, counter: [u32; 4]) -> Self {
        Self {
            key: [seed as u32, (seed >> 32) as u32],
            counter,
            waiting: None,
        }
    }

    fn bits(&mut self) -> u64 {
        if let Some(bits) = self.waiting.take() {
            return bits;
        }
        let [a, b, c, d] = philox(self.counter, self.key);
        self.counter[0] = self.counter[0].wrapping_add(1);
        self.waiting = Some(u64::from(c) | u64::from(d) << 32);
        u64::from(a) | u64::from(b) << 32
    }

    /// Uniform in (0, 1): an odd multiple of 2⁻⁵³.
    pub fn uniform(&mut self) -> f64 {
        uniform(self.bits())
    }

    /// Standard normal, by Box and Muller; |ξ| ≤ √(2·53·ln 2) < [`LARGEST_NORMAL`], as a uniform number is at least 2⁻⁵³.
    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(self.uniform()));
        radius * libm::cos(2.0 * std::f64::consts::PI * self.uniform())
    }
}

/// The counter of a step. The channel's low 15 bits stand beside the purpose, the others above the member.
#[inline(always)]
fn counter_of_step(member: u64, channel: u32, step: u64) -> [u32; 4] {
    let purpose = 1 << 31 | (channel & 0x7FFF) << 16 | (step >> 32) as u32;
    let above = (channel >> 15) << 15;
    [
        step as u32,
        purpose,
        member as u32,
        (member >> 32) as u32 | above,
    ]
}

/// Numbers that are drawn together.
const TOGETHER: usize = 64;

/// [`normal`](Random::normal) of each channel from `channel` on, of [`of_step`](Random::of_step): the same bits.
pub fn normals_of_step(seed: u64, member: u64, channel: u32, step: u64, into: &mut [f64]) {
    if let [alone] = into {
        *alone = Random::of_step(seed, member, channel, step).normal();
        return;
    }
    let mut first = channel;
    for normals in into.chunks_mut(TOGETHER) {
        let (mut radii, mut turns) = ([1.0; TOGETHER], [0.0; TOGETHER]);
        run_loops(Uniform {
            seed,
            member,
            first,
            step,
            radii: &mut radii,
            turns: &mut turns,
        });
        first = first.wrapping_add(TOGETHER as u32);
        elementary::ln_lanes(&mut radii);
        radii.iter_mut().for_each(|radius| *radius *= -2.0);
        elementary::sqrt_lanes(&mut radii);
        elementary::cos_lanes(&mut turns);
        for (normal, (radius, cosine)) in normals.iter_mut().zip(radii.iter().zip(turns)) {
            *normal = radius * cosine;
        }
    }
}

/// The two uniform numbers of each channel from the first on, the second times 2π.
struct Uniform<'a> {
    seed: u64,
    member: u64,
    first: u32,
    step: u64,
    radii: &'a mut [f64; TOGETHER],
    turns: &'a mut [f64; TOGETHER],
}

impl Work for Uniform<'_> {
    #[inline(always)]
    fn run(self) {
        let key = [self.seed as u32, (self.seed >> 32) as u32];
        let (radii, turns) = (self.radii.iter_mut(), self.turns.iter_mut());
        for (at, (radius, turn)) in radii.zip(turns).enumerate() {
            let channel = self.first.wrapping_add(at as u32);
            let [a, b, c, d] = philox(counter_of_step(self.member, channel, self.step), key);
            *radius = uniform(u64::from(a) | u64::from(b) << 32);
            *turn = 2.0 * std::f64::consts::PI * uniform(u64::from(c) | u64::from(d) << 32);
        }
    }
}

/// Uniform in (0, 1), of random bits: an odd multiple of 2⁻⁵³. The bits become those of a number in [1, 2), from which 1 is
/// taken: all of it is exact.
#[inline(always)]
fn uniform(bits: u64) -> f64 {
    let above_1 = f64::from_bits(0x3FF0 << 48 | bits >> 12);
    above_1 - 1.0 + f64::EPSILON / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The known answers of the Random123 distribution.
    #[test]
    fn philox_gives_its_known_answers() {
        assert_eq!(
            philox([0; 4], [0; 2]),
            [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]
        );
        assert_eq!(
            philox([u32::MAX; 4], [u32::MAX; 2]),
            [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]
        );
        assert_eq!(
            philox(
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0]
            ),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    /// Steps up to 2⁴⁸, channels and members have numbers of their own, apart from every stream below 2³¹.
    #[test]
    fn every_step_and_channel_has_a_counter_of_its_own() {
        let mut seen = std::collections::HashSet::new();
        let steps = [0, 1, u64::from(u32::MAX), 1 << 32, 1 << 40, (1 << 48) - 1];
        for member in [0, 1, 1 << 32] {
            for channel in [
                0,
                1,
                (1 << 15) - 1,
                1 << 15,
                1 << 16,
                3 << 20,
                (1 << 30) + 1,
            ] {
                for step in steps {
                    assert!(seen.insert(Random::of_step(3, member, channel, step).counter));
                }
            }
            for stream in [0, 1, (1 << 31) - 1] {
                assert!(seen.insert(Random::new(3, member, stream).counter));
            }
        }
    }

    /// Drawn together numbers have the bits of those drawn alone, also where their channels pass the 2¹⁵-th.
    #[test]
    fn numbers_drawn_together_are_those_drawn_alone() {
        let mut compared = 0;
        for (count, first) in [(1, 0), (7, 3), (1000, (1 << 15) - 500), (130, 262_100)] {
            let mut together = vec![0.0; count];
            normals_of_step(9, 5, first, 77, &mut together);
            for (channel, normal) in (first..).zip(&together) {
                let alone = Random::of_step(9, 5, channel, 77).normal();
                assert_eq!(alone.to_bits(), normal.to_bits(), "channel {channel}");
                compared += 1;
            }
        }
        assert_eq!(compared, 1138);
    }

    /// √(−2 ln 2⁻⁵³), the largest that Box and Muller's radius becomes.
    #[test]
    fn normal_numbers_are_bounded() {
        let radius = libm::sqrt(2.0 * 53.0 * std::f64::consts::LN_2);
        assert!(radius < LARGEST_NORMAL && radius > LARGEST_NORMAL - 1e-3);
    }

    /// Moments of 10⁵ numbers within five standard errors.
    #[test]
    fn numbers_have_their_moments() {
        let count = 100_000;
        let (mut uniform, mut normal) = ([0.0; 2], [0.0; 4]);
        for member in 0..count {
            let mut random = Random::new(7, member, 3);
            let (u, z) = (random.uniform(), random.normal());
            assert!(u > 0.0 && u < 1.0);
            uniform[0] += u;
            uniform[1] += u * u;
            let mut power = 1.0;
            for moment in &mut normal {
                power *= z;
                *moment += power;
            }
        }
        let n = count as f64;
        let close = |sum: f64, mean: f64, variance: f64| {
            let error = libm::sqrt(variance / n);
            assert!(
                (sum / n - mean).abs() < 5.0 * error,
                "{} for {mean}",
                sum / n
            );
        };
        close(uniform[0], 0.5, 1.0 / 12.0);
        close(uniform[1], 1.0 / 3.0, 4.0 / 45.0);
        close(normal[0], 0.0, 1.0);
        close(normal[1], 1.0, 2.0);
        close(normal[2], 0.0, 15.0);
        close(normal[3], 3.0, 96.0);
    }
}
