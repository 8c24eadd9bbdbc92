//! Systems, pairs by Gauss's method of order 6 on short steps, and random numbers.

use std::sync::Arc;

// Parts that scenes name.
use leafwise_constant as _;
use leafwise_darboux_magnetic as _;
use leafwise_hamilton_jacobi as _;
use leafwise_karasev as _;
use leafwise_lie_poisson as _;
use leafwise_log_canonical as _;
use leafwise_so3 as _;

use leafwise_core::dynamics::Correction;
use leafwise_core::formulas::FormulaDynamics;
use leafwise_core::part::Dimensions;
use leafwise_core::{Method, PoissonSystem, RealizationData, Walk};
use leafwise_expression::Expression;
use leafwise_expression::syntax::{Formula, Scope};
use leafwise_learn::{
    BasisAxis, BasisDegree, FunctionFamily, LearnError, LearnOptions, Learned, StatePairs, learn,
};
use leafwise_tests::gauss::flow;
use leafwise_tests::scenes::composed;

pub const RIGID_BODY: &str = "[system]\nvariables = [\"x\", \"y\", \"z\"]\nbracket = { \"x,y\" = \"-z\", \"y,z\" = \"-x\", \"z,x\" = \"-y\" }\n\
     hamiltonian = \"x^2/2 + 2*y^2/3 + 0.4*z^2\"\ncasimirs = { C = \"x^2 + y^2 + z^2\" }\n";

/// A pendulum whose bracket depends on a Casimir.
pub const PENDULUM: &str = "[system]\nvariables = [\"q\", \"p\", \"c\"]\nbracket = { \"q,p\" = \"1 + c\" }\nconvention = \"{x,H}\"\n\
     hamiltonian = \"p^2/2 - cos(q) + c*p\"\n";

/// A system with an exact realization of its tensor.
pub struct Place {
    pub system: PoissonSystem,
    pub realization: Arc<dyn RealizationData>,
}

impl Place {
    /// Of a `[system]` table, over a realization by name, or by a table with its name.
    pub fn new(system: &str, realization: &str, initial: &str) -> Self {
        let realization = match realization.starts_with('{') {
            true => realization.to_owned(),
            false => format!("\"{realization}\""),
        };
        let run = composed(&format!(
            "{system}\n[method]\nrealization = {realization}\ndynamics = \"hamilton-jacobi\"\ntime-step = 0.1\n\
             [run]\ninitial = {initial}\nsteps = 1\n"
        ));
        let method = run.method.written().expect("realization and dynamics");
        Self {
            realization: method.shared_realization(),
            system: run.system,
        }
    }

    /// Pairs over a time from these states, by the flow.
    pub fn pairs(&self, states: &[Vec<f64>], h: f64) -> (Vec<f64>, Vec<f64>) {
        let after = states.iter().flat_map(|x| self.flow(x, h));
        (states.concat(), after.collect())
    }

    /// The flow, by 64 steps of a unit of time.
    pub fn flow(&self, x: &[f64], h: f64) -> Vec<f64> {
        flow(&self.system, x, h, (64.0 * h).ceil() as usize)
    }

    pub fn learn(
        &self,
        h: f64,
        (before, after): &(Vec<f64>, Vec<f64>),
        options: &LearnOptions,
    ) -> Result<Learned, LearnError> {
        let d = self.system.dimension();
        let pairs = StatePairs::new(d, before, after, None)?;
        learn(&self.system, &self.realization, (1.0, h), &pairs, options)
    }

    /// The map of what was learned, from its formulas.
    pub fn method(&self, learned: &Learned) -> (PoissonSystem, Method) {
        let names = self.system.variables();
        let read = |text: &str| -> Expression {
            let scope = Scope::new().with_variables(names);
            let formula = Formula::parse(text).expect(text);
            formula.resolve(&scope, None).expect(text).expect(text)
        };
        let energy = read(&learned.hamiltonian);
        let formulas = self.system.formulas("tests").expect("formulas");
        let system: PoissonSystem = formulas
            .with_hamiltonian(energy.clone())
            .expect("the same variables")
            .into();
        let further = learned.further.iter().map(|text| read(text));
        let dynamics = FormulaDynamics {
            name: "generating-function",
            order: 2,
            self_adjoint: Some(true),
            correction: Correction::Bisection,
            dimensions: Dimensions {
                least: 1,
                most: None,
            },
            coefficients: std::iter::once(energy).chain(further).collect(),
        };
        let method = Method::compose(&system, Arc::clone(&self.realization), Arc::new(dynamics));
        (system, method.expect("a method"))
    }
}

/// x_1, …, x_n by a map.
pub fn orbit(method: &Method, system: &PoissonSystem, x: &[f64], h: f64, n: u64) -> Vec<Vec<f64>> {
    let mut walk = Walk::of(method, system, x, h);
    let mut states = Vec::new();
    walk.watch(n, |walk| states.push(walk.state().to_vec()))
        .expect("steps");
    states
}

/// Polynomials in each variable.
pub fn polynomials(d: usize, degree: usize) -> LearnOptions {
    let axis = BasisAxis {
        family: FunctionFamily::Polynomial,
        has_logarithm: false,
    };
    LearnOptions {
        axes: vec![axis; d],
        degree: Some(BasisDegree::Total(degree)),
        ridge: 0.0,
        has_noise: false,
        finds_hamiltonian: true,
    }
}

/// The same with logarithms.
pub fn logarithms(d: usize, degree: usize) -> LearnOptions {
    let mut options = polynomials(d, degree);
    options
        .axes
        .iter_mut()
        .for_each(|axis| axis.has_logarithm = true);
    options
}

/// Steele, Lea and Flood's splitmix64.
pub struct Draws(pub u64);

impl Draws {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.uniform()
    }

    /// Box and Muller's normal deviate.
    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.uniform()));
        radius * libm::cos(std::f64::consts::TAU * self.uniform())
    }

    /// States on spheres of radii 0.9 to 1.1.
    pub fn on_spheres(&mut self, count: usize) -> Vec<Vec<f64>> {
        (0..count)
            .map(|_| {
                let x: Vec<f64> = (0..3).map(|_| self.normal()).collect();
                let length = libm::sqrt(x.iter().map(|x| x * x).sum());
                let radius = self.between(0.9, 1.1);
                x.iter().map(|x| x / length * radius).collect()
            })
            .collect()
    }

    /// States in a box.
    pub fn in_box(&mut self, count: usize, box_: &[(f64, f64)]) -> Vec<Vec<f64>> {
        let mut state = || box_.iter().map(|(a, b)| self.between(*a, *b)).collect();
        (0..count).map(|_| state()).collect()
    }

    pub fn noisy(&mut self, numbers: &mut [f64], size: f64) {
        numbers.iter_mut().for_each(|x| *x += size * self.normal());
    }
}

/// Root mean square.
pub fn rms(errors: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for error in errors {
        sum += error * error;
        count += 1;
    }
    libm::sqrt(sum / f64::from(count.max(1)))
}
