//! Strang's product as a step map.

use std::sync::{Arc, Mutex, PoisonError};

use leafwise_core::lattice::{LatticeMap, LatticeSource};
use leafwise_core::part::{
    Compared, Elsewhere, Family, ParameterDefault, ParameterInfo, PartInfo, PartKind,
    PartParameters,
};
use leafwise_core::registry::StepperPart;
use leafwise_core::solver::{
    ExplicitMap, Factored, MapAbilities, MapProperties, StepMap, Stepper, Structure,
};
use leafwise_core::{BuildError, Differential, Inverse, PoissonSystem, Shadow, SystemFormulas};
use leafwise_expression::{Arithmetic, Graph, Kernel, OperationCount, Ring, StepSize, Term};

use crate::arrangement::{AUTO, ORDER, asked_order, named_order};
use crate::code::{product_increment, return_increment};
use crate::display::Names;
use crate::lattice::LatticeSplitting;
use crate::piece::{NAME, Piece};
use crate::pieces::{Bodies, find_pieces};
use crate::product::{Product, Splits, evaluations, is_symmetric};
use crate::rounding::settled;
use crate::schedule::{STRANG, passes};
use crate::shears::Shears;
use crate::terms::FlowsOfTerms;

static INFO: PartInfo = PartInfo {
    name: NAME,
    summary: "Strang's product of exact flows of the Hamiltonian's pieces, found from the formulas",
    declares: "order 2; self-adjoint; exactly Poisson; explicit",
    domain: "Hamiltonians whose terms have flows that are polynomial, exponential or rotations, or free rigid bodies, \
             or bodies about centres that attract them by the inverse square, or pairs of vectors that turn about one axis",
    literature: "Strang, On the construction and comparison of difference schemes (1968); \
                 McLachlan, Quispel, Splitting methods, Acta Numerica 11 (2002); Hairer, Lubich, \
                 Wanner, Geometric Numerical Integration, section VII.4.2; bodies: van Zon, Schofield, J. Comput. Phys. 225 \
                 (2007); Celledoni, Fassò, Säfström, Zanna, SIAM J. Sci. Comput. 30 (2008); Kepler's motion: Wisdom, Holman, Astron. J. \
                 102 (1991); Wisdom, Hernandez, Mon. Not. R. Astron. Soc. 453 (2015)",
    parameters: &[
        ParameterInfo {
            name: ORDER,
            summary: "the order in which a step takes the pieces, by their numbers in the order of H's terms: \"2 1 3\"; the last \
                      one is the middle of a step",
            default: ParameterDefault::Text(AUTO),
        },
        ParameterInfo {
            name: BODIES,
            summary: "how a step moves free rigid bodies, squares of momenta with the brackets of so(3), and bodies about a centre, \
                      a*|p|^2 - k/|q - c| in two or three dimensions: \"axes\" rotates about one axis after the other and splits \
                      kinetic energy from attraction; \"whole\" takes the exact flow of the body or of Kepler's motion, as separate \
                      pieces after the others",
            default: ParameterDefault::Text(AXES),
        },
    ],
    family: Some(Family::Splitting),
    compared: Some(Compared {
        settings: &[&[], &[(BODIES, ParameterDefault::Text(WHOLE))]],
        ..Compared::at(1)
    }),
    reference: Some(&[]),
    elsewhere: Some(Elsewhere {
        names: &[
            "verlet",
            "velocity-verlet",
            "stormer-verlet",
            "störmer-verlet",
            "leapfrog",
            "kdk",
            "dkd",
            "strang",
        ],
        is: "Störmer and Verlet's method, leapfrog, where H = T(p) + V(q); but an oscillator, p^2/2 + q^2/2, is turned exactly",
    }),
    ..PartInfo::of(PartKind::Stepper)
};

/// φ¹_{t/2} ∘ … ∘ φʳ_t ∘ … ∘ φ¹_{t/2}, t = εh, over exact flows of the pieces of H. This product is explicit, of order
/// 2, self-adjoint, and a Poisson map that keeps every Casimir (G. Strang, SIAM Journal on Numerical Analysis 5,
/// 506–517 (1968)).
#[derive(Clone, Debug)]
pub struct Splitting {
    shared: Arc<Shared>,
}

/// Cache of code for products of χ and χ*, each with the product's parts of the time.
type ByParts<T> = Mutex<Vec<(Vec<f64>, T)>>;

#[derive(Debug)]
struct Shared {
    system: SystemFormulas,
    ring: Ring,
    pieces: Vec<Piece>,
    step: ExplicitMap,
    /// Products that were asked for.
    products: ByParts<ExplicitMap>,
    /// Their steps back with gradients.
    returns: ByParts<Option<Arc<Kernel>>>,
}

/// The parameter that says how bodies are taken, and its words.
const BODIES: &str = "bodies";
const AXES: &str = "axes";
const WHOLE: &str = "whole";

fn bodies(parameters: &PartParameters) -> Result<Bodies, BuildError> {
    let word = parameters.word(&INFO, BODIES, &[AXES, WHOLE])?;
    Ok(if word == WHOLE {
        Bodies::Whole
    } else {
        Bodies::Axes
    })
}

/// The largest product, in operations, that becomes one kernel.
const LARGEST_PRODUCT: u64 = 20_000;

impl Splitting {
    /// Splits the system's Hamiltonian and compiles the step.
    ///
    /// # Errors
    /// Fails with [`BuildError::DoesNotFit`] with the term of H that has no exact flow, or where flows cancel. Fails
    /// with [`BuildError::Algebra`] where a formula is outside the algebra.
    pub fn new(system: &PoissonSystem) -> Result<Self, BuildError> {
        Self::with_parameters(system, &PartParameters::new())
    }

    /// The same with the pieces in an order of their own.
    fn with_parameters(
        system: &PoissonSystem,
        parameters: &PartParameters,
    ) -> Result<Self, BuildError> {
        system.without_forces(INFO.name)?;
        let system = system.formulas(INFO.name)?;
        let mut ring = Ring::new(system.dimension());
        let pieces = find_pieces(system, &mut ring, bodies(parameters)?)?;
        let pieces = settled(system, &ring, pieces)?;
        let order = match named_order(&INFO, parameters, pieces.len())? {
            Some(order) => order,
            None => costliest_last(system, &ring, &pieces)?,
        };
        Self::of_pieces(system, &ring, &pieces, &order)
    }

    /// The product of `pieces` in this order.
    fn of_pieces(
        system: &SystemFormulas,
        ring: &Ring,
        pieces: &[Piece],
        order: &[usize],
    ) -> Result<Self, BuildError> {
        let pieces: Vec<Piece> = order.iter().map(|at| pieces[*at].clone()).collect();
        let mut graph = Graph::new();
        let increment = increment_code(&mut graph, system, ring, &pieces, &STRANG)?;
        let parameters = system.parameters().len();
        let step = ExplicitMap::compile(graph, increment, parameters);
        Ok(Self {
            shared: Arc::new(Shared {
                system: system.clone(),
                ring: ring.clone(),
                pieces,
                step,
                products: Mutex::default(),
                returns: Mutex::default(),
            }),
        })
    }

    /// The pieces, in the order of the first half of a step.
    pub fn pieces(&self) -> &[Piece] {
        &self.shared.pieces
    }

    /// The flow of each piece over the time εh.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where a function has no code.
    pub(crate) fn flows(&self) -> Result<Vec<ExplicitMap>, BuildError> {
        let Shared {
            system,
            ring,
            pieces,
            ..
        } = self.shared.as_ref();
        let flow = |piece| {
            let mut graph = Graph::new();
            let piece = std::slice::from_ref(piece);
            let increment = increment_code(&mut graph, system, ring, piece, &[1.0])?;
            let parameters = system.parameters().len();
            Ok(ExplicitMap::compile(graph, increment, parameters))
        };
        pieces.iter().map(flow).collect()
    }

    /// The pieces' Hamiltonians as formulas.
    pub fn formulas(&self) -> Vec<String> {
        let Shared {
            system,
            ring,
            pieces,
            ..
        } = self.shared.as_ref();
        let mut sums = ring.clone();
        let hamiltonians = pieces.iter().map(|piece| piece.hamiltonian(&mut sums));
        let hamiltonians: Vec<_> = hamiltonians.collect();
        let names = Names { system, ring };
        let formulas = hamiltonians.iter().map(|f| names.polynomial(f));
        formulas.collect()
    }

    /// Operations of one step.
    pub fn operations(&self) -> OperationCount {
        self.shared.step.operations()
    }

    /// χ and χ* over `parts` of the time, in turn, as one kernel.
    fn kernel_of(&self, parts: &[f64]) -> ExplicitMap {
        let Shared {
            system,
            ring,
            pieces,
            products,
            ..
        } = self.shared.as_ref();
        let mut products = products.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, product)) = products.iter().find(|(known, _)| known == parts) {
            return product.clone();
        }
        let mut graph = Graph::new();
        let increment = increment_code(&mut graph, system, ring, pieces, parts)
            .expect("the flows of a step have code over any time");
        let product = ExplicitMap::compile(graph, increment, system.parameters().len())
            .counting(evaluations(parts));
        products.push((parts.to_vec(), product.clone()));
        product
    }

    /// Step over −t of the symmetric product of χ and χ* over `parts`, with the pull-back through its inverse. Returns
    /// one kernel of x and w, or `None` where a derivative has no code.
    fn return_of(&self, parts: &[f64]) -> Option<Arc<Kernel>> {
        let Shared {
            system,
            ring,
            pieces,
            returns,
            ..
        } = self.shared.as_ref();
        let mut returns = returns.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, kernel)) = returns.iter().find(|(known, _)| known == parts) {
            return kernel.clone();
        }
        let (d, parameters) = (system.dimension(), system.parameters().len());
        let mut graph = Graph::new();
        let [x, w] = [0, d]
            .map(|from| -> Vec<Term> { (from..from + d).map(|at| graph.input(at)).collect() });
        let order: Vec<usize> = (0..pieces.len()).collect();
        let flows = passes(&order, parts);
        let outputs = return_increment(&mut graph, ring, pieces, &flows, [&x, &w], parameters);
        let outputs = outputs
            .and_then(|outputs| graph.unless_refused(outputs))
            .ok();
        let compile = |outputs: Vec<Term>| Kernel::compile(&graph, &outputs, parameters, 2 * d);
        let kernel = outputs.map(compile).map(Arc::new);
        returns.push((parts.to_vec(), kernel.clone()));
        kernel
    }

    fn differential_of(
        &self,
        step: &ExplicitMap,
        parts: &[f64],
        parameters: &[f64],
        sizes: (f64, f64),
    ) -> Box<dyn Differential> {
        let inverse = match is_symmetric(parts).then(|| self.return_of(parts)) {
            None => Inverse::Solved,
            Some(None) => Inverse::Opposite,
            Some(Some(kernel)) => Inverse::Kernel(kernel),
        };
        step.differential(parameters, sizes, inverse)
    }
}

/// The pieces as they come, the one with the costliest flow last: the middle of a step, taken once.
fn costliest_last(
    system: &SystemFormulas,
    ring: &Ring,
    pieces: &[Piece],
) -> Result<Vec<usize>, BuildError> {
    let (parameters, d) = (system.parameters().len(), system.dimension());
    let mut costliest = (0, 0);
    for (at, piece) in pieces.iter().enumerate() {
        let mut graph = Graph::new();
        let flow = increment_code(
            &mut graph,
            system,
            ring,
            std::slice::from_ref(piece),
            &STRANG,
        )?;
        let flow = Kernel::compile(&graph, &flow, parameters, d);
        let cost = flow.step_operations().work();
        if cost >= costliest.0 {
            costliest = (cost, at);
        }
    }
    let mut order: Vec<usize> = (0..pieces.len()).filter(|at| *at != costliest.1).collect();
    order.extend((!pieces.is_empty()).then_some(costliest.1));
    Ok(order)
}

fn increment_code(
    graph: &mut Graph,
    system: &SystemFormulas,
    ring: &Ring,
    pieces: &[Piece],
    parts: &[f64],
) -> Result<Vec<Term>, BuildError> {
    let x: Vec<Term> = (0..system.dimension()).map(|i| graph.input(i)).collect();
    let (epsilon, h) = (
        graph.step_size(StepSize::Epsilon),
        graph.step_size(StepSize::H),
    );
    let time = graph.multiply(&epsilon, &h);
    let order: Vec<usize> = (0..pieces.len()).collect();
    let flows = passes(&order, parts);
    Ok(product_increment(graph, ring, pieces, &flows, &time, &x)?)
}

impl StepMap for Splitting {
    fn dimension(&self) -> usize {
        self.shared.system.dimension()
    }

    fn properties(&self) -> MapProperties {
        MapProperties {
            order: 2,
            structure: Structure::Exact,
            self_adjoint: Some(true),
        }
    }

    fn describe(&self) -> String {
        let pieces = self.shared.pieces.len();
        let noun = if pieces == 1 { "piece" } else { "pieces" };
        format!("{} into {pieces} {noun}", INFO.name)
    }

    fn stepper(&self, lanes: usize, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Stepper> {
        self.shared.step.stepper(lanes, parameters, epsilon, h)
    }

    fn differential(&self, parameters: &[f64], epsilon: f64, h: f64) -> Box<dyn Differential> {
        self.differential_of(&self.shared.step, &STRANG, parameters, (epsilon, h))
    }

    fn abilities(&self) -> MapAbilities<'_> {
        let Shared {
            system,
            ring,
            pieces,
            step,
            ..
        } = self.shared.as_ref();
        let factored = Factored {
            factors: Product::factors(self),
            pieces: pieces.len(),
            arranged: Some(Box::new(|asked| {
                let order = asked_order(system, ring, pieces, asked, &self.describe())?;
                Ok(Arc::new(Self::of_pieces(system, ring, pieces, &order)?))
            })),
            // As one kernel. The state between flows is plain doubles; the flows' increments add up apart from it, so
            // that the step's increment rounds in proportion to itself.
            product: Box::new(|parts| {
                let operations = step.operations().total() as u64 * evaluations(parts);
                (operations <= LARGEST_PRODUCT)
                    .then(|| -> Arc<dyn StepMap> { Arc::new(Product::new(self, parts)) })
            }),
        };
        MapAbilities {
            kernels: vec![("step", step.kernel())],
            shadow: Some(Box::new(|system, last, products| {
                self.passes_shadow(&STRANG, system, last, products)
            })),
            factored: Some(factored),
            ..MapAbilities::default()
        }
    }
}

impl Splits for Splitting {
    fn passes_shadow(
        &self,
        parts: &[f64],
        system: &SystemFormulas,
        last: usize,
        products: u64,
    ) -> Result<Option<Shadow>, BuildError> {
        let Shared { ring, pieces, .. } = self.shared.as_ref();
        let mut ring = ring.clone();
        let hamiltonians: Vec<_> = (pieces.iter())
            .map(|piece| piece.hamiltonian(&mut ring))
            .collect();
        let flows: Vec<_> = (hamiltonians.into_iter())
            .map(|piece| Shadow::expanded(ring.clone(), vec![piece]))
            .collect();
        let order: Vec<usize> = (0..flows.len()).collect();
        let steps = passes(&order, parts).into_iter();
        let steps: Vec<_> = steps.map(|flow| (flow.piece, flow.part)).collect();
        Shadow::of_product(system, &flows, &steps, last, products)
    }

    fn passes_stepper(
        &self,
        parts: &[f64],
        lanes: usize,
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Stepper> {
        self.kernel_of(parts).stepper(lanes, parameters, epsilon, h)
    }

    fn passes_differential(
        &self,
        parts: &[f64],
        parameters: &[f64],
        epsilon: f64,
        h: f64,
    ) -> Box<dyn Differential> {
        self.differential_of(&self.kernel_of(parts), parts, parameters, (epsilon, h))
    }
}

fn build(
    system: &PoissonSystem,
    parameters: &PartParameters,
) -> Result<Arc<dyn StepMap>, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    if let Some(system) = system.opaque() {
        if matches!(bodies(parameters)?, Bodies::Whole) {
            return Err(BuildError::DoesNotFit {
                part: NAME,
                reason:
                    "in sums over pairs in a loop no body has a separate flow: leave `bodies` out"
                        .to_owned(),
            });
        }
        let terms = system.numbers.terms();
        return match terms.filter(|_| system.numbers.shears().is_empty()) {
            Some(terms) => {
                let flows = |system: &SystemFormulas| {
                    Splitting::new(&PoissonSystem::from(system.clone()))?.flows()
                };
                Ok(Arc::new(FlowsOfTerms::new(
                    &INFO, terms, parameters, flows,
                )?))
            }
            None => Ok(Arc::new(Shears::new(&INFO, system, parameters)?)),
        };
    }
    Ok(Arc::new(Splitting::with_parameters(system, parameters)?))
}

fn build_on_lattice(
    source: &dyn LatticeSource,
    parameters: &PartParameters,
) -> Result<LatticeMap, BuildError> {
    parameters.refuse_unknown(&INFO)?;
    if bodies(parameters)? == Bodies::Whole {
        return Err(BuildError::DoesNotFit {
            part: NAME,
            reason: "the pieces of a long lattice repeat along it, and whole bodies are not supported there: leave `bodies` \
                     at \"axes\""
                .to_owned(),
        });
    }
    let splitting = LatticeSplitting::new(source)?;
    let order = named_order(&INFO, parameters, splitting.pieces())?;
    Ok(match order {
        Some(order) => splitting.in_order(order).into(),
        None => splitting.into(),
    })
}

leafwise_core::built_in!(StepperPart::new(&INFO, build).with_sweeps(build_on_lattice));
