//! Lifts by quadratic maps of coordinates with a constant tensor.

use leafwise_core::lift::{End, Lift, LiftShape, Slowing};
use leafwise_core::{BuildError, StepError};
use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Graph, Polynomial, Rational, Ring, Term};

use crate::across::Across;
use crate::algebra::Algebra;
use crate::casimirs::{Held, Square, quadratic_casimirs};
use crate::constants::LinearTensor;
use crate::forms::Forms;
use crate::least::Rows;
use crate::relabel::Relabelling;
use crate::slowing::{Motion, taken};

/// J: z ↦ x with x_k = ½ Σ_a σ_a z_aᵀS_k z_a, {z_a, z_a} = σ_a Ω.
///
/// Steps of a Gauss method for H∘J take fibres of J to fibres where these are orbits of affine symmetries of Ω that J
/// does not see. There they are Poisson maps of x, to round-off.
#[derive(Clone, Debug)]
pub struct QuadraticLift {
    algebra: Algebra,
    /// The forms of x, and which y with which sign each is.
    forms: Forms,
    picks: Vec<(usize, f64)>,
    /// λ, and Ω in units of it.
    ring: Ring,
    unit: Polynomial,
    omega: Vec<Rational>,
    /// The way to the fibre of an x nearby, where that takes no matrix.
    across: Option<Across>,
    casimirs: Vec<Square>,
    held: Held,
}

/// A base point is taken over from the step before where J of it is within this part of the sizes of its summands.
const NEAR: f64 = 1e-8;

/// The most variables and coordinates that points are moved in.
pub const WIDEST: [usize; 2] = [36, 72];

/// Those of rotations and of the like.
const SMALL: [usize; 2] = [6, 8];

/// Those in between.
const MIDDLE: [usize; 2] = [15, 32];

impl QuadraticLift {
    /// The lift of a tensor whose variables are an algebra's in this order.
    pub fn new(algebra: &Algebra, tensor: &LinearTensor, order: &Relabelling) -> Self {
        let forms = algebra.forms.picked(&order.picks);
        let omega = algebra.omega.iter().map(|entry| entry * &order.unit);
        let casimirs = quadratic_casimirs(&tensor.constants);
        Self {
            picks: order.picks.iter().map(|(k, s)| (*k, s.to_f64())).collect(),
            ring: tensor.ring.clone(),
            unit: tensor.unit.clone(),
            omega: omega.collect(),
            across: (algebra.copies == 1 && !algebra.is_signed)
                .then(|| Across::of(&forms, algebra.groups))
                .flatten(),
            held: Held::of(&casimirs),
            casimirs,
            forms,
            algebra: algebra.clone(),
        }
    }

    fn width(&self) -> usize {
        self.forms.coordinates() * self.algebra.copies
    }

    /// z of a base point, and σ: none where all are 1.
    fn split<'a, T>(&self, base: &'a [T]) -> (&'a [T], &'a [T]) {
        base.split_at(self.width())
    }

    /// The copies of z with their signs.
    fn copies<'a>(&self, base: &'a [f64]) -> impl Iterator<Item = (f64, &'a [f64])> {
        let (z, signs) = self.split(base);
        let signs = signs.iter().copied().chain(std::iter::repeat(1.0));
        signs.zip(z.chunks_exact(self.forms.coordinates()))
    }

    /// Moves the z of a base point by a δ with DJ δ = x + low − J(z), the shortest where blocks of DJ are not
    /// orthogonal. Returns whether J(z) was near; z is not moved otherwise.
    fn move_across<const D: usize, const N: usize>(
        &self,
        (x, low): (&[f64], &[f64]),
        base: &mut [f64],
    ) -> bool {
        let d = x.len();
        let (mut image, mut sizes, mut rest) = ([0.0; D], [0.0; D], [0.0; D]);
        for (sign, z) in self.copies(base) {
            self.forms
                .add_image(sign, z, &mut image[..d], &mut sizes[..d]);
        }
        for i in 0..d {
            rest[i] = (x[i] - image[i]) + low[i];
            if rest[i].is_nan() || rest[i].abs() > NEAR * sizes[i] {
                return false;
            }
        }
        let width = self.width();
        if let Some(across) = &self.across {
            across.add::<N>(&self.forms, &rest, &mut base[..width]);
            return true;
        }
        let mut rows = Rows::<D, N>::new(d, width);
        self.write_slopes(base, &mut rows.rows[..d]);
        rows.factor();
        rows.solve(&mut rest);
        rows.add_combination(&rest[..d], &mut base[..width]);
        true
    }

    /// DJ: σ_a S_k z_a.
    fn write_slopes<const N: usize>(&self, base: &[f64], rows: &mut [[f64; N]]) {
        let n = self.forms.coordinates();
        for (a, (sign, z)) in self.copies(base).enumerate() {
            for (k, row) in rows.iter_mut().enumerate() {
                self.forms.add_slopes(k, sign, z, &mut row[a * n..][..n]);
            }
        }
    }

    fn write_slopes_of_base<const D: usize, const N: usize>(
        &self,
        base: &[f64],
        slopes: &mut [f64],
    ) {
        let d = self.forms.count();
        let mut rows = Rows::<D, N>::new(d, self.width());
        self.write_slopes(base, &mut rows.rows[..d]);
        let none = if rows.factor() > 0 { f64::NAN } else { 0.0 };
        slopes.fill(0.0);
        for k in 0..d {
            let mut unit = [0.0; D];
            unit[k] = 1.0;
            rows.solve(&mut unit);
            for a in 0..self.width() {
                let entry: f64 = (0..d).map(|i| rows.rows[i][a] * unit[i]).sum();
                slopes[a * d + k] = entry + none;
            }
        }
    }

    /// Room enough for points to be moved in.
    fn bounds(&self) -> [usize; 2] {
        let sizes = [SMALL, MIDDLE];
        let fits = |[d, n]: &[usize; 2]| self.forms.count() <= *d && self.width() <= *n;
        sizes.into_iter().find(fits).unwrap_or(WIDEST)
    }
}

impl Lift for QuadraticLift {
    fn shape(&self) -> LiftShape {
        let signs = match self.algebra.is_signed {
            true => self.algebra.copies,
            false => 0,
        };
        LiftShape {
            coordinates: self.width(),
            base: self.width() + signs,
            follows: true,
        }
    }

    /// The z that the step before has come to, moved to the fibre of x across the fibres. A section where there is none.
    fn place(
        &self,
        x: &[f64],
        low: &[f64],
        before: Option<End<'_>>,
        base: &mut [f64],
    ) -> Result<(), StepError> {
        let width = self.width();
        if let Some(End { z, base: from }) = before {
            base.copy_from_slice(from);
            for (base, z) in base.iter_mut().zip(z) {
                *base += z;
            }
            if let Some(settle) = self.algebra.settle {
                settle(&mut base[..width]);
            }
            let is_near = match self.bounds() {
                SMALL => self.move_across::<{ SMALL[0] }, { SMALL[1] }>((x, low), base),
                MIDDLE => self.move_across::<{ MIDDLE[0] }, { MIDDLE[1] }>((x, low), base),
                _ => self.move_across::<{ WIDEST[0] }, { WIDEST[1] }>((x, low), base),
            };
            if is_near {
                return Ok(());
            }
        }
        let mut y = [0.0; WIDEST[0]];
        for ((place, sign), x) in self.picks.iter().zip(x) {
            y[*place] = sign * x;
        }
        let (z, signs) = base.split_at_mut(width);
        (self.algebra.section)(&y[..x.len()], z, signs)
    }

    /// A change of z by its size is one of x by its size, copies together and groups of coordinates apart.
    fn sizes(&self, base: &[f64], sizes: &mut [f64]) {
        let n = self.forms.coordinates();
        let (z, _) = self.split(base);
        let mut from = 0;
        for end in self.algebra.groups.iter().copied().chain([n]) {
            let mut size = 0.0;
            for copy in z.chunks_exact(n) {
                for z in &copy[from..end] {
                    size = if z.abs() > size { z.abs() } else { size };
                }
            }
            for copy in sizes.chunks_exact_mut(n) {
                copy[from..end].fill(size);
            }
            from = end;
        }
    }

    fn slowing(
        &self,
        slowing: &mut Slowing<'_>,
        places: &[usize],
    ) -> Result<Polynomial, BuildError> {
        let over = |x: &[f64]| {
            let mut base = vec![0.0; self.shape().base];
            self.place(x, &vec![0.0; x.len()], None, &mut base).ok()?;
            let mut sizes = vec![0.0; self.width()];
            self.sizes(&base, &mut sizes);
            base.truncate(self.width());
            sizes
                .iter()
                .all(|size| *size > 0.0)
                .then_some((base, sizes))
        };
        let motion = Motion {
            over: &over,
            forms: &self.forms,
            omega: &self.omega,
            casimirs: &self.casimirs,
            is_round: self.across.as_ref().is_some_and(Across::is_round),
        };
        Ok(taken(&motion, slowing, places))
    }

    fn image(&self, graph: &mut Graph, z: &[Term], base: &[Term]) -> Result<Vec<Term>, BuildError> {
        let n = self.forms.coordinates();
        let (from, signs) = self.split(base);
        let pairs = from.iter().zip(z);
        let z: Vec<Term> = pairs.map(|(base, z)| graph.add(base, z)).collect();
        let copies = z.chunks_exact(n).map(|z| self.forms.image(graph, z));
        let copies = copies.collect();
        Ok(signed_sum(graph, copies, signs))
    }

    /// ż_a = −λ Ω Σ_k w_k S_k z_a: signs cancel.
    fn field(
        &self,
        graph: &mut Graph,
        z: &[Term],
        base: &[Term],
        covector: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let n = self.forms.coordinates();
        let one = graph.one();
        let unit = lift(graph, &self.ring, &[vec![(one, self.unit.clone())]], &[])?.remove(0);
        let w: Vec<Term> = covector.iter().map(|w| graph.multiply(&unit, w)).collect();
        let (from, _) = self.split(base);
        let pairs = from.iter().zip(z);
        let z: Vec<Term> = pairs.map(|(base, z)| graph.add(base, z)).collect();
        let mut field = Vec::with_capacity(z.len());
        for z in z.chunks_exact(n) {
            let slopes = self.forms.pull_back(graph, z, &w);
            for row in self.omega.chunks_exact(n) {
                let mut terms = Vec::new();
                for (entry, slope) in row.iter().zip(&slopes).filter(|(e, _)| !e.is_zero()) {
                    let scaled = slope.iter().map(|(c, term)| (-(c * entry), term.clone()));
                    terms.extend(scaled);
                }
                field.push(graph.combine(&terms));
            }
        }
        Ok(field)
    }

    fn increment(
        &self,
        graph: &mut Graph,
        z: &[Term],
        base: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        let n = self.forms.coordinates();
        let (from, signs) = self.split(base);
        let pairs = from.chunks_exact(n).zip(z.chunks_exact(n));
        let copies = pairs.map(|(from, z)| self.forms.change(graph, from, z));
        let copies = copies.collect();
        Ok(signed_sum(graph, copies, signs))
    }

    /// DJᵀ(DJ DJᵀ)⁻¹.
    fn slopes_of_base(&self, base: &[f64], slopes: &mut [f64]) {
        match self.bounds() {
            SMALL => self.write_slopes_of_base::<{ SMALL[0] }, { SMALL[1] }>(base, slopes),
            MIDDLE => self.write_slopes_of_base::<{ MIDDLE[0] }, { MIDDLE[1] }>(base, slopes),
            _ => self.write_slopes_of_base::<{ WIDEST[0] }, { WIDEST[1] }>(base, slopes),
        }
    }

    /// Quadratic Casimirs are constant along the motion and along a Gauss method's steps but for rounding.
    fn hold(&self, x: &[f64], low: &[f64], increment: &mut [f64]) -> f64 {
        self.held.hold(x, low, increment)
    }
}

/// Σ_a σ_a x_a; Σ_a x_a without signs.
fn signed_sum(graph: &mut Graph, copies: Vec<Vec<Term>>, signs: &[Term]) -> Vec<Term> {
    let d = copies[0].len();
    let mut sums = vec![Vec::new(); d];
    for (a, copy) in copies.into_iter().enumerate() {
        for (sum, term) in sums.iter_mut().zip(copy) {
            let term = match signs.get(a) {
                Some(sign) => graph.multiply(sign, &term),
                None => term,
            };
            sum.push((Rational::one(), term));
        }
    }
    sums.iter().map(|sum| graph.combine(sum)).collect()
}
