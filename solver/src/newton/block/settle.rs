//! The solution that is connected with the state, where a lane's own is not plainly that.

use leafwise_expression::Workspace;

use super::Block;
use super::masks::{guard_ratio, ratio_in_own_units, take_guard};
use crate::elimination::Rows;
use crate::error::StepError;
use crate::judge::{all_finite, inside_chart};
use crate::newton::convergence::Convergence;

impl<const W: usize, const D: usize, V: Rows<W>, M: Rows<W>> Block<W, D, V, M> {
    /// Makes sure that a lane's solution is the one connected with the state, and takes that where the
    /// solve found another or none.
    #[cold]
    pub(super) fn settle(&mut self, w: usize) {
        let d = self.dimension;
        // An iterate that led out of the chart says nothing of the solution that begins at the state, nor does one found outside
        // from a series that need not converge.
        let may_be_inside = self.lanes[w].is_astray || !self.start.is_known(w);
        if let Err(error) = &self.outcome[w]
            && !error.is_of_a_solve()
            && !(may_be_inside && matches!(error, StepError::LeftChart { .. }))
        {
            return;
        }
        let (x, low) = (self.x.as_ref(), self.low.as_ref());
        for i in 0..d {
            self.from[i] = x[i][w];
            self.found[i] = self.y.as_ref()[i][w];
        }
        let (kernel, full, halved, y, from) = (
            &self.kernel.full,
            &mut self.full,
            &mut self.halved,
            self.y.as_mut(),
            &self.from,
        );
        let bases = self.kernel.bases;
        let (parameters, epsilon, h) = (&self.parameters, self.epsilon, self.h);
        let prepare = |full: &mut Workspace, part: f64| {
            kernel.prepare(full, parameters, &[epsilon; W], &[part * h; W]);
        };
        let (mut spent, mut prepared) = (0, 1.0);
        let solved = std::mem::replace(&mut self.outcome[w], Ok(()));
        let settled = self.branch.settle(
            from,
            from,
            solved.map(|()| &self.found[..]),
            &mut spent,
            |part, point, residual, jacobian| {
                // Most paths look at the middle and the end, and no other part is prepared.
                let workspace = if part == 0.5 {
                    halved.get_or_insert_with(|| {
                        let mut workspace = kernel.workspace(W);
                        prepare(&mut workspace, part);
                        workspace
                    })
                } else {
                    if part != prepared {
                        prepare(full, part);
                        prepared = part;
                    }
                    &mut *full
                };
                for i in 0..d {
                    y[i][w] = point[i];
                }
                let (base, ends) = kernel.evaluate_rows(workspace, y).split_at(bases);
                let (ends, rest) = ends.split_at(2 * d);
                for i in 0..d {
                    let base = if bases == 0 { point[i] } else { base[i][w] };
                    residual[i] = from[i] - base - ends[i][w] + low[i][w];
                }
                for (entry, row) in jacobian.iter_mut().zip(rest) {
                    *entry = row[w];
                }
                all_finite(residual, jacobian, "a Newton correction")?;
                let mut guard = [[0.0; W]; 2];
                let rows = &rest[2 * d * d..];
                take_guard(&[true; W], &mut guard, rows);
                match self.kernel.guards_series && rows.len() == 2 * d {
                    true if ratio_in_own_units(self.x.as_ref(), rows, w) < 1.0 => Ok(()),
                    _ => inside_chart(guard_ratio(&guard, w)),
                }
            },
        );
        if prepared != 1.0 {
            prepare(full, 1.0);
        }
        let goal = match settled {
            Ok(false) => self.branch.end(),
            _ => &self.found,
        };
        for (y, goal) in self.y.as_mut().iter_mut().zip(goal) {
            y[w] = *goal;
        }
        self.lanes[w].jacobians += u32::try_from(spent).unwrap_or(u32::MAX);
        match settled {
            Ok(true) => {}
            Ok(false) => {
                // What the other solution told, of sizes and convergence, says nothing of this one.
                let lane = &mut self.lanes[w];
                let before = lane.convergence.evaluations;
                lane.convergence = Convergence::new();
                lane.next = lane.convergence.start(None, 0);
                for (i, end) in self.branch.end().iter().enumerate() {
                    let from = self.from[i];
                    self.allowed.as_mut()[i][w] = from.abs() + (end - from).abs();
                    self.smallest.as_mut()[i][w] = f64::INFINITY;
                }
                let mut y = self.y.take();
                self.iterate(y.as_mut());
                self.y = y;
                self.lanes[w].convergence.evaluations += before;
                for (found, y) in self.found.iter_mut().zip(self.y.as_ref()) {
                    *found = y[w];
                }
                if self.outcome[w].is_ok() {
                    self.outcome[w] = self.branch.confirm_end(&self.found);
                }
            }
            Err(error) => self.outcome[w] = Err(error),
        }
        self.lanes[w].convergence.evaluations += u32::try_from(spent).unwrap_or(u32::MAX);
    }
}
