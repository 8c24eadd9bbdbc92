//! A file of states: CSV, or a JSON list of lists.

/// The numbers of all rows, one for each of the coordinates `names` a row, in their order.
///
/// # Errors
/// The first thing wrong, and in which row or column.
pub(super) fn read_states(text: &str, names: &[String]) -> Result<Vec<f64>, String> {
    let d = names.len();
    // A byte order mark, as spreadsheets write it.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (columns, rows) = if text.trim_start().starts_with('[') {
        let rows: Result<Vec<Vec<f64>>, _> = serde_json::from_str(text);
        let rows = rows.map_err(|error| format!("not a JSON list of lists of numbers: {error}"))?;
        (None, rows)
    } else {
        read_csv(text)?
    };
    let places = columns.map(|columns| places(&columns, names)).transpose()?;
    if rows.is_empty() {
        return Err("it has no row of numbers".to_owned());
    }
    let mut states = Vec::with_capacity(rows.len() * d);
    for (at, row) in rows.iter().enumerate() {
        if row.len() != d {
            return Err(format!(
                "row {} has {} numbers, and the state has {d} coordinates",
                at + 1,
                row.len()
            ));
        }
        if let Some(value) = row.iter().find(|value| !value.is_finite()) {
            return Err(format!(
                "row {} holds {value:?}, not a finite number",
                at + 1
            ));
        }
        match &places {
            Some(places) => states.extend(places.iter().map(|place| row[*place])),
            None => states.extend(row),
        }
    }
    Ok(states)
}

/// Where the columns of a file hold each coordinate.
fn places(columns: &[String], names: &[String]) -> Result<Vec<usize>, String> {
    if let Some(column) = columns.iter().find(|column| !names.contains(column)) {
        let shown: Vec<&str> = names.iter().take(8).map(String::as_str).collect();
        let rest = if names.len() > shown.len() {
            ", …"
        } else {
            ""
        };
        return Err(format!(
            "its column `{column}` is none of the coordinates {}{rest}",
            shown.join(", ")
        ));
    }
    let place = |name: &String| {
        let mut found = columns
            .iter()
            .enumerate()
            .filter(|(_, column)| *column == name);
        match (found.next(), found.next()) {
            (Some((place, _)), None) => Ok(place),
            (None, _) => Err(format!("it has no column `{name}`")),
            (Some(_), Some(_)) => Err(format!("it has two columns `{name}`")),
        }
    };
    names.iter().map(place).collect()
}

/// Names of columns where there is a line of them, and the rows.
type Table = (Option<Vec<String>>, Vec<Vec<f64>>);

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
    Ok((columns, rows))
}

/// The cells of a line: between commas where it has one, else between semicolons, else between tabs,
/// else between spaces. Only of spaces are several one.
fn cells(line: &str) -> Vec<&str> {
    let line = line.trim_matches(' ');
    match [',', ';', '\t']
        .into_iter()
        .find(|mark| line.contains(*mark))
    {
        Some(mark) => line
            .split(mark)
            .map(|cell| cell.trim_matches(' '))
            .collect(),
        None => line.split_whitespace().collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::read_states;

    fn read(text: &str) -> Result<Vec<f64>, String> {
        read_states(text, &["x1".to_owned(), "x2".to_owned()])
    }

    #[test]
    fn states_are_read_from_csv_and_json() {
        let numbers = [1.0, 2.5, -3e-4, 0.0];
        for text in [
            "x1,x2\n1,2.5\n\n-3e-4,0\n",
            "# two states\n1 2.5\n-0.0003\t0",
            "\u{feff}x1, x2\r\n1 , 2.5\r\n-3e-4,0\r\n",
            "\u{feff} [[1, 2.5], [-0.0003, 0]]",
            "  1   2.5 \n -3e-4  0",
            "\"x1\";\"x2\"\n1;2.5\n-3e-4;0",
            "[[1, 2.5], [-0.0003, 0]]",
        ] {
            assert_eq!(read(text), Ok(numbers.to_vec()), "{text}");
        }
        for (text, said) in [
            ("1,2\n3", "row 2 has 1 numbers"),
            ("1,2\n3,a", "line 2 is not"),
            ("1,a\n3,4", "line 1 is not"),
            ("x1,x2", "it has no row"),
            ("", "it has no row"),
            ("1,inf", "not a finite number"),
            ("1,,2", "line 1 has an empty cell in column 2"),
            ("x1,x2\n,4,5", "line 2 has an empty cell in column 1"),
            ("1,2\n3,4,", "line 2 has an empty cell in column 3"),
            ("1;;2", "empty cell in column 2"),
            ("1\t\t2", "empty cell in column 2"),
            ("x1,,x2\n1,2", "line 1 has an empty cell in column 2"),
            ("1,5;2,5", "line 1 is not"),
            ("[[1, 2], 3]", "not a JSON list"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.contains(said), "{error}");
        }
    }

    #[test]
    fn named_columns_stand_in_any_order_and_are_the_coordinates() {
        assert_eq!(read("x2,x1\n1,2\n3,4"), Ok(vec![2.0, 1.0, 4.0, 3.0]));
        for (text, said) in [
            ("x1,y\n1,2", "column `y` is none of the coordinates x1, x2"),
            ("x1,x1\n1,2", "two columns `x1`"),
            ("x1,x2,x1\n1,2,3", "two columns `x1`"),
            ("x1\n1", "no column `x2`"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
