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

/// An open plane of spins that is a lattice of its own.
const PLANE: &str = r#"[system]
families = { s = { components = ["x", "y", "z"], length = [5, 6] } }
boundary = "open"
bracket = { lie-algebra = "so3" }
hamiltonian = "-sum(i, j, s.x[i,j]*s.x[i+1,j] + s.z[i,j]*s.z[i,j+1])"
[method]
stepper = "splitting"
time-step = 0.05
[run]
steps = 1
[run.initial]
"s.x[i,j]" = "0.6*cos(pi*j/8)"
"s.y[i,j]" = "0.6*sin(pi*j/8)"
"s.z[i,j]" = 0.8
"#;

/// By `--set` without quotes, and as a direction of a sweep; each row is that run.
#[test]
fn one_site_is_set_by_its_key() {
    let observables = "[{ one = \"s.x[2,3]\" }, { next = \"s.y[2,2]\" }]";
    let here = Place::with(&format!(
        "{PLANE}[sweep]\nrecord = {{ observables = {observables} }}\n[sweep.grid]\n\"run.initial.s.x[2,3]\" = [0.1, 0.2]\n"
    ));
    let swept = here.leafwise(&["sweep", "scene.toml", "--out", "sweep"]);
    assert_eq!(swept.code, Some(0), "{}", swept.err);
    let table = here.read("sweep/sweep.csv");
    here.write("scene.toml", PLANE);
    for (value, row) in ["0.1", "0.2"].into_iter().zip(table.lines().skip(1)) {
        let set = format!("run.initial.s.x[2,3]={value}");
        let record = format!("run.record.observables={observables}");
        let said = here.leafwise(&[
            "run",
            "scene.toml",
            "--force",
            "--out",
            "run",
            "--set",
            &set,
            "--set",
            &record,
        ]);
        assert_eq!(said.code, Some(0), "{}", said.err);
        let samples = here.read("run/samples.csv");
        let rows: Vec<Vec<&str>> = samples
            .lines()
            .map(|row| row.split(',').collect())
            .collect();
        assert_eq!(rows[1][1], value);
        for of_last in &rows[2][1..] {
            assert!(
                row.split(',').any(|cell| cell == *of_last),
                "{row}\n{samples}"
            );
        }
    }
}

#[test]
fn terms_beyond_the_ends_of_a_plane_are_told_by_rows() {
    let here = Place::with(PLANE);
    let said = here.leafwise(&["check", "scene.toml"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    for shown in [
        "s.z[i,j]*s.z[i,j+1]  of sites [:,5]",
        "s.x[i,j]*s.x[i+1,j]  of sites [4,:]",
    ] {
        assert!(said.out.contains(shown), "{}", said.out);
    }
}

/// The advice cures.
#[test]
fn a_plane_is_made_short_as_the_message_says() {
    let here = Place::with(PLANE);
    let shorter = "system.families.s.length=[2,4]";
    for command in ["shadow", "evaluate"] {
        let refused = here.leafwise(&[command, "scene.toml"]);
        assert_eq!(refused.code, Some(2), "{}", refused.err);
        refused.says(&[&format!("--set {shorter}")]);
    }
    let short = here.leafwise(&["shadow", "scene.toml", "--set", shorter]);
    assert_eq!(short.code, Some(0), "{}", short.err);
    // A method of another kind has a realization.
    let method = "method={ realization = \"auto\", dynamics = { name = \"hamilton-jacobi\", order = 2 }, time-step = 0.05 }";
    let short = here.leafwise(&["evaluate", "scene.toml", "--set", shorter, "--set", method]);
    assert_eq!(short.code, Some(0), "{}", short.err);
}

/// Of a lattice that is stepped by sweeps the advice has a short one, and asks no other method to step it.
#[test]
fn spins_in_sublattices_run_at_any_length() {
    for sites in [8, 10, 12, 16, 20, 30] {
        let scene = format!(
            "[system]\nfamilies = {{ s = {{ components = [\"x\", \"y\", \"z\"], length = {sites} }} }}\n\
             bracket = {{ lie-algebra = \"so3\" }}\nhamiltonian = \"-sum(i, dot(s[i], s[i+1]))\"\n\
             [method]\nstepper = \"sublattices\"\ntime-step = 0.05\n[run]\nsteps = 20\n\
             initial = {{ \"s.x[i]\" = 0.6, \"s.y[i]\" = \"0.8*cos(i)\", \"s.z[i]\" = \"0.8*sin(i)\" }}\n"
        );
        let said = Place::with(&scene).leafwise(&["run", "scene.toml"]);
        assert_eq!(said.code, Some(0), "{sites}: {}", said.err);
    }
}

/// The motion of a site of a lattice with an open axis no longer than twice what H couples along it.
#[test]
fn short_open_axes_have_a_motion() {
    for offset in [9, 10, 15, 19] {
        let scene = format!(
            "[system]\nfamilies = {{ q = [20, 30], p = [20, 30] }}\nbracket = \"canonical\"\nboundary = \"open\"\n\
             hamiltonian = \"sum(i, j, p[i,j]^2/2 + q[i,j]*q[i+{offset},j])\"\n\
             [method]\nstepper = \"splitting\"\ntime-step = 0.01\n[run]\nsteps = 2\n\
             initial = {{ \"q[i,j]\" = 1, \"p[i,j]\" = 0 }}\n"
        );
        let said = Place::with(&scene).leafwise(&["check", "scene.toml"]);
        assert_eq!(said.code, Some(0), "{offset}: {}", said.err);
    }
}
