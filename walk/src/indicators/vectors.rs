//! Vectors at right angles to each other, by coordinates that are measured.

/// The part of a direction that must be left of it beside those before it, for these to be told apart.
pub(super) const APART: f64 = 1e-10;

/// The vectors, of length 1 in the measured coordinates: so many at right angles to each other, the others to the first. `None`
/// where they are fewer directions.
pub(super) fn orthonormal(
    mut vectors: Vec<f64>,
    (d, measured): (usize, usize),
    count: usize,
) -> Option<Vec<f64>> {
    for k in 0..vectors.len() / d.max(1) {
        let (before, own) = vectors.split_at_mut(k * d);
        let own = &mut own[..d];
        let before = if k < count { before } else { &mut before[..d] };
        normalise(own, measured)?;
        // Twice is enough.
        for _ in 0..2 {
            before
                .chunks_exact(d)
                .for_each(|one| take_out(own, one, measured));
        }
        if norm(&own[..measured]) <= APART {
            return None;
        }
        normalise(own, measured)?;
    }
    Some(vectors)
}

/// Takes the part along a vector of length 1 out.
pub(super) fn take_out(own: &mut [f64], one: &[f64], measured: usize) {
    let part = dot(&own[..measured], &one[..measured]);
    for (x, y) in own.iter_mut().zip(one) {
        *x -= part * y;
    }
}

/// Divides by the norm of the measured coordinates, which it returns; `None` where that is 0 or no number.
pub(super) fn normalise(own: &mut [f64], measured: usize) -> Option<f64> {
    let norm = norm(&own[..measured]);
    if !(norm > 0.0 && norm.is_finite()) {
        return None;
    }
    own.iter_mut().for_each(|x| *x /= norm);
    Some(norm)
}

/// |v|, of any size.
pub(super) fn norm(vector: &[f64]) -> f64 {
    let size = vector.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    if size == 0.0 || !size.is_finite() {
        return size;
    }
    let squares = vector.iter().map(|v| (v / size) * (v / size));
    size * libm::sqrt(squares.sum())
}

/// a·b.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
