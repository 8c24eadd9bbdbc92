//! The shadow Hamiltonian of a product of flows, by the formula of Baker, Campbell, Hausdorff and Dynkin.
//!
//! With L_F = {F, ·} the flow of F over t takes a function f to exp(t L_F) f, and [L_F, L_G] = L_{{F, G}}. So words of
//! the logarithm of exp(…)·exp(…)·…, the first flow leftmost, are nested Poisson brackets. Let P be the part of the
//! logarithm in which a letter a occurs r times in each word. Then
//!
//! P = (1/r) Σ c_w {…{{a, w_2}, w_3}, …, w_k} over the words w = a w_2 … w_k.
//!
//! This is Dynkin's formula for the grading that counts a alone (C. Reutenauer, *Free Lie Algebras*, section 1.6).

use std::collections::BTreeMap;

use leafwise_expression::{Arithmetic, DifferentialAlgebra, Polynomial, Rational, Ring};

use super::words::{Coefficient, Series, Word};
use super::{Code, Shadow};
use crate::error::BuildError;
use crate::system::SystemFormulas;

/// The most words of one degree.
const MOST_WORDS: f64 = 65_536.0;

/// Parts of a step whose powers stay short are exact.
const SHORT: i64 = 1 << 10;

impl Shadow {
    /// Shadow of the product Φ^s_{γ_s t} ∘ … ∘ Φ^1_{γ_1 t}, F_1 to F_`last`. Each flow is a shadow's, by its place in
    /// `flows`, and its γ. The result is `None` where a shadow is code. Too many words, or more than `products`
    /// products of terms, give `None` too.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where the tensor or a Hamiltonian is outside the exact algebra.
    pub fn of_product(
        system: &SystemFormulas,
        flows: &[Self],
        steps: &[(usize, f64)],
        last: usize,
        products: u64,
    ) -> Result<Option<Self>, BuildError> {
        let mut ring = Ring::limited(system.dimension(), products);
        let mut letters = Vec::new();
        let mut degrees = Vec::new();
        // The letters of each flow, with their powers of the time.
        let mut alphabets = Vec::new();
        for flow in flows {
            let Some(elements) = flow.elements_in(&mut ring)? else {
                return Ok(None);
            };
            let mut alphabet = Vec::new();
            for (at, element) in elements.into_iter().enumerate().take(last) {
                if !element.is_zero() {
                    alphabet.push((letters.len() as u8, at + 1));
                    letters.push(element);
                    degrees.push(at + 1);
                }
            }
            alphabets.push(alphabet);
        }
        if words_of(&degrees, last) > MOST_WORDS || letters.len() > usize::from(u8::MAX) {
            return Ok(None);
        }
        let are_short = steps.iter().all(|(_, part)| {
            let scaled = part * SHORT as f64;
            scaled == libm::trunc(scaled) && part.abs() <= SHORT as f64
        });
        let words = match are_short {
            true => logarithm::<Rational>(&alphabets, steps, &degrees, last),
            false => logarithm::<f64>(&alphabets, steps, &degrees, last),
        };
        let brackets = Brackets::new(system, &mut ring, &letters)?;
        let mut coefficients = Vec::with_capacity(last);
        for of_degree in words {
            let sum = brackets.sum(&mut ring, &letters, of_degree);
            if ring.refusal().is_some() {
                return Ok(None);
            }
            coefficients.push(sum?);
        }
        Ok(Some(Self {
            code: Code::Ring(Box::new(ring), coefficients),
        }))
    }
}

/// How many words of degree `last` there are.
fn words_of(degrees: &[usize], last: usize) -> f64 {
    let mut counts = vec![1.0_f64];
    for degree in 1..=last {
        let before = degrees.iter().filter(|d| **d <= degree);
        counts.push(before.map(|d| counts[degree - d]).sum());
    }
    counts[last]
}

/// The words of the logarithm, degree by degree from 1 on.
fn logarithm<C: Coefficient>(
    alphabets: &[Vec<(u8, usize)>],
    steps: &[(usize, f64)],
    degrees: &[usize],
    last: usize,
) -> Vec<BTreeMap<Word, Rational>> {
    let mut product = Series::<C>::one(degrees, last);
    for (flow, part) in steps {
        let part = C::of(*part);
        let letters = alphabets[*flow].iter().map(|(letter, degree)| {
            let power = (1..*degree).fold(part.clone(), |power, _| power.times(&part));
            (*letter, power)
        });
        let letters: Vec<_> = letters.collect();
        product = product.times_exponential(&letters);
    }
    let series = product.logarithm();
    let mut words = vec![BTreeMap::new(); last];
    for (word, coefficient) in &series.terms {
        if let Some(coefficient) = coefficient.rational() {
            let degree = series.degree(word);
            words[degree - 1].insert(word.clone(), coefficient);
        }
    }
    words
}

/// Poisson brackets with letters.
struct Brackets {
    /// The motion ẋ = {G, x} of each letter G.
    fields: Vec<Vec<Polynomial>>,
}

impl Brackets {
    fn new(
        system: &SystemFormulas,
        ring: &mut Ring,
        letters: &[Polynomial],
    ) -> Result<Self, BuildError> {
        let d = system.dimension();
        let x: Vec<Polynomial> = (0..d).map(|at| ring.variable(at)).collect();
        let mut fields = Vec::with_capacity(letters.len());
        for letter in letters {
            let gradient = ring.differential(letter, d)?;
            let field = system.apply_tensor(ring, &x, &gradient)?;
            fields.push(field.iter().map(|f| ring.negate(f)).collect());
        }
        Ok(Self { fields })
    }

    /// {f, G} = −{G, f} for the letter G.
    fn with(&self, ring: &mut Ring, f: &Polynomial, letter: u8) -> Result<Polynomial, BuildError> {
        let field = &self.fields[usize::from(letter)];
        let slopes = ring.differential(f, field.len())?;
        let terms = field.iter().zip(&slopes);
        let terms: Vec<_> = terms
            .map(|(velocity, slope)| (-Rational::one(), velocity, slope))
            .collect();
        Ok(ring.sum_of_products(&terms))
    }

    /// The Lie element Σ c_w w as a function.
    fn sum(
        &self,
        ring: &mut Ring,
        letters: &[Polynomial],
        words: BTreeMap<Word, Rational>,
    ) -> Result<Polynomial, BuildError> {
        // By the letters that occur, whatever their order.
        let mut parts: BTreeMap<Word, Vec<(Word, Rational)>> = BTreeMap::new();
        for (word, coefficient) in words {
            let mut kind = word.clone();
            kind.sort_unstable();
            parts.entry(kind).or_default().push((word, coefficient));
        }
        let mut sums = Vec::new();
        for (kind, words) in parts {
            let count = |letter: &u8| kind.iter().filter(|other| *other == letter).count();
            let Some((first, times)) = kind
                .iter()
                .map(|letter| (*letter, count(letter)))
                .min_by_key(|(_, times)| *times)
            else {
                continue;
            };
            let words: Vec<_> = words
                .into_iter()
                .filter(|(word, _)| word[0] == first)
                .collect();
            let start = &letters[usize::from(first)];
            let part = self.nested(ring, start, &words, 1)?;
            sums.push((Rational::new(1, times as i64), part));
        }
        Ok(ring.combine(&sums))
    }

    /// Σ c_w {…{f, w_k}, …} over words that agree before their k-th letter; in the order of words.
    fn nested(
        &self,
        ring: &mut Ring,
        f: &Polynomial,
        words: &[(Word, Rational)],
        k: usize,
    ) -> Result<Polynomial, BuildError> {
        if f.is_zero() {
            return Ok(ring.zero());
        }
        let mut sums = Vec::new();
        let ended = words.iter().filter(|(word, _)| word.len() == k);
        for (_, coefficient) in ended {
            sums.push((coefficient.clone(), f.clone()));
        }
        let longer: Vec<_> = words
            .iter()
            .filter(|(word, _)| word.len() > k)
            .cloned()
            .collect();
        for group in longer.chunk_by(|(a, _), (b, _)| a[k] == b[k]) {
            let inner = self.with(ring, f, group[0].0[k])?;
            sums.push((Rational::one(), self.nested(ring, &inner, group, k + 1)?));
        }
        Ok(ring.combine(&sums))
    }
}
