//! Members that are given: in memory, or as a file, CSV or a JSON list of lists.

/// The initial states of members, and parameters of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Members {
    /// The coordinates of one member after the other, where they are given; all start at the scene's initial state where not.
    pub states: Option<Vec<f64>>,
    /// The parameters that are given, by name, with a value for each member.
    pub parameters: Vec<(String, Vec<f64>)>,
}

impl Members {
    /// The members of a text, a row each: one number for each of the coordinates `names`, in their order or under their names;
    /// beside those columns may have names of `parameters`.
    ///
    /// # Errors
    /// The first thing wrong, and in which row or column.
    pub(super) fn read(text: &str, names: &[String], parameters: &[&str]) -> Result<Self, String> {
        // A byte order mark, as spreadsheets write it.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let (columns, rows) = if text.trim_start().starts_with('[') {
            let rows: Result<Vec<Vec<f64>>, _> = serde_json::from_str(text);
            let rows =
                rows.map_err(|error| format!("not a JSON list of lists of numbers: {error}"))?;
            (None, rows)
        } else {
            read_csv(text)?
        };
        let columns = columns.unwrap_or_else(|| names.to_vec());
        let places = places(&columns, names, parameters)?;
        if rows.is_empty() {
            return Err("it has no row of numbers".to_owned());
        }
        for (at, row) in rows.iter().enumerate() {
            if row.len() != columns.len() {
                return Err(format!(
                    "row {} has {} numbers, and {}",
                    at + 1,
                    row.len(),
                    match columns.len() == names.len() {
                        true => format!("the state has {} coordinates", names.len()),
                        false => format!("there are {} columns", columns.len()),
                    }
                ));
            }
            if let Some(value) = row.iter().find(|value| !value.is_finite()) {
                return Err(format!(
                    "row {} holds {value:?}, not a finite number",
                    at + 1
                ));
            }
        }
        let state = |row: &Vec<f64>| places.iter().map(|place| row[*place]).collect::<Vec<_>>();
        let is_parameter = |(_, name): &(usize, &String)| !names.contains(name);
        let own = columns.iter().enumerate().filter(is_parameter);
        let own = own.map(|(at, name)| (name.clone(), rows.iter().map(|row| row[at]).collect()));
        Ok(Self {
            states: Some(rows.iter().flat_map(state).collect()),
            parameters: own.collect(),
        })
    }
}

/// Where the columns of a file hold each coordinate; the others are parameters.
fn places(columns: &[String], names: &[String], parameters: &[&str]) -> Result<Vec<usize>, String> {
    let is_known =
        |column: &&String| names.contains(column) || parameters.contains(&column.as_str());
    if let Some(column) = columns.iter().find(|column| !is_known(column)) {
        let shown: Vec<&str> = names.iter().take(8).map(String::as_str).collect();
        let rest = if names.len() > shown.len() {
            ", …"
        } else {
            ""
        };
        return Err(format!(
            "its column `{column}` is none of the coordinates {}{rest}, and no parameter",
            shown.join(", ")
        ));
    }
    let twice = |(at, column): &(usize, &String)| columns[..*at].contains(column);
    if let Some((_, column)) = columns.iter().enumerate().find(twice) {
        return Err(format!("it has two columns `{column}`"));
    }
    let place = |name: &String| {
        let found = columns.iter().position(|column| column == name);
        found.ok_or_else(|| format!("it has no column `{name}`"))
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
    use super::Members;

    fn members(text: &str) -> Result<Members, String> {
        Members::read(text, &["x1".to_owned(), "x2".to_owned()], &["I1", "I2"])
    }

    fn read(text: &str) -> Result<Vec<f64>, String> {
        members(text).map(|members| members.states.unwrap_or_default())
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

    #[test]
    fn columns_may_have_the_names_of_parameters() {
        let found = members("x2,I2,x1\n1,7,2\n3,8,4").expect("members");
        assert_eq!(found.states, Some(vec![2.0, 1.0, 4.0, 3.0]));
        assert_eq!(found.parameters, [("I2".to_owned(), vec![7.0, 8.0])]);
        for (text, said) in [
            (
                "x1,x2,I2\n1,2",
                "row 1 has 2 numbers, and there are 3 columns",
            ),
            ("x1,x2,I2,I2\n1,2,3,4", "two columns `I2`"),
            (
                "x1,x2,I3\n1,2,3",
                "column `I3` is none of the coordinates x1, x2, and no parameter",
            ),
        ] {
            let error = members(text).expect_err(text);
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
