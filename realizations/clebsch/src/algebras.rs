//! The algebras that are known by their structure constants, one a file.

pub mod euclidean;
pub mod rotations;
pub mod symplectic;
pub mod two_rotations;

use std::sync::LazyLock;

use crate::algebra::Algebra;
use crate::constants::Constants;

/// An algebra with its structure constants.
#[derive(Debug)]
pub struct Known {
    /// Its forms.
    pub algebra: Algebra,
    /// Its structure constants.
    pub constants: Constants,
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
            constants: Constants::of_forms(&algebra.forms, &algebra.omega)
                .expect("brackets of an algebra's forms are sums of them"),
            algebra,
        });
        known.collect()
    });
    &KNOWN
}
