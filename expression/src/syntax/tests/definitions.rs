use super::super::SyntaxErrorKind as Kind;
use super::*;

/// a and x, half = a/2, twice = 2 x.
fn scope() -> Scope {
    let scope = Scope::new().with_variables(&["x"]).with_parameters(&["a"]);
    let value = |scope: &Scope, text: &str| parse(text).resolve(scope, None).expect(text);
    let half = value(&scope, "a/2").expect("no boundary");
    let scope = scope.with_definition("half", half);
    let twice = value(&scope, "2*x*half/half").expect("no boundary");
    scope.with_definition("twice", twice)
}

#[test]
fn names_stand_for_their_formulas() {
    let resolved = parse("twice^2 + half").resolve(&scope(), None);
    let expression = resolved.expect("known").expect("no boundary");
    assert_eq!(expression.evaluate(&[3.0], &[5.0]), 38.5);
}

/// A definition that is an integer is one as an exponent.
#[test]
fn a_number_with_a_name_is_an_exponent() {
    let scope = scope().with_definition("n", resolve("3"));
    let resolved = parse("x^n").resolve(&scope, None);
    let expression = resolved.expect("known").expect("no boundary");
    assert_eq!(expression.evaluate(&[-2.0], &[5.0]), -8.0);
}

#[test]
fn a_number_is_made_of_definitions_of_parameters() {
    let value = |text: &str| parse(text).value(&scope(), &[5.0], None);
    assert_eq!(value("half + 1"), Ok(3.5));
    let error = value("half + twice").expect_err("of the state");
    assert_eq!(error.span, 7..12);
    assert!(matches!(error.kind, Kind::NotAFunctionOfParameters { .. }));
    let error = parse("half")
        .value(&scope(), &[], None)
        .expect_err("no value");
    assert!(matches!(error.kind, Kind::ParameterWithoutValue { .. }));
    let error = value("half[0]").expect_err("no family");
    assert!(matches!(error.kind, Kind::NotAFamily { .. }));
}

#[test]
fn misspelt_definitions_are_named() {
    assert_eq!(
        refusal("twyce", &scope()).suggestion.as_deref(),
        Some("twice")
    );
    let error = refusal("x + half[0]", &scope());
    assert!(matches!(error.kind, Kind::NotAFamily { .. }), "{error}");
}
