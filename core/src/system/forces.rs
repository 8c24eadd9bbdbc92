//! Forces: one-forms η beside dH, for ẋ = −Π(dH + η) + f, and a friction f.
//!
//! Motions stay on the symplectic leaves whatever η is: Casimirs are constant, since Π dC = 0. The energy is not:
//! dH/dt = −⟨η, ẋ_H⟩ with ẋ_H = −Π dH. Damping is the one-form η = λ g ẋ_H of a rate λ ≥ 0 and a positive semidefinite
//! metric g. Under it dH/dt = −λ ⟨g ẋ_H, ẋ_H⟩ ≤ 0: the double bracket (R. Brockett, *Dynamical systems that sort lists,
//! diagonalize matrices, and solve linear programming problems*, Linear Algebra and its Applications 146 (1991); A.
//! Bloch, P. Krishnaprasad, J. Marsden, T. Ratiu, *The Euler–Poincaré equations and double bracket dissipation*,
//! Communications in Mathematical Physics 175 (1996)).
//!
//! Friction f is a part of the velocity of which nothing is asked: dH/dt = −⟨η, ẋ_H⟩ + ⟨dH, f⟩, and dC/dt = ⟨dC, f⟩ for
//! every Casimir C. Where there are Casimirs it leaves the leaves. Where there are none it changes the symplectic form.

use leafwise_expression::Expression;

use crate::error::BuildError;

/// The motions of a system, each with what the one before has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum MotionClass {
    /// ẋ = {H, x}.
    #[default]
    Hamiltonian,
    /// ẋ = −Π(dH + η), along symplectic leaves.
    OnLeaves,
    /// ẋ = −Π(dH + η) + f, with a friction f, which leaves the leaves where there are Casimirs.
    OffLeaves,
}

/// η = Σ_i η_i dx_i + λ g ẋ_H, and f.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces {
    /// η_1 … η_d; empty where damping is all there is.
    pub one_form: Vec<Expression>,
    /// λ g ẋ_H.
    pub damping: Option<Damping>,
    /// f_1 … f_d, added to ẋ as they stand; empty where there is none.
    pub friction: Vec<Expression>,
}

/// The one-form λ g ẋ_H.
#[derive(Clone, Debug, PartialEq)]
pub struct Damping {
    /// λ ≥ 0.
    pub rate: Expression,
    /// g.
    pub metric: Metric,
}

/// A positive semidefinite g_ij(x), which makes velocities covectors.
#[derive(Clone, Debug, PartialEq)]
pub enum Metric {
    /// d entries g_ii, the others being 0.
    Diagonal(Vec<Expression>),
    /// d rows of d entries, g_ij = g_ji.
    Full(Vec<Vec<Expression>>),
}

impl Metric {
    /// The identity on the first `moving` of d coordinates, 0 on the others.
    pub fn identity(moving: usize, d: usize) -> Self {
        Self::Diagonal((0..d).map(|i| i32::from(i < moving).into()).collect())
    }

    /// The entries (i, j, g_ij) that are not 0 by their place.
    pub(super) fn entries(&self) -> Vec<(usize, usize, &Expression)> {
        match self {
            Self::Diagonal(entries) => entries.iter().enumerate().map(|(i, g)| (i, i, g)).collect(),
            Self::Full(rows) => {
                let rows = rows.iter().enumerate();
                rows.flat_map(|(i, row)| row.iter().enumerate().map(move |(j, g)| (i, j, g)))
                    .collect()
            }
        }
    }

    /// The lengths that have to be d.
    fn lengths(&self) -> Vec<usize> {
        match self {
            Self::Diagonal(entries) => vec![entries.len()],
            Self::Full(rows) => std::iter::once(rows.len())
                .chain(rows.iter().map(Vec::len))
                .collect(),
        }
    }
}

impl Forces {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.motion() == MotionClass::Hamiltonian
    }

    /// The same of `d` coordinates, of which those behind feel none.
    #[must_use]
    pub fn with_resting(mut self, d: usize) -> Self {
        for components in [&mut self.one_form, &mut self.friction] {
            if !components.is_empty() {
                components.resize(d, 0.into());
            }
        }
        match self.damping.as_mut().map(|damping| &mut damping.metric) {
            Some(Metric::Diagonal(entries)) => entries.resize(d, 0.into()),
            Some(Metric::Full(rows)) => {
                rows.iter_mut().for_each(|row| row.resize(d, 0.into()));
                rows.resize(d, vec![0.into(); d]);
            }
            None => {}
        }
        self
    }

    /// The motion under them.
    pub fn motion(&self) -> MotionClass {
        match (self.friction.is_empty(), &self.damping) {
            (false, _) => MotionClass::OffLeaves,
            (true, None) if self.one_form.is_empty() => MotionClass::Hamiltonian,
            (true, _) => MotionClass::OnLeaves,
        }
    }

    /// Those that are there, in words: `the forces and the friction`.
    pub fn words(&self) -> String {
        let kinds = [
            (!self.one_form.is_empty(), "the forces"),
            (self.damping.is_some(), "the damping"),
            (!self.friction.is_empty(), "the friction"),
        ];
        let present = kinds.iter().filter(|(is_present, _)| *is_present);
        let words: Vec<&str> = present.map(|(_, word)| *word).collect();
        words.join(" and ")
    }

    /// Every formula in them.
    pub fn formulas(&self) -> impl Iterator<Item = &Expression> {
        let damping = self.damping.iter().flat_map(|damping| {
            let metric = damping.metric.entries().into_iter().map(|(.., g)| g);
            std::iter::once(&damping.rate).chain(metric)
        });
        self.one_form.iter().chain(&self.friction).chain(damping)
    }

    /// Refuses lists of other lengths than d.
    pub(super) fn check(&self, d: usize) -> Result<(), BuildError> {
        let of = |what: &str, found: usize| match found == d {
            true => Ok(()),
            false => Err(BuildError::Dimension {
                what: what.to_owned(),
                expected: d,
                found,
            }),
        };
        if !self.one_form.is_empty() {
            of("the number of forces", self.one_form.len())?;
        }
        if !self.friction.is_empty() {
            of(
                "the number of components of the friction",
                self.friction.len(),
            )?;
        }
        let damping = self.damping.iter();
        damping
            .flat_map(|damping| damping.metric.lengths())
            .try_for_each(|found| of("a row of the metric of the damping", found))
    }
}
