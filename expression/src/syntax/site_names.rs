//! Names of the sites of a chain, such as bodies: `q[Sun]` for `q[0]`.

use std::sync::Arc;

use super::error::{SyntaxError, SyntaxErrorKind};
use super::formula::Formula;
use super::parser::{Parsed, node};
use super::pattern::VariablePattern;
use super::suggestion::nearest;
use super::tree::{Anchor, Kind, Node, Reference, Span};

/// Indices that keys and formulas count by where sites have names; a sum may introduce any other one.
pub const INDEX_NAMES: [&str; 6] = ["i", "j", "k", "l", "m", "n"];

/// Names of the sites 0, 1, … of a chain; none where sites are numbers alone.
///
/// ```
/// use leafwise_expression::syntax::{Formula, Scope, SiteNames};
///
/// let names = SiteNames::new(["Sun", "Earth"]);
/// let scope = Scope::new().with_family("q", 0, 2);
/// let formula = Formula::parse("q[Earth] - 3*q[Sun]").and_then(|formula| formula.with_sites(&names));
/// let expression = formula.and_then(|formula| formula.resolve(&scope, None));
/// assert_eq!(expression.expect("known names").expect("a value").evaluate(&[2.0, 10.0], &[]), 4.0);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SiteNames {
    names: Arc<[String]>,
}

impl SiteNames {
    /// The names in the order of the sites.
    pub fn new<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Self {
        Self {
            names: names.into_iter().map(Into::into).collect(),
        }
    }

    /// Whether sites are numbers alone.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The number of the site called `name`.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|own| own == name)
    }

    /// The name of a site; its number where it has none.
    pub fn name(&self, site: usize) -> String {
        let name = self.names.get(site).cloned();
        name.unwrap_or_else(|| site.to_string())
    }

    /// All names, in the order of the sites.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// The error that no site is called `name`, with the nearest one that there is.
    fn unknown(&self, text: &str, name: Span) -> SyntaxError {
        let word = name.of(text);
        let kind = SyntaxErrorKind::UnknownSite {
            name: word.to_owned(),
            names: self.names.to_vec(),
        };
        SyntaxError::new(name, kind).suggesting(nearest(word, self.iter()))
    }

    /// A reference with numbers in the places of names. Names in `bound` are indices of sums around it.
    fn numbered(
        &self,
        text: &str,
        mut reference: Reference,
        bound: &[&str],
    ) -> Result<Reference, SyntaxError> {
        for site in &mut reference.sites {
            let Anchor::Name(span) = site.anchor else {
                continue;
            };
            let name = span.of(text);
            match self.position(name) {
                Some(at) => {
                    site.anchor = Anchor::Start;
                    site.offset = site
                        .offset
                        .saturating_add(i64::try_from(at).unwrap_or(i64::MAX));
                }
                None if bound.contains(&name) || INDEX_NAMES.contains(&name) => {}
                None => return Err(self.unknown(text, span)),
            }
        }
        Ok(reference)
    }

    fn in_node<'a>(&self, text: &'a str, of: &Node, bound: &mut Vec<&'a str>) -> Parsed {
        let kind = match &of.kind {
            Kind::Reference(reference) => {
                Kind::Reference(self.numbered(text, reference.clone(), bound)?)
            }
            Kind::SumOver { index, .. } => {
                let name = index.of(text);
                if self.position(name).is_some() {
                    let kind = SyntaxErrorKind::SiteAsIndex {
                        name: name.to_owned(),
                    };
                    return Err(Box::new(SyntaxError::new(*index, kind)));
                }
                bound.push(name);
                let kind = (of.kind).with_parts(&mut |part| self.in_node(text, part, bound));
                bound.pop();
                kind?
            }
            kind => kind.with_parts(&mut |part| self.in_node(text, part, bound))?,
        };
        node(of.span, kind)
    }
}

impl Formula {
    /// The formula with the numbers of sites in the places of their names: `q[Sun]` is `q[0]`.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::UnknownSite`] for a name in brackets that is neither a site nor an index. Indices are those of
    /// sums around it and [`INDEX_NAMES`]. [`SyntaxErrorKind::SiteAsIndex`] for a sum over an index called as a site.
    pub fn with_sites(self, names: &SiteNames) -> Result<Self, SyntaxError> {
        if names.is_empty() {
            return Ok(self);
        }
        let root = names.in_node(self.source(), self.root(), &mut Vec::new());
        let (root, text) = (root.map_err(|error| *error)?, self.source().to_owned());
        Ok(self.rewritten(text, *root))
    }
}

impl VariablePattern {
    /// The variable with the numbers of sites in the places of their names: `q[Sun]` is `q[0]`.
    ///
    /// # Errors
    /// [`SyntaxErrorKind::UnknownSite`] for a name in brackets that is no site and not in [`INDEX_NAMES`].
    pub fn with_sites(self, names: &SiteNames) -> Result<Self, SyntaxError> {
        if names.is_empty() {
            return Ok(self);
        }
        let (text, reference) = self.reference();
        let numbered = names.numbered(text, reference.clone(), &[])?;
        Ok(self.at(numbered))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Scope;
    use super::*;

    fn names() -> SiteNames {
        SiteNames::new(["Sun", "Earth", "Moon"])
    }

    #[test]
    fn names_stand_for_the_numbers_of_their_sites() {
        let scope = Scope::new()
            .with_family("q", 0, 3)
            .with_parameters(&["Sun"]);
        let value = |text: &str| {
            let formula = Formula::parse(text)?.with_sites(&names())?;
            let expression = formula.resolve(&scope, None)?.expect("a value");
            Ok::<_, SyntaxError>(expression.evaluate(&[2.0, 10.0, 11.5], &[100.0]))
        };
        // By numbers, and by a parameter of the same name, which brackets do not mean.
        assert_eq!(value("q[Moon] - q[Earth] + Sun*q[Sun]"), Ok(201.5));
        assert_eq!(value("q[Sun+2] + q[Moon-1]"), Ok(21.5));
        // Any name is an index within its sum; outside it is none.
        assert_eq!(value("sum(body, q[body]*q[Earth])"), Ok(235.0));
        let refused = value("sum(body, q[body])*q[body]").expect_err("no index");
        assert_eq!(refused.span, 21..25);
        assert!(matches!(refused.kind, SyntaxErrorKind::UnknownSite { .. }));
        let refused = value("q[Sun] + q[Erath]").expect_err("no site");
        assert_eq!(
            (refused.span, refused.suggestion.as_deref()),
            (11..16, Some("Earth"))
        );
        let refused = value("sum(Sun, q[Sun])").expect_err("a site");
        let kind = SyntaxErrorKind::SiteAsIndex { name: "Sun".into() };
        assert_eq!((refused.span, refused.kind), (4..7, kind));
    }

    #[test]
    fn keys_by_names_are_those_of_numbers() {
        let scope = Scope::new().with_family("q", 5, 3);
        let key = |text: &str| VariablePattern::parse_one(text)?.with_sites(&names());
        let moon = key("q[Moon]").expect("a site");
        assert!(moon.index_names().is_empty());
        assert_eq!(moon.resolve(&scope, None), Ok(Some(7)));
        assert_eq!(moon.to_string(), "q[2]");
        assert_eq!(key("q[i]").expect("an index").index_names(), ["i"]);
        let refused = key("q[Mon]").expect_err("no site");
        assert_eq!(
            (refused.span, refused.suggestion.as_deref()),
            (2..5, Some("Moon"))
        );
    }
}
