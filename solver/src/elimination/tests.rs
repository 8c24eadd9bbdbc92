//! Claims of elimination.

use super::{ANY, Factors, Rows};

/// Solves one system in lane 1 of 2, the other lane's being the identity.
fn solve<const D: usize>(a: &[f64], r: &[f64]) -> Option<Vec<f64>> {
    let d = r.len();
    let unit = |at: usize| f64::from(u8::from(at.is_multiple_of(d + 1)));
    let matrix: Vec<[f64; 2]> = a.iter().enumerate().map(|(at, v)| [unit(at), *v]).collect();
    let mut right: Vec<[f64; 2]> = r.iter().map(|v| [*v, *v]).collect();
    let mut factors = Factors::<2>::new(d);
    let singular = factors.factor::<D>(&matrix, &[], &[true; 2]);
    assert!(!singular[0]);
    factors.solve::<D>(&mut right);
    assert!(right.iter().zip(r).all(|(solved, r)| solved[0] == *r));
    (!singular[1]).then(|| right.iter().map(|v| v[1]).collect())
}

#[test]
fn solves_with_a_zero_leading_entry() {
    let a = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 1.0];
    let r = [7.0, 3.0, 6.0];
    // The residual of elimination with pivoting, and of the inverse: a few roundings of entries up to 7.
    for found in [solve::<3>(&a, &r), solve::<ANY>(&a, &r)] {
        for (found, expected) in found.expect("regular").iter().zip([1.0, 2.0, 3.0]) {
            assert!((found - expected).abs() <= 8.0 * f64::EPSILON, "{found}");
        }
    }
}

#[test]
fn refuses_matrices_that_are_singular_or_not_finite() {
    for a in [[1.0, 2.0, 2.0, 4.0], [0.0; 4], [1.0, f64::NAN, 0.0, 1.0]] {
        assert_eq!(solve::<2>(&a, &[1.0, 1.0]), None, "{a:?}");
    }
}

/// Rows that are left out are not told from rows from which nothing is subtracted.
#[test]
fn zeros_are_left_out_without_changing_a_bit() {
    const D: usize = 6;
    let mut state = 1_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut solved = 0;
    for sparsity in [-1.0, -0.5, 0.0, 0.5] {
        for _ in 0..100 {
            let entry = |_| if random() < sparsity { 0.0 } else { random() };
            let mut a: Vec<f64> = (0..D * D).map(entry).collect();
            let r: Vec<f64> = (0..D).map(|_| random()).collect();
            let bits = |z: Option<Vec<f64>>| z.map(|z| z.iter().map(|z| z.to_bits()).collect());
            let both = |a: &[f64]| -> [Option<Vec<u64>>; 2] {
                [bits(solve::<D>(a, &r)), bits(solve::<ANY>(a, &r))]
            };
            let [whole, left_out] = both(&a);
            assert_eq!(whole, left_out);
            solved += usize::from(whole.is_some());
            a[3] = f64::INFINITY;
            let [whole, left_out] = both(&a);
            assert_eq!(whole, left_out);
        }
    }
    assert!(solved > 200, "{solved}");
}

/// By the formula for 2 × 2, in units that force exchanges or do not.
#[test]
fn the_sign_of_the_determinant_and_nearness_do_not_depend_on_units() {
    let entries = [-3.0_f64, -1.0, -0.2, 0.0, 0.2, 1.0, 3.0];
    let mut counts = [0, 0];
    for at in 0..7_usize.pow(4) {
        let [a, b, c, d] = std::array::from_fn(|k| entries[at / 7_usize.pow(k as u32) % 7]);
        let determinant: f64 = a * d - b * c;
        if determinant.abs() < 1e-12 {
            continue;
        }
        let near = |pivot: f64| pivot > 0.5 && pivot < 2.0;
        let is_near = near(a) && near(d - b * c / a);
        for unit in [1.0, libm::exp2(40.0), libm::exp2(-40.0)] {
            let mut factors = Factors::<1>::new(2);
            let matrix = [[a], [b * unit], [c / unit], [d]];
            let [singular] = factors.factor::<ANY>(&matrix, &[], &[true]);
            assert!(!singular);
            let positive = factors.has_positive_determinant(0);
            assert_eq!(positive, determinant > 0.0, "{a} {b} {c} {d} in {unit}");
            assert_eq!(factors.is_near_identity(0), is_near, "{a} {b} {c} {d}");
            counts[usize::from(is_near)] += 1;
        }
    }
    assert!(counts[0] > 100 && counts[1] > 100);
}

#[test]
fn columns_are_solved_to_the_bits_of_each_alone() {
    let at = |k: usize| libm::sin(1.0 + (k * k % 37) as f64);
    for exchanges in [false, true] {
        const D: usize = 5;
        let unit = |k: usize| if k.is_multiple_of(D + 1) { 1.0 } else { 0.0 };
        let entry = |k: usize| {
            [if exchanges {
                at(k)
            } else {
                0.05 * at(k) + unit(k)
            }]
        };
        let matrix: Vec<[f64; 1]> = (0..D * D).map(entry).collect();
        let mut factors = Factors::<1>::new(D);
        assert_eq!(factors.factor::<ANY>(&matrix, &[], &[true]), [false]);
        assert_eq!(factors.exchanged, [exchanges]);
        for columns in 1..10 {
            let right: Vec<f64> = (0..D * columns).map(|k| at(k + 100)).collect();
            let mut together = right.clone();
            factors.solve_columns(&mut together, columns);
            for column in 0..columns {
                let of = |all: &[f64]| -> Vec<[f64; 1]> {
                    (0..D).map(|row| [all[row * columns + column]]).collect()
                };
                let mut alone = of(&right);
                factors.solve::<ANY>(&mut alone);
                assert_eq!(alone, of(&together), "column {column} of {columns}");
            }
        }
    }
}

/// A of D×D near the identity and away from it, r: every lane's solution has the bits of its own.
fn check_lanes<const D: usize, const W: usize, M: Rows<W>, S: Rows<1>>() {
    let lane = |at: usize, w: usize| libm::sin(1.0 + (at * at % 37 + 5 * w) as f64);
    for size in [0.1, 1.0] {
        let unit = |at: usize| f64::from(u8::from(at.is_multiple_of(D + 1)));
        let entry = |at: usize, w: usize| unit(at) + size * lane(at, w);
        let matrix: Vec<[f64; W]> = (0..D * D)
            .map(|at| std::array::from_fn(|w| entry(at, w)))
            .collect();
        let right: [[f64; W]; D] =
            std::array::from_fn(|at| std::array::from_fn(|w| lane(at + 100, w)));
        let mut factors = Factors::<W, M>::new(D);
        assert_eq!(factors.factor::<D>(&matrix, &[], &[true; W]), [false; W]);
        let mut together = right;
        factors.solve::<D>(&mut together);
        for w in 0..W {
            let own: Vec<[f64; 1]> = matrix.iter().map(|row| [row[w]]).collect();
            let mut factors = Factors::<1, S>::new(D);
            assert_eq!(factors.factor::<D>(&own, &[], &[true]), [false]);
            let mut alone = right.map(|row| [row[w]]);
            factors.solve::<D>(&mut alone);
            assert_eq!(
                together.map(|row| row[w].to_bits()),
                alone.map(|row| row[0].to_bits()),
                "lane {w} of {W}, {D} equations"
            );
            if D <= 3 {
                // Inverses: their own test has the bound.
                continue;
            }
            // d² γ_3d ρ ‖A‖ ‖z‖ with ρ ≤ 2^(d−1): Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed.,
            // theorem 9.5 and equation 9.14.
            let rows = own
                .chunks_exact(D)
                .map(|row| row.iter().map(|[a]| a.abs()).sum());
            let norm = rows.fold(0.0, f64::max);
            let largest = alone.iter().fold(0.0, |m: f64, [v]| m.max(v.abs()));
            let growth = f64::from(1_u32 << (D - 1));
            let allowed = 1.5 * (D * D * D) as f64 * f64::EPSILON * growth * norm * largest;
            for row in 0..D {
                let products = (0..D).map(|k| own[row * D + k][0] * alone[k][0]);
                let defect = (products.sum::<f64>() - right[row][w]).abs();
                assert!(
                    defect <= allowed,
                    "{defect:e} in lane {w} of {W}, {D} equations"
                );
            }
        }
    }
}

#[test]
fn lanes_are_solved_to_the_bits_of_each_alone() {
    macro_rules! check {
        ($($d:literal),*) => {$(
            check_lanes::<$d, 2, [[f64; 2]; $d * $d], [[f64; 1]; $d * $d]>();
            check_lanes::<$d, 4, [[f64; 4]; $d * $d], [[f64; 1]; $d * $d]>();
            check_lanes::<$d, 8, [[f64; 8]; $d * $d], [[f64; 1]; $d * $d]>();
            check_lanes::<$d, 8, Vec<[f64; 8]>, Vec<[f64; 1]>>();
        )*};
    }
    check!(2, 3, 4, 5, 6, 8);
}

/// Lanes that are not wanted keep the factors they have.
#[test]
fn other_lanes_keep_their_factors() {
    let mut factors = Factors::<2>::new(1);
    factors.factor::<1>(&[[2.0, 4.0]], &[], &[true, true]);
    factors.factor::<1>(&[[8.0, 8.0]], &[], &[true, false]);
    let mut right = [[1.0, 1.0]];
    factors.solve::<1>(&mut right);
    assert_eq!(right, [[0.125, 0.25]]);
}

/// Near the identity by cofactors, whatever the units of the second coordinate: A⁻¹(A z) = z to the roundings
/// of two products of three, over a determinant above 1/8.
#[test]
fn small_matrices_are_inverted_in_any_units() {
    let values = [-0.3, 0.0, 0.2, 0.45];
    let unit = libm::exp2(40.0);
    let mut near = 0;
    for at in 0..4_usize.pow(6) {
        let value = |k: u32| values[at / 4_usize.pow(k) % 4];
        let a = [
            [1.0 + value(0), value(1) * unit, value(2)],
            [value(3) / unit, 1.0, value(4) / unit],
            [value(5), -value(1) * unit, 1.0 + value(2)],
        ];
        let flat: Vec<[f64; 1]> = a.iter().flatten().map(|v| [*v]).collect();
        let mut factors = Factors::<1>::new(3);
        let [singular] = factors.factor::<3>(&flat, &[], &[true]);
        if singular || !factors.is_near_identity(0) {
            continue;
        }
        near += 1;
        let z = [1.0, -2.0 / unit, 3.0];
        let product = |row: &[f64; 3]| row.iter().zip(z).map(|(a, z)| a * z).sum();
        let mut right = a.each_ref().map(|row| [product(row)]);
        factors.solve::<3>(&mut right);
        for (found, expected) in right.iter().zip(z) {
            let error = (found[0] - expected).abs() / expected.abs();
            assert!(error <= 256.0 * f64::EPSILON, "{a:?}: {error:e}");
        }
    }
    assert!(near > 1000, "{near} are near the identity");
}

/// A change of units by powers of two, S⁻¹AS for unknowns of sizes S⁻¹s, changes solutions by these powers and no other
/// bit, near the identity and far from it, some unknowns without a size.
#[test]
fn units_change_no_bit_of_a_solution() {
    let at = |k: usize| libm::sin(1.0 + (k * k % 101) as f64);
    let mut exchanged = [0; 2];
    for number in 0..200 {
        for d in [2, 3, 5] {
            let far = number % 2 == 1;
            let entry = |k: usize| match far {
                true => at(k + 7 * number),
                false => 0.2 * at(k + 7 * number) + f64::from(u8::from(k.is_multiple_of(d + 1))),
            };
            let unit = |k: usize| libm::exp2((60.0 * at(k + 3 * number)).round());
            let size = |k: usize| {
                if (k + number).is_multiple_of(4) {
                    0.0
                } else {
                    at(k + number)
                }
            };
            let solved = |unit: &dyn Fn(usize) -> f64| {
                let matrix: Vec<[f64; 1]> = (0..d * d)
                    .map(|k| [entry(k) * unit(k / d) / unit(k % d)])
                    .collect();
                let rows = |of: &dyn Fn(usize) -> f64| -> Vec<[f64; 1]> {
                    (0..d).map(|k| [of(k) * unit(k)]).collect()
                };
                let (sizes, mut right) = (rows(&size), rows(&|k| at(k + 50)));
                let mut factors = Factors::<1>::new(d);
                let singular = match d {
                    2 => factors.factor::<2>(&matrix, &sizes, &[true]),
                    3 => factors.factor::<3>(&matrix, &sizes, &[true]),
                    _ => factors.factor::<ANY>(&matrix, &sizes, &[true]),
                };
                assert_eq!(singular, [false]);
                match d {
                    2 => factors.solve::<2>(&mut right),
                    3 => factors.solve::<3>(&mut right),
                    _ => factors.solve::<ANY>(&mut right),
                }
                let right = right.iter().enumerate().map(|(k, [v])| v / unit(k));
                (right.collect::<Vec<f64>>(), factors.exchanged[0])
            };
            let (here, there) = (solved(&|_| 1.0), solved(&unit));
            assert_eq!(here, there, "matrix {number} of dimension {d}");
            exchanged[usize::from(far)] += 1;
        }
    }
    assert_eq!(exchanged, [300; 2]);
}
