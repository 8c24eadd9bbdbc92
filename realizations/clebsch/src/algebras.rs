//! The algebras that are known by their structure constants, one a file.

pub mod euclidean;
pub mod rotations;
pub mod symplectic;
pub mod two_rotations;

use std::sync::{LazyLock, OnceLock};

use crate::algebra::Algebra;
use crate::constants::Constants;

/// An algebra with its structure constants.
#[derive(Debug)]
pub struct Known {
    /// Its forms.
    pub algebra: Algebra,
    constants: OnceLock<Constants>,
}

impl Known {
    /// Its structure constants, formed when they are first asked for.
    pub fn constants(&self) -> &Constants {
        let Algebra { forms, omega, .. } = &self.algebra;
        self.constants.get_or_init(|| {
            Constants::of_forms(forms, omega)
                .expect("brackets of an algebra's forms are sums of them")
        })
    }
}

/// All of them.
pub fn known() -> &'static [Known] {
    static KNOWN: LazyLock<Vec<Known>> = LazyLock::new(|| {
        let mut algebras = vec![
            rotations::algebra(),
            euclidean::algebra(),
            two_rotations::algebra(),
        ];
        algebras.extend(symplectic::algebras());
        let known = algebras.into_iter().map(|algebra| Known {
            algebra,
            constants: OnceLock::new(),
        });
        known.collect()
    });
    &KNOWN
}
