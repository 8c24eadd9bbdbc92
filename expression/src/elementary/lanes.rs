//! A function on many numbers: by registers where its argument is ordinary, by `libm` elsewhere.

use std::marker::PhantomData;

use crate::vector::{Fused, InstructionSet, One, Register, RegisterWork, ScalarWork, run_scalar};

/// The operations of a function of `libm` in their order, its branches written as selections: the
/// same bits, on many arguments at once.
pub(super) trait Elementary {
    /// The values and whether they are `libm`'s: x is ordinary. Never for NaN.
    fn ordinary<R: Register>(x: R) -> (R, R::Mask);
    /// The value at any argument.
    fn any(x: f64) -> f64;
}

/// x ↦ f(x) for each number.
pub(super) struct Lanes<'a, F>(&'a mut [f64], PhantomData<F>);

impl<'a, F> Lanes<'a, F> {
    pub(super) fn new(values: &'a mut [f64]) -> Self {
        Self(values, PhantomData)
    }
}

/// The most lanes of a register.
const MOST: usize = 8;

impl<F: Elementary> RegisterWork for Lanes<'_, F> {
    #[inline(always)]
    fn run<R: Register>(self) {
        let mut blocks = self.0.chunks_exact_mut(R::LANES);
        for block in &mut blocks {
            let x = R::load(block);
            let (values, ordinary) = F::ordinary(x);
            values.store(block);
            if !R::all(ordinary) {
                replace::<F, R>(block, x);
            }
        }
        let rest = blocks.into_remainder();
        if let [first, _, ..] = *rest {
            let mut padded = [first; MOST];
            padded[..rest.len()].copy_from_slice(rest);
            let x = R::load(&padded);
            let (values, ordinary) = F::ordinary(x);
            values.store(&mut padded);
            rest.copy_from_slice(&padded[..rest.len()]);
            if !R::all(ordinary) {
                replace::<F, R>(rest, x);
            }
        } else {
            Self::new(rest).run_alone();
        }
    }

    #[inline(always)]
    fn run_alone(self) {
        for value in self.0 {
            *value = F::any(*value);
        }
    }
}

/// The values at arguments of which some are not ordinary: for the others the same.
#[cold]
#[inline(never)]
fn replace<F: Elementary, R: Register>(values: &mut [f64], x: R) {
    let mut arguments = [0.0; MOST];
    x.store(&mut arguments);
    for (value, x) in values.iter_mut().zip(arguments) {
        *value = F::any(x);
    }
}

/// x ↦ f(x) for each number, with the widest instruction set.
pub(super) fn apply<F: Elementary>(values: &mut [f64]) {
    InstructionSet::best().run_registers(Lanes::<F>::new(values));
}

/// A pair of functions of one argument.
pub(super) trait ElementaryPair {
    /// Both values and whether they are `libm`'s.
    fn ordinary<R: Register>(x: R) -> (R, R, R::Mask);
    /// The values at any argument, fused products by F.
    fn any<F: Fused>(x: f64) -> (f64, f64);
}

/// The values at an ordinary argument.
#[inline(always)]
pub(super) fn value_of_pair<P: ElementaryPair, F: Fused>(x: f64) -> Option<(f64, f64)> {
    let (first, second, ordinary) = P::ordinary(One::<F>::splat(x));
    ordinary.then_some((first.0, second.0))
}

/// The values at any argument.
#[inline(always)]
pub(super) fn both<P: ElementaryPair>(x: f64) -> (f64, f64) {
    run_scalar(Both::<P>(x, PhantomData))
}

struct Both<P>(f64, PhantomData<P>);

impl<P: ElementaryPair> ScalarWork for Both<P> {
    type Output = (f64, f64);

    #[inline(always)]
    fn run<F: Fused>(self) -> (f64, f64) {
        P::any::<F>(self.0)
    }
}

/// The first of two functions alone.
pub(super) struct First<F>(PhantomData<F>);

impl<F: ElementaryPair> Elementary for First<F> {
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R::Mask) {
        let (first, _, ordinary) = F::ordinary(x);
        (first, ordinary)
    }

    fn any(x: f64) -> f64 {
        both::<F>(x).0
    }
}

/// The second of two functions alone.
pub(super) struct Second<F>(PhantomData<F>);

impl<F: ElementaryPair> Elementary for Second<F> {
    #[inline(always)]
    fn ordinary<R: Register>(x: R) -> (R, R::Mask) {
        let (_, second, ordinary) = F::ordinary(x);
        (second, ordinary)
    }

    fn any(x: f64) -> f64 {
        both::<F>(x).1
    }
}

/// x ↦ f(x) in the first numbers, g(x) in the second.
pub(super) struct PairLanes<'a, F>(&'a mut [f64], &'a mut [f64], PhantomData<F>);

impl<'a, F> PairLanes<'a, F> {
    pub(super) fn new(first: &'a mut [f64], second: &'a mut [f64]) -> Self {
        assert_eq!(first.len(), second.len(), "two values an argument");
        Self(first, second, PhantomData)
    }
}

impl<F: ElementaryPair> RegisterWork for PairLanes<'_, F> {
    #[inline(always)]
    fn run<R: Register>(self) {
        let mut blocks = self.0.chunks_exact_mut(R::LANES);
        let mut others = self.1.chunks_exact_mut(R::LANES);
        for (block, other) in (&mut blocks).zip(&mut others) {
            let x = R::load(block);
            let (first, second, ordinary) = F::ordinary(x);
            first.store(block);
            second.store(other);
            if !R::all(ordinary) {
                replace_pair::<F, R>(block, other, x);
            }
        }
        Self::new(blocks.into_remainder(), others.into_remainder()).run_alone();
    }

    #[inline(always)]
    fn run_alone(self) {
        for (a, b) in self.0.iter_mut().zip(self.1) {
            (*a, *b) = both::<F>(*a);
        }
    }
}

#[cold]
#[inline(never)]
fn replace_pair<F: ElementaryPair, R: Register>(first: &mut [f64], second: &mut [f64], x: R) {
    let mut arguments = [0.0; MOST];
    x.store(&mut arguments);
    for ((a, b), x) in first.iter_mut().zip(second).zip(arguments) {
        (*a, *b) = both::<F>(x);
    }
}

/// x ↦ f(x) in `first`, g(x) in `second`, with the widest instruction set.
pub(super) fn apply_pair<F: ElementaryPair>(first: &mut [f64], second: &mut [f64]) {
    InstructionSet::best().run_registers(PairLanes::<F>::new(first, second));
}
