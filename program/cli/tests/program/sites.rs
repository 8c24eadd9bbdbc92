//! Parameters of every site: what they do to runs.

use crate::support::Place;

/// A chain with springs of its own at every site.
const CHAIN: &str = r#"[system]
families    = { q = 8, p = 8 }
parameters  = { "J[i]" = { file = "j.csv" } }
bracket     = { "q[i],p[i]" = "-1" }
boundary    = "periodic"
hamiltonian = "sum(i, p[i]^2/2 + J[i]*(q[i+1] - q[i])^2/2)"
[method]
realization = "auto"
dynamics    = { name = "hamilton-jacobi", order = 2 }
time-step   = 0.1
[run]
initial = { "q[i]" = "sin(2*pi*i/N)", "p[i]" = 0 }
steps   = 20
"#;

const VALUES: &str = "1\n1.5\n2\n2.5\n3\n2.5\n2\n1.5\n";

fn samples(scene: &str, length: usize) -> String {
    let scene = scene.replace("= 8", &format!("= {length}"));
    let scene = scene.replace(
        "steps   = 20\n",
        "steps   = 20\nrecord = { states = [\"q\"] }\n",
    );
    let here = Place::with(&scene);
    let rows: Vec<&str> = VALUES.lines().cycle().take(length).collect();
    here.write("j.csv", &rows.join("\n"));
    let said = here.leafwise(&["run", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    here.read("runs/scene/samples.csv")
}

/// They are a family that no bracket moves, which nothing shows; written out and by templates.
#[test]
fn parameters_of_sites_are_a_family_at_rest() {
    let at_rest = CHAIN
        .replace("p = 8 }", "p = 8, J = 8 }")
        .replace("parameters  = { \"J[i]\" = { file = \"j.csv\" } }\n", "")
        .replace(
            "\"p[i]\" = 0",
            "\"p[i]\" = 0, \"J[i]\" = { file = \"j.csv\" }",
        );
    for length in [8, 48] {
        assert_eq!(samples(CHAIN, length), samples(&at_rest, length));
    }
}

#[test]
fn a_run_is_not_continued_with_other_numbers() {
    let here = Place::with(CHAIN);
    here.write("j.csv", VALUES);
    let run = |steps: &str| here.leafwise(&["run", "scene.toml", "--set", steps]);
    assert_eq!(run("run.steps=20").code, Some(0));
    assert_eq!(run("run.steps=30").code, Some(0));
    here.write("j.csv", &VALUES.replace("2.5", "2.25"));
    let said = run("run.steps=40");
    assert_eq!(said.code, Some(2), "{}", said.err);
    said.says(&["other numbers in j.csv", "--force"]);
}
