//! Linear changes of variables.

use super::systems::{
    B5, HEAVY_TOP, HENON_HEILES, KIRCHHOFF, LAGRANGES_TOP, LOTKA_VOLTERRA, MAXWELL_BLOCH,
    MAY_LEONARD, ROTOR, THREE_WAVE, TODA,
};
use std::time::{Duration, Instant};

use super::*;

/// Which matrices A are drawn.
#[derive(Clone, Copy)]
enum Change {
    /// All that are invertible.
    Linear,
    /// Positive multiples of the variables in any order.
    Monomial,
}

/// x = A z with integers from −2 to 2 over such numbers up to `below` turns z' = A⁻¹ f(A z) into the same kind of equations.
fn changed(rows: Rows, change: Change, seed: u64, below: i64) -> Option<Equations> {
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
    let mut a: Vec<Vec<Rational>> = (0..d).map(|_| (0..d).map(|_| entry()).collect()).collect();
    if matches!(change, Change::Monomial) {
        for (i, row) in a.iter_mut().enumerate() {
            let own = (i + usize::try_from(seed).expect("small")) % d;
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = match j == own {
                    true => &entry.abs() + &Rational::new(1, below),
                    false => Rational::zero(),
                };
            }
        }
    }
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

type Case = (&'static str, Rows, Change, Kind);

const CASES: &[Case] = &[
    (
        "Henon and Heiles",
        HENON_HEILES,
        Change::Linear,
        Kind::Constant,
    ),
    ("DETEST B5", B5, Change::Linear, Kind::Affine),
    (
        "Maxwell and Bloch",
        MAXWELL_BLOCH,
        Change::Linear,
        Kind::Affine,
    ),
    ("rotor", ROTOR, Change::Linear, Kind::Affine),
    ("Toda", TODA, Change::Linear, Kind::Affine),
    ("three waves", THREE_WAVE, Change::Linear, Kind::Constant),
    ("heavy top", HEAVY_TOP, Change::Linear, Kind::Affine),
    (
        "Lagrange's top",
        LAGRANGES_TOP,
        Change::Linear,
        Kind::Affine,
    ),
    ("Kirchhoff", KIRCHHOFF, Change::Linear, Kind::Affine),
    (
        "Lotka and Volterra",
        LOTKA_VOLTERRA,
        Change::Monomial,
        Kind::LogCanonical,
    ),
    (
        "May and Leonard",
        MAY_LEONARD,
        Change::Monomial,
        Kind::FirstIntegrals,
    ),
];

/// Constant and affine brackets go over into such under linear changes of variables, the others' kinds under multiples: four of each system here, with denominators
/// up to 1, 2, 3 and 5.
#[test]
fn linear_changes_of_variables_keep_the_kind() {
    changes(4);
}

/// A hundred changes of each system.
#[test]
#[ignore = "minutes"]
fn a_hundred_linear_changes_keep_the_kind() {
    changes(100);
}

fn changes(each: usize) {
    let mut count = 0;
    for (name, rows, change, kind) in CASES {
        let mut longest = Duration::ZERO;
        for below in [1, 2, 3, 5] {
            let drawn = (1..1000).filter_map(|seed| changed(rows, *change, seed, below));
            for equations in drawn.take(each / 4) {
                let begin = Instant::now();
                let found = search(&equations).bracket.map(|found| found.kind);
                longest = longest.max(begin.elapsed());
                assert_eq!(found, Some(*kind), "{name}: {equations:?}");
                bracket(name, &equations);
                count += 1;
            }
        }
        println!("{name}: {each} changes, the longest search {longest:?}");
    }
    assert_eq!(count, CASES.len() * each);
}
