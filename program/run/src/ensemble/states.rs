//! Members that are given: in memory, or as a file, CSV or a JSON list of lists.

use leafwise_scene::table::{Table, place};

/// The initial states of members, and parameters of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Members {
    /// The coordinates of one member after the other, where they are given; all start at the scene's initial state where not.
    pub states: Option<Vec<f64>>,
    /// The parameters that are given, by name, with a value for each member.
    pub parameters: Vec<(String, Vec<f64>)>,
}

impl Members {
    /// Members of a text, a row each: one number for each of the coordinates `names`, in their order or under their
    /// names. Further columns may have names of `parameters`.
    ///
    /// # Errors
    /// The first thing wrong, and in which row or column.
    pub(super) fn read(text: &str, names: &[String], parameters: &[&str]) -> Result<Self, String> {
        let table = Table::read(text)?;
        let columns = table.columns.as_deref().unwrap_or(names);
        let places = places(columns, names, parameters)?;
        table.check(columns.len(), || match columns.len() == names.len() {
            true => format!("the state has {} coordinates", names.len()),
            false => format!("there are {} columns", columns.len()),
        })?;
        let rows = table.rows.iter();
        let state = |row: &Vec<f64>| places.iter().map(|place| row[*place]).collect::<Vec<_>>();
        let is_parameter = |(_, name): &(usize, &String)| !names.contains(name);
        let own = columns.iter().enumerate().filter(is_parameter);
        let own = own.map(|(at, name)| (name.clone(), rows.clone().map(|row| row[at]).collect()));
        Ok(Self {
            states: Some(rows.clone().flat_map(state).collect()),
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
            "its column `{column}` is neither one of the coordinates {}{rest} nor a parameter",
            shown.join(", ")
        ));
    }
    let twice = |(at, column): &(usize, &String)| columns[..*at].contains(column);
    if let Some((_, column)) = columns.iter().enumerate().find(twice) {
        return Err(format!("it has two columns `{column}`"));
    }
    names.iter().map(|name| place(columns, name)).collect()
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
            (
                "x1,y\n1,2",
                "column `y` is neither one of the coordinates x1, x2",
            ),
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
                "column `I3` is neither one of the coordinates x1, x2 nor a parameter",
            ),
        ] {
            let error = members(text).expect_err(text);
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
