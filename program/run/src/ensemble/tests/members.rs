//! Where members begin, and how many there are.

use std::fs;

use super::*;

/// Points of a grid are not held in memory.
#[test]
fn a_grid_larger_than_memory_is_refused_by_its_number_and_read_by_place() {
    let grid = |more: &str| {
        let ranges =
            "{ I1 = { range = [1, 2, 100_000_000] }, I2 = { range = [1, 3, 100_000_001] } }";
        let document = scene(METHODS[0], &format!("parameters = {ranges}\n{more}"));
        compose_ensemble(&document, &Registry::with_builtin(), Path::new(""))
    };
    let refusal = grid("").err().expect("too many");
    assert!(
        refusal
            .message
            .contains("10000000100000000 members, at most"),
        "{}",
        refusal.message
    );
    let refusal = grid("members = 7").err().expect("not the grid");
    assert!(
        refusal.message.contains("do not fill the grid"),
        "{}",
        refusal.message
    );
    let document = scene(
        METHODS[0],
        "parameters = { I1 = { range = [1, 2, 100_000_001] } }",
    );
    let registry = Registry::with_builtin();
    let ensemble = compose_ensemble(&document, &registry, Path::new("")).expect("an ensemble");
    let drawn = |member| ensemble.population.draw(member).expect("a state").1[0];
    assert_eq!(
        [drawn(0), drawn(50_000_000), drawn(100_000_000)],
        [1.0, 1.5, 2.0]
    );
}

#[test]
fn members_are_where_their_distribution_has_them() {
    let norm = |v: &[f64]| libm::sqrt(v.iter().map(|v| v * v).sum());
    let states = |initial: &str| -> Vec<Vec<f64>> {
        let document = scene(METHODS[0], &format!("members = 400\ninitial = {initial}"));
        let population = composed(&document).population;
        let draw = |member| population.draw(member).expect("a state").0;
        (0..population.members()).map(draw).collect()
    };
    let center = [1.0, 3.0, 3.0];
    let away = |state: &[f64]| {
        let difference: Vec<f64> = state.iter().zip(center).map(|(x, c)| x - c).collect();
        norm(&difference)
    };
    let radii: Vec<f64> = states("{ ball = 0.5 }").iter().map(|s| away(s)).collect();
    assert!(radii.iter().all(|r| *r <= 0.5 + 1e-15));
    // (r/R)³ is uniform: its mean over 400 lies within five standard errors of ½.
    let mean = radii.iter().map(|r| 8.0 * r * r * r).sum::<f64>() / 400.0;
    assert!(
        (mean - 0.5).abs() < 5.0 / libm::sqrt(12.0 * 400.0),
        "{mean}"
    );
    for state in states("{ sphere = 2, center = [0, 0, 0] }") {
        assert!((norm(&state) - 2.0).abs() < 1e-15 * 4.0);
    }
    for state in states("{ leaf = 0.3 }") {
        assert!((norm(&state) - libm::sqrt(19.0)).abs() < 4.0 * f64::EPSILON * 4.4);
    }
    for state in states("{ box = [0.1, 0, 2] }") {
        assert!((state[0] - 1.0).abs() <= 0.1 && state[1] == 3.0 && (state[2] - 3.0).abs() <= 2.0);
    }
    assert_ne!(states("{ normal = 0.1 }")[0], states("{ normal = 0.1 }")[1]);
    assert_eq!(states("{ normal = 0.1 }")[7], states("{ normal = 0.1 }")[7]);
}

/// {x, y} = 1 on four coordinates has corank 2; one Casimir does not fix a leaf, z and w do, and neither
/// units nor a function of them change that.
#[test]
fn a_leaf_needs_as_many_casimirs_as_the_corank() {
    let registry = Registry::with_builtin();
    for (casimirs, independent) in [
        ("z = \"z\"", Some(1)),
        ("z = \"z\", square = \"z^2 + 1e30*z\"", Some(1)),
        ("z = \"z\", w = \"1e-30*w\"", None),
    ] {
        let text = format!(
            "[system]\nvariables = [\"x\", \"y\", \"z\", \"w\"]\nbracket = {{ \"x,y\" = \"1e20\" }}\n\
             hamiltonian = \"x^2 + y^2\"\ncasimirs = {{ {casimirs} }}\n[method]\nstepper = \"rk4\"\n\
             time-step = 1e-22\n[run]\ninitial = [1, 2, 3, 4]\nsteps = 1\n[ensemble]\nmembers = 3\n\
             initial = {{ leaf = 0.1 }}\n"
        );
        let document =
            SceneDocument::parse("scene.toml", &text, &Registry::empty()).expect("a scene");
        let composed = compose_ensemble(&document, &registry, Path::new(""));
        match (composed, independent) {
            (Ok(ensemble), None) => {
                let (state, _) = ensemble.population.draw(1).expect("a state");
                assert!((state[2] - 3.0).abs() < 1e-15 && (state[3] - 4.0).abs() < 1e-15);
            }
            (Err(refusal), Some(count)) => {
                let message = &refusal.message;
                let said = format!("{count} independent Casimirs");
                assert!(
                    message.contains("has 2 equations") && message.contains(&said),
                    "{message}"
                );
            }
            (composed, _) => panic!("{casimirs}: {}", composed.is_ok()),
        }
    }
}

/// Where the leaf is flat beside r, ρ²/r² of a ball's projection from 3 dimensions onto it is distributed by
/// u ↦ 1 − (1 − u)^(3/2), of mean 2/5 and variance 12/175: not uniform over the disc, which has the mean 1/2, and 0
/// at the rim.
#[test]
fn members_of_a_leaf_are_a_balls_projection_along_the_casimirs() {
    const MEMBERS: f64 = 4000.0;
    let radius = 0.01;
    let ensemble = format!("members = {MEMBERS}\ninitial = {{ leaf = {radius} }}");
    let population = composed(&scene(METHODS[0], &ensemble)).population;
    let square = |u: &[f64]| u.iter().map(|v| v * v).sum::<f64>();
    let mut parts: Vec<f64> = (0..population.members())
        .map(|member| {
            let (state, _) = population.draw(member).expect("a state");
            let away: Vec<f64> = state
                .iter()
                .zip([1.0, 3.0, 3.0])
                .map(|(x, c)| x - c)
                .collect();
            square(&away) / (radius * radius)
        })
        .collect();
    parts.sort_by(f64::total_cmp);
    // Five standard deviations of the mean; curvature moves ρ by a part of (r/|c|)² = r²/19.
    let bend = radius * radius / 19.0;
    let mean = parts.iter().sum::<f64>() / MEMBERS;
    assert!(
        (mean - 0.4).abs() <= 5.0 * libm::sqrt(12.0 / 175.0 / MEMBERS) + bend,
        "{mean}"
    );
    // Kolmogorov's distance of N draws exceeds 2.5/√N with probability 2 exp(−12.5) = 7e-6.
    let distance = parts.iter().enumerate().fold(0.0_f64, |most, (below, u)| {
        let expected = 1.0 - libm::pow((1.0 - u).max(0.0), 1.5);
        let found = [below as f64 / MEMBERS, (below + 1) as f64 / MEMBERS];
        found
            .iter()
            .fold(most, |most, f| most.max((f - expected).abs()))
    });
    assert!(
        distance <= 2.5 / libm::sqrt(MEMBERS) + 2.0 * bend,
        "{distance}"
    );
}

/// x² + y² − z² = −1/4 has two sheets, and a state that is drawn beyond the cone between them comes to the other one:
/// what a leaf's members share is the Casimir's value.
#[test]
fn a_leaf_is_met_by_its_values_on_either_sheet() {
    let text = "[system]\nvariables = [\"x\", \"y\", \"z\"]\n\
                bracket = { \"x,y\" = \"-z\", \"y,z\" = \"x\", \"z,x\" = \"y\" }\nhamiltonian = \"z\"\n\
                casimirs = { surface = \"x^2 + y^2 - z^2\" }\n[method]\nstepper = \"rk4\"\ntime-step = 0.1\n\
                [run]\ninitial = [0, 0, 0.5]\nsteps = 1\n[ensemble]\nmembers = 400\n";
    for (radius, reaches_the_other) in [(0.1, false), (1.5, true)] {
        let text = format!("{text}initial = {{ leaf = {radius} }}\n");
        let document =
            SceneDocument::parse("scene.toml", &text, &Registry::empty()).expect("a scene");
        let population = composed(&document).population;
        let states: Vec<_> = (0..400).filter_map(|k| population.draw(k).ok()).collect();
        for (state, _) in &states {
            let [x, y, z] = [state[0], state[1], state[2]];
            let surface = x * x + y * y - z * z;
            // Each square is rounded, and x to what its last correction left of it.
            let noise = 8.0 * f64::EPSILON * (x * x + y * y + z * z);
            assert!((surface + 0.25).abs() <= noise, "{state:?}: {surface}");
        }
        let others = states.iter().filter(|(state, _)| state[2] < 0.0).count();
        assert_eq!(others > 0, reaches_the_other);
    }
}

#[test]
fn files_and_grids_set_the_number_of_members() {
    let root = tempfile::tempdir().expect("a directory");
    fs::write(root.path().join("states.csv"), "x1,x2,x3\n1,2,3\n4,5,6\n").expect("writable");
    let grid = "initial = { file = \"states.csv\" }\n\
                parameters = { I1 = { range = [1, 2, 3] }, I2 = { values = [0.5, 0.75] } }";
    let document = scene(METHODS[0], grid);
    let ensemble = compose_ensemble(&document, &Registry::with_builtin(), root.path());
    let population = ensemble.expect("an ensemble").population;
    assert_eq!(population.members(), 12);
    let own = "x1,x2,x3,I2\n1,2,3,0.5\n4,5,6,0.75\n";
    fs::write(root.path().join("own.csv"), own).expect("writable");
    fs::write(root.path().join("unknown.csv"), own.replace("I2", "I4")).expect("writable");
    let drawn: Vec<_> = (0..12)
        .map(|k| population.draw(k).expect("a state"))
        .collect();
    assert_eq!(drawn[1], (vec![1.0, 2.0, 3.0], vec![1.0, 0.75, 1.25]));
    assert_eq!(drawn[8], (vec![4.0, 5.0, 6.0], vec![1.5, 0.5, 1.25]));
    for (ensemble, said) in [
        ("initial = { ball = 1 }", "[ensemble] needs `members`"),
        (
            "members = 13\ninitial = { file = \"states.csv\" }",
            "13 members, and the file has states for 2",
        ),
        (
            "members = 5\nparameters = { I1 = { values = [1, 2] } }",
            "5 members do not fill the grid of 2",
        ),
        (
            "members = 5\ninitial = { file = \"absent.csv\" }",
            "cannot read",
        ),
        (
            "initial = { file = \"own.csv\" }\nparameters = { I2 = { values = [1] } }",
            "`I2` has a value for each member already",
        ),
        (
            "initial = { file = \"unknown.csv\" }",
            "its column `I4` is neither one of the coordinates x1, x2, x3 nor a parameter",
        ),
        (
            "members = 5\nrecord = { observables = [\"enrgy\"] }",
            "unknown observable `enrgy`",
        ),
    ] {
        let document = scene(METHODS[0], ensemble);
        let refusal = compose_ensemble(&document, &Registry::with_builtin(), root.path());
        let message = refusal.err().expect(ensemble).message;
        assert!(message.contains(said), "{message}");
    }
}

/// A file's columns under the names of parameters, and the same numbers in memory, are the same members.
#[test]
fn members_in_memory_are_those_of_a_file() {
    let root = tempfile::tempdir().expect("a directory");
    let rows = "I2,x1,x2,x3\n0.5,1,2,3\n0.75,4,5,6\n0.9,-1,0.5,2\n";
    fs::write(root.path().join("members.csv"), rows).expect("writable");
    let registry = Registry::with_builtin();
    let keep = "final-states = \"csv\"";
    let of_file = scene(
        METHODS[1],
        &format!("initial = {{ file = \"members.csv\" }}\n{keep}"),
    );
    let of_file = (
        compose_ensemble(&of_file, &registry, root.path()).expect("an ensemble"),
        of_file,
    );
    let members = Members {
        states: Some(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -1.0, 0.5, 2.0]),
        parameters: vec![("I2".to_owned(), vec![0.5, 0.75, 0.9])],
    };
    // A number of members and a distribution are those of others.
    let of_memory = scene(
        METHODS[1],
        &format!("members = 7\ninitial = {{ leaf = 0.1 }}\n{keep}"),
    );
    let of_memory = (
        compose_members(&of_memory, &registry, &members).expect("an ensemble"),
        of_memory,
    );
    let left = [&of_file, &of_memory].map(|(ensemble, document)| {
        let out = tempfile::tempdir().expect("a directory");
        let options = options(&out.path().join("out"));
        let (all, progress) = (workforce(2, 2), &mut crate::Quiet);
        let job = EnsembleJob::new(document, ensemble, Portion::default(), &options, all);
        let report = perform(&job.expect("a job"), progress).expect("a run");
        assert_eq!(report.reductions.members, 3);
        fs::read_to_string(options.directory.join("final_states.csv")).expect("a file")
    });
    assert_eq!(left[0], left[1]);
    assert!(
        left[0].starts_with("member,outcome,I2,x1,x2,x3,energy"),
        "{}",
        left[0]
    );
    let refused = |members: Members, said: &str| {
        let refusal = compose_members(&of_memory.1, &registry, &members);
        let message = refusal.err().expect(said).message;
        assert!(message.contains(said), "{message}");
    };
    let with = |change: &dyn Fn(&mut Members)| {
        let mut members = members.clone();
        change(&mut members);
        members
    };
    let whole = "a state and a value of each parameter";
    refused(with(&|m| m.parameters[0].1.push(1.0)), whole);
    refused(with(&|m| m.states = Some(vec![1.0; 8])), whole);
    refused(with(&|m| m.states = Some(Vec::new())), whole);
    refused(with(&|m| m.parameters[0].1[1] = f64::NAN), "not finite");
    refused(
        with(&|m| m.parameters[0].0 = "I4".to_owned()),
        "`I4` is not a parameter",
    );
    let twice = with(&|m| m.parameters.push(m.parameters[0].clone()));
    refused(twice, "`I2` has a value for each member already");
}
