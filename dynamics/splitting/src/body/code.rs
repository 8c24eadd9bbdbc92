//! Jacobi's functions, vectors and rotations as straight-line code.

use leafwise_expression::{Arithmetic, Function, Rational, Term};

use super::vectors::Vector;
use crate::sums::{Code, WITHIN};

/// How often the time doubles.
const DOUBLINGS: u32 = 4;

/// Terms of the series over the shortest time τ: √p τ ≤ 3/32, and what they leave out is (6/(32 π))¹⁴ = 7e-18 of them.
const TERMS: usize = 6;

/// Largest √|p| t over the whole time. S, C and D have their first pole on the real axis, if any, where half of √|p| t
/// is π/2 or more, whatever signs p and q have.
const FARTHEST: (i64, i64) = (3, 1 << (DOUBLINGS + 1));

/// How often the time doubles for the rotation about m: of 64 radians at most, from a quarter.
const DOUBLINGS_ABOUT_M: u32 = 7;

impl Code<'_> {
    pub(super) fn components(&mut self, vector: &Vector, x: &[Term]) -> [Term; 3] {
        vector.map(|(at, sign)| self.sum(&[(sign, &[&x[at]])]))
    }

    /// Writes a vector's components to its coordinates.
    pub(super) fn scatter(&mut self, vector: &Vector, components: &[Term], to: &mut [Term]) {
        for ((at, sign), component) in vector.iter().zip(components) {
            to[*at] = self.sum(&[(*sign, &[component])]);
        }
    }

    pub(crate) fn cross(&mut self, a: &[Term], b: &[Term]) -> Vec<Term> {
        let component = |l: usize| {
            let (next, other) = ((l + 1) % 3, (l + 2) % 3);
            self.sum(&[(1, &[&a[next], &b[other]]), (-1, &[&a[other], &b[next]])])
        };
        (0..3).map(component).collect()
    }

    pub(super) fn quaternion_product(&mut self, a: &[Term], b: &[Term]) -> Vec<Term> {
        let mut product = vec![self.sum(&[
            (1, &[&a[0], &b[0]]),
            (-1, &[&a[1], &b[1]]),
            (-1, &[&a[2], &b[2]]),
            (-1, &[&a[3], &b[3]]),
        ])];
        for l in 1..4 {
            let (next, other) = (l % 3 + 1, (l + 1) % 3 + 1);
            product.push(self.sum(&[
                (1, &[&a[0], &b[l]]),
                (1, &[&a[l], &b[0]]),
                (1, &[&a[next], &b[other]]),
                (-1, &[&a[other], &b[next]]),
            ]));
        }
        product
    }

    /// 2(q₀ q×n + q×(q×n))/(q₀² + |q|²): the change of n by the rotation of the quaternion (q₀, q), of any length.
    pub(crate) fn turned(&mut self, turn: &[Term], n: &[Term; 3]) -> Vec<Term> {
        let (scalar, vector) = turn.split_first().expect("four components");
        let square = self.sum(&[
            (1, &[scalar, scalar]),
            (1, &[&vector[0], &vector[0]]),
            (1, &[&vector[1], &vector[1]]),
            (1, &[&vector[2], &vector[2]]),
        ]);
        let factor = self.reciprocal(&square);
        let factor = self.whole(&[(2, &[&factor])]);
        let once = self.cross(vector, n);
        let twice = self.cross(vector, &once);
        let both = once.iter().zip(&twice);
        both.map(|(once, twice)| {
            let sum = self.sum(&[(1, &[scalar, once]), (1, &[twice])]);
            self.product(&[&factor, &sum])
        })
        .collect()
    }

    /// The quaternion of the body's rotation from m on less that by κ₂ about m, from the a_l times t. Where m is alone, any rotation
    /// serves that turns it as the body does: the one with β₂ = 0 needs neither α nor the β_l.
    pub(super) fn turn(&mut self, angles: &[Term], m: &[Term; 3], is_alone: bool) -> Vec<Term> {
        let shortest = Rational::new(1, 1 << (DOUBLINGS + 1));
        let shorter = |code: &mut Self, angle: &Term| {
            let scaled = code.0.scale(&shortest, angle);
            code.0.whole(&scaled)
        };
        let [a1, a2, a3] = [0, 1, 2].map(|l| shorter(self, &angles[l]));
        let [one, half] = [self.0.one(), self.0.constant(&Rational::new(1, 2))];
        let squares = [0, 1, 2].map(|l| self.product(&[&m[l], &m[l]]));
        let [s1, s2, s3] = squares.each_ref();
        let big_p = self.whole(&[(1, &[&a3, s2]), (-1, &[&a2, s3])]);
        let big_q = self.whole(&[(1, &[&a1, s2]), (-1, &[&a2, s1])]);
        let big_r = self.whole(&[(1, &[&a3, s1]), (-1, &[&a1, s3])]);
        let (p, q) = (
            self.whole(&[(1, &[&a1, &big_p])]),
            self.whole(&[(1, &[&a3, &big_q])]),
        );
        let far = self.sum(&[(1, &[&p, &p]), (1, &[&q, &q])]);
        let inverse = Rational::new(FARTHEST.1, FARTHEST.0);
        let square = &inverse * &inverse;
        let far = self.0.scale(&(&square * &square), &far);
        let far = self.0.apply_analytic(WITHIN, 0, &far);
        let p = self.sum(&[(1, &[&p]), (1, &[&far])]);
        let (e, f) = (self.sum(&[(1, &[&p]), (1, &[&q])]), self.product(&[&p, &q]));
        let product = self.product(&[&big_p, &big_q]);
        // S, C, D over the shortest time.
        let s = self.sine(&e, &f);
        let mut s = self.0.whole(&s);
        let w = self.product(&[&s, &s]);
        let (x, y) = (self.product(&[&p, &w]), self.product(&[&q, &w]));
        let [mut c, mut d] = [&x, &y].map(|x| {
            let square = self.sum(&[(1, &[&one]), (-1, &[x])]);
            self.function(Function::Sqrt, &square)
        });
        let (mut gamma, b2) = self.attitude(
            &[a1.clone(), a3.clone()],
            squares.each_ref(),
            &big_r,
            [&e, &f, &q],
            &w,
        );
        let mut b2 = self.whole(&[(1, &[&s, &w, &b2])]);
        let mut alpha = self.sum(&[(1, &[&one]), (-1, &[&gamma])]);
        let above = self.sum(&[(1, &[&b2]), (1, &[&alpha, &a3, &s])]);
        let b1 = self.0.divide(&above, &d).expect("D is not 0");
        let mut b1 = self.0.whole(&b1);
        let above = self.sum(&[(1, &[&b2]), (-1, &[&alpha, &a1, &s])]);
        let b3 = self.0.divide(&above, &c).expect("C is not 0");
        let mut b3 = self.0.whole(&b3);
        for _ in 0..DOUBLINGS {
            let w = self.product(&[&s, &s]);
            let (x, y) = (self.product(&[&p, &w]), self.product(&[&q, &w]));
            let xy = self.product(&[&x, &y]);
            let below = self.sum(&[(1, &[&half]), (-1, &[&half, &xy])]);
            let r = self.reciprocal(&below);
            let r = self.0.whole(&r);
            let (sc, sd, cd) = (
                self.product(&[&s, &c]),
                self.product(&[&s, &d]),
                self.product(&[&c, &d]),
            );
            let square = self.product(&[&b2, &b2, &product, &w]);
            let next = self.sum(&[
                (1, &[&gamma]),
                (1, &[&gamma, &alpha]),
                (-1, &[&xy]),
                (-1, &[&square]),
            ]);
            gamma = self.product(&[&r, &next]);
            let first = self.sum(&[(1, &[&alpha, &b1, &c]), (-1, &[&b2, &b3, &big_p, &sd])]);
            let second = self.sum(&[(1, &[&alpha, &b2, &cd]), (1, &[&b3, &b1, &big_r, &s])]);
            let third = self.sum(&[(1, &[&alpha, &b3, &d]), (1, &[&b1, &b2, &big_q, &sc])]);
            [b1, b2, b3] = [first, second, third].map(|b| self.product(&[&r, &b]));
            s = self.product(&[&r, &s, &cd]);
            let fall = self.sum(&[(1, &[&x]), (-1, &[&xy])]);
            c = self.sum(&[(1, &[&one]), (-1, &[&r, &fall])]);
            let fall = self.sum(&[(1, &[&y]), (-1, &[&xy])]);
            d = self.sum(&[(1, &[&one]), (-1, &[&r, &fall])]);
            alpha = self.sum(&[(1, &[&one]), (-1, &[&gamma])]);
        }
        // About the state between, which is half of the time away; that state and α times 1 − a₁a₃S²m₂².
        let s_m1 = self.product(&[&s, &m[0]]);
        let (s_m2, s_m3) = (self.product(&[&s, &m[1]]), self.product(&[&s, &m[2]]));
        let between = [
            self.sum(&[(1, &[&m[0], &c]), (1, &[&a1, &d, &s_m2, &m[2]])]),
            self.sum(&[(1, &[&m[1], &c, &d]), (1, &[&a2, &s_m3, &m[0]])]),
            self.sum(&[(1, &[&m[2], &d]), (1, &[&a3, &c, &s_m1, &m[1]])]),
        ];
        if is_alone {
            alpha = self.product(&[&c, &d]);
            b1 = self.product(&[&a3, &s, &c]);
            b2 = self.0.zero();
            b3 = self.sum(&[(-1, &[&a1, &s, &d])]);
        }
        let below = self.sum(&[(1, &[&one]), (-1, &[&a1, &a3, &s_m2, &s_m2])]);
        let mut turn = vec![self.product(&[&alpha, &below])];
        let factors = [b1, b2, b3];
        turn.extend(
            factors
                .iter()
                .zip(&between)
                .map(|(b, m)| self.product(&[b, m])),
        );
        turn
    }

    /// S(1) = Σ cⱼ, where S″ = −eS + 2fS³. Terms follow from (2j)(2j + 1)cⱼ = −e cⱼ₋₁ + 2f Σ c_k c_l c_m,
    /// k + l + m = j − 2.
    fn sine(&mut self, e: &Term, f: &Term) -> Term {
        // The numbers in front of eⁱfˡ, cⱼ having those with i + 2l = j.
        let mut series: Vec<Vec<Rational>> = vec![vec![Rational::one()]];
        for j in 1..=TERMS {
            let mut next = vec![Rational::zero(); j / 2 + 1];
            for (l, number) in series[j - 1].iter().enumerate() {
                next[l] = -number.clone();
            }
            for k in 0..(j - 1) {
                for l in 0..(j - 1 - k) {
                    for (u, a) in series[k].iter().enumerate() {
                        for (v, b) in series[l].iter().enumerate() {
                            for (w, c) in series[j - 2 - k - l].iter().enumerate() {
                                let product = &(&(a * b) * c) * &Rational::from_integer(2);
                                next[u + v + w + 1] += &product;
                            }
                        }
                    }
                }
            }
            let share = Rational::new(1, (2 * j * (2 * j + 1)) as i64);
            series.push(next.iter().map(|number| number * &share).collect());
        }
        let of_f = (0..=TERMS / 2).map(|l| {
            let of_e = (2 * l..=TERMS).map(|j| self.0.constant(&series[j][l]));
            let of_e: Vec<Term> = of_e.collect();
            self.horner(&of_e, e)
        });
        let of_f: Vec<Term> = of_f.collect();
        self.horner(&of_f, f)
    }

    /// 1 − α and β₂/S³ as series in w = S², at κ₂ = 0.
    fn attitude(
        &mut self,
        [a1, a3]: &[Term; 2],
        squares: [&Term; 3],
        big_r: &Term,
        [e, f, q]: [&Term; 3],
        w: &Term,
    ) -> (Term, Term) {
        let [s1, s2, s3] = squares;
        let both = self.product(&[a1, a3]);
        let length = self.sum(&[(1, &[s1]), (1, &[s2]), (1, &[s3])]);
        let (by_length, by_r) = (
            self.whole(&[(1, &[&both, &length])]),
            self.whole(&[(1, &[&both, big_r])]),
        );
        let h = self.sum(&[(1, &[q]), (-1, &[a1, big_r])]);
        // α_k in front of wᵏ, b_k in front of S³wᵏ.
        let (mut alpha, mut b): (Vec<Term>, Vec<Term>) = (vec![self.0.one()], Vec::new());
        for k in 0..=TERMS {
            let (n, zero) = (k as i64, self.0.zero());
            let before = |list: &[Term], by: usize| {
                k.checked_sub(by)
                    .map_or_else(|| zero.clone(), |at| list[at].clone())
            };
            if k > 0 {
                let (last, last_but_one, turned) =
                    (before(&alpha, 1), before(&alpha, 2), before(&b, 2));
                let factor = self.sum(&[(2 * (n - 1), &[e]), (-1, &[&h])]);
                let next = self.sum(&[
                    (1, &[&factor, &last]),
                    (5 - 2 * n, &[f, &last_but_one]),
                    (-1, &[big_r, &turned]),
                ]);
                let next = self.0.scale(&Rational::new(1, 2 * n), &next);
                alpha.push(self.0.whole(&next));
            }
            // β₂ is of the third order.
            if k + 2 <= TERMS {
                let (last, last_but_one) = (before(&b, 1), before(&b, 2));
                let factor = self.sum(&[(2 * n + 1, &[e]), (-1, &[&by_length])]);
                let next = self.sum(&[
                    (1, &[&factor, &last]),
                    (2 - 2 * n, &[f, &last_but_one]),
                    (-1, &[&by_r, &alpha[k]]),
                ]);
                let next = self.0.scale(&Rational::new(1, 2 * n + 3), &next);
                b.push(self.0.whole(&next));
            }
        }
        let rise = self.horner(&alpha[1..], w);
        let gamma = self.whole(&[(-1, &[&rise, w])]);
        (gamma, self.horner(&b, w))
    }

    /// The quaternion (cos ½κ₂|m|t, sin ½κ₂|m|t m/|m|), from κ₂t.
    pub(super) fn turn_about(&mut self, angle: &Term, m: &[Term; 3]) -> Vec<Term> {
        let shortest = Rational::new(1, 1 << (DOUBLINGS_ABOUT_M + 1));
        let angle = self.0.scale(&shortest, angle);
        let square = self.sum(&[
            (1, &[&m[0], &m[0]]),
            (1, &[&m[1], &m[1]]),
            (1, &[&m[2], &m[2]]),
        ]);
        let z = self.product(&[&angle, &angle, &square]);
        let far = self.0.scale(&Rational::from_integer(16), &z);
        let far = self.0.apply_analytic(WITHIN, 0, &far);
        let z = self.sum(&[(1, &[&z]), (1, &[&far])]);
        // sin θ/θ and (1 − cos θ)/θ², θ² = z ≤ 1/16.
        let mut number = Rational::one();
        let (mut odd, mut even) = (Vec::new(), Vec::new());
        for k in 0..6 {
            odd.push(self.0.constant(&number));
            number = &number * &Rational::new(1, 2 * k + 2);
            even.push(self.0.constant(&number));
            number = &number * &Rational::new(-1, 2 * k + 3);
        }
        let odd = self.horner(&odd, &z);
        let even = self.horner(&even, &z);
        let mut sine = self.product(&[&angle, &odd]);
        let mut versine = self.product(&[&z, &even]);
        let (one, two) = (self.0.one(), self.0.constant(&Rational::from_integer(2)));
        for _ in 0..DOUBLINGS_ABOUT_M {
            let fall = self.sum(&[(1, &[&one]), (-1, &[&versine])]);
            sine = self.sum(&[(2, &[&sine, &fall])]);
            sine = self.0.whole(&sine);
            let rest = self.sum(&[(1, &[&two]), (-1, &[&versine])]);
            versine = self.sum(&[(2, &[&versine, &rest])]);
            versine = self.0.whole(&versine);
        }
        let mut turn = vec![self.sum(&[(1, &[&one]), (-1, &[&versine])])];
        turn.extend(m.iter().map(|m| self.product(&[&sine, m])));
        turn
    }
}
