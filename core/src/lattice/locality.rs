//! How far the formulas of a lattice look.

use leafwise_expression::{Arithmetic, Graph, Kernel, Term};

use super::geometry::LatticeGeometry;
use super::source::LatticeSource;
use crate::error::BuildError;
use crate::system::SystemFormulas;

/// The longest reach that is looked for.
const LONGEST_REACH: usize = 16;

/// How many sites the tensor and dH together look to either side, at least 1; `None` for a lattice
/// that is too short to tell, of which every site is written out.
///
/// # Errors
/// [`BuildError::NotLocal`] when the Hamiltonian couples distant sites,
/// [`BuildError::NotHomogeneous`] when the tensor does not repeat from site to site.
pub fn local_reach(source: &dyn LatticeSource) -> Result<Option<usize>, BuildError> {
    let geometry = source.geometry();
    let mut trial = 9;
    loop {
        if geometry.length() <= trial {
            return Ok(None);
        }
        let proxy = geometry.resized(trial);
        let system = source.write_out(&proxy)?;
        system.without_forces("a long lattice")?;
        let formulas = system.formulas("a long lattice")?;
        check_homogeneous(formulas, &proxy)?;
        let reach = reach(formulas, &proxy)?;
        if 2 * reach + 1 < trial {
            return Ok(Some(reach));
        }
        if reach > LONGEST_REACH {
            return Err(BuildError::NotLocal { reach });
        }
        trial = 2 * trial + 1;
    }
}

/// Refuses a tensor whose entries change from one interior site to the next: one with a fixed site
/// such as `x[0],x[5]`, of which a template would make many.
fn check_homogeneous(
    system: &SystemFormulas,
    geometry: &LatticeGeometry,
) -> Result<(), BuildError> {
    let offsets = geometry.offsets();
    let length = geometry.length();
    let is_interior = |site: usize| geometry.periodic || (2..length - 3).contains(&site);
    let moved = |coordinate: usize| {
        let (family, site) = geometry.locate(coordinate);
        let next = (site + 1) % length;
        (next < geometry.families[family].1).then(|| offsets[family] + next)
    };
    let mut graph = Graph::new();
    for (&(a, b), entry) in system.tensor() {
        if !is_interior(geometry.locate(a).1) || !is_interior(geometry.locate(b).1) {
            continue;
        }
        let not_homogeneous = || BuildError::NotHomogeneous {
            first: geometry.name(a),
            second: geometry.name(b),
        };
        let (Some(c), Some(d)) = (moved(a), moved(b)) else {
            continue;
        };
        let here = entry.evaluate_in(&mut graph, &mut |graph, at| {
            Ok(graph.input(moved(at).unwrap_or(at)))
        })?;
        let there = system
            .tensor()
            .get(&(c.min(d), c.max(d)))
            .ok_or_else(not_homogeneous)?;
        let there = there.evaluate_in(&mut graph, &mut |graph, at| Ok(graph.input(at)))?;
        let there = if c < d { there } else { graph.negate(&there) };
        let difference = graph.subtract(&here, &there);
        if !graph.is_zero(&difference) {
            return Err(not_homogeneous());
        }
    }
    Ok(())
}

/// How far dH and the tensor's rows at the centre of a written-out lattice look.
fn reach(system: &SystemFormulas, geometry: &LatticeGeometry) -> Result<usize, BuildError> {
    let d = system.dimension();
    let centre = geometry.length() / 2;
    let offsets = geometry.offsets();
    let mut graph = Graph::new();
    let x: Vec<Term> = (0..d).map(|i| graph.input(i)).collect();
    let v: Vec<Term> = (d..2 * d).map(|i| graph.input(i)).collect();
    let energy = system
        .hamiltonian()
        .evaluate_in(&mut graph, &mut |_, at| Ok(x[at].clone()))?;
    let rows = system.apply_tensor(&mut graph, &x, &v)?;
    let mut reach = [0, 0];
    for (family, (_, length)) in geometry.families.iter().enumerate() {
        if centre >= *length {
            continue;
        }
        let coordinate = offsets[family] + centre;
        let slope = graph.derivative(&energy, coordinate)?;
        for (which, term) in [slope, rows[coordinate].clone()].into_iter().enumerate() {
            if graph.is_zero(&term) {
                continue;
            }
            for input in Kernel::compile_used(&graph, &[term], 0).1 {
                let (_, site) = geometry.locate(input % d);
                reach[which] = reach[which].max(geometry.shift(centre, site).unsigned_abs());
            }
        }
    }
    Ok((reach[0] + reach[1]).max(1))
}
