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

mod linear;

use leafwise_core::StepMap;
use leafwise_core::gradient::{GradientError, Plan, Trajectory};
use leafwise_core::solver::judge::larger;
use leafwise_scene::compose::ComposedRun;
use thiserror::Error;

pub use linear::Complex;
use linear::{Columns, SingularValues, eigenvalues};

/// Newton steps, at most.
const STEPS: usize = 40;

/// Halvings of one.
const HALVINGS: usize = 10;

/// A closure, over the size of the state, that whole corrections alone make better.
const NEAR: f64 = 1e-10;

/// Singular values of the bordered system that count, over the largest.
const PART: f64 = 1e-11;

/// Singular values of M − 1 that are taken for zeros, over its size. The first bound serves with which the multipliers add up to
/// the trace of M. Where neighbours part by much, as next to a mass, small values are no zeros.
const KERNEL: [f64; 4] = [1e-7, 1e-9, 1e-11, 1e-13];

/// How far that sum may be from the trace, relative.
const TRACE: f64 = 1e-5;

/// The part of a period by which its derivative is found.
const CHANGE: f64 = 1e-5;

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
    /// N.
    pub steps: u64,
    /// Turns of this orbit in the period that was looked for: more than 1 where that is a multiple of its own.
    pub turns: u64,
    /// max |Φᴺ(x) − x|.
    pub closure: f64,
    /// Newton steps that were made.
    pub iterations: usize,
    /// Multipliers that are 1 by the time and the integrals.
    pub trivial: usize,
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

/// Why no orbit is found.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OrbitError {
    /// A run that has none.
    #[error("{message}")]
    NotOffered {
        /// Reason.
        message: &'static str,
        /// A remedy.
        help: &'static str,
    },
    /// A step fails.
    #[error("the orbit cannot be followed: {0}")]
    Step(#[from] GradientError),
    /// Newton's method ends elsewhere.
    #[error(
        "no orbit closes near here: after {iterations} corrections the ends are {closure:.1e} apart"
    )]
    NotClosed {
        /// Corrections made.
        iterations: usize,
        /// max |Φᴺ(x) − x|.
        closure: f64,
    },
    /// The period falls to 0, after which every point is where it was.
    #[error(
        "no orbit closes near here: the period shrinks to zero, from {first} to {period:.1e} after {iterations} corrections"
    )]
    Shrinks {
        /// Corrections made.
        iterations: usize,
        /// The period at first.
        first: f64,
        /// The period at the end.
        period: f64,
    },
    /// The state rests.
    #[error(
        "no orbit closes near here: after {iterations} corrections the state is an equilibrium or next to one, that moves by {moved:.1e} in a period"
    )]
    Equilibrium {
        /// Corrections made.
        iterations: usize,
        /// max |x_k − x_0| over a turn.
        moved: f64,
    },
    /// The multipliers of an orbit cannot be told from round-off.
    #[error(
        "an orbit closes to {closure:.1e}, but its multipliers drown in round-off: a turn makes changes {growth:.1e} times as large"
    )]
    Multipliers {
        /// max |Φᴺ(x) − x|.
        closure: f64,
        /// The largest singular value of DΦᴺ − 1.
        growth: f64,
    },
    /// The energy or a Casimir is another one.
    #[error(
        "no orbit closes near here with the {name} held: of the one that closes it is {off:.1e} away"
    )]
    NotHeld {
        /// The invariant.
        name: String,
        /// How far its value is from the one that was to be held, relative.
        off: f64,
    },
}

/// The end of a turn.
struct AfterTurn {
    /// Φᴺ(x) − x.
    gap: Vec<f64>,
    /// Columns of DΦᴺ.
    monodromy: Columns,
}

/// Steps of one map.
struct Turns<'a> {
    map: &'a dyn StepMap,
    parameters: Vec<f64>,
    epsilon: f64,
    steps: u64,
}

impl<'a> Turns<'a> {
    fn of(run: &'a ComposedRun, steps: u64) -> Self {
        Self {
            map: run.method.map(),
            parameters: run.system.parameter_values(),
            epsilon: run.plan.epsilon,
            steps,
        }
    }

    fn trajectory(&self, period: f64) -> Trajectory<'_> {
        Trajectory {
            map: self.map,
            parameters: &self.parameters,
            epsilon: self.epsilon,
            h: period / (self.steps as f64 * self.epsilon),
            goes_on: &|| true,
        }
    }

    fn turn(&self, x: &[f64], period: f64) -> Result<AfterTurn, GradientError> {
        let d = x.len();
        let trajectory = self.trajectory(period);
        let mut tangents = vec![0.0; d * d];
        (0..d).for_each(|i| tangents[i * d + i] = 1.0);
        let plan = Plan {
            steps: self.steps,
            every: self.steps,
        };
        let end = trajectory.push(x, (&tangents, &[]), plan)?;
        let ends = end.samples[d..].iter().zip(x);
        Ok(AfterTurn {
            gap: ends.map(|(end, x)| end - x).collect(),
            monodromy: end.tangents[d * d..]
                .chunks_exact(d)
                .map(<[f64]>::to_vec)
                .collect(),
        })
    }

    /// max |x_k − x_0| after so many steps of a period.
    fn gap_after(&self, x: &[f64], period: f64, steps: u64) -> Result<f64, GradientError> {
        let plan = Plan {
            steps,
            every: steps,
        };
        let end = self.trajectory(period).push(x, (&[], &[]), plan)?;
        let gaps = end.samples[x.len()..].iter().zip(x);
        Ok(gaps.fold(0.0, |most, (a, b)| larger(most, (a - b).abs())))
    }

    /// max |x_k − x_0| over a turn.
    fn moved(&self, x: &[f64], period: f64) -> Result<f64, GradientError> {
        let every = Plan {
            steps: self.steps,
            every: 1,
        };
        let turn = self.trajectory(period).push(x, (&[], &[]), every)?;
        let states = turn.samples.chunks_exact(x.len());
        let gaps = states.flat_map(|state| state.iter().zip(x).map(|(a, b)| (a - b).abs()));
        Ok(gaps.fold(0.0, f64::max))
    }

    /// ∂Φᴺ/∂T.
    fn by_period(&self, x: &[f64], period: f64) -> Result<Vec<f64>, GradientError> {
        let [ahead, behind] = [1.0 + CHANGE, 1.0 - CHANGE].map(|part| self.turn(x, period * part));
        let (ahead, behind) = (ahead?.gap, behind?.gap);
        let change = 2.0 * CHANGE * period;
        Ok(ahead
            .iter()
            .zip(behind)
            .map(|(a, b)| (a - b) / change)
            .collect())
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
    let size = size_of(&orbit.state);
    let own = Turns::of(run, orbit.steps);
    let moved = own.moved(&orbit.state, orbit.period).ok()?;
    (2..=TURNS.min(orbit.steps)).find_map(|count| {
        let steps = orbit.steps.div_ceil(count);
        let part = Turns::of(run, steps);
        let period = orbit.period / count as f64;
        let near = part.gap_after(&orbit.state, period, steps).ok()?;
        if near > BACK * moved {
            return None;
        }
        // Near a bifurcation an orbit of two turns nearly closes after one: it closes in these steps as the shorter one does, or is another.
        let all = (orbit.period, steps * count);
        let whole = closed(run, &orbit.state, all, hold).ok()?;
        let own = Turns::of(run, whole.steps);
        let gap = own.gap_after(&whole.state, whole.period, steps).ok()?;
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

/// The largest coordinate, and 1 at least.
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
    let turns = Turns::of(run, steps);
    let mut invariants = Invariants::of(run)?;
    let (mut x, first) = (initial.to_vec(), period);
    let mut period = first;
    let held = invariants.values(&x);
    let size = size_of(&x);
    let moved_at_first = turns.moved(&x, period)?;
    let mut turn = turns.turn(&x, period)?;
    let mut iterations = 0;
    while iterations < STEPS && invariants.with_gap((&x, &held, hold), &turn.gap) > 0.0 {
        let along = turns.by_period(&x, period)?;
        let system = bordered(&turn, &along, &mut invariants, (&x, &held, hold));
        let change = SingularValues::of(&system.0).solve(&system.1, PART);
        let before = length(&system.1);
        let mut part = 1.0;
        let mut better = None;
        // Near round-off a shorter correction is no better.
        let halvings = if before > NEAR * size { HALVINGS } else { 1 };
        for _ in 0..halvings {
            let moved = x.iter().zip(&change).map(|(x, dx)| x + part * dx);
            let moved: Vec<f64> = moved.collect();
            let longer = period + part * change[x.len()];
            if longer > 0.0
                && let Ok(next) = turns.turn(&moved, longer)
                && invariants.with_gap((&moved, &held, hold), &next.gap) < before
            {
                better = Some((moved, longer, next));
                break;
            }
            part *= 0.5;
        }
        let Some(next) = better else { break };
        iterations += 1;
        (x, period, turn) = next;
        if period < SHRUNK * first {
            return Err(OrbitError::Shrinks {
                iterations,
                first,
                period,
            });
        }
    }
    let closure = turn
        .gap
        .iter()
        .fold(0.0_f64, |most, gap| most.max(gap.abs()));
    if closure.is_nan() || closure > CLOSED * size {
        return Err(OrbitError::NotClosed {
            iterations,
            closure,
        });
    }
    let moved = turns.moved(&x, period)?;
    if closure >= MOVED * moved || moved < RESTS * moved_at_first {
        return Err(OrbitError::Equilibrium { iterations, moved });
    }
    let now = invariants.values(&x);
    for (at, (now, held)) in now.iter().zip(&held).enumerate() {
        let off = (now - held).abs() / held.abs().max(1.0);
        if at == 0 && hold == Hold::Period || off <= CLOSED {
            continue;
        }
        let name = match at {
            0 => "energy".to_owned(),
            _ => format!("Casimir {}", run.system.casimir_names()[at - 1]),
        };
        return Err(OrbitError::NotHeld { name, off });
    }
    let (trivial, multipliers) = multipliers(&turn.monodromy)
        .map_err(|growth| OrbitError::Multipliers { closure, growth })?;
    let opposite = multipliers.iter().zip(multipliers.iter().rev());
    let products = opposite.map(|(a, b)| (a.modulus() * b.modulus() - 1.0).abs());
    Ok(PeriodicOrbit {
        pairing: products.fold(0.0, f64::max),
        state: x,
        period,
        steps: turns.steps,
        turns: 1,
        closure,
        iterations,
        trivial,
        multipliers,
    })
}

fn refuse(run: &ComposedRun, (period, steps): (f64, u64)) -> Result<(), OrbitError> {
    let (message, help) = if run.method.lattice().is_some() {
        (
            "orbits of long lattices are not closed",
            "shorten the lattice",
        )
    } else if run.method.noise().is_some() {
        (
            "a motion with noise has no periodic orbits",
            "take the noise out",
        )
    } else if run.plan.events.act.is_some() {
        (
            "events of this scene change the state, and orbits are closed by the method's steps alone",
            "take `set` out of run.section",
        )
    } else if run.system.has_forces() {
        (
            "a motion with forces does not hold the energy, which the orbits that are closed do",
            "take system.forces out",
        )
    } else if run.table_step().is_some() {
        (
            "the generating function holds for one time step alone, and an orbit is closed by steps of a part of its period",
            "close the orbit of the scene whose steps the table puts together",
        )
    } else if run.is_extended() {
        (
            "orbits of systems whose H names the time, with a pace, parameters of sites or a contact bracket are not closed",
            "close the orbit of a system without them",
        )
    } else if steps == 0 || !(period > 0.0 && period.is_finite()) {
        (
            "an orbit takes steps over a positive time, and here are none",
            "give a positive period and a number of steps",
        )
    } else {
        return Ok(());
    };
    Err(OrbitError::NotOffered { message, help })
}

/// Energy and Casimirs, with their gradients.
struct Invariants {
    observer: leafwise_core::Observer,
}

impl Invariants {
    fn of(run: &ComposedRun) -> Result<Self, OrbitError> {
        let observer = run.invariants().map_err(|_| OrbitError::NotOffered {
            message: "the invariants have no code",
            help: "declare others",
        })?;
        Ok(Self { observer })
    }

    fn values(&mut self, x: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.observer.observables()];
        self.observer.evaluate(x, &mut values);
        values
    }

    /// The gradient of each that is held, of length 1, and how far it is to its value along it; 0 where it has none.
    fn rows(&mut self, (x, held, hold): (&[f64], &[f64], Hold)) -> Vec<(Vec<f64>, f64)> {
        let (now, gradients) = (self.values(x), self.gradients(x));
        let off = held.iter().zip(now).map(|(held, now)| held - now);
        let rows = gradients.into_iter().zip(off);
        let rows = rows.skip(usize::from(hold == Hold::Period));
        rows.map(|(gradient, off)| unit(gradient, off)).collect()
    }

    /// The length of the right-hand side of all equations.
    fn with_gap(&mut self, at: (&[f64], &[f64], Hold), gap: &[f64]) -> f64 {
        let off: Vec<f64> = self.rows(at).iter().map(|(_, off)| *off).collect();
        length(&[gap, &off].concat())
    }

    /// By differences: they direct Newton's method, and its end depends on values alone.
    fn gradients(&mut self, x: &[f64]) -> Vec<Vec<f64>> {
        let mut gradients = vec![vec![0.0; x.len()]; self.observer.observables()];
        let mut moved = x.to_vec();
        for i in 0..x.len() {
            let change = 1e-6 * x[i].abs().max(1.0);
            moved[i] = x[i] + change;
            let ahead = self.values(&moved);
            moved[i] = x[i] - change;
            let behind = self.values(&moved);
            moved[i] = x[i];
            for ((gradient, a), b) in gradients.iter_mut().zip(ahead).zip(behind) {
                gradient[i] = (a - b) / (2.0 * change);
            }
        }
        gradients
    }
}

/// The columns of [M − 1, ∂_T; borders] and the right-hand side.
fn bordered(
    turn: &AfterTurn,
    along: &[f64],
    invariants: &mut Invariants,
    (x, held, hold): (&[f64], &[f64], Hold),
) -> (Columns, Vec<f64>) {
    let d = x.len();
    // A column of zeros takes the period out of the unknowns: the least step does not change it.
    let free = match hold {
        Hold::Energy => 1.0,
        Hold::Period => 0.0,
    };
    let mut rows: Vec<(Vec<f64>, f64)> = (0..d)
        .map(|i| {
            let own = (0..d).map(|j| turn.monodromy[j][i] - f64::from(u8::from(i == j)));
            (own.chain([free * along[i]]).collect(), -turn.gap[i])
        })
        .collect();
    rows.push(unit(along.to_vec(), 0.0));
    rows.extend(invariants.rows((x, held, hold)));
    let borders = rows.iter_mut().skip(d);
    borders.for_each(|(row, _)| row.push(0.0));
    let columns = (0..=d).map(|j| rows.iter().map(|(row, _)| row[j]).collect());
    (
        columns.collect(),
        rows.iter().map(|(_, right)| *right).collect(),
    )
}

/// An equation over the length of its row.
fn unit(mut row: Vec<f64>, right: f64) -> (Vec<f64>, f64) {
    let size = length(&row);
    let inverse = if size > 0.0 { 1.0 / size } else { 0.0 };
    row.iter_mut().for_each(|entry| *entry *= inverse);
    (row, right * inverse)
}

fn length(v: &[f64]) -> f64 {
    libm::sqrt(v.iter().map(|x| x * x).sum())
}

/// How many multipliers are 1 by the time and the integrals, and the others; else the size of M − 1.
fn multipliers(monodromy: &Columns) -> Result<(usize, Vec<Complex>), f64> {
    let d = monodromy.len();
    let mut less = monodromy.clone();
    (0..d).for_each(|i| less[i][i] -= 1.0);
    let parts = SingularValues::of(&less);
    let size = parts.values[0].max(1.0);
    let trace: f64 = (0..d).map(|i| monodromy[i][i]).sum();
    let found = KERNEL.iter().find_map(|part| {
        let rank = parts.values.iter().filter(|value| **value > part * size);
        let rank = rank.count();
        let others = eigenvalues(&reduced(monodromy, &parts, rank))?;
        let trivial = d - others.len();
        let sum = trivial as f64 + others.iter().map(|of| of.re).sum::<f64>();
        let scale = 1.0 + others.iter().map(|of| of.modulus()).sum::<f64>();
        ((sum - trace).abs() <= TRACE * scale).then_some((trivial, others))
    });
    found.ok_or(size)
}

/// M in the image of M − 1, given its singular values of which so many are no zeros, but for its own vectors in that image.
fn reduced(monodromy: &Columns, parts: &SingularValues, rank: usize) -> Columns {
    let d = monodromy.len();
    // The image of M − 1 is what all integrals leave; in it lie those of the kernel that are no motion across leaves.
    let image = &parts.left[..rank];
    let project = |v: &Vec<f64>| -> Vec<f64> {
        image
            .iter()
            .map(|u| u.iter().zip(v).map(|(a, b)| a * b).sum())
            .collect()
    };
    let inside: Columns = parts.right[rank..].iter().map(project).collect();
    let found = SingularValues::of(&inside);
    let kept: Columns = (found.left.iter().zip(&found.values))
        .filter(|(_, value)| **value > 0.5)
        .map(|(column, _)| column.clone())
        .collect();
    let basis = complement(&kept, rank);
    // Its vectors in the state's coordinates.
    let basis: Columns = basis
        .iter()
        .map(|own| {
            let mut v = vec![0.0; d];
            for (part, u) in own.iter().zip(image) {
                v.iter_mut().zip(u).for_each(|(v, u)| *v += part * u);
            }
            v
        })
        .collect();
    basis
        .iter()
        .map(|v| {
            let mut moved = vec![0.0; d];
            for (part, column) in v.iter().zip(monodromy) {
                moved
                    .iter_mut()
                    .zip(column)
                    .for_each(|(m, c)| *m += part * c);
            }
            basis
                .iter()
                .map(|w| w.iter().zip(&moved).map(|(a, b)| a * b).sum())
                .collect()
        })
        .collect()
}

/// An orthonormal basis of what is at right angles to orthonormal vectors.
fn complement(vectors: &Columns, dimension: usize) -> Columns {
    let mut all: Columns = vectors.clone();
    while all.len() < dimension {
        let candidates = (0..dimension).map(|j| {
            let mut v = vec![0.0; dimension];
            v[j] = 1.0;
            for _ in 0..2 {
                for u in &all {
                    let along: f64 = u.iter().zip(&v).map(|(a, b)| a * b).sum();
                    v.iter_mut().zip(u).for_each(|(v, u)| *v -= along * u);
                }
            }
            v
        });
        let longest = candidates.max_by(|a, b| length(a).total_cmp(&length(b)));
        let Some(mut v) = longest else { break };
        let size = length(&v);
        v.iter_mut().for_each(|entry| *entry /= size);
        all.push(v);
    }
    all.split_off(vectors.len())
}
