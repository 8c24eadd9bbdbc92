//! The coordinates that a run records.

use serde::Serialize;

use super::Refusal;
use crate::document::{ALL_STATES, Located, SceneDocument};

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
}

impl StateSlice {
    /// The name of its k-th coordinate.
    fn name_of(&self, k: usize) -> String {
        let Some(first) = self.first else {
            return self.name.clone();
        };
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
                        slices.push(slice(document, &all, &text.clone().map(|_| component))?);
                    }
                }
                None => slices.push(slice(document, &all, text)?),
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
        });
        offset += count;
    }
    all
}

/// `x`, `q`, `q[500]`, `q[0..10]`, `q[::100]`, `q[10:500:7]`; along several axes `q` and `q[2,3]`.
fn slice(
    document: &SceneDocument,
    all: &[StateSlice],
    asked: &Located<String>,
) -> Result<StateSlice, Refusal> {
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
        return Ok(whole.clone());
    };
    if whole.first.is_none() {
        return Err(refuse(
            format!("`{name}` is a single variable and has no sites"),
            format!("write \"{name}\""),
        ));
    }
    let length = whole.count;
    let inner = sites.strip_suffix(']');
    if whole.axes.len() > 1 {
        let Some(site) = inner.and_then(|inner| site(inner, &whole.axes)) else {
            let last: Vec<String> = whole.axes.iter().map(|n| (n - 1).to_string()).collect();
            return Err(refuse(
                format!(
                    "`{text}` is not a site of `{name}`, whose last is {name}[{}]",
                    last.join(",")
                ),
                format!(
                    "write {name} for all of it, {name}[{}] for one site",
                    last.join(",")
                ),
            ));
        };
        return Ok(StateSlice {
            first: Some(site),
            count: 1,
            offset: whole.offset + site,
            ..whole.clone()
        });
    }
    let range = inner.and_then(|inner| range(inner, length));
    let Some((first, end, step)) = range else {
        return Err(refuse(
            format!("`{text}` is not a part of `{name}`"),
            format!(
                "write {name} for all of it, {name}[5] for one site, {name}[0..10] for ten, {name}[::100] for \
                 every hundredth"
            ),
        ));
    };
    if end > length || first >= end {
        return Err(refuse(
            format!(
                "`{name}` has the sites 0 to {}, and `{text}` names others",
                length - 1
            ),
            format!("the end of a slice is exclusive: {name}[0..{length}] is all of it"),
        ));
    }
    Ok(StateSlice {
        first: Some(first),
        step,
        count: (end - first).div_ceil(step),
        offset: whole.offset + first,
        ..whole.clone()
    })
}

/// The number of the site `2,3` of a family with these axes.
fn site(text: &str, axes: &[usize]) -> Option<usize> {
    let parts: Vec<&str> = text.split(',').collect();
    let mut number = 0;
    for (part, length) in parts.iter().zip(axes) {
        let at = part.trim().parse::<usize>().ok()?;
        number = number * length + (at < *length).then_some(at)?;
    }
    (parts.len() == axes.len()).then_some(number)
}

/// First site, the one behind the last, and the step of `5`, `0..10`, `0:10`, `::100`, `10:500:7`.
fn range(text: &str, length: usize) -> Option<(usize, usize, usize)> {
    let text = text.replace("..", ":");
    let number = |text: &str, otherwise: usize| match text.trim() {
        "" => Some(otherwise),
        digits => digits.parse().ok(),
    };
    let parts: Vec<&str> = text.split(':').collect();
    match parts.as_slice() {
        [one] => {
            let site = one.trim().parse::<usize>().ok()?;
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
