//! Periodic orbits: Φᴺ(x) = x with N steps of T/N, by Newton's method with invariants held, and what neighbours do after a turn.
//!
//! The unknowns are x and T, or x alone where the period is held. Equations are those of the closing, one that holds the phase, and
//! one for each invariant that is held. The least step is taken that makes the sum of their squares least. Singular values of
//! symmetries do not count: of a family of orbits one that is near is found.
//!
//! A point that rests closes after any time, and every point after none: they are no orbits, and are refused.
//!
//! Tangents are carried by the exact monodromy M = DΦᴺ. Its kernels M v = v and wᵀM = wᵀ are those of the time and
//! of the integrals. Between them are left the multipliers of the reduced motion.
//!
//! - `equations`, `newton`: the bordered equations, and their corrections.
//! - `multipliers`, `linear`: the reduced motion; singular values and eigenvalues of small matrices.
//! - `family`: orbits along the energy, the period or a parameter.
//! - `rest`, `leaf`, `units`: equilibria, the linearized motion in their leaf, in units of that motion.

mod equations;
mod error;
mod family;
mod leaf;
mod linear;
mod multipliers;
mod newton;
mod rest;
mod units;

use leafwise_scene::compose::ComposedRun;

use equations::{AfterTurn, Equations, Invariants, Turns, largest};
pub use error::OrbitError;
pub use family::follow;
pub use family::types::{Along, Ends, FamilyOrbit, Following, Mark, OrbitFamily};
pub use leaf::{NoEigenvalues, Verdict};
pub use linear::Complex;
use multipliers::{Kernel, Multipliers};
use newton::{Corrected, corrected, length};
pub use rest::{Rest, RestError, rest};

/// A closure, over the size of the state, that whole corrections alone make better.
const NEAR: f64 = 1e-10;

/// Singular values of the bordered system that count, over the largest.
const PART: f64 = 1e-11;

/// A multiplier off the unit circle by more is that of an unstable orbit.
const STABLE: f64 = 1e-6;

/// The closure, over the size of the state, that is an orbit's.
const CLOSED: f64 = 1e-9;

/// The closure of an orbit is smaller than this part of how far it moves.
const MOVED: f64 = 1e-3;

/// A period that falls below this part of the first one falls to 0.
const SHRUNK: f64 = 1e-3;

/// A state that moves less than this part of what it moved at first has come to rest.
const RESTS: f64 = 1e-6;

/// Turns that are looked for in one period, at most.
const TURNS: u64 = 12;

/// After a part of the period a state that is nearer to the first one than this part of how far it moves may be back.
const BACK: f64 = 1e-2;

/// The quantity beside Casimirs that is held while an orbit is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// The energy: the period is found.
    Energy,
    /// The period: the energy is found.
    Period,
}

/// A closed orbit.
#[derive(Clone, Debug)]
pub struct PeriodicOrbit {
    /// A state on it.
    pub state: Vec<f64>,
    /// T.
    pub period: f64,
    /// H on it.
    pub energy: f64,
    /// N.
    pub steps: u64,
    /// Units of the coordinates, as large as these are.
    units: Vec<f64>,
    /// Turns of this orbit in the period that was looked for: more than 1 where that is a multiple of its own.
    pub turns: u64,
    /// max |Φᴺ(x) − x|.
    pub closure: f64,
    /// Newton steps that were made.
    pub iterations: usize,
    /// Multipliers that are 1 by the time and the integrals.
    pub trivial: usize,
    /// Which part of M the others are of.
    kernel: Kernel,
    /// All others, the largest first.
    pub multipliers: Vec<Complex>,
    /// max |μ_k μ_{m+1−k} − 1| of multipliers by size: they come in pairs.
    pub pairing: f64,
}

impl PeriodicOrbit {
    /// Whether no multiplier is off the unit circle.
    pub fn is_stable(&self) -> bool {
        self.multipliers
            .iter()
            .all(|of| of.modulus() <= 1.0 + STABLE)
    }
}

/// Closes an orbit near a run's initial state and a period, in so many steps. Where the period is several turns of a shorter orbit,
/// that one is found, in as many times fewer steps.
///
/// # Errors
/// [`OrbitError`].
pub fn close(
    run: &ComposedRun,
    (period, steps): (f64, u64),
    hold: Hold,
) -> Result<PeriodicOrbit, OrbitError> {
    refuse(run, (period, steps))?;
    let mut orbit = closed(run, &run.plan.initial, (period, steps), hold)?;
    while let Some(shorter) = of_one_turn(run, &orbit, hold) {
        orbit = shorter;
    }
    Ok(orbit)
}

/// The orbit that is passed several times in the period of this one.
fn of_one_turn(run: &ComposedRun, orbit: &PeriodicOrbit, hold: Hold) -> Option<PeriodicOrbit> {
    let of = |steps: u64| Turns::of(run, steps, orbit.units.clone());
    let own = of(orbit.steps);
    let x = own.inside(&orbit.state);
    let size = size_of(&x);
    let moved = own.moved(&x, orbit.period).ok()?;
    (2..=TURNS.min(orbit.steps)).find_map(|count| {
        let steps = orbit.steps.div_ceil(count);
        let part = of(steps);
        let period = orbit.period / count as f64;
        let near = part.gap_after(&x, period, steps).ok()?;
        if near > BACK * moved {
            return None;
        }
        // Near a bifurcation an orbit of two turns nearly closes after one: it closes in these steps as the shorter one does, or is another.
        let all = (orbit.period, steps * count);
        let whole = closed(run, &orbit.state, all, hold).ok()?;
        let own = of(whole.steps);
        let x = own.inside(&whole.state);
        let gap = own.gap_after(&x, whole.period, steps).ok()?;
        if gap > CLOSED * size {
            return None;
        }
        let all = (whole.period / count as f64, steps);
        let one = closed(run, &whole.state, all, hold).ok()?;
        Some(PeriodicOrbit {
            turns: count * orbit.turns,
            iterations: orbit.iterations + whole.iterations + one.iterations,
            ..one
        })
    })
}

/// The largest coordinate in its units, and 1 at least.
fn size_of(x: &[f64]) -> f64 {
    x.iter().fold(1.0_f64, |most, x| most.max(x.abs()))
}

/// Closes an orbit near a state.
fn closed(
    run: &ComposedRun,
    initial: &[f64],
    (period, steps): (f64, u64),
    hold: Hold,
) -> Result<PeriodicOrbit, OrbitError> {
    let turns = Turns::in_units(run, steps, (initial, period))?;
    let invariants = Invariants(run);
    let (d, first, initial) = (initial.len(), period, turns.inside(initial));
    let moved_at_first = turns.moved(&initial, first)?;
    let near = NEAR * size_of(&initial);
    let equations = Equations {
        held: invariants.values(&initial, &turns)?,
        turns,
        invariants,
        holds_energy: hold == Hold::Energy,
        finds_period: hold == Hold::Energy,
        period_unit: first,
        moving: None,
        border: None,
    };
    let unknowns = [&initial[..], &[1.0]].concat();
    let found = corrected(
        unknowns,
        (PART, near),
        |u| equations.at(u),
        |u, at| equations.columns(u, at),
        |u, iterations| match u[d] < SHRUNK {
            true => Err(OrbitError::Shrinks {
                iterations,
                first,
                period: u[d] * first,
            }),
            false => Ok(()),
        },
    )?;
    let casimirs = run.system.casimir_names();
    judged(&equations, &found, moved_at_first, (&casimirs, None)).map(|(orbit, _)| orbit)
}

/// The orbit that corrections came to, if it is one. Its multipliers are those of a kernel, where that is known.
fn judged(
    equations: &Equations<'_>,
    found: &Corrected<AfterTurn>,
    moved_at_first: f64,
    (casimirs, kernel): (&[&str], Option<Kernel>),
) -> Result<(PeriodicOrbit, f64), OrbitError> {
    let (x, period, turns) = equations.parts(&found.unknowns);
    let iterations = found.corrections;
    let gap = largest(&found.at.found.gap);
    let closure = largest(&turns.outside(&found.at.found.gap));
    if gap.is_nan() || gap > CLOSED * size_of(x) {
        return Err(OrbitError::NotClosed {
            iterations,
            closure,
        });
    }
    let moved = turns.moved(x, period)?;
    if gap >= MOVED * moved || moved < RESTS * moved_at_first {
        return Err(OrbitError::Equilibrium { iterations, moved });
    }
    let now = equations.invariants.values(x, &turns)?;
    let gradients = equations.invariants.gradients(x, &turns)?;
    let pairs = now.iter().zip(&equations.held).zip(gradients);
    for (at, ((now, held), gradient)) in pairs.enumerate() {
        let off = (now - held).abs() / held.abs().max(length(&gradient)).max(f64::MIN_POSITIVE);
        if at == 0 && !equations.holds_energy || off <= CLOSED {
            continue;
        }
        let name = match at {
            0 => "energy".to_owned(),
            _ => format!("Casimir {}", casimirs[at - 1]),
        };
        return Err(OrbitError::NotHeld { name, off });
    }
    let monodromy = &found.at.found.monodromy;
    let known = kernel.and_then(|kernel| Multipliers::with(monodromy, kernel));
    let multipliers = match known {
        Some(known) => known,
        None => Multipliers::of(monodromy)
            .map_err(|growth| OrbitError::Multipliers { closure, growth })?,
    };
    let others = &multipliers.others;
    let opposite = others.iter().zip(others.iter().rev());
    let products = opposite.map(|(a, b)| (a.modulus() * b.modulus() - 1.0).abs());
    let orbit = PeriodicOrbit {
        pairing: products.fold(0.0, f64::max),
        state: turns.outside(x),
        period,
        energy: now[0],
        steps: turns.steps,
        units: turns.units,
        turns: 1,
        closure,
        iterations,
        trivial: multipliers.trivial,
        kernel: multipliers.kernel,
        multipliers: multipliers.others,
    };
    Ok((orbit, moved))
}

fn refuse(run: &ComposedRun, (period, steps): (f64, u64)) -> Result<(), OrbitError> {
    if run.system.has_forces() {
        return Err(OrbitError::NotOffered {
            message: "a motion with forces or friction does not keep the energy, which every periodic orbit here must",
            help: run.without_forces().into(),
        });
    }
    let (message, help) = if run.method.lattice().is_some() {
        (
            "the search for periodic orbits does not support long lattices",
            "shorten the lattice",
        )
    } else if run.method.noise().is_some() {
        (
            "a motion with noise has no periodic orbits",
            "remove the noise",
        )
    } else if run.plan.events.act.is_some() {
        (
            "events of this scene change the state, and orbits are closed by the method's steps alone",
            "remove `set` from run.section",
        )
    } else if run.table_step().is_some() {
        (
            "the generating function holds for one time step alone, and an orbit is closed by steps of a part of its period",
            "close the orbit of the scene whose steps the table puts together",
        )
    } else if run.is_extended() {
        (
            "the search for periodic orbits does not support an H that names the time, a pace, parameters of sites or a contact bracket",
            "close the orbit of a system without them",
        )
    } else if steps == 0 || !(period > 0.0 && period.is_finite()) {
        (
            "an orbit needs steps over a positive time, and there are none",
            "give a positive period and a number of steps",
        )
    } else {
        return Ok(());
    };
    Err(OrbitError::NotOffered {
        message,
        help: help.into(),
    })
}
