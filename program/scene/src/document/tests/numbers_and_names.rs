//! Claims about types, ranges, shapes and names.

use super::*;

#[test]
fn wrong_types_say_what_was_expected_and_what_was_found() {
    assert_eq!(
        seen(&broken("epsilon = 0.1", "epsilon = \"fast\"")),
        (
            15,
            11,
            "\"fast\"",
            "`epsilon` is neither a number nor a formula of numbers: unknown name `fast`",
            "numbers and functions of them are allowed here, as \"sqrt(3)/2\""
        )
    );
    assert_eq!(
        seen(&broken("steps   = 1000", "steps = 1.5")).3,
        "`steps` must be a whole number, found 1.5"
    );
    assert_eq!(
        seen(&broken("steps   = 1000", "steps = -3")),
        (
            20,
            9,
            "-3",
            "`steps` must be a whole number of at least 0, found -3",
            ""
        )
    );
    assert_eq!(
        seen(&broken("every = 10", "every = 0")).3,
        "`every` must be a whole number of at least 1, found 0"
    );
    assert_eq!(
        seen(&broken("steps   = 1000", "steps = 99999999999999999999")).3,
        "`steps` must be a whole number of at most 18446744073709551615, found 99999999999999999999"
    );
    assert_eq!(
        seen(&broken(
            "variables   = [\"x1\", \"x2\", \"x3\"]",
            "variables = [\"x1\", 2]"
        )),
        (5, 20, "2", "`variables[1]` must be a string, found 2", "")
    );
    assert_eq!(
        seen(&broken("I2 = 0.75", "I2 = \"half\"")).3,
        "`I2` is neither a number nor a formula of numbers and other parameters: unknown name `half`"
    );
}

#[test]
fn numbers_that_are_not_finite_are_refused_where_they_stand() {
    for literal in ["nan", "inf", "-inf", "+nan", "1e400"] {
        let diagnostic = broken("I2 = 0.75", &format!("I2 = {literal}"));
        let (line, column, text, message, _) = seen(&diagnostic);
        assert_eq!((line, column, text), (6, 32, literal));
        assert_eq!(
            message,
            format!("`I2` must be a finite number, found {literal}")
        );
        assert_eq!(
            seen(&broken("[1, 3, 3.5e0]", &format!("[1, 3, {literal}]"))).2,
            literal
        );
        assert_eq!(
            seen(&broken("epsilon = 0.1", &format!("epsilon = {literal}"))).2,
            literal
        );
    }
}

#[test]
fn a_step_is_two_factors_or_their_product_and_never_zero() {
    assert_eq!(
        seen(&broken("epsilon = 0.1", "epsilon = 0.0")),
        (
            15,
            11,
            "0.0",
            "`epsilon` must be different from zero, found 0.0",
            ""
        )
    );
    assert_eq!(
        seen(&broken("h       = 2.0", "time-step = 0.2")),
        (
            15,
            1,
            "epsilon",
            "`epsilon` cannot be combined with `time-step`",
            "give `epsilon` and `h`, or `time-step` alone: one step advances t by epsilon*h"
        )
    );
    let lone = broken("h       = 2.0\n", "");
    assert_eq!(
        seen(&lone),
        (
            11,
            2,
            "method",
            "[method] needs `h`",
            "for example: h = 2.0"
        )
    );
    let tiny = broken(
        "epsilon = 0.1\nh       = 2.0",
        "epsilon = 1e-200\nh = 1e-200",
    );
    assert_eq!(
        seen(&tiny).3,
        "`epsilon*h` must be finite and not zero, found 0"
    );
    let backward = parse(&RIGID_BODY.replace("h       = 2.0", "h = -2.0")).expect("backward runs");
    assert_eq!(backward.method.step.time_step(), -0.2);
    let alone = parse(&RIGID_BODY.replace("epsilon = 0.1\nh       = 2.0", "time-step = 0.2"));
    assert_eq!(
        alone.expect("a time step alone").method.step.time_step(),
        0.2
    );
}

#[test]
fn shapes_are_checked_against_the_dimension() {
    assert_eq!(
        seen(&broken("[1, 3, 3.5e0]", "[1, 3]")),
        (
            19,
            11,
            "[1, 3]",
            "initial has 2 entries, expected 3, one for each variable",
            ""
        )
    );
    let entries = "{ \"x1,x2\" = \"-x3\", \"x2,x3\" = \"-x1\", \"x3,x1\" = \"-x2\" }";
    let ragged = broken(entries, "{ log-canonical = [[0, 2], [1]] }");
    assert_eq!(seen(&ragged).2, "[1]");
    let small = broken(entries, "{ log-canonical = [[0, 2], [-2, 0]] }");
    assert_eq!(
        seen(&small).3,
        "log-canonical has 2 rows, expected one for each of the 3 variables"
    );
    let both = broken(entries, "{ lie-algebra = \"so3\", \"x1,x2\" = \"x3\" }");
    assert_eq!(
        seen(&both).3,
        "`x1,x2` cannot be combined with `lie-algebra`"
    );
    let two = broken(
        entries,
        "{ lie-algebra = { name = \"so3\", structure = [] } }",
    );
    assert_eq!(seen(&two).3, "`structure` cannot be combined with `name`");
    let none = broken(entries, "{ lie-algebra = { } }");
    assert_eq!(seen(&none).3, "lie-algebra needs `name`");
    let number = broken(entries, "{ lie-algebra = 3 }");
    assert_eq!(seen(&number).2, "3");
    let short = broken(entries, "{ lie-algebra = { structure = [[1, 2, 1]] } }");
    assert_eq!(seen(&short).2, "[1, 2, 1]");
    assert_eq!(
        seen(&short).3,
        "entry 1 of structure has 3 entries, expected four: [i, j, k, c] for [e_i, e_j] = … + c e_k + …"
    );
    let none = broken(entries, "{ lie-algebra = { structure = [[0, 2, 1, 1]] } }");
    assert_eq!(seen(&none).2, "0");
    let kind = broken(entries, "{ lie_algebra = \"so3\" }");
    assert_eq!(
        seen(&kind),
        (
            7,
            17,
            "lie_algebra",
            "`lie_algebra` is not a pair of variables",
            "did you mean `lie-algebra`?"
        )
    );
}

#[test]
fn names_are_valid_and_declared_once() {
    let twice = broken("\"x2\", \"x3\"]", "\"x1\", \"x3\"]");
    assert_eq!(
        seen(&twice),
        (5, 22, "\"x1\"", "`x1` is declared twice", "")
    );
    assert_eq!(
        seen(&broken("\"x2\", \"x3\"]", "\"2x\", \"x3\"]")).2,
        "\"2x\""
    );
    let convention = broken("casimirs    =", "convention = \"{x,h}\"\ncasimirs =");
    assert_eq!(seen(&convention).3, "unknown convention `{x,h}`");
    assert_eq!(convention.help.as_deref(), Some("did you mean `{x,H}`?"));
}
