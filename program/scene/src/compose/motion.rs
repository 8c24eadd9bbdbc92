//! ẋ as formulas to read.

use leafwise_core::lattice::LatticeGeometry;
use leafwise_core::{Evaluator, PoissonSystem, SystemFormulas, system::Parameter};
use leafwise_expression::{Arithmetic, Expression, Graph, Kernel, Polynomial, Ring, Term};

use super::channels::Channel;
use super::contact::Contact;
use super::run::ComposedRun;
use super::stepping::Stepping;

/// Products of terms up to which ẋ is expanded.
const MOST_PRODUCTS: u64 = 100_000;

/// Parts of a formula that is still worth reading.
const MOST_PARTS: usize = 2_000;

/// Terms of a sum that is read more easily than products of sums, and how many times as long it may be.
const MOST_TERMS: usize = 12;
const MOST_FLAT: usize = 2;

/// How far a formula may be from the code of ẋ, relative to the largest component: expanded far from
/// its zero it cancels, and is then no help.
const AGREEMENT: f64 = 1e-9;

/// ẋ, to be read.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A formula for each variable, `None` for one too long to be read.
    Formulas(Vec<(String, Option<String>)>),
    /// The same for one site of a lattice, its neighbours named `x[i+1]`.
    Site(Vec<(String, Option<String>)>),
    /// A system of numbers: the values at the initial state.
    Values(Vec<(String, f64)>),
}

impl Motion {
    /// The field σ {H_k, x} of each channel of noise, beside H_k as the scene writes it.
    pub fn of_noise(run: &ComposedRun) -> Vec<(String, Self)> {
        let (Some(noise), Some(system)) = (run.method.noise(), run.system.expressions()) else {
            return Vec::new();
        };
        let field = |channel: &Channel| {
            let alone = channel.system(system).ok()?;
            let code = field_at(run, &alone.clone().into())?;
            Some((channel.text.clone(), Self::written(run, &alone, &code)?))
        };
        noise.channels.iter().filter_map(field).collect()
    }

    /// ẋ of a composed run; `None` where it has no value at the initial state.
    pub fn of(run: &ComposedRun) -> Option<Self> {
        if let Some(contact) = &run.contact {
            return Self::of_contact(run, contact);
        }
        let in_time = run.in_time().ok()?;
        let code = field_at(run, &in_time)?;
        let Some(system) = in_time.expressions() else {
            let names = in_time.variables().iter().cloned();
            return Some(Self::Values(names.zip(code).collect()));
        };
        Self::written(run, system, &code)
    }

    /// ẋ of a contact motion, by the field of H in the place of K.
    fn of_contact(run: &ComposedRun, contact: &Contact) -> Option<Self> {
        let formulas = run.system.expressions()?;
        let alone = formulas.with_hamiltonian(contact.energy().clone()).ok()?;
        let mut graph = Graph::new();
        let x: Vec<_> = (0..alone.dimension()).map(|i| graph.input(i)).collect();
        let field = field_in_code(&alone, Some(contact), &mut graph, &x)?;
        let kernel = Kernel::compile(&graph, &field, alone.parameters().len(), x.len());
        let mut workspace = kernel.workspace(1);
        kernel.prepare(&mut workspace, &alone.parameter_values(), &[1.0], &[1.0]);
        let mut code = vec![0.0; x.len()];
        kernel.evaluate(&mut workspace, &run.near, &mut code);
        Self::written(run, &alone, &code)
    }

    /// The formulas of the field of a system that stands for a run's, given its values near the initial state. There are none on a
    /// long lattice of which no site is away from open ends.
    fn written(run: &ComposedRun, system: &SystemFormulas, code: &[f64]) -> Option<Self> {
        let lattice = match &run.method {
            Stepping::Lattice(lattice) => lattice.interior.map(|site| (&lattice.written, site)),
            _ => None,
        };
        let Some((geometry, site)) = lattice else {
            let coordinates: Vec<usize> = run.plan.layout.own().collect();
            if coordinates.len() > system.dimension() {
                return None;
            }
            let names = system.variables();
            let of = (system, run.contact.as_ref());
            let formulas = formulas(of, &run.near, code, &coordinates, names);
            return Some(Self::Formulas(formulas));
        };
        let offsets = geometry.offsets();
        let moving = run.plan.families.len();
        let families = offsets.iter().zip(&geometry.families[..moving]);
        let coordinates: Vec<usize> = families
            .filter(|(_, (_, length))| site < *length)
            .map(|(offset, _)| offset + site)
            .collect();
        let names = names_about(geometry, site);
        let of = (system, None);
        let formulas = formulas(of, &run.near, code, &coordinates, &names);
        Some(Self::Site(formulas))
    }
}

/// The coordinates' names as seen from a site: `x[i]`, `x[i+1]`, ….
fn names_about(geometry: &LatticeGeometry, here: usize) -> Vec<String> {
    let name = |coordinate: usize| {
        let (family, site) = geometry.locate(coordinate);
        let family = &geometry.families[family].0;
        let shifts = geometry.shift(here, site).into_iter().zip(["i", "j", "k"]);
        let sites = shifts
            .take(geometry.axes.len())
            .map(|(shift, index)| match shift {
                0 => index.to_owned(),
                shift => format!("{index}{shift:+}"),
            });
        format!("{family}[{}]", sites.collect::<Vec<_>>().join(","))
    };
    (0..geometry.dimension()).map(name).collect()
}

/// ẋ at a state near the initial one, by the code that steppers use.
fn field_at(run: &ComposedRun, system: &PoissonSystem) -> Option<Vec<f64>> {
    let field = system.field_values().ok()?;
    let mut value = vec![0.0; run.system.dimension()];
    let mut evaluator = field.evaluator(&run.system.parameter_values(), 1.0, 1.0);
    evaluator.values(&run.near, &mut value).ok()?;
    Some(value)
}

/// ẋ of some coordinates as text: the expanded formula or the code written out, the shorter one that has the value of
/// the code. In place of a text with parentheses in parentheses stands the sum of a few terms.
fn formulas(
    (system, contact): (&SystemFormulas, Option<&Contact>),
    x: &[f64],
    code: &[f64],
    coordinates: &[usize],
    names: &[String],
) -> Vec<(String, Option<String>)> {
    let parameters: Vec<String> = system.parameters().iter().map(name_of).collect();
    let values = system.parameter_values();
    let scale = code.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let (expanded, terms) = expanded(system, contact, coordinates).unzip();
    let candidates = [expanded, as_code(system, contact, coordinates)];
    let text = |at: usize, coordinate: usize| {
        let written = |formulas: &Vec<Option<Expression>>| {
            let formula = formulas[at].as_ref()?;
            let difference = formula.evaluate(x, &values) - code[coordinate];
            let agrees = difference.is_nan() || difference.abs() <= AGREEMENT * scale;
            agrees.then(|| formula.written(names, &parameters))
        };
        let candidates = candidates.iter().flatten().filter_map(written);
        let shortest = candidates.min_by_key(String::len)?;
        let flat = terms.as_ref().and_then(written);
        let is_readable =
            |flat: &String| flat.chars().count() <= MOST_FLAT * shortest.chars().count();
        match flat.filter(is_readable) {
            Some(flat) if depth(&shortest) > 1 && depth(&flat) <= 1 => Some(flat),
            _ => Some(shortest),
        }
    };
    let rows = coordinates.iter().enumerate();
    rows.map(|(at, &coordinate)| (names[coordinate].clone(), text(at, coordinate)))
        .collect()
}

/// How many parentheses are open at once at most.
fn depth(text: &str) -> usize {
    let (mut open, mut most) = (0_usize, 0);
    for c in text.chars() {
        match c {
            '(' => open += 1,
            ')' => open = open.saturating_sub(1),
            _ => {}
        }
        most = most.max(open);
    }
    most
}

fn name_of(parameter: &Parameter) -> String {
    parameter.name.clone()
}

/// Formulas of some coordinates.
type Formulas = Vec<Option<Expression>>;

/// −Π (dH + η) + f in the exact ring, and the same as sums of its terms where they are few.
fn expanded(
    system: &SystemFormulas,
    contact: Option<&Contact>,
    coordinates: &[usize],
) -> Option<(Formulas, Formulas)> {
    let d = system.dimension();
    let mut ring = Ring::limited(d, MOST_PRODUCTS);
    let x: Vec<_> = (0..d).map(|i| ring.variable(i)).collect();
    let energy = system.hamiltonian();
    let energy = energy.evaluate_in(&mut ring, &mut |_, at| Ok(x[at].clone()));
    let energy = energy.ok()?;
    let gradient = ring.gradient(&energy).ok()?;
    let field = system.motion_reversed(&mut ring, &x, gradient).ok()?;
    let mut field: Vec<Polynomial> = field.iter().map(|f| ring.negate(f)).collect();
    if let Some(contact) = contact {
        field = contact.field(&mut ring, &x, (&energy, field));
    }
    if ring.refusal().is_some() {
        return None;
    }
    let components: Vec<Polynomial> = coordinates.iter().map(|at| field[*at].clone()).collect();
    let formula = |component: &Polynomial| {
        (component.terms().len() <= MOST_PARTS).then(|| ring.formula(component))
    };
    let sum = |component: &Polynomial| {
        let terms = component.terms().iter();
        let term = |(monomial, coefficient): &(_, _)| {
            ring.formula(&Polynomial::term(
                Clone::clone(monomial),
                Clone::clone(coefficient),
            ))
        };
        (terms.len() <= MOST_TERMS).then(|| Expression::Sum(terms.map(term).collect()))
    };
    Some((
        components.iter().map(formula).collect(),
        components.iter().map(sum).collect(),
    ))
}

/// The same as code, its shared parts written out.
fn as_code(
    system: &SystemFormulas,
    contact: Option<&Contact>,
    coordinates: &[usize],
) -> Option<Formulas> {
    let mut graph = Graph::new();
    let x: Vec<_> = (0..system.dimension()).map(|i| graph.input(i)).collect();
    let field = field_in_code(system, contact, &mut graph, &x)?;
    let formula = |&at: &usize| graph.formula(&field[at], MOST_PARTS);
    Some(coordinates.iter().map(formula).collect())
}

/// ẋ as code.
fn field_in_code(
    system: &SystemFormulas,
    contact: Option<&Contact>,
    graph: &mut Graph,
    x: &[Term],
) -> Option<Vec<Term>> {
    let field = system.vector_field(graph, x).ok()?;
    let Some(contact) = contact else {
        return Some(field);
    };
    let energy = system.hamiltonian();
    let energy = energy.evaluate_in(graph, &mut |_, at| Ok(x[at].clone()));
    Some(contact.field(graph, x, (&energy.ok()?, field)))
}
