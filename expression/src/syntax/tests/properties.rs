use proptest::prelude::*;

use super::super::VariablePattern;
use super::*;

/// A chain of operands and operators without parentheses, and its value by reducing the operators
/// one rank after the other: powers from the right, signs, products and quotients, sums.
#[derive(Debug)]
struct Chain {
    text: String,
    value: f64,
}

fn chain(first: (bool, f64), rest: Vec<(char, bool, f64)>) -> Chain {
    let sign = |negative: bool| if negative { "-" } else { "" };
    let mut text = format!("{}{}", sign(first.0), first.1);
    let mut operands = vec![(first.0, first.1)];
    let mut operators = Vec::new();
    for (operator, negative, operand) in rest {
        text.push_str(&format!(" {operator}{}{operand}", sign(negative)));
        operators.push(operator);
        operands.push((negative, operand));
    }
    // The exponent at the right end of a tower is a number as written, the others are powers.
    let mut tower = None;
    while let Some(at) = operators.iter().rposition(|operator| *operator == '^') {
        let (negative, exponent) = operands.remove(at + 1);
        operators.remove(at);
        let base = operands[at].1;
        operands[at].1 = if tower == Some(at + 1) {
            libm::pow(base, if negative { -exponent } else { exponent })
        } else {
            let power = vec![base; exponent as usize].iter().product::<f64>();
            if negative { 1.0 / power } else { power }
        };
        tower = Some(at);
    }
    let mut values: Vec<f64> = operands
        .iter()
        .map(|(negative, x)| if *negative { -x } else { *x })
        .collect();
    while let Some(at) = operators
        .iter()
        .position(|operator| "*/".contains(*operator))
    {
        let right = values.remove(at + 1);
        match operators.remove(at) {
            '*' => values[at] *= right,
            _ => values[at] /= right,
        }
    }
    let mut value = values[0];
    for (operator, operand) in operators.iter().zip(&values[1..]) {
        value += if *operator == '+' { *operand } else { -operand };
    }
    Chain { text, value }
}

fn any_chain() -> impl Strategy<Value = Chain> {
    let operand = || (any::<bool>(), (1u8..5).prop_map(f64::from));
    let link = (
        prop::sample::select(vec!['+', '-', '*', '/', '^']),
        operand(),
    )
        .prop_map(|(operator, (negative, operand))| (operator, negative, operand));
    (operand(), prop::collection::vec(link, 0..9)).prop_map(|(first, rest)| chain(first, rest))
}

/// Texts of formulas, nested at random: of names and numbers, with sums over a family when `sums`.
fn any_formula(leaves: Vec<&'static str>, sums: bool) -> impl Strategy<Value = String> {
    let leaf = prop::sample::select(leaves).prop_map(str::to_owned);
    leaf.prop_recursive(6, 48, 3, move |inner| {
        let operator = prop::sample::select(vec!["+", "-", "*", "^", " - ", "**", "/(-2)*"]);
        // An inner text is shorter, so that sums inside each other have different indices.
        let around = move |a: String| {
            let j = a.len();
            if sums {
                format!("sum(j{j}, u[j{j}-1]*({a}))")
            } else {
                format!("cos({a})")
            }
        };
        prop_oneof![
            (inner.clone(), operator, inner.clone()).prop_map(|(a, o, b)| format!("{a}{o}{b}")),
            (inner.clone(), inner.clone()).prop_map(move |(a, b)| {
                if sums {
                    format!("{a}/{b}")
                } else {
                    format!("{a}*{b}")
                }
            }),
            inner.clone().prop_map(|a| format!("({a})")),
            inner.clone().prop_map(|a| format!("-{a}")),
            inner.clone().prop_map(|a| format!("sin({a})")),
            inner.clone().prop_map(|a| format!("abs({a})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("if({a} < {b}, {b}, {a})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("max({a}, {b})")),
            inner.prop_map(around),
        ]
    })
}

/// Texts made of pieces that formulas contain, and texts of any characters.
fn any_garbage() -> impl Strategy<Value = String> {
    let pieces = vec![
        "x",
        "u",
        "i",
        "N",
        "sum",
        "sum(i,",
        "sin",
        "(",
        ")",
        "[",
        "]",
        ",",
        "+",
        "-",
        "*",
        "/",
        "^",
        "1",
        "0.5",
        "1e",
        "e5",
        "9e9",
        "1e400",
        "99999999999",
        "u[i+1]",
        "γ",
        "²",
        "−",
        " ",
        ".",
        "pi",
        "log",
        "_",
    ];
    let soup = prop::collection::vec(prop::sample::select(pieces), 0..20).prop_map(|p| p.concat());
    prop_oneof![3 => soup, 1 => ".{0,40}"]
}

proptest! {
    #[test]
    fn chains_of_operators_have_the_value_of_their_ranks(chain in any_chain()) {
        let value = parse(&chain.text).value(&Scope::new(), &[], None).expect("numbers");
        let same = value == chain.value || (value.is_nan() && chain.value.is_nan());
        prop_assert!(same, "{} = {value}, expected {}", chain.text, chain.value);
    }

    #[test]
    fn a_printed_formula_parses_to_the_same_expression(
        text in any_formula(vec!["x", "y", "a", "pi", "2", "0.25", "1e-3", "u[i+1]", "N"], true),
    ) {
        let scope = scalars().with_family("u", 3, 2);
        let first = parse(&text);
        let second = parse(&first.to_string());
        prop_assert_eq!(second.to_string(), first.to_string());
        prop_assert_eq!(second.references(), first.references());
        let at = Some((&["i"][..], 1));
        prop_assert_eq!(second.resolve(&scope, at), first.resolve(&scope, at));
    }

    #[test]
    fn no_text_panics_and_every_span_lies_in_the_text(text in any_garbage()) {
        let scope = scalars().with_family("u", 3, 2).with_length(7);
        let within = |error: &SyntaxError| text.get(error.span.clone()).is_some();
        match Formula::parse(&text) {
            Err(error) => prop_assert!(within(&error), "{error:?}"),
            Ok(formula) => {
                prop_assert!(Formula::parse(&formula.to_string()).is_ok());
                let names = formula.free_indices();
                let index = (!names.is_empty()).then_some((&names[..], 1));
                let results = [
                    formula.resolve(&scope, index).err(),
                    formula.value(&scope, &[1.0], index).err(),
                ];
                for error in results.iter().flatten() {
                    prop_assert!(within(error), "{error:?}");
                }
            }
        }
        for error in [
            VariablePattern::parse_one(&text).err(),
            VariablePattern::parse_pair(&text).err(),
        ].iter().flatten() {
            prop_assert!(within(error), "{error:?}");
        }
    }

    /// The numbers are dyadic, so that the exact quotients of an expression are those of doubles.
    #[test]
    fn a_value_is_that_of_the_expression(
        text in any_formula(vec!["a", "b", "pi", "2", "0.25", "N"], false),
    ) {
        let scope = scalars().with_length(6);
        let formula = parse(&text);
        let value = formula.value(&scope, &[0.5, 1.25], None).expect("parameters");
        let expression = formula.resolve(&scope, None).expect("names").expect("no boundary");
        let expected = expression.evaluate(&[], &[0.5, 1.25]);
        prop_assert!(value == expected || (value.is_nan() && expected.is_nan()));
    }
}
