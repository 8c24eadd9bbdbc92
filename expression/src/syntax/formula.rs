//! A parsed formula.

use std::collections::BTreeSet;

use super::error::SyntaxError;
use super::parser::Parser;
use super::tree::{Kind, Node, Span};

/// A parsed formula, its names not yet resolved.
///
/// [`Formula::resolve`] makes an exact expression of it, [`Formula::value`] a number.
#[derive(Clone, Debug)]
pub struct Formula {
    /// The text, and behind it names of components of vectors.
    text: String,
    /// The bytes of the text alone.
    written: usize,
    root: Node,
}

impl Formula {
    /// Parses `text`; see the [module](super) for the grammar.
    ///
    /// # Errors
    /// [`SyntaxError`] when the text is not a formula, is nested more than
    /// [`DEPTH_LIMIT`](super::DEPTH_LIMIT) levels deep, or calls an unknown function.
    pub fn parse(text: &str) -> Result<Self, SyntaxError> {
        let root = Parser::new(text)
            .and_then(Parser::formula)
            .map_err(|error| *error)?;
        Ok(Self {
            text: text.to_owned(),
            written: text.len(),
            root: *root,
        })
    }

    /// Parses a condition as `if` takes one, such as `0 < x < 1 and not y > 2`: a formula that is 1 where it holds and 0
    /// elsewhere.
    ///
    /// # Errors
    /// [`SyntaxError`] as of [`Formula::parse`], and where nothing is compared.
    pub fn parse_condition(text: &str) -> Result<Self, SyntaxError> {
        let root = Parser::new(text)
            .and_then(Parser::whole_condition)
            .map_err(|error| *error)?;
        Ok(Self {
            text: text.to_owned(),
            written: text.len(),
            root: *root,
        })
    }

    /// The text as parsed.
    pub fn text(&self) -> &str {
        &self.text[..self.written]
    }

    /// The text that spans lead into.
    pub(super) fn source(&self) -> &str {
        &self.text
    }

    /// The same formula as another tree over a longer text.
    pub(super) fn rewritten(self, text: String, root: Node) -> Self {
        Self { text, root, ..self }
    }

    pub(super) fn root(&self) -> &Node {
        &self.root
    }

    /// Whether it has a sum over sites.
    pub fn has_sum(&self) -> bool {
        self.root.has_sum()
    }

    /// Names of the indices in brackets that no `sum` introduces, one an axis: `i` in `x[i+1]*sum(j, x[j])`, `i` and `j` in
    /// `x[i,j+1]`, an empty name and `j` in `x[1,j]`. Each is the first that stands along its axis.
    ///
    /// A bare name is never counted, since it may as well be a parameter.
    pub fn free_indices(&self) -> Vec<&str> {
        let mut free: Vec<&str> = Vec::new();
        self.visit(&mut |node, bound| {
            let Kind::Reference(reference) = &node.kind else {
                return;
            };
            for (axis, name) in reference.index_names(&self.text).into_iter().enumerate() {
                if name.is_empty() || bound.contains(&name) {
                    continue;
                }
                if free.len() <= axis {
                    free.resize(axis + 1, "");
                }
                if free[axis].is_empty() {
                    free[axis] = name;
                }
            }
        });
        free
    }

    /// The names of variables, families and parameters that occur. A bare name that is the index
    /// of a sum around it or the free index is not among them.
    pub fn references(&self) -> BTreeSet<&str> {
        let free = self.free_indices();
        let mut found = BTreeSet::new();
        self.visit(&mut |node, bound| {
            if let Kind::Reference(reference) = &node.kind {
                let name = reference.name.of(&self.text);
                let index = bound.contains(&name) || free.contains(&name);
                if !reference.sites.is_empty() || !index {
                    found.insert(name);
                }
            }
        });
        found
    }

    /// Calls `inspect` with every node and the indices of the sums around it.
    fn visit<'a>(&'a self, inspect: &mut impl FnMut(&'a Node, &[&'a str])) {
        descend(&self.text, &self.root, &mut Vec::new(), inspect);
    }
}

fn descend<'a>(
    text: &'a str,
    node: &'a Node,
    bound: &mut Vec<&'a str>,
    inspect: &mut impl FnMut(&'a Node, &[&'a str]),
) {
    inspect(node, bound);
    let index: Option<Span> = match node.kind {
        Kind::SumOver { index, .. } => Some(index),
        _ => None,
    };
    bound.extend(index.map(|span| span.of(text)));
    for child in node.kind.children() {
        descend(text, child, bound, inspect);
    }
    if index.is_some() {
        bound.pop();
    }
}
