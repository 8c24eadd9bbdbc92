//! The lattice of a scene: its families, axes and ends.

use leafwise_core::lattice::{Axis, LatticeGeometry};

use super::Refusal;
use crate::document::{Boundary, SceneDocument};

/// The number of coordinates that move, with the families as long as those of `lattice`.
pub(super) fn moving(document: &SceneDocument, lattice: &LatticeGeometry) -> usize {
    let system = &document.system;
    let families = lattice.families[..system.moving().len()].iter();
    system.variables.len() + families.map(|family| family.1).sum::<usize>()
}

/// The families of a scene at their true lengths.
pub(super) fn geometry(document: &SceneDocument) -> LatticeGeometry {
    let system = &document.system;
    let periodic = |axis: usize| system.boundary_along(axis) != Boundary::Open;
    let families = system.families.iter();
    match system.axes[..] {
        [] => {
            let families = families.map(|(name, length)| (name.value.clone(), length.value));
            LatticeGeometry::chain(families.collect(), periodic(0))
                .with_site_names(system.site_names.clone())
        }
        _ => {
            let axes = system.axes.iter().enumerate();
            let axes = axes.map(|(axis, length)| Axis {
                length: *length,
                periodic: periodic(axis),
            });
            let names = families.map(|(name, _)| name.value.clone());
            LatticeGeometry::along(names, axes.collect())
        }
    }
}

/// A scene's lattice with a single site.
pub(super) fn one_site(document: &SceneDocument) -> LatticeGeometry {
    let whole = geometry(document);
    let axes = whole.axes.iter().map(|axis| Axis { length: 1, ..*axis });
    LatticeGeometry::along(
        whole.families.iter().map(|family| family.0.clone()),
        axes.collect(),
    )
}

/// On a ring every family has the same length: a site index counts all of them.
pub(super) fn check_lengths(document: &SceneDocument) -> Result<(), Refusal> {
    let system = &document.system;
    let is_open = system.boundary_along(0) == Boundary::Open;
    let Some(((first, length), rest)) = system.families.split_first() else {
        return Ok(());
    };
    let Some((other, differs)) = rest.iter().find(|(_, l)| l.value != length.value) else {
        return Ok(());
    };
    if is_open {
        return Ok(());
    }
    Err(Box::new(document.diagnostic(
        &differs.place(),
        format!(
            "on a periodic boundary all families have one length, and `{}` has {} sites where \
             `{}` has {}",
            other.value, differs.value, first.value, length.value
        ),
        "another length",
        Some("make them equal, or set boundary = \"open\"".to_owned()),
    )))
}
