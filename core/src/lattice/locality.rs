//! Which lattice is written out in the place of a long one.

use leafwise_expression::syntax::AXES;

use super::geometry::{LatticeGeometry, PerAxis, SHORTEST};
use super::source::LatticeSource;
use crate::error::BuildError;

/// Largest number of coordinates of a lattice that is written out, in the place of a longer one or whole where it is
/// no longer. It holds for code that goes through tensor and dH once, which takes minutes to form. Code that goes
/// through them more often takes more for every coordinate.
const MOST_COORDINATES: usize = 8192;

/// Proxy lattice for code that goes through tensor and dH `times` times, and the number of sites at an open end that
/// have code of their own there. The true lattice where it is no longer.
///
/// # Errors
/// [`BuildError::NotLocal`] where that takes too much memory; those of [`LatticeSource::reach`].
pub fn proxy_of(
    source: &dyn LatticeSource,
    times: usize,
) -> Result<(LatticeGeometry, PerAxis<usize>), BuildError> {
    let geometry = source.geometry();
    let reach = source.reach()?;
    let looks = reach.of_times(times, geometry.ends());
    let short = (geometry.length() > SHORTEST).then(|| geometry.proxy(looks));
    let (proxy, width) = short
        .flatten()
        .unwrap_or_else(|| (geometry.clone(), [0; AXES]));
    check_room(&proxy, looks, times)?;
    Ok((proxy, width))
}

/// Refuses to write out too long a lattice for code that looks `reach` sites away, through tensor and dH so many times.
///
/// # Errors
/// [`BuildError::NotLocal`].
pub(super) fn check_room(
    written: &LatticeGeometry,
    reach: PerAxis<usize>,
    times: usize,
) -> Result<(), BuildError> {
    let (coordinates, most) = (written.dimension(), MOST_COORDINATES / times.max(1));
    if coordinates <= most {
        return Ok(());
    }
    Err(BuildError::NotLocal {
        reach: reach.into_iter().max().unwrap_or(0),
        coordinates,
        most,
        is_of_order: times > 1,
    })
}
