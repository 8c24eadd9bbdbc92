//! Periodic axes whose last node is the first one again.

use super::axis::TableAxis;

/// Values at both ends differ by less than this part of the largest: they are those of one node.
const SAME: f64 = 1e-9;

/// Squares of fourth differences at the joint fall by more where the last node is left out.
const SMOOTHER: f64 = 2.0;

/// The axis along which numbers, the last axis fastest, repeat the first node of a period at its end.
///
/// The values at both ends of every line are the same there. So are those of an even function with nodes in the middles of cells, which
/// is smooth where its period closes. A repeated node makes a step there: the fourth differences are smaller without it.
pub(super) fn repeated_end<'a>(axes: &'a [TableAxis], numbers: &[f64]) -> Option<&'a TableAxis> {
    let largest = numbers
        .iter()
        .fold(0.0_f64, |most, number| most.max(number.abs()));
    let mut stride = numbers.len();
    axes.iter().find(|axis| {
        stride /= axis.nodes;
        axis.is_periodic && {
            let lines = lines(numbers, axis.nodes, stride);
            is_repeated(lines, SAME * largest)
        }
    })
}

/// The numbers along an axis, line by line.
fn lines(numbers: &[f64], nodes: usize, stride: usize) -> impl Iterator<Item = Vec<f64>> + '_ {
    let blocks = numbers.chunks_exact(nodes * stride);
    blocks.flat_map(move |block| {
        (0..stride).map(move |start| block[start..].iter().step_by(stride).copied().collect())
    })
}

fn is_repeated(lines: impl Iterator<Item = Vec<f64>>, same: f64) -> bool {
    let (mut with, mut without) = (0.0, 0.0);
    for line in lines {
        let Some((last, others)) = line.split_last() else {
            return false;
        };
        if others.len() < 5 || (last - line[0]).abs() > same {
            return false;
        }
        with += at_joint(&line);
        without += at_joint(others);
    }
    with > SMOOTHER * without
}

/// Squares of the fourth differences about the place where a period closes.
fn at_joint(line: &[f64]) -> f64 {
    let n = line.len();
    let difference = |at: usize| -> f64 {
        let weights = [1.0, -4.0, 6.0, -4.0, 1.0].iter().enumerate();
        weights.map(|(k, w)| w * line[(at + n + k - 2) % n]).sum()
    };
    [n - 2, n - 1, 0, 1]
        .map(difference)
        .iter()
        .map(|difference| difference * difference)
        .sum()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::axis::TableAxis;
    use super::repeated_end;

    fn axes(nodes: [usize; 2]) -> [TableAxis; 2] {
        [("q", nodes[0]), ("r", nodes[1])].map(|(name, nodes)| TableAxis {
            name: name.to_owned(),
            first: 0.0,
            last: 1.0,
            nodes,
            is_periodic: true,
        })
    }

    /// Functions of two angles at nodes that begin so far within a cell, with or without the end of one period.
    #[test]
    fn ends_of_periods_are_told_from_even_functions() {
        let functions: [fn(f64, f64) -> f64; 4] = [
            |q, r| libm::cos(q) * (2.0 + libm::cos(r)),
            |q, r| libm::exp(libm::cos(q)) + 0.2 * libm::cos(2.0 * r),
            |q, r| libm::cos(q - 1.0) + libm::sin(r),
            |q, r| libm::sin(2.0 * q) * libm::sin(r) + libm::cos(q + r),
        ];
        let mut cases = 0;
        for of in functions {
            for count in [17, 24, 33] {
                for within in [0.0, 0.5, 0.3] {
                    for ends in [[0, 0], [1, 0], [0, 1]] {
                        let node = |k: usize| TAU * ((k % count) as f64 + within) / count as f64;
                        let nodes = ends.map(|end| count + end);
                        let numbers: Vec<f64> = (0..nodes[0] * nodes[1])
                            .map(|at| of(node(at / nodes[1]), node(at % nodes[1])))
                            .collect();
                        let axes = axes(nodes);
                        let found = repeated_end(&axes, &numbers).map(|axis| axis.name.as_str());
                        let expected = match ends {
                            [1, _] => Some("q"),
                            [_, 1] => Some("r"),
                            _ => None,
                        };
                        assert_eq!(found, expected, "{count} {within}");
                        cases += 1;
                    }
                }
            }
        }
        assert_eq!(cases, 108);
        // A constant has no joint, and few nodes show none.
        assert!(repeated_end(&axes([9, 9]), &[1.0; 81]).is_none());
        assert!(repeated_end(&axes([3, 3]), &[0.0; 9]).is_none());
    }
}
