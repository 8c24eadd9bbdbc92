//! Scenes with noise: the same bytes however an ensemble is cut, and what is refused beside noise.

use crate::support::Place;

const SPIN: &str = "\
[system]
variables   = [\"x\", \"y\", \"z\"]
parameters  = { s = 0.4 }
bracket     = { lie-algebra = \"so3\" }
hamiltonian = \"-z\"
casimirs    = { length = \"x^2 + y^2 + z^2\" }
noise       = [{ hamiltonian = \"x\", strength = \"s\" }, { hamiltonian = \"y\", strength = \"s\" }]
[method]
realization = \"auto\"
time-step   = 0.1
[run]
initial = [0.6, 0, 0.8]
steps   = 40
seed    = 3
[ensemble]
members      = 200
seed         = 9
parameters   = { s = { uniform = [0.2, 0.5] } }
record       = { every = 10, observables = [\"energy\", \"x*y\"] }
final-states = \"csv\"
";

const FILES: [&str; 3] = ["statistics.csv", "windows.csv", "final_states.csv"];

#[test]
fn a_noisy_ensemble_has_the_same_bytes_on_any_threads_and_in_any_shards() {
    for way in ["joint", "split"] {
        let here = Place::with(&SPIN.replace("[run]", &format!("noise = \"{way}\"\n[run]")));
        let whole = here.leafwise(&["ensemble", "scene.toml", "--out", "whole", "--threads", "1"]);
        assert_eq!(whole.code, Some(0), "{}", whole.err);
        let two = here.leafwise(&["ensemble", "scene.toml", "--out", "two", "--threads", "2"]);
        assert_eq!(two.code, Some(0), "{}", two.err);
        for part in ["2/3", "1/3", "3/3"] {
            let said =
                here.leafwise(&["ensemble", "scene.toml", "--out", "parts", "--shard", part]);
            assert_eq!(said.code, Some(0), "{}", said.err);
        }
        let merged = here.leafwise(&["merge", "parts", "--out", "merged"]);
        assert_eq!(merged.code, Some(0), "{}", merged.err);
        for file in FILES {
            let whole = here.read(&format!("whole/{file}"));
            for other in ["two", "merged"] {
                assert!(
                    whole == here.read(&format!("{other}/{file}")),
                    "{way}: {other}/{file}"
                );
            }
        }
    }
}

/// Members whose parameters leave no strength, or no damping, are no members; their numbers are told.
#[test]
fn members_out_of_the_domain_of_noise_and_damping_fail() {
    let damped = SPIN.replace(
        "noise       = [{ hamiltonian = \"x\", strength = \"s\" }, { hamiltonian = \"y\", strength = \"s\" }]",
        "damping = { rate = \"s\" }",
    );
    let damped = damped.replace("seed    = 3\n", "");
    for (scene, values, failed, message) in [
        (
            SPIN,
            "[0.4, -0.4, 0]",
            2,
            "the strength of a channel of noise is -0.4",
        ),
        (
            &damped,
            "[0.4, -0.4, 0]",
            1,
            "the rate of the damping is -0.4",
        ),
    ] {
        let here = Place::with(scene);
        let drawn = format!("ensemble.parameters={{ s = {{ values = {values} }} }}");
        let asked = [
            "--set",
            "ensemble.members=3",
            "--set",
            &drawn,
            "--out",
            "out",
            "--quiet",
        ];
        let said = here.leafwise(&[&["ensemble", "scene.toml"][..], &asked].concat());
        let failures = here.read("out/failures.csv");
        assert_eq!(
            failures.lines().count(),
            1 + failed,
            "{failures}\n{}",
            said.err
        );
        assert!(failures.contains(message), "{failures}");
        let alone =
            here.leafwise(&[&["ensemble", "scene.toml", "--member", "1"][..], &asked].concat());
        assert_eq!(alone.code, Some(3), "{}", alone.err);
        alone.says(&[message]);
    }
}

#[test]
fn a_member_alone_draws_what_it_draws_in_its_ensemble() {
    let here = Place::with(SPIN);
    let said = here.leafwise(&["ensemble", "scene.toml", "--out", "whole", "--quiet"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    let states = here.read("whole/final_states.csv");
    let heading: Vec<&str> = states
        .lines()
        .next()
        .expect("a heading")
        .split(',')
        .collect();
    let x = heading.iter().position(|name| *name == "x").expect("x");
    let mut ends = Vec::new();
    for member in [0, 7, 199] {
        let number = member.to_string();
        let alone = ["ensemble", "scene.toml", "--member", &number, "--json"];
        let said = here.leafwise(&alone);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let samples = here.read(&format!("runs/scene-member-{number}/samples.csv"));
        let last: Vec<&str> = samples
            .lines()
            .last()
            .expect("a sample")
            .split(',')
            .collect();
        let row: Vec<&str> = states
            .lines()
            .nth(member + 1)
            .expect("a row")
            .split(',')
            .collect();
        let own = samples
            .lines()
            .next()
            .expect("a heading")
            .split(',')
            .position(|name| name == "x");
        assert_eq!(last[own.expect("x")], row[x], "member {number}");
        ends.push(row[x].to_owned());
    }
    ends.dedup();
    assert_eq!(ends.len(), 3, "members draw the same: {ends:?}");
}

#[test]
fn a_run_tells_its_noise_and_that_the_energy_is_not_kept() {
    let here = Place::with(SPIN);
    let said = here.leafwise(&["run", "scene.toml", "--explain", "--out", "one"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    said.says(&[
        "weak order 1; Stratonovich, seed 3",
        "Noise of x, o dW",
        "changes by the noise; Casimirs are kept to round-off",
    ]);
    assert!(!said.err.contains("warning"), "{}", said.err);
    let other = here.leafwise(&["run", "scene.toml", "--set", "run.seed=4", "--out", "other"]);
    assert_eq!(other.code, Some(0), "{}", other.err);
    assert!(here.read("one/samples.csv") != here.read("other/samples.csv"));
    let checked = here.leafwise(&["check", "scene.toml", "--json"]).json();
    assert_eq!(checked["noise"][1]["field"]["z"], "-s*x");
}

#[test]
fn what_noise_has_no_meaning_for_is_refused() {
    let here = Place::with(SPIN);
    let cases = [
        ("run.stop=\"z < 0\"", "`stop` is not offered with noise"),
        (
            "run.section={ at = \"z = 0\" }",
            "a section is not offered with noise",
        ),
        (
            "run.record={ times = [0.25] }",
            "`times` are not offered with noise",
        ),
        (
            "method.pace=\"1 + x^2\"",
            "a pace is not offered with noise",
        ),
        ("method.time-step=-0.1", "noise runs forward in time"),
        (
            "system.parameters.s=0",
            "the strength of a channel of noise is 0.0",
        ),
        (
            "system.noise=[{ hamiltonian = \"x\", strength = \"1 + x^2\" }]",
            "a formula of the parameters",
        ),
        (
            "run.record={ observables = [\"shadow-energy\"] }",
            "every step follows another Hamiltonian",
        ),
    ];
    for (change, message) in cases {
        let said = here.leafwise(&["run", "scene.toml", "--set", change]);
        assert_eq!(said.code, Some(3), "{change}: {}", said.err);
        said.says(&[message]);
    }
    let split = [
        "method.noise=\"split\"",
        "system.noise=[{ hamiltonian = \"x*y*z\", strength = 1 }]",
    ];
    let said = here.leafwise(&["run", "scene.toml", "--set", split[0], "--set", split[1]]);
    assert_eq!(said.code, Some(3), "{}", said.err);
    said.says(&[
        "needs the exact flow of every channel",
        "`x*y*z`",
        "noise = \"joint\"",
    ]);
    let commands: [&[&str]; 5] = [
        &["compare", "scene.toml"],
        &["tune", "scene.toml", "--error", "1e-6"],
        &["tune", "scene.toml", "--shadow", "1e-6"],
        &["shadow", "scene.toml"],
        &["evaluate", "scene.toml", "--x", "1,2,3", "--p", "1,2,3"],
    ];
    for command in commands {
        let said = here.leafwise(command);
        assert_eq!(said.code, Some(3), "{command:?}: {}", said.err);
        said.says(&["of a system with noise"]);
    }
    let said = here.leafwise(&["verify", "scene.toml"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&["of a system with noise"]);
    assert!(here.is_untouched());
}
