//! Claims about reading scenes.

mod assigned;
mod numbers_and_names;
mod sources;

use leafwise_core::registry::SystemPart;
use leafwise_core::{Origin, PartInfo, PartKind, Registry};

use super::*;
use crate::diagnostic::SceneDiagnostic;

const RIGID_BODY: &str = r#"# a rigid body
plugins = ["libextra.so"]

[system]
variables   = ["x1", "x2", "x3"]
parameters  = { I1 = 1.0, I2 = 0.75, I3 = 1_000.5 }
bracket     = { "x1,x2" = "-x3", "x2,x3" = "-x1", "x3,x1" = "-x2" }
hamiltonian = "x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)"
casimirs    = { spin = "x1^2 + x2^2 + x3^2" }

[method]
realization = { name = "karasev-truncated", order = 6 }
dynamics    = { name = "hamilton-jacobi", order = 2 }   # even
composition = "none"
epsilon = 0.1
h       = 2.0

[run]
initial = [1, 3, 3.5e0]
steps   = 1000
record  = { every = 10 }
"#;

const FRAGMENT: &str = r#"
[about]
reference = "somewhere"
[system]
families    = { x = 8 }
parameters  = { rate = 1.5 }
bracket     = { "x[i],x[i+1]" = "x[i]*x[i+1]" }
boundary    = "periodic"
convention  = "{x, H}"
hamiltonian = "rate*sum(i, x[i])"
"#;

static LATTICE: PartInfo = PartInfo {
    name: "volterra-lattice",
    ..PartInfo::of(PartKind::System)
};
static BROKEN: PartInfo = PartInfo {
    name: "broken",
    ..PartInfo::of(PartKind::System)
};

/// The parts that are linked, and systems by text alone.
fn library() -> Registry {
    let mut registry = Registry::with_builtin();
    for (info, fragment) in [(&LATTICE, FRAGMENT), (&BROKEN, "[system\n")] {
        let part = SystemPart::new(info, |_| unreachable!("it is read as text"));
        let origin = Origin::built_in("a test", "1");
        let part = part.with_fragment(fragment);
        registry.register(part.into(), origin).expect("a new name");
    }
    registry
}

fn parse(text: &str) -> Result<SceneDocument, SceneErrors> {
    SceneDocument::parse("scene.toml", text, &library())
}

fn with(overrides: &[(&str, &str)]) -> Result<SceneDocument, SceneErrors> {
    let owned: Vec<_> = overrides
        .iter()
        .map(|(path, value)| (path.to_string(), value.to_string()))
        .collect();
    SceneDocument::parse_with("scene.toml", RIGID_BODY, &owned, &library())
}

/// The first diagnostic of the rigid body's scene with one piece replaced.
fn broken(from: &str, to: &str) -> SceneDiagnostic {
    assert!(RIGID_BODY.contains(from), "the scene has no {from}");
    let errors = parse(&RIGID_BODY.replace(from, to)).expect_err("the scene is wrong");
    errors.diagnostics().remove(0)
}

/// Line, column, underlined text, message and help of a diagnostic.
fn seen(diagnostic: &SceneDiagnostic) -> (usize, usize, &str, &str, &str) {
    let (line, column) = diagnostic.line_column();
    (
        line,
        column,
        &diagnostic.source_text[diagnostic.span.clone()],
        &diagnostic.message,
        diagnostic.help.as_deref().unwrap_or(""),
    )
}

#[test]
fn a_scene_reads_as_written_and_keeps_the_order_of_its_text() {
    let scene = parse(RIGID_BODY).expect("a valid scene");
    let names: Vec<_> = scene
        .system
        .parameters
        .iter()
        .map(|(n, _)| n.value.as_str())
        .collect();
    assert_eq!(names, ["I1", "I2", "I3"]);
    assert_eq!(scene.system.parameters[2].1.value.literal, "1000.5");
    let BracketSpec::Entries(entries) = &scene.system.bracket.value else {
        panic!("entries expected");
    };
    let keys: Vec<_> = entries.iter().map(|(key, _)| key.value.as_str()).collect();
    assert_eq!(keys, ["x1,x2", "x2,x3", "x3,x1"]);
    assert_eq!(scene.system.convention, Convention::HamiltonFirst);
    assert_eq!(scene.method.composition, None);
    let realization = scene.method.realization.as_ref().expect("a realization");
    assert_eq!(realization.name.value, "karasev-truncated");
    let (key, value) = &realization.parameters[0];
    assert_eq!(key.value, "order");
    let six = Number {
        literal: "6".to_owned(),
        value: 6.0,
    };
    assert_eq!(value.value, ParameterValue::Number(six));
    assert_eq!(&scene.text[value.span.clone()], "6");
    assert_eq!(
        (scene.method.step.epsilon(), scene.method.step.h()),
        (0.1, 2.0)
    );
    assert_eq!(scene.run.record.every, 10);
    let observables: Vec<_> = scene
        .run
        .record
        .observables
        .iter()
        .map(ObservableSpec::heading)
        .collect();
    assert_eq!(observables, ["energy", "spin"]);
    assert_eq!(scene.plugins[0].path.value, "libextra.so");
}

#[test]
fn places_inside_formulas_and_bracket_keys_are_exact() {
    let scene = parse(RIGID_BODY).expect("a valid scene");
    let formula = &scene.system.hamiltonian;
    let start = formula.value.find("I2").expect("I2 occurs");
    let place = scene.place_in_formula(formula, start..start + 2);
    let diagnostic = scene.diagnostic(&place, "unknown", "here", None);
    assert_eq!(diagnostic.line_column(), (8, 38));
    assert_eq!(&scene.text[diagnostic.span], "I2");
    let BracketSpec::Entries(entries) = &scene.system.bracket.value else {
        panic!("entries expected");
    };
    let place = scene.place_in_formula(&entries[1].0, 3..5);
    assert_eq!(&scene.text[place.span], "x3");
}

#[test]
fn every_unknown_key_is_underlined_and_its_nearest_key_named() {
    assert_eq!(
        seen(&broken("epsilon = 0.1", "epsillon = 0.1")),
        (
            15,
            1,
            "epsillon",
            "unknown key `epsillon` in [method]",
            "did you mean `epsilon`?"
        )
    );
    assert_eq!(
        seen(&broken("hamiltonian =", "hamiltonain =")),
        (
            8,
            1,
            "hamiltonain",
            "unknown key `hamiltonain` in [system]",
            "did you mean `hamiltonian`?"
        )
    );
    assert_eq!(
        seen(&broken("every = 10", "evry = 10")),
        (
            21,
            13,
            "evry",
            "unknown key `evry` in record",
            "did you mean `every`?"
        )
    );
    assert_eq!(
        seen(&broken("[run]", "[rn]")),
        (
            18,
            2,
            "rn",
            "unknown key `rn` in the scene",
            "did you mean `run`?"
        )
    );
    let stranger = broken("steps   = 1000", "steps = 1\nzzzz = 2");
    assert_eq!(
        stranger.help.as_deref(),
        Some(
            "valid here: initial, steps, until, t0, stop, section, seed, member, error, record, out"
        )
    );
}

#[test]
fn a_missing_table_or_key_comes_with_an_example() {
    assert_eq!(
        seen(&broken(
            "hamiltonian = \"x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)\"\n",
            ""
        )),
        (
            4,
            2,
            "system",
            "[system] needs `hamiltonian`",
            "for example: hamiltonian = \"x1^2/2 + x2^2/2\""
        )
    );
    let empty = parse("").expect_err("an empty scene");
    let messages: Vec<_> = empty.problems.iter().map(ToString::to_string).collect();
    assert_eq!(
        messages,
        [
            "the scene needs `system`",
            "the scene needs `method`",
            "the scene needs `run`"
        ]
    );
    let part = broken("{ name = \"hamilton-jacobi\", order = 2 }", "{ order = 2 }");
    assert_eq!(
        seen(&part),
        (
            13,
            15,
            "{ order = 2 }",
            "dynamics needs `name`",
            "for example: dynamics = { name = \"hamilton-jacobi\" }"
        )
    );
}

#[test]
fn several_problems_are_reported_in_the_order_of_the_text() {
    let text = RIGID_BODY
        .replace("I2 = 0.75", "I2 = nan")
        .replace("steps ", "stops ");
    let errors = parse(&text).expect_err("two problems");
    let messages: Vec<_> = errors.problems.iter().map(ToString::to_string).collect();
    assert_eq!(
        messages,
        [
            "`I2` must be a finite number, found nan",
            "unknown key `stops` in [run]",
        ]
    );
    assert_eq!(errors.to_string(), messages[0]);
}
