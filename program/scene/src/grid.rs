//! Numbers at the nodes of a grid, from a file of text: columns, a grid of values, or a list of places and values.

use std::path::Path;

use leafwise_core::NumberArray;

use crate::input::read_text;
use crate::table::{Table, column_of, place, read_cells};

/// How far from a node a place may be that is given as one, over the distance of nodes.
const MISPLACED: f64 = 1e-3;

/// Nodes at equal distances.
pub struct GridAxis<'a> {
    /// Its name.
    pub name: &'a str,
    /// The first and the last node, or the two ends of a period.
    pub ends: [f64; 2],
    /// Whether the last end is the first one again, and no node.
    pub is_periodic: bool,
}

impl GridAxis<'_> {
    fn spacing(&self, nodes: usize) -> f64 {
        let parts = nodes.saturating_sub(usize::from(!self.is_periodic));
        (self.ends[1] - self.ends[0]) / parts.max(1) as f64
    }

    /// The node at a place, of so many.
    fn node(&self, value: f64, nodes: usize) -> Option<usize> {
        let at = (value - self.ends[0]) / self.spacing(nodes);
        let node = at.round();
        let is_one = (at - node).abs() <= MISPLACED && node >= 0.0 && node < nodes as f64;
        is_one.then_some(node as usize)
    }

    /// Whether these are its nodes from the first to the last.
    fn are_nodes(&self, values: &[f64]) -> bool {
        let mut own = values.iter().zip(0..);
        own.all(|(value, at)| self.node(*value, values.len()) == Some(at))
    }

    /// The first nodes, of so many.
    fn shown(&self, nodes: usize) -> String {
        let node = |at: usize| self.ends[0] + at as f64 * self.spacing(nodes);
        let first: Vec<String> = (0..nodes.min(3)).map(|at| short(node(at))).collect();
        match nodes {
            0..=3 => first.join(", "),
            _ => format!("{}, … {}", first.join(", "), short(node(nodes - 1))),
        }
    }
}

/// A number with as many digits as say where it is.
fn short(value: f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6 + 0.0)
}

/// Numbers at the nodes of these axes.
///
/// # Errors
/// The first thing wrong, and in which row or column.
pub fn read_nodes(
    path: &Path,
    axes: &[GridAxis<'_>],
    column: Option<&str>,
) -> Result<NumberArray, String> {
    let text =
        read_text(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    nodes_of(&text, axes, column).map_err(|reason| format!("{}: {reason}", path.display()))
}

fn nodes_of(
    text: &str,
    axes: &[GridAxis<'_>],
    column: Option<&str>,
) -> Result<NumberArray, String> {
    let table = Table::read(text).or_else(|error| match axes.len() {
        2 => read_cells(text).ok_or(error),
        _ => Err(error),
    })?;
    if let Some(list) = List::of(&table, axes, column)? {
        return list.numbers(&table, axes);
    }
    match axes.len() {
        1 => {
            let numbers = column_of(text, column)?;
            Ok(NumberArray {
                shape: vec![numbers.len()],
                numbers,
            })
        }
        2 if column.is_none() => grid(&table, axes),
        _ => {
            let names: Vec<&str> = axes.iter().map(|axis| axis.name).collect();
            let places = names.join(", ");
            let is_of_two = axes.len() == 2;
            let what = match is_of_two {
                true => "`column` chooses one of a list",
                false => "of three axes a file of text is a list",
            };
            Err(format!(
                "{what}, whose first line has the names of the axes, {places}, and one of the values: a row for each node"
            ))
        }
    }
}

/// Nodes for each row of a list, at most, that are made room for.
const MOST_NODES_A_ROW: u128 = 1000;

/// A row for each node: its place on every axis, and the value there.
struct List {
    /// The columns of the places, in the order of the axes.
    places: Vec<usize>,
    value: usize,
    /// Whether the file has no names, and only its numbers say that it is a list.
    is_guess: bool,
}

impl List {
    fn of(
        table: &Table,
        axes: &[GridAxis<'_>],
        column: Option<&str>,
    ) -> Result<Option<Self>, String> {
        let width = table.columns.as_ref().map_or(table.rows[0].len(), Vec::len);
        let Some(names) = &table.columns else {
            let is_guess = axes.len() > 1 && width == axes.len() + 1 && column.is_none();
            return Ok(is_guess.then(|| Self {
                places: (0..axes.len()).collect(),
                value: axes.len(),
                is_guess,
            }));
        };
        if width <= axes.len()
            || !axes
                .iter()
                .all(|axis| names.iter().any(|name| name == axis.name))
        {
            return Ok(None);
        }
        let places: Result<Vec<usize>, String> =
            axes.iter().map(|axis| place(names, axis.name)).collect();
        let places = places?;
        let others: Vec<usize> = (0..width).filter(|at| !places.contains(at)).collect();
        let value = match (column, others.as_slice()) {
            (Some(name), _) => place(names, name)?,
            (None, [only]) => *only,
            (None, several) => {
                let named: Vec<&str> = several.iter().map(|at| names[*at].as_str()).collect();
                return Err(format!(
                    "its values may be in the columns {}: choose one by column = \"{}\"",
                    named.join(", "),
                    named[0]
                ));
            }
        };
        Ok((!places.contains(&value)).then_some(Self {
            places,
            value,
            is_guess: false,
        }))
    }

    /// The values in the order of the axes.
    fn numbers(&self, table: &Table, axes: &[GridAxis<'_>]) -> Result<NumberArray, String> {
        let rows = &table.rows;
        let width = table.columns.as_ref().map_or(rows[0].len(), Vec::len);
        table.check(width, || format!("others have {width}"))?;
        let column = |at: usize| -> Vec<f64> { rows.iter().map(|row| row[at]).collect() };
        let shape: Vec<usize> = (axes.iter().zip(&self.places))
            .map(|(axis, at)| different(column(*at), axis))
            .collect();
        match self.fill(table, axes, &shape) {
            Err(_) if self.is_guess && axes.len() == 2 => grid(table, axes),
            filled => filled,
        }
    }

    fn fill(
        &self,
        table: &Table,
        axes: &[GridAxis<'_>],
        shape: &[usize],
    ) -> Result<NumberArray, String> {
        let rows = table.rows.len();
        let missing = |count: u128| {
            let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
            format!(
                "it is a list with {rows} rows, and {count} nodes of {} are missing: every node needs one row",
                lengths.join(" × ")
            )
        };
        let nodes = shape.iter().map(|nodes| *nodes as u128).product::<u128>();
        // Places without an order have many more nodes than rows: those are not made room for.
        if nodes > MOST_NODES_A_ROW * rows as u128 {
            return Err(missing(nodes - rows as u128));
        }
        let mut numbers = vec![f64::NAN; nodes as usize];
        for (row, number) in table.rows.iter().zip(1..) {
            let mut place = 0;
            for ((axis, at), nodes) in axes.iter().zip(&self.places).zip(shape) {
                let Some(node) = axis.node(row[*at], *nodes) else {
                    return Err(format!(
                        "row {number} has {} = {:?}, which is not a node: {nodes} nodes at equal distances on `axes` are {}",
                        axis.name,
                        row[*at],
                        axis.shown(*nodes)
                    ));
                };
                place = place * nodes + node;
            }
            if !numbers[place].is_nan() {
                return Err(format!("row {number} has the node of another row"));
            }
            numbers[place] = row[self.value];
        }
        let count = numbers.iter().filter(|number| number.is_nan()).count();
        if count > 0 {
            return Err(missing(count as u128));
        }
        Ok(NumberArray {
            shape: shape.to_vec(),
            numbers,
        })
    }
}

/// How many different places there are, up to what numbers in a file are rounded to.
fn different(mut places: Vec<f64>, axis: &GridAxis<'_>) -> usize {
    let room = 1e-7 * (axis.ends[1] - axis.ends[0]);
    places.sort_by(f64::total_cmp);
    places.dedup_by(|one, other| (*one - *other).abs() <= room);
    places.len()
}

/// A row for each node of the first axis. Coordinates in the first row and column, where they are the nodes of the axes, are
/// left out.
fn grid(table: &Table, axes: &[GridAxis<'_>]) -> Result<NumberArray, String> {
    let rows = &table.rows;
    let (height, width) = (rows.len(), rows[0].len());
    let has_corner = rows[0][0].is_finite();
    let array = |rows: &[Vec<f64>], from: usize| NumberArray {
        shape: vec![rows.len(), rows[0].len() - from],
        numbers: rows.iter().flat_map(|row| row[from..].to_vec()).collect(),
    };
    let is_whole = rows.iter().all(|row| row.len() == width);
    if is_whole && height > 2 && width > 2 {
        let first = &rows[0][1..];
        let side: Vec<f64> = rows[1..].iter().map(|row| row[0]).collect();
        if axes[0].are_nodes(&side) && axes[1].are_nodes(first) {
            let inside = Table {
                columns: None,
                rows: rows[1..].to_vec(),
            };
            inside.check(width, || format!("the first has {width}"))?;
            return Ok(array(&inside.rows, 1));
        }
        let is_turned = axes[1].are_nodes(&side) && axes[0].are_nodes(first);
        let rises = |values: &[f64]| values.len() > 2 && rise(values);
        // Values that are linear along both go on through the corner.
        let whole: Vec<f64> = std::iter::once(rows[0][0]).chain(side.clone()).collect();
        let goes_on = has_corner && rise(&rows[0]) && rise(&whole);
        if is_turned || !has_corner || rises(first) && rises(&side) && !goes_on {
            return Err(coordinates(axes, (&side, first), is_turned));
        }
    }
    table.check(width, || format!("the first has {width}"))?;
    Ok(array(rows, 0))
}

/// Whether numbers rise by equal distances, as coordinates do.
fn rise(values: &[f64]) -> bool {
    let [first, .., last] = values else {
        return false;
    };
    let axis = GridAxis {
        name: "",
        ends: [*first, *last],
        is_periodic: false,
    };
    first < last && axis.are_nodes(values)
}

/// Advice on coordinates that are not those of the axes.
fn coordinates(axes: &[GridAxis<'_>], (side, first): (&[f64], &[f64]), is_turned: bool) -> String {
    let shown = |values: &[f64]| match values {
        [one, .., last] => format!("{} … {}", short(*one), short(*last)),
        _ => String::new(),
    };
    let found = format!(
        "its first column, {}, and its first row, {}, look like coordinates",
        shown(side),
        shown(first)
    );
    let [x, y] = [axes[0].name, axes[1].name];
    let (nodes, others) = (axes[0].shown(side.len()), axes[1].shown(first.len()));
    match is_turned {
        true => format!(
            "{found}, of {y} down and {x} along: rows belong to the first axis, so turn the grid, or give axes and arguments \
             in the other order"
        ),
        false => format!(
            "{found}, and not those of `axes`, {x}: {nodes}, {y}: {others}; give `axes` their ends, and they are left out, or \
             leave them out yourself: all other numbers are values"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::{GridAxis, nodes_of};

    fn axes() -> [GridAxis<'static>; 2] {
        [("x", 1.0), ("y", 0.3)].map(|(name, last)| GridAxis {
            name,
            ends: [0.0, last],
            is_periodic: false,
        })
    }

    fn value(x: f64, y: f64) -> f64 {
        1.0 + x * x + 3.0 * x * y
    }

    const X: [f64; 3] = [0.0, 0.5, 1.0];
    const Y: [f64; 4] = [0.0, 0.1, 0.2, 0.3];

    fn expected() -> Vec<f64> {
        X.iter().flat_map(|x| Y.map(|y| value(*x, y))).collect()
    }

    fn joined(cells: &[f64]) -> String {
        let cells: Vec<String> = cells.iter().map(|cell| format!("{cell:?}")).collect();
        cells.join(",")
    }

    /// The grid with a corner before its coordinates.
    fn with_coordinates(corner: &str) -> String {
        let head = format!("{corner},{}\n", joined(&Y));
        let rows = X.map(|x| format!("{x:?},{}\n", joined(&Y.map(|y| value(x, y)))));
        head + &rows.concat()
    }

    #[test]
    fn one_grid_comes_from_values_from_coordinates_and_from_lists() {
        let bare: String = X.map(|x| joined(&Y.map(|y| value(x, y))) + "\n").concat();
        let mut rows: Vec<String> = (X.iter())
            .flat_map(|x| Y.map(|y| format!("{y:?},{:?},{x:?}\n", value(*x, y))))
            .collect();
        // In whatever order rows stand.
        rows.rotate_left(5);
        rows.swap(1, 7);
        let list = format!("y,B,x\n{}", rows.concat());
        let several = format!("y,B,x,C\n{}", rows.concat().replace('\n', ",7\n"));
        let plain: String = (X.iter())
            .flat_map(|x| Y.map(|y| format!("{x:?} {y:?} {:?}\n", value(*x, y))))
            .collect();
        let corners = ["0", "x\\y", "", "3"].map(with_coordinates);
        let mut texts: Vec<(&str, Option<&str>)> =
            vec![(&bare, None), (&list, None), (&plain, None)];
        texts.push((&several, Some("B")));
        texts.extend(corners.iter().map(|text| (text.as_str(), None)));
        for (text, column) in texts {
            let read =
                nodes_of(text, &axes(), column).unwrap_or_else(|error| panic!("{error}\n{text}"));
            assert_eq!(
                (read.shape, read.numbers),
                (vec![3, 4], expected()),
                "{text}"
            );
        }
    }

    /// x + y is a table of values, whatever it looks like.
    #[test]
    fn a_linear_table_is_one_of_values() {
        let rows = X.map(|x| joined(&Y.map(|y| x + y)) + "\n").concat();
        let read = nodes_of(&rows, &axes(), None).expect("values");
        assert_eq!(read.shape, [3, 4]);
    }

    #[test]
    fn what_is_no_grid_of_the_axes_is_said() {
        let list = "x,y,B\n0,0,1\n0,0.3,2\n1,0,3\n";
        let turned: String = format!("0,{}\n", joined(&X))
            + &Y.map(|y| format!("{y:?},{}\n", joined(&X.map(|x| value(x, y)))))
                .concat();
        let other = with_coordinates("0")
            .replace("0.5,", "2,")
            .replace("1.0,", "4,");
        let worded = other.replacen("0,", "x,", 1);
        for (text, column, said) in [
            (list, None, "1 nodes of 2 × 2 are missing"),
            (
                &list.replace("1,0,3", "0,0,3\n1,0,3"),
                None,
                "the node of another row",
            ),
            (
                &list.replace("0.3", "0.2"),
                None,
                "row 2 has y = 0.2, which is not a node",
            ),
            (
                &list.replace(",B", ",B,C").replace("1\n", "1,5\n"),
                None,
                "column = \"B\"",
            ),
            ("1,2\n3,4\n", Some("B"), "`column` chooses one of a list"),
            (&turned, None, "of y down and x along"),
            (
                &other,
                None,
                "look like coordinates, and not those of `axes`",
            ),
            (
                &worded,
                None,
                "look like coordinates, and not those of `axes`",
            ),
        ] {
            let error = nodes_of(text, &axes(), column).expect_err(text);
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
