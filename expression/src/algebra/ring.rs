//! The differential ring in which Hamilton–Jacobi coefficients are computed exactly.

use rustc_hash::FxHashMap;

use super::generator::{Atom, Generator};
use super::monomial::Symbol;
use super::polynomial::{Coefficient, Polynomial};
use crate::arithmetic::AlgebraError;
use crate::expression::Function;
use crate::reach::Reach;

/// ℚ(parameters)[x₁^±, …, x_d^±, generators]: Laurent polynomials in the state variables and in
/// adjoined functions of the state ([`Generator`]), closed under ∂/∂xᵢ.
///
/// Sums are collected, so cancellation is exact and zero is recognized wherever the generators'
/// relations decide it. What they do not decide is not refused: it stays a sum of terms.
#[derive(Clone, Debug)]
pub struct Ring {
    pub(super) variables: usize,
    pub(super) generators: Vec<Generator>,
    /// The variables that each generator depends on.
    pub(super) reaches: Vec<Reach>,
    /// Whether each generator has a value at every state.
    pub(super) are_everywhere: Vec<bool>,
    pub(super) symbols: FxHashMap<Generator, Symbol>,
    pub(super) atoms: Vec<Atom>,
    pub(super) atom_symbols: FxHashMap<Atom, Symbol>,
    pub(super) derivatives: FxHashMap<(Symbol, usize), Polynomial>,
    pub(super) has_relations: bool,
    /// Products of terms that may still be formed.
    pub(super) remaining: u64,
    /// The limit that was reached.
    pub(super) refusal: Option<AlgebraError>,
}

/// Products of terms that any ring may form: a minute where they are formed one by one.
const MOST_PRODUCTS: u64 = 1 << 28;

/// The largest size of an exponent: sums of a few of them fit a machine word.
pub(super) const LARGEST_EXPONENT: u32 = 32_767;

impl Ring {
    /// The ring over `variables` state variables, with no generator yet. It forms 2²⁸ products of terms
    /// at most, then refuses.
    pub fn new(variables: usize) -> Self {
        Self {
            variables,
            generators: Vec::new(),
            reaches: Vec::new(),
            are_everywhere: Vec::new(),
            symbols: FxHashMap::default(),
            atoms: Vec::new(),
            atom_symbols: FxHashMap::default(),
            derivatives: FxHashMap::default(),
            has_relations: false,
            remaining: MOST_PRODUCTS,
            refusal: None,
        }
    }

    /// The same for at most `products` products of terms. Once they are spent every further product
    /// is 0, so that a computation that grows too long soon ends: who sets a limit asks
    /// [`refusal`](crate::Arithmetic::refusal) before taking a result.
    pub fn limited(variables: usize, products: u64) -> Self {
        Self {
            remaining: products,
            ..Self::new(variables)
        }
    }

    /// Allows at most `products` further products of terms, whatever was refused before.
    pub fn allow(&mut self, products: u64) {
        self.remaining = products;
        self.refusal = None;
    }

    /// Whether so many products of terms may be formed; none may after a refusal.
    pub(super) fn spend(&mut self, products: usize) -> bool {
        self.remaining = self.remaining.saturating_sub(products as u64);
        if self.remaining == 0 {
            self.refuse(AlgebraError::ExpansionTooLong);
        }
        self.refusal.is_none()
    }

    /// Whether exponents of this size may occur; none may after a refusal.
    pub(super) fn admits(&mut self, exponent: u32) -> bool {
        if exponent > LARGEST_EXPONENT {
            self.refuse(AlgebraError::ExpandedExponent);
        }
        self.refusal.is_none()
    }

    pub(super) fn refuse(&mut self, reason: AlgebraError) {
        self.refusal.get_or_insert(reason);
    }

    /// `result`, unless a limit was reached on the way to it.
    pub(super) fn unless_refused<T>(&self, result: T) -> Result<T, AlgebraError> {
        match &self.refusal {
            None => Ok(result),
            Some(reason) => Err(reason.clone()),
        }
    }

    /// The number d of state variables.
    pub fn variables(&self) -> usize {
        self.variables
    }

    /// The variable xᵢ.
    pub fn variable(&self, index: usize) -> Polynomial {
        debug_assert!(index < self.variables);
        Polynomial::symbol(index as Symbol)
    }

    /// The generator behind a symbol, `None` for a variable.
    pub fn generator(&self, symbol: Symbol) -> Option<&Generator> {
        (symbol as usize)
            .checked_sub(self.variables)
            .map(|at| &self.generators[at])
    }

    /// The constant behind a symbol of a [`Coefficient`].
    pub fn atom(&self, symbol: Symbol) -> &Atom {
        &self.atoms[symbol as usize]
    }

    pub(super) fn adjoin(&mut self, generator: Generator) -> Symbol {
        if let Some(&symbol) = self.symbols.get(&generator) {
            return symbol;
        }
        let symbol = Symbol::try_from(self.variables + self.generators.len())
            .expect("fewer than 2^32 symbols");
        self.has_relations |= matches!(
            generator,
            Generator::Inverse(_)
                | Generator::Root(..)
                | Generator::Kept(..)
                | Generator::Function(Function::Cos | Function::Cosh, _)
        );
        let reaches: Vec<Reach> = generator.arguments().map(|u| self.reach_of(u)).collect();
        let reach = Reach::union(&reaches);
        self.are_everywhere
            .push(self.has_value_everywhere(&generator));
        self.symbols.insert(generator.clone(), symbol);
        self.generators.push(generator);
        self.reaches.push(reach);
        symbol
    }

    pub(super) fn atom_symbol(&mut self, atom: Atom) -> Coefficient {
        let next = Symbol::try_from(self.atoms.len()).expect("fewer than 2^32 constants");
        let symbol = *self.atom_symbols.entry(atom.clone()).or_insert(next);
        if symbol == next {
            self.atoms.push(atom);
        }
        Coefficient::symbol(symbol)
    }

    /// The variables that a polynomial depends on.
    pub(super) fn reach_of(&self, f: &Polynomial) -> Reach {
        let symbols = f.terms().iter().flat_map(|(m, _)| m.factors());
        let reaches: Vec<Reach> = symbols
            .map(
                |&(symbol, _)| match (symbol as usize).checked_sub(self.variables) {
                    None => Reach::variable(symbol),
                    Some(at) => self.reaches[at].clone(),
                },
            )
            .collect();
        Reach::union(&reaches)
    }
}
