//! Where more work no longer makes less error.

/// An error that is small enough, relative to the state, for a plateau to be round-off.
pub(super) const SMALL: f64 = 1e-8;

/// Watches whether more cost still makes less error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plateau {
    /// The least error so far.
    pub least: f64,
    cost: u64,
    without_gain: u32,
}

impl Default for Plateau {
    fn default() -> Self {
        Self {
            least: f64::INFINITY,
            cost: 0,
            without_gain: 0,
        }
    }
}

impl Plateau {
    /// Takes in the next run; tells whether two costlier ones in a row gained less than a tenth.
    pub fn is_reached(&mut self, error: f64, cost: u64) -> bool {
        if error < 0.9 * self.least {
            self.without_gain = 0;
        } else if cost > self.cost {
            self.without_gain += 1;
        }
        self.cost = self.cost.max(cost);
        self.least = self.least.min(error);
        self.without_gain >= 2
    }
}
