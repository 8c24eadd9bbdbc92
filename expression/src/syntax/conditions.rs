//! Conditions of choices: comparisons with `and`, `or` and `not`.

use super::composite::Relation;
use super::lexer::{Symbol, TokenKind};
use super::parser::{CLOSE, Parsed, Parser, list, node};
use super::tree::{Kind, Node};

const AND: &str = "and";
const OR: &str = "or";
const NOT: &str = "not";

impl Parser<'_> {
    /// The condition that the whole text is.
    pub(super) fn whole_condition(mut self) -> Parsed {
        let root = self.condition()?;
        self.end("`and`, `or` or an operator")?;
        Ok(root)
    }

    /// Comparisons with `and` and `or`, of which `and` binds tighter, and `not` tighter still.
    pub(super) fn condition(&mut self) -> Parsed {
        self.joined(OR, Self::all_of, Kind::Or)
    }

    fn all_of(&mut self) -> Parsed {
        self.joined(AND, Self::negation, Kind::And)
    }

    fn joined(
        &mut self,
        word: &str,
        parse: fn(&mut Self) -> Parsed,
        kind: fn(Vec<Node>) -> Kind,
    ) -> Parsed {
        let first = parse(self)?;
        let mut parts = vec![*first];
        while self.is_word(self.position, word) {
            self.position += 1;
            parts.push(*parse(self)?);
        }
        match parts.len() {
            1 => Ok(Box::new(parts.remove(0))),
            _ => list(parts, kind),
        }
    }

    /// `not` a condition, a condition in parentheses, or a comparison.
    fn negation(&mut self) -> Parsed {
        let start = self.next_span();
        if self.is_word(self.position, NOT) {
            self.position += 1;
            let inner = self.deeper(start, Self::negation)?;
            return node(start.to(inner.span), Kind::Not(inner));
        }
        if self.is_condition_in_parentheses() {
            self.position += 1;
            let mut inner = self.deeper(start, Self::condition)?;
            inner.span = start.to(self.expect(Symbol::Close, CLOSE)?);
            return Ok(inner);
        }
        self.comparison()
    }

    /// `a < b`, and `a < b <= c` for both.
    fn comparison(&mut self) -> Parsed {
        let mut left = self.sum()?;
        let mut parts = Vec::new();
        while let Some(relation) = self.symbol().and_then(relation) {
            self.position += 1;
            let right = self.sum()?;
            let compare = |pair| Kind::Compare(relation, pair);
            let span = left.span.to(right.span);
            parts.push(*node(span, compare(Box::new([*left, (*right).clone()])))?);
            left = right;
        }
        match parts.len() {
            0 => Err(self.unexpected("`<`, `<=`, `>`, `>=`, `==` or `!=`")),
            1 => Ok(Box::new(parts.remove(0))),
            _ => list(parts, Kind::And),
        }
    }

    fn is_word(&self, position: usize, word: &str) -> bool {
        let token = self.tokens.get(position);
        token.is_some_and(|token| token.kind == TokenKind::Name && token.span.of(self.text) == word)
    }

    /// Whether a parenthesis comes next in which something is compared, not in the arguments of a call.
    fn is_condition_in_parentheses(&self) -> bool {
        // Whether each parenthesis that is open is that of a call.
        let mut open: Vec<bool> = Vec::new();
        for (at, token) in self.tokens.iter().enumerate().skip(self.position) {
            match token.kind {
                TokenKind::Symbol(Symbol::Open) => {
                    let before = at.checked_sub(1).map(|before| self.tokens[before].kind);
                    let is_joined = [AND, OR, NOT]
                        .iter()
                        .any(|word| at > 0 && self.is_word(at - 1, word));
                    open.push(before == Some(TokenKind::Name) && !is_joined);
                }
                TokenKind::Symbol(Symbol::Close) => drop(open.pop()),
                TokenKind::Symbol(symbol)
                    if relation(symbol).is_some() && !open.contains(&true) =>
                {
                    return !open.is_empty();
                }
                _ => {}
            }
            if open.is_empty() {
                return false;
            }
        }
        false
    }
}

fn relation(symbol: Symbol) -> Option<Relation> {
    match symbol {
        Symbol::Less => Some(Relation::Less),
        Symbol::LessOrEqual => Some(Relation::LessOrEqual),
        Symbol::Greater => Some(Relation::Greater),
        Symbol::GreaterOrEqual => Some(Relation::GreaterOrEqual),
        Symbol::Equal => Some(Relation::Equal),
        Symbol::NotEqual => Some(Relation::NotEqual),
        _ => None,
    }
}
