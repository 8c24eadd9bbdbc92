//! Poisson tensors of every family, as a scene writes them and entry by entry.

use leafwise::expression::Function;

use crate::source::Source;
use crate::tree::Tree;

/// Which kind of tensor it is: what methods suit it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// so(3)*.
    Rotations,
    /// Another Lie–Poisson tensor.
    Linear,
    /// {x_i, x_j} = a_ij x_i x_j.
    LogCanonical,
    /// {q, p} = ±1, or constants.
    Constant,
    /// Positions and velocities in a magnetic field.
    Magnetic,
    /// The gradient of a function in space, or any function of the plane.
    General,
}

/// A tensor and its Casimirs.
#[derive(Clone, Debug)]
pub struct Tensor {
    /// Its kind.
    pub family: Family,
    /// The coordinates.
    pub names: Vec<&'static str>,
    /// The scene's `bracket`.
    pub written: String,
    /// Entries (i, j, {x_i, x_j}), each pair once.
    pub entries: Vec<(usize, usize, Tree)>,
    /// Functions C with Π ∇C = 0.
    pub casimirs: Vec<Tree>,
    /// Whether ẋ = {x, H}, not {H, x}.
    pub is_textbook: bool,
    /// A vector potential, of a magnetic field.
    pub potential: Option<String>,
    /// Whether coordinates keep their signs and begin positive.
    pub is_positive: bool,
}

fn x(index: usize) -> Tree {
    Tree::Variable(index)
}

fn product(factors: Vec<Tree>) -> Tree {
    Tree::Product(factors)
}

/// A tensor of any family.
pub fn tensor(source: &mut Source<'_>) -> Tensor {
    let mut tensor = match source.below(11) {
        0 => rotations(),
        1 => rigid_motions(),
        2 => traceless(),
        3 => heisenberg(),
        4 | 5 => log_canonical(source),
        6 => canonical(source),
        7 => return magnetic(source),
        8 => nambu(source),
        9 => constant(source),
        _ => plane(source),
    };
    tensor.is_textbook = source.chance(64);
    // Some by name, where the program has one.
    let name = match tensor.names.as_slice() {
        ["x1", "x2", "x3"] => Some("so3"),
        ["l1", ..] => Some("se3"),
        ["h", "e", "f"] => Some("sl2"),
        _ => None,
    };
    tensor.written = match name {
        Some(name) if source.chance(64) => format!("{{ lie-algebra = \"{name}\" }}"),
        _ if tensor.written.is_empty() => written(&tensor),
        _ => tensor.written,
    };
    tensor
}

fn written(tensor: &Tensor) -> String {
    let entries: Vec<String> = tensor
        .entries
        .iter()
        .map(|(i, j, entry)| {
            let (a, b) = (tensor.names[*i], tensor.names[*j]);
            format!("\"{a},{b}\" = \"{}\"", entry.text(&tensor.names))
        })
        .collect();
    format!("{{ {} }}", entries.join(", "))
}

fn made(
    family: Family,
    names: &[&'static str],
    entries: Vec<(usize, usize, Tree)>,
    casimirs: Vec<Tree>,
) -> Tensor {
    Tensor {
        family,
        names: names.to_vec(),
        written: String::new(),
        entries,
        casimirs,
        is_textbook: false,
        potential: None,
        is_positive: false,
    }
}

fn rotations() -> Tensor {
    let entry = |i: usize| (i, (i + 1) % 3, Tree::Negate(x((i + 2) % 3).into()));
    let casimir = x(0).to(2).plus(x(1).to(2)).plus(x(2).to(2));
    made(
        Family::Rotations,
        &["x1", "x2", "x3"],
        (0..3).map(entry).collect(),
        vec![casimir],
    )
}

fn rigid_motions() -> Tensor {
    let mut entries = Vec::new();
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        entries.push((i, j, Tree::Negate(x(k).into())));
        entries.push((i, 3 + j, Tree::Negate(x(3 + k).into())));
        entries.push((j, 3 + i, x(3 + k)));
    }
    let square = x(3).to(2).plus(x(4).to(2)).plus(x(5).to(2));
    let pitch = (0..3).map(|i| (false, product(vec![x(i), x(3 + i)])));
    made(
        Family::Linear,
        &["l1", "l2", "l3", "p1", "p2", "p3"],
        entries,
        vec![square, Tree::Sum(pitch.collect())],
    )
}

fn traceless() -> Tensor {
    let entries = vec![
        (0, 1, x(1).times(-2.0)),
        (0, 2, x(2).times(2.0)),
        (1, 2, Tree::Negate(x(0).into())),
    ];
    let casimir = x(0).to(2).plus(product(vec![x(1), x(2)]).times(4.0));
    made(Family::Linear, &["h", "e", "f"], entries, vec![casimir])
}

fn heisenberg() -> Tensor {
    let entries = vec![(0, 1, Tree::Negate(x(2).into()))];
    made(Family::Linear, &["q", "p", "z"], entries, vec![x(2)])
}

fn log_canonical(source: &mut Source<'_>) -> Tensor {
    let d = 2 + source.below(3);
    let mut matrix = vec![vec![0.0; d]; d];
    let mut entries = Vec::new();
    for i in 0..d {
        for j in i + 1..d {
            let a = match source.decimal(-2.0, 2.0) {
                0.0 => 1.0,
                a => a,
            };
            matrix[i][j] = a;
            matrix[j][i] = -a;
            entries.push((i, j, product(vec![Tree::Number(a), x(i), x(j)])));
        }
    }
    let ln = |i: usize, c: f64| (false, x(i).under(Function::Ln).times(c));
    // The kernel of a skew 3 × 3 matrix.
    let casimirs = match d {
        3 => vec![Tree::Sum(vec![
            ln(0, matrix[1][2]),
            ln(1, -matrix[0][2]),
            ln(2, matrix[0][1]),
        ])],
        _ => Vec::new(),
    };
    let names = &["x1", "x2", "y3", "y4"][..d];
    let mut tensor = made(Family::LogCanonical, names, entries, casimirs);
    tensor.is_positive = true;
    if source.chance(128) {
        tensor.written = format!("{{ log-canonical = {matrix:?} }}");
    }
    tensor
}

fn canonical(source: &mut Source<'_>) -> Tensor {
    let one = || Tree::Number(-1.0);
    match source.below(2) {
        0 => made(Family::Constant, &["q", "p"], vec![(0, 1, one())], vec![]),
        _ => {
            let entries = vec![(0, 2, one()), (1, 3, one())];
            made(Family::Constant, &["q1", "q2", "p1", "p2"], entries, vec![])
        }
    }
}

fn constant(source: &mut Source<'_>) -> Tensor {
    let mut number = || match source.decimal(-2.0, 2.0) {
        0.0 => 1.0,
        c => c,
    };
    let [a, b, c] = [number(), number(), number()];
    let entries = [(0, 1, c), (1, 2, a), (2, 0, b)].map(|(i, j, v)| (i, j, Tree::Number(v)));
    let casimir = x(0).times(a).plus(x(1).times(b)).plus(x(2).times(c));
    made(
        Family::Constant,
        &["u", "v", "w"],
        entries.into(),
        vec![casimir],
    )
}

/// x′ = v, v′ = v × B − ∇V, whatever the convention: {x, v} = 1 and {v_i, v_j} = ε_ijk B_k for ẋ = {x, H}.
fn magnetic(source: &mut Source<'_>) -> Tensor {
    let (a, b) = (source.decimal(-2.0, 2.0), source.decimal(-1.0, 1.0));
    let one = || Tree::Number(1.0);
    let is_plane = source.chance(128);
    let (names, field, axis): (&[&str], Tree, usize) = match is_plane {
        true => (&["x", "y", "vx", "vy"], x(0).times(b).shifted(a), 2),
        false => (
            &["x", "y", "z", "vx", "vy", "vz"],
            x(0).times(b).plus(x(1).to(2)).shifted(a),
            3,
        ),
    };
    let mut entries: Vec<_> = (0..axis).map(|i| (i, axis + i, one())).collect();
    entries.push((axis, axis + 1, field.clone()));
    let text = field.text(names);
    let written = match is_plane {
        true => format!("{{ magnetic-field = [\"{text}\"] }}"),
        false => format!("{{ magnetic-field = [\"0\", \"0\", \"{text}\"] }}"),
    };
    let mut tensor = made(Family::Magnetic, &[], entries, vec![]);
    tensor.names = match is_plane {
        true => vec!["x", "y", "vx", "vy"],
        false => vec!["x", "y", "z", "vx", "vy", "vz"],
    };
    let along_y = format!("({a:?})*x + ({b:?})*x^2/2");
    tensor.potential = Some(match is_plane {
        true => format!("0; {along_y}"),
        false => format!("-y^3/3; {along_y}; 0"),
    });
    tensor.written = written;
    tensor.is_textbook = true;
    tensor
}

/// {x, y} = ∂C/∂z and cyclic.
fn nambu(source: &mut Source<'_>) -> Tensor {
    let mut number = || source.decimal(-2.0, 2.0);
    let [a, b, c, m, n] = [number(), number(), number(), number(), number()];
    let casimir = x(0)
        .to(2)
        .times(a)
        .plus(x(1).to(2).times(b))
        .plus(x(2).to(2).times(c))
        .plus(product(vec![x(0), x(1), x(2)]).times(m))
        .plus(x(2).to(3).times(n));
    let slope = |i: usize, twice: f64| {
        let others = product(vec![x((i + 1) % 3), x((i + 2) % 3)]);
        x(i).times(2.0 * twice).plus(others.times(m))
    };
    let along_z = slope(2, c).plus(x(2).to(2).times(3.0 * n));
    let entries = vec![(0, 1, along_z), (1, 2, slope(0, a)), (2, 0, slope(1, b))];
    made(Family::General, &["x", "y", "z"], entries, vec![casimir])
}

fn plane(source: &mut Source<'_>) -> Tensor {
    let (a, b) = (source.decimal(0.2, 3.0), source.decimal(-1.0, 1.0));
    let entry = match source.below(4) {
        0 => x(0).times(b).shifted(a),
        1 => x(0).to(2).plus(x(1).to(2)).shifted(a),
        2 => x(0).to(2).shifted(a).under(Function::Sqrt),
        _ => x(0).to(2).plus(x(1).to(2)).shifted(a).inverse(),
    };
    made(Family::General, &["x", "y"], vec![(0, 1, entry)], vec![])
}
