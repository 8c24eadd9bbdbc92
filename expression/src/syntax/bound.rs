//! Indices with their values, inside one another.

/// A site that a caller is at: the names of its indices, one an axis or empty, and its number, the last axis fastest.
pub type At<'a> = (&'a [&'a str], usize);

/// An index with its value, and the ones around it.
#[derive(Clone, Copy)]
pub(super) struct Bound<'a> {
    pub(super) name: &'a str,
    pub(super) value: usize,
    /// How many values it takes.
    pub(super) length: usize,
    /// 0 for the index that the caller gives, and one more for each sum.
    pub(super) level: usize,
    pub(super) outer: Option<&'a Bound<'a>>,
}

/// The binding of `name` in `bound`.
pub(super) fn find<'a>(bound: Option<&'a Bound<'a>>, name: &str) -> Option<&'a Bound<'a>> {
    std::iter::successors(bound, |inner| inner.outer).find(|index| index.name == name)
}

/// Calls `then` with each name bound to its value of so many, inside `outer`.
pub(super) fn bind<R>(
    names: &[&str],
    values: &[(usize, usize)],
    level: usize,
    outer: Option<&Bound<'_>>,
    then: &mut dyn FnMut(Option<&Bound<'_>>) -> R,
) -> R {
    match (names, values) {
        // A number stands along this axis.
        (["", names @ ..], [_, values @ ..]) => bind(names, values, level, outer, then),
        ([name, names @ ..], [(value, length), values @ ..]) => {
            let bound = Bound {
                name,
                value: *value,
                length: *length,
                level,
                outer,
            };
            bind(names, values, level, Some(&bound), then)
        }
        _ => then(outer),
    }
}
