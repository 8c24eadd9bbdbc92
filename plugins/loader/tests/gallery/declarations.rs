//! Libraries that do not declare what the interface asks for.

use super::*;

#[test]
fn wrong_magic() {
    let refusal = refused("wrong_magic", "bad magic [58, 49, 41, 46, 57, 49, 53, 45]");
    assert!(matches!(refusal, Refusal::BadMagic { .. }));
}

#[test]
fn another_version_of_the_interface() {
    let text = "plugin ABI 7.0, host supports 1.0 to 1.0";
    assert_eq!(
        refused("other_major", text),
        Refusal::Abi { major: 7, minor: 0 }
    );
    let text = "plugin ABI 1.5, host supports 1.0 to 1.0";
    assert_eq!(
        refused("newer_minor", text),
        Refusal::Abi { major: 1, minor: 5 }
    );
}

#[test]
fn no_entry_of_this_version() {
    let refusal = refused(
        "only_v3",
        "no entry point leafwise_plugin_entry_v1 (it offers v3)",
    );
    assert_eq!(refusal, Refusal::NoEntryPoint { offers: vec![3] });
    let text = "no entry point leafwise_plugin_entry_v1: not a Leafwise plugin";
    assert_eq!(
        refused("no_entry", text),
        Refusal::NoEntryPoint { offers: vec![] }
    );
}

#[test]
fn a_null_entry() {
    assert_eq!(
        refused("null_entry", "entry returned NULL"),
        Refusal::NullEntry
    );
}

#[test]
fn a_required_function_that_is_null() {
    let text = "part gallery/zero: required function `alpha` is NULL";
    assert!(matches!(
        refused("null_function", text),
        Refusal::MissingFunction { .. }
    ));
}

#[test]
fn older_and_shorter_structs_load_without_what_they_do_not_know() {
    let workshop = Workshop::new();
    let mut registry = Registry::empty();
    let path = workshop.compile("shorter");
    let plugin = load(&path, Some(probe()), &mut registry).expect("an older plugin");
    assert_eq!(plugin.declaration.license, None);
    let part = &plugin.declaration.parts[0];
    assert_eq!(part.flags.self_adjoint(), None);
    assert_eq!(registry.parts().len(), 1);
}

#[test]
fn names_that_no_formula_could_use() {
    let workshop = Workshop::new();
    for (names, text) in [
        (
            r#""x", "sin", "z""#,
            "the variable `sin` cannot have this name: ",
        ),
        (
            r#""x", "<b>y</b>", "z""#,
            "the variable `<b>y</b>` cannot have this name: ",
        ),
        (
            r#""x", "y\nz", "z""#,
            "the variable `y\\nz` cannot have this name: ",
        ),
        (r#""x", "\xff", "z""#, "the name of variable 2 is not UTF-8"),
        (
            r#""x", "same", "same""#,
            "has the name of another variable, Casimir or parameter",
        ),
        (
            r#""x", "spin", "z""#,
            "the Casimir `spin` has the name of another variable",
        ),
        (
            r#""x", "rotor", "z""#,
            "the variable `rotor` has the name of another variable",
        ),
        (
            r#""time", "y", "z""#,
            "the variable `time` has a name that is reserved in samples and formulas",
        ),
        (
            r#""x", "energy", "z""#,
            "the variable `energy` has a name that is reserved in samples",
        ),
    ] {
        let option = format!("-DNAMES={names}");
        let path = workshop.compile_with("names", &["-O3", "-ffp-contract=off", &option]);
        let said = refusal(&path, Some(probe())).to_string();
        assert!(said.contains(text), "`{text}` is missing from: {said}");
    }
}

#[test]
fn an_id_that_is_taken() {
    let text = "it offers two parts called `gallery/twin`";
    assert!(matches!(
        refused("two_of_one_id", text),
        Refusal::TwoOfOneId { .. }
    ));
    // Another file with the id of the plugin that `refusal` loaded first.
    let workshop = Workshop::new();
    let copy = workshop.compile_with("still", &["-O1"]);
    let error = refusal(&copy, Some(probe()));
    let Refusal::Duplicate { id, .. } = &error.refusal else {
        panic!("{error}");
    };
    assert_eq!(id, "gallery/still");
    assert!(
        error
            .to_string()
            .contains("a stepper of this name is already registered"),
        "{error}"
    );
}

#[test]
fn a_formula_that_cannot_be_read() {
    let text = "part gallery/wrong-formula: formula `increment.2`: unknown name `y1`";
    assert!(matches!(
        refused("wrong_formula", text),
        Refusal::Formula { .. }
    ));
}
