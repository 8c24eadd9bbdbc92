//! Lie series in numbers at one point.
//!
//! In exact algebra a Lie series that does not end grows until it is given up; in numbers its terms cost
//! microseconds. A term that is certainly not 0 at one point is not 0.

use std::collections::{BTreeMap, BTreeSet};

use leafwise_core::SystemFormulas;
use leafwise_expression::bounded::{Bounded, BoundedNumbers};
use leafwise_expression::series::{Tape, TaylorState};
use leafwise_expression::{AlgebraError, Arithmetic, Rational, Ring};

use crate::field::{Field, variables};

/// The longest Lie series that is tried.
pub(crate) const LONGEST: usize = 8;

/// Values above so many of their bounds are not 0.
const CERTAIN: f64 = 16.0;

/// A point of phase space, with the parameters' values.
pub struct Probe {
    x: Vec<f64>,
    parameters: Vec<f64>,
}

impl Probe {
    /// A point away from the one about which the system moves, where symmetry may hide terms.
    pub fn of(system: &SystemFormulas) -> Self {
        let x = system.points().pop();
        Self {
            x: x.unwrap_or_else(|| system.near().to_vec()),
            parameters: system.parameter_values(),
        }
    }

    /// Whether the numbers rule out a closed form of x_i(t), from dₖ = Dᵏx_i. They do where d₉ ≠ 0 and d₁d₄ ≠ d₂d₃.
    /// The series of a motion polynomial in time has ended before d₉. Both products are equal where d₂ = φd₁, Dφ = 0
    /// and where d₃ = −λd₁, Dλ = 0.
    pub fn rules_out(&self, ring: &Ring, field: &Field, index: usize) -> bool {
        let Ok(c) = self.series(ring, field, index) else {
            return false;
        };
        // dₖ = k! cₖ.
        let mut numbers = self.numbers();
        let products = [
            (Rational::from_integer(2), numbers.multiply(&c[1], &c[4])),
            (-Rational::one(), numbers.multiply(&c[2], &c[3])),
        ];
        is_not_zero(&c[LONGEST + 1]) && is_not_zero(&numbers.combine(&products))
    }

    /// The Taylor coefficients of x_i(t) to the order after [`LONGEST`].
    fn series(
        &self,
        ring: &Ring,
        field: &Field,
        index: usize,
    ) -> Result<Vec<Bounded>, AlgebraError> {
        let mut tape = Tape::new();
        let mut moving = BTreeMap::new();
        for i in reached(ring, field, index) {
            let velocity = tape.record(&ring.formula(&field[&i]))?;
            moving.insert(i, (velocity, vec![Bounded::exact(self.x[i])]));
        }
        let mut numbers = self.numbers();
        let mut state = TaylorState::new(&tape);
        for k in 0..=LONGEST {
            state.extend(&tape, &mut numbers, |_, i| match moving.get(&i) {
                Some((_, c)) => c[k],
                None if k == 0 => Bounded::exact(self.x[i]),
                None => Bounded::exact(0.0),
            })?;
            let share = Rational::new(1, k as i64 + 1);
            for (velocity, c) in moving.values_mut() {
                c.push(numbers.scale(&share, state.coefficient(*velocity, k)));
            }
        }
        Ok(moving.remove(&index).map(|(_, c)| c).unwrap_or_default())
    }

    fn numbers(&self) -> BoundedNumbers {
        BoundedNumbers {
            parameters: self.parameters.clone(),
        }
    }
}

fn is_not_zero(number: &Bounded) -> bool {
    number.value.abs() > CERTAIN * number.error
}

/// The variables that move and that x_i(t) depends on, x_i itself among them.
fn reached(ring: &Ring, field: &Field, index: usize) -> BTreeSet<usize> {
    let (mut found, mut open) = (BTreeSet::new(), vec![index]);
    while let Some(i) = open.pop() {
        let Some(velocity) = field.get(&i).filter(|_| !found.contains(&i)) else {
            continue;
        };
        found.insert(i);
        open.extend(variables(ring, velocity));
    }
    found
}
