//! The solution that is connected with the state before the step.

use super::DenseFactors;
use super::judge::{Reached, SMALLEST_SCALE, larger, reach, settled};
use crate::error::StepError;

/// A part of the way is taken where Newton's corrections fall by this factor: by Kantorovich's theorem
/// the solution is then the only one nearby.
const CONTRACTS: f64 = 0.25;

/// The smallest part of the way that is tried.
const SHORTEST: f64 = 1.0 / 1024.0;

/// Two points that differ by less than this part of the unknowns are the same solution. Newton's last
/// correction at a point of the path is smaller.
const SAME: f64 = 1e-6;

/// Corrections that fall by so much each are small enough after so many.
const MOST_CORRECTIONS: usize = 12;

/// A path that takes more evaluations than this leads nowhere.
const MOST_EVALUATIONS: u64 = 1000;

/// Follows the solutions u of F_s(u) = 0 from u₀ at s = 0 to s = 1, by Newton's method.
///
/// F_s is the equation of a step s times as long, and u₀ its solution for a step of size 0. That is y = x for
/// β̂(L(y)) = x, and all stages at the state for a Runge–Kutta method. DF_0 is the identity, so that along the branch
/// that begins there the determinant of DF_s is positive until the branch folds. Newton's method alone may jump to
/// another, on which the map is not near the flow, and which one it takes may depend on earlier steps.
///
/// Over the graph of a one-form θ that of sθ will do. Where neither is at hand, F_s = F − (1 − s) F(u₀) is followed.
/// Its path ends at the same solution where the determinants of both families stay positive between them.
#[derive(Clone, Debug)]
pub struct Branch {
    point: Vec<f64>,
    trial: Vec<f64>,
    /// Where a part began, and where it ends when it is taken at once; the last two points of its quarters.
    part: Vec<f64>,
    at_once: Vec<f64>,
    before: Vec<f64>,
    last: Vec<f64>,
    /// −F at the trial, then Newton's correction; DF there, then DF − 1.
    residual: Vec<f64>,
    jacobian: Vec<f64>,
    /// Scales that the unknowns are measured against, and the least of them: what the others put into an unknown.
    scale: Vec<f64>,
    least: Vec<f64>,
    /// Round-off that the others put into an unknown: at first hand, and with that at second.
    hands: [Vec<f64>; 2],
    /// Which of them have begun to move, and whether others have moved.
    begins: Vec<bool>,
    has_others: bool,
    factors: DenseFactors,
    reached: Reached,
}

impl Branch {
    /// Room for equations in n unknowns.
    pub fn new(n: usize) -> Self {
        Self {
            point: vec![0.0; n],
            trial: vec![0.0; n],
            part: vec![0.0; n],
            before: vec![0.0; n],
            last: vec![0.0; n],
            at_once: vec![0.0; n],
            residual: vec![0.0; n],
            jacobian: vec![0.0; n * n],
            scale: vec![0.0; n],
            least: vec![0.0; n],
            hands: [vec![0.0; n], vec![0.0; n]],
            begins: vec![false; n],
            has_others: false,
            factors: DenseFactors::new(n),
            reached: Reached::new(n),
        }
    }

    /// Follows the path from `start` and makes sure that what was `solved` at s = 1 is its end. The closure
    /// `evaluate` writes −F_s(u) and DF_s(u), row-major, for s and u. The unknowns are measured against `sizes`,
    /// beside the way that they came. Counts the evaluations.
    ///
    /// Returns `false` where it is not, or where nothing was found. The solve is then to begin again at the
    /// [`end`](Self::end), and what it finds is to be [confirmed](Self::confirm_end).
    ///
    /// # Errors
    /// [`StepError::OtherBranch`] where DF becomes singular on the way. Where F has no value there, the error of the
    /// solve, or of `evaluate` if the solve had none.
    pub fn settle(
        &mut self,
        start: &[f64],
        sizes: &[f64],
        solved: Result<&[f64], StepError>,
        evaluations: &mut u64,
        evaluate: impl FnMut(f64, &[f64], &mut [f64], &mut [f64]) -> Result<(), StepError>,
    ) -> Result<bool, StepError> {
        let found = solved.as_ref().ok().copied();
        let path = self.follow(start, sizes, found, evaluations, evaluate);
        match (path, solved) {
            (Ok(()), solved) => Ok(solved.is_ok_and(|found| self.ends_at(found))),
            (Err(error), Ok(_)) | (Err(error @ StepError::OtherBranch { .. }), Err(_)) => {
                Err(error)
            }
            (Err(_), Err(error)) => Err(error),
        }
    }

    /// Refuses a solution that is not the end of the last path.
    ///
    /// # Errors
    /// [`StepError::OtherBranch`].
    pub fn confirm_end(&self, point: &[f64]) -> Result<(), StepError> {
        match self.ends_at(point) {
            true => Ok(()),
            false => Err(StepError::OtherBranch { reached: 1.0 }),
        }
    }

    /// Goes the path from `start` to its end, as [`settle`](Self::settle) says. Where a solution was
    /// `found` at s = 1 and the way by quarters leads to it, that will do.
    fn follow(
        &mut self,
        start: &[f64],
        sizes: &[f64],
        found: Option<&[f64]>,
        evaluations: &mut u64,
        mut evaluate: impl FnMut(f64, &[f64], &mut [f64], &mut [f64]) -> Result<(), StepError>,
    ) -> Result<(), StepError> {
        let begin = [start, sizes];
        self.point.copy_from_slice(start);
        let most = *evaluations + MOST_EVALUATIONS;
        let mut counted = |s: f64, u: &[f64], residual: &mut [f64], jacobian: &mut [f64]| {
            if *evaluations >= most {
                return Err(StepError::OtherBranch { reached: s });
            }
            *evaluations += 1;
            evaluate(s, u, residual, jacobian)
        };
        if let Some(found) = found
            && self.confirm(begin, found, &mut counted).is_ok()
        {
            return Ok(());
        }
        let (mut reached, mut part) = (0.0, 1.0);
        loop {
            let goal = reached + part;
            match self.advance(begin, reached, goal, &mut counted) {
                Ok(()) if goal >= 1.0 => return Ok(()),
                Ok(()) => {
                    reached = goal;
                    part = (2.0 * part).min(1.0 - reached);
                }
                Err(_) if part > SHORTEST => part *= 0.5,
                Err(None) => return Err(StepError::OtherBranch { reached }),
                Err(Some(error)) => return Err(error),
            }
        }
    }

    /// From the start, and its sizes, to the solution that was found at s = 1, by quarters, each foreseen by the one before.
    fn confirm(
        &mut self,
        begin: [&[f64]; 2],
        found: &[f64],
        evaluate: &mut impl FnMut(f64, &[f64], &mut [f64], &mut [f64]) -> Result<(), StepError>,
    ) -> Result<(), Option<StepError>> {
        let confirmed = self.go(begin, [0.0, 1.0], &[0.25, 0.5, 0.75, 1.0], evaluate);
        if confirmed.is_ok() && self.ends_at(found) {
            return Ok(());
        }
        self.point.copy_from_slice(begin[0]);
        confirmed.and(Err(None))
    }

    /// From the solution at `reached` to that at `goal`, at once and by way of the middle. Where the force turns over on the way,
    /// corrections may fall fast towards another solution, but hardly towards the same one by both ways.
    fn advance(
        &mut self,
        begin: [&[f64]; 2],
        reached: f64,
        goal: f64,
        evaluate: &mut impl FnMut(f64, &[f64], &mut [f64], &mut [f64]) -> Result<(), StepError>,
    ) -> Result<(), Option<StepError>> {
        self.part.copy_from_slice(&self.point);
        self.correct(begin, goal, evaluate)?;
        std::mem::swap(&mut self.point, &mut self.at_once);
        self.point.copy_from_slice(&self.part);
        let by_way = self.go(begin, [reached, goal], &[0.5, 1.0], evaluate);
        if by_way.is_ok() && self.ends_at(&self.at_once) {
            return Ok(());
        }
        self.point.copy_from_slice(&self.part);
        by_way.and(Err(None))
    }

    /// From the solution at `from` by `parts` of the way to that at `goal`. Of quarters each but the first begins where the one
    /// before leads straight on.
    fn go(
        &mut self,
        begin: [&[f64]; 2],
        [from, goal]: [f64; 2],
        parts: &[f64],
        evaluate: &mut impl FnMut(f64, &[f64], &mut [f64], &mut [f64]) -> Result<(), StepError>,
    ) -> Result<(), Option<StepError>> {
        for (at, part) in parts.iter().enumerate() {
            std::mem::swap(&mut self.before, &mut self.last);
            self.last.copy_from_slice(&self.point);
            if parts.len() > 2 && at > 0 {
                for (u, before) in self.point.iter_mut().zip(&self.before) {
                    *u += *u - before;
                }
            }
            self.correct(begin, from + part * (goal - from), evaluate)?;
        }
        Ok(())
    }

    /// Solves F_s(u) = 0 by Newton's method from the point, which then is the solution. Fails where corrections do
    /// not fall or the determinant is not positive. Where F has no value, it fails with that as a reason.
    fn correct(
        &mut self,
        begin: [&[f64]; 2],
        s: f64,
        evaluate: &mut impl FnMut(f64, &[f64], &mut [f64], &mut [f64]) -> Result<(), StepError>,
    ) -> Result<(), Option<StepError>> {
        self.take_scale(begin);
        self.trial.copy_from_slice(&self.point);
        let mut last = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            evaluate(s, &self.trial, &mut self.residual, &mut self.jacobian).map_err(Some)?;
            let is_regular = self.factors.factor_of_sizes(&self.jacobian, &self.scale);
            if !is_regular || !self.factors.has_positive_determinant() {
                return Err(None);
            }
            self.factors.solve(&mut self.residual);
            self.take_least();
            let (size, next, settled) = self.measure();
            let falls = size <= SAME || size <= CONTRACTS * last;
            if !falls && (size.is_nan() || !self.is_round_off()) {
                return Err(None);
            }
            for (u, correction) in self.trial.iter_mut().zip(&self.residual) {
                *u += correction;
            }
            if size <= SAME && settled {
                self.take_reached();
            }
            if size <= SAME && settled || !falls {
                self.point.copy_from_slice(&self.trial);
                return Ok(());
            }
            last = next;
        }
        Err(None)
    }

    /// Sets the scales of the unknowns: `sizes` and how far they came.
    fn take_scale(&mut self, [start, sizes]: [&[f64]; 2]) {
        let own = sizes.iter().zip(self.point.iter().zip(start));
        for (scale, (size, (point, start))) in self.scale.iter_mut().zip(own) {
            *scale = size.abs() + (point - start).abs();
        }
        self.begins.fill(false);
        self.has_others = false;
    }

    /// Sets the least scales. A component may be the round-off of what the others put into it, at first hand and, by
    /// the elimination, at second. That is N s + N² s with N = |DF − 1|, as far as DF⁻¹ does not take it back.
    fn take_least(&mut self) {
        let n = self.scale.len();
        for (i, row) in self.jacobian.chunks_exact_mut(n).enumerate() {
            row[i] -= 1.0;
        }
        let rows = || self.jacobian.chunks_exact(n);
        let [first, both] = &mut self.hands;
        for (first, row) in first.iter_mut().zip(rows()) {
            *first = reach(row, &self.scale);
        }
        for ((both, first_hand), row) in both.iter_mut().zip(&*first).zip(rows()) {
            *both = first_hand + reach(row, first);
        }
        for ((least, own), row) in self.least.iter_mut().zip(&*both).zip(rows()) {
            // Of hands that grow by g each, g s + g² s at most s is left.
            let own_again = reach(row, both);
            *least = SAME * settled(settled(*own, own_again), own_again);
        }
    }

    /// Raises the least scales to what the round-off of all that are settled puts into an unknown, at whatever hand.
    fn take_reached(&mut self) {
        let own = self.scale.iter().zip(&self.residual);
        for (size, (scale, correction)) in self.reached.sizes.iter_mut().zip(own) {
            let is_settled = correction.abs() <= SAME * scale;
            *size = if is_settled { *scale } else { 0.0 };
        }
        let factors = &self.factors;
        self.reached.add(&mut |right| factors.solve(right));
        for (least, size) in self.least.iter_mut().zip(&self.reached.sizes) {
            *least = larger(*least, SAME * size);
        }
    }

    /// Whether corrections that do not fall are the round-off of settled unknowns in others.
    fn is_round_off(&mut self) -> bool {
        self.take_reached();
        let scales = self.scale.iter().zip(&self.least);
        let mut pairs = self.residual.iter().zip(scales);
        pairs.all(|(correction, (scale, least))| correction.abs() <= SAME * larger(*scale, *least))
    }

    /// Largest relative correction of the unknowns that corrections must fall in. With it come the size that the next
    /// ones are compared with, and whether the others are settled.
    ///
    /// An unknown that moves farther than by its size begins to move, from 0 or from the little that it came, as the
    /// others drive it. Its corrections fall when theirs have. They count, from the next one on, where no others have
    /// moved.
    fn measure(&mut self) -> (f64, f64, bool) {
        let (mut moving, mut begun, mut begins) = (0.0, 0.0, false);
        for (i, correction) in self.residual.iter().enumerate() {
            let own = correction.abs();
            let size = own / (larger(self.scale[i], self.least[i]) + SMALLEST_SCALE);
            if size > 1.0 && size.is_finite() {
                (begins, self.begins[i]) = (true, true);
                self.scale[i] += own;
            } else if self.begins[i] {
                begun = larger(begun, size);
            } else {
                self.has_others |= own > 0.0;
                moving = larger(moving, size);
            }
        }
        if self.has_others {
            return (moving, moving, begun <= SAME && !begins);
        }
        (begun, if begins { 1.0 } else { begun }, !begins)
    }

    /// Where the last path ended.
    pub fn end(&self) -> &[f64] {
        &self.point
    }

    /// Whether a point is the end of the last path, and not another solution.
    fn ends_at(&self, point: &[f64]) -> bool {
        let scales = self.scale.iter().zip(&self.least);
        let mut pairs = self.point.iter().zip(point).zip(scales);
        pairs.all(|((a, b), (scale, least))| {
            (a - b).abs() <= SAME * (larger(*scale, *least) + SMALLEST_SCALE)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Branch;
    use crate::error::StepError;

    /// y + a sin y = x, the implicit midpoint rule of a pendulum with a = t²/4: from y = x.
    fn pendulum(a: f64, x: f64) -> Result<f64, StepError> {
        let mut branch = Branch::new(1);
        let found = branch.follow(&[x], &[x], None, &mut 0, |s, y, residual, jacobian| {
            let a = a * s * s;
            residual[0] = x - y[0] - a * libm::sin(y[0]);
            jacobian[0] = 1.0 + a * libm::cos(y[0]);
            Ok(())
        });
        found.map(|()| branch.end()[0])
    }

    /// The branch itself, by steps of a from 0.
    fn continued(a: f64, x: f64) -> f64 {
        let mut y = x;
        for k in 1..=4000 {
            let a = a * f64::from(k) / 4000.0;
            for _ in 0..3 {
                y += (x - y - a * libm::sin(y)) / (1.0 + a * libm::cos(y));
            }
        }
        y
    }

    #[test]
    fn what_is_found_is_the_branch_from_the_state_itself() {
        for a in [0.2, 0.7, 0.99, 1.5, 2.25, 6.0] {
            for k in -60..=60 {
                let x = 0.1 * f64::from(k);
                let y = pendulum(a, x).expect("the branch does not fold");
                let error = (y - continued(a, x)).abs();
                assert!(error <= 1e-8 * (1.0 + x.abs()), "a = {a}, x = {x}: {y}");
            }
        }
    }

    /// y − a y² = x has the branch y = (1 − √(1 − 4ax))/(2a) up to its fold at 4ax = 1.
    /// y + a sin y = f, z = y² from y = z = 0: no unknown has a size, and z none in the first correction.
    /// u' = 1 and chains v' = u⁴, w' = v² of implicit steps: the driven ones begin at 1e-12 and 1e-25 of the first, and grow
    /// by more than their size from one correction to the next. A way of few evaluations, whatever their units.
    #[test]
    fn what_is_driven_at_a_high_order_settles_after_what_drives_it() {
        for unit in [1.0, 1e-30, 1e30] {
            let mut branch = Branch::new(3);
            let start = [1e-3, 1e-14, 1e-28 * unit];
            let mut evaluations = 0;
            let found = branch.follow(
                &start,
                &start,
                None,
                &mut evaluations,
                |s, y, residual, jacobian| {
                    let ([u, v, w], h) = ([y[0], y[1], y[2]], s * 0.05);
                    let fields = [1.0, libm::pow(u, 4.0), unit * v * v];
                    for (i, (y, field)) in [u, v, w].into_iter().zip(fields).enumerate() {
                        residual[i] = start[i] + h * field - y;
                    }
                    let slopes = [-4.0 * h * u * u * u, -2.0 * h * unit * v];
                    jacobian.copy_from_slice(&[
                        1.0, 0.0, 0.0, slopes[0], 1.0, 0.0, 0.0, slopes[1], 1.0,
                    ]);
                    Ok(())
                },
            );
            found.expect("the branch does not fold");
            let u = 1e-3 + 0.05;
            let v = 1e-14 + 0.05 * libm::pow(u, 4.0);
            let w = (1e-28 + 0.05 * v * v) * unit;
            for (found, exact) in branch.end().iter().zip([u, v, w]) {
                assert!((found - exact).abs() <= 1e-9 * exact, "{found} for {exact}");
            }
            // Five solves, of four evaluations at most.
            assert!(evaluations <= 20, "{evaluations}");
        }
    }

    #[test]
    fn a_path_may_begin_at_zero() {
        for (a, f) in [(0.2, 0.1), (1.5, 0.3), (1.5, 1e-12)] {
            let mut branch = Branch::new(2);
            let found = branch.follow(
                &[0.0; 2],
                &[0.0; 2],
                None,
                &mut 0,
                |s, u, residual, jacobian| {
                    let [y, z] = [u[0], u[1]];
                    residual.copy_from_slice(&[s * f - y - s * a * libm::sin(y), y * y - z]);
                    jacobian.copy_from_slice(&[1.0 + s * a * libm::cos(y), 0.0, -2.0 * y, 1.0]);
                    Ok(())
                },
            );
            found.expect("the branch does not fold");
            let y = branch.end()[0];
            // Newton's last correction is below SAME, its square below round-off.
            assert!(
                (y + a * libm::sin(y) - f).abs() <= 1e-11 * f,
                "a = {a}: {y}"
            );
        }
    }

    #[test]
    fn beyond_a_fold_there_is_nothing() {
        let x = 0.7;
        for k in 1..=100 {
            let a = 0.02 * f64::from(k);
            let mut branch = Branch::new(1);
            let found = branch.follow(&[x], &[x], None, &mut 0, |s, y, residual, jacobian| {
                residual[0] = x - y[0] + s * a * y[0] * y[0];
                jacobian[0] = 1.0 - 2.0 * s * a * y[0];
                Ok(())
            });
            let discriminant = 1.0 - 4.0 * a * x;
            if discriminant > 0.0 {
                assert_eq!(found, Ok(()), "a = {a}");
                let exact = (1.0 - libm::sqrt(discriminant)) / (2.0 * a);
                assert!(branch.ends_at(&[exact]), "a = {a}: {:?}", branch.end());
            } else {
                let reached = match found {
                    Err(StepError::OtherBranch { reached }) => reached,
                    other => panic!("a = {a}: {other:?}"),
                };
                // The fold is at s = 1/(4ax).
                let fold = 1.0 / (4.0 * a * x);
                assert!(
                    reached <= fold && reached > 0.95 * fold,
                    "a = {a}: {reached}"
                );
            }
        }
    }

    #[test]
    fn a_way_over_a_turning_force_is_not_taken_at_once() {
        // a = 4.9: from y = 3.34 Newton's corrections fall fast towards a root beyond the first.
        for k in 0..4000 {
            let x = 0.01 * f64::from(k);
            for a in [4.3, 4.9, 5.17, 6.3] {
                let Ok(y) = pendulum(a, x) else { continue };
                let error = (y - continued(a, x)).abs();
                assert!(error <= 1e-8 * (1.0 + x), "a = {a}, x = {x}: {y}");
            }
        }
    }

    /// y + s² t²/4 sin y = q + s t p/2: the midpoint of a pendulum. Whatever solution is handed over, by Newton's method
    /// from anywhere, the path ends at its own.
    #[test]
    fn no_other_solution_that_was_found_is_confirmed() {
        let mut others = 0;
        for case in 0..20_000 {
            let drawn = |k: f64| (f64::from(case) * k).fract();
            let [q, p] = [0.618_033_988, 0.754_877_666].map(|k| 3.0 * drawn(k) - 1.5);
            let t = 2.5 + 2.5 * drawn(0.569_840_290);
            let at = |s: f64, y: f64| {
                let a = 0.25 * s * s * t * t;
                let residual = q + 0.5 * s * t * p - y - a * libm::sin(y);
                (residual, 1.0 + a * libm::cos(y))
            };
            let mut own = q;
            let folds = (1..=500).any(|k| {
                (0..4).any(|_| {
                    let (residual, slope) = at(f64::from(k) / 500.0, own);
                    own += residual / slope;
                    slope <= 0.0
                })
            });
            let mut found = 16.0 * drawn(0.438_447_187) - 8.0;
            for _ in 0..30 {
                let (residual, slope) = at(1.0, found);
                found += residual / slope;
            }
            if folds || !found.is_finite() || at(1.0, found).0.abs() > 1e-12 {
                continue;
            }
            others += u32::from((found - own).abs() > 1e-3);
            let mut branch = Branch::new(1);
            let (start, found) = ([q], [found]);
            let path = branch.follow(&start, &start, Some(&found), &mut 0, |s, y, f, df| {
                (f[0], df[0]) = at(s, y[0]);
                Ok(())
            });
            if path.is_ok() {
                let error = (branch.end()[0] - own).abs();
                assert!(error <= 1e-5, "{q}, {p}, {t}, {found:?}: {error:e}");
            }
        }
        assert!(others > 2000, "{others}");
    }

    #[test]
    fn a_linear_equation_takes_one_correction() {
        let mut evaluations = 0;
        let mut branch = Branch::new(2);
        // 1 + a J with a = 1e6: far from the identity, of determinant 1 + a².
        let a = 1e6;
        let found = branch.follow(
            &[1.0, 2.0],
            &[1.0, 2.0],
            None,
            &mut evaluations,
            |s, y, residual, jacobian| {
                let a = s * a;
                residual.copy_from_slice(&[1.0 - y[0] - a * y[1], 2.0 - y[1] + a * y[0]]);
                jacobian.copy_from_slice(&[1.0, a, -a, 1.0]);
                Ok(())
            },
        );
        found.expect("a solution");
        let exact = [(1.0 - 2.0 * a) / (1.0 + a * a), (2.0 + a) / (1.0 + a * a)];
        assert!(branch.ends_at(&exact), "{:?}", branch.end());
        assert!(evaluations <= 9, "{evaluations}");
    }
}
