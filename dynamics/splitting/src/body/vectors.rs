//! Vectors that so(3) turns, found among coordinates.

use leafwise_expression::{Rational, Ring};

use crate::field::Field;

/// A vector by its components, each a coordinate with a sign.
pub(super) type Vector = [(usize, i64); 3];

/// The vector of which `first` is the first component, where the fields of m's coordinates turn it. The turns are
/// e₂ × n = (n₃, 0, −n₁) and e₃ × n = (−n₂, n₁, 0).
pub(super) fn vector(axes: [&Turns; 3], sign: i64, first: usize) -> Option<Vector> {
    let (to_third, third) = axes[1].of(first)?;
    let (to_second, second) = axes[2].of(first)?;
    let vector = [
        (first, 1),
        (second, -sign * to_second),
        (third, sign * to_third),
    ];
    let turns = |axis: usize| {
        let [of, next, other] = [0, 1, 2].map(|by| vector[(axis + by) % 3]);
        let sign = sign * next.1 * other.1;
        axes[axis].rests(of.0)
            && axes[axis].of(next.0) == Some((-sign, other.0))
            && axes[axis].of(other.0) == Some((sign, next.0))
    };
    (0..3).all(turns).then_some(vector)
}

/// The field of a coordinate where it is made of coordinates.
pub(super) struct Turns(Vec<Turn>);

enum Turn {
    Rests,
    /// ± a coordinate.
    Along(i64, usize),
    Otherwise,
}

impl Turns {
    pub(super) fn new(ring: &Ring, field: &Field) -> Self {
        let dimension = ring.variables();
        let turn = |at: usize| match field.get(&at) {
            None => Turn::Rests,
            Some(velocity) => {
                let along = velocity.symbols().first().copied();
                let along = along.filter(|symbol| (*symbol as usize) < dimension);
                let sign = along.and_then(|symbol| {
                    let x = ring.variable(symbol as usize);
                    [1, -1]
                        .into_iter()
                        .find(|sign| x.scaled(&Rational::from_integer(*sign)) == *velocity)
                });
                match (along, sign) {
                    (Some(symbol), Some(sign)) => Turn::Along(sign, symbol as usize),
                    _ => Turn::Otherwise,
                }
            }
        };
        Self((0..dimension).map(turn).collect())
    }

    pub(super) fn of(&self, at: usize) -> Option<(i64, usize)> {
        match self.0[at] {
            Turn::Along(sign, other) => Some((sign, other)),
            _ => None,
        }
    }

    pub(super) fn rests(&self, at: usize) -> bool {
        matches!(self.0[at], Turn::Rests)
    }
}
