//! Round-off bounds of coordinates, derivatives and tensors, whatever their units are.
//!
//! In units c_i x_i of the coordinates every quantity here changes as what it bounds does, so that ratios of
//! the two do not change at all.

use nalgebra::DMatrix;

/// |x_i|, and of coordinates that are 0 the largest of the others, or 1: where no map says more.
pub(super) fn sizes(state: &[f64]) -> Vec<f64> {
    let largest = state.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let other = if largest == 0.0 { 1.0 } else { largest };
    let size = |v: &f64| if *v == 0.0 { other } else { v.abs() };
    state.iter().map(size).collect()
}

/// max(|x_i|, |y_i|, Σ_k |DF_ik| |x_k|) for y = F(x): what a coordinate holds at both ends, and what round-off
/// of the others is multiplied by on its way into it. It is 0 only where nothing reaches the coordinate.
pub(super) fn sizes_along(x: &[f64], y: &[f64], tangent: &DMatrix<f64>) -> Vec<f64> {
    (0..x.len())
        .map(|i| {
            let row = tangent.row(i);
            let put: f64 = row.iter().zip(x).map(|(t, x)| (t * x).abs()).sum();
            x[i].abs().max(y[i].abs()).max(put)
        })
        .collect()
}

/// F_ik, the round-off of a derivative's entries in units of u, for values of size s_i and arguments of size a_k.
/// Round-off of a row is that of the whole row: max(s_i, max_k |D_ik| a_k) in units of a_k. An argument without a
/// size has entries with round-off of their own alone.
pub(super) fn of_rows(
    derivative: &DMatrix<f64>,
    values: &[f64],
    arguments: &[f64],
) -> DMatrix<f64> {
    let mut rows = derivative.abs();
    for (i, mut row) in rows.row_iter_mut().enumerate() {
        let products = row.iter().zip(arguments).map(|(entry, a)| entry * a);
        let whole = products.fold(values[i], f64::max);
        for (entry, a) in row.iter_mut().zip(arguments) {
            if *a > 0.0 {
                *entry = entry.max(whole / a);
            }
        }
    }
    rows
}

/// (Σ_{ij} (m_ij/bound_ij)²)^{1/2} over the entries that have a bound: an entry without one is 0, for its bound
/// holds every term of it. `None` where no entry has a bound.
pub(super) fn relative(matrix: &DMatrix<f64>, bounds: &DMatrix<f64>) -> Option<f64> {
    let pairs = matrix.iter().zip(bounds.iter());
    let bounded = pairs.filter(|(_, bound)| **bound != 0.0);
    let squares = bounded.map(|(entry, bound)| (entry / bound) * (entry / bound));
    squares
        .fold(None, |sum, square| Some(sum.unwrap_or(0.0) + square))
        .map(libm::sqrt)
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::{of_rows, relative, sizes_along};

    /// Units are powers of two: nothing is rounded anew.
    #[test]
    fn ratios_do_not_depend_on_units() {
        let (x, y) = ([0.7, 0.0, -3.0], [0.6, 1e-3, -3.1]);
        let map = DMatrix::from_row_slice(3, 3, &[0.9, 0.3, 0.0, 1e-3, 1.0, 0.2, 0.0, -0.1, 1.1]);
        let of = |units: [f64; 3]| {
            let scaled = |v: [f64; 3]| [0, 1, 2].map(|i| v[i] * units[i]);
            let (x, y) = (scaled(x), scaled(y));
            let map = DMatrix::from_fn(3, 3, |i, k| map[(i, k)] * units[i] / units[k]);
            let sizes = sizes_along(&x, &y, &map);
            let rows = of_rows(&map, &sizes, &sizes);
            (
                [0, 1, 2].map(|i| sizes[i] / units[i]),
                relative(&map, &rows).map(f64::to_bits),
            )
        };
        let usual = of([1.0; 3]);
        assert_eq!(usual.0[1], 1e-3_f64.max(0.7 * 1e-3 + 3.0 * 0.2));
        assert_eq!(of([100, -90, 3].map(|k| libm::ldexp(1.0, k))), usual);
    }

    #[test]
    fn nothing_is_relative_to_nothing() {
        let zero = DMatrix::zeros(2, 2);
        assert_eq!(relative(&zero, &zero), None);
    }
}
