use super::super::SyntaxErrorKind as Kind;
use super::*;
use crate::operators::Quantity;

const POINT: [f64; 3] = [2.0, -3.0, 5.0];

/// The value of a formula of x = 2, y = −3, z = 5, a = 7, b = 11, and of what it prints as, parsed and resolved anew.
fn value(text: &str) -> f64 {
    let parameters = [7.0, 11.0];
    let value = resolve(text).evaluate(&POINT, &parameters);
    let printed = parse(text).to_string();
    assert_eq!(resolve(&printed).evaluate(&POINT, &parameters), value);
    let names = |names: &[&str]| {
        names
            .iter()
            .map(|name| (*name).to_owned())
            .collect::<Vec<_>>()
    };
    let written = resolve(text).written(&names(&["x", "y", "z"]), &names(&["a", "b"]));
    assert_eq!(
        resolve(&written).evaluate(&POINT, &parameters),
        value,
        "{text} is written {written}"
    );
    value
}

#[test]
fn functions_in_pieces_have_their_values() {
    for (text, expected) in [
        ("abs(y)", 3.0),
        ("abs(-x)", 2.0),
        ("sign(y) + 10*sign(x) + 100*sign(x - 2)", 9.0),
        ("min(x, y)", -3.0),
        ("max(x, y)", 2.0),
        ("max(1e300, x)", 1e300),
        ("min(x, y, z) + 10*max(x, y, z, 4)", 47.0),
        ("max(y, -7, -5)", -3.0),
        ("min(1e-300, z)", 1e-300),
        ("floor(y/2) + ceil(y/2)", -3.0),
        ("floor(2.5) + 10*ceil(2.5)", 32.0),
        ("mod(7.5, x)", 1.5),
        ("mod(-7.5, x)", 0.5),
        ("mod(7.5, y)", -1.5),
        ("mod(6, y)", 0.0),
        ("mod(-1e-20, x)", 0.0),
        ("mod(7.5e200, 2e-200) + 1", 1.0),
        ("heaviside(x) + heaviside(y) + heaviside(x - 2)", 1.0),
        ("sec(0) + cot(pi/4)", 2.0),
        ("csc(pi/2)", 1.0),
        ("log10(1000) + log2(8)", 6.0),
        ("erf(0) + erfc(0)", 1.0),
        ("gamma(z) + lgamma(1)", 24.0),
        ("j0(0) + j1(0) + j1(0, 1)", 1.5),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
}

#[test]
fn a_choice_takes_one_value_and_does_not_look_at_the_other() {
    for (text, expected) in [
        ("if(x < 3, 1, 2)", 1.0),
        ("if(x < 2, 1, 2)", 2.0),
        ("if(x <= 2, 1, 2)", 1.0),
        ("if(x > 2, 1, 2)", 2.0),
        ("if(x >= 2, 1, 2)", 1.0),
        ("if(0 < x, 1, 2)", 1.0),
        ("if(x > 0, 1, 2)", 1.0),
        ("if(0 >= y, 1, 2)", 1.0),
        ("if(y < x and x < z, 1, 2)", 1.0),
        ("if(y < x < z, 1, 2)", 1.0),
        ("if(z < x < y or x < z, 1, 2)", 1.0),
        ("if(z < x and x < z or y > 0, 1, 2)", 2.0),
        ("if(y > 0 or x > 0 and z < 0, 1, 2)", 2.0),
        ("if(x > 0, if(y > 0, 1, 2), 3)", 2.0),
        ("2*if(y > 0, sqrt(y), x)", 4.0),
        ("if(y < 0, x, ln(y)/0)", 2.0),
        ("if(a < b, x, y)", 2.0),
        ("if(2 < 1, sqrt(-1), x)", 2.0),
        ("if(x == 2, 1, 2)", 1.0),
        ("if(x != 2, 1, 2)", 2.0),
        ("if(x == y, 1, 2)", 2.0),
        ("if(x != y, 1, 2)", 1.0),
        ("if(not x == 2, 1, 2)", 2.0),
        ("if(not (x < y or y < -5), 1, 2)", 1.0),
        ("if((x < y or z > x) and (y < 0), 1, 2)", 1.0),
        ("if(x < y or z > x and y > 0, 1, 2)", 2.0),
        ("if(not x < y and not not z > x, 1, 2)", 1.0),
        ("if((x + y)*2 < (z), 1, 2)", 1.0),
        ("if(((x < z)) and max((x), y) == 2, 1, 2)", 1.0),
        ("if(not (x < z and y < x), 1, 2)", 2.0),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
    // What has no value is of no side.
    for text in [
        "if(ln(y) > 0, 1, 2)",
        "if(ln(y) <= 0, 1, 2)",
        "max(ln(y), 1)",
        "if(ln(y) == 0, 1, 2)",
        "if(not ln(y) != 0, 1, 2)",
        "mod(z, x - 2)",
    ] {
        assert!(
            resolve(text).evaluate(&POINT, &[0.0, 0.0]).is_nan(),
            "{text}"
        );
    }
}

#[test]
fn values_of_parameters_take_the_same_functions() {
    for text in [
        "atan2(a, -b)",
        "mod(-a, b)",
        "if(a < b and b < 100, a, b)",
        "if(a > b or a > 1, a, b)",
        "min(a, b) + max(a, 3) + abs(-a) + cot(a)",
        "D(a^3*b, a)",
        "ellipk(1/a) + lgamma(a, 2)",
    ] {
        let parameters = [7.0, 11.0];
        let number = parse(text)
            .value(&scalars(), &parameters, None)
            .expect(text);
        assert_eq!(
            number,
            resolve(text).evaluate(&POINT, &parameters),
            "{text}"
        );
    }
    // An index is a number there.
    let lattice = scalars().with_family("u", 3, 5);
    let number =
        parse("D(a^2*i, a) + sum(j, D(b*j, b))*i").value(&lattice, &[7.0, 11.0], Some((&["i"], 3)));
    assert_eq!(number.expect("a number"), 14.0 * 3.0 + 10.0 * 3.0);
    assert!(
        parse("D(a*x, a)")
            .value(&scalars(), &[7.0, 11.0], None)
            .is_err()
    );
}

#[test]
fn a_derivative_is_the_formula_of_one() {
    for (text, expected) in [
        ("D(x^3, x)", 12.0),
        ("D(x^3*y, x, y)", 12.0),
        ("D(D(x^3*y, x), x)", -36.0),
        ("D(a*x^2, a)", 4.0),
        ("D(x^2, z)", 0.0),
        ("D(abs(y)*x, y)", -2.0),
        ("D(min(x, y)^2, y)", -6.0),
        ("D(if(x > 0, x^2, sqrt(-x)), x)", 4.0),
        ("D(mod(x*7, 3), x)", 7.0),
        ("D(floor(x), x) + D(sign(x), x)", 0.0),
        ("D(atan2(y, x), x)", 3.0 / 13.0),
        ("D(atan2(y, x), y)", 2.0 / 13.0),
        ("D(log2(x), x)*ln(2)", 0.5),
        ("D(j0(x), x) + j1(x)", 0.0),
        ("D(lgamma(x), x) - lgamma(x, 1)", 0.0),
    ] {
        let found = value(text);
        assert!(
            (found - expected).abs() <= 4.0 * f64::EPSILON,
            "{text}: {found}"
        );
    }
    let scope = scalars().with_definition("r", resolve("sqrt(x^2 + y^2)"));
    let slope = parse("D(1/r, x)")
        .resolve(&scope, None)
        .expect("known names");
    let slope = slope.expect("no boundary").evaluate(&POINT, &[0.0, 0.0]);
    let expected = -2.0 / (13.0 * libm::sqrt(13.0));
    assert!((slope - expected).abs() <= 4.0 * f64::EPSILON);
    // B = curl A of A = (0, x² z, x y).
    let curl = ["D(x*y, y) - D(x^2*z, z)", "-D(x*y, x)", "D(x^2*z, x)"];
    assert_eq!(curl.map(value), [2.0 - 4.0, 3.0, 20.0]);
    let lattice = Scope::new().with_family("u", 0, 4);
    let sum = parse("D(sum(i, u[i]^2*u[i+1]), u[2])").resolve(&lattice, None);
    let sum = sum.expect("known names").expect("no boundary");
    // 2 u₂ u₃ + u₁².
    assert_eq!(sum.evaluate(&[1.0, 2.0, 3.0, 5.0], &[]), 34.0);
    let x = Quantity::Variable(0);
    assert_eq!(x.abs().derivative(x), Ok(x.sign()));
}

#[test]
fn what_is_wrong_with_a_choice_or_a_derivative_is_said() {
    let scope = scalars()
        .with_definition("r", resolve("x^2"))
        .with_parameters(&["gamma", "D"]);
    for (text, place, message) in [
        (
            "if(x, 1, 2)",
            ",",
            "expected `<`, `<=`, `>`, `>=`, `==` or `!=`, found `,`",
        ),
        (
            "if(x < 1, 2)",
            ")",
            "expected `,` and the value elsewhere, found `)`",
        ),
        (
            "if(x < 1)",
            ")",
            "expected `,` and the value where the condition holds, found `)`",
        ),
        ("x < 1", "<", "expected an operator"),
        ("if(x = 1, 1, 2)", "=", "did you mean `==`?"),
        ("if(x ≠ 1, 1, 2)", "≠", "did you mean `!=`?"),
        ("if(not x, 1, 2)", ",", "expected `<`, `<=`, `>`, `>=`"),
        (
            "if((x < 1, 1, 2)",
            ",",
            "expected an operator or `)`, found `,`",
        ),
        (
            "atan2(x)",
            ")",
            "expected `,` and a second argument, found `)`",
        ),
        ("abs(x, y)", ",", "expected an operator or `)`, found `,`"),
        (
            "j0(x, y)",
            "y",
            "expected a whole number below 256, how often the function is differentiated",
        ),
        (
            "gamma(x)",
            "gamma",
            "`gamma` is a name of the scene here, not a function",
        ),
        (
            "D(x^2, x)",
            "D",
            "`D` is a name of the scene here, not a function",
        ),
        ("arctan(x)", "arctan", "did you mean `atan`?"),
        ("fabs(x)", "fabs", "did you mean `abs`?"),
        ("Log(x)", "Log", "did you mean `ln`?"),
        ("pow(x, 2)", "pow", "did you mean `x^y`?"),
        ("ln10(x)", "ln10", "did you mean `ln(10)`?"),
        ("step(x)", "step", "did you mean `heaviside`?"),
        ("blob(x)", "blob", "there are exp, ln, sqrt,"),
    ] {
        let error = refusal(text, &scope);
        assert_eq!(text.get(error.span.clone()), Some(place), "{text}: {error}");
        assert!(error.to_string().contains(message), "{text}: {error}");
    }
    let scope = scalars().with_definition("r", resolve("x^2"));
    let kind = |text: &str| parse(text).resolve(&scope, None).expect_err(text).kind;
    assert!(matches!(kind("D(x, r)"), Kind::DerivativeByFormula { name } if name == "r"));
    assert!(matches!(kind("D(x, w)"), Kind::UnknownName { name } if name == "w"));
    assert!(matches!(kind("D(x^y, x)"), Kind::NoDerivative { .. }));
    assert!(matches!(
        refusal("D(x, 2)", &scope).kind,
        Kind::Expected { .. }
    ));
    assert!(matches!(
        refusal("D(x)", &scope).kind,
        Kind::Expected { .. }
    ));
    // A name that is a function's stands for itself where no parenthesis follows.
    let scope = Scope::new().with_parameters(&["gamma", "D", "j1", "if"]);
    let sum = parse("gamma + D + j1 + if").resolve(&scope, None);
    assert_eq!(
        sum.expect("names")
            .expect("a sum")
            .evaluate(&[], &[1.0, 2.0, 3.0, 4.0]),
        10.0
    );
}

/// Thousands of arguments and conditions lie a logarithm deep: nothing that walks the formula runs out of stack.
#[test]
fn many_arguments_and_conditions_are_not_as_deep_as_they_are_many() {
    let count = 20_000_i32;
    let arguments: Vec<String> = (0..count).map(|i| format!("x - {i}")).collect();
    let joined = |word: &str| {
        let parts: Vec<String> = (0..count).map(|i| format!("x > {i} + y")).collect();
        format!("if({}, 1, 0)", parts.join(word))
    };
    for (text, expected) in [
        (
            format!("min({})", arguments.join(", ")),
            3.0 - f64::from(count),
        ),
        (format!("max({})", arguments.join(", ")), 2.0),
        (joined(" or "), 1.0),
        (joined(" and "), 0.0),
    ] {
        let formula = resolve(&text);
        assert!(formula.height() < 100, "{}", formula.height());
        assert_eq!(formula.evaluate(&POINT, &[]), expected);
    }
    let all: Vec<String> = (0..100).map(|i| format!("x > y - {i}")).collect();
    assert_eq!(value(&format!("if({}, z, x)", all.join(" and "))), 5.0);
    assert_eq!(value(&format!("if({}, z, x)", all.join(" or "))), 5.0);
    assert_eq!(value(&format!("if(not ({}), z, x)", all.join(" or "))), 2.0);
}
