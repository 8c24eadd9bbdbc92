//! The spherical midpoint rule on products of so(3)*: the part `spherical-midpoint`.

use std::sync::Arc;

use leafwise_core::lattice::{
    ImplicitSweeps, LatticeMap, LatticeSource, ProxyCode, StageBuilder, StageEnds,
};
use leafwise_core::part::{Compared, Family, PartInfo, PartKind, PartParameters};
use leafwise_core::registry::StepperPart;
use leafwise_core::runge_kutta::{SmoothMap, SmoothMapEvaluator};
use leafwise_core::solver::judge::reach;
use leafwise_core::solver::{StepReport, Trajectories};
use leafwise_core::{
    BuildError, Evaluator, MapProperties, PoissonSystem, StepError, StepMap, Structure,
    SystemFormulas,
};
use leafwise_expression::{Arithmetic, Function, Polynomial, Rational, Ring, Term};
use nalgebra::{DMatrix, Matrix3, Vector3};

use crate::reference_map::{ReferenceMap, row_major};
use crate::step_equation::{StepEquation, StepSolve};

static INFO: PartInfo = PartInfo {
    name: "spherical-midpoint",
    summary: "x+ = x + t X(|x| (x + x+)/|x + x+|), triple by triple",
    declares: "order 2; self-adjoint; exactly Poisson; keeps every |x|; exact tangent",
    domain: "products of so(3)*: triples of coordinates, in any order, with {x1,x2} = c x3 and cyclic, c constant; \
             besides, coordinates that commute with all, such as parameters of sites",
    literature: "R. McLachlan, K. Modin, O. Verdier, Symplectic integrators for spin systems, \
                 Phys. Rev. E 89 (2014); A minimal-variable symplectic walk on spheres, \
                 Math. Comp. 86 (2017)",
    family: Some(Family::Poisson),
    compared: Some(Compared::at(2)),
    ..PartInfo::of(PartKind::Stepper)
};

const PROPERTIES: MapProperties = MapProperties {
    order: 2,
    structure: Structure::Exact,
    self_adjoint: Some(true),
};

/// Operations of a triple's middle and its derivatives, the two roots weighted.
const TRIPLE: usize = 100;

/// D = t X(Γ(x, D)) with Γ = |x| (2x + D)/|2x + D| in each triple. X(Γ) is normal to Γ, so
/// |x + D|² − |x|² = D·(2x + D) = 0. A coordinate of no triple rests: Γ = x and D = 0.
struct Midpoint {
    field: SmoothMapEvaluator,
    /// The coordinates of each triple.
    triples: Arc<[[usize; 3]]>,
    /// Of each coordinate its triple, and which of the three it is; `None` where it rests.
    places: Vec<Option<(usize, usize)>>,
    time_step: f64,
    start: Vec<f64>,
    change: Vec<f64>,
    middle: Vec<f64>,
    values: Vec<f64>,
    jacobian: Vec<f64>,
    /// ∂Γ/∂D and ∂Γ/∂x of each triple.
    turns: Vec<Matrix3<f64>>,
    stretches: Vec<Matrix3<f64>>,
    /// Whether the last evaluation was with derivatives.
    is_exact: bool,
    /// Operations of the triples.
    operations: u64,
}

impl Midpoint {
    fn new(
        field: &SmoothMap,
        triples: &Arc<[[usize; 3]]>,
        parameters: &[f64],
        time_step: f64,
    ) -> Self {
        let d = field.inputs();
        let mut places = vec![None; d];
        for (triple, coordinates) in triples.iter().enumerate() {
            for (c, at) in coordinates.iter().enumerate() {
                places[*at] = Some((triple, c));
            }
        }
        let room = || vec![0.0; d];
        Self {
            field: field.evaluator(parameters, 1.0, 1.0),
            triples: Arc::clone(triples),
            places,
            time_step,
            start: room(),
            change: room(),
            middle: room(),
            values: room(),
            jacobian: vec![0.0; d * d],
            turns: vec![Matrix3::zeros(); triples.len()],
            stretches: vec![Matrix3::zeros(); triples.len()],
            is_exact: false,
            operations: 0,
        }
    }

    /// Γ of a triple, ∂Γ/∂D and ∂Γ/∂x; all 0 at the origin, where the field vanishes.
    fn middle(&self, triple: usize) -> (Vector3<f64>, Matrix3<f64>, Matrix3<f64>) {
        let of = |all: &[f64]| Vector3::from(self.triples[triple].map(|at| all[at]));
        let x = of(&self.start);
        let sum = 2.0 * x + of(&self.change);
        let (radius, length) = (norm(&x), norm(&sum));
        if radius == 0.0 {
            return (Vector3::zeros(), Matrix3::zeros(), Matrix3::zeros());
        }
        let unit = sum / length;
        let turn = (Matrix3::identity() - unit * unit.transpose()) * (radius / length);
        let stretch = unit * (x / radius).transpose();
        (unit * radius, turn, stretch + 2.0 * turn)
    }

    /// Entry (i, k) of t DX(Γ)·B for a matrix B of these blocks, and of `rest` where coordinates rest.
    fn through(&self, blocks: &[Matrix3<f64>], rest: f64, i: usize, k: usize) -> f64 {
        let row = &self.jacobian[i * self.start.len()..][..self.start.len()];
        let Some((triple, c)) = self.places[k] else {
            return self.time_step * row[k] * rest;
        };
        let row = self.triples[triple].map(|at| row[at]);
        let column = blocks[triple].column(c);
        let sum: f64 = row.iter().zip(column.iter()).map(|(a, b)| a * b).sum();
        self.time_step * sum
    }
}

impl StepEquation for Midpoint {
    fn time_step(&mut self) -> &mut f64 {
        &mut self.time_step
    }

    /// t X(Γ) − D and 1 − t DX(Γ) ∂Γ/∂D.
    fn linearize(
        &mut self,
        change: &[f64],
        residual: &mut [f64],
        matrix: &mut [f64],
    ) -> Result<(), StepError> {
        let d = self.start.len();
        self.is_exact = !matrix.is_empty();
        // Radii, the middle and its two derivatives; the matrix, block by block.
        let of_matrix = if self.is_exact { 7 * d * d } else { 0 };
        self.operations += (TRIPLE * self.turns.len() + of_matrix) as u64;
        self.change.copy_from_slice(change);
        self.middle.copy_from_slice(&self.start);
        for triple in 0..self.turns.len() {
            let (middle, turn, stretch) = self.middle(triple);
            for (at, value) in self.triples[triple].iter().zip(middle.iter()) {
                self.middle[*at] = *value;
            }
            self.turns[triple] = turn;
            self.stretches[triple] = stretch;
        }
        self.field.values(&self.middle, &mut self.values)?;
        if self.is_exact {
            self.field.jacobians(&self.middle, &mut self.jacobian)?;
        }
        for (c, residual) in residual.iter_mut().enumerate() {
            *residual = self.time_step * self.values[c] - change[c];
        }
        for (at, entry) in matrix.iter_mut().enumerate() {
            let unit = if at / d == at % d { 1.0 } else { 0.0 };
            *entry = unit - self.through(&self.turns, 0.0, at / d, at % d);
        }
        Ok(())
    }

    fn change(&self, row: usize) -> f64 {
        self.time_step * self.values[row]
    }

    fn measure(&self, row: usize) -> (f64, f64, f64) {
        if !self.is_exact {
            return (self.start[row], self.change(row), 0.0);
        }
        let d = self.start.len();
        let sensitivity = reach(&self.jacobian[row * d..][..d], &self.middle);
        let put_in = self.time_step.abs() * sensitivity;
        (self.start[row], 0.0, put_in)
    }

    fn unit(&self) -> f64 {
        1.0
    }
}

fn norm(v: &Vector3<f64>) -> f64 {
    libm::sqrt(v.iter().map(|c| c * c).sum())
}

/// The equation of a step and its solve.
struct SphericalMidpoint {
    midpoint: Midpoint,
    solve: StepSolve,
}

impl SphericalMidpoint {
    fn advance(&mut self, x: &[f64]) -> Result<usize, StepError> {
        let (midpoint, solve) = (&mut self.midpoint, &mut self.solve);
        midpoint.start.copy_from_slice(x);
        let mut evaluations = solve.solve(midpoint, x)?;
        if solve.is_by_residuals() {
            // Spheres are kept as far as D is t X(Γ): once more, without acceleration.
            solve.add_residual(midpoint)?;
            evaluations += 1;
        }
        Ok(evaluations)
    }
}

impl Trajectories for SphericalMidpoint {
    fn step(&mut self, x: &[f64], _low: &[f64], increment: &mut [f64], taken: &mut [StepReport]) {
        let step = self.advance(x);
        increment.copy_from_slice(&self.solve.unknowns);
        taken[0].take(step, self.solve.is_rounded());
    }

    fn operations(&self) -> Option<u64> {
        let midpoint = &self.midpoint;
        Some(midpoint.field.operations()? + midpoint.operations + self.solve.operations())
    }

    fn tangent(&mut self, _: usize) -> Option<Vec<f64>> {
        let d = self.midpoint.start.len();
        if !self.solve.factor(&mut self.midpoint) {
            return None;
        }
        let mut tangent = DMatrix::identity(d, d);
        for k in 0..d {
            let through = |i| self.midpoint.through(&self.midpoint.stretches, 1.0, i, k);
            let mut column: Vec<f64> = (0..d).map(through).collect();
            self.solve.factors.solve(&mut column);
            for (i, change) in column.iter().enumerate() {
                tangent[(i, k)] += change;
            }
        }
        Some(row_major(&tangent))
    }

    fn restart(&mut self, _: usize) {
        self.solve.restart();
    }

    fn memory(&self, _: usize) -> Vec<f64> {
        self.solve.memory()
    }

    fn restore(&mut self, _: usize, memory: &[f64]) {
        self.solve.restore(memory);
    }
}

/// The triples of a product of so(3)*: in each {x1,x2} = c x3, {x2,x3} = c x1, {x3,x1} = c x2 with one c, and nothing else.
/// Coordinates without an entry rest.
fn triples(system: &SystemFormulas) -> Result<Vec<[usize; 3]>, BuildError> {
    let unfit = |reason: String| BuildError::DoesNotFit {
        part: INFO.name,
        reason,
    };
    let d = system.dimension();
    let mut triples = joined(system);
    triples.retain(|set| set.len() > 1);
    if triples.is_empty() || triples.iter().any(|triple| triple.len() != 3) {
        return Err(unfit(
            "its variables do not form triples of so(3)*".to_owned(),
        ));
    }
    let mut ring = Ring::new(d);
    let x: Vec<Polynomial> = (0..d).map(|i| ring.variable(i)).collect();
    let entry = |ring: &mut Ring, i: usize, j: usize| match system.tensor().get(&(i, j)) {
        None => Ok(Polynomial::zero()),
        Some(entry) => entry.evaluate_in(ring, &mut |_, at| Ok(x[at].clone())),
    };
    let mut found = Vec::with_capacity(triples.len());
    for triple in triples {
        let [a, b, c] = [triple[0], triple[1], triple[2]];
        let mut factor: Option<Polynomial> = None;
        for (i, j, third) in [(a, b, c), (b, c, a), (a, c, b)] {
            let value = entry(&mut ring, i, j)?;
            // {x1, x3} stands above the diagonal with the other sign.
            let signed = if third == b {
                ring.negate(&value)
            } else {
                value
            };
            let own = ring.derivative(&signed, third)?;
            let again = ring.multiply(&own, &x[third]);
            let known = factor.get_or_insert_with(|| own.clone());
            let is_same = *known == own && ring.subtract(&again, &signed).is_zero();
            if !is_same || own.is_zero() || own.as_constant().is_none() {
                let [i, j] = [i, j].map(|at| &system.variables()[at]);
                return Err(unfit(format!("{{{i}, {j}}} is not that of so(3)*")));
            }
        }
        found.push([a, b, c]);
    }
    Ok(found)
}

/// Coordinates that entries join, those of each set in order.
fn joined(system: &SystemFormulas) -> Vec<Vec<usize>> {
    let mut sets: Vec<Vec<usize>> = (0..system.dimension()).map(|at| vec![at]).collect();
    for &(i, j) in system.tensor().keys() {
        let of = |at: usize| sets.iter().position(|set| set.contains(&at));
        if let (Some(first), Some(second)) = (of(i), of(j))
            && first != second
        {
            let (kept, moved) = (first.min(second), first.max(second));
            let moved = sets.remove(moved);
            sets[kept].extend(moved);
        }
    }
    for set in &mut sets {
        set.sort_unstable();
    }
    sets
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    let triples: Arc<[[usize; 3]]> = triples(system.formulas(INFO.name)?)?.into();
    let field = system.field_map()?;
    Ok(Arc::new(ReferenceMap {
        dimension: system.dimension(),
        properties: PROPERTIES,
        description: INFO.name.to_owned(),
        together: 1,
        kept_signs: Vec::new(),
        make: Box::new(move |parameters, time_step, _| {
            Box::new(SphericalMidpoint {
                midpoint: Midpoint::new(&field, &triples, parameters, time_step),
                solve: StepSolve::new(field.inputs(), true).plainly_first(),
            })
        }),
    }))
}

/// The rule on a long lattice. For the middle y = Γ of a step, |y| = |x|, and X(y) is normal to y in each triple. The
/// ends are x = c y − t X(y)/2 and x+ = c y + t X(y)/2 with c = √(1 − s), s = |t X(y)|²/(4 |y|²). Both ends follow
/// from y alone.
///
/// # Errors
/// As [`build`], of a lattice of any length.
fn build_on_lattice(
    source: &dyn LatticeSource,
    parameters: &PartParameters,
) -> Result<LatticeMap, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    ImplicitSweeps::compose(source, PROPERTIES.order, |builder, code| {
        code.system.without_forces(INFO.name)?;
        let formulas = code.system.formulas(INFO.name)?;
        let ends = ends(builder, code, formulas, &triples(formulas)?)?;
        Ok((ends, PROPERTIES, INFO.name.to_owned()))
    })
}

/// x − y = (c − 1) y − t X(y)/2, where c − 1 = −s/(1 + c), and x+ − x = t X(y).
fn ends(
    builder: &mut StageBuilder,
    code: &ProxyCode<'_>,
    formulas: &SystemFormulas,
    triples: &[[usize; 3]],
) -> Result<StageEnds, BuildError> {
    let y = &code.y;
    let graph = &mut builder.graph;
    let [epsilon, h] = &code.sizes;
    let step = graph.multiply(epsilon, h);
    let field = formulas.vector_field(graph, y)?;
    let increment: Vec<Term> = field.iter().map(|x| graph.multiply(&step, x)).collect();
    let (one, half) = (Rational::one(), Rational::new(1, 2));
    let unit = graph.one();
    // Where a triple is 0 its field is 0 too.
    let ten = graph.constant(&Rational::from_integer(10));
    let tiny = graph.integer_power(&ten, SMALLEST_SQUARE)?;
    let mut offset = increment.clone();
    let mut reaches = vec![None; y.len()];
    for triple in triples {
        let squares = |of: &[Term]| triple.map(|at| (one.clone(), of[at].clone(), of[at].clone()));
        let (lengths, moves) = (squares(y), squares(&increment));
        let terms = lengths.each_ref().map(|(c, a, b)| (c.clone(), a, b));
        let length = graph.combine_products(&[(one.clone(), tiny.clone())], &terms);
        let terms = moves.each_ref().map(|(c, a, b)| (c.clone(), a, b));
        let moved = graph.sum_of_products(&terms);
        let quarter = graph.scale(&Rational::new(1, 4), &moved);
        let s = graph.divide(&quarter, &length)?;
        let left = graph.subtract(&unit, &s);
        let c = graph.apply(Function::Sqrt, &left)?;
        let below = graph.add(&unit, &c);
        let shrink = graph.divide(&s, &below)?;
        for at in triple {
            offset[*at] = graph.combine_products(
                &[(-half.clone(), increment[*at].clone())],
                &[(-one.clone(), &shrink, &y[*at])],
            );
        }
        reaches[triple[0]] = Some(s);
    }
    builder.guard(reaches);
    Ok(StageEnds { offset, increment })
}

/// The power of ten beside |y|², far below any square that is not 0.
const SMALLEST_SQUARE: i64 = -300;

leafwise_core::built_in!(StepperPart::new(&INFO, build).with_sweeps(build_on_lattice));
