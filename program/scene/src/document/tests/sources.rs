//! Claims about library systems, overrides and text that is not TOML.

use super::*;

fn lattice(system: &str) -> String {
    format!(
        "[system]\n{system}\n[method]\nstepper = \"implicit-midpoint\"\ntime-step = 0.1\n\
         [run]\ninitial = {{ \"x[i]\" = \"1 + 0.1*sin(2*pi*i/N)\" }}\nsteps = 3\n"
    )
}

#[test]
fn a_library_system_takes_parameters_and_lengths_and_nothing_else() {
    let text = lattice(
        "library = \"volterra-lattice\"\nparameters = { rate = 2 }\nfamilies = { x = 1024 }",
    );
    let scene = parse(&text).expect("a library scene");
    assert_eq!(scene.system.dimension(), 1024);
    assert_eq!(scene.system.parameters[0].1.value.value, 2.0);
    assert_eq!(scene.system.parameters[0].1.source, Source::Scene);
    assert_eq!(scene.system.convention, Convention::HamiltonSecond);
    assert_eq!(
        scene.system.boundary.as_ref().map(|b| &b.value[..]),
        Some(&[Boundary::Periodic][..])
    );
    let hamiltonian = scene.system.hamiltonian.place();
    let diagnostic = scene.diagnostic(&hamiltonian, "m", "l", None);
    assert_eq!(diagnostic.source_name, "library system volterra-lattice");
    assert_eq!(diagnostic.line_column(), (10, 15));

    let first = |system: &str| {
        let errors = parse(&lattice(system)).expect_err("a wrong scene");
        errors.diagnostics().remove(0)
    };
    assert_eq!(
        seen(&first("library = \"volterra-latice\"")),
        (
            2,
            11,
            "\"volterra-latice\"",
            "unknown library system `volterra-latice`",
            "did you mean `volterra-lattice`?"
        )
    );
    let parameter = first("library = \"volterra-lattice\"\nparameters = { rat = 2 }");
    assert_eq!(
        seen(&parameter),
        (
            3,
            16,
            "rat",
            "unknown parameter of this system `rat`",
            "did you mean `rate`?"
        )
    );
    let beside = first("library = \"volterra-lattice\"\nhamiltonian = \"x\"");
    assert_eq!(
        seen(&beside).3,
        "`hamiltonian` cannot be combined with `library`"
    );
    let fragment = first("library = \"broken\"");
    assert_eq!(fragment.source_name, "library system broken");
}

#[test]
fn overrides_rewrite_the_text_and_keep_its_comments() {
    let scene = with(&[
        ("method.epsilon", "0.05"),
        ("method.dynamics.order", "4"),
        ("run.record.observables", "[\"energy\"]"),
        ("run.out", "elsewhere/dir"),
        ("system.parameters.I2", "2"),
    ])
    .expect("valid overrides");
    assert_eq!(scene.method.step.epsilon(), 0.05);
    assert!(scene.text.contains("epsilon = 0.05\n"));
    assert!(scene.text.contains("order = 4 }   # even"));
    assert_eq!(scene.run.record.observables.len(), 1);
    assert_eq!(
        scene.run.out.as_ref().map(|out| out.value.as_str()),
        Some("elsewhere/dir")
    );
    assert_eq!(scene.system.parameters[1].1.value.value, 2.0);
    let again = parse(&scene.text).expect("the effective text is a scene");
    assert_eq!(again, scene);
}

#[test]
fn overriding_one_alternative_removes_the_others() {
    let scene = with(&[("method.time-step", "0.01")]).expect("a time step alone");
    assert_eq!(scene.method.step.time_step(), 0.01);
    let scene = with(&[("method.stepper", "rk4")]).expect("a stepper alone");
    assert_eq!(scene.method.realization, None);
    let scene = with(&[("method.composition.order", "4")]).expect("a word becomes a table");
    assert!(
        scene
            .text
            .contains("composition = { name = \"none\", order = 4 }"),
        "{}",
        scene.text
    );
}

#[test]
fn a_table_takes_the_place_of_a_table() {
    let method = "{ stepper = { name = \"rk4\" }, time-step = 0.25 }";
    let scene = with(&[("method", method), ("run.steps", "7")]).expect("valid overrides");
    assert_eq!(scene.text.matches("[method]").count(), 1);
    assert!(scene.text.contains("time-step = 0.25"), "{}", scene.text);
    assert!(!scene.text.contains("hamilton-jacobi"), "{}", scene.text);
    let errors = with(&[("run", "5")]).expect_err("no table");
    let told = errors.diagnostics().remove(0);
    assert!(
        told.message
            .contains("name one of its keys, or give a table"),
        "{}",
        told.message
    );
}

#[test]
fn an_override_takes_the_place_of_its_alternatives_in_every_table() {
    let ensemble = "{ members = 3, initial = { ball = 0.1 }, record = { every = 2 } }";
    let scene = with(&[
        ("ensemble", ensemble),
        ("ensemble.initial.sphere", "0.2"),
        ("ensemble.record.times", "[1.0]"),
    ]);
    let scene = scene.expect("valid overrides");
    for gone in ["ball", "every = 2"] {
        assert!(!scene.text.contains(gone), "{}", scene.text);
    }
    // A library system takes no place: what is written of a system stays, and is refused beside it.
    let errors = with(&[("system.library", "volterra-lattice")]).expect_err("a written system");
    assert!(errors.to_string().contains("with `library`"), "{errors}");
}

#[test]
fn an_override_outside_the_format_is_underlined_in_the_argument() {
    let errors = with(&[("method.epsillon", "0.05")]).expect_err("no such key");
    let diagnostic = errors.diagnostics().remove(0);
    assert_eq!(diagnostic.source_name, "--set");
    assert_eq!(
        seen(&diagnostic),
        (
            1,
            8,
            "epsillon",
            "unknown key `epsillon` in [method]",
            "did you mean `epsilon`?"
        )
    );
    assert_eq!(diagnostic.source_text, "method.epsillon=0.05");
    for path in [
        "",
        "method..h",
        "method",
        "method.epsilon.deep",
        "plugins.a",
    ] {
        assert!(with(&[(path, "1")]).is_err(), "{path} was accepted");
    }
    let value = with(&[("method.epsilon", "quick")]).expect_err("not a number");
    assert_eq!(seen(&value.diagnostics()[0]).2, "\"quick\"");
}

#[test]
fn text_that_is_not_toml_is_reported_where_it_breaks() {
    let diagnostic = broken("epsilon = 0.1", "epsilon = = 0.1");
    assert_eq!(diagnostic.line_column().0, 15);
    assert!(diagnostic.message.starts_with("not valid TOML"));
    let twice = broken("epsilon = 0.1", "h = 0.1");
    assert_eq!(twice.line_column(), (16, 1));
    assert!(twice.message.contains("duplicate key"), "{}", twice.message);
}

#[test]
fn no_truncation_of_a_scene_panics() {
    for end in 0..RIGID_BODY.len() {
        if let Err(errors) = parse(&RIGID_BODY[..end]) {
            for diagnostic in errors.diagnostics() {
                assert!(!diagnostic.render(false).is_empty());
            }
        }
    }
}
