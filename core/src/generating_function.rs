//! The generating function Ŝ of a Lagrangian bisection graph(dŜ).

use leafwise_expression::graph::lift;
use leafwise_expression::{Arithmetic, Graph, Polynomial, Rational, Ring, Term};

use crate::error::BuildError;
use crate::system::{Agreement, SystemFormulas};

/// Ŝ_{ε,h} = Σ_{l odd} ε^{l−1} hˡ S_l in one of its forms.
#[derive(Clone, Debug)]
pub enum Generating {
    /// Expanded: the shortest form where sums cancel, as over most linear tensors.
    Polynomials(GeneratingFunction),
    /// As code: the shorter form where expanded products are long.
    Code(GeneratingCode),
}

impl Generating {
    /// The number of coefficients S_1, S_3, ….
    pub fn len(&self) -> usize {
        match self {
            Self::Polynomials(function) => function.coefficients.len(),
            Self::Code(code) => code.coefficients.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// S_{2k+1}(y) and dS_{2k+1}(y) at ε = 1 as code, S first.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an adjoined function has no code.
    pub fn coefficient(
        &self,
        graph: &mut Graph,
        k: usize,
        y: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        match self {
            Self::Polynomials(function) => {
                let one = graph.one();
                let gradient = &function.gradients[k];
                let all = std::iter::once(&function.coefficients[k]).chain(gradient);
                let outputs: Vec<_> = all.map(|f| vec![(one.clone(), f.clone())]).collect();
                Ok(lift(graph, &function.ring, &outputs, y)?)
            }
            Self::Code(code) => {
                let gradient = &code.gradients[k];
                let all = std::iter::once(&code.coefficients[k]).chain(gradient);
                let terms: Vec<Term> = all.cloned().collect();
                Ok(graph.import(&code.graph, &terms, y)?)
            }
        }
    }

    /// dŜ_{ε,h}(y) as code.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an adjoined function has no code.
    pub fn differential(
        &self,
        graph: &mut Graph,
        epsilon: &Term,
        h: &Term,
        y: &[Term],
    ) -> Result<Vec<Term>, BuildError> {
        // ε^{l−1} hˡ for l = 1, 3, …
        let time = graph.multiply(epsilon, h);
        let square = graph.multiply(&time, &time);
        let mut power = h.clone();
        let mut powers = Vec::with_capacity(self.len());
        for _ in 0..self.len() {
            powers.push(power.clone());
            power = graph.multiply(&power, &square);
        }
        match self {
            Self::Polynomials(function) => {
                let mut outputs: Vec<Vec<(Term, Polynomial)>> = vec![Vec::new(); y.len()];
                for (power, gradient) in powers.iter().zip(&function.gradients) {
                    for (output, component) in outputs.iter_mut().zip(gradient) {
                        output.push((power.clone(), component.clone()));
                    }
                }
                Ok(lift(graph, &function.ring, &outputs, y)?)
            }
            Self::Code(code) => {
                let mut sums: Vec<Vec<(Rational, Term)>> = vec![Vec::new(); y.len()];
                for (power, gradient) in powers.iter().zip(&code.gradients) {
                    let gradient = graph.import(&code.graph, gradient, y)?;
                    for (sum, component) in sums.iter_mut().zip(&gradient) {
                        sum.push((Rational::one(), graph.multiply(power, component)));
                    }
                }
                Ok(sums.iter().map(|sum| graph.combine(sum)).collect())
            }
        }
    }
}

/// Ŝ as straight-line code: nothing is expanded, and gradients are formed in reverse.
#[derive(Clone, Debug)]
pub struct GeneratingCode {
    /// The code; its inputs are the coordinates of M.
    pub graph: Graph,
    /// S_1, S_3, … at ε = 1.
    pub coefficients: Vec<Term>,
    /// dS_1, dS_3, …: d components each.
    pub gradients: Vec<Vec<Term>>,
}

/// Ŝ_{ε,h} = Σ_{l odd} ε^{l−1} hˡ S_l in exact algebra (paper, section 4.2; only odd l by
/// Proposition 1).
#[derive(Clone, Debug)]
pub struct GeneratingFunction {
    /// The ring the coefficients live in.
    pub ring: Ring,
    /// S_1, S_3, … at ε = 1.
    pub coefficients: Vec<Polynomial>,
    /// dS_1, dS_3, …: d components each.
    pub gradients: Vec<Vec<Polynomial>>,
}

/// Largest ratio of h² dS_{l+2} to dS_l at steps that a series serves: about θ²/24 where a step turns by θ.
const NEXT_ORDER: f64 = 1.0 / 16.0;

impl GeneratingFunction {
    /// Whether the expanded dS_l have the values of those of the code at points about the system's state, and round as
    /// well. An expansion that cancels, such as that of a power of q − 1000, is right and of no use.
    ///
    /// # Errors
    /// [`BuildError::Algebra`] where an adjoined function has no code.
    pub fn rounds_as(
        &self,
        code: &GeneratingCode,
        system: &SystemFormulas,
    ) -> Result<bool, BuildError> {
        let mut graph = code.graph.clone();
        let x: Vec<Term> = (0..system.dimension()).map(|i| graph.input(i)).collect();
        let one = graph.one();
        let expanded = self.gradients.iter().flatten();
        let outputs: Vec<_> = expanded.map(|f| vec![(one.clone(), f.clone())]).collect();
        let made = lift(&mut graph, &self.ring, &outputs, &x)?;
        let expected: Vec<Term> = code.gradients.iter().flatten().cloned().collect();
        let d = system.dimension();
        let share = |at: usize| (0..at / d).fold(1.0, |share, _| share * NEXT_ORDER);
        Ok(system.agreement_of_parts(&graph, &made, &expected, share) == Agreement::Same)
    }
}
