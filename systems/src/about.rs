//! Title, summary, literature and orbits of a library system: the `[about]` table of its text.

use std::fmt;

use serde::Deserialize;

/// The `[about]` table of a library text.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct About {
    /// The system's name, as a heading.
    pub title: String,
    /// One paragraph: the phase space, the Hamiltonian, the signs.
    pub summary: String,
    /// Where the system is written.
    pub reference: Reference,
    /// Known behaviour of the orbits: bounded, periodic, chaotic, heteroclinic.
    pub orbit: String,
}

/// A place in the literature.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The authors, separated by commas.
    pub authors: String,
    /// The title of the article or book.
    pub title: String,
    /// The journal with volume and pages, the publisher, or the preprint number.
    pub published: String,
    /// The year.
    pub year: u16,
    /// The section, example or equations within it.
    pub location: String,
}

impl fmt::Display for Reference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            authors,
            title,
            published,
            year,
            location,
        } = self;
        write!(
            formatter,
            "{authors}, {title}, {published} ({year}), {location}"
        )
    }
}
