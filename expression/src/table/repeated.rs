//! Periodic axes whose last node is the first one again.

use super::axis::TableAxis;

/// Values at both ends differ by less than this part of the largest: they are those of one node.
const SAME: f64 = 1e-9;

/// Squares of fourth differences at the joint fall by more where the last node is left out.
const SMOOTHER: f64 = 2.0;

/// They are so many times those of the numbers' round-off, or nothing is seen: a table of few decimals may have the same ends by chance.
const SEEN: f64 = 16.0;

const FOURTH: [f64; 5] = [1.0, -4.0, 6.0, -4.0, 1.0];
const EIGHTH: [f64; 9] = [1.0, -8.0, 28.0, -56.0, 70.0, -56.0, 28.0, -8.0, 1.0];

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
    let (mut with, mut without, mut round_off) = (0.0, 0.0, 0.0);
    for line in lines {
        let Some((last, others)) = line.split_last() else {
            return false;
        };
        if others.len() < 5 || (last - line[0]).abs() > same {
            return false;
        }
        with += at_joint(&line);
        without += at_joint(others);
        round_off += round_off_at_joint(&line);
    }
    with > SMOOTHER * without && with > SEEN * round_off
}

/// Squares of the fourth differences about the place where a period closes.
fn at_joint(line: &[f64]) -> f64 {
    let n = line.len();
    let squares = [n - 2, n - 1, 0, 1].map(|at| square(line, at, &FOURTH));
    squares.iter().sum()
}

/// The mean of these squares for round-off as large as eighth differences show it away from the joint; 0 of a short line.
fn round_off_at_joint(line: &[f64]) -> f64 {
    let away = 6..line.len().saturating_sub(6);
    let count = away.len();
    if count < 4 {
        return 0.0;
    }
    let sum: f64 = away.map(|at| square(line, at, &EIGHTH)).sum();
    let of_noise = |weights: &[f64]| weights.iter().map(|w| w * w).sum::<f64>();
    4.0 * of_noise(&FOURTH) * sum / (count as f64 * of_noise(&EIGHTH))
}

/// The square of a difference about a node of a ring.
fn square(line: &[f64], at: usize, weights: &[f64]) -> f64 {
    let (n, middle) = (line.len(), weights.len() / 2);
    let terms = weights.iter().enumerate();
    let difference: f64 = terms
        .map(|(k, w)| w * line[(at + n + k - middle) % n])
        .sum();
    difference * difference
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

    /// Numbers of two to four decimals often have the same ends though none is repeated.
    #[test]
    fn rounded_numbers_are_not_refused() {
        let functions: [fn(f64) -> f64; 3] = [
            libm::cos,
            |q| libm::exp(libm::cos(q)),
            |q| libm::cos(2.0 * q) + 0.3 * libm::cos(q),
        ];
        let mut cases = 0;
        for of in functions {
            for count in [17, 33, 100, 500] {
                for decimals in [1e2, 1e3, 1e4] {
                    for within in (0..40).map(|k| f64::from(k) / 40.0) {
                        let node = |k: usize| TAU * (k as f64 + within) / count as f64;
                        let numbers: Vec<f64> = (0..count)
                            .map(|k| libm::round(decimals * of(node(k))) / decimals)
                            .collect();
                        cases += usize::from(numbers[0] == numbers[count - 1]);
                        let [axis, _] = axes([count, 1]);
                        assert!(
                            repeated_end(&[axis], &numbers).is_none(),
                            "{count} {decimals} {within}"
                        );
                    }
                }
            }
        }
        assert!(cases > 200, "{cases} tables with the same ends");
    }
}
