//! Spins: summands of a tensor that are so(3)*.

use std::collections::BTreeSet;

use leafwise_expression::{AlgebraError, Arithmetic, Expression, Graph, Polynomial, Ring, Term};

use super::SystemFormulas;

impl SystemFormulas {
    /// κ of {s1,s2} = −κ s3 and cyclic, a constant of the ring, for the coordinates of a spin; `None` for other brackets.
    ///
    /// # Errors
    /// [`AlgebraError`] where an entry has no value in the ring.
    pub fn spin_factor(
        &self,
        ring: &mut Ring,
        places: [usize; 3],
    ) -> Result<Option<Polynomial>, AlgebraError> {
        let factor = self.factor(ring, places)?;
        Ok(factor.filter(|factor| factor.as_constant().is_some()))
    }

    /// κ, whatever it depends on.
    fn factor(
        &self,
        ring: &mut Ring,
        places: [usize; 3],
    ) -> Result<Option<Polynomial>, AlgebraError> {
        let x = places.map(|at| ring.variable(at));
        let mut known: Option<Polynomial> = None;
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (0, 2, 1)] {
            let Some(entry) = self.tensor().get(&(places[i], places[j])) else {
                return Ok(None);
            };
            let entry =
                entry.evaluate_in(ring, &mut |ring: &mut Ring, at| Ok(ring.variable(at)))?;
            // {x1,x3} stands above the diagonal with the other sign.
            let entry = match k {
                1 => entry,
                _ => ring.negate(&entry),
            };
            match &known {
                None => {
                    let ratio = ring.divide(&entry, &x[k])?;
                    if ratio.is_zero() {
                        return Ok(None);
                    }
                    known = Some(ratio);
                }
                Some(factor) => {
                    let expected = ring.multiply(factor, &x[k]);
                    if !ring.subtract(&entry, &expected).is_zero() {
                        return Ok(None);
                    }
                }
            }
        }
        Ok(known)
    }

    /// The coordinates of each spin: three that have brackets with each other alone, {s1,s2} = −κ s3 and cyclic. κ may depend on
    /// coordinates that rest.
    pub fn spins(&self) -> Vec<[usize; 3]> {
        let mut ring = Ring::new(self.dimension());
        let mut beside = vec![BTreeSet::new(); self.dimension()];
        for &(i, j) in self.tensor().keys() {
            beside[i].extend([i, j]);
            beside[j].extend([i, j]);
        }
        let rests = |at: &usize| beside[*at].is_empty();
        let is_spin = |places: &[usize; 3]| {
            let [a, b, c] = *places;
            let own = BTreeSet::from(*places);
            let entries = [(a, b, c), (b, c, a), (a, c, b)];
            // Entries that name their third coordinate alone have a factor of none of the three.
            let is_of_third = entries.iter().all(|(i, j, k)| {
                let entry = self.tensor().get(&(*i, *j));
                entry.is_some_and(|entry| entry.variables().iter().all(|at| at == k || rests(at)))
            });
            places.iter().all(|at| beside[*at] == own) && is_of_third
        };
        let all = (0..self.dimension()).filter(|at| beside[*at].first() == Some(at));
        let triples = all.filter_map(|at| {
            let places: Vec<usize> = beside[at].iter().copied().collect();
            <[usize; 3]>::try_from(places).ok()
        });
        triples
            .filter(is_spin)
            .filter(|places| matches!(self.factor(&mut ring, *places), Ok(Some(_))))
            .collect()
    }
}

/// Σ (L_a f)² and Σ L_a L_a f over these spins and their components, L_a f = s_c ∂f/∂s_b − s_b ∂f/∂s_c of (a, b, c) in cyclic
/// order.
///
/// Turns keep every measure that depends on lengths alone, so that in equilibrium ⟨Σ L_a L_a H⟩ = ⟨Σ (L_a H)²⟩/kT. Where H is
/// linear in each spin, L_a L_a H summed over a is −2 s·∂H/∂s (W. B. Nurdin, K.-D. Schotte, Physical Review E 61, 3579, 2000).
///
/// # Errors
/// [`AlgebraError`] where f or its derivatives have no code.
pub fn turns(f: &Expression, spins: &[[usize; 3]]) -> Result<[Expression; 2], AlgebraError> {
    let mut graph = Graph::compilable();
    let value = f.evaluate_in(&mut graph, &mut |graph: &mut Graph, at| Ok(graph.input(at)))?;
    let [mut squares, mut curvature] = [graph.constant(&0.into()), graph.constant(&0.into())];
    for spin in spins {
        for a in 0..3 {
            let [b, c] = [spin[(a + 1) % 3], spin[(a + 2) % 3]];
            let once = turned(&mut graph, &value, [b, c])?;
            let twice = turned(&mut graph, &once, [b, c])?;
            let square = graph.multiply(&once, &once);
            squares = graph.add(&squares, &square);
            curvature = graph.add(&curvature, &twice);
        }
    }
    let formulas = graph.shared_formulas(&[squares, curvature]);
    let formulas = formulas.and_then(|formulas| <[Expression; 2]>::try_from(formulas).ok());
    formulas.ok_or(AlgebraError::NoSeries)
}

/// L f = c ∂f/∂b − b ∂f/∂c.
fn turned(graph: &mut Graph, f: &Term, [b, c]: [usize; 2]) -> Result<Term, AlgebraError> {
    let by = [graph.derivative(f, b)?, graph.derivative(f, c)?];
    let along = graph.input(c);
    let ahead = graph.multiply(&along, &by[0]);
    let back = graph.input(b);
    let back = graph.multiply(&back, &by[1]);
    Ok(graph.subtract(&ahead, &back))
}

#[cfg(test)]
mod tests {
    use leafwise_expression::syntax::{Formula, Scope};

    use super::turns;

    /// Of H = −B·s − D s_z²: |s × ∂H|² with ∂H = −B − 2D s_z e_z, and 2 B·s − D(2 s² − 6 s_z²), by hand.
    #[test]
    fn turns_of_a_field_and_an_anisotropy_are_those_by_hand() {
        let scope = Scope::new().with_variables(&["x", "y", "z"]);
        let h = Formula::parse("-(0.3*x - 0.7*y + 0.2*z) - 0.9*z^2").expect("a formula");
        let h = h.resolve(&scope, None).expect("names").expect("no site");
        let [squares, curvature] = turns(&h, &[[0, 1, 2]]).expect("derivatives");
        let s = [0.4, -0.5, 1.1];
        let [x, y, z] = s;
        let slope = [-0.3, 0.7, -0.2 - 1.8 * z];
        let cross = [
            y * slope[2] - z * slope[1],
            z * slope[0] - x * slope[2],
            x * slope[1] - y * slope[0],
        ];
        let expected = cross.iter().map(|c| c * c).sum::<f64>();
        assert!((squares.evaluate(&s, &[]) - expected).abs() < 1e-14);
        let along = 0.3 * x - 0.7 * y + 0.2 * z;
        let expected = 2.0 * along - 0.9 * (2.0 * (x * x + y * y) - 4.0 * z * z);
        assert!((curvature.evaluate(&s, &[]) - expected).abs() < 1e-14);
    }
}
