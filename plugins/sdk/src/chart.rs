//! Realizations in a cotangent chart.

use crate::fail::Fail;
use crate::instance::Part;
use crate::realization::Realization;

/// Realization data on S = T*M in a chart: z = (x, p), {x_i, p_j} = δ_ij, σ(x) = (x, 0),
/// β̂(x, p) = α̂(x, −p).
///
/// One formula is enough: α̂ as its parts even and odd in p, so that the step's increment
/// α̂ − β̂ = 2·odd is formed without cancellation. Declare
/// [`Info::cotangent_chart`](crate::Info::cotangent_chart) and
/// [`Info::reversible`](crate::Info::reversible).
pub trait ChartRealization: Part {
    /// Whether [`jacobian`](Self::jacobian) is offered: Newton's method and exact tangents need it.
    const JACOBIAN: bool = false;

    /// d, as given to `create`.
    fn dimension(&self) -> usize;
    /// The parts of α̂_ε(x, p) − x that are even and odd in p, d numbers each.
    ///
    /// # Errors
    /// [`Fail::Outside`] outside the domain.
    fn parts(
        &mut self,
        epsilon: f64,
        x: &[f64],
        p: &[f64],
        even: &mut [f64],
        odd: &mut [f64],
    ) -> Result<(), Fail>;
    /// Their derivatives by (x, p), each d × 2 d, row-major.
    ///
    /// # Errors
    /// [`Fail::Outside`] outside the domain.
    fn jacobian(
        &mut self,
        epsilon: f64,
        x: &[f64],
        p: &[f64],
        even: &mut [f64],
        odd: &mut [f64],
    ) -> Result<(), Fail> {
        let _ = (epsilon, x, p, even, odd);
        Err(Fail::unsupported("the realization offers no `jacobian`"))
    }
}

impl<T: ChartRealization> Realization for T {
    const ENDS: bool = true;
    const ENDS_JACOBIAN: bool = T::JACOBIAN;

    fn space_dimension(&self) -> usize {
        2 * self.dimension()
    }

    fn alpha(&mut self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        end(self, epsilon, z, out, 1.0)
    }

    fn beta(&mut self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        end(self, epsilon, z, out, -1.0)
    }

    fn sigma(&mut self, x: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let (base, p) = out.split_at_mut(x.len());
        base.copy_from_slice(x);
        p.fill(0.0);
        Ok(())
    }

    #[inline]
    fn ends(&mut self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let (x, p) = z.split_at(z.len() / 2);
        let (base, rest) = out.split_at_mut(x.len());
        let (offset, increment) = rest.split_at_mut(x.len());
        self.parts(epsilon, x, p, offset, increment)?;
        base.copy_from_slice(x);
        for (offset, odd) in offset.iter_mut().zip(increment) {
            *offset -= *odd;
            *odd *= 2.0;
        }
        Ok(())
    }

    #[inline]
    fn ends_jacobian(&mut self, epsilon: f64, z: &[f64], out: &mut [f64]) -> Result<(), Fail> {
        let (x, p) = z.split_at(z.len() / 2);
        let (target, increment) = out.split_at_mut(out.len() / 2);
        self.jacobian(epsilon, x, p, target, increment)?;
        for (target, odd) in target.iter_mut().zip(increment) {
            *target -= *odd;
            *odd *= 2.0;
        }
        for i in 0..x.len() {
            target[i * z.len() + i] += 1.0;
        }
        Ok(())
    }
}

/// x + even ± odd.
fn end<T: ChartRealization>(
    part: &mut T,
    epsilon: f64,
    z: &[f64],
    out: &mut [f64],
    sign: f64,
) -> Result<(), Fail> {
    const SMALL: usize = 16;
    let (x, p) = z.split_at(z.len() / 2);
    let mut few = [0.0; SMALL];
    let mut many;
    let odd = if x.len() <= SMALL {
        &mut few[..x.len()]
    } else {
        many = vec![0.0; x.len()];
        &mut many[..]
    };
    part.parts(epsilon, x, p, out, odd)?;
    for i in 0..x.len() {
        out[i] = x[i] + (out[i] + sign * odd[i]);
    }
    Ok(())
}
