//! Linear changes of variables.

use super::systems::{
    B5, HEAVY_TOP, HENON_HEILES, KIRCHHOFF, LAGRANGES_TOP, MAXWELL_BLOCH, ROTOR, THREE_WAVE, TODA,
};
use std::time::{Duration, Instant};

use super::*;

/// x = A z with small integers over such numbers up to `below` turns z' = A⁻¹ f(A z) into the same kind of equations.
fn changed(rows: Rows, seed: u64, below: i64) -> Option<Equations> {
    let original = equations(rows, &[]);
    let d = rows.len();
    let mut state = seed;
    let mut next = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        i64::try_from(state >> 33).expect("31 bits")
    };
    let mut entry = || {
        let above = next() % 5 - 2;
        let below = if below > 1 { next() % below + 1 } else { 1 };
        Rational::new(above, below)
    };
    let a: Vec<Vec<Rational>> = (0..d).map(|_| (0..d).map(|_| entry()).collect()).collect();
    // A⁻¹ by its columns: A y = f, solved with unknown y for each unit vector.
    let mut inverse = vec![vec![Rational::zero(); d]; d];
    for column in 0..d {
        let mut system = Elimination::new(d);
        for (row, entries) in a.iter().enumerate() {
            let right = Rational::from_integer(i64::from(row == column));
            system.add(entries.iter().cloned().chain([right]).enumerate());
        }
        if system.rank() < d {
            return None;
        }
        for (row, value) in system.solutions()?.particular.into_iter().enumerate() {
            inverse[row][column] = value;
        }
    }
    let mut ring = Ring::new(d);
    let z: Vec<Polynomial> = (0..d).map(|i| ring.variable(i)).collect();
    let combined = |ring: &mut Ring, row: &[Rational], parts: &[Polynomial]| {
        let terms: Vec<_> = row.iter().cloned().zip(parts.iter().cloned()).collect();
        ring.combine(&terms)
    };
    let x: Vec<Polynomial> = a.iter().map(|row| combined(&mut ring, row, &z)).collect();
    let mut f = Vec::new();
    for formula in original.field() {
        f.push(
            formula
                .evaluate_in(&mut ring, &mut |_, at| Ok(x[at].clone()))
                .expect("a polynomial"),
        );
    }
    let field = inverse
        .iter()
        .map(|row| combined(&mut ring, row, &f))
        .collect::<Vec<_>>();
    let field = field.iter().map(|f| ring.formula(f)).collect();
    let names = original.variables().to_vec();
    Some(Equations::new(names, Vec::new(), field).expect("a formula for each"))
}

const CASES: &[(&str, Rows, &[Kind])] = &[
    ("Henon and Heiles", HENON_HEILES, &[Kind::Constant]),
    ("DETEST B5", B5, &[Kind::Affine]),
    ("Maxwell and Bloch", MAXWELL_BLOCH, &[Kind::Affine]),
    ("rotor", ROTOR, &[Kind::Affine]),
    ("Toda", TODA, &[Kind::Affine]),
    ("three waves", THREE_WAVE, &[Kind::Constant]),
    ("heavy top", HEAVY_TOP, &[Kind::Affine]),
    ("Kirchhoff", KIRCHHOFF, &[Kind::Affine]),
];

/// Constant and affine brackets go over into such under linear changes of variables, three of each system here.
#[test]
fn linear_changes_of_variables_keep_the_kind() {
    changes(CASES, 3);
}

/// A hundred changes of each system, but of Kirchhoff's body, where some end without a rational solution.
#[test]
#[ignore = "minutes"]
fn a_hundred_linear_changes_keep_the_kind() {
    changes(&CASES[..7], 100);
}

fn changes(cases: &[(&str, Rows, &[Kind])], each: usize) {
    let mut count = 0;
    for (name, rows, kinds) in cases {
        let mut longest = Duration::ZERO;
        for equations in (1..1000)
            .filter_map(|seed| changed(rows, seed, 1))
            .take(each)
        {
            let begin = Instant::now();
            let found = bracket(name, &equations);
            longest = longest.max(begin.elapsed());
            assert!(kinds.contains(&found.kind), "{name}");
            count += 1;
        }
        println!("{name}: {each} changes, the longest search {longest:?}");
    }
    assert_eq!(count, cases.len() * each);
}

/// How many of the first hundred changes of Kirchhoff's body are found, and of the first twenty of Lagrange's top: printed.
#[test]
#[ignore = "minutes: a measurement"]
fn changes_of_dense_bodies_are_counted() {
    for (name, rows, each) in [
        ("Lagrange's top", LAGRANGES_TOP, 20),
        ("Kirchhoff", KIRCHHOFF, 100),
    ] {
        let mut missed = Vec::new();
        let all = (1..1000).filter_map(|seed| Some((seed, changed(rows, seed, 1)?)));
        for (at, (seed, equations)) in all.take(each).enumerate() {
            let begin = Instant::now();
            if search(&equations).bracket.is_none() {
                missed.push(seed);
            }
            println!(
                "{name} {seed}: {:?}, missed {missed:?} of {}",
                begin.elapsed(),
                at + 1
            );
        }
        assert!(2 * missed.len() < each, "{name}: {missed:?}");
    }
}

/// How many of the first changes by fractions with denominators up to 2, 3 and 5 are found: printed, as a measurement that the guide tells.
#[test]
#[ignore = "minutes: a measurement"]
fn changes_by_fractions_are_counted() {
    let each = 20;
    let top: (&str, Rows, &[Kind]) = ("Lagrange's top", LAGRANGES_TOP, &[Kind::Affine]);
    for (name, rows, _) in CASES.iter().chain([&top]) {
        let counts = [1, 2, 3, 5].map(|below| {
            let all = (1..1000).filter_map(|seed| changed(rows, seed, below));
            let begin = Instant::now();
            let found = all
                .take(each)
                .filter(|equations| search(equations).bracket.is_some());
            let found = found.count();
            println!(
                "{name}, denominators up to {below}: {found} of {each}, {:?}",
                begin.elapsed()
            );
            found
        });
        println!("{name}: {counts:?}");
        assert!(counts.iter().all(|count| *count > 0), "{name}");
    }
}
