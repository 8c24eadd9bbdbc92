//! Tables in formulas: their names, their arguments, and the orders of derivatives behind these.

use super::error::{SyntaxError, SyntaxErrorKind};
use super::scope::{Entry, Scope};
use super::suggestion::{alias, is_elsewhere, nearest, written};
use super::tree::{Kind, Node, Span};
use super::vocabulary::function_names;
use crate::table::{Lookup, TableFunction};

impl Scope {
    /// Adds a table, which formulas call by its name. Of two declarations of one name the later holds.
    pub fn with_table(mut self, table: TableFunction) -> Self {
        self.declare(table.name(), Entry::Table(self.tables.len()));
        self.tables.push(table);
        self
    }

    /// Checks that `name` may be given to a table.
    ///
    /// # Errors
    /// Those of [`Scope::check_name`], and `ReservedName` for the name of any function.
    pub fn check_table_name(name: &str) -> Result<(), SyntaxError> {
        Self::check_name(name)?;
        if function_names().any(|function| function == name) {
            let name = name.to_owned();
            let span = Span {
                start: 0,
                end: name.len(),
            };
            return Err(SyntaxError::new(
                span,
                SyntaxErrorKind::ReservedName { name },
            ));
        }
        Ok(())
    }

    /// The table called at `name`, or the derivative of it that orders behind the point ask for, with the point.
    ///
    /// # Errors
    /// `UnknownFunction` where it is no table's name, `Arguments` for another number of arguments, and `Orders` for orders
    /// that are no whole numbers.
    pub(super) fn lookup<'a>(
        &self,
        text: &str,
        name: Span,
        arguments: &'a [Node],
    ) -> Result<(Option<Lookup>, TableFunction, &'a [Node]), SyntaxError> {
        let called = name.of(text);
        let Some(Entry::Table(at)) = self.entry_of(called) else {
            let tables = self.tables.iter().map(|table| table.name());
            return Err(unknown_function(called, name, tables));
        };
        let table = self.tables[at];
        let axes = table.axes().len();
        let (point, orders) = arguments.split_at(axes.min(arguments.len()));
        if point.len() < axes || !orders.is_empty() && orders.len() != axes {
            let kind = SyntaxErrorKind::Arguments {
                name: called.to_owned(),
                axes: table.axes().iter().map(|axis| axis.name.clone()).collect(),
                found: arguments.len(),
            };
            let last = arguments.last().map_or(name, |last| last.span);
            return Err(SyntaxError::new(name.to(last), kind));
        }
        let mut own = Vec::with_capacity(axes);
        for order in orders {
            let number = match &order.kind {
                Kind::Number { exact, .. } => exact.to_i64(),
                _ => None,
            };
            let number = number.and_then(|number| u8::try_from(number).ok());
            let number = number.ok_or_else(|| {
                let name = called.to_owned();
                SyntaxError::new(order.span, SyntaxErrorKind::Orders { name })
            });
            own.push(number?);
        }
        Ok((Lookup::of_orders(table, &own), table, point))
    }
}

/// The error that there is no function of this name, nor a table.
pub(super) fn unknown_function<'a>(
    name: &'a str,
    span: Span,
    tables: impl Iterator<Item = &'a str>,
) -> SyntaxError {
    let functions = function_names().map(|known| -> &'a str { known });
    let misspelt = || nearest(name, tables.chain(functions)).filter(|_| !is_elsewhere(name));
    // Of a library of another language, `np.sqrt`.
    let own = name.rsplit('.').next().unwrap_or(name);
    let same = || function_names().find(|known| *known == own && own != name);
    let suggestion: Option<&str> = alias(&own.to_lowercase()).or_else(|| written(own));
    let suggestion = suggestion.or_else(same);
    let suggestion = suggestion.or_else(misspelt);
    let kind = SyntaxErrorKind::UnknownFunction {
        name: name.to_owned(),
    };
    SyntaxError::new(span, kind).suggesting(suggestion)
}
