//! Axes and numbers that make no spline.

use super::axis::{HIGHEST_DEGREE, MOST_AXES, TableAxis};
use super::error::TableError;

/// The most coefficients of a table: half a gigabyte.
const MOST_COEFFICIENTS: usize = 1 << 26;

/// Refuses what makes no spline.
pub(super) fn check(axes: &[TableAxis], degree: u8, numbers: &[f64]) -> Result<(), TableError> {
    if axes.is_empty() || axes.len() > MOST_AXES {
        return Err(TableError::Axes { count: axes.len() });
    }
    if !(1..=HIGHEST_DEGREE).contains(&degree) {
        return Err(TableError::Degree { degree });
    }
    for axis in axes {
        let name = || axis.name.clone();
        let TableAxis {
            first, last, nodes, ..
        } = *axis;
        let length = last - first;
        if !(length > 0.0 && length.is_finite() && length / nodes.max(1) as f64 > 0.0) {
            let name = name();
            return Err(TableError::Ends { name, first, last });
        }
        if nodes <= usize::from(degree) {
            let name = name();
            return Err(TableError::Nodes {
                name,
                nodes,
                degree,
            });
        }
    }
    let count = axes.iter().map(|axis| axis.nodes + usize::from(degree));
    let count = count.fold(1_usize, usize::saturating_mul);
    if count > MOST_COEFFICIENTS {
        return Err(TableError::TooLarge { count });
    }
    let shape: Vec<usize> = axes.iter().map(|axis| axis.nodes).collect();
    if shape.iter().product::<usize>() != numbers.len() {
        let found = numbers.len();
        return Err(TableError::Shape { shape, found });
    }
    if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
        let (value, mut rest) = (numbers[at], at);
        let mut node = vec![0; shape.len()];
        for (place, length) in node.iter_mut().zip(&shape).rev() {
            *place = rest % length;
            rest /= length;
        }
        return Err(TableError::NotFinite { node, value });
    }
    check_periods(axes, &shape, numbers)
}

/// Numbers at the end of a period are those at its beginning, and stand there alone.
fn check_periods(axes: &[TableAxis], shape: &[usize], numbers: &[f64]) -> Result<(), TableError> {
    let largest = numbers.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (at, axis) in axes.iter().enumerate().filter(|(_, axis)| axis.is_periodic) {
        let inner: usize = shape[at + 1..].iter().product();
        let layer = |i: usize| {
            let is_in = move |place: &usize| place / inner % shape[at] == i;
            (0..numbers.len()).filter(is_in).map(|place| numbers[place])
        };
        let is_same = |i: usize| {
            let mut pairs = layer(0).zip(layer(i));
            pairs.all(|(a, b)| (a - b).abs() <= 1e-12 * largest)
        };
        if is_same(shape[at] - 1) && !is_same(1) {
            let name = axis.name.clone();
            return Err(TableError::Repeated { name });
        }
    }
    Ok(())
}
