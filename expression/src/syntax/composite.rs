//! Functions that are formulas of others: their pieces, and choices between formulas.

use crate::expression::{Expression, Function};
use crate::operators::negated;
use crate::rational::Rational;

/// How two numbers are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

impl Relation {
    pub(super) fn sign(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::LessOrEqual => "<=",
            Self::Greater => ">",
            Self::GreaterOrEqual => ">=",
        }
    }
}

/// A function of one argument or two by a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Composite {
    Min,
    Max,
    Mod,
    Atan2,
    Ceil,
    Heaviside,
    Cot,
    Sec,
    Csc,
}

/// The names, the numbers of arguments, and the functions.
const ALL: [(&str, usize, Composite); 9] = [
    ("min", 2, Composite::Min),
    ("max", 2, Composite::Max),
    ("mod", 2, Composite::Mod),
    ("atan2", 2, Composite::Atan2),
    ("ceil", 1, Composite::Ceil),
    ("heaviside", 1, Composite::Heaviside),
    ("cot", 1, Composite::Cot),
    ("sec", 1, Composite::Sec),
    ("csc", 1, Composite::Csc),
];

impl Composite {
    pub(super) fn names() -> impl Iterator<Item = &'static str> {
        ALL.into_iter().map(|(name, ..)| name)
    }

    pub(super) fn from_name(name: &str) -> Option<Self> {
        let found = ALL.into_iter().find(|(known, ..)| *known == name);
        found.map(|(.., composite)| composite)
    }

    fn entry(self) -> (&'static str, usize) {
        let found = ALL.into_iter().find(|(.., known)| *known == self);
        found.map_or(("", 0), |(name, count, _)| (name, count))
    }

    pub(super) fn name(self) -> &'static str {
        self.entry().0
    }

    /// How many arguments it has.
    pub(super) fn arguments(self) -> usize {
        self.entry().1
    }

    /// The formula of its arguments; a function of one takes the first.
    pub(super) fn formula(self, [x, y]: [Expression; 2]) -> Expression {
        let (x, y) = (x.shared(), y.shared());
        let apply = |function, x: &Expression| Expression::Apply(function, Box::new(x.clone()));
        match self {
            Self::Min => choice(&x - &y, y, x),
            Self::Max => choice(&x - &y, x, y),
            // x − y floor(x/y) is not from 0 to y where the quotient is rounded across an integer.
            Self::Mod => {
                let whole = apply(Function::Floor, &(&x / &y));
                let rest = (&x - &y * whole).shared();
                let within = choice(&y * (&y - &rest), rest.clone(), &rest - &y);
                choice(-(&rest * &y), &rest + &y, within)
            }
            // arctan of the quotient of which the denominator is the larger, and a quarter or half turn.
            Self::Atan2 => {
                let (y, x) = (x, y);
                let steep = (apply(Function::Abs, &y) - apply(Function::Abs, &x)).shared();
                let above = choice(steep.clone(), -&x, y.clone());
                let below = choice(steep.clone(), y.clone(), x.clone());
                let turn = |numerator: i64| {
                    Expression::Constant(Rational::new(numerator, 2)) * Expression::Pi
                };
                let of_steep = choice(y.clone(), turn(1), turn(-1));
                let of_flat = choice(x, 0.into(), choice(-&y, turn(-2), turn(2)));
                apply(Function::Atan, &(above / below)) + choice(steep, of_steep, of_flat)
            }
            Self::Ceil => -apply(Function::Floor, &-&x),
            Self::Heaviside => choice(x, 1.into(), 0.into()),
            Self::Cot => 1 / apply(Function::Tan, &x),
            Self::Sec => 1 / apply(Function::Cos, &x),
            Self::Csc => 1 / apply(Function::Sin, &x),
        }
    }
}

/// a where c > 0, b elsewhere.
fn choice(c: Expression, a: Expression, b: Expression) -> Expression {
    Expression::Where(Box::new([c, a, b]))
}

/// a where the relation of x and y holds, b elsewhere.
pub(super) fn compared(
    relation: Relation,
    [x, y]: [Expression; 2],
    a: Expression,
    b: Expression,
) -> Expression {
    let is_zero = |part: &Expression| matches!(part, Expression::Constant(c) if c.is_zero());
    // u > 0 or not, where x ≤ y is not x > y.
    let (above, below, is_strict) = match relation {
        Relation::Less => (y, x, true),
        Relation::Greater => (x, y, true),
        Relation::LessOrEqual => (x, y, false),
        Relation::GreaterOrEqual => (y, x, false),
    };
    let u = match (is_zero(&above), is_zero(&below)) {
        (_, true) => above,
        (true, false) => negated(below),
        (false, false) => above - below,
    };
    match is_strict {
        true => choice(u, a, b),
        false => choice(u, b, a),
    }
}
