//! Poisson systems written in Rust.

use leafwise_expression::{Expression, Quantity};

use super::{Casimir, Convention, Parameter, PoissonSystem};
use crate::error::BuildError;

/// A Poisson system, written down name by name.
///
/// ```
/// use leafwise_core::SystemBuilder;
///
/// let mut body = SystemBuilder::new();
/// let [x, y, z] = body.variables(["x", "y", "z"]);
/// let [a] = body.parameters([("a", 0.75)]);
/// body.bracket(x, y, -z);
/// body.bracket(y, z, -x);
/// body.bracket(z, x, -y);
/// body.hamiltonian(x * x / 2 + y * y / (2 * a) + z * z / 2.5);
/// body.casimir("spin", x * x + y * y + z * z);
/// let system = body.build()?;
/// assert_eq!(system.dimension(), 3);
/// # Ok::<(), leafwise_core::BuildError>(())
/// ```
///
/// Brackets that are not given vanish, and H is 0 until it is given. The motion is ẋ = {H, x}, as in
/// the paper, unless [`convention`](Self::convention) says otherwise.
#[derive(Clone, Debug, Default)]
pub struct SystemBuilder {
    variables: Vec<String>,
    parameters: Vec<Parameter>,
    bracket: Vec<(Quantity, Quantity, Expression)>,
    hamiltonian: Option<Expression>,
    casimirs: Vec<Casimir>,
    convention: Convention,
}

impl SystemBuilder {
    /// A system of no variables.
    pub fn new() -> Self {
        Self::default()
    }

    /// Variables of these names, after those that are there.
    pub fn variables<const N: usize>(&mut self, names: [&str; N]) -> [Quantity; N] {
        names.map(|name| self.variable(name))
    }

    /// A variable of this name, after those that are there.
    pub fn variable(&mut self, name: impl Into<String>) -> Quantity {
        self.variables.push(name.into());
        Quantity::Variable(self.variables.len() - 1)
    }

    /// Parameters of these names with the values that a run starts from.
    pub fn parameters<const N: usize>(&mut self, parameters: [(&str, f64); N]) -> [Quantity; N] {
        parameters.map(|(name, value)| {
            let name = name.to_owned();
            self.parameters.push(Parameter { name, value });
            Quantity::Parameter(self.parameters.len() - 1)
        })
    }

    /// {a, b} = `entry`, and with it {b, a}.
    pub fn bracket(&mut self, a: Quantity, b: Quantity, entry: impl Into<Expression>) {
        self.bracket.push((a, b, entry.into()));
    }

    /// H.
    pub fn hamiltonian(&mut self, hamiltonian: impl Into<Expression>) {
        self.hamiltonian = Some(hamiltonian.into());
    }

    /// A Casimir: Π ∇C = 0, which [`check_casimir`](crate::diagnostics::check_casimir) measures.
    pub fn casimir(&mut self, name: impl Into<String>, casimir: impl Into<Expression>) {
        self.casimirs.push(Casimir {
            name: name.into(),
            expression: casimir.into(),
        });
    }

    /// The sign of the motion: ẋ = {H, x} or ẋ = {x, H}.
    pub fn convention(&mut self, convention: Convention) {
        self.convention = convention;
    }

    /// Builds the system.
    ///
    /// # Errors
    /// [`BuildError::NotMade`] for a name or a bracket that is given twice and for a bracket that is not of two
    /// variables. A variable or a parameter of a formula that the system does not have gives [`BuildError::Dimension`].
    /// A number that is none is refused where its formula is first evaluated.
    pub fn build(&self) -> Result<PoissonSystem, BuildError> {
        let refuse = |reason: String| BuildError::NotMade {
            part: "the system",
            reason,
        };
        let names = || {
            let parameters = self.parameters.iter().map(|p| &p.name);
            self.variables.iter().chain(parameters)
        };
        let mut twice = names().enumerate();
        if let Some((_, name)) = twice.find(|(at, name)| names().take(*at).any(|n| n == *name)) {
            return Err(refuse(format!("`{name}` is declared twice")));
        }
        let name = |quantity: &Quantity| {
            let known = match quantity {
                Quantity::Variable(at) => self.variables.get(*at),
                Quantity::Parameter(at) => self.parameters.get(*at).map(|p| &p.name),
            };
            known.map_or("?", String::as_str)
        };
        let mut entries: Vec<((usize, usize), Expression)> = Vec::new();
        for (a, b, entry) in &self.bracket {
            let bracket = format!("{{{}, {}}}", name(a), name(b));
            let (pair, entry) = match (*a, *b) {
                (Quantity::Variable(i), Quantity::Variable(j)) if i < j => ((i, j), entry.clone()),
                (Quantity::Variable(i), Quantity::Variable(j)) if i > j => ((j, i), -entry),
                _ => return Err(refuse(format!("{bracket} is not of two variables"))),
            };
            if entries.iter().any(|(known, _)| *known == pair) {
                return Err(refuse(format!("{bracket} is given twice")));
            }
            entries.push((pair, entry));
        }
        PoissonSystem::new(
            self.variables.clone(),
            self.parameters.clone(),
            entries,
            self.hamiltonian.clone().unwrap_or_else(|| 0.into()),
            self.casimirs.clone(),
            self.convention,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane() -> (SystemBuilder, [Quantity; 2]) {
        let mut plane = SystemBuilder::new();
        let both = plane.variables(["q", "p"]);
        (plane, both)
    }

    fn reason(system: &SystemBuilder) -> String {
        system.build().expect_err("refused").to_string()
    }

    #[test]
    fn a_bracket_is_antisymmetric_whichever_half_is_given() {
        let [one, other] = [false, true].map(|is_swapped| {
            let (mut plane, [q, p]) = plane();
            if is_swapped {
                plane.bracket(p, q, q * p);
            } else {
                plane.bracket(q, p, -(q * p));
            }
            let system = plane.build().expect("two variables");
            system.expressions().expect("formulas").tensor().clone()
        });
        assert_eq!(one, other);
        assert_eq!(one.len(), 1);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let (mut twice, [q, p]) = plane();
        twice.bracket(q, p, 1);
        twice.bracket(p, q, 1);
        assert!(reason(&twice).contains("{p, q} is given twice"));

        let (mut itself, [q, _]) = plane();
        itself.bracket(q, q, 1);
        assert!(reason(&itself).contains("{q, q} is not of two variables"));

        let (mut parameter, [q, _]) = plane();
        let [a] = parameter.parameters([("a", 1.0)]);
        parameter.bracket(q, a, 1);
        assert!(reason(&parameter).contains("{q, a} is not of two variables"));

        let (mut names, _) = plane();
        names.parameters([("q", 1.0)]);
        assert!(reason(&names).contains("`q` is declared twice"));

        let (mut foreign, [q, _]) = plane();
        foreign.hamiltonian(q * Quantity::Variable(7));
        assert!(reason(&foreign).contains("variable number 7"));
    }

    #[test]
    fn a_number_that_is_none_is_a_division_by_zero() {
        let (mut plane, [q, p]) = plane();
        plane.bracket(q, p, 1);
        plane.hamiltonian(q * f64::NAN);
        let system = plane.build().expect("two variables");
        let error = system.numbers().expect_err("0/0");
        assert!(matches!(error, BuildError::Algebra(_)), "{error}");
    }
}
