//! Tensors by one-forms and two-forms, and Dirac's bracket of constraints.

use leafwise_core::lattice::LatticeGeometry;
use leafwise_core::system::{Casimir, FormError};
use leafwise_core::{BuildError, PoissonSystem, SystemFormulas};
use leafwise_expression::Expression;
use leafwise_expression::syntax::Scope;
use leafwise_walk::Clock;

use super::Refusal;
use super::extended::Extension;
use super::names::{function, parse, refusal};
use super::sum::{Summand, summands};
use super::tensor::{Antisymmetric, Entries, entries};
use crate::document::{BracketSpec, Located, Place, SceneDocument};

/// One-form, two-form or summands that make a tensor in place of its entries, and constraints on it.
#[derive(Clone, Debug, Default)]
pub struct Forms {
    form: Form,
    /// Named by their text.
    constraints: Vec<Casimir>,
    /// Definitions of the scene by name, for messages.
    names: Vec<(String, Expression)>,
}

#[derive(Clone, Debug, Default)]
enum Form {
    /// The bracket has entries.
    #[default]
    None,
    One(Vec<Expression>),
    Two(Entries),
    /// Those of the summands that have forms, beside the entries of the others.
    Sum(Vec<(Summand, Forms)>),
}

/// Reads the forms and constraints of a scene with its families as long as those of `lattice`, by the scene's names without and
/// with that of the time.
pub(super) fn forms(
    document: &SceneDocument,
    [own, scope]: [&Scope; 2],
    names: &[String],
    lattice: &LatticeGeometry,
) -> Result<Forms, Refusal> {
    let system = &document.system;
    let form = match &system.bracket.value {
        BracketSpec::OneForm(components) => {
            let components = components.iter();
            let components = components.map(|formula| function(document, scope, formula));
            Form::One(components.collect::<Result<_, _>>()?)
        }
        BracketSpec::TwoForm(written) => {
            let table = Antisymmetric {
                noun: "a two-form",
                name: |a, b| format!("ω({a}, {b})"),
            };
            Form::Two(table.entries(document, own, names, written)?)
        }
        BracketSpec::Sum(_) => {
            let mut formed = summands(document, lattice)?;
            formed.retain(Summand::is_formed);
            let with_forms = |summand: Summand| {
                let Summand {
                    document, scope, ..
                } = &summand;
                let own = forms(document, [scope, scope], &summand.names, &summand.lattice)?;
                Ok((summand, own))
            };
            let formed: Vec<_> = formed
                .into_iter()
                .map(with_forms)
                .collect::<Result<_, Refusal>>()?;
            match formed.is_empty() {
                true => Form::None,
                false => Form::Sum(formed),
            }
        }
        _ => Form::None,
    };
    let mut constraints = Vec::with_capacity(system.constraints.len());
    for formula in &system.constraints {
        let mut casimirs = system.casimirs.iter();
        if casimirs.any(|(name, _)| name.value == formula.value) {
            return Err(Box::new(document.diagnostic(
                &formula.place(),
                format!(
                    "the constraint `{}` has the name of a Casimir",
                    formula.value
                ),
                "taken",
                Some("every constraint is already a Casimir, named by its text: remove that Casimir".to_owned()),
            )));
        }
        constraints.push(Casimir {
            name: formula.value.clone(),
            expression: function(document, own, formula)?,
        });
    }
    let mut defined = Vec::with_capacity(system.define.len());
    for (name, _) in &system.define {
        let value = parse(document, name)?
            .resolve(scope, None)
            .map_err(|error| refusal(document, name, &error))?;
        defined.extend(value.map(|value| (name.value.clone(), value)));
    }
    Ok(Forms {
        form,
        constraints,
        names: defined,
    })
}

impl Forms {
    /// The forms of the phase space with (t, e) behind its coordinates: ϑ + e dt, by which t' = 1 for K = H + e.
    pub(super) fn extend(&mut self, extension: &Extension) {
        let Clock { time: t, energy: e } = extension.clock;
        match &mut self.form {
            // {t, e} is an entry beside them.
            Form::None | Form::Sum(_) => {}
            Form::One(form) => form.extend([Expression::Variable(e), Expression::from(0)]),
            // d(e dt) = de ∧ dt.
            Form::Two(form) => {
                form.insert((t, e), Expression::from(-1));
            }
        }
    }

    /// System with the tensor of these forms and constraints, formed about the state about which it moves.
    ///
    /// # Errors
    /// A form that is not closed or has no inverse. Constraints that are not of second class. Both are underlined in
    /// the scene.
    pub fn apply(
        self,
        document: &SceneDocument,
        system: PoissonSystem,
    ) -> Result<PoissonSystem, Refusal> {
        let Some(formulas) = system.expressions() else {
            return Ok(system);
        };
        let formulas = formulas.clone().with_names(self.names);
        let variables = formulas.variables().to_vec();
        let constraints = self.constraints;
        let formed = match self.form {
            Form::None => Ok(formulas),
            Form::Sum(summands) => {
                let mut own = Vec::with_capacity(summands.len());
                for (summand, forms) in summands {
                    own.push(of_summand(summand, forms, &formulas)?);
                }
                Ok(formulas.with_summands(own))
            }
            Form::One(form) => formulas.with_one_form(&form),
            Form::Two(form) => formulas.with_two_form(&form),
        };
        let formed = formed.and_then(|formulas| formulas.with_constraints(constraints));
        formed
            .map(PoissonSystem::from)
            .map_err(|error| refused(document, &error, &variables))
    }
}

/// The places and the tensor of a summand that has forms.
fn of_summand(
    summand: Summand,
    forms: Forms,
    whole: &SystemFormulas,
) -> Result<(Vec<usize>, SystemFormulas), Refusal> {
    let Summand {
        document,
        scope,
        names,
        lattice,
        places,
    } = summand;
    let near: Vec<f64> = places.iter().map(|at| whole.near()[*at]).collect();
    let error = |error: &BuildError| {
        let place = document.system.bracket.place();
        Box::new(document.diagnostic(&place, error.to_string(), "here", None))
    };
    let system = SystemFormulas::new(
        names.clone(),
        whole.parameters().to_vec(),
        entries(&document, &scope, &names, &lattice)?,
        Expression::from(0),
        Vec::new(),
        whole.convention(),
    );
    let system = system.and_then(|system| system.with_near(&near));
    let system = PoissonSystem::from(system.map_err(|refused| error(&refused))?);
    let formed = forms.apply(&document, system)?;
    let formulas = formed
        .formulas("a summand")
        .map_err(|refused| error(&refused))?;
    Ok((places, formulas.clone()))
}

/// A form that makes no tensor, underlined where that shows.
fn refused(document: &SceneDocument, error: &FormError, names: &[String]) -> Refusal {
    let system = &document.system;
    let bracket = system.bracket.place();
    let at = |state: &[f64]| {
        let values = names.iter().zip(state);
        let values: Vec<String> = values.map(|(name, x)| format!("{name} = {x}")).collect();
        values.join(", ")
    };
    let all = || {
        let first = system.constraints.first();
        first.map_or_else(|| bracket.clone(), Located::place)
    };
    let (place, message, label, help) = match error {
        FormError::Components { dimension, .. } => (
            bracket,
            error.to_string(),
            format!("expected {dimension} formulas"),
            format!("one for each of {}, 0 where there is none", names.join(", ")),
        ),
        FormError::OddDimension { .. } => (
            bracket,
            error.to_string(),
            "over an odd number of variables".to_owned(),
            "add the variable that is missing, or write the bracket by its entries".to_owned(),
        ),
        FormError::Degenerate => (
            bracket,
            error.to_string(),
            "has no inverse".to_owned(),
            "the form must be nondegenerate: is a momentum, or a component, missing?"
                .to_owned(),
        ),
        FormError::DegenerateAt { at: state, .. } => (
            document.run.initial.place(),
            error.to_string(),
            format!("here, at {}", at(state)),
            "start elsewhere, or correct the formulas".to_owned(),
        ),
        FormError::NotClosed { triple, value, at: state } => {
            let [i, j, k] = triple.map(|index| names[index].as_str());
            let value = match value.is_nan() {
                true => "has no value near the initial state".to_owned(),
                false => format!("is {value:.3e} and not 0, at {}", at(state)),
            };
            (
                entry_of(document, [i, j, k]).unwrap_or(bracket),
                format!("the two-form ω is not closed: d{i} ω({j}, {k}) + d{j} ω({k}, {i}) + d{k} ω({i}, {j}) {value}"),
                format!("dω has a component along {i}, {j}, {k}"),
                "Jacobi's identity is that the two-form is closed, as every dϑ is: bracket = { one-form = [ … ] }"
                    .to_owned(),
            )
        }
        FormError::FirstClass { constraint: Some(which), .. } => (
            system.constraints.get(*which).map_or(bracket, Located::place),
            "this constraint is of first class: its brackets with all constraints vanish".to_owned(),
            "of first class".to_owned(),
            "Dirac's bracket is of second-class constraints: add the condition that fixes its gauge, or remove \
             a conserved one from the list"
                .to_owned(),
        ),
        FormError::FirstClass { count, .. } => (
            all(),
            error.to_string(),
            match count % 2 {
                1 => format!("{count} constraints, an odd number"),
                _ => "the first of them".to_owned(),
            },
            "some combination of them is of first class: add the condition that fixes its gauge, such as the \
             time derivative of a constraint on positions"
                .to_owned(),
        ),
        other => (
            bracket,
            format!("the tensor of this form has no formulas: {other}"),
            "here".to_owned(),
            "write the bracket by its entries".to_owned(),
        ),
    };
    Box::new(document.diagnostic(&place, message, label, Some(help)))
}

/// The first entry of the two-form that is of two of these variables.
fn entry_of(document: &SceneDocument, triple: [&str; 3]) -> Option<Place> {
    let BracketSpec::TwoForm(entries) = &document.system.bracket.value else {
        return None;
    };
    let is_of = |(key, _): &&(Located<String>, Located<String>)| {
        key.value
            .split(',')
            .all(|name| triple.contains(&name.trim()))
    };
    let (key, _) = entries.iter().find(is_of)?;
    Some(key.place())
}
