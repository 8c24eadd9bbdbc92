//! `bracket = "canonical"`: pairs of a coordinate and its momentum, found by their names or written out.
use super::error::SceneProblemCause;
use super::located::{Located, Place};
use super::reader::{Item, Problems};

/// Beginnings of names of a coordinate and of its momentum, with the same end: `q1` and `p1`, `r.x` and `p.x`.
const STEMS: [(&str, &[&str]); 14] = [
    ("q", &["p"]),
    ("Q", &["P"]),
    ("x", &["p"]),
    ("X", &["P"]),
    ("r", &["p"]),
    ("theta", &["p", "L", "l", "J", "I"]),
    ("phi", &["p", "L", "l", "J", "I", "pi"]),
    ("psi", &["p", "L", "l", "J", "I"]),
    ("alpha", &["p", "L"]),
    ("θ", &["p", "L", "l", "J", "I"]),
    ("φ", &["p", "L", "l", "J", "I", "π"]),
    ("ϕ", &["p", "L", "l", "J", "I", "π"]),
    ("ψ", &["p", "L", "l", "J", "I"]),
    ("α", &["p", "L"]),
];

/// Names of the letters that a momentum puts before its coordinate's name: `px`, `p_theta`.
const BEFORE: [&str; 3] = ["p", "p_", "P"];

/// Names of indices of a site.
const INDICES: [&str; 3] = ["i", "j", "k"];

/// The coordinates that a bracket is of, and the sign of {q, p} with which q' = ∂H/∂p.
#[derive(Clone)]
pub(super) struct Coordinates {
    /// Names, and the lengths of their axes.
    names: Vec<(String, Vec<usize>)>,
    sign: &'static str,
}

impl Coordinates {
    /// Single variables, families with the lengths of their axes, and the sign.
    pub fn of(
        variables: &[Located<String>],
        families: &[(Located<String>, Located<Vec<usize>>)],
        sign: &'static str,
    ) -> Self {
        let variables = variables
            .iter()
            .map(|name| (name.value.clone(), Vec::new()));
        let families = families.iter();
        let families = families.map(|(name, lengths)| (name.value.clone(), lengths.value.clone()));
        Self {
            names: variables.chain(families).collect(),
            sign,
        }
    }

    /// Those of a summand, by the names of variables and families.
    pub fn only(&self, chosen: &[Located<String>]) -> Self {
        let is_chosen = |(name, _): &&(String, Vec<usize>)| {
            let mut chosen = chosen.iter();
            chosen.any(|of| *name == of.value || is_component(name, &of.value))
        };
        Self {
            names: self.names.iter().filter(is_chosen).cloned().collect(),
            sign: self.sign,
        }
    }

    /// Names with vectors of single variables in components: `s` is `s.x`, `s.y`, `s.z`.
    pub fn in_components(&self, names: Vec<Located<String>>) -> Vec<Located<String>> {
        let components = |of: Located<String>| {
            let own = self
                .names
                .iter()
                .filter(|(name, axes)| axes.is_empty() && is_component(name, &of.value));
            let own: Vec<_> = own
                .map(|(name, _)| Located::new(name.clone(), of.place()))
                .collect();
            if own.is_empty() { vec![of] } else { own }
        };
        names.into_iter().flat_map(components).collect()
    }

    /// The entries of the pairs that names tell.
    ///
    /// Each coordinate has one momentum, and no variable is left.
    pub fn by_names(&self, place: &Place, problems: &mut Problems) -> Option<Entries> {
        let mut pairs = Vec::new();
        for at in 0..self.names.len() {
            let partners = self.partners(at);
            match partners[..] {
                [(momentum, true)] => pairs.push((at, momentum)),
                [(_, false)] => {}
                _ => {
                    let partners = partners.iter().map(|(other, _)| self.whole(*other));
                    let mut partners: Vec<String> = partners.collect();
                    partners.dedup();
                    let cause = SceneProblemCause::CanonicalPair {
                        name: self.whole(at),
                        partners,
                        example: self.example(at),
                    };
                    problems.push(cause, place.clone());
                    return None;
                }
            }
        }
        let entry =
            |(coordinate, momentum): (usize, usize)| self.entry(coordinate, momentum, place);
        Some(pairs.into_iter().map(entry).collect())
    }

    /// The name that a scene gives: of a vector's component that of the vector.
    fn whole(&self, at: usize) -> String {
        let name = &self.names[at].0;
        name.split_once('.')
            .map_or(&**name, |(vector, _)| vector)
            .to_owned()
    }

    /// A name and the first other one that may be paired with it where neither is paired by its name.
    fn example(&self, at: usize) -> Option<[String; 2]> {
        let is_in_a_pair = |of: usize| {
            self.names.iter().any(|(other, _)| {
                is_pair(other, &self.names[of].0) || is_pair(&self.names[of].0, other)
            })
        };
        let mut free = (0..self.names.len()).filter(|of| !is_in_a_pair(*of));
        let other =
            free.find(|other| self.whole(*other) != self.whole(at) && self.are_alike(at, *other))?;
        let pair = [self.whole(at), self.whole(other)];
        (!is_in_a_pair(at)).then_some(pair)
    }

    /// The variables that may be paired with one, and whether they are its momenta.
    fn partners(&self, at: usize) -> Vec<(usize, bool)> {
        let name = &self.names[at].0;
        let others = (0..self.names.len()).filter(|other| *other != at);
        let partners = others.filter_map(|other| {
            let other_name = &self.names[other].0;
            let is_alike = self.names[at].1 == self.names[other].1;
            let (first, second) = (is_pair(name, other_name), is_pair(other_name, name));
            (is_alike && (first || second)).then_some((other, first))
        });
        partners.collect()
    }

    /// Those without a single variable that names pair with no other.
    pub fn paired(&self) -> Self {
        let is_single = |at: &usize| self.names[*at].1.is_empty();
        let is_left = |at: &usize| self.partners(*at).is_empty() && is_single(at);
        let left = (0..self.names.len()).find(is_left);
        let kept = (0..self.names.len()).filter(|at| Some(*at) != left);
        Self {
            names: kept.map(|at| self.names[at].clone()).collect(),
            sign: self.sign,
        }
    }

    /// The entries of pairs that are written out, the coordinate first; of vectors one for each component.
    pub fn by_pairs(
        &self,
        pairs: &[Located<Vec<Located<String>>>],
        problems: &mut Problems,
    ) -> Option<Entries> {
        let (mut entries, mut paired) = (Entries::new(), Vec::new());
        for pair in pairs {
            let [coordinate, momentum] = &pair.value[..] else {
                let cause = SceneProblemCause::Shape {
                    what: "a pair of `canonical`".to_owned(),
                    found: format!("{} names", pair.value.len()),
                    expected: "a coordinate and its momentum, as [\"q\", \"p\"]".to_owned(),
                };
                problems.push(cause, pair.place());
                return None;
            };
            let coordinates = self.named(coordinate, problems)?;
            let momenta = self.named(momentum, problems)?;
            let are_alike = coordinates.len() == momenta.len()
                && coordinates
                    .iter()
                    .zip(&momenta)
                    .all(|(q, p)| q != p && self.are_alike(*q, *p));
            if !are_alike {
                let cause = SceneProblemCause::Shape {
                    what: "a pair of `canonical`".to_owned(),
                    found: format!("`{}` and `{}`", coordinate.value, momentum.value),
                    expected: "two variables, two families on the same axes, or two vectors of as many components".to_owned(),
                };
                problems.push(cause, pair.place());
                return None;
            }
            for (at, name) in [(&coordinates, coordinate), (&momenta, momentum)] {
                if at.iter().any(|at| paired.contains(at)) {
                    let name_again = name.value.clone();
                    problems.push(
                        SceneProblemCause::Duplicate { name: name_again },
                        name.place(),
                    );
                    return None;
                }
                paired.extend(at.iter().copied());
            }
            let of = coordinates.into_iter().zip(momenta);
            entries.extend(of.map(|(q, p)| self.entry(q, p, &pair.place())));
        }
        Some(entries)
    }

    /// The variables of a name: one, or the components of a vector.
    fn named(&self, name: &Located<String>, problems: &mut Problems) -> Option<Vec<usize>> {
        let is_meant = |at: &usize| {
            let known = &self.names[*at].0;
            *known == name.value || is_component(known, &name.value)
        };
        let found: Vec<usize> = (0..self.names.len()).filter(is_meant).collect();
        if found.is_empty() {
            let valid = self.names.iter().map(|(known, _)| known.as_str());
            let cause = SceneProblemCause::unknown("variable", &name.value, valid);
            problems.push(cause, name.place());
            return None;
        }
        Some(found)
    }

    /// Whether two have the same axes and, of vectors, the same component.
    fn are_alike(&self, coordinate: usize, momentum: usize) -> bool {
        let [q, p] = [coordinate, momentum].map(|at| &self.names[at]);
        let component = |name: &str| name.split_once('.').map(|(_, own)| own.to_owned());
        q.1 == p.1 && component(&q.0) == component(&p.0)
    }

    fn entry(&self, coordinate: usize, momentum: usize, place: &Place) -> Entry {
        let written = |at: usize| match &self.names[at] {
            (name, axes) if axes.is_empty() => name.clone(),
            (name, axes) => format!("{name}[{}]", INDICES[..axes.len()].join(",")),
        };
        let key = format!("{},{}", written(coordinate), written(momentum));
        let at = |text: String| Located::new(text, place.clone());
        (at(key), at(self.sign.to_owned()))
    }
}

type Entry = (Located<String>, Located<String>);
type Entries = Vec<Entry>;

/// `[["q", "p"], ["theta", "L"]]`.
pub(super) fn read_pairs(
    item: &Item<'_>,
    problems: &mut Problems,
) -> Option<Vec<Located<Vec<Located<String>>>>> {
    item.list_of("a list of pairs of names", problems, |pair, problems| {
        let names = pair.list_of("a pair of names", problems, Item::string)?;
        Some(Located::new(names, pair.place()))
    })
}

/// Whether a family is a component of a vector: `r.x` of `r`.
fn is_component(family: &str, vector: &str) -> bool {
    let rest = family.strip_prefix(vector);
    rest.is_some_and(|rest| rest.starts_with('.'))
}

/// Whether names tell that the second is the momentum of the first.
pub(crate) fn is_pair(coordinate: &str, momentum: &str) -> bool {
    let is_before = |letters: &str| momentum.strip_prefix(letters) == Some(coordinate);
    let have_stems = |(stem, momenta): &(&str, &[&str])| {
        let end = coordinate.strip_prefix(stem);
        let mut momenta = momenta.iter();
        end.is_some_and(|end| momenta.any(|of| momentum.strip_prefix(of) == Some(end)))
    };
    BEFORE.into_iter().any(is_before) || STEMS.iter().any(have_stems)
}
