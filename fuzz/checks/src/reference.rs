//! An independent solution: the explicit midpoint rule extrapolated, with a step that adapts
//! (Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, section II.9).

/// Substeps of the columns: order 2 · 7 at the last.
const SUBSTEPS: [usize; 7] = [2, 4, 6, 8, 10, 12, 14];

/// The error of a step relative to each component's size on the way.
const TOLERANCE: f64 = 1e-13;

/// Steps after which it gives up: the solution is too stiff, or ends.
const MOST_STEPS: usize = 4000;

/// A solution at equal intervals.
pub struct Solution {
    /// x_0 first.
    pub states: Vec<Vec<f64>>,
    /// The shortest step that it took, in intervals, but for those that end at an interval's end.
    pub shortest: f64,
    /// The states after each of its steps within the last interval.
    pub ends: Vec<Vec<f64>>,
}

/// The solution of x′ = f(x) at `times` equal intervals of length `interval`; `None` where it ends
/// or cannot be followed. `widest` takes each coordinate's largest size on the way.
pub fn solution(
    field: &dyn Fn(&[f64]) -> Vec<f64>,
    initial: &[f64],
    interval: f64,
    times: usize,
    widest: &mut [f64],
) -> Option<Solution> {
    let mut x = initial.to_vec();
    let mut states = vec![x.clone()];
    let mut step = interval / 16.0;
    let mut steps = 0;
    let mut shortest = 1.0_f64;
    let mut ends = Vec::new();
    for _ in 0..times {
        ends = vec![x.clone()];
        let mut done = 0.0;
        while done < interval {
            let remains = interval - done;
            let is_last = step >= 0.999 * remains;
            let trial = if is_last { remains } else { step };
            let (next, error) = extrapolated(field, &x, trial);
            steps += 1;
            if steps > MOST_STEPS || trial < 1e-10 * interval {
                return None;
            }
            let size = |at: usize| x[at].abs().max(1e-6 * widest[at]).max(1e-300);
            let worst = (0..x.len()).map(|at| error[at].abs() / size(at));
            let worst = worst.fold(0.0, |m: f64, e| if e > m || e.is_nan() { e } else { m });
            let factor = libm::pow(TOLERANCE / worst.max(1e-30), 1.0 / 13.0);
            let is_taken = worst <= 8.0 * TOLERANCE;
            if !is_taken {
                step = trial
                    * if factor.is_finite() {
                        (0.9 * factor).clamp(0.1, 0.8)
                    } else {
                        0.1
                    };
                continue;
            }
            x = next;
            ends.push(x.clone());
            if !is_last {
                shortest = shortest.min(trial / interval);
            }
            for (widest, x) in widest.iter_mut().zip(&x) {
                *widest = widest.max(x.abs());
            }
            done = if is_last { interval } else { done + trial };
            step = trial * (0.9 * factor).clamp(0.3, 3.0);
        }
        states.push(x.clone());
    }
    Some(Solution {
        states,
        shortest,
        ends,
    })
}

/// One step, of order 14, and its error.
pub fn extrapolated(
    field: &dyn Fn(&[f64]) -> Vec<f64>,
    x: &[f64],
    step: f64,
) -> (Vec<f64>, Vec<f64>) {
    let slope = field(x);
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut change = vec![f64::NAN; x.len()];
    for (row, &count) in SUBSTEPS.iter().enumerate() {
        let part = step / count as f64;
        // Increments, so that little is lost to the state's round-off.
        let mut before = vec![0.0; x.len()];
        let mut now: Vec<f64> = slope.iter().map(|f| part * f).collect();
        let at = |increment: &[f64]| -> Vec<f64> {
            x.iter().zip(increment).map(|(x, i)| x + i).collect()
        };
        for _ in 1..count {
            let f = field(&at(&now));
            let next = before
                .iter()
                .zip(&f)
                .map(|(b, f)| b + 2.0 * part * f)
                .collect();
            before = std::mem::replace(&mut now, next);
        }
        let f = field(&at(&now));
        let smoothed = (0..x.len()).map(|i| 0.5 * (now[i] + before[i] + part * f[i]));
        let mut entry: Vec<f64> = smoothed.collect();
        // Neville's scheme in the squared substep.
        for (column, previous) in columns.iter_mut().enumerate() {
            let ratio = count as f64 / SUBSTEPS[row - column - 1] as f64;
            let weight = 1.0 / (ratio * ratio - 1.0);
            let better: Vec<f64> = entry
                .iter()
                .zip(previous.iter())
                .map(|(e, p)| e + (e - p) * weight)
                .collect();
            *previous = std::mem::replace(&mut entry, better);
        }
        let last = columns.last();
        change = (0..x.len())
            .map(|i| entry[i] - last.map_or(f64::NAN, |last| last[i]))
            .collect();
        columns.push(entry);
    }
    let end = columns.last().map(Vec::as_slice).unwrap_or_default();
    (x.iter().zip(end).map(|(x, e)| x + e).collect(), change)
}
