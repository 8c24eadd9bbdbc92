use proptest::prelude::*;

use super::*;
use crate::arithmetic::Arithmetic;
use crate::graph::{Graph, Term};
use crate::kernel::Kernel;
use crate::series::{Tape, TaylorState};

fn axis(name: &str, first: f64, last: f64, nodes: usize) -> TableAxis {
    TableAxis {
        name: name.to_owned(),
        first,
        last,
        nodes,
        is_periodic: false,
    }
}

fn nodes(axis: &TableAxis) -> Vec<f64> {
    let length = axis.last - axis.first;
    let cells = axis.nodes - usize::from(!axis.is_periodic);
    (0..axis.nodes)
        .map(|i| axis.first + length * i as f64 / cells as f64)
        .collect()
}

/// The numbers of f at the nodes.
fn tabulated(axes: &[TableAxis], f: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let mut points = vec![Vec::new()];
    for axis in axes {
        let with = |point: &Vec<f64>| {
            let point = point.clone();
            nodes(axis)
                .into_iter()
                .map(move |x| [point.clone(), vec![x]].concat())
        };
        points = points.iter().flat_map(with).collect();
    }
    points.iter().map(|point| f(point)).collect()
}

/// (x + s)ᵖ differentiated m times.
fn power(x: f64, p: i32, m: i32) -> f64 {
    let factor: f64 = (0..m).map(|j| f64::from(p - j)).product();
    if p < m {
        0.0
    } else {
        factor * libm::pow(x, f64::from(p - m))
    }
}

/// Polynomials of the degree in each variable are their own splines, with every derivative, in each number of variables.
#[test]
fn polynomials_of_the_degree_are_reproduced() {
    let mut cases = 0;
    for degree in 1..=9_u8 {
        for count in 1..=3_usize {
            if count == 3 && degree > 5 {
                continue;
            }
            let k = usize::from(degree);
            let axes = [
                axis("x", -1.0, 1.0, k + 4),
                axis("y", 0.5, 1.5, k + 1),
                axis("z", -0.25, 1.25, k + 2),
            ];
            let axes = &axes[..count];
            let highest = i32::from(degree);
            let powers = [highest, highest - 1, highest];
            let f = |point: &[f64], orders: [i32; 3]| -> f64 {
                let all = point.iter().zip(powers).zip(orders);
                all.map(|((x, p), m)| power(x + 0.3, p, m) + power(*x, 1, m))
                    .product()
            };
            let numbers = tabulated(axes, |point| f(point, [0; 3]));
            let table = TableFunction::new("f", axes.to_vec(), degree, &numbers).expect("a table");
            for point in [
                [-1.0, 0.5, 1.25],
                [0.17, 0.93, 0.4],
                [1.0, 1.5, -0.25],
                [-0.71, 1.21, 0.9],
            ] {
                let point = &point[..count];
                for code in 0..(k + 1) * (k + 1).min(4) {
                    let orders = [code % (k + 1), code / (k + 1), code % 2];
                    let orders: Vec<u8> = orders[..count].iter().map(|o| *o as u8).collect();
                    let Some(lookup) = Lookup::of_orders(table, &orders) else {
                        continue;
                    };
                    let mut wide = [0; 3];
                    for (wide, order) in wide.iter_mut().zip(&orders) {
                        *wide = i32::from(*order);
                    }
                    let expected = f(point, wide);
                    // Coefficients are off by a few units of their last place, amplified by the ends, by differences and
                    // by the axes' units.
                    let scale: f64 = orders
                        .iter()
                        .zip(axes)
                        .map(|(order, axis)| {
                            let spacing =
                                table.spacing(axes.iter().position(|a| a == axis).unwrap());
                            libm::pow(2.0 / spacing, f64::from(*order))
                        })
                        .product();
                    let allowed = 3e-14 * scale * libm::pow(4.0, f64::from(degree));
                    let found = lookup.at(point);
                    assert!(
                        (found - expected).abs() <= allowed,
                        "{degree} {orders:?} {point:?}: {found} {expected}, {allowed}"
                    );
                    cases += 1;
                }
            }
        }
    }
    assert!(cases > 1000, "{cases}");
}

/// Nodes are met on open and on periodic axes of every degree.
#[test]
fn nodes_are_interpolated() {
    for degree in 1..=9 {
        for is_periodic in [false, true] {
            for count in [usize::from(degree) + 1, 17, 40] {
                let mut own = axis("x", -2.0, 3.0, count);
                own.is_periodic = is_periodic;
                let numbers: Vec<f64> = (0..count).map(|i| ((7 * i) % 11) as f64 - 4.0).collect();
                let table =
                    TableFunction::new("f", vec![own.clone()], degree, &numbers).expect("a table");
                for (x, number) in nodes(&own).iter().zip(&numbers) {
                    for shift in [0.0, 5.0] {
                        if shift > 0.0 && !is_periodic {
                            continue;
                        }
                        let found = table.value().at(&[x + shift]);
                        // Numbers that jump from node to node are met but for the growth of their coefficients.
                        let allowed = 1e-13 * libm::pow(3.0, f64::from(degree));
                        assert!(
                            (found - number).abs() < allowed,
                            "{degree} {is_periodic} {count} {x}: {found} {number}"
                        );
                    }
                }
            }
        }
    }
}

/// A periodic spline and its derivatives below the degree go on smoothly over the end of the period.
#[test]
fn periods_close_smoothly() {
    for degree in 1..=9_u8 {
        let mut own = axis("x", 0.0, 1.0, 24);
        own.is_periodic = true;
        let numbers = tabulated(&[own.clone()], |x| libm::sin(std::f64::consts::TAU * x[0]));
        let table = TableFunction::new("f", vec![own], degree, &numbers).expect("a table");
        for order in 0..degree {
            let lookup = Lookup::of_orders(table, &[order]).expect("a derivative");
            let gap = lookup.at(&[1.0 - 1e-12]) - lookup.at(&[1.0 + 1e-12]);
            // The next derivative times the distance, and rounding.
            let next = libm::pow(7.0, f64::from(order) + 1.0);
            let rounding = 1e-14 * libm::pow(48.0, f64::from(order));
            assert!(
                gap.abs() <= 1e-11 * next + rounding,
                "{degree} {order}: {gap}"
            );
        }
    }
}

fn smooth(count: usize) -> TableFunction {
    let axes = [
        axis("x", 0.0, 2.0, 9),
        axis("y", -1.0, 1.0, 11),
        TableAxis {
            is_periodic: true,
            ..axis("z", 0.0, 3.0, 8)
        },
    ];
    let axes = &axes[..count];
    let f = |point: &[f64]| {
        let angle = std::f64::consts::TAU / 3.0;
        let sum: f64 = point[..count.min(2)].iter().sum();
        libm::sin(sum)
            + point
                .get(2)
                .map_or(0.0, |z| 0.3 * libm::cos(angle * z) * point[0])
    };
    TableFunction::new("smooth", axes.to_vec(), 5, &tabulated(axes, f)).expect("a table")
}

/// Code has the values and derivatives of the sum over all coefficients, the same bits on each number of lanes.
#[test]
fn code_is_the_sum_whatever_the_lanes() {
    for count in 1..=3 {
        let table = smooth(count);
        let mut graph = Graph::new();
        let inputs: Vec<Term> = (0..count).map(|at| graph.input(at)).collect();
        let value = graph.look_up(table.value(), &inputs).expect("code");
        let mut outputs = vec![value.clone()];
        for first in 0..count {
            let slope = graph.derivative(&value, first).expect("code");
            outputs.push(slope.clone());
            for second in 0..count {
                outputs.push(graph.derivative(&slope, second).expect("code"));
            }
        }
        outputs.extend(graph.gradient(&value, count).expect("code"));
        let kernel = Kernel::compile(&graph, &outputs, 0, count);
        let point = [0.83, -0.41, 7.3];
        let values = |lanes: usize| {
            let mut workspace = kernel.workspace(lanes);
            kernel.prepare(&mut workspace, &[], &vec![1.0; lanes], &vec![1.0; lanes]);
            let mut values = vec![0.0; outputs.len() * lanes];
            let inputs: Vec<f64> = point[..count]
                .iter()
                .flat_map(|x| (0..lanes).map(move |w| x + w as f64 / 64.0))
                .collect();
            kernel.evaluate(&mut workspace, &inputs, &mut values);
            values
        };
        let one = values(1);
        for lanes in [2, 4, 5, 8, 16, 64] {
            let many = values(lanes);
            for (at, value) in one.iter().enumerate() {
                assert_eq!(
                    many[at * lanes].to_bits(),
                    value.to_bits(),
                    "{count} {lanes}"
                );
            }
        }
        let mut at = 0;
        let mut check = |orders: &[u8]| {
            let lookup = Lookup::of_orders(table, orders).expect("a derivative");
            let point = &point[..count];
            let allowed = 64.0 * f64::EPSILON * lookup.magnitude(point);
            assert!((one[at] - lookup.at(point)).abs() <= allowed, "{orders:?}");
            at += 1;
        };
        check(&vec![0; count]);
        for first in 0..count {
            let mut orders = vec![0; count];
            orders[first] += 1;
            check(&orders);
            for second in 0..count {
                let mut orders = orders.clone();
                orders[second] += 1;
                check(&orders);
            }
        }
        for first in 0..count {
            let mut orders = vec![0; count];
            orders[first] += 1;
            check(&orders);
        }
    }
}

proptest! {
    /// The Taylor coefficients of a table along a curve give its values nearby: the spline is one polynomial of degree 10 in
    /// each cell, and of degree 20 along a parabola.
    #[test]
    fn series_are_those_of_the_polynomial(
        x in prop::array::uniform2(0.05_f64..0.2),
        slope in prop::array::uniform4(-0.1_f64..0.1),
    ) {
        let table = smooth(2);
        // Inside the cell from 0.75 to 1 and that from -0.2 to 0.
        let start = [0.75 + x[0], x[1] - 0.2];
        let mut tape = Tape::new();
        let point = [0, 1].map(|at| tape.variable(at));
        let f = tape.look_up(table.value(), &point).expect("a node");
        let mut state = TaylorState::new(&tape);
        let mut numbers = crate::bounded::BoundedNumbers { parameters: Vec::new() };
        let [a, b, c, d] = slope;
        let curve = |axis: usize, k: usize| match (axis, k) {
            (axis, 0) => start[axis],
            (0, 1) => a,
            (0, 2) => b,
            (1, 1) => c,
            (1, 2) => d,
            _ => 0.0,
        };
        let orders = 21;
        for k in 0..orders {
            state.extend(&tape, &mut numbers, |_, axis| crate::bounded::Bounded::exact(curve(axis, k))).expect("a series");
        }
        for h in [0.2_f64, -0.2] {
            let at = [0, 1].map(|axis| start[axis] + h * (curve(axis, 1) + h * curve(axis, 2)));
            let inside = at[0] > 0.75 && at[0] < 1.0 && at[1] > -0.2 && at[1] < 0.0;
            prop_assume!(inside);
            let sum = (0..orders).rev().fold(0.0, |sum, k| sum * h + state.coefficient(f, k).value);
            let expected = table.value().at(&at);
            // Derivatives of order m carry the rounding of 2^m differences in units of a cell, and steps are below a tenth of one.
            prop_assert!((sum - expected).abs() < 1e-13, "{sum} {expected}");
        }
    }
}

#[test]
fn what_makes_no_spline_is_refused() {
    let good = || vec![axis("x", 0.0, 1.0, 6)];
    let numbers = [0.0, 1.0, 4.0, 2.0, 0.5, 3.0];
    let refused = |axes: Vec<TableAxis>, degree: u8, numbers: &[f64], said: &str| {
        let error = TableFunction::new("f", axes, degree, numbers).expect_err(said);
        assert!(error.to_string().contains(said), "{error}");
    };
    refused(Vec::new(), 5, &[], "1 to 3 axes");
    refused(good(), 0, &numbers, "degree 0");
    refused(good(), 10, &numbers, "degree 10");
    refused(
        good(),
        5,
        &numbers[1..],
        "5 numbers, and the axes have 6 nodes",
    );
    refused(
        good(),
        7,
        &numbers,
        "takes 8 at least: take more, or degree = 5",
    );
    refused(vec![axis("x", 1.0, 0.0, 6)], 5, &numbers, "from 1.0 to 0.0");
    refused(vec![axis("x", 1.0, 1.0, 6)], 5, &numbers, "below the last");
    refused(
        vec![axis("x", f64::NAN, 1.0, 6)],
        5,
        &numbers,
        "below the last",
    );
    let mut broken = numbers;
    broken[3] = f64::NAN;
    refused(good(), 5, &broken, "node [3], counted from 0, is NaN");
    let mut closed = good();
    closed[0].is_periodic = true;
    // An even function in the middles of cells has f_0 = f_{n−1}.
    let even = [3.0, 1.0, -2.0, -2.0, 1.0, 3.0];
    assert!(TableFunction::new("f", closed, 3, &even).is_ok());
    assert!(TableFunction::new("f", good(), 5, &numbers).is_ok());
    // What the advice says serves.
    assert!(TableFunction::new("f", good(), 5, &numbers).is_ok());
}

#[test]
fn points_outside_are_named_and_have_no_value() {
    let table = smooth(2);
    assert_eq!(table.outside(&[1.0, 1.0]), None);
    let outside = table.outside(&[1.0, 1.25]).expect("outside");
    assert_eq!(
        outside.to_string(),
        "y = 1.25 lies outside the table `smooth`, which has values for y from -1.0 to 1.0"
    );
    assert!(table.value().at(&[1.0, 1.25]).is_nan());
    assert!(table.outside(&[f64::NAN, 0.0]).is_some());
    // Periods never end.
    assert_eq!(smooth(3).outside(&[1.0, 1.0, -1e6]), None);
}

/// The same table again is the table that is there.
#[test]
fn equal_tables_are_one() {
    assert_eq!(smooth(2), smooth(2));
    assert_ne!(smooth(2), smooth(1));
}
