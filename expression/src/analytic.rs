//! Functions known by their values and those of their derivatives, where no formula serves.

use std::fmt;
use std::hash::{Hash, Hasher};

use crate::elementary::NearZero;
use crate::table::TableFunction;

/// An analytic function f of one variable that a crate evaluates itself: straight-line code calls
/// it and its derivatives f⁽ᵏ⁾ like elementary functions.
///
/// For closed forms with a removable singularity, such as sin(√s/2)/√s at s = 0, whose formula
/// neither has a value there nor is accurate nearby. Two functions of the same name are one.
#[derive(Clone, Copy)]
pub struct AnalyticFunction {
    name: &'static str,
    values: Values,
}

/// Where the values come from.
#[derive(Clone, Copy)]
enum Values {
    /// f⁽ᵏ⁾(s) for each k.
    Orders(fn(u32, f64) -> f64),
    /// A pair and which of the two functions it is, with its derivative.
    Pair(&'static FunctionPair, Member, fn() -> Slope),
    /// The parts of a table, by their codes in the place of orders.
    Table(TableFunction),
    /// The number itself, as if it did not depend on anything.
    Held,
}

/// f′ = constant + factor·g: the derivative of a function that is expressed by another one, or by itself.
#[derive(Clone, Copy, Debug)]
pub struct Slope {
    /// The constant.
    pub constant: i64,
    /// The factor of g.
    pub factor: i64,
    /// g.
    pub of: AnalyticFunction,
}

impl AnalyticFunction {
    /// The number s itself with derivatives that are 0: code behind it is not differentiated. For the steps of an
    /// iteration whose last one has the derivative of what they converge to.
    pub const HELD: Self = Self {
        name: "held",
        values: Values::Held,
    };

    /// The function with f⁽ᵏ⁾(s) = `derivative(k, s)`, NaN outside its domain: the same bits on
    /// every machine, so without the elementary functions of `std`.
    pub const fn new(name: &'static str, derivative: fn(u32, f64) -> f64) -> Self {
        Self {
            name,
            values: Values::Orders(derivative),
        }
    }

    /// A member of a pair, with its derivative: code that has the function needs no further call for it.
    pub const fn of_pair(
        pair: &'static FunctionPair,
        member: Member,
        slope: fn() -> Slope,
    ) -> Self {
        Self {
            name: pair.names[member as usize],
            values: Values::Pair(pair, member, slope),
        }
    }

    /// The functions of one number of which a table is evaluated, by their codes in the place of orders.
    pub(crate) fn of_table(table: TableFunction) -> Self {
        Self {
            name: table.unique_name(),
            values: Values::Table(table),
        }
    }

    /// The pair that it is a member of.
    pub fn pair(&self) -> Option<(&'static FunctionPair, Member)> {
        match self.values {
            Values::Orders(_) | Values::Table(_) | Values::Held => None,
            Values::Pair(pair, member, _) => Some((pair, member)),
        }
    }

    /// Its derivative, where that is expressed by a function again.
    pub(crate) fn slope(&self) -> Option<Slope> {
        match self.values {
            Values::Orders(_) | Values::Table(_) | Values::Held => None,
            Values::Pair(_, _, slope) => Some(slope()),
        }
    }

    /// Whether it is [`HELD`](Self::HELD).
    pub(crate) fn is_held(&self) -> bool {
        matches!(self.values, Values::Held)
    }

    /// Stand-in that is equal to the function of this name: functions compare by name. Its values are NaN.
    pub(crate) fn named(name: &'static str) -> Self {
        Self::new(name, |_, _| f64::NAN)
    }

    /// The name that identifies it.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// f⁽ᵏ⁾(s).
    pub fn derivative(&self, order: u32, s: f64) -> f64 {
        match self.values {
            Values::Orders(derivative) => derivative(order, s),
            Values::Table(table) => table.part(order, s),
            Values::Held if order == 0 => s,
            Values::Held => 0.0,
            Values::Pair(pair, member, _) if order == 0 => {
                let (f, g) = (pair.values)(s);
                match member {
                    Member::First => f,
                    Member::Second => g,
                }
            }
            Values::Pair(..) => {
                let mut values = [s];
                self.derivative_lanes(order, &mut values);
                values[0]
            }
        }
    }

    /// Replaces each s by f⁽ᵏ⁾(s), to the bits of [`AnalyticFunction::derivative`].
    pub fn derivative_lanes(&self, order: u32, values: &mut [f64]) {
        match self.values {
            Values::Orders(derivative) => {
                values.iter_mut().for_each(|s| *s = derivative(order, *s));
            }
            Values::Table(table) => table.part_lanes(order, values),
            Values::Held if order == 0 => {}
            Values::Held => values.fill(0.0),
            Values::Pair(pair, member, _) if order == 0 => {
                (pair.lanes_alone[member as usize])(values);
            }
            Values::Pair(_, _, slope) => {
                let slope = slope();
                slope.of.derivative_lanes(order - 1, values);
                let constant = if order == 1 { slope.constant } else { 0 };
                for value in values {
                    *value = constant as f64 + slope.factor as f64 * *value;
                }
            }
        }
    }
}

/// Two functions f and g of one argument that cost together little more than one of them: where
/// straight-line code needs both, they are computed at once.
#[derive(Debug)]
pub struct FunctionPair {
    /// The names of f and g.
    pub names: [&'static str; 2],
    /// f(x) and g(x).
    pub values: fn(f64) -> (f64, f64),
    /// Replaces each x by f(x) and writes g(x), to the bits of `values`.
    pub lanes: fn(&mut [f64], &mut [f64]),
    /// Replace each x by f(x), and by g(x), to the bits of `values`.
    pub lanes_alone: [fn(&mut [f64]); 2],
    /// The formulas of both near 0, to the bits of `values`, where they are plain there.
    #[cfg_attr(not(feature = "jit"), allow(dead_code, reason = "for machine code"))]
    pub(crate) near_zero: Option<fn() -> NearZero>,
}

/// Which function of a [`FunctionPair`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Member {
    /// f.
    First,
    /// g.
    Second,
}

impl Member {
    /// The other one.
    pub fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }
}

impl PartialEq for AnalyticFunction {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for AnalyticFunction {}

impl Hash for AnalyticFunction {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name.hash(state);
    }
}

impl fmt::Debug for AnalyticFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::AnalyticFunction;
    use crate::arithmetic::Arithmetic;
    use crate::expression::Function;
    use crate::graph::{Graph, Term};
    use crate::kernel::Kernel;
    use crate::rational::Rational;

    const SINE: AnalyticFunction = AnalyticFunction::new("test-sine", |order, s| match order % 4 {
        0 => libm::sin(s),
        1 => libm::cos(s),
        2 => -libm::sin(s),
        _ => -libm::cos(s),
    });

    /// f(2 x y) and its derivatives to the third order, f once a node of its own and once a formula.
    #[test]
    fn code_and_derivatives_are_those_of_the_elementary_function() {
        let mut graph = Graph::new();
        let (x, y) = (graph.input(0), graph.input(1));
        let product = graph.multiply(&x, &y);
        let argument = graph.scale(&Rational::from_integer(2), &product);
        let opaque = graph.apply_analytic(SINE, 0, &argument);
        assert_eq!(opaque, graph.apply_analytic(SINE, 0, &argument));
        let known = graph.apply(Function::Sin, &argument).expect("code");
        let mut outputs: Vec<Term> = Vec::new();
        for term in [opaque, known] {
            let mut derivative = term;
            outputs.push(derivative.clone());
            for input in [0, 1, 0] {
                derivative = graph.derivative(&derivative, input).expect("code");
                outputs.push(derivative.clone());
            }
        }
        let kernel = Kernel::compile(&graph, &outputs, 0, 2);
        // f to its third derivative, and sine and cosine.
        assert_eq!(kernel.step_operations().functions, 6);
        for lanes in [1, 3, 8] {
            let mut workspace = kernel.workspace(lanes);
            let sizes = vec![1.0; lanes];
            kernel.prepare(&mut workspace, &[], &sizes, &sizes);
            let mut values = vec![0.0; 8 * lanes];
            kernel.evaluate(
                &mut workspace,
                &[vec![0.7; lanes], vec![-0.4; lanes]].concat(),
                &mut values,
            );
            for k in 0..4 {
                let (found, expected) = (values[k * lanes], values[(4 + k) * lanes]);
                let error = (found - expected).abs();
                assert!(error <= 4.0 * f64::EPSILON, "f^({k}): {found} {expected}");
            }
        }
    }

    /// f(held(x) y): no derivative by x, and no call.
    #[test]
    fn what_is_held_is_not_differentiated() {
        let mut graph = Graph::new();
        let (x, y) = (graph.input(0), graph.input(1));
        let square = graph.multiply(&x, &x);
        let held = graph.apply_analytic(AnalyticFunction::HELD, 0, &square);
        let product = graph.multiply(&held, &y);
        let gradient = graph.gradient(&product, 2).expect("code");
        assert!(gradient[0].scale.is_zero());
        let slopes = [0, 1].map(|input| graph.derivative(&product, input).expect("code"));
        assert!(slopes[0].scale.is_zero());
        assert_eq!(slopes[1], gradient[1]);
        let kernel = Kernel::compile(&graph, &[product, slopes[1].clone()], 0, 2);
        assert_eq!(kernel.step_operations().functions, 0);
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
        let mut values = [0.0; 2];
        kernel.evaluate(&mut workspace, &[3.0, 0.5], &mut values);
        assert_eq!(values, [4.5, 9.0]);
        let derivatives = [0, 1, 2].map(|order| AnalyticFunction::HELD.derivative(order, 0.25));
        assert_eq!(derivatives, [0.25, 0.0, 0.0]);
    }

    #[test]
    fn a_constant_argument_is_evaluated_with_the_coefficients() {
        let mut graph = Graph::new();
        let half = graph.constant(&Rational::new(1, 2));
        let value = graph.apply_analytic(SINE, 1, &half);
        assert!(graph.derivative(&value, 0).expect("code").scale.is_zero());
        let kernel = Kernel::compile(&graph, &[value], 0, 0);
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &[], &[1.0], &[1.0]);
        let mut values = [0.0];
        kernel.evaluate(&mut workspace, &[], &mut values);
        assert_eq!(values[0], libm::cos(0.5));
    }
}
