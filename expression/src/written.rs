//! Resolved formulas as text, with the names of their variables and parameters.

use crate::expression::{Expression, Function};
use crate::rational::Rational;

/// How tightly a text holds together; in a place that needs more it is put in parentheses.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Binding {
    Sum,
    Product,
    Power,
    Atom,
}

/// A text with the sign in front of it.
struct Written {
    is_negative: bool,
    text: String,
    binding: Binding,
}

impl Expression {
    /// The formula as text that parses to the same function: factors 1 and sums of one term are left
    /// out, negative powers stand below a fraction line. What is shared is written out wherever it stands.
    ///
    /// # Panics
    /// When an index is outside `variables` or `parameters`.
    pub fn written(&self, variables: &[String], parameters: &[String]) -> String {
        let names = Names {
            variables,
            parameters,
        };
        names.written(self).signed().text
    }
}

impl Written {
    fn new(text: impl Into<String>, binding: Binding) -> Self {
        Self {
            is_negative: false,
            text: text.into(),
            binding,
        }
    }

    fn atom(text: impl Into<String>) -> Self {
        Self::new(text, Binding::Atom)
    }

    /// The text with its sign, as a sum's first term.
    fn signed(self) -> Self {
        match self.is_negative {
            true => Self::new(format!("-{}", self.text), Binding::Sum),
            false => self,
        }
    }

    /// The text, in parentheses unless it holds together as tightly as `place` needs.
    fn within(self, place: Binding) -> String {
        let part = self.signed();
        match part.binding < place {
            true => format!("({})", part.text),
            false => part.text,
        }
    }
}

struct Names<'a> {
    variables: &'a [String],
    parameters: &'a [String],
}

impl Names<'_> {
    fn written(&self, part: &Expression) -> Written {
        match part {
            Expression::Constant(value) => number(value),
            Expression::Pi => Written::atom("pi"),
            Expression::Variable(index) => Written::atom(&self.variables[*index]),
            Expression::Parameter(index) => Written::atom(&self.parameters[*index]),
            Expression::Sum(terms) => self.sum(terms),
            Expression::Negate(operand) => {
                let operand = self.written(operand);
                // The sign of a sum is that of its first term.
                if operand.binding == Binding::Sum {
                    let text = operand.within(Binding::Product);
                    return Written {
                        is_negative: true,
                        ..Written::new(text, Binding::Product)
                    };
                }
                Written {
                    is_negative: !operand.is_negative,
                    ..operand
                }
            }
            Expression::Product(_) | Expression::Quotient(..) => self.product(part),
            Expression::Power(base, exponent) => match exponent.as_ref() {
                Expression::Constant(value) if value.is_negative() => self.product(part),
                Expression::Constant(value) if *value == Rational::new(1, 2) => {
                    self.function(Function::Sqrt, base)
                }
                _ => {
                    let base = self.written(base).within(Binding::Atom);
                    let exponent = self.written(exponent).within(Binding::Atom);
                    Written::new(format!("{base}^{exponent}"), Binding::Power)
                }
            },
            Expression::Apply(function, argument) => self.function(*function, argument),
            Expression::Binary(function, pair) => {
                let [a, b] = pair.each_ref().map(|part| self.written(part).signed().text);
                Written::atom(format!("{}({a}, {b})", function.name()))
            }
            Expression::Lookup(lookup, point) => {
                let point = point.iter().map(|part| self.written(part).signed().text);
                Written::atom(lookup.called(point))
            }
            Expression::Where(parts) => {
                let [c, a, b] = parts
                    .each_ref()
                    .map(|part| self.written(part).signed().text);
                Written::atom(format!("if({c} > 0, {a}, {b})"))
            }
            Expression::Shared(shared) => self.written(shared),
        }
    }

    fn function(&self, function: Function, argument: &Expression) -> Written {
        let argument = self.written(argument).signed().text;
        Written::atom(function.called(&argument))
    }

    fn sum(&self, terms: &[Expression]) -> Written {
        let mut parts: Vec<Written> = terms.iter().map(|term| self.written(term)).collect();
        match parts.len() {
            0 => return Written::atom("0"),
            1 => return parts.remove(0),
            _ => {}
        }
        let mut text = String::new();
        for (at, part) in parts.into_iter().enumerate() {
            text.push_str(match (at, part.is_negative) {
                (0, false) => "",
                (0, true) => "-",
                (_, false) => " + ",
                (_, true) => " - ",
            });
            text.push_str(&part.text);
        }
        Written::new(text, Binding::Sum)
    }

    /// A product of factors above and below a fraction line.
    fn product(&self, part: &Expression) -> Written {
        let mut factors = Factors {
            number: Rational::one(),
            above: Vec::new(),
            below: Vec::new(),
        };
        factors.take(part, false);
        let mut is_negative = factors.number.is_negative();
        let (mut above, mut below) = (Vec::new(), Vec::new());
        match numeral(&factors.number.abs()) {
            Numeral::One => {}
            Numeral::Whole(text) => above.push(text),
            Numeral::Fraction(numerator, denominator) => {
                above.extend(numerator);
                below.push(denominator);
            }
        }
        for (into, parts) in [(&mut above, factors.above), (&mut below, factors.below)] {
            for factor in parts {
                let factor = self.written(&factor);
                is_negative ^= factor.is_negative;
                let unsigned = Written {
                    is_negative: false,
                    ..factor
                };
                into.push(unsigned.within(Binding::Power));
            }
        }
        if above.is_empty() {
            above.push("1".to_owned());
        }
        let binding = match (above.len(), below.len()) {
            (1, 0) => Binding::Power,
            _ => Binding::Product,
        };
        let mut text = above.join("*");
        match below.as_slice() {
            [] => {}
            [one] => text = format!("{text}/{one}"),
            many => text = format!("{text}/({})", many.join("*")),
        }
        Written {
            is_negative,
            text,
            binding,
        }
    }
}

/// The factors of a product: its number, and what stands above and below the line.
struct Factors {
    number: Rational,
    above: Vec<Expression>,
    below: Vec<Expression>,
}

impl Factors {
    fn take(&mut self, part: &Expression, is_below: bool) {
        match part {
            Expression::Product(factors) => factors.iter().for_each(|f| self.take(f, is_below)),
            Expression::Quotient(above, below) => {
                self.take(above, is_below);
                self.take(below, !is_below);
            }
            Expression::Negate(operand) => {
                self.number = -&self.number;
                self.take(operand, is_below);
            }
            Expression::Constant(value) if !value.is_zero() => {
                self.number = match is_below {
                    true => &self.number * &value.recip(),
                    false => &self.number * value,
                };
            }
            Expression::Power(base, exponent) => match exponent.as_ref() {
                Expression::Constant(value) if value.is_negative() => {
                    let exponent = -value;
                    match exponent.is_one() {
                        true => self.take(base, !is_below),
                        false => self.push(
                            Expression::Power(
                                base.clone(),
                                Box::new(Expression::Constant(exponent)),
                            ),
                            !is_below,
                        ),
                    }
                }
                Expression::Constant(value) if value.is_one() => self.take(base, is_below),
                _ => self.push(part.clone(), is_below),
            },
            Expression::Shared(shared) => self.take(shared, is_below),
            other => self.push(other.clone(), is_below),
        }
    }

    fn push(&mut self, factor: Expression, is_below: bool) {
        match is_below {
            true => self.below.push(factor),
            false => self.above.push(factor),
        }
    }
}

/// How a positive number is written as a factor.
enum Numeral {
    One,
    Whole(String),
    /// A numerator unless it is 1, and a denominator.
    Fraction(Option<String>, String),
}

/// Digits behind the point up to which a decimal is shorter to read than a fraction.
const MOST_DIGITS: u32 = 12;

/// Denominators up to this one stand below a fraction line.
const LARGEST_DENOMINATOR: u64 = 9;

fn numeral(value: &Rational) -> Numeral {
    if value.is_one() {
        return Numeral::One;
    }
    if value.is_integer() {
        return Numeral::Whole(value.to_string());
    }
    let denominator = value.denominator();
    let is_small = denominator <= LARGEST_DENOMINATOR.into() && value.numerator() < 100.into();
    if let Some(decimal) = decimal(value).filter(|_| !is_small) {
        return Numeral::Whole(decimal);
    }
    let numerator = value.numerator().to_string();
    Numeral::Fraction(
        (numerator != "1").then_some(numerator),
        denominator.to_string(),
    )
}

/// The number with a decimal point, where it ends.
fn decimal(value: &Rational) -> Option<String> {
    let mut scaled = value.clone();
    let mut digits = 0;
    while !scaled.is_integer() {
        if digits == MOST_DIGITS {
            return None;
        }
        scaled = &scaled * &Rational::from_integer(10);
        digits += 1;
    }
    let text = scaled.to_string();
    let digits = digits as usize;
    let text = format!("{text:0>width$}", width = digits + 1);
    let (whole, part) = text.split_at(text.len() - digits);
    Some(format!("{whole}.{part}"))
}

fn number(value: &Rational) -> Written {
    let mut written = match numeral(&value.abs()) {
        Numeral::One => Written::atom("1"),
        Numeral::Whole(text) => Written::atom(text),
        Numeral::Fraction(numerator, denominator) => Written::new(
            format!(
                "{}/{denominator}",
                numerator.unwrap_or_else(|| "1".to_owned())
            ),
            Binding::Product,
        ),
    };
    written.is_negative = value.is_negative();
    written
}

#[cfg(test)]
mod tests {
    use crate::syntax::{Formula, Scope};

    fn rewritten(text: &str) -> String {
        let scope = Scope::new()
            .with_variables(&["x", "y"])
            .with_parameters(&["a"]);
        let formula = Formula::parse(text).expect(text);
        let expression = formula.resolve(&scope, None).expect(text).expect(text);
        expression.written(&["x".into(), "y".into()], &["a".into()])
    }

    #[test]
    fn formulas_read_as_a_person_writes_them() {
        for (text, expected) in [
            ("1*x*2", "2*x"),
            ("-(x - y)", "-(x - y)"),
            ("x*y^(-1)*a^(-2)", "x/(y*a^2)"),
            ("0.5*x", "x/2"),
            ("2/3*x", "2*x/3"),
            ("0.125*x + 0.01*y", "x/8 + 0.01*y"),
            ("x^(1/2)", "sqrt(x)"),
            ("(x + y)^2*sin(-x)", "(x + y)^2*sin(-x)"),
            ("x - (-y)", "x + y"),
            ("x - (y - a)", "x - (y - a)"),
            ("-x*(-y)", "x*y"),
            ("(-x)^2", "(-x)^2"),
            ("x^-a", "x^(-a)"),
            ("1/(x*y)", "1/(x*y)"),
            ("0*x", "0*x"),
            ("-1/3", "-1/3"),
            ("(x/2)^2", "(x/2)^2"),
        ] {
            assert_eq!(rewritten(text), expected, "{text}");
        }
    }

    /// The text means the same function: it parses, to the same value up to a dozen roundings.
    #[test]
    fn what_is_written_parses_to_the_same_value() {
        let scope = Scope::new()
            .with_variables(&["x", "y"])
            .with_parameters(&["a"]);
        let value = |text: &str| {
            let formula = Formula::parse(text).expect(text);
            let expression = formula.resolve(&scope, None).expect(text).expect(text);
            expression.evaluate(&[1.7, -0.6], &[0.9])
        };
        for text in [
            "x - (y - (a - x))/(y*(x - a)^3)",
            "-(-x*(y/(-a)))^3 - 1/7",
            "exp(-x/(2*y^2))*x^(-2)/a^-3",
            "(x^2)^a/-y - 0.333*x*-2",
            "x/y/a - x/(y/a)",
            "2^x - sqrt(x*-y)",
        ] {
            let (before, after) = (value(text), value(&rewritten(text)));
            let bound = 64.0 * f64::EPSILON * before.abs();
            assert!(
                (before - after).abs() <= bound,
                "{text}: {}",
                rewritten(text)
            );
        }
    }
}
