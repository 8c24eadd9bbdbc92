//! From tokens to the tree, by recursive descent of bounded depth.

use super::composite::Composite;
use super::error::{SyntaxError, SyntaxErrorKind};
use super::lexer::{Symbol, Token, TokenKind, tokens};
use super::tree::{Anchor, Kind, Node, Reference, Site, Span};
use super::vocabulary::{DERIVATIVE, IF, LENGTH, PI, SUM, is_reserved};
use crate::expression::Function;
use crate::rational::Rational;

/// The greatest depth of a formula: of parentheses and operators inside each other in the text,
/// and of its tree. Sums and products are flat, whatever their length; a chain of divisions is as
/// deep as it is long.
pub const DEPTH_LIMIT: usize = 200;

/// The most axes of a lattice.
pub const AXES: usize = 3;

/// The greatest magnitude of an offset in brackets.
const OFFSET_LIMIT: i64 = i32::MAX as i64;

pub(super) const CLOSE: &str = "an operator or `)`";
const OPERAND: &str = "a number, a name or `(`";
const SITE: &str = "a site such as i, i+1, 3 or N-1";

/// Nodes and errors are boxed so that a level of recursion takes little of the stack.
pub(super) type Parsed = Result<Box<Node>, Box<SyntaxError>>;

pub(super) struct Parser<'a> {
    pub(super) text: &'a str,
    pub(super) tokens: Vec<Token>,
    pub(super) position: usize,
    depth: usize,
    /// The names of the sums around the current position.
    bound: Vec<&'a str>,
}

impl<'a> Parser<'a> {
    pub(super) fn new(text: &'a str) -> Result<Self, Box<SyntaxError>> {
        Ok(Self {
            text,
            tokens: tokens(text)?,
            position: 0,
            depth: 0,
            bound: Vec::new(),
        })
    }

    /// The formula that the whole text is.
    pub(super) fn formula(mut self) -> Parsed {
        let root = self.sum()?;
        self.end("an operator (a product is written with `*`)")?;
        Ok(root)
    }

    /// The single variable that the whole text is.
    pub(super) fn single(mut self) -> Result<Reference, Box<SyntaxError>> {
        let reference = self.reference()?;
        self.end("the end of the name")?;
        Ok(reference)
    }

    /// The two variables that the whole text is, with a comma between.
    pub(super) fn pair(mut self) -> Result<(Reference, Reference), Box<SyntaxError>> {
        let first = self.reference()?;
        self.expect(Symbol::Comma, "`,` and a second variable")?;
        let second = self.reference()?;
        self.end("the end of the pair")?;
        Ok((first, second))
    }

    pub(super) fn sum(&mut self) -> Parsed {
        let first = self.product()?;
        if !matches!(self.symbol(), Some(Symbol::Plus | Symbol::Minus)) {
            return Ok(first);
        }
        let mut terms = vec![*first];
        loop {
            let sign = self.next_span();
            if self.accept(Symbol::Plus) {
                terms.push(*self.product()?);
            } else if self.accept(Symbol::Minus) {
                terms.push(*negated(sign, self.product()?)?);
            } else {
                return list(terms, Kind::Sum);
            }
        }
    }

    fn product(&mut self) -> Parsed {
        let mut left = self.unary()?;
        loop {
            if self.symbol() == Some(Symbol::Times) {
                let mut factors = vec![*left];
                while self.accept(Symbol::Times) {
                    factors.push(*self.unary()?);
                }
                left = list(factors, Kind::Product)?;
            } else if self.accept(Symbol::Divide) {
                left = pair([left, self.unary()?], Kind::Quotient)?;
            } else {
                return Ok(left);
            }
        }
    }

    fn unary(&mut self) -> Parsed {
        let sign = self.next_span();
        if self.accept(Symbol::Minus) {
            return negated(sign, self.deeper(sign, Self::unary)?);
        }
        if self.accept(Symbol::Plus) {
            return self.deeper(sign, Self::unary);
        }
        self.power()
    }

    fn power(&mut self) -> Parsed {
        let base = self.atom()?;
        let operator = self.next_span();
        if !self.accept(Symbol::Power) {
            return Ok(base);
        }
        pair([base, self.deeper(operator, Self::unary)?], Kind::Power)
    }

    fn atom(&mut self) -> Parsed {
        let Some(&token) = self.tokens.get(self.position) else {
            return Err(self.unexpected(OPERAND));
        };
        match token.kind {
            TokenKind::Number => self.number(token.span),
            TokenKind::Name => self.named(token.span),
            TokenKind::Symbol(Symbol::Open) => {
                self.position += 1;
                let mut inner = self.deeper(token.span, Self::sum)?;
                inner.span = token.span.to(self.expect(Symbol::Close, CLOSE)?);
                Ok(inner)
            }
            TokenKind::Symbol(_) => Err(self.unexpected(OPERAND)),
        }
    }

    fn number(&mut self, span: Span) -> Parsed {
        self.position += 1;
        let exact = Rational::parse_decimal(span.of(self.text))
            .map_err(|error| SyntaxError::new(span, SyntaxErrorKind::Number(error)))?;
        let rounded = exact.to_f64();
        if !rounded.is_finite() {
            let literal = span.of(self.text).chars().take(40).collect();
            let kind = SyntaxErrorKind::NotFinite { literal };
            return Err(SyntaxError::new(span, kind).into());
        }
        node(
            span,
            Kind::Number {
                exact,
                rounded,
                literal: span,
            },
        )
    }

    fn named(&mut self, span: Span) -> Parsed {
        let name = span.of(self.text);
        let is_call = self.symbol_at(self.position + 1) == Some(Symbol::Open);
        if let Some(function) = Function::from_name(name)
            && (is_call || is_reserved(name))
        {
            return self.call(span, function);
        }
        if name == SUM {
            return self.sum_over(span);
        }
        if !is_call {
            return self.value(name, span);
        }
        match (name, Composite::from_name(name)) {
            (IF, _) => self.choice(span),
            (DERIVATIVE, _) => self.derivative(span),
            (_, Some(composite)) => self.composite(span, composite),
            (_, None) => self.lookup(span),
        }
    }

    /// A constant, a variable or a parameter.
    fn value(&mut self, name: &str, span: Span) -> Parsed {
        let kind = match name {
            PI => Kind::Pi,
            LENGTH => Kind::Length,
            _ => {
                let reference = self.reference()?;
                let end = self.tokens[self.position - 1].span;
                return node(span.to(end), Kind::Reference(reference));
            }
        };
        self.position += 1;
        node(span, kind)
    }

    fn sum_over(&mut self, start: Span) -> Parsed {
        self.position += 1;
        self.expect(Symbol::Open, "`(`, an index, `,` and a summand after `sum`")?;
        // Each index, and the one that it is greater than.
        let mut indices = Vec::new();
        while indices.is_empty() || self.is_before_index() {
            indices.push((self.bind()?, None));
            while self.accept(Symbol::Less) {
                let above = indices.last().map(|(index, _)| *index);
                indices.push((self.bind()?, above));
            }
            self.expect(Symbol::Comma, "`,` and a summand")?;
        }
        let mut body = self.deeper(start, Self::sum)?;
        let close = self.expect(Symbol::Close, CLOSE)?;
        let span = start.to(close);
        for (index, above) in indices.into_iter().rev() {
            self.bound.pop();
            body = node(span, Kind::SumOver { index, above, body })?;
        }
        Ok(body)
    }

    /// Whether a further index of a sum comes next, a name with `,` or `<` behind it.
    fn is_before_index(&self) -> bool {
        let next = self.tokens.get(self.position);
        let behind = self.symbol_at(self.position + 1);
        next.is_some_and(|token| token.kind == TokenKind::Name)
            && matches!(behind, Some(Symbol::Comma | Symbol::Less))
    }

    /// The name of a sum's index, bound from here on.
    fn bind(&mut self) -> Result<Span, Box<SyntaxError>> {
        let index = self.index_name("the name of an index")?;
        let name = index.of(self.text);
        if self.bound.contains(&name) {
            let kind = SyntaxErrorKind::DuplicateIndex {
                name: name.to_owned(),
            };
            return Err(SyntaxError::new(index, kind).into());
        }
        self.bound.push(name);
        Ok(index)
    }

    pub(super) fn reference(&mut self) -> Result<Reference, Box<SyntaxError>> {
        let name = self.index_name("the name of a variable")?;
        let mut sites = Vec::new();
        if !self.accept(Symbol::OpenBracket) {
            return Ok(Reference {
                name,
                shown: name,
                sites,
            });
        }
        sites.push(self.site()?);
        while sites.len() < AXES && self.accept(Symbol::Comma) {
            sites.push(self.site()?);
        }
        self.expect(Symbol::CloseBracket, "`+`, `-` or `]`")?;
        Ok(Reference {
            name,
            shown: name,
            sites,
        })
    }

    fn site(&mut self) -> Result<Site, Box<SyntaxError>> {
        let start = self.next_span();
        let mut anchor = Anchor::Start;
        let mut offset = 0i64;
        let mut negative = self.accept(Symbol::Minus);
        loop {
            let Some(&token) = self.tokens.get(self.position) else {
                return Err(self.unexpected(SITE));
            };
            let part = token.span.of(self.text);
            match token.kind {
                TokenKind::Number => {
                    let magnitude = part
                        .parse::<i64>()
                        .ok()
                        .filter(|size| *size <= OFFSET_LIMIT);
                    let Some(magnitude) = magnitude else {
                        return Err(self.unexpected("an integer below 2147483648"));
                    };
                    // Each part is below 2^31: only more parts than a text can hold overflow.
                    offset += if negative { -magnitude } else { magnitude };
                }
                TokenKind::Name if anchor == Anchor::Start && !negative => {
                    if part == LENGTH {
                        anchor = Anchor::End;
                    } else {
                        self.refuse_reserved(token.span, SITE)?;
                        anchor = Anchor::Name(token.span);
                    }
                }
                _ => return Err(self.unexpected(SITE)),
            }
            self.position += 1;
            negative = self.symbol() == Some(Symbol::Minus);
            if !negative && self.symbol() != Some(Symbol::Plus) {
                return Ok(Site {
                    anchor,
                    offset,
                    span: start.to(token.span),
                });
            }
            self.position += 1;
        }
    }

    /// A name that stands for something the scene declares.
    fn index_name(&mut self, expected: &'static str) -> Result<Span, Box<SyntaxError>> {
        match self.tokens.get(self.position) {
            Some(Token {
                kind: TokenKind::Name,
                span,
            }) => {
                let span = *span;
                self.refuse_reserved(span, expected)?;
                self.position += 1;
                Ok(span)
            }
            _ => Err(self.unexpected(expected)),
        }
    }

    fn refuse_reserved(&self, span: Span, expected: &'static str) -> Result<(), Box<SyntaxError>> {
        let name = span.of(self.text);
        if is_reserved(name) {
            let kind = SyntaxErrorKind::Expected {
                expected,
                found: name.to_owned(),
            };
            return Err(SyntaxError::new(span, kind).into());
        }
        Ok(())
    }

    /// `parse`, one level deeper.
    pub(super) fn deeper(&mut self, span: Span, parse: fn(&mut Self) -> Parsed) -> Parsed {
        if self.depth == DEPTH_LIMIT {
            return Err(too_deep(span));
        }
        self.depth += 1;
        let parsed = parse(self);
        self.depth -= 1;
        parsed
    }

    pub(super) fn symbol(&self) -> Option<Symbol> {
        self.symbol_at(self.position)
    }

    fn symbol_at(&self, position: usize) -> Option<Symbol> {
        match self.tokens.get(position)?.kind {
            TokenKind::Symbol(symbol) => Some(symbol),
            TokenKind::Number | TokenKind::Name => None,
        }
    }

    pub(super) fn accept(&mut self, symbol: Symbol) -> bool {
        let found = self.symbol() == Some(symbol);
        self.position += usize::from(found);
        found
    }

    pub(super) fn expect(
        &mut self,
        symbol: Symbol,
        expected: &'static str,
    ) -> Result<Span, Box<SyntaxError>> {
        let span = self.next_span();
        if self.accept(symbol) {
            Ok(span)
        } else {
            Err(self.unexpected(expected))
        }
    }

    pub(super) fn end(&self, expected: &'static str) -> Result<(), Box<SyntaxError>> {
        if self.position == self.tokens.len() {
            Ok(())
        } else {
            Err(self.unexpected(expected))
        }
    }

    /// The place of the next token; empty at the end of the text.
    pub(super) fn next_span(&self) -> Span {
        let end = self.text.len();
        self.tokens
            .get(self.position)
            .map_or(Span { start: end, end }, |token| token.span)
    }

    /// The error that the next token is not what is expected.
    pub(super) fn unexpected(&self, expected: &'static str) -> Box<SyntaxError> {
        let span = self.next_span();
        let kind = if self.position < self.tokens.len() {
            let found = span.of(self.text).chars().take(40).collect();
            SyntaxErrorKind::Expected { expected, found }
        } else {
            SyntaxErrorKind::UnexpectedEnd { expected }
        };
        Box::new(SyntaxError::new(span, kind))
    }
}

/// A node above its children, refused when it would be too high.
pub(super) fn node(span: Span, kind: Kind) -> Parsed {
    let below = kind.children().iter().map(|child| child.height + 1).max();
    let height = below.unwrap_or(0);
    if height > DEPTH_LIMIT {
        return Err(too_deep(span));
    }
    Ok(Box::new(Node { span, height, kind }))
}

fn negated(sign: Span, operand: Box<Node>) -> Parsed {
    node(sign.to(operand.span), Kind::Negate(operand))
}

fn pair(parts: [Box<Node>; 2], kind: fn(Box<[Node; 2]>) -> Kind) -> Parsed {
    let span = parts[0].span.to(parts[1].span);
    node(span, kind(Box::new(parts.map(|part| *part))))
}

/// A sum or product of at least one part.
pub(super) fn list(parts: Vec<Node>, kind: fn(Vec<Node>) -> Kind) -> Parsed {
    let span = parts[0].span.to(parts[parts.len() - 1].span);
    node(span, kind(parts))
}

fn too_deep(span: Span) -> Box<SyntaxError> {
    Box::new(SyntaxError::new(
        span,
        SyntaxErrorKind::TooDeep { limit: DEPTH_LIMIT },
    ))
}
