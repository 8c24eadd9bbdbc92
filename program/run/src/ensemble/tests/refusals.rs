//! What is said of a table that is wrong, or absent.

use super::*;

#[test]
fn an_invalid_table_is_refused_where_it_stands() {
    for (ensemble, said, place) in [
        ("member = 5", "unknown key `member` in [ensemble]", "member"),
        (
            "members = 0",
            "`members` must be a whole number of at least 1, found 0",
            "0",
        ),
        (
            "members = 5\ninitial = 3",
            "`initial` must be a table such as { ball = 0.1 }, found 3",
            "3",
        ),
        (
            "members = 5\ninitial = { bal = 1 }",
            "unknown key `bal` in initial",
            "bal",
        ),
        (
            "members = 5\ninitial = { ball = 1, box = 1 }",
            "`box` cannot be combined with `ball`",
            "box",
        ),
        (
            "members = 5\ninitial = { ball = -1 }",
            "`ball` must be a positive number, found -1",
            "-1",
        ),
        (
            "members = 5\ninitial = { box = [1, 2] }",
            "box has 2 entries, expected 3, one for each variable",
            "[1, 2]",
        ),
        (
            "members = 5\nparameters = { J = { uniform = [0, 1] } }",
            "unknown parameter of this system `J`",
            "J",
        ),
        (
            "members = 5\nparameters = { I1 = { uniform = [1, 0] } }",
            "uniform has [1.0, 0.0], expected [from, to], the smaller first",
            "[1, 0]",
        ),
        (
            "members = 5\nrecord = { quantiles = [2] }",
            "`quantiles[0]` must be between 0 and 1, found 2",
            "2",
        ),
        (
            "members = 5\nfinal-states = \"cvs\"",
            "unknown form of final states `cvs`",
            "\"cvs\"",
        ),
    ] {
        let text = BODY
            .replace("METHOD", METHODS[0])
            .replace("ENSEMBLE", ensemble);
        let errors =
            SceneDocument::parse("body.toml", &text, &Registry::empty()).expect_err(ensemble);
        let problem = &errors.problems[0];
        assert_eq!(problem.cause.to_string(), said);
        assert_eq!(&text[problem.place.span.clone()], place, "{ensemble}");
    }
}

#[test]
fn a_scene_without_the_table_says_so() {
    let text = BODY.replace("METHOD", METHODS[0]);
    let text = text.split("[ensemble]").next().expect("a scene");
    let document = SceneDocument::parse("body.toml", text, &Registry::empty()).expect("a scene");
    let refusal = compose_ensemble(&document, &Registry::with_builtin(), Path::new(""));
    let message = refusal.err().expect("refused").message;
    assert_eq!(message, "the scene has no [ensemble] table");
}

/// Nothing that is asked for is passed over: the estimate of a run's error is none of an ensemble's.
#[test]
fn an_estimate_of_the_error_is_refused_where_it_is_asked_for() {
    let text = BODY
        .replace("METHOD", METHODS[0])
        .replace("ENSEMBLE", "members = 5");
    let asked = text.replace("[run]", "[run]\nerror = \"estimate\"");
    assert_ne!(asked, text);
    let registry = Registry::with_builtin();
    let compose = |text: &str| {
        let document = SceneDocument::parse("body.toml", text, &registry).expect("a scene");
        compose_ensemble(&document, &registry, Path::new("")).err()
    };
    let refusal = compose(&asked).expect("refused");
    assert!(
        refusal.message.ends_with("and this is an ensemble"),
        "{}",
        refusal.message
    );
    assert_eq!(&asked[refusal.span.clone()], "\"estimate\"");
    assert!(
        refusal
            .help
            .is_some_and(|help| help.contains("remove `error`"))
    );
    // What it says to do cures it.
    assert!(compose(&text).is_none());
}
