//! Calls of formulas: functions, choices, derivatives.

use super::composite::Composite;
use super::error::SyntaxError;
use super::lexer::{Symbol, TokenKind};
use super::lookups::unknown_function;
use super::parser::{CLOSE, Parsed, Parser, node};
use super::suggestion::alias;
use super::tree::{Kind, Node, Span};
use crate::expression::Function;

impl Parser<'_> {
    pub(super) fn call(&mut self, span: Span, function: Function) -> Parsed {
        self.position += 1;
        let expected = "`(` and an argument after a function's name";
        let opened = self.expect(Symbol::Open, expected);
        opened.map_err(|error| {
            let power = self.power_of_call(span);
            Box::new(error.suggesting(power))
        })?;
        let argument = self.deeper(span, Self::sum)?;
        let function = match function {
            Function::Special(special, _) if self.accept(Symbol::Comma) => {
                Function::Special(special, self.order()?)
            }
            plain => plain,
        };
        let close = self.expect(Symbol::Close, CLOSE)?;
        node(span.to(close), Kind::Call(function, argument))
    }

    /// Of `sin^2(q)`, where the power stands before the argument: `sin(q)^2`.
    fn power_of_call(&self, name: Span) -> Option<String> {
        let [power, number, open] = self.tokens.get(self.position..self.position + 3)? else {
            return None;
        };
        let is_power = power.kind == TokenKind::Symbol(Symbol::Power)
            && number.kind == TokenKind::Number
            && open.kind == TokenKind::Symbol(Symbol::Open);
        let behind = &self.text[open.span.start..];
        let mut depth = 0;
        let close = behind.char_indices().find(|(_, character)| {
            depth += match character {
                '(' => 1,
                ')' => -1,
                _ => 0,
            };
            depth == 0
        });
        let argument = &behind[..=close.filter(|_| is_power)?.0];
        let (name, number) = (name.of(self.text), number.span.of(self.text));
        Some(format!("{name}{argument}^{number}"))
    }

    /// How often a special function is differentiated.
    fn order(&mut self) -> Result<u8, Box<SyntaxError>> {
        let text = self.next_span().of(self.text);
        let order = text.parse::<u8>().ok().filter(|_| {
            let token = self.tokens.get(self.position);
            token.is_some_and(|token| token.kind == TokenKind::Number)
        });
        let expected = "a whole number below 256, how often the function is differentiated";
        let order = order.ok_or_else(|| self.unexpected(expected))?;
        self.position += 1;
        Ok(order)
    }

    /// The name and the opening parenthesis of what is called.
    fn open(&mut self, expected: &'static str) -> Result<(), Box<SyntaxError>> {
        self.position += 1;
        self.expect(Symbol::Open, expected).map(|_| ())
    }

    pub(super) fn composite(&mut self, span: Span, composite: Composite) -> Parsed {
        self.open("`(` and the arguments after a function's name")?;
        let mut arguments = vec![*self.deeper(span, Self::sum)?];
        while arguments.len() < composite.arguments() {
            self.expect(Symbol::Comma, "`,` and a second argument")?;
            arguments.push(*self.deeper(span, Self::sum)?);
        }
        while composite.takes_more() && self.accept(Symbol::Comma) {
            arguments.push(*self.deeper(span, Self::sum)?);
        }
        let close = self.expect(Symbol::Close, CLOSE)?;
        node(span.to(close), Kind::Composite(composite, arguments))
    }

    /// A table of the scene: whether there is one is known where names are.
    pub(super) fn lookup(&mut self, span: Span) -> Parsed {
        let name = span.of(self.text);
        let arguments = self.arguments(span).map_err(|error| {
            // Of functions of other languages the arguments may be no formulas.
            match alias(&name.to_lowercase()) {
                Some(_) => Box::new(unknown_function(name, span, std::iter::empty())),
                None => error,
            }
        });
        let (arguments, close) = arguments?;
        node(span.to(close), Kind::Lookup(span, arguments))
    }

    fn arguments(&mut self, span: Span) -> Result<(Vec<Node>, Span), Box<SyntaxError>> {
        self.open("`(` and the arguments after a function's name")?;
        let mut arguments = vec![*self.deeper(span, Self::sum)?];
        while self.accept(Symbol::Comma) {
            arguments.push(*self.deeper(span, Self::sum)?);
        }
        Ok((arguments, self.expect(Symbol::Close, CLOSE)?))
    }

    pub(super) fn choice(&mut self, span: Span) -> Parsed {
        self.open("`(` and a condition after `if`")?;
        let condition = self.deeper(span, Self::condition)?;
        self.expect(Symbol::Comma, "`,` and the value where the condition holds")?;
        let holds = self.deeper(span, Self::sum)?;
        self.expect(Symbol::Comma, "`,` and the value elsewhere")?;
        let other = self.deeper(span, Self::sum)?;
        let close = self.expect(Symbol::Close, CLOSE)?;
        let parts = Box::new([*condition, *holds, *other]);
        node(span.to(close), Kind::If(parts))
    }

    /// `D(f, x)`, and `D(f, x, y)` for `D(D(f, x), y)`.
    pub(super) fn derivative(&mut self, span: Span) -> Parsed {
        self.open("`(`, a formula, `,` and a variable after `D`")?;
        let mut inner = self.deeper(span, Self::sum)?;
        loop {
            self.expect(Symbol::Comma, "`,` and a variable")?;
            let reference = self.reference()?;
            let end = self.tokens[self.position - 1].span;
            let variable = node(reference.name.to(end), Kind::Reference(reference))?;
            let whole = span.to(end);
            inner = node(whole, Kind::Derivative(Box::new([*inner, *variable])))?;
            if self.symbol() != Some(Symbol::Comma) {
                inner.span = span.to(self.expect(Symbol::Close, CLOSE)?);
                return Ok(inner);
            }
        }
    }
}
