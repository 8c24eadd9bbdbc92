//! Places that references with indices name: variables, parameters, definitions, entries of matrices.

use super::bound::{Bound, find};
use super::error::{SyntaxError, SyntaxErrorKind};
use super::scope::{Boundary, Entry, Scope};
use super::suggestion::nearest;
use super::tree::{Anchor, Reference, Site, Span};

/// Target of a reference.
pub(super) enum Place {
    /// The state variable of this index.
    Variable(usize),
    /// The parameter of this index.
    Parameter(usize),
    /// The definition of this index.
    Definition(usize),
    /// The entry of a matrix in a row and a column.
    Entry { matrix: usize, at: [usize; 2] },
    /// Beyond an open boundary; the index of this level leads there.
    Outside { level: usize },
}

impl Scope {
    /// Target of `reference`, whose name is not an index.
    pub(super) fn place(
        &self,
        text: &str,
        reference: &Reference,
        bound: Option<&Bound<'_>>,
    ) -> Result<Place, SyntaxError> {
        let name = || reference.name.of(text).to_owned();
        let (entry, is_single) = (self.entry(text, reference)?, reference.sites.is_empty());
        let (offset, shape) = match (entry, is_single) {
            (Entry::Variable(index), true) => return Ok(Place::Variable(index)),
            (Entry::Parameter(index), true) => return Ok(Place::Parameter(index)),
            (Entry::Definition(index), true) => return Ok(Place::Definition(index)),
            (Entry::Family { offset, shape }, false) => (offset, shape),
            (Entry::Variable(_) | Entry::Parameter(_) | Entry::Definition(_), false) => {
                let kind = SyntaxErrorKind::NotAFamily { name: name() };
                return Err(SyntaxError::new(reference.span(), kind));
            }
            (Entry::Table(_), _) => {
                let kind = SyntaxErrorKind::TableWithoutPoint { name: name() };
                return Err(SyntaxError::new(reference.shown, kind));
            }
            (Entry::Matrix(matrix), _) => {
                return self.place_in_matrix(text, (matrix, reference), bound);
            }
            (Entry::Family { .. }, true) => {
                let kind = SyntaxErrorKind::IndexMissing { name: name() };
                return Err(SyntaxError::new(reference.shown, kind));
            }
        };
        let axes = shape.lengths();
        if reference.sites.len() != axes.len() {
            let kind = SyntaxErrorKind::AxesDiffer {
                name: name(),
                axes: axes.len(),
                written: reference.sites.len(),
            };
            return Err(SyntaxError::new(reference.span(), kind));
        }
        let (mut member, mut outside) = (0, None);
        for (axis, (site, length)) in reference.sites.iter().zip(axes).enumerate() {
            match self.along(text, (axis, *length), site, bound)? {
                Ok(inside) => member = member * length + inside,
                Err(Some(level)) => outside = outside.max(Some(level)),
                Err(None) => {
                    let (name, length) = (name(), *length);
                    let position = self.position(text, axis, site, bound)?.0;
                    let kind = match axes {
                        [_] => SyntaxErrorKind::IndexOutOfRange {
                            name,
                            position,
                            length,
                        },
                        _ => SyntaxErrorKind::SiteOutOfRange {
                            name,
                            axis,
                            position,
                            length,
                        },
                    };
                    return Err(SyntaxError::new(site.span, kind));
                }
            }
        }
        match outside {
            Some(level) => Ok(Place::Outside { level }),
            None => Ok(Place::Variable(offset + member)),
        }
    }

    /// Where a site is along its axis, and the level of its index.
    pub(super) fn position(
        &self,
        text: &str,
        axis: usize,
        site: &Site,
        bound: Option<&Bound<'_>>,
    ) -> Result<(i64, Option<usize>), SyntaxError> {
        let (base, level) = match site.anchor {
            Anchor::Start => (0, None),
            Anchor::End => (self.lengths().get(axis).copied().unwrap_or(0), None),
            Anchor::Name(span) => {
                let index = find(bound, span.of(text)).ok_or_else(|| unknown(text, span, bound))?;
                // An index of a longer axis would wrap, or end, elsewhere.
                let own = self.lengths().get(axis).copied().unwrap_or(0);
                if matches!(self.lengths(), [_, _, ..]) && own != index.length {
                    let kind = SyntaxErrorKind::AxesOfLengths {
                        name: span.of(text).to_owned(),
                        lengths: [index.length, own],
                    };
                    return Err(SyntaxError::new(span, kind));
                }
                (index.value, Some(index.level))
            }
        };
        Ok(((base as i64).saturating_add(site.offset), level))
    }

    /// The place along an axis of this length that a site names. Inside `Ok`, `Err` beyond its ends, with the level of
    /// the index that leads there.
    pub(super) fn along(
        &self,
        text: &str,
        (axis, length): (usize, usize),
        site: &Site,
        bound: Option<&Bound<'_>>,
    ) -> Result<Result<usize, Option<usize>>, SyntaxError> {
        let (position, level) = self.position(text, axis, site, bound)?;
        if let Anchor::Name(index) = site.anchor {
            self.check_offset(index.of(text), site, (axis, length))?;
        }
        if let Ok(inside) = usize::try_from(position)
            && inside < length
        {
            return Ok(Ok(inside));
        }
        let boundary = self.boundaries.get(axis).copied().unwrap_or_default();
        Ok(match (level, boundary) {
            (Some(_), Boundary::Periodic) if length > 0 => {
                Ok(position.rem_euclid(length as i64) as usize)
            }
            (level, _) => Err(level),
        })
    }

    /// Refuses an offset from an index of more than half of a ring: its sign says the wrong way round. The neighbours of a ring of one site
    /// are that site.
    fn check_offset(
        &self,
        index: &str,
        site: &Site,
        (axis, length): (usize, usize),
    ) -> Result<(), SyntaxError> {
        let boundary = self.boundaries.get(axis).copied().unwrap_or_default();
        let ring = match self.rings.get(axis) {
            Some(0) | None => length,
            Some(ring) => *ring,
        };
        let offset = site.offset;
        if boundary == Boundary::Open || offset.unsigned_abs() <= (ring as u64 / 2).max(1) {
            return Ok(());
        }
        let (ring_length, half) = (ring.max(1) as i128, ring as i128 / 2);
        let same = (i128::from(offset) + half).rem_euclid(ring_length) - half;
        let suggestion = match same {
            0 => index.to_owned(),
            _ => format!("{index}{same:+}"),
        };
        let kind = SyntaxErrorKind::OffsetBeyondHalf {
            axis,
            offset,
            length: ring,
        };
        Err(SyntaxError::new(site.span, kind).suggesting(Some(suggestion)))
    }
}

/// The error that the index name at `span` is not bound.
fn unknown(text: &str, span: Span, bound: Option<&Bound<'_>>) -> SyntaxError {
    let name = span.of(text);
    let known = std::iter::successors(bound, |inner| inner.outer).map(|index| index.name);
    // Index names are single letters: any bound one is what must have been meant.
    let suggestion = nearest(name, known.clone()).or_else(|| known.clone().next());
    let kind = SyntaxErrorKind::UnknownIndex {
        name: name.to_owned(),
    };
    SyntaxError::new(span, kind).suggesting(suggestion)
}
