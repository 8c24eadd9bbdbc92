//! A file of states: CSV, or a JSON list of lists.

/// The numbers of all rows, `d` a row.
///
/// # Errors
/// The first thing wrong, and in which row.
pub(super) fn read_states(text: &str, d: usize) -> Result<Vec<f64>, String> {
    let rows = if text.trim_start().starts_with('[') {
        let rows: Result<Vec<Vec<f64>>, _> = serde_json::from_str(text);
        rows.map_err(|error| format!("not a JSON list of lists of numbers: {error}"))?
    } else {
        read_csv(text)?
    };
    if rows.is_empty() {
        return Err("it has no row".to_owned());
    }
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
    }
    Ok(rows.concat())
}

/// Rows of numbers between commas, semicolons or spaces; a first line of names, empty lines and lines
/// that begin with # are left out.
fn read_csv(text: &str) -> Result<Vec<Vec<f64>>, String> {
    let lines = text.lines().zip(1..);
    let lines = lines.filter(|(line, _)| !line.trim().is_empty() && !line.starts_with('#'));
    let mut rows = Vec::new();
    for (at, (line, number)) in lines.enumerate() {
        let cells = line
            .split([',', ';', ' ', '\t'])
            .filter(|cell| !cell.is_empty());
        let row: Result<Vec<f64>, _> = cells.map(|cell| cell.parse::<f64>()).collect();
        match row {
            Ok(row) => rows.push(row),
            Err(_) if at == 0 => {}
            Err(_) => return Err(format!("line {number} is not a row of numbers: {line}")),
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::read_states;

    #[test]
    fn states_are_read_from_csv_and_json() {
        let numbers = [1.0, 2.5, -3e-4, 0.0];
        for text in [
            "x1,x2\n1,2.5\n\n-3e-4,0\n",
            "# two states\n1 2.5\n-0.0003\t0",
            "[[1, 2.5], [-0.0003, 0]]",
        ] {
            assert_eq!(read_states(text, 2), Ok(numbers.to_vec()), "{text}");
        }
        for (text, said) in [
            ("1,2\n3", "row 2 has 1 numbers"),
            ("1,2\n3,a", "line 2 is not"),
            ("a,b", "it has no row"),
            ("1,inf", "not a finite number"),
            ("[[1, 2], 3]", "not a JSON list"),
        ] {
            let error = read_states(text, 2).expect_err(text);
            assert!(error.contains(said), "{error}");
        }
    }
}
