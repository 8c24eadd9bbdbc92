//! Vectors of all directions, so ordered that exponents come in pairs.
//!
//! First come q_1, …, q_n in the leaf with q_i·Πq_j = 0, then the directions across the leaf, then Πq_n, …, Πq_1. Where Π is
//! canonical the first k of them span the symplectic complement of what the first d − k span. DΦ keeps this, and the volumes of
//! both grow alike. Hence λ_{d+1−k} = −λ_k after every step, to round-off.

use leafwise_core::random::Random;

use super::vectors::{APART, norm, normalise, orthonormal, take_out};

/// The first so many of them from the columns of Π; `None` where there are fewer. Where asked for, one more is in the leaf, at right
/// angles to the first.
pub(super) fn begin(
    columns: &[f64],
    d: usize,
    (count, one_more): (usize, bool),
) -> Option<Vec<f64>> {
    let tensor = |v: &[f64]| -> Vec<f64> {
        let mut moved = vec![0.0; d];
        for (part, column) in v.iter().zip(columns.chunks_exact(d)) {
            moved
                .iter_mut()
                .zip(column)
                .for_each(|(m, c)| *m += part * c);
        }
        moved
    };
    let drawn = |at: u64| -> Vec<f64> {
        let mut random = Random::new(0, at, 0);
        (0..d).map(|_| random.normal()).collect()
    };
    let mut used: Vec<Vec<f64>> = Vec::new();
    let (mut ahead, mut behind) = (Vec::new(), Vec::<Vec<f64>>::new());
    for at in 0..d as u64 {
        let Some(q) = apart(tensor(&drawn(at)), &used) else {
            break;
        };
        let p = tensor(&q);
        used.push(q.clone());
        ahead.extend(q);
        let Some(own) = apart(p.clone(), &used) else {
            break;
        };
        used.push(own);
        behind.push(p);
    }
    let mut vectors = ahead;
    while used.len() < d {
        let units = (0..d).map(|j| {
            let mut unit = vec![0.0; d];
            unit[j] = 1.0;
            left(&mut unit, &used);
            unit
        });
        let mut longest = units.max_by(|a, b| norm(a).total_cmp(&norm(b)))?;
        normalise(&mut longest, d)?;
        vectors.extend(&longest);
        used.push(longest);
    }
    vectors.extend(behind.into_iter().rev().flatten());
    vectors.truncate(count * d);
    if vectors.len() < count * d {
        return None;
    }
    if one_more {
        let mut other = tensor(&drawn(d as u64));
        normalise(&mut other, d)?;
        vectors.extend(other);
    }
    orthonormal(vectors, (d, d), count)
}

/// The part of a vector at right angles to orthonormal ones, made 1 long.
fn apart(mut vector: Vec<f64>, others: &[Vec<f64>]) -> Option<Vec<f64>> {
    let d = vector.len();
    normalise(&mut vector, d)?;
    left(&mut vector, others);
    if norm(&vector) <= APART {
        return None;
    }
    normalise(&mut vector, d)?;
    Some(vector)
}

/// Takes orthonormal vectors out of another, twice.
fn left(vector: &mut [f64], others: &[Vec<f64>]) {
    let d = vector.len();
    for _ in 0..2 {
        others.iter().for_each(|one| take_out(vector, one, d));
    }
}
