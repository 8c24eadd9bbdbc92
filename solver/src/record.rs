//! States after each of many steps of a lane.

/// Room for x_{k+1}, …, x_{k+n} of many steps of a lane alone, and for the evaluations up to each: what
/// [`Stepper::advance`](crate::Stepper::advance) leaves where every state is looked at.
pub struct StepRecord<'a> {
    states: &'a mut [f64],
    evaluations: &'a mut [u64],
    dimension: usize,
    made: usize,
    /// The coordinates that are recorded, where a part of a state is stepped by itself.
    rows: Option<&'a [usize]>,
}

impl<'a> StepRecord<'a> {
    /// Room for as many steps as there are `evaluations`, states of `dimension` coordinates one after the other.
    ///
    /// # Panics
    /// When `states` is of another length.
    pub fn new(states: &'a mut [f64], evaluations: &'a mut [u64], dimension: usize) -> Self {
        assert_eq!(
            states.len(),
            evaluations.len() * dimension,
            "every step has room for its state"
        );
        evaluations.fill(0);
        Self {
            states,
            evaluations,
            dimension,
            made: 0,
            rows: None,
        }
    }

    /// Records the state after one more step, and the stepper's evaluations so far.
    ///
    /// # Panics
    /// When there is no room for it.
    #[inline(always)]
    pub fn take(&mut self, state: &[f64], evaluations: u64) {
        let to = &mut self.states[self.made * self.dimension..][..self.dimension];
        match self.rows {
            None => to.copy_from_slice(state),
            Some(rows) => {
                for (row, x) in rows.iter().zip(state) {
                    to[*row] = *x;
                }
            }
        }
        // Of parts side by side those of the part that takes most count.
        let own = &mut self.evaluations[self.made];
        *own = evaluations.max(*own);
        self.made += 1;
    }

    /// The same room for the steps of a part, whose coordinates are these.
    pub(crate) fn of_part<'b>(&'b mut self, rows: &'b [usize]) -> StepRecord<'b> {
        StepRecord {
            states: self.states,
            evaluations: self.evaluations,
            dimension: self.dimension,
            made: self.made,
            rows: Some(rows),
        }
    }

    /// Forgets what was recorded.
    pub(crate) fn forget(&mut self) {
        self.evaluations[self.made..].fill(0);
    }

    /// Takes it that every part has recorded so many steps.
    pub(crate) fn end_of_parts(&mut self, made: u64) {
        self.made += made as usize;
    }
}
