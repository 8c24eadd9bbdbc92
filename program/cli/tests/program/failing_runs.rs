//! A run that leaves a domain: exit code 1, the step, the state, what to try, and everything
//! recorded before it on disk.

use crate::support::{BODY, Place};

/// Runs a scene that must fail, and returns the object it prints.
fn fails(scene: &str, pieces: &[&str]) -> (Place, serde_json::Value) {
    let here = Place::with(scene);
    let said = here.leafwise(&["run", "scene.toml", "--json"]);
    assert_eq!(said.code, Some(1), "{}{}", said.out, said.err);
    said.says(&["failed at t =", "state before it:", "= help:", "runs/scene"]);
    said.says(&["= more: leafwise explain failed steps"]);
    said.says(pieces);
    let json = said.json();
    assert_eq!(json["outcome"], "failed");
    let (steps, failed) = (json["steps"].as_u64(), json["error"]["step"].as_u64());
    assert_eq!(failed, steps.map(|steps| steps + 1));
    // Every sample up to the last good state is there, and the last one is that state.
    let samples = here.read("runs/scene/samples.csv");
    let last: Vec<f64> = samples
        .lines()
        .last()
        .expect("a sample")
        .split(',')
        .map(|cell| cell.parse().expect("a number"))
        .collect();
    let state: Vec<f64> = json["error"]["state"]
        .as_array()
        .expect("a state")
        .iter()
        .map(|value| value.as_f64().expect("a number"))
        .collect();
    assert_eq!(last[1..=state.len()], state);
    let manifest = here.read("runs/scene/manifest.json");
    assert!(manifest.contains("\"outcome\": \"failed\""));
    assert!(
        here.read("runs/scene/report.html")
            .contains("Failed at step")
    );
    (here, json)
}

/// A particle on a line, {q, p} = -1, in a potential.
fn particle(potential: &str, initial: &str, step: &str) -> String {
    format!(
        "[system]\nvariables = [\"q\", \"p\"]\nbracket = {{ \"q,p\" = \"-1\" }}\n\
         hamiltonian = \"p^2/2 + {potential}\"\n[method]\nrealization = \"auto\"\n\
         dynamics = {{ name = \"hamilton-jacobi\", order = 2 }}\ntime-step = {step}\n[run]\n\
         initial = {initial}\nsteps = 1000\n"
    )
}

#[test]
fn the_logarithm_of_a_negative_number_ends_the_run() {
    // A constant force toward the pole: q turns negative after about 14 steps.
    let (_, json) = fails(
        &particle("q + 1e-9*ln(q)", "[1, 0]", "0.1"),
        &["energy has no finite value"],
    );
    let steps = json["steps"].as_u64().expect("a count");
    assert!((10..20).contains(&steps), "{steps} steps");
}

/// Where no step can be taken nothing is integrated and nothing written.
#[test]
fn a_start_without_a_motion_is_refused_where_it_stands() {
    const ADVICE: &str = "check `initial` and the parameters";
    let zero = particle("k*q^2/m", "[1, 0]", "0.1")
        .replace("[method]", "parameters = { k = 1, m = 0 }\n[method]");
    let starts = [
        (
            particle("q + ln(q)", "[-1, 0]", "0.1"),
            "the energy has no value",
            ADVICE,
        ),
        (particle("1/q", "[0, 1]", "0.1"), "dp/dt is", ADVICE),
        (particle("sqrt(q)", "[0, 1]", "0.1"), "dp/dt is", ADVICE),
        (
            zero,
            "dp/dt is -inf, where `m` is 0",
            "give it another value",
        ),
    ];
    for (scene, message, advice) in starts {
        let here = Place::with(&scene);
        let said = here.leafwise(&["run", "scene.toml"]);
        assert_eq!(said.code, Some(3), "{scene}{}", said.err);
        said.says(&["scene.toml:", "at the initial state", message, advice]);
        assert!(!said.err.contains("step 1"), "{}", said.err);
        assert!(here.is_untouched(), "something was written");
    }
}

#[test]
fn a_step_outside_the_chart_ends_the_run() {
    // At 2 a solution inside exists beside others; at 4 there is none.
    let scene = BODY.replace("time-step   = 0.1", "time-step   = 4.0");
    fails(&scene, &["reduce `time-step`"]);
}

#[test]
fn a_solve_that_does_not_converge_ends_the_run() {
    // The implicit midpoint rule with a quadratic force: near the blow-up its equation, quadratic
    // in the midpoint, has no real solution.
    let (_, json) = fails(
        &particle("(-q^3)", "[1, 1]", "0.2"),
        &[
            "the solution of the step's equation that begins at the state was lost",
            "reduce `time-step`",
        ],
    );
    assert_eq!(json["solver"]["failures"], 1);
}

#[test]
fn a_failed_run_is_not_overwritten_by_accident() {
    let (here, _) = fails(&particle("q + 1e-9*ln(q)", "[1, 0]", "0.1"), &[]);
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(2));
    said.says(&["has failed", "--force"]);
}

/// A realization without an order has none that could be raised; what is said instead helps.
#[test]
fn an_exact_realization_is_not_told_to_raise_its_order() {
    let scene = "[system]\nlibrary = \"heavy-top\"\n[method]\nrealization = \"clebsch\"\n\
                 dynamics = { name = \"collective\", stages = 8 }\ntime-step = 3.0\n\
                 [run]\ninitial = [0.5, 1.0, 1.5, 0.6, 0.0, 0.8]\nsteps = 20\n";
    fails(scene, &["no convergence", "help: reduce `time-step`\n"]);
    let here = Place::with(&scene.replace("time-step = 3.0", "time-step = 0.3"));
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
}

/// The help names the keys that the scene has.
#[test]
fn what_to_reduce_is_named_as_in_the_scene() {
    let scene = BODY.replace("time-step   = 0.1", "epsilon = 0.5\nh = 8.0");
    fails(&scene, &["reduce `h`"]);
}
