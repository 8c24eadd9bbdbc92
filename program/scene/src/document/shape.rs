//! Shapes that the value of a key may have.

use leafwise_core::PartKind;

/// A key of a table.
pub(super) struct Key {
    pub name: &'static str,
    pub shape: Shape,
    /// One line, for editors and the guide.
    pub about: &'static str,
    /// Value where a scene does not say; `None` of a key that its table needs, alone or in the place of others.
    pub default: Option<Default>,
    /// Whether a scene gives one alone of the keys of its table of which this is said.
    pub is_choice: bool,
    /// Keys and words that it does not stand beside.
    pub beside: &'static [Beside],
}

/// Default of a key that a scene leaves out.
#[derive(Clone, Copy)]
pub(super) enum Default {
    /// A value as a scene would write it.
    Toml(&'static str),
    /// Something that no value says.
    Words(&'static str),
}

/// Something that a key does not stand beside.
pub(super) enum Beside {
    /// Keys of its own table that it takes the place of. The reader refuses both, and `--set` of one removes the others.
    InPlaceOf {
        keys: &'static [&'static str],
        advice: &'static str,
    },
    /// Other keys of its own table, which the reader refuses.
    Keys {
        keys: &'static [&'static str],
        advice: &'static str,
    },
    /// Keys of other tables, by their paths. The key is refused where a run is composed.
    Elsewhere {
        paths: &'static [&'static str],
        message: &'static str,
        help: &'static str,
    },
    /// The absence of a key of another table. The key is refused where a run is composed.
    Without {
        path: &'static str,
        message: &'static str,
        help: &'static str,
    },
    /// Something that depends on values or on the system, and is refused where these are known.
    Note(&'static str),
}

impl Key {
    /// The same with a value that holds where a scene does not say, as TOML.
    pub const fn default(mut self, toml: &'static str) -> Self {
        self.default = Some(Default::Toml(toml));
        self
    }

    /// The same with words for what holds where a scene does not say.
    pub const fn otherwise(mut self, words: &'static str) -> Self {
        self.default = Some(Default::Words(words));
        self
    }

    /// The same with what it does not stand beside.
    pub const fn not_beside(mut self, beside: &'static [Beside]) -> Self {
        self.beside = beside;
        self
    }

    /// Other keys of its table that it does not stand beside as it says itself, each with advice.
    pub fn conflicts(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        self.beside.iter().flat_map(|beside| {
            let (keys, advice): (&'static [&'static str], _) = match beside {
                Beside::InPlaceOf { keys, advice } | Beside::Keys { keys, advice } => {
                    (keys, *advice)
                }
                Beside::Elsewhere { .. } | Beside::Without { .. } | Beside::Note(_) => (&[], ""),
            };
            keys.iter().map(move |key| (*key, advice))
        })
    }

    fn takes_the_place_of(&self, other: &str) -> bool {
        self.beside.iter().any(|beside| match beside {
            Beside::InPlaceOf { keys, .. } => keys.contains(&other),
            _ => false,
        })
    }
}

/// Shape that a value may have.
pub(super) enum Shape {
    Text,
    /// A string, or a number that stands for itself.
    Formula,
    Number,
    /// A whole number of at least this.
    Whole(u64),
    /// Any value.
    Anything,
    Words(&'static [&'static str]),
    List(&'static Shape),
    /// A list of as many entries, each of its own shape.
    Entries(&'static [Shape]),
    Table(Keys),
    /// A table of names that the scene chooses.
    Names(&'static Shape),
    /// A table of pairs of variables, `"x,y"`.
    Pairs(&'static Shape),
    Either(&'static [Shape]),
    /// A part by its name, or a table with the name and its parameters.
    Part(PartKind),
    /// A system of the library.
    System,
}

/// A parameter of a part.
static PARAMETER: Shape = Shape::Either(&[Shape::Text, Shape::List(&Shape::Formula)]);

/// The word of a scene that names no part of a kind.
pub(super) fn word_of(kind: PartKind) -> &'static str {
    match kind {
        PartKind::Composition => "none",
        _ => "auto",
    }
}

/// Shape that a key leads to, if any.
pub(super) enum Inner<'a> {
    Known(&'a Shape),
    /// Nothing: these are the keys.
    Unknown(Vec<&'static str>),
    /// Nothing: the value is no table.
    Keyless,
}

impl Shape {
    /// Shape that the key `name` leads to in a value of this shape.
    pub(super) fn inner(&self, name: &str) -> Inner<'_> {
        match self {
            Self::Table(table) => match table.keys.iter().find(|key| key.name == name) {
                Some(key) => Inner::Known(&key.shape),
                None => Inner::Unknown(names(table.keys).collect()),
            },
            Self::Names(each) | Self::Pairs(each) => Inner::Known(each),
            Self::Part(_) => Inner::Known(&PARAMETER),
            Self::Either(shapes) => {
                let mut best = Inner::Keyless;
                for shape in *shapes {
                    match shape.inner(name) {
                        known @ Inner::Known(_) => return known,
                        Inner::Keyless => {}
                        unknown @ Inner::Unknown(_) => best = unknown,
                    }
                }
                best
            }
            _ => Inner::Keyless,
        }
    }

    /// Shape that the key `name` leads to, if any.
    pub(super) fn known(&self, name: &str) -> Option<&Self> {
        match self.inner(name) {
            Inner::Known(shape) => Some(shape),
            Inner::Unknown(_) | Inner::Keyless => None,
        }
    }

    /// The keys of the table of this shape that has the key `name`; none where there is no such table.
    pub(super) fn keys_with(&self, name: &str) -> &'static [Key] {
        match self {
            Self::Table(table) if has(table.keys, name) => table.keys,
            Self::Either(shapes) => {
                let mut keys = shapes.iter().map(|shape| shape.keys_with(name));
                keys.find(|keys| !keys.is_empty()).unwrap_or_default()
            }
            _ => &[],
        }
    }
}

/// The keys of a table.
pub(super) struct Keys {
    pub keys: &'static [Key],
    /// Sets of keys, of which one has to be there whole.
    pub needs: &'static [&'static [&'static str]],
}

/// Whether a key of this name is among `keys`.
pub(super) fn has(keys: &[Key], name: &str) -> bool {
    keys.iter().any(|key| key.name == name)
}

/// The names of keys.
pub(super) fn names(keys: &[Key]) -> impl Iterator<Item = &'static str> + Clone {
    keys.iter().map(|key| key.name)
}

/// The keys that give the same thing as `name` in other words: setting one of them removes the others.
pub(super) fn alternatives(keys: &'static [Key], name: &str) -> impl Iterator<Item = &'static str> {
    let own = keys.iter().find(|key| key.name == name);
    let is_other = move |key: &&Key| {
        own.is_some_and(|own| {
            let are_choices = own.is_choice && key.is_choice && own.name != key.name;
            are_choices || own.takes_the_place_of(key.name) || key.takes_the_place_of(own.name)
        })
    };
    keys.iter().filter(is_other).map(|key| key.name)
}

/// The keys of a table of which a scene gives one alone.
pub(super) fn choices(keys: &[Key]) -> impl Iterator<Item = &'static str> + Clone {
    keys.iter().filter(|key| key.is_choice).map(|key| key.name)
}

pub(super) const fn key(name: &'static str, shape: Shape, about: &'static str) -> Key {
    Key {
        name,
        shape,
        about,
        default: None,
        is_choice: false,
        beside: &[],
    }
}

/// One of the keys of its table of which a scene gives one alone.
pub(super) const fn choice(name: &'static str, shape: Shape, about: &'static str) -> Key {
    let mut key = key(name, shape, about);
    key.is_choice = true;
    key
}

pub(super) const fn table(
    keys: &'static [Key],
    needs: &'static [&'static [&'static str]],
) -> Shape {
    Shape::Table(Keys { keys, needs })
}

/// The two ends of something.
pub(super) const ENDS: Shape = Shape::Entries(&[Shape::Number, Shape::Number]);
/// The two ends of equidistant numbers, and how many there are.
pub(super) const RANGE: Shape = Shape::Entries(&[Shape::Number, Shape::Number, Shape::Whole(2)]);
pub(super) const NUMBERS: Shape = Shape::List(&Shape::Number);
pub(super) const FORMULAS: Shape = Shape::Names(&Shape::Formula);
