//! The field of an equilibrium between its nodes.

use leafwise_expression::TableFunction;
use leafwise_expression::table::TableAxis;

use crate::error::EquilibriumError;
use crate::geqdsk::Geqdsk;

/// B = ∇ψ × ∇φ + F ∇φ by splines.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    file: Geqdsk,
    degree: u8,
    /// ψ(R, Z).
    psi: TableFunction,
    /// ∫ (F − F_edge)/R dR from the first node on; `None` where F is constant.
    stream: Option<TableFunction>,
    /// F by the normalized flux; `None` where it is constant.
    f: Option<TableFunction>,
    axis: [f64; 2],
}

/// The largest normalized flux of the spline at the axis, which is 0 but for the file's interpolation.
const LARGEST_OFF: f64 = 0.02;

/// Places a cell at which tables are compared with what they are of.
const PER_CELL: usize = 7;

/// The part of F's variation by which its table is off where it is smeared, and the part of F below which nobody sees it.
const SMEARED: f64 = 0.01;
const SEEN: f64 = 1e-6;

/// A place where F is smeared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smeared {
    /// The normalized flux where the table is off by most.
    pub surface: f64,
    /// By which part of F's variation.
    pub part: f64,
}

/// The last digit of a file's numbers, of ten.
const DIGITS: f64 = 1e-9;

/// Steps of Newton's method to the magnetic axis.
const STEPS: usize = 50;

/// Nodes and weights of Gauss's rule on [−1, 1]: exact to degree 9.
const GAUSS: [[f64; 2]; 5] = [
    [-0.906_179_845_938_664, 0.236_926_885_056_189_08],
    [-0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
    [0.0, 0.568_888_888_888_888_9],
    [0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
    [0.906_179_845_938_664, 0.236_926_885_056_189_08],
];

impl Equilibrium {
    /// The splines of this degree of a file.
    ///
    /// # Errors
    /// [`EquilibriumError`] for a grid without a spline and a flux without an axis within it.
    pub fn new(mut file: Geqdsk, degree: u8) -> Result<Self, EquilibriumError> {
        let psi = spline(&file, "psi", degree, &file.psi)?;
        let axis = axis(&file, psi)?;
        let at_axis = psi.value().at(&axis);
        let off = normalized(&file, at_axis);
        if off.is_nan() || off.abs() > LARGEST_OFF {
            return Err(EquilibriumError::Odd(format!(
                "psi is {at_axis} on the axis, and the file gives {}: these disagree relative to the flux at its edge, {}",
                file.psi_range[0], file.psi_range[1]
            )));
        }
        // The extremum lies between nodes, and the file's number is one of another interpolation.
        if off.abs() > DIGITS {
            file.psi_range[0] = at_axis;
        }
        let table = |name, numbers: &[f64]| spline(&file, name, degree, numbers);
        let edge = file.f[file.f.len() - 1];
        let (stream, f) = match file.f.iter().all(|f| *f == edge) {
            true => (None, None),
            false => {
                let f = along_flux(&file, degree)?;
                let slope = table("(F - F_edge)/R", &excess(&file, f))?;
                (Some(table("G", &primitive(&file, slope))?), Some(f))
            }
        };
        Ok(Self {
            file,
            degree,
            psi,
            stream,
            f,
            axis,
        })
    }

    /// The file.
    pub fn file(&self) -> &Geqdsk {
        &self.file
    }

    /// The degree of the splines.
    pub fn degree(&self) -> u8 {
        self.degree
    }

    /// R and Z of the magnetic axis, where the spline of ψ has its extremum.
    pub fn axis(&self) -> [f64; 2] {
        self.axis
    }

    /// F at the edge, in T·m.
    pub fn edge_f(&self) -> f64 {
        self.file.f[self.file.f.len() - 1]
    }

    /// ∫ (F − F_edge)/R dR at the nodes, those along Z fastest, in T·m; `None` where F is constant.
    pub fn stream_numbers(&self) -> Option<Vec<f64>> {
        let stream = self.stream?.value();
        Some(points(&self.file).map(|point| stream.at(&point)).collect())
    }

    /// s = (ψ − ψ_axis)/(ψ_edge − ψ_axis): 0 on the axis, 1 at the edge; NaN outside the grid.
    pub fn flux(&self, [r, z]: [f64; 2]) -> f64 {
        normalized(&self.file, self.psi.value().at(&[r, z]))
    }

    /// B_R, B_Z and B_φ, in T; NaN outside the grid.
    pub fn field(&self, [r, z]: [f64; 2]) -> [f64; 3] {
        let [along_r, along_z] = self.slopes([r, z]);
        let stream = self.stream.map_or(0.0, |stream| slope(stream, 0, [r, z]));
        [-along_z / r, along_r / r, self.edge_f() / r + stream]
    }

    /// Where F changes within so few cells of the grid that its table is smeared; `None` where it follows F.
    ///
    /// F of the table and F of the flux are compared on the axis' height, between the nodes.
    pub fn smeared(&self) -> Option<Smeared> {
        let f = self.f?;
        let bounds = |pick: fn(f64, f64) -> f64| self.file.f.iter().copied().reduce(pick);
        let range = bounds(f64::max)? - bounds(f64::min)?;
        let [first, last] = self.file.r;
        let [axis, z] = self.axis;
        let count = PER_CELL * (self.file.nodes[0] - 1);
        let mut worst = Smeared {
            surface: 0.0,
            part: 0.0,
        };
        for at in 0..=count {
            let r = (first + (last - first) * at as f64 / count as f64).min(last);
            let surface = self.flux([r, z]);
            // Beyond the edge, on either side, F is no measure.
            if !(0.0..=1.0).contains(&surface) || (r - axis).abs() > last - first {
                continue;
            }
            let part = (self.field([r, z])[2] * r - f.value().at(&[surface])).abs() / range;
            if part > worst.part {
                worst = Smeared { surface, part };
            }
        }
        let is_seen = worst.part * range > SEEN * self.edge_f().abs();
        (worst.part > SMEARED && is_seen).then_some(worst)
    }

    /// |B|, in T.
    pub fn strength(&self, point: [f64; 2]) -> f64 {
        let squares = self.field(point).map(|b| b * b);
        libm::sqrt(squares.iter().sum())
    }

    /// ∂ψ/∂R and ∂ψ/∂Z.
    pub(crate) fn slopes(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| slope(self.psi, axis, point))
    }

    /// The safety factor on the axis: F/(R √det ∂²ψ), with the sign of F.
    pub fn axis_safety_factor(&self) -> f64 {
        let [[rr, rz], [_, zz]] = curvature(self.psi, self.axis);
        let [r, _] = self.axis;
        let f = self.field(self.axis)[2] * r;
        f / (r * libm::sqrt(rr * zz - rz * rz))
    }
}

/// The nodes of the grid, those along Z fastest.
fn points(file: &Geqdsk) -> impl Iterator<Item = [f64; 2]> {
    let [along_r, along_z] = file.nodes;
    let at = |[first, last]: [f64; 2], count: usize, i: usize| {
        let part = i as f64 / (count - 1) as f64;
        // The last node exactly: beyond it there is no table.
        if i + 1 == count {
            last
        } else {
            first + (last - first) * part
        }
    };
    let (r, z) = (file.r, file.z);
    (0..along_r)
        .flat_map(move |i| (0..along_z).map(move |j| [at(r, along_r, i), at(z, along_z, j)]))
}

fn spline(
    file: &Geqdsk,
    name: &'static str,
    degree: u8,
    numbers: &[f64],
) -> Result<TableFunction, EquilibriumError> {
    let axis = |name: &str, [first, last]: [f64; 2], nodes| TableAxis {
        name: name.to_owned(),
        first,
        last,
        nodes,
        is_periodic: false,
    };
    let axes = vec![
        axis("R", file.r, file.nodes[0]),
        axis("Z", file.z, file.nodes[1]),
    ];
    TableFunction::new(name, axes, degree, numbers)
        .map_err(|error| EquilibriumError::Table { name, error })
}

fn normalized(file: &Geqdsk, psi: f64) -> f64 {
    let [axis, edge] = file.psi_range;
    (psi - axis) / (edge - axis)
}

/// (F − F_edge)/R at the nodes.
///
/// Beyond the edge F goes on as a smooth function. With the vacuum's constant, the kink at the edge would ring in the spline. It
/// would move the field within by 1e-6 of it on 65 × 65 nodes.
fn excess(file: &Geqdsk, f: TableFunction) -> Vec<f64> {
    let edge = file.f[file.f.len() - 1];
    let at = |([r, _], psi): ([f64; 2], &f64)| (continued(f, normalized(file, *psi)) - edge) / r;
    points(file).zip(&file.psi).map(at).collect()
}

/// F by the normalized flux.
fn along_flux(file: &Geqdsk, degree: u8) -> Result<TableFunction, EquilibriumError> {
    let name = "F";
    let axis = TableAxis {
        name: "s".to_owned(),
        first: 0.0,
        last: 1.0,
        nodes: file.f.len(),
        is_periodic: false,
    };
    TableFunction::new(name, vec![axis], degree, &file.f)
        .map_err(|error| EquilibriumError::Table { name, error })
}

/// The normalized flux beyond an end of [0, 1] from where on a continued function is nearly constant.
const CONTINUED: f64 = 0.5;

/// A spline on [0, 1], continued by its value, slope and curvature at the end.
///
/// The distance that these stand for stays below [`CONTINUED`], and has the true distance's first four derivatives at the end.
fn continued(f: TableFunction, s: f64) -> f64 {
    let end = s.clamp(0.0, 1.0);
    let distance = s - end;
    let part = distance / CONTINUED;
    let distance = distance / libm::sqrt(libm::sqrt(1.0 + part * part * part * part));
    let slope = f.value().derivative(0);
    let curvature = slope.and_then(|slope| slope.derivative(0));
    let [slope, curvature] = [slope, curvature].map(|of| of.map_or(0.0, |of| of.at(&[end])));
    f.value().at(&[end]) + distance * (slope + distance * curvature / 2.0)
}

/// The integral of a spline along R from the first node to each: its pieces are polynomials, and Gauss's rule is exact.
fn primitive(file: &Geqdsk, slope: TableFunction) -> Vec<f64> {
    let nodes: Vec<[f64; 2]> = points(file).collect();
    let [along_r, along_z] = file.nodes;
    let mut numbers = vec![0.0; nodes.len()];
    for i in 1..along_r {
        for j in 0..along_z {
            let [[left, z], [right, _]] = [nodes[(i - 1) * along_z + j], nodes[i * along_z + j]];
            // Knots of even degrees stand half-way between nodes.
            let quarter = (right - left) / 4.0;
            let mut sum = 0.0;
            for middle in [left + quarter, right - quarter] {
                for [place, weight] in GAUSS {
                    sum += weight * quarter * slope.value().at(&[middle + quarter * place, z]);
                }
            }
            numbers[i * along_z + j] = numbers[(i - 1) * along_z + j] + sum;
        }
    }
    numbers
}

fn slope(table: TableFunction, axis: usize, point: [f64; 2]) -> f64 {
    let slope = table.value().derivative(axis);
    slope.map_or(0.0, |slope| slope.at(&point))
}

fn curvature(table: TableFunction, point: [f64; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|first| {
        [0, 1].map(|second| {
            let slope = table.value().derivative(first);
            let curvature = slope.and_then(|slope| slope.derivative(second));
            curvature.map_or(0.0, |curvature| curvature.at(&point))
        })
    })
}

/// The extremum of ψ next to the axis that the file gives.
fn axis(file: &Geqdsk, psi: TableFunction) -> Result<[f64; 2], EquilibriumError> {
    let told = file.axis;
    let away = |point: [f64; 2]| {
        let cell = |[first, last]: [f64; 2], count: usize| (last - first) / (count - 1) as f64;
        let [dr, dz] = [cell(file.r, file.nodes[0]), cell(file.z, file.nodes[1])];
        ((point[0] - told[0]) / dr)
            .abs()
            .max(((point[1] - told[1]) / dz).abs())
    };
    let mut point = told;
    for _ in 0..STEPS {
        let [gr, gz] = [0, 1].map(|axis| slope(psi, axis, point));
        let [[rr, rz], [_, zz]] = curvature(psi, point);
        let determinant = rr * zz - rz * rz;
        let step = [
            (zz * gr - rz * gz) / determinant,
            (rr * gz - rz * gr) / determinant,
        ];
        // Adding 0 leaves no negative zero.
        let next = [point[0] - step[0] + 0.0, point[1] - step[1] + 0.0];
        let is_extremum = determinant > 0.0;
        if !is_extremum || away(next).is_nan() || away(next) > 3.0 {
            break;
        }
        let is_still = step[0].abs() + step[1].abs() <= 1e-14 * (file.r[1] - file.r[0]);
        point = next;
        if is_still {
            return Ok(point);
        }
    }
    Err(EquilibriumError::Odd(format!(
        "the flux has no extremum within three cells of the axis in the file, R = {}, Z = {}",
        told[0], told[1]
    )))
}
