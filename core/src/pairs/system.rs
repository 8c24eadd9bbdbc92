//! Poisson systems of functions of sums over sites and pairs.

use std::sync::Arc;

use leafwise_expression::{Arithmetic, Expression, Graph, Term, Workspace};

use super::BodyShape;
use super::bracket::{BodyMotion, applied};
use super::function::{BodyFunction, BodySum};
use super::shears::parts;
use super::site_code::SiteCode;
use super::tangent::{TangentCode, Tangents};
use super::values::{Slopes, SlopesCode, Sums, SumsCode};
use crate::error::{BuildError, StepError};
use crate::evaluator::Evaluator;
use crate::system::numbers::{Derivatives, Shear, SystemEvaluator, SystemFunction, vector};
use crate::system::{Convention, Forces, OpaqueSystem, Parameter, SystemFormulas, SystemNumbers};

/// A Poisson system with H and Casimirs of sums, and a tensor whose entries couple coordinates of one site.
#[derive(Clone, Debug)]
pub struct BodySystem {
    /// The numbers of families and sites.
    pub shape: BodyShape,
    /// The coordinates' names, family after family.
    pub variables: Vec<String>,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// Π_ab = {x_a, x_b}, a < b, of families at one site, in the paper's convention and in the coordinates of that site.
    pub bracket: Vec<((usize, usize), Expression)>,
    /// Forces at one site, a component for each family, in the coordinates of that site.
    pub forces: Forces,
    /// H.
    pub hamiltonian: BodyFunction,
    /// The Casimirs by name.
    pub casimirs: Vec<(String, BodyFunction)>,
    /// A state near which it moves; no numbers where none is known.
    pub near: Vec<f64>,
}

impl BodySystem {
    /// The system as one of numbers, evaluated in a loop over pairs.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a formula or derivative has no code.
    pub fn compile(&self) -> Result<OpaqueSystem, BuildError> {
        let (shape, parameters) = (&self.shape, self.parameters.len());
        let moving = self.moving();
        let all: Vec<usize> = (0..shape.families).collect();
        let field = self.field_of(&moving, &moving)?;
        let gradient = SlopesCode::new(
            &self.hamiltonian,
            shape,
            &all,
            parameters,
            |_, _, gradient| Ok(gradient.iter().cloned().enumerate().collect()),
        )?;
        let mut tensor_families = Vec::new();
        let tensor = SiteCode::new(2 * shape.families, parameters, |graph, rows| {
            let (x, v) = rows.split_at(shape.families);
            let (families, terms) = applied(&self.bracket, graph, x, v, false)?
                .into_iter()
                .unzip();
            tensor_families = families;
            Ok(terms)
        })?;
        let gradient = Arc::new(gradient);
        // A field may have no derivative. That of forces is not offered.
        let has_forces = !self.forces.is_empty();
        let motion = BodyMotion {
            shape,
            parameters,
            bracket: &self.bracket,
            hamiltonian: &self.hamiltonian,
        };
        let tangent = match has_forces {
            true => None,
            false => TangentCode::new(&motion, &gradient).ok().map(Arc::new),
        };
        let casimirs: Vec<BodyFunction> = (self.casimirs.iter())
            .map(|(_, casimir)| casimir.clone())
            .collect();
        let code = Arc::new(BodyCode {
            shape: shape.clone(),
            field: Arc::new(field),
            gradient,
            tensor,
            tensor_families,
            energy: Arc::new(SumsCode::of_functions(
                std::slice::from_ref(&self.hamiltonian),
                shape,
                parameters,
            )?),
            casimirs: Arc::new(SumsCode::of_functions(&casimirs, shape, parameters)?),
        });
        let of_field = Arc::clone(&code);
        let mut numbers = SystemNumbers::new(Derivatives::default(), move |parameters| {
            Box::new(BodyEvaluator::new(&code, parameters))
        })
        .with_field(move |parameters, points| {
            Box::new(FieldOfBodies {
                slopes: Slopes::new(&of_field.field, points, parameters),
                work: of_field.field.work() * points as u64,
                operations: 0,
            })
        })
        .with_motion(self.forces.motion())
        .with_derived_gradient();
        if let Some(poles) = self.poles()? {
            numbers = numbers.with_poles(poles);
        }
        let [of_series, of_rounding] = [self.clone(), self.clone()];
        numbers = numbers
            .with_jets(move |order| of_series.jet(order))
            .with_rounding(move || of_rounding.bounds());
        if let Some(tangent) = tangent {
            numbers = numbers.with_field_tangent(move |parameters| {
                let made = |is_pulled| Tangents::new(&tangent, parameters, is_pulled);
                [Box::new(made(false)), Box::new(made(true))]
            });
        }
        if let Some(terms) = self.terms()? {
            numbers = numbers.with_terms(terms);
        }
        if self.rests(&moving) {
            numbers = numbers.with_resting_tensor();
            if !has_forces {
                numbers = numbers.with_shears(self.shears()?);
            }
        }
        Ok(OpaqueSystem {
            name: "sums over pairs".to_owned(),
            variables: self.variables.clone(),
            parameters: self.parameters.clone(),
            casimirs: self.casimirs.iter().map(|(name, _)| name.clone()).collect(),
            numbers,
        })
    }

    /// The families that the tensor or friction moves.
    pub(super) fn moving(&self) -> Vec<usize> {
        let friction = self.forces.friction.iter().enumerate();
        let friction = friction.filter(|(_, own)| **own != 0.into());
        let mut moving: Vec<usize> = (self.bracket.iter())
            .flat_map(|((a, b), _)| [*a, *b])
            .chain(friction.map(|(family, _)| family))
            .collect();
        moving.sort_unstable();
        moving.dedup();
        moving
    }

    /// The same with families at rest behind its own, moved by Σ_i s(x_i) beside H: ẋ = −Π(dH + η + ds). Damping is of H all the same.
    ///
    /// `names` are those of the families, s a formula in the coordinates of a site, those at rest too. Casimirs are left out.
    ///
    /// # Errors
    /// Those of [`SystemFormulas::with_perturbation`], for the formulas of a site.
    pub fn with_resting(mut self, names: &[String], s: Expression) -> Result<Self, BuildError> {
        let further = names.len();
        self.hamiltonian = self.hamiltonian.with_families(&self.shape, further);
        self.casimirs.clear();
        self.near.clear();
        for name in names {
            let sites = 0..self.shape.sites;
            self.variables.extend(sites.map(|i| format!("{name}[{i}]")));
        }
        self.shape.families += further;
        self.forces = self.forces.with_resting(self.shape.families);
        if self.forces.is_empty() {
            let own = &mut self.hamiltonian;
            let all = vec![own.outer.clone(), Expression::Variable(own.sums.len())];
            own.outer = Expression::Sum(all);
            let pair = 0.into();
            own.sums.push(BodySum { site: s, pair });
        } else {
            let site = self.of_a_site()?.with_perturbation(s)?;
            self.forces = site.forces().clone();
        }
        Ok(self)
    }

    /// Tensor and forces of one site, with H = 0.
    ///
    /// # Errors
    /// [`BuildError::Dimension`] where a formula looks at other sites.
    pub fn of_a_site(&self) -> Result<SystemFormulas, BuildError> {
        let names = (0..self.shape.families).map(|family| format!("x{family}"));
        let site = SystemFormulas::new(
            names.collect(),
            self.parameters.clone(),
            self.bracket.iter().cloned(),
            0.into(),
            Vec::new(),
            Convention::HamiltonianFirst,
        )?;
        site.with_forces(self.forces.clone())
    }

    /// −Π(∇H + η) + f at one site for each family that moves, given ∇H there.
    ///
    /// # Errors
    /// [`BuildError`] where a formula has no code.
    pub(super) fn velocities(
        &self,
        graph: &mut Graph,
        x: &[Term],
        gradient: &[Term],
    ) -> Result<Vec<(usize, Term)>, BuildError> {
        if self.forces.is_empty() {
            return applied(&self.bracket, graph, x, gradient, true);
        }
        let site = self.of_a_site()?;
        let reversed = site.motion_reversed(graph, x, gradient.to_vec())?;
        let moving = self.moving().into_iter();
        Ok(moving
            .map(|family| (family, graph.negate(&reversed[family])))
            .collect())
    }

    /// The families of −Π∇H, or of the field with forces, that `moves` lists, with the gradient by families `by`.
    fn field_of(&self, moves: &[usize], by: &[usize]) -> Result<SlopesCode, BuildError> {
        let parameters = self.parameters.len();
        SlopesCode::new(
            &self.hamiltonian,
            &self.shape,
            by,
            parameters,
            |graph, x, gradient| {
                let mut results = self.velocities(graph, x, gradient)?;
                results.retain(|(family, _)| moves.contains(family));
                Ok(results)
            },
        )
    }

    /// The parts of H = T + V whose flows are shears, that of fewer operations first; none where H does not separate.
    fn shears(&self) -> Result<Vec<Shear>, BuildError> {
        let entries = self.bracket.iter();
        let entries: Vec<_> = entries
            .map(|(at, entry)| (*at, entry.variables()))
            .collect();
        let Some(parts) = parts(&self.hamiltonian, &self.shape, &entries)? else {
            return Ok(Vec::new());
        };
        let mut shears = Vec::new();
        for part in parts {
            let code = Arc::new(self.field_of(&part.moves, &part.by)?);
            let work = code.work();
            let sites = self.shape.sites;
            let moves = part.moves.iter();
            let moves: Vec<usize> = moves
                .flat_map(|family| family * sites..(family + 1) * sites)
                .collect();
            let shear = Shear::new(part.is_affine, moves, move |parameters, points| {
                Box::new(FieldOfBodies {
                    slopes: Slopes::new(&code, points, parameters),
                    work: work * points as u64,
                    operations: 0,
                })
            });
            shears.push((work, shear));
        }
        shears.sort_by_key(|(work, _)| *work);
        Ok(shears.into_iter().map(|(_, shear)| shear).collect())
    }

    /// Whether the entries of the tensor depend on coordinates that rest alone.
    pub(super) fn rests(&self, moving: &[usize]) -> bool {
        let mut entries = self.bracket.iter();
        entries.all(|(_, entry)| {
            entry
                .variables()
                .is_disjoint(&moving.iter().copied().collect())
        })
    }
}

/// The code of a system.
struct BodyCode {
    shape: BodyShape,
    /// −Π∇H, ∇H and Πv.
    field: Arc<SlopesCode>,
    gradient: Arc<SlopesCode>,
    tensor: SiteCode,
    tensor_families: Vec<usize>,
    /// H and the Casimirs.
    energy: Arc<SumsCode>,
    casimirs: Arc<SumsCode>,
}

/// The field of a system at points side by side.
struct FieldOfBodies {
    slopes: Slopes,
    /// Operations of one evaluation, and of all so far.
    work: u64,
    operations: u64,
}

impl Evaluator for FieldOfBodies {
    fn values(&mut self, points: &[f64], field: &mut [f64]) -> Result<(), StepError> {
        self.slopes.evaluate(points, field);
        self.operations += self.work;
        Ok(())
    }

    fn jacobians(&mut self, _points: &[f64], _out: &mut [f64]) -> Result<(), StepError> {
        Err(StepError::NoTangent)
    }

    fn operations(&self) -> Option<u64> {
        Some(self.operations)
    }
}

/// One thread's evaluator of a system of bodies, point by point.
struct BodyEvaluator {
    code: Arc<BodyCode>,
    gradient: Slopes,
    tensor: Workspace,
    energy: Sums,
    casimirs: Sums,
    operations: u64,
}

impl BodyEvaluator {
    fn new(code: &Arc<BodyCode>, parameters: &[f64]) -> Self {
        Self {
            gradient: Slopes::new(&code.gradient, 1, parameters),
            tensor: code.tensor.workspace(parameters),
            energy: Sums::new(&code.energy, 1, parameters),
            casimirs: Sums::new(&code.casimirs, 1, parameters),
            code: Arc::clone(code),
            operations: 0,
        }
    }

    fn apply_tensor(&mut self, y: &[f64], v: &[f64], out: &mut [f64]) {
        let places = self.code.shape.sites;
        let families = self.code.shape.families;
        let row = |at: usize| match at < families {
            true => &y[at * places..][..places],
            false => &v[(at - families) * places..][..places],
        };
        out.fill(0.0);
        let (code, workspace) = (&self.code, &mut self.tensor);
        code.tensor
            .evaluate(workspace, places, row, |result, place, values| {
                let start = code.tensor_families[result] * places + place;
                out[start..][..values.len()].copy_from_slice(values);
            });
    }
}

impl SystemEvaluator for BodyEvaluator {
    fn evaluate(
        &mut self,
        function: SystemFunction<'_>,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), StepError> {
        let d = self.code.shape.dimension();
        let results = match function {
            SystemFunction::Tensor(_) | SystemFunction::Gradient => d,
            SystemFunction::Hamiltonian => 1,
            SystemFunction::Casimirs => self.code.casimirs.outers(),
            SystemFunction::TensorTangent(..)
            | SystemFunction::Hessian(_)
            | SystemFunction::CasimirGradients => return Err(StepError::NoTangent),
        };
        for (at, out) in out.chunks_exact_mut(results.max(1)).enumerate() {
            let y = vector(y, d, at);
            match function {
                SystemFunction::Tensor(v) => self.apply_tensor(y, vector(v, d, at), out),
                SystemFunction::Gradient => {
                    self.gradient.evaluate(y, out);
                    self.operations += self.code.gradient.work();
                }
                SystemFunction::Hamiltonian => self.energy.evaluate(y, out),
                _ => self.casimirs.evaluate(y, out),
            }
        }
        Ok(())
    }

    fn operations(&self) -> Option<u64> {
        Some(self.operations)
    }
}
