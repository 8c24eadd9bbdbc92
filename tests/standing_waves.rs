//! Standing waves, whose nodes are round-off alone: every solve ends, in any units.

use std::cell::Cell;

use leafwise_tests::scenes::{composed, end};
use proptest::prelude::*;

/// Implicit steppers and methods, whose solves judge corrections of nodes.
const METHODS: [&str; 9] = [
    r#"stepper = "implicit-midpoint""#,
    r#"stepper = { name = "gauss", stages = 2 }"#,
    r#"stepper = { name = "gauss", stages = 3 }"#,
    r#"stepper = { name = "gauss", stages = 5 }"#,
    r#"stepper = { name = "energy-preserving", order = 2 }"#,
    r#"stepper = { name = "energy-preserving", order = 4 }"#,
    r#"stepper = "projection""#,
    r#"dynamics = { name = "hamilton-jacobi", order = 2 }"#,
    r#"dynamics = { name = "hamilton-jacobi", order = 4 }"#,
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
