//! Sublattices of long lattices: each flow is a sweep over all sites, over no time at those of other colours.

use std::collections::BTreeSet;
use std::sync::Arc;

use leafwise_core::BuildError;
use leafwise_core::lattice::{
    Cells, LatticeGeometry, LatticeMap, LatticeProgram, LatticeSlopes, LatticeSource, Proxy,
    StageBuilder,
};
use leafwise_core::part::PartParameters;
use leafwise_expression::{Arithmetic, Graph, StepSize};

use super::colours::{Bond, Colouring};
use super::spins::Spins;
use super::{INFO, describe, properties, unfit};
use crate::lattice::{LatticeSplitting, Shared};

/// Fields that programs over the same state may write behind it and the sum of its changes.
const OTHERS: usize = 2;

pub(super) fn build(
    source: &dyn LatticeSource,
    parameters: &PartParameters,
) -> Result<LatticeMap, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    let geometry = source.geometry();
    let cells = Cells::new(geometry.clone(), 1)
        .ok_or_else(|| unfit("a family of the lattice has no sites"))?;
    let looks = source.reach()?.of_times(1, geometry.ends());
    let (proxy_cells, width) = cells.proxy(looks)?;
    let proxy = source.write_out(proxy_cells.sites())?;
    let system = proxy.formulas(INFO.name)?;
    let spins = Spins::of(system)?;
    let kinds = Kinds::of(&spins, proxy_cells.sites())?;
    let colouring = Colouring::of(geometry, kinds.families.len(), &kinds.bonds).ok_or_else(|| {
        unfit(
            "its spins do not divide into a few sublattices without couplings inside them: try axes of even length, or \
             boundary = \"open\"",
        )
    })?;

    let dimension = proxy_cells.rows().dimension();
    let mut builder = StageBuilder::new(dimension);
    let (state, x) = builder.unwritten();
    let (sum, sums) = builder.unwritten();
    for _ in 0..OTHERS {
        builder.unwritten();
    }
    let masks: Vec<_> = (0..colouring.count).map(|_| builder.unwritten()).collect();
    let (epsilon, h) = (
        builder.graph.step_size(StepSize::Epsilon),
        builder.graph.step_size(StepSize::H),
    );
    let whole = builder.graph.multiply(&epsilon, &h);
    for (_, mask) in &masks {
        let graph = &mut builder.graph;
        let mut own = |graph: &mut Graph, at: usize| {
            let is_moved = &mask[spins.all[at].places[0]];
            Some(graph.multiply(&whole, is_moved))
        };
        let increments = spins.increments(graph, &x, &mut own)?;
        let (mut moved, mut added) = (vec![None; dimension], vec![None; dimension]);
        for (spin, increment) in spins.all.iter().zip(increments) {
            let is_moved = &mask[spin.places[0]];
            for (place, change) in spin.places.into_iter().zip(increment.into_iter().flatten()) {
                let change = graph.multiply(is_moved, &change);
                moved[place] = Some(graph.add(&x[place], &change));
                added[place] = Some(graph.add(&sums[place], &change));
            }
        }
        graph.unless_refused(())?;
        builder.update(state, moved);
        builder.update(sum, added);
        builder.finish_stage_apart();
    }
    let (written, count) = (
        Proxy {
            geometry: proxy_cells.rows(),
            width,
        },
        system.parameters().len(),
    );
    let program = Arc::new(LatticeProgram::compile(
        cells.rows(),
        written,
        &builder,
        count,
    )?);
    let slopes = LatticeSlopes::new(&program, written, builder.without(sum), count);
    let values = kinds.masks(&colouring, geometry);
    let constants = masks.into_iter().map(|(field, _)| field).zip(values);
    let splitting = LatticeSplitting {
        shared: Arc::new(Shared {
            order: (0..colouring.count).collect(),
            described: describe(colouring.count),
            structure: properties().structure,
            constants: Arc::new(constants.collect()),
            cells,
            slopes: Arc::new(slopes),
            program,
            state,
            sum,
            proxy_cells,
        }),
    };
    Ok(splitting.into())
}

/// Spins of a lattice by the families that hold their components.
struct Kinds {
    families: Vec<[usize; 3]>,
    bonds: BTreeSet<Bond>,
}

impl Kinds {
    fn of(spins: &Spins<'_>, proxy: &LatticeGeometry) -> Result<Self, BuildError> {
        let mut families: Vec<[usize; 3]> = Vec::new();
        let mut own = Vec::with_capacity(spins.all.len());
        let mut owner = vec![None; proxy.dimension()];
        for (at, spin) in spins.all.iter().enumerate() {
            let located = spin.places.map(|place| proxy.locate(place));
            let site = located[0].1;
            if located.iter().any(|(_, other)| *other != site) {
                return Err(unfit("the components of a spin are of different sites"));
            }
            let kind = located.map(|(family, _)| family);
            let known = families.iter().position(|other| *other == kind);
            let number = known.unwrap_or(families.len());
            if known.is_none() {
                families.push(kind);
            }
            own.push((number, site));
            for place in spin.places {
                owner[place] = Some(at);
            }
        }
        let mut bonds = BTreeSet::new();
        for ((kind, site), reads) in own.iter().zip(&spins.reads) {
            for other in reads.iter().filter_map(|place| owner[*place]) {
                let (other, at) = own[other];
                bonds.insert((*kind, other, proxy.shift(*site, at)));
            }
        }
        Ok(Self { families, bonds })
    }

    /// For each colour 1 at the coordinates of its spins, 0 at all others.
    fn masks(&self, colouring: &Colouring, geometry: &LatticeGeometry) -> Vec<Vec<f64>> {
        let mut masks = vec![vec![0.0; geometry.dimension()]; colouring.count];
        let offsets = geometry.offsets();
        for (kind, families) in self.families.iter().enumerate() {
            for family in families {
                for site in 0..geometry.families[*family].1 {
                    let colour = colouring.of_spin(kind, geometry.place(site));
                    masks[colour][offsets[*family] + site] = 1.0;
                }
            }
        }
        masks
    }
}
