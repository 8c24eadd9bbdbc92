//! Corners and jumps of formulas: functions that are 0 where a formula is not smooth.

use crate::expression::{Binary, Expression, Function};

impl Expression {
    /// Functions of which one changes its sign where the formula has a corner or jumps. These are u of |u| and sign u, and c of a
    /// choice by c > 0. They are sin(πu) of ⌊u⌋, sin(πa/b) of a remainder, and y of an angle. A choice by its own value is none.
    pub fn corners(&self) -> Vec<Self> {
        let whole =
            |u: Self| Self::Apply(Function::Sin, Box::new(Self::Product(vec![Self::Pi, u])));
        let mut corners: Vec<Self> = Vec::new();
        self.visit(&mut |part| {
            let found = match part {
                Self::Where(parts) if is_of_itself(parts) => None,
                Self::Where(parts) => Some(parts[0].clone()),
                Self::Apply(Function::Abs | Function::Sign, u) => Some((**u).clone()),
                Self::Apply(Function::Floor, u) => Some(whole((**u).clone())),
                Self::Binary(Binary::Mod, pair) => Some(whole(&pair[0] / &pair[1])),
                Self::Binary(Binary::Atan2, pair) => Some(pair[0].clone()),
                _ => None,
            };
            let found = found.filter(|found| !found.variables().is_empty());
            corners.extend(found.filter(|found| !corners.contains(found)));
        });
        corners
    }
}

/// c where c > 0, or −c where −c < 0: as comparisons are written that are nowhere 0.
fn is_of_itself([condition, value, _]: &[Expression; 3]) -> bool {
    condition == value || matches!(condition, Expression::Negate(inner) if **inner == *value)
}

#[cfg(test)]
mod tests {
    use crate::syntax::{Formula, Scope};

    fn scope() -> Scope {
        Scope::new().with_variables(&["x", "y"])
    }

    /// Zeros of the corners of formulas of x and y, on lines through them.
    #[test]
    fn corners_change_their_sign_where_formulas_are_not_smooth() {
        let scope = scope();
        for (text, places) in [
            ("abs(x - 0.5)", vec![0.5]),
            ("mod(x, 2) - y", vec![0.0, 2.0]),
            ("floor(x) + x^2", vec![0.0, 1.0, 2.0]),
            ("atan2(x - 1, -1)", vec![1.0]),
            ("min(x, 1.5) + max(x, 0.25)", vec![1.5, 0.25]),
            ("if(x > 2, x, 2*x)", vec![2.0]),
            ("x^2 + sin(y)", vec![]),
        ] {
            let formula = Formula::parse(text)
                .and_then(|f| f.resolve(&scope, None))
                .expect("a formula")
                .expect("no boundary");
            let corners = formula.corners();
            assert_eq!(corners.is_empty(), places.is_empty(), "{text}");
            for place in places {
                let signs = |x: f64| -> Vec<bool> {
                    corners
                        .iter()
                        .map(|c| c.evaluate(&[x, 0.3], &[]) > 0.0)
                        .collect()
                };
                assert_ne!(
                    signs(place - 0.01),
                    signs(place + 0.01),
                    "{text} at {place}"
                );
            }
        }
        let of = |text: &str| {
            Formula::parse_condition(text)
                .and_then(|c| c.margin(&scope))
                .expect("a condition")
        };
        assert!(of("x < 1").corners().is_empty());
        assert!(of("x^2 + y^2 >= 1").corners().is_empty());
        assert_eq!(of("x < 1 and y > 2").corners().len(), 1);
        assert_eq!(of("abs(x) < 1").corners().len(), 1);
    }

    /// Whether the slope of a margin along x turns as slowly at the centre as elsewhere. That of √(x² + y²) turns within 1e-9.
    fn is_smooth_at_the_centre(margin: &crate::Expression) -> bool {
        let slope = |x: f64| {
            let at = |x: f64| margin.evaluate(&[x, 1e-12], &[]);
            (at(x + 1e-9) - at(x - 1e-9)) / 2e-9
        };
        (slope(1e-7) - slope(-1e-7)).abs() < 1e-3
    }

    /// √u − b and what stands for it have one sign, for all b and beside other terms.
    #[test]
    fn magnitudes_are_compared_by_their_squares() {
        let scope = scope();
        let norm = |[x, y]: [f64; 2]| libm::hypot(x, y);
        type Margin<'a> = &'a dyn Fn([f64; 2]) -> f64;
        let cases: [(&str, Margin<'_>); 12] = [
            ("sqrt(x^2 + y^2) < 0.5", &|x| 0.5 - norm(x)),
            ("0.5 >= sqrt(x^2 + y^2)", &|x| 0.5 - norm(x)),
            ("2*sqrt(x*x + y^2) - 0.6 > 0", &|x| 2.0 * norm(x) - 0.6),
            ("x < y + sqrt(x^2 + 0.1)", &|[x, y]| {
                y + libm::sqrt(x * x + 0.1) - x
            }),
            ("-sqrt(x^2 + y^2) < x - 0.2", &|x| x[0] - 0.2 + norm(x)),
            ("sqrt(x^2 + y^2) > -0.5", &|x| norm(x) + 0.5),
            ("(x^2 + y^2)^0.5 < 0.5", &|x| 0.5 - norm(x)),
            ("(x^2 + y^2)^(1/2) < 0.5", &|x| 0.5 - norm(x)),
            ("sqrt(x^2 + y^2)/2 < 0.25", &|x| 0.25 - norm(x) / 2.0),
            ("-sqrt(x^2 + y^2)/(-2) < 0.25", &|x| 0.25 - norm(x) / 2.0),
            ("1/2*sqrt(x^2/3 + y*y)*4 > 1", &|[x, y]| {
                2.0 * libm::sqrt(x * x / 3.0 + y * y) - 1.0
            }),
            ("0.1 - (x^2 + y^2)^0.5/(1/3) < x", &|x| {
                x[0] - 0.1 + 3.0 * norm(x)
            }),
        ];
        for (text, expected) in cases {
            let margin = Formula::parse_condition(text).and_then(|c| c.margin(&scope));
            let margin = margin.expect("a condition");
            let mut signs = [0, 0];
            for at in 0..400 {
                let x = [at % 20, at / 20].map(|k| 0.1 * f64::from(k) - 0.987);
                let holds = expected(x) > 0.0;
                signs[usize::from(holds)] += 1;
                assert_eq!(margin.evaluate(&x, &[]) > 0.0, holds, "{text} at {x:?}");
            }
            assert!(signs[1] > 10, "{text}");
            assert!(is_smooth_at_the_centre(&margin), "{text}");
        }
        // Definitions are looked through, on both sides, and where they double at every level.
        let x = || crate::Expression::from(crate::Quantity::Variable(0));
        let norm = (x() * x()).shared();
        let norm = crate::Expression::Apply(crate::Function::Sqrt, Box::new(norm)).shared();
        let half = crate::Expression::Constant(crate::Rational::new(1, 2));
        let deep = (0..60).fold(x().shared(), |sum, _| (sum.clone() + sum).shared());
        for (left, right) in [
            (norm.clone(), half.clone()),
            ((norm.clone() - half.clone()).shared(), half.clone()),
            (half.clone(), (half + norm.clone()).shared()),
            (norm, deep),
        ] {
            let margin = crate::Expression::compared_magnitude(&left, &right);
            let margin = margin.expect("a root is compared");
            assert!(is_smooth_at_the_centre(&margin));
            for x in [0.25, 0.75, 1.25] {
                let expected = left.evaluate(&[x], &[]) - right.evaluate(&[x], &[]);
                assert_eq!(margin.evaluate(&[x], &[]) > 0.0, expected > 0.0, "{x}");
            }
        }
        // Near 0 it is smooth: a fourth of the way is a sixteenth of the square.
        let of = |text: &str| Formula::parse_condition(text).and_then(|c| c.margin(&scope));
        let margin = of("sqrt(x^2 + y^2) > 0").expect("a condition");
        assert!((margin.evaluate(&[0.25, 0.0], &[]) - 0.0625).abs() < 1e-15);
    }
}
