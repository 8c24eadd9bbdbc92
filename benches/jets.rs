//! Times of jets of tables: a value with all its derivatives up to an order, at a point in each of eight lanes.
//!
//! `cargo bench -p leafwise-benches --bench jets` prints the nanoseconds that all eight lanes take, and one of them. Points wander over a table
//! of degree 5 with 33 nodes along each axis.

#![allow(clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use leafwise::expression::table::TableAxis;
use leafwise::expression::{Arithmetic, Execution, Graph, Kernel, TableFunction, Term};

const LANES: usize = 8;
const NODES: usize = 33;
const DEGREE: u8 = 5;

/// Groups of eight points, and passes over all of them.
const GROUPS: usize = 512;
const PASSES: usize = 40;

fn main() {
    for dimension in [1, 2, 3] {
        for order in [1, 2, 3] {
            let (outputs, seconds) = measured(dimension, order);
            println!(
                "{dimension}-D, orders to {order}, {outputs} numbers: {:.0} ns for eight lanes, {:.0} ns a jet",
                seconds * 1e9,
                seconds * 1e9 / LANES as f64
            );
        }
    }
}

/// A smooth function at the nodes.
fn table(dimension: usize) -> TableFunction {
    let axis = |at: usize| TableAxis {
        name: ["x", "y", "z"][at].to_owned(),
        first: 0.0,
        last: 1.0,
        nodes: NODES,
        is_periodic: false,
    };
    let axes: Vec<TableAxis> = (0..dimension).map(axis).collect();
    let count: usize = axes.iter().map(|axis| axis.nodes).product();
    let number = |at: usize| {
        let mut phase = 0.0;
        let mut rest = at;
        for axis in 0..dimension {
            phase += (axis + 2) as f64 * (rest % NODES) as f64 / NODES as f64;
            rest /= NODES;
        }
        libm::sin(phase)
    };
    let numbers: Vec<f64> = (0..count).map(number).collect();
    TableFunction::new("f", axes, DEGREE, &numbers).expect("a table")
}

/// The numbers of a jet, and the least seconds that eight of them took in a pass.
fn measured(dimension: usize, order: usize) -> (usize, f64) {
    let mut graph = Graph::new();
    let inputs: Vec<Term> = (0..dimension).map(|at| graph.input(at)).collect();
    let value = graph
        .look_up(table(dimension).value(), &inputs)
        .expect("code");
    // Derivatives by indices that do not fall, each once.
    let mut outputs = vec![value.clone()];
    let mut last = vec![(value, 0)];
    for _ in 0..order {
        let mut next = Vec::new();
        for (term, from) in &last {
            for along in *from..dimension {
                next.push((graph.derivative(term, along).expect("code"), along));
            }
        }
        outputs.extend(next.iter().map(|(term, _)| term.clone()));
        last = next;
    }
    let kernel = Kernel::compile(&graph, &outputs, 0, dimension);
    let mut workspace = kernel.workspace_for(LANES, Execution::Compiled);
    kernel.prepare(&mut workspace, &[], &[1.0; LANES], &[1.0; LANES]);
    let mut values = vec![0.0; outputs.len() * LANES];
    let group = |group: usize| -> Vec<f64> {
        let part = |at: usize| 0.5 + 0.49 * libm::sin((group * dimension * LANES + at) as f64);
        (0..dimension * LANES).map(part).collect()
    };
    let points: Vec<Vec<f64>> = (0..GROUPS).map(group).collect();
    let mut least = f64::INFINITY;
    for _ in 0..PASSES {
        let begin = Instant::now();
        for point in &points {
            kernel.evaluate(&mut workspace, black_box(point), &mut values);
            black_box(&mut values);
        }
        least = least.min(begin.elapsed().as_secs_f64() / GROUPS as f64);
    }
    (outputs.len(), least)
}
