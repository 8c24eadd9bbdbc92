//! Coefficients of the spline of one variable that interpolates its nodes.

use super::banded::Banded;

/// The values at `u` of the k + 1 B-splines that a cell of unit length sees, the oldest first.
///
/// They follow from the degrees below: p b_j^p = (u + p − j) b_{j−1}^{p−1} + (j + 1 − u) b_j^{p−1}.
pub(super) fn weights(degree: usize, u: f64) -> Vec<f64> {
    let mut weights = vec![1.0];
    for p in 1..=degree {
        let of = |j: Option<usize>| j.and_then(|j| weights.get(j)).copied().unwrap_or(0.0);
        let next = (0..=p).map(|j| {
            let [left, right] = [of(j.checked_sub(1)), of(Some(j))];
            let [j, p] = [j as f64, p as f64];
            ((u + p - j) * left + (j + 1.0 - u) * right) / p
        });
        weights = next.collect();
    }
    weights
}

/// How an axis is divided into cells on which the spline is one polynomial.
///
/// Knots stand at the nodes for odd degrees, half-way between nodes for even ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cells {
    /// The cells.
    pub(super) count: usize,
    /// The place of the first node in the first cell, 0 or 1/2.
    pub(super) shift: f64,
}

impl Cells {
    pub(super) fn of(nodes: usize, degree: usize, is_periodic: bool) -> Self {
        let is_odd = degree % 2 == 1;
        Self {
            count: if is_odd && !is_periodic {
                nodes - 1
            } else {
                nodes
            },
            shift: if is_odd { 0.0 } else { 0.5 },
        }
    }
}

/// Equations between values at nodes and coefficients.
pub(super) enum Interpolation {
    /// Not-a-knot ends.
    Open {
        /// Rows of conditions before those of the nodes.
        ends: usize,
        matrix: Banded,
    },
    /// A circulant matrix as a band and a border of `border` unknowns.
    Periodic(Box<Bordered>),
}

impl Interpolation {
    /// Of at least `degree` + 1 nodes.
    pub(super) fn new(nodes: usize, degree: usize, is_periodic: bool) -> Self {
        let cells = Cells::of(nodes, degree, is_periodic);
        let mut weights = weights(degree, cells.shift);
        // At a knot the newest B-spline is 0.
        if cells.shift == 0.0 && degree > 0 {
            weights.pop();
        }
        if is_periodic {
            return Self::Periodic(Box::new(Bordered::new(nodes, &weights)));
        }
        // So many knots at each end are none: across them the highest derivative does not jump.
        let ends = degree / 2;
        let size = cells.count + degree;
        let mut entries = Vec::new();
        // Across a knot between cells c − 1 and c the k-th derivative jumps by the (k+1)-th difference of coefficients.
        let difference = alternating(degree + 1);
        let mut condition = |row: usize, knot: usize| {
            let entry = |(j, value): (usize, &f64)| (row, knot - 1 + j, *value);
            entries.extend(difference.iter().enumerate().map(entry));
        };
        for at in 0..ends {
            condition(at, at + 1);
            condition(ends + nodes + at, cells.count - ends + at);
        }
        for node in 0..nodes {
            let entry = |(j, value): (usize, &f64)| (ends + node, node + j, *value);
            entries.extend(weights.iter().enumerate().map(entry));
        }
        let matrix = Banded::new(size, [degree + 1, degree + 1], entries);
        Self::Open { ends, matrix }
    }

    /// Coefficients of the values at the nodes: one more than the degree for the first cell, and one for each further.
    pub(super) fn coefficients(&self, values: &[f64], degree: usize) -> Vec<f64> {
        match self {
            Self::Open { ends, matrix } => {
                let mut x = vec![0.0; values.len() + 2 * ends];
                x[*ends..ends + values.len()].copy_from_slice(values);
                matrix.solve(&mut x);
                x
            }
            Self::Periodic(bordered) => {
                let own = bordered.solve(values);
                let wrapped = own.iter().cycle().take(degree);
                own.iter().chain(wrapped).copied().collect()
            }
        }
    }
}

/// (−1)^(m−j) m!/(j! (m − j)!) for j = 0 … m.
fn alternating(m: usize) -> Vec<f64> {
    let mut row = vec![1.0];
    for _ in 0..m {
        let mut next = vec![0.0; row.len() + 1];
        for (j, value) in row.iter().enumerate() {
            next[j] -= value;
            next[j + 1] += value;
        }
        row = next;
    }
    row
}

/// Σ_j w_j c_{i+j} = v_i with indices modulo n.
///
/// The last unknowns and equations are a border of a band: with B the band, [B E; F D] is solved by D − F B⁻¹ E.
pub(super) struct Bordered {
    weights: Vec<f64>,
    inner: Banded,
    /// B⁻¹ E, a column for each unknown of the border.
    columns: Vec<Vec<f64>>,
    border: Banded,
}

impl Bordered {
    fn new(nodes: usize, weights: &[f64]) -> Self {
        let reach = weights.len() - 1;
        // Row i holds c_{i−reach/2} … so that the matrix is symmetric with its largest entries on the diagonal.
        let before = reach / 2;
        let entry = |row: usize, j: usize| ((row + nodes + j - before) % nodes, weights[j]);
        let inside = nodes - reach;
        let [mut inner, mut right, mut below, mut corner] = [const { Vec::new() }; 4];
        for row in 0..nodes {
            for j in 0..=reach {
                let (column, value) = entry(row, j);
                match (row < inside, column < inside) {
                    (true, true) => inner.push((row, column, value)),
                    (true, false) => right.push((row, column - inside, value)),
                    (false, true) => below.push((row - inside, column, value)),
                    (false, false) => corner.push((row - inside, column - inside, value)),
                }
            }
        }
        let inner = Banded::new(inside, [before, reach - before], inner);
        let columns = (0..reach).map(|column| {
            let mut x = vec![0.0; inside];
            for &(row, _, value) in right.iter().filter(|entry| entry.1 == column) {
                x[row] += value;
            }
            inner.solve(&mut x);
            x
        });
        let columns: Vec<Vec<f64>> = columns.collect();
        for &(row, at, value) in &below {
            for (column, x) in columns.iter().enumerate() {
                corner.push((row, column, -value * x[at]));
            }
        }
        let border = Banded::new(reach, [reach.max(1) - 1; 2], corner);
        Self {
            weights: weights.to_vec(),
            inner,
            columns,
            border,
        }
    }

    fn solve(&self, values: &[f64]) -> Vec<f64> {
        let (nodes, reach) = (values.len(), self.weights.len() - 1);
        let inside = nodes - reach;
        let before = reach / 2;
        let mut x = values.to_vec();
        let (first, last) = x.split_at_mut(inside);
        self.inner.solve(first);
        for (row, last) in last.iter_mut().enumerate() {
            for (j, weight) in self.weights.iter().enumerate() {
                let column = (inside + row + nodes + j - before) % nodes;
                if column < inside {
                    *last -= weight * first[column];
                }
            }
        }
        self.border.solve(last);
        for (column, value) in self.columns.iter().zip(last.iter()) {
            for (x, c) in first.iter_mut().zip(column) {
                *x -= c * value;
            }
        }
        // Row i began with c_i where the cell i begins.
        x.rotate_right(before);
        x
    }
}
