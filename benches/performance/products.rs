//! A step of a product whose Hamiltonian couples no summands against the sum of its summands' steps.

use std::fmt::Write as _;
use std::hint::black_box;

use leafwise::core::Walk;
use leafwise_benches::composed;

use crate::accuracy::ratio;
use crate::document::{Table, time};
use crate::measure::{Run, interleaved};

const ROUNDS: usize = 41;

/// Steps in one sample.
const STEPS: usize = 200;

/// Steps before the first sample.
const WARM_UP: u64 = 2000;

/// A factor: its name, variables, bracket, Hamiltonian and state; `#` stands for its number in a product.
struct Summand {
    name: &'static str,
    variables: &'static [&'static str],
    bracket: &'static str,
    hamiltonian: &'static str,
    initial: &'static [f64],
}

const BODY: Summand = Summand {
    name: "body",
    variables: &["x#", "y#", "z#"],
    bracket: "{ lie-algebra = \"so3\" }",
    hamiltonian: "x#^2/2 + y#^2/4 + z#^2/6",
    initial: &[1.0, 0.5, -0.7],
};

const PENDULUM: Summand = Summand {
    name: "pendulum",
    variables: &["q#", "p#"],
    bracket: "{ \"q#,p#\" = \"-1\" }",
    hamiltonian: "p#^2/2 - cos(q#)",
    initial: &[1.0, 0.0],
};

const SPECIES: Summand = Summand {
    name: "species",
    variables: &["u#", "v#"],
    bracket: "{ log-canonical = [[0, 1], [-1, 0]] }",
    hamiltonian: "u# - ln(u#) + v# - ln(v#)",
    initial: &[1.2, 0.8],
};

const PRODUCTS: [&[&Summand]; 4] = [
    &[&BODY, &PENDULUM],
    &[&BODY, &SPECIES],
    &[&BODY, &BODY, &PENDULUM],
    &[&BODY, &BODY, &PENDULUM, &SPECIES],
];

const ORDERS: [usize; 3] = [2, 4, 6];

/// A scene of these summands.
fn scene(summands: &[(usize, &Summand)], order: usize) -> String {
    let (mut variables, mut brackets, mut energies, mut initial) = (vec![], vec![], vec![], vec![]);
    for (number, summand) in summands {
        let own = |text: &str| text.replace('#', &number.to_string());
        let names: Vec<String> = summand.variables.iter().map(|v| own(v)).collect();
        brackets.push(format!(
            "{{ variables = {names:?}, bracket = {} }}",
            own(summand.bracket)
        ));
        variables.extend(names);
        energies.push(own(summand.hamiltonian));
        initial.extend_from_slice(summand.initial);
    }
    let bracket = match summands {
        [(number, one)] => one.bracket.replace('#', &number.to_string()),
        _ => format!("{{ sum = [{}] }}", brackets.join(", ")),
    };
    format!(
        "[system]\nvariables = {variables:?}\nbracket = {bracket}\nhamiltonian = \"{}\"\n[method]\nrealization = \"auto\"\n\
         dynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\ntime-step = 0.05\n[run]\ninitial = {initial:?}\n\
         steps = 1\n",
        energies.join(" + ")
    )
}

fn walk(summands: &[(usize, &Summand)], order: usize) -> Walk {
    let mut walk = composed(&scene(summands, order)).walk();
    walk.advance(WARM_UP).expect("steps");
    walk
}

/// The table of all products.
pub fn table() -> String {
    let mut table = Table::new(&[
        "product",
        "m",
        "d",
        "its summands",
        "product",
        "ratio",
        "of operations",
    ]);
    for summands in PRODUCTS {
        let numbered: Vec<_> = (1..).zip(summands.iter().copied()).collect();
        let mut name = String::new();
        for summand in summands {
            let sign = if name.is_empty() { "" } else { " × " };
            write!(name, "{sign}{}", summand.name).expect("a string");
        }
        for order in ORDERS {
            let mut all: Vec<Walk> = numbered.iter().map(|one| walk(&[*one], order)).collect();
            all.push(walk(&numbered, order));
            let mut runs: Vec<Run<'_>> = Vec::new();
            for walk in &mut all {
                runs.push(Box::new(|| {
                    walk.advance(STEPS as u64).expect("steps");
                    black_box(walk.state());
                }));
            }
            let times = interleaved(&mut runs, ROUNDS);
            drop(runs);
            let (product, parts) = (summands.len(), 0..summands.len());
            let sum: f64 = parts.clone().map(|at| times.seconds(at).median).sum();
            let operations =
                |at: usize| all[at].statistics().operations_per_step().expect("counted");
            let of_operations = operations(product) / parts.clone().map(operations).sum::<f64>();
            table.row(&[
                name.clone(),
                order.to_string(),
                all[product].state().len().to_string(),
                time(sum / STEPS as f64),
                time(times.seconds(product).median / STEPS as f64),
                ratio(times.over_sum(product, parts.clone())),
                format!("{of_operations:.3}"),
            ]);
        }
    }
    table.finish()
}
