//! Equations of motion.

use leafwise_expression::{Expression, Rational};

use crate::error::FindError;

/// The equations ẋ = f(x, λ) of named variables x and parameters λ with exact values.
#[derive(Clone, Debug)]
pub struct Equations {
    variables: Vec<String>,
    parameters: Vec<(String, Rational)>,
    field: Vec<Expression>,
}

impl Equations {
    /// Equations of these variables, a formula for each.
    ///
    /// # Errors
    /// [`FindError::Count`] unless there are as many formulas as variables, and at least one.
    pub fn new(
        variables: Vec<String>,
        parameters: Vec<(String, Rational)>,
        field: Vec<Expression>,
    ) -> Result<Self, FindError> {
        if field.len() != variables.len() || field.is_empty() {
            return Err(FindError::Count {
                equations: field.len(),
                variables: variables.len(),
            });
        }
        Ok(Self {
            variables,
            parameters,
            field,
        })
    }

    /// The variables' names.
    pub fn variables(&self) -> &[String] {
        &self.variables
    }

    /// The parameters' names and values.
    pub fn parameters(&self) -> &[(String, Rational)] {
        &self.parameters
    }

    /// The components of f.
    pub fn field(&self) -> &[Expression] {
        &self.field
    }

    /// The same equations with numbers in place of the parameters.
    pub fn with_numbers(&self) -> Self {
        let values: Vec<Rational> = self.parameters.iter().map(|(_, v)| v.clone()).collect();
        Self {
            variables: self.variables.clone(),
            parameters: Vec::new(),
            field: (self.field.iter())
                .map(|f| f.with_parameters(&values))
                .collect(),
        }
    }
}
