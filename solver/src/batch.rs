//! One evaluation at many points, and which of them failed.

use crate::error::StepError;

/// Lets `evaluate` write the results at all points, contiguous: `inputs` numbers of `z` and
/// `outputs` of `out` each. Where that fails the points are taken one by one, and those that fail are
/// handed over.
#[inline]
pub fn batch(
    (inputs, outputs): (usize, usize),
    z: &[f64],
    out: &mut [f64],
    mut failed: impl FnMut(usize, StepError),
    mut evaluate: impl FnMut(&[f64], &mut [f64]) -> Result<(), StepError>,
) {
    if z.len() == inputs {
        if let Err(error) = evaluate(z, out) {
            failed(0, error);
        }
        return;
    }
    assert_eq!(z.len() / inputs * outputs, out.len(), "results of a batch");
    if evaluate(z, out).is_ok() {
        return;
    }
    let points = z.chunks_exact(inputs).zip(out.chunks_exact_mut(outputs));
    for (at, (z, out)) in points.enumerate() {
        if let Err(error) = evaluate(z, out) {
            failed(at, error);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::batch;
    use crate::error::StepError;

    /// 2 z₁ + z₂ where z₁ is positive.
    fn evaluate(z: &[f64], out: &mut [f64]) -> Result<(), StepError> {
        for at in 0..out.len() {
            if z[2 * at] <= 0.0 {
                return Err(StepError::NoTangent);
            }
            out[at] = 2.0 * z[2 * at] + z[2 * at + 1];
        }
        Ok(())
    }

    #[test]
    fn only_the_points_that_fail_have_no_result() {
        let z = [1.0, 2.0, -1.0, 5.0, 3.0, 4.0, 0.0, 1.0];
        let (mut out, mut failures) = ([f64::NAN; 4], Vec::new());
        let mut calls = Vec::new();
        let fail = |at, error| failures.push((at, error));
        batch((2, 1), &z, &mut out, fail, |z, out| {
            calls.push(out.len());
            evaluate(z, out)
        });
        assert_eq!(failures, [1, 3].map(|at| (at, StepError::NoTangent)));
        assert_eq!((out[0], out[2]), (4.0, 10.0));
        assert_eq!(calls, [4, 1, 1, 1, 1]);
        // What does not fail is one call.
        let good = [1.0, 2.0, 3.0, 4.0];
        let mut calls = 0;
        batch(
            (2, 1),
            &good,
            &mut out[..2],
            |_, _| unreachable!("defined"),
            |z, out| {
                calls += 1;
                evaluate(z, out)
            },
        );
        assert_eq!((out[0], out[1], calls), (4.0, 10.0, 1));
    }
}
