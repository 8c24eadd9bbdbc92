//! Whole states among the samples of a run, some of them.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use leafwise_scene::compose::ComposedRun;

use super::drive::Session;
use super::error::RunError;
use super::states::{FILE, HEADER};

/// The most states that are read.
const MOST_STATES: u64 = 64;

/// The most numbers of them together.
const MOST_NUMBERS: u64 = 1 << 23;

/// Some recorded states in the order of the state, each with its time, the first and the last among them; nothing where
/// samples do not hold whole states. States that are not finite are left out.
pub(super) fn whole_states(
    run: &ComposedRun,
    session: &Session<'_>,
) -> Result<Vec<(f64, Vec<f64>)>, RunError> {
    let width = run.own(&run.plan.initial).len();
    let states = &run.plan.states;
    // No coordinate is recorded twice.
    if states.width() != width || width == 0 {
        return Ok(Vec::new());
    }
    let count = session.samples().count();
    let most = (MOST_NUMBERS / width as u64).clamp(2, MOST_STATES);
    let stride = count.saturating_sub(1).div_ceil(most - 1).max(1);
    let rows = session
        .samples()
        .read(usize::try_from(stride).unwrap_or(usize::MAX))?;
    let mut file = match session.directory() {
        Some(directory) if !session.has_states_in_samples() => {
            let path = directory.join(FILE);
            Some((File::open(&path).map_err(RunError::io(&path))?, path))
        }
        _ => None,
    };
    let mut kept = Vec::with_capacity(rows.len());
    let mut bytes = vec![0; 8 * width];
    for (k, row) in rows.iter().enumerate() {
        let recorded: Vec<f64> = match &mut file {
            None => row.iter().skip(1).take(width).copied().collect(),
            Some((file, path)) => {
                let sample = (k as u64 * stride).min(count.saturating_sub(1));
                let place = HEADER as u64 + sample * bytes.len() as u64;
                let read = file.seek(SeekFrom::Start(place));
                read.and_then(|_| file.read_exact(&mut bytes))
                    .map_err(RunError::io(&*path))?;
                let values = bytes.chunks_exact(8);
                values
                    .map(|value| f64::from_le_bytes(value.try_into().unwrap_or_default()))
                    .collect()
            }
        };
        if recorded.len() == width && recorded.iter().all(|value| value.is_finite()) {
            let mut state = vec![0.0; width];
            for (value, place) in recorded.into_iter().zip(states.coordinates()) {
                state[place] = value;
            }
            kept.push((row[0], state));
        }
    }
    Ok(kept)
}
