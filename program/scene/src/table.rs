//! Files of numbers: CSV, or a JSON list of lists or of numbers.

use std::path::Path;

use leafwise_core::NumberArray;

use crate::input::read_text;

/// Rows of numbers, at least one, and the names of their columns where the file gives them.
pub struct Table {
    /// The names.
    pub columns: Option<Vec<String>>,
    /// The rows.
    pub rows: Vec<Vec<f64>>,
}

/// Numbers of one column of a file, a row each. Where `column` names none, it is the file's only column.
///
/// # Errors
/// The first thing wrong, and in which row or column.
pub fn read_column(path: &Path, column: Option<&str>) -> Result<Vec<f64>, String> {
    let numbers = read_table(path)?.column(column);
    numbers.map_err(|reason| format!("{}: {reason}", path.display()))
}

/// The same as an array; the numbers of all columns in rows where `column` names none and there are several without names.
///
/// # Errors
/// As [`read_column`] and [`read_rows`].
pub fn read_numbers(path: &Path, column: Option<&str>) -> Result<NumberArray, String> {
    let table = read_table(path)?;
    let is_grid = column.is_none() && table.columns.is_none() && table.rows[0].len() > 1;
    let array = match is_grid {
        true => table.array(),
        false => table.column(column).map(|numbers| NumberArray {
            shape: vec![numbers.len()],
            numbers,
        }),
    };
    array.map_err(|reason| format!("{}: {reason}", path.display()))
}

fn read_table(path: &Path) -> Result<Table, String> {
    let text =
        read_text(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    Table::read(&text).map_err(|reason| format!("{}: {reason}", path.display()))
}

/// Rows of numbers, all as long as the first.
///
/// # Errors
/// The first thing wrong, and in which row.
pub fn read_rows(path: &Path) -> Result<NumberArray, String> {
    let array = read_table(path)?.array();
    array.map_err(|reason| format!("{}: {reason}", path.display()))
}

/// Numbers of one column of a text.
///
/// # Errors
/// As [`read_column`].
pub fn column_of(text: &str, column: Option<&str>) -> Result<Vec<f64>, String> {
    Table::read(text)?.column(column)
}

impl Table {
    /// A JSON list of rows or of single numbers, or CSV.
    ///
    /// # Errors
    /// What it is not, and in which line.
    pub fn read(text: &str) -> Result<Self, String> {
        // A byte order mark, as spreadsheets write it.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let table = if text.trim_start().starts_with('[') {
            let columns = None;
            let rows = match serde_json::from_str::<Vec<f64>>(text) {
                Ok(numbers) => numbers.into_iter().map(|number| vec![number]).collect(),
                Err(_) => serde_json::from_str(text)
                    .map_err(|error| format!("not a JSON list of lists of numbers: {error}"))?,
            };
            Self { columns, rows }
        } else {
            read_csv(text)?
        };
        match table.rows.is_empty() {
            true => Err("it has no row of numbers".to_owned()),
            false => Ok(table),
        }
    }

    /// Numbers of one column.
    ///
    /// # Errors
    /// As [`read_column`].
    pub fn column(&self, column: Option<&str>) -> Result<Vec<f64>, String> {
        let Table { columns, rows } = self;
        let d = columns.as_ref().map_or(rows[0].len(), Vec::len);
        let at = match (column, columns) {
            (None, _) if d == 1 => 0,
            (None, None) => {
                return Err(format!("it has {d} columns, and no names to choose one by"));
            }
            (None, Some(columns)) => {
                return Err(format!(
                    "it has {d} columns: choose one by column = \"{}\"",
                    columns[0]
                ));
            }
            (Some(name), None) => {
                return Err(format!("it has no header line, and so no column `{name}`"));
            }
            (Some(name), Some(columns)) => place(columns, name)?,
        };
        self.check(d, || format!("others have {d}"))?;
        Ok(rows.iter().map(|row| row[at]).collect())
    }

    /// All numbers in rows as long as the first.
    ///
    /// # Errors
    /// As [`read_rows`].
    pub fn array(&self) -> Result<NumberArray, String> {
        let width = self.rows[0].len();
        self.check(width, || format!("the first has {width}"))?;
        Ok(NumberArray {
            shape: vec![self.rows.len(), width],
            numbers: self.rows.concat(),
        })
    }

    /// Refuses a row of another length, and numbers that are not finite; `expected` says why the length.
    ///
    /// # Errors
    /// The first such row.
    pub fn check(&self, length: usize, expected: impl Fn() -> String) -> Result<(), String> {
        for (row, number) in self.rows.iter().zip(1..) {
            if row.len() != length {
                let found = row.len();
                return Err(format!(
                    "row {number} has {found} numbers, and {}",
                    expected()
                ));
            }
            if let Some(value) = row.iter().find(|value| !value.is_finite()) {
                return Err(format!("row {number} holds {value:?}, not a finite number"));
            }
        }
        Ok(())
    }
}

/// Where the column of this name stands.
///
/// # Errors
/// There is none, or two.
pub fn place(columns: &[String], name: &str) -> Result<usize, String> {
    let mut found = columns
        .iter()
        .enumerate()
        .filter(|(_, column)| *column == name);
    match (found.next(), found.next()) {
        (Some((place, _)), None) => Ok(place),
        (None, _) => Err(format!("it has no column `{name}`")),
        (Some(_), Some(_)) => Err(format!("it has two columns `{name}`")),
    }
}

/// Rows of numbers between commas, semicolons or blanks behind an optional line of names; empty
/// lines and lines that begin with # are left out.
fn read_csv(text: &str) -> Result<Table, String> {
    let lines = text.lines().zip(1..);
    let lines = lines.filter(|(line, _)| !line.trim().is_empty() && !line.starts_with('#'));
    let (mut columns, mut rows) = (None, Vec::new());
    for (at, (line, number)) in lines.enumerate() {
        let cells = cells(line);
        if let Some(empty) = cells.iter().position(|cell| cell.is_empty()) {
            let column = empty + 1;
            return Err(format!(
                "line {number} has an empty cell in column {column}, where a number is missing: {line}"
            ));
        }
        let row: Result<Vec<f64>, _> = cells.iter().map(|cell| cell.parse::<f64>()).collect();
        // A line without any number is one of names; one with some is a row with a slip in it.
        let is_named = at == 0 && cells.iter().all(|cell| cell.parse::<f64>().is_err());
        match row {
            Ok(row) => rows.push(row),
            Err(_) if is_named => {
                let names = cells.iter().map(|cell| cell.trim_matches('"').to_owned());
                columns = Some(names.collect());
            }
            Err(_) => return Err(format!("line {number} is not a row of numbers: {line}")),
        }
    }
    Ok(Table { columns, rows })
}

/// Rows of numbers behind a first line of which only the first cell is no number, as over a column and beside a row of
/// coordinates: NaN stands for it.
pub fn read_cells(text: &str) -> Option<Table> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let is_row = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
    let mut lines = text.lines().filter(is_row);
    let first = cells(lines.next()?);
    let (corner, others) = first.split_first()?;
    let others: Result<Vec<f64>, _> = others.iter().map(|cell| cell.parse::<f64>()).collect();
    let others = others.ok().filter(|others| !others.is_empty())?;
    if corner.parse::<f64>().is_ok() {
        return None;
    }
    let rest: Vec<&str> = lines.collect();
    let mut table = read_csv(&rest.join("\n")).ok()?;
    let corner = std::iter::once(f64::NAN);
    table.rows.insert(0, corner.chain(others).collect());
    table.columns.is_none().then_some(table)
}

/// The cells of a line: between commas where it has one, else between semicolons, else between tabs,
/// else between spaces. Only of spaces are several one. A mark in quotes is of its cell.
fn cells(line: &str) -> Vec<&str> {
    let line = line.trim_matches(' ');
    let parts = [',', ';', '\t'].map(|mark| unquoted(line, mark));
    match parts.into_iter().find(|parts| parts.len() > 1) {
        Some(parts) => parts
            .into_iter()
            .map(|cell| cell.trim_matches(' '))
            .collect(),
        None if line.starts_with('"') => vec![line],
        None => line.split_whitespace().collect(),
    }
}

/// The parts of a line between marks that stand outside of quotes.
fn unquoted(line: &str, mark: char) -> Vec<&str> {
    let (mut parts, mut start, mut is_quoted) = (Vec::new(), 0, false);
    for (at, c) in line.char_indices() {
        if c == '"' {
            is_quoted = !is_quoted;
        } else if c == mark && !is_quoted {
            parts.push(&line[start..at]);
            start = at + mark.len_utf8();
        }
    }
    parts.push(&line[start..]);
    parts
}

#[cfg(test)]
mod tests {
    use super::column_of;

    #[test]
    fn a_column_has_a_number_a_row() {
        for (text, column) in [
            ("1\n2.5\n", None),
            ("[1, 2.5]", None),
            ("[[1], [2.5]]", None),
            ("J\n1\n2.5", None),
            ("J\n1\n2.5", Some("J")),
            ("b,J\n7,1\n8,2.5", Some("J")),
            ("\"J[0,0]\",\"J[0,1]\"\n7,1\n8,2.5", Some("J[0,1]")),
            ("\"J[0,0]\"; b\n1; 7\n2.5; 8", Some("J[0,0]")),
            ("\"J[0,0]\"\n1\n2.5", Some("J[0,0]")),
        ] {
            assert_eq!(column_of(text, column), Ok(vec![1.0, 2.5]), "{text}");
        }
        for (text, column, said) in [
            ("1,2", None, "it has 2 columns, and no names"),
            ("a,b\n1,2", None, "choose one by column = \"a\""),
            ("a,b\n1,2", Some("c"), "it has no column `c`"),
            ("1\n2", Some("a"), "no header line"),
            (
                "a,b\n1,2\n3",
                Some("a"),
                "row 2 has 1 numbers, and others have 2",
            ),
            ("1\nnan", None, "row 2 holds NaN"),
            ("1\ntwo", None, "line 2 is not a row of numbers"),
            ("", None, "it has no row"),
        ] {
            let error = column_of(text, column).expect_err(text);
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
