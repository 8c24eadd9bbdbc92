//! Lists of quadratic forms x_k = ½ zᵀS_k z, exact, as code and as numbers.

use std::ops::Range;

use leafwise_expression::{Arithmetic, Graph, Rational, Term};

/// c z_a z_b.
#[derive(Clone, Debug, PartialEq)]
pub struct Product {
    /// c.
    pub factor: Rational,
    /// a ≤ b.
    pub places: [usize; 2],
}

/// Forms x_k = Σ c z_a z_b.
#[derive(Clone, Debug)]
pub struct Forms {
    coordinates: usize,
    rows: Vec<Vec<Product>>,
    /// The products of all rows as numbers, and where each row's are.
    products: Vec<(f64, usize, usize)>,
    ranges: Vec<Range<usize>>,
}

impl Forms {
    /// These forms on so many coordinates.
    pub fn new(coordinates: usize, rows: Vec<Vec<Product>>) -> Self {
        let (mut products, mut ranges) = (Vec::new(), Vec::new());
        for row in &rows {
            let from = products.len();
            let numbers = row.iter();
            products.extend(numbers.map(|p| (p.factor.to_f64(), p.places[0], p.places[1])));
            ranges.push(from..products.len());
        }
        Self {
            coordinates,
            rows,
            products,
            ranges,
        }
    }

    /// Forms with products c z_a z_b, c in units of 1/`denominator`.
    pub fn of_table(coordinates: usize, denominator: i64, rows: &[&[(i64, usize, usize)]]) -> Self {
        let row = |products: &&[(i64, usize, usize)]| {
            let products = products.iter();
            let product = |&(factor, a, b): &(i64, usize, usize)| Product {
                factor: Rational::new(factor, denominator),
                places: [a.min(b), a.max(b)],
            };
            products.map(product).collect()
        };
        Self::new(coordinates, rows.iter().map(row).collect())
    }

    /// n, the number of coordinates z.
    pub fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// d, the number of forms.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// The products of each form.
    pub fn rows(&self) -> &[Vec<Product>] {
        &self.rows
    }

    /// The forms c·x_k for these (k, c), one after the other.
    pub fn picked(&self, picks: &[(usize, Rational)]) -> Self {
        let rows = picks.iter().map(|(k, factor)| {
            let products = self.rows[*k].iter();
            let scaled = products.map(|product| Product {
                factor: &product.factor * factor,
                places: product.places,
            });
            scaled.collect()
        });
        Self::new(self.coordinates, rows.collect())
    }

    /// S_k, row-major.
    pub fn matrix(&self, k: usize) -> Vec<Rational> {
        let n = self.coordinates;
        let mut matrix = vec![Rational::from_integer(0); n * n];
        for Product {
            factor,
            places: [a, b],
        } in &self.rows[k]
        {
            matrix[a * n + b] += factor;
            matrix[b * n + a] += factor;
        }
        matrix
    }

    /// x at z as code.
    pub fn image(&self, graph: &mut Graph, z: &[Term]) -> Vec<Term> {
        let rows = self.rows.iter().map(|row| {
            let terms = row.iter().map(
                |Product {
                     factor,
                     places: [a, b],
                 }| { (factor.clone(), graph.multiply(&z[*a], &z[*b])) },
            );
            let terms: Vec<_> = terms.collect();
            graph.combine(&terms)
        });
        rows.collect()
    }

    /// x at z + δ less x at z as code: products of δ with z + δ/2, in which x at z does not stand.
    pub fn change(&self, graph: &mut Graph, z: &[Term], delta: &[Term]) -> Vec<Term> {
        let half = Rational::new(1, 2);
        let pairs = z.iter().zip(delta);
        let middle: Vec<Term> = pairs
            .map(|(z, delta)| {
                graph.combine(&[(Rational::one(), z.clone()), (half.clone(), delta.clone())])
            })
            .collect();
        let rows = self.rows.iter().map(|row| {
            let mut terms = Vec::new();
            for Product {
                factor,
                places: [a, b],
            } in row
            {
                terms.push((factor.clone(), graph.multiply(&middle[*a], &delta[*b])));
                terms.push((factor.clone(), graph.multiply(&delta[*a], &middle[*b])));
            }
            graph.combine(&terms)
        });
        rows.collect()
    }

    /// The summands of Σ_k w_k S_k z as code, coordinate by coordinate.
    pub fn pull_back(
        &self,
        graph: &mut Graph,
        z: &[Term],
        w: &[Term],
    ) -> Vec<Vec<(Rational, Term)>> {
        let mut sums = vec![Vec::new(); z.len()];
        for (row, w) in self.rows.iter().zip(w) {
            for Product {
                factor,
                places: [a, b],
            } in row
            {
                sums[*a].push((factor.clone(), graph.multiply(&z[*b], w)));
                sums[*b].push((factor.clone(), graph.multiply(&z[*a], w)));
            }
        }
        sums
    }

    /// Adds `sign` times x at z to `image`, and the sizes of its summands to `sizes`.
    pub fn add_image(&self, sign: f64, z: &[f64], image: &mut [f64], sizes: &mut [f64]) {
        for ((range, image), size) in self.ranges.iter().zip(image).zip(sizes) {
            let (mut sum, mut most) = (0.0, 0.0);
            for (factor, a, b) in &self.products[range.clone()] {
                let product = factor * (z[*a] * z[*b]);
                sum += product;
                most += product.abs();
            }
            *image += sign * sum;
            *size += most;
        }
    }

    /// The products c z_a z_b of a form.
    #[inline]
    pub fn products(&self, k: usize) -> &[(f64, usize, usize)] {
        &self.products[self.ranges[k].clone()]
    }

    /// Adds `sign` S_k z to a row of derivatives.
    pub fn add_slopes(&self, k: usize, sign: f64, z: &[f64], row: &mut [f64]) {
        for (factor, a, b) in self.products(k) {
            row[*a] += sign * factor * z[*b];
            row[*b] += sign * factor * z[*a];
        }
    }
}

/// A B of square matrices, row-major.
pub fn product(n: usize, a: &[Rational], b: &[Rational]) -> Vec<Rational> {
    let mut out = vec![Rational::from_integer(0); n * n];
    for i in 0..n {
        for k in 0..n {
            if a[i * n + k].is_zero() {
                continue;
            }
            for j in 0..n {
                if !b[k * n + j].is_zero() {
                    out[i * n + j] += &(&a[i * n + k] * &b[k * n + j]);
                }
            }
        }
    }
    out
}

/// A + c B.
pub fn sum(a: &[Rational], b: &[Rational], c: &Rational) -> Vec<Rational> {
    a.iter().zip(b).map(|(a, b)| a + &(c * b)).collect()
}
