//! Axes and numbers that make no spline.

use super::axis::{HIGHEST_DEGREE, MOST_AXES, TableAxis};
use super::error::TableError;
use super::repeated::repeated_end;

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
    match repeated_end(axes, numbers) {
        Some(axis) => Err(TableError::EndRepeated {
            name: axis.name.clone(),
            nodes: axis.nodes,
        }),
        None => Ok(()),
    }
}
