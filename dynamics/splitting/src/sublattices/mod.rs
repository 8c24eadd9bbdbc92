//! Damped spins, sublattice after sublattice.
//!
//! Where no spin of a sublattice is in the field of another, all of them turn and fall into fields at rest. Their motion has a
//! closed form, along the leaves. Strang's product over the sublattices is explicit, of order 2 and self-adjoint. Without
//! damping it keeps H, and is no Poisson map: spins at rest in a flow do not feel that others turn about them.
//!
//! Literature on even and odd sites, and on more sublattices:
//!
//! - Frank, Huang, Leimkuhler, *Geometric integrators for classical spin systems*, Journal of Computational Physics 133 (1997);
//! - Krech, Bunker, Landau, *Fast spin dynamics algorithms for classical spin systems*, Computer Physics Communications 111
//!   (1998).
//!
//! Modules:
//!
//! - `flow`: the damped precession of one spin.
//! - `spins`: which systems are of spins.
//! - `colours`: sublattices.
//! - `written`: steps of systems that are written out.
//! - `lattice`: sweeps over long lattices.

mod colours;
mod flow;
mod lattice;
mod spins;
mod written;

use leafwise_core::part::{Elsewhere, PartInfo, PartKind};
use leafwise_core::registry::StepperPart;
use leafwise_core::solver::{MapProperties, Structure};
use leafwise_core::{BuildError, MotionClass};

static INFO: PartInfo = PartInfo {
    name: "sublattices",
    summary: "exact flows of damped spins in the field of the others, sublattice after sublattice",
    declares: "order 2; self-adjoint; explicit; leaf-preserving, every length of a spin to round-off, and no Poisson map; \
               without damping H is kept to round-off",
    domain: "spins, so(3)* for each, with H linear in every one: exchange, fields, not anisotropies; damping of one rate a \
             spin",
    literature: "Frank, Huang, Leimkuhler, Geometric integrators for classical spin systems, J. Comput. Phys. 133 (1997); \
                 Krech, Bunker, Landau, Fast spin dynamics algorithms for classical spin systems, Comput. Phys. Commun. \
                 111 (1998)",
    takes: MotionClass::OnLeaves,
    elsewhere: Some(Elsewhere {
        names: &[
            "checkerboard",
            "even-odd",
            "odd-even",
            "staggered-red-black",
        ],
        is: "the product over sublattices of spins",
    }),
    ..PartInfo::of(PartKind::Stepper)
};

fn unfit(reason: impl Into<String>) -> BuildError {
    BuildError::DoesNotFit {
        part: INFO.name,
        reason: reason.into(),
    }
}

/// Order, structure and symmetry of the product, with damping or without.
fn properties() -> MapProperties {
    MapProperties {
        order: 2,
        structure: Structure::Leaves,
        self_adjoint: Some(true),
    }
}

fn describe(count: usize) -> String {
    format!("{} of {count} colours", INFO.name)
}

leafwise_core::built_in!(StepperPart::new(&INFO, written::build).with_sweeps(lattice::build));
