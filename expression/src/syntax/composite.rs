//! Functions that are formulas of others: their pieces, and choices between formulas.

use crate::expression::{Binary, Expression, Function};
use crate::operators::negated;

/// How two numbers are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
}

impl Relation {
    pub(super) fn sign(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::LessOrEqual => "<=",
            Self::Greater => ">",
            Self::GreaterOrEqual => ">=",
            Self::Equal => "==",
            Self::NotEqual => "!=",
        }
    }
}

/// A function of several arguments, or of one by a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Composite {
    Min,
    Max,
    Two(Binary),
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
    ("mod", 2, Composite::Two(Binary::Mod)),
    ("atan2", 2, Composite::Two(Binary::Atan2)),
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

    /// How many arguments it has at least.
    pub(super) fn arguments(self) -> usize {
        self.entry().1
    }

    /// Whether it takes more arguments than that.
    pub(super) fn takes_more(self) -> bool {
        matches!(self, Self::Min | Self::Max)
    }

    /// The formula of its arguments. Of many it is that of halves, so that its height is their number's logarithm.
    pub(super) fn formula(self, arguments: Vec<Expression>) -> Expression {
        let mut values: Vec<Expression> = arguments.into_iter().map(Expression::shared).collect();
        if let [one] = &values[..] {
            return self.of_one(one);
        }
        while values.len() > 2 {
            let mut next = Vec::with_capacity(values.len().div_ceil(2));
            let mut pairs = values.into_iter();
            while let Some(first) = pairs.next() {
                next.push(match pairs.next() {
                    Some(second) => self.of_two(first, second).shared(),
                    None => first,
                });
            }
            values = next;
        }
        let mut pair = values.into_iter();
        match (pair.next(), pair.next()) {
            (Some(first), Some(second)) => self.of_two(first, second),
            _ => Expression::Sum(Vec::new()),
        }
    }

    fn of_two(self, x: Expression, y: Expression) -> Expression {
        match self {
            Self::Min => choice(&x - &y, y, x),
            Self::Two(function) => Expression::Binary(function, Box::new([x, y])),
            _ => choice(&x - &y, x, y),
        }
    }

    fn of_one(self, x: &Expression) -> Expression {
        let apply = |function, x: &Expression| Expression::Apply(function, Box::new(x.clone()));
        match self {
            Self::Ceil => -apply(Function::Floor, &-x),
            Self::Heaviside => choice(x.clone(), 1.into(), 0.into()),
            Self::Cot => 1 / apply(Function::Tan, x),
            Self::Sec => 1 / apply(Function::Cos, x),
            Self::Csc => 1 / apply(Function::Sin, x),
            Self::Min | Self::Max | Self::Two(_) => x.clone(),
        }
    }
}

/// a where c > 0, b elsewhere.
pub(super) fn choice(c: Expression, a: Expression, b: Expression) -> Expression {
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
        Relation::Equal | Relation::NotEqual => {
            let (a, b) = match relation {
                Relation::Equal => (a, b.shared()),
                _ => (b, a.shared()),
            };
            let u = (x - y).shared();
            return choice(u.clone(), b.clone(), choice(-u, b, a));
        }
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
