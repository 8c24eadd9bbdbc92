//! Parts that break the contract when they are called.

use super::*;

#[test]
fn a_fatal_call_tells_its_reason() {
    let text = "increment: fatal: panic: index out of bounds: the len is 0 but the index is 3";
    assert!(matches!(fails("fatal", text), SmokeFailure::Call { .. }));
}

#[test]
fn results_that_are_not_finite() {
    let text = "increment: non-finite output at point 0 coordinate 0";
    assert!(matches!(
        fails("not_finite", text),
        SmokeFailure::NotFinite { .. }
    ));
}

#[test]
fn wrong_mathematics() {
    let text = "bisection identity alpha(x,0)=x on so(3)* violated: [0.375, 0.5, 0.625]";
    match refused("wrong_maths", text) {
        Refusal::Smoke { failure, .. } => {
            let SmokeFailure::Identity { expected, .. } = failure else {
                panic!("{failure:?}");
            };
            assert_eq!(expected, [0.75, 1.0, 1.25]);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn writing_where_nothing_belongs() {
    let text = "increment: canary: it wrote past the end of its output";
    assert!(matches!(
        fails("overruns", text),
        SmokeFailure::Overwritten { .. }
    ));
    let text = "increment: canary: it wrote into the gaps between its results";
    assert!(matches!(
        fails("ignores_strides", text),
        SmokeFailure::Overwritten { .. }
    ));
}

#[test]
fn writing_to_an_input() {
    let text = "hamiltonian: canary: it wrote to its input `point`";
    assert!(matches!(
        fails("writes_input", text),
        SmokeFailure::Overwritten { .. }
    ));
}

/// Instances are called on several threads at once: what a call keeps in static memory is overwritten
/// by the others.
#[test]
fn memory_that_instances_share() {
    let text =
        "gradient: instances called on several threads at once gave other answers than one alone";
    assert!(matches!(
        fails("static_scratch", text),
        SmokeFailure::NotParallel { .. }
    ));
    let text =
        "gradient: an instance gave another answer after another instance was made and called";
    assert!(matches!(
        fails("static_parameters", text),
        SmokeFailure::DependsOnOthers { .. }
    ));
}

/// Static data that change are reported, and are no failure where the answers stay.
#[test]
fn a_counter_in_static_memory() {
    let workshop = Workshop::new();
    let path = workshop.compile("counts_calls");
    let plugin = load(&path, Some(probe()), &mut Registry::empty()).expect("a good plugin");
    assert_eq!(plugin.tried[0].writing_static_data, ["gradient"]);
}

/// The child process calls everything that the program calls: names and promises too.
#[test]
fn names_and_promises_are_asked_for_in_the_child() {
    let workshop = Workshop::new();
    let with = |name: &str, option: &str| {
        let path = workshop.compile_with(name, &["-O3", "-ffp-contract=off", option]);
        let is_endless = option.contains("for (;;)");
        let probe = if is_endless { impatient() } else { probe() };
        refusal(&path, Some(probe)).to_string()
    };
    let name = "-DNAMES=\"a\", \"b\", (const char *)1";
    for (name, option, text) in [
        ("names", name, "probe: child killed by signal 11 (SIGSEGV)"),
        (
            "promises",
            "-DCALL=__builtin_trap()",
            "probe: child killed by signal",
        ),
        (
            "promises",
            "-DCALL=for (;;)",
            "probe: no report within 1.5 s",
        ),
        (
            "promises",
            "-DCALL=promised->order = -5",
            "properties: error: properties: order -5 is less than 1",
        ),
        (
            "promises",
            "-DCALL=promised->structure = -7",
            "properties: error: properties: structure -7 is unknown",
        ),
        (
            "promises",
            "-DCALL=promised->flags = ~0u",
            "it is declared self-adjoint and not self-adjoint",
        ),
    ] {
        let said = with(name, option);
        assert!(said.contains(text), "`{text}` is missing from: {said}");
    }
}

#[test]
fn a_number_of_casimirs_that_cannot_be() {
    let text = "18446744073709551615 Casimirs are more than 1048576";
    assert!(matches!(
        fails("endless_casimirs", text),
        SmokeFailure::Shape { .. }
    ));
}

/// Only LW_UNSUPPORTED says that a part does not serve a problem.
#[test]
fn a_part_that_cannot_be_made() {
    let text = "create: error: the table of inertia is missing";
    assert!(matches!(
        fails("cannot_create", text),
        SmokeFailure::Call { .. }
    ));
}

#[test]
fn a_map_that_remembers() {
    let text = "increment: two calls at the same points gave different answers";
    assert!(matches!(
        fails("remembers", text),
        SmokeFailure::NotRepeatable { .. }
    ));
}
