//! The coordinates that a run records.

use leafwise_expression::syntax::SiteNames;
use serde::Serialize;

use super::Refusal;
use super::names::sites_by_name;
use crate::document::{ALL_STATES, Located, SceneDocument, nearest};

/// The most coordinates that stand as columns in `samples.csv`; more are recorded as `states.npy`. Where a
/// scene does not say which, all of at most so many are recorded, and none of more.
pub const WIDEST_STATE: usize = 64;

/// Coordinates `first`, `first + step`, … of one variable or family.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct StateSlice {
    /// The variable or the family.
    pub name: String,
    /// The first site; `None` for a single variable.
    pub first: Option<usize>,
    /// Sites from one coordinate to the next.
    pub step: usize,
    /// How many.
    pub count: usize,
    /// The place of the first in the state.
    #[serde(skip)]
    offset: usize,
    /// The lengths of the family's axes; none of a single variable.
    #[serde(skip)]
    axes: Vec<usize>,
    /// Names of the sites of a chain.
    #[serde(skip)]
    site_names: SiteNames,
}

impl StateSlice {
    /// The name of its k-th coordinate.
    fn name_of(&self, k: usize) -> String {
        let Some(first) = self.first else {
            return self.name.clone();
        };
        if !self.site_names.is_empty() {
            let site = self.site_names.name(first + k * self.step);
            return format!("{}[{site}]", self.name);
        }
        let (mut rest, mut place) = (first + k * self.step, Vec::new());
        for length in self.axes.iter().skip(1).rev() {
            place.push((rest % length).to_string());
            rest /= length;
        }
        place.push(rest.to_string());
        place.reverse();
        format!("{}[{}]", self.name, place.join(","))
    }
}

/// Coordinates of the state that a run records.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordedStates {
    /// Slices of the state, in the order of their columns.
    pub slices: Vec<StateSlice>,
    /// Whether the scene says so.
    pub is_chosen: bool,
    dimension: usize,
}

impl RecordedStates {
    /// The number of columns.
    pub fn width(&self) -> usize {
        self.slices.iter().map(|slice| slice.count).sum()
    }

    /// The coordinates, by their places in the state.
    pub fn coordinates(&self) -> impl Iterator<Item = usize> + '_ {
        let places = |slice: &StateSlice| {
            let (offset, step) = (slice.offset, slice.step);
            (0..slice.count).map(move |k| offset + k * step)
        };
        self.slices.iter().flat_map(places)
    }

    /// The columns' names.
    pub fn names(&self) -> Vec<String> {
        let names = |slice: &StateSlice| -> Vec<String> {
            (0..slice.count).map(|k| slice.name_of(k)).collect()
        };
        self.slices.iter().flat_map(names).collect()
    }

    /// Whether they are columns of `samples.csv`.
    pub fn are_in_samples(&self) -> bool {
        self.width() <= WIDEST_STATE
    }

    /// Whether every sample holds the whole state, in its order, among its columns.
    pub fn is_whole_in_samples(&self) -> bool {
        self.are_in_samples()
            && self.width() == self.dimension
            && self
                .coordinates()
                .enumerate()
                .all(|(at, place)| at == place)
    }
}

/// Coordinates of its state that the scene asks to record.
///
/// # Errors
/// A name or slice that the state does not have, underlined in the scene. A coordinate that is recorded twice.
pub(super) fn recorded_states(document: &SceneDocument) -> Result<RecordedStates, Refusal> {
    let all = variables(document);
    let dimension = document.system.coordinates();
    let Some(asked) = &document.run.record.states else {
        let slices = if dimension <= WIDEST_STATE {
            all
        } else {
            Vec::new()
        };
        return Ok(RecordedStates {
            slices,
            is_chosen: false,
            dimension,
        });
    };
    let mut slices = Vec::new();
    for text in asked {
        let is_all = text.value == ALL_STATES && all.iter().all(|slice| slice.name != text.value);
        match is_all {
            true => slices.extend(all.clone()),
            false => match document.system.components_of_key(text.value.trim()) {
                Some(components) => {
                    for component in components {
                        slices.extend(slice(document, &all, &text.clone().map(|_| component))?);
                    }
                }
                None => slices.extend(slice(document, &all, text)?),
            },
        }
    }
    let recorded = RecordedStates {
        slices,
        is_chosen: true,
        dimension,
    };
    let mut seen = vec![false; dimension];
    for (at, place) in recorded.coordinates().enumerate() {
        if std::mem::replace(&mut seen[place], true) {
            let name = &recorded.names()[at];
            return Err(Box::new(document.diagnostic(
                &asked[asked.len() - 1].place(),
                format!("`{name}` is recorded twice"),
                "here or before",
                Some("write slices that do not overlap".to_owned()),
            )));
        }
    }
    Ok(recorded)
}

/// Every variable and family, whole.
fn variables(document: &SceneDocument) -> Vec<StateSlice> {
    let system = &document.system;
    let singles = system.variables.iter().map(|name| (name, None));
    let families = system.moving().iter();
    let families = families.map(|(name, length)| (name, Some(length.value)));
    let mut offset = 0;
    let mut all = Vec::new();
    for (name, length) in singles.chain(families) {
        let count = length.unwrap_or(1);
        all.push(StateSlice {
            name: name.value.clone(),
            first: length.map(|_| 0),
            step: 1,
            count,
            offset,
            axes: match (length, &system.axes[..]) {
                (None, _) => Vec::new(),
                (Some(length), []) => vec![length],
                (Some(_), axes) => axes.to_vec(),
            },
            site_names: system.site_names.clone(),
        });
        offset += count;
    }
    all
}

/// `x`, `q`, `q[500]`, `q[0..10]`, `q[::100]`, `q[10:500:7]`; along several axes `q`, `q[2,3]`, `q[:,5]`, `q[0..10,::2]`.
fn slice(
    document: &SceneDocument,
    all: &[StateSlice],
    asked: &Located<String>,
) -> Result<Vec<StateSlice>, Refusal> {
    let text = asked.value.trim();
    let refuse = |message: String, help: String| {
        let place = document.place_in_formula(asked, 0..asked.value.len());
        Box::new(document.diagnostic(&place, message, "here", Some(help)))
    };
    let (name, sites) = match text.split_once('[') {
        None => (text, None),
        Some((name, rest)) => (name.trim(), Some(rest)),
    };
    let Some(whole) = all.iter().find(|slice| slice.name == name) else {
        let names: Vec<&str> = all.iter().map(|slice| slice.name.as_str()).collect();
        return Err(refuse(
            format!("the state has no coordinates `{name}`"),
            format!(
                "it has {}; a function of the state belongs in `observables`",
                names.join(", ")
            ),
        ));
    };
    let Some(sites) = sites else {
        return Ok(vec![whole.clone()]);
    };
    if whole.first.is_none() {
        return Err(refuse(
            format!("`{name}` is a single variable and has no sites"),
            format!("write \"{name}\""),
        ));
    }
    let inner = sites.strip_suffix(']');
    let Some(ranges) = inner.and_then(|inner| ranges(inner, whole)) else {
        let help = match &whole.axes[..] {
            [_] if !whole.site_names.is_empty() => {
                let inner = inner.unwrap_or_default().trim();
                let near = nearest(inner, whole.site_names.iter());
                match near {
                    Some(near) => format!("did you mean {name}[{near}]?"),
                    None => format!("{}; {name} is all of it", sites_by_name(&whole.site_names)),
                }
            }
            [_] => format!(
                "write {name} for all of it, {name}[5] for one site, {name}[0..10] for ten, {name}[::100] for \
                 every hundredth"
            ),
            axes => {
                let [all, last] = [vec![":"; axes.len() - 1], vec!["0"; axes.len()]];
                let [all, last] = [all, last].map(|parts| parts.join(","));
                format!(
                    "write {name} for all of it, {name}[{last}] for one site, {name}[{all},0] for those with 0 along the last \
                     axis: a range for each of the {} axes",
                    axes.len()
                )
            }
        };
        return Err(refuse(format!("`{text}` is not a part of `{name}`"), help));
    };
    for ((first, end, _), length) in ranges.iter().zip(&whole.axes) {
        if end > length || first >= end {
            let last: Vec<String> = whole.axes.iter().map(|n| (n - 1).to_string()).collect();
            let [from, last] = [vec!["0"; last.len()].join(","), last.join(",")];
            let names = if first < length && first >= end {
                "none"
            } else {
                "others"
            };
            return Err(refuse(
                format!("`{name}` has the sites {from} to {last}, and `{text}` names {names}"),
                match whole.axes.len() {
                    1 => {
                        format!("the end of a slice is exclusive: {name}[0..{length}] is all of it")
                    }
                    _ => format!(
                        "the end of a range is exclusive: 0..{length} is all along that axis"
                    ),
                },
            ));
        }
    }
    Ok(rows(whole, &ranges))
}

/// First place, the one behind the last, and the step along an axis.
type Range = (usize, usize, usize);

/// The sites of these ranges, rows along the last axis that has several, in the order of the state.
fn rows(whole: &StateSlice, ranges: &[Range]) -> Vec<StateSlice> {
    let counts: Vec<usize> = (ranges.iter())
        .map(|(first, end, step)| (end - first).div_ceil(*step))
        .collect();
    let strides: Vec<usize> = (1..=ranges.len())
        .map(|axis| whole.axes[axis..].iter().product())
        .collect();
    let along = counts.iter().rposition(|count| *count > 1);
    let along = along.unwrap_or(ranges.len() - 1);
    let before: usize = counts[..along].iter().product();
    let row = |mut number: usize| {
        let mut site: usize = (ranges.iter().zip(&strides))
            .map(|((first, ..), stride)| first * stride)
            .sum();
        for axis in (0..along).rev() {
            site += number % counts[axis] * ranges[axis].2 * strides[axis];
            number /= counts[axis];
        }
        StateSlice {
            first: Some(site),
            step: ranges[along].2 * strides[along],
            count: counts[along],
            offset: whole.offset + site,
            ..whole.clone()
        }
    };
    (0..before).map(row).collect()
}

/// The range along each axis, of `0..10,5` or `:,:,8`.
fn ranges(text: &str, whole: &StateSlice) -> Option<Vec<Range>> {
    let parts: Vec<&str> = text.split(',').collect();
    let ranges = parts.iter().zip(&whole.axes);
    let ranges = ranges.map(|(part, length)| range(part, *length, &whole.site_names));
    (parts.len() == whole.axes.len()).then(|| ranges.collect())?
}

/// First site, the one behind the last, and the step of `5`, `Sun`, `N-1`, `0..10`, `0:10`, `::100`, `10:N-1:7`; N is the length.
fn range(text: &str, length: usize, names: &SiteNames) -> Option<Range> {
    let text = text.replace("..", ":");
    // Names of sites may begin with N too.
    let is_length = |rest: &&str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    let number = |text: &str, otherwise: usize| match text.trim() {
        "" => Some(otherwise),
        text => match text
            .strip_prefix('N')
            .filter(is_length)
            .map(str::trim_start)
        {
            None => names.position(text).or_else(|| text.parse().ok()),
            Some("") => Some(length),
            Some(less) => length.checked_sub(less.strip_prefix('-')?.trim().parse().ok()?),
        },
    };
    let parts: Vec<&str> = text.split(':').collect();
    match parts.as_slice() {
        [one] if !one.trim().is_empty() => {
            let site = number(one, 0)?;
            Some((site, site.checked_add(1)?, 1))
        }
        [first, end] => Some((number(first, 0)?, number(end, length)?, 1)),
        [first, end, step] => {
            let step = number(step, 1).filter(|step| *step > 0)?;
            Some((number(first, 0)?, number(end, length)?, step))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{SiteNames, StateSlice, ranges, rows};

    /// Places of a box of 4 × 5 × 6 sites, as a loop over its indices finds them.
    #[test]
    fn parts_of_a_box_are_its_sites_in_order() {
        let whole = StateSlice {
            name: "q".to_owned(),
            first: Some(0),
            step: 1,
            count: 120,
            offset: 7,
            axes: vec![4, 5, 6],
            site_names: SiteNames::default(),
        };
        for (text, is_there) in [
            (":,:,:", [true; 3].map(|_| None)),
            (":,:,2", [None, None, Some(2)]),
            ("3,:,:", [Some(3), None, None]),
            ("1, :, 5", [Some(1), None, Some(5)]),
            (":,4,0", [None, Some(4), Some(0)]),
            ("3,4,5", [Some(3), Some(4), Some(5)]),
        ] {
            let mut expected = Vec::new();
            for at in 0..120 {
                let place = [at / 30, at / 6 % 5, at % 6];
                if place
                    .iter()
                    .zip(is_there)
                    .all(|(at, own)| own.is_none_or(|own| own == *at))
                {
                    expected.push((7 + at, format!("q[{},{},{}]", place[0], place[1], place[2])));
                }
            }
            let found = rows(&whole, &ranges(text, &whole).expect(text));
            let found = found.iter().flat_map(|row| {
                (0..row.count).map(|k| (row.offset + k * row.step, row.name_of(k)))
            });
            assert_eq!(found.collect::<Vec<_>>(), expected, "{text}");
        }
        let every_other = rows(&whole, &ranges("::3,1..5:2,2", &whole).expect("ranges"));
        let sites = every_other
            .iter()
            .flat_map(|row| (0..row.count).map(|k| row.name_of(k)));
        let sites: Vec<String> = sites.collect();
        assert_eq!(sites, ["q[0,1,2]", "q[0,3,2]", "q[3,1,2]", "q[3,3,2]"]);
        let last = ranges("N-1, 1..N-2, ::N", &whole);
        assert_eq!(last, Some(vec![(3, 4, 1), (1, 3, 1), (0, 6, 6)]));
        for none in [
            ":,:", "1,2,3,4", "a,:,:", ":,:,::0", "N-5,:,:", ",:,:", "N+1,:,:",
        ] {
            assert!(ranges(none, &whole).is_none(), "{none}");
        }
    }
}
