//! Ranges of sites: of rows, between them, and of a box without another.

use std::ops::Range;

use super::geometry::{LatticeGeometry, SiteBox};

/// The ranges between rows.
pub(super) fn gaps(rows: &[Range<usize>]) -> impl Iterator<Item = Range<usize>> {
    let pairs = rows.windows(2);
    pairs.map(|rows| rows[0].end..rows[1].start)
}

/// How many sites there are in ranges.
pub(super) fn total(ranges: &[Range<usize>]) -> usize {
    ranges.iter().map(Range::len).sum()
}

/// Ranges without others, both in the order of the sites.
pub(super) fn without(
    ranges: &[Range<usize>],
    others: &[Range<usize>],
    left: &mut Vec<Range<usize>>,
) {
    left.clear();
    let mut others = others.iter().peekable();
    for range in ranges {
        let mut start = range.start;
        while let Some(other) = others.peek().filter(|other| other.start < range.end) {
            if other.start > start {
                left.push(start..other.start);
            }
            start = start.max(other.end);
            if other.end > range.end {
                break;
            }
            others.next();
        }
        if start < range.end {
            left.push(start..range.end);
        }
    }
}

/// The sites of a box that are not in an inner one, in ranges.
pub(super) fn rest(
    whole: SiteBox,
    inner: SiteBox,
    geometry: &LatticeGeometry,
) -> Vec<Range<usize>> {
    let axes = geometry.axes.len();
    let last = axes.saturating_sub(1);
    let (rows, length) = whole.rows(axes);
    let mut left = Vec::new();
    for place in rows {
        let start = geometry.site(place);
        let mut middle = place;
        middle[last] = inner.start[last];
        let ranges = match inner.sites() > 0 && inner.has(middle) {
            true => {
                let [before, behind] =
                    [inner.start[last], inner.end[last]].map(|at| start + (at - whole.start[last]));
                [start..before, behind..start + length]
            }
            false => [start..start + length, 0..0],
        };
        left.extend(ranges.into_iter().filter(|range| !range.is_empty()));
    }
    left
}
