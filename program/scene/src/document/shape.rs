//! Shapes that the value of a key may have.

use leafwise_core::PartKind;

/// A key of a table.
pub(super) struct Key {
    pub name: &'static str,
    pub shape: Shape,
    /// One line, for editors.
    pub about: &'static str,
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

pub(super) const fn key(name: &'static str, shape: Shape, about: &'static str) -> Key {
    Key { name, shape, about }
}

pub(super) const fn table(
    keys: &'static [Key],
    needs: &'static [&'static [&'static str]],
) -> Shape {
    Shape::Table(Keys { keys, needs })
}

pub(super) const NUMBERS: Shape = Shape::List(&Shape::Number);
pub(super) const FORMULAS: Shape = Shape::Names(&Shape::Formula);
