//! Where errors at ever smaller steps become round-off.

/// The size of round-off, as the errors themselves show it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Floor {
    /// Its size as far as it is seen.
    pub round_off: f64,
    /// The most that may be round-off.
    most: f64,
    last: Option<(f64, f64)>,
    touched: usize,
}

impl Floor {
    /// Round-off is at least `least` and at most `most`.
    pub fn new(least: f64, most: f64) -> Self {
        Self {
            round_off: least,
            most,
            last: None,
            touched: 0,
        }
    }

    /// Takes in the error at a step smaller than those before. One that may be round-off and falls
    /// more slowly than half an order would is.
    pub fn take(&mut self, t: f64, error: f64) {
        let stands = self.last.is_some_and(|(before, largest)| {
            error <= self.most && error >= largest * libm::sqrt(t / before)
        });
        if stands {
            self.round_off = self.round_off.max(error);
        }
        self.touched = if stands || error <= self.round_off {
            self.touched + 1
        } else {
            0
        };
        self.last = Some((t, error));
    }

    /// How many errors in a row are round-off.
    pub fn touched(&self) -> usize {
        self.touched
    }
}

#[cfg(test)]
mod tests {
    use super::Floor;

    #[test]
    fn errors_that_fall_are_not_round_off() {
        let mut floor = Floor::new(1e-16, 1e-12);
        for k in 0..40 {
            let t = libm::exp2(-0.25 * f64::from(k));
            floor.take(t, 1e-3 * t);
        }
        assert_eq!((floor.round_off, floor.touched()), (1e-16, 0));
    }

    #[test]
    fn errors_that_stand_are_unless_they_are_large() {
        let mut floor = Floor::new(1e-16, 1e-12);
        for (t, error) in [
            (1.0, 1e-3),
            (0.5, 1e-3),
            (0.25, 1e-14),
            (0.2, 3e-15),
            (0.1, 4e-15),
        ] {
            floor.take(t, error);
        }
        assert_eq!((floor.round_off, floor.touched()), (4e-15, 1));
    }
}
