//! Corners of a condition or of a surface in all lanes: the lanes whose last step may pass one.

use crate::turns::Past;

/// Values of the [corners](leafwise_expression::Expression::corners) of one function after the last steps. A lane whose step passes none
/// is looked at as if the function were smooth.
pub(super) struct Corners {
    /// The number of the first corner among the functions that are evaluated.
    first: usize,
    count: usize,
    lanes: usize,
    /// Corner c of lane w at `[w*count + c]`.
    pasts: Vec<Past>,
}

impl Corners {
    /// Of so many functions, of which those from number `first` on are corners.
    pub fn new(functions: usize, first: usize, lanes: usize) -> Self {
        let count = functions.saturating_sub(first);
        Self {
            first,
            count,
            lanes,
            pasts: vec![Past::default(); count * lanes],
        }
    }

    /// One lane's values, one for each corner, of those of all functions in all lanes.
    fn values<'a>(&self, lane: usize, all: &'a [f64]) -> impl Iterator<Item = f64> + use<'a> {
        let own = all.iter().skip(self.first * self.lanes + lane);
        own.step_by(self.lanes).copied()
    }

    /// At the initial states, where the functions have these values in all lanes.
    pub fn begin(&mut self, all: &[f64]) {
        for lane in 0..self.lanes {
            let values = self.values(lane, all);
            let pasts = self.pasts[lane * self.count..].iter_mut();
            pasts
                .zip(values)
                .for_each(|(past, value)| *past = Past::begin(value));
        }
    }

    /// One lane's past values.
    pub fn of(&self, lane: usize) -> &[Past] {
        &self.pasts[lane * self.count..][..self.count]
    }

    /// Whether a lane may have passed a corner in the last step, at whose end the functions have these values in all lanes. It has
    /// where one changes its sign, or where its second differences allow that it does so and comes back.
    pub fn may_be_passed(&self, lane: usize, all: &[f64]) -> bool {
        let mut own = self.of(lane).iter().zip(self.values(lane, all));
        own.any(|(past, value)| past.value() * value < 0.0 || !past.shows_all(value))
    }

    /// One lane after a step, the last of so many.
    pub fn go_on(&mut self, lane: usize, steps: u64, all: &[f64]) {
        let values = self.values(lane, all);
        let pasts = self.pasts[lane * self.count..].iter_mut();
        for (past, value) in pasts.zip(values) {
            if !past.has_seen(steps) {
                *past = past.then(value);
            }
        }
    }

    /// One lane whose state an event has changed: the functions have these values there, in this lane alone.
    pub fn begin_again(&mut self, lane: usize, own: &[f64]) {
        let pasts = self.pasts[lane * self.count..][..self.count].iter_mut();
        for (past, value) in pasts.zip(&own[self.first..]) {
            *past = past.begun_again(*value);
        }
    }

    /// Takes the past values of a walk of one lane from the beginning of a list, and tells what is left of it; `None` where it is too
    /// short.
    pub fn restore<'a>(&mut self, memory: &'a [Past]) -> Option<&'a [Past]> {
        let (own, rest) = memory.split_at_checked(self.pasts.len())?;
        self.pasts.copy_from_slice(own);
        Some(rest)
    }
}

#[cfg(test)]
mod tests {
    use super::Corners;

    /// A lane is told only where its corner is passed: at a change of sign, and where a sine turns past zero within the step.
    #[test]
    fn lanes_are_told_apart_by_the_corners_that_they_pass() {
        let lanes = 4;
        // The function, then the corner t − 0.55, sin(ω t) − 0.99, 5 + t, and t² − 1e-3 of a step's length 0.1.
        let corner = |lane: usize, t: f64| match lane {
            0 => t - 0.55,
            1 => libm::sin(12.0 * t) - 0.99,
            2 => 5.0 + t,
            _ => (t - 0.85) * (t - 0.85) - 1e-3,
        };
        let all = |t: f64| {
            let corners = (0..lanes).map(|lane| corner(lane, t));
            std::iter::repeat_n(1.0, lanes)
                .chain(corners)
                .collect::<Vec<f64>>()
        };
        let mut corners = Corners::new(2, 1, lanes);
        corners.begin(&all(0.0));
        let mut hidden = 0;
        for step in 1_u32..=20 {
            let (from, to) = (0.1 * f64::from(step - 1), 0.1 * f64::from(step));
            for lane in 0..lanes {
                // 1000 parts of the step show what is passed.
                let sign = |k: u32| corner(lane, from + (to - from) * f64::from(k) / 1000.0) > 0.0;
                let is_passed = (1..=1000).any(|k| sign(k) != sign(k - 1));
                let is_told = corners.may_be_passed(lane, &all(to));
                assert!(is_told || !is_passed, "lane {lane}, step {step}");
                hidden += u32::from(is_passed && sign(0) == sign(1000));
                // What a first step or two hide is not known. A straight corner is told where it is passed and nowhere else.
                if lane % 2 == 0 && step > 2 {
                    assert_eq!(is_told, is_passed, "lane {lane}, step {step}");
                }
            }
            (0..lanes).for_each(|lane| corners.go_on(lane, u64::from(step), &all(to)));
            // A step that was seen is not taken in again.
            let before = corners.pasts.clone();
            corners.go_on(0, u64::from(step), &all(to + 1.0));
            assert_eq!(corners.pasts, before);
        }
        assert!(hidden >= 2, "{hidden}");
    }
}
