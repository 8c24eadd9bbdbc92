//! The systems by id.

use serde::de::DeserializeOwned;

use crate::{About, Defaults, SystemError};

/// One system of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LibrarySystem {
    /// The name by which a scene asks for it: `library = "rigid-body"`.
    pub id: &'static str,
    /// The whole TOML text, with the tables `[about]`, `[system]` and `[default]`.
    pub text: &'static str,
}

impl LibrarySystem {
    /// Title, summary, literature and orbit.
    ///
    /// # Errors
    /// [`SystemError::Malformed`], [`SystemError::MissingTable`]; no system of [`all`] has either.
    pub fn about(&self) -> Result<About, SystemError> {
        self.read("about")
    }

    /// The `[system]` table, as a scene has it.
    ///
    /// # Errors
    /// [`SystemError::Malformed`], [`SystemError::MissingTable`]; no system of [`all`] has either.
    pub fn system(&self) -> Result<toml::Table, SystemError> {
        self.read("system")
    }

    /// The initial state and the time step to start from.
    ///
    /// # Errors
    /// [`SystemError::Malformed`], [`SystemError::MissingTable`]; no system of [`all`] has either.
    pub fn defaults(&self) -> Result<Defaults, SystemError> {
        self.read("default")
    }

    /// The dimension of the phase space: the number of variables and of family members together.
    ///
    /// # Errors
    /// As [`system`](Self::system), and [`SystemError::NoVariables`] when nothing is named.
    pub fn dimension(&self) -> Result<usize, SystemError> {
        let system = self.system()?;
        let variables = system
            .get("variables")
            .and_then(toml::Value::as_array)
            .map_or(0, Vec::len);
        let members: usize = system
            .get("families")
            .and_then(toml::Value::as_table)
            .into_iter()
            .flat_map(toml::Table::values)
            .filter_map(|family| match family {
                toml::Value::Table(vectors) => {
                    let length = usize::try_from(vectors.get("length")?.as_integer()?).ok()?;
                    Some(length * vectors.get("components")?.as_array()?.len())
                }
                length => usize::try_from(length.as_integer()?).ok(),
            })
            .sum();
        match variables + members {
            0 => Err(SystemError::NoVariables {
                id: self.id.to_owned(),
            }),
            dimension => Ok(dimension),
        }
    }

    fn read<T: DeserializeOwned>(&self, table: &'static str) -> Result<T, SystemError> {
        let malformed = |error: toml::de::Error| SystemError::Malformed {
            id: self.id.to_owned(),
            message: error.to_string(),
        };
        let mut text: toml::Table = toml::from_str(self.text).map_err(malformed)?;
        text.remove(table)
            .ok_or_else(|| SystemError::MissingTable {
                id: self.id.to_owned(),
                table,
            })?
            .try_into()
            .map_err(malformed)
    }
}

macro_rules! library {
    ($($id:literal),*) => {
        static LIBRARY: [LibrarySystem; 33] = [$(
            LibrarySystem { id: $id, text: include_str!(concat!("../library/", $id, ".toml")) }
        ),*];
    };
}

of_each_system!(library);

/// Every system of the library, sorted by id.
pub fn all() -> &'static [LibrarySystem] {
    &LIBRARY
}

/// The system with this id.
pub fn find(id: &str) -> Option<&'static LibrarySystem> {
    LIBRARY
        .binary_search_by(|system| system.id.cmp(id))
        .ok()
        .map(|place| &LIBRARY[place])
}

/// The id most like `id`, for a message about an unknown one; none when nothing is alike.
///
/// Alike means a Jaro–Winkler similarity of at least 0.8.
pub fn nearest(id: &str) -> Option<&'static str> {
    LIBRARY
        .iter()
        .map(|system| (strsim::jaro_winkler(id, system.id), system.id))
        .filter(|(similarity, _)| *similarity >= 0.8)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, id)| id)
}
