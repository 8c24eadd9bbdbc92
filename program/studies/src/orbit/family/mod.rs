//! Families of periodic orbits by pseudo-arclength: predictions along the tangent, corrections at right angles to it.
//!
//! Cf. E. Doedel, H. B. Keller, J. P. Kernévez, Int. J. Bifurcation Chaos 1 (1991). An orbit of a Poisson system has
//! neighbours of other energies, so that one system has a family by itself. With the energy or the period held there is one
//! along a parameter.
//!
//! Functions along a family change their sign at its marks. They are the slope of what is continued, Π(μ − 1), Π(μ + 1), and
//! the discriminant of the μ + 1/μ, over the multipliers.
//!
//! Where another family comes through, the equations have a null vector beside the tangent. That family begins along it
//! (H. B. Keller, in *Applications of Bifurcation Theory*, Academic Press (1977)).

mod marks;
pub(super) mod types;

use leafwise_scene::compose::ComposedRun;

use self::types::{Along, Ends, FamilyOrbit, Following, Mark, OrbitFamily};
use super::equations::{AfterTurn, Equations, Invariants, Moving, Turns};
use super::linear::{Columns, Complex, SingularValues, dot};
use super::multipliers::{Kernel, complement, discriminant};
use super::newton::{Corrected, corrected, length};
use super::{Hold, NEAR, OrbitError, PART, PeriodicOrbit, close, judged, size_of};

/// A singular value below this is that of a direction along the family, or of a symmetry.
const ALONG: f64 = 1e-7;

/// Steps that the whole way would take where the slope is that of its beginning.
const STEPS: f64 = 20.0;

/// The longest and the shortest step along a family.
const LONGEST: f64 = 0.1;
const SHORTEST: f64 = 1e-7;

/// The longest step over the one before it.
const LONGER: f64 = 1.4;

/// The cosine of the turn of the tangent in a step, at least.
const STRAIGHT: f64 = 0.95;

/// Corrections of one prediction, at most.
const CORRECTIONS: usize = 12;

/// An orbit with what leads on from it.
struct Continued {
    unknowns: Vec<f64>,
    orbit: PeriodicOrbit,
    value: f64,
    tangent: Vec<f64>,
    /// The derivative of the value along the tangent, Π(μ − 1), Π(μ + 1) and the discriminant.
    tests: [f64; 4],
    /// The size of the orbit.
    moved: f64,
    /// The least singular value that counts.
    least: f64,
    /// Its vector, and those of directions along the family and of symmetries.
    space: Columns,
}

/// The places of the functions that change their sign at marks.
const FOLD: usize = 0;
const PLUS: usize = 1;
const MINUS: usize = 2;
const DISCRIMINANT: usize = 3;

struct Walk<'a> {
    equations: Equations<'a>,
    along: &'a Along,
    casimirs: Vec<&'a str>,
    /// Of the first orbit.
    kernel: Kernel,
    /// Directions along the family and of symmetries.
    free: usize,
    moved_at_first: f64,
}

/// Closes an orbit as [`close`] does, and follows its family.
///
/// # Errors
/// [`OrbitError`] of the first orbit; what stops the family later is where it [ends](OrbitFamily::ends).
pub fn follow(
    run: &ComposedRun,
    (period, steps): (f64, u64),
    hold: Hold,
    following: &Following,
) -> Result<OrbitFamily, OrbitError> {
    let first = close(run, (period, steps), hold)?;
    let turns = Turns::of(run, first.steps, first.units.clone());
    let x = turns.inside(&first.state);
    let invariants = Invariants(run);
    let along = &following.along;
    let moving = match along {
        Along::Energy | Along::Period => None,
        Along::Parameter(name) => {
            let mut all = run.system.parameters().iter();
            let Some(parameter) = all.position(|own| own.name == *name) else {
                return Err(OrbitError::NoParameter { name: name.clone() });
            };
            let own = run.system.parameter_values()[parameter];
            let unit = (following.to - own).abs();
            Some((Moving { parameter, unit }, own))
        }
    };
    let is_alone = moving.is_none();
    let begins = match (along, moving) {
        (Along::Energy, _) => first.energy,
        (Along::Period, _) => first.period,
        (_, moving) => moving.map_or(0.0, |(_, own)| own),
    };
    let way = following.to - begins;
    if !way.is_finite() || way == 0.0 {
        return Err(OrbitError::NotOffered {
            message: "a family is followed to another value than that of its first orbit",
            help: "name a value further away".into(),
        });
    }
    let mut unknowns = [x.as_slice(), &[1.0]].concat();
    unknowns.extend(moving.map(|(moving, own)| own / moving.unit));
    let mut walk = Walk {
        moved_at_first: turns.moved(&x, first.period)?,
        casimirs: run.system.casimir_names(),
        kernel: first.kernel,
        free: 1,
        along,
        equations: Equations {
            held: invariants.values(&x, &turns)?,
            turns,
            invariants,
            holds_energy: !is_alone && hold == Hold::Energy,
            finds_period: is_alone || hold == Hold::Energy,
            period_unit: first.period,
            moving: moving.map(|(moving, _)| moving),
            border: None,
        },
    };
    walk.family(first, unknowns, (begins, way), following)
}

impl Walk<'_> {
    fn family(
        &mut self,
        first: PeriodicOrbit,
        unknowns: Vec<f64>,
        (begins, way): (f64, f64),
        following: &Following,
    ) -> Result<OrbitFamily, OrbitError> {
        let at = self.equations.at(&unknowns)?;
        let columns = self.equations.columns(&unknowns, &at)?;
        let values = SingularValues::of(&columns).values;
        self.free = values
            .iter()
            .filter(|value| **value <= ALONG)
            .count()
            .max(1);
        let mut guide = self.slope(&unknowns)?;
        guide.iter_mut().for_each(|g| *g *= way.signum());
        let begun = Corrected {
            unknowns,
            at,
            corrections: first.iterations,
        };
        let mut here = self.point(begun, &guide)?;
        here.orbit = first;
        let mut members = vec![here.member(None)];
        let mut branches = following.branch.map_or(0, i64::unsigned_abs);
        let longest = |here: &Continued| LONGEST.min((way / (STEPS * here.tests[FOLD])).abs());
        let mut step = longest(&here);
        let mut has_left = false;
        let ends = loop {
            if members.len() >= following.most {
                break Ends::Many;
            }
            let next = match self.stepped(&here, step) {
                Ok(next) if next.cosine(&here) >= STRAIGHT || step < 4.0 * SHORTEST => next,
                // The equilibrium at which a family ends.
                Err(OrbitError::Equilibrium { .. }) if step < 1e-3 => break Ends::Equilibrium,
                Err(error) if step < SHORTEST => break Ends::Lost(error),
                _ => {
                    step *= 0.5;
                    continue;
                }
            };
            let is_there = (next.value - following.to) * way >= 0.0;
            let next = match is_there.then(|| self.landed(&here, &next, following.to)) {
                None => next,
                Some(Ok(landed)) => landed,
                Some(Err(_)) if step >= SHORTEST => {
                    step *= 0.5;
                    continue;
                }
                Some(Err(error)) => break Ends::Lost(error),
            };
            match self.marks(&here, &next) {
                Ok(marks) => {
                    let mut marks = marks.into_iter();
                    let at = marks.find(|(mark, point)| {
                        let is_branch = *mark == Mark::Branch;
                        branches = branches.saturating_sub(u64::from(is_branch && branches > 0));
                        members.push(point.member(Some(*mark)));
                        is_branch && branches == 0 && !has_left && following.branch.is_some()
                    });
                    if let Some((_, point)) = at {
                        has_left = true;
                        here = point.on_other_family(&here, following.branch.unwrap_or(1) < 0);
                        step = longest(&here);
                        continue;
                    }
                }
                Err(OrbitError::Equilibrium { .. }) => break Ends::Equilibrium,
                Err(_) if step >= SHORTEST => {
                    step *= 0.5;
                    continue;
                }
                Err(error) => break Ends::Lost(error),
            }
            members.push(next.member(None));
            if is_there {
                break match following.branch.is_some() && !has_left {
                    true => Ends::NoBranch,
                    false => Ends::Reached,
                };
            }
            if (next.value - begins) * way < 0.0 {
                break Ends::Returned;
            }
            step = (LONGER * step).min(longest(&next));
            here = next;
        };
        Ok(OrbitFamily { members, ends })
    }

    /// The derivative of what is continued by the unknowns.
    fn slope(&self, unknowns: &[f64]) -> Result<Vec<f64>, OrbitError> {
        let (x, _, turns) = self.equations.parts(unknowns);
        let d = x.len();
        let mut slope = vec![0.0; unknowns.len()];
        match (self.along, self.equations.moving) {
            (Along::Energy, _) => {
                let gradients = self.equations.invariants.gradients(x, &turns)?;
                slope[..d].copy_from_slice(&gradients[0]);
            }
            (Along::Period, _) | (_, None) => slope[d] = self.equations.period_unit,
            (_, Some(moving)) => slope[d + 1] = moving.unit,
        }
        Ok(slope)
    }

    /// The orbit near unknowns on a plane.
    fn solved(
        &mut self,
        start: Vec<f64>,
        border: Option<(Vec<f64>, f64)>,
        guide: &[f64],
    ) -> Result<Continued, OrbitError> {
        let found = self.closed(start, border)?;
        self.point(found, guide)
    }

    /// Unknowns that close, near others, on a plane.
    fn closed(
        &mut self,
        start: Vec<f64>,
        border: Option<(Vec<f64>, f64)>,
    ) -> Result<Corrected<AfterTurn>, OrbitError> {
        self.equations.border = border;
        let near = NEAR * size_of(&start);
        let found = {
            let equations = &self.equations;
            corrected(
                start,
                (PART, near),
                |u| equations.at(u),
                |u, at| equations.columns(u, at),
                |_, iterations| match iterations > CORRECTIONS {
                    true => Err(OrbitError::NotClosed {
                        iterations,
                        closure: f64::NAN,
                    }),
                    false => Ok(()),
                },
            )
        };
        self.equations.border = None;
        found
    }

    /// The orbit that is found, with its tangent on the side of a guide.
    fn point(&self, found: Corrected<AfterTurn>, guide: &[f64]) -> Result<Continued, OrbitError> {
        let known = (self.casimirs.as_slice(), Some(self.kernel));
        let (orbit, moved) = judged(&self.equations, &found, self.moved_at_first, known)?;
        let columns = self.equations.columns(&found.unknowns, &found.at)?;
        let parts = SingularValues::of(&columns);
        let count = parts.values.len() - self.free;
        let tangent = projected(&parts.right[count..].to_vec(), guide);
        let slope = self.slope(&found.unknowns)?;
        let product = |one: f64| {
            let size: f64 = orbit
                .multipliers
                .iter()
                .map(|of| 1.0 + of.modulus())
                .product();
            let all = orbit.multipliers.iter();
            all.fold(Complex { re: 1.0, im: 0.0 }, |product, of| {
                product.times(Complex {
                    re: of.re + one,
                    im: of.im,
                })
            })
            .re / size
        };
        Ok(Continued {
            tests: [
                dot(&slope, &tangent),
                product(-1.0),
                product(1.0),
                discriminant(&orbit.multipliers),
            ],
            value: match (self.along, self.equations.moving) {
                (Along::Energy, _) => orbit.energy,
                (Along::Period, _) | (_, None) => orbit.period,
                (_, Some(moving)) => found.unknowns[orbit.state.len() + 1] * moving.unit,
            },
            least: parts.values[count - 1],
            space: parts.right[count - 1..].to_vec(),
            unknowns: found.unknowns,
            moved,
            orbit,
            tangent,
        })
    }

    /// The orbit a step further along the tangent.
    fn stepped(&mut self, here: &Continued, step: f64) -> Result<Continued, OrbitError> {
        let pairs = here.unknowns.iter().zip(&here.tangent);
        let start: Vec<f64> = pairs.map(|(u, t)| u + step * t).collect();
        let border = (here.tangent.clone(), dot(&here.tangent, &start));
        self.solved(start, Some(border), &here.tangent)
    }

    /// The orbit of a value between those of two.
    fn landed(
        &mut self,
        here: &Continued,
        next: &Continued,
        to: f64,
    ) -> Result<Continued, OrbitError> {
        let part = (to - here.value) / (next.value - here.value);
        let pairs = here.unknowns.iter().zip(&next.unknowns);
        let start: Vec<f64> = pairs.map(|(a, b)| a + part * (b - a)).collect();
        let d = here.orbit.state.len();
        let (holds, held) = (self.equations.holds_energy, self.equations.held.clone());
        let mut border = None;
        match (self.along, self.equations.moving) {
            (Along::Energy, _) => {
                self.equations.holds_energy = true;
                self.equations.held[0] = to;
            }
            (_, moving) => {
                let mut row = vec![0.0; start.len()];
                let (at, unit) = match moving {
                    None => (d, self.equations.period_unit),
                    Some(moving) => (d + 1, moving.unit),
                };
                row[at] = 1.0;
                border = Some((row, to / unit));
            }
        }
        let found = self.closed(start, border);
        (self.equations.holds_energy, self.equations.held) = (holds, held);
        // The tangent is of the equations that leave the value free.
        let found = found?;
        let found = Corrected {
            at: self.equations.at(&found.unknowns)?,
            ..found
        };
        let point = self.point(found, &here.tangent)?;
        Ok(Continued { value: to, ..point })
    }
}

impl Continued {
    fn member(&self, mark: Option<Mark>) -> FamilyOrbit {
        FamilyOrbit {
            value: self.value,
            orbit: self.orbit.clone(),
            mark,
        }
    }

    /// The same orbit as the first of the family that comes through, along or against its direction. Two directions are free here:
    /// the other family's is at right angles to those that were free before.
    fn on_other_family(self, before: &Self, is_against: bool) -> Self {
        let own = before.space[1..].iter();
        let own = own.map(|free| self.space.iter().map(|own| dot(own, free)).collect());
        let own = SingularValues::of(&own.collect()).left;
        let parts = complement(&own, self.space.len()).pop().unwrap_or_default();
        let mut null = vec![0.0; self.unknowns.len()];
        for (part, vector) in parts.iter().zip(&self.space) {
            null.iter_mut()
                .zip(vector)
                .for_each(|(n, v)| *n += part * v);
        }
        let largest = null.iter().copied();
        let largest = largest.max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let sign = match (largest.unwrap_or(1.0) > 0.0) != is_against {
            true => 1.0,
            false => -1.0,
        };
        Self {
            tangent: null.iter().map(|n| sign * n).collect(),
            // Both are 0 here but for round-off.
            tests: [0.0, 0.0, self.tests[MINUS], self.tests[DISCRIMINANT]],
            ..self
        }
    }

    fn cosine(&self, other: &Self) -> f64 {
        dot(&self.tangent, &other.tangent)
    }
}

/// The unit vector of a space that is nearest to a guide.
fn projected(space: &Columns, guide: &[f64]) -> Vec<f64> {
    let mut own = vec![0.0; guide.len()];
    for vector in space {
        let part = dot(vector, guide);
        own.iter_mut().zip(vector).for_each(|(o, v)| *o += part * v);
    }
    let size = length(&own);
    match size > 0.0 {
        true => own.iter().map(|o| o / size).collect(),
        false => space.last().cloned().unwrap_or_default(),
    }
}
