//! How far a step on many coordinates is from a Poisson map, along a few directions.
//!
//! A Poisson map Φ takes leaves to leaves, and their symplectic forms to each other. For u = Πa and v = Πb there are
//! covectors with DΦ u = Π′a′ and DΦ v = Π′b′ at the end. Then a′·Π′b′ = a·Πb. So a few random covectors tell a defect
//! from none, by derivatives along as many directions. All entries of DΦ Π DΦᵀ − Π∘Φ take one for each coordinate.

use nalgebra::{DMatrix, DVector};

use super::differences::jacobian_by_differences;
use super::{one_step, round_off};
use crate::error::StepError;
use crate::random::Random;
use crate::solver::Stepper;
use crate::system::{Entries, TensorMatrix};

/// The number of coordinates up to which every entry of a defect is measured.
pub const MOST_MEASURED: usize = 256;

/// The number of random covectors.
pub const COVECTORS: usize = 4;

/// The most coordinates that the tensor couples to one another.
const MOST_COUPLED: usize = 32;

/// Singular values below this part of the largest are those of Casimirs.
const OF_CASIMIRS: f64 = 1e-8;

/// The seed of the covectors.
const SEED: u64 = 42;

/// The least step of differences along a direction.
const LEAST_STEP: f64 = 1.0 / 1024.0;

/// A defect along directions: what is left of u_a·a_b and of DΦ u beside leaves, with bounds on round-off and on the errors
/// of differences in the same units.
pub(super) struct AlongDirections {
    pub(super) defect: DMatrix<f64>,
    pub(super) bounds: DMatrix<f64>,
    pub(super) floor: DMatrix<f64>,
    pub(super) next: Vec<f64>,
}

/// The defect of a step from x; `None` where the tensor couples too many coordinates to one
/// another.
///
/// # Errors
/// The stepper's [`StepError`].
pub(super) fn sample(
    stepper: &mut dyn Stepper,
    x: &[f64],
    tensor: &mut TensorMatrix,
) -> Result<Option<AlongDirections>, StepError> {
    let d = x.len();
    let mut increment = vec![0.0; d];
    one_step::increment(stepper, x, &mut increment)?;
    let next: Vec<f64> = x.iter().zip(&increment).map(|(x, i)| x + i).collect();
    let (before, after) = (tensor.entries_at(x)?, tensor.entries_at(&next)?);
    let sizes = round_off::sizes(x);
    let Some(leaves) = Leaves::new(&after, &sizes) else {
        return Ok(None);
    };
    let (mut covectors, mut images) = (Vec::new(), Vec::new());
    for own in 0..COVECTORS {
        let mut random = Random::new(SEED, 0, own as u32);
        let covector = sizes.iter().map(|size| (random.uniform() - 0.5) / size);
        let covector = DVector::from_iterator(d, covector);
        let direction = applied(&before, &covector);
        let longest = (direction.iter().zip(&sizes)).fold(0.0_f64, |m, (u, s)| m.max(u.abs() / s));
        if longest == 0.0 {
            return Ok(None);
        }
        let (covector, direction) = (covector / longest, direction / longest);
        let image = along(stepper, x, direction.as_slice())?;
        images.push(leaves.image(image));
        covectors.push((covector, direction));
    }
    let mut defect = DMatrix::zeros(COVECTORS, COVECTORS + d);
    let (mut bounds, mut floor) = (defect.clone(), defect.clone());
    for a in 0..COVECTORS {
        let own = &images[a];
        for b in (0..COVECTORS).filter(|b| *b != a) {
            let other = &images[b];
            let before = covectors[a].0.dot(&covectors[b].1);
            let sizes = covectors[a].0.abs().dot(&covectors[b].1.abs());
            defect[(a, b)] = own.covector.dot(&other.direction) - before;
            let size = |a: &Image, b: &Image| a.covector.abs().dot(&b.direction.abs());
            bounds[(a, b)] = size(own, other) + size(other, own) + sizes;
            floor[(a, b)] =
                own.error.dot(&other.covector.abs()) + other.error.dot(&own.covector.abs());
        }
        for at in 0..d {
            defect[(a, COVECTORS + at)] = own.beside[at];
            bounds[(a, COVECTORS + at)] = own.sizes[at];
            floor[(a, COVECTORS + at)] = 2.0 * own.error_sizes[at];
        }
    }
    Ok(Some(AlongDirections {
        defect,
        bounds,
        floor,
        next,
    }))
}

/// max(|x_i|, |Φ_i|, |Σ_k DΦ_ik σ_k s_k|) over a few random signs σ. It is what round-off of coordinates of sizes s is
/// multiplied by on its way into each, but for the square root of their number.
///
/// # Errors
/// The stepper's [`StepError`].
pub(super) fn sizes_along(
    stepper: &mut dyn Stepper,
    from: &[f64],
    (x, y): (&[f64], &[f64]),
) -> Result<Vec<f64>, StepError> {
    let ends = x.iter().zip(y);
    let mut sizes: Vec<f64> = ends.map(|(x, y)| x.abs().max(y.abs())).collect();
    for own in 0..COVECTORS {
        let mut random = Random::new(SEED, 1, own as u32);
        let signs = x
            .iter()
            .map(|x| x.abs() * (random.uniform() - 0.5).signum());
        let signs: Vec<f64> = signs.collect();
        let [moved, _] = along(stepper, from, &signs)?;
        for (size, moved) in sizes.iter_mut().zip(moved.iter()) {
            *size = size.max(moved.abs());
        }
    }
    Ok(sizes)
}

/// DΦ u by differences of cold steps, and what it may be wrong by.
fn along(
    stepper: &mut dyn Stepper,
    x: &[f64],
    direction: &[f64],
) -> Result<[DVector<f64>; 2], StepError> {
    let d = x.len();
    let mut place = vec![0.0; d];
    let change = jacobian_by_differences(&[0.0], d, |at, out| {
        for ((place, x), u) in place.iter_mut().zip(x).zip(direction) {
            *place = x + at[0] * u;
        }
        one_step::increment(stepper, &place, out)
    })?;
    let direction = DVector::from_column_slice(direction);
    let (moved, mut error) = (
        change.jacobian.column(0).clone_owned(),
        change.error.column(0).clone_owned(),
    );
    // Round-off of the places themselves, where they are no multiple of the step apart.
    error += moved.abs() * (4.0 * f64::EPSILON / LEAST_STEP);
    Ok([direction + moved, error])
}

/// Πv.
fn applied(tensor: &Entries, v: &DVector<f64>) -> DVector<f64> {
    let mut result = DVector::zeros(v.len());
    for (column, v) in tensor.iter().zip(v.iter()) {
        column.iter().for_each(|(i, entry)| result[*i] += entry * v);
    }
    result
}

/// Coordinates that a tensor couples, its entries in units of theirs, their pseudo-inverse, and whether they have a Casimir.
struct CoupledBlock {
    members: Vec<usize>,
    tensor: DMatrix<f64>,
    inverse: DMatrix<f64>,
    has_casimir: bool,
}

/// The blocks of coordinates that a tensor couples, with pseudo-inverses in units of the coordinates.
struct Leaves {
    blocks: Vec<CoupledBlock>,
    sizes: Vec<f64>,
}

/// DΦ u: a vector of the leaf with its covector, and what stands beside the leaf.
struct Image {
    direction: DVector<f64>,
    covector: DVector<f64>,
    error: DVector<f64>,
    beside: DVector<f64>,
    /// The largest of a block, and the same of errors, in each coordinate's own units.
    sizes: DVector<f64>,
    error_sizes: DVector<f64>,
}

impl Leaves {
    fn new(tensor: &Entries, sizes: &[f64]) -> Option<Self> {
        let d = sizes.len();
        let mut block_of: Vec<Option<usize>> = vec![None; d];
        let mut blocks = Vec::new();
        for start in 0..d {
            if block_of[start].is_some() {
                continue;
            }
            let mut members = vec![start];
            block_of[start] = Some(blocks.len());
            let mut next = 0;
            while let Some(&at) = members.get(next) {
                for (other, value) in &tensor[at] {
                    if block_of[*other].is_none() && *value != 0.0 {
                        block_of[*other] = Some(blocks.len());
                        members.push(*other);
                    }
                }
                next += 1;
            }
            if members.len() > MOST_COUPLED {
                return None;
            }
            let mut own = DMatrix::zeros(members.len(), members.len());
            for (at, j) in members.iter().enumerate() {
                for (i, value) in &tensor[*j] {
                    if let Some(row) = members.iter().position(|member| member == i) {
                        own[(row, at)] = value / (sizes[*i] * sizes[*j]);
                    }
                }
            }
            let decomposed = own.clone().svd(true, true);
            let least = OF_CASIMIRS * decomposed.singular_values.max();
            let least = least.max(f64::MIN_POSITIVE);
            blocks.push(CoupledBlock {
                has_casimir: decomposed.rank(least) < members.len(),
                inverse: decomposed.pseudo_inverse(least).ok()?,
                tensor: own,
                members,
            });
        }
        Some(Self {
            blocks,
            sizes: sizes.to_vec(),
        })
    }

    fn image(&self, [direction, error]: [DVector<f64>; 2]) -> Image {
        let zeros = DVector::zeros(direction.len());
        let mut image = Image {
            covector: zeros.clone(),
            beside: zeros.clone(),
            sizes: zeros.clone(),
            error_sizes: zeros,
            direction,
            error,
        };
        for block in &self.blocks {
            let members = &block.members;
            let scaled = |vector: &DVector<f64>| {
                let own = members.iter().map(|at| vector[*at] / self.sizes[*at]);
                DVector::from_iterator(members.len(), own)
            };
            let (direction, error) = (scaled(&image.direction), scaled(&image.error));
            let covector = &block.inverse * &direction;
            let beside = &direction - &block.tensor * &covector;
            for (own, at) in members.iter().enumerate() {
                let size = self.sizes[*at];
                image.covector[*at] = covector[own] / size;
                // Where there is no Casimir, nothing stands beside the leaf.
                if !block.has_casimir {
                    continue;
                }
                image.beside[*at] = beside[own] * size;
                image.sizes[*at] = direction.amax() * size;
                image.error_sizes[*at] = error.sum() * size;
            }
        }
        image
    }
}
