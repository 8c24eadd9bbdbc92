//! Sums over pairs against sums written out.

use leafwise_expression::series::jet as jet_of;
use leafwise_expression::syntax::{Formula, Scope};
use leafwise_expression::{Arithmetic, Expression, Graph, Kernel, Term};

use super::{BodyFunction, BodyShape, BodySystem, PairMatrix};
use crate::evaluator::Evaluator;
use crate::system::{
    Damping, Forces, Metric, MotionClass, OpaqueSystem, Parameter, SystemFunction,
};

const FAMILIES: [&str; 3] = ["x", "y", "g"];

/// H of vortices of strengths g at (x, y), or of terms that i and j may not exchange.
const POTENTIALS: [&str; 8] = [
    "-sum(i<j, g[i]*g[j]*ln((x[i] - x[j])^2 + (y[i] - y[j])^2))/4 + a*sum(i, x[i]^2*y[i])",
    "sum(i<j, g[i]*x[i]*y[j]^2) - sum(i, y[i]^3)",
    "sum(i, g[i]*sum(j, cos(x[i] - 2*y[j]))/N) + 2",
    "sum(i, cos(x[i]))^2/N + a*sum(i<j, x[i]*x[j])^2 + sqrt(1 + sum(i, y[i]^2))",
    "sum(i<j, J[i,j]*cos(x[i] - 2*y[j])) + sum(i, J[i,i]*x[i]^2)",
    "sum(i<j, K[i,j]*cos(x[i] - x[j]) + K[j,i]*y[i]*y[j])",
    "sum(i, j, J[i,j]*x[i]*y[j] + K[i,j]*y[i]*x[j])/N",
    "sum(i<j, (J[i,i] - K[j,j])*x[i]*x[j])^2 + sum(i, x[i]*sum(j, J[j,i]*y[j]))",
];

/// A matrix without symmetry, and a symmetric one.
fn matrices(sites: usize) -> [(&'static str, Vec<f64>); 2] {
    let entry = |i: usize, j: usize| libm::sin(3.1 * i as f64 + 1.7 * (j * j) as f64 + 1.0);
    let all = || (0..sites).flat_map(|i| (0..sites).map(move |j| (i, j)));
    let symmetric = all().map(|(i, j)| entry(i.min(j), i.max(j)));
    [
        ("J", all().map(|(i, j)| entry(i, j)).collect()),
        ("K", symmetric.collect()),
    ]
}

fn shape(sites: usize) -> BodyShape {
    let matrices = matrices(sites).into_iter();
    let matrix = |(_, numbers): (_, Vec<f64>)| PairMatrix::new(numbers.into(), sites);
    BodyShape {
        families: FAMILIES.len(),
        sites,
        matrices: matrices.map(|own| matrix(own).expect("square")).collect(),
    }
}

fn scope(sites: usize) -> Scope {
    let families = FAMILIES.iter().enumerate();
    let scope = Scope::new().with_parameters(&["a"]);
    let scope = families.fold(scope, |scope, (at, name)| {
        scope.with_family(name, at * sites, sites)
    });
    let matrices = matrices(sites).into_iter();
    matrices.fold(scope, |scope, (name, numbers)| {
        scope.with_matrix(name, sites, numbers.into())
    })
}

fn function(text: &str, sites: usize) -> BodyFunction {
    let (scope, d) = (scope(sites), FAMILIES.len() * sites);
    let sums = (Formula::parse(text).expect("a formula")).pair_sums(&scope, d);
    let sums = sums.expect("sums over pairs");
    BodyFunction::of(&sums, &shape(sites))
}

fn system(text: &str, sites: usize) -> OpaqueSystem {
    system_with(text, sites, Forces::default())
}

fn system_with(text: &str, sites: usize, forces: Forces) -> OpaqueSystem {
    let one = Expression::from(1);
    let entry = Expression::Quotient(Box::new(one), Box::new(Expression::Variable(2)));
    let all = FAMILIES
        .iter()
        .flat_map(|name| (0..sites).map(move |i| format!("{name}[{i}]")));
    let system = BodySystem {
        shape: shape(sites),
        variables: all.collect(),
        parameters: vec![Parameter {
            name: "a".to_owned(),
            value: 0.3,
        }],
        bracket: vec![((0, 1), entry)],
        forces,
        hamiltonian: function(text, sites),
        casimirs: Vec::new(),
        near: Vec::new(),
    };
    system.compile().expect("code")
}

/// A state without symmetry.
fn state(sites: usize) -> Vec<f64> {
    let numbers = 0..FAMILIES.len() * sites;
    let number = |at: usize| 1.5 + libm::sin(1.7 * at as f64 + 0.3 * (at * at) as f64);
    numbers.map(number).collect()
}

/// H and −Π∇H at few sites, at those of one tile and of several, against the formula written out: sums of N² terms of size
/// 10 at most, off by N² roundings of them each.
#[test]
fn loops_have_the_values_of_the_formula_written_out() {
    for text in POTENTIALS {
        for sites in [2, 3, 9, 32, 33, 64, 75] {
            let system = system(text, sites);
            let x = state(sites);
            let written = Formula::parse(text).expect("a formula");
            let written = written
                .resolve(&scope(sites), None)
                .expect("names")
                .expect("all");
            let allowed = 1e-15 * 10.0 * (sites * sites) as f64;
            let mut numbers = system.numbers.evaluator(&[0.3]);
            let mut energy = [0.0];
            numbers.hamiltonian(&x, &mut energy).expect("a value");
            let expected = written.evaluate(&x, &[0.3]);
            let scale = 1.0 + expected.abs();
            assert!(
                (energy[0] - expected).abs() <= allowed * scale,
                "{text} {sites}: {energy:?} {expected}"
            );
            let mut field = vec![0.0; x.len()];
            let make = system.numbers.field().expect("offered");
            make(&[0.3], 1).values(&x, &mut field).expect("a value");
            let mut gradient = vec![0.0; x.len()];
            numbers.gradient(&x, &mut gradient).expect("a value");
            for i in [0, sites / 2, sites - 1] {
                for (family, other, sign) in [(0, 1, -1.0), (1, 0, 1.0)] {
                    let at = other * sites + i;
                    let slope = written.derivative(leafwise_expression::Quantity::Variable(at));
                    let slope = slope.expect("a derivative").evaluate(&x, &[0.3]);
                    let expected = sign * slope / x[2 * sites + i];
                    let found = field[family * sites + i];
                    let allowed = allowed * (scale + slope.abs());
                    assert!(
                        (found - expected).abs() <= allowed,
                        "{text} {sites} {i}: {found} {expected}"
                    );
                    assert!(
                        (gradient[at] - slope).abs() <= allowed,
                        "{text} {sites} {i}"
                    );
                }
            }
            // Parameters of sites rest.
            assert!(field[2 * sites..].iter().all(|v| *v == 0.0));
        }
    }
}

/// Pairs in the other order, where the formula has no value, do not enter: √(g_j − g_i) with g that grows along the chain.
#[test]
fn pairs_in_the_other_order_do_not_count() {
    for sites in [5, 33] {
        let system = system("sum(i<j, sqrt(g[j] - g[i])*x[i]*y[j])", sites);
        let mut x = state(sites);
        for i in 0..sites {
            x[2 * sites + i] = 1.0 + i as f64;
        }
        let mut field = vec![0.0; x.len()];
        let make = system.numbers.field().expect("offered");
        make(&[0.3], 1).values(&x, &mut field).expect("a value");
        let mut energy = [0.0];
        let mut numbers = system.numbers.evaluator(&[0.3]);
        numbers.hamiltonian(&x, &mut energy).expect("a value");
        let root = |i: usize, j: usize| libm::sqrt((j - i) as f64);
        let pairs = || (0..sites).flat_map(|j| (0..j).map(move |i| (i, j)));
        let expected: f64 = pairs().map(|(i, j)| root(i, j) * x[i] * x[sites + j]).sum();
        assert!((energy[0] - expected).abs() <= 1e-14 * expected);
        for i in 0..sites {
            // {x, y} = 1/g in the paper's sign: x' = −∂H/∂y/g.
            let slope: f64 = (0..i).map(|k| root(k, i) * x[k]).sum();
            let expected = -slope / x[2 * sites + i];
            assert!(
                (field[i] - expected).abs() <= 1e-13 * (1.0 + expected.abs()),
                "{i}"
            );
        }
    }
}

/// The field at several points has the bits of each point alone.
#[test]
fn points_side_by_side_have_the_bits_of_points_alone() {
    for text in POTENTIALS {
        for sites in [3, 30, 45] {
            let system = system(text, sites);
            let make = system.numbers.field().expect("offered");
            let x = state(sites);
            for points in [2, 3, 4, 8] {
                let at = |point: usize, c: usize| x[c] * (1.0 + 0.01 * point as f64);
                let rows: Vec<f64> = (0..x.len())
                    .flat_map(|c| (0..points).map(move |point| (point, c)))
                    .map(|(point, c)| at(point, c))
                    .collect();
                let mut together = vec![0.0; rows.len()];
                make(&[0.3], points)
                    .values(&rows, &mut together)
                    .expect("values");
                for point in 0..points {
                    let own: Vec<f64> = (0..x.len()).map(|c| at(point, c)).collect();
                    let mut alone = vec![0.0; x.len()];
                    make(&[0.3], 1).values(&own, &mut alone).expect("a value");
                    for (c, alone) in alone.iter().enumerate() {
                        assert_eq!(
                            together[c * points + point],
                            *alone,
                            "{text} {sites} {points}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn what_is_no_sum_of_pairs_is_refused() {
    for text in [
        "sum(i, x[i]*x[i+1])",
        "sum(i<j, x[i]*x[3])",
        "x[0] + sum(i, x[i])",
        "sum(i, sum(j, x[i]*x[j])^2)",
        "sum(i, sum(j, sum(k, x[i]*x[j]*x[k])))",
        "sum(i<j, J[i,j+1]*x[i]*x[j])",
        "sum(i<j, J[i,3]*x[i]*x[j])",
    ] {
        let formula = Formula::parse(text).expect("a formula");
        assert!(formula.pair_sums(&scope(9), 27).is_err(), "{text}");
    }
    let function = SystemFunction::Hessian(&[]);
    let mut numbers = system(POTENTIALS[0], 3).numbers.evaluator(&[0.3]);
    assert!(
        numbers
            .evaluate(function, &state(3), &mut [0.0; 9])
            .is_err()
    );
}

/// x_1, …, x_p of a motion against the series of the field written out, site by site. Coefficients are sums of N terms of
/// products, up to the powers of the fastest rate: those of one order are compared by the largest of them.
#[test]
fn series_of_motions_are_those_of_the_field_written_out() {
    for text in POTENTIALS {
        for (sites, order) in [(2, 9), (8, 7), (33, 2)] {
            compare_series(text, &[], (sites, order));
        }
    }
}

/// The same with forces of each kind and all together: η = a xy dx + sin(x)g dy, λ g with λ = a² and g = diag(1 + y², 2),
/// f = (−ax, x − y, −g/10).
#[test]
fn series_of_motions_with_forces_are_those_of_the_field_written_out() {
    for text in [POTENTIALS[0], POTENTIALS[3], POTENTIALS[6]] {
        for kinds in [&["forces"][..], &["damping"], &["friction"], &KINDS] {
            for (sites, order) in [(2, 6), (8, 5), (33, 2)] {
                compare_series(text, kinds, (sites, order));
            }
        }
    }
}

const KINDS: [&str; 3] = ["forces", "damping", "friction"];

/// Formulas of one site for each family: η, the diagonal of g, and f.
const OF_A_SITE: [[&str; 3]; 3] = [
    ["a*x[0]*y[0]", "sin(x[0])*g[0]", "0"],
    ["1 + y[0]^2", "2", "0"],
    ["-a*x[0]", "x[0] - y[0]", "-g[0]/10"],
];

fn of_a_site(text: &str) -> Expression {
    let formula = Formula::parse(text).expect("a formula");
    let formula = formula.resolve(&scope(1), None).expect("names");
    formula.expect("a site")
}

fn forces(kinds: &[&str]) -> Forces {
    let formulas = |kind: &str| -> Vec<Expression> {
        let at = KINDS.iter().position(|own| *own == kind).expect("known");
        match kinds.contains(&kind) {
            true => OF_A_SITE[at].map(of_a_site).into(),
            false => Vec::new(),
        }
    };
    let metric = formulas("damping");
    Forces {
        one_form: formulas("forces"),
        damping: (!metric.is_empty()).then(|| Damping {
            rate: of_a_site("a^2"),
            metric: Metric::Diagonal(metric),
        }),
        friction: formulas("friction"),
    }
}

/// −Π(∇H + η + λ g ẋ_H) + f at a site, given ∇H there; Π has the entry 1/g.
fn field_of_a_site(graph: &mut Graph, kinds: &[&str], x: &[Term], slope: &[Term]) -> Vec<Term> {
    let value = |graph: &mut Graph, kind: usize, family: usize| {
        let formula = of_a_site(OF_A_SITE[kind][family]);
        let value = formula.evaluate_in(graph, &mut |_, at| Ok(x[at].clone()));
        value.expect("code")
    };
    let turned = |graph: &mut Graph, v: &[Term]| {
        let [along, across] = [1, 0].map(|at| graph.divide(&v[at], &x[2]).expect("code"));
        [graph.negate(&along), across, graph.zero()]
    };
    let velocity = turned(graph, slope);
    let mut covector = slope.to_vec();
    for family in 0..2 {
        if kinds.contains(&"forces") {
            let force = value(graph, 0, family);
            covector[family] = graph.add(&covector[family], &force);
        }
        if kinds.contains(&"damping") {
            let rate = of_a_site("a^2").evaluate_in(graph, &mut |_, at| Ok(x[at].clone()));
            let metric = value(graph, 1, family);
            let factor = graph.multiply(&rate.expect("code"), &metric);
            let force = graph.multiply(&factor, &velocity[family]);
            covector[family] = graph.add(&covector[family], &force);
        }
    }
    let mut field = turned(graph, &covector).to_vec();
    if kinds.contains(&"friction") {
        for (family, own) in field.iter_mut().enumerate() {
            let friction = value(graph, 2, family);
            *own = graph.add(own, &friction);
        }
    }
    field
}

fn compare_series(text: &str, kinds: &[&str], (sites, order): (usize, usize)) {
    let system = system_with(text, sites, forces(kinds));
    let is_moved = system.numbers.motion() != MotionClass::Hamiltonian;
    assert_eq!(is_moved, !kinds.is_empty());
    let x = state(sites);
    let (d, unit) = (x.len(), 0.125);
    let make = system.numbers.jets().expect("offered");
    let jet = make(order).expect("code");
    let mut found = vec![0.0; order * d];
    let mut evaluator = jet.map.evaluator(&[0.3], 1.0, unit);
    evaluator.values(&x, &mut found).expect("a series");
    let written = Formula::parse(text).expect("a formula");
    let written = written.resolve(&scope(sites), None).expect("names");
    let mut graph = Graph::compilable();
    let variable = &mut |graph: &mut Graph, at: usize| Ok(graph.input(at));
    let energy = written.expect("all").evaluate_in(&mut graph, variable);
    let gradient = graph.gradient(&energy.expect("code"), d).expect("code");
    let mut field = vec![graph.zero(); d];
    for i in 0..sites {
        let places = [0, 1, 2].map(|family| family * sites + i);
        let x = places.map(|at| graph.input(at));
        let slope = places.map(|at| gradient[at].clone());
        let own = field_of_a_site(&mut graph, kinds, &x, &slope);
        places
            .into_iter()
            .zip(own)
            .for_each(|(at, own)| field[at] = own);
    }
    let expected = jet_of(&mut graph, &field, order).expect("code").concat();
    let kernel = Kernel::compile(&graph, &expected, 1, d);
    let mut workspace = kernel.workspace(1);
    kernel.prepare(&mut workspace, &[0.3], &[1.0], &[unit]);
    let mut expected = vec![0.0; order * d];
    kernel.evaluate(&mut workspace, &x, &mut expected);
    let mut field = vec![0.0; d];
    let make = system.numbers.field().expect("offered");
    make(&[0.3], 1).values(&x, &mut field).expect("a value");
    field.iter_mut().for_each(|v| *v *= unit);
    let found = std::iter::once(&field[..]).chain(found.chunks(d));
    let expected = std::iter::once(&expected[..d]).chain(expected.chunks(d));
    for (k, (found, expected)) in found.zip(expected).enumerate() {
        let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
            assert!(
                (found - expected).abs() <= 1e-13 * k.max(1) as f64 * largest,
                "{text} {kinds:?} {sites} x_{k}[{i}]: {found} {expected}"
            );
        }
    }
}

/// Bounds on rounding errors are those of the field written out, but for the order of sums.
#[test]
fn bounds_on_rounding_errors_hold() {
    for text in POTENTIALS {
        let system = system(text, 9);
        let (x, mut bounds) = (state(9), vec![0.0; 27]);
        let jet = system.numbers.jets().expect("offered")(2).expect("code");
        let errors = vec![0.0; 27];
        jet.rounding.bounds(&[0.3], &x, &errors, &mut bounds);
        let make = system.numbers.field().expect("offered");
        let mut field = vec![0.0; 27];
        make(&[0.3], 1).values(&x, &mut field).expect("a value");
        for (bound, field) in bounds.iter().zip(&field).take(18) {
            let least = 0.5 * f64::EPSILON * field.abs();
            assert!(
                *bound >= least && *bound <= 1e-12 * (1.0 + field.abs()),
                "{text} {bound:e} {field}"
            );
        }
    }
}
