//! Random small scenes: a tensor of every family, a Hamiltonian, a state, a step and a method.

use std::collections::BTreeMap;

use leafwise::expression::Function;

use crate::method::method;
use crate::source::Source;
use crate::tensor::{Family, Tensor, tensor};
use crate::tree::Tree;

/// A scene with what it means, apart from the program's own reading.
#[derive(Clone, Debug)]
pub struct RandomScene {
    /// The scene's text.
    pub text: String,
    /// {x_i, x_j}, and whether the motion is ẋ = {x, H} instead of {H, x}.
    pub tensor: Tensor,
    /// H.
    pub hamiltonian: Tree,
    /// x_0.
    pub initial: Vec<f64>,
    /// εh.
    pub time_step: f64,
    /// The tolerance of its stepper, 0 where it has none.
    pub tolerance: f64,
    /// Units of the coordinates: those of the text are these times the coordinates here, as its time is `second` times
    /// the time here. Powers of two.
    pub units: Vec<f64>,
    /// The unit of the text's time.
    pub second: f64,
}

/// How many steps a scene takes.
pub const STEPS: usize = 4;

/// The product of step and rate ẋ/x of a scene: from tame to extreme.
const TAME: f64 = 1e-3;
const EXTREME: f64 = 8.0;

impl RandomScene {
    /// A scene from bytes.
    pub fn drawn(source: &mut Source<'_>) -> Self {
        let tensor = tensor(source);
        let initial = initial(source, &tensor);
        let hamiltonian = hamiltonian(source, &tensor);
        let mut scene = Self {
            text: String::new(),
            tensor,
            hamiltonian,
            initial,
            time_step: 0.0,
            tolerance: 0.0,
            units: Vec::new(),
            second: 1.0,
        };
        scene.units = vec![1.0; scene.initial.len()];
        let tame = libm::log(EXTREME / TAME);
        let relative = EXTREME * libm::exp(-tame * source.between(0.0, 1.0));
        let step = relative / scene.rate();
        let step = if step.is_finite() { step } else { 0.1 };
        scene.time_step = format!("{step:.2e}").parse().unwrap_or(0.1);
        let method = method(source, &scene.tensor);
        scene.tolerance = method.tolerance;
        // A projection is orthogonal in the coordinates as they are written.
        if !method.text.contains("projection") && source.chance(64) {
            scene.draw_units(source);
        }
        scene.text = scene.written(&method.text);
        scene
    }

    /// Other units of coordinates and time in the text; that of the energy is such that the tensor keeps its form.
    fn draw_units(&mut self, source: &mut Source<'_>) {
        let mut unit = || libm::exp2((source.below(121) as f64) - 60.0);
        self.second = unit();
        match self.tensor.family {
            // Structure constants stay in units of the energy times the time.
            Family::Rotations | Family::Linear => {
                let unit = unit();
                self.units.fill(unit);
            }
            // Velocities are changes of positions.
            Family::Magnetic => self.second = 1.0,
            // What is of one letter is of one kind, by which advice judges what hardly moves.
            _ => {
                let mut kinds: BTreeMap<Option<char>, f64> = BTreeMap::new();
                for (own, name) in self.units.iter_mut().zip(&self.tensor.names) {
                    *own = *(kinds.entry(name.chars().next())).or_insert_with(&mut unit);
                }
            }
        }
    }

    fn written(&self, method: &str) -> String {
        let tensor = &self.tensor;
        let names: Vec<String> = tensor
            .names
            .iter()
            .map(|name| format!("{name:?}"))
            .collect();
        let convention = if tensor.is_textbook { "{x,H}" } else { "{H,x}" };
        // Coordinates in the units of the text, by those that formulas are of.
        let power = |unit: f64| format!("2^({})", libm::log2(unit));
        let own: Vec<String> = (tensor.names.iter().zip(&self.units))
            .map(|(name, unit)| match *unit {
                1.0 => (*name).to_owned(),
                unit => format!("({name}*{})", power(1.0 / unit)),
            })
            .collect();
        let own: Vec<&str> = own.iter().map(String::as_str).collect();
        let casimirs: Vec<String> = tensor
            .casimirs
            .iter()
            .enumerate()
            .map(|(at, casimir)| format!("C{at} = \"{}\"", casimir.text(&own)))
            .collect();
        let is_of_structure = matches!(tensor.family, Family::Rotations | Family::Linear);
        let action = if is_of_structure { self.units[0] } else { 1.0 };
        let energy = action / self.second;
        let hamiltonian = self.hamiltonian.text(&own);
        let hamiltonian = match energy {
            1.0 => hamiltonian,
            energy => format!("{}*({hamiltonian})", power(energy)),
        };
        let has_entries = matches!(tensor.family, Family::Constant | Family::General);
        let bracket = match has_entries && self.units.iter().any(|unit| *unit != 1.0) {
            false => tensor.written.clone(),
            true => {
                let entries = tensor.entries.iter().map(|(i, j, entry)| {
                    let (a, b) = (tensor.names[*i], tensor.names[*j]);
                    let factor = power(self.units[*i] * self.units[*j]);
                    format!("\"{a},{b}\" = \"{factor}*({})\"", entry.text(&own))
                });
                format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
            }
        };
        let initial = self.initial.iter().zip(&self.units);
        let initial: Vec<f64> = initial.map(|(x, unit)| x * unit).collect();
        format!(
            "[system]\nvariables = [{}]\nconvention = \"{convention}\"\nbracket = {bracket}\nhamiltonian = \"{hamiltonian}\"\n\
             casimirs = {{ {} }}\n[method]\n{method}time-step = {:?}\n[run]\ninitial = {initial:?}\nsteps = {STEPS}\n",
            names.join(", "),
            casimirs.join(", "),
            self.time_step * self.second,
        )
    }

    /// ẋ by dual numbers.
    pub fn field(&self, x: &[f64]) -> Vec<f64> {
        let d = x.len();
        let gradient = self.hamiltonian.dual(x);
        let sign = if self.tensor.is_textbook { 1.0 } else { -1.0 };
        let mut field = vec![0.0; d];
        for (i, j, entry) in &self.tensor.entries {
            let entry = sign * entry.value(x);
            field[*i] += entry * gradient.slope(*j);
            field[*j] -= entry * gradient.slope(*i);
        }
        field
    }

    /// max |ẋ_i| over max |x_i| at the initial state.
    fn rate(&self) -> f64 {
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let field = self.field(&self.initial);
        if self.tensor.is_positive {
            let relative = field.iter().zip(&self.initial).map(|(f, x)| f / x);
            return largest(&relative.collect::<Vec<_>>());
        }
        largest(&field) / largest(&self.initial)
    }
}

fn initial(source: &mut Source<'_>, tensor: &Tensor) -> Vec<f64> {
    let (low, high) = if tensor.is_positive {
        (0.05, 4.0)
    } else {
        (-2.0, 2.0)
    };
    let scale = match source.below(12) {
        0 => source.pick(&[1e-3, 10.0, 100.0]),
        _ => 1.0,
    };
    let away = |x: f64| if x == 0.0 { 0.25 } else { x };
    (0..tensor.names.len())
        .map(|_| scale * away(source.decimal(low, high)))
        .map(|x| format!("{x:.6}").parse().unwrap_or(x))
        .collect()
}

/// A Hamiltonian: what is usual for the tensor, and often terms that algebra finds hard.
fn hamiltonian(source: &mut Source<'_>, tensor: &Tensor) -> Tree {
    let d = tensor.names.len();
    let coefficient = |source: &mut Source<'_>| match source.decimal(-2.0, 2.0) {
        0.0 => 0.5,
        c => c,
    };
    let mut h = Tree::Number(0.0);
    if tensor.is_positive {
        for at in 0..d {
            let (a, b) = (source.decimal(0.2, 2.0), source.decimal(0.2, 2.0));
            h = h.plus(Tree::Variable(at).times(a));
            h = h.plus(Tree::Variable(at).under(Function::Ln).times(-b));
        }
    } else {
        for at in 0..d {
            let c = source.decimal(0.2, 2.0);
            h = h.plus(Tree::Variable(at).to(2).times(c));
        }
    }
    if let Tree::Sum(terms) = &mut h {
        terms.remove(0);
    }
    for _ in 0..source.below(4) {
        let c = coefficient(source);
        h = h.plus(hard_term(source, d).times(c));
    }
    h
}

/// Quotients, roots, shifted powers, products and functions; pulses and switches that lie ahead.
fn hard_term(source: &mut Source<'_>, d: usize) -> Tree {
    let x = Tree::Variable(source.below(d));
    let y = Tree::Variable(source.below(d));
    let shift = match source.below(8) {
        0 => source.pick(&[10.0, -30.0, 100.0, 1000.0]),
        _ => source.decimal(-3.0, 3.0),
    };
    let positive = source.decimal(0.5, 4.0);
    let narrow = source.pick(&[1.0, 3.0, 10.0, 30.0]);
    match source.below(18) {
        0 => x.shifted(shift).inverse(),
        1 => x.to(2).shifted(positive).inverse(),
        2 => Tree::Quotient(y.into(), x.shifted(shift).into()),
        3 => x.to(2).shifted(positive).under(Function::Sqrt),
        4 => x.shifted(shift).under(Function::Sqrt),
        5 => x.shifted(shift).to(2 + source.below(5) as i32),
        6 => x.shifted(shift).to(3).plus(y.to(2)),
        7 => Tree::Power(
            x.shifted(shift).into(),
            source.below(9) as i32 - 4,
            source.pick(&[2, 3]),
        ),
        8 => Tree::Quotient(Tree::Number(positive).into(), x.into())
            .shifted(shift)
            .inverse(),
        9 => Tree::Product(vec![x, y]),
        10 => Tree::Product(vec![x.to(2), y]),
        11 => x.under(source.pick(&[Function::Sin, Function::Cos, Function::Exp])),
        12 => Tree::Negate(x.into())
            .under(Function::Exp)
            .plus(y.under(Function::Atan)),
        13 => x.shifted(shift).under(Function::Ln),
        14 => Tree::Product(vec![x, y]).under(source.pick(&[
            Function::Tanh,
            Function::Cosh,
            Function::Sin,
        ])),
        // exp(−(n(x + c))²) and tanh(n(x + c)), about a place that the motion may come to.
        15 => Tree::Negate(
            x.shifted(source.decimal(-3.0, 3.0))
                .times(narrow)
                .to(2)
                .into(),
        )
        .under(Function::Exp),
        16 => x
            .shifted(source.decimal(-3.0, 3.0))
            .times(narrow)
            .under(Function::Tanh),
        _ => Tree::drawn(source, 2, d),
    }
}
