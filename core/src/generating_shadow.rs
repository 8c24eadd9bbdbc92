//! The shadow Hamiltonian of the map with a generating function.
//!
//! The flow of H̃ over τh has the generating function S with ∂_τ S = h H̃(α(x, dS)) and S = 0 at τ = 0. Its
//! coefficients are polynomials in τ:
//!
//! s_n(x, τ) = ∫_0^τ [h^{n−1}] H̃(α(x, Σ_{k<n} hᵏ ds_k)) dτ.
//!
//! With H̃ = Σ h^{n−1} F_n, F_n enters s_n as τ F_n alone. The map's own coefficients are the s_n(x, 1): Ŝ_n for n < m,
//! nothing from there on; so F_n = −s_n(x, 1) before it has entered. F_{m+1} = −S_{m+1}(H).

use leafwise_expression::graph::lift;
use leafwise_expression::series::{Tape, TapeIndex, TaylorState};
use leafwise_expression::{
    AlgebraError, Arithmetic, DifferentialAlgebra, Expression, Graph, Polynomial, Rational, Ring,
    Term,
};

use crate::error::BuildError;
use crate::generating_function::Generating;
use crate::realization::{SourceRecursion, SourceSeries};
use crate::shadow::Shadow;

/// The longest code of a shadow, in operations.
const MOST_NODES: usize = 1 << 16;

/// Terms F_1 to F_`last` of the shadow Hamiltonian, for a generating function on `dimension` coordinates. They are
/// expanded where that takes at most `products` products of terms. Beyond that they are formed as code, if F_{m+1} is
/// the only correction among them. Otherwise, and where the code is too long, the result is `None`.
///
/// # Errors
/// [`BuildError::Algebra`] where the tensor or the Hamiltonian is outside the exact algebra.
pub(crate) fn shadow_of(
    generating: &Generating,
    series: &SourceSeries<'_>,
    dimension: usize,
    last: usize,
    products: u64,
) -> Result<Option<Shadow>, BuildError> {
    let m = 2 * generating.len();
    let energy = match generating {
        Generating::Polynomials(function) => function.ring.formula(&function.coefficients[0]),
        Generating::Code(code) => {
            let formulas = code.graph.shared_formulas(&code.coefficients[..1]);
            match formulas.and_then(|formulas| formulas.into_iter().next()) {
                Some(energy) => energy,
                None => return Ok(None),
            }
        }
    };
    let coordinates: Vec<usize> = (0..dimension).collect();
    let orders = Orders { dimension, m, last };
    let is_first = last <= m + 2;
    let mut ring = Ring::limited(dimension + usize::from(!is_first), products);
    let source = (series.in_ring)(&mut ring, &coordinates);
    let formed = source.and_then(|source| match is_first {
        true => orders.coefficients(&energy, &mut ring, source, &Homogeneous),
        false => {
            let clock = Clock {
                symbol: dimension as u32,
            };
            orders.coefficients(&energy, &mut ring, source, &clock)
        }
    });
    if ring.refusal().is_none() {
        return Ok(Some(Shadow::expanded(ring, formed?)));
    }
    if !is_first {
        return Ok(None);
    }
    let mut graph = Graph::limited(MOST_NODES);
    let source = (series.in_graph)(&mut graph, &coordinates)?;
    match orders.coefficients(&energy, &mut graph, source, &Homogeneous) {
        Ok(coefficients) => Ok(Some(Shadow::code(graph, coefficients))),
        Err(BuildError::Algebra(AlgebraError::CodeTooLong { .. })) => Ok(None),
        Err(other) => Err(other),
    }
}

/// Which F_n are formed.
struct Orders {
    dimension: usize,
    m: usize,
    last: usize,
}

/// How s_n depends on τ.
trait Time<A: DifferentialAlgebra> {
    /// ∫_0^τ f dτ, of what stands in order n.
    fn integral(&self, algebra: &mut A, f: &A::Element, n: usize) -> A::Element;
    /// f at τ = 1.
    fn at_one(&self, f: &A::Element) -> A::Element;
    /// τ f.
    fn times(&self, algebra: &mut A, f: &A::Element) -> A::Element;
    /// A function of the coordinates as operations.
    fn tape(&self, algebra: &A, f: &A::Element) -> Result<(Tape, TapeIndex), BuildError>;
}

/// s_n = τⁿ S_n, as long as H̃ is H: the integral is 1/n of the integrand, and τ may be 1.
struct Homogeneous;

impl<A: DifferentialAlgebra> Time<A> for Homogeneous {
    fn integral(&self, algebra: &mut A, f: &A::Element, n: usize) -> A::Element {
        algebra.scale(&Rational::new(1, n as i64), f)
    }
    fn at_one(&self, f: &A::Element) -> A::Element {
        f.clone()
    }
    fn times(&self, _: &mut A, f: &A::Element) -> A::Element {
        f.clone()
    }
    fn tape(&self, _: &A, _: &A::Element) -> Result<(Tape, TapeIndex), BuildError> {
        unreachable!("nothing is followed behind the first correction")
    }
}

/// τ is a variable of the ring behind the coordinates.
struct Clock {
    symbol: u32,
}

impl Time<Ring> for Clock {
    fn integral(&self, _: &mut Ring, f: &Polynomial, _: usize) -> Polynomial {
        let terms = f.terms().iter();
        Polynomial::collect(terms.map(|(monomial, c)| {
            let power = i64::from(monomial.exponent(self.symbol)) + 1;
            let factor = Rational::new(1, power);
            (monomial.shifted(self.symbol, 1), c.scaled(&factor))
        }))
    }

    fn at_one(&self, f: &Polynomial) -> Polynomial {
        let terms = f.terms().iter();
        Polynomial::collect(terms.map(|(monomial, c)| {
            let power = monomial.exponent(self.symbol);
            (monomial.shifted(self.symbol, -power), c.clone())
        }))
    }

    fn times(&self, _: &mut Ring, f: &Polynomial) -> Polynomial {
        let terms = f.terms().iter();
        Polynomial::collect(
            terms.map(|(monomial, c)| (monomial.shifted(self.symbol, 1), c.clone())),
        )
    }

    fn tape(&self, ring: &Ring, f: &Polynomial) -> Result<(Tape, TapeIndex), BuildError> {
        let mut graph = Graph::new();
        let inputs: Vec<Term> = (0..ring.variables()).map(|i| graph.input(i)).collect();
        let one = graph.one();
        let code = lift(&mut graph, ring, &[vec![(one, f.clone())]], &inputs)?;
        let mut tape = Tape::new();
        // τ does not occur.
        let mut inputs: Vec<TapeIndex> = (0..self.symbol as usize)
            .map(|i| tape.variable(i))
            .collect();
        inputs.push(tape.one());
        let node = graph.evaluate_in(&mut tape, &code, &inputs)?[0];
        Ok((tape, node))
    }
}

/// F_n along α, from order n on.
struct Followed<E> {
    n: usize,
    tape: Tape,
    node: TapeIndex,
    state: TaylorState<E>,
    known: usize,
}

impl<E: Clone + std::fmt::Debug> Followed<E> {
    fn new(n: usize, tape: Tape, node: TapeIndex) -> Self {
        let state = TaylorState::new(&tape);
        Self {
            n,
            tape,
            node,
            state,
            known: 0,
        }
    }

    /// [hᵏ] F_n ∘ α.
    fn coefficient<A: Arithmetic<Element = E>>(
        &mut self,
        algebra: &mut A,
        alpha: &[Vec<E>],
        k: usize,
    ) -> Result<E, AlgebraError> {
        while self.known <= k {
            let now = &alpha[self.known];
            self.state
                .extend(&self.tape, algebra, |_, i| now[i].clone())?;
            self.known += 1;
        }
        Ok(self.state.coefficient(self.node, k).clone())
    }
}

impl Orders {
    /// F_1 to F_last in an algebra.
    fn coefficients<A: DifferentialAlgebra>(
        &self,
        energy: &Expression,
        algebra: &mut A,
        mut source: SourceRecursion<A>,
        time: &impl Time<A>,
    ) -> Result<Vec<A::Element>, BuildError> {
        let d = self.dimension;
        let mut tape = Tape::new();
        let node = tape.record(energy)?;
        let mut followed = vec![Followed::new(1, tape, node)];
        let x: Vec<A::Element> = (0..d).map(|i| algebra.coordinate(i)).collect();
        let mut coefficients = vec![algebra.zero(); self.last];
        let mut alpha = vec![x];
        for n in 1..=self.last {
            let mut gradient = vec![algebra.zero(); d];
            // s_n = 0 for even n: H̃ is even in h, and the flow over −τh inverts that over τh.
            if n % 2 == 1 {
                let mut parts = Vec::new();
                for function in &mut followed {
                    let integrand = function.coefficient(algebra, &alpha, n - function.n)?;
                    parts.push((Rational::one(), time.integral(algebra, &integrand, n)));
                }
                let mut s = algebra.combine(&parts);
                if n == 1 {
                    coefficients[0] = time.at_one(&s);
                } else if n > self.m {
                    let at_one = time.at_one(&s);
                    let next = algebra.negate(&at_one);
                    let entering = time.times(algebra, &next);
                    s = algebra.add(&s, &entering);
                    if n + 2 <= self.last {
                        let (tape, node) = time.tape(algebra, &next)?;
                        followed.push(Followed::new(n, tape, node));
                    }
                    coefficients[n - 1] = next;
                }
                gradient = algebra.differential(&s, d)?;
            }
            if let Some(refusal) = algebra.refusal() {
                return Err(refusal.clone().into());
            }
            if n < self.last {
                alpha.push(source(algebra, gradient)?);
            }
        }
        Ok(coefficients)
    }
}
