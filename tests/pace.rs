//! A pace: variable steps that are Poisson maps in a fictitious time, and states at given times between them.

#![allow(
    clippy::print_stdout,
    reason = "measured numbers, read with --nocapture"
)]

use leafwise::core::StepMap;
use leafwise::core::diagnostics::TensorDefect;
use leafwise_tests::numbers::{UNIT_ROUNDOFF, distance, largest};
use leafwise_tests::orders::measure;
use leafwise_tests::scenes::composed;

use crate::runs::{Table, ran};

/// Enright and Pryce's D5 at T = 20, as printed.
const D5: [f64; 4] = [
    -1.295266250987574,
    0.4003938963792321,
    -0.6775390924707566,
    -0.1270838154278686,
];

/// τ of a period, ∮ dt/r^{3/2}, is ∫₀^{2π} (1 − e cos E)^{−1/2} dE: 200 steps of it.
fn two_hundredth(eccentricity: f64) -> f64 {
    // The trapezoidal rule converges geometrically for periodic functions.
    let points = 4096;
    let angle = |k: i32| 2.0 * std::f64::consts::PI * f64::from(k) / f64::from(points);
    let value = |k: i32| 1.0 / libm::sqrt(1.0 - eccentricity * libm::cos(angle(k)));
    let sum: f64 = (0..points).map(value).sum();
    2.0 * std::f64::consts::PI * sum / f64::from(points) / 200.0
}

const KEPLER: &str = "library = \"kepler\"";

/// A body at the pericentre of an ellipse of this eccentricity.
fn pericentre(e: f64) -> [f64; 4] {
    [1.0 - e, 0.0, 0.0, libm::sqrt((1.0 + e) / (1.0 - e))]
}

fn scene(system: &str, method: &str, initial: &[f64], run: &str) -> String {
    format!("[system]\n{system}\n[method]\n{method}\n[run]\ninitial = {initial:?}\n{run}\n")
}

/// `hamilton-jacobi` of this order with steps of r^{3/2} Δτ.
fn kepler(order: usize, step: f64) -> String {
    format!(
        "dynamics = {{ name = \"hamilton-jacobi\", order = {order} }}\npace = \"(q1^2 + q2^2)^0.75\"\ntime-step = {step:?}"
    )
}

#[test]
fn keplers_problem_d5_is_solved_to_1e_12_in_fewer_than_a_thousand_steps() {
    let text = scene(KEPLER, &kepler(8, 0.03), &pericentre(0.9), "until = 20");
    let (report, table) = ran(&text, &[]);
    let error = distance(&report.final_state, &D5);
    println!(
        "{} steps, error {error:.1e}, of t {:?}",
        report.steps, report.step_times
    );
    assert!(report.steps <= 1000, "{}", report.steps);
    assert!(error <= 1e-12, "{error:e}");
    assert_eq!(report.time, 20.0);
    let samples = table("samples.csv");
    let last = |name: &str| *samples[name].last().expect("the end");
    assert_eq!(last("t"), 20.0);
    assert_eq!(["q1", "q2", "p1", "p2"].map(last), report.final_state[..]);
    // r runs from 0.1 to 1.9, r^{3/2} over a factor of 83.
    let [least, most] = report.step_times.expect("different steps");
    assert!((70.0..90.0).contains(&(most / least)), "{least} {most}");
}

/// The energy error of an exactly Poisson map in τ is bounded, and is the same at every passage of the pericentre.
#[test]
fn the_energy_error_stays_what_it_is_over_many_periods() {
    let periods = 40.0;
    let until = periods * 2.0 * std::f64::consts::PI;
    for (order, bound) in [(4, 1e-6), (8, 1e-12)] {
        let method = kepler(order, two_hundredth(0.9));
        let run = format!(
            "until = {until:?}\nrecord = {{ interval = {:?} }}",
            until / 8.0
        );
        let (report, table) = ran(&scene(KEPLER, &method, &pericentre(0.9), &run), &[]);
        let windows = &table("windows.csv")["energy"];
        let drift = report.invariants[0].maximum;
        let most = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
        let tenth = windows.len() / 10;
        let (first, last) = (
            most(&windows[..tenth]),
            most(&windows[windows.len() - tenth..]),
        );
        let growth = last / first;
        println!(
            "order {order}: {} steps of {periods} periods, energy {drift:.1e}, growth {growth:.2}",
            report.steps
        );
        // 200 a period, and the step that passes the end.
        assert!(report.steps.abs_diff(8000) <= 2, "{}", report.steps);
        assert!(drift <= bound, "order {order}: {drift:e}");
        // At order 8 what is left is a random walk of round-off.
        assert!(order == 8 || growth < 1.05, "order {order}: {growth}");
    }
}

/// After a period of 2π the body is where it was; there it is fastest, and Δt of the time is an error |v| Δt of the place.
#[test]
fn an_eccentricity_of_0_99_returns_after_its_period() {
    let start = pericentre(0.99);
    let until = 2.0 * std::f64::consts::PI;
    let run = format!("until = {until:?}");
    let (report, _) = ran(
        &scene(KEPLER, &kepler(8, two_hundredth(0.99)), &start, &run),
        &[],
    );
    let error = distance(&report.final_state, &start) / largest(start);
    println!("e = 0.99: {} steps, error {error:.1e}", report.steps);
    // At most one more: that which passes the end.
    assert!(report.steps.abs_diff(200) <= 1, "{}", report.steps);
    assert!(error < 1e-5, "{error:e}");
    let finer = kepler(8, 0.25 * two_hundredth(0.99));
    let (report, _) = ran(&scene(KEPLER, &finer, &start, &run), &[]);
    let error = distance(&report.final_state, &start) / largest(start);
    println!("e = 0.99: {} steps, error {error:.1e}", report.steps);
    assert!(error < 1e-9, "{error:e}");
}

/// On states at the same t the order is that of the map in τ.
#[test]
fn states_at_a_given_time_have_the_order_of_the_method() {
    for (order, steps) in [
        (2, [0.02, 0.015, 0.01, 0.0075, 0.005]),
        (4, [0.06, 0.045, 0.03, 0.0225, 0.015]),
        (6, [0.12, 0.09, 0.06, 0.045, 0.03]),
    ] {
        let error = |step: &f64| {
            let text = scene(
                KEPLER,
                &kepler(order, *step),
                &pericentre(0.9),
                "until = 20",
            );
            (*step, distance(&ran(&text, &[]).0.final_state, &D5))
        };
        let points: Vec<_> = steps.iter().map(error).collect();
        let found = measure(&points, 512.0 * UNIT_ROUNDOFF, 2.0).expect("errors above round-off");
        println!("order {order}: {found}");
        assert!(
            found.is(order as f64, 2.0),
            "order {order}: {found}: {points:?}"
        );
    }
}

/// DΦ Π DΦᵀ = Π for the map in τ of (x, t, e), on K = 0 and off it.
#[test]
fn the_map_of_the_fictitious_time_is_exactly_poisson() {
    for order in [2, 4] {
        let run = composed(&scene(
            KEPLER,
            &kepler(order, 0.05),
            &pericentre(0.6),
            "steps = 1",
        ));
        let values = run.system.parameter_values();
        let map: &dyn StepMap = run.method.map();
        let mut instrument =
            TensorDefect::new(&run.system, map, &values, 1.0, 0.05).expect("an instrument");
        let mut off = run.plan.initial.clone();
        off[5] += 0.25;
        for state in [&run.plan.initial, &off] {
            let defect = instrument.measure(state).expect("a step");
            let relative = defect.relative().expect("a tensor that is not 0");
            assert!(relative < 1e-12, "order {order}: {relative:e}");
        }
    }
}

/// States at given times are read off steps of their own: those of the run are the same to the bit with and without them.
#[test]
fn records_at_given_times_do_not_disturb_the_steps() {
    let method = kepler(6, 0.07);
    let end = |record: &str| {
        let run = format!("until = 9.5\n{record}");
        let (report, table) = ran(&scene(KEPLER, &method, &pericentre(0.7), &run), &[]);
        (report, table("samples.csv"))
    };
    let (without, all) = end("");
    let (with, samples) = end("record = { interval = 0.25 }");
    assert_eq!(without.final_state, with.final_state);
    assert_eq!(without.steps, with.steps);
    let expected: Vec<f64> = (0..=38).map(|k| 0.25 * f64::from(k)).collect();
    assert_eq!(samples["t"], expected);
    // Every step that ends before the end is a sample where none is asked for.
    assert_eq!(all["t"].len() as u64, without.steps + 1);
    // The energy of a state between two steps errs like that of steps.
    let energy = |table: &Table| {
        let values = &table["energy"];
        largest(values.iter().map(|value| value - values[0]))
    };
    let (between, at_steps) = (energy(&samples), energy(&all));
    assert!(between <= 2.0 * at_steps, "{between:e} {at_steps:e}");
}

/// Times that are written have their samples, however near to the end that is written too; multiples of an interval that come to
/// the end but for rounding are the end.
#[test]
fn given_times_next_to_the_end_have_samples_of_their_own() {
    let times = |run: &str| {
        let run = format!("until = 2\nrecord = {{ {run} }}");
        let (_, table) = ran(&scene(KEPLER, &kepler(4, 0.1), &pericentre(0.5), &run), &[]);
        table("samples.csv")["t"].clone()
    };
    let near = 2.0 - 9e-15;
    let found = times(&format!("times = [1, {near:?}, 2]"));
    assert_eq!(found, [0.0, 1.0, near, 2.0]);
    let found = times(&format!("times = [1, {near:?}]"));
    assert_eq!(found, [0.0, 1.0, near, 2.0]);
    let third = 2.0 / 3.0 - 1e-16;
    let found = times(&format!("interval = {third:?}"));
    assert_eq!((found.len(), found[3]), (4, 2.0));
}

/// x″ = −x − 0.1 cos t at a pace that names both the state and the time: g = 1/(1 + q² + sin²t).
#[test]
fn a_pace_and_a_hamiltonian_may_both_name_the_time() {
    let system = "variables = [\"q\", \"p\"]\nbracket = { \"q,p\" = \"1\" }\nconvention = \"{x,H}\"\n\
                  hamiltonian = \"p^2/2 + q^2/2 + 0.1*q*cos(t)\"";
    let t = 10.0;
    let (sin, cos) = (libm::sin(t), libm::cos(t));
    let exact = [
        cos + 0.5 * sin - t * sin / 20.0,
        -sin + 0.5 * cos - sin / 20.0 - t * cos / 20.0,
    ];
    let error = |step: f64| {
        let method = format!(
            "dynamics = {{ name = \"hamilton-jacobi\", order = 4 }}\npace = \"1/(1 + q^2 + sin(t)^2)\"\ntime-step = {step:?}"
        );
        let (report, _) = ran(&scene(system, &method, &[1.0, 0.5], "until = 10"), &[]);
        (step, distance(&report.final_state, &exact))
    };
    let points: Vec<_> = [0.4, 0.3, 0.2, 0.15, 0.1].map(error).to_vec();
    let found = measure(&points, 64.0 * UNIT_ROUNDOFF, 2.0).expect("errors above round-off");
    println!("{found}");
    assert!(found.is(4.0, 2.0), "{found}: {points:?}");
}
