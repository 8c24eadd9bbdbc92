//! Results of a search.

use std::collections::{BTreeMap, BTreeSet};

use leafwise_core::SystemFormulas;
use leafwise_expression::algebra::{Generator, Monomial};
use leafwise_expression::{AlgebraError, Arithmetic, Expression, Polynomial, Rational, Ring};

use crate::field::RingField;

/// Kinds of brackets that are looked for, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Kind {
    /// {x_i, x_j} constant.
    Constant,
    /// {x_i, x_j} = a_ij x_i x_j.
    LogCanonical,
    /// {x_i, x_j} = c_ij + Σ_k c_ij^k x_k.
    Affine,
    /// ẋ = φ ∇C × ∇H in space, ẋ = φ (∂H/∂y, −∂H/∂x) in the plane.
    FirstIntegrals,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 4] = [
        Self::Constant,
        Self::LogCanonical,
        Self::Affine,
        Self::FirstIntegrals,
    ];

    /// Name of the kind: `constant`, `log canonical`, `affine` or `first integrals`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::LogCanonical => "log canonical",
            Self::Affine => "affine",
            Self::FirstIntegrals => "first integrals",
        }
    }
}

/// A tensor with ẋ = J ∇H, before it is proved.
#[derive(Clone, Debug)]
pub(crate) struct TensorCandidate {
    pub kind: Kind,
    /// J_ij for i < j.
    pub tensor: BTreeMap<(usize, usize), Polynomial>,
    pub hamiltonian: Polynomial,
    pub family: usize,
    /// H as it is written, where the ring would expand it.
    pub energy: Option<Expression>,
    /// Casimirs that the construction gives; others are looked for.
    pub casimirs: Vec<Expression>,
}

impl TensorCandidate {
    /// The same with λJ and H/λ: the first coefficient of the first entry becomes 1 or −1, and energies of momenta become positive.
    pub fn normalized(
        self,
        field: &mut RingField,
        parameters: &[f64],
    ) -> Result<Self, AlgebraError> {
        let first = |f: &Polynomial| {
            let coefficient = f.terms().first().map(|(_, c)| c.clone())?;
            coefficient
                .terms()
                .first()
                .map(|(_, number)| number.clone())
        };
        let lead = self.tensor.values().next().and_then(first);
        let (Some(lead), Some(energy)) = (lead, first(&self.hamiltonian)) else {
            return Ok(self);
        };
        let sign = match self.sign_of_momentum(field, parameters)? {
            0 => energy.signum(),
            sign => sign,
        };
        let ring = &mut field.ring;
        let lambda = lead.recip().abs() * Rational::from_integer(sign.into());
        let tensor = self.tensor.into_iter();
        let factor = Expression::Constant(lambda.recip());
        Ok(Self {
            energy: self.energy.map(|energy| match lambda.is_one() {
                true => energy,
                false => Expression::Product(vec![factor, energy]),
            }),
            tensor: tensor
                .map(|(pair, entry)| (pair, ring.scale(&lambda, &entry)))
                .collect(),
            hamiltonian: ring.scale(&lambda.recip(), &self.hamiltonian),
            ..self
        })
    }

    /// The sign of H's second derivatives by momenta, 0 where no momentum is seen.
    ///
    /// A momentum x_j is one in which some f_i with J_ij ≠ 0 is affine. Constant J_ij and ∂f_i/∂x_j are those of a canonical pair with a mass, and
    /// decide before others: first those with the position x_i before x_j. H has no such derivative by a momentum of first degree.
    fn sign_of_momentum(
        &self,
        field: &mut RingField,
        parameters: &[f64],
    ) -> Result<i32, AlgebraError> {
        let d = field.dimension();
        let near: Vec<f64> = (0..d).map(|i| 0.4 + 0.1 * i as f64 / d as f64).collect();
        let is_constant = |f: &Polynomial| f.terms().iter().all(|(m, _)| m.factors().is_empty());
        // By the orders (position, momentum) and (momentum, position), and of all other pairs.
        let mut momenta = [const { BTreeSet::new() }; 3];
        for (&(a, b), entry) in &self.tensor {
            for (order, (i, j)) in [(a, b), (b, a)].into_iter().enumerate() {
                let slope = field.ring.derivative(&field.f[i], j)?;
                let is_affine = field.ring.derivative(&slope, j)?.is_zero();
                if slope.is_zero() || !is_affine {
                    continue;
                }
                let is_pair = is_constant(entry) && is_constant(&slope);
                momenta[if is_pair { order } else { 2 }].insert(j);
            }
        }
        for momenta in momenta {
            let mut sum = 0;
            for j in momenta {
                let slope = field.ring.derivative(&self.hamiltonian, j)?;
                let mass = field.ring.derivative(&slope, j)?;
                let value = field.ring.formula(&mass).evaluate(&near, parameters);
                sum += i32::from(value > 0.0) - i32::from(value < 0.0);
            }
            if sum != 0 {
                return Ok(sum.signum());
            }
        }
        Ok(0)
    }

    /// Order of preference: few fractions in the tensor, then few terms, then many squares in H, then few terms in H.
    pub fn size(&self, ring: &Ring) -> [usize; 4] {
        let factors = self.tensor.values().flat_map(Polynomial::terms);
        let factors = factors.flat_map(|(m, _)| m.factors());
        let fractions = factors.filter(|&&(symbol, exponent)| {
            exponent < 0 || matches!(ring.generator(symbol), Some(Generator::Inverse(_)))
        });
        let fractions = fractions.count();
        let entries = self.tensor.values().map(|entry| entry.terms().len());
        let terms = self.hamiltonian.terms();
        let is_square = |m: &Monomial| matches!(m.factors(), [(_, 2)]);
        let others = terms.iter().filter(|(m, _)| !is_square(m)).count();
        let squares = terms.len() - others;
        let missing = self.tensor.len().saturating_sub(squares);
        [fractions, entries.sum(), missing, terms.len()]
    }

    /// Puts the preferred one of both in the place of `best`.
    pub fn keep_smaller(best: &mut Option<Self>, other: Option<Self>, ring: &Ring) {
        if let Some(other) = other
            && best
                .as_ref()
                .is_none_or(|known| other.size(ring) < known.size(ring))
        {
            *best = Some(other);
        }
    }

    /// H as a formula.
    pub fn written(&self, ring: &Ring) -> Expression {
        self.energy
            .clone()
            .unwrap_or_else(|| ring.formula(&self.hamiltonian))
    }
}

/// A search in one kind: a tensor, or the reason why there is none.
pub(crate) enum Attempt {
    Found(Box<TensorCandidate>),
    None(NoBracket),
}

impl Attempt {
    pub fn none(reason: impl Into<String>) -> Self {
        Self::None(NoBracket {
            reason: reason.into(),
            is_proved: false,
            lacks_hamiltonian: false,
        })
    }

    pub fn proved(reason: impl Into<String>) -> Self {
        Self::None(NoBracket {
            reason: reason.into(),
            is_proved: true,
            lacks_hamiltonian: false,
        })
    }
}

/// A bracket with ẋ = {x, H}, proved.
#[derive(Clone, Debug)]
pub struct FoundBracket {
    /// The kind of the tensor.
    pub kind: Kind,
    /// {x_i, x_j} for i < j, with ẋ = {x, H}; absent entries are zero.
    pub entries: BTreeMap<(usize, usize), Expression>,
    /// H.
    pub hamiltonian: Expression,
    /// Casimirs, those that were found.
    pub casimirs: Vec<Expression>,
    /// The dimension of the linear family of tensors in which this one was chosen, at least 1. A scale of H is a member of it.
    pub family: usize,
    /// Whether parameters are held as names. Otherwise numbers stand in their places.
    pub has_parameters: bool,
    /// The same as a system.
    pub system: SystemFormulas,
}

/// A kind in which there is no bracket, or none was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedKind {
    /// The kind.
    pub kind: Kind,
    /// The reason, as a sentence without its full stop.
    pub reason: String,
    /// Whether it proves that no bracket of this kind exists.
    pub is_proved: bool,
    /// Whether a tensor of this kind fits, and only its Hamiltonian was not found.
    pub lacks_hamiltonian: bool,
}

/// The same before its kind is known.
pub(crate) struct NoBracket {
    pub reason: String,
    pub is_proved: bool,
    pub lacks_hamiltonian: bool,
}

impl NoBracket {
    pub fn of(self, kind: Kind) -> RefusedKind {
        let Self {
            reason,
            is_proved,
            lacks_hamiltonian,
        } = self;
        RefusedKind {
            kind,
            reason,
            is_proved,
            lacks_hamiltonian,
        }
    }
}

/// Everything that a search found.
#[derive(Clone, Debug)]
pub struct Report {
    /// The first bracket in the order of the kinds.
    pub bracket: Option<FoundBracket>,
    /// Kinds without one that were tried before it, with the reasons.
    pub refused: Vec<RefusedKind>,
    /// First integrals, a basis of those of the degree that was tried. Products of each other count.
    pub integrals: Vec<Expression>,
    /// The degree up to which first integrals were looked for, 0 where none was needed.
    pub degree: usize,
    /// Equilibrium near which no bracket of any kind exists, and the reason, where one is known.
    pub never: Option<String>,
}
