//! Formulas as text again, with no more parentheses than the tree needs.

use std::fmt;

use super::formula::Formula;
use super::tree::{Anchor, Kind, Node, Reference, Span};
use crate::expression::Function;

/// How tightly a part holds together; a part in a place that needs more is put in parentheses.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Binding {
    Sum,
    Product,
    Sign,
    Power,
    Atom,
}

impl fmt::Display for Formula {
    /// The formula in a uniform spelling, which parses to the same tree. Numbers stand as written.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        Printer {
            text: self.source(),
            formatter,
        }
        .print(self.root(), Binding::Sum)
    }
}

pub(super) fn print_reference(
    text: &str,
    reference: &Reference,
    formatter: &mut fmt::Formatter<'_>,
) -> fmt::Result {
    formatter.write_str(reference.name.of(text))?;
    for (axis, site) in reference.sites.iter().enumerate() {
        formatter.write_str(if axis == 0 { "[" } else { "," })?;
        let offset = site.offset;
        match site.anchor {
            Anchor::Start => write!(formatter, "{offset}")?,
            Anchor::End => formatter.write_str("N")?,
            Anchor::Name(name) => formatter.write_str(name.of(text))?,
        }
        if site.anchor != Anchor::Start && offset != 0 {
            write!(formatter, "{offset:+}")?;
        }
    }
    match reference.sites.is_empty() {
        true => Ok(()),
        false => formatter.write_str("]"),
    }
}

struct Printer<'a, 'b> {
    text: &'a str,
    formatter: &'a mut fmt::Formatter<'b>,
}

impl Printer<'_, '_> {
    fn print(&mut self, node: &Node, place: Binding) -> fmt::Result {
        if binding(&node.kind) < place {
            self.write("(")?;
            self.bare(&node.kind)?;
            return self.write(")");
        }
        self.bare(&node.kind)
    }

    fn bare(&mut self, kind: &Kind) -> fmt::Result {
        match kind {
            Kind::Number { literal, .. } => self.write_span(*literal),
            Kind::Pi => self.write(super::vocabulary::PI),
            Kind::Length => self.write(super::vocabulary::LENGTH),
            Kind::Reference(reference) => print_reference(self.text, reference, self.formatter),
            Kind::Call(function, argument) => {
                self.write(function.name())?;
                self.write("(")?;
                self.print(argument, Binding::Sum)?;
                if let Function::Special(_, order @ 1..) = function {
                    write!(self.formatter, ", {order}")?;
                }
                self.write(")")
            }
            Kind::Lookup(name, arguments) => self.called(name.of(self.text), arguments),
            Kind::Composite(composite, arguments) => self.called(composite.name(), arguments),
            Kind::If(parts) => self.called(super::vocabulary::IF, parts.as_slice()),
            Kind::Compare(relation, pair) => {
                self.print(&pair[0], Binding::Sum)?;
                write!(self.formatter, " {} ", relation.sign())?;
                self.print(&pair[1], Binding::Sum)
            }
            Kind::And(parts) => parts.iter().enumerate().try_for_each(|(at, part)| {
                self.write(if at > 0 { " and " } else { "" })?;
                self.part(part, matches!(part.kind, Kind::Or(_)))
            }),
            Kind::Not(part) => {
                self.write("not ")?;
                self.part(part, matches!(part.kind, Kind::And(_) | Kind::Or(_)))
            }
            Kind::Or(parts) => self.list(parts, " or "),
            Kind::Derivative(pair) => self.called(super::vocabulary::DERIVATIVE, pair.as_slice()),
            Kind::SumOver { index, body, .. } => {
                self.write("sum(")?;
                self.write_span(*index)?;
                let mut body = body;
                // Sums over several indices are written as one.
                while let Kind::SumOver {
                    index,
                    above,
                    body: inner,
                } = &body.kind
                {
                    self.write(if above.is_some() { "<" } else { ", " })?;
                    self.write_span(*index)?;
                    body = inner;
                }
                self.write(", ")?;
                self.print(body, Binding::Sum)?;
                self.write(")")
            }
            Kind::Sum(terms) => {
                self.print(&terms[0], Binding::Product)?;
                terms[1..].iter().try_for_each(|term| match &term.kind {
                    Kind::Negate(operand) => {
                        self.write(" - ")?;
                        self.print(operand, Binding::Product)
                    }
                    _ => {
                        self.write(" + ")?;
                        self.print(term, Binding::Product)
                    }
                })
            }
            Kind::Product(factors) => {
                // A leading product would merge with this one; a leading quotient does not.
                let first = match factors[0].kind {
                    Kind::Quotient(_) => Binding::Product,
                    _ => Binding::Sign,
                };
                self.print(&factors[0], first)?;
                factors[1..].iter().try_for_each(|factor| {
                    self.write("*")?;
                    self.print(factor, Binding::Sign)
                })
            }
            Kind::Negate(operand) => {
                self.write("-")?;
                self.print(operand, Binding::Sign)
            }
            Kind::Quotient(pair) => {
                self.print(&pair[0], Binding::Product)?;
                self.write("/")?;
                self.print(&pair[1], Binding::Sign)
            }
            Kind::Power(pair) => {
                self.print(&pair[0], Binding::Atom)?;
                self.write("^")?;
                self.print(&pair[1], Binding::Sign)
            }
        }
    }

    /// A part of a condition, in parentheses or not.
    fn part(&mut self, part: &Node, is_closed: bool) -> fmt::Result {
        self.write(if is_closed { "(" } else { "" })?;
        self.print(part, Binding::Sum)?;
        self.write(if is_closed { ")" } else { "" })
    }

    fn called(&mut self, name: &str, arguments: &[Node]) -> fmt::Result {
        self.write(name)?;
        self.write("(")?;
        self.list(arguments, ", ")?;
        self.write(")")
    }

    fn list(&mut self, parts: &[Node], between: &str) -> fmt::Result {
        for (at, part) in parts.iter().enumerate() {
            if at > 0 {
                self.write(between)?;
            }
            self.print(part, Binding::Sum)?;
        }
        Ok(())
    }

    fn write(&mut self, text: &str) -> fmt::Result {
        self.formatter.write_str(text)
    }

    fn write_span(&mut self, span: Span) -> fmt::Result {
        self.formatter.write_str(span.of(self.text))
    }
}

fn binding(kind: &Kind) -> Binding {
    match kind {
        Kind::Sum(_) => Binding::Sum,
        Kind::Product(_) | Kind::Quotient(_) => Binding::Product,
        Kind::Negate(_) => Binding::Sign,
        Kind::Power(_) => Binding::Power,
        _ => Binding::Atom,
    }
}
