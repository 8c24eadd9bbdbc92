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

/// M = Σ q_i² within a sum over i, beside an index i, and within another definition: its i is its own.
#[test]
fn indices_of_a_definition_are_its_own() {
    let scope = Scope::new().with_family("q", 0, 5);
    let q = [0.3, -1.1, 2.0, 0.7, -0.4];
    let sum = |of: &dyn Fn(f64) -> f64| q.iter().map(|q| of(*q)).sum::<f64>();
    let (first, second) = (sum(&|q| q), sum(&|q| q * q));
    let m = parse("sum(i, q[i]^2)");
    let n = parse("sum(i, q[i]*M)").written_out(&[("M", &m)]);
    let n = n.expect("a formula");
    for (text, expected) in [
        ("sum(i, q[i]*M)", first * second),
        ("sum(i, q[i]^2*M/N)", second * second / 5.0),
        (
            "sum(i<j, q[i]*q[j]) + W",
            (first * first - second) / 2.0 + first * second,
        ),
        ("M^2", second * second),
    ] {
        let written = parse(text).written_out(&[("M", &m), ("W", &n)]);
        let written = written.expect("a formula");
        let resolved = written.resolve(&scope, None).expect(text);
        let value = resolved.expect("no boundary").evaluate(&q, &[]);
        assert!((value - expected).abs() < 1e-13, "{text}: {value}");
        let Ok(pairs) = written.pair_sums(&scope, 5) else {
            assert!(text.contains("W"), "{text}");
            continue;
        };
        let sums = pairs.sums.iter().map(|sum| {
            let sites = q.iter().map(|q| sum.site.evaluate(&[*q, 0.0], &[]));
            let of_pairs = (0..5).flat_map(|i| (i + 1..5).map(move |j| [q[i], q[j]]));
            sites.sum::<f64>() + of_pairs.map(|x| sum.pair.evaluate(&x, &[])).sum::<f64>()
        });
        let state: Vec<f64> = q.iter().copied().chain(sums).collect();
        let value = pairs.outer.evaluate(&state, &[]);
        assert!((value - expected).abs() < 1e-12, "{text}: {value} in pairs");
    }
    let at_site = parse("q[i]*M")
        .written_out(&[("M", &m)])
        .expect("a formula");
    let index = (&["i"][..], 2);
    let value = at_site.resolve(&scope, Some(index)).expect("names");
    let value = value.expect("no boundary").evaluate(&q, &[]);
    assert!((value - 2.0 * second).abs() < 1e-13, "{value}");
    let error = Formula::parse("sum(i, q[i]*sum(i, q[i]))").expect_err("one index twice");
    assert!(matches!(error.kind, Kind::DuplicateIndex { .. }), "{error}");
}
