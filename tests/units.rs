//! Units: a system with every coordinate, the time and the energy in other units takes the same steps, to the bit where units
//! differ by powers of two, to round-off elsewhere, or is refused alike.

use std::cell::Cell;
use std::fmt::Write as _;

use leafwise::core::Registry;
use leafwise::run::{Asked, Quiet, RunOutcome, run_in_memory};
use leafwise::scene::compose;
use leafwise_tests::numbers::UNIT_ROUNDOFF;
use leafwise_tests::scenes::document;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

const STEPS: usize = 12;

/// A system whose formulas name its coordinates in brackets, and its methods.
struct Problem {
    variables: &'static [&'static str],
    bracket: &'static [(usize, usize, &'static str)],
    hamiltonian: &'static str,
    /// A one-form beside dH.
    forces: &'static [&'static str],
    initial: &'static [f64],
    time_step: f64,
    methods: &'static [&'static str],
    /// Coordinates that its methods take in one unit alone.
    in_one_unit: &'static [usize],
}

const EVERYWHERE: [&str; 20] = [
    "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }",
    "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }",
    "realization = { name = \"karasev-truncated\", order = 4 }\ndynamics = { name = \"hamilton-jacobi\", order = 2 }",
    "realization = { name = \"karasev-truncated\", order = 2 }\ndynamics = \"collective\"",
    "realization = \"karasev-collocated\"\ndynamics = { name = \"hamilton-jacobi\", order = 4 }",
    "realization = \"auto\"\ndynamics = { name = \"collective\", integrator = \"gauss\" }",
    "stepper = { name = \"gauss\", stages = 2 }",
    "stepper = \"implicit-midpoint\"",
    "stepper = \"energy-preserving\"",
    "stepper = \"rk4\"",
    "realization = \"auto\"\ndynamics = { name = \"collective\", integrator = \"stormer-verlet\" }",
    "realization = \"auto\"\ndynamics = { name = \"collective\", integrator = \"implicit-midpoint\" }",
    "realization = \"karasev-collocated\"\ndynamics = { name = \"collective\", integrator = \"gauss\" }",
    "realization = { name = \"karasev-truncated\", order = 2 }\ndynamics = { name = \"collective\", correction = \"none\" }",
    "realization = \"auto\"\ndynamics = { name = \"hamilton-jacobi\", order = 2 }\ncomposition = \"kahan-li-8\"",
    "stepper = \"taylor\"",
    "stepper = \"dop853\"",
    "stepper = \"dormand-prince45\"",
    "stepper = \"splitting\"",
    "stepper = \"splitting\"\ncomposition = \"blanes-moan-6\"",
];

/// Those without splittings, whose flows are checked at points where coordinates that are 0 are moved by the largest, in
/// whatever units: about two bodies the refusal is another one in some.
const WITHOUT_SPLITTINGS: &[&str] = EVERYWHERE.split_at(EVERYWHERE.len() - 2).0;

const WITH_FORCES: [&str; 7] = [
    "realization = \"auto\"\ndynamics = \"one-form\"",
    "realization = \"karasev-collocated\"\ndynamics = \"one-form\"",
    "stepper = { name = \"gauss\", stages = 2 }",
    "stepper = \"rk4\"",
    "stepper = \"taylor\"",
    "stepper = \"dop853\"",
    "stepper = \"dormand-prince45\"",
];

/// Methods that choose their own substeps. Those of `taylor` have half of a double's digits, 10⁻⁷ of a tolerance in which is
/// more than round-off where the tolerance is large.
const WITH_A_TOLERANCE: [&str; 5] = [
    "stepper = \"taylor\"",
    "stepper = { name = \"taylor\", tolerance = 1e-10 }",
    "stepper = \"dop853\"",
    "stepper = { name = \"dop853\", tolerance = 1e-6 }",
    "stepper = \"dormand-prince45\"",
];

const MIDPOINT: [&str; 1] = ["stepper = \"spherical-midpoint\""];

const PROBLEMS: [Problem; 10] = [
    // Two bodies in the plane, one a thousand times as heavy, from rest at one of them.
    Problem {
        variables: &["x", "y", "X", "Y", "a", "b", "A", "B"],
        bracket: &[(0, 4, "1"), (1, 5, "1"), (2, 6, "1"), (3, 7, "1")],
        hamiltonian: "([a]^2+[b]^2)/2*1000 + ([A]^2+[B]^2)/2 - 0.001/sqrt(([x]-[X])^2+([y]-[Y])^2)",
        forces: &[],
        initial: &[1.0, 0.0, 0.0, 0.0, 0.0, 0.00095, 0.0, -0.00095],
        time_step: 0.05,
        methods: WITHOUT_SPLITTINGS,
        in_one_unit: &[],
    },
    // A pendulum beside a body on a spring.
    Problem {
        variables: &["q", "p", "u", "v"],
        bracket: &[(0, 1, "1"), (2, 3, "1")],
        hamiltonian: "[p]^2/2 - cos([q]) + [v]^2/6 + 5*[u]^2 + [q]*[u]/3",
        forces: &[],
        initial: &[0.0, 1.25, 0.0, 0.5],
        time_step: 0.1,
        methods: &EVERYWHERE,
        in_one_unit: &[],
    },
    // A rigid body.
    Problem {
        variables: &["k", "l", "m"],
        bracket: &[(0, 1, "-[m]"), (1, 2, "-[k]"), (2, 0, "-[l]")],
        hamiltonian: "[k]^2/2 + [l]^2/3 + [m]^2/5",
        forces: &[],
        initial: &[0.1, 1.5, -0.25],
        time_step: 0.1,
        methods: &EVERYWHERE,
        in_one_unit: &[],
    },
    // Predators and prey.
    Problem {
        variables: &["x", "y"],
        bracket: &[(0, 1, "[x]*[y]")],
        hamiltonian: "[x] - ln([x]) + [y]/2 - 2*ln([y])",
        forces: &[],
        initial: &[0.5, 3.0],
        time_step: 0.05,
        methods: &EVERYWHERE,
        in_one_unit: &[],
    },
    // A charge in a magnetic field.
    Problem {
        variables: &["x", "y", "v", "w"],
        bracket: &[(0, 2, "1"), (1, 3, "1"), (2, 3, "1.5 + [x]/4")],
        hamiltonian: "[v]^2/2 + [w]^2/2 + [x]*[y]/8 + [x]^2/4 + [y]^2/4",
        forces: &[],
        initial: &[0.75, 0.0, 0.0, 0.5],
        time_step: 0.05,
        methods: &EVERYWHERE,
        in_one_unit: &[],
    },
    // A pendulum with friction that drives another.
    Problem {
        variables: &["q", "p", "u", "v"],
        bracket: &[(0, 1, "1"), (2, 3, "1")],
        hamiltonian: "[p]^2/2 - cos([q]) + [v]^2/6 - cos([u])",
        forces: &["[p]/5", "0", "[q]/3", "0"],
        initial: &[0.0, 1.25, 0.0, 0.5],
        time_step: 0.1,
        methods: &WITH_FORCES,
        in_one_unit: &[],
    },
    // A heavy top.
    Problem {
        variables: &["k", "l", "m", "x", "y", "z"],
        bracket: &[
            (0, 1, "-[m]"),
            (1, 2, "-[k]"),
            (2, 0, "-[l]"),
            (0, 4, "-[z]"),
            (1, 5, "-[x]"),
            (2, 3, "-[y]"),
            (1, 3, "[z]"),
            (2, 4, "[x]"),
            (0, 5, "[y]"),
        ],
        hamiltonian: "[k]^2/2 + [l]^2/3 + [m]^2/5 + [z] + [x]/5",
        forces: &[],
        initial: &[0.1, 1.5, -0.25, 0.6, 0.0, 0.8],
        time_step: 0.05,
        methods: &EVERYWHERE,
        in_one_unit: &[],
    },
    // Six bodies on springs, of which one is displaced: the others begin as powers of the time up to the tenth.
    Problem {
        variables: &["a", "b", "c", "d", "e", "f", "A", "B", "C", "D", "E", "F"],
        bracket: &[
            (0, 6, "1"),
            (1, 7, "1"),
            (2, 8, "1"),
            (3, 9, "1"),
            (4, 10, "1"),
            (5, 11, "1"),
        ],
        hamiltonian: "([A]^2+[B]^2+[C]^2+[D]^2+[E]^2+[F]^2)/2 + (([b]-[a])^2+([c]-[b])^2+([d]-[c])^2+([e]-[d])^2+([f]-[e])^2)/2 \
                      + ([b]-[a])^4/8",
        forces: &[],
        initial: &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        time_step: 0.1,
        methods: &WITH_A_TOLERANCE,
        in_one_unit: &[],
    },
    // A body on a spring that is pulled as the fourth power of a time of its own, from rest.
    Problem {
        variables: &["x", "t", "p", "e"],
        bracket: &[(0, 2, "1"), (1, 3, "1")],
        hamiltonian: "[p]^2/2 + [x]^2/2 - [x]*[t]^4 + [e]",
        forces: &[],
        initial: &[0.0, 0.0, 0.0, 0.0],
        time_step: 0.1,
        methods: &WITH_A_TOLERANCE,
        in_one_unit: &[],
    },
    // A rigid body, its momenta in one unit.
    Problem {
        variables: &["k", "l", "m"],
        bracket: &[(0, 1, "-[m]"), (1, 2, "-[k]"), (2, 0, "-[l]")],
        hamiltonian: "[k]^2/2 + [l]^2/3 + [m]^2/5",
        forces: &[],
        initial: &[0.1, 1.5, -0.25],
        time_step: 0.1,
        methods: &MIDPOINT,
        in_one_unit: &[0, 1, 2],
    },
];

/// Coordinates of the longest problem.
const MOST: usize = 12;

impl Problem {
    /// The formula with its coordinates in other units, which are parameters: formulas are written alike in any units.
    fn formula(&self, text: &str) -> String {
        let each = self.variables.iter().enumerate();
        each.fold(text.to_owned(), |text, (i, name)| {
            text.replace(&format!("[{name}]"), &format!("({name}/U{})", self.unit(i)))
        })
    }

    /// The coordinate whose unit is that of coordinate i.
    fn unit(&self, i: usize) -> usize {
        match self.in_one_unit {
            [first, ..] if self.in_one_unit.contains(&i) => *first,
            _ => i,
        }
    }
}

/// Units of the coordinates, the time and the energy: powers of a base.
#[derive(Clone, Debug)]
struct Units {
    base: f64,
    coordinates: Vec<i32>,
    time: i32,
    energy: i32,
}

impl Units {
    fn value(&self, exponent: i32) -> f64 {
        match self.base {
            2.0 => libm::exp2(exponent.into()),
            _ => format!("1e{exponent}").parse().expect("a number"),
        }
    }

    fn parameters(&self) -> String {
        let of = |name: String, exponent: i32| format!("{name} = {:e}", self.value(exponent));
        let coordinates = self.coordinates.iter().enumerate();
        let coordinates = coordinates.map(|(i, exponent)| of(format!("U{i}"), *exponent));
        let others = [
            of("T0".to_owned(), self.time),
            of("E0".to_owned(), self.energy),
        ];
        coordinates.chain(others).collect::<Vec<_>>().join(", ")
    }
}

/// The scene of a problem in these units, its step so many times as long.
fn scene(problem: &Problem, method: &str, units: &Units, step: f64) -> String {
    let variables = problem.variables;
    let mut bracket = String::new();
    for (i, j, entry) in problem.bracket {
        let (a, b, entry) = (variables[*i], variables[*j], problem.formula(entry));
        let (i, j) = (problem.unit(*i), problem.unit(*j));
        let _ = write!(bracket, "\"{a},{b}\" = \"U{i}*U{j}/(T0*E0)*({entry})\", ");
    }
    let forces = problem.forces.iter().enumerate();
    let forces: Vec<String> = forces
        .map(|(i, force)| format!("E0/U{}*({})", problem.unit(i), problem.formula(force)))
        .collect();
    let forces = match forces.is_empty() {
        true => String::new(),
        false => format!("forces = {forces:?}\n"),
    };
    let pairs = problem.initial.iter().zip(&units.coordinates);
    let initial: Vec<f64> = pairs.map(|(x, unit)| x * units.value(*unit)).collect();
    format!(
        "[system]\nvariables = {variables:?}\nparameters = {{ {} }}\nbracket = {{ {bracket} }}\nconvention = \"{{x,H}}\"\n\
         hamiltonian = \"E0*({})\"\n{forces}[method]\n{method}\ntime-step = {:e}\n\
         [run]\ninitial = {initial:?}\nsteps = {STEPS}\n",
        units.parameters(),
        problem.formula(problem.hamiltonian),
        step * problem.time_step * units.value(units.time),
    )
}

/// Coordinates of each sample in the problem's own units, or how the run failed.
fn run(problem: &Problem, method: &str, units: &Units, step: f64) -> Result<Vec<Vec<f64>>, String> {
    let registry = Registry::with_builtin();
    let document = document(&scene(problem, method, units, step), &[]);
    let without_numbers = |text: &str| -> String {
        let letters = text
            .chars()
            .filter(|c| !c.is_numeric() && *c != '-' && *c != 'e');
        letters.collect()
    };
    let refused = |text: String| format!("refused: {}", without_numbers(&text));
    let composed = compose(&document, &registry).map_err(|error| refused(error.to_string()))?;
    let recorded = run_in_memory(
        &document,
        &composed,
        &registry,
        Asked::default(),
        &mut Quiet,
    )
    .map_err(|error| refused(error.to_string()))?;
    if let RunOutcome::Failed(failure) = &recorded.report.outcome {
        let why = without_numbers(&failure.message);
        return Err(format!(
            "failed after {} steps: {why}",
            recorded.report.steps
        ));
    }
    let rows = recorded.samples.chunks_exact(recorded.columns.len());
    let coordinates = |row: &[f64]| -> Vec<f64> {
        let own = row[1..].iter().zip(&units.coordinates);
        own.map(|(x, unit)| x / units.value(*unit)).collect()
    };
    Ok(rows.map(coordinates).collect())
}

/// Whether a problem takes the same steps in these units and in its own, and whether there were any.
fn compare(
    problem: &Problem,
    method: &str,
    units: &Units,
    step: f64,
) -> Result<bool, TestCaseError> {
    let own = Units {
        coordinates: vec![0; units.coordinates.len()],
        time: 0,
        energy: 0,
        ..*units
    };
    let [here, there] = [&own, units].map(|units| run(problem, method, units, step));
    let place = format!("{method} of {:?}, {units:?}", problem.variables);
    let (here, there) = match (here, there) {
        (Ok(here), Ok(there)) => (here, there),
        (here, there) => {
            prop_assert_eq!(here.err(), there.err(), "{}", place);
            return Ok(false);
        }
    };
    // Powers of two change no bit of a solve; where it starts by extrapolation, the order that serves the largest coordinate
    // best may be another one, and another start ends within round-off.
    if units.base == 2.0 && method.starts_with("stepper") {
        prop_assert_eq!(here, there, "{}", place);
        return Ok(true);
    }
    // Each step rounds formulas of some twenty operations of numbers about as large as the coordinates, and what it
    // rounds grows by e² at most over the run.
    let bound = 20.0 * 8.0 * STEPS as f64 * UNIT_ROUNDOFF;
    for coordinate in 0..problem.variables.len() {
        let of =
            |rows: &[Vec<f64>]| -> Vec<f64> { rows.iter().map(|row| row[coordinate]).collect() };
        let (here, there) = (of(&here), of(&there));
        let size = here.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (a, b) in here.iter().zip(&there) {
            let error = (a - b).abs();
            prop_assert!(
                error <= bound * size,
                "{place}, coordinate {coordinate}: {a:e} and {b:e}"
            );
        }
    }
    Ok(true)
}

/// How many of so many drawn problems, methods and units were compared.
fn compared(base: f64, largest: i32, steps: Vec<f64>, cases: u32) -> u32 {
    let mut runner = TestRunner::new(Config {
        cases,
        failure_persistence: None,
        ..Config::default()
    });
    let exponent = || -largest..=largest;
    let drawn = (
        0..PROBLEMS.len(),
        any::<prop::sample::Index>(),
        prop::collection::vec(exponent(), MOST),
        exponent(),
        exponent(),
        prop::sample::select(steps),
    );
    let count = Cell::new(0);
    let outcome = runner.run(
        &drawn,
        |(problem, method, mut coordinates, time, energy, step)| {
            let problem = &PROBLEMS[problem];
            coordinates.truncate(problem.variables.len());
            for at in problem.in_one_unit {
                coordinates[*at] = coordinates[problem.unit(*at)];
            }
            let units = Units {
                base,
                coordinates,
                time,
                energy,
            };
            let is_compared = compare(
                problem,
                problem.methods[method.index(problem.methods.len())],
                &units,
                step,
            )?;
            count.set(count.get() + u32::from(is_compared));
            Ok(())
        },
    );
    outcome.unwrap_or_else(|error| panic!("{error}"));
    count.get()
}

#[test]
fn units_that_are_powers_of_two_change_no_bit() {
    let compared = compared(2.0, 60, vec![0.5, 1.0, 2.0], 90);
    assert!(compared > 80, "{compared}");
}

#[test]
fn units_change_nothing_but_round_off() {
    let compared = compared(10.0, 30, vec![0.5, 1.0, 2.0], 75);
    assert!(compared > 65, "{compared}");
}
