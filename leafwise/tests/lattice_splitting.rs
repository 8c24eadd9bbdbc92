//! Splitting of a long lattice by sweeps over its sites.

use std::sync::Arc;

use crate::chain::Chain;
use leafwise::composition::{Composed, Scheme};
use leafwise::core::lattice::LatticeMap;
use leafwise::core::solver::{StepMap, Stepper, Structure};
use leafwise::core::{BuildError, Walk};
use leafwise::splitting::{LatticeSplitting, Splitting};

/// {x[i], x[i+1]} = x[i] x[i+1], H = Σ x[i].
fn volterra(sites: usize, periodic: bool) -> Chain {
    let bracket = [("x[i],x[i+1]", "x[i]*x[i+1]")];
    Chain::new(&[("x", sites)], periodic, &bracket, "sum(i, x[i])")
}

/// Canonical pairs with springs between neighbours: kinetic and potential energy.
fn springs(sites: usize, periodic: bool) -> Chain {
    let families = [("q", sites), ("p", sites)];
    let hamiltonian = "sum(i, p[i]^2/2) + sum(i, (q[i+1] - q[i])^2/2 - cos(q[i]))";
    Chain::new(&families, periodic, &[("q[i],p[i]", "1")], hamiltonian)
}

/// Toda in Flaschka's variables, one a fewer than b where the ends are open.
fn toda(sites: usize, periodic: bool) -> Chain {
    let families = [("a", sites - usize::from(!periodic)), ("b", sites)];
    let bracket = [("a[i],b[i]", "-a[i]"), ("a[i],b[i+1]", "a[i]")];
    Chain::new(
        &families,
        periodic,
        &bracket,
        "sum(i, b[i]^2/2) + sum(i, a[i]^2)",
    )
}

/// Spins on a chain, x, y, z rotating about fields that neighbours make.
fn spins(sites: usize, periodic: bool) -> Chain {
    let families = [("x", sites), ("y", sites), ("z", sites)];
    let bracket = [
        ("x[i],y[i]", "z[i]"),
        ("y[i],z[i]", "x[i]"),
        ("z[i],x[i]", "y[i]"),
    ];
    Chain::new(
        &families,
        periodic,
        &bracket,
        "sum(i, z[i]*z[i+1] + 0.3*x[i])",
    )
}

/// {x[i], x[i+k]} = x[i] x[i+k], H = Σ x[i].
fn far_volterra(sites: usize, periodic: bool, offset: usize) -> Chain {
    let pair = format!("x[i],x[i+{offset}]");
    let entry = format!("x[i]*x[i+{offset}]");
    Chain::new(
        &[("x", sites)],
        periodic,
        &[(&pair, &entry)],
        "sum(i, x[i])",
    )
}

/// s moves r moves u, each so many sites away.
fn far_relay(sites: usize, periodic: bool, offset: usize) -> Chain {
    let mut chain = relay(sites, periodic);
    chain.hamiltonian = format!("sum(i, q[i]*s[i+{offset}] + r[i]*v[i+{offset}])");
    chain
}

/// Three canonical pairs a site; s moves r moves u along the chain in one piece, so that a flow
/// reads at another site what it moves.
fn relay(sites: usize, periodic: bool) -> Chain {
    let families = ["q", "p", "r", "s", "u", "v"].map(|name| (name, sites));
    let bracket = [("q[i],p[i]", "1"), ("r[i],s[i]", "1"), ("u[i],v[i]", "1")];
    let hamiltonian = "sum(i, q[i]*s[i+1] + r[i]*v[i+1])";
    Chain::new(&families, periodic, &bracket, hamiltonian)
}

fn initial(dimension: usize) -> Vec<f64> {
    let value = |c: usize| 1.0 + 0.3 * libm::sin(1.7 * c as f64);
    (0..dimension).map(value).collect()
}

fn increment(mut stepper: Box<dyn Stepper>, x: &[f64]) -> Vec<f64> {
    let (mut increment, mut outcome) = (vec![f64::NAN; x.len()], [Ok(())]);
    stepper.increment(x, &vec![0.0; x.len()], &mut increment, &mut outcome);
    outcome[0].clone().expect("a step");
    increment
}

/// The largest difference, relative to the state's size or 1.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let size = b.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs() / size);
    differences.fold(0.0, f64::max)
}

/// The lattices that split, with how many pieces and after how many sites these repeat.
fn lattices(sites: usize, periodic: bool) -> [(Chain, usize, usize); 5] {
    [
        (volterra(sites, periodic), 2, 2),
        (springs(sites, periodic), 2, 1),
        (toda(sites, periodic), 2, 1),
        (spins(sites, periodic), 2, 1),
        (relay(sites, periodic), 1, 1),
    ]
}

/// The pieces are those of the system written out, so that a step differs by round-off alone: flows
/// of a step of 0.1 round their increments and the state a few times each.
#[test]
fn sweeps_take_the_steps_of_the_splitting_written_out() {
    for periodic in [true, false] {
        // A block and a part of one, two and a rest.
        for sites in [50, 134] {
            for (chain, pieces, period) in lattices(sites, periodic) {
                let sweeps = LatticeSplitting::new(&chain).expect("a lattice that splits");
                assert_eq!(sweeps.pieces(), pieces, "{}", chain.hamiltonian);
                assert_eq!(sweeps.period(), period, "{}", chain.hamiltonian);
                assert!(sweeps.proxy_geometry().length() < sites);
                let written = Splitting::new(&chain.whole()).expect("a system that splits");
                assert_eq!(written.pieces().len(), pieces, "{}", chain.hamiltonian);
                let x = initial(chain.geometry.dimension());
                let a = increment(sweeps.stepper(1, &[], 0.5, 0.2), &x);
                let b = increment(written.stepper(1, &[], 0.5, 0.2), &x);
                let error = difference(&a, &b);
                assert!(
                    error <= 16.0 * f64::EPSILON,
                    "{}: {error:e}",
                    chain.hamiltonian
                );
            }
        }
    }
}

/// What stands k sites away is moved by what stands 2k away, and pieces repeat after two sites, after 2k, or nowhere but on the whole
/// lattice: at every length the sweeps move as the splitting written out, into the same pieces or into others.
#[test]
fn sweeps_that_look_far_move_as_the_splitting_written_out() {
    let mut far_periods = 0;
    for offset in [1, 2, 3, 5, 6, 7, 12, 20] {
        for periodic in [true, false] {
            for sites in [41, 4 * offset + 17, 10 * offset + 2, 12 * offset] {
                let chains = [
                    far_volterra(sites, periodic, offset),
                    far_relay(sites, periodic, offset),
                ];
                for chain in chains {
                    let sweeps = match LatticeSplitting::new(&chain) {
                        Ok(sweeps) => sweeps,
                        // A ring that the pieces do not fit.
                        Err(BuildError::DoesNotFit { .. }) if periodic => continue,
                        Err(error) => panic!("{}, {sites} sites: {error}", chain.hamiltonian),
                    };
                    far_periods += usize::from(sweeps.period() > 4);
                    let written = Splitting::new(&chain.whole()).expect("a system that splits");
                    let x = initial(chain.geometry.dimension());
                    let apart = |h: f64| {
                        let a = increment(sweeps.stepper(1, &[], 0.5, h), &x);
                        let b = increment(written.stepper(1, &[], 0.5, h), &x);
                        difference(&a, &b)
                    };
                    // Two splittings of one system into other pieces differ by the third power of the step, of two systems by the first.
                    let (whole, half) = (apart(0.02), apart(0.01));
                    assert!(
                        whole <= 16.0 * f64::EPSILON || half <= whole / 7.0,
                        "{:?}, {}, {sites} sites, ring {periodic}: {whole:e}, {half:e}",
                        chain.bracket[0],
                        chain.hamiltonian
                    );
                }
            }
        }
    }
    assert!(
        far_periods >= 5,
        "{far_periods} lattices had pieces that repeat after twice their reach"
    );
}

/// One sum a site, kinetic and potential energy in turn: the terms of all sites go together
/// nevertheless.
#[test]
fn terms_of_one_sum_are_told_apart_up_to_translation() {
    let mut chain = springs(50, true);
    chain.hamiltonian = "2*sum(i, p[i]^2/2 + (q[i+1] - q[i])^2/2 - cos(q[i]))/2".to_owned();
    let sweeps = LatticeSplitting::new(&chain).expect("a lattice that splits");
    assert_eq!((sweeps.pieces(), sweeps.period()), (2, 1));
}

/// The product of five Strang steps with their inner half flows merged takes 11 sweeps for 15; the
/// same product one after the other, over the system written out, differs by round-off alone.
#[test]
fn a_composition_merges_the_flows_that_meet() {
    let scheme = Scheme::find("suzuki-4").expect("a scheme");
    for periodic in [true, false] {
        let chain = volterra(130, periodic);
        let sweeps = LatticeSplitting::new(&chain).expect("a lattice that splits");
        let work = |mut stepper: Box<dyn Stepper>| {
            let x = initial(130);
            stepper.increment(&x, &[0.0; 130], &mut [0.0; 130], &mut [Ok(())]);
            let statistics = stepper.statistics();
            (
                statistics.evaluations,
                statistics.operations.expect("counted"),
            )
        };
        let (_, strang) = work(sweeps.stepper(1, &[], 1.0, 0.1));
        let composed = Composed::new(Arc::new(sweeps), scheme).expect("self-adjoint");
        let (evaluations, operations) = work(composed.stepper(1, &[], 1.0, 0.1));
        assert_eq!(evaluations, 5);
        assert!(operations < 4 * strang, "{operations} {strang}");

        let written = Splitting::new(&chain.whole()).expect("a system that splits");
        let written = Composed::new(Arc::new(written), scheme).expect("self-adjoint");
        let x = initial(130);
        let a = increment(composed.stepper(1, &[], 1.0, 0.1), &x);
        let b = increment(written.stepper(1, &[], 1.0, 0.1), &x);
        let error = difference(&a, &b);
        assert!(error <= 32.0 * f64::EPSILON, "{error:e}");
    }
}

#[test]
fn every_lane_has_the_bits_of_its_own_trajectory() {
    let chain = springs(40, false);
    let sweeps = LatticeSplitting::new(&chain).expect("a lattice that splits");
    let d = sweeps.dimension();
    let mut together = sweeps.stepper(3, &[], 1.0, 0.1);
    let lane = |w: usize| -> Vec<f64> { (0..d).map(|c| libm::cos((c + 7 * w) as f64)).collect() };
    let mut x: Vec<f64> = (0..d)
        .flat_map(|c| (0..3).map(move |w| (c, w)))
        .map(|(c, w)| lane(w)[c])
        .collect();
    // Lane 1 leaves the formulas' domain; the others do not notice.
    x[3 * 5 + 1] = f64::NAN;
    let (mut increments, mut outcome) = (vec![0.0; 3 * d], vec![Ok(()); 3]);
    together.increment(&x, &vec![0.0; 3 * d], &mut increments, &mut outcome);
    for w in [0, 2] {
        let alone = increment(sweeps.stepper(1, &[], 1.0, 0.1), &lane(w));
        let own: Vec<f64> = increments.iter().skip(w).step_by(3).copied().collect();
        assert_eq!(own, alone);
        assert_eq!(outcome[w], Ok(()));
    }
    assert!(outcome[1].is_err());
    assert!(
        increments
            .iter()
            .skip(1)
            .step_by(3)
            .all(|change| *change == 0.0)
    );
}

/// Σ ln x over the even and over the odd sites. A step rounds each increment, a tenth of its
/// coordinate: the sums walk by √(steps × sites) × ε/10.
#[test]
fn casimirs_keep_to_round_off() {
    let (sites, steps) = (256, 2000);
    let chain = volterra(sites, true);
    let sweeps = LatticeSplitting::new(&chain).expect("a lattice that splits");
    assert_eq!(sweeps.properties().structure, Structure::Exact);
    let scheme = Scheme::find("suzuki-4").expect("a scheme");
    let composed = Composed::new(Arc::new(sweeps), scheme).expect("self-adjoint");
    let mut walk = Walk::new(&composed, &[], 1.0, 0.2, &initial(sites));
    let casimirs = |x: &[f64]| {
        [0, 1].map(|parity| {
            x.iter()
                .skip(parity)
                .step_by(2)
                .map(|x| libm::log(*x))
                .sum::<f64>()
        })
    };
    let before = casimirs(walk.state());
    for _ in 0..steps {
        walk.step().expect("a step");
    }
    let after = casimirs(walk.state());
    let walk = libm::sqrt((steps * sites) as f64) * 0.1 * f64::EPSILON;
    for (before, after) in before.iter().zip(after) {
        assert!(
            (before - after).abs() < 30.0 * walk,
            "{before} {after} {walk:e}"
        );
    }
}

#[test]
fn a_ring_that_the_pieces_do_not_fit_is_refused() {
    let error = LatticeSplitting::new(&volterra(101, true)).expect_err("an odd ring");
    let BuildError::DoesNotFit { reason, .. } = &error else {
        panic!("{error}");
    };
    assert!(reason.contains("multiple of 2"), "{reason}");
    LatticeSplitting::new(&volterra(101, false)).expect("an open chain of any length");
    let mut logistic = volterra(40, true);
    logistic.hamiltonian = "sum(i, exp(x[i] + x[i+1]))".to_owned();
    let error = LatticeSplitting::new(&logistic).expect_err("no exact flow");
    assert!(error.to_string().contains("does not split"), "{error}");
}

#[test]
fn a_million_sites_are_built_as_quickly_as_a_hundred() {
    for chain in [volterra, springs, toda, spins] {
        let operations = |sites| {
            let sweeps = LatticeSplitting::new(&chain(sites, true)).expect("a lattice that splits");
            sweeps.cost().operations
        };
        assert_eq!(operations(1_000_000), 10_000 * operations(100));
    }
}
