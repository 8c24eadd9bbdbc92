//! Events that change the state: bounces, kicks, resets.

use leafwise_core::{BuildError, StepError};

use super::Watched;
use super::looks::time_of;
use crate::events::{Side, crossings, end};
use crate::fault::{Ended, Fault, Why};
use crate::look::Look;
use crate::step::{Between, CLOSE, StepEnd};

/// Acts of one event within a step, at most.
const MOST: usize = 100;

/// The part of a step by which the side is found to which a motion leaves a surface.
const PROBE: f64 = 1.0 / 1_048_576.0;

/// The speed just behind an event, over the mean one of the rest of the step, below which the motion rests on the surface. A state on
/// the surface may be as large a part of a probe's way from it.
const RESTS: f64 = 1e-3;

impl Watched<'_> {
    /// Lets events act on the lanes that cross their surfaces in the last step. The state is changed where it crosses, and the rest of
    /// the step is made from there: the last step of the looks that follow begins there.
    pub(super) fn act<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        take: &mut F,
    ) -> Result<(), E> {
        for at in 0..self.events.len() {
            if self.events[at].event.act.is_none() {
                continue;
            }
            self.events[at].values.at(self.walk.state());
            for lane in 0..self.walk.lanes() {
                if self.moved[lane] && self.walk.lives(lane) {
                    self.act_on(at, lane, take)?;
                }
            }
        }
        Ok(())
    }

    fn act_on<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        at: usize,
        lane: usize,
        take: &mut F,
    ) -> Result<(), E> {
        let (steps, lanes) = (self.walk.steps(), self.walk.lanes());
        let event = self.events[at].event;
        let text = &event.section.text;
        let mut value = self.events[at].values.last()[lane];
        let mut latest = None;
        if let Some(side) = self.events[at].stays(lane, steps) {
            self.events[at].sides[lane] = side;
            return Ok(());
        }
        for _ in 0..MOST {
            let own = &self.events[at];
            let side = own.sides[lane];
            let after = StepEnd::of(&self.walk, lane);
            let alone = self.alones.at(lane, &self.start)?;
            let (values, last) = (&mut alone.events[at], &mut alone.last);
            let seen = (side, own.corners.of(lane), value, steps);
            let found = crossings(event, values, last, &after.state, seen);
            let (crossed, between) = match found {
                Ok((crossed, found)) => match found.into_iter().next() {
                    Some(between) => (crossed, between),
                    None => {
                        self.events[at].sides[lane] = crossed;
                        return Ok(());
                    }
                },
                Err(fault) => {
                    self.fail(lane, fault, steps);
                    return Ok(());
                }
            };
            let across = side.across(&event.section);
            let (time, whole) = (
                time_of(None, last, steps, &between),
                last.whole(between.part),
            );
            if self.stops_before(lane, &between)? {
                return Ok(());
            }
            let others = self.others_before(lane, &between, take)?;
            if !self.walk.lives(lane) {
                return Ok(());
            }
            self.events[at].sides[lane] = crossed;
            while let Some(asked) = self.passed_time(lane, time) {
                self.take_before(lane, (asked, time), &between.state, take)?;
            }
            let on_it = (time, between.state.clone(), true);
            self.take_crossing(at, lane, on_it, take)?;
            if !self.walk.lives(lane) {
                return Ok(());
            }
            let alone = self.alones.at(lane, &self.start)?;
            let own = alone.events[at].at(&between.state)[1..event.first_corner()].to_vec();
            let mut state = between.state;
            let set = event.act.iter().flat_map(|act| &act.set);
            for ((coordinate, _), value) in set.zip(&own) {
                state[*coordinate] = *value;
            }
            if own.iter().any(|value| !value.is_finite()) {
                let text = event
                    .act
                    .as_ref()
                    .map_or_else(String::new, |act| act.text.clone());
                self.fail_at(lane, Fault::Undefined(text), (time, state));
                return Ok(());
            }
            if let (Some(own), Some(values)) = (&mut self.stop, &mut alone.stop) {
                let difference = values.at(&state)[0];
                own.pasts[lane] = own.pasts[lane].begun_again(difference);
                if own.stop.holds(difference) {
                    self.end_between(lane, Why::Stopped, time, state);
                    return Ok(());
                }
            }
            for (at, sides) in others {
                let value = alone.events[at].at(&state)[0];
                self.events[at].sides[lane] = sides.begin_again(value);
            }
            let begun = self.begin_again(at, lane, &state, whole);
            let Begun {
                begins,
                probe,
                leads,
            } = match begun? {
                Ok(begun) => begun,
                Err(error) => {
                    self.fail_at(lane, error.into(), (time, state));
                    return Ok(());
                }
            };
            let (rest, away) = (1.0 - whole, leads - begins);
            // Time and place are rounded: what is next to the surface beside what the motion makes in a probe is on it.
            let is_on = crossed.is_on(begins, steps) || begins.abs() < RESTS * away.abs();
            // The side to which the motion leaves; at rest on the surface it is the one behind the crossing.
            let leaves = match (is_on, away == 0.0) {
                (true, true) => across,
                (true, false) => 1.0_f64.copysign(away),
                (false, _) => 1.0_f64.copysign(begins),
            };
            let alone = self.alones.at(lane, &self.start)?;
            let (values, last) = (&mut alone.events[at], &mut alone.last);
            let end = match rest <= CLOSE {
                true => Ok(state.clone()),
                false => last.part(1.0),
            };
            let mut end = match end {
                Ok(end) => end,
                Err(error) => {
                    self.fail_at(lane, error.into(), (time, state));
                    return Ok(());
                }
            };
            value = values.at(&end)[0];
            if rest <= PROBE {
                // Whatever follows is of the next step.
                self.walk.put(lane, &end);
                let known = if is_on { on_side(value, leaves) } else { value };
                self.events[at].sides[lane] = side.behind(crossed, known, leaves).with_step();
                return Ok(self.begin_corners_again(lane)?);
            }
            let mut known = begins;
            if is_on {
                known = on_side(begins, leaves);
                let is_back = value * across > 0.0;
                // It goes through the surface as fast as it is behind it at the end, or else it is pulled there from rest.
                let rests = away.abs() * rest < RESTS * PROBE * (value - begins).abs();
                if is_back && rests && leaves == across {
                    self.fail_at(lane, Fault::Accumulates(text.clone()), (time, state));
                    return Ok(());
                }
                if is_back && leaves != across {
                    // It comes back within the step: what is left of that begins off the surface.
                    self.start.put(lane, lanes, &probe, whole + PROBE);
                    let alone = self.alones.at(lane, &self.start)?;
                    match alone.last.part(1.0) {
                        Ok(further) => end = further,
                        Err(error) => {
                            self.fail_at(lane, error.into(), (time, state));
                            return Ok(());
                        }
                    }
                    value = alone.events[at].at(&end)[0];
                    known = leads;
                }
            }
            self.walk.put(lane, &end);
            self.events[at].sides[lane] = side.behind(crossed, known, leaves);
            self.begin_corners_again(lane)?;
            latest = Some((time, state));
        }
        if let Some(latest) = latest {
            self.fail_at(lane, Fault::TooMany(text.clone(), MOST), latest);
        }
        Ok(())
    }

    /// Begins what is left of the step at the state behind an event.
    fn begin_again(
        &mut self,
        at: usize,
        lane: usize,
        state: &[f64],
        whole: f64,
    ) -> Result<Result<Begun, StepError>, BuildError> {
        let lanes = self.walk.lanes();
        // The length of the probe is that of the whole step, whatever is left of it.
        self.start.put(lane, lanes, state, 0.0);
        let alone = self.alones.at(lane, &self.start)?;
        let values = &mut alone.events[at];
        let begins = values.at(state)[0];
        let probe = alone.last.part(PROBE);
        let begun = probe.map(|probe| {
            let leads = values.at(&probe)[0];
            Begun {
                begins,
                probe,
                leads,
            }
        });
        self.start.put(lane, lanes, state, whole);
        Ok(begun)
    }

    /// Takes in the corners where what is left of the step begins.
    fn begin_corners_again(&mut self, lane: usize) -> Result<(), BuildError> {
        let alone = self.alones.at(lane, &self.start)?;
        let state = &alone.last.start.state;
        for (own, values) in self.events.iter_mut().zip(&mut alone.events) {
            own.corners.begin_again(lane, values.at(state));
        }
        if let (Some(own), Some(values)) = (&mut self.stop, &mut alone.stop) {
            own.corners.begin_again(lane, values.at(state));
        }
        Ok(())
    }

    /// Ends a lane that the condition ends in the part of the last step before an event acts.
    fn stops_before(&mut self, lane: usize, between: &Between) -> Result<bool, BuildError> {
        let (steps, part) = (self.walk.steps(), between.part);
        if part <= 0.0 {
            return Ok(false);
        }
        let alone = self.alones.at(lane, &self.start)?;
        let (Some(own), Some(values)) = (&self.stop, &mut alone.stop) else {
            return Ok(false);
        };
        let (stop, last) = (own.stop, &mut alone.last);
        let value = values.at(&between.state)[0];
        let seen = (own.pasts[lane], own.corners.of(lane), value);
        let found = last.within(part, |last| end(stop, values, last, &between.state, seen));
        match found {
            Err(fault) => self.fail(lane, fault, steps),
            Ok(None) => return Ok(false),
            Ok(Some(inner)) => {
                let inner = Between {
                    part: part * inner.part,
                    ..inner
                };
                let time = time_of(None, last, steps, &inner);
                if !self.is_on_the_way(lane, time) {
                    return Ok(false);
                }
                self.end_between(lane, Why::Stopped, time, inner.state);
            }
        }
        Ok(true)
    }

    /// Takes in what other events cross in the part of the last step before an event acts. Tells the sides of each before and after it.
    fn others_before<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        lane: usize,
        between: &Between,
        take: &mut F,
    ) -> Result<Vec<(usize, Sides)>, E> {
        let (steps, part) = (self.walk.steps(), between.part);
        let (mut sides, mut order) = (Vec::new(), Vec::new());
        for at in 0..self.events.len() {
            let own = &self.events[at];
            if own.event.act.is_some() {
                continue;
            }
            let side = own.sides[lane];
            let alone = self.alones.at(lane, &self.start)?;
            let (values, last) = (&mut alone.events[at], &mut alone.last);
            let value = values.at(&between.state)[0];
            let seen = (side, own.corners.of(lane), value, steps);
            let event = own.event;
            let found = match part > 0.0 {
                true => last.within(part, |last| {
                    crossings(event, values, last, &between.state, seen)
                }),
                false => Ok((side, Vec::new())),
            };
            match found {
                Err(fault) => {
                    self.fail(lane, fault, steps);
                    return Ok(sides);
                }
                Ok((after, found)) => {
                    sides.push((at, Sides(side, after)));
                    order.extend(found.into_iter().map(|inner| {
                        let inner = Between {
                            part: part * inner.part,
                            ..inner
                        };
                        (time_of(None, last, steps, &inner), at, inner.state)
                    }));
                }
            }
        }
        let forward = self.course.step();
        order.sort_by(|one, other| (one.0 * forward).total_cmp(&(other.0 * forward)));
        for (time, at, state) in order {
            self.take_crossing(at, lane, (time, state, true), take)?;
            if !self.walk.lives(lane) {
                break;
            }
        }
        Ok(sides)
    }

    /// Ends a lane that cannot go on behind an event.
    fn fail_at(&mut self, lane: usize, fault: Fault, (time, state): (f64, Vec<f64>)) {
        let ended = Ended {
            why: Why::Failed(fault),
            steps: self.walk.steps() - 1,
            time,
            state,
            is_between: true,
        };
        self.end(lane, ended);
    }

    /// Takes in the state at a time that is asked for, before an event acts.
    fn take_before<E: From<BuildError>, F: FnMut(Look<'_>) -> Result<(), E>>(
        &mut self,
        lane: usize,
        (asked, time): (f64, f64),
        state: &[f64],
        take: &mut F,
    ) -> Result<(), E> {
        let steps = self.walk.steps();
        let alone = self.alones.at(lane, &self.start)?;
        let found = match (time - asked) * self.course.step() > 0.0 {
            true => alone.last.state_at(steps, asked),
            false => Ok(state.to_vec()),
        };
        let number = self.next[lane];
        self.next[lane] += 1;
        match found {
            Ok(state) => take(Look::Sample {
                lane,
                number,
                time: asked,
                state: &state,
                steps: None,
            }),
            Err(error) => {
                self.fail(lane, error.into(), steps);
                Ok(())
            }
        }
    }
}

/// How the motion leaves a state behind an event.
struct Begun {
    /// Left − right there.
    begins: f64,
    /// The state a [`PROBE`] of a step later.
    probe: Vec<f64>,
    /// Left − right at that.
    leads: f64,
}

/// Where a run stands beside the surface of an event before and after a part of a step.
struct Sides(Side, Side);

impl Sides {
    /// Behind the change of the state at the end of that part: left − right has this value there.
    fn begin_again(self, value: f64) -> Side {
        let Self(before, after) = self;
        before.behind(after, value, after.sign_of(value))
    }
}

/// A value next to zero with the sign of the side to which the motion leaves, whatever rounding has made of it.
fn on_side(value: f64, side: f64) -> f64 {
    value.abs().max(f64::MIN_POSITIVE) * side
}
