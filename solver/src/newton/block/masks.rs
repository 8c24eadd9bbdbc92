//! Masks of lanes: operations on some of the lanes alone.

use leafwise_expression::kernel::apart;

use crate::judge::{self, larger};

/// One number of each lane.
pub(super) type Row<const W: usize> = [f64; W];

/// Whether a mask holds a lane.
#[inline(always)]
pub(super) fn any<const W: usize>(mask: &[bool; W]) -> bool {
    mask.iter().any(|lane| *lane)
}

/// values += changes in the lanes of `mask`. Where it holds all, no sum waits for what the mask was found from.
#[inline(always)]
pub(super) fn add_where<const W: usize>(
    mask: &[bool; W],
    values: &mut [Row<W>],
    changes: &[Row<W>],
) {
    if !mask.iter().all(|lane| *lane) {
        return match W {
            1 => add_nothing(),
            _ => add_some(mask, values, changes),
        };
    }
    for (value, change) in values.iter_mut().zip(changes) {
        for w in 0..W {
            value[w] += change[w];
        }
    }
}

/// A call, which no compiler makes a selection of a sum and none.
#[inline(never)]
fn add_nothing() {}

/// The same of some lanes alone; a call, which no compiler makes a selection of both sums.
#[inline(never)]
fn add_some<const W: usize>(mask: &[bool; W], values: &mut [Row<W>], changes: &[Row<W>]) {
    for (value, change) in values.iter_mut().zip(changes) {
        select(mask, value, &std::array::from_fn(|w| value[w] + change[w]));
    }
}

/// The values of the lanes in `mask`.
#[inline(always)]
pub(super) fn select<const W: usize>(mask: &[bool; W], kept: &mut Row<W>, value: &Row<W>) {
    for w in 0..W {
        kept[w] = if mask[w] { value[w] } else { kept[w] };
    }
}

/// The same of many rows.
#[inline(always)]
pub(super) fn keep<const W: usize>(mask: &[bool; W], kept: &mut [Row<W>], values: &[Row<W>]) {
    let values = &values[..kept.len()];
    if mask.iter().all(|lane| *lane) {
        for (kept, value) in kept.iter_mut().zip(values) {
            *kept = *value;
            apart::<W>();
        }
    } else {
        for (kept, value) in kept.iter_mut().zip(values) {
            select(mask, kept, value);
        }
    }
}

/// The largest entries of a guard's first and second half, NaN where one is, in the lanes of `mask`.
#[inline(always)]
pub(super) fn take_guard<const W: usize>(
    mask: &[bool; W],
    kept: &mut [Row<W>; 2],
    guard: &[Row<W>],
) {
    let (first, last) = guard.split_at(guard.len() / 2);
    for (kept, rows) in kept.iter_mut().zip([first, last]) {
        let mut size = [0.0; W];
        for row in rows {
            for w in 0..W {
                size[w] = larger(size[w], row[w].abs());
            }
        }
        select(mask, kept, &size);
    }
}

/// Whether a lane's [`guard_ratio`] is below 1.
#[inline(always)]
pub(super) fn is_inside<const W: usize>(guard: &[Row<W>; 2], w: usize) -> bool {
    let [first, last] = [guard[0][w], guard[1][w]];
    last == 0.0 || last < first
}

/// max |last| over max |first|, 0 where the last is 0; NaN where one is.
pub(super) fn guard_ratio<const W: usize>(guard: &[Row<W>; 2], w: usize) -> f64 {
    match (guard[0][w], guard[1][w]) {
        (_, 0.0) => 0.0,
        (first, last) => last / first,
    }
}

/// [`ratio_in_own_units`](judge::ratio_in_own_units) of a lane.
pub(super) fn ratio_in_own_units<const W: usize>(x: &[Row<W>], guard: &[Row<W>], w: usize) -> f64 {
    let (first, last) = guard.split_at(guard.len() / 2);
    let x: Vec<f64> = x.iter().map(|x| x[w]).collect();
    let pairs = first.iter().zip(last);
    judge::ratio_in_own_units(&x, pairs.map(|(first, last)| [first[w], last[w]]))
}

#[cfg(test)]
mod tests {
    use super::{add_where, guard_ratio, is_inside, ratio_in_own_units, take_guard};
    use crate::judge::inside_chart;

    /// A lane that is not added to keeps its bits, −0 too, and one that is has the bits that it has alone.
    #[test]
    fn sums_of_some_lanes_are_those_of_each_alone() {
        let (values, changes) = (
            [-0.0, 1.0, f64::MIN_POSITIVE],
            [0.1, f64::EPSILON / 2.0, f64::NAN],
        );
        for mask in (0..8).map(|bits| std::array::from_fn(|w| bits >> w & 1 == 1)) {
            let mut together = [values];
            add_where(&mask, &mut together, &[changes]);
            for w in 0..3 {
                let mut alone = [[values[w]]];
                add_where(&[mask[w]], &mut alone, &[[changes[w]]]);
                assert_eq!(
                    together[0][w].to_bits(),
                    alone[0][0].to_bits(),
                    "{mask:?}, lane {w}"
                );
                let expected = if mask[w] {
                    values[w] + changes[w]
                } else {
                    values[w]
                };
                assert_eq!(
                    together[0][w].to_bits(),
                    expected.to_bits(),
                    "{mask:?}, lane {w}"
                );
            }
        }
    }

    #[test]
    fn a_guard_that_is_no_number_is_outside_the_chart() {
        let guard = |first: [f64; 2], last: [f64; 2]| {
            let rows: Vec<[f64; 1]> = first.iter().chain(&last).map(|v| [*v]).collect();
            let mut guard = [[0.0]; 2];
            take_guard(&[true], &mut guard, &rows);
            let is_in = inside_chart(guard_ratio(&guard, 0)).is_ok();
            assert_eq!(is_inside(&guard, 0), is_in, "{first:?}, {last:?}");
            is_in
        };
        assert!(guard([1.0, 2.0], [0.5, 1.5]));
        assert!(guard([0.0, 0.0], [0.0, 0.0]));
        assert!(!guard([1.0, 2.0], [0.5, 2.5]));
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(!guard([1.0, 2.0], [0.5, bad]));
            assert!(!guard([1.0, 2.0], [bad, 0.5]));
        }
        assert!(!guard([f64::NAN, 2.0], [0.5, 0.5]));
        assert!(!guard([2.0, f64::NAN], [0.5, 0.5]));
    }

    /// A series of a coordinate that turns, in units in which it is the largest; the same in any others.
    #[test]
    fn own_units_tell_how_a_series_decays_where_a_large_coordinate_turns() {
        let ratio = |units: [f64; 2], x: [f64; 2], first: [f64; 2], last: [f64; 2]| {
            let rows = |values: [f64; 2]| [[values[0] * units[0]], [values[1] * units[1]]];
            let guard = [rows(first), rows(last)].concat();
            let mut whole = [[0.0]; 2];
            take_guard(&[true], &mut whole, &guard);
            (
                guard_ratio(&whole, 0),
                ratio_in_own_units(&rows(x), &guard, 0),
            )
        };
        const POWER: f64 = 1e30;
        for units in [[1.0, 1.0], [1.0, POWER], [1.0 / POWER, POWER]] {
            let (_, own) = ratio(units, [1.0, 2.0], [0.5, 0.0], [0.125, 0.25]);
            assert!((own / 0.375 - 1.0).abs() <= 4.0 * f64::EPSILON, "{own}");
            let (_, outside) = ratio(units, [1.0, 2.0], [0.5, 0.25], [0.25, 4.0]);
            assert!(outside > 1.0);
            let (_, of_no_size) = ratio(units, [1.0, 0.0], [0.5, 0.0], [0.125, 0.25]);
            assert_eq!(of_no_size, f64::INFINITY);
            let (_, at_rest) = ratio(units, [1.0, 0.0], [0.0, 0.0], [0.0, 0.0]);
            assert_eq!(at_rest, 0.0);
            assert!(
                ratio(units, [1.0, 1.0], [0.5, 0.5], [f64::NAN, 0.0])
                    .1
                    .is_nan()
            );
        }
        let (whole, own) = ratio([1.0, 1e9], [1.0, 2.0], [0.5, 0.0], [0.125, 0.25]);
        assert!(whole > 1e8 && own < 1.0);
    }
}
