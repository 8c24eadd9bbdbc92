//! Pairs of states one step apart, in files.

use std::path::Path;

use leafwise_core::NumberArray;

use crate::input::read_text;
use crate::npy::read_npy;
use crate::table::{Table, place};

/// Ends of the names of columns after the step: `x'`, or `x_next`.
const NEXT: [&str; 2] = ["'", "_next"];

/// Columns that may tell the time of a trajectory's rows.
const TIMES: [&str; 2] = ["t", "time"];

/// The column of weights.
const WEIGHT: &str = "weight";

/// Times of rows that differ by the step up to this part of it are one step apart.
const SAME_STEP: f64 = 1e-6;

/// Pairs as arrays of shape (N, d), the last axis fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairTable {
    /// States before the step.
    pub before: Vec<f64>,
    /// States after it.
    pub after: Vec<f64>,
    /// A weight each, where the file has them.
    pub weights: Option<Vec<f64>>,
}

/// Pairs of states of these variables, one `time_step` apart.
///
/// A CSV file has a line of names. With columns `x` and `x'` (or `x_next`) for every variable x each row is a pair. With columns `x` alone the rows are a
/// trajectory. Its neighbours are pairs where a column `t` says that they are one step apart, or where there is none. An array of
/// NumPy's is a trajectory of the shape (T, d), or several, (R, T, d): pairs are (N, 2, d).
///
/// # Errors
/// The first thing wrong, and what to do.
pub fn read_pairs(path: &Path, variables: &[String], time_step: f64) -> Result<PairTable, String> {
    let is_array = path.extension().is_some_and(|extension| extension == "npy");
    if is_array {
        return of_array(&read_npy(path)?, variables)
            .map_err(|reason| format!("{}: {reason}", path.display()));
    }
    let text = read_text(path);
    let text = text.map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    of_text(&text, variables, time_step).map_err(|reason| format!("{}: {reason}", path.display()))
}

/// One number for each pair: an array of NumPy's, or a column.
///
/// # Errors
/// The first thing wrong.
pub fn read_weights(path: &Path) -> Result<Vec<f64>, String> {
    if path.extension().is_some_and(|extension| extension == "npy") {
        let array = read_npy(path)?;
        return match array.shape.len() {
            1 => Ok(array.numbers),
            _ => Err(format!(
                "{}: weights have the shape {:?}, not one number for each pair",
                path.display(),
                array.shape
            )),
        };
    }
    crate::table::read_column(path, None)
}

/// States of these variables: columns by their names, or an array of NumPy's whose last axis is the state.
///
/// # Errors
/// The first thing wrong, and what to do.
pub fn read_states(path: &Path, variables: &[String]) -> Result<Vec<Vec<f64>>, String> {
    let d = variables.len();
    let named = |reason: String| format!("{}: {reason}", path.display());
    if path.extension().is_some_and(|extension| extension == "npy") {
        let array = read_npy(path)?;
        return match array.shape.last() {
            Some(&own) if own == d => Ok(array.numbers.chunks(d).map(<[f64]>::to_vec).collect()),
            _ => Err(named(format!(
                "its shape is {:?}: states of {d} coordinates have the shape (N, {d})",
                array.shape
            ))),
        };
    }
    let text = read_text(path);
    let text = text.map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let table = Table::read(&text).map_err(named)?;
    let columns = table.columns.as_deref().ok_or_else(|| {
        named(format!(
            "it has no header line: begin it with {}",
            variables.join(",")
        ))
    })?;
    let places: Result<Vec<usize>, String> =
        variables.iter().map(|name| place(columns, name)).collect();
    let places = places.map_err(named)?;
    let rows = table.rows.iter().enumerate().map(|(at, row)| {
        let state = places.iter().map(|place| row.get(*place).copied());
        state.collect::<Option<Vec<f64>>>().ok_or_else(|| {
            named(format!(
                "row {} has {} numbers, and {} columns have names",
                at + 1,
                row.len(),
                columns.len()
            ))
        })
    });
    rows.collect()
}

fn of_array(array: &NumberArray, variables: &[String]) -> Result<PairTable, String> {
    let d = variables.len();
    let (runs, length) = match array.shape[..] {
        [length, own] if own == d => (1, length),
        [runs, length, own] if own == d => (runs, length),
        _ => {
            return Err(format!(
                "its shape is {:?}: pairs of states of {d} coordinates have the shape (N, 2, {d}), a trajectory (T, {d})",
                array.shape
            ));
        }
    };
    if length < 2 || runs == 0 {
        return Err("a trajectory of one state has no pair".to_owned());
    }
    let mut table = PairTable::default();
    for run in array.numbers.chunks(length * d) {
        table.before.extend(&run[..(length - 1) * d]);
        table.after.extend(&run[d..]);
    }
    Ok(table)
}

fn of_text(text: &str, variables: &[String], time_step: f64) -> Result<PairTable, String> {
    let table = Table::read(text)?;
    let Some(columns) = &table.columns else {
        return Err(format!(
            "it has no header line: begin it with {}",
            headings(variables)
        ));
    };
    // Numbers that are not finite are refused with their pair.
    let width = columns.len();
    if let Some(at) = table.rows.iter().position(|row| row.len() != width) {
        let found = table.rows[at].len();
        return Err(format!(
            "row {} has {found} numbers, and {width} columns have names",
            at + 1
        ));
    }
    let column = |name: &str| {
        place(columns, name).map_err(|reason| format!("{reason}: it needs {}", headings(variables)))
    };
    let before: Vec<usize> = variables
        .iter()
        .map(|name| column(name))
        .collect::<Result<_, _>>()?;
    // Of columns that may be there, the one that is.
    let optional = |name: &str| -> Result<Option<usize>, String> {
        let is_there = columns.iter().any(|column| column == name);
        match is_there && !variables.iter().any(|variable| variable == name) {
            true => place(columns, name).map(Some),
            false => Ok(None),
        }
    };
    let weight = optional(WEIGHT)?;
    let rows = |places: &[usize]| -> Vec<f64> {
        let rows = table.rows.iter();
        rows.flat_map(|row| places.iter().map(|at| row[*at]))
            .collect()
    };
    let next = NEXT.iter().find(|suffix| {
        let named = variables.iter().map(|name| format!("{name}{suffix}"));
        named.into_iter().any(|name| columns.contains(&name))
    });
    if let Some(suffix) = next {
        let after: Vec<usize> = variables
            .iter()
            .map(|name| column(&format!("{name}{suffix}")))
            .collect::<Result<_, _>>()?;
        return Ok(PairTable {
            before: rows(&before),
            after: rows(&after),
            weights: weight.map(|at| rows(&[at])),
        });
    }
    let times = TIMES.map(optional).into_iter();
    let times = times.collect::<Result<Vec<_>, _>>()?;
    let time = times.into_iter().flatten().min();
    let mut pairs = PairTable {
        weights: weight.map(|_| Vec::new()),
        ..PairTable::default()
    };
    // Of growing times the shortest, of falling ones alone the shortest too, which is negative.
    let mut shortest: Option<f64> = None;
    for rows in table.rows.windows(2) {
        if let Some(at) = time {
            let step = rows[1][at] - rows[0][at];
            let is_shorter = |known: f64| match known > 0.0 {
                true => step > 0.0 && step < known,
                false => step > known,
            };
            if step != 0.0 && step.is_finite() && shortest.is_none_or(is_shorter) {
                shortest = Some(step);
            }
            let is_step = (step - time_step).abs() <= SAME_STEP * time_step.abs();
            if !is_step {
                continue;
            }
        }
        pairs.before.extend(before.iter().map(|at| rows[0][*at]));
        pairs.after.extend(before.iter().map(|at| rows[1][*at]));
        if let (Some(weights), Some(at)) = (&mut pairs.weights, weight) {
            weights.push(rows[0][at]);
        }
    }
    if !pairs.before.is_empty() {
        return Ok(pairs);
    }
    Err(match shortest {
        Some(step) => {
            let falls = if step < 0.0 { ": the times fall" } else { "" };
            format!(
                "no row is one step of {time_step} after the row before it, and the shortest time between two is {step:?}{falls}; \
                 give that step, --set method.time-step={step:?}, or rows at the times of the steps"
            )
        }
        None if table.rows.len() > 1 => {
            "all rows are at one time: leave the column of times out, and each row is one step after the row before it"
                .to_owned()
        }
        None => "a trajectory of one row has no pair".to_owned(),
    })
}

/// The names that a file of pairs needs.
fn headings(variables: &[String]) -> String {
    let next = variables.iter().map(|name| format!("{name}'"));
    let names: Vec<String> = variables.iter().cloned().chain(next).collect();
    let all = names.join(",");
    format!(
        "the columns {all}, or for a trajectory {}",
        variables.join(",")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<PairTable, String> {
        of_text(text, &["q".to_owned(), "p".to_owned()], 0.5)
    }

    /// Names decide on the order of columns, and others are left out.
    #[test]
    fn columns_are_taken_by_their_names() {
        let expected = PairTable {
            before: vec![1.0, 2.0, 5.0, 6.0],
            after: vec![3.0, 4.0, 7.0, 8.0],
            weights: None,
        };
        for text in [
            "q,p,q',p'\n1,2,3,4\n5,6,7,8\n",
            "p',mass,p,q',q\n4,9,2,3,1\n8,9,6,7,5\n",
            "q p q_next p_next\n1 2 3 4\n5 6 7 8\n",
        ] {
            assert_eq!(table(text), Ok(expected.clone()), "{text}");
        }
        let weighted = table("q,p,q',p',weight\n1,2,3,4,1\n5,6,7,8,0.5\n").expect("pairs");
        assert_eq!(weighted.weights, Some(vec![1.0, 0.5]));
    }

    /// Neighbours of a trajectory are pairs, but where it begins anew.
    #[test]
    fn trajectories_are_pairs_of_neighbours() {
        let expected = PairTable {
            before: vec![1.0, 2.0, 7.0, 8.0],
            after: vec![3.0, 4.0, 9.0, 0.0],
            weights: None,
        };
        let text = "t,q,p\n0,1,2\n0.5,3,4\n0,7,8\n0.5,9,0\n";
        assert_eq!(table(text), Ok(expected));
        assert_eq!(table("q,p\n1,2\n3,4\n").expect("one").before, [1.0, 2.0]);
        let array = NumberArray {
            shape: vec![2, 2, 2],
            numbers: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0],
        };
        let found = of_array(&array, &["q".to_owned(), "p".to_owned()]).expect("pairs");
        assert_eq!(found.before, [1.0, 2.0, 5.0, 6.0]);
        assert_eq!(found.after, [3.0, 4.0, 7.0, 8.0]);
    }

    /// A trajectory whose times fall is one of negative steps: the error names that step, which takes it.
    #[test]
    fn falling_times_are_pairs_of_the_negative_step() {
        let text = "t,q,p\n3,1,2\n2,3,4\n1,5,6\n";
        let variables = ["q".to_owned(), "p".to_owned()];
        let reason = of_text(text, &variables, 1.0).expect_err("falling times");
        let (_, behind) = reason
            .split_once("--set method.time-step=")
            .expect("a cure");
        let step: f64 = behind
            .split(',')
            .next()
            .and_then(|step| step.parse().ok())
            .expect("a number");
        let pairs = of_text(text, &variables, step).expect("pairs");
        assert_eq!(pairs.before, [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(pairs.after, [3.0, 4.0, 5.0, 6.0]);
    }

    #[test]
    fn files_that_are_no_pairs_say_what_they_need() {
        for (text, expected) in [
            ("1,2,3,4\n", "begin it with the columns q,p,q',p'"),
            (
                "q,x\n1,2\n",
                "it has no column `p`: it needs the columns q,p,q',p'",
            ),
            ("q,p,q'\n1,2,3\n", "it has no column `p'`"),
            ("q,p,p\n1,2,3\n", "it has two columns `p`"),
            ("q,p,q',p',q'\n1,2,3,4,5\n", "it has two columns `q'`"),
            ("t,q,p,t\n0,1,2,0\n", "it has two columns `t`"),
            (
                "q,p,q',p',weight,weight\n1,2,3,4,1,2\n",
                "it has two columns `weight`",
            ),
            (
                "q,p,q',p'\n1,2,3\n",
                "row 1 has 3 numbers, and 4 columns have names",
            ),
            ("q,p\n1,2\n", "a trajectory of one row has no pair"),
            ("t,q,p\n0,1,2\n0.1,3,4\n", "--set method.time-step=0.1"),
            // Several trajectories: the times fall where one begins.
            (
                "t,q,p\n0,1,2\n0.1,3,4\n0,1,3\n0.2,3,5\n",
                "--set method.time-step=0.1,",
            ),
            ("t,q,p\n1,1,2\n0.5,3,4\n0,5,6\n", "is -0.5: the times fall"),
            ("t,q,p\n1,1,2\n1,3,4\n", "all rows are at one time"),
        ] {
            let reason = table(text).expect_err(text);
            assert!(reason.contains(expected), "{text}: {reason}");
        }
        let array = NumberArray {
            shape: vec![4, 3],
            numbers: vec![0.0; 12],
        };
        let reason = of_array(&array, &["q".to_owned()]).expect_err("three coordinates");
        assert!(reason.contains("(N, 2, 1)"), "{reason}");
    }
}
