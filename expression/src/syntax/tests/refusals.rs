use super::super::{POWER_LIMIT, SyntaxErrorKind as Kind, TERM_LIMIT};
use super::*;
use crate::rational::DecimalError;

/// What each refused formula says: the text pointed at, the message, the suggestion.
#[test]
fn errors_point_at_their_text_and_suggest_near_names() {
    let scope = Scope::new()
        .with_variables(&["x1", "x2", "x3"])
        .with_parameters(&["I1", "omega"])
        .with_family("u", 3, 4);
    for (text, place, message) in [
        ("x1 + x4^2", "x4", "unknown name `x4`; did you mean `x1`?"),
        (
            "2*omgea",
            "omgea",
            "unknown name `omgea`; did you mean `omega`?",
        ),
        ("i1 + 1", "i1", "unknown name `i1`; did you mean `I1`?"),
        ("Pi", "Pi", "unknown name `Pi`; did you mean `pi`?"),
        ("momentum*x1", "momentum", "unknown name `momentum`"),
        (
            "log(x1)",
            "log",
            "unknown function `log` (a product is written with `*`); \
            did you mean `ln`?",
        ),
        (
            "arcsin(x1)",
            "arcsin",
            "unknown function `arcsin` (a product is written with `*`); \
            did you mean `asin`?",
        ),
        (
            "sine(x1)",
            "sine",
            "unknown function `sine` (a product is written with `*`); \
            did you mean `sin`?",
        ),
        (
            "x1(x2 + 1)",
            "x1",
            "unknown function `x1` (a product is written with `*`)",
        ),
        (
            "2x1",
            "x1",
            "expected an operator (a product is written with `*`), found `x1`",
        ),
        (
            "x1 + ",
            "",
            "the formula ends where a number, a name or `(` is expected",
        ),
        (
            "",
            "",
            "the formula ends where a number, a name or `(` is expected",
        ),
        (
            "(x1",
            "",
            "the formula ends where an operator or `)` is expected",
        ),
        (
            "x1)",
            ")",
            "expected an operator (a product is written with `*`), found `)`",
        ),
        (
            "x1 * / 2",
            "/",
            "expected a number, a name or `(`, found `/`",
        ),
        (
            "sin x1",
            "x1",
            "expected `(` and an argument after a function's name, found `x1`",
        ),
        (
            "2*sin^2(x1 + (x2))",
            "^",
            "expected `(` and an argument after a function's name, found `^`; did you mean `sin(x1 + (x2))^2`?",
        ),
        (
            "x1 + |x1 - x2|/2",
            "|",
            "unexpected character `|`; did you mean `abs(x1 - x2)`?",
        ),
        (
            "x1 || x2",
            "|",
            "unexpected character `|`; did you mean `or`?",
        ),
        (
            "np.sqrt(x1)",
            "np.sqrt",
            "unknown function `np.sqrt` (a product is written with `*`); did you mean `sqrt`?",
        ),
        (
            "math.log(x1)",
            "math.log",
            "unknown function `math.log` (a product is written with `*`); did you mean `ln`?",
        ),
        ("sin(x1, x2)", ",", "expected an operator or `)`, found `,`"),
        ("x1 − 2", "−", "unexpected character `−`; did you mean `-`?"),
        ("x1²", "²", "unexpected character `²`; did you mean `^2`?"),
        ("x1 $ 2", "$", "unexpected character `$`"),
        (
            "1e500*x1",
            "1e500",
            "the exponent of `1e500` is outside the range -400 to 400",
        ),
        (
            "x1^(2000)",
            "(2000)",
            "the exponent `(2000)` is outside the range -1000 to 1000",
        ),
        (
            "x1^-1e300",
            "-1e300",
            "the exponent `-1e300` is outside the range -1000 to 1000",
        ),
        ("u + 1", "u", "`u` is a family; write one member as `u[i]`"),
        ("x1[2]", "x1[2", "`x1` is not a family and takes no index"),
        ("I1[2]", "I1[2", "`I1` is not a family and takes no index"),
        ("u[4]", "4", "`u` has the members u[0] to u[3], not u[4]"),
        ("u[-1]", "-1", "`u` has the members u[0] to u[3], not u[-1]"),
        ("u[N]", "N", "`u` has the members u[0] to u[3], not u[4]"),
        (
            "u[i]",
            "i",
            "unknown index `i`; introduce it by the key or by `sum(i, ...)`",
        ),
        (
            "sum(j, u[i])",
            "i",
            "unknown index `i`; introduce it by the key or by `sum(i, ...)`; \
            did you mean `j`?",
        ),
        (
            "sum(i, i*u[i])",
            "i",
            "the index `i` is used as a number; tensors and Hamiltonians \
            must be homogeneous along the family, so an index is allowed only in brackets",
        ),
        (
            "sum(i, sum(i, u[i]))",
            "i",
            "the index `i` is already in use here",
        ),
        (
            "sum(pi, u[0])",
            "pi",
            "expected the name of an index, found `pi`",
        ),
        ("sum(u[0])", "[", "expected `,` and a summand, found `[`"),
        (
            "u[0.5]",
            "0.5",
            "expected an integer below 2147483648, found `0.5`",
        ),
        (
            "u[9999999999]",
            "9999999999",
            "expected an integer below 2147483648",
        ),
        ("sum(i, u[2*i])", "*", "expected `+`, `-` or `]`, found `*`"),
        (
            "sum(i, u[-i])",
            "i",
            "expected a site such as i, i+1, 3 or N-1, found `i`",
        ),
        (
            "sum(i, sum(j, u[i+j]))",
            "j",
            "expected a site such as i, i+1, 3 or N-1, found `j`",
        ),
        (
            "u[]",
            "]",
            "expected a site such as i, i+1, 3 or N-1, found `]`",
        ),
    ] {
        let error = refusal(text, &scope);
        let pointed = error.span.clone();
        assert_eq!(
            text.get(pointed.clone()),
            Some(place),
            "{text}: {error} at {pointed:?}"
        );
        let shown = error.to_string();
        let whole = shown == message || message.len() < shown.len() && !message.contains("mean");
        assert!(whole && shown.contains(message), "{text}: {shown}");
        assert!(!shown.contains('\n'));
    }
}

#[test]
fn far_fetched_names_are_not_suggested() {
    let scope = scalars();
    for text in ["momentum", "w", "energy(x)", "x + ab12"] {
        assert_eq!(refusal(text, &scope).suggestion, None, "{text}");
    }
}

#[test]
fn errors_are_typed() {
    let number = refusal("1e500", &scalars());
    assert!(matches!(
        number.kind,
        Kind::Number(DecimalError::ExponentOutOfRange { .. })
    ));
    assert!(std::error::Error::source(&number).is_some());
    let exponent = POWER_LIMIT + 1;
    let error = refusal(&format!("x^{exponent}"), &scalars());
    let expected = Kind::ExponentTooLarge {
        exponent: exponent.to_string(),
        limit: POWER_LIMIT,
    };
    assert_eq!(error.kind, expected);
    assert_eq!(
        refusal("N", &scalars()).kind,
        Kind::LengthUnknown { name: "N" }
    );
    assert_eq!(
        refusal("sum(i, 1)", &scalars()).kind,
        Kind::LengthUnknown { name: "sum" }
    );
}

#[test]
fn sums_that_explode_are_refused() {
    let scope = Scope::new().with_family("u", 0, 1 << 20);
    let text = "sum(i, sum(j, sum(k, 1)))";
    let limit = Kind::TooManyTerms { limit: TERM_LIMIT };
    assert_eq!(
        parse(text)
            .value(&scope, &[], None)
            .expect_err("2^60 terms")
            .kind,
        limit
    );
}

#[test]
fn values_are_functions_of_parameters_and_indices_alone() {
    let scope = scalars().with_family("u", 3, 4);
    let error = |text: &str| {
        parse(text)
            .value(&scope, &[1.0], Some((&["i"], 2)))
            .expect_err(text)
    };
    for (text, name) in [("1 + x", "x"), ("a*u[i]", "u"), ("u", "u")] {
        let kind = Kind::NotAFunctionOfParameters {
            name: name.to_owned(),
        };
        assert_eq!(error(text).kind, kind, "{text}");
    }
    assert_eq!(
        error("b").kind,
        Kind::ParameterWithoutValue {
            name: "b".to_owned()
        }
    );
    assert_eq!(
        error("a[i]").kind,
        Kind::NotAFamily {
            name: "a".to_owned()
        }
    );
    assert_eq!(
        error("j").kind,
        Kind::UnknownName {
            name: "j".to_owned()
        }
    );
}

#[test]
fn names_that_formulas_use_otherwise_are_reserved() {
    for name in ["x1", "_", "γ", "Ω_0", "i", "n", "e"] {
        assert_eq!(Scope::check_name(name), Ok(()), "{name}");
    }
    for name in ["pi", "N", "sum", "sin", "ln"] {
        let kind = Scope::check_name(name).expect_err(name).kind;
        assert_eq!(
            kind,
            Kind::ReservedName {
                name: name.to_owned()
            }
        );
    }
    for name in ["", "1x", "x y", "x[0]", "x²", "x-1", "₁"] {
        let kind = Scope::check_name(name).expect_err(name).kind;
        assert_eq!(
            kind,
            Kind::InvalidName {
                name: name.to_owned()
            }
        );
    }
}
