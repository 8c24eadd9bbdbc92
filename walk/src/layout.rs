//! The layout of a state.

use std::ops::Range;

/// Layout of a state that is stepped: the motion's own coordinates, then parameters of sites, the time with its energy, the scale
/// of a contact form. Each but the first may be absent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateLayout {
    own: usize,
    sites: usize,
    has_clock: bool,
    has_scale: bool,
}

/// Places of t and of e, its energy, in a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clock {
    /// Place of t.
    pub time: usize,
    /// Place of e.
    pub energy: usize,
}

impl Clock {
    /// The clock behind so many other coordinates.
    pub fn behind(coordinates: usize) -> Self {
        Self {
            time: coordinates,
            energy: coordinates + 1,
        }
    }

    /// The place of what stands behind it.
    pub fn end(self) -> usize {
        self.energy + 1
    }
}

impl StateLayout {
    /// Layout of so many own coordinates and parameters of sites.
    pub fn new(own: usize, sites: usize) -> Self {
        Self {
            own,
            sites,
            has_clock: false,
            has_scale: false,
        }
    }

    /// The same with the time and its energy, if so.
    #[must_use]
    pub fn with_clock(mut self, has_clock: bool) -> Self {
        self.has_clock = has_clock;
        self
    }

    /// The same with the scale of a contact form, if so.
    #[must_use]
    pub fn with_scale(mut self, has_scale: bool) -> Self {
        self.has_scale = has_scale;
        self
    }

    /// The number of own coordinates.
    pub fn coordinates(&self) -> usize {
        self.own
    }

    /// The places of own coordinates.
    pub fn own(&self) -> Range<usize> {
        0..self.own
    }

    /// The places of parameters of sites.
    pub fn sites(&self) -> Range<usize> {
        self.own..self.own + self.sites
    }

    /// The places of t and e, where the time is a coordinate.
    pub fn clock(&self) -> Option<Clock> {
        self.has_clock.then(|| Clock::behind(self.sites().end))
    }

    /// The place of the scale of a contact form.
    pub fn scale(&self) -> Option<usize> {
        let before = self.clock().map_or(self.sites().end, Clock::end);
        self.has_scale.then_some(before)
    }

    /// The number of all.
    pub fn dimension(&self) -> usize {
        let before = self.clock().map_or(self.sites().end, Clock::end);
        before + usize::from(self.has_scale)
    }

    /// The places of what is of the motion, and not made for it: all but e and the scale, which are the last.
    pub fn moving(&self) -> Range<usize> {
        let energy = self.clock().map(|clock| clock.energy);
        0..energy.or(self.scale()).unwrap_or(self.dimension())
    }

    /// The places of everything but own coordinates.
    pub fn beside(&self) -> Range<usize> {
        self.own..self.dimension()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_its_parts_one_behind_the_other() {
        for (own, sites) in [(3, 0), (4, 2), (0, 0)] {
            for (has_clock, has_scale) in
                [(false, false), (true, false), (false, true), (true, true)]
            {
                let layout = StateLayout::new(own, sites)
                    .with_clock(has_clock)
                    .with_scale(has_scale);
                let clock = layout.clock().into_iter();
                let parts = layout.own().chain(layout.sites());
                let parts = parts.chain(clock.flat_map(|clock| [clock.time, clock.energy]));
                let parts: Vec<usize> = parts.chain(layout.scale()).collect();
                assert!(
                    parts.iter().copied().eq(0..layout.dimension()),
                    "{layout:?}"
                );
                assert_eq!(layout.own().end, layout.beside().start);
                let last = usize::from(has_clock) + usize::from(has_scale);
                assert_eq!(layout.moving().end, layout.dimension() - last);
            }
        }
    }
}
