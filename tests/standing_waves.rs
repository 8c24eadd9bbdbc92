//! Standing waves, whose nodes are round-off alone: every solve ends, in any units.

use std::cell::Cell;

use leafwise_tests::scenes::{composed, end};
use proptest::prelude::*;

/// Implicit steppers, whose solves judge corrections of nodes.
const METHODS: [&str; 7] = [
    r#"stepper = "implicit-midpoint""#,
    r#"stepper = { name = "gauss", stages = 2 }"#,
    r#"stepper = { name = "gauss", stages = 3 }"#,
    r#"stepper = { name = "gauss", stages = 5 }"#,
    r#"stepper = { name = "energy-preserving", order = 2 }"#,
    r#"stepper = { name = "energy-preserving", order = 4 }"#,
    r#"stepper = "projection""#,
];

/// A ring of particles with springs of cubic and quartic potentials, moved as sin(2πki/n), in a unit of q.
#[derive(Clone, Debug)]
struct Wave {
    sites: usize,
    mode: usize,
    quartic: f64,
    unit: f64,
    method: usize,
    step: f64,
}

fn waves() -> impl Strategy<Value = Wave> {
    let shape = (3_usize..7, 1_usize..3, 0.0..1.0_f64);
    (shape, -9_i32..10, 0..METHODS.len(), 0.01..0.3_f64).prop_map(
        |((pairs, mode, quartic), exponent, method, step)| Wave {
            sites: 2 * pairs,
            mode,
            quartic,
            unit: libm::ldexp(1.0, 3 * exponent),
            method,
            step,
        },
    )
}

impl Wave {
    /// The size of the wave's nodes after 60 steps beside that of the wave.
    fn nodes(&self) -> f64 {
        let Self {
            sites,
            mode,
            quartic,
            unit,
            method,
            step,
        } = self;
        let square = 1.0 / (unit * unit);
        let run = composed(&format!(
            "[system]\nfamilies = {{ q = {sites}, p = {sites} }}\nbracket = \"canonical\"\n\
             hamiltonian = \"sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2 + {quartic:?}*{square:?}*(q[i+1] - q[i])^4/4)\"\n\
             [method]\n{}\ntime-step = {step:?}\n\
             [run]\nsteps = 60\ninitial = {{ \"q[i]\" = \"{unit:?}*sin(2*pi*{mode}*i/N)\", \"p[i]\" = 0 }}\n",
            METHODS[*method]
        ));
        let state = end(&run);
        let middle = sites / 2;
        let nodes = [
            state[0],
            state[middle],
            state[*sites],
            state[sites + middle],
        ];
        nodes
            .iter()
            .fold(0.0, |all, node| f64::max(all, node.abs()))
            / unit
    }
}

#[test]
fn nodes_that_are_round_off_hold_up_no_solve() {
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(48)
    };
    let (ran, round_off) = (Cell::new(0), Cell::new(0));
    proptest!(config, |(wave in waves())| {
        let nodes = wave.nodes();
        // Modes of the wave's equation linearized grow by less than e^(10 t) in t ≤ 18; most hardly do.
        prop_assert!(nodes < 1e-3, "{wave:?}: nodes of {nodes:e}");
        ran.update(|ran| ran + 1);
        round_off.update(|cases| cases + usize::from(0.0 < nodes && nodes < 1e-13));
    });
    assert_eq!(ran.get(), 48);
    assert!(
        round_off.get() >= 12,
        "nodes are round-off in {} waves",
        round_off.get()
    );
}

/// A wave of a ring of linear springs, in steps much longer than the fastest wave: one solution, which each step of the midpoint rule turns by
/// 2 arctan(hω/2), ω² = k (2 − 2 cos(2πm/n)), and a quadratic energy makes both methods the midpoint rule.
#[test]
fn stiff_linear_waves_turn_as_the_midpoint_rule_says() {
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(12)
    };
    let drawn = (
        3_usize..31,
        1_usize..4,
        2_i32..9,
        0.05..1.0_f64,
        any::<bool>(),
    );
    let ran = Cell::new(0);
    proptest!(config, |((pairs, mode, exponent, fast, is_midpoint) in drawn)| {
        let (sites, stiffness) = (2 * pairs, libm::pow(10.0, f64::from(exponent)));
        // So many radians of the fastest wave a step; at 200 and more a solve may be refused.
        let step = fast / (2.0 * libm::sqrt(stiffness));
        let method = match is_midpoint {
            true => r#""implicit-midpoint""#,
            false => r#"{ name = "energy-preserving", order = 2 }"#,
        };
        let steps = 10;
        let run = composed(&format!(
            "[system]\nfamilies = {{ q = {sites}, p = {sites} }}\nbracket = \"canonical\"\n\
             hamiltonian = \"sum(i, p[i]^2/2 + {stiffness:?}*(q[i+1] - q[i])^2/2)\"\n\
             [method]\nstepper = {method}\ntime-step = {step:?}\n\
             [run]\nsteps = {steps}\ninitial = {{ \"q[i]\" = \"sin(2*pi*{mode}*i/N)\", \"p[i]\" = 0 }}\n"
        ));
        let state = end(&run);
        let wave = std::f64::consts::TAU * mode as f64 / sites as f64;
        let omega = libm::sqrt(stiffness * (2.0 - 2.0 * libm::cos(wave)));
        let angle = 2.0 * libm::atan(step * omega / 2.0) * f64::from(steps);
        // Solves by matrices as large as (1 + h w)^2, w the fastest rate, in each step.
        let bound = 8.0 * f64::EPSILON * f64::from(steps) * (1.0 + fast) * (1.0 + fast);
        for (site, q) in state[..sites].iter().enumerate() {
            let expected = libm::sin(wave * site as f64) * libm::cos(angle);
            prop_assert!((q - expected).abs() <= bound, "{method} {sites} {stiffness} {step}: {q} for {expected}");
        }
        ran.update(|ran| ran + 1);
    });
    assert_eq!(ran.get(), 12);
}
