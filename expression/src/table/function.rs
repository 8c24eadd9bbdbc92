//! The spline of a table, and its derivatives at points.

use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::{Mutex, PoisonError};

use super::axis::{MOST_AXES, TableAxis};
use super::check::check;
use super::error::TableError;
use super::interpolation::{Cells, Interpolation, weights};
use super::part::Part;

/// A function that interpolates a table of numbers.
///
/// Copies are one table. A program keeps each table until it ends, and tables of the same name, axes and numbers once.
///
/// ```
/// use leafwise_expression::table::{TableFunction, TableAxis};
///
/// let axis = TableAxis { name: "x".to_owned(), first: 0.0, last: 3.0, nodes: 7, is_periodic: false };
/// let cubes: Vec<f64> = (0..7).map(|i| f64::from(i * i * i) / 8.0).collect();
/// let table = TableFunction::new("cube", vec![axis], 3, &cubes).expect("a table");
/// let slope = table.value().derivative(0).expect("a slope");
/// assert!((table.value().at(&[1.3]) - 2.197).abs() < 1e-14);
/// assert!((slope.at(&[1.3]) - 5.07).abs() < 1e-13);
/// assert!(table.value().at(&[3.5]).is_nan());
/// ```
#[derive(Clone, Copy)]
pub struct TableFunction(&'static Spline);

struct Spline {
    /// The place among all tables of the program.
    number: u32,
    name: String,
    /// A name that no other table has.
    unique: String,
    degree: u8,
    axes: Vec<TableAxis>,
    cells: Vec<Cells>,
    /// The places from one coefficient to the next along each axis.
    strides: Vec<usize>,
    /// The last axis fastest.
    coefficients: Vec<f64>,
}

/// Every table of the program.
static TABLES: Mutex<Vec<&'static Spline>> = Mutex::new(Vec::new());

impl TableFunction {
    /// The spline of this degree with these numbers at the nodes, the last axis fastest.
    ///
    /// # Errors
    /// [`TableError`] for axes, degrees and numbers that make no spline.
    pub fn new(
        name: &str,
        axes: Vec<TableAxis>,
        degree: u8,
        numbers: &[f64],
    ) -> Result<Self, TableError> {
        check(&axes, degree, numbers)?;
        let k = usize::from(degree);
        let mut coefficients = numbers.to_vec();
        let mut shape: Vec<usize> = axes.iter().map(|axis| axis.nodes).collect();
        for (at, axis) in axes.iter().enumerate() {
            let interpolation = Interpolation::new(axis.nodes, k, axis.is_periodic);
            coefficients = along(&coefficients, &mut shape, at, |line| {
                interpolation.coefficients(line, k)
            });
        }
        let cells = axes
            .iter()
            .map(|axis| Cells::of(axis.nodes, k, axis.is_periodic));
        let cells = cells.collect();
        let stride = |at: usize| shape[at + 1..].iter().product();
        let strides = (0..shape.len()).map(stride).collect();
        let mut tables = TABLES.lock().unwrap_or_else(PoisonError::into_inner);
        let is_it = |known: &&&'static Spline| {
            known.name == name
                && known.degree == degree
                && known.axes == axes
                && known.coefficients == coefficients
        };
        if let Some(known) = tables.iter().find(is_it) {
            return Ok(Self(known));
        }
        let number = u32::try_from(tables.len()).map_err(|_| TableError::TooMany)?;
        let spline = Box::leak(Box::new(Spline {
            number,
            name: name.to_owned(),
            unique: format!("{name}#{number}"),
            degree,
            axes,
            cells,
            strides,
            coefficients,
        }));
        tables.push(spline);
        Ok(Self(spline))
    }

    /// The name that formulas call it by.
    pub fn name(self) -> &'static str {
        &self.0.name
    }

    /// A name that no other table of the program has.
    pub(crate) fn unique_name(self) -> &'static str {
        &self.0.unique
    }

    /// Its variables.
    pub fn axes(self) -> &'static [TableAxis] {
        &self.0.axes
    }

    /// The degree of its polynomials in each variable.
    pub fn degree(self) -> u8 {
        self.0.degree
    }

    /// The coefficients c, the last axis fastest: as many along each axis as it has cells, and the degree more.
    pub fn coefficients(self) -> &'static [f64] {
        &self.0.coefficients
    }

    /// The function itself, of which derivatives are taken.
    pub fn value(self) -> Lookup {
        Lookup {
            table: self,
            orders: [0; MOST_AXES],
        }
    }

    /// The length of a cell.
    pub(crate) fn spacing(self, axis: usize) -> f64 {
        let TableAxis {
            first,
            last,
            nodes,
            is_periodic,
            ..
        } = &self.0.axes[axis];
        let cells = if *is_periodic { *nodes } else { nodes - 1 };
        (last - first) / cells as f64
    }

    /// The cell of x along an axis and the place in it; `None` where there is none.
    fn cell(self, axis: usize, x: f64) -> Option<(usize, f64)> {
        let TableAxis {
            first,
            last,
            is_periodic,
            ..
        } = self.0.axes[axis];
        let Cells { count, shift } = self.0.cells[axis];
        let scaled = (x - first) / self.spacing(axis) + shift;
        let below = libm::floor(scaled);
        if is_periodic {
            // Beyond 2⁵² no place in a cell is left.
            if scaled.is_nan() || scaled.abs() >= 4_503_599_627_370_496.0 {
                return None;
            }
            let count = count as f64;
            let cell = below - count * libm::floor(below / count);
            return Some((cell as usize, scaled - below));
        }
        if !(x >= first && x <= last) {
            return None;
        }
        let cell = (below as usize).min(count - 1);
        Some((cell, scaled - cell as f64))
    }

    /// A part of a value as a function of one number, NaN outside; see [`Part`].
    pub(crate) fn part(self, code: u32, x: f64) -> f64 {
        match Part::of_code(code) {
            Part::Fraction(axis) => self.cell(axis, x).map_or(f64::NAN, |(_, u)| u),
            Part::Place(axis) => match self.cell(axis, x) {
                Some((cell, _)) => (cell * self.0.strides[axis]) as f64,
                None => f64::NAN,
            },
            Part::Coefficient(offset) => {
                // NaN is 0 as a whole number.
                let value = self.0.coefficients.get(x as usize + offset);
                if x.is_nan() {
                    f64::NAN
                } else {
                    value.copied().unwrap_or(f64::NAN)
                }
            }
        }
    }

    /// The same of each number.
    pub(crate) fn part_lanes(self, code: u32, values: &mut [f64]) {
        if let Part::Coefficient(offset) = Part::of_code(code) {
            let coefficients = self.0.coefficients.get(offset..).unwrap_or(&[]);
            for x in values {
                let value = coefficients.get(*x as usize).copied();
                *x = if x.is_nan() {
                    f64::NAN
                } else {
                    value.unwrap_or(f64::NAN)
                };
            }
            return;
        }
        for x in values {
            *x = self.part(code, *x);
        }
    }

    /// The places from a coefficient to the next along an axis.
    pub(crate) fn stride(self, axis: usize) -> usize {
        self.0.strides[axis]
    }

    /// The first argument that has no cell, with its axis.
    pub fn outside(self, arguments: &[f64]) -> Option<Outside> {
        let mut all = arguments.iter().enumerate();
        all.find(|(axis, x)| self.cell(*axis, **x).is_none())
            .map(|(axis, value)| Outside {
                table: self,
                axis,
                value: *value,
            })
    }
}

/// A point outside a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outside {
    /// The table.
    pub table: TableFunction,
    /// The place of the axis along which it is outside.
    pub axis: usize,
    /// The coordinate there.
    pub value: f64,
}

impl fmt::Display for Outside {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TableAxis {
            name, first, last, ..
        } = &self.table.axes()[self.axis];
        let table = self.table.name();
        let value = self.value;
        write!(
            formatter,
            "{name} = {value:?} lies outside the table `{table}`, which has values for {name} from {first:?} to {last:?}"
        )
    }
}

/// Replaces each line of numbers along one axis by another one.
fn along(
    numbers: &[f64],
    shape: &mut [usize],
    axis: usize,
    of: impl Fn(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let inner: usize = shape[axis + 1..].iter().product();
    let outer: usize = shape[..axis].iter().product();
    let length = shape[axis];
    let mut lines = Vec::with_capacity(outer * inner);
    for before in 0..outer {
        for after in 0..inner {
            let at = |i: usize| numbers[(before * length + i) * inner + after];
            lines.push(of(&(0..length).map(at).collect::<Vec<_>>()));
        }
    }
    let length = lines.first().map_or(0, Vec::len);
    shape[axis] = length;
    let mut new = Vec::with_capacity(outer * inner * length);
    for before in 0..outer {
        for i in 0..length {
            for after in 0..inner {
                new.push(lines[before * inner + after][i]);
            }
        }
    }
    new
}

impl PartialEq for TableFunction {
    fn eq(&self, other: &Self) -> bool {
        self.0.number == other.0.number
    }
}

impl Eq for TableFunction {}

impl Hash for TableFunction {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.number.hash(state);
    }
}

impl fmt::Debug for TableFunction {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0.unique)
    }
}

/// A table or one of its derivatives.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Lookup {
    table: TableFunction,
    orders: [u8; MOST_AXES],
}

impl Lookup {
    /// The derivative of these orders along the axes; `None` where that is 0 everywhere.
    pub fn of_orders(table: TableFunction, orders: &[u8]) -> Option<Self> {
        let mut own = [0; MOST_AXES];
        own[..orders.len()].copy_from_slice(orders);
        let is_zero = orders.iter().any(|order| *order > table.degree());
        (!is_zero).then_some(Self { table, orders: own })
    }

    /// The table.
    pub fn table(self) -> TableFunction {
        self.table
    }

    /// How often it is differentiated along each axis.
    pub fn orders(&self) -> &[u8] {
        &self.orders[..self.table.axes().len()]
    }

    /// The derivative along an axis; `None` where that is 0 everywhere.
    pub fn derivative(self, axis: usize) -> Option<Self> {
        let mut orders = self.orders;
        orders[axis] += 1;
        let is_zero = orders[axis] > self.table.degree();
        (!is_zero).then_some(Self { orders, ..self })
    }

    /// The function as it is written: derivatives have their orders behind the arguments.
    pub fn called(self, arguments: impl Iterator<Item = String>) -> String {
        let mut parts: Vec<String> = arguments.collect();
        if self.orders.iter().any(|order| *order > 0) {
            parts.extend(self.orders().iter().map(u8::to_string));
        }
        format!("{}({})", self.table.name(), parts.join(", "))
    }

    /// The value at a point, NaN outside the table.
    ///
    /// # Panics
    /// When there are fewer numbers than axes.
    pub fn at(self, point: &[f64]) -> f64 {
        self.sum(point, |value| value)
    }

    /// Σ |c_{i+j} Π b_{j_l}|: rounding moves the value by some 2⁻⁵² of it.
    pub(crate) fn magnitude(self, point: &[f64]) -> f64 {
        self.sum(point, f64::abs)
    }

    fn sum(self, point: &[f64], size: impl Fn(f64) -> f64) -> f64 {
        let spline = self.table.0;
        // The offsets and products of weights that were formed so far.
        let mut products = vec![(0, 1.0)];
        for (axis, order) in self.orders().iter().enumerate() {
            let Some((cell, u)) = self.table.cell(axis, point[axis]) else {
                return f64::NAN;
            };
            let weights = differences(spline.degree, *order, u);
            let slope = (0..*order).fold(1.0, |slope, _| slope / self.table.spacing(axis));
            let next = products.iter().flat_map(|(at, product)| {
                let weights = weights.iter().enumerate();
                weights.map(move |(j, weight)| {
                    (
                        at + (cell + j) * spline.strides[axis],
                        product * weight * slope,
                    )
                })
            });
            products = next.collect();
        }
        let terms = products.iter();
        terms
            .map(|(at, weight)| size(weight * spline.coefficients[*at]))
            .sum()
    }
}

/// The derivatives in u of this order of the k + 1 B-splines of degree k: differences of those of degree k − m.
fn differences(degree: u8, order: u8, u: f64) -> Vec<f64> {
    let mut row = weights(usize::from(degree - order), u);
    for _ in 0..order {
        let of = |j: Option<usize>| j.and_then(|j| row.get(j)).copied().unwrap_or(0.0);
        row = (0..=row.len())
            .map(|j| of(j.checked_sub(1)) - of(Some(j)))
            .collect();
    }
    row
}

impl fmt::Debug for Lookup {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:?}{:?}", self.table, self.orders())
    }
}
