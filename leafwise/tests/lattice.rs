//! A long lattice steps by templates exactly as one that is written out site by site.

use std::sync::Arc;

use crate::chain::Chain;
use leafwise::core::LatticeMethod;
use leafwise::core::lattice::LatticeObservables;
use leafwise::core::{BuildError, Method, PartParameters, Registry, Walk};
use proptest::prelude::{Just, ProptestConfig, Strategy, any, prop_assert, prop_oneof, proptest};

/// {x[i], x[i+1]} = x[i] x[i+1] on the first family, {x[i], y[i+1]} = 1 + x[i] y[i+1] where there
/// is a second: a tensor for comparing codes, Poisson or not.
fn volterra(lengths: &[usize], periodic: bool, hamiltonian: &'static str) -> Chain {
    let families: Vec<(&str, usize)> = ["x", "y"]
        .into_iter()
        .zip(lengths.iter().copied())
        .collect();
    let templates = [
        ("x[i],x[i+1]", "x[i]*x[i+1]"),
        ("x[i],y[i+1]", "1 + x[i]*y[i+1]"),
    ];
    Chain::new(
        &families,
        periodic,
        &templates[..families.len()],
        hamiltonian,
    )
}

fn compose(chain: &Chain, n: i64, m: i64) -> Result<LatticeMethod, BuildError> {
    let registry = Registry::with_builtin();
    let dynamics = registry
        .dynamics("hamilton-jacobi")?
        .build(&PartParameters::new().with("order", m))?;
    LatticeMethod::compose(
        chain,
        &|system| {
            let part = registry.realization("karasev-truncated")?;
            part.build(system, &PartParameters::new().with("order", n))
        },
        dynamics,
    )
}

fn written_out(chain: &Chain, n: i64, m: i64) -> Method {
    let registry = Registry::with_builtin();
    let system = chain.whole();
    let parameters = |order| PartParameters::new().with("order", order);
    let realization = registry
        .realization("karasev-truncated")
        .and_then(|part| part.build(&system, &parameters(n)))
        .expect("a realization");
    let dynamics = registry
        .dynamics("hamilton-jacobi")
        .and_then(|part| part.build(&parameters(m)))
        .expect("dynamics");
    Method::compose(&system, Arc::clone(&realization), dynamics).expect("a method")
}

/// Both solve the same equation to round-off; after 20 steps of t = 0.02 they differ by that many
/// solves of a few units in the last place.
fn assert_agrees(chain: &Chain, n: i64, m: i64) {
    let d = chain.geometry.dimension();
    let initial: Vec<f64> = (0..d)
        .map(|c| 1.0 + 0.3 * libm::sin(1.7 * c as f64))
        .collect();
    let lattice = compose(chain, n, m).expect("a lattice method");
    let method = written_out(chain, n, m);
    let mut a = Walk::new(lattice.map().map.as_ref(), &[], 1.0, 0.02, &initial);
    let mut b = Walk::new(&method, &[], 1.0, 0.02, &initial);
    for _ in 0..20 {
        a.step().expect("a step");
        b.step().expect("a step");
    }
    for (coordinate, (a, b)) in a.state().iter().zip(b.state()).enumerate() {
        let tolerance = 20.0 * 8.0 * f64::EPSILON * b.abs().max(1.0);
        assert!(
            (a - b).abs() <= tolerance,
            "{}: {a} {b}",
            chain.geometry.name(coordinate)
        );
    }
}

#[test]
fn a_ring_equals_its_written_out_form() {
    assert_agrees(
        &volterra(&[16], true, "sum(i, x[i] + 0.1*x[i]^2*x[i+1])"),
        3,
        2,
    );
}

#[test]
fn an_open_chain_equals_its_written_out_form() {
    assert_agrees(
        &volterra(&[14], false, "sum(i, x[i] + 0.1*x[i]^2*x[i+1])"),
        3,
        2,
    );
}

#[test]
fn higher_dynamic_orders_have_longer_templates() {
    assert_agrees(&volterra(&[22], true, "sum(i, x[i] + ln(x[i]))"), 2, 4);
    assert_agrees(&volterra(&[22], false, "sum(i, x[i] + ln(x[i]))"), 2, 4);
}

#[test]
fn families_of_different_lengths_share_an_open_chain() {
    assert_agrees(
        &volterra(&[13, 14], false, "sum(i, x[i]*y[i]) + sum(i, y[i]^2)/2"),
        2,
        2,
    );
}

#[test]
fn a_hamiltonian_that_couples_all_sites_is_refused() {
    for hamiltonian in ["sum(i, x[i])^2", "sum(i<j, x[i]*x[j])", "sum(i, x[i]*x[0])"] {
        let chain = volterra(&[100], true, hamiltonian);
        assert!(matches!(
            compose(&chain, 2, 2),
            Err(BuildError::Lattice { .. })
        ));
    }
}

/// The right number, of lattices that would take too much memory.
#[test]
fn a_lattice_that_looks_too_far_is_refused_with_its_distance() {
    let chain = volterra(&[1_000_000], true, "sum(i, x[i]*x[i+5000])");
    assert!(matches!(
        compose(&chain, 2, 2),
        Err(BuildError::NotLocal { reach: 5001, .. })
    ));
}

/// Where an index of a template stands, how far it names sites, and how long the lattice is.
#[derive(Clone, Debug)]
struct Far {
    pair: [i64; 2],
    in_entry: i64,
    coupled: [i64; 2],
    order: i64,
    extra: usize,
    periodic: bool,
}

impl Far {
    fn chain(&self) -> Chain {
        let at = |offset: i64| format!("x[i{offset:+}]");
        let [a, b] = self.pair.map(at);
        let entry = format!("{a}*{b} + 0.1*{}", at(self.in_entry));
        let [c, d] = self.coupled.map(at);
        let hamiltonian = format!("sum(i, x[i]) + 0.1*sum(i, {c}^2*{d})");
        let named = [self.pair[0], self.pair[1], self.in_entry];
        let apart = named
            .iter()
            .max()
            .zip(named.iter().min())
            .map_or(0, |(a, b)| a - b);
        let each = apart + (self.coupled[0] - self.coupled[1]).abs();
        let beside = self
            .pair
            .iter()
            .chain(&self.coupled)
            .chain([&self.in_entry])
            .map(|offset| offset.abs())
            .max();
        let width = each * (self.order - 1) + beside.unwrap_or(0);
        // So long that the templates are of a shorter lattice.
        let sites = 2 * width as usize + 4 + self.extra;
        Chain::new(
            &[("x", sites)],
            self.periodic,
            &[(&format!("{a},{b}"), &entry)],
            &hamiltonian,
        )
    }
}

/// A tensor of any entries, Poisson or not, moves by templates as it does written out.
fn far() -> impl Strategy<Value = Far> {
    let near_or_far = || prop_oneof![-2..3_i64, -8..9_i64];
    (
        1..9_i64,
        near_or_far(),
        near_or_far(),
        near_or_far(),
        0..10_usize,
        any::<bool>(),
    )
        .prop_flat_map(|(apart, start, in_entry, coupled, extra, periodic)| {
            // Long series take short distances.
            let order = if apart + in_entry.abs() + start.abs() + coupled.abs() <= 8 {
                4
            } else {
                2
            };
            Just(Far {
                pair: [start, start + apart],
                in_entry,
                coupled: [start, start + coupled],
                order,
                extra,
                periodic,
            })
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn far_templates_equal_their_written_out_form(far in far()) {
        let chain = far.chain();
        let lattice = compose(&chain, 2, far.order).expect("a lattice method");
        prop_assert!(lattice.map().proxy_geometry.length() < chain.geometry.length());
        assert_agrees(&chain, 2, far.order);
    }
}

#[test]
fn an_energy_is_summed_over_sites() {
    for periodic in [true, false] {
        let chain = volterra(
            &[50, 50],
            periodic,
            "sum(i, x[i]*y[i+1]) - sum(i, y[i]^2)/2 + 3",
        );
        let mut observables = LatticeObservables::new(&chain, &[], 0..1).expect("densities");
        let state: Vec<f64> = (0..100)
            .map(|c| 1.0 + 0.3 * libm::sin(1.7 * c as f64))
            .collect();
        let mut value = [0.0];
        observables.evaluate(&state, &mut value);
        let system = chain.whole();
        let expected = system
            .expressions()
            .expect("formulas")
            .hamiltonian()
            .evaluate(&state, &[]);
        // 100 terms of size 1 to 2, added plainly.
        assert!(
            (value[0] - expected).abs() < 100.0 * 200.0 * f64::EPSILON,
            "{value:?} {expected}"
        );
    }
}

#[test]
fn a_million_sites_are_built_as_quickly_as_a_hundred() {
    let operations = |sites| {
        let chain = volterra(&[sites], true, "sum(i, x[i])");
        let method = compose(&chain, 2, 2).expect("a lattice method");
        assert_eq!(method.map().map.dimension(), sites);
        method.map().operations
    };
    assert_eq!(operations(1_000_000), 10_000 * operations(100));
}

/// At an open end a spring is missing, not the mass it hangs on.
#[test]
fn a_term_that_reaches_outside_leaves_the_others_of_its_summand() {
    let together = volterra(&[30, 30], false, "sum(i, x[i]^2/2 + (y[i+1] - y[i])^2/2)");
    let halved = volterra(&[30, 30], false, "sum(i, (x[i]^2 + (y[i+1] - y[i])^2)/2)");
    let apart = volterra(
        &[30, 30],
        false,
        "sum(i, x[i]^2/2) + sum(i, (y[i+1] - y[i])^2/2)",
    );
    let state: Vec<f64> = (0..60)
        .map(|c| 1.0 + 0.3 * libm::sin(1.7 * f64::from(c)))
        .collect();
    let mut expected: f64 = state[..30].iter().map(|p| p * p / 2.0).sum();
    expected += state[30..]
        .windows(2)
        .map(|q| (q[1] - q[0]) * (q[1] - q[0]) / 2.0)
        .sum::<f64>();
    for chain in [together, halved, apart] {
        let mut value = [0.0];
        let mut densities = LatticeObservables::new(&chain, &[], 0..1).expect("densities");
        densities.evaluate(&state, &mut value);
        let system = chain.whole();
        let written = system
            .expressions()
            .expect("formulas")
            .hamiltonian()
            .evaluate(&state, &[]);
        // 60 terms of size 1, added in different orders.
        let tolerance = 60.0 * 60.0 * f64::EPSILON;
        assert!(
            (value[0] - expected).abs() < tolerance,
            "{}: {value:?}",
            chain.hamiltonian
        );
        assert!(
            (written - expected).abs() < tolerance,
            "{}: {written}",
            chain.hamiltonian
        );
    }
}
